//! Output files: existing ones with other content are replaced only on request.

use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_bytes;
use protomer_io::destination::is_stream_at;
pub use protomer_io::mesh::MeshFormat;
use std::path::Path;

/// Writes a file. One that holds exactly these bytes is left alone, so that the same command may be
/// repeated.
///
/// # Errors
/// If it already exists with other content and `force` is not set, or it cannot be written.
///
/// ```
/// use protomer_common::output_file::write_once;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("network.toml");
/// write_once(&path, "nodes = []", false)?;
/// write_once(&path, "nodes = []", false)?;
/// assert!(write_once(&path, "rods = []", false).is_err());
/// write_once(&path, "rods = []", true)?;
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn write_once(path: &Path, content: &(impl AsRef<[u8]> + ?Sized), force: bool) -> Result<()> {
    let bytes = content.as_ref();
    refuse_to_replace(path, bytes, force)?;
    Ok(write_bytes(path, bytes)?)
}

/// Writes files into a folder, which is made if it is missing. Nothing is written if one of them may
/// not be.
///
/// # Errors
/// As [`write_once`], and if the folder cannot be made.
///
/// ```
/// use protomer_common::output_file::write_folder;
/// # let folder = tempfile::tempdir()?;
/// let answer = folder.path().join("answer");
/// write_folder(&answer, &[("a.csv", b"1\n".to_vec()), ("b.csv", b"2\n".to_vec())], false)?;
/// let other = [("c.csv", b"3\n".to_vec()), ("a.csv", b"4\n".to_vec())];
/// assert!(write_folder(&answer, &other, false).is_err());
/// assert!(!answer.join("c.csv").exists());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn write_folder(folder: &Path, files: &[(&str, Vec<u8>)], force: bool) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    for (name, content) in files {
        refuse_to_replace(&folder.join(name), content, force)?;
    }
    for (name, content) in files {
        write_once(&folder.join(name), content, force)?;
    }
    Ok(())
}

/// Refuses a file that exists with other content, unless `force` is set. Verbs that write several
/// files check all of them first.
///
/// ```
/// use protomer_common::output_file::refuse_to_replace;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("network.toml");
/// std::fs::write(&path, "nodes = []")?;
/// assert!(refuse_to_replace(&path, b"nodes = []", false).is_ok());
/// assert!(refuse_to_replace(&path, b"rods = []", false).is_err());
/// assert!(refuse_to_replace(&path, b"rods = []", true).is_ok());
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// If the file exists with other content and `force` is not set.
pub fn refuse_to_replace(path: &Path, bytes: &[u8], force: bool) -> Result<()> {
    let is_same = path.is_file()
        && !is_stream_at(path)
        && protomer_io::input::read(path).is_ok_and(|present| present == bytes);
    match is_same {
        true => Ok(()),
        false => refuse_to_overwrite(path, force),
    }
}

/// Refuses an existing file, unless `force` is set.
///
/// ```
/// use protomer_common::output_file::refuse_to_overwrite;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("network.toml");
/// assert!(refuse_to_overwrite(&path, false).is_ok());
/// std::fs::write(&path, "nodes = []")?;
/// assert!(refuse_to_overwrite(&path, false).is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// If the file exists and `force` is not set.
pub fn refuse_to_overwrite(path: &Path, force: bool) -> Result<()> {
    // Nothing of a device or a pipe is lost.
    if path.exists() && !force && !is_stream_at(path) {
        bail!(
            "{} already exists; choose another name, or overwrite it with --force",
            path.display()
        );
    }
    Ok(())
}

/// Refuses a file that could not be written. Long computations check this before they begin, when
/// they cannot know yet whether they would write the same again.
///
/// ```
/// use protomer_common::output_file::require_writable;
/// # let folder = tempfile::tempdir()?;
/// let file = folder.path().join("body.json");
/// assert!(require_writable(&file, false).is_ok());
/// std::fs::write(&file, "{}")?;
/// assert!(require_writable(&file, false).is_err(), "it is there already");
/// assert!(require_writable(&file, true).is_ok());
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// As [`refuse_to_overwrite`] and [`require_folder`].
pub fn require_writable(path: &Path, force: bool) -> Result<()> {
    refuse_to_overwrite(path, force)?;
    require_folder(path)
}

/// Refuses a file whose folder is missing.
///
/// ```
/// use protomer_common::output_file::require_folder;
/// # let folder = tempfile::tempdir()?;
/// assert!(require_folder(&folder.path().join("log.csv")).is_ok());
/// assert!(require_folder(&folder.path().join("missing/log.csv")).is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// If there is no such folder.
pub fn require_folder(path: &Path) -> Result<()> {
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
