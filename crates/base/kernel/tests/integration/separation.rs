//! The fast test of overlap of rounded bodies against the closest points.

use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::separation::{Pair, pack};
use protomer_kernel::{Rotation, Vec3};

fn turned(vectors: &[Vec3], rotation: &Rotation) -> Vec<[f64; 3]> {
    let turn = |vector: &Vec3| (rotation * vector).into();
    vectors.iter().map(turn).collect()
}

#[test]
fn rounded_bodies_overlap_where_the_distance_of_their_cores_says_so() {
    let body = Polytope::from_shape(&by_name("truncated-tetrahedron:0.5").unwrap()).unwrap();
    let corners = body.corners;
    let mut apart = 0;
    for number in 0..4000 {
        let mut rng = CounterRng::new(12, 0, number);
        let (first, second) = (rng.rotation(), rng.rotation());
        let offset = rng.unit_vector() * rng.uniform_in(0.3, 1.4);
        let (first, second) = (turned(&corners, &first), turned(&corners, &second));
        let places = |corners: &[[f64; 3]], shift: Vec3| -> Vec<Vec3> {
            corners.iter().map(|x| Vec3::from(*x) + shift).collect()
        };
        let found = closest_points(&places(&first, Vec3::zeros()), &places(&second, offset));
        let distance = found.map_or(0.0, |points| points.distance());
        let reach = rng.uniform_in(1e-3, 0.4);
        let pair = Pair {
            first: &pack(&first),
            second: &pack(&second),
            offset: offset.into(),
            reach,
            error: 0.0,
        };
        let overlap = pair.overlap(&mut { pair.offset }, || true);
        assert_eq!(overlap, distance < reach, "{number}: {distance} {reach}");
        apart += usize::from(!overlap);
        if distance > 0.0 {
            for (reach, expected) in [(distance * 0.999_999, false), (distance * 1.000_001, true)] {
                let pair = Pair { reach, ..pair };
                assert_eq!(pair.overlap(&mut { pair.offset }, || true), expected);
            }
        }
    }
    assert!((500..3500).contains(&apart), "{apart}");
}
