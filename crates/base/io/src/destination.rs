//! What a path that is to be written leads to.

use crate::{IoError, Result};
use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};

/// Longest chain of links that is followed, as on Linux.
const MOST_LINKS: usize = 40;

/// Destination of a path, with links followed.
///
/// ```
/// use protomer_io::destination::Destination;
/// # let folder = tempfile::tempdir()?;
/// let file = folder.path().join("log.csv");
/// assert!(matches!(Destination::find(&file)?, Destination::Replaceable(path) if path == file));
/// assert!(Destination::find(folder.path()).is_err(), "a folder is not replaced by a file");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub enum Destination {
    /// A regular file, or none yet: it is replaced as a whole.
    Replaceable(PathBuf),
    /// A device, a pipe, or an open file of a process, opened for writing at its end.
    Stream(File),
}

impl Destination {
    /// Finds out what `path` leads to.
    ///
    /// ```
    /// use protomer_io::destination::Destination;
    /// use std::path::Path;
    /// let found = Destination::find(Path::new("new.csv"))?;
    /// assert!(matches!(found, Destination::Replaceable(file) if file == Path::new("new.csv")));
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::File`] for a folder, a socket, a disk, a pipe that nobody reads, links that lead in a
    /// circle, and a device that cannot be opened.
    pub fn find(path: &Path) -> Result<Self> {
        // Followed by hand, one link at a time: the file is to be replaced
        // where it lies, and the last part of the chain may not exist yet.
        let mut file = path.to_owned();
        for _ in 0..MOST_LINKS {
            // Resolving these would give a path like `pipe:[123]`, or one that was removed.
            if is_of_a_process(&file) {
                return open(path).map(Self::Stream);
            }
            match fs::symlink_metadata(&file) {
                Ok(metadata) if metadata.is_symlink() => {
                    let target = fs::read_link(&file).map_err(IoError::file(path, "follow"))?;
                    // An absolute target replaces the whole path.
                    file = file.parent().unwrap_or(Path::new("")).join(target);
                }
                Ok(metadata) if is_stream(&metadata) => return open(path).map(Self::Stream),
                Ok(metadata) if !metadata.is_file() => return Err(refused(path, &metadata)),
                // Whatever else is wrong is said where the file is written.
                Ok(_) | Err(_) => return Ok(Self::Replaceable(file)),
            }
        }
        Err(other(path, "its links lead in a circle"))
    }
}

/// Whether something is there that is written into and not replaced, so that nothing is lost.
///
/// ```
/// use protomer_io::destination::is_stream_at;
/// use std::path::Path;
/// assert!(!is_stream_at(Path::new("Cargo.toml")));
/// # #[cfg(target_os = "linux")]
/// assert!(is_stream_at(Path::new("/dev/null")));
/// ```
pub fn is_stream_at(path: &Path) -> bool {
    is_of_a_process(path)
        || fs::metadata(path).is_ok_and(|metadata| is_stream(&metadata))
        || fs::read_link(path).is_ok_and(|target| is_of_a_process(&target))
}

/// Whether a path names an open file of a process, as `/dev/stdout` does on Linux: a link whose target is
/// not always a path.
fn is_of_a_process(path: &Path) -> bool {
    path.starts_with("/proc") || path.starts_with("/dev/fd")
}

#[cfg(unix)]
fn is_stream(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    kind.is_char_device() || kind.is_fifo()
}

#[cfg(not(unix))]
fn is_stream(_: &fs::Metadata) -> bool {
    false
}

fn open(path: &Path) -> Result<File> {
    let mut options = OpenOptions::new();
    // At the end: the shell may have redirected several commands into the same file.
    options.append(true);
    // Opening a pipe waits for a reader. A first opening that does not wait tells whether there is one.
    let _reader_is_there = probe(&options, path)?;
    options.open(path).map_err(IoError::file(path, "write"))
}

#[cfg(unix)]
fn probe(options: &OpenOptions, path: &Path) -> Result<Option<File>> {
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    if !fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo()) {
        return Ok(None);
    }
    // Without a reader this fails at once instead of waiting for one that may never come.
    let opened = options.clone().custom_flags(libc::O_NONBLOCK).open(path);
    match opened {
        Ok(file) => Ok(Some(file)),
        Err(error) if error.raw_os_error() == Some(libc::ENXIO) => Err(other(
            path,
            "it is a pipe that nobody reads; start its reader first",
        )),
        Err(error) => Err(IoError::file(path, "write")(error)),
    }
}

#[cfg(not(unix))]
fn probe(_: &OpenOptions, _: &Path) -> Result<Option<File>> {
    Ok(None)
}

fn refused(path: &Path, metadata: &fs::Metadata) -> IoError {
    let reason = match metadata.is_dir() {
        true => "it is a folder; name a file",
        false => "it is no regular file; name another",
    };
    other(path, reason)
}

fn other(path: &Path, reason: &str) -> IoError {
    IoError::file(path, "write")(std::io::Error::other(reason.to_owned()))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn folders_sockets_and_circles_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        symlink("b", path("a")).unwrap();
        symlink("a", path("b")).unwrap();
        let cases = [
            (folder.path().to_owned(), "name a file"),
            (path("socket"), "no regular file"),
            (path("a"), "circle"),
        ];
        for (path, cause) in cases {
            let message = Destination::find(&path).unwrap_err().to_string();
            assert!(message.contains(cause), "{message}");
        }
    }

    #[test]
    fn a_link_to_nothing_leads_to_a_new_file() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        symlink("new", &link).unwrap();
        let target = Destination::find(&link).unwrap();
        assert!(
            matches!(&target, Destination::Replaceable(file) if *file == folder.path().join("new")),
            "{target:?}"
        );
    }
}
