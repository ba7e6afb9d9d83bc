//! Assembly files: which bodies there are and where they are placed.
//!
//! ```json
//! {"box_angstrom": [600, 600, 600],
//!  "bodies": [{"name": "a", "file": "a.body"}],
//!  "placements": [{"body": "a", "position_angstrom": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}]}
//! ```
//!
//! File names are relative to the assembly file. A `null` box is open space; `wall_radius_angstrom`
//! puts a spherical wall around the origin instead.

use crate::bodies::body_file;
use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::{Body, check_name};
use protomer_common::input::{cannot_read, path_from};
use protomer_kernel::mesh::LARGEST_COORDINATE_ANGSTROM;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_results::keys;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An assembly as written in its file.
///
/// ```
/// use protomer_protein_verbs::assemblies::assembly_file::AssemblyFile;
/// let text = r#"{
///     "box_angstrom": [600, 600, 600],
///     "bodies": [{"name": "a", "file": "a.body"}],
///     "placements": [
///         {"body": "a", "position_angstrom": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}
///     ]
/// }"#;
/// let file: AssemblyFile = serde_json::from_str(text)?;
/// assert_eq!(file.placements[0].body, "a");
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AssemblyFile {
    /// Edge lengths of the periodic box, Å; `None` for open space.
    #[serde(default)]
    pub box_angstrom: Option<[f64; 3]>,
    /// Radius of a spherical wall around the origin, Å.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_radius_angstrom: Option<f64>,
    /// The kinds of bodies.
    pub bodies: Vec<BodyEntry>,
    /// The placed bodies.
    pub placements: Vec<Placement>,
    /// Origin of the assembly: a note for readers, ignored by the engines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<serde_json::Value>,
}

/// A kind of body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyEntry {
    /// Name by which placements refer to the kind.
    pub name: String,
    /// The body file, relative to the assembly file.
    pub file: PathBuf,
}

/// One body of the assembly.
///
/// ```
/// use protomer_kernel::Pose;
/// use protomer_protein_verbs::assemblies::assembly_file::Placement;
/// let placement = Placement::new("6mdr_A", &Pose::identity());
/// assert_eq!(placement.orientation_wxyz, [1.0, 0.0, 0.0, 0.0], "scalar first");
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Name of the kind of body.
    pub body: String,
    /// Position of the body's origin, Å.
    pub position_angstrom: [f64; 3],
    /// Orientation as a quaternion, scalar first.
    pub orientation_wxyz: [f64; 4],
}

impl Placement {
    /// The placement of a body of this kind at this pose.
    pub fn new(body: &str, pose: &Pose) -> Self {
        Self {
            body: body.to_owned(),
            position_angstrom: pose.position.into(),
            orientation_wxyz: pose.wxyz(),
        }
    }
}

/// An assembly with its bodies loaded.
///
/// ```no_run
/// use protomer_protein_verbs::assemblies::assembly_file::Assembly;
/// use std::path::Path;
/// let assembly = Assembly::read(Path::new("6mdr/assembly.json"))?;
/// println!("{} bodies of {} kinds", assembly.len(), assembly.bodies.len());
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Assembly {
    /// The kinds of bodies.
    pub bodies: Vec<Arc<Body>>,
    /// The kind of each body, an index into `bodies`.
    pub kinds: Vec<usize>,
    /// The pose of each body.
    pub poses: Vec<Pose>,
    /// Space that contains the bodies.
    pub boundary: Boundary,
    /// SHA-256 over the assembly file and the body files, in hexadecimal: the identity of the
    /// input.
    pub sha256: String,
    /// The assembly file; `None` for an assembly that was not read from one.
    pub path: Option<PathBuf>,
}

impl Assembly {
    /// Reads an assembly file and the body files it names.
    ///
    /// # Errors
    /// Names the file, the key or the placement, and what to do.
    pub fn read(path: &Path) -> Result<Self> {
        FileKind::Assembly.require(path)?;
        let bytes =
            protomer_io::input::read(path).with_context(|| cannot_read("the assembly", path))?;
        let file: AssemblyFile = keys::from_json(path, &bytes)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let mut bodies = Vec::new();
        let mut identity = bytes;
        for entry in &file.bodies {
            let body_path = folder.join(&entry.file);
            let (body, sha256) = body_file::read(&body_path)
                .with_context(|| format!("body '{}' of {}", entry.name, path.display()))?;
            identity.extend_from_slice(sha256.as_bytes());
            bodies.push(Arc::new(body));
        }
        let mut assembly =
            Self::assemble(&file, bodies).with_context(|| path.display().to_string())?;
        assembly.sha256 = protomer_io::atomic::sha256_hex(&identity);
        assembly.path = Some(path.to_owned());
        Ok(assembly)
    }

    /// Puts loaded bodies (in the order of `file.bodies`) at the placements of a file.
    ///
    /// # Errors
    /// Names the invalid placement.
    pub fn assemble(file: &AssemblyFile, bodies: Vec<Arc<Body>>) -> Result<Self> {
        if file.placements.is_empty() {
            bail!("the assembly contains no bodies; add entries to 'placements'");
        }
        for (index, entry) in file.bodies.iter().enumerate() {
            check_name(&entry.name).with_context(|| format!("entry {index} of 'bodies'"))?;
            if file.bodies[..index]
                .iter()
                .any(|earlier| earlier.name == entry.name)
            {
                bail!(
                    "two entries of 'bodies' are named '{}'; give each a unique name",
                    entry.name
                );
            }
        }
        let mut kinds = Vec::with_capacity(file.placements.len());
        let mut poses = Vec::with_capacity(file.placements.len());
        for (index, placement) in file.placements.iter().enumerate() {
            let Some(kind) = file
                .bodies
                .iter()
                .position(|entry| entry.name == placement.body)
            else {
                let names: Vec<&str> = file
                    .bodies
                    .iter()
                    .map(|entry| entry.name.as_str())
                    .collect();
                bail!(
                    "placement {index} names body '{}', but 'bodies' has only {}",
                    placement.body,
                    names.join(", ")
                );
            };
            kinds.push(kind);
            poses.push(checked_pose(placement).with_context(|| format!("placement {index}"))?);
        }
        Ok(Self {
            bodies,
            kinds,
            poses,
            boundary: boundary_of(file)?,
            sha256: String::new(),
            path: None,
        })
    }

    /// Number of placed bodies.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether no body is placed.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The relative path from a directory to the assembly file. It stays valid when a folder
    /// that holds both is moved. `None` without a file, or if there is no relative path.
    pub fn path_from(&self, directory: &Path) -> Option<PathBuf> {
        path_from(self.path.as_ref()?, directory)
    }

    /// Edge lengths of the periodic box, Å.
    pub fn box_angstrom(&self) -> Option<[f64; 3]> {
        match self.boundary {
            Boundary::Periodic { lengths_angstrom } => Some(lengths_angstrom.into()),
            Boundary::Open | Boundary::SphereWall { .. } => None,
        }
    }

    /// Concentration of the bodies, mol/L; zero in open space.
    pub fn concentration_molar(&self) -> f64 {
        self.len() as f64
            / self.boundary.volume_angstrom3()
            / protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR
    }
}

fn checked_pose(placement: &Placement) -> Result<Pose> {
    let norm = placement
        .orientation_wxyz
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    if !placement
        .position_angstrom
        .iter()
        .all(|x| x.abs() <= LARGEST_COORDINATE_ANGSTROM)
    {
        bail!(
            "position_angstrom must be three numbers within {LARGEST_COORDINATE_ANGSTROM:.0} Å of the origin"
        );
    }
    if !(norm.is_finite() && (norm - 1.0).abs() < 1e-3) {
        bail!("orientation_wxyz has length {norm:.4}; give a unit quaternion, scalar first");
    }
    Ok(Pose::from_wxyz(
        Vec3::from(placement.position_angstrom),
        placement.orientation_wxyz,
    ))
}

fn boundary_of(file: &AssemblyFile) -> Result<Boundary> {
    match (file.box_angstrom, file.wall_radius_angstrom) {
        (Some(_), Some(_)) => bail!("give 'box_angstrom' or 'wall_radius_angstrom', not both"),
        (Some(lengths), None) => {
            Ok(Boundary::periodic(Vec3::from(lengths)).context("box_angstrom")?)
        }
        (None, Some(radius)) if radius.is_finite() && radius > 0.0 => Ok(Boundary::SphereWall {
            radius_angstrom: radius,
        }),
        (None, Some(radius)) => bail!("wall_radius_angstrom is {radius}; it must be positive"),
        (None, None) => Ok(Boundary::Open),
    }
}
