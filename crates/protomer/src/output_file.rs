//! Files that a verb writes once: none is replaced unless that is asked for.

use anyhow::{Result, bail};
use protomer_io::atomic::write_atomically;
use std::path::Path;

/// Writes a file.
///
/// # Errors
/// If it is there already and `force` is not given, or the disk refuses.
pub fn write_once(path: &Path, text: &str, force: bool) -> Result<()> {
    refuse_to_overwrite(path, force)?;
    Ok(write_atomically(path, |file| {
        file.write_all(text.as_bytes())
    })?)
}

/// Refuses a file that is there already, unless `force` is given.
///
/// # Errors
/// If it is.
pub fn refuse_to_overwrite(path: &Path, force: bool) -> Result<()> {
    if path.exists() && !force {
        bail!(
            "{} is already there; choose another name, or overwrite it with --force",
            path.display()
        );
    }
    Ok(())
}

/// Refuses a file that cannot be written: for work that is too long to find out at its end.
///
/// # Errors
/// As [`refuse_to_overwrite`]; also if its folder is missing.
pub fn require_writable(path: &Path, force: bool) -> Result<()> {
    refuse_to_overwrite(path, force)?;
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            bail!(
                "cannot write {}: there is no folder {}; make it first",
                path.display(),
                folder.display()
            )
        }
        _ => Ok(()),
    }
}
