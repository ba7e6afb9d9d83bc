//! Strands, the separate polymers of a structure, and names that tell them apart.
//!
//! A strand is a series of polymer residues of one chain in the order of the file. It ends where the
//! file says so, by TER or by another segment identifier (CHARMM, X-PLOR), or where residue numbers
//! begin again, unless the next residue is bonded to the last one. A gap in a strand is a chain break,
//! not an end.
//!
//! Each strand is a separate chain. Where the file gives no name, or the same to several, they are
//! named here: by the segment identifier where there is no chain, by letters where there is neither,
//! and with a number where a chain begins again with residue numbers that it had before.

use super::classes::ResidueClass;
use super::contents::Atom;
use super::residue_key::ResidueKey;
use super::residues::AtomGroup;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

/// A residue before it is selected.
pub(crate) struct Placed<'g, 'a> {
    pub(crate) group: &'g AtomGroup<'a>,
    pub(crate) class: ResidueClass,
    /// The group whose chain this one continues, if the file lists it elsewhere.
    pub(crate) host: Option<&'g AtomGroup<'a>>,
}

impl<'a> Placed<'_, 'a> {
    fn is_polymer(&self) -> bool {
        self.class.is_protein() || self.class == ResidueClass::Nucleotide
    }

    /// The first atom of the residue, or of the one whose chain it continues.
    fn first_atom(&self) -> Option<&'a Atom> {
        let group = self.host.unwrap_or(self.group);
        group.atoms.first().copied()
    }

    /// Segment, chain of the archive, and number of TER records before the residue.
    fn strand_of_file(&self) -> Option<([&'a str; 2], u32)> {
        let atom = self.first_atom()?;
        Some(([&atom.segment, &atom.label_chain], atom.polymer))
    }
}

/// The strands and names of the residues, each by the index of the residue.
pub(crate) struct Strands {
    /// Number of the strand; `None` outside polymers.
    pub(crate) strand: Vec<Option<usize>>,
    /// Key with the name of the chain and, where the file numbers nothing, a number.
    pub(crate) keys: Vec<ResidueKey>,
    /// Notes, in words, about what was named or numbered.
    pub(crate) notes: Vec<String>,
}

impl Strands {
    /// The strands of residues in the order of their chains.
    pub(crate) fn from_residues(residues: &[Placed]) -> Self {
        let strand = strands(residues);
        let mut keys: Vec<ResidueKey> = residues
            .iter()
            .map(|residue| residue.group.key.clone())
            .collect();
        let mut notes = Vec::new();
        number(residues, &strand, &mut keys, &mut notes);
        name(residues, &strand, &mut keys, &mut notes);
        Self {
            strand,
            keys,
            notes,
        }
    }
}

/// The last strand of a chain.
#[derive(Default)]
struct LastStrand<'a> {
    number: usize,
    /// Index of its last residue.
    residue: usize,
    /// Number and insertion code of each of its residues.
    numbers: HashSet<(i32, &'a str)>,
}

/// The number of the strand of each polymer residue.
fn strands(residues: &[Placed]) -> Vec<Option<usize>> {
    let mut strand = vec![None; residues.len()];
    let mut count = 0;
    let mut last: HashMap<&str, LastStrand> = HashMap::new();
    for (index, residue) in residues.iter().enumerate() {
        if !residue.is_polymer() {
            continue;
        }
        let key = &residue.group.key;
        let number = (key.number, &*key.insertion_code);
        let LastStrand {
            number: of_chain,
            residue: before,
            numbers,
        } = last.entry(&key.chain).or_default();
        let is_first = numbers.is_empty();
        if is_first || ends_between(&residues[*before], residue, numbers.contains(&number)) {
            *of_chain = count;
            count += 1;
            numbers.clear();
        }
        strand[index] = Some(*of_chain);
        numbers.insert(number);
        *before = index;
    }
    strand
}

/// Whether a strand ends between two successive residues of a chain.
fn ends_between(before: &Placed, after: &Placed, is_number_used: bool) -> bool {
    let is_backwards = after.group.key.number < before.group.key.number;
    let is_other_strand = before.strand_of_file() != after.strand_of_file();
    let ends = is_other_strand || (is_number_used && is_backwards);
    ends && !super::links::are_bonded(before.group, after.group)
}

/// Numbers the residues of strands in which all have the same number.
fn number(
    residues: &[Placed],
    strand: &[Option<usize>],
    keys: &mut [ResidueKey],
    notes: &mut Vec<String>,
) {
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, strand) in strand.iter().enumerate() {
        if let Some(strand) = strand {
            members.entry(*strand).or_default().push(index);
        }
    }
    for members in members.values() {
        let first = &residues[members[0]].group.key;
        let are_equal = members
            .iter()
            .all(|index| residues[*index].group.key == *first);
        if members.len() < 2 || !are_equal {
            continue;
        }
        for (number, &index) in (1..).zip(members) {
            keys[index].number = number;
        }
        notes.push(format!(
            "all {} residues of {} have the number {}: they are told apart by names and atoms, and \
             numbered from 1 in their order",
            members.len(),
            chain_in_words(&first.chain),
            first.number
        ));
    }
}

fn chain_in_words(chain: &str) -> String {
    if chain.is_empty() {
        "the chain without a name".into()
    } else {
        format!("chain {chain}")
    }
}

/// Names strands that share a name with another.
fn name(
    residues: &[Placed],
    strand: &[Option<usize>],
    keys: &mut [ResidueKey],
    notes: &mut Vec<String>,
) {
    name_by_segments(residues, strand, keys, notes);
    let mut used: BTreeSet<Arc<str>> = keys.iter().map(|key| key.chain.clone()).collect();
    let mut names: BTreeMap<usize, Arc<str>> = BTreeMap::new();
    for (chain, strands) in by_chain(strand, keys) {
        let named = match &*chain {
            "" => letters(&strands, &mut used),
            _ => numbered(&chain, &strands, &mut used),
        };
        if !named.is_empty() {
            notes.push(naming_note(&chain, strands.len(), &named));
            names.extend(named);
        }
    }
    for (strand, key) in strand.iter().zip(keys) {
        if let Some(name) = strand.and_then(|strand| names.get(&strand)) {
            key.chain = name.clone();
        }
    }
}

/// A strand of a chain.
struct Strand {
    number: usize,
    /// Number and insertion code of each residue.
    residues: Vec<(i32, Arc<str>)>,
}

/// The strands of each chain, in their order.
fn by_chain(strand: &[Option<usize>], keys: &[ResidueKey]) -> BTreeMap<Arc<str>, Vec<Strand>> {
    let mut by_chain: BTreeMap<Arc<str>, Vec<Strand>> = BTreeMap::new();
    for (number, key) in strand.iter().zip(keys) {
        let Some(number) = *number else {
            continue;
        };
        let residue = (key.number, key.insertion_code.clone());
        let strands = by_chain.entry(key.chain.clone()).or_default();
        match strands.last_mut().filter(|last| last.number == number) {
            Some(last) => last.residues.push(residue),
            None => strands.push(Strand {
                number,
                residues: vec![residue],
            }),
        }
    }
    by_chain
}

fn naming_note(chain: &str, strands: usize, names: &BTreeMap<usize, Arc<str>>) -> String {
    let listed: Vec<String> = names.values().map(|name| name.to_string()).collect();
    let listed = super::messages::listed(&listed);
    if chain.is_empty() {
        return format!(
            "{strands} chains without a name, told apart by TER, segments or numbers that begin \
             again: named {listed}"
        );
    }
    format!(
        "chain {chain} ends and begins again with the same residue numbers: what follows is named \
         {listed}"
    )
}

/// Chains without a name take that of their segment, where polymers have different ones.
fn name_by_segments(
    residues: &[Placed],
    strand: &[Option<usize>],
    keys: &mut [ResidueKey],
    notes: &mut Vec<String>,
) {
    let segment = |index: usize| Some(residues[index].first_atom()?.segment.clone());
    let mut segments: BTreeSet<Arc<str>> = BTreeSet::new();
    for (index, key) in keys.iter().enumerate() {
        if key.chain.is_empty() && strand[index].is_some() {
            segments.extend(segment(index));
        }
    }
    if segments.len() < 2 || segments.iter().any(|segment| segment.is_empty()) {
        return;
    }
    for (index, key) in keys.iter_mut().enumerate() {
        if let (true, Some(segment)) = (key.chain.is_empty(), segment(index)) {
            key.chain = segment;
        }
    }
    let listed: Vec<String> = segments.iter().map(|name| name.to_string()).collect();
    let listed = super::messages::listed(&listed);
    notes.push(format!(
        "chains without a name are named by their segments (columns 73-76): {listed}"
    ));
}

/// Free letters for several strands without a name.
fn letters(strands: &[Strand], used: &mut BTreeSet<Arc<str>>) -> BTreeMap<usize, Arc<str>> {
    let mut names = BTreeMap::new();
    if strands.len() < 2 {
        return names;
    }
    let mut candidates = (0..).map(letters_of);
    for strand in strands {
        if let Some(name) = candidates.find(|name| !used.contains(name)) {
            used.insert(name.clone());
            names.insert(strand.number, name);
        }
    }
    names
}

/// Letters of a number, counted from zero: A, B, ..., Z, AA, AB, ...
fn letters_of(number: usize) -> Arc<str> {
    let mut letters = Vec::new();
    let mut quotient = number + 1;
    while quotient > 0 {
        quotient -= 1;
        letters.push(char::from(b'A' + (quotient % 26) as u8));
        quotient /= 26;
    }
    letters.iter().rev().collect::<String>().into()
}

/// Names `A2`, `A3`, ... for the strands of chain A whose residue numbers occurred in it before.
fn numbered(
    chain: &str,
    strands: &[Strand],
    used: &mut BTreeSet<Arc<str>>,
) -> BTreeMap<usize, Arc<str>> {
    let mut names = BTreeMap::new();
    let mut candidates = (2..).map(|copy: usize| Arc::from(format!("{chain}{copy}")));
    let mut taken: HashSet<&(i32, Arc<str>)> = HashSet::new();
    for strand in strands {
        if !strand
            .residues
            .iter()
            .any(|residue| taken.contains(residue))
        {
            taken.extend(&strand.residues);
        } else if let Some(name) = candidates.find(|name| !used.contains(name)) {
            used.insert(name.clone());
            names.insert(strand.number, name);
        }
    }
    names
}
