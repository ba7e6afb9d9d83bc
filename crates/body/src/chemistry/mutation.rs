//! Residues exchanged in place: another charge and hydropathy on the same atoms.
//!
//! The geometry stays: a mutated residue keeps its atoms and their names. The new residue's
//! template holds on the backbone; its side chain's net charge goes to the outermost side-chain
//! atoms there are ([`super::charges`]). That places a charge within a few Å of where a rebuilt
//! side chain would have it, which is what supercharged variants of a rigid body need.

use super::amino_acid::AminoAcid;
use crate::structure::{ResidueClass, SelectedResidue, Selection, mark_disulfides};
use crate::{BodyError, Result};
use std::fmt;
use std::sync::Arc;

/// One exchange.
#[derive(Debug, Clone, PartialEq)]
pub struct Mutation {
    /// Chain (author's); every copy of it in an assembly is mutated.
    pub chain: String,
    /// Residue number.
    pub number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
    /// The amino acid that is there.
    pub from: AminoAcid,
    /// The amino acid to put.
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
    let items = list
        .split(',')
        .map(str::trim)
        .filter(|item| !item.is_empty());
    items
        .map(|item| parse_mutation(item).ok_or_else(|| unreadable(item)))
        .collect()
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

/// Applies the exchanges.
///
/// # Errors
/// [`BodyError::Invalid`] if there is no such residue, or another one than the mutation says, which
/// it names.
pub fn mutate(selection: &mut Selection, mutations: &[Mutation]) -> Result<()> {
    for mutation in mutations {
        let mut found = false;
        for residue in selection
            .residues
            .iter_mut()
            .filter(|residue| is_at(residue, mutation))
        {
            exchange(residue, mutation)?;
            found = true;
        }
        if !found {
            return Err(absent(selection, mutation));
        }
    }
    // A cysteine whose partner is gone has a free thiol.
    mark_disulfides(&mut selection.residues);
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

fn absent(selection: &Selection, mutation: &Mutation) -> BodyError {
    let numbers = selection
        .residues
        .iter()
        .filter(|residue| *residue.source_chain == *mutation.chain);
    let range = numbers.fold(None, |range: Option<(i32, i32)>, residue| {
        let number = residue.key.number;
        Some(range.map_or((number, number), |(low, high)| {
            (low.min(number), high.max(number))
        }))
    });
    BodyError::Invalid {
        cause: format!(
            "no residue {}:{}{}",
            mutation.chain, mutation.number, mutation.insertion_code
        ),
        remedy: match range {
            Some((low, high)) => format!(
                "the residues of chain {} run from {low} to {high}",
                mutation.chain
            ),
            None => format!("chain {} is not selected", mutation.chain),
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
