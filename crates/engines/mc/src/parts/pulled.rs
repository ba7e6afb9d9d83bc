//! Simulations of a part in umbrella windows that exchange their states.
//!
//! One half of the runs starts with the last body in its place, and the bias pulls it out; the other half starts with it
//! drawn at the displacement of each window. What the two disagree about enters the error.

use super::PartKind;
use super::configuration::{Configuration, Flexible, Moved};
use super::windows::Windows;
use crate::pair::region::Region;
use nalgebra::Vector6;
use protomer_kernel::Pose;
use protomer_kernel::random::CounterRng;

/// A part whose last body is pulled out.
pub(super) struct Pulled<'a> {
    pub part: &'a PartKind,
    /// The part without the last body, with the limits of the others.
    pub without: &'a Flexible<'a>,
    /// The whole part, for its energies.
    pub whole: &'a Flexible<'a>,
    /// Places of the last body next to that which it is attached to.
    pub region: &'a Region,
    /// Numbers of the bodies that move in addition to the last one.
    pub near: Vec<usize>,
    pub windows: &'a Windows,
    /// Configurations of the part without the last body.
    pub before: &'a [Configuration],
    pub sweeps: u64,
}

/// A state of a window.
#[derive(Debug, Clone)]
struct Member {
    configuration: Configuration,
    displacement_angstrom: f64,
    /// Number of the simulation, which moves from window to window by exchanges.
    walker: usize,
}

/// A sample of a window.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub displacement_angstrom: f64,
    /// Energy of the last body with the others, kT.
    pub meeting_kt: f64,
    /// The configuration, where it may serve for a larger part.
    pub configuration: Option<Configuration>,
}

/// Samples of all windows.
pub(super) struct Simulated {
    /// Samples by window.
    pub frames: Vec<Vec<Frame>>,
    /// Share of accepted exchanges of each two neighbouring windows.
    pub exchanged: Vec<f64>,
    pub round_trips: u64,
    pub evaluations: u64,
}

/// Samples of a window at most.
const FRAMES: u64 = 500;
/// Trial moves of the last body in a sweep.
const MOVES: usize = 4;
/// Smallest size of a move, relative to the largest: the last body is loose in one window and tight in another.
const SMALLEST: f64 = 0.02;
/// Largest shift and displacement by a turn of the other bodies, which are in their wells, Å.
const MEMBER_ANGSTROM: f64 = 2.0;
/// Tries to find a start of one kind.
const TRIES: usize = 500;
/// Bodies from which on only some samples keep their configuration.
const MANY_BODIES: usize = 8;

impl Pulled<'_> {
    fn last(&self) -> usize {
        self.part.bodies.len() - 1
    }

    fn partner(&self) -> usize {
        self.part.attached_to[self.last()]
    }

    /// Displacement of the last body, Å.
    fn displacement_angstrom(&self, last: &Pose, to: &Pose) -> f64 {
        let place = self.region.place(&last.then(&to.inverse()));
        self.region.square_displacement(&place).sqrt()
    }

    /// Whether the last body overlaps no other at a place next to a configuration of them.
    pub fn is_free(&self, place: &Vector6<f64>, rng: &mut CounterRng) -> bool {
        let before = &self.before[rng.index(self.before.len())];
        let pose = self.region.pose(place).then(&before.poses[self.partner()]);
        !self.whole.overlaps(&before.poses, self.last(), &pose)
    }

    /// Simulates all windows; `None` without room for the last body, or if the work was ended. `stream` has the random
    /// numbers of a step.
    pub fn simulated(
        &self,
        starts_bound: bool,
        stream: &dyn Fn(u64) -> CounterRng,
        goes_on: &dyn Fn() -> bool,
    ) -> Option<Simulated> {
        let windows = self.windows.count();
        let mut rng = stream(0);
        let starts = (0..windows).map(|window| self.start(window, starts_bound, &mut rng));
        let mut members: Vec<Member> = starts.collect::<Option<_>>()?;
        let mut found = Simulated {
            frames: vec![Vec::new(); windows],
            exchanged: vec![0.0; windows - 1],
            round_trips: 0,
            evaluations: 0,
        };
        let mut trips = Trips::new(windows);
        let settling = self.sweeps / 4;
        let every = (self.sweeps / FRAMES).max(1);
        for sweep in 0..settling + self.sweeps {
            if !goes_on() {
                return None;
            }
            // Streams: the start, then for each sweep one of each window and one of the exchanges.
            let first = 1 + sweep * (windows as u64 + 1);
            for (window, member) in members.iter_mut().enumerate() {
                let mut rng = stream(first + window as u64);
                found.evaluations += self.sweep(window, member, &mut rng);
            }
            let mut rng = stream(first + windows as u64);
            let accepted = self.exchange(&mut members, sweep, &mut rng);
            if sweep < settling {
                continue;
            }
            for (count, accepted) in found.exchanged.iter_mut().zip(accepted) {
                *count += f64::from(u8::from(accepted));
            }
            found.round_trips += trips.ended(&members);
            if (sweep - settling).is_multiple_of(every) {
                for (frames, member) in found.frames.iter_mut().zip(&members) {
                    frames.push(self.frame(member, frames.len()));
                }
            }
        }
        // Each pair takes its turn in every second sweep.
        let turns = 0.5 * self.sweeps as f64;
        found.exchanged.iter_mut().for_each(|count| *count /= turns);
        Some(found)
    }

    fn frame(&self, member: &Member, number: usize) -> Frame {
        let is_bound = member.displacement_angstrom < self.region.limit_angstrom;
        let keeps = number.is_multiple_of(1 + self.part.bodies.len() / MANY_BODIES);
        Frame {
            displacement_angstrom: member.displacement_angstrom,
            meeting_kt: member.configuration.row_sum_kt(self.last()),
            configuration: (is_bound && keeps).then(|| member.configuration.clone()),
        }
    }

    /// A first state of a window: in its place, or at the displacement of the window.
    fn start(&self, window: usize, starts_bound: bool, rng: &mut CounterRng) -> Option<Member> {
        let wanted_angstrom = self.windows.displacement_angstrom(window);
        // Wider and wider about the place, until there is room.
        let mut within_angstrom = match starts_bound {
            true => 0.1 * self.region.limit_angstrom,
            false => wanted_angstrom,
        };
        let mut least_angstrom = match starts_bound {
            true => 0.0,
            false => 0.7 * wanted_angstrom,
        };
        while within_angstrom < self.windows.free_angstrom[1] {
            let region = Region {
                limit_angstrom: within_angstrom,
                ..self.region.clone()
            };
            for _ in 0..TRIES {
                let before = &self.before[rng.index(self.before.len())];
                let place = region.draw(rng);
                let pose = region.pose(&place).then(&before.poses[self.partner()]);
                let displacement_angstrom = region.square_displacement(&place).sqrt();
                if displacement_angstrom < least_angstrom {
                    continue;
                }
                let energies_kt = self.whole.energies_kt(&before.poses, self.last(), &pose);
                if let Some(energies_kt) = energies_kt {
                    return Some(Member {
                        configuration: before.with_body(pose, &energies_kt),
                        displacement_angstrom,
                        walker: window,
                    });
                }
            }
            within_angstrom *= 1.5;
            least_angstrom = 0.0;
        }
        None
    }

    /// Trial moves of the last body and of the others near it; returns the number of energies that were computed.
    fn sweep(&self, window: usize, member: &mut Member, rng: &mut CounterRng) -> u64 {
        let mut evaluations = 0;
        let widest_angstrom = self.windows.displacement_angstrom(window);
        for _ in 0..MOVES {
            evaluations += self.step(window, member, (self.last(), widest_angstrom), rng);
        }
        // A single other body is the frame of the last one: its moves would change nothing.
        if self.part.bodies.len() > 2 {
            for body in &self.near {
                evaluations += self.step(window, member, (*body, MEMBER_ANGSTROM), rng);
            }
        }
        evaluations
    }

    /// A trial move of one body, by Metropolis' rule with the bias of the window.
    fn step(
        &self,
        window: usize,
        member: &mut Member,
        (body, widest_angstrom): (usize, f64),
        rng: &mut CounterRng,
    ) -> u64 {
        let configuration = &member.configuration;
        let size = SMALLEST.powf(rng.uniform());
        let kind = rng.index(3);
        let gyration_angstrom = self.region.square_of_gyration_angstrom2.sqrt();
        let shift = rng.vector_in_ball(widest_angstrom * size);
        let widest_rad = (widest_angstrom / gyration_angstrom).min(std::f64::consts::PI);
        let turn = rng.small_rotation(widest_rad * size);
        let threshold = rng.uniform();
        let mut pose = configuration.poses[body];
        // A shift, a turn, or both.
        if kind != 1 {
            pose.position += shift;
        }
        if kind != 0 {
            pose.rotation = turn * pose.rotation;
        }
        let (last, to) = (self.last(), self.partner());
        let displacement_angstrom = if body == last {
            self.displacement_angstrom(&pose, &configuration.poses[to])
        } else if body == to {
            self.displacement_angstrom(&configuration.poses[last], &pose)
        } else {
            member.displacement_angstrom
        };
        let bias_kt = |displacement| self.windows.bias_kt(window, displacement);
        let rise_kt = bias_kt(displacement_angstrom) - bias_kt(member.displacement_angstrom);
        let is_within_limits =
            body == last || self.without.is_within_limits(configuration, body, &pose);
        if !rise_kt.is_finite() || !is_within_limits {
            return 0;
        }
        let Some(energies_kt) = self.whole.energies_kt(&configuration.poses, body, &pose) else {
            return 1;
        };
        let moved = Moved {
            body,
            pose,
            energies_kt,
        };
        if threshold < (-rise_kt - configuration.change_kt(&moved)).exp() {
            member.configuration.place(&moved);
            member.displacement_angstrom = displacement_angstrom;
        }
        1
    }

    /// Neighbouring windows exchange their states, even and odd pairs in turn; which of them did.
    fn exchange(&self, members: &mut [Member], sweep: u64, rng: &mut CounterRng) -> Vec<bool> {
        let mut accepted = vec![false; members.len() - 1];
        for window in ((sweep % 2) as usize..members.len() - 1).step_by(2) {
            let (a, b) = (
                members[window].displacement_angstrom,
                members[window + 1].displacement_angstrom,
            );
            let bias_kt = |window, displacement| self.windows.bias_kt(window, displacement);
            // The energies of the bodies cancel: only biases differ.
            let rise_kt = bias_kt(window, b) + bias_kt(window + 1, a)
                - bias_kt(window, a)
                - bias_kt(window + 1, b);
            if rng.uniform() < (-rise_kt).exp() {
                members.swap(window, window + 1);
                accepted[window] = true;
            }
        }
        accepted
    }
}

/// Ends of the windows that the walkers met last.
struct Trips {
    met_outer: Vec<Option<bool>>,
}

impl Trips {
    fn new(walkers: usize) -> Self {
        Self {
            met_outer: vec![None; walkers],
        }
    }

    /// Round trips that end in this sweep.
    fn ended(&mut self, members: &[Member]) -> u64 {
        let (inner, outer) = (members[0].walker, members[members.len() - 1].walker);
        let before = self.met_outer[inner].replace(false);
        // An outer end counts on the way from an inner one.
        if self.met_outer[outer].is_some() {
            self.met_outer[outer] = Some(true);
        }
        u64::from(before == Some(true))
    }
}
