//! Files the tests read.

use flate2::read::GzDecoder;
use protomer_body::structure::{Selection, SelectionSettings, Structure};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The structures that come with the repository.
pub fn bundled() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../data/structures")
}

use crate::test_data;

/// The larger set of structures, which is not part of the repository.
pub fn many_structures() -> PathBuf {
    test_data::test_data("data/structures")
}

/// The decompressed bytes of a file.
pub fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let file =
        std::fs::File::open(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    GzDecoder::new(file).read_to_end(&mut bytes).unwrap();
    bytes
}

pub fn read(folder: &Path, name: &str) -> Structure {
    Structure::read(name, &bytes(folder, name)).unwrap()
}

pub fn select(structure: &Structure) -> Selection {
    structure.select(&SelectionSettings::default()).unwrap()
}
