//! Nodes and cell of a network, and strains of them.

use super::model::Framework;
use nalgebra::{Matrix3, Vector3};

/// Nodes and cell: where a network is in the course of a minimisation. Coordinates are (x, y, z) or
/// (y, z), Å.
///
/// ```
/// use protomer_linkage::framework::build::face_centred_cubic;
/// use protomer_linkage::framework::energy::{Configuration, NetworkEnergy};
/// let net = face_centred_cubic(3.0, 7.0)?;
/// let energy = NetworkEnergy::new(&net)?;
/// let mut state = Configuration::built(&net);
/// assert_eq!(energy.energy(&state), 0.0);
/// state.strain(3, &[0.01, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// // ½ C11 ε² V with C11 = 2 ks/a.
/// assert!((energy.energy(&state) / (0.5 * 14.0 / 3.0 * 1e-4 * 27.0) - 1.0).abs() < 0.02);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// Coordinates node after node.
    pub nodes_angstrom: Vec<f64>,
    /// Cell vectors, rows.
    pub cell_angstrom: [[f64; 3]; 3],
}

impl Configuration {
    /// A network as it is built.
    pub fn built(framework: &Framework) -> Self {
        let mut cell = [[0.0; 3]; 3];
        for (row, vector) in cell.iter_mut().zip(&framework.cell_angstrom) {
            row[..vector.len()].copy_from_slice(vector);
        }
        Self {
            nodes_angstrom: framework.nodes_angstrom.concat(),
            cell_angstrom: cell,
        }
    }

    /// Applies the homogeneous deformation 1 + ε.
    pub fn strain(&mut self, dimension: usize, strains: &[f64]) {
        let tensor = strain_tensor(dimension, strains);
        for node in self.nodes_angstrom.chunks_exact_mut(dimension) {
            deform(node, dimension, &tensor);
        }
        for vector in &mut self.cell_angstrom {
            deform(vector, dimension, &tensor);
        }
    }

    /// Configuration without the rotation from `start` to here, so that axes keep their meaning:
    /// with F = R U the deformation of the cell, everything is turned by R⁻¹. Strains that follow
    /// each other add up to rotations, which cost nothing.
    #[must_use]
    pub fn without_rotation(&self, start: &Self) -> Self {
        let Some(back) = self.rotation_back_to(start) else {
            return self.clone();
        };
        let dimension = start.dimension();
        let mut rotated = self.clone();
        for node in rotated.nodes_angstrom.chunks_exact_mut(dimension) {
            turn(node, &back);
        }
        for vector in rotated.cell_angstrom.iter_mut().take(dimension) {
            turn(&mut vector[..dimension], &back);
        }
        rotated
    }

    /// R⁻¹ of F = R U.
    fn rotation_back_to(&self, start: &Self) -> Option<Matrix3<f64>> {
        let inverse = columns(&start.cell_angstrom).try_inverse()?;
        // Polar decomposition by singular values: R = U Vᵀ.
        let svd = (columns(&self.cell_angstrom) * inverse).svd(true, true);
        Some((svd.u? * svd.v_t?).transpose())
    }

    fn dimension(&self) -> usize {
        if self.cell_angstrom[2] == [0.0; 3] {
            2
        } else {
            3
        }
    }

    /// The places of all node coordinates, for an order of elimination.
    pub(super) fn places(&self, dimension: usize) -> Vec<[f64; 3]> {
        let mut places = Vec::with_capacity(self.nodes_angstrom.len());
        for node in self.nodes_angstrom.chunks_exact(dimension) {
            let mut place = [0.0; 3];
            place[..dimension].copy_from_slice(node);
            // All coordinates of a node are at one place for the order of elimination.
            places.extend(std::iter::repeat_n(place, dimension));
        }
        places
    }

    /// The network with its nodes and cell here.
    pub fn place(&self, framework: &Framework) -> Framework {
        let dimension = framework.dimension();
        let nodes = self.nodes_angstrom.chunks_exact(dimension);
        let cell = self.cell_angstrom[..dimension].iter();
        Framework {
            nodes_angstrom: nodes.map(<[f64]>::to_vec).collect(),
            cell_angstrom: cell.map(|v| v[..dimension].to_vec()).collect(),
            ..framework.clone()
        }
    }
}

/// Cell vectors as columns; a plane gets the axis that it leaves out.
fn columns(cell: &[[f64; 3]; 3]) -> Matrix3<f64> {
    let mut matrix = Matrix3::from_fn(|i, j| cell[j][i]);
    if matrix.column(2).iter().all(|x| *x == 0.0) {
        matrix[(2, 2)] = 1.0;
    }
    matrix
}

fn turn(vector: &mut [f64], rotation: &Matrix3<f64>) {
    let mut padded = Vector3::zeros();
    padded.as_mut_slice()[..vector.len()].copy_from_slice(vector);
    let rotated = rotation * padded;
    vector.copy_from_slice(&rotated.as_slice()[..vector.len()]);
}

/// (1 + ε) applied to a vector.
fn deform(vector: &mut [f64], dimension: usize, tensor: &[[f64; 3]; 3]) {
    let mut deformed = [0.0; 3];
    for (coordinate, (row, x)) in deformed.iter_mut().zip(tensor.iter().zip(&*vector)) {
        let mut change = 0.0;
        for (entry, component) in row.iter().zip(&vector[..dimension]) {
            change += entry * component;
        }
        *coordinate = x + change;
    }
    vector[..dimension].copy_from_slice(&deformed[..dimension]);
}

/// ε as a matrix from its components in the order of the [module](super).
pub(super) fn strain_tensor(dimension: usize, strains: &[f64]) -> [[f64; 3]; 3] {
    let mut tensor = [[0.0; 3]; 3];
    for (index, strain) in strains.iter().enumerate() {
        let (i, j) = strain_axes(dimension, index);
        if i == j {
            tensor[i][i] += strain;
        } else {
            // Engineering shear counts both places: half in each.
            tensor[i][j] += 0.5 * strain;
            tensor[j][i] += 0.5 * strain;
        }
    }
    tensor
}

/// The two axes of a strain component.
pub(super) fn strain_axes(dimension: usize, index: usize) -> (usize, usize) {
    match (dimension, index) {
        (2, 2) => (0, 1),
        (_, 3) => (1, 2),
        (_, 4) => (0, 2),
        (_, 5) => (0, 1),
        (_, axis) => (axis, axis),
    }
}

/// B_a D: the change of a vector under unit strain a.
pub(super) fn strained(dimension: usize, index: usize, d: &[f64; 3]) -> [f64; 3] {
    let mut vector = [0.0; 3];
    match strain_axes(dimension, index) {
        (i, j) if i == j => vector[i] = d[i],
        (i, j) => (vector[i], vector[j]) = (0.5 * d[j], 0.5 * d[i]),
    }
    vector
}
