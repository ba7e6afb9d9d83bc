//! The rigid motion that best maps one point set onto another.

use crate::{BodyError, Result};
use nalgebra::Matrix3;
use protomer_kernel::{Pose, Rotation, Vec3};

/// The best rigid motion and the distance that remains.
///
/// ```
/// use protomer_body::assembly::superpose;
/// use protomer_kernel::Vec3;
/// let segment = |length: f64| [Vec3::zeros(), length * Vec3::x()];
/// let best = superpose(&segment(2.0), &segment(4.0))?;
/// assert!((best.rmsd_angstrom - 1.0).abs() < 1e-12, "each end is 1 Å off");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Superposition {
    /// Maps the moving points onto the fixed ones.
    pub pose: Pose,
    /// Root mean square distance after the motion, Å.
    pub rmsd_angstrom: f64,
}

/// Minimises Σ |R mᵢ + t - fᵢ|² over proper rotations R and translations t (Kabsch, Acta Cryst.
/// A32, 922 (1976) and A34, 827 (1978)): with both sets centred and Σ mᵢ fᵢᵀ = U S Vᵀ, R = V
/// diag(1, 1, det(V Uᵀ)) Uᵀ, the sign on the smallest singular value. For points on a line any
/// rotation about the line is equally good; one of them is returned.
///
/// ```
/// use protomer_body::assembly::superpose;
/// use protomer_kernel::{Pose, Vec3};
/// let points = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
/// let pose = Pose::from_wxyz(Vec3::new(3.0, 1.0, -2.0), [0.5, 0.5, 0.5, 0.5]);
/// let moved = points.map(|point| pose.transform_point(&point));
/// let best = superpose(&points, &moved)?;
/// assert!(best.rmsd_angstrom < 1e-12 && (best.pose.position - pose.position).norm() < 1e-12);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] for sets of different size, empty sets and coordinates that are not
/// finite.
pub fn superpose(moving: &[Vec3], fixed: &[Vec3]) -> Result<Superposition> {
    let unmatched = || BodyError::Invalid {
        cause: format!(
            "{} points cannot be superposed on {}",
            moving.len(),
            fixed.len()
        ),
        remedy: "match finite positions one to one".into(),
    };
    let is_matched = !moving.is_empty() && moving.len() == fixed.len();
    if !is_matched || !is_finite(moving) || !is_finite(fixed) {
        return Err(unmatched());
    }
    let (from, to) = (mean(moving), mean(fixed));
    let mut covariance = Matrix3::zeros();
    for (m, f) in moving.iter().zip(fixed) {
        covariance += (m - from) * (f - to).transpose();
    }
    if !covariance.iter().all(|x| x.is_finite()) {
        return Err(unmatched());
    }
    let rotation = best_rotation(&covariance);
    let pose = Pose {
        position: to - rotation * from,
        rotation,
    };
    let mut squares = 0.0;
    for (m, f) in moving.iter().zip(fixed) {
        squares += (pose.transform_point(m) - f).norm_squared();
    }
    Ok(Superposition {
        pose,
        rmsd_angstrom: (squares / moving.len() as f64).sqrt(),
    })
}

fn is_finite(points: &[Vec3]) -> bool {
    points.iter().flatten().all(|x| x.is_finite())
}

fn best_rotation(covariance: &Matrix3<f64>) -> Rotation {
    let svd = covariance.svd(true, true);
    let (Some(u), Some(v_transposed)) = (svd.u, svd.v_t) else {
        return Rotation::identity();
    };
    let mut v = v_transposed.transpose();
    if (v * u.transpose()).determinant() < 0.0 {
        let smallest = svd.singular_values.imin();
        v.column_mut(smallest).neg_mut();
    }
    let matrix = v * u.transpose();
    Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(matrix))
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        [-20.0..20.0, -20.0..20.0, -20.0..20.0_f64].prop_map(|[x, y, z]| Vec3::new(x, y, z))
    }

    fn quaternion() -> impl Strategy<Value = [f64; 4]> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0_f64].prop_filter("not zero", |q: &[f64; 4]| {
            q.iter().map(|x| x * x).sum::<f64>() > 0.01
        })
    }

    proptest! {
        #[test]
        fn a_motion_is_found_again(points in prop::collection::vec(vector(), 4..30), at in vector(), q in quaternion()) {
            let pose = Pose::from_wxyz(at, q);
            let moved: Vec<Vec3> = points.iter().map(|point| pose.transform_point(point)).collect();
            prop_assert!(superpose(&points, &moved).unwrap().rmsd_angstrom < 1e-9);
        }

        /// The twin: no small rotation about the optimum does better, and a mirror image never
        /// becomes the original.
        #[test]
        fn nothing_near_is_better(points in prop::collection::vec(vector(), 4..30), noise in prop::collection::vec(vector(), 30), axis in vector()) {
            let mirrored: Vec<Vec3> = points.iter().zip(&noise).map(|(p, n)| Vec3::new(-p.x, p.y, p.z) + n * 0.01).collect();
            let best = superpose(&points, &mirrored).unwrap();
            let sum = |pose: &Pose| points.iter().zip(&mirrored).map(|(p, f)| (pose.transform_point(p) - f).norm_squared()).sum::<f64>();
            let centre = mean(&mirrored);
            for angle in [-0.3, -1e-3, 1e-3, 0.3] {
                let turn = Rotation::new(axis.normalize() * angle);
                let about = Pose { position: centre - turn * centre, rotation: turn };
                prop_assert!(sum(&best.pose.then(&about)) >= sum(&best.pose) * (1.0 - 1e-12));
            }
            let matrix = best.pose.rotation.to_rotation_matrix();
            prop_assert!((matrix.matrix().determinant() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn unmatched_sets_are_refused() {
        assert!(superpose(&[], &[]).is_err());
        assert!(superpose(&[Vec3::zeros()], &[]).is_err());
        assert!(superpose(&[Vec3::repeat(f64::NAN)], &[Vec3::zeros()]).is_err());
        let one = superpose(&[Vec3::zeros()], &[Vec3::repeat(2.0)]).unwrap();
        assert!((one.pose.position - Vec3::repeat(2.0)).norm() < 1e-12);
    }
}
