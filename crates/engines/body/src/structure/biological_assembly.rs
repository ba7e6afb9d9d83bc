//! Biological assemblies: which chains, copied by which rigid motions.

use crate::{BodyError, Result};
use nalgebra::{Matrix3, Rotation3};
use protomer_kernel::{Pose, Rotation, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// An assembly as the file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct BiologicalAssembly {
    /// Identifier in the file.
    pub id: String,
    /// Details that the file states about the assembly, for example `HEXAMERIC`.
    pub details: String,
    /// Chains with the operators applied to them.
    pub parts: Vec<AssemblyPart>,
}

/// Some chains and the operators that copy them.
#[derive(Debug, Clone, PartialEq)]
pub struct AssemblyPart {
    /// Chains, by [`super::contents::Atom::label_chain`]; empty for all.
    pub chains: Vec<Arc<str>>,
    /// Motions; each gives one copy of the chains.
    pub operators: Vec<Operator>,
}

/// A motion x' = R x + t as a file writes it: rounded, and not yet checked to be proper.
///
/// ```
/// use nalgebra::Matrix3;
/// use protomer_body::structure::Operator;
/// use protomer_kernel::Vec3;
/// let half_turn = Operator {
///     name: "2".into(),
///     rotation: Matrix3::from_diagonal(&Vec3::new(-1.0, -1.0, 1.0)),
///     translation: Vec3::new(10.0, 0.0, 0.0),
/// };
/// let image = half_turn.pose()?.transform_point(&Vec3::new(1.0, 2.0, 3.0));
/// assert!((image - Vec3::new(9.0, -2.0, 3.0)).norm() < 1e-12);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    /// Identifier in the file; a product of two is written `a-b`.
    pub name: String,
    /// The matrix R.
    pub rotation: Matrix3<f64>,
    /// The vector t, Å.
    pub translation: Vec3,
}

impl Operator {
    /// The motion as a pose.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] unless R is a proper rotation to the digits of a file: R Rᵀ = 1 and
    /// det R = 1 to 1e-3. A mirror operation would turn a protein into its enantiomer.
    pub fn pose(&self) -> Result<Pose> {
        const ROUNDING: f64 = 1e-3;
        const LARGEST_ANGSTROM: f64 = 1e6;
        let product = self.rotation * self.rotation.transpose();
        let defect = (product - Matrix3::identity()).abs().max();
        let determinant = self.rotation.determinant();
        let is_rotation = defect < ROUNDING && (determinant - 1.0).abs() < ROUNDING;
        let is_near = self.translation.iter().all(|t| t.abs() < LARGEST_ANGSTROM);
        if !(is_rotation && is_near) {
            let name = &self.name;
            return Err(BodyError::Invalid {
                cause: format!(
                    "operator {name} is not a rigid motion without a mirror (determinant \
                     {determinant:.4})"
                ),
                remedy: "choose another assembly or correct the operator in the file".into(),
            });
        }
        Ok(Pose {
            position: self.translation,
            rotation: nearest_rotation(&self.rotation),
        })
    }

    /// Product of two operators: first `first`, then `self`.
    fn after(&self, first: &Operator) -> Operator {
        Operator {
            name: format!("{}-{}", self.name, first.name),
            rotation: self.rotation * first.rotation,
            translation: self.rotation * first.translation + self.translation,
        }
    }
}

/// The rotation nearest to a rounded rotation matrix: the orthogonal factor U Vᵀ of its polar
/// decomposition.
fn nearest_rotation(matrix: &Matrix3<f64>) -> Rotation {
    let svd = matrix.svd(true, true);
    let orthogonal = match (svd.u, svd.v_t) {
        (Some(u), Some(v_transposed)) => u * v_transposed,
        _ => *matrix,
    };
    Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(orthogonal))
}

/// Evaluates an operator expression such as `1,2`, `(1-60)`, `P` or `(X0)(1,2,5-8)`; of a product
/// the right factor acts first.
///
/// # Errors
/// A message that names the unknown operator, the unbalanced parenthesis, or an expression with too
/// many operators.
pub(crate) fn evaluate(
    expression: &str,
    operators: &HashMap<String, Operator>,
) -> std::result::Result<Vec<Operator>, String> {
    let mut product: Option<Vec<Operator>> = None;
    for factor in factors(expression)? {
        let mut right = Vec::new();
        for name in names(&factor)? {
            match operators.get(&name) {
                Some(operator) => right.push(operator.clone()),
                None => return Err(format!("operator {name} is not listed")),
            }
        }
        product = Some(match product {
            None => right,
            Some(left) => multiplied(&left, &right)?,
        });
    }
    match product {
        Some(operators) if !operators.is_empty() => Ok(operators),
        _ => Err("no operator".to_string()),
    }
}

/// Limit on the operators of a file; the largest viral assemblies have a few thousand.
pub(crate) const MOST_OPERATORS: usize = 100_000;

fn too_many() -> String {
    format!("more than {MOST_OPERATORS} operators")
}

/// Every operator of the left factor after every one of the right.
fn multiplied(left: &[Operator], right: &[Operator]) -> std::result::Result<Vec<Operator>, String> {
    if left.len().saturating_mul(right.len()) > MOST_OPERATORS {
        return Err(too_many());
    }
    let mut product = Vec::with_capacity(left.len() * right.len());
    for outer in left {
        for inner in right {
            product.push(outer.after(inner));
        }
    }
    Ok(product)
}

/// The parenthesised factors of an expression; an expression without parentheses is one factor.
fn factors(expression: &str) -> std::result::Result<Vec<String>, String> {
    let compact: String = expression.split_whitespace().collect();
    if !compact.contains(['(', ')']) {
        return Ok(vec![compact]);
    }
    let unbalanced = || "parentheses do not match".to_string();
    let inner = compact.strip_prefix('(').ok_or_else(unbalanced)?;
    let inner = inner.strip_suffix(')').ok_or_else(unbalanced)?;
    let factors: Vec<String> = inner.split(")(").map(str::to_string).collect();
    if factors.iter().any(|factor| factor.contains(['(', ')'])) {
        Err(unbalanced())
    } else {
        Ok(factors)
    }
}

/// The names in a list such as `1,2,5-8`.
fn names(list: &str) -> std::result::Result<Vec<String>, String> {
    let mut names = Vec::new();
    for item in list.split(',') {
        match range(item) {
            Some((first, last)) if last.saturating_sub(first) < MOST_OPERATORS => {
                names.extend((first..=last).map(|number| number.to_string()));
            }
            Some(_) => return Err(too_many()),
            None if item.is_empty() => {}
            None => names.push(item.to_string()),
        }
        if names.len() > MOST_OPERATORS {
            return Err(too_many());
        }
    }
    Ok(names)
}

/// First and last number of a range such as `5-8`.
fn range(item: &str) -> Option<(usize, usize)> {
    let (first, last) = item.split_once('-')?;
    Some((first.parse().ok()?, last.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shifts(names: &[&str]) -> HashMap<String, Operator> {
        let operator = |(i, name): (usize, &&str)| {
            let translation = Vec3::new(i as f64, 0.0, 0.0);
            (
                name.to_string(),
                Operator {
                    name: name.to_string(),
                    rotation: Matrix3::identity(),
                    translation,
                },
            )
        };
        names.iter().enumerate().map(operator).collect()
    }

    #[test]
    fn expressions_are_evaluated() {
        let operators = shifts(&["X0", "1", "2", "3", "4", "5", "6", "7", "8", "P"]);
        let count = |expression| evaluate(expression, &operators).map(|list| list.len());
        assert_eq!(count("1,2,3,4"), Ok(4));
        assert_eq!(count("(1-8)"), Ok(8));
        assert_eq!(count("P"), Ok(1));
        assert_eq!(count("(X0)(1,2,5-8)"), Ok(6));
        assert_eq!(evaluate("(X0)(3)", &operators).unwrap()[0].name, "X0-3");
        for wrong in ["9", "(1", "1)(2", "", "()", "(1-99999999999)", "(1)((2)"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_pose_is_the_operator_to_the_digits_of_the_file() {
        let rounded = |angle: f64| (angle.to_radians().cos() * 1e6).round() / 1e6;
        for degrees in (0..=360).step_by(30).map(f64::from) {
            let (cosine, sine) = (rounded(degrees), rounded(degrees - 90.0));
            let rotation = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
            let operator = Operator {
                name: "1".into(),
                rotation,
                translation: Vec3::new(1.0, 2.0, 3.0),
            };
            let pose = operator.pose().unwrap();
            let point = Vec3::new(50.0, -20.0, 7.0);
            assert!(
                (pose.transform_point(&point) - (rotation * point + operator.translation)).norm()
                    < 1e-4,
                "{degrees}"
            );
        }
    }

    #[test]
    fn a_mirror_is_refused() {
        let rotation = Matrix3::from_diagonal(&Vec3::new(1.0, 1.0, -1.0));
        let mirror = Operator {
            name: "7".into(),
            rotation,
            translation: Vec3::zeros(),
        };
        assert!(
            mirror
                .pose()
                .unwrap_err()
                .to_string()
                .contains("operator 7")
        );
    }
}
