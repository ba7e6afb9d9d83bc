//! Tests of unit cells and crystals.

use super::*;
use protomer_kernel::Vec3;
use protomer_kernel::shape::{Shape, builders::by_name};
use std::f64::consts::PI;

fn ball<const D: usize>() -> HardBody<D> {
    let shape = match D {
        2 => Shape::flat(&[[0.0, 0.0]]),
        _ => Shape::solid(&[Vec3::zeros()]),
    };
    HardBody::new(&shape.unwrap(), 0.5).unwrap()
}

#[test]
fn every_name_is_that_of_a_unit_cell() {
    fn cells<const D: usize>() -> Vec<UnitCell<D>> {
        let names = NAMES[D - 1].iter().chain(NAMES_OF_SEVERAL[D - 1]);
        names.map(|name| UnitCell::by_name(name).unwrap()).collect()
    }
    assert_eq!(cells::<1>().len(), 2);
    assert_eq!(cells::<2>().len(), 3);
    assert_eq!(cells::<3>().len(), 11);
}

/// Neighbours that touch are of the other kind, and as many as in the minerals.
#[test]
fn cells_of_several_kinds_alternate() {
    fn neighbours<const D: usize>(name: &str, expected: usize) {
        let cell = UnitCell::<D>::by_name(name).unwrap();
        let [first, second] = cell.composition()[..] else {
            unreachable!("{name}")
        };
        assert_eq!(first, second);
        let mixture =
            Mixture::new(vec![ball(), ball()], cell.kinds_of_bodies(216 * 2 * first)).unwrap();
        let crystal = Crystal::of_mixture(&cell, &mixture, &[], 0.1).unwrap();
        let way = |one: usize, other: usize| {
            let apart = std::array::from_fn(|axis| {
                crystal.positions[other][axis] - crystal.positions[one][axis]
            });
            norm(&crystal.space.nearest_image(&apart))
        };
        let others = |one: usize| (0..mixture.len()).filter(move |other| *other != one);
        for one in 0..cell.sites.len() {
            let nearest = others(one)
                .map(|other| way(one, other))
                .fold(f64::INFINITY, f64::min);
            let touching = others(one).filter(|other| way(one, *other) < 1.001 * nearest);
            let touching: Vec<usize> = touching.collect();
            assert_eq!(touching.len(), expected, "{name}");
            assert!(
                touching
                    .iter()
                    .all(|other| mixture.kind_of()[*other] != mixture.kind_of()[one])
            );
        }
    }
    neighbours::<3>("nacl", 6);
    neighbours::<3>("cscl", 8);
    neighbours::<3>("zincblende", 4);
    neighbours::<3>("wurtzite", 4);
    neighbours::<2>("checkerboard", 4);
}

/// Balls of two sizes touch as in the minerals.
#[test]
fn balls_of_two_sizes_pack_as_densely_as_their_radii_allow() {
    let densest = |name: &str, radii: [f64; 2], bodies: usize| {
        let cell = UnitCell::<3>::by_name(name).unwrap();
        let kinds = radii.map(|radius| HardBody::ball(radius).unwrap()).to_vec();
        let mixture = Mixture::new(kinds, cell.kinds_of_bodies(bodies)).unwrap();
        let crystal = Crystal::of_mixture(&cell, &mixture, &[], 0.95).unwrap();
        match crystal.system_of(&mixture, &[]) {
            Err(Error::Dense { largest, .. }) => largest,
            other => unreachable!("{name}: {other:?}"),
        }
    };
    let small = 2.0_f64.sqrt() - 1.0;
    // Both kinds touch: edge 2 (1 + r), four of each.
    let edge = 2.0 * (1.0 + small);
    let rock_salt = 16.0 / 3.0 * PI * (1.0 + small.powi(3)) / edge.powi(3);
    assert!((densest("nacl", [1.0, small], 512) - rock_salt).abs() < 1e-7);
    let small = 3.0_f64.sqrt() - 1.0;
    let caesium = 4.0 / 3.0 * PI * (1.0 + small.powi(3)) / 8.0;
    assert!((densest("cscl", [1.0, small], 250) - caesium).abs() < 1e-7);
}

#[test]
fn crystals_of_several_kinds_refuse_bodies_of_one() {
    let cell = UnitCell::<3>::by_name("nacl").unwrap();
    let refused = Crystal::new(&cell, &ball(), 64, 0.1).unwrap_err();
    assert_eq!(refused, Error::KindsOfCrystal { kinds: 2, given: 1 });
    let gap = UnitCell {
        sites: vec![Site {
            kind: 1,
            ..cell.sites[0]
        }],
        ..cell
    };
    let words = Crystal::new(&gap, &ball(), 64, 0.1)
        .unwrap_err()
        .to_string();
    assert!(words.contains("without gaps"), "{words}");
}

/// The largest packing fraction of a crystal, as its error tells it.
fn densest<const D: usize>(name: &str, body: &HardBody<D>, bodies: usize) -> f64 {
    let cell = UnitCell::by_name(name).unwrap();
    let crystal = Crystal::new(&cell, body, bodies, 0.999).unwrap();
    match crystal.system(body, &[]) {
        Err(Error::Dense { largest, .. }) => largest,
        Err(other) => unreachable!("{name}: {other}"),
        Ok(_) => 0.999,
    }
}

#[test]
fn balls_pack_as_densely_as_the_crystals_allow() {
    for (name, bodies, expected) in [
        ("simple-cubic", 64, PI / 6.0),
        ("bcc", 128, PI * 3.0_f64.sqrt() / 8.0),
        ("fcc", 108, PI / 18.0_f64.sqrt()),
        ("hcp", 96, PI / 18.0_f64.sqrt()),
        ("diamond", 64, PI * 3.0_f64.sqrt() / 16.0),
        // Neighbours along the chains are half an edge apart.
        ("a15", 64, PI / 6.0),
        ("hexagonal-diamond", 64, PI * 3.0_f64.sqrt() / 16.0),
    ] {
        let found = densest(name, &ball::<3>(), bodies);
        assert!((found - expected).abs() < 1e-7, "{name}: {found}");
    }
    for (name, expected) in [("square", PI / 4.0), ("hexagonal", PI / 12.0_f64.sqrt())] {
        let found = densest(name, &ball::<2>(), 64);
        assert!((found - expected).abs() < 1e-7, "{name}: {found}");
    }
}

/// One unit cell, smaller than its bodies reach, says what many cells say.
#[test]
fn bodies_that_overlap_are_found_in_one_cell() {
    let fcc = PI / 18.0_f64.sqrt();
    let rhombohedral = UnitCell {
        space: PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3]).unwrap(),
        ..UnitCell::by_name("simple-cubic").unwrap()
    };
    for (cell, at, densest) in [
        (UnitCell::by_name("simple-cubic").unwrap(), [0, 0], PI / 6.0),
        (UnitCell::by_name("fcc").unwrap(), [0, 1], fcc),
        (rhombohedral, [0, 0], fcc),
    ] {
        let overlap = |packing: f64| {
            let crystal = Crystal::new(&cell, &ball(), cell.sites.len(), packing);
            crystal.unwrap().first_overlap(&ball())
        };
        assert_eq!(overlap(densest - 1e-6), None);
        assert_eq!(overlap(densest + 1e-6), Some(at));
    }
    let solid = by_name("truncated-tetrahedron:0.6666666666666666").unwrap();
    let body = HardBody::<3>::new(&solid, 0.0).unwrap();
    let cell = UnitCell::by_name("diamond").unwrap();
    let overlap = |packing: f64| {
        let crystal = Crystal::new(&cell, &body, 8, packing).unwrap();
        crystal.first_overlap(&body)
    };
    assert_eq!(overlap(23.0 / 24.0 - 1e-6), None);
    assert_eq!(overlap(23.0 / 24.0 + 1e-6), Some([0, 1]));
}

/// The box of a tilted cell is as dense as that of a cubic one, and an oblique one of disks as a hexagonal
/// one with right angles.
#[test]
fn cells_with_angles_make_the_same_crystals() {
    let rhombohedral = UnitCell {
        space: PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3]).unwrap(),
        ..UnitCell::by_name("simple-cubic").unwrap()
    };
    let oblique = UnitCell {
        space: PeriodicBox::with_angles(&[1.0; 2], &[120.0]).unwrap(),
        ..UnitCell::by_name("square").unwrap()
    };
    let crystal = Crystal::new(&rhombohedral, &ball::<3>(), 60, 0.999).unwrap();
    let Err(Error::Dense { largest, .. }) = crystal.system(&ball(), &[]) else {
        unreachable!()
    };
    assert!((largest - PI / 18.0_f64.sqrt()).abs() < 1e-7, "{largest}");
    let crystal = Crystal::new(&oblique, &ball::<2>(), 60, 0.999).unwrap();
    let Err(Error::Dense { largest, .. }) = crystal.system(&ball(), &[]) else {
        unreachable!()
    };
    assert!((largest - PI / 12.0_f64.sqrt()).abs() < 1e-7, "{largest}");
}

/// The two diamonds of Archimedean truncated tetrahedra close at 23/24; hexagons fill the
/// plane.
#[test]
fn faces_look_at_their_neighbours() {
    let name = "truncated-tetrahedron:0.6666666666666666";
    let body = HardBody::<3>::new(&by_name(name).unwrap(), 0.0).unwrap();
    for name in ["diamond", "hexagonal-diamond"] {
        let found = densest(name, &body, 216);
        assert!((found - 23.0 / 24.0).abs() < 1e-6, "{name}: {found}");
    }
    let hexagon = HardBody::<2>::new(&by_name("polygon:6").unwrap(), 0.0).unwrap();
    assert_eq!(densest("hexagonal", &hexagon, 64), 0.999);
}

#[test]
fn translations_are_counted_with_orientations() {
    let body = HardBody::<3>::new(&by_name("tetrahedron").unwrap(), 0.0).unwrap();
    let symmetry = Symmetry::find(&body).unwrap();
    for (name, bodies, sites) in [
        ("fcc", 108, 1.0),
        ("hcp", 96, 2.0),
        ("diamond", 64, 2.0),
        ("hexagonal-diamond", 64, 4.0),
    ] {
        let cell = UnitCell::by_name(name).unwrap();
        let crystal = Crystal::new(&cell, &body, bodies, 0.1).unwrap();
        let found = crystal.primitive_volume(&symmetry) * 0.1 / body.volume;
        assert!((found - sites).abs() < 1e-9, "{name}: {found}");
    }
    // Without its orientations the hexagonal diamond still has four sites, a turned fcc has four.
    let mut cell = UnitCell::<3>::by_name("fcc").unwrap();
    for (number, site) in cell.sites.iter_mut().enumerate() {
        site.rotation = Rotation::from_scaled_axis(0.2 * number as f64 * Vec3::x());
    }
    let crystal = Crystal::new(&cell, &body, 108, 0.1).unwrap();
    let found = crystal.primitive_volume(&symmetry) * 0.1 / body.volume;
    assert!((found - 4.0).abs() < 1e-9, "{found}");
}

#[test]
fn boxes_are_as_near_to_cubes_as_cells_allow() {
    assert_eq!(repeats(&[1.0; 3], 27), [3, 3, 3]);
    assert_eq!(repeats(&[1.0; 3], 24).iter().max(), Some(&4));
    assert_eq!(repeats(&[3.0_f64.sqrt(), 1.0], 40), [5, 8]);
    assert_eq!(repeats(&[1.0], 7), [7]);
    let cell = UnitCell::<3>::by_name("fcc").unwrap();
    let refused = Crystal::new(&cell, &ball(), 100, 0.5);
    assert!(refused.is_ok());
    let refused = Crystal::new(&cell, &ball(), 110, 0.5).unwrap_err();
    assert!(refused.to_string().contains("such as 108"), "{refused}");
}

fn dipyramid() -> HardBody<3> {
    let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.8]].map(Vec3::from);
    let both: Vec<Vec3> = corners.iter().flat_map(|x| [*x, -x]).collect();
    HardBody::new(&Shape::solid(&both).unwrap(), 0.0).unwrap()
}

/// Whatever cell and number one begins with, the number that an error names makes a crystal, at once.
#[test]
fn numbers_that_errors_name_make_crystals() {
    let body = dipyramid();
    let cell = |edges: [f64; 3], angles: &[f64]| UnitCell {
        space: PeriodicBox::with_angles(&edges, angles).unwrap(),
        ..UnitCell::by_name("bcc").unwrap()
    };
    for cell in [
        cell([1.0, 1.0, 1.8], &[90.0; 3]),
        cell([1.0, 1.0, 7.0], &[90.0; 3]),
        cell([1.0, 2.0, 3.0], &[70.0, 80.0, 110.0]),
    ] {
        for depletant in [None, Some(0.2)] {
            let depletants: Vec<Depletant> = depletant
                .map(|radius| Depletant {
                    radius,
                    fugacity: 1.0,
                })
                .into_iter()
                .collect();
            for bodies in [1, 2, 3, 4, 10, 167] {
                let system = |bodies: usize| {
                    let crystal = Crystal::among(&cell, &body, &depletants, bodies, 0.02)?;
                    crystal.system(&body, &depletants)
                };
                let enough = match system(bodies) {
                    Ok(_) => continue,
                    Err(Error::BoxTooSmall { bodies, .. }) => bodies,
                    Err(Error::PartialCell { nearest, .. }) => nearest,
                    Err(other) => unreachable!("{bodies}: {other}"),
                };
                let made = system(enough);
                assert!(made.is_ok(), "{bodies}: {enough}: {:?}", made.err());
            }
        }
    }
}

#[test]
fn sites_that_coincide_are_named() {
    let ball = ball::<3>();
    for places in [
        vec![[0.0; 3], [1.0, 0.0, 0.0]],
        vec![[0.5; 3], [0.0; 3], [-1.5, 2.5, 0.5]],
        vec![[0.0; 3], [1e-9, 0.0, 1.0 - 1e-9]],
    ] {
        let sites = places.iter().map(|place| Site {
            place: *place,
            rotation: Rotation::identity(),
            kind: 0,
        });
        let cell = UnitCell {
            space: PeriodicBox::rectangular([1.0; 3]).unwrap(),
            sites: sites.collect(),
        };
        let error = Crystal::new(&cell, &ball, 60, 0.1).unwrap_err();
        let bodies = [1, places.len()];
        assert_eq!(error, Error::SameSite { bodies });
    }
}

/// A message says how densely bodies fit, and they do.
#[test]
fn bodies_fit_at_the_packing_fraction_that_an_error_names() {
    let cell = UnitCell::<3>::by_name("fcc").unwrap();
    let crystal = |packing| Crystal::new(&cell, &ball::<3>(), 108, packing).unwrap();
    let error = crystal(0.9).system(&ball(), &[]).unwrap_err().to_string();
    let named = error.rsplit(' ').next().unwrap();
    // It is 0.74048, which would be rounded to 0.7405.
    assert_eq!(named, "0.7404");
    assert!(crystal(named.parse().unwrap()).system(&ball(), &[]).is_ok());
}
