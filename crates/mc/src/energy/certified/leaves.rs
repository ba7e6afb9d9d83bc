//! The charges of a body in leaves of sixteen neighbours.

use crate::charges::ChargeCloud;
use protomer_kernel::Vec3;

/// Charges of a leaf.
pub(super) const LEAF: usize = 16;

/// Charges sorted into leaves; coordinates relative to the middle of the charges' box, Å. A leaf
/// that is not full repeats its first place without charge.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Leaves {
    /// Middle of the charges' box in the body's frame, Å.
    pub middle: [f64; 3],
    /// Half the extents of the charges' box, Å.
    pub half_extents: [f64; 3],
    /// Coordinates, Å.
    pub x: Vec<[f64; LEAF]>,
    /// Coordinates, Å.
    pub y: Vec<[f64; LEAF]>,
    /// Coordinates, Å.
    pub z: Vec<[f64; LEAF]>,
    /// Charges, e.
    pub charge: Vec<[f64; LEAF]>,
    /// Centre and radius of each leaf's bounding sphere, Å.
    pub spheres: Vec<[f64; 4]>,
    /// Sum of the charges' magnitudes in each leaf, e.
    pub magnitude: Vec<f64>,
}

impl Leaves {
    /// Leaves of at most [`LEAF`] charges and a radius of at most `largest_radius` (Å).
    pub fn new(charges: &ChargeCloud, largest_radius: f64) -> Self {
        let mut places: Vec<(Vec3, f64)> = charges.iter().collect();
        let Some((low, high)) = extents(&places) else {
            return Self::default();
        };
        let middle = 0.5 * (low + high);
        places.iter_mut().for_each(|place| place.0 -= middle);
        let mut leaves = Self {
            middle: middle.into(),
            half_extents: (0.5 * (high - low)).into(),
            ..Self::default()
        };
        leaves.split(&mut places, largest_radius);
        leaves
    }

    pub fn len(&self) -> usize {
        self.charge.len()
    }

    /// Halves the charges at the median of their longest extent, at a multiple of [`LEAF`], until a
    /// leaf is left.
    fn split(&mut self, places: &mut [(Vec3, f64)], largest_radius: f64) {
        let Some((low, high)) = extents(places) else {
            return;
        };
        let count = places.len();
        if count <= LEAF {
            let sphere = bounding_sphere(places);
            if sphere[3] <= largest_radius || count == 1 {
                return self.push(places, sphere);
            }
        }
        let axis = (high - low).imax();
        let middle = if count > LEAF {
            count.div_ceil(LEAF).div_ceil(2) * LEAF
        } else {
            count / 2
        };
        places.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
        let (left, right) = places.split_at_mut(middle);
        self.split(left, largest_radius);
        self.split(right, largest_radius);
    }

    fn push(&mut self, places: &[(Vec3, f64)], sphere: [f64; 4]) {
        let at = |lane: usize, axis: usize| {
            places
                .get(lane)
                .or(places.first())
                .map_or(0.0, |place| place.0[axis])
        };
        self.x.push(std::array::from_fn(|lane| at(lane, 0)));
        self.y.push(std::array::from_fn(|lane| at(lane, 1)));
        self.z.push(std::array::from_fn(|lane| at(lane, 2)));
        self.charge.push(std::array::from_fn(|lane| {
            places.get(lane).map_or(0.0, |place| place.1)
        }));
        self.spheres.push(sphere);
        self.magnitude
            .push(places.iter().map(|place| place.1.abs()).sum());
    }
}

fn extents(places: &[(Vec3, f64)]) -> Option<(Vec3, Vec3)> {
    let first = places.first()?.0;
    let low = places.iter().fold(first, |low, place| low.inf(&place.0));
    let high = places.iter().fold(first, |high, place| high.sup(&place.0));
    Some((low, high))
}

/// A small sphere about the places: the centre is drawn ever more slowly to the farthest place
/// (Bădoiu and Clarkson, SODA '03, 801 (2003)); the radius reaches the farthest place whatever the
/// centre.
fn bounding_sphere(places: &[(Vec3, f64)]) -> [f64; 4] {
    let mut centre = places.iter().map(|place| place.0).sum::<Vec3>() / places.len() as f64;
    let farthest = |centre: &Vec3| {
        places
            .iter()
            .map(|place| (place.0, (place.0 - centre).norm()))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    };
    for step in 0..200 {
        if let Some((place, _)) = farthest(&centre) {
            centre += (place - centre) / f64::from(step + 2);
        }
    }
    [
        centre.x,
        centre.y,
        centre.z,
        farthest(&centre).map_or(0.0, |far| far.1),
    ]
}
