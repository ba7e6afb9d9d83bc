//! A solved potential, anywhere in space.

use super::coulomb_source::at_points;
use crate::charge_tree::ChargeTree;
use crate::charged_sphere::ChargedSphere;
use crate::grid::{Grid, ScalarField};
use crate::point_charges::PointCharges;
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// A solved potential.
///
/// ```
/// use protomer_field::{ChargedSphere, DielectricModel, SolveSettings, solve};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: -1.0 };
/// let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?);
/// let potential = solve(&[ion], &model, &SolveSettings::default())?;
/// assert!(potential.solvation_energy_kt < 0.0);
/// assert!(potential.at(&Vec3::new(5.0, 0.0, 0.0)).is_some_and(|value| value < 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Potential {
    /// The reaction field u inside, φ outside, kT/e.
    reduced: ScalarField,
    sides: Sides,
    /// The Coulomb potential inside.
    coulomb: PointCharges,
    tree: ChargeTree,
    /// Half the sum of charge times reaction field, kT.
    pub solvation_energy_kt: f64,
    /// Iterations of the solver.
    pub iterations: usize,
}

/// On which side of the surface the points of a grid are.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// Whether a point is inside.
    pub(super) inside: Vec<bool>,
    /// The points that are not, but so near that only rounding may have kept them out, ascending.
    pub(super) on_surface: Vec<usize>,
}

impl Potential {
    pub(super) fn new(
        reduced: ScalarField,
        sides: Sides,
        tree: ChargeTree,
        spheres: &[ChargedSphere],
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
        potential.solvation_energy_kt = potential.solvation_energy(spheres);
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

    /// Which points of the grid are inside the surface.
    pub(crate) fn inside(&self) -> &[bool] {
        &self.sides.inside
    }

    /// Whether a point of the grid is outside the surface, however distances are rounded.
    pub(crate) fn is_outside(&self, point: usize) -> bool {
        !self.sides.inside[point] && self.sides.on_surface.binary_search(&point).is_err()
    }

    /// The potential at a point of the grid outside the surface, kT/e.
    pub(crate) fn at_outer_point(&self, point: usize) -> f64 {
        self.reduced.values[point]
    }

    /// u inside and φ outside, kT/e, interpolated across the surface as if it were smooth there.
    pub(super) fn reduced_at(&self, place: &Vec3) -> Option<f64> {
        self.reduced.at(place)
    }

    /// The reaction field φ - φ_C at a place, kT/e: cubic deep inside, trilinear near the surface.
    fn reaction_at(&self, place: &Vec3) -> f64 {
        let grid = &self.reduced.grid;
        if let Some(points) = grid.tricubic(place)
            && points.points.iter().all(|point| self.sides.inside[*point])
        {
            return points.interpolate(|point| self.reduced.values[point]);
        }
        match grid.trilinear(place) {
            Some(corners) => corners.interpolate(|point| self.reaction_at_point(point)),
            None => 0.0,
        }
    }

    fn reaction_at_point(&self, point: usize) -> f64 {
        let value = self.reduced.values[point];
        if self.sides.inside[point] {
            value
        } else {
            value - self.coulomb.coulomb(&self.reduced.grid.point_at(point))
        }
    }

    /// The potential at a place, kT/e; `None` outside the grid. Where all corners of the cell are
    /// outside the surface, φ itself is interpolated; elsewhere the reaction field is, and the
    /// Coulomb potential is added.
    pub fn at(&self, place: &Vec3) -> Option<f64> {
        let corners = self.reduced.grid.trilinear(place)?;
        if corners.points.iter().any(|point| self.sides.inside[*point]) {
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
}
