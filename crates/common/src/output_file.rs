//! Output files: existing ones are replaced only on request.

use anyhow::{Result, bail};
use protomer_io::atomic::write_atomically;
use std::path::Path;

/// Writes a file.
///
/// # Errors
/// If it already exists and `force` is not set, or it cannot be written.
///
/// ```
/// use protomer_common::output_file::write_once;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("network.toml");
/// write_once(&path, "nodes = []", false)?;
/// assert!(write_once(&path, "nodes = []", false).is_err());
/// write_once(&path, "nodes = []", true)?;
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn write_once(path: &Path, text: &str, force: bool) -> Result<()> {
    refuse_to_overwrite(path, force)?;
    Ok(write_atomically(path, |file| {
        file.write_all(text.as_bytes())
    })?)
}

/// Refuses an existing file, unless `force` is set.
///
/// # Errors
/// If the file exists and `force` is not set.
pub fn refuse_to_overwrite(path: &Path, force: bool) -> Result<()> {
    if path.exists() && !force {
        bail!(
            "{} already exists; choose another name, or overwrite it with --force",
            path.display()
        );
    }
    Ok(())
}

/// Refuses a file that could not be written. Long computations check this before they begin.
///
/// # Errors
/// As [`refuse_to_overwrite`]; also if its folder is missing.
pub fn require_writable(path: &Path, force: bool) -> Result<()> {
    refuse_to_overwrite(path, force)?;
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            bail!(
                "cannot write {}: there is no folder {}; create it first",
                path.display(),
                folder.display()
            )
        }
        _ => Ok(()),
    }
}
