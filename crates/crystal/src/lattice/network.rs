//! What is joined to what.

use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

/// A rigid square, in reduced units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Square {
    /// From the centre to a corner, l.
    pub half_diagonal: f64,
    /// Mass.
    pub mass: f64,
    /// Moment of inertia about the centre.
    pub inertia: f64,
}

impl Default for Square {
    /// The unit square of the paper: l = 1, m = 1, I = l²/3.
    fn default() -> Self {
        Self {
            half_diagonal: 1.0,
            mass: 1.0,
            inertia: 1.0 / 3.0,
        }
    }
}

/// A corner of a square, k = 1 to 4 in the paper's numbering: at θ + 135°, θ + 45°, θ + 225° and
/// θ - 45°.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corner {
    /// Index of the square.
    pub square: usize,
    /// 1 to 4.
    pub vertex: u8,
}

impl Corner {
    /// From the centre of a square of half-diagonal 1 at θ = 0 to this corner.
    pub fn direction(self) -> [f64; 2] {
        corner_direction(self.vertex)
    }
}

/// A massless rigid rod between two corners.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// Where it begins.
    pub from: Corner,
    /// Where it ends.
    pub to: Corner,
    /// Its length, r0.
    pub length: f64,
    /// Which periodic image of the second square it leads to, in cells along x and y.
    #[serde(default)]
    pub image: [i32; 2],
}

/// What is at the edges of a lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Edges {
    /// Nothing.
    Open,
    /// The opposite edge.
    Periodic,
}

/// Squares and rods. Row i and column j of a lattice of `columns` columns is square p = i ·
/// columns + j, at x growing with j and y falling with i.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Rows and columns, for networks that are cut from a lattice; they give each square its sign
    /// (-1)^(i+j).
    pub rows: usize,
    /// See `rows`.
    pub columns: usize,
    /// The squares, row by row.
    pub squares: Vec<Square>,
    /// The rods.
    pub rods: Vec<Rod>,
    /// Edges of the periodic cell along x and y.
    #[serde(default)]
    pub cell: Option<[f64; 2]>,
    /// Row and column of every square, where some are missing from the lattice; otherwise they fill
    /// it row by row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub places: Option<Vec<[usize; 2]>>,
}

/// The corner of the unit square (half-diagonal 1) at θ = 0.
pub(crate) fn corner_direction(vertex: u8) -> [f64; 2] {
    let h = FRAC_1_SQRT_2;
    match vertex {
        1 => [-h, h],
        2 => [h, h],
        3 => [-h, -h],
        _ => [h, -h],
    }
}

impl Network {
    /// The lattice of the paper (its table I): every square joined to its four neighbours, corner
    /// to corner.
    ///
    /// For `Edges::Periodic` the cell is that of the state at `angle`, θ = (-1)^(i+j) angle, in
    /// which the rods lie along x and y: the distance of neighbours is 2 l cos(angle - π/4) + r0.
    ///
    /// ```
    /// use protomer_crystal::lattice::{Edges, Network, Square};
    /// let network = Network::lattice(10, 10, 3.0 / 22.0, Square::default(), Edges::Open, std::f64::consts::FRAC_PI_4)?;
    /// assert_eq!(network.rods.len(), 180);
    /// # Ok::<(), protomer_crystal::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a rod length or square that is not positive,
    /// [`CrystalError::BadNetwork`] for no squares, or periodic edges with an odd number of rows or
    /// columns, where the checkerboard does not close.
    pub fn lattice(
        rows: usize,
        columns: usize,
        rod_length: f64,
        square: Square,
        edges: Edges,
        angle: f64,
    ) -> Result<Self> {
        if rows == 0 || columns == 0 {
            return Err(CrystalError::BadNetwork(
                "the lattice has no squares; give at least one row and column".into(),
            ));
        }
        let periodic = edges == Edges::Periodic;
        if periodic && (rows % 2 == 1 || columns % 2 == 1) {
            return Err(CrystalError::BadNetwork(format!(
                "{rows} x {columns} squares cannot be periodic: neighbours must turn in opposite directions, so give an \
                 even number of rows and columns"
            )));
        }
        let mut rods = Vec::new();
        for i in 0..rows {
            for j in 0..columns {
                let even = (i + j) % 2 == 0;
                let here = |vertex| Corner {
                    square: i * columns + j,
                    vertex,
                };
                if j + 1 < columns || periodic {
                    let to = Corner {
                        square: i * columns + (j + 1) % columns,
                        vertex: if even { 3 } else { 1 },
                    };
                    let from = here(if even { 4 } else { 2 });
                    rods.push(Rod {
                        from,
                        to,
                        length: rod_length,
                        image: [i32::from(j + 1 == columns), 0],
                    });
                }
                if i + 1 < rows || periodic {
                    let to = Corner {
                        square: (i + 1) % rows * columns + j,
                        vertex: if even { 1 } else { 2 },
                    };
                    let from = here(if even { 3 } else { 4 });
                    rods.push(Rod {
                        from,
                        to,
                        length: rod_length,
                        image: [0, -i32::from(i + 1 == rows)],
                    });
                }
            }
        }
        let squares = vec![square; rows * columns];
        let distance = spacing(rod_length, square.half_diagonal, angle);
        let cell = periodic.then_some([columns as f64 * distance, rows as f64 * distance]);
        let network = Self {
            rows,
            columns,
            squares,
            rods,
            cell,
            places: None,
        };
        network.check()?;
        Ok(network)
    }

    /// Row and column of a square.
    pub fn place(&self, square: usize) -> [usize; 2] {
        match &self.places {
            Some(places) => places[square],
            None => [square / self.columns, square % self.columns],
        }
    }

    /// The square in a row and column; `None` where it is missing.
    pub fn at(&self, row: usize, column: usize) -> Option<usize> {
        if row >= self.rows || column >= self.columns {
            return None;
        }
        match &self.places {
            Some(places) => places.iter().position(|place| *place == [row, column]),
            None => Some(row * self.columns + column),
        }
    }

    /// +1 for squares with even i + j, -1 for the others.
    pub fn sign(&self, square: usize) -> f64 {
        let [row, column] = self.place(square);
        if (row + column).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    }

    /// The network without some of its squares and the rods that end there; the others move up in
    /// the list.
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] if no square is left.
    pub fn without_squares(&self, removed: &[usize]) -> Result<Self> {
        let kept: Vec<usize> = (0..self.squares.len())
            .filter(|square| !removed.contains(square))
            .collect();
        let corner = |corner: Corner| {
            kept.iter()
                .position(|square| *square == corner.square)
                .map(|square| Corner { square, ..corner })
        };
        let rods = self.rods.iter().filter_map(|rod| {
            Some(Rod {
                from: corner(rod.from)?,
                to: corner(rod.to)?,
                ..*rod
            })
        });
        let network = Self {
            rods: rods.collect(),
            places: Some(kept.iter().map(|square| self.place(*square)).collect()),
            squares: kept.iter().map(|square| self.squares[*square]).collect(),
            ..*self
        };
        network.check()?;
        Ok(network)
    }

    /// Checks what the types cannot.
    ///
    /// # Errors
    /// Names the square or rod that makes no sense.
    pub fn check(&self) -> Result<()> {
        let positive = |setting: &'static str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(())
            } else {
                Err(CrystalError::BadSetting {
                    setting,
                    value,
                    requirement: "positive",
                })
            }
        };
        if let Some(places) = &self.places {
            let outside = places
                .iter()
                .position(|[row, column]| *row >= self.rows || *column >= self.columns);
            if places.len() != self.squares.len() || outside.is_some() {
                return Err(CrystalError::BadNetwork(format!(
                    "{} places in {} rows of {} columns do not fit {} squares",
                    places.len(),
                    self.rows,
                    self.columns,
                    self.squares.len()
                )));
            }
        }
        let fills = self.places.is_some() || self.rows * self.columns == self.squares.len();
        if self.squares.is_empty() || !fills {
            return Err(CrystalError::BadNetwork(format!(
                "{} rows of {} columns are not {} squares",
                self.rows,
                self.columns,
                self.squares.len()
            )));
        }
        for square in &self.squares {
            positive("half_diagonal", square.half_diagonal)?;
            positive("mass", square.mass)?;
            positive("inertia", square.inertia)?;
        }
        for edge in self.cell.iter().flatten() {
            positive("cell", *edge)?;
        }
        for (index, rod) in self.rods.iter().enumerate() {
            positive("rod_length", rod.length)?;
            let bad =
                |problem: String| Err(CrystalError::BadNetwork(format!("rod {index} {problem}")));
            for corner in [rod.from, rod.to] {
                if corner.square >= self.squares.len() {
                    return bad(format!(
                        "ends at square {}, but there are {}",
                        corner.square,
                        self.squares.len()
                    ));
                }
                if !(1..=4).contains(&corner.vertex) {
                    return bad(format!(
                        "ends at vertex {}; vertices are 1 to 4",
                        corner.vertex
                    ));
                }
            }
            if rod.from.square == rod.to.square && rod.image == [0, 0] {
                return bad(format!("joins square {} to itself", rod.from.square));
            }
            if rod.image != [0, 0] && self.cell.is_none() {
                return bad("leads to a periodic image, but the network has no cell".into());
            }
        }
        Ok(())
    }
}

/// The distance of neighbouring centres in the coherent state θ = (-1)^(i+j) angle with rods along
/// x and y.
pub(crate) fn spacing(rod_length: f64, half_diagonal: f64, angle: f64) -> f64 {
    2.0 * half_diagonal * (angle - std::f64::consts::FRAC_PI_4).cos() + rod_length
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::lattice::State;

    #[test]
    fn a_lattice_with_a_hole_keeps_its_places_and_signs() {
        let full = Network::lattice(3, 4, 0.2, Square::default(), Edges::Open, 0.5).unwrap();
        let holed = full.without_squares(&[5, 0]).unwrap();
        assert_eq!(
            (
                holed.squares.len(),
                holed.at(0, 0),
                holed.at(1, 1),
                holed.at(3, 0)
            ),
            (10, None, None, None)
        );
        // A corner square has two rods, one in the middle four.
        assert_eq!(holed.rods.len(), full.rods.len() - 6);
        let (state, before) = (State::coherent(&holed, 0.5), State::coherent(&full, 0.5));
        for square in 0..10 {
            let [row, column] = holed.place(square);
            assert_eq!(holed.at(row, column), Some(square));
            let old = full.at(row, column).unwrap();
            assert_eq!(holed.sign(square), full.sign(old));
            assert_eq!(
                state.positions[3 * square..3 * square + 3],
                before.positions[3 * old..3 * old + 3]
            );
        }
        assert!(full.without_squares(&(0..12).collect::<Vec<_>>()).is_err());
        assert!(
            Network {
                places: Some(vec![[9, 9]; 12]),
                ..full
            }
            .check()
            .is_err()
        );
    }
}
