//! The atoms of a PQR file: which of its points are atoms, and whether they are in Å.
//!
//! The same oddities as in structure files ([`crate::structure`]): atoms without a position, the same
//! atom twice, nanometres. Bare spheres and charges, which have no residue, are taken as they are.

use crate::Result;
use crate::structure::records::{ExactPosition, exact, is_placeholder};
use crate::structure::scale::refuse_unit;
use protomer_kernel::{PointRecord, Vec3};
use std::collections::HashMap;

/// The points that are atoms, and warnings about the others.
pub(crate) struct SiftedPoints {
    pub(crate) points: Vec<PointRecord>,
    pub(crate) warnings: Vec<String>,
}

/// Leaves out atoms without a position and repeated ones.
///
/// # Errors
/// [`crate::BodyError::Parse`] for coordinates in another unit than Å.
pub(crate) fn sift_points(file: &str, points: &[PointRecord]) -> Result<SiftedPoints> {
    refuse_other_unit(file, points)?;
    let mut first_at: HashMap<ExactPosition, &PointRecord> = HashMap::with_capacity(points.len());
    let (mut unbuilt, mut repeated, mut coincident) = (0, 0, 0);
    let mut records = Vec::with_capacity(points.len());
    for point in points {
        let is_atom = !point.residue_name.is_empty();
        if is_atom && is_placeholder(&point.position) {
            unbuilt += 1;
            continue;
        }
        let first = first_at.entry(exact(&point.position)).or_insert(point);
        if is_atom && !std::ptr::eq(*first, point) {
            if *first == point {
                repeated += 1;
                continue;
            }
            coincident += 1;
        }
        records.push(point.clone());
    }
    let mut warnings = Vec::new();
    for (count, what) in [
        (unbuilt, "atoms without a position (999 or 9999) left out"),
        (repeated, "repeated atoms left out"),
        (
            coincident,
            "atoms are exactly where another one is: they are kept, check the file",
        ),
    ] {
        if count > 0 {
            warnings.push(format!("{count} {what}"));
        }
    }
    Ok(SiftedPoints {
        points: records,
        warnings,
    })
}

/// Refuses points whose bonds N-CA have the length of another unit.
fn refuse_other_unit(file: &str, points: &[PointRecord]) -> Result<()> {
    /// Least number of bonds for a verdict: fewer may be bad ones.
    const FEWEST: usize = 4;
    let mut nitrogen: Option<&PointRecord> = None;
    let mut lengths = Vec::new();
    for point in points {
        match (point.atom_name.as_str(), nitrogen) {
            ("N", _) => nitrogen = Some(point),
            ("CA", Some(nitrogen)) if nitrogen.residue_number == point.residue_number => {
                let bond: Vec3 = nitrogen.position - point.position;
                lengths.push(bond.norm());
            }
            _ => {}
        }
    }
    match lengths.len() {
        0..FEWEST => Ok(()),
        _ => refuse_unit(file, &mut lengths),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn residues(scale: f64) -> Vec<PointRecord> {
        let mut points = Vec::new();
        for number in 0..5 {
            for (name, x) in [("N", 0.0), ("CA", 1.46)] {
                points.push(PointRecord {
                    position: Vec3::new(scale * (x + 3.8 * f64::from(number)), 0.0, 0.0),
                    charge_e: 0.25,
                    radius_angstrom: 1.7,
                    atom_name: name.into(),
                    residue_name: "GLY".into(),
                    residue_number: number,
                    ..PointRecord::default()
                });
            }
        }
        points
    }

    #[test]
    fn the_same_atoms_twice_count_once() {
        let once = residues(1.0);
        let sifted = sift_points("x.pqr", &[once.clone(), once.clone()].concat()).unwrap();
        assert_eq!(sifted.points, once);
        assert_eq!(sifted.warnings, ["10 repeated atoms left out"]);
        assert!(sift_points("x.pqr", &once).unwrap().warnings.is_empty());
    }

    #[test]
    fn atoms_without_a_position_are_left_out() {
        let mut points = residues(1.0);
        points[3].position = Vec3::repeat(9999.0);
        let sifted = sift_points("x.pqr", &points).unwrap();
        assert_eq!((sifted.points.len(), sifted.warnings.len()), (9, 1));
    }

    #[test]
    fn charges_on_one_point_are_no_atoms() {
        let charges = vec![PointRecord::default(); 3];
        let sifted = sift_points("x.xyzq", &charges).unwrap();
        assert_eq!((sifted.points.len(), sifted.warnings.len()), (3, 0));
    }

    #[test]
    fn nanometres_are_refused() {
        let error = sift_points("x.pqr", &residues(0.1))
            .err()
            .unwrap()
            .to_string();
        assert!(
            error.contains("x.pqr") && error.contains("nm") && error.contains("by 10"),
            "{error}"
        );
    }
}
