//! The bodies of a structure, kept in the directory for its page and for other verbs.

use crate::assemblies::assemble::write_assembly;
use crate::assemblies::assembly_file::{Assembly, AssemblyFile, BodyEntry, Placement};
use crate::bodies::body_file;
use anyhow::{Context, Result};
use protomer_results::Record;
use std::path::{Path, PathBuf};

/// Folder of the bodies of a structure.
pub(super) const FOLDER: &str = "assembly";
/// Assembly file in that folder.
pub(super) const FILE: &str = "assembly.json";
/// Key of the assembly in the details of a record.
pub(super) const KEY: &str = "assembly";

/// Path of the assembly from the directory: of its own file, or of the file that [`keep`] writes.
pub(super) fn path_in(assembly: &Assembly, directory: &Path) -> Option<PathBuf> {
    match assembly.path {
        Some(_) => assembly.path_from(directory),
        None => Some(Path::new(FOLDER).join(FILE)),
    }
}

/// Writes an assembly that has no file, with a box of this edge, Å.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn keep(
    assembly: &Assembly,
    edge_angstrom: Option<f64>,
    directory: &Path,
) -> Result<()> {
    if assembly.path.is_some() {
        return Ok(());
    }
    let folder = directory.join(FOLDER);
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let mut bodies = Vec::with_capacity(assembly.bodies.len());
    for body in &assembly.bodies {
        let file = PathBuf::from(format!("{}.body", body.name));
        body_file::write(&folder.join(&file), body)?;
        bodies.push(BodyEntry {
            name: body.name.clone(),
            file,
        });
    }
    let placed = assembly.kinds.iter().zip(&assembly.poses);
    let file = AssemblyFile {
        box_angstrom: edge_angstrom.map(|edge| [edge; 3]),
        wall_radius_angstrom: None,
        placements: placed
            .map(|(kind, pose)| Placement::new(&assembly.bodies[*kind].name, pose))
            .collect(),
        bodies,
        provenance: None,
    };
    write_assembly(&folder.join(FILE), &file, true)
}

/// The assembly that a record names.
///
/// # Errors
/// If the record names none, or its files are gone.
pub(super) fn of_record(directory: &Path, record: &Record) -> Result<Assembly> {
    let path = record.details[KEY].as_str();
    let path = path.context("run.json names no assembly")?;
    Assembly::read(&directory.join(path))
}
