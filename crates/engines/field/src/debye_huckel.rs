//! Screened charges in a uniform solvent.
//!
//! A sphere of radius a with charge q has, outside its ion-free shell of radius b ≥ a (Debye and
//! Hückel, Phys. Z. 24, 185 (1923)),
//!
//! φ(r) = λ_B q exp(-κ (r - b)) / (r (1 + κ b)),
//!
//! in kT/e with the Bjerrum length λ_B of the solvent. For many spheres the sum of these ignores
//! the solvent that the spheres displace. It is a good approximation far away, where it gives
//! boundary values, and the cheap alternative near the solute.

use crate::charge_tree::{ChargeTree, FARTHER, bounds};
use crate::charged_sphere::ChargedSphere;
use crate::dielectric::DielectricModel;
use crate::grid::{Grid, ScalarField, set_points};
use crate::point_charges::{PointCharges, Source};
use crate::screened_sum::ScreenedSum;
use protomer_kernel::Vec3;

/// The sum of the screened potentials of charged spheres.
///
/// ```
/// use protomer_field::{ChargedSphere, DielectricModel, debye_huckel::Superposition};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let saline = Electrolyte::in_water(298.15, 0.1)?;
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: 1.0 };
/// let potential = Superposition::new(&[ion], &DielectricModel::new(saline));
/// // Ions of 2 Å come as near as b = 4 Å.
/// let kappa = saline.inverse_debye_length_per_angstrom();
/// let at_closest_approach = saline.bjerrum_length_angstrom() / (4.0 * (1.0 + 4.0 * kappa));
/// let found = potential.value_at(&Vec3::new(4.0, 0.0, 0.0));
/// assert!((found / at_closest_approach - 1.0).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Superposition {
    direct: PointCharges,
    tree: ChargeTree,
    kappa: f64,
}

impl Superposition {
    /// The potentials of these spheres in the solvent of this model.
    pub fn new(spheres: &[ChargedSphere], dielectric: &DielectricModel) -> Self {
        Self::with_reach(spheres, dielectric, |sphere| sphere.radius_angstrom)
    }

    /// Variant of [`new`](Superposition::new) with all ions outside one sphere around the whole
    /// solute. Far away a solute looks like one ion, so this suits boundary values.
    /// `reach_angstrom` is the distance from a charge to the ions around the solute.
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
        let kappa = dielectric.electrolyte.inverse_debye_length_per_angstrom();
        let bjerrum = dielectric.electrolyte.bjerrum_length_angstrom();
        let mut sources = Vec::new();
        for sphere in spheres {
            // A sphere without charge has no potential, only a volume, which this sum ignores.
            if sphere.charge_e != 0.0 {
                let b = reach(sphere) + dielectric.ion_radius_angstrom;
                sources.push(Source {
                    place: sphere.centre,
                    strength: bjerrum * sphere.charge_e * (kappa * b).exp() / (1.0 + kappa * b),
                    least_distance_angstrom: sphere.radius_angstrom.max(1e-6),
                });
            }
        }
        Self {
            direct: PointCharges::new(&sources),
            tree: ChargeTree::new(&sources),
            kappa,
        }
    }

    /// The sum at the places of a box between two corners, with far atoms in clusters and the error
    /// of `charge_tree`.
    pub(crate) fn seen_from(&self, low: &Vec3, high: &Vec3) -> ScreenedSum {
        // The finer clusters: potentials on faces are small because many charges cancel.
        let sources = self.tree.seen_from(low, high, FARTHER);
        ScreenedSum::new(&sources, 0.5 * (low + high), self.kappa)
    }

    /// The sums of the near and of the far charges at the places of a box between two corners, with the
    /// error of [`seen_from`](Superposition::seen_from). A charge is far from [`FARTHER`] half-diagonals
    /// of the box from its middle on.
    pub(crate) fn near_and_far(&self, low: &Vec3, high: &Vec3) -> [ScreenedSum; 2] {
        let (middle, half_diagonal) = (0.5 * (low + high), 0.5 * (high - low).norm());
        let sources = self.tree.seen_from(low, high, FARTHER);
        let is_near = |source: &Source| (source.place - middle).norm() < FARTHER * half_diagonal;
        let (near, far): (Vec<_>, Vec<_>) = sources.into_iter().partition(is_near);
        [near, far].map(|sources| ScreenedSum::new(&sources, middle, self.kappa))
    }

    /// The distance of the nearest charge from a plane perpendicular to an axis, Å; 0 if there are
    /// charges on both sides, and infinite without charges.
    pub(crate) fn distance_from_plane(&self, axis: usize, place: f64) -> f64 {
        let places = self.tree.sources().iter().map(|source| &source.place);
        let (low, high) = bounds(places);
        // Charges on both sides make both terms negative: the nearest may be in the plane itself.
        (low[axis] - place).max(place - high[axis]).max(0.0)
    }

    /// The potential at a place, kT/e; inside a sphere it is that at its surface.
    pub fn value_at(&self, place: &Vec3) -> f64 {
        self.direct.screened(place, self.kappa)
    }

    /// The potential on a grid, kT/e.
    ///
    /// ```
    /// use protomer_field::{ChargedSphere, DielectricModel, Grid, debye_huckel::Superposition};
    /// use protomer_kernel::{Electrolyte, Vec3};
    /// let saline = Electrolyte::in_water(298.15, 0.1)?;
    /// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: 1.0 };
    /// let potential = Superposition::new(&[ion], &DielectricModel::new(saline));
    /// let grid = Grid { origin_angstrom: [4.0, 0.0, 0.0], spacing_angstrom: 2.0, shape: [3, 1, 1] };
    /// let field = potential.tabulate(grid);
    /// assert_eq!(field.values[1], potential.value_at(&Vec3::new(6.0, 0.0, 0.0)));
    /// assert!(field.values[0] > field.values[1] && field.values[1] > field.values[2]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn tabulate(&self, grid: Grid) -> ScalarField {
        let mut values = vec![0.0; grid.len()];
        set_points(grid.shape, &mut values, |[i, j, k], value| {
            *value = self.value_at(&grid.point(i, j, k));
        });
        ScalarField { grid, values }
    }
}
