//! `log.csv` of a simulation: one row of observables at regular intervals of production.

use super::columns::{Column, Columns, Measured};
use protomer_results::Row;
use protomer_results::log::Cell;

/// One row of the log.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LogRow {
    /// Production sweeps done.
    pub sweep: u64,
    /// Numbers of the state.
    pub numbers: Columns<f64>,
}

impl LogRow {
    /// The row of a state.
    pub fn new(sweep: u64, state: &Measured) -> Self {
        let numbers = Columns::new(|column| (column.value)(state));
        Self { sweep, numbers }
    }
}

impl Row for LogRow {
    fn columns() -> Vec<&'static str> {
        let names = Column::all().into_iter().map(|column| column.name);
        std::iter::once("sweep").chain(names).collect()
    }

    fn later_columns() -> Vec<&'static str> {
        let later = Column::all().into_iter().filter(|column| column.is_later);
        later.map(|column| column.name).collect()
    }

    fn to_cells(&self) -> Vec<String> {
        let numbers = self.numbers.entries().into_iter();
        let numbers = numbers.map(|(_, number)| number.write());
        std::iter::once(self.sweep.write()).chain(numbers).collect()
    }

    fn from_cells(cells: &[Option<&str>]) -> Option<Self> {
        let (sweep, cells) = cells.split_first()?;
        let mut numbers = Vec::with_capacity(cells.len());
        for cell in cells {
            numbers.push(cell.map_or(Some(f64::NAN), f64::read)?);
        }
        let mut numbers = numbers.into_iter();
        Some(Self {
            sweep: u64::read((*sweep)?)?,
            numbers: Columns::new(|_| numbers.next().unwrap_or(f64::NAN)),
        })
    }
}

protomer_results::log_row! {
    /// One row of `charges.csv`: net charges of the bodies of a run that changes protons.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ChargeRow {
        /// Production sweeps done.
        pub sweep: u64,
        /// Mean net charge of a body, e.
        pub mean_net_charge_e: f64,
        /// Lowest net charge of a body, e.
        pub lowest_net_charge_e: f64,
        /// Highest net charge of a body, e.
        pub highest_net_charge_e: f64,
    }
}

impl ChargeRow {
    /// The row of the net charges of all bodies, e.
    pub fn new(sweep: u64, charges_e: &[f64]) -> Self {
        Self {
            sweep,
            mean_net_charge_e: charges_e.iter().sum::<f64>() / charges_e.len() as f64,
            lowest_net_charge_e: charges_e.iter().copied().fold(f64::INFINITY, f64::min),
            highest_net_charge_e: charges_e.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_a_round_trip() {
        let row = LogRow {
            sweep: 3,
            numbers: Columns {
                r_g_angstrom: 1.0 / 3.0,
                native_contacts: 0.1 + 0.2,
                largest_cluster: 3.0,
                energy_kt: -1e-17,
                contacts: 4.0,
                ..Columns::default()
            },
        };
        let cells = row.to_cells();
        let mut read: Vec<Option<&str>> = cells.iter().map(|cell| Some(cell.as_str())).collect();
        assert_eq!(LogRow::from_cells(&read), Some(row));
        assert_eq!((cells[0].as_str(), cells[3].as_str()), ("3", "3"));
        assert_eq!(cells.len(), LogRow::columns().len());
        read[7] = None;
        let earlier = LogRow::from_cells(&read).unwrap();
        assert!(earlier.numbers.bound_fraction.is_nan() && earlier.numbers.contacts == 4.0);
        read[2] = Some("NaN");
        assert!(
            LogRow::from_cells(&read)
                .unwrap()
                .numbers
                .native_contacts
                .is_nan()
        );
        read[2] = Some("many");
        assert_eq!(LogRow::from_cells(&read), None);
    }
}
