//! The answer of a verb: a value that a program can take, text for a reader, and possibly a
//! figure. Nothing here prints.

use protomer_plot::Figure;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// The answer of a verb. Its serialised form is the JSON output of the verb.
///
/// ```
/// use protomer_common::answer::{Answer, AnyAnswer};
/// use serde::Serialize;
///
/// #[derive(Serialize)]
/// struct Count {
///     bodies: usize,
/// }
///
/// impl Answer for Count {
///     fn text(&self) -> String {
///         format!("{} bodies", self.bodies)
///     }
/// }
///
/// let answer: Box<dyn AnyAnswer> = Box::new(Count { bodies: 3 });
/// assert_eq!(answer.text(), "3 bodies");
/// assert_eq!(answer.value().unwrap()["bodies"], 3);
/// ```
pub trait Answer: Serialize {
    /// The text for a reader, without a trailing newline.
    fn text(&self) -> String;

    /// The figure, if there is anything to draw.
    fn figure(&self) -> Option<Figure> {
        None
    }
}

/// A completed part of work that many processes share.
///
/// ```
/// use protomer_common::answer::{Answer, CompletedPart};
/// let part = CompletedPart { shard: 2, of: 4, count: 3, tasks: ["run", "runs"] };
/// assert_eq!(part.text(), "part 2 of 4: 3 runs done; run without --shard for the table");
/// assert_eq!(serde_json::to_string(&part).unwrap(), r#"{"shard":2,"of":4,"runs":3}"#);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompletedPart {
    /// The number of the part, counted from 1.
    pub shard: usize,
    /// The number of parts.
    pub of: usize,
    /// Number of tasks of the part.
    pub count: usize,
    /// Name of a task, and of several.
    pub tasks: [&'static str; 2],
}

impl Serialize for CompletedPart {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3))?;
        map.serialize_entry("shard", &self.shard)?;
        map.serialize_entry("of", &self.of)?;
        map.serialize_entry(self.tasks[1], &self.count)?;
        map.end()
    }
}

impl Answer for CompletedPart {
    fn text(&self) -> String {
        let [one, many] = self.tasks;
        format!(
            "part {} of {}: {} done; run without --shard for the table",
            self.shard,
            self.of,
            counted(self.count, one, many)
        )
    }
}

/// A number with the name of what is counted.
///
/// ```
/// use protomer_common::answer::counted;
/// assert_eq!(counted(1, "body", "bodies"), "1 body");
/// assert_eq!(counted(0, "body", "bodies"), "0 bodies");
/// ```
pub fn counted(number: usize, one: &str, many: &str) -> String {
    match number {
        1 => format!("1 {one}"),
        _ => format!("{number} {many}"),
    }
}

/// An answer with its type erased.
pub trait AnyAnswer {
    /// The text for a reader; see [`Answer::text`].
    fn text(&self) -> String;

    /// The figure, if there is anything to draw; see [`Answer::figure`].
    fn figure(&self) -> Option<Figure>;

    /// The answer as JSON text.
    ///
    /// # Errors
    /// If the value cannot be represented in JSON.
    fn json(&self) -> serde_json::Result<String>;

    /// The answer as a JSON value, its keys in the order of the text.
    ///
    /// # Errors
    /// If the value cannot be represented in JSON.
    fn value(&self) -> serde_json::Result<Value>;
}

impl<A: Answer> AnyAnswer for A {
    fn text(&self) -> String {
        Answer::text(self)
    }

    fn figure(&self) -> Option<Figure> {
        Answer::figure(self)
    }

    fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }

    fn value(&self) -> serde_json::Result<Value> {
        serde_json::to_value(self)
    }
}

/// Aligns rows in columns, two spaces apart; the first row is the heading.
///
/// ```
/// use protomer_common::answer::columns;
/// let rows = [["body", "copies"], ["a", "12"]].map(|row| row.map(str::to_owned).to_vec());
/// assert_eq!(columns(&rows), "body  copies\na     12");
/// ```
pub fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let padded = row.iter().zip(&widths);
        let cells: Vec<String> = padded
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        cells.join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A heading as a row of [`columns`].
///
/// ```
/// use protomer_common::answer::{columns, heading};
/// let rows = [heading(["salt", "pH"]), heading(["0.1 M", "7"])];
/// assert_eq!(columns(&rows), "salt   pH\n0.1 M  7");
/// ```
pub fn heading<const N: usize>(names: [&str; N]) -> Vec<String> {
    names.map(str::to_owned).to_vec()
}
