//! What is joined to what.

use crate::error::{CrystalError, Result, require_positive};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

/// A rigid square, in reduced units.
///
/// ```
/// use protomer_linkage::lattice::Square;
/// let heavy = Square { mass: 2.0, inertia: 2.0 / 3.0, ..Square::default() };
/// assert_eq!(heavy.half_diagonal, 1.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Square {
    /// Distance from the centre to a corner, l.
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
///
/// ```
/// use protomer_linkage::lattice::Corner;
/// let upper_right = Corner { square: 0, vertex: 2 };
/// let [x, y] = upper_right.direction();
/// assert!(x > 0.0 && x == y);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corner {
    /// Index of the square.
    pub square: usize,
    /// Number of the corner, 1 to 4.
    pub vertex: u8,
}

impl Corner {
    /// The vector from the centre of a square of half-diagonal 1 at θ = 0 to this corner.
    pub fn direction(self) -> [f64; 2] {
        let h = FRAC_1_SQRT_2;
        match self.vertex {
            1 => [-h, h],
            2 => [h, h],
            3 => [-h, -h],
            _ => [h, -h],
        }
    }
}

/// A massless rigid rod between two corners.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// First end of the rod.
    pub from: Corner,
    /// Second end of the rod.
    pub to: Corner,
    /// Length of the rod, r0.
    pub length: f64,
    /// The periodic image of the second square at which the rod ends, in cells along x and y.
    #[serde(default)]
    pub image: [i32; 2],
}

impl Rod {
    /// The corner at one end: 0 is `from`, 1 is `to`.
    pub(crate) fn corner_at(&self, end: u8) -> Corner {
        if end == 0 { self.from } else { self.to }
    }
}

protomer_kernel::choices! {
    /// Edges of a lattice: open or periodic.
    pub enum Edges {
        /// Edges with nothing beyond them.
        Open = "open",
        /// Edges that continue at the opposite edge.
        Periodic = "periodic",
    }
}

/// Squares and the rods that join them.
///
/// Row i and column j of a lattice with `columns` columns is square p = i · columns + j; x grows
/// with j and y falls with i.
///
/// ```
/// use protomer_linkage::lattice::{Edges, Network, Square};
/// let lattice = Network::lattice(3, 3, 0.2, Square::default(), Edges::Open, 0.5)?;
/// assert_eq!((lattice.squares.len(), lattice.rods.len()), (9, 12));
/// // The square in the middle is missing, and its four rods with it.
/// let with_a_hole = lattice.without_squares(&[4])?;
/// assert_eq!((with_a_hole.squares.len(), with_a_hole.rods.len()), (8, 8));
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Rows of the lattice from which the network is cut. Rows and columns give each square its
    /// sign (-1)^(i+j).
    pub rows: usize,
    /// Columns of the lattice from which the network is cut.
    pub columns: usize,
    /// The squares, row by row.
    pub squares: Vec<Square>,
    /// The rods.
    pub rods: Vec<Rod>,
    /// Edges of the periodic cell along x and y, of a flexible one those of the coherent state.
    #[serde(default)]
    pub cell: Option<[f64; 2]>,
    /// Mass of each component of a flexible cell; `None` for a fixed one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell_mass: Option<f64>,
    /// Row and column of every square, where some are missing from the lattice; otherwise the
    /// squares fill it row by row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub places: Option<Vec<[usize; 2]>>,
}

impl Network {
    /// The lattice of the paper (its table I): every square joined to its four neighbours, corner
    /// to corner.
    ///
    /// For `Edges::Periodic` the cell is that of the state at `angle`, θ = (-1)^(i+j) angle, in
    /// which the rods lie along x and y: the distance of neighbours is 2 l cos(angle - π/4) + r0.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let open = std::f64::consts::FRAC_PI_4;
    /// let network = Network::lattice(10, 10, 3.0 / 22.0, Square::default(), Edges::Open, open)?;
    /// assert_eq!(network.rods.len(), 180);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a rod length or square that is not positive,
    /// [`CrystalError::BadNetwork`] for a lattice without squares, or for periodic edges with an
    /// odd number of rows or columns, where the checkerboard does not close.
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
                "{rows} x {columns} squares cannot be periodic: neighbours must turn in opposite \
                 directions, so give an even number of rows and columns"
            )));
        }
        let distance = spacing(rod_length, square.half_diagonal, angle);
        let network = Self {
            rows,
            columns,
            squares: vec![square; rows * columns],
            rods: lattice_rods(rows, columns, rod_length, periodic),
            cell: periodic.then_some([columns as f64 * distance, rows as f64 * distance]),
            cell_mass: None,
            places: None,
        };
        network.check()?;
        Ok(network)
    }

    /// The network with a flexible cell, each component of which has this mass.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let periodic = Network::lattice(2, 2, 0.5, Square::default(), Edges::Periodic, 0.3)?;
    /// assert_eq!(periodic.with_flexible_cell(1.0)?.coordinates(), 3 * 4 + 3);
    /// let open = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
    /// assert!(open.with_flexible_cell(1.0).is_err());
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] for open edges, [`CrystalError::BadSetting`] for a mass that is
    /// not positive.
    pub fn with_flexible_cell(mut self, mass: f64) -> Result<Self> {
        self.cell_mass = Some(mass);
        self.check()?;
        Ok(self)
    }

    /// Number of coordinates: x, y and θ of every square, and H_xx, H_yy and H_xy of a flexible
    /// cell.
    pub fn coordinates(&self) -> usize {
        3 * self.bodies()
    }

    /// The squares, and a flexible cell.
    pub(crate) fn bodies(&self) -> usize {
        self.squares.len() + usize::from(self.cell_mass.is_some())
    }

    /// The first of the coordinates of a flexible cell.
    pub(crate) fn cell_place(&self) -> Option<usize> {
        self.cell_mass.map(|_| 3 * self.squares.len())
    }

    /// Mass per coordinate of a square, or of the cell after the last one.
    pub(crate) fn inertia_per_coordinate(&self, body: usize) -> [f64; 3] {
        match self.squares.get(body) {
            Some(square) => [square.mass, square.mass, square.inertia],
            None => [self.cell_mass.unwrap_or(f64::INFINITY); 3],
        }
    }

    /// Row and column of a square.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let network = Network::lattice(2, 3, 0.5, Square::default(), Edges::Open, 0.7)?;
    /// assert_eq!((network.place(4), network.square(1, 1)), ([1, 1], Some(4)));
    /// assert_eq!(network.square(2, 0), None, "there are two rows");
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn place(&self, square: usize) -> [usize; 2] {
        match &self.places {
            Some(places) => places[square],
            None => [square / self.columns, square % self.columns],
        }
    }

    /// The square in a row and column; `None` where it is missing.
    pub fn square(&self, row: usize, column: usize) -> Option<usize> {
        if row >= self.rows || column >= self.columns {
            return None;
        }
        match &self.places {
            Some(places) => places.iter().position(|place| *place == [row, column]),
            None => Some(row * self.columns + column),
        }
    }

    /// +1 for squares with even i + j, -1 for the others.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.7)?;
    /// assert_eq!([0, 1, 2, 3].map(|square| network.sign(square)), [1.0, -1.0, -1.0, 1.0]);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn sign(&self, square: usize) -> f64 {
        let [row, column] = self.place(square);
        if (row + column).is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    }

    /// The half-diagonal of the first square, which stands for all where they are equal.
    pub(crate) fn first_half_diagonal(&self) -> f64 {
        match self.squares.first() {
            Some(square) => square.half_diagonal,
            None => 1.0,
        }
    }

    /// The network without some of its squares and the rods that end there; the other squares move
    /// up in the list.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square};
    /// let network = Network::lattice(3, 3, 0.5, Square::default(), Edges::Open, 0.7)?;
    /// let vacancy = network.without_squares(&[4])?;
    /// assert_eq!((network.rods.len(), vacancy.rods.len()), (12, 8));
    /// assert_eq!(vacancy.square(1, 1), None);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] if no square is left.
    pub fn without_squares(&self, removed: &[usize]) -> Result<Self> {
        let mut new_index = vec![None; self.squares.len()];
        let (mut squares, mut places) = (Vec::new(), Vec::new());
        for (old, square) in self.squares.iter().enumerate() {
            if !removed.contains(&old) {
                new_index[old] = Some(squares.len());
                squares.push(*square);
                places.push(self.place(old));
            }
        }
        let mut rods = Vec::new();
        for rod in &self.rods {
            let ends = (new_index[rod.from.square], new_index[rod.to.square]);
            if let (Some(from), Some(to)) = ends {
                let mut new_rod = *rod;
                new_rod.from.square = from;
                new_rod.to.square = to;
                rods.push(new_rod);
            }
        }
        let network = Self {
            squares,
            rods,
            places: Some(places),
            ..*self
        };
        network.check()?;
        Ok(network)
    }

    /// Checks what the types cannot.
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] or [`CrystalError::BadSetting`] names the square or rod that
    /// makes no sense.
    pub fn check(&self) -> Result<()> {
        self.check_places()?;
        for square in &self.squares {
            require_positive("half_diagonal", square.half_diagonal)?;
            require_positive("mass", square.mass)?;
            require_positive("inertia", square.inertia)?;
        }
        for edge in self.cell.iter().flatten() {
            require_positive("cell", *edge)?;
        }
        if let Some(mass) = self.cell_mass {
            require_positive("cell_mass", mass)?;
            if self.cell.is_none() {
                return Err(CrystalError::BadNetwork(
                    "a lattice with open edges has no cell to be flexible; give edges = \
                     \"periodic\", or remove the mass of the cell"
                        .into(),
                ));
            }
        }
        for (index, rod) in self.rods.iter().enumerate() {
            require_positive("rod_length", rod.length)?;
            if let Some(problem) = self.problem_of_rod(rod) {
                return Err(CrystalError::BadNetwork(format!("rod {index} {problem}")));
            }
        }
        Ok(())
    }

    fn check_places(&self) -> Result<()> {
        let (rows, columns, squares) = (self.rows, self.columns, self.squares.len());
        if let Some(places) = &self.places {
            let is_outside = |place: &[usize; 2]| place[0] >= rows || place[1] >= columns;
            if places.len() != squares || places.iter().any(is_outside) {
                return Err(CrystalError::BadNetwork(format!(
                    "{} places in {rows} rows of {columns} columns do not fit {squares} squares",
                    places.len()
                )));
            }
        }
        let fills = self.places.is_some() || rows * columns == squares;
        if self.squares.is_empty() || !fills {
            return Err(CrystalError::BadNetwork(format!(
                "{rows} rows of {columns} columns are not {squares} squares"
            )));
        }
        Ok(())
    }

    fn problem_of_rod(&self, rod: &Rod) -> Option<String> {
        let squares = self.squares.len();
        for Corner { square, vertex } in [rod.from, rod.to] {
            if square >= squares {
                return Some(format!("ends at square {square}, but there are {squares}"));
            }
            if !(1..=4).contains(&vertex) {
                return Some(format!("ends at vertex {vertex}; vertices are 1 to 4"));
            }
        }
        if rod.from.square == rod.to.square && rod.image == [0, 0] {
            return Some(format!("joins square {} to itself", rod.from.square));
        }
        if rod.image != [0, 0] && self.cell.is_none() {
            return Some("leads to a periodic image, but the network has no cell".into());
        }
        None
    }
}

/// Table I of the paper: rods to the right and below every square, in this order.
fn lattice_rods(rows: usize, columns: usize, length: f64, periodic: bool) -> Vec<Rod> {
    let mut rods = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let index = i * columns + j;
            let even = (i + j).is_multiple_of(2);
            if j + 1 < columns || periodic {
                let right = i * columns + (j + 1) % columns;
                let [from, to] = if even { [4, 3] } else { [2, 1] };
                let image = [i32::from(j + 1 == columns), 0];
                rods.push(rod([index, right], [from, to], length, image));
            }
            if i + 1 < rows || periodic {
                let below = (i + 1) % rows * columns + j;
                let [from, to] = if even { [3, 1] } else { [4, 2] };
                let image = [0, -i32::from(i + 1 == rows)];
                rods.push(rod([index, below], [from, to], length, image));
            }
        }
    }
    rods
}

fn rod(squares: [usize; 2], vertices: [u8; 2], length: f64, image: [i32; 2]) -> Rod {
    Rod {
        from: Corner {
            square: squares[0],
            vertex: vertices[0],
        },
        to: Corner {
            square: squares[1],
            vertex: vertices[1],
        },
        length,
        image,
    }
}

/// The distance of neighbouring centres in the coherent state θ = (-1)^(i+j) angle with rods along
/// x and y.
pub(crate) fn spacing(rod_length: f64, half_diagonal: f64, angle: f64) -> f64 {
    2.0 * half_diagonal * (angle - FRAC_PI_4).cos() + rod_length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::State;

    #[test]
    fn a_lattice_with_a_hole_keeps_its_places_and_signs() {
        let full = Network::lattice(3, 4, 0.2, Square::default(), Edges::Open, 0.5).unwrap();
        let holed = full.without_squares(&[5, 0]).unwrap();
        assert_eq!(
            (
                holed.squares.len(),
                holed.square(0, 0),
                holed.square(1, 1),
                holed.square(3, 0)
            ),
            (10, None, None, None)
        );
        // A corner square has two rods, one in the middle four.
        assert_eq!(holed.rods.len(), full.rods.len() - 6);
        let (state, before) = (State::coherent(&holed, 0.5), State::coherent(&full, 0.5));
        for square in 0..10 {
            let [row, column] = holed.place(square);
            assert_eq!(holed.square(row, column), Some(square));
            let old = full.square(row, column).unwrap();
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
