//! Results that take long to make and are the same every time, kept in the user's cache folder.
//!
//! An entry is a file named by the hash of everything that shapes its content. It holds a line that says what it is, the
//! SHA-256 of the content, and the content. Entries appear whole or not at all, and are checked when read, so that two
//! programs may use one folder; removing any of them, at any time, costs time only.

use anyhow::{Context, Result, bail};
use protomer_io::atomic::{sha256_hex, write_atomically};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The environment variable that names another folder.
pub const FOLDER_VARIABLE: &str = "PROTOMER_CACHE_DIR";

const FIRST_LINE: &[u8] = b"protomer cache 1\n";
const HASH_LENGTH: usize = 64;

/// A folder of entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DiskCache {
    folder: PathBuf,
}

impl DiskCache {
    /// The cache in this folder, which is made when the first entry is written.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The user's: `PROTOMER_CACHE_DIR`, or `protomer` in `XDG_CACHE_HOME` or in `~/.cache`; `None` without any of them.
    pub fn of_user() -> Option<Self> {
        Self::of(|name| std::env::var_os(name))
    }

    fn of(variable: impl Fn(&str) -> Option<OsString>) -> Option<Self> {
        let set = |name: &str| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = set(FOLDER_VARIABLE)
            // The base directory specification: relative paths are to be ignored.
            .or_else(|| set("XDG_CACHE_HOME").filter(|path| path.is_absolute()).map(|path| path.join("protomer")))
            .or_else(|| set("HOME").map(|path| path.join(".cache").join("protomer")))?;
        Some(Self::new(folder))
    }

    /// Where an entry lies.
    pub fn path(&self, key: &str) -> PathBuf {
        self.folder.join(key)
    }

    /// The content of an entry; `None` if there is none.
    ///
    /// # Errors
    /// If there is one and it is damaged or cannot be read.
    pub fn load(&self, key: &str) -> Result<Option<Vec<u8>>> {
        let path = self.path(key);
        let mut bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
        };
        let head = FIRST_LINE.len() + HASH_LENGTH;
        if bytes.len() < head || !bytes.starts_with(FIRST_LINE) {
            bail!("{} is cut off or no entry of a cache", path.display());
        }
        let content = bytes.split_off(head);
        if bytes.get(FIRST_LINE.len()..) != Some(sha256_hex(&content).as_bytes()) {
            bail!("{} is damaged: its checksum is wrong", path.display());
        }
        Ok(Some(content))
    }

    /// Writes an entry; an older one stays until the new one is complete.
    ///
    /// # Errors
    /// If the folder or the disk does not take it.
    pub fn store(&self, key: &str, content: &[u8]) -> Result<()> {
        make_folder(&self.folder)?;
        let hash = sha256_hex(content);
        write_atomically(&self.path(key), |file| {
            file.write_all(FIRST_LINE)?;
            file.write_all(hash.as_bytes())?;
            file.write_all(content)
        })?;
        Ok(())
    }
}

fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::new(folder.path().join("deep/er"));
        assert_eq!(cache.load("key").unwrap(), None);
        cache.store("key", b"content").unwrap();
        assert_eq!(cache.load("key").unwrap().unwrap(), b"content");
        cache.store("key", b"").unwrap();
        assert_eq!(cache.load("key").unwrap().unwrap(), b"");
    }

    #[test]
    fn every_cut_and_every_changed_byte_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::new(folder.path());
        cache.store("key", b"some content").unwrap();
        let whole = std::fs::read(cache.path("key")).unwrap();
        for index in 0..whole.len() {
            std::fs::write(cache.path("key"), &whole[..index]).unwrap();
            assert!(cache.load("key").is_err(), "cut at {index}");
            let mut changed = whole.clone();
            changed[index] ^= 1;
            std::fs::write(cache.path("key"), changed).unwrap();
            assert!(cache.load("key").is_err(), "changed at {index}");
        }
    }

    #[test]
    fn the_folder_follows_the_environment() {
        let of = |variables: &'static [(&str, &str)]| {
            DiskCache::of(|name| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into()))
        };
        let folder = |path: &str| Some(DiskCache::new(path));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[("HOME", "/home/a")]), folder("/home/a/.cache/protomer"));
        assert_eq!(of(&[("HOME", "/home/a"), ("XDG_CACHE_HOME", "/c")]), folder("/c/protomer"));
        assert_eq!(of(&[("HOME", "/home/a"), ("XDG_CACHE_HOME", "c")]), folder("/home/a/.cache/protomer"));
        assert_eq!(of(&[("XDG_CACHE_HOME", "/c"), (FOLDER_VARIABLE, "mine")]), folder("mine"));
    }
}
