//! Area that two bodies bury in their contact.
//!
//! ```text
//! A = A_1 + A_2 - A_12
//! ```
//!
//! with the areas of the solvent-accessible surfaces (Lee and Richards, J. Mol. Biol. 55, 379 (1971)), exact by the
//! arrangement of their spheres.

use super::Partner;
use crate::Result;
use crate::surface::{Arrangement, Measure};
use protomer_kernel::Vec3;

/// Accessible area that two bodies lose by their contact, both sides together, Å².
///
/// # Errors
/// As [`Arrangement::new`].
///
/// ```
/// use protomer_body::interface::{Partner, buried_area_angstrom2};
/// # use protomer_body::{Source, SurfaceSettings, build_body_of_points};
/// # use protomer_kernel::{PointRecord, Vec3};
/// # let ball = PointRecord { radius_angstrom: 2.0, ..PointRecord::default() };
/// # let source = Source { file: "ball.xyzr", sha256: "" };
/// # let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
/// let place = |x| Partner { body: &body, origin_angstrom: Vec3::new(x, 0.0, 0.0) };
/// // Two balls of 3.4 Å with their probes, 4 Å apart, hide caps of a height of 1.4 Å.
/// let caps = 2.0 * std::f64::consts::TAU * 3.4 * 1.4;
/// let area = buried_area_angstrom2([place(0.0), place(4.0)], 1.4)?;
/// assert!((area - caps).abs() < 1e-4);
/// assert!(buried_area_angstrom2([place(0.0), place(9.0)], 1.4)?.abs() < 1e-4);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn buried_area_angstrom2(
    partners: [Partner<'_>; 2],
    probe_radius_angstrom: f64,
) -> Result<f64> {
    let [first, second] = partners.map(|partner| {
        let atoms = partner.atoms();
        atoms
            .map(|atom| (atom.position, atom.site.radius_angstrom))
            .collect::<Vec<_>>()
    });
    let together: Vec<(Vec3, f64)> = first.iter().chain(&second).copied().collect();
    let area = |atoms: &[(Vec3, f64)]| accessible_area_angstrom2(atoms, probe_radius_angstrom);
    Ok(area(&first)? + area(&second)? - area(&together)?)
}

/// Sites of each body that touch the solvent in the complex, in ascending order.
///
/// # Errors
/// As [`Arrangement::new`].
pub fn exposed_sites(
    partners: [Partner<'_>; 2],
    probe_radius_angstrom: f64,
) -> Result<[Vec<usize>; 2]> {
    let mut atoms = Vec::new();
    for (side, partner) in partners.iter().enumerate() {
        for (index, site) in partner.body.sites.iter().enumerate() {
            if site.radius_angstrom > 0.0 {
                let position = site.position + partner.origin_angstrom;
                atoms.push((side, index, position, site.radius_angstrom));
            }
        }
    }
    let centres: Vec<Vec3> = atoms.iter().map(|atom| atom.2).collect();
    let radii: Vec<f64> = atoms.iter().map(|atom| atom.3).collect();
    let accessible = Arrangement::new(&centres, &radii, probe_radius_angstrom)?;
    let mut exposed = [Vec::new(), Vec::new()];
    for atom in accessible.exposed_atoms() {
        let (side, index, ..) = atoms[atom as usize];
        exposed[side].push(index);
    }
    Ok(exposed)
}

fn accessible_area_angstrom2(atoms: &[(Vec3, f64)], probe_radius_angstrom: f64) -> Result<f64> {
    let (centres, radii): (Vec<Vec3>, Vec<f64>) = atoms.iter().copied().unzip();
    let accessible = Arrangement::new(&centres, &radii, probe_radius_angstrom)?;
    Ok(Measure::new(&accessible).total().sas_area_angstrom2)
}
