//! Spheres among depletants, by free volume theory.

use super::{Coexistence, CriticalPoint, Phases, TriplePoint};
use anyhow::{Result, bail};
use protomer_hpmc::free_volume_theory::{Mixture, PHASES};
use protomer_hpmc::tangent;
use protomer_kernel::Number;

/// Largest size ratio; beyond this limit and the next two the gas is thinner than any for which
/// tangents are sought.
const LARGEST_SIZE_RATIO: f64 = 10.0;
/// Smallest size ratio.
const SMALLEST_SIZE_RATIO: f64 = 1e-3;
/// Largest packing fraction of the depletants in the reservoir.
const DENSEST_RESERVOIR: f64 = 100.0;

/// Refuses numbers for which no tangent can be found.
fn check(size_ratios: &[f64], reservoirs: &[f64]) -> Result<()> {
    for (name, values, from, to) in [
        (
            "size-ratio",
            size_ratios,
            SMALLEST_SIZE_RATIO,
            LARGEST_SIZE_RATIO,
        ),
        ("reservoir", reservoirs, 0.0, DENSEST_RESERVOIR),
    ] {
        if let Some(value) = values.iter().find(|value| !(from..=to).contains(*value)) {
            bail!(
                "--{name} is {}; give a number from {from} to {to}",
                Number(*value)
            );
        }
    }
    Ok(())
}

/// Phases of hard spheres among penetrable depletants, for each size ratio and each reservoir.
///
/// # Errors
/// For a size ratio or a packing fraction out of range, and where the gas is so thin that no tangent is found.
///
/// ```
/// let found = protomer_shape_verbs::hard_bodies::phases::phases_of_mixtures(&[0.1], &[0.05])?;
/// assert_eq!(found.coexistences[0].phases, ["fluid", "solid"]);
/// assert!((found.coexistences[0].packing_fractions[0] - 0.4854011093).abs() < 1e-9);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn phases_of_mixtures(size_ratios: &[f64], reservoirs: &[f64]) -> Result<Phases> {
    check(size_ratios, reservoirs)?;
    let mut phases = Phases::none();
    for q in size_ratios.iter().copied() {
        for reservoir in reservoirs.iter().copied() {
            let mixture = Mixture::new(q, reservoir)?;
            let stable = mixture.coexistences();
            if stable.is_empty() {
                // Hard spheres freeze in every reservoir.
                bail!(
                    "--size-ratio {q}, --reservoir {reservoir}: the fluid that coexists with the solid is thinner \
                     than can be computed; give a smaller reservoir"
                );
            }
            let named = |coexistence: &tangent::Coexistence, names: [&str; 2]| Coexistence {
                size_ratio: Some(q),
                reservoir_packing_fraction: Some(reservoir),
                phases: names.map(str::to_owned),
                packing_fractions: coexistence.densities,
                uncertainty: None,
                pressure: coexistence.pressure + mixture.reservoir_pressure(),
                osmotic_pressure: Some(coexistence.pressure),
                chemical_potential: coexistence.chemical_potential,
                free_volume_fractions: Some(
                    coexistence.densities.map(|eta| mixture.free_volume(eta)),
                ),
            };
            for coexistence in &stable {
                // Branch 0 is the fluid: two densities on it are gas and liquid.
                let names = match (coexistence.branches, stable.len()) {
                    ([0, 0], _) => ["gas", "liquid"],
                    // With two coexistences the second is that of the denser fluid.
                    ([0, _], 2..) => ["liquid", PHASES[1]],
                    _ => PHASES,
                };
                phases.coexistences.push(named(coexistence, names));
            }
            // A single coexistence is fluid and solid; gas
            // and liquid may still be metastable below it.
            if stable.len() == 1
                && let Some(coexistence) = mixture.gas_and_liquid()
            {
                phases
                    .metastable
                    .push(named(&coexistence, ["gas", "liquid"]));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reservoirs_for_which_no_tangent_can_be_found_are_refused() {
        for (size_ratio, reservoir, words) in [
            (
                0.5,
                1e300,
                "--reservoir is 1e300; give a number from 0 to 100",
            ),
            (
                1e308,
                0.4,
                "--size-ratio is 1e308; give a number from 0.001 to 10",
            ),
            (0.5, f64::NAN, "--reservoir is NaN"),
            (0.1, 10.0, "thinner than can be computed"),
        ] {
            let error = phases_of_mixtures(&[size_ratio], &[reservoir]).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
