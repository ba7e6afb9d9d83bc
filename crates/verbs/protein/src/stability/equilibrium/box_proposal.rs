//! A box for simulations of the bodies of a structure.
//!
//! ```text
//! L³ = N/(N_A c)     for N bodies at the total concentration c
//! ```
//!
//! The box is at least so large that the whole assembly does not meet its images: its diameter and six Debye lengths.

use super::StabilitySettings;
use crate::assemblies::assembly_file::Assembly;
use anyhow::Result;
use protomer_kernel::Vec3;
use protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR;

/// Room between the whole assembly and its images, Debye lengths.
const DEBYE_LENGTHS: f64 = 6.0;

/// Edge of a cubic box for the bodies of a structure at the first concentration, Å; `None` for an assembly with a file, which says
/// itself whether it has a box.
pub(super) fn proposed_box_angstrom(
    assembly: &Assembly,
    settings: &StabilitySettings,
) -> Result<Option<f64>> {
    if assembly.path.is_some() {
        return Ok(None);
    }
    let salts = settings.salt_molar.iter().copied();
    let lowest_molar = salts.fold(f64::INFINITY, f64::min);
    let interaction = settings.medium.interaction(Some(lowest_molar))?;
    let debye_angstrom = interaction.electrolyte.debye_length_angstrom();
    let room_angstrom = diameter_angstrom(assembly) + DEBYE_LENGTHS * debye_angstrom;
    let density_per_angstrom3 = settings.concentration_molar[0] * NUMBER_DENSITY_PER_MOLAR;
    let edge_angstrom = (assembly.len() as f64 / density_per_angstrom3).cbrt();
    Ok(Some(edge_angstrom.max(room_angstrom).ceil()))
}

/// Diameter of the ball about the middle of an assembly that holds all its surfaces, Å.
fn diameter_angstrom(assembly: &Assembly) -> f64 {
    let count = assembly.poses.len().max(1) as f64;
    let places = assembly.poses.iter().map(|pose| pose.position);
    let middle = places.sum::<Vec3>() / count;
    let mut square: f64 = 0.0;
    for (kind, pose) in assembly.kinds.iter().zip(&assembly.poses) {
        for vertex in &assembly.bodies[*kind].mesh.vertices {
            square = square.max((pose.transform_point(vertex) - middle).norm_squared());
        }
    }
    2.0 * square.sqrt()
}
