//! Finds relatives in different clusters, which no split by cluster can keep on one side.

use super::row::Row;
use super::structure::at_most;
use std::collections::BTreeMap;

/// Maximum number of lines.
const MOST_LINES: usize = 10;

/// One line for each file and each family that is in several clusters, up to the maximum.
pub fn in_several_clusters(rows: &[Row]) -> Vec<String> {
    let mut files: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    let mut families: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        files.entry(&row.sha256).or_default().push(row);
        families.entry(&row.family).or_default().push(row);
    }
    files.remove("");
    families.remove("");
    let of_file = |two: String| format!("{two}, and are the same file");
    let of_family = |family: &str, two: String| format!("{two}, and are of the family '{family}'");
    let files = files.values().filter_map(|group| apart(group)).map(of_file);
    let families = families
        .iter()
        .filter_map(|(family, group)| Some(of_family(family, apart(group)?)));
    let remedy = |line: String| {
        format!("{line}; put relatives into one cluster, or no split can keep them on one side")
    };
    at_most(MOST_LINES, files.chain(families).map(remedy).collect())
}

/// Describes the first two members of a group whose clusters differ.
fn apart(group: &[&Row]) -> Option<String> {
    let first = group.first()?;
    let other = group.iter().find(|row| row.cluster != first.cluster)?;
    Some(format!(
        "'{}' and '{}' are in different clusters, '{}' and '{}'",
        first.name, other.name, first.cluster, other.cluster
    ))
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
        in_several_clusters(&structures.iter().map(row).collect::<Vec<Row>>())
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
        let found = lines(&[
            ["a", "1", "f", "x"],
            ["b", "2", "", "x"],
            ["c", "1", "f", "y"],
            ["d", "3", "f", "z"],
        ]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with(
            "'a' and 'b' are in different clusters, '1' and '2', and are the same file"
        ));
        assert!(
            found[1].starts_with("'a' and 'd'") && found[1].contains("the family 'f'"),
            "{found:?}"
        );
    }
}
