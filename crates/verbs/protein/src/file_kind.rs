//! What a file or directory is, so that one of the wrong kind is refused with the verb it belongs to.

use anyhow::{Result, bail};
use protomer_body::structure::Format;
use protomer_io::mesh::MeshFormat;
use protomer_kernel::plain_text::is_density_map;
use protomer_results::ResultKind;
use std::io::Read;
use std::path::Path;

/// Bytes at the beginning of a JSON or TOML file that suffice to tell its kind.
const HEAD_BYTES: u64 = 1 << 16;
/// First bytes of a container.
const CONTAINER: &[u8] = b"\x89PRTMR";
/// Kind of the container of a body, with its length before it.
const OF_BODY: &[u8] = b"\x04\0body";
/// Offset of the kind, with its length, in a container.
const KIND_AT: usize = 20;

/// A kind of file or directory.
///
/// ```
/// use protomer_protein_verbs::file_kind::FileKind;
/// use std::path::Path;
/// let structure = Path::new("../../../data/structures/5pti.cif.gz");
/// assert_eq!(FileKind::from_path(structure), Some(FileKind::Structure));
/// let error = FileKind::Body.require(structure).unwrap_err().to_string();
/// assert!(error.ends_with("is a structure: 'protomer ingest' makes a body of it"), "{error}");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileKind {
    /// PDB or mmCIF.
    Structure,
    /// Points with charges and radii.
    Pqr,
    /// A triangle mesh.
    Mesh,
    /// A density map, MRC or CCP4.
    DensityMap,
    /// A body file.
    Body,
    /// An assembly file.
    Assembly,
    /// A list of structures and labels.
    Manifest,
    /// A directory of results.
    Results(ResultKind),
}

impl FileKind {
    /// The kind of a path; `None` if it is not known, or there is nothing.
    pub fn from_path(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return ResultKind::detect(path).map(Self::Results);
        }
        let mut head = Vec::new();
        protomer_io::input::open(path)
            .and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head))
            .ok()?;
        if head.starts_with(CONTAINER) {
            let is_body = head
                .get(KIND_AT..)
                .is_some_and(|kind| kind.starts_with(OF_BODY));
            return is_body.then_some(Self::Body);
        }
        let name = path.display().to_string();
        if is_density_map(&head) || has_ending_of_maps(&name) {
            return Some(Self::DensityMap);
        }
        let text = String::from_utf8_lossy(&head);
        match Format::of_name(&name) {
            Some(Format::Pqr) => return Some(Self::Pqr),
            Some(_) => return Some(Self::Structure),
            None if MeshFormat::from_name(&name).is_ok() => return Some(Self::Mesh),
            None => {}
        }
        if text.trim_start().starts_with('{') && text.contains("\"placements\"") {
            return Some(Self::Assembly);
        }
        let heading = text.lines().next().unwrap_or_default();
        let has = |column: &str| heading.split(',').any(|cell| cell.trim() == column);
        (has("file") && has("label")).then_some(Self::Manifest)
    }

    /// Refuses a path that is known to be of another kind. What is not known, or missing, is left to
    /// the reader.
    ///
    /// # Errors
    /// Says what the path is, and which verb makes this kind of it, or else takes it.
    pub fn require(&self, path: &Path) -> Result<()> {
        let kind = Self::from_path(path);
        match kind.and_then(|present| present.refusal(path, self)) {
            Some(refusal) => bail!(refusal),
            None => Ok(()),
        }
    }

    /// Reason to refuse a path of this kind where another is wanted. A PQR file serves as a
    /// structure.
    fn refusal(&self, path: &Path, wanted: &Self) -> Option<String> {
        let serves = self == wanted || (*self == Self::Pqr && *wanted == Self::Structure);
        let way = self.way_to(wanted);
        (!serves).then(|| format!("{} is {}: {way}", path.display(), self.name()))
    }

    /// The kind in a sentence.
    fn name(&self) -> String {
        match self {
            Self::Structure => "a structure".into(),
            Self::Pqr => "a PQR file".into(),
            Self::Mesh => "a mesh".into(),
            Self::DensityMap => "a density map, not a structure".into(),
            Self::Body => "a body".into(),
            Self::Assembly => "an assembly".into(),
            Self::Manifest => "a list of structures".into(),
            Self::Results(ResultKind::VoxelSet) => "a voxel set".into(),
            Self::Results(kind) => format!("a directory with {kind}"),
        }
    }

    /// The verb that leads from this kind to `wanted`; the verbs that take this kind, if there is none.
    fn way_to(&self, wanted: &Self) -> &'static str {
        match (self, wanted) {
            (Self::Structure, Self::Assembly) => {
                "'protomer assemble structure' makes an assembly of it"
            }
            (Self::Structure | Self::Pqr, Self::Results(ResultKind::VoxelSet)) => {
                "'protomer voxelize' makes a voxel set of a list of structures"
            }
            (Self::Structure | Self::Pqr, _) => "'protomer ingest' makes a body of it",
            (Self::DensityMap, _) => "give the atoms that were built into it, as PDB or mmCIF",
            (Self::Mesh, _) => "'protomer body --mesh' makes a body of it",
            (Self::Body, Self::Assembly) => {
                "'protomer assemble ring' and 'assemble fluid' make assemblies of bodies"
            }
            (Self::Body, _) => "'protomer assemble', 'pair', 'surface' and 'potential' take bodies",
            (Self::Assembly, Self::Results(ResultKind::Sweep)) => {
                "'protomer sweep' and 'protomer simulate' make such a directory of it"
            }
            (Self::Assembly, _) => {
                "'protomer inspect', 'simulate', 'sweep' and 'export' take assemblies"
            }
            (Self::Manifest, _) => "'protomer voxelize' makes a voxel set of it",
            (Self::Results(ResultKind::VoxelSet), _) => {
                "'protomer train', 'tune', 'predict' and 'merge' take voxel sets"
            }
            (Self::Results(ResultKind::Sweep), _) => {
                "'protomer report', 'compare' and 'export' read it"
            }
            (Self::Results(ResultKind::Training), _) => "'protomer report' and 'predict' read it",
            (Self::Results(ResultKind::LatticeRun), _) => {
                "'protomer report' and 'lattice animate' read it"
            }
            (Self::Results(_), _) => "'protomer report' reads it",
        }
    }
}

/// Whether the name is that of a density map, compressed or not. Its header is not visible in a
/// compressed one.
fn has_ending_of_maps(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let name = lower.strip_suffix(".gz").unwrap_or(&lower);
    [".mrc", ".ccp4", ".map"]
        .iter()
        .any(|ending| name.ends_with(ending))
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_io::container::Container;

    #[test]
    fn each_kind_is_told_by_its_content_or_name() {
        let folder = tempfile::tempdir().unwrap();
        let container = |kind: &str| {
            let empty = serde_json::Value::Null;
            Container::new(kind, empty).to_bytes().unwrap()
        };
        let (body, checkpoint) = (container("body"), container("checkpoint"));
        let cases: [(&str, &[u8], Option<FileKind>); 10] = [
            ("a.pdb", b"ATOM", Some(FileKind::Structure)),
            ("a.cif.gz", b"\x1f\x8b", Some(FileKind::Structure)),
            ("a.pqr", b"ATOM", Some(FileKind::Pqr)),
            ("a.off", b"OFF", Some(FileKind::Mesh)),
            ("a.map.gz", b"\x1f\x8b", Some(FileKind::DensityMap)),
            ("a.any", &body, Some(FileKind::Body)),
            ("checkpoint.bin", &checkpoint, None),
            ("a.json", b" {\"placements\": []}", Some(FileKind::Assembly)),
            ("a.csv", b"file,label,cluster\n", Some(FileKind::Manifest)),
            ("a.txt", b"words", None),
        ];
        for (name, content, expected) in cases {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            assert_eq!(FileKind::from_path(&path), expected, "{name}");
        }
        assert_eq!(
            FileKind::from_path(&folder.path().join("missing.pdb")),
            None
        );
        std::fs::write(folder.path().join("run.json"), r#"{"kind": "lattice run"}"#).unwrap();
        let words = FileKind::Assembly
            .require(folder.path())
            .unwrap_err()
            .to_string();
        assert!(
            words.contains("is a directory with a lattice run"),
            "{words}"
        );
    }
}
