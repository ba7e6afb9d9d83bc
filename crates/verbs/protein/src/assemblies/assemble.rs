//! Bodies with their files, and the assembly files that place them.

use crate::assemblies::assembly_file::{AssemblyFile, BodyEntry, Placement};
use crate::bodies::body_file;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_body::assembly::{self, HardBodies, HardBody};
use protomer_common::output_file::{refuse_to_replace, write_once};
use protomer_kernel::{Pose, Vec3};
use std::path::{Component, Path, PathBuf};

/// The neighbouring cells of a periodic box, one of each opposite pair.
const HALF_OF_NEIGHBOURS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// Bodies with the files they were read from.
#[derive(Debug)]
pub struct BodyFiles {
    /// The files.
    pub paths: Vec<PathBuf>,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// The bodies, prepared for overlap tests.
    pub hard: HardBodies,
}

impl BodyFiles {
    /// Reads body files.
    ///
    /// # Errors
    /// Names the file that cannot be read.
    pub fn read(paths: &[PathBuf]) -> Result<Self> {
        let mut bodies = Vec::with_capacity(paths.len());
        for path in paths {
            let (body, _) = body_file::read(path)?;
            bodies.push(body);
        }
        Self::new(paths.to_vec(), bodies)
    }

    /// Bodies that will be written to these files.
    ///
    /// # Errors
    /// Names the file of the body whose mesh bounds no solid.
    pub fn new(paths: Vec<PathBuf>, bodies: Vec<Body>) -> Result<Self> {
        let mut hard = Vec::with_capacity(bodies.len());
        for (body, path) in bodies.iter().zip(&paths) {
            hard.push(HardBody::from_body(body).with_context(|| path.display().to_string())?);
        }
        Ok(Self {
            paths,
            bodies,
            hard: HardBodies::new(hard),
        })
    }

    /// Describes placements as an assembly file; the names of body files are relative to `path`.
    ///
    /// # Errors
    /// If a folder does not exist.
    pub fn assembly_file(
        &self,
        path: &Path,
        placements: &[assembly::Placement],
        box_angstrom: Option<[f64; 3]>,
        provenance: serde_json::Value,
    ) -> Result<AssemblyFile> {
        let names = self.names();
        let mut bodies = Vec::new();
        for (name, file) in names.iter().zip(&self.paths) {
            bodies.push(BodyEntry {
                name: name.clone(),
                file: relative_to(file, path)?,
            });
        }
        let placements = placements
            .iter()
            .map(|(kind, pose)| Placement::new(&names[*kind], pose))
            .collect();
        let file = AssemblyFile {
            box_angstrom,
            wall_radius_angstrom: None,
            bodies,
            placements,
            provenance: Some(provenance),
        };
        Ok(file)
    }

    /// Refuses a periodic box in which bodies overlap across its faces.
    ///
    /// # Errors
    /// Says how large a box is large enough.
    pub fn require_room(
        &self,
        placements: &[assembly::Placement],
        box_angstrom: Option<[f64; 3]>,
    ) -> Result<()> {
        let Some([x, y, z]) = box_angstrom else {
            return Ok(());
        };
        let mut all = placements.to_vec();
        for shift in HALF_OF_NEIGHBOURS {
            let shift = Vec3::new(shift[0] * x, shift[1] * y, shift[2] * z);
            for (kind, pose) in placements {
                let position = pose.position + shift;
                all.push((*kind, Pose { position, ..*pose }));
            }
        }
        if !self.hard.any_overlap(&all) {
            return Ok(());
        }
        let radius = |kind: usize| self.bodies[kind].mesh_radius_angstrom();
        let mut needed_angstrom: f64 = 0.0;
        for (kind, pose) in placements {
            for (other, other_pose) in placements {
                let apart = (pose.position - other_pose.position).norm();
                needed_angstrom = needed_angstrom.max(apart + radius(*kind) + radius(*other));
            }
        }
        bail!(
            "in a box of {x} x {y} x {z} Å the bodies overlap with their own images; give a larger \
             one, such as --box {:.0}",
            needed_angstrom.ceil()
        )
    }

    /// The names by which placements refer to bodies: their own names, numbered where two share
    /// one.
    fn names(&self) -> Vec<String> {
        let mut names = Vec::with_capacity(self.bodies.len());
        for (index, body) in self.bodies.iter().enumerate() {
            let name = &body.name;
            let sharing = self.bodies.iter().filter(|other| other.name == *name);
            names.push(match sharing.count() {
                1 => name.clone(),
                _ => format!("{name}-{}", index + 1),
            });
        }
        names
    }
}

/// Writes an assembly file.
///
/// # Errors
/// If it exists with other content and `force` is not set, or cannot be written.
pub fn write_assembly(path: &Path, file: &AssemblyFile, force: bool) -> Result<()> {
    let text = text_of(file)?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    }
    write_once(path, &text, force)
}

/// Refuses a file that exists and holds anything but exactly this assembly, unless `force` is set.
///
/// # Errors
/// If it does.
pub fn refuse_another(path: &Path, file: &AssemblyFile, force: bool) -> Result<()> {
    refuse_to_replace(path, text_of(file)?.as_bytes(), force)
}

fn text_of(file: &AssemblyFile) -> Result<String> {
    let text = serde_json::to_string_pretty(file).context("the assembly cannot be serialised")?;
    Ok(text + "\n")
}

/// The path from the folder of `from` to `file`.
fn relative_to(file: &Path, from: &Path) -> Result<PathBuf> {
    let folder = match from.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let (file, folder) = (absolute(file)?, absolute(folder)?);
    let both = file.components().zip(folder.components());
    let shared = both.take_while(|(a, b)| a == b).count();
    let levels_up = folder.components().count() - shared;
    let mut relative: PathBuf = std::iter::repeat_n(Component::ParentDir, levels_up).collect();
    relative.extend(file.components().skip(shared));
    Ok(relative)
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).with_context(|| path.display().to_string())
}
