//! Point files: atoms of a PQR, spheres of an `.xyzr`, bare charges of an `.xyzq`.

use crate::pqr;
use crate::text::{self, Line};
use crate::{IoError, Result};
use std::str::SplitWhitespace;

pub use protomer_kernel::PointRecord;

/// Reads a point file in the format given by the extension of its name: `.pqr`, `.xyzr` (x y z
/// radius), anything else x y z charge. `.gz` after the extension is ignored.
///
/// ```
/// let charges = protomer_io::points::read_points("pair.xyzq", b"0 0 0 1\n0 0 5 -1\n")?;
/// assert_eq!(charges[1].charge_e, -1.0);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names the line.
pub fn read_points(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    let lower = name.to_ascii_lowercase();
    let plain = lower.strip_suffix(".gz").unwrap_or(&lower);
    match plain.rsplit('.').next() {
        Some("pqr") => pqr::read_pqr(name, bytes),
        Some("xyzr") => read_xyzr(name, bytes),
        _ => read_xyzq(name, bytes),
    }
}

/// Reads spheres: x y z radius on each line, in Å. Up to two more columns (a flag and a name) are
/// ignored; `#` begins a comment.
///
/// ```
/// let spheres = protomer_io::points::read_xyzr("two.xyzr", b"0 0 0 1.5\n0 0 3 1.2 # oxygen\n")?;
/// assert_eq!(spheres[1].radius_angstrom, 1.2);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names the line.
pub fn read_xyzr(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    read_lines(name, bytes, |line, tokens| {
        let record = PointRecord {
            position: line.position(tokens, "a sphere")?,
            radius_angstrom: line.radius(tokens.next())?,
            ..PointRecord::default()
        };
        // A fifth and sixth column are a flag and a name; `nth(2)` is the third further token.
        if tokens.nth(2).is_some() {
            let remedy = "write x y z radius, optionally followed by a flag and a name";
            return Err(line.error("there are more than six columns", remedy));
        }
        Ok(record)
    })
}

/// Reads point charges: x y z charge, and optionally a radius, on each line; `#` begins a comment.
///
/// ```
/// let ions = protomer_io::points::read_xyzq("ions.xyzq", b"0 0 0 2 1.7\n")?;
/// assert_eq!((ions[0].charge_e, ions[0].radius_angstrom), (2.0, 1.7));
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names the line.
pub fn read_xyzq(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    read_lines(name, bytes, |line, tokens| {
        let mut record = PointRecord {
            position: line.position(tokens, "a charge")?,
            charge_e: line.charge(tokens.next())?,
            ..PointRecord::default()
        };
        if let Some(radius) = tokens.next() {
            record.radius_angstrom = line.radius(Some(radius))?;
        }
        if tokens.next().is_some() {
            let remedy = "write x y z charge, optionally followed by a radius";
            return Err(line.error("there are more than five columns", remedy));
        }
        Ok(record)
    })
}

/// The record of each line that is neither blank nor a comment.
fn read_lines(
    name: &str,
    bytes: &[u8],
    record: impl Fn(&Line, &mut SplitWhitespace) -> Result<PointRecord>,
) -> Result<Vec<PointRecord>> {
    let text = text::decode(name, bytes)?;
    let mut records = Vec::new();
    for line in Line::significant(name, &text) {
        records.push(record(&line, &mut line.text.split_whitespace())?);
    }
    if records.is_empty() {
        let cause = "the file holds no points";
        return Err(IoError::parse(name, 0, cause, "write one point per line"));
    }
    Ok(records)
}
