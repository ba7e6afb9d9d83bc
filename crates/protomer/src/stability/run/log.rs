//! `log.csv` of a simulation: one row of observables at regular intervals of production.

use protomer_results::Row;

/// One row of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRow {
    /// Production sweeps done.
    pub sweep: u64,
    /// Radius of gyration of the body positions, Å.
    pub r_g_angstrom: f64,
    /// Fraction of the initial contacts that persist; NaN if there were none initially.
    pub native_contacts: f64,
    /// Bodies in the largest cluster.
    pub largest_cluster: usize,
    /// Total energy, kT.
    pub energy_kt: f64,
    /// Mean number of bodies moved by a cluster move since the last row.
    pub cluster_moved: f64,
}

impl Row for LogRow {
    fn columns() -> Vec<&'static str> {
        vec![
            "sweep",
            "r_g_angstrom",
            "native_contacts",
            "largest_cluster",
            "energy_kT",
            "cluster_moved",
        ]
    }

    // Rust prints the shortest decimal that reads back as the same number, so no precision is lost.
    fn to_line(&self) -> String {
        format!(
            "{},{},{},{},{},{}",
            self.sweep,
            self.r_g_angstrom,
            self.native_contacts,
            self.largest_cluster,
            self.energy_kt,
            self.cluster_moved
        )
    }

    fn from_line(line: &str) -> Option<Self> {
        let mut cells = line.split(',');
        let row = Self {
            sweep: cells.next()?.parse().ok()?,
            r_g_angstrom: cells.next()?.parse().ok()?,
            native_contacts: cells.next()?.parse().ok()?,
            largest_cluster: cells.next()?.parse().ok()?,
            energy_kt: cells.next()?.parse().ok()?,
            cluster_moved: cells.next()?.parse().ok()?,
        };
        cells.next().is_none().then_some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_a_round_trip() {
        let row = LogRow {
            sweep: 3,
            r_g_angstrom: 1.0 / 3.0,
            native_contacts: 0.1 + 0.2,
            largest_cluster: 3,
            energy_kt: -1e-17,
            cluster_moved: 0.0,
        };
        assert_eq!(LogRow::from_line(&row.to_line()), Some(row));
        assert_eq!(row.to_line().split(',').count(), LogRow::columns().len());
        assert_eq!(LogRow::from_line("1,2,3"), None);
        let without_contacts = LogRow {
            native_contacts: f64::NAN,
            ..row
        };
        let read = LogRow::from_line(&without_contacts.to_line()).unwrap();
        assert!(read.native_contacts.is_nan());
    }
}
