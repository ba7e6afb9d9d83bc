//! Starting states.
//!
//! Angles and velocities that are drawn at random do not obey the rods: of the 3 ns² velocities of
//! an open lattice only ns² + 2 ns are free, and for short rods hardly any angle is. What is
//! requested is therefore brought onto the rods along the shortest way in the metric of the masses
//! (see [`Projector`]), and [`Started`] says what was reached.
//!
//! Squares may overlap after a random turn; [`Start::build_apart`] draws again until they do not.

use super::collision::detection::{Detector, rods_block_by_default};
use super::dynamics::Dynamics;
use super::force::{coherent_part, incoherent_spread};
use super::network::Network;
use super::projector::Projector;
use super::state::{State, angles, from_middle};
use super::thermostat::Langevin;
use crate::error::{CrystalError, Result, require_finite, require_not_negative, require_positive};
use crate::plane::largest_magnitude;
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// Random turns are made in steps of at most this angle times the length of the shortest rod, or
/// this angle if all rods are longer than a half-diagonal.
const TURN_PER_STEP: f64 = 0.1;
/// Starts are drawn at most so often until their squares are apart.
const MOST_DRAWS: u32 = 200;

/// Velocities of the squares at the start. What the rods forbid is removed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StartVelocities {
    /// Squares at rest.
    #[default]
    Rest,
    /// ω = (-1)^(i+j) rate, with the translations of the coherent motion.
    Checkerboard {
        /// ⟨ω⟩₁.
        rate: f64,
    },
    /// Angular velocities drawn uniformly from (-largest, largest).
    Uniform {
        /// Bound of the numbers drawn.
        largest: f64,
        /// Σ ω² to which all velocities are scaled in the end.
        #[serde(default)]
        sum_of_squares: Option<f64>,
    },
    /// Disordered spins: (-1)^(i+j) rate plus a normal number.
    Normal {
        /// ⟨ω⟩₁ before the normal numbers are added.
        #[serde(default)]
        rate: f64,
        /// Standard deviation of the normal numbers.
        spread: f64,
        /// Σ ω² to which all velocities are scaled in the end.
        #[serde(default)]
        sum_of_squares: Option<f64>,
    },
    /// Velocities of the canonical ensemble, translations included.
    Thermal {
        /// kT in units of mass · half-diagonal² / time².
        kt: f64,
    },
}

/// Settings of the state from which a run starts.
///
/// ```
/// use protomer_linkage::lattice::{Edges, Network, Square, Start, StartVelocities};
/// let velocities = StartVelocities::Checkerboard { rate: 1.0 };
/// let start = Start { velocities, ..Start::default() };
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, start.angle)?;
/// let started = start.build(&network, 0)?;
/// assert!((started.sum_of_squares - 4.0).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// θ = (-1)^(i+j) angle before random turns, rad: π/4 is open, 0 closed.
    pub angle: f64,
    /// Requested standard deviation of the normal random turns, rad; the rods allow less.
    pub angle_spread: f64,
    /// Velocities.
    pub velocities: StartVelocities,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for Start {
    /// The open state at rest.
    fn default() -> Self {
        Self {
            angle: FRAC_PI_4,
            angle_spread: 0.0,
            velocities: StartVelocities::Rest,
            seed: 0,
        }
    }
}

/// A starting state, and how near it came to what was requested.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Started {
    /// The state; rods and velocities agree.
    pub state: State,
    /// Standard deviation about the coherent state of the angles that were drawn, rad.
    pub angle_spread_drawn: f64,
    /// Standard deviation about the coherent state of the angles that the rods allowed, rad.
    pub angle_spread_reached: f64,
    /// Σ ω² of the state.
    pub sum_of_squares: f64,
    /// Number of starts that were drawn before this one and discarded because squares overlapped or
    /// could not be brought onto the rods.
    pub discarded_draws: u32,
}

impl Start {
    /// The closed state, θ = 0, at rest.
    pub fn closed() -> Self {
        Self {
            angle: 0.0,
            ..Self::default()
        }
    }

    /// Builds the state for a network; different replicas draw different numbers.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for spreads or sums that make no sense,
    /// [`CrystalError::OverConstrained`] and [`CrystalError::BadState`] where the rods cannot be
    /// obeyed, as in a periodic cell made for another angle.
    pub fn build(&self, network: &Network, replica: u32) -> Result<Started> {
        self.build_unless(network, replica, &|| false)
    }

    /// Variant of [`build`](Start::build) that ends when `stops` says that the work must stop.
    ///
    /// # Errors
    /// As [`build`](Start::build), and [`CrystalError::Stopped`].
    pub fn build_unless(
        &self,
        network: &Network,
        replica: u32,
        stops: &dyn Fn() -> bool,
    ) -> Result<Started> {
        network.check()?;
        self.check()?;
        let mut state = State::coherent(network, self.angle);
        let mut projector = Projector::new(network);
        let mut angle_spread_drawn = 0.0;
        if self.angle_spread > 0.0 {
            let turns = self.draw_turns(network, replica);
            angle_spread_drawn = incoherent_spread(network, &turns);
            turn_along_rods(network, &mut projector, &turns, &mut state, stops)?;
        } else {
            projector.positions(&mut state.positions)?;
        }
        self.set_velocities(network, replica, &mut projector, &mut state)?;
        state.check(network)?;
        Ok(Started {
            angle_spread_drawn,
            angle_spread_reached: incoherent_spread(network, &state.positions),
            sum_of_squares: sum_of_squares(network, &state.velocities),
            discarded_draws: 0,
            state,
        })
    }

    /// Builds the state of replica 0, or, if random angles let squares overlap or cannot be brought
    /// onto the rods, that of the first replica in which all is well.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square, Start};
    /// // Open squares stand corner to corner, and large random turns let some of them overlap.
    /// let start = Start { angle_spread: 2.0, ..Start::default() };
    /// let network = Network::lattice(4, 4, 0.2, Square::default(), Edges::Open, start.angle)?;
    /// assert!(start.build_apart(&network)?.discarded_draws > 0);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// As [`build`](Start::build), and [`CrystalError::Overlap`], of the last of 200 draws.
    pub fn build_apart(&self, network: &Network) -> Result<Started> {
        self.build_apart_unless(network, &|| false)
    }

    /// Variant of [`build_apart`](Start::build_apart) that ends when `stops` says that the work
    /// must stop.
    ///
    /// # Errors
    /// As [`build_apart`](Start::build_apart), and [`CrystalError::Stopped`].
    pub fn build_apart_unless(
        &self,
        network: &Network,
        stops: &dyn Fn() -> bool,
    ) -> Result<Started> {
        let draws = if self.angle_spread > 0.0 {
            MOST_DRAWS
        } else {
            1
        };
        let mut replica = 0;
        loop {
            let started = self
                .build_unless(network, replica, stops)
                .and_then(|started| {
                    require_apart(network, &started.state)?;
                    Ok(started)
                });
            match started {
                Err(CrystalError::Overlap { .. } | CrystalError::BadState(_))
                    if replica + 1 < draws =>
                {
                    replica += 1;
                }
                Ok(started) => {
                    return Ok(Started {
                        discarded_draws: replica,
                        ..started
                    });
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Brings a state from elsewhere onto the rods. Velocities are those of the state, or drawn as for [`build`](Start::build).
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square, Start, State};
    /// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, 0.5)?;
    /// let mut state = State::coherent(&network, 0.5);
    /// state.positions[0] += 1e-6;
    /// let started = Start::default().build_from(&network, state, false)?;
    /// assert!((started.state.positions[2] - 0.5).abs() < 1e-6);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// As [`build`](Start::build), and those of [`State::check`].
    pub fn build_from(
        &self,
        network: &Network,
        mut state: State,
        has_velocities: bool,
    ) -> Result<Started> {
        network.check()?;
        self.check()?;
        state.check(network)?;
        let mut projector = Projector::new(network);
        projector.positions(&mut state.positions)?;
        if has_velocities {
            projector.velocities(&state.positions, &mut state.velocities)?;
        } else {
            self.set_velocities(network, 0, &mut projector, &mut state)?;
        }
        state.check(network)?;
        Ok(Started {
            angle_spread_drawn: 0.0,
            angle_spread_reached: incoherent_spread(network, &state.positions),
            sum_of_squares: sum_of_squares(network, &state.velocities),
            discarded_draws: 0,
            state,
        })
    }

    fn check(&self) -> Result<()> {
        require_finite("angle", self.angle)?;
        require_not_negative("angle_spread", self.angle_spread)?;
        match self.velocities {
            StartVelocities::Rest => {}
            StartVelocities::Checkerboard { rate } => require_finite("rate", rate)?,
            StartVelocities::Uniform { largest, .. } => require_positive("largest", largest)?,
            StartVelocities::Normal { rate, spread, .. } => {
                require_finite("rate", rate)?;
                require_not_negative("spread", spread)?;
            }
            StartVelocities::Thermal { kt } => require_not_negative("kt", kt)?,
        }
        match self.velocities.wanted_sum_of_squares() {
            Some(sum) => require_positive("sum_of_squares", sum),
            None => Ok(()),
        }
    }

    /// A normal turn for every square, as an array of x, y, θ per square.
    fn draw_turns(&self, network: &Network, replica: u32) -> Vec<f64> {
        let mut rng = CounterRng::for_purpose(self.seed, replica, 0, Purpose::LatticeAngles);
        let mut turns = vec![0.0; 3 * network.squares.len()];
        for turn in turns.chunks_exact_mut(3) {
            turn[2] = self.angle_spread * rng.normal();
        }
        turns
    }

    fn set_velocities(
        &self,
        network: &Network,
        replica: u32,
        projector: &mut Projector,
        state: &mut State,
    ) -> Result<()> {
        let mut rng = CounterRng::for_purpose(self.seed, replica, 0, Purpose::LatticeVelocities);
        match self.velocities {
            StartVelocities::Rest => return Ok(()),
            StartVelocities::Thermal { kt } => {
                let mut dynamics = Dynamics::new(Arc::new(network.clone()), Vec::new(), state)?;
                let bath = Langevin::new(kt, 0.0, self.seed, replica)?;
                bath.draw_velocities(&mut dynamics, state);
                return Ok(());
            }
            StartVelocities::Checkerboard { rate } => coherent_velocities(network, rate, state),
            StartVelocities::Uniform { largest, .. } => {
                for velocity in square_rates(network, &mut state.velocities) {
                    velocity[2] = rng.uniform_in(-largest, largest);
                }
            }
            StartVelocities::Normal { rate, spread, .. } => {
                if rate != 0.0 {
                    coherent_velocities(network, rate, state);
                }
                for velocity in square_rates(network, &mut state.velocities) {
                    velocity[2] += spread * rng.normal();
                }
            }
        }
        projector.velocities(&state.positions, &mut state.velocities)?;
        match self.velocities.wanted_sum_of_squares() {
            Some(wanted) => scale_to(network, wanted, &mut state.velocities),
            None => Ok(()),
        }
    }
}

impl StartVelocities {
    fn wanted_sum_of_squares(self) -> Option<f64> {
        match self {
            Self::Uniform { sum_of_squares, .. } | Self::Normal { sum_of_squares, .. } => {
                sum_of_squares
            }
            Self::Rest | Self::Checkerboard { .. } | Self::Thermal { .. } => None,
        }
    }
}

/// The velocities of the coherent motion at the coherent angle of this state, about the middle of
/// the lattice: ω = (-1)^(i+j) rate, and centres that follow the distance of neighbours, d = 2 l
/// cos(θ - π/4) + r0,
///
/// ẋ = (j - mean j) ḋ, ẏ = (mean i - i) ḋ, ḋ = -2 l sin(θ - π/4) rate.
///
/// The edges of a flexible cell follow as well.
pub fn coherent_velocities(network: &Network, rate: f64, state: &mut State) {
    let [_, angle] = coherent_part(network, &state.positions);
    let opening = -2.0 * network.first_half_diagonal() * (angle - FRAC_PI_4).sin() * rate;
    for (p, velocity) in square_rates(network, &mut state.velocities).enumerate() {
        let [right, up] = from_middle(network, p);
        velocity[0] = right * opening;
        velocity[1] = up * opening;
        velocity[2] = network.sign(p) * rate;
    }
    if let Some(place) = network.cell_place() {
        let edges = [network.columns as f64, network.rows as f64, 0.0];
        for (velocity, squares) in state.velocities[place..].iter_mut().zip(edges) {
            *velocity = squares * opening;
        }
    }
}

/// Turns the squares by small parts of the turns, each followed by a projection onto the rods: what
/// the rods forbid is lost on the way, and the rest arrives.
fn turn_along_rods(
    network: &Network,
    projector: &mut Projector,
    turns: &[f64],
    state: &mut State,
    stops: &dyn Fn() -> bool,
) -> Result<()> {
    let mut shortest = 1.0_f64;
    for rod in &network.rods {
        shortest = shortest.min(rod.length);
    }
    let steps = largest_magnitude(turns) / (TURN_PER_STEP * shortest);
    let steps = steps.ceil().max(1.0);
    for _ in 0..steps as usize {
        if stops() {
            return Err(CrystalError::Stopped);
        }
        let positions = state.positions.chunks_exact_mut(3);
        for (position, turn) in positions.zip(turns.chunks_exact(3)) {
            position[2] += turn[2] / steps;
        }
        projector.positions(&mut state.positions)?;
    }
    Ok(())
}

fn require_apart(network: &Network, state: &State) -> Result<()> {
    let detector = Detector::new(network, &state.positions, rods_block_by_default(network));
    detector.check_no_overlap(network, &state.positions, state.time)
}

fn scale_to(network: &Network, wanted: f64, velocities: &mut [f64]) -> Result<()> {
    let factor = (wanted / sum_of_squares(network, velocities)).sqrt();
    if !factor.is_finite() {
        return Err(CrystalError::BadState(
            "the squares do not turn, so Σ ω² cannot be scaled; give the velocities a spread or \
             rate"
                .into(),
        ));
    }
    for velocity in velocities {
        *velocity *= factor;
    }
    Ok(())
}

/// Σ ω².
fn sum_of_squares(network: &Network, velocities: &[f64]) -> f64 {
    let spins = angles(velocities).take(network.squares.len());
    spins.map(|omega| omega * omega).sum()
}

/// ẋ, ẏ, ω of every square, without a flexible cell.
fn square_rates<'a>(
    network: &Network,
    velocities: &'a mut [f64],
) -> impl Iterator<Item = &'a mut [f64]> {
    velocities.chunks_exact_mut(3).take(network.squares.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Corner, Dynamics, Edges, Rod, Square};
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
            let moved: Vec<f64> = state
                .positions
                .iter()
                .zip(&state.velocities)
                .map(|(s, v)| s + time * v)
                .collect();
            let corner = |corner: Corner| {
                let angle = moved[3 * corner.square + 2]
                    + [135.0_f64, 45.0, 225.0, -45.0][usize::from(corner.vertex) - 1].to_radians();
                [
                    moved[3 * corner.square] + angle.cos(),
                    moved[3 * corner.square + 1] + angle.sin(),
                ]
            };
            let length = |rod: &Rod| {
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
                velocities: StartVelocities::Checkerboard { rate: 0.7 },
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
            let velocities = StartVelocities::Uniform {
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
                velocities: StartVelocities::Uniform {
                    largest: 0.0,
                    sum_of_squares: None,
                },
                ..Start::default()
            },
            Start {
                velocities: StartVelocities::Normal {
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
