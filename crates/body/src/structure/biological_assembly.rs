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
    /// What the file says about it, for example `HEXAMERIC`.
    pub details: String,
    /// Chains with the operators applied to them.
    pub parts: Vec<AssemblyPart>,
}

/// Some chains and the operators that copy them.
#[derive(Debug, Clone, PartialEq)]
pub struct AssemblyPart {
    /// Chains, by [`super::contents::Atom::label_chain`].
    pub chains: Vec<Arc<str>>,
    /// Motions; each gives one copy of the chains.
    pub operators: Vec<Operator>,
}

/// A motion x' = R x + t as a file writes it, with rounded digits and not yet known to be proper.
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
        let defect = (self.rotation * self.rotation.transpose() - Matrix3::identity())
            .abs()
            .max();
        let determinant = self.rotation.determinant();
        let is_near = self.translation.iter().all(|t| t.abs() < LARGEST_ANGSTROM);
        if !(defect < ROUNDING && (determinant - 1.0).abs() < ROUNDING && is_near) {
            return Err(BodyError::Invalid {
                cause: format!(
                    "operator {} is not a rigid motion without a mirror (determinant {determinant:.4})",
                    self.name
                ),
                remedy: "choose another assembly or correct the operator in the file".into(),
            });
        }
        Ok(Pose {
            position: self.translation,
            rotation: nearest_rotation(&self.rotation),
        })
    }

    /// First `first`, then `self`.
    fn after(&self, first: &Operator) -> Operator {
        Operator {
            name: format!("{}-{}", self.name, first.name),
            rotation: self.rotation * first.rotation,
            translation: self.rotation * first.translation + self.translation,
        }
    }
}

/// The rotation nearest to a matrix that is one but for its rounded digits: the orthogonal factor U
/// Vᵀ of its polar decomposition.
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
        let mut factor_operators = Vec::new();
        for name in names(&factor)? {
            factor_operators.push(
                operators
                    .get(&name)
                    .ok_or_else(|| format!("operator {name} is not listed"))?
                    .clone(),
            );
        }
        product = Some(match product {
            None => factor_operators,
            Some(left) => {
                if left.len().saturating_mul(factor_operators.len()) > MOST_OPERATORS {
                    return Err(format!("more than {MOST_OPERATORS} operators"));
                }
                left.iter()
                    .flat_map(|outer| factor_operators.iter().map(|inner| outer.after(inner)))
                    .collect()
            }
        });
    }
    product
        .filter(|operators| !operators.is_empty())
        .ok_or_else(|| "no operator".to_string())
}

/// Operators a file may have; the largest viral assemblies have a few thousand.
pub(crate) const MOST_OPERATORS: usize = 100_000;

/// The parenthesised factors of an expression; one without parentheses is its own factor.
fn factors(expression: &str) -> std::result::Result<Vec<String>, String> {
    let compact: String = expression.chars().filter(|c| !c.is_whitespace()).collect();
    if !compact.contains(['(', ')']) {
        return Ok(vec![compact]);
    }
    let unbalanced = || "parentheses do not match".to_string();
    let inner = compact
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')'))
        .ok_or_else(unbalanced)?;
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
    for item in list.split(',').filter(|item| !item.is_empty()) {
        let range = item
            .split_once('-')
            .and_then(|(a, b)| Some((a.parse::<usize>().ok()?, b.parse::<usize>().ok()?)));
        match range {
            Some((first, last)) if last.saturating_sub(first) < MOST_OPERATORS => {
                names.extend((first..=last).map(|number| number.to_string()));
            }
            Some(_) => return Err(format!("more than {MOST_OPERATORS} operators")),
            None => names.push(item.to_string()),
        }
        if names.len() > MOST_OPERATORS {
            return Err(format!("more than {MOST_OPERATORS} operators"));
        }
    }
    Ok(names)
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
