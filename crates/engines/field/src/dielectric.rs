//! The dielectric model of a solver: a solute of low permittivity in an electrolyte.

use crate::ion_response::IonResponse;
use crate::surface::SurfaceDefinition;
use protomer_kernel::Electrolyte;

/// Media inside and outside the surface of a solute.
///
/// ```
/// use protomer_field::{DielectricModel, SurfaceDefinition};
/// use protomer_kernel::Electrolyte;
/// let saline = Electrolyte::in_water(298.15, 0.15)?;
/// let model = DielectricModel {
///     surface: SurfaceDefinition::VanDerWaals,
///     ..DielectricModel::new(saline)
/// };
/// assert_eq!((model.inner_permittivity, model.ion_radius_angstrom), (2.0, 2.0));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DielectricModel {
    /// The solvent outside, and its salt.
    pub electrolyte: Electrolyte,
    /// Relative permittivity inside the surface.
    pub inner_permittivity: f64,
    /// Definition of the surface.
    pub surface: SurfaceDefinition,
    /// Radius of a solvent molecule, Å.
    pub probe_angstrom: f64,
    /// The centres of ions keep this distance from the spheres, Å; zero lets them reach the surface.
    pub ion_radius_angstrom: f64,
    /// Response of the ions to the potential. The electrolyte states their ionic strength.
    pub ion_response: IonResponse,
}

impl DielectricModel {
    /// A protein in this electrolyte: permittivity 2 inside the solvent-excluded surface of a probe
    /// of 1.4 Å, and ions of 2 Å that respond linearly.
    ///
    /// ```
    /// use protomer_field::DielectricModel;
    /// use protomer_kernel::Electrolyte;
    /// let protein = DielectricModel::new(Electrolyte::in_water(298.15, 0.15)?);
    /// assert_eq!((protein.inner_permittivity, protein.probe_angstrom), (2.0, 1.4));
    /// assert_eq!(protein.electrolyte.salt_molar(), Some(0.15));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn new(electrolyte: Electrolyte) -> Self {
        Self {
            electrolyte,
            inner_permittivity: 2.0,
            surface: SurfaceDefinition::SolventExcluded,
            probe_angstrom: 1.4,
            ion_radius_angstrom: 2.0,
            ion_response: IonResponse::Linear,
        }
    }
}
