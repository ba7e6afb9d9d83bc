//! Where effective charges stand, and where their potential is compared.

use super::distance::SurfaceDistances;
use crate::charged_sphere::ChargedSphere;
use crate::poisson_boltzmann::Potential;
use protomer_kernel::Vec3;
use std::collections::HashMap;

/// Charges as large as this, e, are sites if they lie at [`CHARGE_DEPTHS_ANGSTROM`] and not nearer
/// to each other than [`CHARGE_SPACING_ANGSTROM`].
const STRONG_CHARGE_E: f64 = 0.2;
/// Range below the surface, Å, in which charges are sites. Deeper ones look smooth from outside.
const CHARGE_DEPTHS_ANGSTROM: [f32; 2] = [1.0, 6.0];
/// Least distance between two charges that are sites, Å.
const CHARGE_SPACING_ANGSTROM: f64 = 2.4;
/// Other sites lie this deep below the surface, Å.
const SITE_DEPTHS_ANGSTROM: [f32; 2] = [2.0, 2.7];
/// Least distance of the other sites from each other and from the charges, Å.
const SITE_SPACING_ANGSTROM: f64 = 2.6;

/// The first layer lies this far beyond what ions cannot enter, Å.
const FIRST_LAYER_ANGSTROM: f64 = 1.5;
/// Distance of each layer from the first, Å.
const LAYERS_ANGSTROM: [f64; 6] = [0.0, 1.2, 2.8, 5.0, 7.5, 10.5];
/// The distance of neighbouring points of each layer, Å.
const POINT_SPACINGS_ANGSTROM: [f64; 6] = [1.8, 2.0, 2.6, 3.4, 4.4, 5.6];

/// A point outside, with the potential there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Position, Å.
    pub position: Vec3,
    /// The potential, kT/e.
    pub potential_kt_per_e: f64,
    /// The number of its layer.
    pub layer: usize,
}

/// Places for charges, evenly spread below the surface.
pub fn sites(
    potential: &Potential,
    distances: &SurfaceDistances,
    spheres: &[ChargedSphere],
) -> Vec<Vec3> {
    let grid = potential.grid();
    let mut chosen = Spread::new(SITE_SPACING_ANGSTROM);
    let mut strong: Vec<&ChargedSphere> = spheres
        .iter()
        .filter(|sphere| sphere.charge_e.abs() >= STRONG_CHARGE_E)
        .collect();
    strong.sort_by(|a, b| b.charge_e.abs().total_cmp(&a.charge_e.abs()));
    let [shallow, deep] = CHARGE_DEPTHS_ANGSTROM;
    for charge in strong {
        let depth = grid.locate(&charge.centre).map_or(0.0, |([i, j, k], _)| {
            distances.depth_angstrom[grid.index(i, j, k)]
        });
        if (shallow..deep).contains(&depth) {
            chosen.add(charge.centre, CHARGE_SPACING_ANGSTROM);
        }
    }
    let [shallow, deep] = SITE_DEPTHS_ANGSTROM;
    for (point, depth) in distances.depth_angstrom.iter().enumerate() {
        if (shallow..deep).contains(depth) {
            chosen.add(grid.point_at(point), SITE_SPACING_ANGSTROM);
        }
    }
    chosen.places
}

/// Points in layers around the region that ions cannot enter.
pub fn layers(
    potential: &Potential,
    distances: &SurfaceDistances,
    ion_radius_angstrom: f64,
) -> Vec<Place> {
    let grid = potential.grid();
    let mut places = Vec::new();
    for (layer, beyond) in LAYERS_ANGSTROM.iter().enumerate() {
        let near = ion_radius_angstrom + FIRST_LAYER_ANGSTROM + beyond;
        let far = near + grid.spacing_angstrom;
        let range = near as f32..far as f32;
        let spacing = POINT_SPACINGS_ANGSTROM[layer];
        let mut chosen = Spread::new(spacing);
        for (point, distance) in distances.outside_angstrom.iter().enumerate() {
            let position = grid.point_at(point);
            if range.contains(distance) && chosen.add(position, spacing) {
                places.push(Place {
                    position,
                    potential_kt_per_e: potential.at_outer_point(point),
                    layer,
                });
            }
        }
    }
    places
}

/// Points that keep a distance from each other.
struct Spread {
    places: Vec<Vec3>,
    cell_angstrom: f64,
    cells: HashMap<[i32; 3], Vec<usize>>,
}

impl Spread {
    fn new(cell_angstrom: f64) -> Self {
        Self {
            places: Vec::new(),
            cell_angstrom,
            cells: HashMap::new(),
        }
    }

    /// Adds a point unless another is nearer than `apart` (at most the size of a cell), Å, and
    /// returns whether it did.
    fn add(&mut self, place: Vec3, apart: f64) -> bool {
        let cell: [i32; 3] =
            std::array::from_fn(|axis| (place[axis] / self.cell_angstrom).floor() as i32);
        for number in 0..27 {
            let near = [
                cell[0] + number % 3 - 1,
                cell[1] + number / 3 % 3 - 1,
                cell[2] + number / 9 - 1,
            ];
            for other in self.cells.get(&near).into_iter().flatten() {
                if (self.places[*other] - place).norm_squared() < apart * apart {
                    return false;
                }
            }
        }
        self.cells.entry(cell).or_default().push(self.places.len());
        self.places.push(place);
        true
    }
}
