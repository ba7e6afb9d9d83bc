//! Finds, reads, decompresses and hashes input files.

use anyhow::{Context, Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_io::gzip::read_maybe_gzip_from;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Upper limit for a decompressed structure or mesh file.
const LARGEST_INPUT_BYTES: u64 = 2_000_000_000;

/// Extensions of the structure files that a folder is searched for, each also with `.gz`.
const STRUCTURE_ENDINGS: [&str; 5] = ["pdb", "ent", "cif", "mmcif", "pqr"];

/// The relative path from a directory, which need not exist yet, to a file. It stays valid when a
/// folder that holds both is moved. `None` if there is no such file, or no relative path.
///
/// ```
/// use protomer_common::input::path_from;
/// use std::path::Path;
/// # let folder = tempfile::tempdir()?;
/// std::fs::create_dir(folder.path().join("results"))?;
/// std::fs::write(folder.path().join("5pti.pdb"), "END\n")?;
/// let path = path_from(&folder.path().join("5pti.pdb"), &folder.path().join("results"));
/// assert_eq!(path.as_deref(), Some(Path::new("../5pti.pdb")));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn path_from(file: &Path, directory: &Path) -> Option<PathBuf> {
    let file = file.canonicalize().ok()?;
    let from = directory
        .canonicalize()
        .or_else(|_| std::path::absolute(directory))
        .ok()?;
    let both = file.components().zip(from.components());
    // The folders that both share are left out; up from the rest, then down to the file.
    let common = both.take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|_| Component::ParentDir);
    // Nothing in common, as on two drives: no relative path exists.
    (common > 0).then(|| up.chain(file.components().skip(common)).collect())
}

/// A file in memory.
///
/// ```
/// use protomer_common::input::InputFile;
/// use std::path::Path;
/// let file = InputFile::read(Path::new("../../../data/structures/5pti.cif.gz"))?;
/// assert!(file.bytes.starts_with(b"data_5PTI"));
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct InputFile {
    /// Name as the user gave it.
    pub name: String,
    /// Content, decompressed.
    pub bytes: Vec<u8>,
    /// SHA-256 of the file as stored, before decompression.
    pub sha256: String,
}

impl InputFile {
    /// Reads a file, decompressing it if it is gzipped.
    ///
    /// ```
    /// use protomer_common::input::InputFile;
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("points.csv");
    /// std::fs::write(&path, "x,y,z\n")?;
    /// let file = InputFile::read(&path)?;
    /// assert_eq!((&file.bytes[..], file.sha256.len()), (&b"x,y,z\n"[..], 64));
    /// assert!(InputFile::read(&folder.path().join("missing.csv")).is_err());
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// Names the file and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        // Hashed as stored: the digest is the one that `sha256sum` shows.
        let raw = stored_bytes(path)?;
        let sha256 = sha256_hex(&raw);
        let bytes = if raw.starts_with(&[0x1f, 0x8b]) {
            read_maybe_gzip_from(&name, raw.as_slice(), LARGEST_INPUT_BYTES)?
        } else {
            raw
        };
        Ok(Self {
            name,
            bytes,
            sha256,
        })
    }

    /// Computes the SHA-256 of a file as stored, without decompression.
    ///
    /// ```
    /// use protomer_common::input::InputFile;
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("abc.txt");
    /// std::fs::write(&path, "abc")?;
    /// assert!(InputFile::sha256_of(&path)?.starts_with("ba7816bf8f01cfea"));
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// Names the file.
    pub fn sha256_of(path: &Path) -> Result<String> {
        Ok(sha256_hex(&stored_bytes(path)?))
    }
}

/// A file as it is stored.
fn stored_bytes(path: &Path) -> Result<Vec<u8>> {
    let name = path.display();
    if path.is_dir() {
        bail!("{name} is a folder; name a file");
    }
    let mut raw = Vec::new();
    protomer_io::input::open(path)
        // One byte more than allowed tells a file that just fits from a larger one.
        .and_then(|file| file.take(LARGEST_INPUT_BYTES + 1).read_to_end(&mut raw))
        .with_context(|| cannot_read("", path))?;
    if raw.len() as u64 > LARGEST_INPUT_BYTES {
        bail!(
            "{name} holds more than {LARGEST_INPUT_BYTES} bytes; give a structure, mesh or point file"
        );
    }
    Ok(raw)
}

/// The beginning of the error for a file that cannot be read, with a word for it or none. Where there is no
/// file of this name, it says what may be meant: a structure file whose name begins so, or an entry of the
/// Protein Data Bank.
///
/// ```
/// use protomer_common::input::cannot_read;
/// use std::path::Path;
/// let message = cannot_read("", Path::new("4hhb"));
/// assert_eq!(message, "cannot read 4hhb; 'protomer fetch 4hhb' downloads this entry of the Protein Data Bank");
/// assert_eq!(cannot_read("the assembly", Path::new("a.json")), "cannot read the assembly a.json");
/// ```
pub fn cannot_read(word: &str, path: &Path) -> String {
    let unread = match word {
        "" => format!("cannot read {}", path.display()),
        _ => format!("cannot read {word} {}", path.display()),
    };
    if path.exists() {
        return unread;
    }
    if let Some(structure) = structure_called(path) {
        return format!(
            "{unread}; there is {}: name it in full",
            structure.display()
        );
    }
    match path.to_str().filter(|name| is_pdb_entry(name)) {
        Some(entry) => format!(
            "{unread}; 'protomer fetch {entry}' downloads this entry of the Protein Data Bank"
        ),
        None => unread,
    }
}

/// Whether a word is an entry of the Protein Data Bank: four characters that begin with a digit, or `pdb_`
/// and eight characters.
///
/// ```
/// use protomer_common::input::is_pdb_entry;
/// assert!(is_pdb_entry("4hhb") && is_pdb_entry("pdb_00004HHB"));
/// assert!(!is_pdb_entry("cube") && !is_pdb_entry("4hhb.pdb"));
/// ```
pub fn is_pdb_entry(word: &str) -> bool {
    let lower = word.to_ascii_lowercase();
    let classic = lower.len() == 4 && lower.starts_with(|c: char| c.is_ascii_digit());
    let extended = lower.len() == 12 && lower.starts_with("pdb_");
    let is_plain = lower.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    (classic || extended) && is_plain
}

/// A structure file with this name and an ending, which was left out.
fn structure_called(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let compressed = std::iter::once(format!("{name}.gz"));
    let endings = STRUCTURE_ENDINGS.iter();
    let files = endings.flat_map(|end| [format!("{name}.{end}"), format!("{name}.{end}.gz")]);
    let mut paths = compressed
        .chain(files)
        .map(|file| path.with_file_name(file));
    paths.find(|path| path.is_file() && is_structure(path))
}

/// Expands folders and lists: a folder stands for the structure files in it, sorted by name, and a
/// file `NAME.txt` for those that it names ([`listed_in`]).
///
/// # Errors
/// If a folder or a list cannot be read, or holds no structure files.
///
/// ```
/// use std::path::PathBuf;
/// let files = protomer_common::input::expand(&[PathBuf::from("../../../data/structures")])?;
/// assert!(files.iter().any(|file| file.ends_with("5pti.cif.gz")));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn expand(inputs: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for input in inputs {
        if input.extension().is_some_and(|ending| ending == "txt") && input.is_file() {
            files.extend(listed_in(input)?);
            continue;
        }
        if !input.is_dir() {
            files.push(input.clone());
            continue;
        }
        let entries = input
            .read_dir()
            .with_context(|| format!("cannot read the folder {}", input.display()))?;
        let mut structures = Vec::new();
        for entry in entries {
            let path = entry
                .with_context(|| format!("cannot read the folder {}", input.display()))?
                .path();
            if path.is_file() && is_structure(&path) {
                require_text(&path)?;
                structures.push(path);
            }
        }
        if structures.is_empty() {
            bail!(
                "{} holds no structure file ({})",
                input.display(),
                STRUCTURE_ENDINGS.join(", ")
            );
        }
        structures.sort();
        files.extend(structures);
    }
    Ok(files)
}

/// The files that a text file names, one a line, relative to its folder. Empty lines and those that
/// begin with `#` are left out.
///
/// # Errors
/// If the file cannot be read or names nothing.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let list = folder.path().join("files.txt");
/// std::fs::write(&list, "# two\n1crn.pdb\n\nmore/5pti.cif.gz\n")?;
/// let files = protomer_common::input::listed_in(&list)?;
/// assert_eq!(files, [folder.path().join("1crn.pdb"), folder.path().join("more/5pti.cif.gz")]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn listed_in(list: &Path) -> Result<Vec<PathBuf>> {
    let shown = list.display();
    let text =
        protomer_io::input::read_to_string(list).with_context(|| format!("cannot read {shown}"))?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let mut files = Vec::new();
    for line in text.lines().map(str::trim) {
        if !line.is_empty() && !line.starts_with('#') {
            files.push(folder.join(line));
        }
    }
    if files.is_empty() {
        bail!("{shown} names no file; write one a line");
    }
    Ok(files)
}

/// Refuses a file whose name is not UTF-8: results name their inputs as text, and two such names may look the same.
///
/// # Errors
/// Names the file as far as it can be written.
pub fn require_text(path: &Path) -> Result<()> {
    if path.to_str().is_none() {
        bail!("the name {path:?} is not UTF-8; rename the file");
    }
    Ok(())
}

fn is_structure(path: &Path) -> bool {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    STRUCTURE_ENDINGS.iter().any(|ending| {
        name.strip_suffix(ending)
            .is_some_and(|stem| stem.ends_with('.'))
    })
}

/// The file name without folder and extensions: `5pti` for `data/5pti.pdb.gz`.
///
/// ```
/// use std::path::Path;
/// assert_eq!(protomer_common::input::stem(Path::new("data/5pti.pdb.gz")), "5pti");
/// ```
pub fn stem(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.')
        .map_or(name, |(stem, _)| stem)
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_its_ending_is_completed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("4hhb.cif.gz");
        std::fs::write(&file, "").unwrap();
        let message = cannot_read("", &folder.path().join("4hhb"));
        assert!(message.ends_with(&format!("there is {}: name it in full", file.display())));
        let message = cannot_read("", &folder.path().join("4hhb.cif"));
        assert!(message.contains("there is"), "{message}");
        let other = folder.path().join("4hhc");
        assert_eq!(
            cannot_read("", &other),
            format!("cannot read {}", other.display())
        );
    }
}
