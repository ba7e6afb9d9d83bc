//! Which chains make up one body.
//!
//! A user states a body by its chains, `A,B`, among the chains of one file or of several in one frame.
//! Nothing is guessed: an unknown chain, one that is stated twice, and one that two files have are errors.

use anyhow::{Result, bail};
use protomer_body::structure::Selection;
use std::collections::HashSet;
use std::str::FromStr;

/// The names of the chains of one body, as a user states them.
///
/// ```
/// use protomer_protein_verbs::bodies::chain_groups::ChainNames;
/// let names: ChainNames = "H,L".parse()?;
/// assert_eq!(names.0, ["H", "L"]);
/// assert!("H,,L".parse::<ChainNames>().is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChainNames(pub Vec<String>);

impl FromStr for ChainNames {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
        if names.iter().any(String::is_empty) {
            bail!("'{text}' is no list of chains; give their names with commas, such as A,B");
        }
        Ok(Self(names))
    }
}

/// The chains of one body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChainGroup {
    /// Index of the file.
    pub file: usize,
    /// Names of the chains.
    pub chains: Vec<String>,
}

/// Names of the chains of a selection, in its order.
pub fn chains_of(selection: &Selection) -> Vec<String> {
    let mut names = HashSet::new();
    let mut chains = Vec::new();
    for residue in &selection.residues {
        let name = &*residue.key.chain;
        if names.insert(name) {
            chains.push(name.to_owned());
        }
    }
    chains
}

/// Finds stated bodies among the chains of each file.
///
/// ```
/// use protomer_protein_verbs::bodies::chain_groups::stated_groups;
/// let chains = [vec!["H".to_owned(), "L".to_owned()], vec!["A".to_owned()]];
/// let groups = stated_groups(&["L,H".parse()?, "A".parse()?], &chains)?;
/// assert_eq!((groups[0].file, groups[1].file), (0, 1));
/// assert_eq!(groups[0].chains, ["L", "H"]);
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// Names the chain that no file has, that two files have, or that is stated twice, and the body whose
/// chains are in two files.
pub fn stated_groups(
    stated: &[ChainNames],
    chains_of_files: &[Vec<String>],
) -> Result<Vec<ChainGroup>> {
    let mut taken = HashSet::new();
    let mut groups = Vec::with_capacity(stated.len());
    for ChainNames(chains) in stated {
        let mut files = Vec::with_capacity(chains.len());
        for chain in chains {
            files.push(file_of(chain, chains_of_files)?);
            if !taken.insert(chain) {
                bail!("chain {chain} is stated twice; a chain belongs to one body");
            }
        }
        let Some(&file) = files.first() else {
            bail!("a body without chains; give their names, such as --body A,B");
        };
        if files.iter().any(|other| *other != file) {
            bail!(
                "the chains of the body {} are in two files; put chains that move as one into one file",
                chains.join(",")
            );
        }
        groups.push(ChainGroup {
            file,
            chains: chains.clone(),
        });
    }
    Ok(groups)
}

/// The file that has a chain.
fn file_of(chain: &str, chains_of_files: &[Vec<String>]) -> Result<usize> {
    let has_chain = |chains: &Vec<String>| chains.iter().any(|name| name == chain);
    let mut files = (0..chains_of_files.len()).filter(|file| has_chain(&chains_of_files[*file]));
    match (files.next(), files.next()) {
        (Some(file), None) => Ok(file),
        (Some(_), Some(_)) => bail!(
            "two files have a chain {chain}, so its name does not say which one is meant; rename it in one \
             of them, or leave out --body: each file is one body then"
        ),
        (None, _) => bail!(
            "there is no chain {chain}; there are {}",
            chains_of_files.concat().join(", ")
        ),
    }
}

/// The chains that belong to no group, with the index of their file.
pub fn ungrouped(groups: &[ChainGroup], chains_of_files: &[Vec<String>]) -> Vec<(usize, String)> {
    let is_grouped = |file: usize, chain: &String| {
        let mut of_file = groups.iter().filter(|group| group.file == file);
        of_file.any(|group| group.chains.contains(chain))
    };
    let mut remaining_chains = Vec::new();
    for (file, chains) in chains_of_files.iter().enumerate() {
        for chain in chains {
            if !is_grouped(file, chain) {
                remaining_chains.push((file, chain.clone()));
            }
        }
    }
    remaining_chains
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chains(names: &str) -> Vec<String> {
        names.chars().map(String::from).collect()
    }

    fn found(bodies: &[&str], files: &[Vec<String>]) -> Result<Vec<ChainGroup>> {
        let stated: Vec<ChainNames> = bodies.iter().map(|body| body.parse().unwrap()).collect();
        stated_groups(&stated, files)
    }

    #[test]
    fn what_is_not_clear_is_refused() {
        let two = [chains("HL"), chains("AH")];
        for (bodies, said) in [
            (&["X"][..], "there is no chain X; there are H, L, A, H"),
            (&["H"], "two files have a chain H"),
            (&["L", "L"], "chain L is stated twice"),
            (&["L,L"], "chain L is stated twice"),
            (&["L,A"], "the body L,A are in two files"),
        ] {
            let message = found(bodies, &two).unwrap_err().to_string();
            assert!(message.contains(said), "{message}");
        }
    }

    #[test]
    fn chains_without_a_body_are_known() {
        let files = [chains("HLX"), chains("AH")];
        let groups = found(&["L,X", "A"], &files).unwrap();
        let remaining_chains = ungrouped(&groups, &files);
        assert_eq!(remaining_chains, [(0, "H".to_owned()), (1, "H".to_owned())]);
    }
}
