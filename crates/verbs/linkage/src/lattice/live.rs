//! A lattice in memory, for loops of one's own.

use super::given_state::GivenState;
use super::log::LogRow;
use super::settings::LatticeSettings;
use super::start::{Begun, begin, begin_from, time_step};
use super::trajectory::{frame, header};
use anyhow::{Result, bail};
use protomer_common::live::{Arrays, Column, Live, changed, refuse_others, restored, take};
use protomer_io::gsd::Chunk;
use protomer_linkage::lattice::paper::PaperStatistics;
use protomer_linkage::lattice::{Cell, Mover, State};
use protomer_results::Row;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::sync::Arc;

/// Arrays of the state and their columns.
const COLUMNS: [Column; 4] = [
    column("positions", 2),
    column("angles", 1),
    column("velocities", 2),
    column("spins", 1),
];

const fn column(name: &'static str, columns: usize) -> Column {
    Column { name, columns }
}

/// A lattice in memory. It begins as `lattice run` begins it, or where the arrays have it: `positions` of the squares,
/// `angles`, and if there are any `velocities` and `spins`, the rates of the angles; otherwise the velocities are those of the settings.
///
/// ```
/// use protomer_linkage_verbs::lattice::live::lattice;
/// let settings = serde_json::json!({ "rows": 3, "columns": 3, "time_step": 0.01 });
/// let mut squares = lattice(&settings, None)?;
/// squares.advance(100)?;
/// let mut angles = [0.0; 9];
/// squares.copy("angles", &mut angles);
/// assert!(angles[0] < std::f64::consts::FRAC_PI_4, "the open lattice closes");
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// As for a run with these settings; also for arrays that do not fit, squares that are off their rods, and squares that
/// overlap.
pub fn lattice(settings: &Value, arrays: Option<Arrays>) -> Result<Box<dyn Live>> {
    let settings: LatticeSettings = changed(&LatticeSettings::default(), settings)?;
    if settings.sweep.is_some() {
        bail!("the settings have a [sweep]; a simulation is one run, so remove it");
    }
    let begun = match arrays {
        None => begin(&settings)?,
        Some(arrays) => begin_from(&settings, &given(arrays)?)?,
    };
    Ok(Box::new(LiveLattice::new(settings, begun)?))
}

/// The state of arrays.
fn given(mut arrays: Arrays) -> Result<GivenState> {
    arrays.remove("box");
    let Some(places) = take(&mut arrays, COLUMNS[0], None)? else {
        bail!("there are no positions; give a row with x and y for each square");
    };
    let count = places.len() / 2;
    let mut taken = |column: Column| take(&mut arrays, column, Some(count));
    let (angles, velocities, spins) = (taken(COLUMNS[1])?, taken(COLUMNS[2])?, taken(COLUMNS[3])?);
    refuse_others(&arrays, &COLUMNS)?;
    let Some(angles) = angles else {
        bail!("there are no angles; give one for each square, in radians");
    };
    let has_velocities = velocities.is_some() || spins.is_some();
    let velocities = joined(
        &velocities.unwrap_or_else(|| vec![0.0; 2 * count]),
        &spins.unwrap_or_else(|| vec![0.0; count]),
    );
    Ok(GivenState {
        origin: "the arrays".into(),
        positions: joined(&places, &angles),
        velocities: has_velocities.then_some(velocities),
    })
}

/// x, y and the angle of each square in one array.
fn joined(places: &[f64], angles: &[f64]) -> Vec<f64> {
    let rows = places.chunks_exact(2).zip(angles);
    rows.flat_map(|(place, angle)| [place[0], place[1], *angle])
        .collect()
}

struct LiveLattice {
    settings: LatticeSettings,
    begun: Begun,
    mover: Mover,
    state: State,
    /// Energy of the state.
    energy: f64,
    steps: u64,
    clock: Clock,
}

/// Time as a function of the steps: multiplied, not accumulated, as in a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Clock {
    time_step: f64,
    first_step: u64,
    first_time: f64,
}

impl Clock {
    fn time(&self, steps: u64) -> f64 {
        self.first_time + (steps - self.first_step) as f64 * self.time_step
    }
}

/// Everything that changes during a simulation.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    settings: LatticeSettings,
    state: State,
    steps: u64,
    events: u64,
    clock: Clock,
    paper: Option<PaperStatistics>,
}

impl LiveLattice {
    fn new(settings: LatticeSettings, begun: Begun) -> Result<Self> {
        let clock = Clock {
            time_step: time_step(&settings, &begun)?,
            first_step: 0,
            first_time: 0.0,
        };
        let mut mover = mover(&settings, &begun)?;
        Ok(Self {
            energy: mover.energy(&begun.state),
            mover,
            state: begun.state.clone(),
            settings,
            begun,
            steps: 0,
            clock,
        })
    }

    fn row(&mut self) -> LogRow {
        let start = &self.begun.state.positions;
        LogRow::new(self.steps, &mut self.mover, &self.state, start, start)
    }
}

fn mover(settings: &LatticeSettings, begun: &Begun) -> Result<Mover> {
    let network = Arc::new(begun.network.clone());
    Ok(Mover::new(&settings.motion()?, network, &begun.state)?)
}

impl Live for LiveLattice {
    fn count(&self) -> usize {
        self.begun.network.squares.len()
    }

    fn done(&self) -> u64 {
        self.steps
    }

    fn advance(&mut self, count: u64) -> Result<()> {
        self.mover.prepare(&self.state)?;
        for _ in 0..count {
            let before = self.state.clone();
            let step = self
                .mover
                .step(&mut self.state, self.clock.time_step, self.steps);
            if let Err(error) = step {
                self.state = before;
                return Err(error.into());
            }
            self.steps += 1;
            self.state.time = self.clock.time(self.steps);
        }
        self.energy = self.mover.energy(&self.state);
        Ok(())
    }

    fn arrays(&self) -> Vec<Column> {
        COLUMNS.to_vec()
    }

    fn copy(&self, name: &str, rows: &mut [f64]) {
        let (numbers, columns) = match name {
            "positions" => (&self.state.positions, 0..2),
            "angles" => (&self.state.positions, 2..3),
            "velocities" => (&self.state.velocities, 0..2),
            "spins" => (&self.state.velocities, 2..3),
            _ => return,
        };
        let squares = numbers.chunks_exact(3);
        for (row, square) in rows.chunks_exact_mut(columns.len()).zip(squares) {
            row.copy_from_slice(&square[columns.clone()]);
        }
    }

    fn space(&self) -> [f64; 6] {
        if self.begun.network.cell.is_none() {
            return [0.0; 6];
        }
        let cell = Cell::read(&self.begun.network, &self.state.positions);
        [cell.xx, cell.yy, 0.0, cell.xy / cell.yy, 0.0, 0.0]
    }

    fn place(&mut self, mut arrays: Arrays) -> Result<()> {
        for Column { name, columns } in COLUMNS {
            if !arrays.contains_key(name) {
                let mut values = vec![0.0; columns * self.count()];
                self.copy(name, &mut values);
                let rows = protomer_common::live::Rows { columns, values };
                arrays.insert(name.to_owned(), rows);
            }
        }
        let mut given = given(arrays)?;
        // The arrays are of squares: a flexible cell stays as it is.
        let squares = 3 * self.count();
        given
            .positions
            .extend_from_slice(&self.state.positions[squares..]);
        if let Some(velocities) = &mut given.velocities {
            velocities.extend_from_slice(&self.state.velocities[squares..]);
        }
        let started = given.on_rods(&self.begun.network, &self.settings)?;
        let state = State {
            time: self.state.time,
            ..started.state
        };
        // Loads refer to the lattice at its start, so the mover is that of the start.
        let mut mover = mover(&self.settings, &self.begun)?;
        mover.resume(&state, self.mover.events(), self.mover.paper_statistics())?;
        self.energy = mover.energy(&state);
        (self.state, self.mover) = (state, mover);
        Ok(())
    }

    fn settings(&self) -> Result<Value> {
        Ok(serde_json::to_value(&self.settings)?)
    }

    fn change(&mut self, settings: &Value) -> Result<()> {
        let changed: LatticeSettings = changed(&self.settings, settings)?;
        if changed.plan() != self.settings.plan() || changed.state != self.settings.state {
            bail!(
                "squares, rods, edges and their start are those of another lattice; begin another simulation, or place these squares \
                 elsewhere"
            );
        }
        changed.check()?;
        let mut mover = mover(&changed, &self.begun)?;
        mover.resume(&self.state, self.mover.events(), None)?;
        self.energy = mover.energy(&self.state);
        if changed.time_step != self.settings.time_step {
            self.clock = Clock {
                time_step: time_step(&changed, &self.begun)?,
                first_step: self.steps,
                first_time: self.state.time,
            };
        }
        (self.settings, self.mover) = (changed, mover);
        Ok(())
    }

    fn measure(&mut self) -> Vec<(&'static str, String)> {
        self.row().named()
    }

    fn save(&self) -> Result<Vec<u8>> {
        Ok(serde_json::to_vec(&Saved {
            settings: self.settings.clone(),
            state: self.state.clone(),
            steps: self.steps,
            events: self.mover.events(),
            clock: self.clock,
            paper: self.mover.paper_statistics(),
        })?)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<()> {
        let saved: Saved = restored(saved, "a lattice")?;
        if saved.settings.plan() != self.settings.plan() {
            bail!("the saved state is of another lattice; restore one of this simulation");
        }
        saved.state.check(&self.begun.network)?;
        let mut mover = mover(&saved.settings, &self.begun)?;
        mover.resume(&saved.state, saved.events, saved.paper)?;
        *self = Self {
            energy: mover.energy(&saved.state),
            settings: saved.settings,
            begun: self.begun.clone(),
            mover,
            state: saved.state,
            steps: saved.steps,
            clock: saved.clock,
        };
        Ok(())
    }

    fn header(&self) -> Result<Vec<Chunk>> {
        header(&self.begun.network)
    }

    fn frame(&self) -> Vec<Chunk> {
        frame(self.steps, &self.begun.network, &self.state, self.energy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::run::run_lattice;
    use protomer_common::live::Rows;
    use protomer_results::Execution;
    use serde_json::json;

    fn settings() -> LatticeSettings {
        LatticeSettings {
            rows: 4,
            columns: 4,
            r0: 0.5,
            steps: Some(400),
            trajectory_every: 100,
            velocity_spread: 0.3,
            ..LatticeSettings::default()
        }
    }

    fn begun_as(settings: &LatticeSettings) -> Box<dyn Live> {
        lattice(&serde_json::to_value(settings).unwrap(), None).unwrap()
    }

    fn copied(squares: &dyn Live, name: &str) -> Vec<f64> {
        let column = COLUMNS.into_iter().find(|column| column.name == name);
        let mut values = vec![0.0; column.unwrap().columns * squares.count()];
        squares.copy(name, &mut values);
        values
    }

    /// The slow twin is the run in a directory: its last state to the last bit.
    #[test]
    fn a_loop_gives_the_state_of_a_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        run_lattice(&settings(), &path, &Execution::default()).unwrap();
        let mut squares = begun_as(&settings());
        for count in [1, 99, 300] {
            squares.advance(count).unwrap();
        }
        let run = crate::lattice::run::saved_state(&path).unwrap();
        let places = copied(&*squares, "positions");
        let angles = copied(&*squares, "angles");
        assert_eq!(joined(&places, &angles), run.positions);
        let velocities = copied(&*squares, "velocities");
        assert_eq!(
            joined(&velocities, &copied(&*squares, "spins")),
            run.velocities
        );
    }

    #[test]
    fn a_run_starts_from_another_run_and_from_its_trajectory() {
        let folder = tempfile::tempdir().unwrap();
        let (first, next) = (folder.path().join("first"), folder.path().join("next"));
        let before = run_lattice(&settings(), &first, &Execution::default()).unwrap();
        let energy = before.finished().unwrap().energy;
        let on = |start: &std::path::Path, frame| LatticeSettings {
            state: Some(start.display().to_string()),
            frame,
            ..settings()
        };
        let after = run_lattice(&on(&first, None), &next, &Execution::default()).unwrap();
        let after = after.finished().unwrap();
        assert!((after.start_energy / energy - 1.0).abs() < 1e-12);
        let trajectory = first.join("trajectory.gsd");
        let begun = begin(&on(&trajectory, None)).unwrap();
        let exact = crate::lattice::run::saved_state(&first).unwrap();
        let off = begun.state.positions.iter().zip(&exact.positions);
        assert!(off.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) < 1e-9);
        let complaint = |settings: &LatticeSettings| format!("{:#}", begin(settings).unwrap_err());
        let other_rods = LatticeSettings {
            r0: 0.7,
            ..on(&trajectory, None)
        };
        assert!(
            complaint(&other_rods).contains("off their rods"),
            "{}",
            complaint(&other_rods)
        );
        let fewer = LatticeSettings {
            rows: 3,
            ..on(&trajectory, None)
        };
        assert!(complaint(&fewer).contains("has 16 squares"));
        assert!(complaint(&on(&first, Some(1))).contains("--frame is for a GSD file"));
        assert!(complaint(&on(&trajectory, Some(70))).contains("70"));
    }

    #[test]
    fn a_saved_lattice_goes_on_bit_for_bit_and_squares_can_be_placed() {
        let mut squares = begun_as(&settings());
        squares.advance(150).unwrap();
        let saved = squares.save().unwrap();
        squares.advance(200).unwrap();
        let end = copied(&*squares, "positions");
        squares.restore(&saved).unwrap();
        assert_eq!(squares.done(), 150);
        squares.advance(200).unwrap();
        assert_eq!(copied(&*squares, "positions"), end);
        // At rest nothing moves.
        let rest = |columns: usize| Rows {
            columns,
            values: vec![0.0; columns * 16],
        };
        let still = Arrays::from([
            ("velocities".to_owned(), rest(2)),
            ("spins".to_owned(), rest(1)),
        ]);
        squares.place(still).unwrap();
        let before = copied(&*squares, "positions");
        squares.advance(10).unwrap();
        let moved = before.iter().zip(copied(&*squares, "positions"));
        assert!(moved.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) < 1e-12);
        let apart = Arrays::from([("positions".to_owned(), rest(2))]);
        assert!(squares.place(apart).is_err());
        squares.change(&json!({ "kappa": 0.5 })).unwrap();
        assert!(squares.change(&json!({ "rows": 5 })).is_err());
        assert!(squares.change(&json!({ "kapa": 0.5 })).is_err());
    }
}
