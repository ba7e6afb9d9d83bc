//! The first contact in a step.
//!
//! Over a step of length H the squares are taken to move as s(t) = s + v t + r (t/H)², with r such
//! that the path ends where the drift ends. On this path [`march`](super::march) finds the first
//! contact of every pair that is near enough; the earliest is then brought to the true sub-step,
//! which keeps the rods exactly, by Newton steps on the gap.
//!
//! Most pairs are not looked at in most steps. A pair with separation g when last seen cannot meet
//! before the fastest square has travelled g/2 since, corners included: it is `due` only then.

use super::march::{End, Probe, ROOT, first_root};
use crate::lattice::contact::candidates::{Body, Candidates, Pair};
use crate::lattice::contact::separation::{
    Along, Moving, Rectangle, along_axes, at_rest, corner_in_motion, separation,
    time_to_next_corner,
};
use crate::lattice::contact::{Contact, TOUCHING, minus, place, rod_ends, rod_shift, sides_at};
use crate::lattice::network::{Corner, Network, corner_direction};
use crate::lattice::{Dynamics, State};
use crate::{CrystalError, Result};
use std::f64::consts::SQRT_2;

/// Extra width of the candidate list, in half-diagonals.
const SKIN: f64 = 0.5;
const MOST_NEWTON_STEPS: usize = 40;

/// What could meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Watch {
    /// Two bodies.
    Pair(Pair),
    /// A rod and the square it hangs on at this end.
    Stop {
        /// The rod.
        rod: usize,
        /// 0 for `from`, 1 for `to`.
        end: u8,
    },
}

impl Watch {
    /// Both bodies in words.
    pub fn names(&self, network: &Network) -> (String, String) {
        let name = |body: Body| match body {
            Body::Square(p) => format!("square {p}"),
            Body::Rod(r) => {
                let rod = network.rods[r];
                format!(
                    "rod {r} (squares {} and {})",
                    rod.from.square, rod.to.square
                )
            }
        };
        match *self {
            Self::Pair(pair) => (name(Body::Square(pair.first)), name(pair.second)),
            Self::Stop { rod, end } => {
                let ends = network.rods[rod];
                (
                    name(Body::Square(if end == 0 {
                        ends.from.square
                    } else {
                        ends.to.square
                    })),
                    name(Body::Rod(rod)),
                )
            }
        }
    }

    /// The separation: positive apart.
    pub fn gap(&self, network: &Network, positions: &[f64]) -> f64 {
        self.gap_of(network, at_rest(positions))
    }

    fn gap_of(&self, network: &Network, at: impl Fn(usize) -> Moving + Copy) -> f64 {
        match *self {
            Self::Pair(pair) => {
                let (a, b) = bodies(network, &pair, at);
                separation(&a, &b)
            }
            Self::Stop { rod, end } => {
                let [x, y] = stop(network, rod, end, at);
                x.distance.max(y.distance)
            }
        }
    }

    /// Adds the contacts of two bodies that touch. Corners head on are listed from either side.
    pub fn contacts(&self, network: &Network, positions: &[f64], out: &mut Vec<Contact>) {
        match *self {
            Self::Pair(Pair {
                first,
                second: Body::Square(second),
                shift,
            }) => {
                for (striker, target, shift) in [
                    (first, second, shift),
                    (second, first, [-shift[0], -shift[1]]),
                ] {
                    let body = Rectangle::square(network, target, at_rest(positions)).moved(shift);
                    for vertex in 1..=4 {
                        let corner = Corner {
                            square: striker,
                            vertex,
                        };
                        if height_above(&body, place(network, positions, corner)) <= TOUCHING {
                            out.push(Contact::of_corner(
                                network, positions, corner, target, shift,
                            ));
                        }
                    }
                }
            }
            Self::Pair(Pair {
                first,
                second: Body::Rod(rod),
                shift,
            }) => {
                let [a, b] = rod_ends(network, positions, rod);
                let along = minus(b, a);
                let length = along[0].hypot(along[1]);
                let u = [along[0] / length, along[1] / length];
                let height = |point: [f64; 2]| {
                    let away = minus(minus(point, shift), a);
                    (
                        u[0] * away[1] - u[1] * away[0],
                        (u[0] * away[0] + u[1] * away[1]) / length,
                    )
                };
                let left = height([positions[3 * first], positions[3 * first + 1]]).0 > 0.0;
                for vertex in 1..=4 {
                    let striker = Corner {
                        square: first,
                        vertex,
                    };
                    let (across, share) = height(place(network, positions, striker));
                    // At the very end of a rod there is a corner, and that has contacts of its own.
                    let inside = (TOUCHING..1.0 - TOUCHING).contains(&share);
                    // Where only an end of the rod touches, corners may lie beyond its
                    // prolongation.
                    if inside && across.abs() <= TOUCHING {
                        out.push(Contact::RodCorner {
                            striker,
                            rod,
                            left,
                            shift,
                        });
                    }
                }
            }
            Self::Stop { rod, end } => {
                let ends = network.rods[rod];
                let near = if end == 0 { ends.from } else { ends.to };
                let [x, y] = stop(network, rod, end, at_rest(positions));
                let sides = sides_at(near.vertex);
                let side = if x.distance >= y.distance {
                    sides[0]
                } else {
                    sides[1]
                };
                out.push(Contact::RodStop { rod, end, side });
            }
        }
    }
}

/// How far a point is above the sides of a rectangle (eq. 12 of the paper, less l², over √2 l):
/// negative inside.
fn height_above(body: &Rectangle, point: [f64; 2]) -> f64 {
    let [x, y] = minus(point, body.centre);
    let [c, s] = body.axis;
    ((c * x + s * y).abs() - body.half[0]).max((c * y - s * x).abs() - body.half[1])
}

fn bodies(
    network: &Network,
    pair: &Pair,
    at: impl Fn(usize) -> Moving + Copy,
) -> (Rectangle, Rectangle) {
    let second = match pair.second {
        Body::Square(q) => Rectangle::square(network, q, at),
        Body::Rod(r) => Rectangle::rod(network, r, at),
    };
    (
        Rectangle::square(network, pair.first, at),
        second.moved(pair.shift),
    )
}

/// The far end of a rod over the lines of the two sides that meet where it hangs.
fn stop(network: &Network, rod: usize, end: u8, at: impl Fn(usize) -> Moving) -> [Along; 2] {
    let (ends, shift) = (network.rods[rod], rod_shift(network, rod));
    let (near, far, sign) = if end == 0 {
        (ends.from, ends.to, 1.0)
    } else {
        (ends.to, ends.from, -1.0)
    };
    let own = at(near.square);
    let ((a, va), (b, vb)) = (
        corner_in_motion(network, near, own),
        corner_in_motion(network, far, at(far.square)),
    );
    let along = [b[0] - a[0] + sign * shift[0], b[1] - a[1] + sign * shift[1]];
    let speed = minus(vb, va);
    let ((sine, cosine), spin) = (own.0[2].sin_cos(), own.1[2]);
    let outward = corner_direction(near.vertex);
    let over = |axis: [f64; 2]| {
        let distance = along[0] * axis[0] + along[1] * axis[1];
        let rate = speed[0] * axis[0]
            + speed[1] * axis[1]
            + spin * (along[1] * axis[0] - along[0] * axis[1]);
        Along {
            distance,
            rate,
            worst_rate: rate,
        }
    };
    let (x, y) = (outward[0].signum(), outward[1].signum());
    [over([x * cosine, x * sine]), over([-y * sine, y * cosine])]
}

/// A step: where it begins and ends.
struct Path<'a> {
    positions: &'a [f64],
    velocities: &'a [f64],
    next: &'a [f64],
    length: f64,
}

/// Largest speed, acceleration, angular velocity and angular acceleration on a path.
#[derive(Debug, Clone, Copy)]
struct Limits {
    acceleration: f64,
    spin: f64,
    spin_change: f64,
}

impl Path<'_> {
    fn bend(&self, p: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let k = 3 * p + axis;
            self.next[k] - self.positions[k] - self.velocities[k] * self.length
        })
    }

    fn at(&self, time: f64) -> impl Fn(usize) -> Moving + Copy + '_ {
        let share = time / self.length;
        move |p| {
            let bend = self.bend(p);
            let s = [0, 1, 2].map(|axis| {
                self.positions[3 * p + axis]
                    + self.velocities[3 * p + axis] * time
                    + bend[axis] * share * share
            });
            let v = [0, 1, 2]
                .map(|axis| self.velocities[3 * p + axis] + 2.0 * bend[axis] * share / self.length);
            (s, v)
        }
    }

    /// The farthest a point of a square can go.
    fn travel(&self, network: &Network) -> f64 {
        let mut farthest = 0.0_f64;
        for (p, square) in network.squares.iter().enumerate() {
            let (bend, v) = (self.bend(p), &self.velocities[3 * p..3 * p + 3]);
            let centre = (v[0] * v[0] + v[1] * v[1]).sqrt() * self.length
                + (bend[0] * bend[0] + bend[1] * bend[1]).sqrt();
            let travel = centre + square.half_diagonal * (v[2].abs() * self.length + bend[2].abs());
            if travel.is_nan() {
                return travel;
            }
            farthest = farthest.max(travel);
        }
        farthest
    }

    /// The time near `time` at which a gap that changes at `rate` closes on the path of third order
    /// that also begins with these accelerations: as good as the drift itself but for the fourth
    /// order.
    fn refine(
        &self,
        network: &Network,
        watch: &Watch,
        accelerations: &[f64],
        time: f64,
        rate: f64,
    ) -> f64 {
        let cubic = |time: f64| {
            let share = time / self.length;
            move |p: usize| {
                let bend = self.bend(p);
                let s = [0, 1, 2].map(|axis| {
                    let k = 3 * p + axis;
                    let pull = 0.5 * accelerations[k] * self.length * self.length;
                    let curved = pull + (bend[axis] - pull) * share;
                    self.positions[k] + self.velocities[k] * time + curved * share * share
                });
                (s, [0.0; 3])
            }
        };
        let mut refined = time;
        if rate < 0.0 {
            for _ in 0..3 {
                refined -= watch.gap_of(network, cubic(refined)) / rate;
            }
        }
        // Where that leads astray the first guess is as good.
        let near = (refined - time).abs() <= 0.1 * self.length;
        if near && refined > 0.0 && refined < self.length {
            refined
        } else {
            time
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

    /// Of a corner of a square.
    fn corner_acceleration(&self, network: &Network, p: usize) -> f64 {
        let limits = self.limits(p);
        limits.acceleration
            + network.squares[p].half_diagonal * (limits.spin_change + limits.spin * limits.spin)
    }

    fn body_limits(&self, network: &Network, body: Body, moving: &Rectangle) -> Limits {
        match body {
            Body::Square(p) => self.limits(p),
            Body::Rod(r) => {
                let rod = network.rods[r];
                let ends =
                    [rod.from.square, rod.to.square].map(|p| self.corner_acceleration(network, p));
                let bend = (ends[0] + ends[1]) / rod.length;
                let spin = 1.5 * (moving.spin.abs() + bend * self.length);
                Limits {
                    acceleration: ends[0].max(ends[1]),
                    spin,
                    spin_change: bend + 2.0 * spin * spin,
                }
            }
        }
    }

    /// |m''| of the separations along the axes.
    fn curvature(&self, network: &Network, pair: &Pair, a: &Rectangle, b: &Rectangle) -> f64 {
        let first = self.body_limits(network, Body::Square(pair.first), a);
        let second = self.body_limits(network, pair.second, b);
        let pull = first.acceleration + second.acceleration;
        let speed = (a.velocity[0] - b.velocity[0]).hypot(a.velocity[1] - b.velocity[1])
            + pull * self.length;
        let distance =
            (a.centre[0] - b.centre[0]).hypot(a.centre[1] - b.centre[1]) + speed * self.length;
        let (spin, spin_change) = (
            first.spin.max(second.spin),
            first.spin_change.max(second.spin_change),
        );
        let reach = (a.half[0] + a.half[1]).max(b.half[0] + b.half[1]);
        let turning = first.spin + second.spin;
        pull + 2.0 * speed * spin
            + distance * (spin * spin + spin_change)
            + reach * (turning * turning + first.spin_change + second.spin_change)
    }

    fn march(&self, network: &Network, watch: &Watch) -> End {
        match *watch {
            Watch::Pair(pair) => {
                let (a, b) = bodies(network, &pair, self.at(0.0));
                let probe = |time: f64| {
                    let (a, b) = bodies(network, &pair, self.at(time));
                    Probe {
                        along: along_axes(&a, &b),
                        to_kink: time_to_next_corner(&a, &b),
                    }
                };
                first_root(probe, self.curvature(network, &pair, &a, &b), self.length)
            }
            Watch::Stop { rod, end } => {
                let ends = network.rods[rod];
                let (near, far) = if end == 0 {
                    (ends.from.square, ends.to.square)
                } else {
                    (ends.to.square, ends.from.square)
                };
                let pull = self.corner_acceleration(network, near)
                    + self.corner_acceleration(network, far);
                let body = Rectangle::rod(network, rod, self.at(0.0));
                let limits = self.limits(near);
                let speed = body.spin.abs() * ends.length + pull * self.length;
                let curvature = pull
                    + 2.0 * speed * limits.spin
                    + ends.length * (limits.spin * limits.spin + limits.spin_change);
                let probe = |time: f64| Probe {
                    along: stop(network, rod, end, self.at(time)),
                    to_kink: f64::INFINITY,
                };
                first_root(probe, curvature, self.length)
            }
        }
    }
}

/// Finds contacts, and remembers which pairs are not due yet.
#[derive(Debug, Clone)]
pub struct Detector {
    candidates: Candidates,
    skin: f64,
    rods_block: bool,
    stops: Vec<Watch>,
    /// For every pair, then every stop.
    due: Vec<f64>,
    travelled: f64,
    /// The watches that can have met in the last step looked at, and whether they touched at its
    /// start.
    hot: Vec<(Watch, bool)>,
    /// Those whose path had a root: time, rate.
    roots: Vec<(Watch, f64, f64)>,
    free: Vec<f64>,
    total: Vec<f64>,
}

/// Where the first contact is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Time since the start of the step.
    pub time: f64,
    /// What meets.
    pub watch: Watch,
}

impl Detector {
    /// For a network at these positions. With `rods_block`, rods are obstacles for corners and for
    /// the squares they hang on.
    pub fn new(network: &Network, positions: &[f64], rods_block: bool) -> Self {
        let half_diagonal = network
            .squares
            .iter()
            .map(|square| square.half_diagonal)
            .fold(0.0, f64::max);
        let skin = SKIN * half_diagonal;
        let candidates = Candidates::new(network, positions, skin, rods_block);
        let mut stops = Vec::new();
        for (rod, ends) in network.rods.iter().enumerate().filter(|_| rods_block) {
            // A shorter rod's far end meets the side itself.
            for (end, corner) in [(0, ends.from), (1, ends.to)] {
                if ends.length > SQRT_2 * network.squares[corner.square].half_diagonal {
                    stops.push(Watch::Stop { rod, end });
                }
            }
        }
        let due = vec![0.0; candidates.pairs().len() + stops.len()];
        Self {
            candidates,
            skin,
            rods_block,
            stops,
            due,
            travelled: 0.0,
            hot: Vec::new(),
            roots: Vec::new(),
            free: vec![0.0; positions.len()],
            total: vec![0.0; positions.len()],
        }
    }

    /// Whether rods are obstacles.
    pub fn rods_block(&self) -> bool {
        self.rods_block
    }

    /// How often the list of near pairs was made.
    pub fn lists(&self) -> u64 {
        self.candidates.rebuilds()
    }

    /// Everything on the list, with rods and stops.
    pub fn watches(&self) -> impl Iterator<Item = Watch> + '_ {
        self.candidates
            .pairs()
            .iter()
            .map(|pair| Watch::Pair(*pair))
            .chain(self.stops.iter().copied())
    }

    /// The watches that may be closed in the step last looked at.
    pub fn hot(&self) -> impl Iterator<Item = &Watch> {
        self.hot.iter().map(|(watch, _)| watch)
    }

    /// Refreshes the candidates and forgets what is due: for positions that did not come from a
    /// step.
    pub fn reset(&mut self, network: &Network, positions: &[f64]) {
        self.candidates.rebuild(network, positions);
        self.due.clear();
        self.due
            .resize(self.candidates.pairs().len() + self.stops.len(), 0.0);
        self.travelled = 0.0;
    }

    /// # Errors
    /// [`CrystalError::Overlap`] names the first two bodies that overlap by more than 1e-9.
    pub fn check_no_overlap(&self, network: &Network, positions: &[f64], time: f64) -> Result<()> {
        for watch in self.watches() {
            let gap = watch.gap(network, positions);
            if gap.is_nan() || gap < -TOUCHING {
                return Err(overlap(network, &watch, -gap, time));
            }
        }
        Ok(())
    }

    /// Contacts of everything that touches at these positions, among what the last step looked at.
    /// Corners head on are listed from either side.
    pub fn touching(&self, network: &Network, positions: &[f64]) -> Vec<Contact> {
        let mut contacts = Vec::new();
        for (watch, _) in &self.hot {
            if watch.gap(network, positions) <= TOUCHING {
                watch.contacts(network, positions, &mut contacts);
            }
        }
        contacts
    }

    /// Watches that close on the path from this state to `next`: fills `hot` and `roots`.
    fn scan(&mut self, network: &Network, state: &State, next: &[f64], step: f64) -> Result<()> {
        let path = Path {
            positions: &state.positions,
            velocities: &state.velocities,
            next,
            length: step,
        };
        let travel = path.travel(network);
        if !travel.is_finite() {
            return Err(CrystalError::NotFinite {
                square: 0,
                time: state.time,
            });
        }
        if !self.candidates.holds(&state.positions, travel) {
            // Free squares may be fast: the list then reaches farther.
            self.candidates.set_skin(self.skin.max(2.5 * travel));
            self.reset(network, &state.positions);
        }
        self.hot.clear();
        self.roots.clear();
        let now = self.travelled;
        self.travelled += 2.0 * travel;
        let pairs = self.candidates.pairs();
        for (index, due) in self.due.iter_mut().enumerate() {
            if *due > self.travelled {
                continue;
            }
            let (watch, lever) = match pairs.get(index) {
                Some(pair) => (Watch::Pair(*pair), 1.0),
                None => {
                    let watch = self.stops[index - pairs.len()];
                    // The line of a side turns with the square: its height over a far end changes
                    // by the lever.
                    let length = if let Watch::Stop { rod, .. } = watch {
                        network.rods[rod].length
                    } else {
                        0.0
                    };
                    (watch, 1.0 + length)
                }
            };
            let gap = watch.gap(network, &state.positions);
            *due = now + gap / lever;
            if *due > self.travelled {
                continue;
            }
            self.hot.push((watch, gap <= TOUCHING));
            match path.march(network, &watch) {
                End::Free => {}
                End::Root { time, rate } => self.roots.push((watch, time, rate)),
                End::Overlapping { depth } => {
                    return Err(overlap(network, &watch, depth, state.time));
                }
            }
        }
        Ok(())
    }

    /// The first contact in the drift of length `step` from a prepared state. `positions` are those
    /// at its end, or at the contact, and the drift to there is the last one made.
    ///
    /// # Errors
    /// Those of [`Dynamics::drift`], and [`CrystalError::Overlap`] if bodies overlap at the start.
    pub fn first_meeting(
        &mut self,
        dynamics: &mut Dynamics,
        state: &State,
        step: f64,
        positions: &mut [f64],
    ) -> Result<Option<Meeting>> {
        dynamics.drift(state, step, positions)?;
        let network = dynamics.network().clone();
        self.scan(&network, state, positions, step)?;
        let Some(earliest) = self
            .roots
            .iter()
            .copied()
            .min_by(|a, b| a.1.total_cmp(&b.1))
        else {
            return Ok(None);
        };
        let (mut watch, mut time, mut rate) = earliest;
        if time == 0.0 {
            positions.copy_from_slice(&state.positions);
            return Ok(Some(Meeting { time, watch }));
        }
        dynamics.accelerations_into(&mut self.free, &mut self.total);
        let path = Path {
            positions: &state.positions,
            velocities: &state.velocities,
            next: positions,
            length: step,
        };
        time = path.refine(&network, &watch, &self.total, time, rate);
        // Everything that is near, as one gap, along the true drift.
        let (mut open, mut closed) = (0.0_f64, f64::INFINITY);
        let mut last: Option<(f64, f64)> = None;
        for newton_step in 0..=MOST_NEWTON_STEPS {
            dynamics.drift(state, time, positions)?;
            let mut gap = f64::INFINITY;
            for (other, touched) in &self.hot {
                let value = other.gap(&network, positions);
                // What touched at the start and parts is no contact; it may come back, or the path
                // may have been wrong.
                let comes_back = || {
                    self.roots
                        .iter()
                        .any(|(root, at, _)| root == other && time >= 0.5 * at)
                };
                if value < gap && (!touched || value < -2.0 * ROOT || comes_back()) {
                    (gap, watch) = (value, *other);
                }
            }
            if gap.abs() <= ROOT || newton_step == MOST_NEWTON_STEPS {
                break;
            }
            if gap > 0.0 {
                open = open.max(time);
            } else {
                closed = closed.min(time);
            }
            if let Some((before, value)) = last {
                let secant = (gap - value) / (time - before);
                if secant < 0.0 {
                    rate = secant;
                }
            }
            last = Some((time, gap));
            let mut guess = if rate < 0.0 {
                time - gap / rate
            } else {
                f64::INFINITY
            };
            if !(guess > open && guess < closed) {
                guess = if closed.is_finite() {
                    0.5 * (open + closed)
                } else {
                    0.5 * (open + step)
                };
            }
            if guess == time || guess >= step {
                break;
            }
            time = guess;
        }
        Ok(Some(Meeting { time, watch }))
    }
}

pub(crate) fn overlap(network: &Network, watch: &Watch, depth: f64, time: f64) -> CrystalError {
    let (first, second) = watch.names(network);
    CrystalError::Overlap {
        first,
        second,
        depth,
        time,
    }
}
