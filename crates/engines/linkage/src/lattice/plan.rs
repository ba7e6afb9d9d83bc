//! A lattice with its defects, square by square and rod by rod.

use super::cell::CellKind;
use super::network::{Corner, Edges, Network, Rod, Square};
use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;

/// Mass of each component of a flexible cell, as a share of the mass of all squares.
const CELL_MASS_SHARE: f64 = 0.1;

/// A lattice of equal squares, and what differs from it.
///
/// Squares are named by row and column, from 0 at the upper left; vertices are 1 upper left, 2
/// upper right, 3 lower left, 4 lower right at θ = 0.
///
/// ```
/// use protomer_linkage::lattice::Plan;
/// let plan = Plan {
///     rows: 4,
///     columns: 4,
///     removed_squares: vec![[1, 2]],
///     ..Plan::default()
/// };
/// let network = plan.network()?;
/// assert_eq!((network.squares.len(), network.rods.len()), (15, 20));
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Rows of squares.
    pub rows: usize,
    /// Columns of squares.
    pub columns: usize,
    /// Length of the rods, r0.
    pub rod_length: f64,
    /// Edges of the lattice: open or periodic.
    pub edges: Edges,
    /// Whether the cell of a periodic lattice can change.
    pub cell: CellKind,
    /// Mass of each component of a flexible cell; a tenth of that of all squares if left out.
    pub cell_mass: Option<f64>,
    /// The angle of the coherent state for which a periodic cell is made, rad.
    pub angle: f64,
    /// The square.
    pub square: Square,
    /// Squares that differ.
    pub other_squares: Vec<OtherSquare>,
    /// The rods, if they are not those of the lattice.
    pub rods: Option<Vec<ListedRod>>,
    /// Rods that are missing: row, column and vertex of either end.
    pub removed_rods: Vec<[usize; 3]>,
    /// Squares that are missing, with their rods: row and column.
    pub removed_squares: Vec<[usize; 2]>,
}

/// A square that differs from the others. What is left out is as in them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherSquare {
    /// Row and column, from 0 at the upper left.
    pub at: [usize; 2],
    /// Distance from the centre to a corner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_diagonal: Option<f64>,
    /// Mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Moment of inertia about the centre; if left out, that of the same material, in proportion to
    /// m l².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia: Option<f64>,
}

/// A rod of a list.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedRod {
    /// Row, column and vertex (1 to 4) of the first end.
    pub from: [usize; 3],
    /// Row, column and vertex (1 to 4) of the second end.
    pub to: [usize; 3],
    /// Length of the rod; r0 if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
}

impl Default for Plan {
    /// The open C98 RhuA crystal: 10 x 10 unit squares joined by rods of 3/22.
    fn default() -> Self {
        Self {
            rows: 10,
            columns: 10,
            rod_length: 3.0 / 22.0,
            edges: Edges::Open,
            cell: CellKind::Fixed,
            cell_mass: None,
            angle: FRAC_PI_4,
            square: Square::default(),
            other_squares: Vec::new(),
            rods: None,
            removed_rods: Vec::new(),
            removed_squares: Vec::new(),
        }
    }
}

impl Plan {
    /// The network of this plan.
    ///
    /// # Errors
    /// Those of [`Network::lattice`] and [`Network::check`]; [`CrystalError::NoSuchSquare`],
    /// [`CrystalError::NoSuchVertex`] and [`CrystalError::NoSuchRod`] name the setting that points
    /// to nothing.
    pub fn network(&self) -> Result<Network> {
        let mut network = Network::lattice(
            self.rows,
            self.columns,
            self.rod_length,
            self.square,
            self.edges,
            self.angle,
        )?;
        for other in &self.other_squares {
            let square = self.square_at("other_squares", other.at)?;
            network.squares[square] = other.square(&self.square);
        }
        if let Some(listed) = &self.rods {
            network.rods.clear();
            for rod in listed {
                network.rods.push(self.listed_rod(rod)?);
            }
        }
        for end in &self.removed_rods {
            self.remove_rods_at(*end, &mut network.rods)?;
        }
        let mut removed = BTreeSet::new();
        for place in &self.removed_squares {
            removed.insert(self.square_at("removed_squares", *place)?);
        }
        if !removed.is_empty() {
            network = network.without_squares(&Vec::from_iter(removed))?;
        }
        if self.cell == CellKind::Flexible {
            let mut mass = 0.0;
            for square in &network.squares {
                mass += CELL_MASS_SHARE * square.mass;
            }
            network = network.with_flexible_cell(self.cell_mass.unwrap_or(mass))?;
        }
        network.check()?;
        Ok(network)
    }

    fn square_at(&self, setting: &'static str, [row, column]: [usize; 2]) -> Result<usize> {
        if row < self.rows && column < self.columns {
            return Ok(row * self.columns + column);
        }
        Err(CrystalError::NoSuchSquare {
            setting,
            row,
            column,
            rows: self.rows,
            columns: self.columns,
        })
    }

    fn corner_at(&self, setting: &'static str, place: [usize; 3]) -> Result<Corner> {
        let [row, column, vertex] = place;
        let square = self.square_at(setting, [row, column])?;
        match u8::try_from(vertex) {
            Ok(vertex @ 1..=4) => Ok(Corner { square, vertex }),
            _ => Err(CrystalError::NoSuchVertex { setting, vertex }),
        }
    }

    fn listed_rod(&self, rod: &ListedRod) -> Result<Rod> {
        Ok(Rod {
            from: self.corner_at("rods", rod.from)?,
            to: self.corner_at("rods", rod.to)?,
            length: rod.length.unwrap_or(self.rod_length),
            image: [0, 0],
        })
    }

    fn remove_rods_at(&self, end: [usize; 3], rods: &mut Vec<Rod>) -> Result<()> {
        let corner = self.corner_at("removed_rods", end)?;
        let before = rods.len();
        rods.retain(|rod| rod.from != corner && rod.to != corner);
        if rods.len() == before {
            return Err(CrystalError::NoSuchRod { end });
        }
        Ok(())
    }
}

impl OtherSquare {
    /// The square, where the others are `usual`.
    fn square(&self, usual: &Square) -> Square {
        let half_diagonal = self.half_diagonal.unwrap_or(usual.half_diagonal);
        let mass = self.mass.unwrap_or(usual.mass);
        let usual_ratio = usual.inertia / (usual.mass * usual.half_diagonal * usual.half_diagonal);
        let same_material = usual_ratio * mass * half_diagonal * half_diagonal;
        Square {
            half_diagonal,
            mass,
            inertia: self.inertia.unwrap_or(same_material),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_plan_names_must_be_there() {
        let beyond = Plan {
            removed_squares: vec![[10, 0]],
            ..Plan::default()
        };
        let error = beyond.network().unwrap_err().to_string();
        assert!(
            error.contains("removed_squares") && error.contains("0 to 9"),
            "{error}"
        );
        let vertex = Plan {
            removed_rods: vec![[0, 0, 5]],
            ..Plan::default()
        };
        let error = vertex.network().unwrap_err().to_string();
        assert!(error.contains("vertex 5"), "{error}");
        let free_corner = Plan {
            removed_rods: vec![[0, 0, 1]],
            ..Plan::default()
        };
        let error = free_corner.network().unwrap_err().to_string();
        assert!(error.contains("no rod ends"), "{error}");
    }

    #[test]
    fn other_squares_are_of_the_same_material() {
        let plan = Plan {
            other_squares: vec![OtherSquare {
                at: [0, 1],
                half_diagonal: Some(0.9),
                mass: Some(2.0),
                inertia: None,
            }],
            ..Plan::default()
        };
        let other = plan.network().unwrap().squares[1];
        assert!((other.inertia - 2.0 * 0.81 / 3.0).abs() < 1e-15);
    }
}
