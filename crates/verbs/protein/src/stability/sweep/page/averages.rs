//! The averages at a single salt concentration.

use crate::stability::run::{RunSettings, Start, Starts};
use crate::stability::sweep::result::SweepResult;
use crate::stability::sweep::table::ReplicaResult;
use protomer_common::page::{Part, significant, significant_or_dash};
use protomer_kernel::statistics::Summary;

/// The results at a single salt concentration, those of each start apart.
pub fn averages(result: &SweepResult, settings: &RunSettings) -> Part {
    let replicas: Vec<(u32, &ReplicaResult)> = (0..)
        .zip(result.replicas.first().into_iter().flatten())
        .collect();
    // Starts that disagree have no common mean.
    let groups: Vec<(&str, Vec<&ReplicaResult>)> = match settings.starts {
        Starts::Both => [
            ("from the assembly", Start::Assembly),
            ("from a fluid", Start::Fluid),
        ]
        .map(|(name, start)| {
            let ours = replicas
                .iter()
                .filter(|(number, _)| settings.starts.of_replica(*number) == start);
            (name, ours.map(|(_, replica)| *replica).collect())
        })
        .into(),
        Starts::Assembly | Starts::Fluid => {
            let all = replicas.iter().map(|(_, replica)| *replica);
            vec![("average", all.collect())]
        }
    };
    let mut columns = vec![""];
    columns.extend(groups.iter().map(|(name, _)| *name));
    let mut rows = Vec::new();
    for (label, value) in AVERAGES {
        let mut row = vec![label.to_owned()];
        row.extend(groups.iter().map(|(_, replicas)| average(replicas, value)));
        rows.push(row);
    }
    Part::Table { columns, rows }
}

/// A mean of a replica, and its standard error; NaN without one.
type Average = [f64; 2];
/// Average of a quantity over a replica; `None` if the replica has none.
type AverageOfReplica = fn(&ReplicaResult) -> Option<Average>;

/// Names of the averaged quantities, with their values in the result of a replica.
const AVERAGES: [(&str, AverageOfReplica); 8] = [
    ("radius of gyration (Å)", |replica| {
        Some(of_series(replica.r_g_angstrom))
    }),
    ("native contacts left", |replica| {
        replica.native_contacts.map(of_series)
    }),
    ("pairs of bodies in contact", |replica| {
        replica.contacts.map(of_series)
    }),
    ("bodies that touch another", |replica| {
        replica.bound_fraction.map(of_series)
    }),
    ("bodies in the largest cluster", |replica| {
        Some(of_series(replica.largest_cluster))
    }),
    ("energy (kT)", |replica| Some(of_series(replica.energy_kt))),
    ("accepted translations", |replica| {
        Some([replica.accepted.translation_acceptance, f64::NAN])
    }),
    ("accepted rotations", |replica| {
        Some([replica.accepted.rotation_acceptance, f64::NAN])
    }),
];

fn of_series(summary: Summary) -> Average {
    [summary.mean, summary.standard_error]
}

/// The mean over replicas with its standard error, from the errors of the replicas.
fn average(replicas: &[&ReplicaResult], value: AverageOfReplica) -> String {
    let count = replicas.len() as f64;
    let (mut sum, mut squares) = (0.0, 0.0);
    for replica in replicas {
        // A replica of an earlier version may lack the value, and then there is no mean.
        let Some([mean, error]) = value(replica) else {
            return significant_or_dash(None, 0);
        };
        sum += mean;
        squares += error * error;
    }
    let mean = significant(sum / count, 5);
    match squares.sqrt() / count {
        error if error.is_finite() => format!("{mean} ± {}", significant(error, 2)),
        _ => mean,
    }
}
