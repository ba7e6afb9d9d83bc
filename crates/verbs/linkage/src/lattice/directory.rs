//! The settings in the directory of a lattice run or sweep.

use super::settings::LatticeSettings;
use anyhow::Result;
use protomer_results::keys;
use std::path::Path;

/// The file with the resolved settings.
pub const SETTINGS: &str = "run.toml";

/// The settings of a directory or of a file.
///
/// # Errors
/// Names the file, the line and the key.
pub fn read_settings(path: &Path) -> Result<LatticeSettings> {
    let file = if path.is_dir() {
        path.join(SETTINGS)
    } else {
        path.to_owned()
    };
    Ok(keys::read_toml(&file)?)
}
