//! Replica exchange: a ladder of simulations of the same bodies, say at several salt
//! concentrations, that swap their states.
//!
//! Rung i samples exp(-U_i). Every so often, neighbours i and j propose to swap their states x_i and
//! x_j, and do so with probability min(1, exp(-Δ)),
//!
//! Δ = U_i(x_j) + U_j(x_i) - U_i(x_i) - U_j(x_j),
//!
//! which keeps every rung's distribution (Hukushima and Nemoto, J. Phys. Soc. Jpn. 65, 1604 (1996)).
//! A state that is stuck on one rung relaxes while it visits others. The simulations themselves stay
//! on their rungs, with their step sizes and their random numbers.

use crate::energy::{Effort, compared_kt};
use crate::moves::Acceptance;
use crate::{Checkpoint, McError, Result, Simulation};
use protomer_kernel::Pose;
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Simulations that exchange their states, neighbours next to each other.
pub struct Ladder {
    rungs: Vec<Simulation>,
    seed: u64,
    ladder: u32,
    exchanges: Exchanges,
}

/// Record of the exchanges since the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exchanges {
    /// Rounds of exchanges. In each, every other pair of neighbours tries to swap.
    pub rounds: u64,
    /// Swaps between each rung and the next.
    pub swaps: Vec<Acceptance>,
    /// Walker on each rung, numbered by the rung on which it started.
    pub walkers: Vec<usize>,
    /// The end of the ladder that each walker was at last.
    last_ends: Vec<Option<End>>,
    /// Ways of walkers from one end to the other and back, counted together.
    pub round_trips: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum End {
    First,
    Last,
}

impl Exchanges {
    /// Whether the lists are those of so many rungs, and each rung has a walker.
    fn fit(&self, rungs: usize) -> bool {
        let mut walkers = self.walkers.clone();
        walkers.sort_unstable();
        // Each walker once: a permutation of the rungs.
        walkers.into_iter().eq(0..rungs)
            && self.last_ends.len() == rungs
            && self.swaps.len() + 1 == rungs.max(1)
    }

    fn new(rungs: usize) -> Self {
        let mut exchanges = Self {
            rounds: 0,
            swaps: vec![Acceptance::default(); rungs.saturating_sub(1)],
            walkers: (0..rungs).collect(),
            last_ends: vec![None; rungs],
            round_trips: 0.0,
        };
        exchanges.note_ends();
        exchanges
    }

    fn note_ends(&mut self) {
        let ends = [
            (self.walkers.first(), End::First),
            (self.walkers.last(), End::Last),
        ];
        for (walker, end) in ends {
            let Some(last) = walker.and_then(|walker| self.last_ends.get_mut(*walker)) else {
                continue;
            };
            // Half a round trip per change of end; at the very start there is none before.
            if last.is_some_and(|last| last != end) {
                self.round_trips += 0.5;
            }
            *last = Some(end);
        }
    }
}

impl Ladder {
    /// A ladder of these simulations, which must be of the same bodies in the same space and at the
    /// same sweep. `ladder` tells several ladders of one seed apart.
    ///
    /// # Errors
    /// [`McError::BadSystem`] if bodies, spaces or sweeps differ.
    pub fn new(rungs: Vec<Simulation>, seed: u64, ladder: u32) -> Result<Self> {
        let exchanges = Exchanges::new(rungs.len());
        require_alike(&rungs)?;
        Ok(Self {
            rungs,
            seed,
            ladder,
            exchanges,
        })
    }

    /// Continues with simulations that were resumed from their checkpoints.
    ///
    /// # Errors
    /// As [`Ladder::new`]; [`McError::ForeignCheckpoint`] if the exchanges are of another number of
    /// rungs.
    pub fn resume(
        rungs: Vec<Simulation>,
        seed: u64,
        ladder: u32,
        exchanges: Exchanges,
    ) -> Result<Self> {
        if !exchanges.fit(rungs.len()) {
            let cause = format!(
                "it has {} rungs, and this ladder {}",
                exchanges.walkers.len(),
                rungs.len()
            );
            return Err(McError::ForeignCheckpoint(cause));
        }
        Ok(Self {
            rungs,
            seed,
            ladder,
            exchanges,
        })
    }

    /// The simulations.
    pub fn rungs(&self) -> &[Simulation] {
        &self.rungs
    }

    /// Record of the exchanges.
    pub fn exchanges(&self) -> &Exchanges {
        &self.exchanges
    }

    /// The states of all simulations.
    pub fn checkpoints(&self) -> Vec<Checkpoint> {
        self.rungs.iter().map(Simulation::checkpoint).collect()
    }

    /// Runs every simulation up to a total of `sweep` sweeps, on all threads, or until
    /// `must_stop`. The results do not depend on the number of threads.
    ///
    /// # Errors
    /// As [`Simulation::run_until`].
    pub fn run_until(&mut self, sweep: u64, must_stop: &(dyn Fn() -> bool + Sync)) -> Result<()> {
        let run = |rung: &mut Simulation| {
            let mut observer = |_: &Simulation| match must_stop() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            rung.run_until(sweep, &mut observer).map(drop)
        };
        self.rungs.par_iter_mut().try_for_each(run)
    }

    /// One round of exchanges: between rungs 0 and 1, 2 and 3, ..., or, every other time, between 1
    /// and 2, 3 and 4, ...
    ///
    /// # Errors
    /// [`McError::NonFiniteEnergy`] names a pair of bodies.
    pub fn exchange(&mut self) -> Result<()> {
        self.exchange_by(|rise_kt| rise_kt)
    }

    /// Variant of [`exchange`](Self::exchange) with another rule: what it makes of Δ decides.
    fn exchange_by(&mut self, rule: impl Fn(f64) -> f64 + Sync) -> Result<()> {
        let round = self.exchanges.rounds;
        // Even and odd pairs alternate, so that no rung is in two swaps of one round.
        let first = (round % 2) as usize;
        let (seed, ladder) = (self.seed, self.ladder);
        // A ladder of one rung has no pairs.
        let pairs = self.rungs.get_mut(first..).unwrap_or_default();
        let decided: Vec<bool> = pairs
            .par_chunks_exact_mut(2)
            .enumerate()
            .map(|(number, pair)| {
                // The same stream for all pairs of a round, the
                // number picks from it: independent of threads.
                let stream = CounterRng::for_purpose(seed, ladder, round, Purpose::Exchange);
                swap_maybe(pair, &rule, budget_kt(stream, number))
            })
            .collect::<Result<_>>()?;
        for (number, swapped) in decided.into_iter().enumerate() {
            let lower = first + 2 * number;
            self.exchanges.swaps[lower].count(swapped);
            if swapped {
                self.exchanges.walkers.swap(lower, lower + 1);
            }
        }
        self.exchanges.note_ends();
        self.exchanges.rounds += 1;
        Ok(())
    }
}

/// -ln u with the number of a pair in a round.
fn budget_kt(mut stream: CounterRng, number: usize) -> f64 {
    let mut uniform = stream.uniform();
    // Counted off: a pair's number does not depend on who else asks.
    for _ in 0..number {
        uniform = stream.uniform();
    }
    -uniform.ln()
}

/// Lets two simulations swap their states if the energy rises by less than the budget.
fn swap_maybe(pair: &mut [Simulation], rule: &impl Fn(f64) -> f64, budget_kt: f64) -> Result<bool> {
    let [one, other] = pair else {
        return Ok(false);
    };
    // Copied first: after one rung has taken the poses the other still needs the old ones.
    let poses = [&*one, &*other].map(|rung| rung.system().poses().to_vec());
    let rise = |effort| Ok(rule(rise_kt(one, other, &poses, effort)?));
    let accepted = compared_kt(budget_kt, rise)? < budget_kt;
    if accepted {
        one.take_poses(&poses[1])?;
        other.take_poses(&poses[0])?;
    }
    Ok(accepted)
}

/// Δ, kT.
fn rise_kt(
    one: &Simulation,
    other: &Simulation,
    [of_one, of_other]: &[Vec<Pose>; 2],
    effort: Effort,
) -> Result<f64> {
    let swapped = one.energy_at_kt(of_other, effort)? + other.energy_at_kt(of_one, effort)?;
    let unswapped = one.energy_at_kt(of_one, effort)? + other.energy_at_kt(of_other, effort)?;
    Ok(swapped - unswapped)
}

fn require_alike(rungs: &[Simulation]) -> Result<()> {
    let Some((first, others)) = rungs.split_first() else {
        return Ok(());
    };
    let names = |rung: &Simulation| crate::checkpoint::type_names(rung.system());
    for rung in others {
        if names(rung) != names(first)
            || rung.system().boundary() != first.system().boundary()
            || rung.sweep() != first.sweep()
        {
            return Err(McError::BadSystem(
                "the rungs of a ladder are simulations of the same bodies in the same space, at \
                 the same sweep"
                    .into(),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::octahedron;
    use crate::{BodyType, Interaction, Settings, System};
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::statistics::RunningMoments;
    use protomer_kernel::{Boundary, Rotation, Vec3};
    use std::sync::Arc;

    const CONTACT_ANGSTROM: f64 = 10.0;
    const HALF_BOX_ANGSTROM: f64 = 30.0;
    const NEAR_ANGSTROM: f64 = 14.0;
    /// Bjerrum lengths of the rungs, Å.
    const BJERRUM_ANGSTROM: [f64; 3] = [7.0, 4.5, 2.0];

    fn yukawa(rung: usize) -> Yukawa {
        Yukawa::new(BJERRUM_ANGSTROM[rung], 0.05, 25.0).unwrap()
    }

    /// Two octahedra with opposite charges in their centres.
    fn system(apart_angstrom: f64) -> System {
        let mesh = octahedron(5.0);
        let kinds = [3.0, -3.0].map(|charge| {
            Arc::new(BodyType::new("ion", &mesh, &[(Vec3::zeros(), charge)]).unwrap())
        });
        let pose = |x: f64| Pose {
            position: Vec3::new(x, 0.0, 0.0),
            rotation: Rotation::identity(),
        };
        let bodies = [
            (0, pose(-0.5 * apart_angstrom)),
            (1, pose(0.5 * apart_angstrom)),
        ];
        let space = Boundary::periodic(Vec3::repeat(2.0 * HALF_BOX_ANGSTROM)).unwrap();
        System::new(kinds.to_vec(), &bodies, space).unwrap()
    }

    fn ladder(seed: u64) -> Ladder {
        let rung = |rung: usize| {
            let settings = Settings {
                equilibration_sweeps: 0,
                cluster_moves_per_sweep: 0,
                translation_step_angstrom: 5.0,
                ..Settings::new(Interaction::YukawaDirect(yukawa(rung)))
            };
            Simulation::new(system(20.0), settings, seed, rung as u32).unwrap()
        };
        Ladder::new((0..3).map(rung).collect(), seed, 0).unwrap()
    }

    fn distance(simulation: &Simulation) -> f64 {
        simulation.system().pair(0, 1).displacement.norm()
    }

    /// P(r < 14 Å) among distances beyond contact, within the largest sphere of the box:
    /// r² exp(-V(r)).
    fn exact(rung: usize) -> f64 {
        let (mut near, mut all) = (0.0, 0.0);
        let width = 1e-3;
        let mut r = CONTACT_ANGSTROM + width / 2.0;
        while r < HALF_BOX_ANGSTROM {
            let weight = r * r * (9.0 * yukawa(rung).energy_kt(r)).exp();
            all += weight;
            near += if r < NEAR_ANGSTROM { weight } else { 0.0 };
            r += width;
        }
        near / all
    }

    /// By how many standard errors each rung's probability is off.
    fn deviations(rule: impl Fn(f64) -> f64 + Sync + Copy) -> [f64; 3] {
        const LADDERS: u64 = 8;
        let mut shares = [const { Vec::new() }; 3];
        for seed in 0..LADDERS {
            let mut ladder = ladder(seed);
            let mut counts = [[0.0; 2]; 3];
            for sweep in 1..=20_000 {
                ladder.run_until(sweep, &|| false).unwrap();
                ladder.exchange_by(rule).unwrap();
                for (counts, rung) in counts.iter_mut().zip(ladder.rungs()) {
                    let r = distance(rung);
                    if (CONTACT_ANGSTROM..HALF_BOX_ANGSTROM).contains(&r) {
                        counts[1] += 1.0;
                        counts[0] += if r < NEAR_ANGSTROM { 1.0 } else { 0.0 };
                    }
                }
            }
            for (shares, [near, all]) in shares.iter_mut().zip(counts) {
                shares.push(near / all);
            }
        }
        let mut rung = 0;
        shares.map(|shares| {
            let moments = RunningMoments::in_two_passes(&shares);
            rung += 1;
            (moments.mean() - exact(rung - 1)) / moments.independent_standard_error()
        })
    }

    #[test]
    fn exchanges_keep_the_distribution_of_every_rung() {
        for deviation in deviations(|rise_kt| rise_kt) {
            assert!(deviation.abs() < 5.0, "{deviation} standard errors");
        }
    }

    #[test]
    fn a_wrong_rule_is_noticed() {
        let largest = |scores: [f64; 3]| {
            scores
                .into_iter()
                .fold(0.0, |most: f64, z| most.max(z.abs()))
        };
        assert!(largest(deviations(|_| f64::NEG_INFINITY)) > 8.0);
        assert!(largest(deviations(|rise_kt| 0.5 * rise_kt)) > 8.0);
    }

    #[test]
    fn walkers_and_swaps_are_counted() {
        let mut ladder = ladder(1);
        for sweep in 1..=400 {
            ladder.run_until(sweep, &|| false).unwrap();
            ladder.exchange().unwrap();
        }
        let exchanges = ladder.exchanges();
        let trials: Vec<u64> = exchanges.swaps.iter().map(|count| count.trials).collect();
        assert_eq!(trials, [200, 200]);
        let mut walkers = exchanges.walkers.clone();
        walkers.sort_unstable();
        assert_eq!(walkers, [0, 1, 2]);
        assert!(exchanges.round_trips > 5.0);
    }

    #[test]
    fn a_continued_ladder_is_the_uninterrupted_one() {
        let run = |ladder: &mut Ladder, from: u64, to: u64| {
            for sweep in from + 1..=to {
                ladder.run_until(sweep, &|| false).unwrap();
                ladder.exchange().unwrap();
            }
        };
        let mut whole = ladder(3);
        run(&mut whole, 0, 60);
        let mut begun = ladder(3);
        run(&mut begun, 0, 25);
        let rungs = begun.checkpoints().into_iter();
        let rungs = rungs.map(|checkpoint| Simulation::resume(system(20.0), checkpoint).unwrap());
        let rungs = rungs.collect();
        let mut continued = Ladder::resume(rungs, 3, 0, begun.exchanges().clone()).unwrap();
        run(&mut continued, 25, 60);
        assert_eq!(whole.checkpoints(), continued.checkpoints());
        assert_eq!(whole.exchanges(), continued.exchanges());
    }
}
