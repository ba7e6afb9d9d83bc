//! Crystals: unit cells of any shape, repeated until they hold all bodies.

use crate::body::{HardBody, norm};
use crate::error::{require, require_packing_fraction};
use crate::mixture::Mixture;
use crate::reservoir::Depletant;
use crate::symmetry::{Symmetry, frame};
use crate::system::{System, bodies_in_longer_box, first_that_works, least_edge};
use crate::{Error, Result};
use nalgebra::Rotation3;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::separation::{Block, dot};
use protomer_kernel::{Rotation, Vec3};

/// Names of unit cells, by dimension.
pub const NAMES: [&[&str]; 3] = [
    &["row"],
    &["square", "hexagonal"],
    &[
        "simple-cubic",
        "fcc",
        "bcc",
        "hcp",
        "diamond",
        "hexagonal-diamond",
        "a15",
    ],
];

/// Names of unit cells with sites for several kinds of bodies, by dimension.
pub const NAMES_OF_SEVERAL: [&[&str]; 3] = [
    &["alternating"],
    &["checkerboard"],
    &["nacl", "cscl", "zincblende", "wurtzite"],
];

/// Sites nearer to each other than this part of the cell are the same.
const SAME: f64 = 1e-6;
/// Translations are across a bond if the cosine of their angle is less.
const ACROSS: f64 = 0.25;

/// A site of a unit cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site<const D: usize> {
    /// The place, in parts of the edges.
    pub place: [f64; D],
    /// The orientation of the body on it.
    pub rotation: Rotation,
    /// Number of the kind of the body on it.
    pub kind: u32,
}

/// A unit cell.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_hpmc::crystal::{Crystal, Site, UnitCell};
/// use protomer_kernel::{Rotation, periodic_box::PeriodicBox};
/// let site = |place| Site { place, rotation: Rotation::identity(), kind: 0 };
/// let honeycomb = UnitCell {
///     space: PeriodicBox::with_angles(&[1.0, 1.0], &[60.0])?,
///     sites: vec![site([0.0, 0.0]), site([1.0 / 3.0, 1.0 / 3.0])],
/// };
/// let disk = HardBody::<2>::ball(0.5)?;
/// let crystal = |packing| Crystal::new(&honeycomb, &disk, 32, packing);
/// // Disks of a honeycomb touch at π/(3√3) = 0.6046.
/// assert_eq!(crystal(0.604)?.first_overlap(&disk), None);
/// assert!(crystal(0.605)?.first_overlap(&disk).is_some());
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct UnitCell<const D: usize> {
    /// Shape of the cell; the size does not matter.
    pub space: PeriodicBox<D>,
    /// The sites.
    pub sites: Vec<Site<D>>,
}

impl<const D: usize> UnitCell<D> {
    /// The unit cell of this name, with bodies as their shapes have them.
    ///
    /// In the diamonds, the bodies of the two kinds of sites are turned so that the faces of a (truncated)
    /// tetrahedron by name look at the four neighbours. In the hexagonal crystal, nearest neighbours
    /// are at odd multiples of 30 degrees from the first axis, where hexagons by name have their
    /// edges. The cells of several kinds are a row and a square with two kinds alternating, rock salt, caesium chloride, and the
    /// two diamonds with a kind on either kind of site.
    ///
    /// # Errors
    /// For an unknown name, which lists the [`NAMES`] and the [`NAMES_OF_SEVERAL`].
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// assert_eq!(UnitCell::<3>::by_name("fcc")?.sites.len(), 4);
    /// assert_eq!(UnitCell::<3>::by_name("nacl")?.composition(), [4, 4]);
    /// assert!(UnitCell::<2>::by_name("fcc").is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn by_name(name: &str) -> Result<Self> {
        let (edges, places): (&[f64], &[&[f64]]) = match (D, name) {
            (1, "row") => (&[1.0], &[&[0.0]]),
            (2, "square") => (&[1.0; 2], &[&[0.0; 2]]),
            (2, "hexagonal" | "triangular") => (&[SQRT_3, 1.0], &[&[0.0; 2], &[0.5; 2]]),
            (3, "simple-cubic" | "sc") => (&[1.0; 3], &[&[0.0; 3]]),
            (3, "bcc") => (&[1.0; 3], &[&[0.0; 3], &[0.5; 3]]),
            (3, "fcc") => (&[1.0; 3], &FCC),
            (3, "hcp") => (&[1.0, SQRT_3, SQRT_8_3], &HCP),
            (3, "a15") => (&[1.0; 3], &A15),
            (3, "diamond" | "zincblende") => (&[1.0; 3], &DIAMOND),
            (3, "hexagonal-diamond" | "wurtzite") => (&[1.0, SQRT_3, SQRT_8_3], &HEXAGONAL_DIAMOND),
            (1, "alternating") => (&[1.0], &[&[0.0], &[0.5]]),
            (2, "checkerboard") => (&[1.0; 2], &[&[0.0; 2], &[0.5; 2]]),
            (3, "cscl") => (&[1.0; 3], &[&[0.0; 3], &[0.5; 3]]),
            (3, "nacl") => (&[1.0; 3], &ROCK_SALT),
            _ => {
                return Err(Error::UnknownCrystal {
                    name: name.to_owned(),
                    dimension: D,
                    names: [NAMES[D - 1], NAMES_OF_SEVERAL[D - 1]].concat(),
                });
            }
        };
        let mut cell = Self {
            space: PeriodicBox::rectangular(std::array::from_fn(|axis| edges[axis]))?,
            sites: Vec::new(),
        };
        let is_of_several = NAMES_OF_SEVERAL[D - 1].contains(&name);
        for (number, place) in places.iter().enumerate() {
            // Sites of the second kind are the second half, but for wurtzite, whose layers come in pairs.
            let second = match name {
                "wurtzite" => number / 2 % 2,
                _ => 2 * number / places.len(),
            };
            cell.sites.push(Site {
                place: std::array::from_fn(|axis| place[axis]),
                rotation: Rotation::identity(),
                kind: if is_of_several { second as u32 } else { 0 },
            });
        }
        if name.ends_with("diamond") || ["zincblende", "wurtzite"].contains(&name) {
            cell.turn_to_neighbours();
        }
        Ok(cell)
    }

    /// Number of sites of each kind of bodies.
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// assert_eq!(UnitCell::<3>::by_name("cscl")?.composition(), [1, 1]);
    /// assert_eq!(UnitCell::<3>::by_name("bcc")?.composition(), [2]);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn composition(&self) -> Vec<usize> {
        let kinds = self.sites.iter().map(|site| site.kind as usize + 1).max();
        let count = |kind| {
            self.sites
                .iter()
                .filter(move |site| site.kind as usize == kind)
        };
        (0..kinds.unwrap_or(0))
            .map(|kind| count(kind).count())
            .collect()
    }

    /// The kind of each of so many bodies, as the sites of repeated cells have them.
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// assert_eq!(UnitCell::<3>::by_name("cscl")?.kinds_of_bodies(4), [0, 1, 0, 1]);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn kinds_of_bodies(&self, bodies: usize) -> Vec<u32> {
        let kinds = self.sites.iter().map(|site| site.kind).cycle();
        kinds.take(bodies).collect()
    }

    /// Turns each body so that the faces of a tetrahedron look at the four nearest sites.
    fn turn_to_neighbours(&mut self) {
        for number in 0..self.sites.len() {
            let mut bonds = Vec::new();
            for other in 0..self.sites.len() {
                // The 27 images around: nearest sites may be in the next cell.
                for image in 0..27 {
                    let shift = [image % 3, image / 3 % 3, image / 9].map(|x| f64::from(x) - 1.0);
                    let parts = std::array::from_fn(|axis| {
                        let [from, to] = [number, other].map(|site| self.sites[site].place[axis]);
                        to - from + shift[axis]
                    });
                    let vector = self.space.point(&parts);
                    let bond = Vec3::from_fn(|axis, _| vector.get(axis).copied().unwrap_or(0.0));
                    if bond.norm() > SAME {
                        bonds.push(bond);
                    }
                }
            }
            // The four shortest vectors are the bonds of a diamond.
            bonds.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
            bonds.truncate(4);
            self.sites[number].rotation = faces_along(&bonds);
        }
    }

    /// The same cell with every body turned first, in its own frame.
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// use protomer_kernel::{Rotation, Vec3};
    /// let quarter_turn = Rotation::new(std::f64::consts::FRAC_PI_2 * Vec3::z());
    /// let cell = UnitCell::<3>::by_name("bcc")?.with_bodies_turned(&quarter_turn);
    /// assert!(cell.sites.iter().all(|site| site.rotation.angle_to(&quarter_turn) < 1e-12));
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn with_bodies_turned(mut self, rotation: &Rotation) -> Self {
        for site in &mut self.sites {
            // Turned in its own frame: the orientation on the site comes after.
            site.rotation *= rotation;
        }
        self
    }

    /// Whether the cell, moved by the way from its first site to another, looks as before.
    fn is_translation(&self, to: &Site<D>, symmetry: &Symmetry) -> bool {
        let first = &self.sites[0];
        self.sites.iter().all(|site| {
            let shifted_place: [f64; D] =
                std::array::from_fn(|axis| site.place[axis] + to.place[axis] - first.place[axis]);
            let lands_on = |other: &Site<D>| {
                is_same_place(&shifted_place, &other.place)
                    && other.kind == site.kind
                    && symmetry.are_alike(&other.rotation, &site.rotation)
            };
            self.sites.iter().any(lands_on)
        })
    }

    fn check(&self) -> Result<()> {
        require(
            "the number of sites of the unit cell",
            self.sites.len() as f64,
            "at least 1",
            !self.sites.is_empty(),
        )?;
        let volume = self.space.volume();
        let holds = volume.is_normal();
        require(
            "the volume of the unit cell",
            volume,
            "from 1e-307 to 1e308",
            holds,
        )?;
        let fewest = self.composition().into_iter().min().unwrap_or(0);
        require(
            "the number of sites of a kind in the unit cell",
            fewest as f64,
            "at least 1: number the kinds without gaps",
            fewest > 0,
        )?;
        for (second, site) in self.sites.iter().enumerate() {
            if let Some(first) = self.sites[..second]
                .iter()
                .position(|other| is_same_place(&other.place, &site.place))
            {
                return Err(Error::SameSite {
                    bodies: [first + 1, second + 1],
                });
            }
        }
        Ok(())
    }
}

/// Whether two places, in parts of the edges, are the same or images of each other.
fn is_same_place<const D: usize>(one: &[f64; D], other: &[f64; D]) -> bool {
    let mut apart = one.iter().zip(other).map(|(a, b)| a - b);
    apart.all(|x| (x - x.round()).abs() < SAME)
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;
const SQRT_8_3: f64 = 1.632_993_161_855_452;
const THIRD: f64 = 1.0 / 3.0;
const FCC: [&[f64]; 4] = [
    &[0.0, 0.0, 0.0],
    &[0.0, 0.5, 0.5],
    &[0.5, 0.0, 0.5],
    &[0.5, 0.5, 0.0],
];
const ROCK_SALT: [&[f64]; 8] = [
    &[0.0, 0.0, 0.0],
    &[0.0, 0.5, 0.5],
    &[0.5, 0.0, 0.5],
    &[0.5, 0.5, 0.0],
    &[0.5, 0.0, 0.0],
    &[0.5, 0.5, 0.5],
    &[0.0, 0.0, 0.5],
    &[0.0, 0.5, 0.0],
];
const HCP: [&[f64]; 4] = [
    &[0.0, 0.0, 0.0],
    &[0.5, 0.5, 0.0],
    &[0.0, THIRD, 0.5],
    &[0.5, 0.5 + THIRD, 0.5],
];
/// β-tungsten or Cr₃Si (Strukturbericht A15): a body-centred lattice, and on the faces chains along the three axes.
const A15: [&[f64]; 8] = [
    &[0.0, 0.0, 0.0],
    &[0.5, 0.5, 0.5],
    &[0.0, 0.5, 0.25],
    &[0.0, 0.5, 0.75],
    &[0.25, 0.0, 0.5],
    &[0.75, 0.0, 0.5],
    &[0.5, 0.25, 0.0],
    &[0.5, 0.75, 0.0],
];
const DIAMOND: [&[f64]; 8] = [
    &[0.0, 0.0, 0.0],
    &[0.0, 0.5, 0.5],
    &[0.5, 0.0, 0.5],
    &[0.5, 0.5, 0.0],
    &[0.25, 0.25, 0.25],
    &[0.25, 0.75, 0.75],
    &[0.75, 0.25, 0.75],
    &[0.75, 0.75, 0.25],
];
const HEXAGONAL_DIAMOND: [&[f64]; 8] = [
    &[0.0, THIRD, 0.0625],
    &[0.5, THIRD + 0.5, 0.0625],
    &[0.0, THIRD, 0.4375],
    &[0.5, THIRD + 0.5, 0.4375],
    &[0.5, 0.5 * THIRD, 0.5625],
    &[0.0, 0.5 * THIRD + 0.5, 0.5625],
    &[0.5, 0.5 * THIRD, 0.9375],
    &[0.0, 0.5 * THIRD + 0.5, 0.9375],
];

/// A rotation that takes the faces of a tetrahedron by name to four directions.
fn faces_along(directions: &[Vec3]) -> Rotation {
    let face = |x: f64, y: f64, z: f64| Vec3::new(-x, -y, -z).normalize();
    let faces = [
        face(1.0, 1.0, 1.0),
        face(1.0, -1.0, -1.0),
        face(-1.0, 1.0, -1.0),
        face(-1.0, -1.0, 1.0),
    ];
    // Two faces fix the orientation; the others check it.
    let from = frame(&faces[0], &faces[1]);
    for first in directions {
        for second in directions {
            if (first - second).norm() < SAME {
                continue;
            }
            // Any pair of bonds may stand for the first two faces.
            let matrix = frame(first, second) * from.transpose();
            let looks_along = |face: &Vec3| {
                let normal = matrix * face;
                let is_near = |way: &Vec3| (way.normalize() - normal).norm() < 1e-3;
                directions.iter().any(is_near)
            };
            if faces.iter().all(looks_along) {
                let rotation = Rotation3::from_matrix_unchecked(matrix);
                return Rotation::from_rotation_matrix(&rotation);
            }
        }
    }
    Rotation::identity()
}

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
mod tests {
    use super::*;
    use protomer_kernel::shape::{Shape, builders::by_name};
    use std::f64::consts::PI;

    fn ball<const D: usize>() -> HardBody<D> {
        let shape = match D {
            2 => Shape::flat(&[[0.0, 0.0]]),
            _ => Shape::solid(&[Vec3::zeros()]),
        };
        HardBody::new(&shape.unwrap(), 0.5).unwrap()
    }

    #[test]
    fn every_name_is_that_of_a_unit_cell() {
        assert!(
            NAMES[0]
                .iter()
                .all(|name| UnitCell::<1>::by_name(name).is_ok())
        );
        assert!(
            NAMES[1]
                .iter()
                .all(|name| UnitCell::<2>::by_name(name).is_ok())
        );
        assert!(
            NAMES[2]
                .iter()
                .all(|name| UnitCell::<3>::by_name(name).is_ok())
        );
        assert!(UnitCell::<1>::by_name(NAMES_OF_SEVERAL[0][0]).is_ok());
    }

    /// Neighbours that touch are of the other kind, and as many as in the minerals.
    #[test]
    fn cells_of_several_kinds_alternate() {
        fn neighbours<const D: usize>(name: &str, expected: usize) {
            let cell = UnitCell::<D>::by_name(name).unwrap();
            let [first, second] = cell.composition()[..] else {
                unreachable!("{name}")
            };
            assert_eq!(first, second);
            let mixture =
                Mixture::new(vec![ball(), ball()], cell.kinds_of_bodies(216 * 2 * first)).unwrap();
            let crystal = Crystal::of_mixture(&cell, &mixture, &[], 0.1).unwrap();
            let way = |one: usize, other: usize| {
                let apart = std::array::from_fn(|axis| {
                    crystal.positions[other][axis] - crystal.positions[one][axis]
                });
                norm(&crystal.space.nearest_image(&apart))
            };
            let others = |one: usize| (0..mixture.len()).filter(move |other| *other != one);
            for one in 0..cell.sites.len() {
                let nearest = others(one)
                    .map(|other| way(one, other))
                    .fold(f64::INFINITY, f64::min);
                let touching = others(one).filter(|other| way(one, *other) < 1.001 * nearest);
                let touching: Vec<usize> = touching.collect();
                assert_eq!(touching.len(), expected, "{name}");
                assert!(
                    touching
                        .iter()
                        .all(|other| mixture.kind_of()[*other] != mixture.kind_of()[one])
                );
            }
        }
        neighbours::<3>("nacl", 6);
        neighbours::<3>("cscl", 8);
        neighbours::<3>("zincblende", 4);
        neighbours::<3>("wurtzite", 4);
        neighbours::<2>("checkerboard", 4);
    }

    /// Balls of two sizes touch as in the minerals.
    #[test]
    fn balls_of_two_sizes_pack_as_densely_as_their_radii_allow() {
        let densest = |name: &str, radii: [f64; 2], bodies: usize| {
            let cell = UnitCell::<3>::by_name(name).unwrap();
            let kinds = radii.map(|radius| HardBody::ball(radius).unwrap()).to_vec();
            let mixture = Mixture::new(kinds, cell.kinds_of_bodies(bodies)).unwrap();
            let crystal = Crystal::of_mixture(&cell, &mixture, &[], 0.95).unwrap();
            match crystal.system_of(&mixture, &[]) {
                Err(Error::Dense { largest, .. }) => largest,
                other => unreachable!("{name}: {other:?}"),
            }
        };
        let small = 2.0_f64.sqrt() - 1.0;
        // Both kinds touch: edge 2 (1 + r), four of each.
        let edge = 2.0 * (1.0 + small);
        let rock_salt = 16.0 / 3.0 * PI * (1.0 + small.powi(3)) / edge.powi(3);
        assert!((densest("nacl", [1.0, small], 512) - rock_salt).abs() < 1e-7);
        let small = 3.0_f64.sqrt() - 1.0;
        let caesium = 4.0 / 3.0 * PI * (1.0 + small.powi(3)) / 8.0;
        assert!((densest("cscl", [1.0, small], 250) - caesium).abs() < 1e-7);
    }

    #[test]
    fn crystals_of_several_kinds_refuse_bodies_of_one() {
        let cell = UnitCell::<3>::by_name("nacl").unwrap();
        let refused = Crystal::new(&cell, &ball(), 64, 0.1).unwrap_err();
        assert_eq!(refused, Error::KindsOfCrystal { kinds: 2, given: 1 });
        let gap = UnitCell {
            sites: vec![Site {
                kind: 1,
                ..cell.sites[0]
            }],
            ..cell
        };
        let words = Crystal::new(&gap, &ball(), 64, 0.1)
            .unwrap_err()
            .to_string();
        assert!(words.contains("without gaps"), "{words}");
    }

    /// The largest packing fraction of a crystal, as its error tells it.
    fn densest<const D: usize>(name: &str, body: &HardBody<D>, bodies: usize) -> f64 {
        let cell = UnitCell::by_name(name).unwrap();
        let crystal = Crystal::new(&cell, body, bodies, 0.999).unwrap();
        match crystal.system(body, &[]) {
            Err(Error::Dense { largest, .. }) => largest,
            Err(other) => unreachable!("{name}: {other}"),
            Ok(_) => 0.999,
        }
    }

    #[test]
    fn balls_pack_as_densely_as_the_crystals_allow() {
        for (name, bodies, expected) in [
            ("simple-cubic", 64, PI / 6.0),
            ("bcc", 128, PI * 3.0_f64.sqrt() / 8.0),
            ("fcc", 108, PI / 18.0_f64.sqrt()),
            ("hcp", 96, PI / 18.0_f64.sqrt()),
            ("diamond", 64, PI * 3.0_f64.sqrt() / 16.0),
            // Neighbours along the chains are half an edge apart.
            ("a15", 64, PI / 6.0),
            ("hexagonal-diamond", 64, PI * 3.0_f64.sqrt() / 16.0),
        ] {
            let found = densest(name, &ball::<3>(), bodies);
            assert!((found - expected).abs() < 1e-7, "{name}: {found}");
        }
        for (name, expected) in [("square", PI / 4.0), ("hexagonal", PI / 12.0_f64.sqrt())] {
            let found = densest(name, &ball::<2>(), 64);
            assert!((found - expected).abs() < 1e-7, "{name}: {found}");
        }
    }

    /// One unit cell, smaller than its bodies reach, says what many cells say.
    #[test]
    fn bodies_that_overlap_are_found_in_one_cell() {
        let fcc = PI / 18.0_f64.sqrt();
        let rhombohedral = UnitCell {
            space: PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3]).unwrap(),
            ..UnitCell::by_name("simple-cubic").unwrap()
        };
        for (cell, at, densest) in [
            (UnitCell::by_name("simple-cubic").unwrap(), [0, 0], PI / 6.0),
            (UnitCell::by_name("fcc").unwrap(), [0, 1], fcc),
            (rhombohedral, [0, 0], fcc),
        ] {
            let overlap = |packing: f64| {
                let crystal = Crystal::new(&cell, &ball(), cell.sites.len(), packing);
                crystal.unwrap().first_overlap(&ball())
            };
            assert_eq!(overlap(densest - 1e-6), None);
            assert_eq!(overlap(densest + 1e-6), Some(at));
        }
        let solid = by_name("truncated-tetrahedron:0.6666666666666666").unwrap();
        let body = HardBody::<3>::new(&solid, 0.0).unwrap();
        let cell = UnitCell::by_name("diamond").unwrap();
        let overlap = |packing: f64| {
            let crystal = Crystal::new(&cell, &body, 8, packing).unwrap();
            crystal.first_overlap(&body)
        };
        assert_eq!(overlap(23.0 / 24.0 - 1e-6), None);
        assert_eq!(overlap(23.0 / 24.0 + 1e-6), Some([0, 1]));
    }

    /// The box of a tilted cell is as dense as that of a cubic one, and an oblique one of disks as a hexagonal
    /// one with right angles.
    #[test]
    fn cells_with_angles_make_the_same_crystals() {
        let rhombohedral = UnitCell {
            space: PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3]).unwrap(),
            ..UnitCell::by_name("simple-cubic").unwrap()
        };
        let oblique = UnitCell {
            space: PeriodicBox::with_angles(&[1.0; 2], &[120.0]).unwrap(),
            ..UnitCell::by_name("square").unwrap()
        };
        let crystal = Crystal::new(&rhombohedral, &ball::<3>(), 60, 0.999).unwrap();
        let Err(Error::Dense { largest, .. }) = crystal.system(&ball(), &[]) else {
            unreachable!()
        };
        assert!((largest - PI / 18.0_f64.sqrt()).abs() < 1e-7, "{largest}");
        let crystal = Crystal::new(&oblique, &ball::<2>(), 60, 0.999).unwrap();
        let Err(Error::Dense { largest, .. }) = crystal.system(&ball(), &[]) else {
            unreachable!()
        };
        assert!((largest - PI / 12.0_f64.sqrt()).abs() < 1e-7, "{largest}");
    }

    /// The two diamonds of Archimedean truncated tetrahedra close at 23/24; hexagons fill the
    /// plane.
    #[test]
    fn faces_look_at_their_neighbours() {
        let name = "truncated-tetrahedron:0.6666666666666666";
        let body = HardBody::<3>::new(&by_name(name).unwrap(), 0.0).unwrap();
        for name in ["diamond", "hexagonal-diamond"] {
            let found = densest(name, &body, 216);
            assert!((found - 23.0 / 24.0).abs() < 1e-6, "{name}: {found}");
        }
        let hexagon = HardBody::<2>::new(&by_name("polygon:6").unwrap(), 0.0).unwrap();
        assert_eq!(densest("hexagonal", &hexagon, 64), 0.999);
    }

    #[test]
    fn translations_are_counted_with_orientations() {
        let body = HardBody::<3>::new(&by_name("tetrahedron").unwrap(), 0.0).unwrap();
        let symmetry = Symmetry::find(&body).unwrap();
        for (name, bodies, sites) in [
            ("fcc", 108, 1.0),
            ("hcp", 96, 2.0),
            ("diamond", 64, 2.0),
            ("hexagonal-diamond", 64, 4.0),
        ] {
            let cell = UnitCell::by_name(name).unwrap();
            let crystal = Crystal::new(&cell, &body, bodies, 0.1).unwrap();
            let found = crystal.primitive_volume(&symmetry) * 0.1 / body.volume;
            assert!((found - sites).abs() < 1e-9, "{name}: {found}");
        }
        // Without its orientations the hexagonal diamond still has four sites, a turned fcc has four.
        let mut cell = UnitCell::<3>::by_name("fcc").unwrap();
        for (number, site) in cell.sites.iter_mut().enumerate() {
            site.rotation = Rotation::from_scaled_axis(0.2 * number as f64 * Vec3::x());
        }
        let crystal = Crystal::new(&cell, &body, 108, 0.1).unwrap();
        let found = crystal.primitive_volume(&symmetry) * 0.1 / body.volume;
        assert!((found - 4.0).abs() < 1e-9, "{found}");
    }

    #[test]
    fn boxes_are_as_near_to_cubes_as_cells_allow() {
        assert_eq!(repeats(&[1.0; 3], 27), [3, 3, 3]);
        assert_eq!(repeats(&[1.0; 3], 24).iter().max(), Some(&4));
        assert_eq!(repeats(&[3.0_f64.sqrt(), 1.0], 40), [5, 8]);
        assert_eq!(repeats(&[1.0], 7), [7]);
        let cell = UnitCell::<3>::by_name("fcc").unwrap();
        let refused = Crystal::new(&cell, &ball(), 100, 0.5);
        assert!(refused.is_ok());
        let refused = Crystal::new(&cell, &ball(), 110, 0.5).unwrap_err();
        assert!(refused.to_string().contains("such as 108"), "{refused}");
    }

    fn dipyramid() -> HardBody<3> {
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.8]].map(Vec3::from);
        let both: Vec<Vec3> = corners.iter().flat_map(|x| [*x, -x]).collect();
        HardBody::new(&Shape::solid(&both).unwrap(), 0.0).unwrap()
    }

    /// Whatever cell and number one begins with, the number that an error names makes a crystal, at once.
    #[test]
    fn numbers_that_errors_name_make_crystals() {
        let body = dipyramid();
        let cell = |edges: [f64; 3], angles: &[f64]| UnitCell {
            space: PeriodicBox::with_angles(&edges, angles).unwrap(),
            ..UnitCell::by_name("bcc").unwrap()
        };
        for cell in [
            cell([1.0, 1.0, 1.8], &[90.0; 3]),
            cell([1.0, 1.0, 7.0], &[90.0; 3]),
            cell([1.0, 2.0, 3.0], &[70.0, 80.0, 110.0]),
        ] {
            for depletant in [None, Some(0.2)] {
                let depletants: Vec<Depletant> = depletant
                    .map(|radius| Depletant {
                        radius,
                        fugacity: 1.0,
                    })
                    .into_iter()
                    .collect();
                for bodies in [1, 2, 3, 4, 10, 167] {
                    let system = |bodies: usize| {
                        let crystal = Crystal::among(&cell, &body, &depletants, bodies, 0.02)?;
                        crystal.system(&body, &depletants)
                    };
                    let enough = match system(bodies) {
                        Ok(_) => continue,
                        Err(Error::BoxTooSmall { bodies, .. }) => bodies,
                        Err(Error::PartialCell { nearest, .. }) => nearest,
                        Err(other) => unreachable!("{bodies}: {other}"),
                    };
                    let made = system(enough);
                    assert!(made.is_ok(), "{bodies}: {enough}: {:?}", made.err());
                }
            }
        }
    }

    #[test]
    fn sites_that_coincide_are_named() {
        let ball = ball::<3>();
        for places in [
            vec![[0.0; 3], [1.0, 0.0, 0.0]],
            vec![[0.5; 3], [0.0; 3], [-1.5, 2.5, 0.5]],
            vec![[0.0; 3], [1e-9, 0.0, 1.0 - 1e-9]],
        ] {
            let sites = places.iter().map(|place| Site {
                place: *place,
                rotation: Rotation::identity(),
                kind: 0,
            });
            let cell = UnitCell {
                space: PeriodicBox::rectangular([1.0; 3]).unwrap(),
                sites: sites.collect(),
            };
            let error = Crystal::new(&cell, &ball, 60, 0.1).unwrap_err();
            let bodies = [1, places.len()];
            assert_eq!(error, Error::SameSite { bodies });
        }
    }

    /// A message says how densely bodies fit, and they do.
    #[test]
    fn bodies_fit_at_the_packing_fraction_that_an_error_names() {
        let cell = UnitCell::<3>::by_name("fcc").unwrap();
        let crystal = |packing| Crystal::new(&cell, &ball::<3>(), 108, packing).unwrap();
        let error = crystal(0.9).system(&ball(), &[]).unwrap_err().to_string();
        let named = error.rsplit(' ').next().unwrap();
        // It is 0.74048, which would be rounded to 0.7405.
        assert_eq!(named, "0.7404");
        assert!(crystal(named.parse().unwrap()).system(&ball(), &[]).is_ok());
    }
}
