//! Files as they are opened to be read: regular ones only. A named pipe would be waited for until somebody writes into
//! it, a terminal until somebody types, and a device may never end; and most readers look at a file more than once.

use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::Path;

/// Opens a file to be read.
///
/// # Errors
/// As [`File::open`]; also for pipes, devices and sockets.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.txt");
/// std::fs::write(&path, "1 2 3")?;
/// assert_eq!(protomer_io::input::read_to_string(&path)?, "1 2 3");
/// # #[cfg(unix)]
/// assert!(protomer_io::input::open("/dev/zero").is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn open(path: impl AsRef<Path>) -> io::Result<File> {
    let path = path.as_ref();
    let kind = path.metadata()?.file_type();
    // The system says what is wrong with a folder.
    if kind.is_file() || kind.is_dir() {
        return File::open(path);
    }
    let reason = format!(
        "it is {}, not a file; write its content into a file and name that",
        name_of(kind)
    );
    Err(io::Error::new(io::ErrorKind::InvalidInput, reason))
}

/// The bytes of a file.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.pdb");
/// std::fs::write(&path, "END\n")?;
/// assert_eq!(protomer_io::input::read(&path)?, b"END\n");
/// assert!(protomer_io::input::read(folder.path().join("b.pdb")).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// As [`open`], and if the file cannot be read.
pub fn read(path: impl AsRef<Path>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.txt");
/// std::fs::write(&path, [0xff])?;
/// assert!(protomer_io::input::read_to_string(&path).is_err(), "not UTF-8");
/// std::fs::write(&path, "3 Å")?;
/// assert_eq!(protomer_io::input::read_to_string(&path)?, "3 Å");
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// As [`read`], and for bytes that are not UTF-8.
pub fn read_to_string(path: impl AsRef<Path>) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.read_to_string(&mut text)?;
    Ok(text)
}

#[cfg(unix)]
fn name_of(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if kind.is_fifo() => "a pipe",
        () if kind.is_socket() => "a socket",
        () => "a device",
    }
}

#[cfg(not(unix))]
fn name_of(_: FileType) -> &'static str {
    "a device"
}
