//! `log.csv` of a simulation: one row of observables at regular intervals of production.

protomer_results::log_row! {
    /// One row of the log.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LogRow {
        /// Production sweeps done.
        pub sweep: u64,
        /// Radius of gyration of the body positions, Å.
        pub r_g_angstrom: f64,
        /// Fraction of the native contacts, those of the assembly, that are left; NaN if it has none.
        pub native_contacts: f64,
        /// Bodies in the largest cluster.
        pub largest_cluster: usize,
        /// Total energy, kT.
        pub energy_kt("energy_kT"): f64,
        /// Mean number of bodies moved by a cluster move since the last row.
        pub cluster_moved: f64,
        /// Pairs of bodies in contact; NaN in logs of earlier versions.
        pub contacts: f64 = f64::NAN,
        /// Fraction of the bodies that touch another; NaN in logs of earlier versions.
        pub bound_fraction: f64 = f64::NAN,
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
    use protomer_results::Row;

    #[test]
    fn rows_survive_a_round_trip() {
        let row = LogRow {
            sweep: 3,
            r_g_angstrom: 1.0 / 3.0,
            native_contacts: 0.1 + 0.2,
            largest_cluster: 3,
            energy_kt: -1e-17,
            cluster_moved: 0.0,
            contacts: 4.0,
            bound_fraction: 2.0 / 3.0,
        };
        assert_eq!(LogRow::from_cells(&row.to_cells()), Some(row));
        assert_eq!(row.to_cells().len(), LogRow::columns().len());
        let cells = |number: usize| vec!["6".to_owned(); number];
        for number in [3, 7, 9] {
            assert_eq!(LogRow::from_cells(&cells(number)), None);
        }
        let earlier = LogRow::from_cells(&cells(6)).unwrap();
        assert!(earlier.bound_fraction.is_nan() && earlier.cluster_moved == 6.0);
        let without_contacts = LogRow {
            native_contacts: f64::NAN,
            ..row
        };
        let read = LogRow::from_cells(&without_contacts.to_cells()).unwrap();
        assert!(read.native_contacts.is_nan());
    }
}
