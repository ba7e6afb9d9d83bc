//! Starting states.
//!
//! Angles and velocities that are drawn at random do not obey the rods: of the 3 ns² velocities of
//! an open lattice only ns² + 2 ns are free, and for short rods hardly any angle is. What is asked
//! for is therefore brought onto the rods along the shortest way in the metric of the masses, and
//! [`Started`] says what was reached.
//!
//! Positions: s -= M⁻¹ Jᵀ A⁻¹ σ until σ = 0 (Newton's method; A = J M⁻¹ Jᵀ).
//! Velocities: v -= M⁻¹ Jᵀ A⁻¹ J v.
//!
//! Squares may overlap after a random turn; whether they do is for the collisions to say.

use super::force::coherent_part;
use super::network::Network;
use super::rods::RodSystem;
use super::state::State;
use crate::{CrystalError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::sparse::SparseError;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_4, TAU};

const ROD_TOLERANCE: f64 = 1e-13;
const VELOCITY_TOLERANCE: f64 = 1e-14;
const MOST_ITERATIONS: usize = 50;
/// Random turns are made in steps of at most this many rod lengths per half-diagonal, or this
/// angle.
const TURN_PER_STEP: f64 = 0.1;

/// How the squares turn at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum AngularVelocities {
    /// Not at all.
    #[default]
    Rest,
    /// ω = (-1)^(i+j) rate, with the translations of the coherent motion.
    Checkerboard {
        /// ⟨ω⟩₁.
        rate: f64,
    },
    /// Each uniform in (-largest, largest), then brought onto the rods.
    Uniform {
        /// Bound of what is drawn.
        largest: f64,
        /// All velocities are scaled in the end so that Σ ω² is this.
        #[serde(default)]
        sum_of_squares: Option<f64>,
    },
    /// (-1)^(i+j) rate plus a normal number of this standard deviation, then brought onto the rods.
    Normal {
        /// ⟨ω⟩₁ of what is drawn.
        #[serde(default)]
        rate: f64,
        /// Standard deviation of what is drawn.
        spread: f64,
        /// All velocities are scaled in the end so that Σ ω² is this.
        #[serde(default)]
        sum_of_squares: Option<f64>,
    },
}

/// What a run starts from.
///
/// ```
/// use protomer_crystal::lattice::{AngularVelocities, Edges, Network, Square, Start};
/// let start = Start { velocities: AngularVelocities::Checkerboard { rate: 1.0 }, ..Start::default() };
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, start.angle)?;
/// let started = start.build(&network, 0)?;
/// assert!((started.sum_of_squares - 4.0).abs() < 1e-12);
/// # Ok::<(), protomer_crystal::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// θ = (-1)^(i+j) angle before random turns: π/4 is open, 0 closed.
    pub angle: f64,
    /// Standard deviation of the normal random turns asked for; the rods allow less.
    pub angle_spread: f64,
    /// Angular velocities.
    pub velocities: AngularVelocities,
    /// Seed of whatever is random.
    pub seed: u64,
}

impl Default for Start {
    /// The open state at rest.
    fn default() -> Self {
        Self {
            angle: FRAC_PI_4,
            angle_spread: 0.0,
            velocities: AngularVelocities::Rest,
            seed: 0,
        }
    }
}

/// A starting state, and what became of the wishes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Started {
    /// The state; rods and velocities agree.
    pub state: State,
    /// Standard deviation about the coherent state of the angles that were drawn.
    pub angle_spread_drawn: f64,
    /// The same of the angles that the rods allowed.
    pub angle_spread_reached: f64,
    /// Σ ω² of the state.
    pub sum_of_squares: f64,
}

impl Start {
    /// The closed state, θ = 0, at rest.
    pub fn closed() -> Self {
        Self {
            angle: 0.0,
            ..Self::default()
        }
    }

    /// The state that this describes for a network; different replicas draw different numbers.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for spreads or sums that make no sense,
    /// [`CrystalError::OverConstrained`] and [`CrystalError::BadState`] where the rods cannot be
    /// obeyed, as in a periodic cell made for another angle.
    pub fn build(&self, network: &Network, replica: u32) -> Result<Started> {
        network.check()?;
        self.check()?;
        let mut state = State::coherent(network, self.angle);
        let mut projector = Projector::new(network);
        let mut angle_spread_drawn = 0.0;
        if self.angle_spread > 0.0 {
            let mut rng = CounterRng::for_purpose(self.seed, replica, 0, Purpose::LatticeAngles);
            let turns: Vec<f64> = network
                .squares
                .iter()
                .map(|_| self.angle_spread * normal(&mut rng))
                .collect();
            angle_spread_drawn = spread_of(network, &turns);
            turn_along_rods(network, &mut projector, &turns, &mut state)?;
        } else {
            projector.positions(&mut state.positions)?;
        }
        self.set_velocities(network, replica, &mut projector, &mut state)?;
        state.check(network)?;
        let angles: Vec<f64> = state.positions.iter().skip(2).step_by(3).copied().collect();
        let angle_spread_reached = spread_of(network, &angles);
        let sum_of_squares = sum_of_squares(&state.velocities);
        Ok(Started {
            state,
            angle_spread_drawn,
            angle_spread_reached,
            sum_of_squares,
        })
    }

    fn check(&self) -> Result<()> {
        let require =
            |setting: &'static str, value: f64, holds: bool, requirement: &'static str| {
                if value.is_finite() && holds {
                    Ok(())
                } else {
                    Err(CrystalError::BadSetting {
                        setting,
                        value,
                        requirement,
                    })
                }
            };
        require("angle", self.angle, true, "finite")?;
        require(
            "angle_spread",
            self.angle_spread,
            self.angle_spread >= 0.0,
            "zero or positive",
        )?;
        let sum = match self.velocities {
            AngularVelocities::Rest => None,
            AngularVelocities::Checkerboard { rate } => {
                require("rate", rate, true, "finite")?;
                None
            }
            AngularVelocities::Uniform {
                largest,
                sum_of_squares,
            } => {
                require("largest", largest, largest > 0.0, "positive")?;
                sum_of_squares
            }
            AngularVelocities::Normal {
                rate,
                spread,
                sum_of_squares,
            } => {
                require("rate", rate, true, "finite")?;
                require("spread", spread, spread >= 0.0, "zero or positive")?;
                sum_of_squares
            }
        };
        sum.map_or(Ok(()), |sum| {
            require("sum_of_squares", sum, sum > 0.0, "positive")
        })
    }

    fn set_velocities(
        &self,
        network: &Network,
        replica: u32,
        projector: &mut Projector,
        state: &mut State,
    ) -> Result<()> {
        let mut rng = CounterRng::for_purpose(self.seed, replica, 0, Purpose::LatticeVelocities);
        let mut wanted = None;
        match self.velocities {
            AngularVelocities::Rest => return Ok(()),
            AngularVelocities::Checkerboard { rate } => coherent_velocities(network, rate, state),
            AngularVelocities::Uniform {
                largest,
                sum_of_squares,
            } => {
                wanted = sum_of_squares;
                for velocity in state.velocities.chunks_exact_mut(3) {
                    velocity[2] = rng.uniform_in(-largest, largest);
                }
            }
            AngularVelocities::Normal {
                rate,
                spread,
                sum_of_squares,
            } => {
                wanted = sum_of_squares;
                if rate != 0.0 {
                    coherent_velocities(network, rate, state);
                }
                for velocity in state.velocities.chunks_exact_mut(3) {
                    velocity[2] += spread * normal(&mut rng);
                }
            }
        }
        projector.velocities(&state.positions, &mut state.velocities)?;
        if let Some(wanted) = wanted {
            let factor = (wanted / sum_of_squares(&state.velocities)).sqrt();
            if !factor.is_finite() {
                return Err(CrystalError::BadState(
                    "the squares do not turn, so Σ ω² cannot be scaled; give the velocities a spread or rate".into(),
                ));
            }
            state
                .velocities
                .iter_mut()
                .for_each(|velocity| *velocity *= factor);
        }
        Ok(())
    }
}

/// The velocities of the coherent motion at the coherent angle of this state, about the middle of
/// the lattice: ω = (-1)^(i+j) rate, and centres that follow the distance of neighbours, d = 2 l
/// cos(θ - π/4) + r0,
///
/// ẋ = (j - mean j) ḋ, ẏ = (mean i - i) ḋ, ḋ = -2 l sin(θ - π/4) rate.
pub fn coherent_velocities(network: &Network, rate: f64, state: &mut State) {
    let [_, angle] = coherent_part(network, &state.positions);
    let half_diagonal = network
        .squares
        .first()
        .map_or(1.0, |square| square.half_diagonal);
    let opening = -2.0 * half_diagonal * (angle - FRAC_PI_4).sin() * rate;
    let middle = |count: usize| 0.5 * (count - 1) as f64;
    for (p, velocity) in state.velocities.chunks_exact_mut(3).enumerate() {
        let [i, j] = network.place(p).map(|index| index as f64);
        velocity[0] = (j - middle(network.columns)) * opening;
        velocity[1] = (middle(network.rows) - i) * opening;
        velocity[2] = network.sign(p) * rate;
    }
}

/// Brings positions and velocities onto the rods.
#[derive(Debug, Clone)]
pub struct Projector {
    rods: RodSystem,
    sigma: Vec<f64>,
}

impl Projector {
    /// For the rods of this network.
    pub fn new(network: &Network) -> Self {
        let rods = RodSystem::new(network);
        let sigma = vec![0.0; rods.len()];
        Self { rods, sigma }
    }

    fn linearize(&mut self, positions: &[f64]) -> Result<()> {
        self.rods.linearize(positions).map_err(|error| match error {
            SparseError::Dependent { row, .. } => CrystalError::OverConstrained {
                rod: row,
                time: 0.0,
            },
            other => CrystalError::BadState(format!(
                "the positions cannot be brought onto the rods: {other}"
            )),
        })
    }

    /// Moves the squares, by little where they are heavy, until every rod has its length. Returns
    /// the number of iterations.
    ///
    /// # Errors
    /// [`CrystalError::OverConstrained`] at a singular position, [`CrystalError::BadState`] if the
    /// way does not end.
    pub fn positions(&mut self, positions: &mut [f64]) -> Result<usize> {
        let extent = positions
            .iter()
            .fold(1.0_f64, |extent, x| extent.max(x.abs()));
        let tolerance = ROD_TOLERANCE + 2.0 * f64::EPSILON * extent;
        let mut before = f64::INFINITY;
        for iteration in 0..MOST_ITERATIONS {
            let (rod, violation) = self.rods.violations(positions, &mut self.sigma);
            let stalled = violation.abs() >= 0.5 * before && violation.abs() <= 8.0 * tolerance;
            if violation.abs() <= tolerance || stalled {
                return Ok(iteration);
            }
            if !violation.is_finite() {
                return Err(CrystalError::BadState(format!(
                    "rod {rod} has no finite length"
                )));
            }
            before = violation.abs();
            self.linearize(positions)?;
            self.rods.solve(&mut self.sigma);
            self.rods.add_response(&self.sigma, -1.0, positions);
        }
        let (rod, violation) = self.rods.violations(positions, &mut self.sigma);
        Err(CrystalError::BadState(format!(
            "the positions cannot be brought onto the rods: rod {rod} is still off by {violation:+e} after \
             {MOST_ITERATIONS} iterations; start nearer to a state that obeys them"
        )))
    }

    /// Takes from the velocities what would change the lengths of the rods at these positions.
    ///
    /// # Errors
    /// [`CrystalError::OverConstrained`] at a singular position.
    pub fn velocities(&mut self, positions: &[f64], velocities: &mut [f64]) -> Result<()> {
        self.linearize(positions)?;
        for _ in 0..3 {
            self.rods.apply(velocities, &mut self.sigma);
            let left = self.sigma.iter().fold(0.0_f64, |left, x| left.max(x.abs()));
            if left <= VELOCITY_TOLERANCE {
                break;
            }
            self.rods.solve(&mut self.sigma);
            self.rods.add_response(&self.sigma, -1.0, velocities);
        }
        Ok(())
    }
}

/// Turns the squares by small parts of what is asked, each followed by a return to the rods, so
/// that what the rods forbid is lost on the way and the rest arrives.
fn turn_along_rods(
    network: &Network,
    projector: &mut Projector,
    turns: &[f64],
    state: &mut State,
) -> Result<()> {
    let shortest = network
        .rods
        .iter()
        .map(|rod| rod.length)
        .fold(1.0, f64::min);
    let largest_turn = turns
        .iter()
        .fold(0.0_f64, |largest, turn| largest.max(turn.abs()));
    let steps = (largest_turn / (TURN_PER_STEP * shortest)).ceil().max(1.0);
    for _ in 0..steps as usize {
        for (position, turn) in state.positions.chunks_exact_mut(3).zip(turns) {
            position[2] += turn / steps;
        }
        projector.positions(&mut state.positions)?;
    }
    Ok(())
}

/// √(Σ (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁)² / N).
fn spread_of(network: &Network, angles: &[f64]) -> f64 {
    let coordinates: Vec<f64> = angles.iter().flat_map(|angle| [0.0, 0.0, *angle]).collect();
    let [uniform, checkerboard] = coherent_part(network, &coordinates);
    let away =
        |(p, angle): (usize, &f64)| (angle - uniform - network.sign(p) * checkerboard).powi(2);
    (angles.iter().enumerate().map(away).sum::<f64>() / angles.len() as f64).sqrt()
}

fn sum_of_squares(velocities: &[f64]) -> f64 {
    velocities
        .iter()
        .skip(2)
        .step_by(3)
        .map(|omega| omega * omega)
        .sum()
}

/// Two independent standard normal numbers (Box and Muller) from exactly two uniform ones.
pub(crate) fn normal_pair(rng: &mut CounterRng) -> [f64; 2] {
    // 1 - u lies in (0, 1].
    let radius = (-2.0 * (1.0 - rng.uniform()).ln()).sqrt();
    let (sine, cosine) = (TAU * rng.uniform()).sin_cos();
    [radius * cosine, radius * sine]
}

fn normal(rng: &mut CounterRng) -> f64 {
    normal_pair(rng)[0]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::lattice::{Dynamics, Edges, Square};
    use std::sync::Arc;

    fn lattice(size: usize, rod_length: f64) -> Network {
        Network::lattice(
            size,
            size,
            rod_length,
            Square::default(),
            Edges::Open,
            FRAC_PI_4,
        )
        .unwrap()
    }

    /// J v, row by row from the definition: how fast each rod's length changes.
    fn stretching(network: &Network, state: &State) -> f64 {
        let ends = |time: f64| -> Vec<f64> {
            let at: Vec<f64> = state
                .positions
                .iter()
                .zip(&state.velocities)
                .map(|(s, v)| s + time * v)
                .collect();
            let corner = |corner: super::super::Corner| {
                let angle = at[3 * corner.square + 2]
                    + [135.0_f64, 45.0, 225.0, -45.0][usize::from(corner.vertex) - 1].to_radians();
                [
                    at[3 * corner.square] + angle.cos(),
                    at[3 * corner.square + 1] + angle.sin(),
                ]
            };
            let length = |rod: &super::super::Rod| {
                let (a, b) = (corner(rod.from), corner(rod.to));
                (a[0] - b[0]).hypot(a[1] - b[1])
            };
            network.rods.iter().map(length).collect()
        };
        let (before, after) = (ends(-1e-5), ends(1e-5));
        before
            .iter()
            .zip(&after)
            .map(|(a, b)| ((b - a) / 2e-5).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn coherent_velocities_stretch_no_rod_and_need_no_projection() {
        for angle in [FRAC_PI_4, 0.3, 0.0] {
            let network = lattice(5, 0.3);
            let mut state = State::coherent(&network, angle);
            coherent_velocities(&network, 0.7, &mut state);
            assert!(stretching(&network, &state) < 1e-8);
            let start = Start {
                angle,
                velocities: AngularVelocities::Checkerboard { rate: 0.7 },
                ..Start::default()
            };
            let started = start.build(&network, 0).unwrap().state;
            for (a, b) in state.velocities.iter().zip(&started.velocities) {
                assert!((a - b).abs() < 1e-12, "{angle}: {a} {b}");
            }
        }
    }

    #[test]
    fn random_starts_obey_the_rods_and_say_what_they_reached() {
        for rod_length in [0.05, 3.0 / 22.0, 1.0] {
            let network = lattice(4, rod_length);
            let velocities = AngularVelocities::Uniform {
                largest: 1.0,
                sum_of_squares: Some(4.0),
            };
            let start = Start {
                angle_spread: 0.2,
                velocities,
                seed: 5,
                ..Start::default()
            };
            let started = start.build(&network, 3).unwrap();
            assert!((started.sum_of_squares - 4.0).abs() < 1e-12);
            assert!(
                started.angle_spread_drawn > 0.1
                    && started.angle_spread_reached < started.angle_spread_drawn
            );
            assert!(started.angle_spread_reached > 0.0);
            assert!(stretching(&network, &started.state) < 1e-7);
            // The dynamics refuse a state off the rods by 1e-6; the lengths are far better.
            let mut dynamics =
                Dynamics::new(Arc::new(network.clone()), Vec::new(), &started.state).unwrap();
            let mut sigma = vec![0.0; network.rods.len()];
            let (_, violation) = dynamics
                .rods()
                .violations(&started.state.positions, &mut sigma);
            assert!(violation.abs() < 1e-12);
            assert_eq!(started, start.build(&network, 3).unwrap());
            assert_ne!(started.state, start.build(&network, 4).unwrap().state);
        }
    }

    #[test]
    fn shorter_rods_allow_less_spread() {
        let reached = |rod_length| {
            let start = Start {
                angle_spread: 0.2,
                seed: 1,
                ..Start::default()
            };
            start
                .build(&lattice(6, rod_length), 0)
                .unwrap()
                .angle_spread_reached
        };
        let [short, middle, long] = [0.02, 0.2, 1.0].map(reached);
        assert!(short < middle && middle < long, "{short} {middle} {long}");
    }

    #[test]
    fn a_projection_is_orthogonal_in_the_metric_of_the_masses() {
        let network = lattice(3, 0.5);
        let state = Start {
            angle_spread: 0.1,
            seed: 2,
            ..Start::default()
        }
        .build(&network, 0)
        .unwrap()
        .state;
        let mut projector = Projector::new(&network);
        let drawn: Vec<f64> = (0..27)
            .map(|index| (1.7 * f64::from(index)).sin())
            .collect();
        let mut kept = drawn.clone();
        projector.velocities(&state.positions, &mut kept).unwrap();
        let weight = |index: usize| if index % 3 == 2 { 1.0 / 3.0 } else { 1.0 };
        let product: f64 = (0..27)
            .map(|k| weight(k) * kept[k] * (drawn[k] - kept[k]))
            .sum();
        assert!(product.abs() < 1e-12);
        let norm = |v: &[f64]| (0..27).map(|k| weight(k) * v[k] * v[k]).sum::<f64>();
        assert!(norm(&kept) < 0.9 * norm(&drawn));
    }

    #[test]
    fn nonsense_is_refused() {
        let network = lattice(2, 0.5);
        for start in [
            Start {
                angle: f64::NAN,
                ..Start::default()
            },
            Start {
                angle_spread: -1.0,
                ..Start::default()
            },
            Start {
                velocities: AngularVelocities::Uniform {
                    largest: 0.0,
                    sum_of_squares: None,
                },
                ..Start::default()
            },
            Start {
                velocities: AngularVelocities::Normal {
                    rate: 0.0,
                    spread: 0.0,
                    sum_of_squares: Some(1.0),
                },
                ..Start::default()
            },
        ] {
            assert!(start.build(&network, 0).is_err(), "{start:?}");
        }
    }
}
