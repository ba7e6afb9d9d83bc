//! The response of water and salt to two bodies, to first order in what each body displaces.
//!
//! Charges in water everywhere have the screened Coulomb energy E₀. Body A displaces water and ions:
//! its permittivity is lower, and ions keep away from it. With φ_A the solved potential of A alone
//! (Poisson-Boltzmann), the charges of B interact with A by Σ q_B φ_A, that is E₀ and a change δ_A
//! that follows from the cavity of A. In the same way Σ q_A φ_B is E₀ + δ_B. To first order both
//! changes add, and each body takes solvent away from the field of the other, which costs
//!
//! ```text
//! E = Σ q_B φ_A + Σ q_A φ_B - E₀
//!     + 1/(8π λ_B) [ ∫_B (1 - ε_i/ε) |∇φ_A|² + κ² φ_A² dV + ∫_A (1 - ε_i/ε) |∇φ_B|² + κ² φ_B² dV ]
//! ```
//!
//! in kT, with the Bjerrum length λ_B of the solvent; the ions' part is taken over the layer around a
//! body that they do not enter as well, and every part only where the other body does not displace
//! the solvent already.
//!
//! The charges of a body may follow the potential of the other ([`regulated_response`]): a group of
//! capacitance C gains -C φ e, and the energy falls by 4 C ln cosh(φ/2), which is C φ²/2 where φ is small.
//! Both bodies are in the potential of the mean charges of the other; the correlation of their
//! fluctuations is left out.
//!
//! What does not depend on the salt is not small at contact, and not of first order: a charge that
//! loses its water. It belongs to the short-ranged terms. So the response is that at one salt
//! concentration minus that at [`REFERENCE_SALT_MOLAR`], where it reaches hardly farther than contact.
//! What is left is smooth: the Coulomb parts near the charges cancel.
//!
//! | module | one idea |
//! |---|---|
//! | `table` | what a body does to the charges and the volume of others, on a grid |
//! | `sites` | charges and displaced volume of a body, gathered on a coarse lattice |

mod sites;
mod table;

pub use sites::ResponseSite;
pub use table::ResponseTable;

use crate::charged_sphere::ChargedSphere;
use crate::dielectric::DielectricModel;
use crate::poisson_boltzmann::{SoluteOnGrid, SolveSettings, grid_around};
use crate::surface::surface_of;
use crate::{FieldError, Result};
use protomer_kernel::Electrolyte;

/// The salt concentration at which the response is counted as zero, mol/L.
pub const REFERENCE_SALT_MOLAR: f64 = 1.0;

/// Spacing of the grid, Å. On 0.7 Å the salt effects of 45 complexes change by a few per cent.
const SPACING_ANGSTROM: f64 = 1.0;
/// Margin of the table beyond the atoms, in Debye lengths.
const MARGIN_DEBYE_LENGTHS: f64 = 2.0;
/// Least margin of the table beyond the atoms, Å.
const LEAST_MARGIN_ANGSTROM: f64 = 16.0;
/// Largest margin of the table beyond the atoms, Å.
const LARGEST_MARGIN_ANGSTROM: f64 = 28.0;

/// Response between a body and others in one medium.
#[derive(Debug, Clone)]
pub struct SolventResponse {
    /// Table of what charges and volume feel near the body.
    pub table: ResponseTable,
    /// Lattice points that hold the charges and the volume of the body.
    pub sites: Vec<ResponseSite>,
    /// The table reaches this far beyond the atoms, Å.
    pub margin_angstrom: f64,
}

/// Solves for the response of a body with these charges in a medium.
///
/// ```
/// use protomer_field::solvent_response::solvent_response;
/// use protomer_field::{ChargedSphere, DielectricModel};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 3.0, charge_e: 1.0 };
/// let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?);
/// let response = solvent_response(&[ion], &model)?;
/// // The potential at 8 Å in kT/e, without the screened Coulomb potential.
/// let [per_charge, _, _, _] = response.table.value_at(&Vec3::new(8.0, 0.0, 0.0));
/// assert!(per_charge.abs() > 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FieldError::BadInput`] for a medium without salt, and those of
/// [`solve`](crate::poisson_boltzmann::solve).
pub fn solvent_response(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
) -> Result<SolventResponse> {
    regulated_response(spheres, &[], dielectric)
}

/// Variant of [`solvent_response`] for a body whose charges follow the potential of others, with the
/// capacitance of each sphere, e².
///
/// # Errors
/// As [`solvent_response`].
pub fn regulated_response(
    spheres: &[ChargedSphere],
    capacitances_e2: &[f64],
    dielectric: &DielectricModel,
) -> Result<SolventResponse> {
    let electrolyte = dielectric.electrolyte;
    let debye_length = 1.0 / electrolyte.inverse_debye_length_per_angstrom();
    if !debye_length.is_finite() {
        return Err(FieldError::BadInput(
            "the response of the solvent is that of salt water; give a salt above zero".into(),
        ));
    }
    let margin =
        (MARGIN_DEBYE_LENGTHS * debye_length).clamp(LEAST_MARGIN_ANGSTROM, LARGEST_MARGIN_ANGSTROM);
    let settings = SolveSettings {
        spacing_angstrom: SPACING_ANGSTROM,
        margin_angstrom: margin,
        cells_multiple: 8,
        ..SolveSettings::default()
    };
    let reference = Electrolyte::new(
        electrolyte.temperature_kelvin(),
        REFERENCE_SALT_MOLAR,
        electrolyte.relative_permittivity(),
    )?;
    let solid = surface_of(spheres, dielectric.surface, dielectric.probe_angstrom)?;
    let grid = grid_around(spheres, &settings)?;
    let solute = SoluteOnGrid::new(&*solid, spheres, dielectric, grid)?;
    let charged = solute.with_charges(spheres)?;
    let solved = [electrolyte, reference]
        .map(|medium| Ok::<_, FieldError>((medium, charged.solve(&medium, &settings)?)));
    let [actual, reference] = solved;
    Ok(SolventResponse {
        table: ResponseTable::new(spheres, &solute, [&actual?, &reference?], margin),
        sites: sites::gather(spheres, capacitances_e2, &solute),
        margin_angstrom: margin,
    })
}
