//! Bound poses with all atoms: `poses/pose_01.pdb` and `poses/pose_01.cif`, the lowest energy first.
//!
//! The first body is in its own frame, as in the JSON, so that a pose there and its file agree.

use super::residues::ResidueEnergies;
use super::result::PoseResult;
use crate::export::{StructureFormat, write_structure};
use anyhow::{Context, Result};
use protomer_body::Body;
use protomer_body::structure::write::{PlacedBodies, PlacedBody, has_atoms};
use protomer_io::atomic::{remove_abandoned, write_atomically};
use protomer_kernel::{Pose, Vec3};
use protomer_mc::energy::terms::EnergyParts;
use std::path::Path;

/// The folder of the files.
const FOLDER: &str = "poses";

/// Writes the poses of the second body in the frame of the first, with the energies of residues (kT)
/// as B factors where they are known; returns warnings.
pub(super) fn write(
    directory: &Path,
    bodies: [&Body; 2],
    poses: &[PoseResult],
    residues: &[ResidueEnergies],
) -> Result<Vec<String>> {
    let folder = directory.join(FOLDER);
    remove_earlier(&folder)?;
    if poses.is_empty() {
        return Ok(Vec::new());
    }
    for body in bodies {
        if !has_atoms(body) {
            return Ok(vec![format!(
                "warning: bound poses are not written as structures: body '{}' has no atoms; make \
                 it from a structure file with 'protomer ingest'",
                body.name
            )]);
        }
    }
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let digits = poses.len().to_string().len().max(2);
    let mut refused = None;
    for (number, pose) in poses.iter().enumerate() {
        let number = number + 1;
        let mut placed = placed(bodies, number, pose);
        if let Some(energies) = residues.get(number - 1) {
            for (copy, parts) in placed.copies.iter_mut().zip(energies) {
                copy.residue_values = parts.iter().map(EnergyParts::total_kt).collect();
            }
        }
        let path = folder.join(format!("pose_{number:0digits$}"));
        write_structure(&path.with_extension("cif"), StructureFormat::Mmcif, &placed)?;
        // What does not fit the columns of PDB is in the other file.
        match placed.to_pdb() {
            Ok(text) => write_atomically(&path.with_extension("pdb"), |file| {
                file.write_all(text.as_bytes())
            })?,
            Err(error) => refused = Some(error),
        }
    }
    let warning = |error| format!("warning: bound poses are written as mmCIF only: {error}");
    Ok(refused.map(warning).into_iter().collect())
}

fn placed<'a>(
    [first, second]: [&'a Body; 2],
    number: usize,
    pose: &PoseResult,
) -> PlacedBodies<'a> {
    let of_second = Pose::from_wxyz(Vec3::from(pose.position_angstrom), pose.orientation_wxyz);
    PlacedBodies {
        title: format!(
            "{} and {}, bound pose {number}, {:.2} kT",
            first.name, second.name, pose.energy_kt
        ),
        copies: vec![
            PlacedBody::new(first, Pose::identity()),
            PlacedBody::new(second, of_second),
        ],
        box_angstrom: None,
    }
}

/// Removes the files of an earlier end of the same run, which may have had more poses or have been
/// killed while it wrote one.
fn remove_earlier(folder: &Path) -> Result<()> {
    if !folder.is_dir() {
        return Ok(());
    }
    remove_abandoned(folder)?;
    let context = || format!("cannot clear the folder {}", folder.display());
    for entry in folder.read_dir().with_context(context)? {
        let path = entry.with_context(context)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_ours =
            name.starts_with("pose_") && (name.ends_with(".pdb") || name.ends_with(".cif"));
        if is_ours {
            std::fs::remove_file(&path).with_context(context)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::structure::Structure;
    use protomer_body::{BodySettings, Source, build_body};

    const LYSINE: &str = "\
ATOM      1  N   LYS X   1      11.104   6.134  -6.504  1.00 10.00           N
ATOM      2  CA  LYS X   1      11.639   6.071  -5.147  1.00 10.00           C";

    fn lysine() -> Body {
        let source = Source {
            file: "lysine.pdb",
            sha256: "",
        };
        let built = build_body(
            "lysine",
            source,
            LYSINE.as_bytes(),
            &BodySettings::default(),
        );
        built.unwrap().body
    }

    fn poses(number: usize) -> Vec<PoseResult> {
        let pose = |index: usize| PoseResult {
            energy_kt: -3.0 + index as f64,
            parts: EnergyParts::default(),
            position_angstrom: [8.0 + index as f64, 0.0, 0.0],
            orientation_wxyz: [0.5, 0.5, -0.5, 0.5],
            share: None,
            log10_kd_molar: None,
            log10_kd_error: None,
        };
        (0..number).map(pose).collect()
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = folder.read_dir().unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn poses_are_written_in_both_formats_and_replace_earlier_ones() {
        let directory = tempfile::tempdir().unwrap();
        let body = lysine();
        let folder = directory.path().join(FOLDER);
        assert!(
            write(directory.path(), [&body; 2], &[], &[])
                .unwrap()
                .is_empty()
        );
        assert!(!folder.exists());
        for number in [3, 1] {
            assert!(
                write(directory.path(), [&body; 2], &poses(number), &[])
                    .unwrap()
                    .is_empty()
            );
            assert_eq!(names(&folder).len(), 2 * number);
        }
        std::fs::write(folder.join("notes.txt"), "mine").unwrap();
        std::fs::write(folder.join(".pose_02.pdb.12-3.partial"), "killed").unwrap();
        write(directory.path(), [&body; 2], &poses(1), &[]).unwrap();
        assert_eq!(names(&folder), ["notes.txt", "pose_01.cif", "pose_01.pdb"]);
        let pose = Pose::from_wxyz(Vec3::new(8.0, 0.0, 0.0), [0.5, 0.5, -0.5, 0.5]);
        for name in ["pose_01.cif", "pose_01.pdb"] {
            let bytes = std::fs::read(folder.join(name)).unwrap();
            let atoms = &Structure::read(name, &bytes).unwrap().models[0].atoms;
            assert_eq!(atoms.len(), 4);
            assert_eq!((&*atoms[0].chain, &*atoms[3].chain), ("A", "B"));
            let site = body.sites[1].position;
            assert!((atoms[1].position - site).amax() < 0.000_501);
            assert!((atoms[3].position - pose.transform_point(&site)).amax() < 0.000_501);
        }
    }

    #[test]
    fn what_cannot_be_written_is_warned_of() {
        let directory = tempfile::tempdir().unwrap();
        let (body, mut points) = (lysine(), lysine());
        points.residues.clear();
        for site in &mut points.sites {
            site.residue = None;
        }
        let warnings = write(directory.path(), [&body, &points], &poses(2), &[]).unwrap();
        assert!(warnings.len() == 1 && warnings[0].contains("'lysine' has no atoms"));
        assert!(!directory.path().join(FOLDER).exists());
        let mut far = poses(2);
        far[1].position_angstrom[0] = 20_000.0;
        let warnings = write(directory.path(), [&body; 2], &far, &[]).unwrap();
        assert!(
            warnings.len() == 1 && warnings[0].contains("mmCIF only"),
            "{warnings:?}"
        );
        let folder = directory.path().join(FOLDER);
        assert_eq!(
            names(&folder),
            ["pose_01.cif", "pose_01.pdb", "pose_02.cif"]
        );
    }
}
