//! Effective charges: point charges in a uniform electrolyte whose screened potential is, outside a
//! body, that of its charges inside a region of low permittivity that salt does not enter
//! (Gabdoulline and Wade, J. Phys. Chem. 100, 3868 (1996)).
//!
//! ```text
//! λ_B Σ q_j exp(-κ|r - x_j|)/|r - x_j| = φ(r)   wherever ions go
//! ```
//!
//! φ solves the linearised Poisson-Boltzmann equation of the body alone. Outside the region that ions
//! cannot enter, both sides solve ∇²φ = κ²φ, so charges that match φ near this region match it
//! everywhere beyond. In the same way the energy of a second body's charges in φ is that of its
//! effective charges, as long as the region of the second body, too, is filled with electrolyte: what
//! is left out is that each body displaces solvent from the field of the other (desolvation), and
//! reflections of higher order.
//!
//! | module | one idea |
//! |---|---|
//! | `distance` | distances of grid points from the surface |
//! | `places` | sites below the surface, points around it |
//! | `fit` | regularised least squares |
//!
//! There are more sites than charges, and the fit is made in layers. One charge per site misses
//! facing charges by up to 44 %; the far layers fix the net charge.

mod distance;
mod fit;
mod places;

use crate::charged_sphere::{ChargedSphere, bounds};
use crate::dielectric::DielectricModel;
use crate::poisson_boltzmann::{BoundaryCondition, SolveSettings, solve};
use crate::{FieldError, Result};
use distance::SurfaceDistances;
use fit::fit;
use places::{Place, layers, sites};
use protomer_kernel::Vec3;

/// A fit whose residual is larger than this stands for the potential badly.
pub const LARGEST_RELATIVE_RESIDUAL: f64 = 0.05;

/// Settings for the solution of the potential to which charges are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EffectiveChargeSettings {
    /// Grid spacing, Å; where it is `None`, as fine as some six million points allow, from 0.3 to
    /// 0.7 Å.
    pub spacing_angstrom: Option<f64>,
}

/// The effective charges of a body in one electrolyte.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectiveCharges {
    /// Position (Å) and charge (e).
    pub charges: Vec<(Vec3, f64)>,
    /// The sum of the charges of the body, e.
    pub net_charge_e: f64,
    /// The charge that a body seen from far away has, averaged over directions, e:
    /// Σ q sinh(κs)/(κs) over charges at distances s of the origin. A charge at the centre of a
    /// sphere of radius a gives q exp(κa)/(1 + κa).
    pub net_effective_charge_e: f64,
    /// Root mean square error of the potential at the points of the fit, each layer relative to its
    /// own root mean square.
    pub relative_residual: f64,
    /// The ratio of the largest to the smallest eigenvalue bound of the regularised equations, from
    /// the pivots of their factorisation.
    pub condition: f64,
}

/// The charge from afar is stated up to this multiple of the body's own charge, or of one elementary
/// charge if that is more.
const LARGEST_RATIO_FROM_AFAR: f64 = 10.0;

impl EffectiveCharges {
    /// The charge seen from far away, e; `None` where it exceeds ten times the charge of the body (or
    /// ten elementary charges, for a body of less than one).
    ///
    /// A charge at a depth a counts exp(κa)/(1 + κa) times from afar. At high salt that factor reaches
    /// hundreds, the charges of the fit cancel to a small part of themselves, and their weighted sum is
    /// an extrapolation of its errors.
    ///
    /// ```
    /// use protomer_field::effective_charges::EffectiveCharges;
    /// let seen_as = |net_effective_charge_e| EffectiveCharges {
    ///     charges: Vec::new(),
    ///     net_charge_e: 3.0,
    ///     net_effective_charge_e,
    ///     relative_residual: 0.01,
    ///     condition: 1e6,
    /// };
    /// assert_eq!(seen_as(5.0).charge_from_afar_e(), Some(5.0));
    /// assert_eq!(seen_as(-200.0).charge_from_afar_e(), None);
    /// ```
    pub fn charge_from_afar_e(&self) -> Option<f64> {
        let largest_e = LARGEST_RATIO_FROM_AFAR * self.net_charge_e.abs().max(1.0);
        let charge_e = self.net_effective_charge_e;
        (charge_e.abs() <= largest_e).then_some(charge_e)
    }
}

/// The distance from the faces of the grid to the spheres, Å: room for the layers.
const MARGIN_ANGSTROM: f64 = 13.5;
/// Points of a grid whose spacing is chosen.
const POINTS: f64 = 6e6;
/// The finest and the coarsest spacing that is chosen, Å.
const SPACINGS_ANGSTROM: (f64, f64) = (0.3, 0.7);

/// Fits effective charges to the potential of these spheres.
///
/// ```
/// use protomer_field::effective_charges::{EffectiveChargeSettings, effective_charges};
/// use protomer_field::{ChargedSphere, DielectricModel};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 6.0, charge_e: 1.0 };
/// let mut model = DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?);
/// model.ion_radius_angstrom = 0.0;
/// let found = effective_charges(&[ion], &model, &EffectiveChargeSettings::default())?;
/// let kappa_a = 6.0 * model.electrolyte.inverse_debye_length_per_angstrom();
/// let expected = kappa_a.exp() / (1.0 + kappa_a);
/// assert!((found.net_effective_charge_e / expected - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`solve`]; [`FieldError::BadInput`] without charges, and for a body too thin for sites below
/// its surface.
pub fn effective_charges(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &EffectiveChargeSettings,
) -> Result<EffectiveCharges> {
    if spheres.iter().all(|sphere| sphere.charge_e == 0.0) {
        return Err(FieldError::BadInput(
            "there are no charges to be fitted; use bare charges or hard bodies".into(),
        ));
    }
    let margin_angstrom = MARGIN_ANGSTROM + dielectric.ion_radius_angstrom;
    let solve_settings = SolveSettings {
        spacing_angstrom: settings
            .spacing_angstrom
            .unwrap_or_else(|| affordable_spacing(spheres, margin_angstrom)),
        margin_angstrom,
        boundary: BoundaryCondition::CoarseGrid,
        ..SolveSettings::default()
    };
    let potential = solve(spheres, dielectric, &solve_settings)?;
    let distances = SurfaceDistances::new(&potential);
    let sites = sites(&potential, &distances, spheres);
    if sites.is_empty() {
        return Err(FieldError::BadInput(
            "the body is too thin for charges below its surface; use bare charges".into(),
        ));
    }
    let points: Vec<Place> = layers(&potential, &distances, dielectric.ion_radius_angstrom);
    let electrolyte = &dielectric.electrolyte;
    let kappa = electrolyte.inverse_debye_length_per_angstrom();
    let fitted = fit(
        &sites,
        &points,
        electrolyte.bjerrum_length_angstrom(),
        kappa,
    )?;
    let mut charges = Vec::with_capacity(sites.len());
    let mut net_effective_charge_e = 0.0;
    for (site, charge) in sites.into_iter().zip(fitted.charges_e) {
        net_effective_charge_e += charge * seen_from_afar(kappa * site.norm());
        charges.push((site, charge));
    }
    Ok(EffectiveCharges {
        charges,
        net_charge_e: spheres.iter().map(|sphere| sphere.charge_e).sum(),
        net_effective_charge_e,
        relative_residual: fitted.relative_residual,
        condition: fitted.condition,
    })
}

/// The spacing at which a grid around these spheres has the usual number of points, Å.
fn affordable_spacing(spheres: &[ChargedSphere], margin_angstrom: f64) -> f64 {
    let (low, high) = bounds(spheres);
    let volume = (high - low).add_scalar(2.0 * margin_angstrom).product();
    let (finest, coarsest) = SPACINGS_ANGSTROM;
    (volume / POINTS).cbrt().clamp(finest, coarsest)
}

/// sinh(x)/x.
fn seen_from_afar(x: f64) -> f64 {
    if x < 1e-4 { 1.0 } else { x.sinh() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chymotrypsin at 1 M and at 100 mM: +2954.56 e is no charge of a body of +3.01 e.
    #[test]
    fn a_charge_from_afar_that_is_an_extrapolation_is_not_stated() {
        let seen = |net_charge_e: f64, net_effective_charge_e: f64| {
            let charges = EffectiveCharges {
                charges: Vec::new(),
                net_charge_e,
                net_effective_charge_e,
                relative_residual: 0.01,
                condition: 1.0,
            };
            charges.charge_from_afar_e()
        };
        assert_eq!(seen(3.01, 2954.56), None);
        assert_eq!(seen(-3.01, -267.0), None);
        assert_eq!(seen(3.01, 9.7), Some(9.7));
        assert_eq!(seen(0.02, 3.0), Some(3.0));
    }
}
