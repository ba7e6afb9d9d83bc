//! Bodies in motion in memory, for loops of one's own.

use super::log::LogRow;
use super::placed::{begin_from, of_file, packing_fraction, with_state};
use super::schedule::Schedule;
use super::settings::DynamicsSettings;
use super::start::kinds;
use super::trajectory::{frame, header};
use crate::given_state::{GivenState, given_arrays, replaced};
use anyhow::{Result, bail};
use protomer_common::live::{Arrays, Column, Live, Rows, changed, restored};
use protomer_io::gsd::Chunk;
use protomer_kernel::{Boundary, Vec3};
use protomer_md::engine::{Engine, Motion};
use protomer_results::Row;
use serde_json::{Value, json};

/// Bodies in motion in memory. They begin as `md run` begins them, through compression and equilibration, or where the arrays have
/// them, without either: `positions` from the middle of the box, `orientations` (in a plane `angles`), `velocities`, `spins` and
/// `box`. Without velocities they get those of the temperature.
///
/// ```
/// use protomer_shape_verbs::dynamics::live::dynamics;
/// use protomer_common::live::{Arrays, Rows};
/// let settings = serde_json::json!({ "shape": "disk", "ensemble": "nve" });
/// let rows = |columns, values: &[f64]| Rows { columns, values: values.to_vec() };
/// let arrays = Arrays::from([
///     ("positions".to_owned(), rows(2, &[-2.0, 0.0, 2.0, 0.0])),
///     ("velocities".to_owned(), rows(3, &[1.0, 0.0, 0.0, -1.0, 0.0, 0.0])),
///     ("box".to_owned(), rows(2, &[20.0, 20.0])),
/// ]);
/// let mut disks = dynamics(&settings, Some(arrays))?;
/// disks.advance(1000)?;
/// let mut positions = [0.0; 4];
/// disks.copy("positions", &mut positions);
/// assert!((positions[0] + 1.9).abs() < 1e-9, "0.1 further, at a time step of 1e-4");
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// As for a run with these settings; also for arrays that do not fit, and bodies that overlap.
pub fn dynamics(settings: &Value, arrays: Option<Arrays>) -> Result<Box<dyn Live>> {
    let defaults = DynamicsSettings::default();
    let Some(arrays) = arrays else {
        let schedule = Schedule::new(with_state(changed(&defaults, settings)?)?)?;
        return Ok(Box::new(LiveDynamics::new(schedule)?));
    };
    // Bodies in their places need no preparation, unless one is given.
    let unprepared = changed(
        &defaults,
        &json!({ "compress_steps": 0, "equilibrate_steps": 0 }),
    )?;
    let settings: DynamicsSettings = changed(&unprepared, settings)?;
    let dimensions = kinds(&settings)?.first().map_or(3, |kind| kind.dimension);
    let schedule = begin(settings, &given_arrays(arrays, dimensions)?)?;
    Ok(Box::new(LiveDynamics::new(schedule)?))
}

/// The course of bodies that begin where they are given, with their number and packing fraction in the settings.
fn begin(settings: DynamicsSettings, given: &GivenState) -> Result<Schedule> {
    let found = of_file(given, &settings, kinds(&settings)?)?;
    let settings = DynamicsSettings {
        bodies: found.bodies.count(),
        packing_fraction: packing_fraction(&found),
        ..settings
    };
    settings.check()?;
    let begun = begin_from(&settings, found)?;
    Ok(Schedule { settings, begun })
}

struct LiveDynamics {
    schedule: Schedule,
    engine: Engine,
}

impl LiveDynamics {
    fn new(schedule: Schedule) -> Result<Self> {
        let engine = schedule.engine(None)?;
        Ok(Self { schedule, engine })
    }

    fn is_flat(&self) -> bool {
        self.engine.bodies().dimension() == 2
    }
}

impl Live for LiveDynamics {
    fn count(&self) -> usize {
        self.engine.bodies().count()
    }

    fn done(&self) -> u64 {
        self.engine.motion().steps
    }

    fn advance(&mut self, count: u64) -> Result<()> {
        for _ in 0..count {
            self.schedule.step(&mut self.engine)?;
        }
        Ok(())
    }

    fn arrays(&self) -> Vec<Column> {
        let places = if self.is_flat() { 2 } else { 3 };
        let columns = [
            ("positions", places),
            ("orientations", 4),
            ("velocities", 3),
            ("spins", 3),
        ];
        columns
            .map(|(name, columns)| Column { name, columns })
            .to_vec()
    }

    fn copy(&self, name: &str, rows: &mut [f64]) {
        let state = &self.engine.motion().state;
        let mut fill = |vectors: &[Vec3], columns: usize| {
            for (row, vector) in rows.chunks_exact_mut(columns).zip(vectors) {
                row.copy_from_slice(&vector.as_slice()[..columns]);
            }
        };
        match name {
            "positions" => fill(&state.positions, if self.is_flat() { 2 } else { 3 }),
            "velocities" => fill(&state.velocities, 3),
            "spins" => fill(&state.spins, 3),
            "orientations" => {
                for (body, row) in rows.chunks_exact_mut(4).enumerate() {
                    let [x, y, z, w] = state.rotation(body).coords.into();
                    row.copy_from_slice(&[w, x, y, z]);
                }
            }
            _ => {}
        }
    }

    fn space(&self) -> [f64; 6] {
        let mut numbers = [0.0; 6];
        if let Boundary::Periodic { lengths_angstrom } = self.engine.motion().state.space {
            let axes = if self.is_flat() { 2 } else { 3 };
            numbers[..axes].copy_from_slice(&lengths_angstrom.as_slice()[..axes]);
        }
        numbers
    }

    fn place(&mut self, arrays: Arrays) -> Result<()> {
        let mut all = replaced(self, arrays)?;
        let kinds = self.engine.bodies().kind_of.iter();
        let kinds = Rows {
            columns: 1,
            values: kinds.map(|kind| *kind as f64).collect(),
        };
        all.insert("kinds".into(), kinds);
        let given = given_arrays(all, self.engine.bodies().dimension())?;
        let schedule = begin(self.schedule.settings.clone(), &given)?;
        let mut engine = schedule.engine(None)?;
        // The steps go on, and with them the random numbers of a bath.
        engine.count_from(self.engine.motion().steps);
        engine.change_settings(schedule.motion(engine.motion().steps))?;
        *self = Self { schedule, engine };
        Ok(())
    }

    fn settings(&self) -> Result<Value> {
        Ok(serde_json::to_value(&self.schedule.settings)?)
    }

    fn change(&mut self, settings: &Value) -> Result<()> {
        let before = &self.schedule.settings;
        let changed: DynamicsSettings = changed(before, settings)?;
        let bodies = |settings: &DynamicsSettings| DynamicsSettings {
            shape: settings.shape.clone(),
            share: settings.share.clone(),
            rounding: settings.rounding,
            keep_size: settings.keep_size,
            fixed_orientations: settings.fixed_orientations,
            bodies: settings.bodies,
            packing_fraction: settings.packing_fraction,
            compress_from: settings.compress_from,
            compress_steps: settings.compress_steps,
            equilibrate_steps: settings.equilibrate_steps,
            start: settings.start.clone(),
            frame: settings.frame,
            pair_potential: settings.pair_potential.clone(),
            field: settings.field.clone(),
            // The unit of those energies.
            temperature: match settings.has_added() {
                true => settings.temperature,
                false => 1.0,
            },
            ..DynamicsSettings::default()
        };
        if bodies(&changed) != bodies(before) {
            bail!(
                "shapes, their number, their start, their preparation and their potentials (with the temperature that is the unit \
                 of these) are those of other bodies; begin another simulation, or place these elsewhere"
            );
        }
        changed.check()?;
        self.schedule.settings = changed;
        let motion = self.schedule.motion(self.engine.motion().steps);
        Ok(self.engine.change_settings(motion)?)
    }

    fn measure(&mut self) -> Vec<(&'static str, String)> {
        let (step, time) = self.schedule.place(&self.engine);
        let row = LogRow::new(
            step,
            time,
            &self.engine,
            self.schedule.begun.volume_with_layer,
        );
        let left_out = LogRow::left_out(&self.schedule.settings);
        let mut named = row.named();
        named.retain(|(name, _)| !left_out.contains(name));
        named
    }

    fn save(&self) -> Result<Vec<u8>> {
        let saved = (&self.schedule.settings, self.engine.motion());
        Ok(serde_json::to_vec(&saved)?)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<()> {
        let (settings, motion): (DynamicsSettings, Motion) = restored(saved, "bodies in motion")?;
        if motion.state.positions.len() != self.count()
            || settings.shape != self.schedule.settings.shape
        {
            bail!("the saved state is of other bodies; restore one of this simulation");
        }
        let before = std::mem::replace(&mut self.schedule.settings, settings);
        match self.schedule.engine(Some(motion)) {
            Ok(engine) => self.engine = engine,
            Err(error) => {
                self.schedule.settings = before;
                return Err(error);
            }
        }
        Ok(())
    }

    fn header(&self) -> Result<Vec<Chunk>> {
        header(self.engine.bodies())
    }

    fn frame(&self) -> Vec<Chunk> {
        let (_, time) = self.schedule.place(&self.engine);
        frame(self.done(), time, &self.engine)
    }
}
