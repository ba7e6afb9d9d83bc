//! The path that a step is taken to follow.
//!
//! Over a step of length H the squares move as s(t) = s + v t + r (t/H)², with r such that the path
//! ends where the drift ends. Bounds of the accelerations on it bound the curvature of every gap,
//! which is what [`march`](super::march) needs to find the first root of each.

use super::march::{End, Probe, first_root};
use super::watch::{Watch, bodies, stop};
use crate::lattice::State;
use crate::lattice::cell::Cell;
use crate::lattice::contact::candidates::{Body, Pair};
use crate::lattice::contact::separation::{Moving, Rectangle, along_axes, time_to_next_corner};
use crate::lattice::network::Network;
use crate::plane::{minus, norm};

/// Newton steps on the path of third order.
const REFINEMENTS: usize = 3;
/// The path of third order is trusted if it moves the contact by at most this share of the step.
const LARGEST_CORRECTION: f64 = 0.1;

/// A step, with its beginning and its end.
pub(super) struct Path<'a> {
    network: &'a Network,
    positions: &'a [f64],
    velocities: &'a [f64],
    next: &'a [f64],
    length: f64,
}

/// Bounds of the motion of a body on a path.
#[derive(Debug, Clone, Copy)]
struct Limits {
    acceleration: f64,
    spin: f64,
    spin_change: f64,
}

impl<'a> Path<'a> {
    pub fn new(network: &'a Network, state: &'a State, next: &'a [f64], length: f64) -> Self {
        Self {
            network,
            positions: &state.positions,
            velocities: &state.velocities,
            next,
            length,
        }
    }

    /// r of a square.
    fn bend(&self, p: usize) -> [f64; 3] {
        let mut bend = [0.0; 3];
        for (axis, bend) in bend.iter_mut().enumerate() {
            let k = 3 * p + axis;
            // What the velocity leaves of the way to the end.
            *bend = self.next[k] - self.positions[k] - self.velocities[k] * self.length;
        }
        bend
    }

    fn state(&self, time: f64) -> impl Fn(usize) -> Moving + Copy + '_ {
        let share = time / self.length;
        move |p| {
            let bend = self.bend(p);
            let (mut s, mut v) = ([0.0; 3], [0.0; 3]);
            for axis in 0..3 {
                let k = 3 * p + axis;
                s[axis] =
                    self.positions[k] + self.velocities[k] * time + bend[axis] * share * share;
                v[axis] = self.velocities[k] + 2.0 * bend[axis] * share / self.length;
            }
            (s, v)
        }
    }

    /// The farthest that a point of any square can go, or of its image up to so many cells away.
    pub fn travel(&self, images: [f64; 2]) -> f64 {
        let mut farthest = 0.0_f64;
        for (p, square) in self.network.squares.iter().enumerate() {
            let (bend, v) = (self.bend(p), &self.velocities[3 * p..3 * p + 3]);
            // Translation along the chord and the bend, rotation of the corner.
            let centre = (v[0] * v[0] + v[1] * v[1]).sqrt() * self.length
                + (bend[0] * bend[0] + bend[1] * bend[1]).sqrt();
            let travel = centre + square.half_diagonal * (v[2].abs() * self.length + bend[2].abs());
            // NaN would lose every comparison; it must be reported.
            if travel.is_nan() {
                return travel;
            }
            farthest = farthest.max(travel);
        }
        farthest + self.cell_travel(images)
    }

    /// The farthest that the image of a body at rest can go, up to so many cells away.
    fn cell_travel(&self, [right, up]: [f64; 2]) -> f64 {
        let Some(place) = self.network.cell_place() else {
            return 0.0;
        };
        let bend = self.bend(self.network.squares.len());
        let rates = &self.velocities[place..];
        let [xx, yy, xy] = [0, 1, 2].map(|axis| rates[axis].abs() * self.length + bend[axis].abs());
        right * xx + up * (yy + xy)
    }

    /// The largest acceleration of an image of a body at rest.
    fn image_acceleration(&self, image: [i32; 2]) -> f64 {
        if image == [0, 0] || self.network.cell_mass.is_none() {
            return 0.0;
        }
        let [xx, yy, xy] = self.bend(self.network.squares.len());
        let shift = Cell { xx, yy, xy }.shift(image.map(f64::from));
        norm(shift) * 2.0 / (self.length * self.length)
    }

    /// The time near `time` at which a gap that changes at `rate` closes on the path of third order
    /// that also begins with these accelerations: it deviates from the drift only in the fourth
    /// order.
    pub fn refine(&self, watch: &Watch, accelerations: &[f64], time: f64, rate: f64) -> f64 {
        let mut refined = time;
        if rate < 0.0 {
            for _ in 0..REFINEMENTS {
                // The rate stays that of the first guess: three corrections are enough.
                let motion = self.at_third_order(accelerations, refined);
                refined -= watch.gap_of(self.network, motion) / rate;
            }
        }
        // Where that leads astray the first guess is as good.
        let near = (refined - time).abs() <= LARGEST_CORRECTION * self.length;
        if near && refined > 0.0 && refined < self.length {
            refined
        } else {
            time
        }
    }

    fn at_third_order<'b>(
        &'b self,
        accelerations: &'b [f64],
        time: f64,
    ) -> impl Fn(usize) -> Moving + Copy + 'b {
        let share = time / self.length;
        move |p| {
            let bend = self.bend(p);
            let mut s = [0.0; 3];
            for axis in 0..3 {
                let k = 3 * p + axis;
                let pull = 0.5 * accelerations[k] * self.length * self.length;
                // Half a t² a, and a term of third order that still ends at `next`.
                let curved = pull + (bend[axis] - pull) * share;
                s[axis] = self.positions[k] + self.velocities[k] * time + curved * share * share;
            }
            (s, [0.0; 3])
        }
    }

    fn limits(&self, p: usize) -> Limits {
        let (bend, per_square) = (self.bend(p), 2.0 / (self.length * self.length));
        let spin_change = bend[2].abs() * per_square;
        Limits {
            acceleration: bend[0].hypot(bend[1]) * per_square,
            spin: self.velocities[3 * p + 2].abs() + spin_change * self.length,
            spin_change,
        }
    }

    /// The largest acceleration of a corner of a square.
    fn corner_acceleration(&self, p: usize) -> f64 {
        let limits = self.limits(p);
        let half_diagonal = self.network.squares[p].half_diagonal;
        // Tangential r α and centripetal r ω².
        limits.acceleration + half_diagonal * (limits.spin_change + limits.spin * limits.spin)
    }

    fn body_limits(&self, body: Body, moving: &Rectangle) -> Limits {
        let rod = match body {
            Body::Square(p) => return self.limits(p),
            Body::Rod(r) => self.network.rods[r],
        };
        let mut ends = [rod.from.square, rod.to.square].map(|p| self.corner_acceleration(p));
        ends[1] += self.image_acceleration(rod.image);
        let bend = (ends[0] + ends[1]) / rod.length;
        let spin = 1.5 * (moving.spin.abs() + bend * self.length);
        Limits {
            acceleration: ends[0].max(ends[1]),
            spin,
            spin_change: bend + 2.0 * spin * spin,
        }
    }

    /// A bound of |m''| of the separations along the axes.
    fn curvature(&self, pair: &Pair, a: &Rectangle, b: &Rectangle) -> f64 {
        // Bounds of the parts of m'': pull, Coriolis, turning axis, turning body.
        let first = self.body_limits(Body::Square(pair.first), a);
        let second = self.body_limits(pair.second, b);
        let of_image = self.image_acceleration(pair.image);
        let pull = first.acceleration + second.acceleration + of_image;
        let speed = norm(minus(a.velocity, b.velocity)) + pull * self.length;
        let distance = norm(minus(a.centre, b.centre)) + speed * self.length;
        let spin = first.spin.max(second.spin);
        let spin_change = first.spin_change.max(second.spin_change);
        let reach = (a.half[0] + a.half[1]).max(b.half[0] + b.half[1]);
        let turning = first.spin + second.spin;
        pull + 2.0 * speed * spin
            + distance * (spin * spin + spin_change)
            + reach * (turning * turning + first.spin_change + second.spin_change)
    }

    /// The first contact of what is watched.
    pub fn march(&self, watch: &Watch) -> End {
        match *watch {
            Watch::Pair(pair) => self.march_pair(&pair),
            Watch::Stop { rod, end } => self.march_stop(rod, end),
        }
    }

    fn march_pair(&self, pair: &Pair) -> End {
        let (a, b) = bodies(self.network, pair, self.state(0.0));
        let curvature = self.curvature(pair, &a, &b);
        let probe = |time: f64| {
            let (a, b) = bodies(self.network, pair, self.state(time));
            Probe {
                functions: along_axes(&a, &b),
                to_kink: time_to_next_corner(&a, &b),
            }
        };
        first_root(probe, curvature, self.length)
    }

    fn march_stop(&self, rod: usize, end: u8) -> End {
        let ends = self.network.rods[rod];
        let (near, far) = (ends.corner_at(end).square, ends.corner_at(1 - end).square);
        let pull = self.corner_acceleration(near)
            + self.corner_acceleration(far)
            + self.image_acceleration(ends.image);
        let body = Rectangle::rod(self.network, rod, self.state(0.0));
        let limits = self.limits(near);
        let speed = body.spin.abs() * ends.length + pull * self.length;
        let curvature = pull
            + 2.0 * speed * limits.spin
            + ends.length * (limits.spin * limits.spin + limits.spin_change);
        let probe = |time: f64| Probe {
            functions: stop(self.network, rod, end, self.state(time)),
            to_kink: f64::INFINITY,
        };
        first_root(probe, curvature, self.length)
    }
}
