//! Simulations in memory, which their caller advances, reads and changes as it likes.
//!
//! A run in a directory has a course that its settings fix. A [`Live`] simulation has none: it serves loops of one's
//! own.

use anyhow::{Context, Result, bail};
use protomer_io::gsd::Chunk;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;

/// Numbers in rows, one for each body.
///
/// ```
/// use protomer_common::live::Rows;
/// let positions = Rows { columns: 3, values: vec![0.0, 0.0, 0.0, 4.0, 0.0, 0.0] };
/// assert_eq!(positions.values.len() / positions.columns, 2, "two bodies");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Number of columns.
    pub columns: usize,
    /// The numbers, row by row.
    pub values: Vec<f64>,
}

/// Arrays by name, such as `positions` and `orientations`; `box` holds the edges of the box and, where it is tilted, its
/// tilt factors.
pub type Arrays = BTreeMap<String, Rows>;

/// Name of an array and the number of its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Name of the quantity.
    pub name: &'static str,
    /// Number of columns.
    pub columns: usize,
}

/// A simulation in memory. Its errors are those of the engine, with what to do about them.
pub trait Live: Send {
    /// Number of bodies.
    fn count(&self) -> usize;

    /// Number of steps or sweeps done.
    fn done(&self) -> u64;

    /// Moves of bodies between two looks for a request to stop. A fixed number, so that no result depends on time.
    fn moves_at_once(&self) -> u64 {
        50_000
    }

    /// Advances by so many steps or sweeps. What only makes the engine fast is forgotten first, so what follows depends
    /// on the state alone.
    ///
    /// # Errors
    /// As the engine.
    fn advance(&mut self, count: u64) -> Result<()>;

    /// Names of the arrays of the state.
    fn arrays(&self) -> Vec<Column>;

    /// Copies an array of the state into rows of its size; another name leaves them as they are.
    fn copy(&self, name: &str, rows: &mut [f64]);

    /// Edges of the box and its tilt factors: Lx, Ly, Lz, xy, xz, yz, with zeros for what it does not have.
    fn space(&self) -> [f64; 6];

    /// Puts the bodies elsewhere; what the arrays do not name stays.
    ///
    /// # Errors
    /// For arrays that do not fit, and bodies that overlap; the state is as before then.
    fn place(&mut self, arrays: Arrays) -> Result<()>;

    /// The settings as a JSON object.
    ///
    /// # Errors
    /// If they cannot be written.
    fn settings(&self) -> Result<Value>;

    /// Goes on with settings whose keys replace those of the simulation.
    ///
    /// # Errors
    /// For settings that cannot be, and for those that make other bodies; nothing has changed then.
    fn change(&mut self, settings: &Value) -> Result<()>;

    /// Measures the state: the row of the log of a run, by column.
    fn measure(&mut self) -> Vec<(&'static str, String)>;

    /// Everything that changes during a simulation, from which it goes on bit for bit.
    ///
    /// # Errors
    /// If the state cannot be written.
    fn save(&self) -> Result<Vec<u8>>;

    /// Goes back to a saved state.
    ///
    /// # Errors
    /// For bytes of another simulation; the state is as before then.
    fn restore(&mut self, saved: &[u8]) -> Result<()>;

    /// Data of a GSD file that are the same in every frame.
    ///
    /// # Errors
    /// If a text does not fit.
    fn header(&self) -> Result<Vec<Chunk>>;

    /// A frame of a GSD file.
    fn frame(&self) -> Vec<Chunk>;
}

/// State that [`Live::save`] wrote for a simulation of these things.
///
/// ```
/// use protomer_common::live::restored;
/// assert_eq!(restored::<(u64, f64)>(b"[3,0.5]", "a walk")?, (3, 0.5));
/// let message = restored::<(u64, f64)>(b"[3", "a walk").unwrap_err().to_string();
/// assert_eq!(message, "this is not what a simulation of a walk has saved");
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// For other bytes.
pub fn restored<T: DeserializeOwned>(saved: &[u8], things: &str) -> Result<T> {
    serde_json::from_slice(saved)
        .with_context(|| format!("this is not what a simulation of {things} has saved"))
}

/// Settings with some of their keys replaced.
///
/// ```
/// use protomer_common::live::changed;
/// use serde::{Deserialize, Serialize};
/// #[derive(Serialize, Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Walk {
///     steps: u64,
///     seed: u64,
/// }
/// let walk = changed(&Walk { steps: 10, seed: 1 }, &serde_json::json!({ "seed": 5 }))?;
/// assert_eq!((walk.steps, walk.seed), (10, 5));
/// let misspelt = changed(&walk, &serde_json::json!({ "sed": 5 }));
/// assert!(misspelt.is_err_and(|error| error.to_string().contains("`sed`")));
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// For unknown keys and values of another kind.
pub fn changed<T: Serialize + DeserializeOwned>(settings: &T, keys: &Value) -> Result<T> {
    let mut all = serde_json::to_value(settings)?;
    let (Some(all_keys), Some(keys)) = (all.as_object_mut(), keys.as_object()) else {
        bail!("settings are names with values; give them as such");
    };
    all_keys.extend(keys.clone());
    Ok(serde_json::from_value(all)?)
}

/// Takes an array out, if it is there, and refuses another number of columns or of rows.
///
/// ```
/// use protomer_common::live::{Arrays, Column, Rows, take};
/// let positions = Rows { columns: 3, values: vec![0.0; 6] };
/// let mut arrays = Arrays::from([("positions".to_owned(), positions)]);
/// let wanted = Column { name: "positions", columns: 3 };
/// assert_eq!(take(&mut arrays, wanted, Some(2))?, Some(vec![0.0; 6]));
/// assert_eq!(take(&mut arrays, wanted, Some(2))?, None, "it has been taken");
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// Names the array, what it has and what it must have.
pub fn take(arrays: &mut Arrays, wanted: Column, count: Option<usize>) -> Result<Option<Vec<f64>>> {
    let Column { name, columns } = wanted;
    let Some(rows) = arrays.remove(name) else {
        return Ok(None);
    };
    if rows.columns != columns {
        bail!("{name} has {} columns; give {columns}", rows.columns);
    }
    let found = rows.values.len() / columns;
    if let Some(count) = count.filter(|count| *count != found) {
        bail!("{name} has {found} rows, and there are {count} bodies; give a row for each");
    }
    if let Some(value) = rows.values.iter().find(|value| !value.is_finite()) {
        bail!("{name} holds {value}; give finite numbers");
    }
    Ok(Some(rows.values))
}

/// Refuses arrays, other than the box, that do not have a row for each body.
///
/// ```
/// use protomer_common::live::{Arrays, Rows, require_rows};
/// let positions = Rows { columns: 3, values: vec![0.0; 6] };
/// let arrays = Arrays::from([("positions".to_owned(), positions)]);
/// assert!(require_rows(&arrays, 2).is_ok());
/// let message = require_rows(&arrays, 3).map_err(|error| error.to_string());
/// assert_eq!(message, Err("positions has 2 rows, and there are 3 bodies; give a row for each".to_owned()));
/// ```
///
/// # Errors
/// Names the array and its rows.
pub fn require_rows(arrays: &Arrays, count: usize) -> Result<()> {
    for (name, rows) in arrays {
        let found = rows.values.len() / rows.columns.max(1);
        if name != "box" && found != count {
            bail!("{name} has {found} rows, and there are {count} bodies; give a row for each");
        }
    }
    Ok(())
}

/// Refuses arrays that nothing has taken.
///
/// ```
/// use protomer_common::live::{Arrays, Column, Rows, refuse_others};
/// let speeds = Rows { columns: 3, values: Vec::new() };
/// let arrays = Arrays::from([("speeds".to_owned(), speeds)]);
/// let message = refuse_others(&arrays, &[Column { name: "positions", columns: 3 }])
///     .map_err(|error| error.to_string());
/// assert_eq!(message, Err("there is no array speeds; give positions or box".to_owned()));
/// ```
///
/// # Errors
/// Names one of them, and those that there are.
pub fn refuse_others(arrays: &Arrays, columns: &[Column]) -> Result<()> {
    if let Some(name) = arrays.keys().next() {
        let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
        bail!("there is no array {name}; give {} or box", names.join(", "));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrays(name: &str, columns: usize, values: &[f64]) -> Arrays {
        let rows = Rows {
            columns,
            values: values.to_vec(),
        };
        Arrays::from([(name.to_owned(), rows)])
    }

    #[test]
    fn arrays_that_do_not_fit_say_what_to_give() {
        let positions = Column {
            name: "positions",
            columns: 3,
        };
        let complaint = |mut arrays: Arrays, count| {
            take(&mut arrays, positions, count).unwrap_err().to_string()
        };
        let flat = complaint(arrays("positions", 2, &[0.0; 4]), None);
        assert_eq!(flat, "positions has 2 columns; give 3");
        let few = complaint(arrays("positions", 3, &[0.0; 3]), Some(2));
        assert_eq!(
            few,
            "positions has 1 rows, and there are 2 bodies; give a row for each"
        );
        let endless = complaint(arrays("positions", 3, &[0.0, f64::NAN, 0.0]), Some(1));
        assert_eq!(endless, "positions holds NaN; give finite numbers");
        let misspelt = refuse_others(&arrays("position", 3, &[]), &[positions]).unwrap_err();
        assert_eq!(
            misspelt.to_string(),
            "there is no array position; give positions or box"
        );
        let mut none = Arrays::new();
        assert_eq!(take(&mut none, positions, None).unwrap(), None);
    }
}
