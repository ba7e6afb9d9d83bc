//! Operations of a space group, from its symbol.

use super::table::SPACE_GROUPS;
use nalgebra::{Matrix3, Vector3};

/// Translations are counted in parts of this number.
const PARTS: i32 = 24;
/// Largest number of operations in a cell, those of F 4 3 2.
const MOST_OPERATIONS: usize = 96;

/// An operation x' = W x + w on fractional coordinates, w between 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SymmetryOperation {
    rotation: Matrix3<i32>,
    /// w in 24ths.
    shift: Vector3<i32>,
}

impl SymmetryOperation {
    fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            shift: Vector3::zeros(),
        }
    }

    /// Reads an operation such as `-y+1/2,x,z`.
    fn parse(text: &str) -> Option<Self> {
        let mut operation = Self {
            rotation: Matrix3::zeros(),
            shift: Vector3::zeros(),
        };
        let rows: Vec<&str> = text.split(',').collect();
        for (row, terms) in rows.iter().enumerate() {
            // Each term begins with its sign.
            let spaced = terms.replace('-', " -").replace('+', " +");
            for term in spaced.split_whitespace() {
                let (sign, name) = match term.strip_prefix('-') {
                    Some(name) => (-1, name),
                    None => (1, term.trim_start_matches('+')),
                };
                match ["x", "y", "z"].iter().position(|axis| *axis == name) {
                    Some(axis) => operation.rotation[(row, axis)] += sign,
                    None => {
                        let (above, below) = name.split_once('/')?;
                        let parts: i32 = above.parse().ok()?;
                        operation.shift[row] += sign * parts * PARTS / below.parse::<i32>().ok()?;
                    }
                }
            }
        }
        (rows.len() == 3).then_some(operation.wrapped())
    }

    fn translation(shift: [i32; 3]) -> Self {
        Self {
            shift: shift.into(),
            ..Self::identity()
        }
    }

    fn wrapped(self) -> Self {
        Self {
            shift: self.shift.map(|parts| parts.rem_euclid(PARTS)),
            ..self
        }
    }

    /// The operation that does `first` and then this one.
    fn after(&self, first: &Self) -> Self {
        let operation = Self {
            rotation: self.rotation * first.rotation,
            shift: self.rotation * first.shift + self.shift,
        };
        operation.wrapped()
    }

    /// The matrix W.
    pub fn rotation(&self) -> Matrix3<f64> {
        self.rotation.map(f64::from)
    }

    /// The vector w.
    pub fn shift(&self) -> Vector3<f64> {
        self.shift.map(|parts| f64::from(parts) / f64::from(PARTS))
    }

    /// The operation with whole translations of the lattice, as `-x,y+1/2,-z+3/2`.
    ///
    /// ```
    /// use protomer_body::crystal::operations;
    /// let screw = operations("P 1 21 1", 90.0).and_then(|group| group.get(1).copied());
    /// assert_eq!(screw.map(|screw| screw.in_words([0, -1, 2])), Some("-x,y-1/2,-z+2".into()));
    /// ```
    pub fn in_words(&self, cells: [i32; 3]) -> String {
        let row = |row: usize| {
            let mut text = String::new();
            for (axis, name) in ["x", "y", "z"].iter().enumerate() {
                match self.rotation[(row, axis)] {
                    1 if text.is_empty() => text += name,
                    1 => text += &format!("+{name}"),
                    -1 => text += &format!("-{name}"),
                    _ => {}
                }
            }
            text + &fraction(self.shift[row] + PARTS * cells[row])
        };
        format!("{},{},{}", row(0), row(1), row(2))
    }
}

/// A number of 24ths with its sign, in lowest terms; empty for zero.
fn fraction(parts: i32) -> String {
    let divisor = (1..=PARTS).rev().find(|d| parts % d == 0 && PARTS % d == 0);
    let divisor = divisor.unwrap_or(1);
    match (parts / divisor, PARTS / divisor) {
        (0, _) => String::new(),
        (above, 1) => format!("{above:+}"),
        (above, below) => format!("{above:+}/{below}"),
    }
}

/// All operations of a cell of a space group, the identity first; `None` for a symbol of no group without mirrors.
///
/// A rhombohedral group has hexagonal axes where the angle γ is 120°, whatever its symbol says.
///
/// ```
/// use protomer_body::crystal::operations;
/// let count = |symbol| operations(symbol, 90.0).map(|group| group.len());
/// assert_eq!(["P 21 21 21", "P 21", "F 4 3 2", "P m m m"].map(count), [Some(4), Some(2), Some(96), None]);
/// ```
pub fn operations(symbol: &str, gamma_degree: f64) -> Option<Vec<SymmetryOperation>> {
    let symbol = in_full(symbol, gamma_degree);
    let (symbol, generators) = SPACE_GROUPS
        .iter()
        .find(|(name, _)| without_blanks(name).to_uppercase() == symbol)?;
    let mut all: Vec<SymmetryOperation> = Vec::new();
    for text in *generators {
        all.push(SymmetryOperation::parse(text)?);
    }
    let lattice = symbol.chars().next().map_or(&[][..], lattice_shifts);
    all.extend(
        lattice
            .iter()
            .map(|shift| SymmetryOperation::translation(*shift)),
    );
    Some(closure(&all))
}

/// All products of generators.
fn closure(generators: &[SymmetryOperation]) -> Vec<SymmetryOperation> {
    let mut group = vec![SymmetryOperation::identity()];
    let mut next = 0;
    while next < group.len() && group.len() <= MOST_OPERATIONS {
        for generator in generators {
            let product = generator.after(&group[next]);
            if !group.contains(&product) {
                group.push(product);
            }
        }
        next += 1;
    }
    group
}

/// A symbol without blanks, in the setting that the table has.
fn in_full(symbol: &str, gamma_degree: f64) -> String {
    let symbol = without_blanks(symbol).to_uppercase();
    let is_hexagonal = (gamma_degree - 120.0).abs() < 1.0;
    match (symbol.as_str(), symbol.strip_prefix('R')) {
        // The unique axis of short symbols is b.
        ("P2" | "P21" | "C2" | "A2" | "I2", _) => format!("{}1{}1", &symbol[..1], &symbol[1..]),
        (_, Some(remainder)) if is_hexagonal => format!("H{remainder}"),
        _ => symbol,
    }
}

fn without_blanks(symbol: &str) -> String {
    symbol.split_whitespace().collect()
}

/// Translations of a lattice in addition to whole cells, in 24ths.
fn lattice_shifts(centring: char) -> &'static [[i32; 3]] {
    match centring {
        'A' => &[[0, 12, 12]],
        'B' => &[[12, 0, 12]],
        'C' => &[[12, 12, 0]],
        'I' => &[[12, 12, 12]],
        'F' => &[[0, 12, 12], [12, 0, 12]],
        'H' => &[[16, 8, 8]],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orders of the groups by their point groups and lattices, and closure under products.
    #[test]
    fn every_group_is_closed_and_has_the_order_of_its_point_group_and_lattice() {
        for (symbol, _) in SPACE_GROUPS {
            let Some(group) = operations(symbol, 90.0) else {
                panic!("{symbol} cannot be read");
            };
            let mut rotations: Vec<Matrix3<i32>> = Vec::new();
            for operation in &group {
                assert_eq!(operation.rotation().determinant().round(), 1.0, "{symbol}");
                if !rotations.contains(&operation.rotation) {
                    rotations.push(operation.rotation);
                }
            }
            let lattice = match symbol.as_bytes()[0] {
                b'F' => 4,
                b'H' => 3,
                b'P' | b'R' => 1,
                _ => 2,
            };
            assert!(
                [1, 2, 3, 4, 6, 8, 12, 24].contains(&rotations.len()),
                "{symbol}"
            );
            assert_eq!(group.len(), lattice * rotations.len(), "{symbol}");
            for first in &group {
                for second in &group {
                    assert!(group.contains(&first.after(second)), "{symbol}");
                }
            }
        }
    }

    #[test]
    fn symbols_are_read_as_files_write_them() {
        let words = |symbol, gamma| {
            let group = operations(symbol, gamma).unwrap_or_default();
            let words = group.iter().map(|operation| operation.in_words([0, 0, 0]));
            words.collect::<Vec<_>>()
        };
        assert_eq!(words("P 21", 90.0), ["x,y,z", "-x,y+1/2,-z"]);
        assert_eq!(words("P 1 21 1", 90.0), words("P 21", 90.0));
        assert_eq!(words("R 3", 120.0).len(), 9);
        assert_eq!(words("R 3", 75.0).len(), 3);
        assert!(words("H 3 2", 120.0).contains(&"x-y+1/3,-y+2/3,-z+2/3".to_owned()));
        assert!(words("P 21 21 21", 90.0).contains(&"x+1/2,-y+1/2,-z".to_owned()));
    }
}
