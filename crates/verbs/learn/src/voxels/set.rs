//! Writes samples to a zarr group and reads them back.

use super::attributes::{Attributes, Making};
use super::columns::{columns, properties, row};
use super::content::Content;
use super::records::SampleRecord;
use super::row::Row;
use super::settings::VoxelizeSettings;
use super::statistics::Gathering;
use anyhow::{Context, Result, bail};
use protomer_field::voxels::Voxels;
use protomer_io::zarr::{self, SampleReader, SetPlan, SetReader, SetWriter};
use protomer_kernel::setting::Choices;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// The current content of the output path of a set.
pub enum OnDisk {
    /// No file or folder.
    Nothing,
    /// The same set, complete.
    Same(Box<SampleReader>),
    /// Another set.
    Other,
}

/// Checks the output path of a set.
///
/// # Errors
/// If the path exists and is not a voxel set.
pub fn state_of(output: &Path, identity: &str) -> Result<OnDisk> {
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Identified {
        identity: Value,
    }
    if !output.exists() {
        return Ok(OnDisk::Nothing);
    }
    let is_no_set = || {
        format!(
            "{} exists and is not a voxel set; choose another output",
            output.display()
        )
    };
    let reader = SampleReader::open(output).with_context(is_no_set)?;
    let present: Identified = zarr::attributes(output).with_context(is_no_set)?;
    Ok(match present.identity.as_str() == Some(identity) {
        true => OnDisk::Same(Box::new(reader)),
        false => OnDisk::Other,
    })
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

/// Writes a set into an empty folder.
///
/// # Errors
/// If a file cannot be written, and the errors of the content.
pub fn write(folder: &Path, making: Making, content: &dyn Content) -> Result<()> {
    let settings = making.settings;
    let channels = settings.channels.iter().map(|channel| channel.name());
    let channels: Vec<String> = channels.map(str::to_owned).collect();
    let implied = settings.implied_channels();
    let plan = SetPlan {
        size: settings.size,
        channels: channels.clone(),
        implied: implied.clone(),
        columns: columns(),
        samples: content.len() as u64,
        voxels: content.voxels(),
    };
    let mut writer = SetWriter::create(folder, plan)?;
    let mut statistics = Gathering::new(settings, content.len(), |sample| content.row(sample))?;
    for number in 0..content.len() {
        let manifest_row = content.row(number)?;
        let (properties, voxels) = content.sample(number)?;
        statistics.add(number, &voxels);
        let Voxels { index, values } = voxels;
        let mut stored: Vec<&[f32]> = Vec::new();
        for (channel, values) in channels.iter().zip(&values) {
            if !implied.contains(channel) {
                stored.push(values);
            }
        }
        let written = writer.push(&index, &stored, &row(manifest_row.entry, &properties));
        written.with_context(|| manifest_row.name)?;
    }
    let attributes = Attributes::new(making, content, statistics.finish())?;
    Ok(writer.finish(&attributes)?)
}

/// Reads everything of a set but the attributes once, and returns the mean time per sample, ms.
///
/// # Errors
/// Names the file that cannot be read.
pub fn read_back(folder: &Path) -> Result<f64> {
    let reader = SampleReader::open(folder)?;
    for part in reader.table().parts() {
        part?;
    }
    let start = Instant::now();
    for sample in 0..reader.len() {
        reader.sample(sample)?;
    }
    Ok(1e3 * start.elapsed().as_secs_f64() / reader.len().max(1) as f64)
}

/// Creates a folder atomically: `fill` fills a temporary one next to it, which is then renamed. A
/// link stays, and the folder that it leads to is replaced.
///
/// # Errors
/// Names the folder.
pub fn replace(output: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    let folder = match output.is_symlink() {
        true => output
            .canonicalize()
            .with_context(|| format!("cannot follow the link {}", output.display()))?,
        false => output.to_owned(),
    };
    let output = folder.as_path();
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
