//! Point files: atoms of a PQR, spheres of an `.xyzr`, bare charges of an `.xyzq`.

use crate::text::{self, Line};
use crate::{Result, pqr};
use protomer_kernel::Vec3;

/// One atom, sphere or point charge. Fields that a format does not have are zero or empty.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointRecord {
    /// Position, Å.
    pub position: Vec3,
    /// Charge, e.
    pub charge_e: f64,
    /// Radius, Å.
    pub radius_angstrom: f64,
    /// Atom name.
    pub atom_name: String,
    /// Residue name.
    pub residue_name: String,
    /// Chain identifier; empty for none.
    pub chain: String,
    /// Residue number.
    pub residue_number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
}

/// Reads a point file in the format that the name's extension means: `.pqr`, `.xyzr` (x y z
/// radius), anything else x y z charge. `.gz` after the extension is ignored.
///
/// # Errors
/// [`crate::IoError::Parse`] names the line.
pub fn read_points(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    let lower = name.to_ascii_lowercase();
    match lower
        .strip_suffix(".gz")
        .unwrap_or(&lower)
        .rsplit('.')
        .next()
    {
        Some("pqr") => pqr::read_pqr(name, bytes),
        Some("xyzr") => read_xyzr(name, bytes),
        _ => read_xyzq(name, bytes),
    }
}

/// Reads spheres: x y z radius on each line, in Å; up to two more columns (a flag and a name) are
/// passed over, `#` begins a comment.
///
/// ```
/// let spheres = protomer_io::points::read_xyzr("two.xyzr", b"0 0 0 1.5\n0 0 3 1.2 # oxygen\n")?;
/// assert_eq!(spheres[1].radius_angstrom, 1.2);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`crate::IoError::Parse`] names the line.
pub fn read_xyzr(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    read_lines(name, bytes, |line| {
        let mut tokens = line.text.split_whitespace();
        let position = line.point(&mut tokens, "a sphere")?;
        let radius_angstrom = radius(line, tokens.next())?;
        match tokens.nth(2) {
            None => Ok(PointRecord {
                position,
                radius_angstrom,
                ..PointRecord::default()
            }),
            Some(_) => Err(line.error(
                "there are more than six columns",
                "write x y z radius, perhaps a flag and a name",
            )),
        }
    })
}

/// Reads point charges: x y z charge, and perhaps a radius, on each line; `#` begins a comment.
///
/// # Errors
/// [`crate::IoError::Parse`] names the line.
pub fn read_xyzq(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    read_lines(name, bytes, |line| {
        let mut tokens = line.text.split_whitespace();
        let position = line.point(&mut tokens, "a charge")?;
        let charge_e = line.number(tokens.next(), "the charge")?;
        let radius_angstrom = tokens
            .next()
            .map_or(Ok(0.0), |token| radius(line, Some(token)))?;
        match tokens.next() {
            None => Ok(PointRecord {
                position,
                charge_e,
                radius_angstrom,
                ..PointRecord::default()
            }),
            Some(_) => Err(line.error(
                "there are more than five columns",
                "write x y z charge and perhaps a radius",
            )),
        }
    })
}

pub(crate) fn radius(line: &Line, token: Option<&str>) -> Result<f64> {
    match line.number(token, "the radius")? {
        negative if negative < 0.0 => Err(line.error(
            format!("the radius is {negative}"),
            "a radius is not negative",
        )),
        radius => Ok(radius),
    }
}

fn read_lines(
    name: &str,
    bytes: &[u8],
    record: impl Fn(&Line) -> Result<PointRecord>,
) -> Result<Vec<PointRecord>> {
    let text = text::decode(name, bytes)?;
    let records = Line::significant(name, &text)
        .map(|line| record(&line))
        .collect::<Result<Vec<_>>>()?;
    if records.is_empty() {
        return Err(crate::IoError::parse(
            name,
            0,
            "the file holds no points",
            "write one point per line",
        ));
    }
    Ok(records)
}
