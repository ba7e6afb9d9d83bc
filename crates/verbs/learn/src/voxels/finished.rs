//! The content of a set whose structures are all done, in the work file.

use super::content::Content;
use super::part::Part;
use super::records::Exclusion;
use super::row::Row;
use super::structure::{Outcome, Properties};
use super::work::WorkFile;
use anyhow::{Context, Result, bail};
use protomer_field::voxels::Voxels;
use std::collections::BTreeMap;

/// Content of a set in the work file. Samples are read whenever they are requested. What a report
/// tells of the structures, exclusions and warnings, is in memory.
pub(super) struct Finished<'a> {
    part: &'a Part<'a>,
    work: &'a WorkFile,
    /// The structure of each sample.
    structures: Vec<usize>,
    voxels: u64,
    excluded: Vec<Exclusion>,
    warnings: BTreeMap<String, Vec<String>>,
}

impl<'a> Finished<'a> {
    /// Reads every record once.
    pub(super) fn count(part: &'a Part, work: &'a WorkFile) -> Result<Self> {
        let mut finished = Self {
            part,
            work,
            structures: Vec::new(),
            voxels: 0,
            excluded: Vec::new(),
            warnings: BTreeMap::new(),
        };
        for structure in 0..part.len() {
            let row = part.row(structure)?;
            let done = work.get(structure).with_context(|| row.name.clone())?;
            match done.outcome {
                Outcome::Sample(sample) => {
                    finished.structures.push(structure);
                    finished.voxels += sample.voxels.index.len() as u64;
                    if !sample.warnings.is_empty() {
                        finished.warnings.insert(row.name, sample.warnings);
                    }
                }
                Outcome::Excluded { reason, detail } => finished.excluded.push(Exclusion {
                    row,
                    reason,
                    detail,
                }),
            }
        }
        Ok(finished)
    }

    /// The exclusions, and the warnings by sample.
    pub(super) fn into_notes(self) -> (Vec<Exclusion>, BTreeMap<String, Vec<String>>) {
        (self.excluded, self.warnings)
    }

    fn structure(&self, sample: usize) -> Result<usize> {
        match self.structures.get(sample) {
            Some(structure) => Ok(*structure),
            None => bail!("there is no sample {sample}"),
        }
    }
}

impl Content for Finished<'_> {
    fn len(&self) -> usize {
        self.structures.len()
    }

    fn voxels(&self) -> u64 {
        self.voxels
    }

    fn row(&self, sample: usize) -> Result<Row> {
        self.part.row(self.structure(sample)?)
    }

    fn sample(&self, sample: usize) -> Result<(Properties, Voxels)> {
        match self.work.get(self.structure(sample)?)?.outcome {
            Outcome::Sample(sample) => Ok((sample.properties, sample.voxels)),
            Outcome::Excluded { .. } => bail!("sample {sample} was excluded"),
        }
    }

    fn excluded(&self) -> &[Exclusion] {
        &self.excluded
    }

    fn warnings(&self) -> &BTreeMap<String, Vec<String>> {
        &self.warnings
    }
}
