//! Where tests keep energy tables.

use std::path::{Path, PathBuf};

/// A folder of energy tables: that of all tests, which `test.sh` makes, or one of its own.
pub enum Cache {
    OfAllTests(PathBuf),
    Own(tempfile::TempDir),
}

impl Cache {
    pub fn new() -> Self {
        match std::env::var_os("PROTOMER_TEST_CACHE_DIR") {
            Some(folder) => Self::OfAllTests(folder.into()),
            None => Self::Own(tempfile::tempdir().unwrap()),
        }
    }

    pub fn path(&self) -> &Path {
        match self {
            Self::OfAllTests(path) => path,
            Self::Own(folder) => folder.path(),
        }
    }
}
