//! Desolvation: what the charges of one body lose where another body displaces solvent from their
//! field (Elcock, Gabdoulline, Wade and McCammon, J. Mol. Biol. 291, 149 (1999)).
//!
//! The field of body A alone is φ, that of its effective charges. Within body B the permittivity is
//! ε_i instead of ε, and there is no salt. To first order in the difference, with φ unchanged, the
//! free energy of A's charges rises by
//!
//! ```text
//! ΔG_A = 1/(8π λ_B) ∫_B  f (1 - ε_i/ε) |∇φ|² + g κ² φ²  dV   (kT)
//! ```
//!
//! and that of B's charges in the same way. The factors f and g stand for what the change of the
//! field adds. They are known in two limits: a small sphere has f = 3ε/(2ε + ε_i), about 1.46, and a
//! flat wall before a charge f = 2/(1 + ε_i/ε), about 1.90. Between them,
//! [`DIELECTRIC_FACTOR`] and [`IONIC_FACTOR`] give the desolvation of two spheres of 12 to 25 Å in
//! 30 mM to 1 M salt within 18 % from a gap of 3 Å on.
//!
//! | module | one idea |
//! |---|---|
//! | `volume` | a body as a set of volume elements |
//! | `table` | the field of a body's charges on a grid |
//!
//! The field is tabulated once, so that an energy costs one look-up per volume element of the other
//! body.

mod table;
mod volume;

use crate::charges::ChargeCloud;
use crate::energy::terms::{PairPotential, Term};
use crate::error::require;
use crate::{BodyType, Result};
use protomer_kernel::Vec3;
use protomer_kernel::overlap::CollisionShape;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use std::f64::consts::PI;
use std::sync::Arc;
use table::FieldTable;
use volume::{VolumeElement, volume_elements};

/// f.
pub const DIELECTRIC_FACTOR: f64 = 1.68;
/// g.
pub const IONIC_FACTOR: f64 = 1.55;

/// The inside of bodies, for desolvation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solute {
    /// ε_i/ε: the permittivity inside over that of the solvent.
    pub permittivity_ratio: f64,
    /// The centres of ions keep this distance from the surface, Å.
    pub ion_radius_angstrom: f64,
}

/// Field and volume elements of one kind of body in one medium, for its desolvation.
#[derive(Debug)]
pub struct DesolvationBody {
    field: FieldTable,
    elements: Vec<VolumeElement>,
    radius_angstrom: f64,
}

impl DesolvationBody {
    /// Tabulates the field of a body's effective charges and divides its volume.
    ///
    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) for a cut potential, and for a field without salt, which reaches too
    /// far for a table.
    pub fn new(
        kind: &BodyType,
        effective: &ChargeCloud,
        yukawa: &Yukawa,
        solute: &Solute,
    ) -> Result<Self> {
        let kappa = yukawa.inverse_debye_length_per_angstrom;
        require(
            "inverse Debye length in 1/Å",
            kappa,
            "positive and without a cut-off for desolvation; add salt",
            !yukawa.is_cut() && kappa > 0.0,
        )?;
        require(
            "permittivity inside over that of the solvent",
            solute.permittivity_ratio,
            "0 to 1 for desolvation",
            (0.0..=1.0).contains(&solute.permittivity_ratio),
        )?;
        let surface = match &kind.surface {
            // Displaced solvent ends at the molecular surface,
            // if there is one besides the hard shape.
            Some(surface) => &CollisionShape::new(surface)?,
            None => &kind.shape,
        };
        let radius_angstrom = surface.bounding_radius_angstrom();
        let mut elements = volume_elements(surface, solute.ion_radius_angstrom);
        let per_volume = 1.0 / (8.0 * PI * yukawa.bjerrum_length_angstrom);
        let dielectric = DIELECTRIC_FACTOR * (1.0 - solute.permittivity_ratio) * per_volume;
        let ionic = IONIC_FACTOR * kappa * kappa * per_volume;
        // The constant factors once, so that an energy is two products per element.
        for element in &mut elements {
            element.dielectric *= dielectric;
            element.ionic *= ionic;
        }
        Ok(Self {
            field: FieldTable::new(effective, yukawa, radius_angstrom),
            elements,
            radius_angstrom,
        })
    }

    /// Desolvation energy of the charges of this body due to another body at a pose in the frame of
    /// this one, kT.
    fn lost_to(&self, other: &Self, pose: &RelativePose) -> f64 {
        // Volume of the other body in the field of this one.
        let mut sum = 0.0;
        for element in &other.elements {
            sum += self.lost_to_element(element, pose).unwrap_or(0.0);
        }
        sum
    }

    /// Desolvation energy due to one volume element, kT; `None` beyond the table.
    fn lost_to_element(&self, element: &VolumeElement, pose: &RelativePose) -> Option<f64> {
        let field = self.field.value_at(&pose.transform_point(&element.place))?;
        let dielectric = element.dielectric * field.square_of_gradient;
        Some(dielectric + element.ionic * field.square_of_potential)
    }
}

/// Desolvation of two bodies.
#[derive(Debug, Clone)]
pub struct Desolvation {
    first: Arc<DesolvationBody>,
    second: Arc<DesolvationBody>,
}

impl Desolvation {
    /// Two bodies.
    pub fn new(first: Arc<DesolvationBody>, second: Arc<DesolvationBody>) -> Self {
        Self { first, second }
    }
}

impl PairPotential for Desolvation {
    fn term(&self) -> Term {
        Term::Desolvation
    }

    fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
        let inverse = second_in_first.inverse();
        self.first.lost_to(&self.second, second_in_first)
            + self.second.lost_to(&self.first, &inverse)
    }

    fn shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64)) {
        let inverse = second_in_first.inverse();
        let displaced = [
            (0, &self.second, &self.first, &inverse),
            (1, &self.first, &self.second, second_in_first),
        ];
        for (displacing, charged, other, pose) in displaced {
            for element in &other.elements {
                if let Some(energy_kt) = charged.lost_to_element(element, pose) {
                    take(displacing, &element.place, energy_kt);
                }
            }
        }
    }

    fn reach_angstrom(&self, _: f64) -> f64 {
        self.first.radius_angstrom + self.second.radius_angstrom + table::MARGIN_ANGSTROM
    }

    fn tail_angstrom3(&self, _: f64) -> f64 {
        0.0
    }
}
