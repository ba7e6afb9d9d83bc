//! Assemblies from recipes and from structures, written as assembly files.

use crate::assemblies::assembly_file::{AssemblyFile, BodyEntry, Placement};
use crate::bodies::body_file;
use crate::bodies::ingest::BodyMeasures;
use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::assembly::{self, Expansion, HardBodies, HardBody, expand_until_free};
use protomer_body::structure::SelectionReport;
use protomer_body::{
    Body, BodySettings, HardCore, Source, build_body_of_selection,
    structure_warnings as warnings_about,
};
use protomer_common::answer::{Answer, columns, heading};
use protomer_common::output_file::{refuse_to_replace, write_once};
use protomer_io::written::FileNames;
use protomer_kernel::{Pose, Vec3};
use protomer_results::ResultKind;
use serde::Serialize;
use std::collections::BTreeMap;
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
/// An expansion by more than this, Å, opens the contacts of a structure.
const LARGE_EXPANSION_ANGSTROM: f64 = 1.0;

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

    fn new(paths: Vec<PathBuf>, bodies: Vec<Body>) -> Result<Self> {
        let mut hard = Vec::with_capacity(bodies.len());
        for (body, path) in bodies.iter().zip(&paths) {
            hard.push(HardBody::of(body).with_context(|| path.display().to_string())?);
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

/// What [`assemble_structure`] found and did.
#[derive(Debug, Clone, Serialize)]
pub struct StructureAssembly {
    /// The assembly file.
    pub assembly: PathBuf,
    /// The body files with the copies of each.
    pub bodies: Vec<StructureBody>,
    /// Pairs of copies that overlap as hard bodies.
    pub overlaps: Vec<(usize, usize)>,
    /// Factor of the uniform expansion that removed the overlaps; 1 if there were none.
    pub expansion_factor: f64,
    /// The largest displacement of a body by the expansion, Å.
    pub largest_displacement_angstrom: f64,
    /// Atoms left out of all chains, by reason.
    pub skipped: BTreeMap<&'static str, usize>,
    /// Warnings about the file and its chains, as `ingest` gives them.
    pub structure_warnings: Vec<String>,
    /// The full report on the selection of atoms.
    pub selection: SelectionReport,
    /// By how much the surfaces were shrunk, Å.
    #[serde(skip)]
    inward_offset_angstrom: f64,
}

impl StructureAssembly {
    /// What a user should know before simulating it.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for warning in &self.structure_warnings {
            warnings.push(format!("warning: {warning}"));
        }
        for body in &self.bodies {
            for warning in &body.warnings {
                let file = body.file.display();
                warnings.push(format!("warning: {file}: {warning}"));
            }
        }
        if self
            .bodies
            .iter()
            .map(|body| body.chains.len())
            .sum::<usize>()
            == 1
        {
            warnings.push(
                "warning: this is a single chain, which has nothing to fall apart from; ask for the \
                 biological assembly with --assembly 1"
                    .into(),
            );
        }
        let moved_angstrom = self.largest_displacement_angstrom;
        if moved_angstrom > LARGE_EXPANSION_ANGSTROM {
            let instead = match larger_offset_angstrom(self.inward_offset_angstrom) {
                Some(offset) if self.inward_offset_angstrom > 0.0 => {
                    format!("shrink the surfaces more: --offset {offset} --relax")
                }
                Some(offset) => format!("shrink the surfaces instead: --offset {offset} --relax"),
                None => {
                    "surfaces cannot be shrunk much further; chains that interlock are one body in \
                         truth, so assemble fewer of them"
                        .into()
                }
            };
            warnings.push(format!(
                "warning: the expansion moved a body by {moved_angstrom:.1} Å, so that contacts of the \
                 structure are open; {instead}"
            ));
        }
        warnings
    }
}

impl Answer for StructureAssembly {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "body",
            "atoms",
            "residues",
            "net charge (e)",
            "copies",
            "largest RMSD (Å)",
        ])];
        for body in &self.bodies {
            let largest = body.rmsd_angstrom.iter().copied().fold(0.0, f64::max);
            rows.push(vec![
                body.file.display().to_string(),
                body.measures.atoms.to_string(),
                body.measures.residues.to_string(),
                format!("{:+.2}", body.measures.net_charge_e),
                body.chains.join(" "),
                format!("{largest:.3}"),
            ]);
        }
        let left_out = match self.selection.skipped_in_words() {
            Some(skipped) => format!("\nleft out: {skipped}"),
            None => String::new(),
        };
        format!(
            "{}{left_out}\n{} pairs of chains overlapped; expanded by a factor {:.6} (at most {:.3} Å)\n{}",
            columns(&rows),
            self.overlaps.len(),
            self.expansion_factor,
            self.largest_displacement_angstrom,
            self.assembly.display()
        )
    }
}

/// One kind of body of a structure.
#[derive(Debug, Clone, Serialize)]
pub struct StructureBody {
    /// The body file.
    pub file: PathBuf,
    /// The chain it was made from.
    pub reference: String,
    /// The chains that are copies of it, the reference among them.
    pub chains: Vec<String>,
    /// Root mean square distance of each copy from the reference, Å.
    pub rmsd_angstrom: Vec<f64>,
    /// Its size and charge.
    #[serde(flatten)]
    pub measures: BodyMeasures,
    /// Warnings about its surface.
    pub warnings: Vec<String>,
}

/// How a structure is decomposed into bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureSettings {
    /// How bodies are made.
    pub body: BodySettings,
    /// Whether to remove overlaps by the smallest uniform expansion.
    pub relax: bool,
    /// Periodic box, Å.
    pub box_angstrom: Option<[f64; 3]>,
    /// Whether to overwrite existing files.
    pub force: bool,
}

/// Decomposes a structure into bodies, one per kind of chain, and writes them with the assembly
/// into a folder.
///
/// # Errors
/// Without `relax`, chains that overlap as hard bodies are an error that lists the pairs.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer::assemblies::assemble::{StructureSettings, assemble_structure};
/// use protomer_body::BodySettings;
/// use std::path::Path;
/// let settings = StructureSettings {
///     body: BodySettings::default(),
///     relax: true,
///     box_angstrom: Some([300.0; 3]),
///     force: false,
/// };
/// let assembly = assemble_structure(Path::new("6mdr.cif.gz"), Path::new("6mdr"), &settings)?;
/// println!("{}", assembly.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn assemble_structure(
    input: &Path,
    folder: &Path,
    settings: &StructureSettings,
) -> Result<StructureAssembly> {
    ResultKind::VoxelSet.refuse_in(folder)?;
    FileKind::Structure.require(input)?;
    let file = protomer_common::input::InputFile::read(input)?;
    let structure = protomer_body::structure::Structure::read(&file.name, &file.bytes)?;
    let selection = structure
        .select(&settings.body.selection)
        .with_context(|| file.name.clone())?;
    let structure_warnings = warnings_about(&structure, &selection.report);
    let types = assembly::body_types(&selection).with_context(|| file.name.clone())?;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let (mut paths, mut bodies, mut placements, mut chains) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut described, mut names) = (Vec::new(), FileNames::default());
    for (kind, body_type) in types.into_iter().enumerate() {
        let stem = protomer_common::input::stem(input);
        let name = names.add(&format!("{stem}_{}", body_type.reference));
        let source = Source {
            file: &file.name,
            sha256: &file.sha256,
        };
        let mut built = build_body_of_selection(&name, source, body_type.selection, &settings.body)
            .with_context(|| format!("{}: chain {}", file.name, body_type.reference))?;
        // Those about atoms and residues are said once, for all chains of the file.
        built
            .warnings
            .retain(|warning| !structure_warnings.contains(warning));
        let path = folder.join(format!("{name}.body"));
        let mut of_body = StructureBody {
            file: path.clone(),
            reference: body_type.reference,
            chains: Vec::new(),
            rmsd_angstrom: Vec::new(),
            measures: BodyMeasures::of(&built.body),
            warnings: built.warnings,
        };
        for copy in body_type.copies {
            placements.push((kind, copy.pose));
            chains.push(copy.chain.clone());
            of_body.chains.push(copy.chain);
            of_body.rmsd_angstrom.push(copy.rmsd_angstrom);
        }
        described.push(of_body);
        paths.push(path);
        bodies.push(built.body);
    }
    let files = BodyFiles::new(paths, bodies)?;
    let overlaps = files.hard.overlapping_pairs(&placements);
    let expansion = relax(&files, placements, &overlaps, &chains, settings)?;
    let path = folder.join("assembly.json");
    let provenance = serde_json::json!({
        "source": file.name, "source_sha256": file.sha256, "chains": chains,
        "expansion_factor": expansion.factor,
    });
    let edges = settings.box_angstrom;
    files.require_room(&expansion.placements, edges)?;
    let assembly = files.assembly_file(&path, &expansion.placements, edges, provenance)?;
    let force = settings.force;
    refuse_another(&path, &assembly, force)?;
    for (path, body) in files.paths.iter().zip(&files.bodies) {
        body_file::refuse_another(path, body, force)?;
    }
    for (path, body) in files.paths.iter().zip(&files.bodies) {
        body_file::write_once(path, body, force)?;
    }
    write_assembly(&path, &assembly, force)?;
    Ok(StructureAssembly {
        assembly: path,
        bodies: described,
        overlaps,
        expansion_factor: expansion.factor,
        largest_displacement_angstrom: expansion.largest_displacement_angstrom,
        skipped: selection.report.skipped.clone(),
        structure_warnings,
        selection: selection.report,
        inward_offset_angstrom: core_offset_angstrom(&settings.body),
    })
}

/// By how much the hard cores are moved inward, Å.
fn core_offset_angstrom(body: &BodySettings) -> f64 {
    let surface = &body.surface;
    let default = match surface.core {
        Some(HardCore::Surface) => 0.0,
        None | Some(HardCore::Native) => HardCore::NATIVE_OFFSET_ANGSTROM,
    };
    surface.inward_offset_angstrom.unwrap_or(default)
}

/// The next larger offset to be tried, Å; `None` if surfaces are shrunk as far as makes sense: the
/// smallest heavy atom has a radius of 1.5 Å.
fn larger_offset_angstrom(offset_angstrom: f64) -> Option<f64> {
    [0.5, 0.8, 1.1]
        .into_iter()
        .find(|larger| *larger > offset_angstrom)
}

/// Placements without overlaps: the given ones, or expanded ones if `relax` is set and they
/// overlap.
fn relax(
    files: &BodyFiles,
    placements: Vec<assembly::Placement>,
    overlaps: &[(usize, usize)],
    chains: &[String],
    settings: &StructureSettings,
) -> Result<Expansion> {
    if settings.relax {
        return Ok(expand_until_free(&placements, 1e-6, |placements| {
            files.hard.any_overlap(placements)
        })?);
    }
    if !overlaps.is_empty() {
        let mut pairs = Vec::new();
        for (i, j) in overlaps {
            pairs.push(format!("{}-{}", chains[*i], chains[*j]));
        }
        let shrink = larger_offset_angstrom(core_offset_angstrom(&settings.body))
            .map_or_else(String::new, |offset| {
                format!(", or shrink the surfaces with --offset {offset}")
            });
        let native = match settings.body.surface.core {
            Some(HardCore::Surface) => "leave out --core surface, ",
            None | Some(HardCore::Native) => "",
        };
        bail!(
            "{} pairs of chains overlap as hard bodies: {}; {native}expand the assembly with \
             --relax{shrink}",
            pairs.len(),
            pairs.join(", ")
        );
    }
    Ok(Expansion {
        factor: 1.0,
        largest_displacement_angstrom: 0.0,
        placements,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A lysine (without the end of its side chain where `is_whole` is false), then a gap, then an
    /// alanine, in a chain at a height z.
    fn chain(chain: char, z: f64, is_whole: bool) -> String {
        let lysine = [
            ("N", 0.0, 0.0),
            ("CA", 1.46, 0.0),
            ("C", 2.0, 1.4),
            ("O", 1.2, 2.4),
            ("CB", 2.0, -1.4),
            ("CG", 3.5, -1.4),
            ("CD", 4.0, -2.8),
            ("CE", 5.5, -2.8),
            ("NZ", 6.0, -4.2),
        ];
        let atoms = if is_whole { 9 } else { 6 };
        let alanine = lysine[..5]
            .iter()
            .map(|(name, x, y)| ("ALA", 5, *name, x + 9.0, *y));
        let lysine = lysine[..atoms]
            .iter()
            .map(|(name, x, y)| ("LYS", 1, *name, *x, *y));
        let mut text = String::new();
        for (residue, number, name, x, y) in lysine.chain(alanine) {
            let element = &name[..1];
            text += &format!(
                "ATOM      1  {name:<3} {residue} {chain}{number:4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {element:>2}\n"
            );
        }
        text
    }

    /// Two nucleotides of three atoms each.
    fn adenosines(chain: char) -> String {
        let mut text = String::new();
        for number in 1..=2 {
            for (name, element, x) in [("P", "P", 0.0), ("O5'", "O", 1.6), ("C5'", "C", 3.0)] {
                let x = x + 6.0 * f64::from(number);
                text += &format!(
                    "ATOM      1  {name:<3}  DA {chain}{number:4}    {x:8.3}{:8.3}{:8.3}  1.00  0.00          {element:>2}\n",
                    40.0, 40.0
                );
            }
        }
        text
    }

    /// Everything that `ingest` says of the file is said, and what each body is like.
    #[test]
    fn a_structure_is_taken_apart_with_all_that_ingest_says_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("two.pdb");
        let water =
            "HETATM    1  O   HOH A 101      30.000  30.000  30.000  1.00  0.00           O\n";
        let haem =
            "HETATM    1 FE   HEM A 100      20.000  20.000  20.000  1.00  0.00          FE\n";
        let text =
            chain('A', 0.0, true) + &chain('B', 15.0, false) + &adenosines('I') + haem + water;
        std::fs::write(&input, text).unwrap();
        let settings = StructureSettings {
            body: BodySettings::default(),
            relax: true,
            box_angstrom: None,
            force: false,
        };
        let made = assemble_structure(&input, &folder.path().join("out"), &settings).unwrap();
        let said = made.warnings().join("\n");
        let body = crate::bodies::ingest::read_and_build(&input, "two", &settings.body).unwrap();
        let of_surface = |warning: &&String| warning.contains("surface");
        for warning in body.warnings.iter().filter(|warning| !of_surface(warning)) {
            assert!(said.contains(warning), "{warning}\n{said}");
        }
        for wanted in [
            "ligands of chain A left out: 1 HEM; --keep-ligands keeps them",
            "nucleic acids of chain I left out: 2 DA; --keep-nucleic-acids keeps them",
            "chain break between A:1 and A:5",
            "LYS B:1 lacks CD, CE, NZ",
        ] {
            assert_eq!(said.matches(wanted).count(), 1, "{wanted}\n{said}");
        }
        let json = serde_json::to_value(&made).unwrap();
        let skipped = serde_json::json!({"ligand": 1, "nucleic acid": 6, "water": 1});
        assert_eq!(json["skipped"], skipped);
        let left_out = &json["selection"]["skipped_residues"];
        assert_eq!(left_out["ligand"]["names"]["HEM"], 1);
        assert_eq!(left_out["nucleic acid"]["chains"][0], "I");
        let words = "left out: 1 ligand, 6 nucleic acid, 1 water";
        assert!(made.text().contains(words), "{}", made.text());
        let charges_e = made.bodies.iter().map(|of_kind| {
            let copies = u32::try_from(of_kind.chains.len()).unwrap();
            f64::from(copies) * of_kind.measures.net_charge_e
        });
        let difference_e = charges_e.sum::<f64>() - body.body.net_charge_e();
        assert!(difference_e.abs() < 1e-9, "{difference_e}");
        let listed = json["structure_warnings"].as_array().unwrap();
        assert!(
            listed
                .iter()
                .any(|line| line.as_str().unwrap().contains("1 HEM"))
        );
    }

    /// What moved far is answered with an offset that was not given yet, or with another way.
    #[test]
    fn advice_never_repeats_the_offset_that_was_given() {
        let warning = |inward_offset_angstrom: f64| {
            let made = StructureAssembly {
                assembly: "assembly.json".into(),
                bodies: Vec::new(),
                overlaps: vec![(0, 1)],
                expansion_factor: 1.9,
                largest_displacement_angstrom: 10.2,
                skipped: BTreeMap::new(),
                structure_warnings: Vec::new(),
                selection: SelectionReport::default(),
                inward_offset_angstrom,
            };
            made.warnings().pop().unwrap()
        };
        assert!(warning(0.0).contains("--offset 0.5 --relax"));
        assert!(warning(0.5).contains("--offset 0.8 --relax"));
        assert!(warning(0.8).contains("--offset 1.1 --relax"));
        assert!(!warning(1.1).contains("--offset"), "{}", warning(1.1));
    }
}
