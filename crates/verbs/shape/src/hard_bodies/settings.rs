//! The settings of a run of hard bodies, as stored in `run.toml`.

use super::start::FLUID;
use crate::given_state::is_state;
use anyhow::{Context, Result, bail};
use protomer_common::range;
use protomer_common::settings::Words;
pub use protomer_hpmc::box_moves::{Freedom, Pressure};
pub use protomer_hpmc::field::{Gravity, HeightTable};
pub use protomer_hpmc::potential::Term;
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::simulation;
use protomer_kernel::Number;
use protomer_results::Settings;
use serde::{Deserialize, Serialize};

/// Settings of a run. They contain everything that can change a result. Lengths are in the unit of the
/// shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HardBodySettings {
    /// File or name of the shape; several for a mixture.
    pub shape: Words,
    /// Relative number of bodies of each shape; empty for equal numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub share: Vec<f64>,
    /// Standard deviation of the size of the bodies, relative to that of the shape.
    #[serde(skip_serializing_if = "is_zero")]
    pub spread: f64,
    /// Radius of the ball, or disk, that rounds the shape.
    pub rounding_radius: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// Part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Sweeps in which the steps are tuned and nothing is measured.
    pub equilibration: u64,
    /// Sweeps after the equilibration.
    pub sweeps: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Sweeps between two measurements.
    pub sample_every: u64,
    /// Sweeps between two frames of the trajectory; zero for no trajectory.
    pub trajectory_every: u64,
    /// Bodies inserted at random per measurement, for the chemical potential.
    pub insertions: usize,
    /// Points per measurement, for the free volume of each depletant; zero for ten per body.
    pub points: usize,
    /// Penetrable hard spheres, or disks, in equilibrium with a reservoir.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub depletants: Vec<Depletant>,
    /// `fluid`, the name of a crystal, the file of a unit cell, a GSD file, or the directory of a run.
    #[serde(skip_serializing_if = "is_fluid")]
    pub start: String,
    /// Frame of the GSD file in which the bodies start, counted from zero; `None` for the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u64>,
    /// Rotation of every body of a crystal in its own frame: degrees in a plane, a quaternion in
    /// space; empty for none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub turn: Vec<f64>,
    /// Edges of the box relative to each other; empty for equal ones, and for a crystal.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub box_ratios: Vec<f64>,
    /// A constant pressure, at which the box changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Pressure>,
    /// Gravity between hard walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
    /// Terms of the energy of each pair of bodies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub potential: Vec<Term>,
    /// Energy of each body by its last coordinate, from the lower end of the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<HeightTable>,
    /// Trial exchanges of the places of two bodies of different kinds in a sweep.
    #[serde(skip_serializing_if = "is_none")]
    pub swaps: usize,
}

impl Default for HardBodySettings {
    fn default() -> Self {
        Self {
            shape: Words::default(),
            share: Vec::new(),
            spread: 0.0,
            rounding_radius: 0.0,
            bodies: 216,
            packing_fraction: 0.3,
            equilibration: 2000,
            sweeps: 10_000,
            seed: 1,
            sample_every: 5,
            trajectory_every: 500,
            insertions: 0,
            points: 0,
            depletants: Vec::new(),
            start: FLUID.into(),
            frame: None,
            turn: Vec::new(),
            box_ratios: Vec::new(),
            pressure: None,
            gravity: None,
            potential: Vec::new(),
            field: None,
            swaps: 0,
        }
    }
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn is_none(number: &usize) -> bool {
    *number == 0
}

fn is_fluid(start: &str) -> bool {
    start == FLUID
}

impl Settings for HardBodySettings {
    /// Settings without the number of sweeps: more sweeps continue a run.
    fn essential(&self) -> Self {
        Self {
            sweeps: 0,
            ..self.clone()
        }
    }
}

/// Largest number of bodies: the numbers of bodies have 31 bits.
const MOST_BODIES: usize = 1 << 30;

/// Refuses a rounding radius that makes no body.
pub(super) fn check_rounding(radius: f64) -> Result<()> {
    if !(0.0..=1e30).contains(&radius) {
        bail!(
            "rounding_radius is {}; it must be from 0 to 1e30",
            Number(radius)
        );
    }
    Ok(())
}

/// Refuses a number of bodies that makes no box.
pub(super) fn check_bodies(bodies: usize) -> Result<()> {
    if !(1..=MOST_BODIES).contains(&bodies) {
        bail!("bodies is {bodies}; it must be from 1 to {MOST_BODIES}");
    }
    Ok(())
}

/// Refuses a packing fraction that makes no box.
pub(super) fn check_packing_fraction(packing_fraction: f64) -> Result<()> {
    if !(1e-15..1.0).contains(&packing_fraction) {
        bail!(
            "packing_fraction is {}; it must be between 0 and 1, and at least 1e-15",
            Number(packing_fraction)
        );
    }
    Ok(())
}

impl HardBodySettings {
    /// Checks what does not depend on the shape.
    ///
    /// # Errors
    /// Names the setting and what it can be.
    pub fn check(&self) -> Result<()> {
        check_packing_fraction(self.packing_fraction)?;
        check_bodies(self.bodies)?;
        check_rounding(self.rounding_radius)?;
        self.check_kinds()?;
        for ratio in &self.box_ratios {
            if !(1e-3..=1e3).contains(ratio) {
                bail!(
                    "box_ratios holds {}; each must be from 0.001 to 1000",
                    Number(*ratio)
                );
            }
        }
        if let Some(angle) = self
            .turn
            .iter()
            .find(|angle| !(-1e9..=1e9).contains(*angle))
        {
            bail!(
                "turn holds {}; each number must be from -1e9 to 1e9",
                Number(*angle)
            );
        }
        for (key, count) in [
            ("equilibration", self.equilibration),
            ("sweeps", self.sweeps),
            ("sample_every", self.sample_every),
            ("trajectory_every", self.trajectory_every),
        ] {
            range::STEPS.require(key, count)?;
        }
        for (key, count) in [("insertions", self.insertions), ("points", self.points)] {
            range::MOVES_OR_NONE.require(key, count as u64)?;
        }
        if self.sample_every == 0 {
            bail!("sample_every is 0; give the sweeps between two measurements");
        }
        if self.sweeps < self.sample_every {
            bail!(
                "{} sweeps are too few for a measurement every {}; give at least {}",
                self.sweeps,
                self.sample_every,
                self.sample_every
            );
        }
        let engine = simulation::Settings {
            pressure: self.pressure,
            gravity: self.gravity,
            field: self.field.clone(),
            swaps: self.swaps,
            ..simulation::Settings::default()
        };
        engine.check(&self.depletants)?;
        for (number, kind) in self.depletants.iter().enumerate() {
            kind.check()
                .with_context(|| format!("depletants {}", number + 1))?;
        }
        self.check_start()
    }

    /// Checks what belongs to bodies of several kinds only.
    fn check_kinds(&self) -> Result<()> {
        let (shapes, shares) = (self.shape.len(), self.share.len());
        if shares != 0 && shares != shapes {
            bail!("--shape: {shapes}, --share: {shares}; give a --share for each --shape, or none");
        }
        if let Some(share) = self
            .share
            .iter()
            .find(|share| !(1e-9..=1e9).contains(*share))
        {
            bail!(
                "share holds {}; each must be from 1e-9 to 1e9",
                Number(*share)
            );
        }
        if !(0.0..=0.3).contains(&self.spread) {
            bail!(
                "spread is {}; it must be from 0 to 0.3",
                Number(self.spread)
            );
        }
        let is_mixture = shapes > 1 || self.spread > 0.0;
        if self.swaps > 0 && !is_mixture {
            bail!(
                "--swaps is for bodies of different kinds; give several --shape or a --spread, or leave it out"
            );
        }
        if is_mixture && self.insertions > 0 {
            bail!("--insertions is for bodies of one kind; leave it out");
        }
        if self.spread > 0.0 && is_state(&self.start) {
            bail!("--spread gives bodies their sizes, and a state has its own; leave one out");
        }
        Ok(())
    }

    /// Checks what belongs to some starts only.
    pub(super) fn check_start(&self) -> Result<()> {
        let (is_fluid, is_state) = (is_fluid(&self.start), is_state(&self.start));
        if self.frame.is_some() && !is_state {
            bail!(
                "--frame is for a GSD file, and the start is {}; leave it out",
                self.start
            );
        }
        if is_state && !(self.turn.is_empty() && self.box_ratios.is_empty()) {
            bail!(
                "{} has its own box and its own orientations; leave --turn and --box out",
                self.start
            );
        }
        if is_state {
            return Ok(());
        }
        if is_fluid && !self.turn.is_empty() {
            bail!(
                "a turn is for crystals, and the start is a fluid; give a crystal or leave it out"
            );
        }
        if !is_fluid && !self.box_ratios.is_empty() {
            bail!("a crystal has the box of its cells; leave the ratios of the edges out");
        }
        if !is_fluid && self.gravity.is_some() {
            bail!("a crystal that fills the box has no room for walls; start from a fluid");
        }
        Ok(())
    }

    /// Points per measurement.
    pub(super) fn resolved_points(&self) -> usize {
        match self.points {
            0 => 10 * self.bodies,
            points => points,
        }
    }
}

/// Depletants as the command line gives them: `RADIUS:FUGACITY`, several with commas between them.
///
/// # Errors
/// Names the part that is not two numbers.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::settings::parse_depletants;
/// let kinds = parse_depletants("0.1:20,0.2:1.5")?;
/// assert_eq!((kinds[1].radius, kinds[1].fugacity), (0.2, 1.5));
/// assert!(parse_depletants("0.1").is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn parse_depletants(text: &str) -> Result<Vec<Depletant>> {
    let mut kinds = Vec::new();
    for part in text.split(',') {
        let numbers = part.trim().split_once(':').and_then(|(radius, fugacity)| {
            Some(Depletant {
                radius: radius.trim().parse().ok()?,
                fugacity: fugacity.trim().parse().ok()?,
            })
        });
        let Some(kind) = numbers else {
            bail!(
                "'{part}' is not RADIUS:FUGACITY; write the radius and the number density in the \
                 reservoir, such as 0.1:20"
            );
        };
        kind.check()?;
        kinds.push(kind);
    }
    Ok(kinds)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each number has a range, and the error names the setting, the value and the range.
    #[test]
    fn numbers_out_of_range_are_named_with_their_range() {
        let settings = HardBodySettings::default;
        let pressed = |kt_per_volume, changes_per_sweep| {
            Some(Pressure {
                kt_per_volume,
                freedom: Freedom::Volume,
                changes_per_sweep,
            })
        };
        let heavy = |weight_kt_per_length| {
            Some(Gravity {
                weight_kt_per_length,
            })
        };
        settings().check().unwrap();
        for (wrong, words) in [
            (
                HardBodySettings {
                    packing_fraction: 1e-308,
                    ..settings()
                },
                "packing_fraction is 1e-308",
            ),
            (
                HardBodySettings {
                    packing_fraction: f64::NAN,
                    ..settings()
                },
                "packing_fraction is NaN",
            ),
            (
                HardBodySettings {
                    equilibration: u64::MAX,
                    ..settings()
                },
                "equilibration is 18446744073709551615; give",
            ),
            (
                HardBodySettings {
                    insertions: usize::MAX,
                    ..settings()
                },
                "insertions is 18446744073709551615; give",
            ),
            (
                HardBodySettings {
                    bodies: 0,
                    ..settings()
                },
                "bodies is 0; it must be from 1",
            ),
            (
                HardBodySettings {
                    rounding_radius: 1e308,
                    ..settings()
                },
                "rounding_radius is 1e308",
            ),
            (
                HardBodySettings {
                    rounding_radius: -0.1,
                    ..settings()
                },
                "rounding_radius is -0.1",
            ),
            (
                HardBodySettings {
                    gravity: heavy(1e308),
                    ..settings()
                },
                "weight of a body (kT per length) is 1e308",
            ),
            (
                HardBodySettings {
                    pressure: pressed(1e308, None),
                    ..settings()
                },
                "pressure (kT per volume) is 1e308",
            ),
            (
                HardBodySettings {
                    pressure: pressed(1.0, Some(0)),
                    ..settings()
                },
                "from 1 to 10000",
            ),
            (
                HardBodySettings {
                    box_ratios: vec![1.0, 0.0],
                    ..settings()
                },
                "box_ratios holds 0",
            ),
            (
                HardBodySettings {
                    turn: vec![f64::INFINITY],
                    ..settings()
                },
                "turn holds inf",
            ),
        ] {
            let error = wrong.check().unwrap_err().to_string();
            let says_range = error.contains("must be") || error.contains("; give ");
            assert!(error.contains(words) && says_range, "{error}");
        }
    }
}
