//! The response against slow, obvious twins: sums over all sites in double precision.

use super::*;
use crate::energy::terms::Terms;
use crate::energy::{EnergyModel, NoCharges, TermsByType, WithTerms};
use crate::test_support::tetrahedron;
use crate::{BodyType, Interaction, Settings, Simulation, System};
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Rotation};
use std::ops::ControlFlow;

/// A body with what it was made from.
struct Solute {
    grid: ResponseGrid,
    sites: Vec<(Vec3, Amounts)>,
    body: Arc<ResponseBody>,
}

impl Solute {
    /// A body whose table holds `value` at the places of its points.
    fn new(
        shape: [usize; 3],
        value: impl Fn(&Vec3) -> Amounts,
        sites: Vec<(Vec3, Amounts)>,
    ) -> Self {
        let origin_angstrom = Vec3::from(shape.map(|points| -0.5 * (points - 1) as f64));
        let mut values = Vec::new();
        for k in 0..shape[2] {
            for j in 0..shape[1] {
                for i in 0..shape[0] {
                    let place = origin_angstrom + Vec3::new(i as f64, j as f64, k as f64);
                    values.push(value(&place).map(|number| number as f32));
                }
            }
        }
        let grid = ResponseGrid {
            origin_angstrom,
            spacing_angstrom: 1.0,
            shape,
            values,
        };
        let charges = sites.iter().map(|(place, amounts)| (*place, amounts[0]));
        let body = ResponseBody::new(grid.clone(), &sites, charges.collect()).unwrap();
        Self {
            grid,
            sites,
            body: Arc::new(body),
        }
    }

    /// The slow, obvious twin: every site of the other body between the eight points around it, kT.
    fn acting_on_kt(&self, other: &Self, pose: &RelativePose) -> f64 {
        let [nx, ny, nz] = self.grid.shape;
        let mut energy_kt = 0.0;
        for (place, amounts) in &other.sites {
            let steps = pose.transform_point(place) - self.grid.origin_angstrom;
            let corner = steps.map(f64::floor);
            let is_inside = |axis: usize, points: usize| {
                corner[axis] >= 0.0 && corner[axis] + 1.0 < points as f64
            };
            if !(is_inside(0, nx) && is_inside(1, ny) && is_inside(2, nz)) {
                continue;
            }
            for step in 0..8 {
                let step = Vec3::from([step & 1, step >> 1 & 1, step >> 2].map(f64::from));
                let point = (corner + step).map(|along| along as usize);
                let value = self.grid.values[(point.z * ny + point.y) * nx + point.x];
                let apart = (steps - corner - step).map(|along| 1.0 - along.abs());
                for (value, amount) in value.iter().zip(amounts) {
                    energy_kt += apart.product() * f64::from(*value) * amount;
                }
            }
        }
        energy_kt
    }
}

/// The response of two bodies by the twin, kT.
fn by_sites_kt(first: &Solute, second: &Solute, pose: &RelativePose) -> f64 {
    first.acting_on_kt(second, pose) + second.acting_on_kt(first, &pose.inverse())
}

/// A ball of 8 Å with charges and volume, in salt of Debye length 10 Å. The tables of the volume end at its
/// surface, and all fall to zero towards the faces, as those of natural bodies do.
fn ball(points: usize, charge_e: f64, seed: u64) -> Solute {
    let half = 0.5 * (points - 1) as f64;
    let value = move |place: &Vec3| {
        let rim = ((half - place.amax()) / 8.0).min(1.0);
        let potential = 3.0 * charge_e * (-place.norm() / 10.0).exp() / (place.norm() + 4.0);
        let outside = f64::from(u8::from(place.norm() > 8.0));
        [
            rim * potential,
            0.004 * rim * outside * potential * potential,
            0.002 * rim * outside * potential * potential,
            -0.5 * rim * outside * potential * potential,
        ]
    };
    let mut rng = CounterRng::new(seed, 0, 0);
    let mut sites = Vec::new();
    // The lattice of 3 Å on which the bodies of a simulation are gathered.
    for number in 0..6 * 6 * 6 {
        let point = [number % 6, number / 6 % 6, number / 36];
        let place = Vec3::from(point.map(|along| 3.0 * f64::from(along) - 7.5));
        if place.norm() < 9.5 {
            let charge_e = rng.uniform_in(-0.5, 0.5) + 0.05 * charge_e;
            sites.push((place, [charge_e, 20.0, 27.0, 0.02]));
        }
    }
    Solute::new([points; 3], value, sites)
}

/// At contact and beyond, and at any orientation, blocks stand for their sites.
#[test]
fn blocks_give_the_sum_over_sites() {
    let balls = [ball(49, 3.0, 11), ball(49, -4.0, 12)];
    let response = SolventResponse::new(Arc::clone(&balls[0].body), Arc::clone(&balls[1].body));
    let (mut largest, mut squares) = (0.0_f64, 0.0);
    let poses = 60;
    for draw in 0..poses {
        let mut rng = CounterRng::new(13, 0, draw);
        let pose = Pose {
            position: (16.5 + 0.3 * draw as f64) * rng.unit_vector(),
            rotation: rng.rotation(),
        };
        let pose = RelativePose::from(&pose);
        let (found, expected) = (
            response.energy_kt(&pose),
            by_sites_kt(&balls[0], &balls[1], &pose),
        );
        let error = found - expected;
        assert!(error.abs() < 0.05, "{draw}: {found} {expected}");
        squares += error * error;
        largest = largest.max(expected.abs());
    }
    let error = (squares / poses as f64).sqrt();
    assert!(error < 0.015, "{error}");
    assert!(largest > 3.0, "{largest}");
}

/// Linear tables are interpolated without error, so the energy is the sum written out.
#[test]
fn the_energy_is_that_of_the_sites_in_both_tables() {
    let value = |place: &Vec3| {
        [
            place.x + 0.5,
            2.0 - place.y,
            place.z * 0.25,
            0.1 * (place.x - place.z),
        ]
    };
    let other = |place: &Vec3| [place.z, place.x - place.y, 1.0, 0.3 - 0.1 * place.y];
    let mut rng = CounterRng::new(4, 0, 0);
    let mut draw = || {
        (
            rng.vector_in_ball(3.0),
            [rng.uniform(), rng.uniform(), rng.uniform(), 0.3],
        )
    };
    let sites: [Vec<(Vec3, Amounts)>; 2] = [
        (0..5).map(|_| draw()).collect(),
        (0..7).map(|_| draw()).collect(),
    ];
    let shape = [21, 25, 23];
    let solutes = [
        Solute::new(shape, value, sites[0].clone()),
        Solute::new(shape, other, sites[1].clone()),
    ];
    let response = SolventResponse::new(Arc::clone(&solutes[0].body), Arc::clone(&solutes[1].body));
    let turn = Rotation::from_axis_angle(&Vec3::y_axis(), 0.7);
    let place = Vec3::new(2.0, -1.0, 3.0);
    let relative = RelativePose::from(&Pose {
        position: place,
        rotation: turn,
    });
    let mut expected = 0.0;
    let dot = |a: Amounts, b: Amounts| (0..4).map(|lane| a[lane] * b[lane]).sum::<f64>();
    for (site, amounts) in &sites[1] {
        expected += dot(value(&(turn * site + place)), *amounts);
    }
    for (site, amounts) in &sites[0] {
        expected += dot(other(&(turn.inverse() * (site - place))), *amounts);
    }
    let found = response.energy_kt(&relative);
    assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    let mut shared = 0.0;
    response.shares(&relative, &mut |_, _, energy_kt| shared += energy_kt);
    assert!((found - shared).abs() < 1e-5, "{found} {shared}");
}

/// A block of sites in a table without rim that it half leaves: sites beyond the table have no energy.
#[test]
fn sites_beyond_the_table_have_no_energy() {
    let constant = Solute::new([21; 3], |_| [1.0; 4], vec![(Vec3::zeros(), [1.0; 4])]);
    let mut sites = Vec::new();
    for along in 0..8 {
        sites.push((
            Vec3::new(3.0 * f64::from(along), 0.0, 0.0),
            [1.0, 2.0, 3.0, 4.0],
        ));
    }
    let row = Solute::new([21; 3], |_| [0.0; 4], sites);
    let response = SolventResponse::new(Arc::clone(&constant.body), Arc::clone(&row.body));
    for along in 0..20 {
        let pose = RelativePose::from(&Pose {
            position: Vec3::new(-8.2 + f64::from(along), 1.3, 2.7),
            rotation: Rotation::identity(),
        });
        let (found, expected) = (
            response.energy_kt(&pose),
            by_sites_kt(&constant, &row, &pose),
        );
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
}

#[test]
fn beyond_its_reach_there_is_nothing() {
    let sites = vec![(Vec3::zeros(), [1.0; 4])];
    let constant = Solute::new([21, 25, 23], |_| [1.0; 4], sites).body;
    let response = SolventResponse::new(Arc::clone(&constant), constant);
    let pose = Pose {
        position: Vec3::new(0.0, 0.0, response.reach_angstrom(0.0) + 0.1),
        rotation: Rotation::identity(),
    };
    assert_eq!(response.energy_kt(&RelativePose::from(&pose)), 0.0);
}

/// The energy that a run keeps is that of its poses, and that of all sites to within what blocks leave out.
#[test]
fn the_energy_of_a_run_does_not_drift() {
    let balls = [ball(33, 3.0, 21), ball(33, -4.0, 22)];
    let kind = || Arc::new(BodyType::new("body", &tetrahedron(7.0), &[]).unwrap());
    let model = || -> Box<dyn EnergyModel> {
        let terms_of_pair = |first: usize, second: usize| {
            let bodies = [first, second].map(|kind| Arc::clone(&balls[kind].body));
            let [first, second] = bodies;
            let term: Arc<dyn PairPotential> = Arc::new(SolventResponse::new(first, second));
            Ok::<_, ()>(Terms(vec![term]))
        };
        Box::new(WithTerms::new(
            Box::new(NoCharges),
            TermsByType::new(2, terms_of_pair).unwrap(),
        ))
    };
    let mut bodies = Vec::new();
    for number in 0..8_usize {
        let corner = [number % 2, number / 2 % 2, number / 4].map(|along| 25.0 * along as f64);
        let position = Vec3::from(corner);
        bodies.push((
            number % 2,
            Pose {
                position,
                rotation: Rotation::identity(),
            },
        ));
    }
    let boundary = Boundary::periodic(Vec3::repeat(50.0)).unwrap();
    let system = System::new(vec![kind(), kind()], &bodies, boundary).unwrap();
    let settings = Settings {
        cluster_moves_per_sweep: 2,
        ..Settings::new(Interaction::HardOnly)
    };
    let mut simulation = Simulation::with_model(system, settings, model(), 3, 0).unwrap();
    simulation
        .run_until(100, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let kept = simulation.observables().energy_kt;
    let system = simulation.system();
    let mut fresh = model();
    fresh.reset(system).unwrap();
    let again = fresh.total_kt(system);
    assert!((kept - again).abs() < 1e-3, "{kept} {again}");
    let (mut by_sites, mut pairs) = (0.0, 0);
    for first in 0..system.len() {
        for second in first + 1..system.len() {
            for cell in 0..27 {
                let shift = [cell % 3, cell / 3 % 3, cell / 9].map(|n| 50.0 * f64::from(n - 1));
                let pair = system.pair(first, second);
                let displacement = pair.displacement + Vec3::from(shift);
                let pose = pair.relative_image(&displacement);
                let kinds = pair.type_indices();
                let energy_kt = by_sites_kt(&balls[kinds.0], &balls[kinds.1], &pose);
                pairs += usize::from(energy_kt != 0.0);
                by_sites += energy_kt;
            }
        }
    }
    let allowed = 0.02 * (pairs as f64).sqrt();
    assert!(
        (kept - by_sites).abs() < allowed,
        "{kept} {by_sites} {pairs}"
    );
    assert!(by_sites.abs() > 1.0 && pairs > 20, "{by_sites} {pairs}");
}

#[test]
fn values_must_fit_the_points() {
    let grid = ResponseGrid {
        origin_angstrom: Vec3::zeros(),
        spacing_angstrom: 1.0,
        shape: [2, 2, 2],
        values: vec![[0.0; 4]; 7],
    };
    assert!(ResponseBody::new(grid, &[], Vec::new()).is_err());
}
