//! The files of a titration, with the record of their kind.

use super::answer::{FILE, TitrationReport};
use anyhow::{Context, Result};
use protomer_common::output_file::{refuse_to_overwrite, write_folder};
use protomer_io::atomic::sha256_hex;
use protomer_results::{Exit, Record, ResultKind, Work};
use std::path::Path;

/// Table of the groups.
pub(super) const GROUPS: &str = "titration.csv";
/// Table of the curve.
pub(super) const CURVE: &str = "curve.csv";
/// Figure of the curve.
pub(super) const PICTURE: &str = "titration.svg";
/// The same figure as pixels.
const PIXELS: &str = "titration.png";

/// Refuses a folder into which the files could not be written, before anything is computed.
///
/// # Errors
/// If the folder holds other results, or one of the files exists and `force` is not set.
pub(super) fn require_free(folder: &Path, force: bool) -> Result<()> {
    ResultKind::Titration.refuse_other(folder)?;
    for name in [GROUPS, CURVE, FILE, PICTURE, PIXELS] {
        refuse_to_overwrite(&folder.join(name), force)?;
    }
    Ok(())
}

/// Writes tables, JSON, figure and record.
///
/// # Errors
/// If a file exists with other content and `force` is not set, or cannot be written.
pub(super) fn write(
    report: &TitrationReport,
    folder: &Path,
    input_sha256: &str,
    force: bool,
) -> Result<()> {
    let figure = report.drawn();
    let json = serde_json::to_string_pretty(report).context("the answer cannot be serialised")?;
    let (groups, curve) = (report.table()?, report.curve_table()?);
    // A titration is never continued, so the hash of its tables is its identity.
    let identity = sha256_hex(format!("{groups}{curve}").as_bytes());
    let files = [
        (GROUPS, groups.into_bytes()),
        (CURVE, curve.into_bytes()),
        (FILE, (json + "\n").into_bytes()),
        (PICTURE, figure.to_svg()?.into_bytes()),
        (PIXELS, figure.to_png()?),
    ];
    write_folder(folder, &files, force)?;
    let work = Work {
        kind: ResultKind::Titration,
        verb: "titrate",
        identity,
        input_sha256: input_sha256.into(),
    };
    Ok(Record::new(&work, Exit::Done).write(folder)?)
}
