//! Mutations without new coordinates: another charge and hydropathy on the same atoms.
//!
//! The geometry stays: a mutated residue keeps its atoms and their names. The new residue's
//! template applies to the backbone; the net charge of its side chain goes to the outermost
//! side-chain atoms present ([`super::charges`]). This places the charge within a few Å of its
//! position in a rebuilt side chain, which is accurate enough for supercharged variants of a rigid
//! body.

use super::amino_acid::AminoAcid;
use crate::structure::{ResidueClass, ResidueKey, SelectedResidue, Selection};
use crate::{BodyError, Result};
use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

/// One mutation.
///
/// ```
/// use protomer_body::chemistry::{AminoAcid, Mutation};
/// let mutation = Mutation {
///     chain: "A".into(),
///     number: 45,
///     insertion_code: String::new(),
///     from: AminoAcid::Lys,
///     to: AminoAcid::Glu,
/// };
/// assert_eq!(mutation.to_string(), "A:K45E");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mutation {
    /// Chain (author's); every copy of it in an assembly is mutated.
    pub chain: String,
    /// Residue number.
    pub number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
    /// The amino acid in the structure.
    pub from: AminoAcid,
    /// The amino acid that replaces it.
    pub to: AminoAcid,
}

impl fmt::Display for Mutation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (from, to) = (self.from.letter(), self.to.letter());
        write!(
            formatter,
            "{}:{from}{}{}{to}",
            self.chain, self.number, self.insertion_code
        )
    }
}

/// Reads a list such as `A:K45E,B:N12D`: chain, one-letter code, number, insertion code if any,
/// one-letter code.
///
/// ```
/// let mutations = protomer_body::chemistry::parse_mutations("A:K45E, B:N-12AD")?;
/// assert_eq!((mutations[0].number, mutations[1].number), (45, -12));
/// assert_eq!(mutations[1].insertion_code, "A");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] that quotes the item.
pub fn parse_mutations(list: &str) -> Result<Vec<Mutation>> {
    let mut mutations = Vec::new();
    for item in list.split(',').map(str::trim) {
        if item.is_empty() {
            continue;
        }
        match parse_mutation(item) {
            Some(mutation) => mutations.push(mutation),
            None => return Err(unreadable(item)),
        }
    }
    Ok(mutations)
}

fn unreadable(item: &str) -> BodyError {
    BodyError::Invalid {
        cause: format!("mutation `{item}` is not understood"),
        remedy: "write chain:from-number-to with one-letter codes, for example A:K45E".into(),
    }
}

fn parse_mutation(item: &str) -> Option<Mutation> {
    let (chain, change) = item.rsplit_once(':')?;
    let from = AminoAcid::of_name(change.get(..1)?)?;
    let to = AminoAcid::of_name(change.get(change.len().checked_sub(1)?..)?)?;
    let place = change.get(1..change.len() - 1)?;
    let digits_end = place.rfind(|c: char| c.is_ascii_digit())? + 1;
    let (number, insertion_code) = place.split_at(digits_end);
    let number = number.parse().ok()?;
    Some(Mutation {
        chain: chain.to_string(),
        number,
        insertion_code: insertion_code.to_string(),
        from,
        to,
    })
}

/// Applies mutations. A cysteine whose partner in a disulfide bond is mutated gets a free thiol.
///
/// ```
/// use protomer_body::chemistry::{mutate, parse_mutations};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let line = "ATOM      1  CA  LYS A  45      11.104   6.134  -6.504  1.00 10.00           C";
/// let structure = Structure::read("lysine.pdb", line.as_bytes())?;
/// let mut selection = structure.select(&SelectionSettings::default())?;
/// mutate(&mut selection, &parse_mutations("A:K45E")?)?;
/// assert_eq!(&*selection.residues[0].name, "GLU");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] if there is no such residue, or if it is another amino acid than the
/// mutation says.
pub fn mutate(selection: &mut Selection, mutations: &[Mutation]) -> Result<()> {
    for mutation in mutations {
        let mut is_present = false;
        for residue in &mut selection.residues {
            if is_at(residue, mutation) {
                exchange(residue, mutation)?;
                is_present = true;
            }
        }
        if !is_present {
            return Err(absent(selection, mutation));
        }
    }
    break_disulfides(selection);
    Ok(())
}

fn is_at(residue: &SelectedResidue, mutation: &Mutation) -> bool {
    let key = &residue.key;
    (*residue.source_chain == *mutation.chain || *key.chain == *mutation.chain)
        && key.number == mutation.number
        && *key.insertion_code == *mutation.insertion_code
        && residue.class.is_protein()
}

fn exchange(residue: &mut SelectedResidue, mutation: &Mutation) -> Result<()> {
    if residue.class.amino_acid() != Some(mutation.from) {
        return Err(BodyError::Invalid {
            cause: format!(
                "residue {} is {}, not {}",
                residue.key,
                residue.name,
                mutation.from.name()
            ),
            remedy: "check chain and numbering; numbers are the authors'".into(),
        });
    }
    residue.mutated_from = Some(mutation.from);
    residue.class = ResidueClass::AminoAcid(mutation.to);
    residue.name = Arc::from(mutation.to.name());
    Ok(())
}

/// Breaks the disulfide bonds of mutated residues, on both sides.
fn break_disulfides(selection: &mut Selection) {
    let mut exchanged: HashSet<ResidueKey> = HashSet::new();
    for residue in &selection.residues {
        if residue.mutated_from.is_some() {
            exchanged.insert(residue.key.clone());
        }
    }
    let mut freed: HashSet<ResidueKey> = exchanged.clone();
    selection.report.disulfides.retain(|bond| {
        let is_broken = exchanged.contains(&bond.residue) || exchanged.contains(&bond.partner);
        if is_broken {
            freed.extend([bond.residue.clone(), bond.partner.clone()]);
        }
        !is_broken
    });
    for residue in &mut selection.residues {
        residue.in_disulfide &= !freed.contains(&residue.key);
    }
}

fn absent(selection: &Selection, mutation: &Mutation) -> BodyError {
    let mut range: Option<(i32, i32)> = None;
    for residue in &selection.residues {
        if [&residue.source_chain, &residue.key.chain].contains(&&Arc::from(&*mutation.chain)) {
            let number = residue.key.number;
            let (low, high) = range.unwrap_or((number, number));
            range = Some((low.min(number), high.max(number)));
        }
    }
    let chain = &mutation.chain;
    BodyError::Invalid {
        cause: format!(
            "no residue {chain}:{}{}",
            mutation.number, mutation.insertion_code
        ),
        remedy: match range {
            Some((low, high)) => {
                format!("the residues of chain {chain} run from {low} to {high}")
            }
            None => format!("chain {chain} is not selected"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_mutation_is_quoted() {
        for wrong in [
            "A:K45", "K45E", "A:KE", "A:45E", "A:K4x5E", "A:", ":", "A:Ké5E",
        ] {
            let message = parse_mutations(wrong).unwrap_err().to_string();
            assert!(message.contains(wrong), "{message}");
        }
    }
}
