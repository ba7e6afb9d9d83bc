//! Ten times longer: 10 000 frames of 10 x 10 at r0 = l (preprint, fig. 8).

use crate::common::{Failure, Settings, lattice, map, table, time_step};
use crate::ensemble::{
    COHERENCE_HEAD, STRAIN_HEAD, coherence_with_errors, difference_rows, record, strain_row,
    write_matrices,
};

/// Writes the tables.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let network = lattice(10, 1.0)?;
    let count = settings.random;
    let records = map(settings.jobs, count, |replica| {
        record(&network, 1000 + replica, 10_000, time_step(1.0))
    })?;
    let mut row = vec![count as f64];
    row.push(
        records
            .iter()
            .map(|record| record.impacts[0] as f64)
            .sum::<f64>()
            / count as f64,
    );
    row.push(
        records
            .iter()
            .map(|record| record.energies.len() as f64)
            .sum::<f64>()
            / count as f64,
    );
    row.extend(strain_row(&records)?);
    row.extend(coherence_with_errors(&network, &records)?);
    table(
        settings,
        "long",
        &format!("trajectories,impacts,frames,{STRAIN_HEAD},{COHERENCE_HEAD}"),
        &[row],
    )?;
    let head = "r0,time,staggered,staggered_error,plain,plain_error";
    table(
        settings,
        "long_differences",
        head,
        &difference_rows(1.0, &records),
    )?;
    let cloud: Vec<Vec<f64>> = records
        .iter()
        .flat_map(|record| {
            record
                .strains
                .iter()
                .step_by(40)
                .map(|[x, y]| vec![1.0, *x, *y])
        })
        .collect();
    table(settings, "long_strains", "r0,xx,yy", &cloud)?;
    write_matrices(settings, "long_synchronisation", &network, &records)
}
