//! The settings of a run: the resolved configuration, as stored in `run.toml`.

use super::limits::{ENERGY, KAPPA, MASS, RATE, ROD_LENGTH, STRESS, TIME, TIME_STEP};
use super::potential_table::PotentialTable;
use anyhow::{Context, Result};
use protomer_common::range::{Range, STEPS};
use protomer_common::settings::{Holds, is_default};
use protomer_kernel::setting::{Choices, Kind, Setting};
use protomer_kernel::spline::Spline;
use protomer_linkage::analysis::lyapunov::LyapunovSettings;
use protomer_linkage::lattice::pair::SquareCharge;
use protomer_linkage::lattice::paper::PaperSettings;
use protomer_linkage::lattice::{
    self, CellKind, Charges, CollisionSettings, Edges, Langevin, Meetings, Motion, Plan, Square,
    StartVelocities, Stress,
};
pub use protomer_linkage::lattice::{ListedRod, OtherSquare, Screening};
use protomer_results::Settings;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_4, PI};

protomer_common::settings! {
    /// Settings of a run. They contain everything that can change a result, and nothing else. Reduced
    /// units: the half-diagonal of a square is 1, its mass is 1.
    ///
    /// ```
    /// use protomer_linkage_verbs::lattice::settings::LatticeSettings;
    /// let settings = LatticeSettings { rows: 4, columns: 6, kappa: 0.5, ..LatticeSettings::default() };
    /// settings.check()?;
    /// assert!(LatticeSettings { r0: 0.0, ..settings }.check().is_err());
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub struct LatticeSettings {
        /// Rows of squares.
        rows: usize = 10_usize;
        /// Columns of squares.
        columns: usize = 10_usize;
        /// Length of the rods; the half-diagonal of a square is 1.
        r0: f64 = 3.0 / 22.0, in ROD_LENGTH, otherwise "3/22";
        /// κ of the potential that favours coherent motion of the squares, an inverse time squared.
        kappa: f64 = 0.0, in KAPPA;
        /// Boundary condition.
        edges: Edges = Edges::Open;
        /// Whether the cell of periodic edges can change; rods, collisions and stress then strain it.
        cell: CellKind = CellKind::Fixed, omit "is_default";
        /// Mass of each component of a flexible cell.
        cell_mass: Option<f64>, in MASS, otherwise "a tenth of the mass of all squares", omit "is_default";
        /// State to start from instead of a coherent lattice: a GSD file of any program, whose first particles are the squares,
        /// or the directory of a run, whose velocities are kept.
        state: Option<String>, otherwise "a coherent lattice", omit "is_default";
        /// Frame of the GSD file to start from, counted from 0.
        frame: Option<u64>, in STEPS, otherwise "the last", omit "is_default";
        /// Orientation at the start: open, closed, or an angle in radians.
        start: Start = Start::Named(NamedStart::Open), in Range::new(-PI, PI, "rad");
        /// Standard deviation of random angles added to the start, radians; short rods allow less.
        angle_spread: f64 = 0.0, in Range::new(0.0, PI, "rad");
        /// Velocities at the start.
        velocities: Velocities = Velocities::Checkerboard;
        /// Angular velocity of every square (checkerboard), or the largest drawn (random).
        speed: f64 = 1.0, in RATE;
        /// Standard deviation of random numbers added to the angular velocities of a checkerboard start;
        /// all velocities are then scaled so that the mean of ω² stays that of the speed.
        velocity_spread: f64 = 0.0, in RATE, omit "is_default";
        /// Run to this time.
        time: f64 = 10.0, in TIME;
        /// Run to this many steps instead.
        steps: Option<u64>, in STEPS, omit "is_default";
        /// Time step: auto, or a number.
        time_step: TimeStep = TimeStep::AUTO, in TIME_STEP, flag "dt", value "TIME_STEP";
        /// Whether squares are impenetrable.
        collisions: bool = true, off "Let squares pass through each other";
        /// Coefficient of restitution: 1 is elastic.
        restitution: f64 = 1.0, in Range::new(0.0, 1.0, "(0: no rebound, 1: elastic)");
        /// Collide as the paper does, with one mean collision time per step, instead of one event after
        /// another.
        paper: bool;
        /// kT of a heat bath, in units of mass times (half-diagonal per time)²; needs --friction.
        temperature: Option<f64>, in ENERGY.or_zero(), omit "is_default";
        /// Friction, an inverse time; without a temperature it only slows the squares down.
        friction: f64 = 0.0, in RATE;
        /// Stress along x, an energy per area in reduced units; positive pulls. Open edges or a flexible cell.
        stress_xx: f64 = 0.0, in STRESS, omit "is_default";
        /// Stress along y.
        stress_yy: f64 = 0.0, in STRESS, omit "is_default";
        /// Seed of the random numbers.
        seed: u64 = 1_u64;
        /// Steps between rows of the log.
        log_every: u64 = 10_u64, in STEPS.at_least(1);
        /// Steps between frames of the trajectory; 0 for none.
        trajectory_every: u64 = 50_u64, in STEPS;
        /// Length of one reduced unit in Å, where the lattice represents real bodies; only
        /// screened charges need it.
        half_diagonal_angstrom: Option<f64>, omit "is_default", from file;
        /// Missing squares, whose rods are missing too: row and column, counted from 0 at the upper
        /// left.
        removed_squares: Vec<[usize; 2]>, omit "is_default", from file;
        /// Missing rods: row, column and vertex of each end.
        removed_rods: Vec<[usize; 3]>, omit "is_default", from file;
        /// Square.
        square: Square, from file;
        /// Squares that differ from `square`.
        other_squares: Vec<OtherSquare>, omit "is_default", from file;
        /// Rods, if they differ from those of the lattice.
        rods: Option<Vec<ListedRod>>, omit "is_default", from file;
        /// Charges on every square, which act if there is a `screening`.
        charges: Vec<SquareCharge>, omit "is_default", from file;
        /// Potential of the opening (-1)^(i+j) (θ - θ') of every joint: 0 and π where closed, π/2 where open.
        angle_potential: Option<PotentialTable>, omit "is_default", from file;
        /// Potential per square of the opening of the whole crystal: 0 and π/2 where closed, π/4 where open.
        opening_potential: Option<PotentialTable>, omit "is_default", from file;
        /// Interaction of the charges.
        screening: Option<Screening>, omit "is_default", from file;
        /// Parameters that a sweep varies.
        sweep: Option<SweepAxes>, omit "is_default", from file;
    }
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

protomer_kernel::choices! {
    /// Ends of the coherent motion.
    pub enum NamedStart {
        /// θ = ± π/4: the squares stand corner to corner.
        Open = "open",
        /// θ = 0: the squares stand side to side, as far apart as the rods are long.
        Closed = "closed",
    }
}

impl Start {
    /// Angle of the start, radians.
    ///
    /// ```
    /// use protomer_linkage_verbs::lattice::settings::{NamedStart, Start};
    /// assert_eq!(Start::Named(NamedStart::Open).angle_rad(), std::f64::consts::FRAC_PI_4);
    /// assert_eq!(Start::Angle(0.3).angle_rad(), 0.3);
    /// ```
    pub fn angle_rad(self) -> f64 {
        match self {
            Start::Named(NamedStart::Open) => FRAC_PI_4,
            Start::Named(NamedStart::Closed) => 0.0,
            Start::Angle(angle) => angle,
        }
    }
}

protomer_kernel::choices! {
    /// Velocities at the start, projected onto those that the rods allow.
    pub enum Velocities {
        /// Every square turns against its neighbours, ω = ±(-1)^(i+j) speed: from the open state it
        /// closes, from any other it opens.
        Checkerboard = "checkerboard",
        /// Every ω drawn evenly from -speed to speed.
        Random = "random",
        /// All velocities are zero.
        Rest = "rest",
        /// Thermal velocities at the temperature of the heat bath.
        Thermal = "thermal",
    }
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

protomer_kernel::choices! {
    /// Automatic time step.
    pub enum NamedTimeStep {
        /// A step that is short enough for the fastest-turning rod.
        Auto = "auto",
    }
}

impl TimeStep {
    /// The automatic step.
    pub const AUTO: Self = TimeStep::Named(NamedTimeStep::Auto);
}

/// Makes a setting of an enum with a name and a number; the words say how to write it.
macro_rules! name_or_number {
    ($setting:ident: $name:ident, $number:ident, $words:literal) => {
        impl std::str::FromStr for $setting {
            type Err = String;

            fn from_str(text: &str) -> Result<Self, String> {
                match (Choices::from_name(text), text.parse::<f64>()) {
                    (Some(name), _) => Ok(Self::$name(name)),
                    (None, Ok(number)) if number.is_finite() => Ok(Self::$number(number)),
                    _ => Err($words.into()),
                }
            }
        }

        impl Setting for $setting {
            const KIND: Kind = Kind::NameOrNumber(|text| text.parse().map(|_: Self| ()));

            fn text(&self) -> Option<String> {
                match self {
                    Self::$name(name) => name.text(),
                    Self::$number(number) => number.text(),
                }
            }
        }

        impl Holds<$setting> for Range {
            fn require_setting(&self, key: &str, setting: &$setting) -> Result<()> {
                match setting {
                    $setting::$name(_) => Ok(()),
                    $setting::$number(number) => self.require(key, *number),
                }
            }
        }
    };
}

name_or_number!(Start: Named, Angle, "give open, closed, or an angle in radians such as 0.3");
name_or_number!(TimeStep: Named, Fixed, "give auto, or a number such as 1e-3");

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
    /// Phases are locked while all differences of (-1)^(i+j) θ are below this angle, rad; 0.5 if
    /// left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub locked_within: Option<f64>,
    /// Measurement of the Lyapunov exponent of every run; if omitted, it is not measured. The seed
    /// of a run is added to the seed here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lyapunov: Option<LyapunovSettings>,
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
            cell: self.cell,
            cell_mass: self.cell_mass,
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
    /// For a negative or non-finite temperature or friction, and tables of potentials that are none.
    pub fn motion(&self) -> Result<Motion> {
        let kt = self.temperature.unwrap_or(0.0);
        let bath = Langevin::new(kt, self.friction, self.seed, 0)?;
        Ok(Motion {
            kappa: self.kappa,
            charges: self.screened_charges(),
            angle_potential: self.potential("angle_potential", &self.angle_potential)?,
            opening_potential: self.potential("opening_potential", &self.opening_potential)?,
            stress: Stress {
                xx: self.stress_xx,
                yy: self.stress_yy,
            },
            meeting: self.meetings(),
            bath: (self.friction > 0.0).then_some(bath),
        })
    }

    /// kT in reduced units, of the heat bath or else of the screened charges.
    pub fn kt(&self) -> Option<f64> {
        let of_charges = self.screening.map(|screening| screening.kt);
        self.temperature.filter(|kt| *kt > 0.0).or(of_charges)
    }

    fn potential(&self, key: &str, table: &Option<PotentialTable>) -> Result<Option<Spline>> {
        let Some(table) = table else {
            return Ok(None);
        };
        let spline = table.spline(self.kt());
        Ok(Some(spline.with_context(|| key.to_owned())?))
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
