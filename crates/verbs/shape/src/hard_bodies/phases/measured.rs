//! Phases of bodies by what simulations measured of them: equations of state, free energies of
//! crystals, free volumes of depletants.

use super::{Coexistence, Phases, Uncertainty};
use crate::hard_bodies::free_energy::FreeEnergyResult;
use crate::hard_bodies::start::FLUID;
use crate::hard_bodies::sweep::EquationOfState;
use anyhow::{Context, Result, bail};
use protomer_hpmc::measured_phase::{Anchor, Estimated, MeasuredPhase, PhaseCurves, State};
use protomer_hpmc::reservoir::ball_volume;
use protomer_hpmc::tangent::{self, Branch, even_samples};
use protomer_kernel::jet::Jet;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_results::{Record, ResultKind, keys};
use std::path::{Path, PathBuf};

/// Samples of a branch.
const SAMPLES: usize = 20_000;
/// Number of draws of all measured values within their errors.
const DRAWS: usize = 200;
/// Number of samples of a branch in one draw.
const SAMPLES_OF_A_DRAW: usize = 2000;
/// Seed of the draws.
const SEED: u64 = 1;
/// Bodies whose volumes differ by less than this part are the same.
const SAME_VOLUME: f64 = 1e-9;

/// Directories in which phases were measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PhaseDirectories {
    /// The sweep of a fluid over packing fractions.
    pub fluid: Option<PathBuf>,
    /// Sweep and free energy of each crystal.
    pub crystals: Vec<(PathBuf, PathBuf)>,
}

/// Phases that coexist by free volume theory with measured free energies and free volumes, for each
/// packing fraction of the depletants in the reservoir. Errors are the scatter over 200 draws of all
/// measured values.
///
/// # Errors
/// Names the directory that holds something else or lacks what is needed, and says how to get it.
pub fn phases_of_measurements(from: &PhaseDirectories, reservoirs: &[f64]) -> Result<Phases> {
    // At an empty reservoir no free volume is needed.
    let needs_free_volumes = reservoirs.iter().any(|reservoir| *reservoir != 0.0);
    let mut branches = Vec::new();
    if let Some(sweep) = &from.fluid {
        branches.push(MeasuredBranch::of_fluid(sweep)?);
    }
    for (sweep, free_energy) in &from.crystals {
        branches.push(MeasuredBranch::of_crystal(sweep, free_energy)?);
    }
    let Some(first) = branches.first() else {
        bail!("there are no phases; give the sweep of a fluid or of a crystal");
    };
    // All beside the first: two pairs that agree with it agree with each other.
    for branch in &branches {
        branch.check_beside(first, needs_free_volumes)?;
    }
    let depletant_radius = first.depletant_radius().filter(|_| needs_free_volumes);
    let mixture = MeasuredMixture::new(&branches, &first.equation, depletant_radius)?;
    let mut phases = Phases::none();
    for reservoir in reservoirs {
        let coexistences = mixture.coexistences(*reservoir)?;
        if coexistences.is_empty() {
            phases.reservoirs_without.push(*reservoir);
        }
        phases.coexistences.extend(coexistences);
    }
    phases.has_coexistence = !phases.coexistences.is_empty();
    Ok(phases)
}

/// One phase, and the sweep in which it was measured.
struct MeasuredBranch {
    sweep: PathBuf,
    equation: EquationOfState,
    phase: MeasuredPhase,
}

impl MeasuredBranch {
    fn of_fluid(sweep: &Path) -> Result<Self> {
        let equation = read_sweep(sweep)?;
        if equation.settings.run.start != FLUID {
            bail!(
                "{} is a sweep of the crystal '{}'; give it as a crystal, with its free energy",
                sweep.display(),
                equation.settings.run.start
            );
        }
        let Some(b2_over_volume) = equation.b2_over_volume else {
            bail!(
                "{} does not state the second virial coefficient: it was made by an earlier version \
                 or with depletants; run the same `hpmc sweep` again, without --force, to add it",
                sweep.display()
            );
        };
        Self::new(sweep, equation, Anchor::IdealGas { b2_over_volume })
    }

    fn of_crystal(sweep: &Path, free_energy: &Path) -> Result<Self> {
        let equation = read_sweep(sweep)?;
        let result = read_free_energy(free_energy)?;
        let run = &equation.settings.run;
        if run.shape.join(", ") != result.shape || run.start != result.crystal {
            bail!(
                "{} is of '{}' in '{}', and {} of '{}' in '{}'; give the free energy of the same \
                 crystal",
                sweep.display(),
                run.shape.join(", "),
                run.start,
                free_energy.display(),
                result.shape,
                result.crystal
            );
        }
        check_volume(
            free_energy,
            // The volume of a body, from the density: the record does not state it.
            result.packing_fraction / result.number_density,
            sweep,
            equation.body_volume,
        )?;
        // Outside the measured range the integration would begin at an extrapolated point.
        let range = packing_fractions(&equation);
        if range.is_none_or(|[low, high]| !(low..=high).contains(&result.packing_fraction)) {
            bail!(
                "the free energy in {} is at a packing fraction of {}, outside of the sweep in {}; \
                 add it to the sweep",
                free_energy.display(),
                result.packing_fraction,
                sweep.display()
            );
        }
        let anchor = Anchor::Computed {
            packing_fraction: result.packing_fraction,
            excess_free_energy_kt: Estimated {
                value: result.excess_free_energy_per_body_kt,
                standard_error: result.excess_free_energy_per_body_kt_error,
            },
        };
        Self::new(sweep, equation, anchor)
    }

    fn new(sweep: &Path, equation: EquationOfState, anchor: Anchor) -> Result<Self> {
        let phase = MeasuredPhase {
            states: states(&equation).with_context(|| sweep.display().to_string())?,
            anchor,
        };
        Ok(Self {
            sweep: sweep.to_owned(),
            equation,
            phase,
        })
    }

    /// The name of the directory, or of the crystal.
    fn name(&self) -> &str {
        let name = self.sweep.file_name().and_then(|name| name.to_str());
        name.unwrap_or(&self.equation.settings.run.start)
    }

    fn depletant_radius(&self) -> Option<f64> {
        let first = self.equation.settings.run.depletants.first()?;
        Some(first.radius)
    }

    /// Refuses phases of other bodies, or with other depletants.
    fn check_beside(&self, first: &Self, needs_free_volumes: bool) -> Result<()> {
        let (a, b) = (&first.equation.settings.run, &self.equation.settings.run);
        if a.shape != b.shape {
            bail!(
                "{} is of '{}' and {} of '{}'; give phases of one body",
                first.sweep.display(),
                a.shape.join(", "),
                self.sweep.display(),
                b.shape.join(", ")
            );
        }
        check_volume(
            &first.sweep,
            first.equation.body_volume,
            &self.sweep,
            self.equation.body_volume,
        )?;
        if !needs_free_volumes {
            return Ok(());
        }
        let free_volumes = &self.phase.states;
        if free_volumes
            .iter()
            .any(|state| state.free_volume_fraction.is_none())
        {
            bail!(
                "{} has no free volumes of depletants; sweep with --depletants RADIUS:0",
                self.sweep.display()
            );
        }
        if self.depletant_radius() != first.depletant_radius() {
            bail!(
                "the depletants of {} and {} have different radii; sweep all phases with one",
                first.sweep.display(),
                self.sweep.display()
            );
        }
        Ok(())
    }
}

/// Refuses bodies of one name that are not the same: another rounding, or a file that has changed.
fn check_volume(one: &Path, volume: f64, other: &Path, volume_there: f64) -> Result<()> {
    // Relative: shapes have any unit.
    if (volume / volume_there - 1.0).abs() < SAME_VOLUME {
        return Ok(());
    }
    bail!(
        "a body of {} has the volume {volume:.6}, one of {} {volume_there:.6}; give phases of one body with \
         one rounding",
        one.display(),
        other.display()
    )
}

fn read_sweep(directory: &Path) -> Result<EquationOfState> {
    if !directory.is_dir() {
        bail!(
            "there is no directory {}; give that of an `hpmc sweep`",
            directory.display()
        );
    }
    ResultKind::HardBodySweep.expect_in(directory)?;
    let equation: Option<EquationOfState> =
        keys::read_json_if_present(&directory.join("equation.json"))?;
    let Some(equation) = equation else {
        bail!(
            "{} holds no finished sweep; run or continue `hpmc sweep` there",
            directory.display()
        );
    };
    let run = &equation.settings.run;
    // The pressure in the sweep must be that of the bodies alone.
    if run.gravity.is_some() || run.depletants.iter().any(|kind| kind.fugacity != 0.0) {
        bail!(
            "{} is a sweep under gravity or among depletants; give one of the bodies alone \
             (--depletants RADIUS:0 measures free volumes)",
            directory.display()
        );
    }
    if equation.settings.packing_fractions.is_empty() {
        bail!(
            "{} is a sweep over pressures; give one over packing fractions",
            directory.display()
        );
    }
    Ok(equation)
}

fn read_free_energy(directory: &Path) -> Result<FreeEnergyResult> {
    ResultKind::FreeEnergy.expect_in(directory)?;
    match Record::read(directory)? {
        Some(record) if record.is_done() => Ok(record.read_details(directory)?),
        _ => bail!(
            "{} holds no finished free energy; run or continue `free-energy` there",
            directory.display()
        ),
    }
}

fn packing_fractions(equation: &EquationOfState) -> Option<[f64; 2]> {
    let (first, last) = (equation.points.first()?, equation.points.last()?);
    Some([first.packing_fraction, last.packing_fraction])
}

/// States measured at each packing fraction; all values must have errors.
fn states(equation: &EquationOfState) -> Result<Vec<State>> {
    let mut states = Vec::new();
    for point in &equation.points {
        // An error of zero means one sample; the fit would take it for certain.
        let estimated = |value: f64, error: Option<f64>| match error {
            Some(standard_error) if standard_error > 0.0 => Ok(Estimated {
                value,
                standard_error,
            }),
            _ => bail!(
                "a value at the packing fraction {} has no error; ask for more sweeps",
                point.packing_fraction
            ),
        };
        states.push(State {
            packing_fraction: point.packing_fraction,
            compressibility_factor: estimated(
                point.compressibility_factor,
                point.compressibility_factor_error,
            )?,
            free_volume_fraction: match point.free_volume_fraction {
                // A volume of zero has no logarithm, and
                // means that no point of the sample was free.
                Some(0.0) => bail!(
                    "no point was free for the depletants at the packing fraction {}, and a curve goes through \
                     logarithms; sweep again with more --points, or without that density",
                    point.packing_fraction
                ),
                Some(value) => Some(estimated(value, point.free_volume_fraction_error)?),
                None => None,
            },
        });
    }
    Ok(states)
}

/// All phases of a body with its depletants, as they were measured and as they might have been.
struct MeasuredMixture<'a> {
    branches: &'a [MeasuredBranch],
    body_volume: f64,
    /// The volume of a body over that of a depletant; zero without depletants.
    depletant_volumes_per_body: f64,
    measured: Vec<PhaseCurves>,
    draws: Vec<Vec<PhaseCurves>>,
}

impl<'a> MeasuredMixture<'a> {
    fn new(
        branches: &'a [MeasuredBranch],
        equation: &EquationOfState,
        depletant_radius: Option<f64>,
    ) -> Result<Self> {
        let body_volume = equation.body_volume;
        let depletant_volumes_per_body = depletant_radius.map_or(0.0, |radius| {
            // Depletants in the volume of a body, per unit of their packing fraction.
            body_volume / ball_volume(equation.dimension, radius)
        });
        let mut measured = Vec::with_capacity(branches.len());
        for branch in branches {
            let curves = branch.phase.curves();
            measured.push(curves.with_context(|| branch.sweep.display().to_string())?);
        }
        let mut draws = Vec::with_capacity(DRAWS);
        // One stream for each draw: all reservoirs see the same
        // draws, so that curves over the reservoir are smooth.
        for draw in 0..DRAWS as u64 {
            let mut rng = CounterRng::for_purpose(SEED, 0, draw, Purpose::Bootstrap);
            let drawn = branches.iter().zip(&measured);
            let drawn = drawn.map(|(branch, curves)| branch.phase.drawn_curves(curves, &mut rng));
            draws.push(drawn.collect::<protomer_hpmc::Result<_>>()?);
        }
        Ok(Self {
            branches,
            body_volume,
            depletant_volumes_per_body,
            measured,
            draws,
        })
    }

    fn coexistences(&self, reservoir: f64) -> Result<Vec<Coexistence>> {
        if !(reservoir.is_finite() && reservoir >= 0.0) {
            bail!("a reservoir cannot have the packing fraction {reservoir}; give zero or more");
        }
        // Depletants in the volume of a body.
        // The reservoir's depletants are ideal: their density is their pressure.
        let density = reservoir * self.depletant_volumes_per_body;
        let tangents = self.tangents(&self.measured, density, SAMPLES);
        let draws = self.draws.iter();
        let draws: Vec<_> = draws
            .map(|drawn| self.tangents(drawn, density, SAMPLES_OF_A_DRAW))
            .collect();
        let named = |coexistence: &tangent::Coexistence| Coexistence {
            size_ratio: None,
            reservoir_packing_fraction: Some(reservoir),
            phases: coexistence
                .branches
                .map(|n| self.branches[n].name().to_owned()),
            packing_fractions: coexistence.densities,
            uncertainty: Some(uncertainty(coexistence, &draws)),
            pressure: coexistence.pressure,
            osmotic_pressure: Some(coexistence.pressure - density),
            chemical_potential: coexistence.chemical_potential,
            free_volume_fractions: free_volumes(&self.measured, coexistence),
        };
        Ok(tangents.iter().map(named).collect())
    }

    fn tangents(
        &self,
        curves: &[PhaseCurves],
        depletants_per_body_volume: f64,
        samples: usize,
    ) -> Vec<tangent::Coexistence> {
        let energy = |curve: &PhaseCurves, x: Jet| {
            // The semi-grand potential: the depletants are free to come and go.
            curve.grand_potential(x, self.body_volume, depletants_per_body_volume)
        };
        let energies: Vec<_> = curves
            .iter()
            .map(|curve| move |x: Jet| energy(curve, x))
            .collect();
        let mut branches: Vec<Branch<'_>> = Vec::new();
        for ((curve, energy), branch) in curves.iter().zip(&energies).zip(self.branches) {
            branches.push(Branch {
                name: branch.name(),
                free_energy: energy,
                samples: even_samples(curve.range[0], curve.range[1], samples),
            });
        }
        tangent::coexistences(&branches)
    }
}

fn free_volumes(curves: &[PhaseCurves], coexistence: &tangent::Coexistence) -> Option<[f64; 2]> {
    let fraction = |n: usize| {
        let free = curves[coexistence.branches[n]]
            .free_volume_fraction(Jet::constant(coexistence.densities[n]))?;
        Some(free.value)
    };
    Some([fraction(0)?, fraction(1)?])
}

/// Scatter of the nearest coexistence of the same phases over the draws.
fn uncertainty(
    coexistence: &tangent::Coexistence,
    draws: &[Vec<tangent::Coexistence>],
) -> Uncertainty {
    let distance = |other: &tangent::Coexistence| {
        let difference = |n: usize| (other.densities[n] - coexistence.densities[n]).abs();
        difference(0) + difference(1)
    };
    // A draw may have several coexistences of these phases, or none.
    let nearest = |draw: &Vec<tangent::Coexistence>| {
        let same = draw
            .iter()
            .filter(|other| other.branches == coexistence.branches);
        same.min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .copied()
    };
    let same: Vec<tangent::Coexistence> = draws.iter().filter_map(nearest).collect();
    let scatter = |value: &dyn Fn(&tangent::Coexistence) -> f64| {
        let count = same.len() as f64;
        let mean = same.iter().map(value).sum::<f64>() / count;
        let squares = same.iter().map(|draw| (value(draw) - mean).powi(2));
        // Of draws, not of means: the scatter itself is the error.
        (squares.sum::<f64>() / (count - 1.0)).sqrt()
    };
    Uncertainty {
        packing_fractions_error: [0, 1].map(|n| scatter(&|draw| draw.densities[n])),
        pressure_error: scatter(&|draw| draw.pressure),
        chemical_potential_error: scatter(&|draw| draw.chemical_potential),
        share_of_draws: same.len() as f64 / draws.len() as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard_bodies::phases::phases_of_mixtures;
    use crate::hard_bodies::settings::HardBodySettings;
    use crate::hard_bodies::sweep::HardBodySweepSettings;
    use protomer_hpmc::free_volume_theory::Mixture;
    use std::f64::consts::PI;

    const SIZE_RATIO: f64 = 0.4;

    /// A branch of spheres of radius 1/2 as if it had been measured, with errors of this part of the
    /// values.
    fn branch(
        name: &str,
        anchor: Anchor,
        states: impl Iterator<Item = (f64, f64)>,
        part: f64,
    ) -> MeasuredBranch {
        let mixture = Mixture::new(SIZE_RATIO, 0.1).unwrap();
        let estimated = |value: f64| Estimated {
            value,
            standard_error: part * value,
        };
        let states = states.map(|(packing_fraction, factor)| State {
            packing_fraction,
            compressibility_factor: estimated(factor),
            free_volume_fraction: Some(estimated(mixture.free_volume(packing_fraction))),
        });
        MeasuredBranch {
            sweep: PathBuf::from(name),
            equation: EquationOfState {
                settings: HardBodySweepSettings {
                    run: HardBodySettings::default(),
                    ..HardBodySweepSettings::default()
                },
                dimension: 3,
                body_volume: PI / 6.0,
                b2_over_volume: Some(4.0),
                points: Vec::new(),
            },
            phase: MeasuredPhase {
                states: states.collect(),
                anchor,
            },
        }
    }

    /// The fluid of Carnahan and Starling, and the cell model of the crystal.
    fn spheres(part: f64) -> [MeasuredBranch; 2] {
        let fluid = (1..=27).map(|n| {
            let x = 0.02 * f64::from(n);
            (x, (1.0 + x + x * x - x.powi(3)) / (1.0 - x).powi(3))
        });
        let dense = PI / (3.0 * 2.0_f64.sqrt());
        let crystal = (0..=14).map(|n| {
            let x = 0.5 + 0.01 * f64::from(n);
            (x, 3.0 / (1.0 - x / dense))
        });
        let packing_fraction = 0.545;
        let room = packing_fraction / (1.0 - packing_fraction / dense);
        let value = 2.1306 + 3.0 * room.ln() - packing_fraction.ln() + 1.0;
        let anchor = Anchor::Computed {
            packing_fraction,
            excess_free_energy_kt: Estimated {
                value,
                standard_error: part * value,
            },
        };
        let ideal = Anchor::IdealGas {
            b2_over_volume: 4.0,
        };
        [
            branch("runs/fluid", ideal, fluid, part),
            branch("runs/solid", anchor, crystal, part),
        ]
    }

    fn coexistence(branches: &[MeasuredBranch], reservoir: f64) -> Vec<Coexistence> {
        let radius = Some(0.5 * SIZE_RATIO);
        let mixture = MeasuredMixture::new(branches, &branches[0].equation, radius).unwrap();
        mixture.coexistences(reservoir).unwrap()
    }

    #[test]
    fn measured_spheres_have_the_phases_of_the_theory() {
        let branches = spheres(1e-8);
        for reservoir in [0.0, 0.3] {
            let found = &coexistence(&branches, reservoir)[0];
            let theory = phases_of_mixtures(&[SIZE_RATIO], &[reservoir]).unwrap();
            let expected = &theory.coexistences[0];
            assert_eq!(found.phases, expected.phases);
            for n in 0..2 {
                let difference = found.packing_fractions[n] - expected.packing_fractions[n];
                assert!(difference.abs() < 2e-4, "{reservoir}: {difference}");
            }
            assert!((found.pressure / expected.pressure - 1.0).abs() < 1e-3);
            let volumes = found.free_volume_fractions.unwrap()[0];
            assert!((volumes / expected.free_volume_fractions.unwrap()[0] - 1.0).abs() < 1e-2);
        }
    }

    /// Errors grow with those of what was measured, and cover what moving the anchor does.
    #[test]
    fn errors_follow_those_of_the_measured_values() {
        let [small, large] = [1e-4, 1e-3].map(|part| {
            let found = coexistence(&spheres(part), 0.1);
            found[0].uncertainty.unwrap()
        });
        assert_eq!((small.share_of_draws, large.share_of_draws), (1.0, 1.0));
        for n in 0..2 {
            let ratio = large.packing_fractions_error[n] / small.packing_fractions_error[n];
            assert!(ratio > 3.0 && ratio < 30.0, "{ratio}");
        }
        let mut moved = spheres(1e-3);
        let before = coexistence(&moved, 0.1)[0].pressure;
        let Anchor::Computed {
            excess_free_energy_kt: anchor,
            ..
        } = &mut moved[1].phase.anchor
        else {
            panic!()
        };
        anchor.value += anchor.standard_error;
        let shift = (coexistence(&moved, 0.1)[0].pressure - before).abs();
        assert!(large.pressure_error > 0.7 * shift && large.pressure_error < 5.0 * shift);
    }
}
