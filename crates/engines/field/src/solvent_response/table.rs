//! What a body does to charges and to displaced volume at any place, on a grid.

use crate::charged_sphere::ChargedSphere;
use crate::debye_huckel::Superposition;
use crate::dielectric::DielectricModel;
use crate::grid::Grid;
use crate::poisson_boltzmann::{Potential, SoluteOnGrid};
use crate::screened_blocks;
use protomer_kernel::{Electrolyte, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Factor on the energy of displaced solvent, because the field in the place of a body is stronger
/// than that in the solvent: to first order 3ε/(2ε + ε_i) or 1.46 for a small ball of permittivity
/// ε_i, and 2/(1 + ε_i/ε) or 1.90 for a wall. Fitted to solves of 66 poses of complexes
/// (docs/validation/solvent-response.md).
const CAVITY_FACTOR: f64 = 1.25;
/// Width of the rim in which the table falls to zero, Å.
const RIM_ANGSTROM: f64 = 8.0;

/// Four numbers at each point of a grid: kT per charge (e), kT per volume of low permittivity and per
/// volume without ions (Å³), and kT per capacitance (e²). They fall to zero towards the faces.
#[derive(Debug, Clone)]
pub struct ResponseTable {
    /// The points.
    pub grid: Grid,
    /// The numbers, with x running fastest.
    pub values: Vec<[f32; 4]>,
}

impl ResponseTable {
    /// Tabulates the response of a solute from its potentials in a medium and in the reference.
    pub(super) fn new(
        spheres: &[ChargedSphere],
        solute: &SoluteOnGrid<'_>,
        solved: [&(Electrolyte, Potential); 2],
        margin_angstrom: f64,
    ) -> Self {
        let grid = *solute.grid();
        let mut values = vec![[0.0; 4]; grid.len()];
        // Actual salt minus reference: added with signs, so one list of values is enough.
        for ((electrolyte, potential), sign) in solved.into_iter().zip([1.0, -1.0]) {
            let model = DielectricModel {
                electrolyte: *electrolyte,
                ..*solute.dielectric()
            };
            let plain = plain_potential(spheres, &model, &grid);
            let part = Part {
                solute,
                potential,
                sign,
                model: &model,
            };
            let rows = values.par_iter_mut().zip(plain);
            rows.enumerate().for_each(|(point, (value, plain))| {
                let more = part.value_at(point, plain);
                for (value, more) in value.iter_mut().zip(more) {
                    *value += more as f32;
                }
            });
        }
        let [(_, actual), _] = solved;
        values
            .par_iter_mut()
            .enumerate()
            .for_each(|(point, value)| {
                value[3] = regulation_kt(&grid, actual, solute, point) as f32;
            });
        // A linear fall to zero, so that bodies that enter the table feel no step.
        let rim = RIM_ANGSTROM.min(0.5 * margin_angstrom);
        values
            .par_iter_mut()
            .enumerate()
            .for_each(|(point, value)| {
                let weight = (from_faces(&grid, point) / rim).min(1.0) as f32;
                *value = value.map(|number| weight * number);
            });
        Self { grid, values }
    }

    /// The numbers at a place, interpolated linearly; zeros beyond the grid.
    ///
    /// ```
    /// use protomer_field::{Grid, solvent_response::ResponseTable};
    /// use protomer_kernel::Vec3;
    /// let grid = Grid { origin_angstrom: [0.0; 3], spacing_angstrom: 1.0, shape: [2; 3] };
    /// let table = ResponseTable { grid, values: vec![[4.0, 3.0, 2.0, 1.0]; 8] };
    /// assert_eq!(table.value_at(&Vec3::repeat(0.5)), [4.0, 3.0, 2.0, 1.0]);
    /// assert_eq!(table.value_at(&Vec3::repeat(1.5)), [0.0; 4]);
    /// ```
    pub fn value_at(&self, place: &Vec3) -> [f64; 4] {
        let Some(stencil) = self.grid.trilinear(place) else {
            return [0.0; 4];
        };
        std::array::from_fn(|number| {
            stencil.interpolate(|point| f64::from(self.values[point][number]))
        })
    }
}

/// Energy of a group whose charge follows the potential φ, per its capacitance, kT: -4 ln cosh(φ/2). That is
/// the exact free energy beyond the mean charge of a half-protonated group (capacitance ¼ e²), and
/// -φ²/2 for any group in a weak potential.
///
/// At points inside next to the surface, φ is the mean of the neighbours outside; deeper it is zero.
fn regulation_kt(
    grid: &Grid,
    potential: &Potential,
    solute: &SoluteOnGrid<'_>,
    point: usize,
) -> f64 {
    let outside = |point: usize| {
        let is_outside = !solute.is_inside(point);
        is_outside.then(|| potential.reduced_at_point(point))
    };
    let value = outside(point).or_else(|| {
        let (place, strides) = (grid.coordinates(point), grid.strides());
        let (mut sum, mut count) = (0.0, 0.0);
        for axis in 0..3 {
            let below = (place[axis] > 0).then(|| point - strides[axis]);
            let above = (place[axis] + 1 < grid.shape[axis]).then(|| point + strides[axis]);
            for value in [below, above].into_iter().flatten().filter_map(outside) {
                sum += value;
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    });
    // ln cosh x = |x| + ln(1 + e^-2|x|) - ln 2, without overflow.
    let half = 0.5 * value.unwrap_or(0.0).abs();
    -4.0 * (half + (-2.0 * half).exp().ln_1p() - std::f64::consts::LN_2)
}

/// The distance of a point from the nearest face of its grid, Å.
fn from_faces(grid: &Grid, point: usize) -> f64 {
    let place = grid.coordinates(point);
    let steps = (0..3).map(|axis| place[axis].min(grid.shape[axis] - 1 - place[axis]));
    grid.spacing_angstrom * steps.min().unwrap_or(0) as f64
}

/// The screened potentials of the charges in water everywhere, kT/e, at the points of a grid.
fn plain_potential(spheres: &[ChargedSphere], model: &DielectricModel, grid: &Grid) -> Vec<f64> {
    let mut charges = spheres.to_vec();
    // Points in water everywhere: neither radius nor a shell without ions.
    for charge in &mut charges {
        charge.radius_angstrom = 0.0;
    }
    let without_shell = DielectricModel {
        ion_radius_angstrom: 0.0,
        ..*model
    };
    let sum = Superposition::new(&charges, &without_shell);
    screened_blocks::tabulate(&sum, grid)
}

/// Contribution of one of the two media.
struct Part<'a> {
    solute: &'a SoluteOnGrid<'a>,
    potential: &'a Potential,
    sign: f64,
    model: &'a DielectricModel,
}

impl Part<'_> {
    /// The three numbers at a point. Inside the solute, the potential is that without the Coulomb part
    /// of its charges, which is the same in both media.
    fn value_at(&self, point: usize, plain: f64) -> [f64; 3] {
        let Self {
            solute,
            potential,
            model,
            ..
        } = self;
        let electrolyte = &model.electrolyte;
        // U = (ε - ε_i)/(8π λ_B ε) |∇φ|² per volume, and κ²/(8π λ_B) φ² for the ions.
        let per_volume = CAVITY_FACTOR / (8.0 * PI * electrolyte.bjerrum_length_angstrom());
        let potential_kt = potential.reduced_at_point(point);
        let (mut dielectric, mut ionic) = (0.0, 0.0);
        // Inside the body no other one can be.
        if !solute.is_inside(point) {
            let ratio = model.inner_permittivity / electrolyte.relative_permittivity();
            dielectric = (1.0 - ratio) * per_volume * self.square_of_gradient(point);
            let kappa = electrolyte.inverse_debye_length_per_angstrom();
            let free = solute.accessible_part(point);
            ionic = free * kappa * kappa * per_volume * potential_kt * potential_kt;
        }
        [potential_kt - plain, dielectric, ionic].map(|number| self.sign * number)
    }

    /// |∇φ|² at a point in the solvent, (kT/e/Å)², from its neighbours in the solvent.
    fn square_of_gradient(&self, point: usize) -> f64 {
        let grid = self.solute.grid();
        let (place, strides) = (grid.coordinates(point), grid.strides());
        let value = |point: usize| self.potential.reduced_at_point(point);
        let mut square = 0.0;
        for axis in 0..3 {
            // One-sided at faces and at the surface: a
            // difference across the surface would see the jump.
            let below = (place[axis] > 0).then(|| point - strides[axis]);
            let above = (place[axis] + 1 < grid.shape[axis]).then(|| point + strides[axis]);
            let [below, above] =
                [below, above].map(|near| near.filter(|near| !self.solute.is_inside(*near)));
            let (from, to) = (below.unwrap_or(point), above.unwrap_or(point));
            let steps = f64::from(u8::from(below.is_some()) + u8::from(above.is_some()));
            if steps > 0.0 {
                square += ((value(to) - value(from)) / (steps * grid.spacing_angstrom)).powi(2);
            }
        }
        square
    }
}
