//! A solved potential, anywhere in space.

use super::coulomb_source::at_points;
use crate::charge_tree::ChargeTree;
use crate::charged_sphere::ChargedSphere;
use crate::grid::{Grid, ScalarField, Stencil, set_points};
use crate::point_charges::PointCharges;
use protomer_kernel::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// A solved potential.
///
/// ```
/// use protomer_field::{ChargedSphere, DielectricModel, SolveSettings, solve};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: -1.0 };
/// let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?);
/// let potential = solve(&[ion], &model, &SolveSettings::default())?;
/// assert!(potential.solvation_energy_kt < 0.0);
/// assert!(potential.value_at(&Vec3::new(5.0, 0.0, 0.0)).is_some_and(|value| value < 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Potential {
    /// The reaction field u inside, φ outside, kT/e.
    reduced: ScalarField,
    sides: Arc<Sides>,
    /// The Coulomb potential inside.
    coulomb: PointCharges,
    tree: ChargeTree,
    /// Half the sum of charge times reaction field and, where ions follow Boltzmann factors, their free
    /// energy beyond that, kT.
    pub solvation_energy_kt: f64,
    /// Iterations of the solver.
    pub iterations: usize,
}

/// Sides of the surface on which the points of a grid are.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// Whether a point is inside.
    pub(super) inside: Vec<bool>,
    /// Points outside, but so near that only rounding may have kept them out, ascending.
    pub(super) on_surface: Vec<usize>,
}

impl Potential {
    pub(super) fn new(
        reduced: ScalarField,
        sides: Arc<Sides>,
        tree: ChargeTree,
        spheres: &[ChargedSphere],
        excess_of_ions_kt: f64,
        iterations: usize,
    ) -> Self {
        let mut potential = Self {
            reduced,
            sides,
            coulomb: PointCharges::new(tree.sources()),
            tree,
            solvation_energy_kt: 0.0,
            iterations,
        };
        potential.solvation_energy_kt = potential.solvation_energy(spheres) + excess_of_ions_kt;
        potential
    }

    /// ½ Σ q u, kT.
    fn solvation_energy(&self, spheres: &[ChargedSphere]) -> f64 {
        let charges = spheres.par_iter().filter(|sphere| sphere.charge_e != 0.0);
        let products = charges.map(|charge| charge.charge_e * self.reaction_at(&charge.centre));
        // Collected before they are summed, so that the sum does not depend on threads.
        let products: Vec<f64> = products.collect();
        0.5 * products.iter().sum::<f64>()
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.reduced.grid
    }

    /// Whether each point of the grid is inside the surface.
    pub(crate) fn inside(&self) -> &[bool] {
        &self.sides.inside
    }

    /// Whether a point of the grid is outside the surface, however distances are rounded.
    pub(crate) fn is_outside(&self, point: usize) -> bool {
        // Rounding may have put a point of the surface outside; as such it must not be trusted.
        !self.sides.inside[point] && self.sides.on_surface.binary_search(&point).is_err()
    }

    /// The potential at a point of the grid outside the surface, kT/e.
    pub(crate) fn at_outer_point(&self, point: usize) -> f64 {
        self.reduced.values[point]
    }

    /// u inside and φ outside at a point of the grid, kT/e.
    pub(crate) fn reduced_at_point(&self, point: usize) -> f64 {
        self.reduced.values[point]
    }

    /// u inside and φ outside, kT/e, interpolated across the surface as if it were smooth there.
    pub(super) fn reduced_at(&self, place: &Vec3) -> Option<f64> {
        self.reduced.value_at(place)
    }

    /// The reaction field φ - φ_C at a place, kT/e: cubic deep inside, trilinear near the surface; zero
    /// outside the grid.
    pub fn reaction_at(&self, place: &Vec3) -> f64 {
        let Some((cell, part)) = self.reduced.grid.locate(place) else {
            return 0.0;
        };
        self.reaction_in(cell, part, |point| self.reaction_at_point(point))
    }

    /// The reaction field in a cell, kT/e, from `reaction` at its corners where the surface is near.
    fn reaction_in(
        &self,
        cell: [usize; 3],
        part: [f64; 3],
        reaction: impl Fn(usize) -> f64,
    ) -> f64 {
        let grid = &self.reduced.grid;
        // The cubic needs 64 points inside; near the surface the kink of φ would spoil it.
        if let Some(points) = grid.tricubic(cell, part)
            && points.points.iter().all(|point| self.sides.inside[*point])
        {
            return points.interpolate(|point| self.reduced.values[point]);
        }
        grid.corners(cell, part).interpolate(reaction)
    }

    fn reaction_at_point(&self, point: usize) -> f64 {
        let value = self.reduced.values[point];
        // Outside, φ is stored: the Coulomb part is taken out so that both sides have one quantity.
        if self.sides.inside[point] {
            value
        } else {
            value - self.coulomb.coulomb(&self.reduced.grid.point_at(point))
        }
    }

    /// Whether a corner of a cell is inside the surface.
    fn is_near_solute(&self, corners: &Stencil<8>) -> bool {
        corners.points.iter().any(|point| self.sides.inside[*point])
    }

    /// The potential at a place, kT/e; `None` outside the grid. Where all corners of the cell are
    /// outside the surface, φ itself is interpolated; elsewhere the reaction field is, and the
    /// Coulomb potential is added.
    ///
    /// ```
    /// use protomer_field::{ChargedSphere, DielectricModel, SolveSettings, solve};
    /// use protomer_kernel::{Electrolyte, Vec3};
    /// let water = DielectricModel::new(Electrolyte::in_water(298.15, 0.0)?);
    /// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 3.0, charge_e: 1.0 };
    /// let potential = solve(&[ion], &water, &SolveSettings::default())?;
    /// let coulomb = water.electrolyte.bjerrum_length_angstrom() / 8.0;
    /// let solved = potential.value_at(&Vec3::new(8.0, 0.0, 0.0));
    /// assert!(solved.is_some_and(|solved| (solved / coulomb - 1.0).abs() < 0.01));
    /// assert_eq!(potential.value_at(&Vec3::new(80.0, 0.0, 0.0)), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn value_at(&self, place: &Vec3) -> Option<f64> {
        let corners = self.reduced.grid.trilinear(place)?;
        // Any corner inside: the reaction field is smooth across, φ is not.
        if self.is_near_solute(&corners) {
            return Some(self.reaction_at(place) + self.coulomb.coulomb(place));
        }
        Some(corners.interpolate(|point| self.reduced.values[point]))
    }

    /// The potential at all points of the grid, kT/e: inside, with the error of `charge_tree`.
    pub fn field(&self) -> ScalarField {
        let mut field = self.reduced.clone();
        for (point, coulomb) in at_points(&field.grid, &self.tree, |point| self.sides.inside[point])
        {
            field.values[point] += coulomb;
        }
        field
    }

    /// The potential at whole multiples of the spacing, kT/e: that of [`value_at`](Self::value_at), inside with
    /// the error of `charge_tree`.
    pub fn on_multiples(&self) -> ScalarField {
        let grid = self.reduced.grid.on_multiples();
        let part = self.part_of_cells(&grid);
        let reaction = self.reaction_near_solute();
        let mut values = vec![0.0; grid.len()];
        set_points(grid.shape, &mut values, |cell, value| {
            // All points have the same place in their cells, so one `part` serves.
            let corners = self.reduced.grid.corners(cell, part);
            *value = match self.is_near_solute(&corners) {
                true => self.reaction_in(cell, part, |point| reaction[point]),
                false => corners.interpolate(|point| self.reduced.values[point]),
            };
        });
        let is_near = |index: usize| {
            let cell = grid.coordinates(index);
            self.is_near_solute(&self.reduced.grid.corners(cell, part))
        };
        // The Coulomb part is added only where it was taken out.
        for (point, coulomb) in at_points(&grid, &self.tree, is_near) {
            values[point] += coulomb;
        }
        ScalarField { grid, values }
    }

    /// Place in its cell of each point of a grid with one point per cell, (0..1)³.
    fn part_of_cells(&self, grid: &Grid) -> [f64; 3] {
        let origin = self.reduced.grid.origin_angstrom;
        [0, 1, 2].map(|axis| {
            let distance = grid.origin_angstrom[axis] - origin[axis];
            // Rounding may lead just out of the cell.
            (distance / grid.spacing_angstrom).clamp(0.0, 1.0)
        })
    }

    /// The reaction field at the points inside and at their neighbours, kT/e; elsewhere φ.
    fn reaction_near_solute(&self) -> Vec<f64> {
        let grid = &self.reduced.grid;
        let inside = &self.sides.inside;
        let mut is_neighbour = vec![false; inside.len()];
        let cells = Grid {
            shape: grid.shape.map(|points| points - 1),
            ..*grid
        };
        for cell in (0..cells.len()).map(|index| cells.coordinates(index)) {
            let corners = grid.corners(cell, [0.0; 3]);
            // All corners of cells at the surface, since interpolation reads them.
            if self.is_near_solute(&corners) {
                for point in corners.points {
                    is_neighbour[point] |= !inside[point];
                }
            }
        }
        let mut reaction = self.reduced.values.clone();
        for (point, coulomb) in at_points(grid, &self.tree, |point| is_neighbour[point]) {
            reaction[point] -= coulomb;
        }
        reaction
    }
}

#[cfg(test)]
mod tests {
    use crate::{ChargedSphere, DielectricModel, SolveSettings, solve};
    use protomer_kernel::{Electrolyte, Vec3};

    #[test]
    fn the_potential_at_multiples_is_that_at_each_place() {
        let sphere = |x: f64, charge_e: f64| ChargedSphere {
            centre: Vec3::new(x, 0.3, -0.2),
            radius_angstrom: 2.0,
            charge_e,
        };
        let spheres = [sphere(10.2, 1.0), sphere(13.0, -0.4)];
        let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.1).unwrap());
        let settings = SolveSettings {
            spacing_angstrom: 0.6,
            margin_angstrom: 4.0,
            ..SolveSettings::default()
        };
        let potential = solve(&spheres, &model, &settings).unwrap();
        let field = potential.on_multiples();
        for index in 0..field.grid.len() {
            let place = field.grid.point_at(index);
            for x in place.iter() {
                let multiple = x / 0.6;
                assert!((multiple - multiple.round()).abs() < 1e-9, "{place}");
            }
            let exact = potential.value_at(&place).unwrap();
            let found = field.values[index];
            assert!(
                (found - exact).abs() < 1e-6 * exact.abs().max(1.0),
                "{found} {exact}"
            );
        }
    }
}
