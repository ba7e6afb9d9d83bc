//! Spheres among depletants, by free volume theory.

use super::{Coexistence, CriticalPoint, Phases, TriplePoint};
use anyhow::Result;
use protomer_hpmc::free_volume_theory::{Mixture, PHASES};
use protomer_hpmc::tangent;

/// Phases of hard spheres among penetrable depletants, for each size ratio and each reservoir.
///
/// # Errors
/// For a size ratio that is not positive, or a negative packing fraction.
///
/// ```
/// let found = protomer_convex::hard_bodies::phases::phases_of_mixtures(&[0.1], &[0.05])?;
/// assert_eq!(found.coexistences[0].phases, ["fluid", "solid"]);
/// assert!((found.coexistences[0].packing_fractions[0] - 0.4854011093).abs() < 1e-9);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn phases_of_mixtures(size_ratios: &[f64], reservoirs: &[f64]) -> Result<Phases> {
    let mut phases = Phases::none();
    for q in size_ratios.iter().copied() {
        for reservoir in reservoirs.iter().copied() {
            let mixture = Mixture::new(q, reservoir)?;
            let stable = mixture.coexistences();
            let named = |found: &tangent::Coexistence, names: [&str; 2]| Coexistence {
                size_ratio: Some(q),
                reservoir_packing_fraction: Some(reservoir),
                phases: names.map(str::to_owned),
                packing_fractions: found.densities,
                uncertainty: None,
                pressure: found.pressure + mixture.reservoir_pressure(),
                osmotic_pressure: Some(found.pressure),
                chemical_potential: found.chemical_potential,
                free_volume_fractions: Some(found.densities.map(|eta| mixture.free_volume(eta))),
            };
            for found in &stable {
                let names = match (found.branches, stable.len()) {
                    ([0, 0], _) => ["gas", "liquid"],
                    ([0, _], 2..) => ["liquid", PHASES[1]],
                    _ => PHASES,
                };
                phases.coexistences.push(named(found, names));
            }
            if stable.len() == 1
                && let Some(found) = mixture.gas_and_liquid()
            {
                phases.metastable.push(named(&found, ["gas", "liquid"]));
            }
        }
        if let Some(critical) = Mixture::critical_point(q)? {
            phases.critical_points.push(CriticalPoint {
                size_ratio: q,
                packing_fraction: critical.packing_fraction,
                reservoir_packing_fraction: critical.reservoir,
                is_stable: critical.is_stable,
            });
        }
        if let Some(triple) = Mixture::triple_point(q)? {
            phases.triple_points.push(TriplePoint {
                size_ratio: q,
                reservoir_packing_fraction: triple.reservoir,
                packing_fractions: triple.packing_fractions,
            });
        }
    }
    phases.has_coexistence = !phases.coexistences.is_empty();
    Ok(phases)
}
