//! The page of a set of voxels.

mod channels;

use super::attributes::Stated;
use super::origin::{Missing, origins};
use super::records::{self, Exclusion, SampleRecord};
use super::row::Row;
use super::samples::VoxelSet;
use super::structure::Reason;
use super::{Fit, Spacing, VoxelizeSettings, set};
use anyhow::{Context, Result};
use protomer_common::page::{
    Contents, Data, Origin, Part, Section, SettingsText, millimolar, significant,
};
use protomer_io::csv::{Cell, Table};
use protomer_kernel::setting::Choices;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::Record;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Number of labels with individual colours; if there are more, the figure shows all samples alike.
const MOST_COLOURS: usize = 6;
/// Maximum number of rows in the tables of labels, clusters and exclusions; the data below have
/// all.
const MOST_ROWS: usize = 30;

/// Contents of the page of a set.
///
/// # Errors
/// If the set is damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let opened = VoxelSet::open(directory)?;
    let reader = opened.reader();
    let settings = set::settings_of(reader)?;
    let excluded = records::exclusions(reader)?;
    let samples = set::samples_of(reader)?;
    let stated = Stated::read(directory)?;
    let mut contents = Contents::new("Set of voxels");
    contents.subtitle = format!(
        "{} samples of {}³ voxels: {}",
        samples.len(),
        settings.size,
        names(&settings)
    );
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
    contents.origin = Origin {
        settings: SettingsText::Text(
            toml::to_string_pretty(&settings).context("the settings cannot be serialised")?,
        ),
        more: vec![
            ("program", or_dash(stated.made_by)),
            ("command", "protomer voxelize".into()),
            ("SHA-256 of the manifest", or_dash(stated.manifest_sha256)),
            (
                "identity (SHA-256 of settings and input)",
                or_dash(stated.identity),
            ),
            ("seed", settings.seed.to_string()),
        ],
        note: "",
        is_run: false,
    };
    contents.problems = problems(&samples, &excluded);
    for shortfall in Missing::find(&origins(reader)?) {
        let parts = shortfall.parts.join(", ");
        contents.problems.push(format!(
            "{} of the {} structures of a manifest are missing; only its parts {parts} are here.",
            shortfall.missing, shortfall.structures
        ));
    }
    contents.add(overview(directory, &samples, &excluded)?);
    contents.add(groups(&samples, &excluded));
    contents.add(channels::section(&opened, &stated.channel_meanings)?);
    if !excluded.is_empty() {
        contents.add(left_out(&excluded)?);
    }
    contents.add(conditions(&settings));
    Ok(contents)
}

fn names(settings: &VoxelizeSettings) -> String {
    let mut names = Vec::new();
    for channel in &settings.channels {
        names.push(channel.name());
    }
    names.join(", ")
}

fn problems(samples: &[SampleRecord], excluded: &[Exclusion]) -> Vec<String> {
    let mut problems = Vec::new();
    if samples.is_empty() {
        problems.push("The set has no samples.".to_owned());
    }
    if !excluded.is_empty() {
        let mut counts = Vec::new();
        for (reason, count) in by_reason(excluded) {
            counts.push(format!("{reason}: {count}"));
        }
        let total = samples.len() + excluded.len();
        problems.push(format!(
            "{} of {total} structures were left out ({}).",
            excluded.len(),
            counts.join(", ")
        ));
    }
    problems
}

/// Word for a reason in `excluded`.
fn word(reason: Reason) -> String {
    match serde_json::to_value(reason) {
        Ok(Value::String(word)) => word,
        _ => String::new(),
    }
}

fn by_reason(excluded: &[Exclusion]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for one in excluded {
        *counts.entry(word(one.reason)).or_insert(0) += 1;
    }
    counts
}

fn overview(directory: &Path, samples: &[SampleRecord], excluded: &[Exclusion]) -> Result<Section> {
    let (mut labels, mut clusters) = (BTreeSet::new(), BTreeSet::new());
    let mut voxels = 0;
    for sample in samples {
        labels.insert(&sample.row.label);
        clusters.insert(&sample.row.cluster);
        voxels += sample.voxels;
    }
    let values = Part::Values(vec![
        ("samples", samples.len().to_string()),
        ("structures left out", excluded.len().to_string()),
        ("labels", labels.len().to_string()),
        ("clusters", clusters.len().to_string()),
        (
            "occupied voxels",
            format!("{voxels}, {} per sample", voxels / samples.len().max(1)),
        ),
        (
            "size of the files",
            format!(
                "{} MB",
                significant(set::bytes_on_disk(directory) as f64 / 1e6, 3)
            ),
        ),
    ]);
    let data = Data::Table {
        name: "samples.csv".into(),
        csv: samples_table(samples)?.to_csv()?,
    };
    let drawn = match samples.is_empty() {
        true => Part::Data(data),
        false => Part::Figure(Box::new(figure(samples)), Some(data)),
    };
    Ok(Section::new("Samples", vec![values, drawn]))
}

fn samples_table(samples: &[SampleRecord]) -> Result<Table> {
    let numbers = [
        "voxels",
        "residues",
        "radius_of_gyration_angstrom",
        "largest_extent_angstrom",
        "net_charge_e",
    ];
    let mut table = Table::new(
        Row::WORDS
            .into_iter()
            .chain(numbers)
            .chain(["spacing_angstrom"]),
    );
    for sample in samples {
        let SampleRecord {
            row,
            voxels,
            properties,
            ..
        } = sample;
        let words = row.words().map(Cell::from);
        let [longest, ..] = properties.extents_angstrom;
        table.push(words.into_iter().chain([
            (*voxels).into(),
            properties.residues.into(),
            properties.radius_of_gyration_angstrom.into(),
            longest.into(),
            properties.net_charge_e.into(),
            properties.spacing_angstrom.into(),
        ]))?;
    }
    Ok(table)
}

/// A figure of the sizes of the samples, by label: a histogram, and the occupied voxels.
fn figure(samples: &[SampleRecord]) -> Figure {
    // Radius of gyration and occupied voxels of the samples of each label.
    let mut groups: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
    let mut all = Vec::with_capacity(samples.len());
    for sample in samples {
        let size = sample.properties.radius_of_gyration_angstrom;
        let point = [size, sample.voxels as f64];
        groups.entry(&sample.row.label).or_default().push(point);
        all.push(point);
    }
    let bins = Bins::new(all.iter().map(|[size, _]| *size));
    if groups.len() > MOST_COLOURS {
        groups = BTreeMap::from([("all samples", all)]);
    }
    let (mut counts, mut occupied) = (Vec::new(), Vec::new());
    for (name, points) in groups {
        counts.push(Series {
            name: name.to_owned(),
            points: bins.count(points.iter().map(|[size, _]| *size)),
            line: true,
            ..Series::default()
        });
        occupied.push(Series {
            name: name.to_owned(),
            replicas: points,
            line: false,
            ..Series::default()
        });
    }
    Figure {
        title: "Sizes of the samples".into(),
        caption: format!(
            "counts in steps of {} Å; below, a point for each sample",
            significant(bins.width, 3)
        ),
        x: Axis::linear("radius of gyration (Å)"),
        panels: vec![
            Panel {
                y: Axis::linear("samples"),
                series: counts,
            },
            Panel {
                y: Axis::linear("occupied voxels"),
                series: occupied,
            },
        ],
    }
}

/// Equal bins over a range.
struct Bins {
    low: f64,
    width: f64,
    count: usize,
}

impl Bins {
    /// Bins for these values, about the square root of their number.
    fn new(values: impl Iterator<Item = f64> + Clone) -> Self {
        let number = values.clone().count();
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        let count = (number as f64).sqrt().ceil().clamp(1.0, 20.0) as usize;
        let width = (high - low) / count as f64;
        Self {
            low,
            width: if width > 0.0 { width } else { 1.0 },
            count,
        }
    }

    /// The number of values in each bin, at its centre.
    fn count(&self, values: impl Iterator<Item = f64>) -> Vec<Point> {
        let mut counts = vec![0usize; self.count];
        for value in values {
            let step = (((value - self.low) / self.width).max(0.0) as usize)
                .min(self.count.saturating_sub(1));
            if let Some(count) = counts.get_mut(step) {
                *count += 1;
            }
        }
        let mut points = Vec::with_capacity(counts.len());
        for (step, count) in counts.into_iter().enumerate() {
            points.push(Point {
                x: self.low + (step as f64 + 0.5) * self.width,
                y: count as f64,
                error: None,
            });
        }
        points
    }
}

/// The section on labels and clusters.
fn groups(samples: &[SampleRecord], excluded: &[Exclusion]) -> Section {
    let mut labels: BTreeMap<&str, (usize, BTreeSet<&str>, usize)> = BTreeMap::new();
    let mut clusters: BTreeMap<&str, (usize, BTreeSet<&str>)> = BTreeMap::new();
    for sample in samples {
        let label = labels.entry(&sample.row.label).or_default();
        label.0 += 1;
        label.1.insert(&sample.row.cluster);
        let cluster = clusters.entry(&sample.row.cluster).or_default();
        cluster.0 += 1;
        cluster.1.insert(&sample.row.label);
    }
    excluded
        .iter()
        .for_each(|one| labels.entry(&one.row.label).or_default().2 += 1);
    let label_rows = labels.iter().map(|(name, (samples, clusters, left_out))| {
        vec![
            (*name).to_owned(),
            samples.to_string(),
            clusters.len().to_string(),
            left_out.to_string(),
        ]
    });
    let mut largest: Vec<_> = clusters.iter().collect();
    largest.sort_by_key(|(name, (samples, _))| (std::cmp::Reverse(*samples), **name));
    let cluster_rows = largest.iter().map(|(name, (samples, labels))| {
        let labels = labels.iter().copied().collect::<Vec<_>>().join(", ");
        vec![(**name).to_owned(), samples.to_string(), labels]
    });
    let note = "Related structures share a cluster, which no split may put on both sides.";
    let columns = vec!["label", "samples", "clusters", "left out"];
    let mut parts = Vec::from(counted("Labels", columns, label_rows.collect()));
    let columns = vec!["cluster", "samples", "labels"];
    parts.extend(counted(
        "Clusters, largest first",
        columns,
        cluster_rows.collect(),
    ));
    parts.push(Part::Paragraph(note.into()));
    Section::new("Labels and clusters", parts)
}

/// A table under a heading, truncated if it is long.
fn counted(title: &str, columns: Vec<&'static str>, mut rows: Vec<Vec<String>>) -> [Part; 2] {
    let title = match rows.len() {
        many if many > MOST_ROWS => format!("{title}: {MOST_ROWS} of {many}"),
        _ => title.to_owned(),
    };
    rows.truncate(MOST_ROWS);
    [Part::Heading(title), Part::Table { columns, rows }]
}

fn left_out(excluded: &[Exclusion]) -> Result<Section> {
    let reasons = by_reason(excluded)
        .into_iter()
        .map(|(reason, count)| vec![reason, count.to_string()]);
    let columns = vec!["reason", "structures"];
    let mut parts = Vec::from(counted("Reasons", columns, reasons.collect()));
    let rows = excluded.iter().map(|one| {
        vec![
            one.row.name.clone(),
            one.row.label.clone(),
            word(one.reason),
            one.detail.clone(),
        ]
    });
    let columns = vec!["name", "label", "reason", "in words"];
    parts.extend(counted("Structures", columns, rows.collect()));
    let mut csv = Table::new([
        "name", "file", "label", "cluster", "family", "sha256", "reason", "detail",
    ]);
    for Exclusion {
        row,
        reason,
        detail,
    } in excluded
    {
        let words = [
            &row.name,
            &row.file,
            &row.label,
            &row.cluster,
            &row.family,
            &row.sha256,
            &word(*reason),
            detail,
        ];
        csv.push(words.map(|word| word.as_str().into()))?;
    }
    parts.push(Part::Data(Data::Table {
        name: "excluded.csv".into(),
        csv: csv.to_csv()?,
    }));
    Ok(Section::new("Left out", parts))
}

fn conditions(settings: &VoxelizeSettings) -> Section {
    let word = |value: Result<Value, serde_json::Error>| {
        value
            .ok()
            .and_then(|word| word.as_str().map(str::to_owned))
            .unwrap_or_default()
    };
    let spacing = match settings.spacing {
        Spacing::Angstrom(spacing) => format!("{spacing} Å"),
        Spacing::Fit(Fit::Fit) => "each structure scaled to fill the grid".into(),
    };
    Section::new(
        "Conditions",
        vec![Part::Values(vec![
            ("grid", format!("{0} × {0} × {0} voxels", settings.size)),
            ("edge of a voxel", spacing),
            (
                "orientation",
                word(serde_json::to_value(settings.orientation)),
            ),
            ("potential", word(serde_json::to_value(settings.potential))),
            ("salt", format!("{} mM", millimolar(settings.salt_molar))),
            ("temperature", format!("{} K", settings.temperature_kelvin)),
            ("pH", settings.ph.to_string()),
            ("probe radius", format!("{} Å", settings.probe_angstrom)),
            (
                "range of the hydropathy",
                format!("{} Å", settings.hydropathy_reach_angstrom),
            ),
            (
                "excluded if more residues lack heavy atoms",
                format!("{} %", 100.0 * settings.most_incomplete),
            ),
        ])],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_step() {
        let values = [1.0, 1.5, 2.0, 4.9, 5.0];
        let bins = Bins::new(values.into_iter());
        let counts: Vec<f64> = bins
            .count(values.into_iter())
            .iter()
            .map(|point| point.y)
            .collect();
        assert_eq!((bins.count, counts.iter().sum::<f64>()), (3, 5.0));
        assert_eq!(counts, [3.0, 0.0, 2.0]);
        assert_eq!(
            Bins::new([2.0].into_iter()).count([2.0].into_iter())[0].y,
            1.0
        );
    }
}
