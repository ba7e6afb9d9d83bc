//! Finished samples, stored until all are done.
//!
//! One file, to which each finished structure appends a record: its length (8 bytes, little-endian)
//! and a checksummed container. An incomplete record, left by a killed process, is cut off when the
//! file is opened again. A complete record of another version is ignored: its key has another
//! [`FORMAT`], so the sample is made again.

use super::structure::{Done, Outcome, Properties, Reason, Sample};
use anyhow::{Context, Result, bail};
use protomer_field::voxels::Voxels;
use protomer_io::container::{Array, Container};
use protomer_io::digest::Digest;
use protomer_results::FileRecord;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Version of the record format. Increase it with every change of the header or the arrays.
pub const FORMAT: u32 = 3;
const KIND: &str = "voxel sample";
/// Upper limit for a record: 512³ voxels of five channels.
const LONGEST_RECORD_BYTES: u64 = 1 << 32;

/// Outcomes by the number of their structure, on disk.
pub struct WorkFile {
    path: PathBuf,
    inner: Mutex<Inner>,
}

/// Place where a record begins, at the end of the length before it; `None` without a record.
type Place = Option<NonZeroU64>;

const LENGTH_BYTES: u64 = 8;

struct Inner {
    file: File,
    records: Vec<Place>,
    end: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    key: String,
    properties: Option<Properties>,
    excluded: Option<(Reason, String)>,
    channels: usize,
    warnings: Vec<String>,
    body: Option<FileRecord>,
}

impl WorkFile {
    /// Opens or creates a work file for structures with these keys; no other process may have it
    /// open.
    ///
    /// # Errors
    /// Names the file; and the errors of the keys.
    pub fn open(path: &Path, keys: impl ExactSizeIterator<Item = Result<Digest>>) -> Result<Self> {
        let name = path.display().to_string();
        let file = OpenOptions::new()
            .read(true)
            // Kept, not emptied: it holds what earlier runs have done.
            .write(true)
            .create(true)
            .truncate(false)
            .open(path);
        let mut file = file.with_context(|| format!("cannot open {name}"))?;
        // Only one process may append; a disk without locks
        // is refused, as two would overwrite each other.
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => bail!("another process works on {name}; wait for it"),
            Err(TryLockError::Error(error)) => {
                return Err(error)
                    .with_context(|| format!("cannot lock {name}; use a disk of this machine"));
            }
        }
        let mut records = vec![None; keys.len()];
        let end = scan(&mut file, keys, &mut records);
        let end = end.with_context(|| format!("cannot read {name}"))?;
        // What follows the last whole record is half of one.
        file.set_len(end)
            .with_context(|| format!("cannot truncate {name}"))?;
        Ok(Self {
            path: path.to_owned(),
            inner: Mutex::new(Inner { file, records, end }),
        })
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // A thread that panicked cannot have left an incomplete record in the index.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The structures without a record, ascending.
    pub fn missing(&self) -> Vec<usize> {
        let inner = self.inner();
        let records = inner.records.iter().enumerate();
        let missing = records.filter(|(_, record)| record.is_none());
        missing.map(|(number, _)| number).collect()
    }

    /// Adds the record of a structure, under its key.
    ///
    /// # Errors
    /// Names the file.
    pub fn keep(&self, number: usize, key: Digest, done: &Done) -> Result<()> {
        // Encoded before the lock is taken: threads wait for the write alone.
        let bytes = encode(key, done)?;
        let mut record = (bytes.len() as u64).to_le_bytes().to_vec();
        record.extend(bytes);
        let mut inner = self.inner();
        // Always at the known end: a write that failed half-way is overwritten by the next.
        let begin = inner.end;
        let cannot_write = || format!("cannot write {}", self.path.display());
        let position = inner.file.seek(SeekFrom::Start(begin));
        position.with_context(cannot_write)?;
        let written = inner.file.write_all(&record);
        written.with_context(cannot_write)?;
        // Only after the whole record is written; until then the end stays where it was.
        inner.end += record.len() as u64;
        if let Some(record) = inner.records.get_mut(number) {
            *record = NonZeroU64::new(begin + LENGTH_BYTES);
        }
        Ok(())
    }

    /// The record of a structure.
    ///
    /// # Errors
    /// If there is none, or it is damaged.
    pub fn get(&self, number: usize) -> Result<Done> {
        let name = self.path.display().to_string();
        let mut inner = self.inner();
        let Some(place) = inner.records.get(number).copied().flatten() else {
            bail!("{name} has no record of structure {number}");
        };
        // The place is behind the length, so that it is never zero.
        let begin = place.get() - LENGTH_BYTES;
        let remaining_bytes = inner.end - begin;
        let position = inner.file.seek(SeekFrom::Start(begin));
        let bytes = position.and_then(|_| read_record(&mut inner.file, remaining_bytes));
        // The lock is free again while the container is decoded.
        drop(inner);
        let bytes = bytes.with_context(|| format!("cannot read {name}"))?;
        let Some(bytes) = bytes else {
            bail!("{name} was changed by another program; remove it and start again");
        };
        Ok(decode(&name, &Container::from_bytes(&name, KIND, &bytes)?)?.1)
    }

    /// Removes the file.
    ///
    /// # Errors
    /// Names the file.
    pub fn remove(self) -> Result<()> {
        std::fs::remove_file(&self.path)
            .with_context(|| format!("cannot remove {}", self.path.display()))
    }
}

/// Finds the complete records of the structures with these keys, and the end of all complete ones.
fn scan(
    file: &mut File,
    keys: impl Iterator<Item = Result<Digest>>,
    records: &mut [Place],
) -> Result<u64> {
    let length = file.metadata()?.len();
    // Nothing to find: the keys, which read every input, are not even made.
    if length == 0 {
        return Ok(0);
    }
    let mut numbers = BTreeMap::new();
    for (number, key) in keys.enumerate() {
        numbers.insert(key?, number);
    }
    // `end` is the end of the last complete record, from which the next is read.
    let mut end = 0;
    file.seek(SeekFrom::Start(0))?;
    let mut reader = std::io::BufReader::new(file);
    while let Some(bytes) = read_record(&mut reader, length - end)? {
        let Ok(container) = Container::from_bytes("", KIND, &bytes) else {
            // A damaged record: its length cannot be trusted either, so nothing behind it can.
            break;
        };
        // A record of another version is whole but has no known key; it is passed over.
        if let Ok((key, _)) = decode("", &container)
            && let Some(record) = numbers
                .get(&key)
                .and_then(|number| records.get_mut(*number))
        {
            *record = NonZeroU64::new(end + LENGTH_BYTES);
        }
        end += LENGTH_BYTES + bytes.len() as u64;
    }
    Ok(end)
}

/// Reads a record behind its length; `None` if not all of it is among the `remaining_bytes`.
fn read_record(reader: &mut impl Read, remaining_bytes: u64) -> std::io::Result<Option<Vec<u8>>> {
    if remaining_bytes < LENGTH_BYTES {
        return Ok(None);
    }
    let mut prefix = [0; 8];
    reader.read_exact(&mut prefix)?;
    let size = u64::from_le_bytes(prefix);
    // Before memory is taken: a length from a damaged file may be anything.
    if size > LONGEST_RECORD_BYTES || size > remaining_bytes - LENGTH_BYTES {
        return Ok(None);
    }
    let mut bytes = vec![0; size as usize];
    reader.read_exact(&mut bytes)?;
    Ok(Some(bytes))
}

fn encode(key: Digest, done: &Done) -> Result<Vec<u8>> {
    let (sample, excluded) = match &done.outcome {
        Outcome::Sample(sample) => (Some(sample), None),
        Outcome::Excluded { reason, detail } => (None, Some((*reason, detail.clone()))),
    };
    let mut header = Header {
        key: key.to_string(),
        properties: None,
        excluded,
        channels: 0,
        warnings: Vec::new(),
        body: done.body.clone(),
    };
    if let Some(sample) = sample {
        header.properties = Some(sample.properties.clone());
        header.channels = sample.voxels.values.len();
        header.warnings = sample.warnings.clone();
    }
    let mut container = Container::new(KIND, serde_json::to_value(header)?);
    if let Some(sample) = sample {
        let voxels = &sample.voxels;
        let count = voxels.index.len();
        container.insert("index", Array::u32(voxels.index.clone(), [count])?);
        for (channel, values) in voxels.values.iter().enumerate() {
            container.insert(
                format!("channel_{channel}"),
                Array::f32(values.clone(), [count])?,
            );
        }
    }
    Ok(container.to_bytes()?)
}

fn decode(name: &str, container: &Container) -> Result<(Digest, Done)> {
    let header: Header =
        serde_json::from_value(container.header.clone()).with_context(|| name.to_owned())?;
    let Some(key) = Digest::from_hex(&header.key) else {
        bail!(
            "{name}: a record has the key '{}', which is no SHA-256",
            header.key
        )
    };
    let outcome = match (header.properties, header.excluded) {
        (Some(properties), None) => {
            let index = container.u32(name, "index", &[None])?.to_vec();
            let mut values = Vec::new();
            for channel in 0..header.channels {
                let shape = [Some(index.len())];
                let of_channel = container.f32(name, &format!("channel_{channel}"), &shape)?;
                values.push(of_channel.to_vec());
            }
            let voxels = Voxels { index, values };
            Outcome::Sample(Box::new(Sample {
                properties,
                voxels,
                warnings: header.warnings,
            }))
        }
        (None, Some((reason, detail))) => Outcome::Excluded { reason, detail },
        _ => bail!("{name}: a record is neither a sample nor an exclusion"),
    };
    let body = header.body;
    Ok((key, Done { outcome, body }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(name: &str) -> Digest {
        Digest::hash(name.as_bytes())
    }

    /// Opens a work file for three structures.
    fn open(path: &Path) -> Result<WorkFile> {
        WorkFile::open(path, ["a", "b", "c"].map(|name| Ok(key(name))).into_iter())
    }

    fn done(outcome: Outcome) -> Done {
        let body = Some(FileRecord {
            file: "a.pdb".into(),
            row: vec!["a.pdb".into(), "ok".into()],
            warnings: vec!["it lacks CB".into()],
            error: None,
        });
        Done { outcome, body }
    }

    fn sample(seed: f32) -> Done {
        let properties = Properties {
            residues: 3,
            radius_of_gyration_angstrom: 1.1,
            extents_angstrom: [3.0, 2.0, 1.0],
            net_charge_e: 0.1,
            spacing_angstrom: 1.0,
            rotation_wxyz: [1.0, 0.0, 0.0, 0.0],
            middle_angstrom: [0.0; 3],
            composition: [0.05; 20],
        };
        let voxels = Voxels {
            index: vec![1, 5],
            values: vec![vec![1.0; 2], vec![seed, -seed]],
        };
        done(Outcome::Sample(Box::new(Sample {
            properties,
            voxels,
            warnings: vec!["it lacks CB".into()],
        })))
    }

    #[test]
    fn what_a_killed_process_left_is_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.work");
        let excluded = done(Outcome::Excluded {
            reason: Reason::TooLarge,
            detail: "x".into(),
        });
        let work = open(&path).unwrap();
        work.keep(0, key("a"), &sample(0.5)).unwrap();
        work.keep(1, key("b"), &excluded).unwrap();
        let whole = std::fs::metadata(&path).unwrap().len();
        work.keep(2, key("c"), &sample(2.0)).unwrap();
        assert!(open(&path).is_err(), "two at once");
        drop(work);
        let bytes = std::fs::read(&path).unwrap();
        for cut in [whole + 1, whole + 8, whole + 40, bytes.len() as u64 - 1] {
            std::fs::write(&path, &bytes[..cut as usize]).unwrap();
            let work = open(&path).unwrap();
            assert_eq!(work.missing(), [2]);
            assert_eq!(
                (work.get(0).unwrap(), work.get(1).unwrap()),
                (sample(0.5), excluded.clone())
            );
            work.keep(2, key("c"), &sample(3.0)).unwrap();
            assert_eq!(work.get(2).unwrap(), sample(3.0));
        }
        // A damaged record and all later ones are made again.
        let mut damaged = bytes.clone();
        damaged[20] ^= 1;
        std::fs::write(&path, &damaged).unwrap();
        let work = open(&path).unwrap();
        assert_eq!(work.missing(), [0, 1, 2]);
        work.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn a_record_of_another_version_is_passed_over_and_hides_none_behind_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.work");
        let mut bytes = Vec::new();
        let mut append = |record: Vec<u8>| {
            bytes.extend((record.len() as u64).to_le_bytes());
            bytes.extend(record);
        };
        append(encode(key("a"), &sample(0.5)).unwrap());
        let older = serde_json::json!({"key": key("b").to_string(), "properties": null, "excluded": null, "channels": 0});
        append(Container::new(KIND, older).to_bytes().unwrap());
        append(encode(key("c"), &sample(1.5)).unwrap());
        std::fs::write(&path, &bytes).unwrap();
        let work = open(&path).unwrap();
        assert_eq!(work.missing(), [1]);
        assert_eq!(work.get(2).unwrap(), sample(1.5));
        work.keep(1, key("b"), &sample(2.5)).unwrap();
        drop(work);
        assert_eq!(open(&path).unwrap().get(1).unwrap(), sample(2.5));
    }
}
