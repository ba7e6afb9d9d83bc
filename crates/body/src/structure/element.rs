//! Elements, and guessing them where a file leaves them out.

/// Element symbols up to lawrencium in upper case, with `D` for deuterium and `X` for an unknown
/// element.
const SYMBOLS: &str = "\
    H HE LI BE B C N O F NE NA MG AL SI P S CL AR K CA SC TI V CR MN FE CO NI CU ZN GA GE AS SE BR \
    KR RB SR Y ZR NB MO TC RU RH PD AG CD IN SN SB TE I XE CS BA LA CE PR ND PM SM EU GD TB DY HO \
    ER TM YB LU HF TA W RE OS IR PT AU HG TL PB BI PO AT RN FR RA AC TH PA U NP PU AM CM BK CF ES \
    FM MD NO LR D X";

/// The symbol in upper case if it names an element.
pub(crate) fn known(symbol: &str) -> Option<&'static str> {
    let symbol = symbol.trim();
    if symbol.is_empty() || symbol.len() > 2 {
        return None;
    }
    SYMBOLS
        .split(' ')
        .find(|known| known.eq_ignore_ascii_case(symbol))
}

/// The element by the atom name in its four columns: a one-letter symbol is in the second
/// column, so ` CA ` is a carbon and `CA  ` calcium; four-letter names that begin with H are
/// hydrogens.
pub(crate) fn from_pdb_name(columns: &str, is_ligand: bool) -> &'static str {
    let starts_in_first_column = columns.starts_with(|c: char| c.is_ascii_alphabetic());
    let is_full = columns.trim().len() == 4;
    if starts_in_first_column && !is_full && is_ligand {
        let first_two = columns.get(..2).unwrap_or(columns);
        let letters = first_two.trim_end_matches(|c: char| !c.is_ascii_alphabetic());
        if let Some(element) = known(letters) {
            return element;
        }
    }
    from_name(columns)
}

/// The element by a bare atom name: its first letter. A digit may precede that of a hydrogen.
pub(crate) fn from_name(name: &str) -> &'static str {
    for (at, letter) in name.char_indices() {
        if letter.is_ascii_alphabetic() {
            return known(&name[at..=at]).unwrap_or("X");
        }
    }
    "X"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_column_tells_carbon_from_calcium() {
        assert_eq!(from_pdb_name(" CA ", false), "C");
        assert_eq!(from_pdb_name("CA  ", true), "CA");
        assert_eq!(from_pdb_name("ZN  ", true), "ZN");
        assert_eq!(from_pdb_name("HG11", false), "H");
        assert_eq!(from_pdb_name("1HB ", false), "H");
        assert_eq!(from_pdb_name("CA  ", false), "C");
        assert_eq!(from_pdb_name("    ", false), "X");
        assert_eq!(known("se"), Some("SE"));
        assert_eq!(known("QQ"), None);
    }
}
