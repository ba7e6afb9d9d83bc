//! Flags of the bodies, their box and what is measured, shared by `run` and `sweep`.

use anyhow::{Result, bail};
use clap::Args;
use protomer_common::settings::Words;
use protomer_shape_verbs::given_state::is_state;
use protomer_shape_verbs::hard_bodies::placed::with_state;
use protomer_shape_verbs::hard_bodies::settings::{
    Freedom, Gravity, HardBodySettings, Pressure, parse_depletants,
};
use protomer_shape_verbs::hard_bodies::start::{FLUID, names_of_crystals, names_of_mixed_crystals};
use protomer_shape_verbs::potential_file::{read_field, read_potential};
use std::path::PathBuf;

/// Bodies, their box, and what is measured.
#[derive(Debug, Args)]
pub struct SystemArgs {
    /// File with points, or the name of a shape, as for `shape`; rod:LENGTH for rods on a line. Several joined
    /// by + are the convex pieces of one body. Give it several times for a mixture.
    #[arg(long, value_name = "FILE", required = true)]
    shape: Vec<String>,
    /// Relative number of bodies of each shape: once for each --shape [default: equal numbers].
    #[arg(long, value_name = "SHARE")]
    share: Vec<f64>,
    /// Radius of the ball, or disk, that rounds the shapes (Minkowski sum).
    #[arg(long, default_value_t = 0.0, value_name = "RADIUS")]
    rounding: f64,
    /// Standard deviation of the sizes of the bodies, relative to that of their shape; each body has its own size, at most
    /// three deviations away.
    #[arg(long, default_value_t = 0.0, value_name = "DEVIATION")]
    spread: f64,
    /// Trial exchanges of the places of two bodies of different kinds or sizes in a sweep.
    #[arg(long, default_value_t = 0, value_name = "NUMBER")]
    swaps: usize,
    /// Number of bodies [default: 216; those of a state].
    #[arg(long)]
    bodies: Option<usize>,
    #[arg(
        long,
        default_value = FLUID,
        value_name = "CRYSTAL",
        help = format!(
            "Initial arrangement of the bodies: {FLUID}, the name of a crystal ({}; with sites for two shapes {}), the file of a \
             unit cell, or a state: a GSD file of any program, or the directory of a run",
            names_of_crystals(&[3, 2, 1]),
            names_of_mixed_crystals(&[3, 2, 1])
        )
    )]
    start: String,
    /// Frame of the GSD file to start from, counted from 0 [default: the last].
    #[arg(long, value_name = "NUMBER")]
    frame: Option<u64>,
    /// Turn every body of a crystal first: degrees in a plane, a quaternion W,X,Y,Z in space.
    #[arg(long, value_delimiter = ',')]
    turn: Vec<f64>,
    /// Edges of the box of a fluid relative to each other, such as 1,1,4 [default: equal].
    #[arg(long = "box", value_delimiter = ',', value_name = "RATIOS")]
    box_ratios: Vec<f64>,
    /// Weight of a body, kT per length (the inverse of the gravitational length), between hard walls at
    /// both ends of the last axis.
    #[arg(long, value_name = "KT_PER_LENGTH")]
    gravity: Option<f64>,
    /// Energy of each body by its last coordinate, from the lower end of the box: a table with the columns height and
    /// energy_kt.
    #[arg(long, value_name = "FILE")]
    field: Option<PathBuf>,
    /// Energy of pairs of bodies in addition to their hardness: terms in a .toml file (square-well, radial, patches,
    /// charges), or a table with the columns distance and energy_kt.
    #[arg(long, value_name = "FILE")]
    potential: Option<PathBuf>,
    /// Penetrable hard spheres, or disks, in equilibrium with a reservoir: radius and number density in
    /// the reservoir, several with commas between them. With density 0 only free volumes are measured.
    #[arg(long, value_name = "RADIUS:FUGACITY,…", allow_hyphen_values = true)]
    depletants: Option<String>,
    /// Sweeps in which the steps are tuned and nothing is measured.
    #[arg(long, default_value_t = 2000, value_name = "SWEEPS")]
    equilibration: u64,
    /// Sweeps after the equilibration; a sweep is one trial move per body.
    #[arg(long, default_value_t = 10_000)]
    sweeps: u64,
    /// Sweeps between measurements.
    #[arg(long, default_value_t = 5, value_name = "SWEEPS")]
    sample_every: u64,
    /// Sweeps between frames of the trajectory; 0 for none.
    #[arg(long, default_value_t = 500, value_name = "SWEEPS")]
    trajectory_every: u64,
    /// Bodies inserted at random per measurement, for the chemical potential.
    #[arg(long, default_value_t = 0, value_name = "NUMBER")]
    insertions: usize,
    /// Points per measurement, for free volumes [default: ten per body].
    #[arg(long, value_name = "NUMBER")]
    points: Option<usize>,
}

/// Changes of the box at constant pressure.
#[derive(Debug, Args)]
pub struct BoxArgs {
    /// At constant pressure, trial changes of the box in a sweep [default: 4; 8 if triclinic].
    #[arg(long, value_name = "NUMBER")]
    box_moves: Option<u32>,
}

impl BoxArgs {
    /// A constant pressure with this freedom of the box.
    pub fn pressure(&self, kt_per_volume: f64, freedom: Freedom) -> Pressure {
        Pressure {
            kt_per_volume,
            freedom,
            changes_per_sweep: self.box_moves,
        }
    }

    /// Refuses what only means something at constant pressure.
    pub fn check(&self, has_pressure: bool) -> Result<()> {
        if self.box_moves.is_some() && !has_pressure {
            bail!("--box-moves is for a constant pressure; give a pressure too, or leave it out");
        }
        Ok(())
    }
}

/// Freedom of the box at constant pressure.
pub fn freedom(anisotropic: bool, triclinic: bool) -> Freedom {
    match (anisotropic, triclinic) {
        (_, true) => Freedom::Shape,
        (true, false) => Freedom::Lengths,
        (false, false) => Freedom::Volume,
    }
}

impl SystemArgs {
    /// Whether the bodies start where a file or a run has them.
    pub fn starts_from_state(&self) -> bool {
        is_state(&self.start)
    }

    /// The settings of a run, but for its pressure and seed. The packing fraction may be left out where the
    /// start is a state.
    pub fn settings(&self, packing_fraction: Option<f64>) -> Result<HardBodySettings> {
        let mut settings = self.settings_of_a_fluid()?;
        if self.starts_from_state() {
            return with_state(settings, self.bodies, packing_fraction);
        }
        if let Some(packing_fraction) = packing_fraction {
            settings.packing_fraction = packing_fraction;
        }
        Ok(settings)
    }

    fn settings_of_a_fluid(&self) -> Result<HardBodySettings> {
        let defaults = HardBodySettings::default();
        Ok(HardBodySettings {
            shape: Words(self.shape.clone()),
            share: self.share.clone(),
            rounding_radius: self.rounding,
            spread: self.spread,
            swaps: self.swaps,
            bodies: self.bodies.unwrap_or(defaults.bodies),
            equilibration: self.equilibration,
            sweeps: self.sweeps,
            sample_every: self.sample_every,
            trajectory_every: self.trajectory_every,
            insertions: self.insertions,
            points: self.points.unwrap_or(0),
            depletants: match &self.depletants {
                None => Vec::new(),
                Some(text) => parse_depletants(text)?,
            },
            start: self.start.clone(),
            frame: self.frame,
            turn: self.turn.clone(),
            box_ratios: self.box_ratios.clone(),
            field: self.field.as_deref().map(read_field).transpose()?,
            potential: match &self.potential {
                None => Vec::new(),
                Some(path) => read_potential(path)?,
            },
            gravity: self.gravity.map(|weight_kt_per_length| Gravity {
                weight_kt_per_length,
            }),
            ..defaults
        })
    }
}
