//! Hard-body overlap, cheapest test first.
//!
//! 1. bounding spheres about the origins;
//! 2. a lower bound on the gap from an earlier test, less the largest possible motion of the
//!    surfaces since;
//! 3. the meshes, nearest candidates first; the result is remembered for step 2.

use crate::sparse_rows::SparseRows;
use crate::system::{Pair, System, Trial};
use protomer_kernel::overlap::{CarriedBound, overlaps, separation_bound};

/// Gaps are measured up to this distance, Å: a pair farther apart is safe for many moves anyway.
const LOOK_AHEAD_ANGSTROM: f64 = 2.0;

/// Gap below which a bound is useless, Å: such a pair is only tested for overlap, which is cheaper.
const TIGHT_ANGSTROM: f64 = 0.4;

/// Motion of the surfaces after which the gap of such a pair is measured again, Å.
const STALE_ANGSTROM: f64 = 2.0;

/// Rounding error of a bound, Å, subtracted before use.
const ROUNDING_ANGSTROM: f64 = 1e-6;

/// Finds overlaps, and remembers distances between surfaces. The memory saves time but never
/// changes a result.
#[derive(Debug, Clone)]
pub struct HardBodies {
    /// Row: the first body of a pair; column: the second.
    gaps: SparseRows<Gap>,
    suspects: Vec<(f64, usize)>,
}

/// A lower bound on the gap between two surfaces, Å, and the state in which it held.
#[derive(Debug, Clone, Copy)]
struct Gap {
    bound_angstrom: f64,
    carried: CarriedBound,
}

impl HardBodies {
    /// Starts with an empty memory.
    pub fn new(bodies: usize) -> Self {
        Self {
            gaps: SparseRows::new(bodies),
            suspects: Vec::new(),
        }
    }

    /// Whether the moved body would overlap one of these partners.
    pub fn blocks(&mut self, trial: &Trial<'_>, partners: &[usize]) -> bool {
        let mut suspects = std::mem::take(&mut self.suspects);
        suspects.clear();
        for &partner in partners {
            let pair = trial.pair(partner);
            if within_bounding_spheres(&pair) {
                // Asked only for pairs whose spheres meet: the look-up costs more than the test.
                let remembered_gap = self.known_gap(&pair);
                if remembered_gap.now_angstrom() <= 0.0 {
                    // Still apart by an earlier bound: proven, no mesh is touched.
                    suspects.push((remembered_gap.now_angstrom(), partner));
                }
            }
        }
        // The least certain first: an overlap ends the search.
        // Ties by index, for the same answer each time.
        suspects.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let blocked = suspects
            .iter()
            .any(|(_, partner)| self.meshes_overlap(&trial.pair(*partner)));
        // Given back, so the next trial needs no allocation.
        self.suspects = suspects;
        blocked
    }

    /// Whether the two bodies of this pair overlap.
    pub fn overlap(&mut self, pair: &Pair<'_>) -> bool {
        within_bounding_spheres(pair)
            && self.known_gap(pair).now_angstrom() <= 0.0
            && self.meshes_overlap(pair)
    }

    /// The remembered bound of the pair, and the largest possible motion of its surfaces since.
    fn known_gap(&self, pair: &Pair<'_>) -> KnownGap {
        let Some(gap) = self.gaps.get(pair.first, pair.second) else {
            return KnownGap::NOTHING;
        };
        let (first, second) = pair.types();
        let radii = [first.hard_radius_angstrom(), second.hard_radius_angstrom()];
        let (first, second) = (&pair.first_pose, &pair.second_pose);
        let remaining = gap
            .carried
            .remaining_angstrom(first, second, &pair.displacement, radii);
        KnownGap {
            bound_angstrom: gap.bound_angstrom,
            moved_angstrom: gap.bound_angstrom - remaining,
        }
    }

    fn meshes_overlap(&mut self, pair: &Pair<'_>) -> bool {
        let (first, second) = pair.types();
        let relative = pair.relative();
        let remembered_gap = self.known_gap(pair);
        // A tight pair would use up its bound in one step; the plain decision is cheaper.
        if remembered_gap.bound_angstrom < TIGHT_ANGSTROM
            && remembered_gap.moved_angstrom < STALE_ANGSTROM
        {
            return overlaps(&first.shape, &second.shape, &relative);
        }
        match separation_bound(&first.shape, &second.shape, &relative, LOOK_AHEAD_ANGSTROM) {
            // Nothing is kept of an overlap: the trial is rejected and the old bound still holds.
            None => true,
            Some(bound_angstrom) => {
                let (first, second) = (&pair.first_pose, &pair.second_pose);
                let carried = CarriedBound::new(bound_angstrom, first, second, &pair.displacement);
                let gap = Gap {
                    bound_angstrom,
                    carried,
                };
                self.gaps.set(pair.first, pair.second, gap);
                false
            }
        }
    }
}

/// A bound on a gap from an earlier test.
#[derive(Debug, Clone, Copy)]
struct KnownGap {
    bound_angstrom: f64,
    moved_angstrom: f64,
}

impl KnownGap {
    const NOTHING: Self = Self {
        bound_angstrom: 0.0,
        moved_angstrom: f64::INFINITY,
    };

    /// The bound that is still valid, Å.
    fn now_angstrom(&self) -> f64 {
        self.bound_angstrom - self.moved_angstrom - ROUNDING_ANGSTROM
    }
}

/// Every pair of bodies that overlaps, the smaller index first, ascending; without using the
/// memory.
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, System, hard::overlapping_pairs};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// let place = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
/// let row = [(0, place(0.0)), (0, place(11.0)), (0, place(20.0))];
/// // Cubes with edges of 10 Å
/// let system = System::new(vec![cube], &row, Boundary::Open)?;
/// assert_eq!(overlapping_pairs(&system), [(1, 2)]);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
pub fn overlapping_pairs(system: &System) -> Vec<(usize, usize)> {
    let pairs = (0..system.len())
        .flat_map(|first| (first + 1..system.len()).map(move |second| (first, second)));
    pairs
        .filter(|&(first, second)| pair_overlaps(&system.pair(first, second)))
        .collect()
}

fn pair_overlaps(pair: &Pair<'_>) -> bool {
    let (first, second) = pair.types();
    within_bounding_spheres(pair) && overlaps(&first.shape, &second.shape, &pair.relative())
}

fn within_bounding_spheres(pair: &Pair<'_>) -> bool {
    let (first, second) = pair.types();
    let reach = first.hard_radius_angstrom() + second.hard_radius_angstrom();
    pair.displacement.norm_squared() < reach * reach
}
