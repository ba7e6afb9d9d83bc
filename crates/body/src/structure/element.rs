//! Elements, and guessing them where a file leaves them out.

/// Element symbols up to lawrencium in upper case, with `D` for deuterium and `X` for an atom that
/// is not known.
const SYMBOLS: &str = "\
    H HE LI BE B C N O F NE NA MG AL SI P S CL AR K CA SC TI V CR MN FE CO NI CU ZN GA GE AS SE BR KR RB SR Y ZR NB MO \
    TC RU RH PD AG CD IN SN SB TE I XE CS BA LA CE PR ND PM SM EU GD TB DY HO ER TM YB LU HF TA W RE OS IR PT AU HG TL \
    PB BI PO AT RN FR RA AC TH PA U NP PU AM CM BK CF ES FM MD NO LR D X";

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

/// The element by the atom name in its four columns: one-letter elements stand in the second
/// column, so ` CA ` is a carbon and `CA  ` calcium; four-letter names that begin with H are
/// hydrogens.
pub(crate) fn from_pdb_name(columns: &str, hetero: bool) -> &'static str {
    let bytes = columns.as_bytes();
    let first = bytes.first().copied().unwrap_or(b' ');
    let starts_in_first_column = first.is_ascii_alphabetic();
    let is_full = columns.trim().len() == 4;
    if starts_in_first_column && !is_full && hetero {
        let two: String = columns
            .chars()
            .take(2)
            .filter(char::is_ascii_alphabetic)
            .collect();
        if let Some(element) = known(&two).filter(|element| element.len() == 2 || two.len() == 1) {
            return element;
        }
    }
    from_name(columns)
}

/// The element by a bare atom name: its first letter, hydrogens perhaps after a digit.
pub(crate) fn from_name(name: &str) -> &'static str {
    let first = name
        .chars()
        .find(char::is_ascii_alphabetic)
        .map(|letter| letter.to_string())
        .unwrap_or_default();
    known(&first).unwrap_or("X")
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
