//! The expanded balls of the atoms, and the caps that they cut off each other.
//!
//! Exact coincidences (four contacts of one probe position, tangent balls, the same atom twice)
//! have no generic combinatorics. They are resolved by growing each radius by its own tiny amount:
//! a hash of the atom's index times an amplitude of 1e-8 Å, far below the accuracy of any radius.
//! Everything after this is generic.

use super::cells::CellList;
use super::circle::Cap;
use crate::{BodyError, Result};
use protomer_kernel::Vec3;

/// Largest coordinate that is accepted, Å.
const MAX_COORDINATE_ANGSTROM: f64 = 1e10;
/// Largest atomic and probe radius that is accepted, Å.
const MAX_RADIUS_ANGSTROM: f64 = 1e3;
/// Expanded balls smaller than this are points and expose nothing, Å.
const LEAST_EXPANDED_RADIUS_ANGSTROM: f64 = 1e-4;
/// Largest number of candidate pairs that is accepted: more take minutes, and only atoms piled on
/// each other have them.
const MAX_CANDIDATE_PAIRS: u64 = 500_000_000;

/// Balls of radius r + p (+ a perturbation) about the atoms.
#[derive(Debug, Clone)]
pub(crate) struct Balls {
    pub(crate) centres: Vec<Vec3>,
    pub(crate) radii: Vec<f64>,
    cells: CellList,
}

impl Balls {
    /// Checks the input and sorts the atoms into cells. Of several atoms at exactly the same place
    /// only the largest enters the cells, so that a pile of duplicates costs nothing.
    pub(crate) fn new(centres: &[Vec3], radii: &[f64], probe: f64) -> Result<Self> {
        check(centres, radii, probe)?;
        let radii: Vec<f64> = radii.iter().map(|radius| radius + probe).collect();
        let members = largest_at_each_place(centres, &radii);
        let mut largest = 0.0_f64;
        for &atom in &members {
            largest = largest.max(radii[atom as usize]);
        }
        if members.is_empty() {
            let cause = "no atom with a radius above zero";
            return Err(invalid(cause, "give atoms radii, or a probe"));
        }
        // Two balls touch at most at twice the largest
        // radius: neighbouring cells hold all partners.
        let cell_edge = 2.0 * largest * (1.0 + 1e-6);
        let cells = CellList::new(centres, members.into_iter(), cell_edge);
        if cells.candidate_pairs() > MAX_CANDIDATE_PAIRS {
            let remedy = "check the coordinates for atoms piled on each other and the radii and \
                          probe for their unit (Å)";
            return Err(invalid("too many atoms overlap each other", remedy));
        }
        Ok(Self {
            centres: centres.to_vec(),
            radii,
            cells,
        })
    }

    /// The same balls, each radius grown by a hash of the atom's index times `amplitude`, Å.
    pub(crate) fn perturbed(&self, amplitude: f64) -> Self {
        // The salt gives each amplitude its own order of growths.
        let salt = amplitude.to_bits();
        let mut perturbed = self.clone();
        for (index, radius) in (0..).zip(&mut perturbed.radii) {
            *radius += amplitude * hashed_fraction(index ^ salt);
        }
        perturbed
    }

    /// Atoms that take part, neighbours in space next to each other.
    pub(crate) fn members(&self) -> &[u32] {
        self.cells.members()
    }

    /// The caps that the other balls cut off ball `atom`, largest first; `None` if another ball
    /// holds it whole.
    pub(crate) fn caps(&self, atom: u32, caps: &mut Vec<Cap>) -> Option<()> {
        caps.clear();
        let (centre, radius) = (self.centres[atom as usize], self.radii[atom as usize]);
        let mut swallowed = false;
        self.cells.for_each_near(&centre, |other| {
            if other == atom {
                return;
            }
            let other_radius = self.radii[other as usize];
            let offset = self.centres[other as usize] - centre;
            let square = offset.norm_squared();
            let reach = radius + other_radius;
            if square >= reach * reach {
                return;
            }
            let distance = square.sqrt();
            let excess = other_radius - radius;
            // One ball inside the other: they have no circle.
            // The smaller is swallowed, the larger unharmed.
            if distance <= excess.abs() {
                swallowed |= excess > 0.0;
                return;
            }
            // Distance of the plane of intersection from the centre, over R_i:
            // h = (d² + R_i² - R_j²) / (2 d).
            let height = (square - excess * reach) / (2.0 * distance * radius);
            caps.push(Cap {
                axis: offset / distance,
                // A plane at the pole would have a circle of radius 0.
                height: height.clamp(-1.0 + 1e-15, 1.0 - 1e-15),
                owner: other,
            });
        });
        if swallowed {
            return None;
        }
        // The largest cap first clips most circles away with the
        // first comparison; the owner makes the order complete.
        caps.sort_unstable_by(|a, b| a.height.total_cmp(&b.height).then(a.owner.cmp(&b.owner)));
        Some(())
    }
}

/// Atoms that have the largest ball of those at exactly the same place; balls that are no more than
/// points are left out.
fn largest_at_each_place(centres: &[Vec3], radii: &[f64]) -> Vec<u32> {
    let place = |atom: u32| {
        let centre = &centres[atom as usize];
        // Adding zero turns -0 into 0, which is the same place.
        [centre.x, centre.y, centre.z].map(|x| (x + 0.0).to_bits())
    };
    let mut order: Vec<u32> = (0..centres.len() as u32).collect();
    order.retain(|atom| radii[*atom as usize] >= LEAST_EXPANDED_RADIUS_ANGSTROM);
    order.sort_unstable_by(|&i, &j| {
        let larger_first = radii[j as usize].total_cmp(&radii[i as usize]);
        place(i).cmp(&place(j)).then(larger_first).then(i.cmp(&j))
    });
    order.dedup_by_key(|atom| place(*atom));
    order
}

fn check(centres: &[Vec3], radii: &[f64], probe: f64) -> Result<()> {
    if centres.is_empty() {
        return Err(invalid("no atoms", "select at least one atom"));
    }
    if centres.len() != radii.len() {
        let cause = format!("{} positions but {} radii", centres.len(), radii.len());
        return Err(invalid(cause, "give one radius per atom"));
    }
    if u32::try_from(centres.len()).is_err() {
        return Err(invalid("more than 4294967295 atoms", "split the structure"));
    }
    let acceptable = 0.0..=MAX_RADIUS_ANGSTROM;
    if !acceptable.contains(&probe) {
        let cause = format!("probe radius {probe} Å");
        return Err(invalid(cause, "use 0 to 1000 Å; water is 1.4 Å"));
    }
    for (index, (centre, &radius)) in centres.iter().zip(radii).enumerate() {
        if !centre.iter().all(|x| x.abs() <= MAX_COORDINATE_ANGSTROM) {
            let [x, y, z] = (*centre).into();
            let cause = format!("atom {index} stands at ({x}, {y}, {z}) Å");
            let remedy = "coordinates must be finite and below 1e10 Å";
            return Err(invalid(cause, remedy));
        }
        if !acceptable.contains(&radius) {
            let cause = format!("atom {index} has radius {radius} Å");
            return Err(invalid(cause, "radii must lie within 0 to 1000 Å"));
        }
    }
    Ok(())
}

pub(crate) fn invalid(cause: impl Into<String>, remedy: impl Into<String>) -> BodyError {
    BodyError::Invalid {
        cause: cause.into(),
        remedy: remedy.into(),
    }
}

/// A fixed pseudo-random number in [0, 1) for each index (the finaliser of SplitMix64).
pub(crate) fn hashed_fraction(index: u64) -> f64 {
    let mut z = index.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
