//! How a structure is turned before it is laid on the grid.

use nalgebra::{Matrix3, Rotation3};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Rotation, Vec3};

protomer_kernel::choices! {
    /// Orientation of a structure on the grid.
    pub enum Orientation, default Random {
        /// A random rotation, derived from the seed and the structure's name.
        Random = "random",
        /// Principal axes along x, y, z, the longest along x.
        Principal = "principal",
        /// The orientation as deposited.
        Deposited = "deposited",
    }
}

impl Orientation {
    /// The rotation for these atoms, a seed and a key of the structure, such as the beginning of a
    /// hash of its name.
    ///
    /// ```
    /// use protomer_field::voxels::Orientation;
    /// let rotation = |key| Orientation::Random.rotation(&[], 1, key);
    /// assert_eq!(rotation(5), rotation(5));
    /// assert!(rotation(5).angle_to(&rotation(6)) > 0.0);
    /// ```
    pub fn rotation(self, positions: &[Vec3], seed: u64, key: u64) -> Rotation {
        match self {
            Orientation::Random => {
                // Both halves of the key reach the counter, the high one as the replica.
                let high = (key >> 32) as u32;
                CounterRng::for_purpose(seed, high, key, Purpose::VoxelOrientation).rotation()
            }
            Orientation::Principal => principal_axes(positions).0,
            Orientation::Deposited => Rotation::identity(),
        }
    }
}

/// The rotation that brings the principal axes of the covariance of the points to x, y and z,
/// largest variance first, and the variances, Å². Axes have no sign: x and y point so that the third
/// moment along them is not negative, and z completes a right-handed frame. Where two variances
/// nearly agree, small changes of the points turn the axes.
///
/// ```
/// use protomer_field::voxels::orientation::principal_axes;
/// use protomer_kernel::Vec3;
/// let along_y = [Vec3::new(0.0, -3.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
/// let (rotation, variances) = principal_axes(&along_y);
/// assert!((rotation * Vec3::y()).x.abs() > 1.0 - 1e-12);
/// assert!((variances[0] - 9.0).abs() < 1e-12);
/// ```
pub fn principal_axes(positions: &[Vec3]) -> (Rotation, [f64; 3]) {
    let count = positions.len().max(1) as f64;
    let middle = positions.iter().sum::<Vec3>() / count;
    let mut covariance = Matrix3::zeros();
    for position in positions {
        let offset = position - middle;
        covariance += offset * offset.transpose();
    }
    let eigen = (covariance / count).symmetric_eigen();
    let mut order = [0, 1, 2];
    // Descending variances.
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let mut axes = order.map(|axis| eigen.eigenvectors.column(axis).into_owned());
    for axis in &mut axes[..2] {
        let mut third_moment = 0.0;
        for position in positions {
            third_moment += (position - middle).dot(axis).powi(3);
        }
        if third_moment < 0.0 {
            *axis = -*axis;
        }
    }
    axes[2] = axes[0].cross(&axes[1]);
    // A rotation matrix with the axes as rows brings them to x, y and z.
    let matrix = Matrix3::from_rows(&axes.map(|axis| axis.transpose()));
    let to_axes = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    (to_axes, order.map(|axis| eigen.eigenvalues[axis].max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> Vec<Vec3> {
        let mut rng = CounterRng::new(3, 0, 0);
        (0..200)
            .map(|_| {
                let point = rng.vector_in_ball(1.0);
                Vec3::new(9.0 * point.x.abs(), 5.0 * point.y.powi(2), 2.0 * point.z)
            })
            .collect()
    }

    #[test]
    fn principal_axes_do_not_depend_on_how_the_points_came() {
        let points = cloud();
        let (rotation, variances) = principal_axes(&points);
        assert!(variances[0] > variances[1] && variances[1] > variances[2]);
        let turned: Vec<Vec3> = points.iter().map(|point| rotation * point).collect();
        let other = CounterRng::new(8, 0, 0).rotation();
        let elsewhere: Vec<Vec3> = points
            .iter()
            .map(|point| other * point + Vec3::new(5.0, -3.0, 1.0))
            .collect();
        let (again, _) = principal_axes(&elsewhere);
        let offset = again * elsewhere[0] - turned[0];
        for (one, two) in turned.iter().zip(&elsewhere) {
            assert!((again * two - one - offset).norm() < 1e-9);
        }
    }

    #[test]
    fn random_rotations_follow_seed_and_key_alone() {
        let rotation = |seed, key| Orientation::Random.rotation(&[], seed, key);
        assert_eq!(rotation(1, 2), rotation(1, 2));
        assert!(rotation(1, 2).angle_to(&rotation(1, 3)) > 1e-3);
        assert!(rotation(1, 2).angle_to(&rotation(2, 2)) > 1e-3);
        assert!(rotation(1, 2).angle_to(&rotation(1, 2 + (1 << 32))) > 1e-3);
        // Every direction is as likely as any other: the mean of where x goes is near zero.
        let mean = (0..4000)
            .map(|key| rotation(5, key) * Vec3::x())
            .sum::<Vec3>()
            / 4000.0;
        assert!(mean.norm() < 0.05, "{mean}");
    }
}
