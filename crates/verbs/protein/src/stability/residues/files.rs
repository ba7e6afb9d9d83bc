//! What is written: JSON, CSV, figures, and a structure coloured by energy.

use super::frames::{AtSalt, Run};
use super::maps::{contact_map, energy_map};
use super::result::{FILE, ResiduesResult};
use super::settings::ResiduesSettings;
use super::tables;
use crate::export::{StructureFormat, gather, write_structure};
use anyhow::{Context, Result, bail};
use protomer_body::structure::write::{PlacedBodies, PlacedBody, has_atoms};
use protomer_common::answer::Answer;
use protomer_common::output_file::refuse_to_overwrite;
use protomer_io::atomic::write_bytes;
use std::path::{Path, PathBuf};

/// The folder in the directory of a run.
pub const FOLDER: &str = "residues";
/// The structure whose B factors are the energies of residues.
const STRUCTURE: &str = "residues.cif";
/// Ends of the scale of colours, kT.
const LIMITS_KT: [f64; 8] = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// Folder of the files; `None` for none.
fn folder(settings: &ResiduesSettings, run: &Run) -> Option<PathBuf> {
    let of_run = run.directory.as_ref().map(|run| run.join(FOLDER));
    settings.output.clone().or(of_run)
}

/// Refuses files that could not be written, before the work.
pub fn require_writable(settings: &ResiduesSettings, run: &Run) -> Result<()> {
    let Some(folder) = folder(settings, run) else {
        if settings.script.is_some() {
            bail!(
                "a script and its structure are written to one folder; name a folder for both with -o FOLDER"
            );
        }
        return Ok(());
    };
    if folder.is_file() {
        bail!(
            "{} is a file; name a folder with -o, which is made if needed",
            folder.display()
        );
    }
    refuse_to_overwrite(&folder.join(FILE), settings.force)
}

/// Writes the files and names them in the result.
pub fn write(
    result: &mut ResiduesResult,
    settings: &ResiduesSettings,
    run: &Run,
    ensemble: &AtSalt,
) -> Result<()> {
    let Some(folder) = folder(settings, run) else {
        return Ok(());
    };
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut files = vec![
        ("residues.csv", tables::residues(&result.residues)?),
        ("residue_pairs.csv", tables::pairs(&result.pairs)?),
    ];
    if let Some(mutations) = &result.mutations {
        files.push(("mutations.csv", tables::mutations(mutations)?));
    }
    let mut written = Vec::new();
    for (name, text) in files {
        written.push(write_text(&folder, name, &text)?);
    }
    if let Some(figure) = result.figure() {
        figure.write_svg(&folder.join("residues.svg"))?;
        figure.write_png(&folder.join("residues.png"))?;
        written.push(folder.join("residues.png"));
    }
    let maps = [
        ("contact_map", contact_map(result)),
        ("energy_map", energy_map(result)),
    ];
    for (name, map) in maps {
        if let Some(map) = map {
            let path = folder.join(name);
            map.write_svg(&path.with_extension("svg"))?;
            map.write_png(&path.with_extension("png"))?;
            written.push(path.with_extension("png"));
        }
    }
    written.extend(structure(result, settings, run, ensemble, &folder)?);
    written.push(folder.join(FILE));
    result.files = written;
    let json = serde_json::to_string_pretty(result).context("the result cannot be serialised")?;
    write_text(&folder, FILE, &(json + "\n"))?;
    Ok(())
}

fn write_text(folder: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let path = folder.join(name);
    write_bytes(&path, text.as_bytes())?;
    Ok(path)
}

/// The last frame with the energies of residues as B factors, and a script that colours by them.
fn structure(
    result: &ResiduesResult,
    settings: &ResiduesSettings,
    run: &Run,
    ensemble: &AtSalt,
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    let assembly = run.assembly();
    let all_have_atoms = assembly.bodies.iter().all(|body| has_atoms(body));
    let (Some(poses), true) = (ensemble.last_of_first(), all_have_atoms) else {
        return Ok(Vec::new());
    };
    let mut poses = poses.clone();
    if let Some(lengths) = assembly.box_angstrom() {
        let positions = poses.iter_mut().map(|pose| &mut pose.position);
        gather(&mut positions.collect::<Vec<_>>(), lengths);
    }
    let mut values: Vec<Vec<f64>> = Vec::new();
    let mut rows = result.residues.iter();
    for body in &assembly.bodies {
        let of_body = rows.by_ref().take(body.residues.len());
        values.push(of_body.map(|row| row.energy_kt.mean).collect());
    }
    let mut copies = Vec::with_capacity(poses.len());
    for (kind, pose) in assembly.kinds.iter().zip(poses) {
        copies.push(PlacedBody {
            residue_values: values[*kind].clone(),
            ..PlacedBody::new(&assembly.bodies[*kind], pose)
        });
    }
    let placed = PlacedBodies {
        title: format!("energy by residue, kT: {}", result.conditions()),
        copies,
        box_angstrom: assembly.box_angstrom(),
    };
    let path = folder.join(STRUCTURE);
    let chains = write_structure(&path, StructureFormat::Mmcif, &placed)?;
    let mut written = vec![path.clone()];
    if let Some(viewer) = settings.script {
        let script = viewer.path_beside(&path);
        let limit = limit_kt(&values);
        let text = viewer.script(&path, &placed, &chains, Some(limit))?;
        let name = script.file_name().unwrap_or_default().to_string_lossy();
        written.push(write_text(folder, &name, &text)?);
    }
    Ok(written)
}

/// The smallest scale that covers all values.
fn limit_kt(values: &[Vec<f64>]) -> f64 {
    let sizes = values.iter().flatten().map(|value| value.abs());
    let most = sizes.fold(0.0, f64::max);
    let [.., largest] = LIMITS_KT;
    let covering = LIMITS_KT.into_iter().find(|limit| *limit >= most);
    covering.unwrap_or(largest)
}
