//! The step at the cut-off: Σ Z_i q_j p(t_ij) θ(-t_ij) with t = r² - r_cut², for one target leaf
//! and all source leaves.
//!
//! Source leaves wholly inside enter by their moments, in double precision; of the straddling ones,
//! charges that are inside for the whole target leaf enter by the leaf's moments; what is left is
//! compared pair by pair. With c the centre of the target leaf and δ_i its members' offsets, s the
//! centre of a source leaf and ε_j its members' offsets, D = s - c and d_j = ε_j + D,
//!
//! ```text
//! t_ij = t_j + η_ij,   t_j = (|D|² - r_cut²) + |ε_j|² + 2 ε_j·D,   η_ij = |δ_i|² - 2 δ_i·d_j
//! ```
//!
//! D and the bracket are found in double precision, the rest in single: all its parts are at most
//! as large as a leaf's diameter times the cut-off, however large the bodies are.

/// Calls the first function where the processor's vectors are WIDE, the second otherwise.
macro_rules! select {
    ($wide:ident, $vector:path, $any:path, ($($argument:expr),*)) => {{
        #[cfg(target_arch = "x86_64")]
        let result = if $wide {
            // SAFETY: WIDE says that the processor has the features.
            unsafe { $vector($($argument),*) }
        } else {
            $any($($argument),*)
        };
        #[cfg(not(target_arch = "x86_64"))]
        let result = $any($($argument),*);
        result
    }};
}

mod classify;
mod collect;
mod compare;
mod contraction;
mod lists;
mod sources;

pub(super) use lists::Lists;
pub(super) use sources::{Sources, Target, moments};

use super::near::NearKernel;
use super::split::Split;
use classify::classify;
use collect::collect;
use compare::compare;
use contraction::Contraction;

/// Entries of a list, and straddling leaves, between two transfers of a sum to double precision.
const CHUNK: usize = 16;
/// Margin of distances in the classification of leaves, Å.
const MARGIN: f64 = 1e-3;
/// Unit roundoff of single precision.
const UNIT: f64 = 5.97e-8;

/// Leaves are no larger than this, Å.
pub(super) const LARGEST_RADIUS: f64 = 5.0;

/// A sum with its bound, kT, and the sum of the squares of the bounds of its independent parts,
/// kT².
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounded {
    pub value: f64,
    pub error: f64,
    pub square: f64,
}

impl Bounded {
    /// A sum whose errors may all point the same way.
    #[inline(always)]
    pub fn of_one_part(value: f64, error: f64) -> Self {
        Self {
            value,
            error,
            square: error * error,
        }
    }

    #[inline(always)]
    pub fn add(&mut self, other: Self) {
        self.value += other.value;
        self.error += other.error;
        self.square += other.square;
    }
}

/// The step's and the near pairs' contributions of one target leaf, kT.
#[inline(always)]
pub(super) fn sum_target<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    near: &NearKernel,
    lists: &mut Lists,
) -> Bounded {
    let finite = split.cutoff.is_finite();
    let square = if finite {
        split.cutoff * split.cutoff
    } else {
        0.0
    };
    let contraction = Contraction::new(target, split, square);
    let inside = classify::<WIDE>(sources, target, split, &contraction.global, lists);
    let mut sum = Bounded {
        value: inside,
        ..Bounded::default()
    };
    if lists.straddling > 0 {
        let t_error = t_error(split, target.radius.max(sources.radius));
        sum.add(collect::<WIDE>(
            sources,
            target,
            split,
            square,
            t_error,
            &contraction,
            lists,
        ));
        sum.add(compare::<WIDE>(sources, target, split, t_error, lists));
    }
    if lists.near > 0 {
        let leaves = &lists.near_leaves[..lists.near];
        sum.add(select!(
            WIDE,
            NearKernel::sum_avx512,
            NearKernel::sum,
            (near, sources, target, leaves)
        ));
    }
    sum
}

/// Bound of the error of a single-precision t, Å²; below it its sign is not trusted. With the
/// largest part W = 2 radius (r_cut + 2 radius), which bounds |t_j| of listed charges, 2 |ε·D|, and
/// 2 |δ·d|, the roundings are those of D, ε, |ε|² (3 W), of the terms of t_j (3 W) and its last sum
/// (4 W: |D|² - r_cut² is at most 2 W), of d and δ (3 W), of the sum with |δ|² (1 W) and of the
/// three products (6 W).
fn t_error(split: &Split, radius: f64) -> f64 {
    20.0 * UNIT * 2.0 * radius * (split.cutoff + 2.0 * radius)
}
