//! Results that take long to make and are the same every time, kept in the user's cache folder.
//!
//! An entry is a file named by the hash of everything that shapes its content. Entries appear whole
//! or not at all, and whoever reads one checks it, so that several programs may use one folder;
//! removing any of them, at any time, costs time only. What was not used for longest goes first
//! when there is no room.
//!
//! Entries hold energy tables, the comparisons of their levels, and effective charges. They take
//! seconds to make.

use anyhow::{Context, Result};
use protomer_io::atomic::write_atomically;
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The environment variable that names another folder; set to nothing, there is no cache.
pub const FOLDER_VARIABLE: &str = "PROTOMER_CACHE_DIR";

/// Largest size of all entries of a folder together, bytes.
pub const SIZE_LIMIT_BYTES: u64 = 2_000_000_000;

/// Ending of the names of entries; only such files are counted and removed.
const ENDING: &str = ".table";
/// Ending of the names of files that are being written.
const PARTIAL_ENDING: &str = ".partial";
/// A file still partial after this long was left by a program that ended.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 3600);

/// A folder of entries.
///
/// ```
/// use protomer_protein_verbs::stability::disk_cache::DiskCache;
/// use std::io::read_to_string;
/// # let folder = tempfile::tempdir()?;
/// let cache = DiskCache::new(folder.path());
/// assert_eq!(cache.load("answer", |file| read_to_string(file))?, None);
/// cache.store("answer", |file| write!(file, "42"))?;
/// assert_eq!(cache.load("answer", |file| read_to_string(file))?, Some("42".to_owned()));
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct DiskCache {
    folder: PathBuf,
    limit_bytes: u64,
    /// Function that is told when the folder is made.
    tell: fn(&str),
}

impl DiskCache {
    /// The cache in this folder, which is made when the first entry is written.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            limit_bytes: SIZE_LIMIT_BYTES,
            tell: |_| (),
        }
    }

    /// The same cache, which tells when it makes its folder: where that is, how large it may get,
    /// and how to empty it.
    pub fn telling(self, tell: fn(&str)) -> Self {
        Self { tell, ..self }
    }

    /// The folder, what it holds and what it may hold.
    pub fn describe(&self) -> String {
        let mut entries = files(&self.folder);
        entries.retain(|file| file.path.to_string_lossy().ends_with(ENDING));
        let held_bytes: u64 = entries.iter().map(|file| file.bytes).sum();
        format!(
            "cache: {}, {:.1} MB of at most {:.0} MB",
            self.folder.display(),
            1e-6 * held_bytes as f64,
            1e-6 * self.limit_bytes as f64
        )
    }

    /// The same cache with another limit, bytes.
    pub fn with_limit(self, limit_bytes: u64) -> Self {
        Self {
            limit_bytes,
            ..self
        }
    }

    /// The cache of the user: `PROTOMER_CACHE_DIR`, or `protomer` in `XDG_CACHE_HOME` or in
    /// `~/.cache`; `None` without any of them, or if the first is set to nothing.
    pub fn of_user() -> Option<Self> {
        Self::from_environment(|name| std::env::var_os(name))
    }

    fn from_environment(variable: impl Fn(&str) -> Option<OsString>) -> Option<Self> {
        if variable(FOLDER_VARIABLE).is_some_and(|value| value.is_empty()) {
            // Set to nothing is a wish, not an absence.
            return None;
        }
        let set = |name: &str| {
            variable(name)
                .filter(|value| !value.is_empty())
                .map(PathBuf::from)
        };
        let folder = set(FOLDER_VARIABLE)
            // The base directory specification: relative paths are to be ignored.
            .or_else(|| {
                set("XDG_CACHE_HOME")
                    .filter(|path| path.is_absolute())
                    .map(|path| path.join("protomer"))
            })
            .or_else(|| set("HOME").map(|path| path.join(".cache").join("protomer")))?;
        Some(Self::new(folder))
    }

    /// Path of an entry.
    pub fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}{ENDING}"))
    }

    /// Reads an entry with `read`; `None` if there is no such entry.
    ///
    /// # Errors
    /// If there is one that cannot be opened or that `read` refuses; names the file.
    pub fn load<T, E>(
        &self,
        key: &str,
        read: impl FnOnce(&mut dyn Read) -> Result<T, E>,
    ) -> Result<Option<T>>
    where
        E: std::error::Error + Send + Sync + 'static,
    {
        let path = self.path(key);
        let file = match protomer_io::input::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot open {}", path.display()));
            }
        };
        // A large buffer: tables are read in many small pieces.
        let value = read(&mut BufReader::with_capacity(1 << 16, &file))
            .with_context(|| path.display().to_string())?;
        // When it was last used, where the folder takes it; otherwise its age counts from when it
        // was written.
        let _ = File::options()
            .append(true)
            .open(&path)
            .and_then(|file| file.set_modified(SystemTime::now()));
        Ok(Some(value))
    }

    /// Writes an entry, then removes others while the folder holds more than its limit.
    ///
    /// # Errors
    /// If the folder or the disk does not take it.
    pub fn store(
        &self,
        key: &str,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<()> {
        self.make_folder()
            .with_context(|| format!("cannot make the folder {}", self.folder.display()))?;
        write_atomically(&self.path(key), write)?;
        // After the entry is there, so the newest one counts as used last.
        self.make_room();
        Ok(())
    }

    /// Makes the folder if there is none; whoever does, tells.
    fn make_folder(&self) -> std::io::Result<()> {
        // The base folder may be missing too, but only our own is told of.
        if let Some(parent) = self.folder.parent() {
            std::fs::create_dir_all(parent)?;
        }
        // `create_dir` succeeds for exactly one of several programs: that one tells.
        match std::fs::create_dir(&self.folder) {
            Ok(()) => {
                (self.tell)(&format!(
                    "what takes long to make is kept in {0}, at most {1:.0} GB; empty it with \
                     rm -r {0}, or do without: --no-cache",
                    self.folder.display(),
                    1e-9 * self.limit_bytes as f64
                ));
                Ok(())
            }
            Err(_) if self.folder.is_dir() => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Removes entries, the one not used for longest first, until the rest is within the limit. A
    /// file that another program removed meanwhile, or that cannot be removed, is passed over.
    fn make_room(&self) {
        let mut entries = files(&self.folder);
        entries.retain(|file| {
            let abandoned = file.path.to_string_lossy().ends_with(PARTIAL_ENDING)
                && file.used.elapsed().is_ok_and(|age| age > ABANDONED_AFTER);
            if abandoned {
                let _ = std::fs::remove_file(&file.path);
            }
            file.path.to_string_lossy().ends_with(ENDING)
        });
        entries.sort_by_key(|file| file.used);
        let mut held_bytes: u64 = entries.iter().map(|file| file.bytes).sum();
        for file in entries {
            // Oldest first, until the rest fits.
            if held_bytes <= self.limit_bytes {
                break;
            }
            let _ = std::fs::remove_file(&file.path);
            // Counted as gone even if it could not be removed:
            // another program has removed it, or nobody can.
            held_bytes -= file.bytes;
        }
    }
}

struct FoundFile {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

/// The entries of a folder and those being written; what does not look like either is left out.
fn files(folder: &Path) -> Vec<FoundFile> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let cache_files = entries.flatten().filter_map(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let (name, is_ours) = match name.strip_suffix(PARTIAL_ENDING) {
            Some(partial) => (
                partial.trim_start_matches('.').to_owned(),
                partial.contains(ENDING),
            ),
            None => (name.clone(), name.ends_with(ENDING)),
        };
        let key = name.split('.').next().unwrap_or_default();
        let is_ours =
            // Keys are hexadecimal: other files in the folder are not ours.
            is_ours && !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_hexdigit());
        let metadata = entry
            .metadata()
            .ok()
            .filter(|metadata| is_ours && metadata.is_file())?;
        Some(FoundFile {
            path: entry.path(),
            bytes: metadata.len(),
            used: metadata.modified().ok()?,
        })
    });
    cache_files.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(cache: &DiskCache, key: &str) -> Result<Option<Vec<u8>>> {
        cache.load(key, |file| {
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).map(|_| bytes)
        })
    }

    #[test]
    fn what_is_stored_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::new(folder.path().join("deep/er"));
        assert_eq!(load(&cache, "ab").unwrap(), None);
        cache
            .store("ab", |file| file.write_all(b"content"))
            .unwrap();
        assert_eq!(load(&cache, "ab").unwrap().unwrap(), b"content");
        cache.store("ab", |_| Ok(())).unwrap();
        assert_eq!(load(&cache, "ab").unwrap().unwrap(), b"");
    }

    #[test]
    fn an_entry_that_is_refused_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::new(folder.path());
        cache
            .store("ab", |file| file.write_all(b"content"))
            .unwrap();
        let refuse = |_: &mut dyn Read| Err::<(), _>(std::io::Error::other("it is damaged"));
        let message = format!("{:#}", cache.load("ab", refuse).unwrap_err());
        assert!(
            message.contains("ab.table") && message.contains("it is damaged"),
            "{message}"
        );
    }

    #[test]
    fn what_was_not_used_for_longest_makes_room_and_other_files_stay() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::new(folder.path()).with_limit(25);
        let age = |path: &Path, seconds: u64| {
            let file = File::options().append(true).open(path).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(seconds))
                .unwrap();
        };
        for name in ["letter.table", "ab.txt", ".letter.partial"] {
            std::fs::write(folder.path().join(name), [0; 100]).unwrap();
            age(&folder.path().join(name), 1_000_000);
        }
        let abandoned = folder.path().join(".aa.table.1-0.partial");
        std::fs::write(&abandoned, [0; 100]).unwrap();
        age(&abandoned, 100_000);
        let ten = |file: &mut dyn Write| file.write_all(&[0; 10]);
        cache.store("a1", ten).unwrap();
        age(&cache.path("a1"), 300);
        cache.store("a2", ten).unwrap();
        age(&cache.path("a2"), 200);
        // Using the older one makes it the younger one.
        load(&cache, "a1").unwrap().unwrap();
        cache.store("a3", ten).unwrap();
        let exists = |key: &str| cache.path(key).exists();
        assert!(exists("a1") && !exists("a2") && exists("a3"));
        assert!(!abandoned.exists());
        for name in ["letter.table", "ab.txt", ".letter.partial"] {
            assert!(folder.path().join(name).exists(), "{name}");
        }
    }

    #[test]
    fn the_folder_follows_the_environment() {
        let chosen = |variables: &'static [(&str, &str)]| {
            DiskCache::from_environment(|name| {
                variables
                    .iter()
                    .find(|(known, _)| *known == name)
                    .map(|(_, value)| value.into())
            })
            .map(|cache| cache.folder)
        };
        let folder = |path: &str| Some(PathBuf::from(path));
        assert_eq!(chosen(&[]), None);
        assert_eq!(chosen(&[("HOME", "/home/a"), (FOLDER_VARIABLE, "")]), None);
        assert_eq!(
            chosen(&[("HOME", "/home/a")]),
            folder("/home/a/.cache/protomer")
        );
        assert_eq!(
            chosen(&[("HOME", "/home/a"), ("XDG_CACHE_HOME", "/c")]),
            folder("/c/protomer")
        );
        assert_eq!(
            chosen(&[("HOME", "/home/a"), ("XDG_CACHE_HOME", "c")]),
            folder("/home/a/.cache/protomer")
        );
        assert_eq!(
            chosen(&[("XDG_CACHE_HOME", "/c"), (FOLDER_VARIABLE, "mine")]),
            folder("mine")
        );
    }
}
