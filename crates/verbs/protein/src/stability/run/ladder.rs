//! One replica at all salt concentrations of a sweep, which exchange their states.
//!
//! ```text
//! LADDER_DIR/  checkpoint.bin  run.json
//! and for each salt concentration, in the directory of its simulation
//! DIR/  log.csv  trajectory.gsd  run.json
//! ```

use super::outputs::{Outputs, SavedOutputs};
use super::{AcceptedFractions, Engine, GivenState, Replica, RunSettings};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Context, Error, Result};
use protomer_mc::exchange::Exchanges;
use protomer_mc::{Checkpoint, Ladder, Simulation};
use protomer_results::checkpoint::require_lengths;
use protomer_results::{Exit, Record, ResultKind, Run, Turn, Work};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A ladder of simulations.
#[derive(Debug)]
pub struct LadderRun<'a> {
    /// The rungs, neighbouring salt concentrations next to each other.
    pub rungs: Vec<Rung<'a>>,
    /// The settings of the sweep.
    pub settings: &'a RunSettings,
    /// Index of the replica.
    pub replica: u32,
    /// Poses of a file from which the bodies start, in the place of those of the assembly.
    pub state: Option<&'a GivenState>,
    /// Hash of everything that shapes the result.
    pub identity: &'a str,
}

/// A rung of a ladder: one salt concentration.
#[derive(Debug)]
pub struct Rung<'a> {
    /// The bodies, with the charges that interact in this medium.
    pub engine: &'a Engine,
    /// The medium.
    pub interaction: ScreenedCoulomb,
    /// Index of the salt concentration in the settings.
    pub salt_index: u32,
    /// Directory of the outputs of the rung.
    pub directory: PathBuf,
}

/// Answer of a ladder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LadderAnswer {
    /// Acceptance ratios of each rung.
    pub accepted: Vec<AcceptedFractions>,
    /// Statistics of the exchanges.
    pub exchanged: Exchanged,
}

/// The exchanges of one replica.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Exchanged {
    /// Index of the replica.
    pub replica: u32,
    /// Accepted fraction of the swaps between each salt concentration and the next higher one.
    pub acceptance: Vec<f64>,
    /// Round trips of states from the lowest to the highest salt and back.
    pub round_trips: f64,
}

impl Exchanged {
    /// Description of the exchanges in one line.
    pub fn text(&self) -> String {
        let fractions: Vec<String> = self
            .acceptance
            .iter()
            .map(|fraction| format!("{fraction:.2}"))
            .collect();
        format!(
            "replica {}: {} of the exchanges between neighbouring salts accepted, {:.1} round trips",
            self.replica,
            fractions.join(", "),
            self.round_trips
        )
    }
}

/// A state from which a ladder continues bit for bit.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    outputs: Vec<SavedOutputs>,
    simulations: Vec<Checkpoint>,
    exchanges: Exchanges,
}

/// A ladder with its open files.
pub struct State {
    ladder: Ladder,
    outputs: Vec<Outputs>,
}

impl Run for LadderRun<'_> {
    type State = State;
    type Checkpoint = Saved;
    type Answer = LadderAnswer;
    type Error = Error;

    fn work(&self) -> Work {
        Work {
            kind: ResultKind::Simulation,
            verb: "sweep",
            identity: self.identity.into(),
            input_sha256: self
                .rungs
                .first()
                .map(|rung| rung.engine.assembly().sha256.clone())
                .unwrap_or_default(),
        }
    }

    fn length(&self) -> u64 {
        // All rungs count, as in `done`.
        self.settings.total_sweeps() * self.rungs.len() as u64
    }

    fn open(&self, _: &Path, saved: Option<Saved>) -> Result<State> {
        let (seed, replica) = (self.settings.seed, self.replica);
        let mut saved_outputs = vec![SavedOutputs::default(); self.rungs.len()];
        let ladder = match saved {
            None => {
                let start = |rung: &Rung<'_>| self.replica_on(rung).start();
                let simulations = self.rungs.iter().map(start).collect::<Result<_>>()?;
                Ladder::new(simulations, seed, replica)?
            }
            Some(saved) => {
                let rungs = self.rungs.len();
                // Before anything is resumed: rungs and saved parts are matched by their place.
                require_lengths(&[
                    ("outputs", saved.outputs.len(), rungs),
                    ("simulations", saved.simulations.len(), rungs),
                ])?;
                saved_outputs = saved.outputs;
                let rungs = self.rungs.iter().zip(saved.simulations);
                let simulations = rungs.map(|(rung, checkpoint)| self.resume(rung, checkpoint));
                let simulations = simulations.collect::<Result<_>>()?;
                Ladder::resume(simulations, seed, replica, saved.exchanges)?
            }
        };
        let mut outputs = Vec::with_capacity(self.rungs.len());
        for (rung, saved) in self.rungs.iter().zip(&saved_outputs) {
            std::fs::create_dir_all(&rung.directory).with_context(|| {
                format!("cannot create the directory {}", rung.directory.display())
            })?;
            let Rung {
                directory, engine, ..
            } = rung;
            outputs.push(Outputs::open(directory, engine, self.settings, saved)?);
        }
        Ok(State { ladder, outputs })
    }

    fn done(&self, state: &State) -> u64 {
        state.ladder.rungs().iter().map(Simulation::sweep).sum()
    }

    /// Advances all rungs to the next output or exchange, whatever comes first. Rungs that were
    /// interrupted on the way catch up in the next turn.
    fn advance(&self, state: &mut State, turn: &Turn<'_>) -> Result<()> {
        let sweeps = |ladder: &Ladder| -> Vec<u64> {
            ladder.rungs().iter().map(Simulation::sweep).collect()
        };
        let before = sweeps(&state.ladder);
        // The rung that is farthest behind decides; the others wait at the stop.
        let last = before.iter().copied().min().unwrap_or(0);
        let stop = self.settings.next_stop(last);
        state.ladder.run_until(stop, &|| turn.is_over())?;
        let rungs = state.ladder.rungs().iter().zip(&mut state.outputs);
        for ((rung, outputs), before) in rungs.zip(before) {
            // Only rungs that arrived in this turn: one that waited has written already.
            if before < stop && rung.sweep() == stop {
                outputs.write(self.settings, rung)?;
            }
        }
        // An exchange needs both states at one sweep; an interrupted ladder catches up first.
        let are_all_there = sweeps(&state.ladder).into_iter().all(|sweep| sweep == stop);
        if are_all_there && stop.is_multiple_of(self.settings.exchange_every) {
            state.ladder.exchange()?;
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<Saved> {
        let outputs = state.outputs.iter_mut().map(Outputs::save);
        Ok(Saved {
            outputs: outputs.collect::<Result<_>>()?,
            simulations: state.ladder.checkpoints(),
            exchanges: state.ladder.exchanges().clone(),
        })
    }

    fn answer(&self, state: &mut State, _: &Path) -> Result<LadderAnswer> {
        // Now that all is done: each rung leaves a record as a simulation by itself would.
        for (rung, simulation) in self.rungs.iter().zip(state.ladder.rungs()) {
            self.record(rung, simulation)?;
        }
        Ok(self.so_far(&state.ladder))
    }

    fn details(&self, state: &mut State, _: &Path) -> Result<serde_json::Value> {
        Ok(serde_json::to_value(self.so_far(&state.ladder))?)
    }

    fn check(&self, _: &Path, saved: &Saved) -> Result<()> {
        let mut rungs = self.rungs.iter().zip(&saved.outputs);
        rungs.try_for_each(|(rung, outputs)| outputs.check(&rung.directory))
    }
}

impl<'a> LadderRun<'a> {
    fn replica_on(&self, rung: &Rung<'a>) -> Replica<'a> {
        Replica {
            engine: rung.engine,
            settings: self.settings,
            interaction: rung.interaction,
            salt_index: rung.salt_index,
            replica: self.replica,
            state: self.state,
            identity: self.identity,
        }
    }

    fn resume(&self, rung: &Rung<'a>, checkpoint: Checkpoint) -> Result<Simulation> {
        let model = rung.engine.energy_model(self.settings, &rung.interaction)?;
        let system = rung.engine.system()?;
        Ok(Simulation::resume_with_model(system, checkpoint, model)?)
    }

    fn so_far(&self, ladder: &Ladder) -> LadderAnswer {
        let exchanges = ladder.exchanges();
        let fraction = |count: &protomer_mc::moves::Acceptance| match count.trials {
            0 => 0.0,
            trials => count.accepted as f64 / trials as f64,
        };
        let accepted = |rung: &Simulation| AcceptedFractions::from_statistics(rung.statistics());
        LadderAnswer {
            accepted: ladder.rungs().iter().map(accepted).collect(),
            exchanged: Exchanged {
                replica: self.replica,
                acceptance: exchanges.swaps.iter().map(fraction).collect(),
                round_trips: exchanges.round_trips,
            },
        }
    }

    /// The record of a rung, as simulations without exchange leave it.
    fn record(&self, rung: &Rung<'a>, simulation: &Simulation) -> Result<()> {
        let replica = self.replica_on(rung);
        let record = Record {
            done: Some(simulation.sweep()),
            details: replica.details_of(simulation),
            ..Record::new(&replica.work(), Exit::Done)
        };
        Ok(record.write(&rung.directory)?)
    }
}
