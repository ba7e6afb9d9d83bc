//! Point group of placed bodies: the proper rotations that map them onto each other.
//!
//! Bodies are chiral and have no symmetry themselves, so a rotation is known by the copy that it maps one
//! body onto. The copies of the rarest kind are tried; a rotation about the centre counts if it maps every
//! body onto a copy of it within a tolerance.
//!
//! | order | most rotations about one axis | group |
//! |---|---|---|
//! | n | n | C_n |
//! | 2n | n | D_n |
//! | 12 | 3 | T |
//! | 24 | 4 | O |
//! | 60 | 5 | I |

use super::placement::Placement;
use protomer_kernel::{Rotation, Vec3};
use serde::Serialize;
use std::collections::BTreeMap;

/// Most bodies for which the group is sought: each rotation compares all with all.
const MOST_BODIES: usize = 2000;
/// Axes nearer than this are one, radian; those of the icosahedral group are 0.55 apart at least.
const SAME_AXIS_RADIAN: f64 = 0.2;
/// Rotations by less than this are none, radian; a ring of a hundred bodies turns by 0.06.
const NO_TURN_RADIAN: f64 = 0.03;

/// Point group of placed bodies.
///
/// ```
/// use protomer_body::assembly::point_group::point_group;
/// use protomer_body::assembly::{Recipe, RecipeSite};
/// use protomer_kernel::Rotation;
/// let recipe = Recipe::dihedral(4, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
/// let frames = [Rotation::identity(); 2];
/// let placements = recipe.placements(&frames, 20.0, 15.0, 0.0)?;
/// let group = point_group(&placements, &[10.0, 10.0], 1.0).unwrap();
/// assert_eq!((group.name.as_str(), group.order), ("D2", 4));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointGroup {
    /// Name in Schoenflies notation, such as `D4`.
    pub name: String,
    /// Number of rotations, the identity among them.
    pub order: usize,
    /// Largest distance of a body from where a rotation maps its copy: root mean square over its atoms, Å.
    pub deviation_angstrom: f64,
}

/// The point group of placed bodies; `None` for rotations that form no group within the tolerance, and for
/// more than two thousand bodies.
///
/// `radii_angstrom` has the radius of gyration of each kind of body, which turns angles into distances.
pub fn point_group(
    placements: &[Placement],
    radii_angstrom: &[f64],
    tolerance_angstrom: f64,
) -> Option<PointGroup> {
    if placements.is_empty() || placements.len() > MOST_BODIES {
        return None;
    }
    let mut centre = Vec3::zeros();
    for (_, pose) in placements {
        centre += pose.position / placements.len() as f64;
    }
    let mut kinds: BTreeMap<usize, Vec<&Placement>> = BTreeMap::new();
    for placement in placements {
        kinds.entry(placement.0).or_default().push(placement);
    }
    let rarest = kinds.values().min_by_key(|copies| copies.len())?;
    let (mut rotations, mut deviation_angstrom) = (Vec::new(), 0.0_f64);
    for copy in rarest {
        let rotation = copy.1.rotation * rarest[0].1.rotation.inverse();
        let mapped = kinds.iter().map(|(kind, copies)| {
            largest_deviation(copies, &rotation, &centre, radii_angstrom[*kind])
        });
        let largest = mapped.fold(0.0, f64::max);
        if largest <= tolerance_angstrom {
            rotations.push(rotation);
            deviation_angstrom = deviation_angstrom.max(largest);
        }
    }
    Some(PointGroup {
        name: name(&rotations)?,
        order: rotations.len(),
        deviation_angstrom,
    })
}

/// The largest distance of a rotated copy from the copy nearest to it, Å.
fn largest_deviation(
    copies: &[&Placement],
    rotation: &Rotation,
    centre: &Vec3,
    radius_angstrom: f64,
) -> f64 {
    let mut largest: f64 = 0.0;
    for (_, pose) in copies {
        let (position, turned) = (
            centre + rotation * (pose.position - centre),
            rotation * pose.rotation,
        );
        let distances = copies.iter().map(|(_, copy)| {
            let angle = copy.rotation.angle_to(&turned);
            (copy.position - position).norm_squared() + (radius_angstrom * angle).powi(2)
        });
        largest = largest.max(distances.fold(f64::INFINITY, f64::min).sqrt());
    }
    largest
}

/// The name of a group of rotations, by its order and the order of its main axis.
fn name(rotations: &[Rotation]) -> Option<String> {
    let turns: Vec<Vec3> = rotations
        .iter()
        .filter(|rotation| rotation.angle() > NO_TURN_RADIAN)
        .filter_map(|rotation| Some(rotation.axis()?.into_inner()))
        .collect();
    let about = |axis: &Vec3| {
        // An axis and its opposite are one.
        let same = turns
            .iter()
            .filter(|other| other.dot(axis).abs() > SAME_AXIS_RADIAN.cos());
        same.count() + 1
    };
    let main = turns.iter().map(about).max().unwrap_or(1);
    match (rotations.len(), main) {
        (order, main) if order == main => Some(format!("C{order}")),
        (order, main) if order == 2 * main => Some(format!("D{main}")),
        (12, 3) => Some("T".into()),
        (24, 4) => Some("O".into()),
        (60, 5) => Some("I".into()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Pose;
    use std::f64::consts::{PI, TAU};

    fn turn(axis: [f64; 3], angle: f64) -> Rotation {
        Rotation::new(Vec3::from(axis).normalize() * angle)
    }

    /// All products of the generators.
    fn generated(generators: &[Rotation]) -> Vec<Rotation> {
        let mut group = vec![Rotation::identity()];
        let mut number = 0;
        while number < group.len() {
            for generator in generators {
                let product = generator * group[number];
                if group.iter().all(|other| other.angle_to(&product) > 1e-3) {
                    group.push(product);
                }
            }
            number += 1;
        }
        group
    }

    /// A body in general position, and its images, somewhere in space.
    fn orbit(group: &[Rotation], noise_angstrom: f64) -> Vec<Placement> {
        let start = Pose {
            position: Vec3::new(31.0, 17.0, 8.0),
            rotation: turn([0.3, 1.0, -0.4], 0.8),
        };
        let place = |(number, rotation): (usize, &Rotation)| {
            let shift = Vec3::new((number as f64).sin(), (2.0 * number as f64).cos(), 0.3);
            let pose = Pose {
                position: rotation * start.position
                    + noise_angstrom * shift
                    + Vec3::new(5.0, -40.0, 12.0),
                rotation: rotation * start.rotation,
            };
            (0, pose)
        };
        group.iter().enumerate().map(place).collect()
    }

    #[test]
    fn every_group_is_recognised() {
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let cases = [
            ("C1", generated(&[])),
            ("C2", generated(&[turn([0.0, 0.0, 1.0], PI)])),
            ("C7", generated(&[turn([0.2, 0.5, 1.0], TAU / 7.0)])),
            (
                "D2",
                generated(&[turn([0.0, 0.0, 1.0], PI), turn([1.0, 0.0, 0.0], PI)]),
            ),
            (
                "D6",
                generated(&[turn([0.0, 0.0, 1.0], TAU / 6.0), turn([1.0, 0.0, 0.0], PI)]),
            ),
            (
                "T",
                generated(&[turn([1.0, 1.0, 1.0], TAU / 3.0), turn([0.0, 0.0, 1.0], PI)]),
            ),
            (
                "O",
                generated(&[
                    turn([1.0, 1.0, 1.0], TAU / 3.0),
                    turn([0.0, 0.0, 1.0], TAU / 4.0),
                ]),
            ),
            (
                "I",
                generated(&[
                    turn([1.0, 1.0, 1.0], TAU / 3.0),
                    turn([0.0, 1.0, golden], TAU / 5.0),
                ]),
            ),
        ];
        for (expected, group) in cases {
            let placements = orbit(&group, 0.3);
            let found = point_group(&placements, &[15.0], 3.0).unwrap();
            assert_eq!(
                (found.name.as_str(), found.order),
                (expected, placements.len())
            );
            // Copies are up to 0.44 Å from their places, those that they meet too, and the centre a little.
            assert!(found.deviation_angstrom < 1.2, "{found:?}");
        }
    }

    #[test]
    fn other_kinds_and_displaced_bodies_lower_the_symmetry() {
        let group = generated(&[turn([0.0, 0.0, 1.0], TAU / 4.0)]);
        let mut placements = orbit(&group, 0.0);
        let order = |placements: &[Placement]| {
            point_group(placements, &[15.0, 15.0], 2.0).map(|group| group.name)
        };
        assert_eq!(order(&placements), Some("C4".into()));
        placements[1].0 = 1;
        placements[3].0 = 1;
        assert_eq!(order(&placements), Some("C2".into()));
        placements[3].1.position.x += 10.0;
        assert_eq!(order(&placements), Some("C1".into()));
        assert_eq!(point_group(&[], &[], 1.0), None);
    }
}
