//! The free energy of a crystal of hard bodies (Frenkel and Ladd, J. Chem. Phys. 81, 3188 (1984)).
//!
//! Springs of the strength λ hold the bodies to the sites (see [`einstein`](crate::einstein)). For the
//! strongest, λ₁, bodies hardly ever meet, and the free energy is that of an Einstein crystal less
//! kT ln P, where P is the part of its states without overlaps. From there to none
//!
//! ```text
//! A/(N kT) = A_E/(N kT) - ln P / N - ∫₀^λ₁ f dλ,   f = <E>/(λ N)
//! ```
//!
//! f is about g/(2 (λ + c)) with g degrees of freedom per body and c = g/(2 f(0)), so the integral is taken
//! over ln(λ + c) by the Gauss-Kronrod rule of 21 points. The Gauss rule of ten of them says how
//! well that does. Sweeps go to the points whose errors count most.

use crate::body::HardBody;
use crate::crystal::Crystal;
use crate::depletants::Counting;
use crate::einstein::{EinsteinCrystal, EinsteinTerms, Springs};
use crate::symmetry::Symmetry;
use crate::system::{MoveCounts, Steps, System};
use crate::{Error, Result};
use protomer_kernel::Rotation;
use protomer_kernel::quadrature::{KRONROD_NODES, gauss_kronrod};
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};

/// Strengths of the springs at which a plan measures.
pub const STRENGTHS: usize = KRONROD_NODES;

/// Acceptance that steps are tuned to.
const ACCEPTANCE: f64 = 0.3;
/// Sweeps between two tunings.
const TUNE_EVERY: u64 = 10;
/// The strongest springs are those with which of so many states few have overlaps.
const LOOKS: u32 = 200;
/// Largest number of those states with overlaps.
const FEW: u32 = 10;
/// A crystal whose bodies meet however strong the springs are is at its closest.
const MOST_DOUBLINGS: u32 = 80;
/// States of the Einstein crystal in which overlaps are counted.
const STATES: u32 = 5000;
/// Sweeps without springs, before and while their extent is estimated.
const PILOT_SWEEPS: u64 = 1000;
/// Stream of the search for the strongest springs; points have the streams below these.
const SEARCH: u32 = 1000;
/// Stream of the states in which overlaps are counted.
const OVERLAPS: u32 = 1001;
/// Stream of the sweeps without springs.
const PILOT: u32 = 1002;

/// A strength of springs at which the extent is measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// λ, kT per squared length.
    pub strength: f64,
    /// Weight of f in the integral.
    pub weight: f64,
    /// Weight in the coarser rule.
    pub coarse_weight: f64,
}

/// Plan of a measurement, with the strengths of the springs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Strength λ₁ of the strongest springs, kT per squared length.
    pub strongest: f64,
    /// c, kT per squared length.
    pub shift: f64,
    /// κ, squared length.
    pub turning: f64,
    /// Number of states of the Einstein crystal that were drawn.
    pub states: u32,
    /// Number of these states without overlaps.
    pub free_states: u32,
    /// The strengths.
    pub points: Vec<Point>,
}

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub error: f64,
}

/// A free energy and its parts, in kT per body. The thermal wavelength is one in the unit of the
/// bodies, the integral over all orientations is one, and bodies cannot be told apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FreeEnergy {
    /// A/(N kT).
    pub total_kt: f64,
    /// Standard error of the free energy.
    #[serde(alias = "error_kt")]
    pub total_kt_error: f64,
    /// Term of the centre of mass.
    pub centre_of_mass_kt: f64,
    /// Term of the strongest springs.
    pub springs_kt: f64,
    /// Term of the orientations in the strongest field.
    pub orientations_kt: f64,
    /// Term -ln P / N of the overlaps with the strongest springs.
    pub overlaps_kt: f64,
    /// Standard error of the term of the overlaps.
    #[serde(alias = "overlaps_error_kt")]
    pub overlaps_kt_error: f64,
    /// The integral over the strength.
    pub integral_kt: f64,
    /// Standard error of the integral.
    #[serde(alias = "integral_error_kt")]
    pub integral_kt_error: f64,
    /// The difference between the rule of 21 points and that of ten.
    pub rules_difference_kt: f64,
    /// Standard error of the difference between the rules: a smaller difference is noise.
    #[serde(alias = "rules_difference_error_kt")]
    pub rules_difference_kt_error: f64,
}

/// A crystal whose free energy is wanted.
#[derive(Debug, Clone)]
pub struct Measurement<'a, const D: usize> {
    body: &'a HardBody<D>,
    crystal: &'a Crystal<D>,
    symmetry: Symmetry,
    seed: u64,
}

impl<'a, const D: usize> Measurement<'a, D> {
    /// A measurement of a crystal of these bodies.
    ///
    /// # Errors
    /// If the bodies overlap on their sites, the box is too small, or their orientation cannot be held.
    pub fn new(body: &'a HardBody<D>, crystal: &'a Crystal<D>, seed: u64) -> Result<Self> {
        crystal.system(body, &[])?;
        Ok(Self {
            body,
            crystal,
            symmetry: Symmetry::find(body)?,
            seed,
        })
    }

    /// The symmetry of the bodies.
    pub fn symmetry(&self) -> &Symmetry {
        &self.symmetry
    }

    /// Finds the strongest springs, counts overlaps with them, and chooses the strengths.
    ///
    /// # Errors
    /// If bodies meet however strong the springs are.
    pub fn plan(&self) -> Result<Plan> {
        // A turn by a small angle moves the farthest corner as far as a shift of the same square.
        let turning = self.body.outer_radius.powi(2);
        let inner = self.body.inner_radius.max(0.1 * self.body.outer_radius);
        // Strong enough to hold orientations, and to keep bodies within their inner radius.
        let mut strongest = (self.symmetry.least_strength_kt() / turning).max(inner.powi(-2));
        let mut doublings = 0;
        // Doubled until few of the states have overlaps.
        while LOOKS - self.free_states(strongest, turning, LOOKS, SEARCH)? > FEW {
            strongest *= 2.0;
            doublings += 1;
            if doublings > MOST_DOUBLINGS {
                let wanted = self.crystal.system(self.body, &[])?.packing_fraction();
                return Err(Error::Dense {
                    wanted,
                    largest: wanted,
                });
            }
        }
        let free_states = self.free_states(strongest, turning, STATES, OVERLAPS)?;
        // At λ = 0: the extent there fixes the shift of the integration variable.
        let mut pilot = self.start(PILOT, 0.0, turning)?;
        pilot.run(PILOT_SWEEPS, true);
        let mut extent = 0.0;
        for _ in 0..PILOT_SWEEPS {
            extent += pilot.run(1, false) / PILOT_SWEEPS as f64;
        }
        let bodies = self.crystal.positions.len() as f64;
        // Degrees of freedom, without the centre of mass; f(0) = g/(2 c).
        let freedom = D as f64 * (1.0 - 1.0 / bodies) + self.symmetry.degrees_of_freedom() as f64;
        let shift = 0.5 * freedom / extent;
        Ok(Plan {
            strongest,
            shift,
            turning,
            states: STATES,
            free_states,
            points: points(strongest, shift),
        })
    }

    /// Number of states of the Einstein crystal without overlaps, of so many drawn.
    fn free_states(&self, strength: f64, turning: f64, states: u32, stream: u32) -> Result<u32> {
        let einstein = EinsteinCrystal {
            crystal: self.crystal,
            symmetry: &self.symmetry,
            strength,
            turning,
        };
        let mut system = self.crystal.system(self.body, &[])?;
        let mut free = 0;
        for state in 0..states {
            let step = u64::from(state);
            let mut rng =
                CounterRng::for_purpose(self.seed, stream, step, Purpose::HardBodyInsertion);
            let (displacements, rotations) = einstein.sample(&mut rng);
            let places = self.crystal.positions.iter().zip(&displacements);
            let trial_positions = places.map(|(site, displacement)| {
                std::array::from_fn(|axis| site[axis] + displacement[axis])
            });
            // Drawn without regard to overlaps, which are what is counted.
            system.put_all(trial_positions.collect(), rotations);
            free += u32::from(!system.has_overlaps());
        }
        Ok(free)
    }

    /// Bodies on their sites, with springs of a strength; `stream` numbers their random numbers.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn start(&self, stream: u32, strength: f64, turning: f64) -> Result<Walker<D>> {
        let steps = Steps {
            translation: 0.1 * self.body.outer_radius,
            rotation: 0.1,
        };
        Ok(Walker {
            seed: self.seed,
            stream,
            system: self.crystal.system(self.body, &[])?,
            springs: Springs::new(self.crystal, &self.symmetry, turning).with_strength(strength),
            steps,
            sweeps: 0,
            counts: MoveCounts::default(),
        })
    }

    /// Resumes from a saved state. Call [`Walker::refresh`] before going on.
    ///
    /// # Errors
    /// If the state is not of these bodies.
    pub fn resume(
        &self,
        stream: u32,
        strength: f64,
        turning: f64,
        state: &WalkerState,
    ) -> Result<Walker<D>> {
        let mut walker = self.start(stream, strength, turning)?;
        let (positions, _) = state.positions.as_chunks::<D>();
        let (displacements, _) = state.displacements.as_chunks::<D>();
        let rotation = |[w, x, y, z]: &[f64; 4]| {
            // The numbers are those of a rotation that was normalised before it was saved.
            Rotation::new_unchecked(nalgebra::Quaternion::new(*w, *x, *y, *z))
        };
        let rotations: Vec<Rotation> = state.orientations_wxyz.iter().map(rotation).collect();
        let bodies = self.crystal.positions.len();
        for count in [positions.len(), displacements.len(), rotations.len()] {
            if count != bodies {
                return Err(Error::OutOfRange {
                    quantity: "the number of saved bodies",
                    value: count as f64,
                    requirement: "that of the crystal; start again with --force",
                });
            }
        }
        walker.springs.restore(displacements);
        walker.system.put_all(positions.to_vec(), rotations);
        walker.steps = state.steps;
        walker.sweeps = state.sweeps;
        walker.counts = state.counts;
        Ok(walker)
    }

    /// The free energy from the extents f at the points of a plan.
    pub fn free_energy(&self, plan: &Plan, extents: &[Estimate]) -> FreeEnergy {
        let einstein = EinsteinCrystal {
            crystal: self.crystal,
            symmetry: &self.symmetry,
            strength: plan.strongest,
            turning: plan.turning,
        };
        let EinsteinTerms {
            centre_of_mass_kt,
            springs_kt,
            orientations_kt,
        } = einstein.terms();
        let bodies = self.crystal.positions.len() as f64;
        let (states, free) = (f64::from(plan.states), f64::from(plan.free_states));
        let overlaps_kt = -(free / states).ln() / bodies;
        // Binomial: variance of ln P is 1/free - 1/states.
        let overlaps_kt_error = ((1.0 / free - 1.0 / states).max(0.0)).sqrt() / bodies;
        let (mut integral, mut variance) = (0.0, 0.0);
        let (mut difference, mut difference_variance) = (0.0, 0.0);
        for (point, extent) in plan.points.iter().zip(extents) {
            integral += point.weight * extent.mean;
            variance += (point.weight * extent.error).powi(2);
            // The difference of the two rules, point by point, so its error is known too.
            let apart = point.weight - point.coarse_weight;
            difference += apart * extent.mean;
            difference_variance += (apart * extent.error).powi(2);
        }
        FreeEnergy {
            total_kt: einstein.terms().total_kt() + overlaps_kt - integral,
            total_kt_error: variance.sqrt().hypot(overlaps_kt_error),
            centre_of_mass_kt,
            springs_kt,
            orientations_kt,
            overlaps_kt,
            overlaps_kt_error,
            integral_kt: integral,
            integral_kt_error: variance.sqrt(),
            rules_difference_kt: difference,
            rules_difference_kt_error: difference_variance.sqrt(),
        }
    }
}

/// The points of the rule in ln(λ + c).
fn points(strongest: f64, shift: f64) -> Vec<Point> {
    let [low, high] = [shift.ln(), (strongest + shift).ln()];
    let half = 0.5 * (high - low);
    let mut points = Vec::new();
    for node in gauss_kronrod() {
        // dλ = (λ + c) d ln(λ + c), with half the width of the interval.
        let shifted = (0.5 * (low + high) + half * node.place).exp();
        points.push(Point {
            strength: shifted - shift,
            weight: half * shifted * node.weight,
            coarse_weight: half * shifted * node.gauss_weight,
        });
    }
    points
}

/// Number of times that each point is to be measured next, `times` in all: first once each, then
/// where the variance of the integral falls most. `measured` tells how often each was measured, and
/// the error that it has.
pub fn share(plan: &Plan, measured: &[(u64, f64)], times: usize) -> Vec<usize> {
    let mut shares = vec![0; plan.points.len()];
    let mut variances = Vec::new();
    for (point, (count, error)) in plan.points.iter().zip(measured) {
        // Of one measurement.
        variances.push((point.weight * error).powi(2) * *count as f64);
    }
    for turn in 0..times {
        let gain = |number: usize| {
            let count = measured[number].0 as f64 + shares[number] as f64;
            // What one more measurement takes off the variance of the integral: v/n - v/(n + 1).
            variances[number] / (count * (count + 1.0))
        };
        // Once each first, then by what the next measurement gains.
        let next = match turn < shares.len() {
            true => turn,
            false => (0..shares.len())
                .max_by(|a, b| gain(*a).total_cmp(&gain(*b)))
                .unwrap_or(0),
        };
        shares[next] += 1;
    }
    shares
}

/// A state from which bodies on springs go on as if they had not stopped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WalkerState {
    /// Sweeps done.
    pub sweeps: u64,
    /// Coordinates of the centres, body by body.
    pub positions: Vec<f64>,
    /// Displacements from the sites, body by body.
    pub displacements: Vec<f64>,
    /// Orientations, scalar first.
    pub orientations_wxyz: Vec<[f64; 4]>,
    /// Largest steps.
    pub steps: Steps,
    /// Moves since the steps were tuned last.
    pub counts: MoveCounts,
}

/// Bodies on springs that move.
#[derive(Debug, Clone)]
pub struct Walker<const D: usize> {
    seed: u64,
    stream: u32,
    system: System<D>,
    springs: Springs<D>,
    steps: Steps,
    sweeps: u64,
    counts: MoveCounts,
}

impl<const D: usize> Walker<D> {
    /// Forgets everything but the state, and computes from it what the next moves need.
    pub fn refresh(&mut self) {
        self.springs.refresh(self.system.rotations());
        self.system.refresh();
    }

    /// Does sweeps, with steps that are tuned or not, and returns the mean of the extent f after
    /// each.
    pub fn run(&mut self, sweeps: u64, is_tuned: bool) -> f64 {
        let bodies = self.system.len() as u64;
        let mut sum = 0.0;
        for _ in 0..sweeps {
            // Trials are numbered through: their streams do not depend on stops.
            for trial in self.sweeps * bodies..(self.sweeps + 1) * bodies {
                let mut rng =
                    CounterRng::for_purpose(self.seed, self.stream, trial, Purpose::HardBodyMove);
                self.system.trial(
                    &mut rng,
                    &self.steps,
                    Counting::Lost,
                    &mut self.springs,
                    &mut self.counts,
                );
            }
            self.sweeps += 1;
            if is_tuned && self.sweeps.is_multiple_of(TUNE_EVERY) {
                // A longer step could take a body past another, to a site that is not its own.
                let body = self.system.body();
                let longest = Steps {
                    translation: body.inner_radius.max(0.2 * body.outer_radius),
                    ..self.system.longest_steps()
                };
                self.steps.tune(&self.counts, ACCEPTANCE, &longest);
                // Counts that are large enough have been used; new steps need new ones.
                if self.counts.total().trials >= 2 * Steps::ENOUGH {
                    self.counts = MoveCounts::default();
                }
            }
            sum += self.springs.extent();
        }
        sum / sweeps.max(1) as f64
    }

    /// The bodies.
    pub fn system(&self) -> &System<D> {
        &self.system
    }

    /// The springs.
    pub fn springs(&self) -> &Springs<D> {
        &self.springs
    }

    /// Sweeps done.
    pub fn sweeps(&self) -> u64 {
        self.sweeps
    }

    /// The accepted part of the moves since the steps were tuned last.
    pub fn acceptance(&self) -> f64 {
        self.counts.total().acceptance()
    }

    /// The state. Call [`refresh`](Self::refresh) before going on, so that this walker does what one from
    /// the state does.
    pub fn state(&self) -> WalkerState {
        let wxyz = |rotation: &Rotation| {
            let q = rotation.quaternion();
            [q.w, q.i, q.j, q.k]
        };
        WalkerState {
            sweeps: self.sweeps,
            positions: self.system.positions().as_flattened().to_vec(),
            displacements: self.springs.displacements().as_flattened().to_vec(),
            orientations_wxyz: self.system.rotations().iter().map(wxyz).collect(),
            steps: self.steps,
            counts: self.counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crystal::UnitCell;
    use protomer_kernel::periodic_box::PeriodicBox;
    use protomer_kernel::statistics::summarize;
    use std::f64::consts::PI;

    /// Free energy of bodies that keep their orientations.
    fn parallel_free_energy(body: &HardBody<3>, edges: [f64; 3]) -> FreeEnergy {
        let cell = UnitCell {
            space: PeriodicBox::rectangular(edges).unwrap(),
            ..UnitCell::by_name("fcc").unwrap()
        };
        let crystal = Crystal::new(&cell, body, 32, 0.58).unwrap();
        let measurement = Measurement {
            symmetry: Symmetry::find(&HardBody::<3>::ball(0.5).unwrap()).unwrap(),
            ..Measurement::new(body, &crystal, 5).unwrap()
        };
        let plan = measurement.plan().unwrap();
        let mut extents = Vec::new();
        for (stream, point) in (0..).zip(&plan.points) {
            let mut walker = measurement
                .start(stream, point.strength, plan.turning)
                .unwrap();
            for _ in 0..30 {
                walker.steps.rotation = 0.0;
                walker.run(TUNE_EVERY, true);
            }
            walker.steps.rotation = 0.0;
            let series: Vec<f64> = (0..100).map(|_| walker.run(10, false)).collect();
            let summary = summarize(&series);
            extents.push(Estimate {
                mean: summary.mean,
                error: summary.standard_error,
            });
        }
        measurement.free_energy(&plan, &extents)
    }

    /// Parallel ellipsoids that do not turn are spheres in stretched coordinates, so their free energy is less by the logarithm of
    /// the stretch.
    #[test]
    fn parallel_ellipsoids_have_the_free_energy_of_spheres() {
        let [stretch, flattening] = [1.6, 0.8];
        let ball = HardBody::ball(0.5).unwrap();
        let egg = HardBody::ellipsoid([0.5, 0.5 * flattening, 0.5 * stretch]).unwrap();
        let spheres = parallel_free_energy(&ball, [1.0; 3]);
        let ellipsoids = parallel_free_energy(&egg, [1.0, flattening, stretch]);
        let expected = spheres.total_kt - f64::ln(stretch * flattening);
        let error = spheres.total_kt_error.hypot(ellipsoids.total_kt_error);
        let off = ellipsoids.total_kt - expected;
        // The logarithm of the stretch, which the test must notice, is 0.25.
        assert!(error < 0.03, "{error}");
        assert!(off.abs() < 4.0 * error, "{off} {error}");
    }

    /// A chain of harmonic springs, like rods near their sites: ∫ f dλ = Σ_k ln[(λ₁ + ω_k)/ω_k]/(2N).
    /// Its long waves make the integrand wide.
    #[test]
    fn the_rule_integrates_over_the_waves_of_a_long_chain() {
        let (bodies, stiffness, strongest) = (100, 30.0, 20_000.0);
        let mut waves = Vec::new();
        for k in 1..bodies {
            let half_phase = PI * f64::from(k) / f64::from(bodies);
            waves.push(4.0 * stiffness * half_phase.sin().powi(2));
        }
        let per_body = |sum: f64| 0.5 * sum / f64::from(bodies);
        let extent =
            |strength: f64| per_body(waves.iter().map(|wave| 1.0 / (strength + wave)).sum());
        let exact = per_body(waves.iter().map(|wave| (strongest / wave).ln_1p()).sum());
        let shift = per_body(waves.len() as f64) / extent(0.0);
        let (mut fine, mut coarse) = (0.0, 0.0);
        for point in points(strongest, shift) {
            fine += point.weight * extent(point.strength);
            coarse += point.coarse_weight * extent(point.strength);
        }
        assert!((fine - exact).abs() < 5e-5, "{fine} {exact}");
        assert!((coarse - exact).abs() > 1e-3, "the coarser rule is coarser");
    }
}
