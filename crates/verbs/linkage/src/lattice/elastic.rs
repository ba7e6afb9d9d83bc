//! Elastic answers of runs in a heat bath: by the fluctuations of the strain in each run, and by the
//! response of runs that differ in their load.

use super::directory::read_settings;
use super::log::LogRow;
use super::settings::LatticeSettings;
use super::start::begin;
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns};
use protomer_common::range::Range;
use protomer_linkage::analysis::elastic::{
    Compliances, LoadedRun, Response, WithError, compliances, response,
};
use protomer_linkage::lattice::load::reference_area;
use protomer_results::log;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Range of the share of a log that is left out.
const DISCARD: Range = Range::new(0.0, 0.95, "");
/// Range of the number of blocks.
const BLOCKS: std::ops::RangeInclusive<usize> = 2..=1000;

/// Evaluation of logs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticSettings {
    /// Share of every log that is left out at its start.
    pub discard: f64,
    /// Number of blocks for the errors.
    pub blocks: usize,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticRun {
    /// Directory of the run.
    pub directory: PathBuf,
    /// Length of the rods.
    pub r0: f64,
    /// Stress along x.
    pub stress_xx: f64,
    /// Stress along y.
    pub stress_yy: f64,
    /// Seed.
    pub seed: u64,
    /// Area to which stresses and compliances refer.
    pub area: f64,
    /// Answers from the fluctuations of this run.
    #[serde(flatten)]
    pub compliances: Compliances,
}

/// Runs that differ in their load only.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticResponse {
    /// Length of the rods.
    pub r0: f64,
    /// Axis of the load: x or y.
    pub load: &'static str,
    /// Number of runs.
    pub runs: usize,
    /// Answers by response and by fluctuation.
    #[serde(flatten)]
    pub response: Response,
}

/// Elastic answers of some runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticAnswer {
    /// Runs in the given order.
    pub runs: Vec<ElasticRun>,
    /// Groups of runs that differ in the load and the seed.
    pub responses: Vec<ElasticResponse>,
}

struct Read {
    run: ElasticRun,
    kt: f64,
    strains: Vec<[f64; 3]>,
    /// Settings without load and seed.
    group: LatticeSettings,
}

/// Evaluates the logs of runs in a heat bath.
///
/// # Errors
/// For a directory that is no run, a run without a heat bath or too short, and settings out of range.
pub fn elastic(directories: &[PathBuf], settings: &ElasticSettings) -> Result<ElasticAnswer> {
    DISCARD.require("--discard", settings.discard)?;
    if !BLOCKS.contains(&settings.blocks) {
        bail!(
            "--blocks is {}; give {} to {}",
            settings.blocks,
            BLOCKS.start(),
            BLOCKS.end()
        );
    }
    let mut all = Vec::with_capacity(directories.len());
    for directory in directories {
        let read = read(directory, settings).with_context(|| directory.display().to_string());
        all.push(read?);
    }
    let mut responses = Vec::new();
    for (index, first) in all.iter().enumerate() {
        // Each group once, by its first member.
        if all[..index]
            .iter()
            .any(|earlier| earlier.group == first.group)
        {
            continue;
        }
        let group: Vec<&Read> = all.iter().filter(|run| run.group == first.group).collect();
        responses.extend(along(&group, "x", settings.blocks)?);
        responses.extend(along(&group, "y", settings.blocks)?);
    }
    Ok(ElasticAnswer {
        runs: all.into_iter().map(|read| read.run).collect(),
        responses,
    })
}

fn read(directory: &Path, wanted: &ElasticSettings) -> Result<Read> {
    let settings = read_settings(directory)?;
    let Some(kt) = settings.temperature.filter(|kt| *kt > 0.0) else {
        bail!(
            "the run has no heat bath, so its strains are not those of equilibrium; run it with --temperature and --friction"
        );
    };
    let rows: Vec<LogRow> = log::read(&directory.join(log::FILE))?;
    let first = (wanted.discard * rows.len() as f64) as usize;
    let mut strains = Vec::with_capacity(rows.len());
    for row in rows.iter().skip(first.max(1)) {
        strains.push([row.strain_xx, row.strain_yy, row.strain_xy]);
    }
    let begun = begin(&settings)?;
    let area = reference_area(&begun.network, &begun.state);
    let compliances = compliances(&strains, area, kt, wanted.blocks)?;
    Ok(Read {
        run: ElasticRun {
            directory: directory.to_owned(),
            r0: settings.r0,
            stress_xx: settings.stress_xx,
            stress_yy: settings.stress_yy,
            seed: settings.seed,
            area,
            compliances,
        },
        kt,
        strains,
        group: LatticeSettings {
            stress_xx: 0.0,
            stress_yy: 0.0,
            seed: 0,
            time: 0.0,
            steps: None,
            ..settings
        },
    })
}

/// The response to loads along one axis, of the runs without a load along the other.
fn along(group: &[&Read], load: &'static str, blocks: usize) -> Result<Option<ElasticResponse>> {
    let is_x = load == "x";
    let mut chosen = Vec::new();
    for read in group {
        let (stress, other) = match is_x {
            true => (read.run.stress_xx, read.run.stress_yy),
            false => (read.run.stress_yy, read.run.stress_xx),
        };
        if other == 0.0 {
            let strains = read.strains.iter();
            let rotated = strains.map(|[x, y, _]| if is_x { [*x, *y] } else { [*y, *x] });
            chosen.push((stress, rotated.collect::<Vec<_>>()));
        }
    }
    let differs = chosen.windows(2).any(|pair| pair[0].0 != pair[1].0);
    let Some(first) = group.first().filter(|_| differs) else {
        return Ok(None);
    };
    let mut runs = Vec::with_capacity(chosen.len());
    for (stress, strains) in &chosen {
        runs.push(LoadedRun {
            stress: *stress,
            strains,
        });
    }
    Ok(Some(ElasticResponse {
        r0: first.run.r0,
        load,
        runs: runs.len(),
        response: response(&runs, first.run.area, first.kt, blocks)?,
    }))
}

impl Answer for ElasticAnswer {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "r0", "σ_xx", "σ_yy", "seed", "ε_xx", "ε_yy", "S_xx", "S_yy", "ν_xy", "ν_yx",
        ])];
        for run in &self.runs {
            let compliances = &run.compliances;
            let mut cells = vec![
                format!("{:.4}", run.r0),
                run.stress_xx.to_string(),
                run.stress_yy.to_string(),
                run.seed.to_string(),
            ];
            for answer in [
                compliances.strain_xx,
                compliances.strain_yy,
                compliances.compliance_xx,
                compliances.compliance_yy,
                compliances.poisson_ratio_xy,
                compliances.poisson_ratio_yx,
            ] {
                cells.push(shown(answer));
            }
            rows.push(cells);
        }
        let runs = columns(&rows);
        if self.responses.is_empty() {
            return runs;
        }
        let mut rows = vec![heading([
            "r0",
            "load",
            "runs",
            "S by response",
            "by fluctuation",
            "ν by response",
            "by fluctuation",
            "apart",
        ])];
        for group in &self.responses {
            let response = &group.response;
            rows.push(vec![
                format!("{:.4}", group.r0),
                group.load.to_owned(),
                group.runs.to_string(),
                shown(response.compliance),
                shown(response.fluctuation_compliance),
                shown(response.poisson_ratio),
                shown(response.fluctuation_poisson_ratio),
                format!("{:.1} errors", response.deviation.abs()),
            ]);
        }
        format!("{runs}\n\n{}", columns(&rows))
    }
}

fn heading<const N: usize>(words: [&str; N]) -> Vec<String> {
    words.map(str::to_owned).to_vec()
}

fn shown(answer: WithError) -> String {
    format!("{:.4} ± {:.4}", answer.value, answer.error)
}
