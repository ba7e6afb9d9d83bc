//! Fluids: nothing overlaps, every body is where it may be with the same probability, and the seed
//! decides.

use crate::common::TemporaryFolder;
use protomer_body::assembly::Placement;
use protomer_kernel::{Pose, Vec3};
use protomer_protein_verbs::assemblies::assemble::BodyFiles;
use protomer_protein_verbs::assemblies::fluid::fluid;

const BOX_ANGSTROM: [f64; 3] = [70.0, 60.0, 80.0];

fn cubes(place: &TemporaryFolder) -> BodyFiles {
    BodyFiles::read(&[place.path("a.body"), place.path("b.body")]).unwrap()
}

/// The 27 images of a placement in the boxes around.
fn images((kind, pose): &Placement) -> Vec<Placement> {
    let shift = |image: usize| [image / 9, image / 3 % 3, image % 3].map(|step| step as f64 - 1.0);
    let shifted = |image: usize| {
        let shift = Vec3::from(shift(image)).component_mul(&Vec3::from(BOX_ANGSTROM));
        (
            *kind,
            Pose {
                position: pose.position + shift,
                rotation: pose.rotation,
            },
        )
    };
    (0..27).map(shifted).collect()
}

#[test]
fn no_body_overlaps_any_image_of_another() {
    let place = TemporaryFolder::new();
    let files = cubes(&place);
    let mut met_across_the_border = 0;
    for seed in 0..20 {
        // An eighth of the volume: placing without looking at images would let bodies overlap
        // across the border.
        let placed = fluid(&files, &[22, 20], BOX_ANGSTROM, seed).unwrap();
        assert_eq!(placed.iter().filter(|(kind, _)| *kind == 0).count(), 22);
        assert_eq!(placed.len(), 42);
        for (second, placement) in placed.iter().enumerate() {
            for first in &placed[..second] {
                for image in images(placement) {
                    assert!(!files.hard.any_overlap(&[*first, image]), "seed {seed}");
                    let near = (image.1.position - first.1.position).norm() < 17.0;
                    met_across_the_border +=
                        usize::from(near && image.1.position != placement.1.position);
                }
            }
        }
    }
    assert!(
        met_across_the_border > 50,
        "the test saw only {met_across_the_border} pairs across the border"
    );
}

#[test]
fn places_and_orientations_are_uniform() {
    let place = TemporaryFolder::new();
    let files = cubes(&place);
    let (mut low, mut up, mut bodies) = ([0.0; 3], [0.0; 3], 0.0);
    for seed in 0..400 {
        for (_, pose) in fluid(&files, &[4, 4], BOX_ANGSTROM, seed).unwrap() {
            let axis = pose.rotation * Vec3::z();
            for (edge, length) in BOX_ANGSTROM.iter().enumerate() {
                assert!(pose.position[edge].abs() <= 0.5 * length);
                low[edge] += f64::from(pose.position[edge] < -0.25 * length);
                up[edge] += axis[edge] * axis[edge];
            }
            bodies += 1.0;
        }
    }
    // A quarter of the bodies in a quarter of the box, a third of the squared axis along each edge;
    // five standard errors of independent draws (variances 3/16 and 4/45).
    for edge in 0..3 {
        assert!(
            (low[edge] / bodies - 0.25_f64).abs() < 5.0 * (3.0 / 16.0 / bodies).sqrt(),
            "{low:?} of {bodies}"
        );
        assert!(
            (up[edge] / bodies - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / bodies).sqrt(),
            "{up:?} of {bodies}"
        );
    }
}

#[test]
fn the_seed_decides() {
    let place = TemporaryFolder::new();
    let files = cubes(&place);
    let made = |seed| fluid(&files, &[3, 2], BOX_ANGSTROM, seed).unwrap();
    assert_eq!(made(5), made(5));
    assert_ne!(made(5), made(6));
}

#[test]
fn a_full_box_and_a_small_box_are_errors() {
    let place = TemporaryFolder::new();
    let files = cubes(&place);
    let refused =
        |counts: &[usize], edge| fluid(&files, counts, [edge; 3], 1).unwrap_err().to_string();
    assert!(refused(&[50, 0], 40.0).contains("no room for body"));
    assert!(refused(&[65, 0], 40.0).contains("and the box has only"));
    assert!(refused(&[1, 1], 34.0).contains("an edge must hold two"));
    assert!(refused(&[1], 100.0).contains("one per body"));
    assert!(refused(&[0, 0], 100.0).contains("at least one"));
    assert!(refused(&[1, 0], f64::NAN).contains("box length"));
}
