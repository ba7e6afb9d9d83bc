//! Bodies with charges in memory, for loops of one's own.

use crate::stability::run::columns::Measured;
use crate::stability::run::{Engine, GivenState, LogRow, Replica, RunSettings, frame, header};
use anyhow::{Result, bail};
use protomer_common::live::{
    Arrays, Column, Live, changed, refuse_others, require_rows, restored, take,
};
use protomer_io::gsd::Chunk;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::{Checkpoint, Simulation};
use protomer_results::Row;
use serde_json::Value;
use std::ops::ControlFlow;

/// Arrays of the state.
const COLUMNS: [Column; 2] = [
    Column {
        name: "positions",
        columns: 3,
    },
    Column {
        name: "orientations",
        columns: 4,
    },
];

/// An assembly in memory, as `simulate` begins it, or with the bodies where arrays have them: `positions` in Å and `orientations`,
/// quaternions with the scalar first, one row for each body.
///
/// # Errors
/// As for a run with these settings; also for arrays that do not fit, and bodies that overlap.
pub fn assembly(
    engine: Engine,
    settings: &RunSettings,
    arrays: Option<Arrays>,
) -> Result<Box<dyn Live>> {
    settings.check()?;
    if settings.simulations() != 1 {
        bail!(
            "the settings describe several simulations; give one salt concentration and one replica"
        );
    }
    let settings = engine.resolved(settings, None)?;
    let interaction = settings
        .medium
        .interaction(settings.salt_molar.first().copied())?;
    let charged = engine.in_medium(&settings, &interaction)?;
    let state = GivenState::wanted(&settings, &engine)?;
    let replica = Replica {
        engine: &charged,
        settings: &settings,
        interaction,
        salt_index: 0,
        replica: 0,
        state: state.as_ref(),
        identity: "",
    };
    let simulation = replica.start()?;
    let mut live = LiveAssembly {
        engine,
        charged,
        settings,
        simulation,
    };
    if let Some(arrays) = arrays {
        live.place(arrays)?;
    }
    Ok(Box::new(live))
}

struct LiveAssembly {
    /// The bodies with charges of their own.
    engine: Engine,
    /// The bodies with what acts in the present medium.
    charged: Engine,
    settings: RunSettings,
    simulation: Simulation,
}

impl LiveAssembly {
    /// The same simulation at other poses, in the medium of these settings.
    fn simulation(
        &self,
        settings: &RunSettings,
        charged: &Engine,
        poses: &[Pose],
    ) -> Result<Simulation> {
        let interaction = settings
            .medium
            .interaction(settings.salt_molar.first().copied())?;
        let model = charged.energy_model(settings, &interaction)?;
        let engine_settings = charged.settings(settings, &interaction)?;
        let system = charged.system_at(poses)?;
        Ok(self.simulation.placed(system, engine_settings, model)?)
    }

    fn row(&self) -> LogRow {
        let state = Measured {
            observables: self.simulation.observables(),
            cluster_moved: f64::NAN,
        };
        LogRow::new(self.simulation.sweep(), &state)
    }
}

impl Live for LiveAssembly {
    fn count(&self) -> usize {
        self.simulation.system().len()
    }

    fn done(&self) -> u64 {
        self.simulation.sweep()
    }

    fn moves_at_once(&self) -> u64 {
        // A move sums the charges of two proteins, which takes about a millisecond.
        200
    }

    fn advance(&mut self, count: u64) -> Result<()> {
        let end = self.done() + count;
        self.simulation
            .run_until(end, &mut |_| ControlFlow::Continue(()))?;
        Ok(())
    }

    fn arrays(&self) -> Vec<Column> {
        COLUMNS.to_vec()
    }

    fn copy(&self, name: &str, rows: &mut [f64]) {
        let poses = self.simulation.system().poses();
        match name {
            "positions" => {
                for (row, pose) in rows.chunks_exact_mut(3).zip(poses) {
                    row.copy_from_slice(pose.position.as_slice());
                }
            }
            "orientations" => {
                for (row, pose) in rows.chunks_exact_mut(4).zip(poses) {
                    row.copy_from_slice(&pose.wxyz());
                }
            }
            _ => {}
        }
    }

    fn space(&self) -> [f64; 6] {
        let mut numbers = [0.0; 6];
        if let Boundary::Periodic { lengths_angstrom } = self.simulation.system().boundary() {
            numbers[..3].copy_from_slice(lengths_angstrom.as_slice());
        }
        numbers
    }

    fn place(&mut self, mut arrays: Arrays) -> Result<()> {
        if arrays.contains_key("box") {
            bail!("the box is that of the assembly; leave box out");
        }
        require_rows(&arrays, self.count())?;
        let positions = take(&mut arrays, COLUMNS[0], None)?;
        let orientations = take(&mut arrays, COLUMNS[1], None)?;
        refuse_others(&arrays, &COLUMNS)?;
        let mut poses = self.simulation.system().poses().to_vec();
        for (pose, row) in poses
            .iter_mut()
            .zip(positions.iter().flat_map(|rows| rows.as_chunks::<3>().0))
        {
            pose.position = Vec3::from(*row);
        }
        for (pose, row) in poses
            .iter_mut()
            .zip(orientations.iter().flat_map(|rows| rows.as_chunks::<4>().0))
        {
            if row.iter().map(|x| x * x).sum::<f64>() < 1e-12 {
                bail!(
                    "orientations holds a quaternion of zeros; give w, x, y, z, with 1, 0, 0, 0 for no turn"
                );
            }
            *pose = Pose::from_wxyz(pose.position, *row);
        }
        self.simulation = self.simulation(&self.settings, &self.charged, &poses)?;
        Ok(())
    }

    fn settings(&self) -> Result<Value> {
        Ok(serde_json::to_value(&self.settings)?)
    }

    fn change(&mut self, keys: &Value) -> Result<()> {
        let settings: RunSettings = changed(&self.settings, keys)?;
        settings.check()?;
        if settings.simulations() != 1 || settings.seed != self.settings.seed {
            bail!(
                "several salts or replicas and another seed make other simulations; begin another one"
            );
        }
        let interaction = settings
            .medium
            .interaction(settings.salt_molar.first().copied())?;
        let charged = self.engine.in_medium(&settings, &interaction)?;
        let poses = self.simulation.system().poses().to_vec();
        self.simulation = self.simulation(&settings, &charged, &poses)?;
        (self.settings, self.charged) = (settings, charged);
        Ok(())
    }

    fn measure(&mut self) -> Vec<(&'static str, String)> {
        self.row().named()
    }

    fn save(&self) -> Result<Vec<u8>> {
        let saved = (&self.settings, self.simulation.checkpoint());
        Ok(serde_json::to_vec(&saved)?)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<()> {
        let (settings, checkpoint): (RunSettings, Checkpoint) = restored(saved, "an assembly")?;
        let interaction = settings
            .medium
            .interaction(settings.salt_molar.first().copied())?;
        let charged = self.engine.in_medium(&settings, &interaction)?;
        let model = charged.energy_model(&settings, &interaction)?;
        self.simulation = Simulation::resume_with_model(charged.system()?, checkpoint, model)?;
        (self.settings, self.charged) = (settings, charged);
        Ok(())
    }

    fn header(&self) -> Result<Vec<Chunk>> {
        header(self.engine.assembly())
    }

    fn frame(&self) -> Vec<Chunk> {
        frame(self.done(), &self.simulation, self.engine.assembly())
    }
}
