use super::*;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::separation::dot;

/// A box in which a body of this range meets no image of itself, tilted by up to twice its lengths: so small
/// that bodies meet several images of each other, long and narrow, or as wide as it is deep.
fn random_box<const D: usize>(rng: &mut CounterRng, range: f64) -> PeriodicBox<D> {
    let [shortest, longest] = [[1.0, 1.5], [2.0, 2.5], [1.0, 8.0], [2.0, 8.0]][rng.index(4)];
    let lengths = std::array::from_fn(|_| range * rng.uniform_in(shortest, longest));
    let tilts = (0..D * (D - 1) / 2).map(|_| rng.uniform_in(-2.0, 2.0));
    PeriodicBox::new(lengths, &tilts.collect::<Vec<_>>()).unwrap()
}

fn random_system<const D: usize>(name: &str, rng: &mut CounterRng) -> System<D> {
    let body = HardBody::<D>::new(&by_name(name).unwrap(), 0.0).unwrap();
    let space = random_box(rng, 2.0 * body.outer_radius);
    let bodies = 1 + (0.2 * space.volume() / body.volume) as usize;
    let (mut positions, mut rotations) = (Vec::new(), Vec::new());
    for _ in 0..bodies {
        positions.push(space.point(&std::array::from_fn(|_| rng.uniform_in(-1.0, 2.0))));
        rotations.push(match D {
            2 => Rotation::from_scaled_axis(rng.uniform() * protomer_kernel::Vec3::z()),
            _ => rng.rotation(),
        });
    }
    System::new(body, Vec::new(), space, positions, rotations).unwrap()
}

/// The bodies that one would overlap, over all images by up to so many edges.
fn overlaps_over_images<const D: usize>(system: &System<D>, trial: &Trial<D>) -> Vec<u32> {
    const MOST: usize = 4;
    let mut found = Vec::new();
    for other in 0..system.len() {
        for image in 0..(2 * MOST + 1).pow(D as u32) {
            let mut rest = image;
            let mut place = system.positions[other];
            for edge in 0..D {
                let times = (rest % (2 * MOST + 1)) as f64 - MOST as f64;
                system.space.add_edges(&mut place, edge, times);
                rest /= 2 * MOST + 1;
            }
            let offset = std::array::from_fn(|axis| place[axis] - trial.position[axis]);
            let near = Near {
                body: other as u32,
                offset,
                squared: dot(&offset, &offset),
            };
            if other != trial.body && system.is_overlap(trial, &near, 1.0) {
                found.push(other as u32);
            }
        }
    }
    found
}

fn overlaps_are_those_of_all_images<const D: usize>(name: &str) {
    let (mut overlapping, mut free, mut collisions) = (0, 0, 0);
    for number in 0..20 {
        let mut rng = CounterRng::new(1, D as u32, number);
        let mut system = random_system::<D>(name, &mut rng);
        for body in 0..system.len() {
            let trial = system.where_it_is(body);
            let expected = overlaps_over_images(&system, &trial);
            let mut found = Vec::new();
            for other in 0..system.len() as u32 {
                let count = system.overlaps_of(&trial, |counted| counted == other);
                found.extend(std::iter::repeat_n(other, count));
            }
            assert_eq!(found, expected, "{:?}", system.space);
            overlapping += found.len();
            free += usize::from(found.is_empty());
            let steps = Steps {
                translation: 0.45 * system.space.smallest_length(),
                rotation: 1.0,
            };
            let trial = system.propose(&mut rng, &steps, Some(body));
            let is_blocked = !overlaps_over_images(&system, &trial).is_empty();
            assert_eq!(system.collides(&trial), is_blocked, "{:?}", system.space);
            collisions += usize::from(is_blocked);
        }
    }
    let kinds = [overlapping, free, collisions];
    assert!(kinds.iter().all(|count| *count > 20), "{kinds:?}");
}

#[test]
fn overlaps_in_tilted_boxes_are_those_of_all_images() {
    overlaps_are_those_of_all_images::<2>("polygon:4");
    overlaps_are_those_of_all_images::<3>("cube");
}

/// A deformation that cannot be leaves everything as it was; one that can moves the bodies with the box.
#[test]
fn bodies_move_with_a_box_that_is_deformed() {
    let mut deformed = 0;
    for number in 0..20 {
        let mut rng = CounterRng::new(2, 0, number);
        let crowded = random_system::<3>("cube", &mut rng);
        // So far apart that few overlap.
        let apart = |place: &[f64; 3]| place.map(|x| 8.0 * x);
        let places: Vec<[f64; 3]> = crowded.positions.iter().map(apart).collect();
        let (space, rotations) = (crowded.space.scaled(8.0), crowded.rotations.clone());
        let mut system = System::new(
            crowded.body().clone(),
            Vec::new(),
            space,
            places.clone(),
            rotations,
        )
        .unwrap();
        let before = system.clone();
        let squeezed = [[0.01, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let deformation = [[1.2, 0.9, -0.7], [0.0, 1.1, 0.8], [0.0, 0.0, 1.3]];
        let is_squeezed = system.try_deform(&squeezed) == Deformation::Done;
        if is_squeezed || system.try_deform(&deformation) != Deformation::Done {
            assert_eq!(system.space, before.space);
            assert_eq!(system.positions, before.positions);
            continue;
        }
        deformed += 1;
        for (place, before) in system.positions.iter().zip(&places) {
            let moved = deformation.map(|row| dot(&row, before));
            let off = std::array::from_fn(|axis| place[axis] - moved[axis]);
            let left = system.space.nearest_image(&off);
            assert!(dot(&left, &left) < 1e-18, "{left:?}");
        }
    }
    assert!(deformed > 5, "{deformed}");
}
