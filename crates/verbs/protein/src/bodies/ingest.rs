//! Converts structure files to body files in parallel. A file that fails is reported; the others
//! continue.

use crate::bodies::body_file;
use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::structure::Structure;
use protomer_body::structure::{Format, SelectionReport};
use protomer_body::{Body, BodyError, BodySettings, BuiltBody, Draft, Source, check_name};
use protomer_common::answer::{Answer, columns, heading};
use protomer_common::input::{InputFile, stem};
use protomer_common::output_file::write_once;
use protomer_common::remedy;
use protomer_field::titration::SolvedProtonation;
use protomer_io::mesh::{MeshFormat, write_mesh};
use protomer_io::points::PointRecord;
use protomer_io::pqr::{read_pqr_file, write_pqr};
use protomer_io::written::LONGEST_FILE_NAME_BYTES;
use protomer_kernel::name::printable;
use protomer_kernel::plain_text::line_end_warning;
use protomer_results::{Progress, ResultKind};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Settings for the conversion of each file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct IngestSettings {
    /// Settings with which bodies are made.
    pub body: BodySettings,
    /// Name of the body, for a single file.
    pub name: Option<String>,
    /// File extensions of the formats to write along with the body file.
    pub exports: Vec<&'static str>,
    /// Whether to overwrite existing bodies.
    pub force: bool,
}

/// The outcome for one file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileOutcome {
    /// The input file.
    pub file: String,
    /// SHA-256 of the file as stored; empty if it cannot be read.
    #[serde(skip)]
    pub sha256: String,
    /// `ok` or `failed`.
    pub status: &'static str,
    /// The body file.
    pub body: Option<PathBuf>,
    /// The size and charge of the body.
    #[serde(flatten)]
    pub measures: Option<BodyMeasures>,
    /// Distance of the mesh from the exact surface.
    #[serde(flatten)]
    pub distance: Option<MeshDistance>,
    /// Atoms left out, by reason.
    pub skipped: BTreeMap<&'static str, usize>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// The full report on the selection of atoms.
    pub selection: Option<SelectionReport>,
    /// The reason for the failure.
    pub error: Option<String>,
}

/// Distance of a mesh from the surface that it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeshDistance {
    /// Root mean square over the mesh, Å.
    pub mesh_rms_distance_angstrom: f64,
    /// Largest distance found, Å.
    pub mesh_largest_distance_angstrom: f64,
}

/// Summary numbers of a body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodyMeasures {
    /// Atoms (charge sites).
    pub atoms: usize,
    /// Residues.
    pub residues: usize,
    /// Sum of the charges, e.
    pub net_charge_e: f64,
    /// Mesh vertices.
    pub vertices: usize,
    /// Mesh triangles.
    pub triangles: usize,
    /// Area of the mesh, Å².
    pub mesh_area_angstrom2: f64,
    /// Volume of the mesh, Å³.
    pub mesh_volume_angstrom3: f64,
    /// Radius of the sphere around the origin that encloses the mesh, Å.
    pub radius_angstrom: f64,
}

impl BodyMeasures {
    /// Measures a body.
    pub fn from_body(body: &Body) -> Self {
        Self {
            atoms: body.sites.len(),
            residues: body.residues.len(),
            net_charge_e: body.net_charge_e(),
            vertices: body.mesh.vertices.len(),
            triangles: body.mesh.triangles.len(),
            mesh_area_angstrom2: body.mesh.area_angstrom2(),
            mesh_volume_angstrom3: body.mass_properties.volume_angstrom3,
            radius_angstrom: body.mesh_radius_angstrom(),
        }
    }
}

/// The outcomes for several files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ingested {
    /// One entry per file, in the order given.
    pub files: Vec<FileOutcome>,
}

impl Ingested {
    /// Whether any file failed.
    pub fn has_failures(&self) -> bool {
        self.files.iter().any(|outcome| outcome.error.is_some())
    }
}

impl Answer for Ingested {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "file",
            "status",
            "atoms",
            "residues",
            "net charge (e)",
            "area (Å²)",
            "volume (Å³)",
            "mesh off by (Å)",
            "skipped",
        ])];
        rows.extend(self.files.iter().map(FileOutcome::cells));
        columns(&rows)
    }
}

impl FileOutcome {
    fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.file.clone(), self.status.into()];
        let (Some(body), Some(distance)) = (&self.measures, &self.distance) else {
            return cells;
        };
        let mut skipped = Vec::new();
        for (reason, count) in &self.skipped {
            skipped.push(format!("{count} {reason}"));
        }
        cells.extend([
            body.atoms.to_string(),
            body.residues.to_string(),
            format!("{:+.2}", body.net_charge_e),
            format!("{:.0}", body.mesh_area_angstrom2),
            format!("{:.0}", body.mesh_volume_angstrom3),
            format!(
                "{:.3} rms, {:.2} at most",
                distance.mesh_rms_distance_angstrom, distance.mesh_largest_distance_angstrom
            ),
            skipped.join(", "),
        ]);
        cells
    }
}

/// Ingests every file into `folder`.
///
/// # Errors
/// If the folder cannot be created or two files would give the same body. An error in a single
/// file is reported in its outcome.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::ingest::{IngestSettings, ingest_files};
/// use protomer_body::BodySettings;
/// use std::path::{Path, PathBuf};
/// let settings = IngestSettings {
///     body: BodySettings::default(),
///     name: None,
///     exports: vec!["ply"],
///     force: false,
/// };
/// let files = [PathBuf::from("5pti.cif.gz")];
/// let ingested = ingest_files(&files, Path::new("bodies"), &settings, &())?;
/// assert!(!ingested.has_failures());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn ingest_files(
    files: &[PathBuf],
    folder: &Path,
    settings: &IngestSettings,
    progress: &dyn Progress,
) -> Result<Ingested> {
    settings.body.surface.check()?;
    ResultKind::VoxelSet.refuse_in(folder)?;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let names = body_names(files, settings)?;
    let jobs: Vec<(&PathBuf, String)> = files.iter().zip(names).collect();
    progress.begin(jobs.len() as u64, "files");
    let one = |(file, name): (&PathBuf, String)| {
        let outcome = ingest_one(file, &name, folder, settings);
        progress.advance(1);
        outcome.unwrap_or_else(|error| FileOutcome::failed(file, &error))
    };
    Ok(Ingested {
        files: jobs.into_par_iter().map(one).collect(),
    })
}

/// Converts one file. An error in the file is its outcome.
///
/// # Errors
/// If the body cannot be written, which says nothing of the file.
pub(super) fn ingest_one(
    file: &Path,
    name: &str,
    folder: &Path,
    settings: &IngestSettings,
) -> Result<FileOutcome> {
    match read_and_build(file, name, &settings.body) {
        Ok(built) => keep(file, name, built, folder, settings),
        Err(error) => Ok(FileOutcome::failed(file, &error)),
    }
}

/// One name per file. Files with the same stem (1crn.pdb and 1crn.cif) keep their extensions
/// to remain distinct.
pub(super) fn body_names(files: &[PathBuf], settings: &IngestSettings) -> Result<Vec<String>> {
    if let Some(name) = &settings.name {
        refuse_path(name)?;
        return Ok(vec![name.clone()]);
    }
    let stems: Vec<String> = files.iter().map(|file| stem(file)).collect();
    let shared = repeated(&stems);
    let mut names = Vec::with_capacity(files.len());
    for (file, stem) in files.iter().zip(stems) {
        names.push(if shared.contains(&stem) {
            full_name(file)
        } else {
            stem
        });
    }
    if let Some(name) = repeated(&names).first() {
        bail!("two input files are named {name}; ingest them into different folders");
    }
    Ok(names)
}

/// Refuses a name that leads out of the folder of its body file, or is too long for a file.
pub(super) fn refuse_path(name: &str) -> Result<()> {
    if name.len() > LONGEST_FILE_NAME_BYTES {
        bail!(
            "the name '{}...' has {} bytes, and that of a body file at most \
             {LONGEST_FILE_NAME_BYTES}; give a shorter one",
            printable(&name.chars().take(20).collect::<String>()),
            name.len()
        );
    }
    if name.contains(['/', '\\', '\0']) {
        bail!(
            "the name '{}' cannot be that of a body file; give one without / and \\",
            printable(name)
        );
    }
    Ok(())
}

/// The names that occur more than once.
fn repeated(names: &[String]) -> BTreeSet<String> {
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort_unstable();
    let equal = sorted.windows(2).filter(|pair| pair[0] == pair[1]);
    equal.map(|pair| pair[0].clone()).collect()
}

fn full_name(file: &Path) -> String {
    let name = file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    name.strip_suffix(".gz").unwrap_or(&name).replace('.', "_")
}

/// Keeps a body in a folder. A body that has no file of a further format is a failure of its input.
///
/// # Errors
/// If a file holds something else or cannot be written.
pub(super) fn keep(
    file: &Path,
    name: &str,
    built: BuiltBody,
    folder: &Path,
    settings: &IngestSettings,
) -> Result<FileOutcome> {
    let exports = match exports(&built.body, folder, name, settings) {
        Ok(exports) => exports,
        Err(error) => return Ok(FileOutcome::failed(file, &error)),
    };
    let path = folder.join(format!("{name}.body"));
    let force = settings.force;
    body_file::refuse_another(&path, &built.body, force)
        .with_context(|| file.display().to_string())?;
    for (path, bytes) in &exports {
        write_once(path, bytes, force)?;
    }
    body_file::write_once(&path, &built.body, force)?;
    let skipped = match &built.selection {
        Some(report) => report.skipped.clone(),
        None => BTreeMap::new(),
    };
    Ok(FileOutcome {
        file: file.display().to_string(),
        sha256: built.body.provenance.source_sha256.clone(),
        status: "ok",
        body: Some(path),
        measures: Some(BodyMeasures::from_body(&built.body)),
        distance: Some(MeshDistance {
            mesh_rms_distance_angstrom: built.deviation.rms_angstrom,
            mesh_largest_distance_angstrom: built.deviation.largest_angstrom,
        }),
        skipped,
        warnings: built.warnings,
        selection: built.selection,
        error: None,
    })
}

/// Makes a body from a structure file.
///
/// # Errors
/// Names the file and the line or residue, and says what to do.
///
/// ```
/// use protomer_protein_verbs::bodies::ingest::read_and_build;
/// use protomer_body::BodySettings;
/// use std::path::Path;
/// let mut settings = BodySettings::default();
/// settings.surface.density_per_angstrom2 = 0.1;
/// let file = Path::new("../../../data/structures/5pti.cif.gz");
/// let built = read_and_build(file, "bpti", &settings)?;
/// assert_eq!(built.body.residues.len(), 58);
/// assert!(built.body.net_charge_e() > 4.0);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn read_and_build(file: &Path, name: &str, settings: &BodySettings) -> Result<BuiltBody> {
    FileKind::Structure.require(file)?;
    let input = InputFile::read(file)?;
    let source = Source {
        file: &input.name,
        sha256: &input.sha256,
    };
    let format = Format::of_file(&input.name, &input.bytes)?;
    if format != Format::Pqr {
        return build_of_structure(name, source, &input.bytes, settings)
            .map_err(|error| named(&input.name, error));
    }
    build_of_pqr(name, &input, settings)
}

fn build_of_structure(
    name: &str,
    source: Source<'_>,
    bytes: &[u8],
    settings: &BodySettings,
) -> protomer_body::Result<BuiltBody> {
    check_name(name)?;
    let structure = Structure::read(source.file, bytes)?;
    let selection = structure.select(&settings.selection)?;
    let solved = &SolvedProtonation;
    let draft = Draft::of_protonated_selection(name, source, selection, settings, solved)?;
    draft.with_warnings_of(&structure).build()
}

/// Makes a body of a PQR file, whose atoms, charges and radii are taken as they are.
fn build_of_pqr(name: &str, input: &InputFile, settings: &BodySettings) -> Result<BuiltBody> {
    refuse_settings_of_structures(settings).with_context(|| input.name.clone())?;
    let source = Source {
        file: &input.name,
        sha256: &input.sha256,
    };
    let file = read_pqr_file(&input.name, &input.bytes)?;
    let draft = Draft::of_points(name, source, &file.atoms, &settings.surface);
    let mut draft = draft.map_err(|error| named(&input.name, error))?;
    if let Some(warning) = Format::Pqr.contradiction(&input.name) {
        draft = draft.with_warning(warning);
    }
    if let Some(warning) = line_end_warning(&input.bytes) {
        draft = draft.with_warning(warning);
    }
    if let Some(warning) = file.models_warning() {
        draft = draft.with_warning(warning);
    }
    draft.build().map_err(|error| named(&input.name, error))
}

/// Refuses settings that select or charge the atoms of a structure, and would do nothing to those of
/// a PQR file.
fn refuse_settings_of_structures(settings: &BodySettings) -> Result<()> {
    let default = BodySettings::default();
    let (selection, sites) = (&settings.selection, &settings.sites);
    let (plain, plain_sites) = (&default.selection, &default.sites);
    let mut without_effect = Vec::new();
    for (flag, is_set) in [
        ("--chain", selection.chains != plain.chains),
        ("--residues", selection.residues != plain.residues),
        ("--model", selection.model != plain.model),
        ("--assembly", selection.assembly != plain.assembly),
        ("--altloc", selection.alternate != plain.alternate),
        ("--keep-ligands", selection.keep_ligands),
        ("--keep-waters", selection.keep_waters),
        ("--keep-hydrogens", selection.keep_hydrogens),
        ("--keep-nucleic-acids", selection.keep_nucleic_acids),
        ("--missing", selection.missing != plain.missing),
        ("--ph", sites.ph != plain_sites.ph),
        ("--charges", sites.charges != plain_sites.charges),
        ("--protonation", sites.structure.is_some()),
        ("--titratable", sites.titratable),
        ("--mutate", settings.mutations != default.mutations),
    ] {
        if is_set {
            without_effect.push(flag);
        }
    }
    if without_effect.is_empty() {
        return Ok(());
    }
    bail!(
        "a PQR file has its own atoms and charges, which {} would not change; leave it out, or give \
         the structure as PDB or mmCIF",
        without_effect.join(", ")
    )
}

/// Prefixes the error with the file name, unless it already contains it.
fn named(file: &str, error: BodyError) -> anyhow::Error {
    match error {
        BodyError::Parse { .. } => error.into(),
        _ => anyhow::Error::from(error).context(file.to_owned()),
    }
}

/// The files of further formats, with their contents.
fn exports(
    body: &Body,
    folder: &Path,
    name: &str,
    settings: &IngestSettings,
) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let mut files = Vec::with_capacity(settings.exports.len());
    for ending in &settings.exports {
        let path = folder.join(format!("{name}.{ending}"));
        let bytes = match *ending {
            "pqr" => write_pqr(&point_records(body))?.into_bytes(),
            _ => write_mesh(
                MeshFormat::from_name(&path.display().to_string())?,
                &body.mesh,
            ),
        };
        files.push((path, bytes));
    }
    Ok(files)
}

/// Converts the sites of a body to records of a PQR file.
fn point_records(body: &Body) -> Vec<PointRecord> {
    let mut records = Vec::with_capacity(body.sites.len());
    for site in &body.sites {
        let mut record = PointRecord {
            position: site.position,
            charge_e: site.charge_e,
            radius_angstrom: site.radius_angstrom,
            atom_name: site.atom_name.clone(),
            ..PointRecord::default()
        };
        if let Some(index) = site.residue
            && let Some(residue) = body.residues.get(index as usize)
        {
            record.residue_name = residue.name.clone();
            record.chain = residue.chain.clone();
            record.residue_number = residue.number;
            record.insertion_code = residue.insertion_code.clone();
        }
        records.push(record);
    }
    records
}

impl FileOutcome {
    pub(super) fn failed(file: &Path, error: &anyhow::Error) -> Self {
        Self {
            file: file.display().to_string(),
            sha256: InputFile::sha256_of(file).unwrap_or_default(),
            status: "failed",
            body: None,
            measures: None,
            distance: None,
            skipped: BTreeMap::new(),
            warnings: Vec::new(),
            selection: None,
            error: Some(remedy::message(error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::chemistry::parse_mutations;
    use protomer_body::structure::SelectionSettings;

    const PQR: &str = "ATOM 1 N ARG A 1 32.231 15.281 -13.143 -0.1500 1.5500\n";
    const PDB: &str =
        "ATOM      1  N   ARG A   1      32.231  15.281 -13.143  1.00 10.00           N\n";

    fn build(name: &str, text: &str, settings: &BodySettings) -> Result<BuiltBody> {
        let folder = tempfile::tempdir()?;
        let file = folder.path().join(name);
        std::fs::write(&file, text)?;
        read_and_build(&file, "x", settings)
    }

    #[test]
    fn content_decides_over_the_name_with_a_warning() {
        let plain = BodySettings::default();
        for (name, text, format) in [
            ("x.pdb", PQR, "PQR"),
            ("x.cif", PQR, "PQR"),
            ("x.pqr", PDB, "PDB"),
            ("x.cif", PDB, "PDB"),
        ] {
            let built = build(name, text, &plain).unwrap();
            let warning = format!("this is {format} by its content");
            let has_warning = built.warnings.iter().any(|line| line.contains(&warning));
            assert!(has_warning, "{name}: {:?}", built.warnings);
            let radius = built.body.sites[0].radius_angstrom;
            assert!((radius - 1.55).abs() < 1e-12, "{name}: {radius}");
        }
        assert!(build("x.pqr", PQR, &plain).unwrap().warnings.is_empty());
    }

    #[test]
    fn what_would_do_nothing_to_a_pqr_file_is_refused() {
        let plain = BodySettings::default;
        let selection = |selection| BodySettings {
            selection,
            ..plain()
        };
        let mut at_ph_4 = plain();
        at_ph_4.sites.ph = 4.0;
        let mutated = BodySettings {
            mutations: parse_mutations("A:R1E").unwrap(),
            ..plain()
        };
        let of_chain = selection(SelectionSettings {
            chains: vec!["B".into()],
            ..SelectionSettings::default()
        });
        let of_model = selection(SelectionSettings {
            model: Some(3),
            ..SelectionSettings::default()
        });
        let assembly = selection(SelectionSettings {
            assembly: Some("1".into()),
            ..SelectionSettings::default()
        });
        for (flag, settings) in [
            ("--ph", at_ph_4),
            ("--mutate", mutated),
            ("--chain", of_chain),
            ("--model", of_model),
            ("--assembly", assembly),
        ] {
            let error = build("x.pqr", PQR, &settings).unwrap_err();
            let message = remedy::message(&error);
            assert!(
                message.contains(flag) && message.contains("x.pqr"),
                "{message}"
            );
        }
    }

    #[test]
    fn the_first_of_several_models_of_a_pqr_file_is_used_with_a_warning() {
        let text = format!("MODEL 1\n{PQR}ENDMDL\nMODEL 2\n{PQR}ENDMDL\n");
        let built = build("x.pqr", &text, &BodySettings::default()).unwrap();
        assert_eq!(built.body.sites.len(), 1);
        assert!(built.warnings[0].contains("first of 2 models"));
    }
}
