//! The strengths of a free energy apart from each other, each a run in a folder: processes may share them.
//!
//! ```text
//! DIR/  run.toml  run.json  points.csv  crystal.gsd
//! DIR/strength_00/  run.json  log.csv  checkpoint.bin   the weakest springs, with crystal.gsd
//! ```
//!
//! Every strength has the same sweeps. What a strength does depends on the settings and its number alone, so results do
//! not depend on who does it.

use super::{
    CRYSTAL, ExtentRow, FreeEnergyResult, FreeEnergyRun, FreeEnergySettings, LAYOUT, LOG,
    SWEEPS_PER_ROW, equilibrate,
};
use anyhow::{Context, Error, Result};
use protomer_common::output_file::write_once;
use protomer_hpmc::frenkel_ladd::{Plan, STRENGTHS, Walker, WalkerState};
use protomer_results::{
    Campaign, End, Execution, Log, LogMark, ResultKind, Run, Shard, Turn, Work, carry_out,
    carry_out_shard, drive, log,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Whether this is the folder of a strength.
pub(super) fn is_strength(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let number = name.strip_prefix("strength_");
    path.is_dir() && number.is_some_and(|number| number.parse::<usize>().is_ok())
}

/// Runs or continues all strengths and collects them.
pub(super) fn carry_out_apart<const D: usize>(
    run: &FreeEnergyRun<'_, D>,
    path: &Path,
    execution: &Execution,
) -> Result<End<FreeEnergyResult>> {
    let strengths = Strengths::new(run, path);
    carry_out(&strengths, path, &LAYOUT, run.settings, execution)
}

/// Runs or continues the strengths of one part; returns their number.
pub(super) fn carry_out_part<const D: usize>(
    run: &FreeEnergyRun<'_, D>,
    path: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    let strengths = Strengths::new(run, path);
    carry_out_shard(&strengths, path, &LAYOUT, run.settings, shard, execution)
}

/// All strengths of a free energy.
struct Strengths<'a, const D: usize> {
    run: &'a FreeEnergyRun<'a, D>,
    path: &'a Path,
    numbers: Vec<usize>,
    /// Made by the first strength that begins in this process; it is the same in all.
    plan: OnceLock<Plan>,
}

impl<'a, const D: usize> Strengths<'a, D> {
    fn new(run: &'a FreeEnergyRun<'a, D>, path: &'a Path) -> Self {
        Self {
            run,
            path,
            numbers: (0..STRENGTHS).collect(),
            plan: OnceLock::new(),
        }
    }

    fn plan(&self) -> Result<Plan> {
        if let Some(plan) = self.plan.get() {
            return Ok(plan.clone());
        }
        // Two threads may both come here; what they find is equal.
        let made = self.run.measurement.plan()?;
        Ok(self.plan.get_or_init(|| made).clone())
    }
}

impl<const D: usize> Campaign for Strengths<'_, D> {
    type Task = usize;
    type Part = Plan;
    type Answer = FreeEnergyResult;
    type Error = Error;

    fn work(&self) -> Work {
        self.run.work()
    }

    fn details_of(&self, answer: &FreeEnergyResult) -> Value {
        serde_json::to_value(answer).unwrap_or(Value::Null)
    }

    fn tasks(&self) -> &[usize] {
        &self.numbers
    }

    fn length(&self) -> (u64, &'static str) {
        (length(self.run.settings), "sweeps")
    }

    fn directory(&self, number: &usize) -> PathBuf {
        self.path.join(format!("strength_{number:02}"))
    }

    fn run(&self, number: &usize, directory: &Path, execution: &Execution) -> Result<End<Plan>> {
        let strength = Strength {
            all: self,
            number: *number,
        };
        let end = drive(&strength, directory, execution)
            .with_context(|| directory.display().to_string())?;
        Ok(end.map(|part| part.plan))
    }

    fn collect(&self, plans: Vec<Plan>) -> Result<FreeEnergyResult> {
        let mut series = vec![Vec::new(); STRENGTHS];
        for number in &self.numbers {
            let rows = log::read::<ExtentRow>(&self.directory(number).join(LOG))?;
            series[*number] = rows.into_iter().map(|row| row.extent).collect();
        }
        let plan = plans.first().context("there are no strengths")?;
        let result = self.run.result(plan, &series, self.path)?;
        let crystal = self.directory(&0).join(CRYSTAL);
        let bytes = protomer_io::input::read(&crystal)?;
        write_once(&self.path.join(CRYSTAL), &bytes, true)?;
        Ok(result)
    }
}

/// Sweeps of a strength, with whole rows.
fn length(settings: &FreeEnergySettings) -> u64 {
    let rows = settings.sweeps.div_ceil(SWEEPS_PER_ROW);
    settings
        .equilibration
        .saturating_add(rows.saturating_mul(SWEEPS_PER_ROW))
}

/// Bodies on springs of one strength.
struct Strength<'a, const D: usize> {
    all: &'a Strengths<'a, D>,
    number: usize,
}

/// Bodies in motion, with the open log.
struct Open<const D: usize> {
    plan: Plan,
    walker: Walker<D>,
    log: Log,
}

/// A state from which a strength continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    plan: Plan,
    walker: WalkerState,
}

/// Details of the record of a strength.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct StrengthResult {
    /// Strengths of all springs.
    plan: Plan,
}

impl<const D: usize> Run for Strength<'_, D> {
    type State = Open<D>;
    type Checkpoint = Saved;
    type Answer = StrengthResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = "free energy strength checkpoint";

    fn work(&self) -> Work {
        Work {
            kind: ResultKind::FreeEnergyStrength,
            ..self.all.run.work()
        }
    }

    fn length(&self) -> u64 {
        length(self.all.run.settings)
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open<D>> {
        let (mark, plan, state) = match saved {
            Some(saved) => (saved.log, saved.plan, Some(saved.walker)),
            None => (LogMark::default(), self.all.plan()?, None),
        };
        let walker = self.all.run.walker(self.number, &plan, state.as_ref())?;
        let log = Log::open::<ExtentRow>(&directory.join(LOG), &mark)?;
        Ok(Open { plan, walker, log })
    }

    fn done(&self, open: &Open<D>) -> u64 {
        open.walker.sweeps()
    }

    fn advance(&self, open: &mut Open<D>, _turn: &Turn<'_>) -> Result<()> {
        let equilibration = self.all.run.settings.equilibration;
        let remaining_sweeps = equilibration.saturating_sub(open.walker.sweeps());
        if remaining_sweeps > 0 {
            equilibrate(&mut open.walker, remaining_sweeps);
            return Ok(());
        }
        // One row, with all that makes sweeps fast made again: no bit depends on where a run was stopped or extended.
        open.walker.refresh();
        let extent = open.walker.run(SWEEPS_PER_ROW, false);
        open.log.append(&ExtentRow {
            point: self.number,
            sweep: open.walker.sweeps(),
            extent,
        })?;
        Ok(())
    }

    fn save(&self, open: &mut Open<D>) -> Result<Saved> {
        Ok(Saved {
            log: open.log.sync()?,
            plan: open.plan.clone(),
            walker: open.walker.state(),
        })
    }

    fn answer(&self, open: &mut Open<D>, directory: &Path) -> Result<StrengthResult> {
        if self.number == 0 {
            let weakest = Some(&open.walker);
            self.all
                .run
                .write_crystal(weakest, &directory.join(CRYSTAL))?;
        }
        Ok(StrengthResult {
            plan: open.plan.clone(),
        })
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }
}
