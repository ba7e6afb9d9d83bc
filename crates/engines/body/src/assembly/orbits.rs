//! Bodies of an arrangement that rotations map onto each other.
//!
//! The energy of a symmetric arrangement is that of one body of each orbit with all others: half of it
//! for each body of the orbit.

use super::placement::Placement;
use super::recipe::Recipe;
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::{PI, TAU};

/// Largest distance of matching positions, relative to the size of the arrangement.
const NEAR: f64 = 1e-6;

/// Bodies that rotations map onto each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Orbit {
    /// Index of the first of these bodies.
    pub representative: usize,
    /// Number of these bodies.
    pub bodies: usize,
}

/// Rotations about the origin that can map a ring or stack onto itself: those about its axis and half
/// turns about axes in the plane between the rings.
///
/// The half turn about the azimuth α maps the azimuth φ to 2α - φ, and a lower position 2πi/n to an
/// upper one 2π(j + s)/n for α = π(i + j + s)/n, s being the stagger.
///
/// ```
/// use protomer_body::assembly::orbits::stack_rotations;
/// use protomer_body::assembly::{Recipe, RecipeSite};
/// let ring = Recipe::ring(5, &[RecipeSite::upright(0)]);
/// assert_eq!(stack_rotations(&ring).len(), 10, "five about the axis and five half turns");
/// ```
pub fn stack_rotations(recipe: &Recipe) -> Vec<Rotation> {
    let members = recipe.rings.first().map_or(0, Vec::len);
    let stagger = match recipe.rings.len() {
        1 => 0.0,
        _ => recipe.stagger,
    };
    let mut rotations = Vec::with_capacity(2 * members);
    for i in 0..members {
        rotations.push(Rotation::new(Vec3::z() * (TAU * i as f64 / members as f64)));
        let azimuth = PI * (i as f64 + stagger) / members as f64;
        let axis = Vec3::new(azimuth.cos(), azimuth.sin(), 0.0);
        rotations.push(Rotation::new(axis * PI));
    }
    rotations
}

/// The orbits of placed bodies under those of the rotations that map the arrangement onto itself.
///
/// ```
/// use protomer_body::assembly::orbits::{orbits, stack_rotations};
/// use protomer_body::assembly::{Recipe, RecipeSite};
/// use protomer_kernel::Rotation;
/// // Two kinds of bodies alternate in two rings of eight: an orbit for each kind.
/// let recipe = Recipe::dihedral(8, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
/// let placements = recipe.placements(&[Rotation::identity(); 2], 10.0, 5.0, 0.0)?;
/// let found = orbits(&placements, &stack_rotations(&recipe));
/// assert_eq!(found.iter().map(|orbit| orbit.bodies).collect::<Vec<_>>(), [8, 8]);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn orbits(placements: &[Placement], rotations: &[Rotation]) -> Vec<Orbit> {
    let maps: Vec<Vec<usize>> = rotations
        .iter()
        .filter_map(|rotation| image(placements, rotation))
        .collect();
    let mut found: Vec<Orbit> = Vec::new();
    let mut has_orbit = vec![false; placements.len()];
    for body in 0..placements.len() {
        if has_orbit[body] {
            continue;
        }
        // The rotations that remain form a group, so the images of one body are its orbit.
        let mut bodies = vec![body];
        bodies.extend(maps.iter().map(|map| map[body]));
        bodies.sort_unstable();
        bodies.dedup();
        for member in &bodies {
            has_orbit[*member] = true;
        }
        found.push(Orbit {
            representative: body,
            bodies: bodies.len(),
        });
    }
    found
}

/// The body that each body is mapped onto; `None` if one is mapped onto none.
fn image(placements: &[Placement], rotation: &Rotation) -> Option<Vec<usize>> {
    let size = placements
        .iter()
        .map(|(_, pose)| pose.position.norm())
        .fold(1.0, f64::max);
    let onto = |(kind, pose): &Placement| {
        let (position, turned) = (rotation * pose.position, rotation * pose.rotation);
        placements.iter().position(|(other, there)| {
            kind == other
                && (there.position - position).norm() < NEAR * size
                && there.rotation.angle_to(&turned) < 1e3 * NEAR
        })
    };
    placements.iter().map(onto).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::RecipeSite;

    fn sizes(recipe: &Recipe) -> Vec<usize> {
        let frames = [
            Rotation::new(Vec3::new(0.3, 0.2, -0.5)),
            Rotation::new(Vec3::new(-1.3, 0.2, 0.5)),
        ];
        let placements = recipe.placements(&frames, 10.0, 7.0, 0.0).unwrap();
        let found = orbits(&placements, &stack_rotations(recipe));
        found.iter().map(|orbit| orbit.bodies).collect()
    }

    #[test]
    fn orbits_follow_the_symmetry_of_the_recipe() {
        let site = |body, up| RecipeSite {
            body,
            up,
            tilt_radian: 0.4,
            spin_radian: -0.7,
        };
        let pattern = [site(0, true), site(1, false)];
        let stack = Recipe {
            stagger: 0.3,
            ..Recipe::dihedral(6, &pattern)
        };
        assert_eq!(sizes(&stack), [6, 6]);
        assert_eq!(sizes(&Recipe::ring(6, &pattern)), [3, 3]);
        // Both rings the same way up: no half turn maps them onto each other.
        let parallel = Recipe {
            rings: vec![stack.rings[0].clone(), stack.rings[0].clone()],
            ..stack.clone()
        };
        assert_eq!(sizes(&parallel), [3, 3, 3, 3]);
        // One body stands differently: every body is alone.
        let mut broken = stack;
        broken.rings[0][2].tilt_radian = 0.1;
        assert_eq!(sizes(&broken), [1; 12]);
    }
}
