//! Small structures written line by line, for tests of one rule each.

use protomer_body::structure::{Selection, SelectionSettings, Structure};

/// One PDB coordinate line; `code` is the alternate location.
pub fn line(
    record: &str,
    name: &str,
    code: char,
    residue: &str,
    place: &str,
    at: [f64; 3],
    occupancy: f64,
) -> String {
    let name = if name.len() < 4 {
        format!(" {name:<3}")
    } else {
        name.to_string()
    };
    let [x, y, z] = at;
    format!(
        "{record:<6}    1 {name}{code}{residue:>3} {place:<6}   {x:8.3}{y:8.3}{z:8.3}{occupancy:6.2}  0.00\n"
    )
}

pub fn atom(name: &str, residue: &str, place: &str, at: [f64; 3]) -> String {
    line("ATOM", name, ' ', residue, place, at, 1.0)
}

/// N, CA, C, O of residue `i` of a straight chain along x with proper peptide bonds, and a CB.
pub fn residue(record: &str, name: &str, place: &str, i: usize) -> String {
    let x = 3.8 * i as f64;
    let backbone = [
        ("N", 0.0, 0.0),
        ("CA", 1.2, 0.8),
        ("C", 2.47, 0.0),
        ("O", 2.5, -1.2),
        ("CB", 1.2, 2.3),
    ];
    backbone
        .iter()
        .map(|(atom, dx, y)| line(record, atom, ' ', name, place, [x + dx, *y, 0.0], 1.0))
        .collect()
}

pub fn select(text: &str) -> Selection {
    select_with(text, &SelectionSettings::default())
}

pub fn select_with(text: &str, settings: &SelectionSettings) -> Selection {
    Structure::read("test.pdb", text.as_bytes())
        .unwrap()
        .select(settings)
        .unwrap()
}
