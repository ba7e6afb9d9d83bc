//! Screened charges in a uniform medium.
//!
//! A sphere of radius a with charge q in a solvent has, outside its ion-free shell of radius b ≥ a
//! (Debye and Hückel, Phys. Z. 24, 185 (1923)),
//!
//! φ(r) = λ_B q exp(-κ (r - b)) / (r (1 + κ b)),
//!
//! in kT/e with the Bjerrum length λ_B of the solvent. For many spheres the sum of these is an
//! approximation that ignores what they displace: good far away, where it serves as boundary value,
//! and the cheap alternative near by.

use crate::grid::{Grid, ScalarField};
use crate::point_charges::{PointCharges, Source};
use crate::poisson_boltzmann::{ChargedSphere, DielectricModel};
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// Screened potentials of charged spheres, added up.
#[derive(Debug, Clone)]
pub struct Superposition {
    sources: PointCharges,
    kappa: f64,
}

impl Superposition {
    /// The potentials of these spheres in the solvent.
    pub fn new(spheres: &[ChargedSphere], dielectric: &DielectricModel) -> Self {
        Self::with_reach(spheres, dielectric, |sphere| sphere.radius_angstrom)
    }

    /// Like [`new`](Superposition::new), with all charges on one sphere around the whole: for
    /// boundary values, where a solute is seen as one ion. `reach_angstrom` is the distance from a
    /// charge to the ions around the solute.
    pub(crate) fn of_solute(
        spheres: &[ChargedSphere],
        dielectric: &DielectricModel,
        reach_angstrom: f64,
    ) -> Self {
        Self::with_reach(spheres, dielectric, |_| reach_angstrom)
    }

    /// Strengths are λ_B q exp(κ b) / (1 + κ b), with b from `reach` (Å) and the radius of ions.
    fn with_reach(
        spheres: &[ChargedSphere],
        dielectric: &DielectricModel,
        reach: impl Fn(&ChargedSphere) -> f64,
    ) -> Self {
        let (kappa, bjerrum) = (
            dielectric.electrolyte.inverse_debye_length_per_angstrom(),
            dielectric.electrolyte.bjerrum_length_angstrom(),
        );
        let sources = spheres
            .iter()
            .filter(|sphere| sphere.charge_e != 0.0)
            .map(|sphere| {
                let b = reach(sphere) + dielectric.ion_radius_angstrom;
                Source {
                    place: sphere.centre,
                    strength: bjerrum * sphere.charge_e * (kappa * b).exp() / (1.0 + kappa * b),
                    least_distance_angstrom: sphere.radius_angstrom.max(1e-6),
                }
            });
        Self {
            sources: sources.collect(),
            kappa,
        }
    }

    /// The potential at a place, kT/e; inside a sphere that at its surface.
    pub fn at(&self, place: &Vec3) -> f64 {
        self.sources.screened(place, self.kappa)
    }

    /// The potential on a grid, kT/e.
    pub fn on(&self, grid: Grid) -> ScalarField {
        let plane = grid.shape[0] * grid.shape[1];
        let mut values = vec![0.0; grid.len()];
        values
            .par_chunks_mut(plane)
            .enumerate()
            .for_each(|(k, plane)| {
                for (n, value) in plane.iter_mut().enumerate() {
                    *value = self.at(&grid.point(n % grid.shape[0], n / grid.shape[0], k));
                }
            });
        ScalarField { grid, values }
    }
}
