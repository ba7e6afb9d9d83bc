//! Elements: what a file states, and what follows from names where it states nothing or nonsense.

use crate::chemistry::amino_acid::{AminoAcid, BACKBONE};
use crate::chemistry::ions::ion;
use crate::chemistry::residue_names;

/// Element symbols up to lawrencium in upper case, with `D` for deuterium and `X` for an unknown
/// element.
const SYMBOLS: &str = "\
    H HE LI BE B C N O F NE NA MG AL SI P S CL AR K CA SC TI V CR MN FE CO NI CU ZN GA GE AS SE BR \
    KR RB SR Y ZR NB MO TC RU RH PD AG CD IN SN SB TE I XE CS BA LA CE PR ND PM SM EU GD TB DY HO \
    ER TM YB LU HF TA W RE OS IR PT AU HG TL PB BI PO AT RN FR RA AC TH PA U NP PU AM CM BK CF ES \
    FM MD NO LR D X";

/// The symbol in upper case if it names an element.
pub(crate) fn parse_symbol(symbol: &str) -> Option<&'static str> {
    let symbol = symbol.trim();
    if symbol.is_empty() || symbol.len() > 2 {
        return None;
    }
    SYMBOLS
        .split(' ')
        .find(|candidate| candidate.eq_ignore_ascii_case(symbol))
}

/// Statements of a file about an atom from which its element follows.
pub(crate) struct Statement<'a> {
    /// The element column.
    pub(crate) symbol: &'a str,
    /// Atom name: in its four columns in PDB, where the column of a letter has a meaning.
    pub(crate) name: &'a str,
    pub(crate) residue_name: &'a str,
    pub(crate) hetero: bool,
}

/// The element of an atom, and whether the element column says another one.
///
/// The name decides for the standard atoms of amino acids: some programs fill the column with the
/// first letters of the name (`CA` for Cα). Otherwise the column decides, then the residue name of
/// an ion, then the atom name.
pub(crate) fn of_atom(statement: &Statement) -> (&'static str, bool) {
    let stated = parse_symbol(statement.symbol);
    if let Some(element) = standard(statement) {
        let is_same =
            stated.is_none_or(|stated| stated == element || is_deuterium(stated, element));
        return match stated {
            Some(stated) if is_same => (stated, false),
            _ => (element, !is_same),
        };
    }
    let element = stated
        .or_else(|| ion_element(statement))
        .unwrap_or_else(|| from_pdb_name(statement));
    (element, false)
}

/// The element of an ion, whose atom has the name of its residue or of the element.
fn ion_element(statement: &Statement) -> Option<&'static str> {
    let element = ion(statement.residue_name)?.element;
    let names = [statement.residue_name, element];
    let is_ion = names
        .iter()
        .any(|name| name.eq_ignore_ascii_case(statement.name.trim()));
    is_ion.then_some(element)
}

fn is_deuterium(stated: &str, element: &str) -> bool {
    stated == "D" && element == "H"
}

/// The element of a standard atom of an amino acid by its name; `X` for a name that stands for no
/// atom there.
fn standard(statement: &Statement) -> Option<&'static str> {
    let amino_acid = residue_names::parent_amino_acid(statement.residue_name)?;
    let name = statement.name.trim();
    let is_plain = AminoAcid::of_residue(statement.residue_name).is_some();
    let letters = name.trim_start_matches(|c: char| c.is_ascii_digit());
    let first = letters.get(..1)?;
    match first {
        "Q" | "M" if is_plain => Some("X"),
        "H" if is_plain || letters.len() < name.len() => Some("H"),
        _ if amino_acid.side_chain().contains(&name) || is_backbone(name) => parse_symbol(first),
        _ => None,
    }
}

fn is_backbone(name: &str) -> bool {
    BACKBONE.contains(&name) || ["CB", "OXT", "OT1", "OT2", "OC1", "OC2"].contains(&name)
}

/// The element by the atom name: a one-letter symbol is in the second of the four columns, so
/// ` CA ` is a carbon and `CA  ` calcium; four-letter names that begin with H are hydrogens.
fn from_pdb_name(statement: &Statement) -> &'static str {
    let columns = statement.name;
    let starts_in_first_column = columns.starts_with(|c: char| c.is_ascii_alphabetic());
    let is_full = columns.trim().len() == 4;
    let is_modified = residue_names::modified_residue(statement.residue_name).is_some();
    let may_be_metal = statement.hetero && !residue_names::is_polymer(statement.residue_name);
    if starts_in_first_column && !is_full && (may_be_metal || is_modified) {
        let first_two = columns.get(..2).unwrap_or(columns);
        let letters = first_two.trim_end_matches(|c: char| !c.is_ascii_alphabetic());
        if let Some(element) = parse_symbol(letters) {
            return element;
        }
    }
    from_name(columns)
}

/// The element by a bare atom name: its first letter. A digit may precede that of a hydrogen.
pub(crate) fn from_name(name: &str) -> &'static str {
    for (index, letter) in name.char_indices() {
        if letter.is_ascii_alphabetic() {
            return parse_symbol(&name[index..=index]).unwrap_or("X");
        }
    }
    "X"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(name: &str, residue_name: &str, symbol: &str) -> (&'static str, bool) {
        let hetero = !["ALA", "MET", "SER"].contains(&residue_name);
        of_atom(&Statement {
            symbol,
            name,
            residue_name,
            hetero,
        })
    }

    #[test]
    fn the_column_of_the_name_tells_carbon_from_calcium() {
        for (name, residue_name, expected) in [
            (" CA ", "LIG", "C"),
            ("CA  ", " CA", "CA"),
            ("ZN  ", "LIG", "ZN"),
            ("HG11", "LIG", "H"),
            ("1HB ", "ALA", "H"),
            ("CA  ", "ALA", "C"),
            ("SE  ", "MSE", "SE"),
            ("    ", "LIG", "X"),
            (" SOD", "SOD", "NA"),
        ] {
            assert_eq!(
                element(name, residue_name.trim(), ""),
                (expected, false),
                "{name}"
            );
        }
        assert_eq!(parse_symbol("se"), Some("SE"));
        assert_eq!(parse_symbol("QQ"), None);
    }

    #[test]
    fn names_of_amino_acids_decide_over_the_element_column() {
        for (name, residue_name, symbol, expected) in [
            ("CA  ", "ALA", "CA", ("C", true)),
            ("SD  ", "MET", "SD", ("S", false)),
            (" OG ", "SER", "C", ("O", true)),
            (" OG ", "SER", "O", ("O", false)),
            (" D  ", "SER", "D", ("D", false)),
            ("HG  ", "SER", "HG", ("H", true)),
            (" HG ", "SER", "D", ("D", false)),
            (" QB ", "ALA", "", ("X", false)),
            (" MG ", "MET", "MG", ("X", true)),
            // Others are what the column says.
            ("CA  ", "LIG", "CA", ("CA", false)),
            ("SE  ", "MSE", "SE", ("SE", false)),
            (" P  ", "SEP", "P", ("P", false)),
            (" CA ", "SEP", "CA", ("C", true)),
        ] {
            assert_eq!(
                element(name, residue_name, symbol),
                expected,
                "{name} {residue_name}"
            );
        }
    }
}
