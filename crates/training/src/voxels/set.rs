//! Writes samples to a zarr group and reads them back.

use super::identity::fixed_conditions;
use super::origin::Origin;
use super::records::{SampleRecord, SetContent};
use super::row::Row;
use super::settings::VoxelizeSettings;
use super::statistics::Gathering;
use super::structure::{Properties, letters};
use anyhow::{Context, Result, bail};
use protomer_field::voxels::{Channel, Voxels};
use protomer_io::zarr::{SetReader, SetWriter};
use protomer_results::ResultKind;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// The current content of the output path of a set.
pub enum OnDisk {
    /// Nothing.
    Nothing,
    /// The same set, complete.
    Same(Box<SetReader>),
    /// Another set.
    Other,
}

/// Checks the output path of a set.
///
/// # Errors
/// If the path exists and is not a voxel set.
pub fn state_of(output: &Path, identity: &str) -> Result<OnDisk> {
    if !output.exists() {
        return Ok(OnDisk::Nothing);
    }
    let reader = SetReader::open(output).context(format!(
        "{} exists and is not a voxel set; choose another output",
        output.display()
    ))?;
    match reader.attributes().get("identity").and_then(Value::as_str) {
        Some(present) if present == identity => Ok(OnDisk::Same(Box::new(reader))),
        _ => Ok(OnDisk::Other),
    }
}

/// The settings of a set.
///
/// # Errors
/// If the attribute is damaged or of another version.
pub fn settings_of(reader: &SetReader) -> Result<VoxelizeSettings> {
    let value = reader
        .attributes()
        .get("settings")
        .cloned()
        .unwrap_or_default();
    serde_json::from_value(value)
        .context("the attribute 'settings' is damaged or of another version; make the set again")
}

/// The attributes of a set.
///
/// # Errors
/// If the settings cannot be serialised.
pub fn attributes(
    settings: &VoxelizeSettings,
    origins: &[Origin],
    identity: &str,
    content: &SetContent,
) -> Result<Map<String, Value>> {
    let mut meanings = Map::new();
    for channel in &settings.channels {
        meanings.insert(channel.name().to_owned(), meaning(*channel).into());
    }
    let manifest_sha256 = match origins {
        [only] => only.manifest_sha256.as_str(),
        _ => "",
    };
    let value = json!({
        "kind": ResultKind::VoxelSet,
        "made_by": format!("protomer {}", env!("CARGO_PKG_VERSION")),
        "identity": identity,
        "manifest_sha256": manifest_sha256,
        "manifests": serde_json::to_value(origins)?,
        "settings": serde_json::to_value(settings)?,
        "spacing_angstrom": serde_json::to_value(settings.spacing)?,
        "conditions": {
            "salt_molar": settings.salt_molar,
            "temperature_kelvin": settings.temperature_kelvin,
            "ph": settings.ph,
            "poisson_boltzmann": fixed_conditions(settings)?,
        },
        "channel_meanings": meanings,
        "samples": lists_of(&content.samples),
        "excluded": serde_json::to_value(&content.excluded)?,
        "warnings": warnings_of(&content.samples),
    });
    match value {
        Value::Object(map) => Ok(map),
        _ => bail!("the attributes are not an object"),
    }
}

/// What the values of a channel mean.
fn meaning(channel: Channel) -> &'static str {
    match channel {
        Channel::Shape => {
            "1 where the surface passes through: centres at most half an edge from it"
        }
        Channel::Solid => "1 where the centre is inside the surface",
        Channel::Potential => "kT/e, at the point of the surface nearest to the centre",
        Channel::Hydropathy => "Kyte-Doolittle index, averaged over nearby residues",
        Channel::Spacing => "edge of the voxels of this sample, Å",
    }
}

/// The string properties of the samples, a list for each.
fn lists_of(samples: &[SampleRecord]) -> Value {
    let mut lists = Map::new();
    for (place, name) in Row::WORDS.into_iter().enumerate() {
        let list = samples.iter().map(|sample| sample.row.words()[place]);
        lists.insert(name.to_owned(), list.collect());
    }
    Value::Object(lists)
}

/// The warnings of the samples that have any, by name.
pub fn warnings_of(samples: &[SampleRecord]) -> BTreeMap<String, Vec<String>> {
    let mut warnings = BTreeMap::new();
    for sample in samples {
        if !sample.warnings.is_empty() {
            warnings.insert(sample.row.name.clone(), sample.warnings.clone());
        }
    }
    warnings
}

/// Names of the numeric columns.
pub fn columns() -> Vec<String> {
    let mut columns: Vec<String> = [
        "entry",
        "residues",
        "radius_of_gyration_angstrom",
        "extent_1_angstrom",
        "extent_2_angstrom",
        "extent_3_angstrom",
        "net_charge_e",
        "spacing_angstrom",
        "rotation_w",
        "rotation_x",
        "rotation_y",
        "rotation_z",
        "middle_x_angstrom",
        "middle_y_angstrom",
        "middle_z_angstrom",
    ]
    .map(str::to_owned)
    .to_vec();
    for letter in letters() {
        columns.push(format!("composition_{letter}"));
    }
    columns
}

fn row(sample: &SampleRecord) -> Vec<f64> {
    let p = &sample.properties;
    let mut row = vec![
        sample.row.entry as f64,
        p.residues as f64,
        p.radius_of_gyration_angstrom,
    ];
    row.extend(p.extents_angstrom);
    row.extend([p.net_charge_e, p.spacing_angstrom]);
    row.extend(p.rotation_wxyz);
    row.extend(p.middle_angstrom);
    row.extend(p.composition);
    row
}

/// The samples of a set without their voxels.
///
/// # Errors
/// If columns or string lists are missing.
pub fn samples_of(reader: &SetReader) -> Result<Vec<SampleRecord>> {
    if reader.columns() != columns() {
        bail!("the columns of the properties are of another version; make the set again");
    }
    let (names, files) = (words(reader, "name")?, words(reader, "file")?);
    let (labels, hashes) = (words(reader, "label")?, words(reader, "sha256")?);
    let (clusters, families) = (words(reader, "cluster")?, words(reader, "family")?);
    let mut warnings: BTreeMap<String, Vec<String>> = match reader.attributes().get("warnings") {
        Some(warnings) => serde_json::from_value(warnings.clone())
            .context("the attribute 'warnings' is damaged; make the set again")?,
        None => BTreeMap::new(),
    };
    let mut samples = Vec::with_capacity(reader.len());
    for sample in 0..reader.len() {
        let word = |list: &[String]| list.get(sample).cloned().unwrap_or_default();
        let (entry, properties) = properties(reader.row(sample));
        let row = Row {
            entry,
            name: word(&names),
            file: word(&files),
            label: word(&labels),
            cluster: word(&clusters),
            family: word(&families),
            sha256: word(&hashes),
        };
        samples.push(SampleRecord {
            key: String::new(),
            voxels: reader.voxels(sample),
            properties,
            warnings: warnings.remove(&row.name).unwrap_or_default(),
            row,
        });
    }
    Ok(samples)
}

/// A string property of all samples.
fn words(reader: &SetReader, list: &str) -> Result<Vec<String>> {
    match reader.words(list) {
        Some(words) if words.len() == reader.len() => Ok(words),
        _ => bail!(
            "the attribute 'samples' has no list '{list}' of {} words",
            reader.len()
        ),
    }
}

/// The entry and the properties in a row of the table; the inverse of [`row`].
fn properties(row: &[f64]) -> (usize, Properties) {
    let at = |column: usize| row.get(column).copied().unwrap_or(f64::NAN);
    let properties = Properties {
        residues: at(1) as usize,
        radius_of_gyration_angstrom: at(2),
        extents_angstrom: std::array::from_fn(|n| at(3 + n)),
        net_charge_e: at(6),
        spacing_angstrom: at(7),
        rotation_wxyz: std::array::from_fn(|n| at(8 + n)),
        middle_angstrom: std::array::from_fn(|n| at(12 + n)),
        composition: std::array::from_fn(|n| at(15 + n)),
    };
    (at(0) as usize, properties)
}

/// Writes a set into an empty folder; `voxels` returns the voxels of each sample in turn, with
/// one list per channel.
///
/// # Errors
/// If a file cannot be written, and the errors of `voxels`.
pub fn write(
    folder: &Path,
    settings: &VoxelizeSettings,
    content: &SetContent,
    mut attributes: Map<String, Value>,
    voxels: &mut dyn FnMut(usize) -> Result<Voxels>,
) -> Result<()> {
    let mut channels = Vec::new();
    for channel in &settings.channels {
        channels.push(channel.name().to_owned());
    }
    let implied = settings.implied_channels();
    let mut writer =
        SetWriter::create(folder, settings.size, &channels, &implied, content.voxels())?;
    let mut statistics = Gathering::new(settings, &content.samples);
    for (number, sample) in content.samples.iter().enumerate() {
        let voxels = voxels(number)?;
        statistics.add(number, &voxels);
        let Voxels { index, values } = voxels;
        let mut stored: Vec<&[f32]> = Vec::new();
        for (channel, values) in channels.iter().zip(&values) {
            if !implied.contains(channel) {
                stored.push(values);
            }
        }
        let written = writer.push(&index, &stored);
        written.with_context(|| sample.row.name.clone())?;
    }
    attributes.insert(
        "statistics".into(),
        serde_json::to_value(statistics.finish())?,
    );
    let rows: Vec<f64> = content.samples.iter().flat_map(row).collect();
    Ok(writer.finish(&columns(), &rows, attributes)?)
}

/// Reads every sample of a set once and returns the mean time per sample, ms.
///
/// # Errors
/// Names the file that cannot be read.
pub fn read_back(folder: &Path) -> Result<f64> {
    let reader = SetReader::open(folder)?;
    let start = Instant::now();
    for sample in 0..reader.len() {
        reader.sample(sample)?;
    }
    Ok(1e3 * start.elapsed().as_secs_f64() / reader.len().max(1) as f64)
}

/// Creates a folder atomically: `fill` fills a temporary one beside it, which is then renamed.
///
/// # Errors
/// Names the folder.
pub fn replace(output: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    let partial = output.with_file_name(name);
    let shown = || format!("cannot write {}", output.display());
    if partial.exists() {
        std::fs::remove_dir_all(&partial).with_context(shown)?;
    }
    std::fs::create_dir_all(&partial).with_context(shown)?;
    fill(&partial)?;
    if output.exists() {
        std::fs::remove_dir_all(output).with_context(shown)?;
    }
    std::fs::rename(&partial, output).with_context(shown)
}

/// Bytes of all files of a folder; zero if there is none.
pub fn bytes_on_disk(folder: &Path) -> u64 {
    let Ok(entries) = folder.read_dir() else {
        return 0;
    };
    let mut bytes = 0;
    for entry in entries.flatten() {
        bytes += match entry.metadata() {
            Ok(metadata) if metadata.is_dir() => bytes_on_disk(&entry.path()),
            Ok(metadata) => metadata.len(),
            Err(_) => 0,
        };
    }
    bytes
}
