//! The error of a solvation energy, from a second grid.

use super::{SolveSettings, solve};
use crate::Result;
use crate::charged_sphere::ChargedSphere;
use crate::dielectric::DielectricModel;

/// Ratio of the two spacings: the second grid is coarser, or finer where it would be coarser than
/// [`COARSEST_ANGSTROM`].
const SECOND_SPACING: f64 = 1.4;
/// Largest spacing of a coarser second grid, Å.
const COARSEST_ANGSTROM: f64 = 1.1;

/// The expected error of a solvation energy E(h), kT, from the energy at a second spacing s h. An
/// error that falls with the square of the spacing is
///
/// δ = |E(s h) - E(h)| / |s² - 1|.
///
/// It is a size to expect, not a bound: how the two grids happen to cut the surface makes single
/// estimates too small or too large.
///
/// # Errors
/// As [`solve`].
pub fn error_estimate_kt(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
    solvation_energy_kt: f64,
) -> Result<f64> {
    let coarser = SECOND_SPACING * settings.spacing_angstrom <= COARSEST_ANGSTROM;
    let scale = if coarser {
        SECOND_SPACING
    } else {
        1.0 / SECOND_SPACING
    };
    let second_settings = SolveSettings {
        spacing_angstrom: scale * settings.spacing_angstrom,
        ..*settings
    };
    let second = solve(spheres, dielectric, &second_settings)?;
    let difference = (second.solvation_energy_kt - solvation_energy_kt).abs();
    Ok(difference / (scale * scale - 1.0).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::{Electrolyte, Vec3};

    #[test]
    fn the_estimate_is_what_a_second_order_error_leaves_between_two_grids() {
        let electrolyte = Electrolyte::new(298.15, 0.0, 78.54).unwrap();
        let dielectric = DielectricModel {
            inner_permittivity: 1.0,
            ..DielectricModel::new(electrolyte)
        };
        let ion = [ChargedSphere {
            centre: Vec3::zeros(),
            radius_angstrom: 2.0,
            charge_e: 1.0,
        }];
        let spaced = |spacing_angstrom| SolveSettings {
            spacing_angstrom,
            ..SolveSettings::default()
        };
        let energy = |spacing| {
            let solved = solve(&ion, &dielectric, &spaced(spacing)).unwrap();
            solved.solvation_energy_kt
        };
        // c h² at both: the coarser differs by 0.96 c h², the finer by (1 - 1/1.96) c h².
        for (spacing, second, share) in [(0.6, 0.84, 0.96), (0.9, 0.9 / 1.4, 1.0 - 1.0 / 1.96)] {
            let expected = (energy(second) - energy(spacing)).abs() / share;
            let found =
                error_estimate_kt(&ion, &dielectric, &spaced(spacing), energy(spacing)).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
    }
}
