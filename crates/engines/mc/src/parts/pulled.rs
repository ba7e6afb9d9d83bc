//! Simulations of a part in windows that exchange their states.
//!
//! One half of the runs starts with the last body in its place, and the bias pulls it out; the other half starts with it
//! drawn at the displacement of each window. What the two disagree about enters the error.
//!
//! Where no energy of the last body acts, only its overlaps are looked up, and its energies are computed when a state is
//! kept or compared with a window in which they act.

use super::PartKind;
use super::configuration::{Configuration, Flexible, Moved};
use super::windows::Windows;
use crate::pair::region::Region;
use crate::{McError, Result};
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
    /// Whether the energies of the last body are those of its pose.
    has_energies: bool,
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
    /// Share of accepted exchanges of each link between windows.
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
/// Displacement within which the search for a start in its place begins, of the limit.
const NEAREST_START: f64 = 0.005;
/// Tries to find a start within a displacement, and within the wall, where other bodies may leave little room.
const TRIES: usize = 500;
const LAST_TRIES: usize = 40_000;
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
        let relative = last.then(&to.inverse());
        self.region.square_displacement(&relative).sqrt()
    }

    /// Whether the last body overlaps no other at a place next to a configuration of them.
    pub fn is_free(&self, place: &Vector6<f64>, rng: &mut CounterRng) -> bool {
        let before = &self.before[rng.index(self.before.len())];
        let pose = self.region.pose(place).then(&before.poses[self.partner()]);
        !self.whole.overlaps(&before.poses, self.last(), &pose)
    }

    /// Simulates all windows; `None` if the work was ended. `stream` has the random numbers of a step.
    ///
    /// # Errors
    /// Without room for the last body.
    pub fn simulated(
        &self,
        starts_bound: bool,
        stream: &dyn Fn(u64) -> CounterRng,
        goes_on: &dyn Fn() -> bool,
    ) -> Result<Option<Simulated>> {
        let windows = self.windows.count();
        let mut rng = stream(0);
        let starts = (0..windows).map(|window| self.start(window, starts_bound, &mut rng));
        let mut members: Vec<Member> = starts.collect::<Result<_>>()?;
        let mut found = Simulated {
            frames: vec![Vec::new(); windows],
            exchanged: vec![0.0; self.windows.links.len()],
            round_trips: 0,
            evaluations: 0,
        };
        let mut trips = Trips::new(windows, self.windows.free_window);
        let settling = self.sweeps / 4;
        let every = (self.sweeps / FRAMES).max(1);
        for sweep in 0..settling + self.sweeps {
            if !goes_on() {
                return Ok(None);
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
                for (frames, member) in found.frames.iter_mut().zip(&mut members) {
                    self.complete(member);
                    frames.push(self.frame(member, frames.len()));
                }
            }
        }
        // Each pair takes its turn in every second sweep.
        let turns = 0.5 * self.sweeps as f64;
        found.exchanged.iter_mut().for_each(|count| *count /= turns);
        Ok(Some(found))
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
    fn start(&self, window: usize, starts_bound: bool, rng: &mut CounterRng) -> Result<Member> {
        let wanted_angstrom = self.windows.displacement_angstrom(window);
        // Wider and wider about the place, until there is room.
        let mut within_angstrom = match starts_bound {
            true => NEAREST_START * self.region.limit_angstrom,
            false => wanted_angstrom,
        };
        let mut least_angstrom = match starts_bound {
            true => 0.0,
            false => 0.7 * wanted_angstrom,
        };
        let wall_angstrom = self.windows.wall_angstrom(window);
        loop {
            let region = Region {
                limit_angstrom: within_angstrom,
                ..self.region.clone()
            };
            let tries = match within_angstrom == wall_angstrom {
                true => LAST_TRIES,
                false => TRIES,
            };
            for _ in 0..tries {
                let before = &self.before[rng.index(self.before.len())];
                let place = region.draw(rng);
                let pose = region.pose(&place).then(&before.poses[self.partner()]);
                let displacement_angstrom = region.square_displacement_at_place(&place).sqrt();
                if displacement_angstrom < least_angstrom {
                    continue;
                }
                let energies_kt = self.whole.energies_kt(&before.poses, self.last(), &pose);
                if let Some(energies_kt) = energies_kt {
                    return Ok(Member {
                        configuration: before.with_body(pose, &energies_kt),
                        displacement_angstrom,
                        has_energies: true,
                        walker: window,
                    });
                }
            }
            if within_angstrom == wall_angstrom {
                break;
            }
            within_angstrom = (1.5 * within_angstrom).min(wall_angstrom);
            least_angstrom = 0.0;
        }
        // A body that fits nowhere else may fit tightly in its place.
        if !starts_bound {
            return self.start(window, true, rng);
        }
        Err(McError::BadSystem(format!(
            "the other bodies leave no room for the last one within {wall_angstrom:.1} Å of its place; a wider --limit may have \
             some, and nested sampling (without --way biased) tells whether there is any"
        )))
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
        // Infinite beyond the wall.
        if !rise_kt.is_finite() || !is_within_limits {
            return 0;
        }
        let coupling = self.windows.coupling(window);
        if body == last && coupling == 0.0 {
            let overlaps = self.whole.overlaps(&configuration.poses, body, &pose);
            if threshold < (-rise_kt).exp() && !overlaps {
                member.configuration.poses[body] = pose;
                member.displacement_angstrom = displacement_angstrom;
                member.has_energies = false;
            }
            return 1;
        }
        let Some(energies_kt) = self.whole.energies_kt(&configuration.poses, body, &pose) else {
            return 1;
        };
        let moved = Moved {
            body,
            pose,
            energies_kt,
        };
        let change_kt = configuration.change_with_coupled_kt(&moved, last, coupling);
        if threshold < (-rise_kt - change_kt).exp() {
            member.configuration.place(&moved);
            member.displacement_angstrom = displacement_angstrom;
        }
        1
    }

    /// Computes the energies of the last body if they are not those of its pose.
    fn complete(&self, member: &mut Member) {
        if member.has_energies {
            return;
        }
        let (poses, last) = (&member.configuration.poses, self.last());
        let pose = poses[last];
        // Each accepted pose is free of overlaps, so there are energies.
        if let Some(energies_kt) = self.whole.energies_kt(poses, last, &pose) {
            member.configuration.place(&Moved {
                body: last,
                pose,
                energies_kt,
            });
        }
        member.has_energies = true;
    }

    /// Windows exchange their states, every other link in turn; which links did.
    fn exchange(&self, members: &mut [Member], sweep: u64, rng: &mut CounterRng) -> Vec<bool> {
        let links = &self.windows.links;
        let mut accepted = vec![false; links.len()];
        for number in ((sweep % 2) as usize..links.len()).step_by(2) {
            let [first, second] = links[number];
            if links[number].map(|window| self.windows.coupling(window)) != [0.0; 2] {
                self.complete(&mut members[first]);
                self.complete(&mut members[second]);
            }
            let (a, b) = (&members[first], &members[second]);
            let energy_kt = |window, member: &Member| {
                let meeting_kt = member.configuration.row_sum_kt(self.last());
                self.windows
                    .energy_kt(window, member.displacement_angstrom, meeting_kt)
            };
            // The energies of the other bodies cancel.
            let rise_kt = energy_kt(first, b) + energy_kt(second, a)
                - energy_kt(first, a)
                - energy_kt(second, b);
            if rng.uniform() < (-rise_kt).exp() {
                members.swap(first, second);
                accepted[number] = true;
            }
        }
        accepted
    }
}

/// Ends of the windows that the walkers met last.
struct Trips {
    met_outer: Vec<Option<bool>>,
    free_window: usize,
}

impl Trips {
    fn new(walkers: usize, free_window: usize) -> Self {
        Self {
            met_outer: vec![None; walkers],
            free_window,
        }
    }

    /// Round trips that end in this sweep.
    fn ended(&mut self, members: &[Member]) -> u64 {
        let (inner, outer) = (members[0].walker, members[self.free_window].walker);
        let before = self.met_outer[inner].replace(false);
        // An outer end counts on the way from an inner one.
        if self.met_outer[outer].is_some() {
            self.met_outer[outer] = Some(true);
        }
        u64::from(before == Some(true))
    }
}
