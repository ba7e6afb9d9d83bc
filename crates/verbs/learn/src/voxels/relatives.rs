//! Finds relatives in different clusters, which no split by cluster can keep on one side.

use super::row::Row;
use super::structure::at_most;
use anyhow::Result;
use protomer_io::digest::Digest;
use std::collections::BTreeMap;

/// Maximum number of lines.
const MOST_LINES: usize = 10;

/// One line for each file and each family that is in several clusters, up to the maximum. The
/// function returns the row of a number below `count`.
///
/// # Errors
/// Those of the function.
pub fn in_several_clusters(
    count: usize,
    row: impl Fn(usize) -> Result<Row>,
) -> Result<Vec<String>> {
    let (mut files, mut families) = (Groups::new(count), Groups::new(count));
    for number in 0..count {
        let row = row(number)?;
        files.add(&row.sha256, number);
        families.add(&row.family, number);
    }
    let mut lines = Vec::new();
    for (_, two) in files.apart(&row, |row| &row.sha256)? {
        lines.push(format!("{two}, and are the same file"));
    }
    for (family, two) in families.apart(&row, |row| &row.family)? {
        lines.push(format!("{two}, and are of the family '{family}'"));
    }
    for line in &mut lines {
        line.push_str("; put relatives into one cluster, or no split can keep them on one side");
    }
    Ok(at_most(MOST_LINES, lines))
}

/// The short hash of a word that several rows may share, and the number of the row.
struct Groups(Vec<(u64, usize)>);

impl Groups {
    /// Empty groups, with room for so many rows.
    fn new(count: usize) -> Self {
        Self(Vec::with_capacity(count))
    }

    fn add(&mut self, word: &str, number: usize) {
        if !word.is_empty() {
            self.0.push((Digest::hash(word.as_bytes()).short(), number));
        }
    }

    /// The words whose rows are in several clusters, in order, and the first two such rows of each.
    fn apart(
        mut self,
        row: impl Fn(usize) -> Result<Row>,
        word: impl Fn(&Row) -> &String,
    ) -> Result<BTreeMap<String, String>> {
        self.0.sort_unstable();
        let mut examples = BTreeMap::new();
        // The word at hand, and its first row.
        let mut first: Option<(u64, usize)> = None;
        for (hash, number) in &self.0 {
            let Some((_, first)) = first.filter(|(of_first, _)| of_first == hash) else {
                first = Some((*hash, *number));
                continue;
            };
            let (first, other) = (row(first)?, row(*number)?);
            if word(&first) == word(&other) && first.cluster != other.cluster {
                let two = in_words(&first, &other);
                examples.entry(word(&first).clone()).or_insert(two);
            }
        }
        Ok(examples)
    }
}

fn in_words(first: &Row, other: &Row) -> String {
    format!(
        "'{}' and '{}' are in different clusters, '{}' and '{}'",
        first.name, other.name, first.cluster, other.cluster
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(structures: &[[&'static str; 4]]) -> Vec<String> {
        let row = |words: &[&'static str; 4]| {
            let [name, cluster, family, sha256] = words.map(str::to_owned);
            Row {
                name,
                cluster,
                family,
                sha256,
                ..Row::default()
            }
        };
        in_several_clusters(structures.len(), |number| Ok(row(&structures[number]))).unwrap()
    }

    #[test]
    fn a_file_and_a_family_in_two_clusters_are_named() {
        assert!(
            lines(&[
                ["a", "1", "f", "x"],
                ["b", "1", "f", "x"],
                ["c", "2", "", ""],
                ["d", "3", "", ""]
            ])
            .is_empty()
        );
        let warnings = lines(&[
            ["a", "1", "f", "x"],
            ["b", "2", "", "x"],
            ["c", "1", "f", "y"],
            ["d", "3", "f", "z"],
        ]);
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[0].starts_with(
            "'a' and 'b' are in different clusters, '1' and '2', and are the same file"
        ));
        assert!(
            warnings[1].starts_with("'a' and 'd'") && warnings[1].contains("the family 'f'"),
            "{warnings:?}"
        );
    }
}
