//! Hard bodies in memory, for loops of one's own.

use super::kinds::Shapes;
use super::placed::{of_file, with_state};
use super::run::{Prepared, engine, measure};
use super::settings::HardBodySettings;
use super::trajectory::{frame, header};
use crate::given_state::{given_arrays, is_state, replaced};
use anyhow::{Result, bail};
use protomer_common::live::{Arrays, Column, Live, changed, restored};
use protomer_hpmc::mixture::Mixture;
use protomer_hpmc::simulation::{Simulation, State};
use protomer_hpmc::start::{Placed, Start};
use protomer_io::gsd::Chunk;
use protomer_results::Row;
use serde_json::Value;

/// Hard bodies in memory. They begin as `hpmc run` begins them, or where the arrays have them: `positions` from the middle of the
/// box, `orientations` (in a plane `angles`) and `box`.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::live::hard_bodies;
/// let settings = serde_json::json!({ "shape": "cube", "bodies": 64, "packing_fraction": 0.2 });
/// let mut cubes = hard_bodies(&settings, None)?;
/// cubes.advance(10)?;
/// let saved = cubes.save()?;
/// let mut positions = vec![0.0; 3 * cubes.count()];
/// cubes.advance(5)?;
/// cubes.copy("positions", &mut positions);
/// cubes.restore(&saved)?;
/// cubes.advance(5)?;
/// let mut again = vec![0.0; 3 * cubes.count()];
/// cubes.copy("positions", &mut again);
/// assert_eq!(positions, again);
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// As for a run with these settings; also for arrays that do not fit, and bodies that overlap.
pub fn hard_bodies(settings: &Value, arrays: Option<Arrays>) -> Result<Box<dyn Live>> {
    let mut all: HardBodySettings = changed(&HardBodySettings::default(), settings)?;
    if arrays.is_none() && is_state(&all.start) {
        let number = |key| settings.get(key).and_then(Value::as_f64);
        let bodies = number("bodies").map(|bodies| bodies as usize);
        all = with_state(all, bodies, number("packing_fraction"))?;
    }
    let settings = all;
    let shape = Shapes::read(&settings)?;
    Ok(match shape.dimension() {
        1 => Box::new(LiveHardBodies::<1>::new(settings, &shape, arrays)?),
        2 => Box::new(LiveHardBodies::<2>::new(settings, &shape, arrays)?),
        _ => Box::new(LiveHardBodies::<3>::new(settings, &shape, arrays)?),
    })
}

struct LiveHardBodies<const D: usize> {
    settings: HardBodySettings,
    mixture: Mixture<D>,
    simulation: Simulation<D>,
}

impl<const D: usize> LiveHardBodies<D> {
    fn new(settings: HardBodySettings, shape: &Shapes, arrays: Option<Arrays>) -> Result<Self> {
        let Some(arrays) = arrays else {
            settings.check()?;
            let Prepared {
                mixture,
                start,
                engine,
                ..
            } = Prepared::new(&settings, shape)?;
            let depletants = &settings.depletants;
            let simulation =
                Simulation::of_mixture(&engine, &mixture, depletants, &start, &|| false)?;
            return Ok(Self {
                settings,
                mixture,
                simulation,
            });
        };
        let given = given_arrays(arrays, D.max(2))?;
        let kinds = shape.kinds(&settings)?;
        let state = of_file(&given, &settings, &kinds)?;
        let settings = HardBodySettings {
            bodies: state.kind_of.len(),
            ..settings
        };
        let mixture = match settings.spread > 0.0 {
            true => shape.mixture(&settings)?,
            false => Mixture::new(kinds, state.kind_of)?,
        };
        let (settings, simulation) = begin(settings, &mixture, state.placed)?;
        Ok(Self {
            settings,
            mixture,
            simulation,
        })
    }

    fn resume(&self, settings: &HardBodySettings, state: &State) -> Result<Simulation<D>> {
        let (engine, depletants) = (engine(settings)?, &settings.depletants);
        Ok(Simulation::resume_mixture(
            &engine,
            &self.mixture,
            depletants,
            state,
        )?)
    }
}

/// A simulation that begins where bodies are given, and its settings with their packing fraction.
fn begin<const D: usize>(
    settings: HardBodySettings,
    mixture: &Mixture<D>,
    placed: Placed<D>,
) -> Result<(HardBodySettings, Simulation<D>)> {
    let settings = HardBodySettings {
        packing_fraction: placed.packing_fraction(mixture.mean_volume()),
        ..settings
    };
    settings.check()?;
    let (engine, start) = (engine(&settings)?, Start::Placed(placed));
    let depletants = &settings.depletants;
    let simulation = Simulation::of_mixture(&engine, mixture, depletants, &start, &|| false)?;
    Ok((settings, simulation))
}

impl<const D: usize> Live for LiveHardBodies<D> {
    fn count(&self) -> usize {
        self.simulation.system().len()
    }

    fn done(&self) -> u64 {
        self.simulation.sweeps()
    }

    fn advance(&mut self, count: u64) -> Result<()> {
        self.simulation.refresh();
        Ok(self.simulation.run(count)?)
    }

    fn arrays(&self) -> Vec<Column> {
        let columns = [("positions", D.max(2)), ("orientations", 4)];
        columns
            .map(|(name, columns)| Column { name, columns })
            .to_vec()
    }

    fn copy(&self, name: &str, rows: &mut [f64]) {
        let system = self.simulation.system();
        match name {
            "positions" => {
                let middle = system.space().point(&[0.5; D]);
                for (row, place) in rows.chunks_exact_mut(D.max(2)).zip(system.positions()) {
                    row.fill(0.0);
                    for axis in 0..D {
                        row[axis] = place[axis] - middle[axis];
                    }
                }
            }
            "orientations" => {
                for (row, rotation) in rows.chunks_exact_mut(4).zip(system.rotations()) {
                    let [x, y, z, w] = rotation.coords.into();
                    row.copy_from_slice(&[w, x, y, z]);
                }
            }
            _ => {}
        }
    }

    fn space(&self) -> [f64; 6] {
        let space = self.simulation.system().space();
        let mut numbers = [0.0; 6];
        numbers[..D].copy_from_slice(space.lengths());
        let tilts = space.tilt_factors();
        numbers[3..3 + tilts.len()].copy_from_slice(&tilts);
        numbers
    }

    fn place(&mut self, arrays: Arrays) -> Result<()> {
        // Steps, counts and the number of sweeps stay: the same simulation goes on from other places.
        let all = replaced(self, arrays)?;
        let given = given_arrays(all, D.max(2))?;
        let placed = of_file(&given, &self.settings, self.simulation.system().kinds())?.placed;
        let (settings, simulation) = begin(self.settings.clone(), &self.mixture, placed)?;
        let moved = simulation.state();
        let state = State {
            lengths: moved.lengths,
            tilt_factors: moved.tilt_factors,
            positions: moved.positions,
            orientations_wxyz: moved.orientations_wxyz,
            ..self.simulation.state()
        };
        self.simulation = self.resume(&settings, &state)?;
        self.settings = settings;
        Ok(())
    }

    fn settings(&self) -> Result<Value> {
        Ok(serde_json::to_value(&self.settings)?)
    }

    fn change(&mut self, settings: &Value) -> Result<()> {
        let changed: HardBodySettings = changed(&self.settings, settings)?;
        let bodies = |settings: &HardBodySettings| {
            (
                settings.shape.clone(),
                settings.share.clone(),
                (settings.rounding_radius, settings.spread),
                settings.bodies,
                settings.start.clone(),
            )
        };
        if bodies(&changed) != bodies(&self.settings)
            || changed.packing_fraction != self.settings.packing_fraction
        {
            bail!(
                "shape, rounding_radius, bodies, packing_fraction and start make other bodies; begin another simulation, or place \
                 these elsewhere"
            );
        }
        if changed.gravity.is_some() != self.settings.gravity.is_some() {
            bail!("walls come and go with gravity; begin another simulation");
        }
        changed.check()?;
        self.simulation = self.resume(&changed, &self.simulation.state())?;
        self.settings = changed;
        Ok(())
    }

    fn measure(&mut self) -> Vec<(&'static str, String)> {
        measure(&mut self.simulation, &self.settings).named()
    }

    fn save(&self) -> Result<Vec<u8>> {
        let saved = (&self.settings, self.simulation.state());
        Ok(serde_json::to_vec(&saved)?)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<()> {
        let (settings, state): (HardBodySettings, State) = restored(saved, "hard bodies")?;
        let bodies = |settings: &HardBodySettings| {
            (
                settings.shape.clone(),
                settings.rounding_radius,
                settings.bodies,
            )
        };
        if bodies(&settings) != bodies(&self.settings) || state.positions.len() != D * self.count()
        {
            bail!("the saved state is of other bodies; restore one of this simulation");
        }
        self.simulation = self.resume(&settings, &state)?;
        self.settings = settings;
        Ok(())
    }

    fn header(&self) -> Result<Vec<Chunk>> {
        header(self.simulation.system())
    }

    fn frame(&self) -> Vec<Chunk> {
        frame(self.done(), self.simulation.system())
    }
}
