//! `protomer scattering`: what light and X-rays see.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_protein_verbs::scattering::{ExperimentSettings, ScatteringSettings, scattering};
use protomer_protein_verbs::stability::DEFAULT_CONTACT_GAP_ANGSTROM;
use std::path::PathBuf;

/// Compute the scattering of light and X-rays by an assembly or by the trajectories of a run:
/// cluster sizes, hydrodynamic radii as dynamic light scattering averages them, S(q) of the
/// centres, P(q) of the bodies and I(q) of the whole.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "scattering stability -o scattering",
    "scattering ring.json --q-max 0.2 --json"
))]
#[group(id = "ScatteringResult")]
pub struct ScatteringArgs {
    /// Assembly file, or directory of a simulation or a sweep.
    input: PathBuf,
    /// Directory for tables (CSV), JSON and figure.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Only this salt concentration of a sweep, such as 100mM.
    #[arg(long, value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    salt: Option<f64>,
    /// Assembly file of a run, if it has moved.
    #[arg(long)]
    assembly: Option<PathBuf>,
    /// Share of the frames at the beginning of each trajectory that is left out.
    #[arg(long, default_value_t = 0.2, value_parser = range::SHARE.number())]
    skip: f64,
    /// Frames of each trajectory that are measured at most, evenly spread.
    #[arg(long, default_value_t = 100, value_parser = range::OBJECTS.number::<usize>())]
    most_frames: usize,
    /// Largest wave number, Å⁻¹.
    #[arg(long, default_value_t = 0.3, value_parser = range::WAVE_NUMBER.number())]
    q_max: f64,
    /// Number of wave numbers.
    #[arg(long, default_value_t = 60, value_parser = range::TABLE_ROWS.number::<usize>())]
    q_points: usize,
    /// Directions of the wave vector for each wave number and frame, at most.
    #[arg(long, default_value_t = 24, value_parser = range::DIRECTIONS.number::<usize>())]
    directions: usize,
    /// Wave number of the dynamic light scattering, Å⁻¹ [default: 0.00264, red light at 173° in water].
    #[arg(long, value_parser = range::WAVE_NUMBER.number())]
    light_q: Option<f64>,
    /// Thickness of the water that moves with a body, Å.
    #[arg(long, default_value_t = 1.1)]
    hydration: f64,
    #[arg(long, help = format!("Surfaces closer than this are in contact, Å [default: that of the run, or {DEFAULT_CONTACT_GAP_ANGSTROM}]"), value_parser = range::CONTACT_GAP.number())]
    contact_gap: Option<f64>,
    /// Seed of the random directions.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl ScatteringArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let defaults = ExperimentSettings::default();
        let settings = ScatteringSettings {
            input: self.input.clone(),
            salt_molar: self.salt,
            assembly: self.assembly.clone(),
            skip: self.skip,
            most_frames: self.most_frames,
            contact_gap_angstrom: self.contact_gap,
            experiment: ExperimentSettings {
                largest_q_per_angstrom: self.q_max,
                wave_numbers: self.q_points,
                directions: self.directions,
                contact_gap_angstrom: self.contact_gap.unwrap_or(defaults.contact_gap_angstrom),
                hydration_angstrom: self.hydration,
                light_q_per_angstrom: self.light_q.unwrap_or(defaults.light_q_per_angstrom),
                seed: self.seed,
            },
            output: self.output.clone(),
            force: front.force(),
        };
        let report = scattering(&settings, front.progress().as_ref())?;
        let warnings = report.warnings.clone();
        let reply = Reply::from_answer(report).with_notes(warnings);
        Ok(match &self.output {
            Some(directory) => {
                let figure = directory.join("scattering.png");
                reply.with_note(format!("figure: {}", figure.display()))
            }
            None => reply,
        })
    }
}
