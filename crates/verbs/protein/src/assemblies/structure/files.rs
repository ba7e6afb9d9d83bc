//! The files of a structure, and what in them becomes a body.

use crate::bodies::chain_groups::{ChainNames, chains_of, stated_groups, ungrouped};
use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::assembly::{Unit, units_of_chains};
use protomer_body::structure::{Selection, SelectionSettings, Structure};
use protomer_body::structure_warnings;
use protomer_common::input::{InputFile, stem};
use std::path::{Path, PathBuf};

/// A file of a structure.
pub(super) struct File {
    pub name: String,
    pub sha256: String,
    pub stem: String,
    pub selection: Selection,
    /// Warnings about the file and its chains, as `ingest` gives them.
    pub warnings: Vec<String>,
}

/// Reads the files, which are in one frame.
pub(super) fn read(paths: &[PathBuf], settings: &SelectionSettings) -> Result<Vec<File>> {
    paths.iter().map(|path| read_one(path, settings)).collect()
}

fn read_one(path: &Path, settings: &SelectionSettings) -> Result<File> {
    FileKind::Structure.require(path)?;
    let file = InputFile::read(path)?;
    let structure = Structure::read(&file.name, &file.bytes)?;
    let selection = structure
        .select(settings)
        .with_context(|| file.name.clone())?;
    Ok(File {
        stem: stem(path),
        warnings: structure_warnings(&structure, &selection.report),
        selection,
        name: file.name,
        sha256: file.sha256,
    })
}

/// A unit with the index of its file and the name of the body made of it.
pub(super) struct NamedUnit {
    pub file: usize,
    pub body: String,
    pub unit: Unit,
}

/// The units that become bodies: each chain of a single file, or each of several files as a whole;
/// or the bodies that the user stated, and each chain of no stated body by itself.
pub(super) fn units(files: &[File], stated: &[ChainNames]) -> Result<Vec<NamedUnit>> {
    if !stated.is_empty() {
        return stated_units(files, stated);
    }
    if let [file] = files {
        let units = units_of_chains(&file.selection).into_iter();
        return Ok(units.map(|unit| named(files, 0, unit)).collect());
    }
    let mut units = Vec::with_capacity(files.len());
    for (index, file) in files.iter().enumerate() {
        if files[..index].iter().any(|other| other.name == file.name) {
            bail!(
                "{} is given twice; give each part of the complex once",
                file.name
            );
        }
        units.push(NamedUnit {
            file: index,
            body: file.stem.clone(),
            unit: Unit::of_selection(&file.stem, &file.selection),
        });
    }
    Ok(units)
}

fn stated_units(files: &[File], stated: &[ChainNames]) -> Result<Vec<NamedUnit>> {
    let chains: Vec<Vec<String>> = files
        .iter()
        .map(|file| chains_of(&file.selection))
        .collect();
    let groups = stated_groups(&with_copies(stated, &chains), &chains)?;
    let mut units = Vec::new();
    for group in &groups {
        let selection = &files[group.file].selection;
        units.push((group.file, Unit::of_chains(selection, &group.chains)));
    }
    for (file, chain) in ungrouped(&groups, &chains) {
        let selection = &files[file].selection;
        units.push((file, Unit::of_chains(selection, &[chain])));
    }
    Ok(units
        .into_iter()
        .map(|(file, unit)| named(files, file, unit))
        .collect())
}

/// The stated bodies with their copies in a biological assembly: `H-2,L-2` for `H,L`.
fn with_copies(stated: &[ChainNames], chains: &[Vec<String>]) -> Vec<ChainNames> {
    let is_stated = |chain: &String| stated.iter().any(|names| names.0.contains(chain));
    let mut all = Vec::new();
    for names in stated {
        all.push(names.clone());
        for copy in 2.. {
            let of_copy: Vec<String> = names
                .0
                .iter()
                .map(|name| format!("{name}-{copy}"))
                .collect();
            let is_there = |chain: &String| chains.iter().flatten().any(|name| name == chain);
            if !of_copy.iter().all(is_there) || of_copy.iter().any(is_stated) {
                break;
            }
            all.push(ChainNames(of_copy));
        }
    }
    all
}

fn named(files: &[File], file: usize, unit: Unit) -> NamedUnit {
    NamedUnit {
        body: format!("{}_{}", files[file].stem, unit.name.replace(',', "_")),
        file,
        unit,
    }
}
