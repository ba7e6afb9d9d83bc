//! Free volume theory and common tangents against numbers of an independent program.

use protomer_hpmc::free_volume_theory::{BodyMeasures, Mixture};
use protomer_hpmc::tangent::{Branch, coexistences, even_samples};
use protomer_kernel::jet::Jet;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::polytope::Polytope;

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() < tolerance,
        "{found} instead of {expected}"
    );
}

#[test]
fn free_volumes_are_those_of_scaled_particle_theory() {
    let sphere = BodyMeasures::sphere(1.0);
    for (packing, q, alpha) in [
        (0.15, 0.05, 0.8263811336090942),
        (0.4, 0.6, 0.022941090674159312),
        (0.47, 1.0, 3.616623200684996e-07),
    ] {
        assert_near(sphere.free_volume(packing, q), alpha, 1e-12);
    }
    for (name, packing, q, alpha) in [
        ("cube", 0.15, 0.1, 0.7619754618356265),
        ("tetrahedron", 0.35, 0.2, 0.07999458602142301),
        ("dodecahedron", 0.45, 0.3, 0.0832769786806738),
    ] {
        let shape = by_name(name).unwrap();
        let measures = Measures::from_shape(&shape, 0.0).unwrap();
        let body = BodyMeasures {
            volume: measures.volume,
            surface: measures.surface,
            integrated_mean_curvature: measures.integrated_mean_curvature,
        };
        let radius = q * Polytope::from_shape(&shape).unwrap().circumradius();
        assert_near(body.free_volume(packing, radius), alpha, 1e-11);
    }
}

#[test]
fn fluid_and_solid_coexist_where_they_should() {
    for (q, reservoir, fluid, solid, osmotic, mu) in [
        (
            0.1,
            0.08,
            0.4782734007476244,
            0.5704232018610599,
            4.108387576160354,
            116.88954521148231,
        ),
        (
            0.2,
            0.25,
            0.26419641704933844,
            0.661864007802803,
            0.46267049510405656,
            54.06693810092492,
        ),
        (
            0.8,
            0.3,
            0.49237717848237494,
            0.542359834187731,
            5.495317459141262,
            15.462975721954901,
        ),
    ] {
        let mixture = Mixture::new(q, reservoir).unwrap();
        let found = mixture.coexistences();
        assert_eq!(found.len(), 1, "{q} {reservoir}");
        assert_near(found[0].densities[0], fluid, 1e-10);
        assert_near(found[0].densities[1], solid, 1e-10);
        assert_near(found[0].pressure, osmotic, 1e-8);
        // The rows give the slope without the part of the reservoir, which is linear in η.
        assert_near(found[0].chemical_potential, mu, 1e-8);
    }
}

#[test]
fn gas_and_liquid_coexist_above_their_critical_point() {
    let critical = Mixture::critical_point(0.5).unwrap().unwrap();
    assert_near(critical.packing_fraction, 0.22399415947668416, 1e-6);
    assert_near(critical.reservoir, 0.4487676976894916, 1e-9);
    let found = Mixture::new(0.5, 0.5).unwrap().coexistences();
    assert_eq!(found.len(), 2);
    assert_near(found[0].densities[0], 0.09358396540229721, 1e-10);
    assert_near(found[0].densities[1], 0.34751055851521023, 1e-10);
    assert_near(found[0].pressure, 0.0750062578372237, 1e-10);
    let gas_alone = Mixture::new(0.5, 0.44).unwrap().gas_and_liquid();
    assert_eq!(gas_alone, None);
}

#[test]
fn triple_points_are_found_unaided() {
    let triple = Mixture::triple_point(0.4).unwrap().unwrap();
    assert_near(triple.reservoir, 0.5149149492404153, 1e-9);
    let [gas, liquid, solid] = triple.packing_fractions;
    assert_near(gas, 0.05067999517149137, 1e-8);
    assert_near(liquid, 0.4614291161437209, 1e-8);
    assert_near(solid, 0.5662607920712336, 1e-8);
    assert_eq!(Mixture::triple_point(0.2).unwrap(), None);
    assert_eq!(Mixture::critical_point(0.02).unwrap(), None);
}

#[test]
fn tangents_are_found_and_what_has_none_says_so() {
    let one = |f: &dyn Fn(Jet) -> Jet, low: f64, high: f64| {
        let samples = even_samples(low, high, 3000);
        coexistences(&[Branch {
            name: "one",
            free_energy: f,
            samples,
        }])
    };
    let convex = |x: Jet| x * x + x * x * x * x * 0.1;
    assert!(one(&convex, -2.0, 2.0).is_empty());
    let regular = |x: Jet| x * x.ln() + (-x + 1.0) * (-x).ln_1p() + x * (-x + 1.0) * 3.0;
    let found = one(&regular, 1e-9, 1.0 - 1e-9);
    assert_eq!(found.len(), 1);
    assert_near(found[0].densities[0], 0.07072018167994482, 1e-10);
    assert_near(found[0].pressure, 0.05834134944143998, 1e-10);

    let well = |depth: f64, centre: f64, stiff: f64| {
        move |x: Jet| (x + -centre) * (x + -centre) * stiff + depth
    };
    let three = |middle: f64| {
        let wells = [
            well(0.0, 0.1, 2.0),
            well(middle, 0.4, 4.0),
            well(0.02, 0.8, 2.0),
        ];
        let branch = |n: usize| Branch {
            name: "well",
            free_energy: &wells[n],
            samples: even_samples(0.0, 1.0, 1000),
        };
        coexistences(&[branch(0), branch(1), branch(2)])
    };
    let stable = three(-0.03);
    assert_eq!(stable.len(), 2);
    assert_near(stable[0].densities[0], 0.07550020016016015, 1e-12);
    assert_near(stable[1].chemical_potential, 0.12264954516723003, 1e-12);
    let metastable = three(0.08);
    assert_eq!(metastable.len(), 1);
    assert_eq!(metastable[0].branches, [0, 2]);
    assert_near(metastable[0].pressure, 0.0029591836734693877, 1e-12);
}

#[test]
fn van_der_waals_gas_and_liquid() {
    let temperature = 0.8;
    let free_energy =
        |x: Jet| x * (x.ln() - (-x + 3.0).ln() - 1.0) * (8.0 * temperature / 3.0) - x * x * 3.0;
    let samples = even_samples(1e-6, 2.999, 6000);
    let found = coexistences(&[Branch {
        name: "fluid",
        free_energy: &free_energy,
        samples,
    }]);
    assert_eq!(found.len(), 1);
    assert_near(found[0].densities[0], 0.2396669218410905, 1e-9);
    assert_near(found[0].densities[1], 1.9327058285996976, 1e-9);
    assert_near(found[0].pressure, 0.3833616236885394, 1e-9);
}
