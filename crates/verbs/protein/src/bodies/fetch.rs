//! Downloads entries from the Protein Data Bank, only on request.

use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::input::is_pdb_entry;
use protomer_io::atomic::write_atomically;
use protomer_results::{Progress, ResultKind};
use serde::Serialize;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Base address of the entry files of the RCSB.
pub const RCSB_DOWNLOAD: &str = "https://files.rcsb.org/download";

/// An upper limit for a compressed entry file.
const LARGEST_DOWNLOAD_BYTES: u64 = 1 << 30;

/// Entries that were downloaded or already present.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Fetched {
    /// Entries with their files, in the order given.
    pub files: Vec<FetchedEntry>,
}

/// An entry and its file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FetchedEntry {
    /// The entry as requested.
    pub entry: String,
    /// File of the entry.
    pub file: PathBuf,
}

impl Answer for Fetched {
    fn text(&self) -> String {
        let line =
            |structure: &FetchedEntry| format!("{}: {}", structure.entry, structure.file.display());
        self.files.iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

/// Downloads entries one after another.
///
/// # Errors
/// As [`fetch`], for the first entry that fails; earlier downloads are kept.
pub fn fetch_all(
    entries: &[String],
    base: &str,
    folder: &Path,
    force: bool,
    progress: &dyn Progress,
) -> Result<Fetched> {
    progress.begin(entries.len() as u64, "entries");
    let mut files = Vec::new();
    for entry in entries {
        files.push(FetchedEntry {
            entry: entry.clone(),
            file: fetch(entry, base, folder, force)?,
        });
        progress.advance(1);
    }
    Ok(Fetched { files })
}

/// Downloads `ENTRY.cif.gz` from `base` into `folder` and returns the file's path. An existing
/// file is kept unless `force` is set.
///
/// # Errors
/// For a malformed entry name, an entry unknown to the server, a broken connection, or a file
/// that cannot be written.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::fetch::{RCSB_DOWNLOAD, fetch};
/// use std::path::Path;
/// let file = fetch("6MDR", RCSB_DOWNLOAD, Path::new("structures"), false)?;
/// assert!(file.ends_with("6MDR.cif.gz"));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn fetch(entry: &str, base: &str, folder: &Path, force: bool) -> Result<PathBuf> {
    let entry = checked_entry(entry)?;
    ResultKind::VoxelSet.refuse_in(folder)?;
    let path = folder.join(format!("{entry}.cif.gz"));
    if path.exists() && !force {
        return Ok(path);
    }
    let url = format!(
        "{}/{}.cif.gz",
        base.trim_end_matches('/'),
        entry.to_uppercase()
    );
    let body = download(&url)?;
    if !body.starts_with(&[0x1f, 0x8b]) {
        bail!(
            "{url} did not answer with a gzip file; check the base address, or download the entry by hand"
        );
    }
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    write_atomically(&path, |file| file.write_all(&body))?;
    Ok(path)
}

/// PDB identifiers are four characters beginning with a digit, or `pdb_` and eight characters.
fn checked_entry(entry: &str) -> Result<String> {
    if is_pdb_entry(entry) {
        Ok(entry.to_lowercase())
    } else {
        bail!(
            "'{entry}' is not a PDB entry; give four characters such as 6MDR, or twelve such as pdb_00006mdr"
        )
    }
}

fn download(url: &str) -> Result<Vec<u8>> {
    let agent: ureq::Agent = ureq::Agent::config_builder()
        .timeout_connect(Some(Duration::from_secs(20)))
        .timeout_recv_response(Some(Duration::from_secs(60)))
        .http_status_as_error(false)
        .build()
        .into();
    let mut response = agent
        .get(url)
        .header("accept-encoding", "identity")
        .call()
        .with_context(|| {
            format!("cannot reach {url}; check the network, or set --base to a mirror")
        })?;
    match response.status().as_u16() {
        200 => {}
        404 => bail!("{url} does not exist; check the entry's name"),
        status => {
            bail!("{url} answered with status {status}; try again later, or set --base to a mirror")
        }
    }
    let mut body = Vec::new();
    let reader = response
        .body_mut()
        .with_config()
        .limit(LARGEST_DOWNLOAD_BYTES)
        .reader();
    reader
        .take(LARGEST_DOWNLOAD_BYTES)
        .read_to_end(&mut body)
        .with_context(|| {
            format!(
                "the download of {url} was interrupted after {} bytes; try again",
                body.len()
            )
        })?;
    Ok(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader, Write};
    use std::net::TcpListener;

    /// Serves each response once on the loopback interface and returns the base address.
    fn serve(responses: Vec<Vec<u8>>) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        std::thread::spawn(move || {
            for response in responses {
                let (mut stream, _) = listener.accept().unwrap();
                let mut reader = BufReader::new(stream.try_clone().unwrap());
                let mut line = String::new();
                while reader.read_line(&mut line).unwrap() > 2 {
                    line.clear();
                }
                stream.write_all(&response).unwrap();
            }
        });
        format!("http://{address}/download")
    }

    fn answer(status: &str, body: &[u8], claimed_length: usize) -> Vec<u8> {
        let mut bytes = format!(
            "HTTP/1.1 {status}\r\ncontent-length: {claimed_length}\r\nconnection: close\r\n\r\n"
        );
        bytes.push_str("");
        let mut bytes = bytes.into_bytes();
        bytes.extend_from_slice(body);
        bytes
    }

    #[test]
    fn an_entry_is_downloaded_once() {
        let folder = tempfile::tempdir().unwrap();
        let gzip = [0x1f, 0x8b, 8, 0, 1, 2, 3];
        let base = serve(vec![answer("200 OK", &gzip, gzip.len())]);
        let path = fetch("6MDR", &base, folder.path(), false).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), gzip);
        // The server answers once only: the second call must not ask again.
        assert_eq!(fetch("6mdr", &base, folder.path(), false).unwrap(), path);
    }

    #[test]
    fn failures_are_told_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let gzip = [0x1f, 0x8b, 8];
        let cases = [
            (answer("404 Not Found", b"", 0), "does not exist"),
            (answer("503 Busy", b"", 0), "status 503"),
            (answer("200 OK", b"<html>", 6), "gzip"),
            (answer("200 OK", &gzip, 1000), "was interrupted"),
        ];
        for (response, expected) in cases {
            let base = serve(vec![response]);
            let error = format!(
                "{:#}",
                fetch("1abc", &base, folder.path(), false).unwrap_err()
            );
            assert!(error.contains(expected), "{error}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn an_entry_is_not_a_path() {
        for entry in ["../../etc", "6MD", "6MDRX", "", "a/b?", "pdb_0000/6md"] {
            assert!(
                fetch(entry, "http://127.0.0.1:1", Path::new("."), false).is_err(),
                "{entry}"
            );
        }
    }
}
