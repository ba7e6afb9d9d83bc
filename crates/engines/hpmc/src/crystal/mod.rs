//! Crystals: unit cells of any shape, repeated until they hold all bodies.

mod catalogue;
mod unit_cell;

pub use catalogue::{NAMES, NAMES_OF_SEVERAL};
pub use unit_cell::{Site, UnitCell};

use crate::body::{HardBody, norm};
use crate::error::require_packing_fraction;
use crate::mixture::Mixture;
use crate::reservoir::Depletant;
use crate::symmetry::Symmetry;
use crate::system::{System, bodies_in_longer_box, first_that_works, least_edge};
use crate::{Error, Result};
use protomer_kernel::Rotation;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::separation::{Block, dot};
use unit_cell::SAME;

/// Translations are across a bond if the cosine of their angle is less.
const ACROSS: f64 = 0.25;

/// Bonds along one translation of the lattice.
#[derive(Debug, Clone)]
pub(crate) struct Bond<const D: usize> {
    /// Translations across it.
    pub slips: Vec<[f64; D]>,
    /// Site at the other end, for each site.
    pub others: Vec<usize>,
}

/// Bodies on all sites of repeated unit cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Crystal<const D: usize> {
    /// The box.
    pub space: PeriodicBox<D>,
    /// The sites.
    pub positions: Vec<[f64; D]>,
    /// The orientations of the bodies on them.
    pub rotations: Vec<Rotation>,
    cell: UnitCell<D>,
    cells: usize,
}

impl<const D: usize> Crystal<D> {
    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.positions.len()
    }

    /// A crystal of so many bodies, in a box as near to a cube as whole cells allow.
    ///
    /// # Errors
    /// Unless the bodies fill whole cells, and for sites or numbers that make no crystal.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// use protomer_hpmc::crystal::{Crystal, UnitCell};
    /// use protomer_kernel::shape::builders::by_name;
    /// let cube = HardBody::<3>::new(&by_name("cube")?, 0.0)?;
    /// let cell = UnitCell::by_name("simple-cubic")?;
    /// let crystal = Crystal::new(&cell, &cube, 64, 0.512)?;
    /// assert!((crystal.space.lengths()[0] - 5.0).abs() < 1e-12);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn new(
        cell: &UnitCell<D>,
        body: &HardBody<D>,
        bodies: usize,
        packing_fraction: f64,
    ) -> Result<Self> {
        Self::among(cell, body, &[], bodies, packing_fraction)
    }

    /// Variant of [`new`](Self::new) for bodies among depletants: a number of bodies that an error
    /// names is one for their box.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn among(
        cell: &UnitCell<D>,
        body: &HardBody<D>,
        depletants: &[Depletant],
        bodies: usize,
        packing_fraction: f64,
    ) -> Result<Self> {
        let mixture = Mixture::equal(body.clone(), bodies);
        Self::of_mixture(cell, &mixture, depletants, packing_fraction)
    }

    /// Variant of [`among`](Self::among) for bodies of several kinds, on the sites in their order: cell by cell, and in each cell as its
    /// sites come.
    ///
    /// # Errors
    /// As [`new`](Self::new); also for fewer kinds of bodies than the cell has kinds of sites.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// use protomer_hpmc::crystal::{Crystal, UnitCell};
    /// use protomer_hpmc::mixture::Mixture;
    /// let cell = UnitCell::<3>::by_name("nacl")?;
    /// let balls = vec![HardBody::ball(0.5)?, HardBody::ball(0.2)?];
    /// let mixture = Mixture::new(balls, cell.kinds_of_bodies(64))?;
    /// let crystal = Crystal::of_mixture(&cell, &mixture, &[], 0.75)?;
    /// assert_eq!(crystal.system_of(&mixture, &[])?.overlaps(), 0);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn of_mixture(
        cell: &UnitCell<D>,
        mixture: &Mixture<D>,
        depletants: &[Depletant],
        packing_fraction: f64,
    ) -> Result<Self> {
        cell.check()?;
        require_packing_fraction(packing_fraction)?;
        let (kinds, given) = (cell.composition().len(), mixture.kinds().len());
        if given < kinds {
            return Err(Error::KindsOfCrystal { kinds, given });
        }
        let (sites, bodies) = (cell.sites.len(), mixture.len());
        let volume_per_body = mean_volume(mixture) / packing_fraction;
        if bodies == 0 || !bodies.is_multiple_of(sites) {
            let cells_per_edge = (bodies as f64 / sites as f64).powf(1.0 / D as f64).round();
            let nearest = cells_per_edge.max(2.0).powi(D as i32) as usize * sites;
            let least = least_edge(mixture.widest(), depletants);
            return Err(Error::PartialCell {
                bodies,
                sites,
                nearest: fewest_bodies(cell, nearest, volume_per_body, least),
            });
        }
        let cells = bodies / sites;
        let (scaled, repeats) = cells_of_crystal(cell, bodies, volume_per_body);
        let (mut positions, mut rotations) = (Vec::new(), Vec::new());
        // Cells in order, x fastest, then their sites.
        for number in 0..cells {
            let (mut index, mut corner) = (number, [0.0; D]);
            for axis in 0..D {
                corner[axis] = (index % repeats[axis]) as f64;
                index /= repeats[axis];
            }
            for site in &cell.sites {
                positions.push(
                    scaled.point(&std::array::from_fn(|axis| corner[axis] + site.place[axis])),
                );
                rotations.push(site.rotation);
            }
        }
        Ok(Self {
            space: scaled.repeated(&repeats),
            positions,
            rotations,
            cell: cell.clone(),
            cells,
        })
    }

    /// A number of bodies, whole cells of them and not less than the given one, whose box cannot shrink below the
    /// least length at constant pressure: as much room is left as for a cube of the given number. Bodies have this mean volume.
    pub fn fewest_bodies_from(&self, bodies: usize, mean_volume: f64, least: f64) -> usize {
        let unit = (bodies as f64 * mean_volume).powf(1.0 / D as f64);
        fewest_bodies(&self.cell, bodies, mean_volume, unit.max(least))
    }

    /// The bodies on their sites.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// use protomer_hpmc::crystal::{Crystal, UnitCell};
    /// let ball = HardBody::<3>::ball(0.5)?;
    /// let crystal = |packing| Crystal::new(&UnitCell::by_name("simple-cubic")?, &ball, 64, packing);
    /// assert!(crystal(0.5)?.system(&ball, &[]).is_ok());
    /// assert!(crystal(0.53)?.system(&ball, &[]).is_err(), "the balls touch at π/6");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// If they overlap there, or the box is too small.
    pub fn system(&self, body: &HardBody<D>, depletants: &[Depletant]) -> Result<System<D>> {
        let mixture = Mixture::equal(body.clone(), self.positions.len());
        self.system_of(&mixture, depletants)
    }

    /// Variant of [`system`](Self::system) for bodies of several kinds, as many as there are sites.
    ///
    /// # Errors
    /// As [`system`](Self::system).
    pub fn system_of(&self, mixture: &Mixture<D>, depletants: &[Depletant]) -> Result<System<D>> {
        let (edge, least) = (
            self.space.smallest_length(),
            least_edge(mixture.widest(), depletants),
        );
        if edge < least {
            let bodies = self.positions.len();
            let packing_fraction = bodies as f64 * mean_volume(mixture) / self.space.volume();
            let volume_per_body = mean_volume(mixture) / packing_fraction;
            return Err(Error::BoxTooSmall {
                edge,
                least,
                bodies: fewest_bodies(&self.cell, bodies, volume_per_body, least),
            });
        }
        let at_scale = |scale: f64| {
            let place = |place: &[f64; D]| place.map(|x| x * scale);
            System::of_mixture(
                mixture.clone(),
                depletants.to_vec(),
                self.space.scaled(scale),
                self.positions.iter().map(place).collect(),
                self.rotations.clone(),
            )
        };
        let system = at_scale(1.0)?;
        if !system.has_overlaps() {
            return Ok(system);
        }
        // Convex bodies that are apart stay so in a wider box.
        // A bracket: overlapping at `tight`, free at `wide`.
        let (mut tight, mut wide) = (1.0, 2.0);
        while at_scale(wide)?.has_overlaps() {
            wide *= 2.0;
        }
        for _ in 0..30 {
            let middle = 0.5 * (tight + wide);
            if at_scale(middle)?.has_overlaps() {
                tight = middle;
            } else {
                wide = middle;
            }
        }
        // 30 halvings: nine digits of the scale, more than an error message shows.
        let wanted = system.packing_fraction();
        Err(Error::Dense {
            wanted,
            largest: wanted / wide.powi(D as i32),
        })
    }

    /// The first two bodies that overlap, over all images; the same number twice for a body and an image of it.
    /// The box may be as small as it likes.
    ///
    /// ```
    /// use protomer_hpmc::body::HardBody;
    /// use protomer_hpmc::crystal::{Crystal, UnitCell};
    /// let ball = HardBody::<3>::ball(0.5)?;
    /// let crystal = |packing| Crystal::new(&UnitCell::by_name("fcc")?, &ball, 32, packing);
    /// assert_eq!(crystal(0.74)?.first_overlap(&ball), None);
    /// assert!(crystal(0.75)?.first_overlap(&ball).is_some());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn first_overlap(&self, body: &HardBody<D>) -> Option<[usize; 2]> {
        let space = self.space.reduced();
        let reach = 2.0 * body.outer_radius;
        let rotated_corners = |rotation: &Rotation| {
            let mut corners = vec![[[0.0; 4]; D]; body.blocks()];
            body.turned_into(rotation, &mut corners);
            corners
        };
        let corners: Vec<Vec<Block<D>>> = self.rotations.iter().map(rotated_corners).collect();
        let places: Vec<[f64; D]> = self.positions.iter().map(|x| space.wrap(x)).collect();
        for first in 0..places.len() {
            for second in first..places.len() {
                let apart = std::array::from_fn(|axis| places[second][axis] - places[first][axis]);
                let overlaps = |offset: [f64; D]| {
                    // A body may meet its own image, but not itself.
                    (first != second || norm(&offset) > 0.0)
                        && body.overlaps_at(body, &corners[first], &corners[second], &offset)
                };
                if space.any_image_within(&apart, reach, overlaps) {
                    return Some([first, second]);
                }
            }
        }
        None
    }

    /// The translations of the lattice to near sites: edges of the unit cell, and what is shorter.
    fn translations(&self, symmetry: &Symmetry) -> Vec<[f64; D]> {
        let cell = self.scaled_cell();
        let edges = (0..D).map(|number| norm(&cell.edge(number)));
        let longest = edges.fold(0.0, f64::max) * (1.0 + SAME);
        let first = &self.cell.sites[0];
        let mut translations = Vec::new();
        for site in &self.cell.sites {
            if !self.cell.is_translation(site, symmetry) {
                continue;
            }
            // Neighbouring cells, 3^D of them, by digits in base three.
            for image in 0..3_usize.pow(D as u32) {
                let mut quotient = image;
                let translation = cell.point(&std::array::from_fn(|axis| {
                    let shift = (quotient % 3) as f64 - 1.0;
                    quotient /= 3;
                    site.place[axis] - first.place[axis] + shift
                }));
                let length = norm(&translation);
                // Up to the longest edge: longer translations are sums of these.
                if length > SAME * longest && length <= longest {
                    translations.push(translation);
                }
            }
        }
        translations
    }

    /// The unit cell in its size.
    fn scaled_cell(&self) -> PeriodicBox<D> {
        let volume = self.space.volume() / self.cells as f64;
        let scale = (volume / self.cell.space.volume()).powf(1.0 / D as f64);
        self.cell.space.scaled(scale)
    }

    /// The bonds between equal sites, with the translations across them.
    pub(crate) fn bonds(&self, symmetry: &Symmetry) -> Vec<Bond<D>> {
        let translations = self.translations(symmetry);
        let mut bonds = Vec::new();
        for translation in &translations {
            let is_across = |slip: &&[f64; D]| {
                dot(slip, translation).abs() < ACROSS * norm(slip) * norm(translation)
            };
            let slips: Vec<[f64; D]> = translations.iter().filter(is_across).copied().collect();
            if slips.is_empty() {
                continue;
            }
            // A translation takes each site to another of the same crystal, or it is none.
            let site_at = |place: &[f64; D]| {
                let is_near = |other: &[f64; D]| {
                    let apart =
                        std::array::from_fn(|axis| other[axis] - place[axis] - translation[axis]);
                    norm(&self.space.nearest_image(&apart)) < SAME * norm(translation)
                };
                self.positions.iter().position(is_near)
            };
            let others: Option<Vec<usize>> = self.positions.iter().map(site_at).collect();
            if let Some(others) = others {
                bonds.push(Bond { slips, others });
            }
        }
        bonds
    }

    /// The volume of the smallest cell that, repeated, makes the crystal: translations by its edges
    /// exchange the bodies and change nothing.
    pub fn primitive_volume(&self, symmetry: &Symmetry) -> f64 {
        let sites = self.cell.sites.iter();
        let translations = sites
            .filter(|site| self.cell.is_translation(site, symmetry))
            .count();
        self.space.volume() / (self.cells * translations.max(1)) as f64
    }
}

/// Mean volume of a body; of equal bodies without the rounding of a sum.
fn mean_volume<const D: usize>(mixture: &Mixture<D>) -> f64 {
    match mixture.kinds() {
        [body] => body.volume,
        _ => mixture.mean_volume(),
    }
}

/// A unit cell in the size that a crystal of so many bodies has, with so much volume for each, and how often it is
/// repeated.
fn cells_of_crystal<const D: usize>(
    cell: &UnitCell<D>,
    bodies: usize,
    volume_per_body: f64,
) -> (PeriodicBox<D>, [usize; D]) {
    let edges = std::array::from_fn(|number| norm(&cell.space.edge(number)));
    let repeats = repeats(&edges, bodies / cell.sites.len());
    let relative = cell.space.repeated(&repeats).volume();
    let scale = (bodies as f64 * volume_per_body / relative).powf(1.0 / D as f64);
    (cell.space.scaled(scale), repeats)
}

/// A number of bodies, whole cells of them and at least as many as given, whose box has no length below the least.
/// It is found by trying, because cells may have to be repeated more along one axis than along another.
fn fewest_bodies<const D: usize>(
    cell: &UnitCell<D>,
    bodies: usize,
    volume_per_body: f64,
    least: f64,
) -> usize {
    let sites = cell.sites.len();
    let length = |bodies: usize| {
        let (cell, repeats) = cells_of_crystal(cell, bodies, volume_per_body);
        cell.repeated(&repeats).smallest_length()
    };
    // No box is shorter than a cube of its volume.
    let cube = (bodies as f64 * volume_per_body).powf(1.0 / D as f64);
    let from = bodies.max(bodies_in_longer_box::<D>(bodies, least / cube));
    first_that_works(from.div_ceil(sites) * sites, sites, |bodies| {
        length(bodies) >= least
    })
}

/// Number of times that a cell is repeated along each axis, so that the longest edge of all is
/// shortest.
fn repeats<const D: usize>(edges: &[f64; D], cells: usize) -> [usize; D] {
    let (mut best, mut shortest) = ([1; D], f64::INFINITY);
    let divisors: Vec<usize> = (1..=cells).filter(|n| cells.is_multiple_of(*n)).collect();
    // Every choice of divisors for all axes but the last, which takes what is left.
    for first in 0..divisors.len().pow(D as u32 - 1) {
        let (mut quotient, mut remaining_cells, mut repeats) = (first, cells, [1; D]);
        for repeat in repeats.iter_mut().take(D - 1) {
            *repeat = divisors[quotient % divisors.len()];
            quotient /= divisors.len();
            if !remaining_cells.is_multiple_of(*repeat) {
                remaining_cells = 0;
                break;
            }
            remaining_cells /= *repeat;
        }
        if remaining_cells == 0 {
            continue;
        }
        repeats[D - 1] = remaining_cells;
        let lengths = (0..D).map(|axis| edges[axis] * repeats[axis] as f64);
        let longest = lengths.fold(0.0, f64::max);
        // Clearly shorter only: rounding must not choose between equal shapes.
        if longest < shortest * (1.0 - 1e-9) {
            (best, shortest) = (repeats, longest);
        }
    }
    best
}

#[cfg(test)]
mod tests;
