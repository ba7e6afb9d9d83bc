//! `log.csv`: energies, temperatures and pressure of a run at regular steps.

use protomer_md::engine::Engine;
use protomer_results::Row;

/// One row of the log. Reduced units, energies per body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LogRow {
    /// Steps since the preparation; below zero during it.
    pub step: i64,
    /// Time since the preparation; below zero during it.
    pub time: f64,
    /// Energy of the repulsion.
    pub potential_energy: f64,
    /// Energy of the repulsion and the motion.
    pub energy: f64,
    /// The energy without the heat of the bath.
    pub kept_energy: f64,
    /// kT of all motion.
    pub temperature: f64,
    /// kT of the centres.
    pub translational_temperature: f64,
    /// kT of the rotations.
    pub rotational_temperature: f64,
    /// Pressure.
    pub pressure: f64,
    /// Part of the space that bodies with their layer fill.
    pub packing_fraction: f64,
}

/// A column: its name and its value in a row.
type Column = (
    &'static str,
    fn(&LogRow) -> f64,
    fn(&mut LogRow) -> &mut f64,
);

macro_rules! columns {
    ($($name:ident),*) => { [$((stringify!($name), |row| row.$name, |row| &mut row.$name)),*] };
}

/// The columns after `step`.
const NUMBERS: [Column; 9] = columns![
    time,
    potential_energy,
    energy,
    kept_energy,
    temperature,
    translational_temperature,
    rotational_temperature,
    pressure,
    packing_fraction
];

impl LogRow {
    /// The row of a state.
    pub fn new(step: i64, time: f64, engine: &Engine, volume_with_layer: f64) -> Self {
        let bodies = engine.bodies();
        let count = bodies.count() as f64;
        let [
            temperature,
            translational_temperature,
            rotational_temperature,
        ] = engine.temperatures();
        let volume = engine.motion().state.volume(bodies.dimension());
        Self {
            step,
            time,
            potential_energy: engine.motion().potential_energy / count,
            energy: engine.energy() / count,
            kept_energy: engine.kept_energy() / count,
            temperature,
            translational_temperature,
            rotational_temperature,
            pressure: engine.pressure(),
            packing_fraction: count * volume_with_layer / volume,
        }
    }
}

impl Row for LogRow {
    fn columns() -> Vec<&'static str> {
        let numbers = NUMBERS.iter().map(|(name, ..)| *name);
        std::iter::once("step").chain(numbers).collect()
    }

    fn to_cells(&self) -> Vec<String> {
        let mut cells = vec![self.step.to_string()];
        for (_, number, _) in NUMBERS {
            cells.push(number(self).to_string());
        }
        cells
    }

    fn from_cells(cells: &[String]) -> Option<Self> {
        let (step, numbers) = cells.split_first()?;
        let mut row = Self {
            step: step.parse().ok()?,
            ..Self::default()
        };
        for ((_, _, place), number) in NUMBERS.iter().zip(numbers) {
            *place(&mut row) = number.parse().ok()?;
        }
        (numbers.len() == NUMBERS.len()).then_some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_a_round_trip() {
        let row = LogRow {
            step: -3,
            time: 0.1 + 0.2,
            pressure: 1.0 / 3.0,
            ..LogRow::default()
        };
        assert_eq!(LogRow::from_cells(&row.to_cells()), Some(row));
        assert_eq!(row.to_cells().len(), LogRow::columns().len());
        assert_eq!(LogRow::from_cells(&["1", "2"].map(String::from)), None);
    }
}
