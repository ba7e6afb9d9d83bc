//! Potentials of pairs and fields against exact results; short runs.

use crate::common::{assert_mean, mean_length, pressed, samples};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::box_moves::Freedom;
use protomer_hpmc::crystal::{Crystal, UnitCell};
use protomer_hpmc::field::HeightTable;
use protomer_hpmc::potential::Term;
use protomer_hpmc::simulation::{Settings, Simulation};
use protomer_hpmc::start::Start;
use protomer_kernel::shape::builders::by_name;
use std::f64::consts::PI;

fn settings(terms: &[Term]) -> Settings {
    Settings {
        equilibration_sweeps: 500,
        potential: terms.to_vec(),
        ..Settings::default()
    }
}

/// Integral of a function of the distance over a shell around a ball of diameter one, by many small steps.
fn over_shell(to: f64, function: impl Fn(f64) -> f64) -> f64 {
    let cells = 200_000;
    let step = (to - 1.0) / f64::from(cells);
    let middle = |cell: i32| 1.0 + step * (f64::from(cell) + 0.5);
    (0..cells)
        .map(|cell| 4.0 * PI * middle(cell).powi(2) * function(middle(cell)) * step)
        .sum()
}

/// Two balls of diameter one in a periodic box of volume V: the partition function is V (V + F) with F the integral of Mayer's
/// function, so Z = (1 + V/(V + F))/2, and the mean energy is the integral of u exp(-u) over V + F.
fn two_balls(terms: &[Term], mayer: f64, energy: f64) {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let edge = 4.2_f64;
    let volume = edge.powi(3);
    let start = Start::fluid(2, 2.0 * ball.volume / volume);
    let (samples, _) = samples(&settings(terms), &ball, &start, 60_000);
    let factors: Vec<f64> = samples
        .iter()
        .map(|sample| sample.compressibility_factor)
        .collect();
    let energies: Vec<f64> = samples
        .iter()
        .map(|sample| sample.energy_kt_per_body.unwrap())
        .collect();
    let states = volume + mayer;
    assert_mean(
        &factors,
        0.5 * (1.0 + volume / states),
        0.02,
        "compressibility factor",
    );
    // Of a pair, over two bodies.
    assert_mean(&energies, 0.5 * energy / states, 0.08, "energy");
}

#[test]
fn two_balls_in_a_square_well_have_their_exact_statistics() {
    for depth_kt in [1.2, -0.7_f64] {
        let well = 4.0 * PI / 3.0 * (1.5_f64.powi(3) - 1.0);
        let mayer = -4.0 * PI / 3.0 + well * (depth_kt.exp() - 1.0);
        let term = Term::SquareWell {
            range: 1.5,
            depth_kt,
        };
        two_balls(&[term], mayer, -depth_kt * depth_kt.exp() * well);
    }
}

#[test]
fn two_balls_with_patches_have_their_exact_statistics() {
    // One patch covers (1 - cos δ)/2 of a ball.
    let (depth_kt, half_angle_degrees) = (2.5_f64, 60.0_f64);
    let share = 0.5 * (1.0 - half_angle_degrees.to_radians().cos());
    let well = share * share * 4.0 * PI / 3.0 * (1.5_f64.powi(3) - 1.0);
    let mayer = -4.0 * PI / 3.0 + well * (depth_kt.exp() - 1.0);
    let term = Term::Patches {
        range: 1.5,
        depth_kt,
        half_angle_degrees,
        directions: vec![vec![0.0, 0.0, 2.0]],
    };
    two_balls(&[term], mayer, -depth_kt * depth_kt.exp() * well);
}

#[test]
fn two_balls_with_a_table_have_their_exact_statistics() {
    let energy = |r: f64| {
        if r < 1.4 {
            -1.5 + 2.0 * (r - 1.0)
        } else {
            -0.7 * (2.0 - r) / 0.6
        }
    };
    let term = Term::Radial {
        distances: vec![1.0, 1.4, 2.0],
        energies_kt: vec![-1.5, -0.7, 0.0],
        curve: None,
    };
    let mayer = -4.0 * PI / 3.0 + over_shell(2.0, |r| (-energy(r)).exp() - 1.0);
    two_balls(
        &[term],
        mayer,
        over_shell(2.0, |r| energy(r) * (-energy(r)).exp()),
    );
}

#[test]
fn two_charged_balls_have_their_exact_statistics() {
    let (charge, length, cut_off) = (1.5_f64, 0.8_f64, 2.0_f64);
    let energy =
        |r: f64| charge * charge * ((-r / length).exp() / r - (-cut_off / length).exp() / cut_off);
    let term = Term::Charges {
        positions: vec![vec![0.0; 3]],
        charges_e: vec![charge],
        bjerrum_length: 1.0,
        debye_length: length,
        cut_off,
    };
    let mayer = -4.0 * PI / 3.0 + over_shell(cut_off, |r| (-energy(r)).exp() - 1.0);
    two_balls(
        &[term],
        mayer,
        over_shell(cut_off, |r| energy(r) * (-energy(r)).exp()),
    );
}

/// Hard rods on a ring that attract their neighbours: each gap g has the weight exp(-P g + depth) within the well and exp(-P g) beyond
/// (Takahashi).
#[test]
fn rods_in_wells_have_their_mean_length() {
    let (rods, pressure, width, depth_kt) = (12.0, 2.0, 0.3, 1.0_f64);
    let weight = |gap: f64| (-pressure * gap + if gap < width { depth_kt } else { 0.0 }).exp();
    let exact = mean_length(rods, weight);
    let rod = HardBody::<1>::ball(0.5).unwrap();
    let crystal = Crystal::new(&UnitCell::by_name("row").unwrap(), &rod, 12, 0.5).unwrap();
    let settings = Settings {
        potential: vec![Term::SquareWell {
            range: 1.0 + width,
            depth_kt,
        }],
        ..pressed(pressure, Freedom::Volume)
    };
    let (samples, _) = samples(&settings, &rod, &Start::Crystal(crystal), 20_000);
    let lengths: Vec<f64> = samples
        .iter()
        .map(|sample| rods / sample.packing_fraction)
        .collect();
    assert_mean(&lengths, exact, 0.01, "length");
    // At constant pressure the mean pressure of contacts and wells is the pressure.
    let pressures: Vec<f64> = samples
        .iter()
        .map(|sample| sample.compressibility_factor * sample.packing_fraction)
        .collect();
    assert_mean(&pressures, pressure, 0.03, "pressure");
}

/// An ideal gas in a valley of a table: the density is exp(-u).
#[test]
fn an_ideal_gas_in_a_table_has_its_profile() {
    let point = HardBody::<3>::ball(1e-4).unwrap();
    let start = Start::fluid(20, 20.0 * point.volume);
    let table = HeightTable {
        heights: vec![0.0, 0.5, 1.0],
        energies_kt: vec![3.0, 0.0, 6.0],
    };
    let settings = Settings {
        field: Some(table),
        ..settings(&[])
    };
    let mut simulation = Simulation::new(&settings, &point, &[], &start).unwrap();
    simulation.run(500).unwrap();
    let mut below = Vec::new();
    for _ in 0..8000 {
        simulation.run(2).unwrap();
        let places = simulation.system().positions().iter();
        below.push(places.filter(|place| place[2] < 0.5).count() as f64 / 20.0);
    }
    // The integrals of exp(-6 x) and exp(-12 x) up to one half.
    let [left, right] = [6.0_f64, 12.0].map(|slope| (1.0 - (-0.5 * slope).exp()) / slope);
    assert_mean(
        &below,
        left / (left + right),
        0.01,
        "share below the middle",
    );
}

/// The fast path of hard bodies is not touched: without terms, the same states.
#[test]
fn a_potential_of_zero_is_none() {
    let cube = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    let start = Start::fluid(64, 0.2);
    let zero = Term::Radial {
        distances: vec![0.5, 2.0],
        energies_kt: vec![0.0, 0.0],
        curve: None,
    };
    let [none, zero] = [settings(&[]), settings(&[zero])].map(|settings| {
        let mut simulation = Simulation::new(&settings, &cube, &[], &start).unwrap();
        simulation.run(200).unwrap();
        simulation.state().positions
    });
    assert_eq!(none, zero);
}

#[test]
fn terms_that_cannot_be_say_why() {
    let complaint = |term: Term| term.potential::<3>().unwrap_err().to_string();
    let radial = |distances: &[f64], energies_kt: &[f64]| Term::Radial {
        distances: distances.to_vec(),
        energies_kt: energies_kt.to_vec(),
        curve: None,
    };
    assert!(complaint(radial(&[1.0, 1.0], &[1.0, 0.0])).contains("above the one before"));
    assert!(complaint(radial(&[1.0, 2.0], &[1.0, 0.5])).contains("must be 0"));
    assert!(complaint(radial(&[1.0, 2.0], &[0.0])).contains("that of its distances"));
    let well = Term::SquareWell {
        range: 0.0,
        depth_kt: 1.0,
    };
    assert!(complaint(well).contains("the range of a potential is 0"));
    let flat = Term::Patches {
        range: 1.0,
        depth_kt: 1.0,
        half_angle_degrees: 20.0,
        directions: vec![vec![1.0, 0.0]],
    };
    assert!(complaint(flat).contains("is 2; it must be 3, in space"));
    let far = settings(&[Term::SquareWell {
        range: 9.0,
        depth_kt: 1.0,
    }]);
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let refused = Simulation::new(&far, &ball, &[], &Start::fluid(8, 0.1)).unwrap_err();
    assert!(
        refused.to_string().contains("range of the potential is 9"),
        "{refused}"
    );
}
