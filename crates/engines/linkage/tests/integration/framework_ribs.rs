//! Ribs that flex, and honeycombs of crosses, stars and wheels, against closed formulas.

use nalgebra::Matrix2;
use protomer_linkage::framework::analytic::Honeycomb;
use protomer_linkage::framework::build::{self, MissingRib};
use protomer_linkage::framework::{Elasticity, Flexure, Framework, Moduli};
use std::f64::consts::{FRAC_PI_2, PI};

fn moduli(network: &Framework) -> Moduli {
    Moduli::new(&Elasticity::from_framework(network).unwrap(), 1.0)
}

fn bending(stiffness: f64, segments: usize) -> Flexure {
    Flexure {
        bending_stiffness_kcal_angstrom_mol: stiffness,
        segments,
    }
}

fn honeycomb(theta_deg: f64, kh: f64, ks: f64) -> Honeycomb {
    Honeycomb {
        h_angstrom: 1.7,
        l_angstrom: 1.2,
        theta_rad: theta_deg.to_radians(),
        hinge_stiffness_kcal_mol_rad2: kh,
        rod_stiffness_kcal_mol_angstrom2: ks,
        thickness_angstrom: 1.3,
    }
}

fn near(value: f64, expected: f64, tolerance: f64, what: &str) {
    let error = (value - expected).abs() / expected.abs().max(1e-3);
    assert!(error < tolerance, "{what}: {value}, not {expected}");
}

#[test]
fn a_flexing_honeycomb_is_one_that_hinges_with_six_ei_over_l() {
    let stiffness = 7.0;
    for theta in [50.0, 75.0, 110.0, 140.0] {
        let straight = build::honeycomb(&honeycomb(theta, 0.0, 300.0)).unwrap();
        for segments in [1, 2, 5, 12] {
            let found = moduli(&straight.flexing(0, &bending(stiffness, segments)).unwrap());
            // Trapezia of the squared moment of a rib whose ends stay parallel.
            let parts = 1.0 + 2.0 / (segments * segments) as f64;
            let made_of = honeycomb(theta, 6.0 * stiffness / 1.2 / parts, 300.0);
            let expected = made_of.both(1.0);
            let what = format!("{theta} degrees, {segments} segments");
            near(found.youngs_gpa[0].unwrap(), expected.e_y_gpa, 1e-8, &what);
            near(found.youngs_gpa[1].unwrap(), expected.e_z_gpa, 1e-8, &what);
            near(found.poissons[0][1].unwrap(), expected.nu_yz, 1e-8, &what);
            near(found.poissons[1][0].unwrap(), expected.nu_zy, 1e-8, &what);
        }
    }
}

#[test]
fn the_shear_modulus_of_a_flexing_honeycomb_converges_to_that_of_beams() {
    // Gibson and Ashby, with inclined ribs at an angle psi to y: the ribs along z bend as well.
    for theta in [60.0_f64, 120.0] {
        let made_of = honeycomb(theta, 0.0, 1e9);
        let (h, l) = (made_of.h_angstrom, made_of.l_angstrom);
        let psi = (theta - 90.0).to_radians();
        let exact = 12.0 * 5.0 / l.powi(3) * (h / l + psi.sin())
            / ((h / l).powi(2) * (1.0 + 2.0 * h / l) * psi.cos())
            / made_of.thickness_angstrom;
        let straight = build::honeycomb(&made_of).unwrap();
        let shear = |segments| {
            let flexing = straight.flexing(0, &bending(5.0, segments)).unwrap();
            moduli(&flexing).shear_gpa[0].unwrap() / exact - 1.0
        };
        let [coarse, fine] = [shear(8), shear(16)];
        assert!(coarse.abs() < 0.05, "{theta}: {coarse}");
        // The error falls with the square of the number of segments.
        near(coarse / fine, 4.0, 0.05, "ratio of errors");
        assert!(((4.0 * fine - coarse) / 3.0).abs() < 1e-3);
    }
}

#[test]
fn chiral_honeycombs_have_their_closed_moduli() {
    let (radius, ligament) = (0.4_f64, 1.7_f64);
    let square = ligament * ligament + 4.0 * radius * radius;
    // Rods a million times stiffer than hinges: at 1e9 the inverse of C has lost its digits.
    let stiff = 1e7;
    for (spokes, factor, ratio) in [(6, 3f64.sqrt(), -1.0), (4, 0.5, 0.0)] {
        let hinged = moduli(&build::chiral(spokes, radius, ligament, stiff, 3.0).unwrap());
        let expected = factor * 3.0 * square / (radius * ligament).powi(2);
        near(hinged.youngs_gpa[0].unwrap(), expected, 1e-4, "hinged E");
        near(
            hinged.youngs_gpa[1].unwrap(),
            expected,
            1e-4,
            "hinged E along z",
        );
        assert!((hinged.poissons[0][1].unwrap() - ratio).abs() < 1e-4);
        // Ligaments that flex: both ends turn alike, 6 EI/L at each.
        let wheels = spokes * (spokes - 1) / 2;
        let straight = build::chiral(spokes, radius, ligament, stiff, 0.0).unwrap();
        for segments in [3, 10] {
            let flexing = straight.flexing(wheels, &bending(2.0, segments)).unwrap();
            let parts = 1.0 + 2.0 / (segments * segments) as f64;
            let expected = factor * 6.0 * 2.0 / ligament * square / (radius * ligament).powi(2);
            let found = moduli(&flexing);
            near(
                found.youngs_gpa[0].unwrap(),
                expected / parts,
                1e-4,
                "flexing E",
            );
            assert!((found.poissons[0][1].unwrap() - ratio).abs() < 1e-4);
        }
    }
}

#[test]
fn a_missing_rib_foam_without_shear_grows_alike_in_both_directions() {
    let made_of = MissingRib {
        arm_angstrom: 1.1,
        rib_angstrom: 2.0,
        angle_rad: 0.6,
        ks: 1e7,
        kh: 3.0,
        cross_kh: 1e7,
    };
    let foam = build::missing_rib(&made_of).unwrap();
    let elasticity = Elasticity::from_framework(&foam).unwrap();
    let c = &elasticity.stiffness;
    near(c[(1, 0)] / c[(0, 0)], -1.0, 1e-4, "ν without shear");
    // Both edges grow by the same part: 2 (C_yy + C_yz) is the curvature of the energy per volume.
    let rigid = 3.0 / (1.1 * 0.6_f64.sin()).powi(2);
    near(
        c[(0, 0)] + c[(0, 1)],
        0.5 * rigid,
        1e-3,
        "biaxial stiffness",
    );
    let free = Moduli::new(&elasticity, 1.0);
    near(free.youngs_gpa[0].unwrap(), 0.5 * rigid, 1e-4, "E");
    assert!(free.poissons[0][1].unwrap().abs() < 1e-4);
}

#[test]
fn stars_with_four_points_follow_two_angles() {
    // With rigid ribs the points are at p = a (cos A + sin B) and q = a (cos B + sin A) of the
    // centre, A and B the angles of the sides to the axes; two hinges at a point between side and
    // rib, one between two sides, one at each notch, whose angle is 90 degrees + A + B.
    let (a, rib, kh) = (1.3, 0.7, 2.0);
    for angle in [0.3_f64, 0.7, 1.2] {
        let half: f64 = 0.5 * angle;
        let (sine, cosine) = half.sin_cos();
        let edge = 2.0 * a * (cosine + sine) + rib;
        let to_strain = Matrix2::new(-sine, cosine, cosine, -sine) * (2.0 * a / edge);
        let energy = Matrix2::new(8.0, 2.0, 2.0, 8.0) * (2.0 * kh);
        let back = to_strain.try_inverse().unwrap();
        let stiffness = back.transpose() * energy * back / (edge * edge);
        let compliance = stiffness.try_inverse().unwrap();
        let found = moduli(&build::stars(4, a, rib, angle, 1e7, kh).unwrap());
        near(
            found.youngs_gpa[0].unwrap(),
            1.0 / compliance[(0, 0)],
            1e-5,
            "E",
        );
        let ratio = -compliance[(1, 0)] / compliance[(0, 0)];
        near(found.poissons[0][1].unwrap(), ratio, 1e-5, "ν");
    }
}

#[test]
fn stars_with_six_points_are_isotropic_and_grow_by_one_angle() {
    let (a, rib, kh, angle) = (1.3, 0.7, 2.0, 0.8_f64);
    let network = build::stars(6, a, rib, angle, 1e7, kh).unwrap();
    let elasticity = Elasticity::from_framework(&network).unwrap();
    let c = &elasticity.stiffness;
    near(c[(1, 1)], c[(0, 0)], 1e-6, "C_zz");
    near(c[(2, 2)], 0.5 * (c[(0, 0)] - c[(0, 1)]), 1e-6, "C of shear");
    // The point is at R = 2 a sin(30° + A), A half of its angle, and a notch turns by twice as much.
    let half = 0.5 * angle;
    let spacing = 4.0 * a * (PI / 6.0 + half).sin() + rib;
    let growth = 4.0 * a * (PI / 6.0 + half).cos() / spacing;
    // Points: hinges of 2 A and, to the rib, twice A; notches: 2 A.
    let energy = 0.5 * kh * 6.0 * (4.0 + 2.0 + 4.0) / growth.powi(2);
    let area = 0.75_f64.sqrt() * spacing * spacing;
    near(
        c[(0, 0)] + c[(0, 1)],
        energy / area,
        1e-5,
        "biaxial stiffness",
    );
}

#[test]
fn alpha_cristobalite_is_tetragonal_and_auxetic_by_its_tetrahedra() {
    let network = build::alpha_cristobalite(1.0, 1e4, 1.0).unwrap();
    let elasticity = Elasticity::from_framework(&network).unwrap();
    let c = &elasticity.stiffness;
    let largest = c.amax();
    let same = |a: (usize, usize), b: (usize, usize)| {
        assert!((c[a] - c[b]).abs() < 1e-6 * largest, "{a:?} {b:?}");
    };
    same((0, 0), (1, 1));
    same((0, 2), (1, 2));
    same((3, 3), (4, 4));
    for (row, column) in [(0, 3), (0, 4), (0, 5), (2, 5), (3, 4), (3, 5)] {
        assert!(c[(row, column)].abs() < 1e-6 * largest);
    }
    // Each Si has four O, all bonds are those of silica, and every O two Si.
    let mut bonds = 0;
    for rod in &network.rods {
        let from = &network.nodes_angstrom[rod.from];
        let mut to = network.nodes_angstrom[rod.to.node].clone();
        for (axis, cells) in rod.to.image.iter().enumerate() {
            to[axis] += f64::from(*cells) * network.cell_angstrom[axis][axis];
        }
        let length = from
            .iter()
            .zip(&to)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt();
        if rod.from < 4 {
            bonds += 1;
            assert!((1.59..1.62).contains(&length), "{length}");
        } else {
            assert!((2.59..2.65).contains(&length), "{length}");
        }
    }
    assert_eq!(bonds, 16);
    // Rigid tetrahedra that turn: ν of a pull along z is negative, as measured (Yeganeh-Haeri, Weidner
    // and Parise, Science 257, 650 (1992)).
    let moduli = Moduli::new(&elasticity, 1.0);
    assert!(moduli.poissons[2][0].unwrap() < 0.0);
    assert!(elasticity.mechanisms.is_empty());
    // Hinges alone keep it from closing: rigid tetrahedra have two strains that cost nothing.
    let free =
        Elasticity::from_framework(&build::alpha_cristobalite(1.0, 1e4, 0.0).unwrap()).unwrap();
    assert_eq!(free.mechanisms.len(), 2);
}

#[test]
fn what_cannot_flex_is_refused() {
    let hinged = build::honeycomb(&honeycomb(70.0, 1.0, 10.0)).unwrap();
    let reason = |network: &Framework, flexure: &Flexure| {
        network.flexing(0, flexure).unwrap_err().to_string()
    };
    assert!(reason(&hinged, &bending(1.0, 4)).contains("--kh 0"));
    let net = build::face_centred_cubic(1.0, 1.0).unwrap();
    assert!(reason(&net, &bending(1.0, 4)).contains("three dimensions"));
    let straight = build::honeycomb(&honeycomb(70.0, 0.0, 10.0)).unwrap();
    assert!(reason(&straight, &bending(-1.0, 4)).contains("flexure"));
    assert!(reason(&straight, &bending(1.0, 0)).contains("segments"));
    for (points, angle) in [(5, 0.3), (4, FRAC_PI_2), (6, 2.2), (4, 0.0)] {
        assert!(build::stars(points, 1.0, 1.0, angle, 1.0, 1.0).is_err());
    }
    let short = MissingRib {
        arm_angstrom: 1.0,
        rib_angstrom: 0.5,
        angle_rad: 1.0,
        ks: 1.0,
        kh: 1.0,
        cross_kh: 1.0,
    };
    let error = build::missing_rib(&short).unwrap_err().to_string();
    assert!(error.contains("do not reach"), "{error}");
    assert!(build::chiral(3, 1.0, 1.0, 1.0, 1.0).is_err());
}
