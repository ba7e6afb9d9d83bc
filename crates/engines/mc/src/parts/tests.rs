//! Partition functions against closed forms, chains drawn directly, and each other.

use super::*;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Rotation, Vec3};
use std::f64::consts::{PI, TAU};

const SPRING_KT_PER_ANGSTROM2: f64 = 4.0;
const TWIST_KT_PER_RAD2: f64 = 400.0;
const WELL_KT: f64 = -14.0;

/// Bodies around an axis, alternating between two species if there are two; neighbours touch.
pub(super) fn ring(bodies: usize, species: usize) -> Arrangement {
    let body = |number: usize| {
        let rotation = Rotation::new(Vec3::z() * (TAU * number as f64 / bodies as f64));
        let pose = Pose {
            position: rotation * Vec3::new(20.0, 0.0, 0.0),
            rotation,
        };
        PlacedBody {
            species: number % species,
            pose,
            frame: pose,
            square_of_gyration_angstrom2: 100.0,
        }
    };
    with_neighbours((0..bodies).map(body).collect(), |i, j| {
        let apart = i.abs_diff(j);
        apart == 1 || apart == bodies - 1
    })
}

pub(super) fn with_neighbours(
    bodies: Vec<PlacedBody>,
    touch: impl Fn(usize, usize) -> bool,
) -> Arrangement {
    let count = bodies.len();
    let neighbours: Vec<Vec<usize>> = (0..count)
        .map(|i| (0..count).filter(|j| *j != i && touch(i, *j)).collect())
        .collect();
    let energy = |i: usize, j: usize| match neighbours[i].contains(&j) {
        true => WELL_KT,
        false => 0.0,
    };
    Arrangement {
        energies_kt: (0..count)
            .map(|i| (0..count).map(|j| energy(i, j)).collect())
            .collect(),
        bodies,
        neighbours,
    }
}

/// A spring and a twist between neighbours, from the pose of the assembly on.
fn spring_kt(arrangement: &Arrangement, (i, j): (usize, usize), a: &Pose, b: &Pose) -> f64 {
    if !arrangement.neighbours[i].contains(&j) {
        return 0.0;
    }
    // Always of the higher body in the frame of the lower, so that the energy is one function.
    let ((i, a), (j, b)) = if i < j {
        ((i, a), (j, b))
    } else {
        ((j, b), (i, a))
    };
    let relative = b.then(&a.inverse());
    let bodies = &arrangement.bodies;
    let native = bodies[j].pose.then(&bodies[i].pose.inverse());
    let shift = relative.position - native.position;
    let angle = relative.rotation.angle_to(&native.rotation);
    WELL_KT
        + 0.5 * SPRING_KT_PER_ANGSTROM2 * shift.norm_squared()
        + 0.5 * TWIST_KT_PER_RAD2 * angle.powi(2)
}

/// Springs between the bodies of an arrangement, weaker by a factor.
struct Springs<'a> {
    arrangement: &'a Arrangement,
    factor: f64,
}

impl BodyEnergies for Springs<'_> {
    fn overlap(&self, _: usize, _: usize, _: &Pose, _: &Pose) -> bool {
        false
    }

    fn energy_kt(&self, i: usize, j: usize, a: &Pose, b: &Pose) -> f64 {
        match spring_kt(self.arrangement, (i, j), a, b) {
            0.0 => 0.0,
            kt => WELL_KT + (kt - WELL_KT) / self.factor,
        }
    }
}

/// Bodies that overlap everywhere.
struct Solid;

impl BodyEnergies for Solid {
    fn overlap(&self, _: usize, _: usize, _: &Pose, _: &Pose) -> bool {
        true
    }

    fn energy_kt(&self, _: usize, _: usize, _: &Pose, _: &Pose) -> f64 {
        0.0
    }
}

/// ln of the integral of one spring.
fn ln_one_spring() -> f64 {
    let step = PI / 100_000.0;
    let by_turn: f64 = (0..100_000)
        .map(|number| (f64::from(number) + 0.5) * step)
        .map(|angle| {
            (-0.5 * TWIST_KT_PER_RAD2 * angle * angle).exp() * (1.0 - angle.cos()) / PI * step
        })
        .sum();
    1.5 * (2.0 * PI / SPRING_KT_PER_ANGSTROM2).ln() + by_turn.ln() - WELL_KT
}

fn precise(seed: u64) -> GrowthSettings {
    GrowthSettings {
        seed,
        live_states: 200,
        runs: 24,
        ..GrowthSettings::default()
    }
}

/// Partition functions of all parts.
fn partitions(arrangement: &Arrangement, settings: &GrowthSettings) -> Vec<Attached> {
    let energy = Springs {
        arrangement,
        factor: 1.0,
    };
    let found = connected_parts(arrangement, 100).unwrap();
    let mut samples: Vec<PartSamples> = Vec::new();
    for (number, part) in found.parts.iter().enumerate() {
        let grown = match part.grown_from {
            None => free_body(arrangement.bodies[part.bodies[0]].pose, settings),
            Some(smaller) => attach(
                arrangement,
                (number as u32, part),
                &samples[smaller],
                &energy,
                settings,
                &|| true,
            )
            .unwrap()
            .unwrap(),
        };
        samples.push(grown);
    }
    samples.iter().map(|grown| *grown.attached()).collect()
}

/// A pose about that of the assembly, drawn with the Boltzmann factor of one spring.
fn drawn(native: &Pose, rng: &mut CounterRng) -> Pose {
    let normal = |rng: &mut CounterRng| Vec3::new(rng.normal(), rng.normal(), rng.normal());
    let shift = normal(rng) / SPRING_KT_PER_ANGSTROM2.sqrt();
    // The density 2 (1 - cos θ)/θ² of even rotations by rejection; it is at most one.
    let turn = loop {
        let turn = normal(rng) / TWIST_KT_PER_RAD2.sqrt();
        let angle = turn.norm();
        if rng.uniform() < 2.0 * (1.0 - angle.cos()) / angle.powi(2) {
            break turn;
        }
    };
    Pose {
        position: native.position + shift,
        rotation: Rotation::new(turn) * native.rotation,
    }
}

/// ln < exp(-U) > of the spring that closes a chain of free springs, and its error: chains are drawn directly.
fn ln_closure(arrangement: &Arrangement, chains: u32) -> (f64, f64) {
    let bodies = arrangement.bodies.len();
    let mut rng = CounterRng::new(3, 0, 0);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..chains {
        let mut pose = arrangement.bodies[0].pose;
        for body in 1..bodies {
            let pair = [&arrangement.bodies[body - 1], &arrangement.bodies[body]];
            let native = pair[1].pose.then(&pair[0].pose.inverse());
            pose = drawn(&native, &mut rng).then(&pose);
        }
        let first = arrangement.bodies[0].pose;
        let factor = (-spring_kt(arrangement, (0, bodies - 1), &first, &pose)).exp();
        sum += factor;
        squares += factor * factor;
    }
    let count = f64::from(chains);
    let relative = (squares / sum.powi(2) - 1.0 / count).sqrt();
    ((sum / count).ln(), relative)
}

#[test]
fn chains_have_the_integrals_of_their_springs_and_rings_close_as_drawn_chains_do() {
    for bodies in [3, 4] {
        let ring = ring(bodies, 1);
        let found = partitions(&ring, &precise(1));
        assert_eq!(found.len(), bodies);
        for (number, part) in found[..bodies - 1].iter().enumerate() {
            let exact = number as f64 * ln_one_spring();
            assert!((part.ln_partition - exact).abs() < 0.12, "{part:?} {exact}");
        }
        let (ln_closure, error) = ln_closure(&ring, 400_000);
        assert!(error < 0.04);
        let exact = (bodies - 1) as f64 * ln_one_spring() + ln_closure;
        let closed = &found[bodies - 1];
        assert!(
            (closed.ln_partition - exact).abs() < 0.2,
            "{bodies} bodies: {closed:?} {exact}"
        );
        assert!(closed.share_at_limit < 0.01 && closed.ln_partition_error < 0.1);
    }
}

/// Samples weighted for other springs have the integrals of these springs, and samples moved into them do too.
#[test]
fn samples_of_one_medium_serve_for_another() {
    let chain = with_neighbours(ring(8, 1).bodies[..3].to_vec(), |i, j| i.abs_diff(j) == 1);
    let found = connected_parts(&chain, 10).unwrap();
    let (settings, factor) = (precise(1), 1.1);
    let energy = Springs {
        arrangement: &chain,
        factor: 1.0,
    };
    let weaker = Springs {
        arrangement: &chain,
        factor,
    };
    let mut samples = free_body(chain.bodies[0].pose, &settings);
    for (number, part) in (0..).zip(&found.parts).skip(1) {
        let part = (number, part);
        samples = attach(&chain, part, &samples, &energy, &settings, &|| true)
            .unwrap()
            .unwrap();
    }
    let whole = found.parts.last().unwrap();
    let before = samples.attached().ln_partition;
    let weighted = samples.weighted(whole, &weaker);
    // Each of two springs has three directions in space and, to a good approximation, three of turns.
    let exact = 2.0 * 3.0 * f64::ln(factor);
    let change = weighted.attached.ln_partition - before;
    assert!((change - exact).abs() < 0.06, "{change} {exact}");
    assert!(weighted.change_error < 0.05 && weighted.effective_samples > 200.0);
    let moved = samples.moved((2, whole), &weaker, &settings);
    let again = moved.weighted(whole, &energy).attached.ln_partition;
    assert!((again - before).abs() < 0.1, "{again} {before}");
}

/// Two balls on a spring, and a third between them that neither may come near.
struct Between<'a> {
    springs: Springs<'a>,
}

const NEAREST_ANGSTROM: f64 = 9.8;

impl BodyEnergies for Between<'_> {
    fn overlap(&self, i: usize, j: usize, a: &Pose, b: &Pose) -> bool {
        (i == 2 || j == 2) && (a.position - b.position).norm() < NEAREST_ANGSTROM
    }

    fn energy_kt(&self, i: usize, j: usize, a: &Pose, b: &Pose) -> f64 {
        match i == 2 || j == 2 {
            true => 0.0,
            false => self.springs.energy_kt(i, j, a, b),
        }
    }
}

/// The room between two bodies by nested sampling over overlapping states, and by drawing springs and places directly.
#[test]
fn a_body_between_others_has_the_room_that_they_leave() {
    let body = |x: f64| {
        let pose = Pose {
            position: Vec3::new(x, 0.0, 0.0),
            rotation: Rotation::identity(),
        };
        PlacedBody {
            species: 0,
            pose,
            frame: pose,
            square_of_gyration_angstrom2: 100.0,
        }
    };
    let row = with_neighbours([0.0, 20.0, 10.0].map(body).to_vec(), |_, _| true);
    let energies = Between {
        springs: Springs {
            arrangement: &row,
            factor: 1.0,
        },
    };
    let part = |bodies: &[usize]| PartKind {
        bodies: bodies.to_vec(),
        attached_to: vec![0; bodies.len()],
        grown_from: None,
        symmetry_number: 1,
        energy_kt: 0.0,
    };
    let settings = GrowthSettings {
        limit_angstrom: 1.5,
        ..precise(1)
    };
    let goes_on = || true;
    let single = free_body(row.bodies[0].pose, &settings);
    let pair = attach(
        &row,
        (1, &part(&[0, 1])),
        &single,
        &energies,
        &settings,
        &goes_on,
    );
    let pair = pair.unwrap().unwrap();
    let three = attach(
        &row,
        (2, &part(&[0, 1, 2])),
        &pair,
        &energies,
        &settings,
        &goes_on,
    );
    let three = three.unwrap().unwrap();
    let found = three.attached().ln_partition - pair.attached().ln_partition;
    let region = crate::pair::region::Region {
        about: row.bodies[2].pose,
        square_of_gyration_angstrom2: 100.0,
        limit_angstrom: 1.5,
    };
    let (mut rng, mut free, draws) = (CounterRng::new(5, 0, 0), 0, 400_000);
    let mut drawn_draws = 0;
    while drawn_draws < draws {
        let second = drawn(&row.bodies[1].pose, &mut rng);
        let shift = second.position - row.bodies[1].pose.position;
        let turn = second.rotation.angle();
        // The spring itself stays within the limit of the part.
        if shift.norm_squared() + 4.0 / 3.0 * (1.0 - turn.cos()) * 100.0 > 1.5 * 1.5 {
            continue;
        }
        drawn_draws += 1;
        let third = region.pose(&region.draw(&mut rng)).position;
        let is_free =
            third.norm() > NEAREST_ANGSTROM && (third - second.position).norm() > NEAREST_ANGSTROM;
        free += u32::from(is_free);
    }
    let exact = (region.volume_angstrom3() * f64::from(free) / f64::from(draws)).ln();
    assert!(f64::from(free) < 0.5 * f64::from(draws));
    assert!((found - exact).abs() < 0.15, "{found} {exact} {free}");
}

/// Few live states: errors cover what seeds differ by.
#[test]
fn errors_cover_what_seeds_differ_by() {
    let chain = with_neighbours(ring(8, 1).bodies[..3].to_vec(), |i, j| i.abs_diff(j) == 1);
    let exact = 2.0 * ln_one_spring();
    let (mut squares, mut bias) = (0.0, 0.0);
    for seed in 0..16 {
        let settings = GrowthSettings {
            seed,
            ..GrowthSettings::default()
        };
        let whole = *partitions(&chain, &settings).last().unwrap();
        let deviation = (whole.ln_partition - exact) / whole.ln_partition_error;
        squares += deviation.powi(2) / 16.0;
        bias += deviation / 16.0;
    }
    // The mean of 16 deviations of one has an error of 0.25.
    assert!(bias.abs() < 0.8, "{bias}");
    assert!((0.25..2.2).contains(&squares), "{squares}");
}

/// All subsets, one by one: the slow twin of the search by size.
fn by_subsets(arrangement: &Arrangement) -> Vec<(usize, usize)> {
    let bodies = arrangement.bodies.len();
    let mut kinds: Vec<Vec<usize>> = Vec::new();
    for subset in 1..1_u32 << bodies {
        let members: Vec<usize> = (0..bodies).filter(|body| subset >> body & 1 == 1).collect();
        let mut reached = vec![members[0]];
        while let Some(next) = members.iter().find(|body| {
            !reached.contains(body)
                && arrangement.neighbours[**body]
                    .iter()
                    .any(|other| reached.contains(other))
        }) {
            reached.push(*next);
        }
        let is_new = |kind: &Vec<usize>| {
            kind.len() != members.len()
                || arrangement.composition(kind) != arrangement.composition(&members)
                || arrangement.motions(kind, &members, 1.0) == 0
        };
        if reached.len() == members.len() && kinds.iter().all(is_new) {
            kinds.push(members);
        }
    }
    let mut found: Vec<(usize, usize)> = kinds
        .iter()
        .map(|kind| (kind.len(), arrangement.motions(kind, kind, 1.0)))
        .collect();
    found.sort_unstable();
    found
}

/// Two rings on top of each other, the upper turned around: D_n.
fn stack(members: usize, species: usize) -> Arrangement {
    let mut bodies = ring(members, species).bodies;
    for body in &mut bodies {
        body.pose.position.z = 8.0;
        body.frame = body.pose;
    }
    let turned = Pose {
        position: Vec3::zeros(),
        rotation: Rotation::new(Vec3::x() * PI),
    };
    let lower: Vec<PlacedBody> = bodies
        .iter()
        .map(|body| PlacedBody {
            pose: body.pose.then(&turned),
            frame: body.pose.then(&turned),
            ..*body
        })
        .collect();
    bodies.extend(lower);
    let places: Vec<Vec3> = bodies.iter().map(|body| body.pose.position).collect();
    let reach = 1.2 * 40.0 * (PI / members as f64).sin();
    with_neighbours(bodies, |i, j| {
        (places[i] - places[j]).norm() < reach.max(17.0)
    })
}

#[test]
fn parts_are_those_of_all_subsets() {
    for arrangement in [ring(6, 1), ring(6, 2), stack(3, 1), stack(4, 2)] {
        let found = connected_parts(&arrangement, 10_000).unwrap();
        let mut parts: Vec<(usize, usize)> = found
            .parts
            .iter()
            .map(|part| (part.bodies.len(), part.symmetry_number))
            .collect();
        parts.sort_unstable();
        assert_eq!(parts, by_subsets(&arrangement));
        assert!(found.omitted.iter().all(|omitted| *omitted == 0));
        for part in &found.parts {
            let Some(smaller) = part.grown_from else {
                continue;
            };
            let smaller = &found.parts[smaller];
            assert_eq!(smaller.bodies, part.bodies[..part.bodies.len() - 1]);
        }
    }
}

#[test]
fn limits_on_parts_keep_the_whole_and_say_what_they_leave_out() {
    let found = connected_parts(&stack(4, 2), 2).unwrap();
    assert_eq!(found.parts.last().unwrap().bodies.len(), 8);
    assert!(found.omitted.iter().sum::<usize>() > 5);
    let mut apart = ring(4, 1);
    apart.neighbours = vec![vec![1], vec![0], vec![3], vec![2]];
    assert_eq!(connected_parts(&apart, 10), None);
}

/// One kind of body: the balance has one unknown, and bisection finds it.
#[test]
fn concentrations_of_one_kind_are_those_of_bisection() {
    let species: Vec<Species> = [(1, 0.0), (2, 20.0), (5, 110.0), (12, 300.0)]
        .map(|(bodies, ln_constant)| Species {
            composition: vec![bodies],
            ln_constant,
        })
        .to_vec();
    for total in [1e-12, 1e-9, 1e-6, 1e-3] {
        let bound = |ln_free: f64| -> f64 {
            let all = species_concentrations(&species, &[ln_free]);
            let bodies = species.iter().map(|one| one.composition[0] as f64);
            all.iter().zip(bodies).map(|(c, bodies)| c * bodies).sum()
        };
        let (mut low, mut high) = (-100.0, 0.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            match bound(middle) < total {
                true => low = middle,
                false => high = middle,
            }
        }
        let ln_free = free_concentrations(&species, &[total])[0];
        assert!((ln_free - low).abs() < 1e-9, "{ln_free} {low}");
    }
}

#[test]
fn two_kinds_are_balanced_each() {
    let species: Vec<Species> = [
        (vec![1, 0], 0.0),
        (vec![0, 1], 0.0),
        (vec![1, 1], 18.0),
        (vec![2, 2], 60.0),
        (vec![0, 2], 9.0),
    ]
    .map(|(composition, ln_constant)| Species {
        composition,
        ln_constant,
    })
    .to_vec();
    for totals in [[1e-6, 1e-6], [1e-6, 3e-9], [2e-3, 1e-3]] {
        let ln_free = free_concentrations(&species, &totals);
        let found = species_concentrations(&species, &ln_free);
        for (kind, total) in totals.iter().enumerate() {
            let sum: f64 = species
                .iter()
                .zip(&found)
                .map(|(one, c)| one.composition[kind] as f64 * c)
                .sum();
            assert!((sum / total - 1.0).abs() < 1e-9, "{sum} {total}");
        }
    }
}

#[test]
fn no_room_an_early_end_and_bad_settings_are_told() {
    let pair = with_neighbours(ring(8, 1).bodies[..2].to_vec(), |_, _| true);
    let settings = GrowthSettings {
        live_states: 20,
        ..GrowthSettings::default()
    };
    let found = connected_parts(&pair, 10).unwrap();
    let single = free_body(pair.bodies[0].pose, &settings);
    let part = (1, &found.parts[1]);
    let none = attach(&pair, part, &single, &Solid, &settings, &|| true).unwrap();
    assert!(none.is_none());
    let flat = Springs {
        arrangement: &pair,
        factor: 1.0,
    };
    let ended = attach(&pair, part, &single, &flat, &settings, &|| false).unwrap();
    assert!(ended.is_none());
    let wrong = GrowthSettings {
        runs: 1,
        ..settings
    };
    assert!(attach(&pair, part, &single, &flat, &wrong, &|| true).is_err());
}
