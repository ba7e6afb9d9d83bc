//! Input that makes no sense is refused with a message a user can act on.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, KernelError, Pose, Rotation, Vec3};
use protomer_mc::{BodyType, Interaction, McError, Settings, Simulation, System};
use std::sync::Arc;

fn on_axis(x: f64) -> Pose {
    Pose {
        position: Vec3::new(x, 0.0, 0.0),
        rotation: Rotation::identity(),
    }
}

fn body(charges: &[(Vec3, f64)]) -> Arc<BodyType> {
    Arc::new(BodyType::new("body", &icosphere(5.0, 1), charges).unwrap())
}

#[test]
fn an_overlapping_start_lists_its_pairs() {
    let system = System::new(
        vec![body(&[])],
        &[(0, on_axis(0.0)), (0, on_axis(30.0)), (0, on_axis(4.0))],
        Boundary::Open,
    )
    .unwrap();
    let error = Simulation::new(system, Settings::new(Interaction::HardOnly), 1, 0)
        .err()
        .unwrap();
    assert_eq!(
        error,
        McError::OverlappingStart {
            pairs: vec![(0, 2)]
        }
    );
    assert!(error.to_string().contains("(0, 2)"));
}

#[test]
fn a_body_within_another_overlaps() {
    let kinds = vec![
        body(&[]),
        Arc::new(BodyType::new("small", &icosphere(1.0, 1), &[]).unwrap()),
    ];
    let system = System::new(
        kinds,
        &[(0, on_axis(0.0)), (1, on_axis(0.5))],
        Boundary::Open,
    )
    .unwrap();
    assert!(Simulation::new(system, Settings::new(Interaction::HardOnly), 1, 0).is_err());
}

#[test]
fn a_box_too_small_for_the_interactions_names_the_box_needed() {
    let boundary = Boundary::periodic(Vec3::repeat(100.0)).unwrap();
    let charged = body(&[(Vec3::new(1.0, 0.0, 0.0), 1.0)]);
    let system = System::new(
        vec![charged],
        &[(0, on_axis(-20.0)), (0, on_axis(20.0))],
        boundary,
    )
    .unwrap();
    let yukawa = Interaction::YukawaDirect(Yukawa::new(7.0, 0.1, 60.0).unwrap());
    let error = Simulation::new(system, Settings::new(yukawa), 1, 0)
        .err()
        .unwrap();
    assert!(matches!(
        error,
        McError::Kernel(KernelError::BoxTooSmall { .. })
    ));
    assert!(error.to_string().contains("124.00"), "{error}");
}

/// A kind of body that is declared and never placed has no part in the system.
#[test]
fn a_kind_without_a_body_needs_no_room() {
    let boundary = Boundary::periodic(Vec3::repeat(100.0)).unwrap();
    let placed = body(&[(Vec3::new(1.0, 0.0, 0.0), 1.0)]);
    let far = [(Vec3::new(400.0, 0.0, 0.0), 1.0)];
    let unplaced = Arc::new(BodyType::new("giant", &icosphere(300.0, 1), &far).unwrap());
    let yukawa = Interaction::YukawaDirect(Yukawa::new(7.0, 0.1, 40.0).unwrap());
    let start = |bodies: &[(usize, Pose)]| {
        let types = vec![placed.clone(), unplaced.clone()];
        let system = System::new(types, bodies, boundary).unwrap();
        Simulation::new(system, Settings::new(yukawa), 1, 0)
    };
    assert!(start(&[(0, on_axis(-20.0)), (0, on_axis(20.0))]).is_ok());
    assert!(start(&[(0, on_axis(-20.0)), (1, on_axis(20.0))]).is_err());
}

#[test]
fn the_energy_of_nothing_is_zero_without_a_sign() {
    use protomer_mc::energy::{DirectSum, EnergyModel};
    let system = System::new(vec![body(&[])], &[(0, on_axis(0.0))], Boundary::Open).unwrap();
    let mut model = DirectSum::new(Yukawa::new(7.0, 0.1, 40.0).unwrap());
    model.reset(&system).unwrap();
    assert_eq!(format!("{:.6}", model.total_kt(&system)), "0.000000");
}

#[test]
fn charges_on_top_of_each_other_are_named() {
    let reaching_out = body(&[
        (Vec3::new(6.0, 0.0, 0.0), 1.0),
        (Vec3::new(-6.0, 0.0, 0.0), 1.0),
    ]);
    let system = System::new(
        vec![reaching_out],
        &[(0, on_axis(0.0)), (0, on_axis(12.0))],
        Boundary::Open,
    )
    .unwrap();
    let yukawa = Interaction::YukawaDirect(Yukawa::new(7.0, 0.1, 60.0).unwrap());
    let error = Simulation::new(system, Settings::new(yukawa), 1, 0)
        .err()
        .unwrap();
    assert!(
        matches!(
            error,
            McError::NonFiniteEnergy {
                first: 0,
                second: 1,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn systems_and_settings_that_contradict_themselves_are_refused() {
    assert!(System::new(vec![body(&[])], &[], Boundary::Open).is_err());
    assert!(System::new(vec![body(&[])], &[(1, on_axis(0.0))], Boundary::Open).is_err());
    assert!(System::new(vec![body(&[])], &[(0, on_axis(f64::NAN))], Boundary::Open).is_err());
    let wall = Boundary::SphereWall {
        radius_angstrom: 10.0,
    };
    assert!(System::new(vec![body(&[])], &[(0, on_axis(11.0))], wall).is_err());
    let good = Settings::new(Interaction::HardOnly);
    for settings in [
        Settings {
            translation_step_angstrom: 0.0,
            ..good
        },
        Settings {
            rotation_step_rad: f64::NAN,
            ..good
        },
        Settings {
            target_acceptance: 1.5,
            ..good
        },
        Settings {
            rotation_fraction: -0.1,
            ..good
        },
        Settings {
            contact_gap_angstrom: 0.0,
            ..good
        },
        Settings {
            cluster_axis_reach_angstrom: Some(-1.0),
            ..good
        },
    ] {
        let system = System::new(vec![body(&[])], &[(0, on_axis(0.0))], Boundary::Open).unwrap();
        assert!(matches!(
            Simulation::new(system, settings, 1, 0),
            Err(McError::BadSetting { .. })
        ));
    }
}
