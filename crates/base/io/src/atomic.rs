//! Files that appear under their name only when they are complete.
//!
//! Only regular files are replaced. A link stays, and the file that it leads to is replaced. A device, a
//! pipe or an open file of a process (`/dev/null`, `/dev/stdout`) gets the content and stays what it is.

use crate::destination::Destination;
use crate::digest::Digest;
use crate::{IoError, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes a file atomically: its name always refers to a complete file, the old or the new one. The
/// content goes to a temporary file in the same folder, which is flushed, synced to disk and
/// renamed; then the folder is synced. If anything fails, the temporary file is removed and the old
/// file is unchanged. What [`Destination`] does not call replaceable is written into instead.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("result.csv");
/// protomer_io::atomic::write_atomically(&path, |file| file.write_all(b"salt_M,r_g\n"))?;
/// assert_eq!(std::fs::read(&path)?, b"salt_M,r_g\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IoError::File`] names the path and the cause (disk full, no permission, missing folder), also
/// for an error that `write` returns.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let path = match Destination::find(path)? {
        Destination::Replaceable(file) => file,
        Destination::Stream(stream) => return write_into(path, stream, write),
    };
    let path = path.as_path();
    let (mut temporary, file) = Temporary::create(path)?;
    let mut writer = BufWriter::new(file);
    // On every early return from here on, `temporary` removes its file.
    write(&mut writer).map_err(IoError::file(path, "write"))?;
    // By hand: a writer that is dropped flushes too, but swallows the error of a full disk.
    writer.flush().map_err(IoError::file(path, "write"))?;
    let file = writer.get_ref();
    // Before the rename: a name on disk must not lead to content that is not.
    file.sync_all().map_err(IoError::file(path, "write"))?;
    // Closed before the rename, which some systems refuse for an open file.
    drop(writer);
    fs::rename(&temporary.path, path).map_err(IoError::file(path, "write"))?;
    // The name is taken now; dropping must not remove the result.
    temporary.renamed = true;
    sync_folder(path)
}

/// Writes these bytes as [`write_atomically`] does.
///
/// ```
/// use protomer_io::atomic::write_bytes;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.txt");
/// write_bytes(&path, b"first")?;
/// write_bytes(&path, b"second")?;
/// assert_eq!(std::fs::read(&path)?, b"second");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`write_atomically`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write_atomically(path, |file| file.write_all(bytes))
}

/// Writes into what cannot be replaced. It cannot be synced either.
fn write_into(
    path: &Path,
    stream: File,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<()> {
    let mut writer = BufWriter::new(stream);
    let written = write(&mut writer).and_then(|()| writer.flush());
    written.map_err(IoError::file(path, "write"))
}

/// Removes the temporary files that [`write_atomically`] left in a folder when its process was
/// killed. The caller ensures that nobody writes into the folder at the same time; subfolders
/// are not touched.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let abandoned = folder.path().join(".result.csv.1234-0.partial");
/// std::fs::write(&abandoned, "half a ta")?;
/// protomer_io::atomic::remove_abandoned(folder.path())?;
/// assert!(!abandoned.exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IoError::File`] if the folder cannot be read or a file cannot be removed.
pub fn remove_abandoned(folder: &Path) -> Result<()> {
    remove_abandoned_of(folder, |_| true)
}

/// Variant of [`remove_abandoned`] that removes only the files whose final name `is_own` accepts:
/// others may write other files into the folder at the same time.
///
/// # Errors
/// As [`remove_abandoned`].
pub fn remove_abandoned_of(folder: &Path, is_own: impl Fn(&str) -> bool) -> Result<()> {
    let entries = fs::read_dir(folder).map_err(IoError::file(folder, "read"))?;
    for entry in entries {
        let entry = entry.map_err(IoError::file(folder, "read"))?;
        // Only names of this form: other hidden files in a user's folder are none of ours.
        if name_of_temporary(&entry.file_name().to_string_lossy()).is_some_and(&is_own) {
            fs::remove_file(entry.path()).map_err(IoError::file(&entry.path(), "remove"))?;
        }
    }
    Ok(())
}

/// NAME if this is `.NAME.PID-N.partial`, as [`Temporary`] calls its files.
fn name_of_temporary(file: &str) -> Option<&str> {
    let middle = file.strip_prefix('.')?.strip_suffix(".partial")?;
    let (name, tag) = middle.rsplit_once('.')?;
    let (process, number) = tag.split_once('-')?;
    (is_digits(process) && is_digits(number)).then_some(name)
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// A temporary file, which is removed when dropped unless it was renamed.
struct Temporary {
    path: PathBuf,
    renamed: bool,
}

impl Temporary {
    /// A new file `.NAME.PID-N.partial` next to `path`.
    fn create(path: &Path) -> Result<(Self, File)> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let Some(name) = path.file_name() else {
            let kind = std::io::ErrorKind::InvalidInput;
            let no_name = std::io::Error::new(kind, "it has no file name");
            return Err(IoError::file(path, "write")(no_name));
        };
        let name = name.to_string_lossy();
        let process = std::process::id();
        // Threads of one process may write the same name
        // at once; the process number alone is not enough.
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        // In the same folder, since a rename works only within one file system.
        let temporary = path.with_file_name(format!(".{name}.{process}-{number}.partial"));
        let mut options = OpenOptions::new();
        // A number that an earlier process had is free again, and what it left may be overwritten.
        options.write(true).create(true).truncate(true);
        let file = options
            .open(&temporary)
            .map_err(IoError::file(path, "write"))?;
        let temporary = Self {
            path: temporary,
            renamed: false,
        };
        Ok((temporary, file))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Syncs the folder of a file: a rename is on disk only when its folder is.
#[cfg(unix)]
fn sync_folder(path: &Path) -> Result<()> {
    let folder = match path.parent() {
        // The parent of a bare name is the empty path, which cannot be opened.
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    File::open(folder)
        .and_then(|folder| folder.sync_all())
        .map_err(IoError::file(path, "sync the folder of"))
}

/// Other systems have no sync of folders.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> Result<()> {
    Ok(())
}

/// The SHA-256 of these bytes in hexadecimal (FIPS 180-4).
///
/// ```
/// let hash = protomer_io::atomic::sha256_hex(b"abc");
/// assert_eq!(hash, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
/// ```
pub fn sha256_hex(bytes: &[u8]) -> String {
    Digest::hash(bytes).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> Vec<String> {
        fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn the_new_content_replaces_the_old() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        for content in ["old", "new"] {
            write_atomically(&path, |file| file.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
        assert_eq!(entries(folder.path()), ["file"]);
    }

    #[test]
    fn the_files_of_a_killed_process_are_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let (left, _file) = Temporary::create(&folder.path().join("checkpoint.bin")).unwrap();
        let others = [
            ".notes.partial",
            "run.12-0.partial",
            ".run.12-.partial",
            "log.csv",
        ];
        others
            .iter()
            .for_each(|name| fs::write(folder.path().join(name), "").unwrap());
        remove_abandoned(folder.path()).unwrap();
        assert!(!left.path.exists());
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
    }

    #[test]
    fn the_files_of_others_in_the_same_folder_stay() {
        let folder = tempfile::tempdir().unwrap();
        let abandoned = |name| {
            let (temporary, _) = Temporary::create(&folder.path().join(name)).unwrap();
            let path = temporary.path.clone();
            std::mem::forget(temporary);
            path
        };
        let (own, other) = (abandoned("a.b.body"), abandoned("a.body"));
        remove_abandoned_of(folder.path(), |name| name == "a.b.body").unwrap();
        assert!(!own.exists() && other.exists());
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "old").unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(&[0; 100_000])?;
            Err(std::io::Error::from(std::io::ErrorKind::StorageFull))
        });
        let message = error.unwrap_err().to_string();
        assert!(
            message.contains("file") && message.contains("no storage space"),
            "{message}"
        );
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(entries(folder.path()), ["file"]);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let message = write_atomically(Path::new("/no/such/folder/x"), |_| Ok(()))
            .unwrap_err()
            .to_string();
        assert!(message.contains("/no/such/folder/x"), "{message}");
        assert!(write_atomically(Path::new("/"), |_| Ok(())).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_leads_to_the_new_content() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("far")).unwrap();
        for (link, target) in [("link", "far/link"), ("far/link", "file")] {
            std::os::unix::fs::symlink(target, path(link)).unwrap();
        }
        for content in ["first", "second"] {
            write_atomically(&path("link"), |file| file.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(path("far/file")).unwrap(), content);
        }
        for link in ["link", "far/link"] {
            assert!(path(link).symlink_metadata().unwrap().is_symlink());
        }
        assert_eq!(entries(&path("far")).len(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_gets_the_content_and_stays_a_pipe() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let content = vec![7; 100_000];
        let nobody = write_atomically(&pipe, |file| file.write_all(&content)).unwrap_err();
        assert!(nobody.to_string().contains("nobody reads"), "{nobody}");
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        // The reader opens the pipe when its thread gets to it.
        while write_atomically(&pipe, |file| file.write_all(&content)).is_err() {
            std::thread::yield_now();
        }
        assert!(reader.join().unwrap() == content);
        assert!(pipe.metadata().unwrap().file_type().is_fifo());
        assert_eq!(entries(folder.path()), ["pipe"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_and_open_files_are_written_into() {
        use std::os::fd::AsRawFd;
        let device = fs::metadata("/dev/null").unwrap();
        write_atomically(Path::new("/dev/null"), |file| file.write_all(b"x")).unwrap();
        assert_eq!(
            fs::metadata("/dev/null").unwrap().file_type(),
            device.file_type()
        );
        let full = write_atomically(Path::new("/dev/full"), |file| file.write_all(b"x"));
        assert!(full.unwrap_err().to_string().contains("/dev/full"));
        // As /dev/stdout is, if it goes into a file.
        let mut open = tempfile::tempfile().unwrap();
        open.write_all(b"first ").unwrap();
        let path = format!("/dev/fd/{}", open.as_raw_fd());
        write_atomically(Path::new(&path), |file| file.write_all(b"second")).unwrap();
        let content = fs::read_to_string(&path).unwrap();
        assert_eq!(content, "first second");
    }
}
