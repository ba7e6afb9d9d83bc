//! The averages at a single salt concentration.

use crate::stability::run::columns::{Column, Statistics};
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
    let mut add = |label: &str, value: &dyn Fn(&ReplicaResult) -> Option<Average>| {
        let mut row = vec![label.to_owned()];
        row.extend(groups.iter().map(|(_, replicas)| average(replicas, value)));
        rows.push(row);
    };
    for column in Column::all() {
        // A mean alone tells of the method, not of the assembly.
        if column.statistics != Statistics::Mean {
            add(column.title, &|replica| {
                replica.averages.get(column).map(of_series)
            });
        }
    }
    add("accepted translations", &|replica| {
        Some([replica.accepted.translation_acceptance, f64::NAN])
    });
    add("accepted rotations", &|replica| {
        Some([replica.accepted.rotation_acceptance, f64::NAN])
    });
    Part::Table { columns, rows }
}

/// A mean of a replica, and its standard error; NaN without one.
type Average = [f64; 2];

fn of_series(summary: Summary) -> Average {
    [summary.mean, summary.standard_error]
}

/// The mean over replicas with its standard error, from the errors of the replicas.
fn average(
    replicas: &[&ReplicaResult],
    value: &dyn Fn(&ReplicaResult) -> Option<Average>,
) -> String {
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
