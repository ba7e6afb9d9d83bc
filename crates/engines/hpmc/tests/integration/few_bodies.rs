//! A few bodies in a box that fluctuates, against draws that are independent of each other; short runs.
//!
//! A draw is an ideal gas: a volume with the density V^N exp(-βPV), a shape of the box with that of the measure of
//! `box_moves`, and places at random. The draws in which no bodies overlap are hard bodies at constant pressure. So
//! a wrong Jacobian, or a wrong choice of what of the box changes, shows in the volumes and in the shapes.

use crate::common::{logarithm, pressed};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::box_moves::Freedom;
use protomer_hpmc::simulation::Simulation;
use protomer_hpmc::start::Start;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::CounterRng;
use protomer_kernel::statistics::{Summary, summarize};

/// Radius of the bodies.
const RADIUS: f64 = 0.5;
/// Measurements of a run.
const SAMPLES: usize = 10_000;
/// Independent draws that the run is compared with.
const DRAWS: u64 = 10_000;
/// The largest error of what is compared.
const PRECISION: f64 = 0.015;

/// What is compared, each of the order of one: the density, the first length and its square, and how far the second
/// edge overhangs the first.
fn measured<const D: usize>(space: &PeriodicBox<D>, bodies: usize) -> [f64; 4] {
    let first = logarithm(space, 0);
    let overhang = space.edge(1)[0] / space.lengths()[0];
    let density = bodies as f64 / space.volume();
    [
        density,
        first,
        first * first,
        (std::f64::consts::TAU * overhang).cos(),
    ]
}

/// A shape at a volume of one: lengths within a factor of two, weighed by (L_i/L_j) for each tilt factor n_ij, because
/// the lattice of images repeats after L_i/L_j in it.
fn random_shape<const D: usize>(freedom: Freedom, rng: &mut CounterRng) -> ([f64; D], Vec<f64>) {
    let bound = 2.0_f64.ln();
    loop {
        let mut logarithms = [0.0; D];
        if freedom == Freedom::Volume {
            return ([1.0; D], Vec::new());
        }
        for axis in 1..D {
            logarithms[axis] = rng.uniform_in(-bound, bound);
            logarithms[0] -= logarithms[axis];
        }
        if logarithms[0].abs() > bound {
            continue;
        }
        let lengths = logarithms.map(f64::exp);
        if freedom == Freedom::Lengths {
            return (lengths, Vec::new());
        }
        let (mut weight, mut largest, mut tilts) = (1.0, 1.0, Vec::new());
        for row in 0..D {
            for column in row + 1..D {
                let period = lengths[row] / lengths[column];
                weight *= period;
                largest *= 4.0;
                tilts.push(period * rng.uniform_in(-0.5, 0.5));
            }
        }
        if rng.uniform() * largest < weight {
            return (lengths, tilts);
        }
    }
}

/// A volume with the density V^N exp(-βPV): a sum of N + 1 waiting times.
fn random_volume(bodies: usize, pressure: f64, rng: &mut CounterRng) -> f64 {
    let waits = (0..=bodies).map(|_| -(1.0 - rng.uniform()).ln());
    waits.sum::<f64>() / pressure
}

/// Whether bodies at random places of a box overlap at any image.
fn overlap_at_random<const D: usize>(
    space: &PeriodicBox<D>,
    bodies: usize,
    rng: &mut CounterRng,
) -> bool {
    let places: Vec<[f64; D]> = (0..bodies)
        .map(|_| space.point(&std::array::from_fn(|_| rng.uniform())))
        .collect();
    let pairs = (0..bodies).flat_map(|second| (0..second).map(move |first| (first, second)));
    let mut apart = pairs.map(|(first, second)| {
        std::array::from_fn(|axis| places[second][axis] - places[first][axis])
    });
    apart.any(|apart| is_overlap_at_any_image(space, &apart))
}

/// Whether two bodies so far apart overlap, one of them at any image by up to so many edges.
fn is_overlap_at_any_image<const D: usize>(space: &PeriodicBox<D>, apart: &[f64; D]) -> bool {
    const MOST: i32 = 3;
    (0..(2 * MOST + 1).pow(D as u32)).any(|image| {
        let (mut rest, mut place) = (image, *apart);
        for edge in 0..D {
            let times = rest % (2 * MOST + 1) - MOST;
            space.add_edges(&mut place, edge, f64::from(times));
            rest /= 2 * MOST + 1;
        }
        place.iter().map(|x| x * x).sum::<f64>() < (2.0 * RADIUS).powi(2)
    })
}

/// A few balls at a constant pressure, kT per volume.
struct Few {
    freedom: Freedom,
    bodies: usize,
    pressure: f64,
}

impl Few {
    /// The means over independent draws without overlaps.
    fn drawn<const D: usize>(&self, draws: u64) -> [Summary; 4] {
        let mut series = [const { Vec::new() }; 4];
        for number in 0..draws {
            let mut rng = CounterRng::new(7, D as u32, number);
            let (lengths, tilts) = random_shape::<D>(self.freedom, &mut rng);
            let volume = random_volume(self.bodies, self.pressure, &mut rng);
            let shape = PeriodicBox::new(lengths, &tilts).unwrap();
            let space = shape.scaled(volume.powf(1.0 / D as f64));
            if !overlap_at_random(&space, self.bodies, &mut rng) {
                for (series, value) in series.iter_mut().zip(measured(&space, self.bodies)) {
                    series.push(value);
                }
            }
        }
        series.map(|series| summarize(&series))
    }

    /// The means over a run, and that of what the bodies bear.
    fn sampled<const D: usize>(&self, samples: usize) -> ([Summary; 4], Summary) {
        let ball = HardBody::<D>::ball(RADIUS).unwrap();
        let settings = pressed(self.pressure, self.freedom);
        let start = Start::fluid(self.bodies, 0.1);
        let mut run = Simulation::new(&settings, &ball, &[], &start).unwrap();
        run.run(settings.equilibration_sweeps).unwrap();
        let (mut series, mut borne) = ([const { Vec::new() }; 4], Vec::new());
        for _ in 0..samples {
            run.run(4).unwrap();
            let sample = run.sample();
            borne.push(sample.compressibility_factor * sample.packing_fraction / ball.volume);
            let space = run.system().space();
            for (series, value) in series.iter_mut().zip(measured(space, self.bodies)) {
                series.push(value);
            }
        }
        (series.map(|series| summarize(&series)), summarize(&borne))
    }

    fn assert_exact<const D: usize>(&self) {
        let (found, borne) = self.sampled::<D>(SAMPLES);
        let exact = self.drawn::<D>(DRAWS);
        let compared = match self.freedom {
            Freedom::Volume => 1,
            Freedom::Lengths => 3,
            Freedom::Shape => 4,
        };
        for number in 0..compared {
            let (found, exact) = (&found[number], &exact[number]);
            let error = found.standard_error.hypot(exact.standard_error);
            let what = format!(
                "{:?} in {D} dimensions, {number}: {found:?} {exact:?}",
                self.freedom
            );
            assert!(error < PRECISION, "{what}");
            assert!((found.mean - exact.mean).abs() < 4.0 * error, "{what}");
        }
        // What the bodies bear is what is imposed, however few they are; to 1 %, as images of two bodies that touch
        // at once put kinks into the density of pairs.
        let off = (borne.mean / self.pressure - 1.0).abs();
        let error = borne.standard_error / self.pressure;
        assert!(
            error < 0.03 && off < 4.0 * error,
            "{:?}, {D}: {borne:?}",
            self.freedom
        );
    }
}

fn assert_exact_at_each_freedom<const D: usize>() {
    let two = |freedom, pressure| Few {
        freedom,
        bodies: 2,
        pressure,
    };
    two(Freedom::Volume, 1.0).assert_exact::<D>();
    // Thin enough that the box never becomes too small for a body and its own images.
    let four = |freedom| Few {
        freedom,
        bodies: 4,
        pressure: 0.15,
    };
    four(Freedom::Lengths).assert_exact::<D>();
    four(Freedom::Shape).assert_exact::<D>();
}

#[test]
fn a_few_disks_have_the_boxes_of_independent_draws() {
    assert_exact_at_each_freedom::<2>();
}

#[test]
fn a_few_balls_have_the_boxes_of_independent_draws() {
    assert_exact_at_each_freedom::<3>();
}
