//! Values that the settings of a lattice may have.
//!
//! Ranges are wide: they hold every lattice that makes sense and end where the arithmetic would.

use super::settings::{LatticeSettings, OtherSquare, Screening, TimeStep, Velocities};
use anyhow::{Result, bail};
use protomer_common::range::Range;
use protomer_common::settings::Declared;
use protomer_linkage::analysis::lyapunov::LyapunovSettings;
use protomer_linkage::lattice::pair::SquareCharge;
use protomer_linkage::lattice::{CellKind, Edges, Square};

/// Upper limit for the number of squares, beyond any practical run.
pub(super) const MOST_SQUARES: usize = 1_000_000;
/// Upper limit for the number of steps, beyond any practical run.
pub(super) const MOST_STEPS: u64 = 1_000_000_000_000;
/// Upper limit for the number of intervals of a Lyapunov exponent.
const MOST_INTERVALS: usize = 10_000_000;

/// Range of lengths in half-diagonals of the unit square.
pub(super) const LENGTH: Range = Range::new(1e-4, 1e3, "");
/// Range of the lengths of rods.
pub(super) const ROD_LENGTH: Range =
    Range::new(1e-4, 1e3, "(a rod without length has no direction)");
/// Range of masses in masses of the unit square.
pub(super) const MASS: Range = Range::new(1e-6, 1e6, "");
/// Range of moments of inertia.
pub(super) const INERTIA: Range = Range::new(1e-9, 1e9, "");
/// Range of angular velocities and friction.
pub(super) const RATE: Range = Range::new(1e-6, 1e6, "").or_zero();
/// Range of κ of the coherence potential.
pub(super) const KAPPA: Range = Range::new(1e-12, 1e9, "").or_zero();
/// Range of times.
pub(super) const TIME: Range = Range::new(1e-9, 1e9, "").or_zero();
/// Range of time steps.
pub(super) const TIME_STEP: Range = Range::new(TIME_STEP_LEAST, 1.0, "");
/// The shortest time step.
pub(super) const TIME_STEP_LEAST: f64 = 1e-9;
/// Range of positions, angles and their rates in a file.
pub(super) const COORDINATE: Range = Range::new(-1e6, 1e6, "");
/// Range of kT.
pub(super) const ENERGY: Range = Range::new(1e-9, 1e6, "");
/// Range of stresses.
pub(super) const STRESS: Range = Range::new(-1e6, 1e6, "");
/// Range of lengths of proteins, and of the medium around them.
const ANGSTROMS: Range = Range::new(1e-2, 1e6, "Å");
/// Range of the charges of sites.
const CHARGE: Range = Range::new(-1e4, 1e4, "e");
/// Range of the places of charges: on their square, or a little beyond.
const PLACE: Range = Range::new(-10.0, 10.0, "half-diagonals");

impl LatticeSettings {
    /// Checks everything that neither the types nor the engine check.
    ///
    /// # Errors
    /// Names the setting, its value and its range.
    ///
    /// ```
    /// use protomer_linkage_verbs::lattice::settings::LatticeSettings;
    /// let settings = LatticeSettings { angle_spread: 4.0, ..LatticeSettings::default() };
    /// let error = settings.check().unwrap_err();
    /// assert_eq!(error.to_string(), "angle_spread is 4; give 0 to 3.141592653589793 rad");
    /// ```
    pub fn check(&self) -> Result<()> {
        self.check_numbers()?;
        self.check_counts()?;
        self.check_squares_and_rods()?;
        self.check_charges()?;
        self.check_combinations()?;
        let locked_within = self.sweep.as_ref().and_then(|sweep| sweep.locked_within);
        if let Some(angle) = locked_within {
            Range::new(1e-6, 1e3, "rad").require("sweep.locked_within", angle)?;
        }
        let lyapunov = self.sweep.as_ref().and_then(|sweep| sweep.lyapunov);
        lyapunov.map_or(Ok(()), |lyapunov| self.check_lyapunov(&lyapunov))
    }

    fn check_numbers(&self) -> Result<()> {
        if self.r0 == 0.0 {
            bail!(
                "r0 is 0: a rod without length has no direction; give a small length such as 0.02, or see 'lattice' in \
                 the guide for the limit"
            );
        }
        self.check_ranges()
    }

    fn check_counts(&self) -> Result<()> {
        if self.rows.saturating_mul(self.columns) > MOST_SQUARES {
            bail!(
                "{} x {} squares are too many; ask for at most {MOST_SQUARES}",
                self.rows,
                self.columns
            );
        }
        if let TimeStep::Fixed(step) = self.time_step
            && self.time / step > MOST_STEPS as f64
        {
            bail!(
                "a time of {} in steps of {step} takes more than {MOST_STEPS} steps; give a larger time_step",
                self.time
            );
        }
        Ok(())
    }

    fn check_squares_and_rods(&self) -> Result<()> {
        let Square {
            half_diagonal,
            mass,
            inertia,
        } = self.square;
        LENGTH.require("square.half_diagonal", half_diagonal)?;
        MASS.require("square.mass", mass)?;
        INERTIA.require("square.inertia", inertia)?;
        for (index, square) in self.other_squares.iter().enumerate() {
            check_other_square(index, square)?;
        }
        for (index, rod) in self.rods.iter().flatten().enumerate() {
            if let Some(length) = rod.length {
                LENGTH.require(&format!("rods[{index}].length"), length)?;
            }
        }
        Ok(())
    }

    fn check_charges(&self) -> Result<()> {
        if let Some(scale) = self.half_diagonal_angstrom {
            ANGSTROMS.require("half_diagonal_angstrom", scale)?;
        }
        for (index, SquareCharge { position, charge }) in self.charges.iter().enumerate() {
            for place in position {
                PLACE.require(&format!("charges[{index}].position"), *place)?;
            }
            CHARGE.require(&format!("charges[{index}].charge"), *charge)?;
        }
        let Some(screening) = self.screening else {
            return Ok(());
        };
        if self.half_diagonal_angstrom.is_none() {
            bail!(
                "screened charges need a length scale; add half_diagonal_angstrom, the length of one unit in Å"
            );
        }
        if self.charges.is_empty() {
            bail!(
                "there is a [screening] but no charge; add [[charges]], as 'protomer lattice square' prints them, or \
                 remove [screening]"
            );
        }
        check_screening(&screening)
    }

    fn check_combinations(&self) -> Result<()> {
        if self.temperature.is_some() && self.friction == 0.0 {
            bail!("a heat bath needs friction; add friction = 1, or remove temperature");
        }
        if self.paper && (self.restitution != 1.0 || !self.collisions) {
            bail!(
                "the paper's collisions are elastic; remove restitution and collisions, or remove paper"
            );
        }
        // Tables that are none are refused here, and not by the run.
        self.motion()?;
        self.check_cell()?;
        if self.velocities == Velocities::Thermal && self.temperature.is_none() {
            bail!("thermal velocities need a temperature; add temperature = 0.1");
        }
        if self.velocity_spread > 0.0 && self.velocities != Velocities::Checkerboard {
            bail!(
                "velocity_spread perturbs a checkerboard start; remove it, or set velocities = \
                 \"checkerboard\""
            );
        }
        Ok(())
    }

    fn check_cell(&self) -> Result<()> {
        let is_flexible = self.cell == CellKind::Flexible;
        if is_flexible && self.edges == Edges::Open {
            bail!(
                "a lattice with open edges has no cell; give edges = \"periodic\", or remove cell"
            );
        }
        if is_flexible && self.paper {
            bail!("the paper's collisions have no flexible cell; remove cell, or remove paper");
        }
        if self.cell_mass.is_some() && !is_flexible {
            bail!(
                "cell_mass is that of a flexible cell; give cell = \"flexible\", or remove cell_mass"
            );
        }
        let has_stress = (self.stress_xx, self.stress_yy) != (0.0, 0.0);
        if has_stress && self.edges == Edges::Periodic && !is_flexible {
            bail!(
                "a stress cannot strain a periodic cell that is fixed; give cell = \"flexible\" or edges = \"open\", or \
                 remove stress_xx and stress_yy"
            );
        }
        Ok(())
    }

    fn check_lyapunov(&self, lyapunov: &LyapunovSettings) -> Result<()> {
        let LyapunovSettings {
            separation,
            interval,
            discarded,
            intervals,
            ..
        } = *lyapunov;
        Range::new(1e-12, 1e-2, "").require("lyapunov.separation", separation)?;
        Range::new(1e-6, 1e6, "").require("lyapunov.interval", interval)?;
        if !(1..=MOST_INTERVALS).contains(&intervals) {
            bail!("lyapunov.intervals is {intervals}; it must be from 1 to {MOST_INTERVALS}");
        }
        if discarded > MOST_INTERVALS {
            bail!("lyapunov.discarded is {discarded}; it must be at most {MOST_INTERVALS}");
        }
        if self.temperature.is_some() {
            bail!(
                "the Lyapunov exponent is defined for motion without noise; remove \
                 temperature or the exponent"
            );
        }
        Ok(())
    }
}

fn check_other_square(index: usize, square: &OtherSquare) -> Result<()> {
    for (key, range, value) in [
        ("half_diagonal", LENGTH, square.half_diagonal),
        ("mass", MASS, square.mass),
        ("inertia", INERTIA, square.inertia),
    ] {
        if let Some(value) = value {
            range.require(&format!("other_squares[{index}].{key}"), value)?;
        }
    }
    Ok(())
}

fn check_screening(screening: &Screening) -> Result<()> {
    for (key, value) in [
        (
            "screening.bjerrum_length_angstrom",
            screening.bjerrum_length_angstrom,
        ),
        (
            "screening.debye_length_angstrom",
            screening.debye_length_angstrom,
        ),
    ] {
        ANGSTROMS.require(key, value)?;
    }
    ENERGY.require("screening.kt", screening.kt)
}
