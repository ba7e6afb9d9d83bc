//! The settings of a run: the resolved configuration, as stored in `run.toml`.

use anyhow::Result;
use protomer_crystal::analysis::lyapunov::LyapunovSettings;
use protomer_crystal::lattice::pair::SquareCharge;
use protomer_crystal::lattice::paper::PaperSettings;
use protomer_crystal::lattice::{
    self, Charges, CollisionSettings, Edges, Langevin, Meetings, Motion, Plan, Square,
    StartVelocities,
};
pub use protomer_crystal::lattice::{ListedRod, OtherSquare, Screening};
use protomer_results::Settings;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;

/// Settings of a run. They contain everything that can change a result, and nothing else. Reduced
/// units: the half-diagonal of a square is 1, its mass is 1.
///
/// ```
/// use protomer_lattices::lattice::settings::LatticeSettings;
/// let settings = LatticeSettings { rows: 4, columns: 6, kappa: 0.5, ..LatticeSettings::default() };
/// settings.check()?;
/// assert!(LatticeSettings { r0: 0.0, ..settings }.check().is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LatticeSettings {
    /// Number of rows of squares.
    pub rows: usize,
    /// Number of columns of squares.
    pub columns: usize,
    /// Length of the rods, r0.
    pub r0: f64,
    /// κ of the coherence potential, an inverse time squared.
    pub kappa: f64,
    /// The boundary condition.
    pub edges: Edges,
    /// The orientation of the squares at the start.
    pub start: Start,
    /// Standard deviation of random angles added to the start; short rods allow less.
    pub angle_spread: f64,
    /// The velocities at the start.
    pub velocities: Velocities,
    /// Initial angular velocity: that of every square (checkerboard), or the largest drawn
    /// (random).
    pub speed: f64,
    /// Standard deviation of random numbers added to the angular velocities of a checkerboard
    /// start; all velocities are then scaled so that the mean of ω² stays that of the speed.
    #[serde(skip_serializing_if = "is_zero")]
    pub velocity_spread: f64,
    /// Time up to which to run.
    pub time: f64,
    /// Number of steps up to which to run, instead of a time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<u64>,
    /// Time step.
    pub time_step: TimeStep,
    /// Whether squares are impenetrable.
    pub collisions: bool,
    /// Coefficient of restitution of the collisions: 1 is elastic.
    pub restitution: f64,
    /// Whether to use the collisions of the paper (one mean collision time per step, equalities)
    /// instead of one event after another.
    pub paper: bool,
    /// Temperature kT of a heat bath, in units of mass times (half-diagonal per time)²; needs a
    /// friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<f64>,
    /// Friction, an inverse time. Without a temperature it only slows the squares down.
    pub friction: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Steps between two rows of the log.
    pub log_every: u64,
    /// Steps between two frames of the trajectory; zero for no trajectory.
    pub trajectory_every: u64,
    /// Length of one reduced unit in Å, where the lattice represents real bodies; only
    /// screened charges need it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_diagonal_angstrom: Option<f64>,
    /// Missing squares, whose rods are missing too: row and column, counted from 0 at the upper
    /// left.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed_squares: Vec<[usize; 2]>,
    /// Missing rods: row, column and vertex of each end.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed_rods: Vec<[usize; 3]>,
    /// The square.
    pub square: Square,
    /// Squares that differ from `square`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub other_squares: Vec<OtherSquare>,
    /// The rods, if they differ from those of the lattice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rods: Option<Vec<ListedRod>>,
    /// Charges on every square, which act if there is a `screening`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub charges: Vec<SquareCharge>,
    /// Interaction of the charges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub screening: Option<Screening>,
    /// The parameters that a sweep varies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepAxes>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Orientation of the squares at the start, θ = ± an angle, which has a name or is given in
/// radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "start is 'open', 'closed', or the angle of the squares in radians"
)]
pub enum Start {
    /// A named state: open or closed.
    Named(NamedStart),
    /// An angle in radians.
    Angle(f64),
}

/// The two ends of the coherent motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NamedStart {
    /// θ = ± π/4: the squares stand corner to corner.
    Open,
    /// θ = 0: the squares stand side to side, as far apart as the rods are long.
    Closed,
}

impl Start {
    /// Angle of the start, radians.
    pub fn angle_rad(self) -> f64 {
        match self {
            Start::Named(NamedStart::Open) => FRAC_PI_4,
            Start::Named(NamedStart::Closed) => 0.0,
            Start::Angle(angle) => angle,
        }
    }
}

/// Parses `open`, `closed` or an angle in radians.
impl std::str::FromStr for Start {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "open" => Ok(Start::Named(NamedStart::Open)),
            "closed" => Ok(Start::Named(NamedStart::Closed)),
            _ => match text.parse::<f64>() {
                Ok(angle) if angle.is_finite() => Ok(Start::Angle(angle)),
                _ => Err("give open, closed, or an angle in radians such as 0.3".into()),
            },
        }
    }
}

/// The initial velocities, projected onto those that the rods allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Velocities {
    /// Every square turns against its neighbours, ω = ±(-1)^(i+j) speed: from the open state it
    /// closes, from any other it opens.
    Checkerboard,
    /// Every ω drawn evenly from -speed to speed.
    Random,
    /// All velocities are zero.
    Rest,
    /// Thermal velocities at the temperature of the heat bath.
    Thermal,
}

/// A time step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "time_step is 'auto' or a number")]
pub enum TimeStep {
    /// An automatic step.
    Named(NamedTimeStep),
    /// An explicit step.
    Fixed(f64),
}

/// An automatic time step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NamedTimeStep {
    /// A step that is short enough for the fastest-turning rod.
    Auto,
}

impl TimeStep {
    /// The automatic step.
    pub const AUTO: Self = TimeStep::Named(NamedTimeStep::Auto);
}

/// Parses `auto` or a number.
impl std::str::FromStr for TimeStep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse::<f64>()) {
            ("auto", _) => Ok(Self::AUTO),
            (_, Ok(step)) if step.is_finite() => Ok(TimeStep::Fixed(step)),
            _ => Err("give auto, or a number such as 1e-3".into()),
        }
    }
}

/// The parameters that a sweep varies: every r0 with every κ, once per seed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepAxes {
    /// Rod lengths; if empty, that of the settings.
    pub r0: Vec<f64>,
    /// Values of κ; if empty, that of the settings.
    pub kappa: Vec<f64>,
    /// Seeds; if empty, that of the settings.
    pub seeds: Vec<u64>,
    /// Measurement of the Lyapunov exponent of every run; if omitted, it is not measured. The seed
    /// of a run is added to the seed here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lyapunov: Option<LyapunovSettings>,
}

impl Default for LatticeSettings {
    fn default() -> Self {
        Self {
            rows: 10,
            columns: 10,
            r0: 3.0 / 22.0,
            kappa: 0.0,
            edges: Edges::Open,
            start: Start::Named(NamedStart::Open),
            angle_spread: 0.0,
            velocities: Velocities::Checkerboard,
            speed: 1.0,
            velocity_spread: 0.0,
            time: 10.0,
            steps: None,
            time_step: TimeStep::AUTO,
            collisions: true,
            restitution: 1.0,
            paper: false,
            temperature: None,
            friction: 0.0,
            seed: 1,
            log_every: 10,
            trajectory_every: 50,
            half_diagonal_angstrom: None,
            removed_squares: Vec::new(),
            removed_rods: Vec::new(),
            square: Square::default(),
            other_squares: Vec::new(),
            rods: None,
            charges: Vec::new(),
            screening: None,
            sweep: None,
        }
    }
}

impl Settings for LatticeSettings {
    /// Excludes the length: a run can be continued to a later time.
    fn essential(&self) -> Self {
        Self {
            time: 0.0,
            steps: None,
            ..self.clone()
        }
    }
}

impl LatticeSettings {
    /// Whether the motion conserves the energy: nothing brakes it, and collisions are elastic.
    pub fn conserves_energy(&self) -> bool {
        self.friction == 0.0 && self.restitution == 1.0 && !self.paper
    }

    /// The lattice and its defects.
    pub fn plan(&self) -> Plan {
        Plan {
            rows: self.rows,
            columns: self.columns,
            rod_length: self.r0,
            edges: self.edges,
            angle: self.start.angle_rad(),
            square: self.square,
            other_squares: self.other_squares.clone(),
            rods: self.rods.clone(),
            removed_rods: self.removed_rods.clone(),
            removed_squares: self.removed_squares.clone(),
        }
    }

    /// The first state.
    pub fn first_state(&self) -> lattice::Start {
        lattice::Start {
            angle: self.start.angle_rad(),
            angle_spread: self.angle_spread,
            velocities: self.start_velocities(),
            seed: self.seed,
        }
    }

    fn start_velocities(&self) -> StartVelocities {
        match self.velocities {
            Velocities::Rest => StartVelocities::Rest,
            Velocities::Thermal => StartVelocities::Thermal {
                kt: self.temperature.unwrap_or(0.0),
            },
            Velocities::Random if self.speed > 0.0 => StartVelocities::Uniform {
                largest: self.speed,
                sum_of_squares: None,
            },
            Velocities::Random => StartVelocities::Rest,
            Velocities::Checkerboard => self.checkerboard_velocities(),
        }
    }

    fn checkerboard_velocities(&self) -> StartVelocities {
        let is_open = (self.start.angle_rad() - FRAC_PI_4).abs() < 1e-9;
        let rate = if is_open { -self.speed } else { self.speed };
        if self.velocity_spread == 0.0 {
            return StartVelocities::Checkerboard { rate };
        }
        let removed: BTreeSet<_> = self.removed_squares.iter().collect();
        let squares = (self.rows * self.columns).saturating_sub(removed.len());
        let sum_of_squares = squares as f64 * self.speed * self.speed;
        StartVelocities::Normal {
            rate,
            spread: self.velocity_spread,
            sum_of_squares: (sum_of_squares > 0.0).then_some(sum_of_squares),
        }
    }

    /// The integrator of the squares.
    ///
    /// # Errors
    /// For a negative or non-finite temperature or friction.
    pub fn motion(&self) -> Result<Motion> {
        let kt = self.temperature.unwrap_or(0.0);
        let bath = Langevin::new(kt, self.friction, self.seed, 0)?;
        Ok(Motion {
            kappa: self.kappa,
            charges: self.screened_charges(),
            meeting: self.meetings(),
            bath: (self.friction > 0.0).then_some(bath),
        })
    }

    fn screened_charges(&self) -> Option<Charges> {
        Some(Charges {
            on_square: self.charges.clone(),
            screening: self.screening?,
            scale_angstrom: self.half_diagonal_angstrom?,
        })
    }

    fn meetings(&self) -> Meetings {
        if self.paper {
            Meetings::Paper(PaperSettings::default())
        } else if self.collisions {
            Meetings::Collisions(CollisionSettings {
                restitution: self.restitution,
                ..CollisionSettings::default()
            })
        } else {
            Meetings::Ignored
        }
    }
}
