//! Reads files that may be gzipped, without trusting their size.

use crate::{IoError, Result};
use flate2::read::MultiGzDecoder;
use std::io::Read;
use std::path::Path;

const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Reads a file, decompressing it if it starts like a gzip file, whatever its name. At most
/// `limit_bytes` are held in memory, which protects against huge files and decompression bombs.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("notes.txt");
/// std::fs::write(&path, "plain text")?;
/// assert_eq!(protomer_io::gzip::read_maybe_gzip(&path, 100)?, b"plain text");
/// assert!(protomer_io::gzip::read_maybe_gzip(&path, 5).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IoError::File`] if the system call fails, [`IoError::TooLarge`] beyond the limit,
/// [`IoError::Parse`] for a damaged gzip file.
pub fn read_maybe_gzip(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    let name = path.display().to_string();
    let file = crate::input::open(path).map_err(IoError::file(path, "open"))?;
    let metadata = file.metadata().map_err(IoError::file(path, "read"))?;
    if metadata.is_dir() {
        let is_folder = std::io::Error::new(std::io::ErrorKind::IsADirectory, "it is a folder");
        return Err(IoError::file(path, "read")(is_folder));
    }
    // The length of a regular file is known before any of it is read.
    if metadata.len() > limit_bytes {
        return Err(too_large(&name, limit_bytes, false));
    }
    read_bounded(path, file, limit_bytes)
}

/// Variant of [`read_maybe_gzip`] for any reader, such as standard input.
///
/// ```
/// let content = protomer_io::gzip::read_maybe_gzip_from("-", &b"ATOM"[..], 1 << 20)?;
/// assert_eq!(content, b"ATOM");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// As [`read_maybe_gzip`].
pub fn read_maybe_gzip_from(name: &str, reader: impl Read, limit_bytes: u64) -> Result<Vec<u8>> {
    read_bounded(Path::new(name), reader, limit_bytes)
}

fn read_bounded(path: &Path, mut reader: impl Read, limit_bytes: u64) -> Result<Vec<u8>> {
    let name = path.display().to_string();
    // The content tells, not the name: files are renamed, and standard input has none.
    let mut start = Vec::with_capacity(GZIP_MAGIC.len());
    (&mut reader)
        .take(GZIP_MAGIC.len() as u64)
        .read_to_end(&mut start)
        .map_err(IoError::file(path, "read"))?;
    let compressed = start == GZIP_MAGIC;
    // The first two bytes were taken from the reader and go back in front.
    let whole = start.as_slice().chain(reader);
    let mut content = Vec::new();
    // One byte beyond the limit distinguishes a file that just fits from one that does not.
    let bound = limit_bytes.saturating_add(1);
    if compressed {
        // Several gzip members may follow each other. The
        // limit is on what comes out: a bomb is small.
        let mut decoder = MultiGzDecoder::new(whole).take(bound);
        if let Err(error) = decoder.read_to_end(&mut content) {
            let cause = format!("the gzip data are damaged or truncated ({error})");
            let remedy = "compress or download the file again";
            return Err(IoError::parse(&name, 0, cause, remedy));
        }
    } else {
        whole
            .take(bound)
            .read_to_end(&mut content)
            .map_err(IoError::file(path, "read"))?;
    }
    if content.len() as u64 > limit_bytes {
        return Err(too_large(&name, limit_bytes, compressed));
    }
    Ok(content)
}

fn too_large(name: &str, limit_bytes: u64, compressed: bool) -> IoError {
    IoError::TooLarge {
        file: name.to_owned(),
        limit_bytes,
        compressed,
        remedy: "check that it is the right file, split it, or raise the limit".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn gzip(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn plain_and_gzipped_files_read_the_same() {
        let content = b"ATOM and so on\n".repeat(1000);
        let mut two_members = gzip(&content[..5000]);
        two_members.extend(gzip(&content[5000..]));
        for bytes in [content.clone(), gzip(&content), two_members] {
            let path = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(&path, &bytes).unwrap();
            assert_eq!(read_maybe_gzip(path.path(), 15_000).unwrap(), content);
        }
        assert_eq!(read_maybe_gzip_from("-", &b""[..], 10).unwrap(), b"");
        assert_eq!(read_maybe_gzip_from("-", &b"x"[..], 10).unwrap(), b"x");
    }

    #[test]
    fn a_bomb_is_refused_at_the_limit() {
        let bomb = gzip(&vec![0; 10_000_000]);
        assert!(bomb.len() < 20_000);
        let error = read_maybe_gzip_from("bomb.gz", bomb.as_slice(), 1_000_000).unwrap_err();
        assert!(
            matches!(
                error,
                IoError::TooLarge {
                    compressed: true,
                    ..
                }
            ),
            "{error}"
        );
        assert!(
            error
                .to_string()
                .contains("bomb.gz: it holds more than 1000000 bytes once decompressed"),
            "{error}"
        );
        let error = read_maybe_gzip_from("big", std::io::repeat(b'A'), 1_000_000).unwrap_err();
        assert!(
            matches!(
                error,
                IoError::TooLarge {
                    compressed: false,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn damaged_gzip_is_named() {
        let bytes = gzip(&b"some text to compress ".repeat(100));
        let error = read_maybe_gzip_from("cut.gz", &bytes[..bytes.len() - 9], 1 << 20).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("cut.gz: the gzip data are damaged or truncated"),
            "{error}"
        );
        let missing = read_maybe_gzip(Path::new("/no/such/file"), 10).unwrap_err();
        assert!(
            missing.to_string().contains("cannot open /no/such/file"),
            "{missing}"
        );
        let folder = read_maybe_gzip(Path::new("/tmp"), u64::MAX).unwrap_err();
        assert!(folder.to_string().contains("folder"), "{folder}");
    }
}
