//! The structures of a manifest that one process voxelises.

use super::identity::{Keys, identity};
use super::manifest::{Entry, Manifest};
use super::row::Row;
use super::settings::VoxelizeSettings;
use anyhow::{Result, bail};
use protomer_common::input::InputFile;
use protomer_io::digest::Digest;
use protomer_results::Shard;
use rayon::prelude::*;

/// The structures, numbered from zero. Only the hash of each file is kept; everything else about a
/// structure is made when it is requested.
pub(super) struct Part<'a> {
    pub(super) manifest: &'a Manifest,
    pub(super) shard: Shard,
    pub(super) settings: &'a VoxelizeSettings,
    /// SHA-256 of each readable file.
    hashes: Vec<Option<Digest>>,
    keys: Keys,
    pub(super) identity: String,
}

impl<'a> Part<'a> {
    pub(super) fn new(
        manifest: &'a Manifest,
        shard: Shard,
        settings: &'a VoxelizeSettings,
        body_density: Option<f64>,
    ) -> Result<Self> {
        let count = (0..manifest.len())
            .filter(|number| shard.has(*number))
            .count();
        let mut part = Self {
            manifest,
            shard,
            settings,
            hashes: Vec::new(),
            keys: Keys::new(settings, body_density)?,
            identity: String::new(),
        };
        let hash = |structure| hash_of(&part.entry(structure).ok()?);
        part.hashes = (0..count).into_par_iter().map(hash).collect();
        let rows = || (0..count).map(|structure| part.row(structure));
        part.identity = identity(settings, rows)?;
        Ok(part)
    }

    /// Number of structures.
    pub(super) fn len(&self) -> usize {
        self.hashes.len()
    }

    pub(super) fn entry(&self, structure: usize) -> Result<Entry> {
        let Shard { index, of: parts } = self.shard;
        self.manifest.entry(index - 1 + structure * parts)
    }

    fn hash(&self, structure: usize) -> Option<Digest> {
        self.hashes.get(structure).copied().flatten()
    }

    pub(super) fn row(&self, structure: usize) -> Result<Row> {
        Ok(Row::new(self.entry(structure)?, self.hash(structure)))
    }

    /// Refuses a structure whose file is not what it was when this process began: its record would
    /// stand under the hash of other content.
    pub(super) fn require_unchanged(&self, structure: usize) -> Result<()> {
        let entry = self.entry(structure)?;
        if hash_of(&entry) == self.hash(structure) {
            return Ok(());
        }
        bail!(
            "{} has changed while it was voxelized; run the same command again",
            entry.path.display()
        )
    }

    /// The key of the record of a structure in the work file.
    pub(super) fn key(&self, structure: usize) -> Result<Digest> {
        let name = self.entry(structure)?.name;
        self.keys.key(&name, self.hash(structure))
    }
}

/// The hash of the file of an entry; for an interface that of both files, the chains and the pose.
/// `None` if a file cannot be read.
fn hash_of(entry: &Entry) -> Option<Digest> {
    let first = InputFile::sha256_of(&entry.path).ok()?;
    let Some(partner) = &entry.partner else {
        return Digest::from_hex(&first);
    };
    let second = InputFile::sha256_of(&partner.path).ok()?;
    let (position, rotation) = (partner.pose.position, partner.pose.wxyz());
    let (chains, others) = (&partner.chains, &partner.partner_chains);
    // Numbers as they print: the fewest digits that read back exactly.
    let text = format!("{first} {second} {chains:?} {others:?} {position:?} {rotation:?}");
    Some(Digest::hash(text.as_bytes()))
}
