//! The columns of `log.csv`, each declared once: the log, the averages of replicas and salts with their
//! tables, the figures, the page and Python follow.

use protomer_kernel::statistics::Summary;
use protomer_mc::observables::Observables;
use serde::de::Error;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value, from_value, json};

/// State of a simulation when a row is logged.
pub struct Measured {
    /// Observables of the state.
    pub observables: Observables,
    /// Mean number of bodies moved by a cluster move since the last row.
    pub cluster_moved: f64,
}

/// A column of the log.
#[derive(Debug)]
pub struct Column {
    /// Name in the log, with the unit.
    pub name: &'static str,
    /// Unit at the end of the name; empty for a number.
    unit: &'static str,
    /// Label of axes and tables, with the unit.
    pub title: &'static str,
    /// Value in a state.
    pub value: fn(&Measured) -> f64,
    /// Whether logs of earlier versions lack the column.
    pub is_later: bool,
    /// Statistics over replicas in the table of a sweep.
    pub statistics: Statistics,
    /// Figures that draw the column.
    pub drawn: Drawn,
    /// Ends of its axis; `None` to fit the data.
    pub range: Option<[f64; 2]>,
}

/// Statistics of a column over replicas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Statistics {
    /// The mean alone, as for what tells of the method.
    Mean,
    /// Mean and standard deviation.
    Deviation,
    /// Mean, standard deviation and standard error.
    Error,
}

/// Figures that draw a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawn {
    /// No figure.
    Nowhere,
    /// The course of a simulation.
    AgainstSweeps,
    /// The course of a simulation, and the curve of a sweep.
    AgainstSalt,
}

/// Ends of the axis of a fraction.
pub const FRACTION: Option<[f64; 2]> = Some([0.0, 1.05]);

macro_rules! columns {
    ($($(#[$text:meta])* $field:ident = $column:expr;)*) => {
        /// A value for each column of the log: numbers of a row, averages of a replica, or averages of
        /// a salt.
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct Columns<T> {
            $($(#[$text])* pub $field: T,)*
        }

        impl<T> Columns<T> {
            /// Values by column, in the order of the log.
            pub fn new(mut value: impl FnMut(&'static Column) -> T) -> Self {
                Self { $($field: value(const { &$column }),)* }
            }

            /// Columns with their values, in the order of the log.
            pub fn entries(&self) -> Vec<(&'static Column, &T)> {
                vec![$((const { &$column }, &self.$field),)*]
            }
        }

        impl<T: Copy> Columns<T> {
            /// Value of one of [`Column::all`].
            pub fn get(&self, column: &Column) -> T {
                let [mut value, ..] = [$(self.$field),*];
                for (other, there) in self.entries() {
                    if other.name == column.name {
                        value = *there;
                    }
                }
                value
            }
        }
    };
}

columns! {
    /// Radius of gyration of the body positions, Å.
    r_g_angstrom = Column {
        unit: "angstrom",
        statistics: Statistics::Error,
        drawn: Drawn::AgainstSalt,
        ..Column::new("r_g_angstrom", "radius of gyration (Å)", |state| state.observables.r_g_angstrom)
    };
    /// Fraction of the native contacts, those of the assembly, that are left; NaN if it has none.
    native_contacts = Column {
        drawn: Drawn::AgainstSweeps,
        range: FRACTION,
        ..Column::new("native_contacts", "native contacts left", |state| {
            state.observables.native_contacts.unwrap_or(f64::NAN)
        })
    };
    /// Bodies in the largest cluster.
    largest_cluster = Column::new("largest_cluster", "bodies in the largest cluster", |state| {
        state.observables.largest_cluster as f64
    });
    /// Total energy, kT.
    energy_kt = Column {
        unit: "kT",
        drawn: Drawn::AgainstSweeps,
        ..Column::new("energy_kT", "energy (kT)", |state| state.observables.energy_kt)
    };
    /// Mean number of bodies moved by a cluster move since the last row.
    cluster_moved = Column {
        statistics: Statistics::Mean,
        ..Column::new("cluster_moved", "bodies moved by a cluster move", |state| state.cluster_moved)
    };
    /// Pairs of bodies in contact; NaN in logs of earlier versions.
    contacts = Column {
        is_later: true,
        drawn: Drawn::AgainstSweeps,
        ..Column::new("contacts", "pairs of bodies in contact", |state| state.observables.contacts as f64)
    };
    /// Fraction of the bodies that touch another; NaN in logs of earlier versions.
    bound_fraction = Column {
        is_later: true,
        drawn: Drawn::AgainstSweeps,
        range: FRACTION,
        ..Column::new("bound_fraction", "bodies that touch another", |state| state.observables.bound_fraction)
    };
}

impl Column {
    /// A column without unit that no figure draws.
    const fn new(name: &'static str, title: &'static str, value: fn(&Measured) -> f64) -> Self {
        Self {
            name,
            unit: "",
            title,
            value,
            is_later: false,
            statistics: Statistics::Deviation,
            drawn: Drawn::Nowhere,
            range: None,
        }
    }

    /// All columns, in the order of the log.
    pub fn all() -> Vec<&'static Self> {
        let mut all = Vec::new();
        Columns::new(|column| all.push(column));
        all
    }

    /// Name without the unit.
    pub fn quantity(&self) -> &'static str {
        match self.unit {
            "" => self.name,
            unit => self.name.trim_end_matches(unit).trim_end_matches('_'),
        }
    }

    /// Name, quantity, title, and the names of its statistics in the table of a sweep, null for those
    /// that the table lacks.
    pub fn description(&self) -> Value {
        let has_deviation = self.statistics != Statistics::Mean;
        let has_error = self.statistics == Statistics::Error;
        json!({
            "name": self.name,
            "quantity": self.quantity(),
            "title": self.title,
            "mean": self.named("mean"),
            "deviation": has_deviation.then(|| self.named("sd")),
            "error": has_error.then(|| self.named("se")),
        })
    }

    /// Name of a statistic in the table of a sweep, such as `r_g_mean_angstrom`.
    pub fn named(&self, statistic: &str) -> String {
        match self.unit {
            "" => format!("{}_{statistic}", self.quantity()),
            unit => format!("{}_{statistic}_{unit}", self.quantity()),
        }
    }
}

/// Average of a column over the replicas at a salt concentration; NaN without values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Mean of the means of the replicas.
    pub mean: f64,
    /// Standard deviation over replicas.
    pub deviation: f64,
    /// Standard error of the mean from the correlated series.
    pub error: f64,
}

impl Columns<Spread> {
    /// The names and numbers of the table of a sweep.
    pub fn cells(&self) -> Vec<(String, f64)> {
        let mut cells = Vec::new();
        for (column, spread) in self.entries() {
            cells.push((column.named("mean"), spread.mean));
            if column.statistics != Statistics::Mean {
                cells.push((column.named("sd"), spread.deviation));
            }
            if column.statistics == Statistics::Error {
                cells.push((column.named("se"), spread.error));
            }
        }
        cells
    }
}

impl Serialize for Columns<Spread> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, number) in self.cells() {
            map.serialize_entry(&name, &number)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Columns<Spread> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let map = Map::<String, Value>::deserialize(deserializer)?;
        // JSON has neither NaN nor infinities, and results of earlier versions lack later columns.
        let number = |column: &Column, statistic, none| {
            let value = map.get(&column.named(statistic));
            value.and_then(Value::as_f64).unwrap_or(none)
        };
        Ok(Self::new(|column| Spread {
            mean: number(column, "mean", f64::NAN),
            deviation: number(column, "sd", f64::NAN),
            error: number(column, "se", f64::INFINITY),
        }))
    }
}

impl Serialize for Columns<Option<Summary>> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (column, summary) in self.entries() {
            match (column.statistics, summary) {
                (Statistics::Mean, _) => {
                    let mean = summary.map(|summary| summary.mean);
                    map.serialize_entry(&column.named("mean"), &mean)?;
                }
                (_, None) if column.is_later => {}
                _ => map.serialize_entry(column.name, summary)?,
            }
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Columns<Option<Summary>> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut map = Map::<String, Value>::deserialize(deserializer)?;
        let mut damaged = None;
        let columns = Self::new(|column| {
            if column.statistics == Statistics::Mean {
                let mean = map.get(&column.named("mean")).and_then(Value::as_f64)?;
                return Some(mean_alone(mean));
            }
            let value = map.remove(column.name)?;
            from_value(value).unwrap_or_else(|error| {
                damaged = Some(format!("{}: {error}", column.name));
                None
            })
        });
        match damaged {
            Some(problem) => Err(D::Error::custom(problem)),
            None => Ok(columns),
        }
    }
}

/// The average of which a result has kept only the mean.
fn mean_alone(mean: f64) -> Summary {
    Summary {
        mean,
        standard_deviation: f64::NAN,
        standard_error: f64::INFINITY,
        autocorrelation_time: f64::NAN,
        effective_samples: f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_statistics_end_in_the_unit() {
        let named: Vec<String> = Columns::new(|_| mean_alone(1.0))
            .entries()
            .into_iter()
            .map(|(column, _)| column.named("mean"))
            .collect();
        let first = ["r_g_mean_angstrom", "native_contacts_mean"];
        assert_eq!(named[..2], first);
        assert_eq!(named[3..5], ["energy_mean_kT", "cluster_moved_mean"]);
        assert_eq!(Column::all()[3].quantity(), "energy");
    }

    #[test]
    fn averages_are_read_back_and_later_columns_may_be_absent() {
        let averages = Columns::new(|column| match column.statistics {
            Statistics::Mean => Some(mean_alone(3.0)),
            _ => Some(protomer_kernel::statistics::summarize(&[
                1.0, 2.0, 4.0, 3.0,
            ])),
        });
        let mut json = serde_json::to_value(averages).unwrap();
        let read: Columns<Option<Summary>> = from_value(json.clone()).unwrap();
        assert_eq!(read.energy_kt, averages.energy_kt);
        assert_eq!(read.cluster_moved.unwrap().mean, 3.0);
        let object = json.as_object_mut().unwrap();
        object.remove("contacts");
        object["native_contacts"] = Value::Null;
        let read: Columns<Option<Summary>> = from_value(json.clone()).unwrap();
        assert_eq!((read.contacts, read.native_contacts), (None, None));
        let written = serde_json::to_value(read).unwrap();
        assert_eq!(
            written, json,
            "a later column is left out, an early one is null"
        );
        json["energy_kT"] = Value::Bool(true);
        let refusal = from_value::<Columns<Option<Summary>>>(json).unwrap_err();
        assert!(refusal.to_string().contains("energy_kT"), "{refusal}");
    }
}
