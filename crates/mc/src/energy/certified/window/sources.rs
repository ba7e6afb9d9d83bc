//! Charges as the loops want them: a body's leaves as sources, one leaf of the other body as
//! target.

use super::super::leaves::{LEAF, Leaves};

/// Moments of a leaf.
pub const MOMENTS: usize = 14;

/// Source leaves as the loops want them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sources {
    /// Members by leaf.
    pub members: Vec<Members>,
    /// The largest radius of a leaf, Å.
    pub radius: f64,
    /// The members' places in double precision.
    pub exact: Vec<[[f64; LEAF]; 3]>,
    /// The members' charges, e.
    pub charge: Vec<[f64; LEAF]>,
    /// Bounding spheres, sixteen leaves at a time; missing ones are infinitely far.
    pub spheres: Vec<[[f64; LEAF]; 4]>,
    /// Moments about the middle of the charges' box, sixteen leaves at a time.
    pub moments: Vec<[[f64; LEAF]; MOMENTS]>,
}

/// Offsets of a leaf's members from its centre, their squares, and charges: x, y, z, |ε|², q.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Members(pub [[f32; LEAF]; 5]);

/// A leaf of the other body where it stands.
#[derive(Default)]
pub struct Target {
    /// Centre and radius of the bounding sphere, Å.
    pub centre: [f64; 3],
    pub radius: f64,
    /// Offsets of the members from the centre, Å.
    pub offset: [[f32; LEAF]; 3],
    pub exact_offset: [[f64; LEAF]; 3],
    /// |δ|², Å².
    pub square: [f64; LEAF],
    /// Charges, e, and the sum of their magnitudes.
    pub charge: [f64; LEAF],
    pub magnitude: f64,
    /// The moments of the leaf about its centre.
    pub moments: [f64; MOMENTS],
}

/// Σ q (1, y, y², y y, |y|² y, |y|⁴) in the order 1, x, y, z, xx, yy, zz, xy, xz, yz, bx, by, bz,
/// bb with b = |y|².
pub fn moments(places: [&[f64; LEAF]; 3], charge: &[f64; LEAF]) -> [f64; MOMENTS] {
    let mut sums = [0.0; MOMENTS];
    for i in 0..LEAF {
        let (x, y, z, q) = (places[0][i], places[1][i], places[2][i], charge[i]);
        let b = x * x + y * y + z * z;
        let values = [
            1.0,
            x,
            y,
            z,
            x * x,
            y * y,
            z * z,
            x * y,
            x * z,
            y * z,
            b * x,
            b * y,
            b * z,
            b * b,
        ];
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += q * value;
        }
    }
    sums
}

impl Sources {
    pub fn new(leaves: &Leaves) -> Self {
        let blocks = leaves.len().div_ceil(LEAF);
        let (mut spheres, mut all_moments) = (
            vec![[[1e9; LEAF], [1e9; LEAF], [1e9; LEAF], [0.0; LEAF]]; blocks],
            vec![[[0.0; LEAF]; MOMENTS]; blocks],
        );
        let (mut exact, mut members) = (Vec::new(), Vec::new());
        for leaf in 0..leaves.len() {
            let places = [leaves.x[leaf], leaves.y[leaf], leaves.z[leaf]];
            let centre = leaves.spheres[leaf];
            let offset: [[f64; LEAF]; 3] =
                std::array::from_fn(|axis| std::array::from_fn(|i| places[axis][i] - centre[axis]));
            let square: [f64; LEAF] =
                std::array::from_fn(|i| offset.iter().map(|axis| axis[i] * axis[i]).sum());
            let [x, y, z] = offset;
            members.push(Members(
                [x, y, z, square, leaves.charge[leaf]].map(|values| values.map(|v| v as f32)),
            ));
            for axis in 0..4 {
                spheres[leaf / LEAF][axis][leaf % LEAF] = centre[axis];
            }
            let [x, y, z] = &places;
            for (k, moment) in moments([x, y, z], &leaves.charge[leaf])
                .into_iter()
                .enumerate()
            {
                all_moments[leaf / LEAF][k][leaf % LEAF] = moment;
            }
            exact.push(places);
        }
        let radius = leaves
            .spheres
            .iter()
            .map(|sphere| sphere[3])
            .fold(0.0, f64::max);
        Self {
            members,
            radius,
            exact,
            charge: leaves.charge.clone(),
            spheres,
            moments: all_moments,
        }
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.members[..])
            + size_of_val(&self.exact[..])
            + size_of_val(&self.charge[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.moments[..])
    }
}
