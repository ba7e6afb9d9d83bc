//! Sets of voxel grids: made, interrupted, continued, joined, read; whatever the order and the
//! threads, the same files.

mod bodies;
mod sets;
mod structures;

use crate::common::program;
use protomer_body::Draft;
use protomer_body::surface::ExactSurface;
use protomer_field::voxels::PotentialModel;
use protomer_learn_verbs::voxels::body_store::BodyStore;
use protomer_learn_verbs::voxels::manifest::Manifest;
use protomer_learn_verbs::voxels::{VoxelizeReport, VoxelizeSettings, voxelize};
use protomer_results::{Execution, FileRecord, Shard};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::Mutex;

/// Helices of five residues each, as PDB text: small, and enough to have a surface, charges and
/// hydropathy.
fn peptide(names: [&str; 5], turn: f64) -> String {
    let mut text = String::new();
    let mut serial = 1;
    for (number, name) in names.iter().enumerate() {
        for (atom, along, radius, angle) in [
            ("N", 0.0, 1.5, 0.0),
            ("CA", 0.9, 2.3, 0.5),
            ("C", 1.9, 1.7, 0.9),
            ("O", 2.2, 2.1, 1.5),
            ("CB", 0.6, 3.3, 0.9),
        ] {
            let angle = angle + turn * number as f64;
            let (x, y, z) = (
                radius * angle.cos(),
                radius * angle.sin(),
                along + 1.5 * number as f64,
            );
            text += &format!(
                "ATOM  {serial:>5}  {atom:<3} {name} A{:>4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00           {}\n",
                number + 1,
                &atom[..1]
            );
            serial += 1;
        }
    }
    text + "END\n"
}

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// Six peptides, three of which cannot be used.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("one.pdb", &peptide(["ALA"; 5], 1.7));
        write(
            "two.pdb",
            &peptide(["ALA", "GLY", "ALA", "ALA", "GLY"], 1.75),
        );
        write(
            "three.pdb",
            &peptide(["GLY", "ALA", "GLY", "ALA", "ALA"], 1.65),
        );
        let trace: Vec<&str> = peptide(["LYS"; 5], 1.7)
            .leak()
            .lines()
            .filter(|line| line.contains(" CA "))
            .collect();
        write("trace.pdb", &trace.join("\n"));
        write("broken.pdb", "ATOM      1  N   ALA A   1      xx.xxx\n");
        write(
            "water.pdb",
            "HETATM    1  O   HOH A   1       0.000   0.000   0.000  1.00  0.00           O\n",
        );
        let far = peptide(["ALA"; 5], 1.7)
            .replace("   1.500   0.000   0.000", "  91.500   0.000   0.000");
        write("far.pdb", &far);
        write(
            "set.csv",
            "file,label,cluster,family\none.pdb,\"P 1\",a,f\ntrace.pdb,x,b,\ntwo.pdb,y,a,\nbroken.pdb,x,c,\nwater.pdb,x,d,\n\
             missing.pdb,x,e,\nfar.pdb,x,g,\nthree.pdb,\"P 1\",h,\n",
        );
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn make(&self, name: &str, shard: Shard, settings: &VoxelizeSettings) -> VoxelizeReport {
        let manifest = Manifest::read(&self.path("set.csv")).unwrap();
        let execution = Execution::default();
        voxelize(
            &manifest,
            shard,
            settings,
            None,
            &self.path(name),
            &execution,
        )
        .unwrap()
    }

    /// A manifest of these files in place of the six peptides, each of a cluster of its own.
    fn list(&self, files: &[String]) {
        let lines: String = files.iter().map(|file| format!("{file},x,\n")).collect();
        std::fs::write(self.path("set.csv"), format!("file,label,cluster\n{lines}")).unwrap();
    }

    /// The program.
    fn run(&self, words: &str) -> Output {
        let mut command = program(words.split_whitespace());
        command.current_dir(self.folder.path()).output().unwrap()
    }
}

/// Structure of the project, gzipped, and its text.
fn bundled(name: &str) -> (Vec<u8>, String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../data/structures")
        .join(name);
    let text = protomer_common::input::InputFile::read(&path)
        .unwrap()
        .bytes;
    (
        std::fs::read(path).unwrap(),
        String::from_utf8(text).unwrap(),
    )
}

fn settings() -> VoxelizeSettings {
    VoxelizeSettings {
        size: 32,
        potential: PotentialModel::DebyeHueckel,
        most_incomplete: 0.3,
        ..Default::default()
    }
}

/// All files of a folder with their content.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in next.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(
                    path.strip_prefix(folder).unwrap().to_owned(),
                    std::fs::read(path).unwrap(),
                );
            }
        }
    }
    found
}

/// Keeps nothing, and counts.
#[derive(Default)]
struct Counting {
    kept: Mutex<Vec<String>>,
    finished: Mutex<Vec<String>>,
}

impl BodyStore for Counting {
    fn density_per_angstrom2(&self) -> f64 {
        0.3
    }

    fn keep(&self, file: &Path, _: Draft, _: ExactSurface) -> anyhow::Result<FileRecord> {
        let file = file.file_name().unwrap().to_string_lossy().into_owned();
        self.kept.lock().unwrap().push(file.clone());
        Ok(FileRecord {
            row: vec!["ok".into()],
            file,
            warnings: Vec::new(),
            error: None,
        })
    }

    fn failed(&self, file: &Path, error: &anyhow::Error) -> FileRecord {
        FileRecord {
            file: file.file_name().unwrap().to_string_lossy().into_owned(),
            row: vec!["failed".into()],
            warnings: Vec::new(),
            error: Some(error.to_string()),
        }
    }

    fn finish(
        &self,
        records: &mut dyn Iterator<Item = anyhow::Result<FileRecord>>,
    ) -> anyhow::Result<()> {
        for record in records {
            self.finished.lock().unwrap().push(record?.file);
        }
        Ok(())
    }
}

fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}
