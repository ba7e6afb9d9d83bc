//! Energies as intervals, at a fraction of the direct sum's cost.
//!
//! ```text
//! energy = Σ_a Z_a [ uncut potential of b at a  -  what lies beyond the cut-off ]
//!                    field: octree of             tail: rays, polynomials for
//!                    polynomials                  what is surely beyond, charges
//!                                                 near the cut-off one by one
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `field` | the smooth part: the uncut screened potential around a body, in cells with error bounds |
//! | `tail` | the rough part: charges beyond the cut-off, sorted once along rays |
//! | `ray_sum` | the inner loop at the cut-off, in single precision, with its rounding bound |
//! | `polynomial` | Taylor polynomials of exp(-κr)/r, their remainder, Chebyshev economisation |
//! | `pair` | the energy of two bodies as an interval |
//! | `model` | decisions by intervals, the direct sum where they stay open |
//!
//! Why so. The cut-off is sharp for every pair of charges, so the energy of two bodies some 45 Å apart jumps by 0.005 to
//! 0.02 kT when one moves by 0.01 to 0.1 Å: thousands of charge pairs cross the cut-off, each worth 1e-4 kT, with either
//! sign. No smooth interpolant of the cut potential can follow that, and bounds by absolute values of the pairs in doubt are
//! tens of kT wide. So the potential is split: without cut-off it is smooth (polynomials, with bounds that see the
//! cancellation between charges, as the *dropped coefficients of their sum* are added up, not those of each charge), and
//! the charges in doubt are compared with the cut-off one by one. What counts is how few they are. For clusters of 16
//! charges on both sides the pairs in doubt fill a shell 10 Å thick, for points against clusters 5 Å, for points against an
//! order along the nearest of 600 rays about 2 Å.
//!
//! Every interval contains the direct sum with its rounding: Taylor remainders, dropped coefficients, single-precision
//! rounding and a charge within rounding of the cut-off are all in its width. What stands behind that: the remainders are
//! derived where they are computed; the pads for rounding are generous estimates, not derived line by line. Tests hold
//! intervals against direct sums on random poses and at the cut-off, and decisions against the direct sum's.

mod field;
mod model;
mod pair;
mod polynomial;
mod ray_sum;
mod tail;

pub use model::{CertifiedSum, Counts};
pub use pair::{Accuracy, ChargeTable, EnergyInterval, pair_energy_interval};

use protomer_kernel::Vec3;

/// Rays along an edge of each face of the cube of directions, where the caller does not choose.
pub const RAYS_PER_EDGE: usize = 10;

/// Point charges as arrays, Å and e.
#[derive(Debug, Clone, Default)]
struct Charges {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    charge: Vec<f64>,
}

impl Charges {
    fn new(charges: impl Iterator<Item = (Vec3, f64)>) -> Self {
        let mut arrays = Self::default();
        for (place, charge) in charges {
            arrays.x.push(place.x);
            arrays.y.push(place.y);
            arrays.z.push(place.z);
            arrays.charge.push(charge);
        }
        arrays
    }

    fn len(&self) -> usize {
        self.charge.len()
    }

    /// Radius of the sphere about the origin that holds every charge, Å.
    fn radius(&self) -> f64 {
        let square = |i: usize| self.x[i].powi(2) + self.y[i].powi(2) + self.z[i].powi(2);
        (0..self.len()).map(square).fold(0.0, f64::max).sqrt()
    }
}
