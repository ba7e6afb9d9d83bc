//! Points that fill a solid.

use nalgebra::{Matrix3, SymmetricEigen};
use protomer_kernel::mesh::MassProperties;
use protomer_kernel::overlap::CollisionShape;
use protomer_kernel::{KernelError, TriangleMesh, Vec3};

/// Points in a solid, about.
const POINTS: f64 = 4000.0;
/// Places of the grid that are tried at most: a ring or a shell leaves most of its box empty.
const MOST_PLACES: f64 = 2e6;
/// Places along each axis at least: one layer has no extent.
const FEWEST_LAYERS: f64 = 2.0;
/// Variances of the points below this share of the largest: they lie in a plane.
const FLAT: f64 = 1e-12;

/// Points of equal weight with the centre and the second moments of the solid inside a mesh, Å, so
/// that their radius of gyration is exact.
///
/// They are the places of a grid along the principal axes, whose steps divide the bounding box. The
/// grid alone would be off by about the square of a step over that of the body. The linear map that
/// takes its covariance C to that of the solid, T, with the least change is
/// C^(-1/2) (C^(1/2) T C^(1/2))^(1/2) C^(-1/2) (Olkin and Pukelsheim, Linear Algebra Appl. 48, 257 (1982)).
///
/// # Errors
/// [`KernelError::BadMesh`] if the mesh bounds no solid, and for one so thin that no grid fills it.
pub(super) fn fill(
    mesh: &TriangleMesh,
    properties: &MassProperties,
) -> Result<Vec<Vec3>, KernelError> {
    let mut points = grid_inside(mesh, properties)?;
    let count = points.len().max(1) as f64;
    let centre = points.iter().sum::<Vec3>() / count;
    let mut covariance = Matrix3::zeros();
    for point in &points {
        covariance += (point - centre) * (point - centre).transpose() / count;
    }
    let Some(map) = least_map(&covariance, &solid_covariance(properties)) else {
        return Err(KernelError::BadMesh(
            "it is too thin to be filled with points that scatter; thicken it".into(),
        ));
    };
    for point in &mut points {
        *point = properties.centroid + map * (*point - centre);
    }
    Ok(points)
}

/// The mean of xxᵀ about the centre, Å²: the inertia tensor is its trace less it, times the volume.
fn solid_covariance(properties: &MassProperties) -> Matrix3<f64> {
    let inertia = properties.inertia_angstrom5 / properties.volume_angstrom3;
    Matrix3::identity() * (0.5 * inertia.trace()) - inertia
}

/// The places of a grid along the principal axes that lie inside, Å.
fn grid_inside(mesh: &TriangleMesh, properties: &MassProperties) -> Result<Vec<Vec3>, KernelError> {
    let shape = CollisionShape::new(mesh)?;
    let axes = SymmetricEigen::new(properties.inertia_angstrom5).eigenvectors;
    let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for vertex in &mesh.vertices {
        let projections = axes.tr_mul(vertex);
        (low, high) = (low.inf(&projections), high.sup(&projections));
    }
    let lengths = high - low;
    let volume = (properties.volume_angstrom3 / POINTS).max(lengths.product() / MOST_PLACES);
    let counts = lengths.map(|length| (length / volume.cbrt()).ceil().max(FEWEST_LAYERS));
    let steps = lengths.component_div(&counts);
    let counts = counts.map(|count| count as usize);
    let mut inside = Vec::new();
    for x in 0..counts.x {
        for y in 0..counts.y {
            for z in 0..counts.z {
                // Half steps from the faces of the box: no place on a plane of a box-like body.
                let place = Vec3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5);
                let point = axes * (low + place.component_mul(&steps));
                if shape.contains_point(&point) {
                    inside.push(point);
                }
            }
        }
    }
    Ok(inside)
}

/// The symmetric map M with M C Mᵀ = T; `None` if C has no extent along some axis.
fn least_map(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let (root, inverse) = (power(from, 0.5)?, power(from, -0.5)?);
    Some(inverse * power(&(root * to * root), 0.5)? * inverse)
}

/// A power of a positive definite matrix.
fn power(matrix: &Matrix3<f64>, exponent: f64) -> Option<Matrix3<f64>> {
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = SymmetricEigen::new(*matrix);
    let is_definite = eigenvalues.min() > FLAT * eigenvalues.max();
    let powers = Matrix3::from_diagonal(&eigenvalues.map(|value| value.powf(exponent)));
    is_definite.then(|| eigenvectors * powers * eigenvectors.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_of_points_is_not_stretched_into_a_solid() {
        let layer = Matrix3::from_diagonal(&Vec3::new(1.0, 2.0, 0.0));
        assert!(least_map(&layer, &Matrix3::identity()).is_none());
    }

    #[test]
    fn the_map_takes_one_covariance_to_the_other() {
        let from = Matrix3::new(2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 3.0);
        let to = Matrix3::new(1.5, -0.1, 0.2, -0.1, 1.2, 0.3, 0.2, 0.3, 2.0);
        let map = least_map(&from, &to).unwrap();
        assert!((map * from * map.transpose() - to).norm() < 1e-12);
        assert!((map - map.transpose()).norm() < 1e-12);
    }
}
