//! Poses of the bodies of a part, with the energies between them.

use super::PartKind;
use crate::nested::step_scale;
use crate::pair::region::{Region, density};
use protomer_kernel::Pose;
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// Overlaps and energies of the bodies of an assembly, by their numbers.
pub trait BodyEnergies: Sync {
    /// Whether two bodies overlap at these poses.
    fn overlap(&self, first: usize, second: usize, first_pose: &Pose, second_pose: &Pose) -> bool;

    /// Energy of two bodies at these poses, at which they do not overlap, kT.
    fn energy_kt(&self, first: usize, second: usize, first_pose: &Pose, second_pose: &Pose) -> f64;
}

/// Poses of the bodies of a part.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Configuration {
    /// Poses, in the order of the bodies of the part.
    pub poses: Vec<Pose>,
    /// Energies of each two bodies, kT: full rows of a symmetric matrix.
    pub energies_kt: Vec<f64>,
}

impl Configuration {
    /// A single body.
    pub fn single(pose: Pose) -> Self {
        Self {
            poses: vec![pose],
            energies_kt: vec![0.0],
        }
    }

    /// The configuration with another body, which has these energies with the present ones, kT.
    pub fn with_body(&self, pose: Pose, energies_kt: &[f64]) -> Self {
        let bodies = self.poses.len();
        let mut poses = self.poses.clone();
        poses.push(pose);
        let mut all = Vec::with_capacity((bodies + 1).pow(2));
        for (row, energy_kt) in energies_kt.iter().enumerate() {
            all.extend_from_slice(&self.energies_kt[row * bodies..(row + 1) * bodies]);
            all.push(*energy_kt);
        }
        all.extend_from_slice(energies_kt);
        all.push(0.0);
        Self {
            poses,
            energies_kt: all,
        }
    }

    /// Energy of all bodies, kT.
    pub fn energy_kt(&self) -> f64 {
        0.5 * self.energies_kt.iter().sum::<f64>()
    }

    /// Energy of a body with all others, kT.
    pub fn row_sum_kt(&self, body: usize) -> f64 {
        self.row_kt(body).iter().sum()
    }

    fn row_kt(&self, body: usize) -> &[f64] {
        let bodies = self.poses.len();
        &self.energies_kt[body * bodies..(body + 1) * bodies]
    }

    /// Change of the energy by a move, kT.
    pub fn change_kt(&self, moved: &Moved) -> f64 {
        let before = self.row_sum_kt(moved.body);
        moved.energies_kt.iter().sum::<f64>() - before
    }

    /// Change of the energy by a move where only a share of the energies of one body acts, kT.
    pub fn change_with_coupled_kt(&self, moved: &Moved, coupled: usize, share: f64) -> f64 {
        let before_kt = self.row_kt(moved.body);
        if moved.body == coupled {
            return share * self.change_kt(moved);
        }
        let change_kt = |other: usize| moved.energies_kt[other] - before_kt[other];
        // Not the whole change less a part: where nothing acts, the energies of the body may be old.
        let others_kt = (0..self.poses.len()).filter(|other| *other != coupled);
        let others_kt: f64 = others_kt.map(change_kt).sum();
        match share {
            0.0 => others_kt,
            share => others_kt + share * change_kt(coupled),
        }
    }

    /// Moves one body.
    pub fn place(&mut self, moved: &Moved) {
        let bodies = self.poses.len();
        self.poses[moved.body] = moved.pose;
        for (other, energy_kt) in moved.energies_kt.iter().enumerate() {
            self.energies_kt[moved.body * bodies + other] = *energy_kt;
            self.energies_kt[other * bodies + moved.body] = *energy_kt;
        }
    }
}

/// A trial move of one body.
pub(super) struct Moved {
    /// Number of the body in the part.
    pub body: usize,
    /// New pose of the body.
    pub pose: Pose,
    /// Energies of the body with the others, kT.
    pub energies_kt: Vec<f64>,
}

/// A part whose bodies move, each within the limit of the body that it is attached to.
pub(super) struct Flexible<'a> {
    part: &'a PartKind,
    energies: &'a dyn BodyEnergies,
    /// Poses of each body about that in the assembly, in the frame of the body that it is attached to; the first body has
    /// the frame of the second, for differences only.
    regions: Vec<Region>,
}

impl<'a> Flexible<'a> {
    /// A part with the regions of its bodies, from the second on.
    pub fn new(part: &'a PartKind, attached: &[Region], energies: &'a dyn BodyEnergies) -> Self {
        let mut regions = Vec::with_capacity(part.bodies.len());
        if let Some(second) = attached.first() {
            regions.push(Region {
                about: second.about.inverse(),
                ..second.clone()
            });
        }
        regions.extend_from_slice(attached);
        Self {
            part,
            energies,
            regions,
        }
    }

    /// The body whose frame a body is described in.
    fn reference(&self, body: usize) -> usize {
        match body {
            0 => 1,
            body => self.part.attached_to[body],
        }
    }

    /// A move of one body that the regions allow and nothing blocks.
    pub fn proposed(
        &self,
        configuration: &Configuration,
        body: usize,
        between: [&Configuration; 2],
        scale: f64,
        uniform: f64,
    ) -> Option<Moved> {
        let (region, reference) = (&self.regions[body], self.reference(body));
        let place = |configuration: &Configuration| {
            region.place(&configuration.poses[body].then(&configuration.poses[reference].inverse()))
        };
        let present = place(configuration);
        let [a, b] = between.map(place);
        let next = present + scale * (a - b);
        // The density makes moves even in rotations, not in their vectors.
        if next.fixed_rows::<3>(3).norm() > std::f64::consts::PI
            || uniform * density(&present) > density(&next)
        {
            return None;
        }
        let pose = region.pose(&next).then(&configuration.poses[reference]);
        if !self.is_within_limits(configuration, body, &pose) {
            return None;
        }
        Some(Moved {
            body,
            energies_kt: self.energies_kt(&configuration.poses, body, &pose)?,
            pose,
        })
    }

    /// Whether a body at a pose is within the limits of the body that it is attached to and of those attached to it.
    pub fn is_within_limits(
        &self,
        configuration: &Configuration,
        body: usize,
        pose: &Pose,
    ) -> bool {
        let into_body = pose.inverse();
        (1..self.part.bodies.len()).all(|attached| {
            let to = self.part.attached_to[attached];
            let relative = match (attached == body, to == body) {
                (true, _) => pose.then(&configuration.poses[to].inverse()),
                (_, true) => configuration.poses[attached].then(&into_body),
                _ => return true,
            };
            self.regions[attached].holds_pose(&relative)
        })
    }

    /// Energies of a body at a pose with all others of the part that have one, kT; `None` at overlap.
    pub fn energies_kt(&self, poses: &[Pose], body: usize, pose: &Pose) -> Option<Vec<f64>> {
        // Overlaps first: half of the trial poses have one, and an overlap costs less than an energy.
        if self.overlaps(poses, body, pose) {
            return None;
        }
        let bodies = &self.part.bodies;
        let energy_kt = |(other, other_pose): (usize, &Pose)| match other == body {
            true => 0.0,
            false => self
                .energies
                .energy_kt(bodies[body], bodies[other], pose, other_pose),
        };
        Some(poses.iter().enumerate().map(energy_kt).collect())
    }

    /// Whether a body at a pose overlaps another of the part that has one.
    pub fn overlaps(&self, poses: &[Pose], body: usize, pose: &Pose) -> bool {
        let bodies = &self.part.bodies;
        let mut others = poses.iter().enumerate();
        others.any(|(other, other_pose)| {
            other != body
                && self
                    .energies
                    .overlap(bodies[body], bodies[other], pose, other_pose)
        })
    }

    /// Weights of configurations of another medium in this one.
    pub fn weights_in_another_medium(&self, configurations: &[Configuration]) -> Weights {
        let (mut logs, mut energies_kt) = (Vec::new(), Vec::new());
        let mut changed = Vec::with_capacity(configurations.len());
        for before in configurations {
            let after = self.in_this_medium(before);
            let after_kt = after
                .as_ref()
                .map_or(f64::INFINITY, Configuration::energy_kt);
            logs.push(before.energy_kt() - after_kt);
            energies_kt.push(after_kt);
            changed.push(after);
        }
        // The largest first, so that no exponential overflows.
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let factors: Vec<f64> = logs.iter().map(|log| (log - largest).exp()).collect();
        let mean = factors.iter().sum::<f64>() / factors.len() as f64;
        Weights {
            shares: factors.iter().map(|factor| factor / mean).collect(),
            ln_mean: largest + mean.ln(),
            energies_kt,
            configurations: changed,
        }
    }

    /// A configuration of another medium with the energies of this one; `None` at overlap.
    fn in_this_medium(&self, before: &Configuration) -> Option<Configuration> {
        let mut energies_kt = Vec::with_capacity(before.energies_kt.len());
        for (body, pose) in before.poses.iter().enumerate() {
            energies_kt.extend(self.energies_kt(&before.poses, body, pose)?);
        }
        Some(Configuration {
            poses: before.poses.clone(),
            energies_kt,
        })
    }

    /// Lets configurations forget each other: each body of each is moved this many times.
    pub fn relax(&self, configurations: &mut [Configuration], rounds: usize, rng: &mut CounterRng) {
        // Differences of the configurations as they were: they stay
        // fixed, so the moves keep the equilibrium.
        let former = configurations.to_vec();
        if former.len() < 3 || self.part.bodies.len() < 2 {
            return;
        }
        for (number, configuration) in configurations.iter_mut().enumerate() {
            for _ in 0..rounds * self.part.bodies.len() {
                let body = rng.index(self.part.bodies.len());
                let other = |rng: &mut CounterRng| {
                    (number + 1 + rng.index(former.len() - 1)) % former.len()
                };
                let (a, b) = (other(rng), other(rng));
                let scale = step_scale(rng);
                let (uniform, threshold) = (rng.uniform(), rng.uniform());
                let between = [&former[a], &former[b]];
                let moved = self.proposed(configuration, body, between, scale, uniform);
                // Metropolis' rule; a rise of the energy is accepted with its Boltzmann factor.
                if let Some(moved) = moved
                    && threshold < (-configuration.change_kt(&moved)).exp()
                {
                    configuration.place(&moved);
                }
            }
        }
    }
}

/// Configurations of one medium in another.
pub(super) struct Weights {
    /// Weight of each configuration, one on average.
    pub shares: Vec<f64>,
    /// ln < exp(-ΔU) >.
    pub ln_mean: f64,
    /// Energies in the other medium, kT; infinite at overlap.
    pub energies_kt: Vec<f64>,
    /// Configurations with the energies of the other medium; `None` at overlap.
    configurations: Vec<Option<Configuration>>,
}

impl Weights {
    /// Configurations drawn by their weights, as many as there were, by equal steps from a random start between zero and
    /// one: this adds the least noise.
    pub fn drawn(&self, start: f64) -> Vec<Configuration> {
        let (mut drawn, mut passed) = (Vec::with_capacity(self.shares.len()), 0.0);
        let mut taken = 0_u32;
        for (share, configuration) in self.shares.iter().zip(&self.configurations) {
            passed += share;
            while f64::from(taken) + start < passed && (taken as usize) < self.shares.len() {
                taken += 1;
                drawn.extend(configuration.clone());
            }
        }
        drawn
    }
}
