//! Relatives that stand in different clusters: no split by cluster can then keep them on one side.

use super::set::SetContent;
use super::structure::at_most;
use std::collections::BTreeMap;

/// What is looked at of a structure.
#[derive(Debug, Clone, Copy)]
pub struct Structure<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its cluster.
    pub cluster: &'a str,
    /// Its family; perhaps empty.
    pub family: &'a str,
    /// SHA-256 of its file; empty if it could not be read.
    pub sha256: &'a str,
}

/// Lines that are kept.
const MOST_LINES: usize = 10;

/// A line for each file and each family that is in several clusters, the first few of them.
pub fn in_several_clusters<'a>(structures: impl Iterator<Item = Structure<'a>>) -> Vec<String> {
    let mut files: BTreeMap<&str, Vec<Structure>> = BTreeMap::new();
    let mut families: BTreeMap<&str, Vec<Structure>> = BTreeMap::new();
    for structure in structures {
        files.entry(structure.sha256).or_default().push(structure);
        families.entry(structure.family).or_default().push(structure);
    }
    files.remove("");
    families.remove("");
    let of_file = |two: String| format!("{two}, and are the same file");
    let of_family = |family: &str, two: String| format!("{two}, and are of the family '{family}'");
    let files = files.values().filter_map(|group| apart(group)).map(of_file);
    let families = families.iter().filter_map(|(family, group)| Some(of_family(family, apart(group)?)));
    let remedy = |line: String| format!("{line}; give relatives one cluster, or no split keeps them on one side");
    at_most(MOST_LINES, files.chain(families).map(remedy).collect())
}

/// The first two of a group whose clusters differ, in words.
fn apart(group: &[Structure]) -> Option<String> {
    let first = group.first()?;
    let other = group.iter().find(|structure| structure.cluster != first.cluster)?;
    Some(format!(
        "'{}' and '{}' are in different clusters, '{}' and '{}'",
        first.name, other.name, first.cluster, other.cluster
    ))
}

/// The same for everything in a set and left out of it.
pub fn of_content(content: &SetContent) -> Vec<String> {
    let samples = content.samples.iter().map(|sample| Structure {
        name: &sample.name,
        cluster: &sample.cluster,
        family: &sample.family,
        sha256: &sample.sha256,
    });
    let excluded = content.excluded.iter().map(|excluded| Structure {
        name: &excluded.name,
        cluster: &excluded.cluster,
        family: &excluded.family,
        sha256: &excluded.sha256,
    });
    in_several_clusters(samples.chain(excluded))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(structures: &[[&str; 4]]) -> Vec<String> {
        in_several_clusters(structures.iter().map(|[name, cluster, family, sha256]| Structure {
            name,
            cluster,
            family,
            sha256,
        }))
    }

    #[test]
    fn a_file_and_a_family_in_two_clusters_are_named() {
        assert!(
            lines(&[["a", "1", "f", "x"], ["b", "1", "f", "x"], ["c", "2", "", ""], ["d", "3", "", ""]]).is_empty()
        );
        let found = lines(&[["a", "1", "f", "x"], ["b", "2", "", "x"], ["c", "1", "f", "y"], ["d", "3", "f", "z"]]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("'a' and 'b' are in different clusters, '1' and '2', and are the same file"));
        assert!(found[1].starts_with("'a' and 'd'") && found[1].contains("the family 'f'"), "{found:?}");
    }
}
