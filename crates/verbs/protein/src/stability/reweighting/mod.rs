//! Curves over salt from the frames of a sweep at all salts together, between the salts that were
//! simulated and at other concentrations of bodies.
//!
//! | module | one idea |
//! |---|---|
//! | `samples` | the frames, what is measured of each, and its energy in every medium |
//! | `curves` | weighted averages with errors, and where they cross one half |
//! | `answer` | the answer: text, tables, figure |
//! | `page` | what the page of a sweep shows of it |

mod answer;
mod curves;
pub(crate) mod page;
mod samples;

pub use answer::{ConcentrationCurve, CurvePoint, HalfSaltEstimate, ReweightingResult};

use crate::scattering::{ScatteringSettings, Source};
use crate::stability::effective::EffectiveStore;
use crate::stability::energy_tables::EnergyTables;
use crate::stability::run::{EnergyMode, Engine, RunSettings, rounds_to, salt_label};
use crate::stability::sweep::half_salt::salt_between;
use crate::stability::sweep::result::SweepResult;
use answer::FILE;
use anyhow::{Context, Result, bail};
use curves::{Curves, Target};
use protomer_common::output_file::write_folder;
use protomer_common::page::millimolar;
use protomer_results::{Progress, ResultKind, keys};
use samples::Samples;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The folder in the directory of a sweep in which a report looks for the answer.
pub const FOLDER: &str = "reweighting";

/// Salts between two neighbours of the sweep, if none are named.
const BETWEEN_NEIGHBOURS: usize = 3;

/// Settings of [`reweighting()`].
#[derive(Debug, Clone)]
pub struct ReweightingSettings {
    /// The directory of a sweep over several salt concentrations.
    pub input: PathBuf,
    /// Salt concentrations of the curves, mol/L; if empty those of the sweep and three between
    /// neighbours.
    pub salt_molar: Vec<f64>,
    /// Concentrations of bodies, mol/L, in addition to that of the sweep.
    pub concentration_molar: Vec<f64>,
    /// Share of the frames at the beginning of each trajectory that is left out.
    pub skip: f64,
    /// Frames of each trajectory that are used at most, evenly spread.
    pub most_frames: usize,
    /// The assembly of the sweep, if it has moved.
    pub assembly: Option<PathBuf>,
    /// Directory for tables, JSON and figure.
    pub output: Option<PathBuf>,
    /// Whether existing files are replaced.
    pub force: bool,
}

impl Default for ReweightingSettings {
    fn default() -> Self {
        Self {
            input: PathBuf::new(),
            salt_molar: Vec::new(),
            concentration_molar: Vec::new(),
            skip: 0.2,
            most_frames: 200,
            assembly: None,
            output: None,
            force: false,
        }
    }
}

/// Weights the frames of a sweep into curves over salt.
///
/// # Errors
/// For a directory without a sweep over several salts or without frames, salts beyond those of the
/// sweep, a concentration without a box, neighbouring salts whose frames have too little in common,
/// and files that exist or cannot be written.
///
/// ```no_run
/// use protomer_protein_verbs::stability::reweighting::{ReweightingSettings, reweighting};
/// use protomer_common::answer::Answer;
/// let settings = ReweightingSettings {
///     input: "stability".into(),
///     concentration_molar: vec![1e-6],
///     ..ReweightingSettings::default()
/// };
/// println!("{}", reweighting(&settings, Default::default(), Default::default(), &())?.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn reweighting(
    settings: &ReweightingSettings,
    tables: Arc<EnergyTables>,
    store: Arc<EffectiveStore>,
    progress: &dyn Progress,
) -> Result<ReweightingResult> {
    let run = run_of(&settings.input)?;
    let frames = ScatteringSettings {
        input: settings.input.clone(),
        assembly: settings.assembly.clone(),
        skip: settings.skip,
        most_frames: settings.most_frames,
        ..ScatteringSettings::default()
    };
    frames.check()?;
    let source = Source::read(&frames)?;
    let salts = salts_of_curves(settings, &run)?;
    let box_angstrom3 = source.assembly.boundary.volume_angstrom3();
    let simulated_molar = source.assembly.concentration_molar();
    // Open space has an infinite volume.
    if !settings.concentration_molar.is_empty() && !box_angstrom3.is_finite() {
        bail!("in open space bodies have no concentration; leave out --concentration");
    }
    let engine = Engine::new(source.assembly.clone())?
        .with_tables(tables)
        .with_effective_store(store);
    let samples = Samples::gather(&engine, &run, &source, &salts, progress)?;
    let curves = Curves::new(&samples)?;
    let mut concentrations = vec![simulated_molar];
    concentrations.extend(&settings.concentration_molar);
    let mut concentration_curves = Vec::new();
    for concentration_molar in concentrations {
        // The first one is that of the sweep itself and may be none, in open space.
        if !(concentration_molar > 0.0 || concentration_curves.is_empty()) {
            bail!("a concentration of bodies is zero; give a positive one, such as 10uM");
        }
        // Exactly zero, so that the curve of the sweep is not changed by rounding.
        let ln_dilution = match concentration_molar == simulated_molar {
            true => 0.0,
            false => (simulated_molar / concentration_molar).ln(),
        };
        let target = Target {
            concentration_molar,
            ln_dilution,
        };
        concentration_curves.push(curves.curve(&salts, target));
    }
    let bodies = source.assembly.len();
    let free_energies_kt = curves.free_energies_kt();
    let result = ReweightingResult::new(
        &settings.input,
        &samples,
        free_energies_kt,
        concentration_curves,
        bodies,
    )?;
    if let Some(directory) = &settings.output {
        write(&result, &samples, directory, settings.force)?;
    }
    Ok(result)
}

/// The settings of a sweep over several salts.
fn run_of(directory: &Path) -> Result<RunSettings> {
    if ResultKind::detect(directory) != Some(ResultKind::Sweep) {
        bail!(
            "{} holds no sweep; name the directory of one over several salt concentrations",
            directory.display()
        );
    }
    let run: RunSettings = keys::read_toml(&directory.join("run.toml"))?;
    run.require_fixed_charges("reweight")?;
    if run.salt_molar.len() < 2 {
        bail!(
            "{} holds one salt concentration; there is nothing between several to weight",
            directory.display()
        );
    }
    if run.energy == Some(EnergyMode::None) {
        bail!(
            "{} holds hard bodies without charges, which are the same at every salt",
            directory.display()
        );
    }
    Ok(run)
}

/// The salts of the curves, ascending.
fn salts_of_curves(settings: &ReweightingSettings, run: &RunSettings) -> Result<Vec<f64>> {
    let mut simulated = run.salt_molar.clone();
    simulated.sort_by(f64::total_cmp);
    let [lowest, .., highest] = simulated[..] else {
        bail!("the sweep has one salt concentration");
    };
    let asked = settings.salt_molar.iter();
    let mut salts: Vec<f64> = asked
        .map(|salt| match *salt {
            // The ends of the sweep as a table shows them, with fewer digits.
            salt if salt < lowest && rounds_to(lowest, salt) => lowest,
            salt if salt > highest && rounds_to(highest, salt) => highest,
            salt => salt,
        })
        .collect();
    if let Some(beyond) = salts
        .iter()
        // Weights hold between the simulated salts only: beyond, no frame was drawn for them.
        .find(|salt| **salt < lowest || **salt > highest)
    {
        bail!(
            "{} mM is beyond the salts of the sweep, {} to {} mM, where its frames say nothing",
            millimolar(*beyond),
            millimolar(lowest),
            millimolar(highest)
        );
    }
    if salts.is_empty() {
        for pair in simulated.windows(2) {
            for number in 0..=BETWEEN_NEIGHBOURS {
                let part = number as f64 / (BETWEEN_NEIGHBOURS + 1) as f64;
                salts.push(salt_between(pair[0], pair[1], part));
            }
        }
        salts.push(highest);
    }
    // Labels name files: two salts with one label are one salt.
    salts.sort_by(f64::total_cmp);
    salts.dedup_by_key(|salt| salt_label(*salt));
    Ok(salts)
}

/// Whether the starts of the sweep agree, from its answer; `None` if that is not known.
fn equilibrated(directory: &Path) -> Result<Option<bool>> {
    let sweep = SweepResult::read(directory)?;
    Ok(sweep.and_then(|sweep| sweep.stability.equilibrated))
}

fn write(
    result: &ReweightingResult,
    samples: &Samples,
    directory: &Path,
    force: bool,
) -> Result<()> {
    let figure = result.drawn();
    let json = serde_json::to_string_pretty(result).context("the answer cannot be serialised")?;
    let files = [
        ("reweighting.csv", result.table()?.into_bytes()),
        ("samples.csv", samples.table()?.into_bytes()),
        (FILE, (json + "\n").into_bytes()),
        ("reweighting.svg", figure.to_svg()?.into_bytes()),
        ("reweighting.png", figure.to_png()?),
    ];
    write_folder(directory, &files, force)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn salts_at(asked_molar: f64) -> Result<Vec<f64>> {
        let settings = ReweightingSettings {
            salt_molar: vec![asked_molar],
            ..ReweightingSettings::default()
        };
        let run = RunSettings {
            salt_molar: vec![0.299_868, 0.094_868],
            ..RunSettings::default()
        };
        salts_of_curves(&settings, &run)
    }

    #[test]
    fn ends_of_the_sweep_are_found_by_the_digits_shown() {
        assert_eq!(salts_at(0.3).unwrap(), [0.299_868]);
        assert_eq!(
            salts_at(0.0948).unwrap_err().to_string(),
            "94.8 mM is beyond the salts of the sweep, 94.868 to 299.868 mM, where its frames say nothing"
        );
        assert_eq!(salts_at(0.2).unwrap(), [0.2]);
    }
}
