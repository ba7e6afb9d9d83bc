//! The columns of the table of properties, and a row of it.

use super::structure::{Properties, letters};

const FIRST: [&str; 15] = [
    "entry",
    "residues",
    "radius_of_gyration_angstrom",
    "extent_1_angstrom",
    "extent_2_angstrom",
    "extent_3_angstrom",
    "net_charge_e",
    "spacing_angstrom",
    "rotation_w",
    "rotation_x",
    "rotation_y",
    "rotation_z",
    "middle_x_angstrom",
    "middle_y_angstrom",
    "middle_z_angstrom",
];

/// Names of the numeric columns.
pub fn columns() -> Vec<String> {
    let mut columns = FIRST.map(str::to_owned).to_vec();
    for letter in letters() {
        columns.push(format!("composition_{letter}"));
    }
    columns
}

/// The row of a sample, with the position of its entry in the manifest.
pub fn row(entry: usize, p: &Properties) -> Vec<f64> {
    let mut row = vec![
        entry as f64,
        p.residues as f64,
        p.radius_of_gyration_angstrom,
    ];
    row.extend(p.extents_angstrom);
    row.extend([p.net_charge_e, p.spacing_angstrom]);
    row.extend(p.rotation_wxyz);
    row.extend(p.middle_angstrom);
    row.extend(p.composition);
    row
}

/// The entry and the properties in a row of the table; the inverse of [`row`].
pub fn properties(row: &[f64]) -> (usize, Properties) {
    let cell = |column: usize| row.get(column).copied().unwrap_or(f64::NAN);
    let properties = Properties {
        residues: cell(1) as usize,
        radius_of_gyration_angstrom: cell(2),
        extents_angstrom: std::array::from_fn(|n| cell(3 + n)),
        net_charge_e: cell(6),
        spacing_angstrom: cell(7),
        rotation_wxyz: std::array::from_fn(|n| cell(8 + n)),
        middle_angstrom: std::array::from_fn(|n| cell(12 + n)),
        composition: std::array::from_fn(|n| cell(15 + n)),
    };
    (cell(0) as usize, properties)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_number_per_column_and_gives_the_properties_back() {
        let numbers: Vec<f64> = (0..columns().len()).map(|n| n as f64).collect();
        let (entry, read) = properties(&numbers);
        assert_eq!(row(entry, &read), numbers);
    }
}
