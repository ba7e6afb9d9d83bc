//! What another charge at a residue would change.
//!
//! A charge Δq added at a place of every copy of a kind of body changes the energy of a state by
//!
//! ```text
//! ΔU = Δq Σ_c φ_c + Δq² Σ_{c<d} v(r_cd)
//! ```
//!
//! with the potential φ_c of the other bodies at the place of copy c, and the places of pairs of
//! copies at r_cd. Averages over the states of the changed system follow from those of a run by
//! weighting its frames with exp(-ΔU).

use super::state::Contributions;
use crate::energy::SitePotential;
use crate::{McError, Result, System};
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;

/// Sites of an added charge, which is shared equally between these places of a kind of body.
#[derive(Debug, Clone, PartialEq)]
pub struct ChargeSites {
    /// The kind of body.
    pub kind: usize,
    /// Places in its frame, Å.
    pub places: Vec<Vec3>,
}

/// Response of the energy of a state to an added charge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    /// Σ φ over the copies, kT/e.
    pub potential_kt_per_e: f64,
    /// Σ v over the pairs of copies, kT/e².
    pub among_copies_kt_per_e2: f64,
}

/// An average over frames with weights exp(-ΔU).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reweighted {
    /// The average.
    pub mean: f64,
    /// (Σ w)²/Σ w²: how many frames of equal weight would be as good.
    pub effective_frames: f64,
}

impl Response {
    /// Change of the energy by a charge, kT.
    pub fn energy_change_kt(&self, charge_e: f64) -> f64 {
        charge_e * self.potential_kt_per_e + charge_e * charge_e * self.among_copies_kt_per_e2
    }
}

impl Contributions {
    /// Responses of a state to a charge at each of these sites.
    ///
    /// # Errors
    /// [`McError::BadSystem`] for a site without places or of a kind that there is not.
    pub fn responses(&self, system: &System, sites: &[ChargeSites]) -> Result<Vec<Response>> {
        for site in sites {
            if site.kind >= self.kinds.len() || site.places.is_empty() {
                return Err(McError::BadSystem(format!(
                    "a charge is to be added to kind {} at {} places; there are {} kinds, and one \
                     place at least is needed",
                    site.kind,
                    site.places.len(),
                    self.kinds.len()
                )));
            }
        }
        let mut responses = vec![Response::default(); sites.len()];
        for first in 0..system.len() {
            for second in first + 1..system.len() {
                let pair = system.pair(first, second);
                let kinds = pair.type_indices();
                for displacement in self.reach_of_charges.images(&pair) {
                    let relative = pair.relative_image(&displacement);
                    self.add_responses(kinds, &relative, sites, &mut responses);
                }
            }
        }
        Ok(responses)
    }

    fn add_responses(
        &self,
        (first, second): (usize, usize),
        relative: &RelativePose,
        sites: &[ChargeSites],
        responses: &mut [Response],
    ) {
        let inverse = relative.inverse();
        let in_first = self.kinds[second].charges.moved(relative);
        let in_second = self.kinds[first].charges.moved(&inverse);
        let mut potentials = Vec::new();
        for (site, response) in sites.iter().zip(responses) {
            let per_place = 1.0 / site.places.len() as f64;
            for (kind, charges) in [(first, &in_first), (second, &in_second)] {
                if kind != site.kind {
                    continue;
                }
                potentials.resize(charges.len(), 0.0);
                for place in &site.places {
                    self.potentials_at(place, charges, &mut potentials);
                    response.potential_kt_per_e += per_place * potentials.iter().sum::<f64>();
                }
            }
            if first == site.kind && second == site.kind {
                for place in &site.places {
                    let image = relative.transform_point(place);
                    for other in &site.places {
                        let square = (image - other).norm_squared();
                        response.among_copies_kt_per_e2 +=
                            per_place * per_place * self.potential.at_square(square);
                    }
                }
            }
        }
    }
}

/// The average of one value per frame with weights exp(-ΔU), ΔU in kT; NaN without frames.
///
/// ```
/// use protomer_mc::contributions::reweighted;
/// let even = reweighted([0.0, 1.0].into_iter().zip([0.5; 2]));
/// assert_eq!((even.mean, even.effective_frames), (0.5, 2.0));
/// let uneven = reweighted([0.0, 1.0].into_iter().zip([0.0, 1e3]));
/// assert_eq!((uneven.mean, uneven.effective_frames), (0.0, 1.0));
/// ```
pub fn reweighted(frames: impl Iterator<Item = (f64, f64)> + Clone) -> Reweighted {
    let changes = frames.clone().map(|(_, change_kt)| change_kt);
    let least = changes.fold(f64::INFINITY, f64::min);
    let (mut weights, mut squares, mut sum) = (0.0, 0.0, 0.0);
    for (value, change_kt) in frames {
        // Relative to the least change, so that no weight overflows.
        let weight = (least - change_kt).exp();
        weights += weight;
        squares += weight * weight;
        sum += weight * value;
    }
    Reweighted {
        mean: sum / weights,
        effective_frames: weights * weights / squares,
    }
}
