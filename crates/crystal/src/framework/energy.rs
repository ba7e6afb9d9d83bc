//! Energy, gradient and Hessian of a network.
//!
//! Every term is a function φ of difference vectors D = x_to - x_from + image · cell. Under a
//! homogeneous strain ε and node displacements they become (1 + ε) D, so with H the Hessian of φ
//! over its vectors and B_a D the change of D under unit strain a,
//!
//! ∂E/∂ε_a = g · B_a D, ∂²E/∂ε_a∂ε_b = B_a D · H B_b D, ∂²E/∂x∂ε_a = Aᵀ (H B_a D + B_a g), ∂²E/∂x∂x
//! = Aᵀ H A,
//!
//! where A takes node displacements to differences and x are positions before the strain.

use super::jet::{Jet, cross, dot};
use super::model::{Framework, Neighbour};
use crate::{CrystalError, Result};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Rest angles nearer to straight than this (rad) use the form that is smooth there.
const NEARLY_STRAIGHT: f64 = 1e-6;

/// The energy of a network as a function of its nodes and cell; what is "as built" is fixed when it
/// is made.
#[derive(Debug, Clone)]
pub struct NetworkEnergy {
    dimension: usize,
    nodes: usize,
    terms: Vec<Term>,
    entries: Vec<(usize, usize)>,
}

#[derive(Debug, Clone)]
struct Term {
    kind: Kind,
    stiffness: f64,
    rest: f64,
    bonds: Vec<Bond>,
    /// For each pair of bond ends, row end before column end, where its block of the Hessian
    /// begins; `NONE` above the diagonal.
    blocks: Vec<u32>,
}

const NONE: u32 = u32::MAX;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Rod,
    /// The signed angle in the plane, from the first bond to the second.
    PlaneHinge,
    Hinge,
    /// A hinge at rest when straight.
    StraightHinge,
    Torsion,
}

#[derive(Debug, Clone, Copy)]
struct Bond {
    from: usize,
    to: usize,
    image: [i32; 3],
}

/// What a network's energy is and how it changes, kcal/mol, Å.
#[derive(Debug, Clone)]
pub struct Derivatives {
    /// kcal/mol.
    pub energy: f64,
    /// Over node coordinates, kcal/mol/Å.
    pub gradient: Vec<f64>,
    /// Over strains, kcal/mol.
    pub strain_gradient: Vec<f64>,
    /// Over strains twice, kcal/mol.
    pub strain_hessian: DMatrix<f64>,
    /// Over node coordinates (rows) and strains, kcal/mol/Å.
    pub mixed: DMatrix<f64>,
    /// Over node coordinates twice, the entries of [`NetworkEnergy::entries`], kcal/mol/Å².
    pub hessian: Vec<f64>,
}

/// Nodes and cell: where a network is in the course of a minimisation. Coordinates are (x, y, z) or
/// (y, z), Å.
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
        let apply = |vector: &mut [f64]| {
            let mut moved = [0.0; 3];
            for i in 0..dimension {
                moved[i] = vector[i]
                    + (0..dimension)
                        .map(|j| tensor[i][j] * vector[j])
                        .sum::<f64>();
            }
            vector[..dimension].copy_from_slice(&moved[..dimension]);
        };
        self.nodes_angstrom
            .chunks_exact_mut(dimension)
            .for_each(apply);
        self.cell_angstrom
            .iter_mut()
            .for_each(|vector| apply(&mut vector[..]));
    }

    /// The same without the rotation from `start` to here, so that axes keep their meaning: with F
    /// = R U the deformation of the cell, all is turned by R⁻¹. Strains that follow each other add
    /// up to rotations, which cost nothing.
    #[must_use]
    pub fn without_rotation(&self, start: &Self) -> Self {
        let columns = |cell: &[[f64; 3]; 3]| {
            let mut matrix = Matrix3::from_fn(|i, j| cell[j][i]);
            // The axis that a plane leaves out.
            if matrix.column(2).iter().all(|x| *x == 0.0) {
                matrix[(2, 2)] = 1.0;
            }
            matrix
        };
        let Some(inverse) = columns(&start.cell_angstrom).try_inverse() else {
            return self.clone();
        };
        let svd = (columns(&self.cell_angstrom) * inverse).svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return self.clone();
        };
        let back = (u * v_t).transpose();
        let turn =
            |vector: &[f64]| back * Vector3::from_fn(|i, _| vector.get(i).copied().unwrap_or(0.0));
        let mut turned = self.clone();
        let dimension = if start.cell_angstrom[2] == [0.0; 3] {
            2
        } else {
            3
        };
        for node in turned.nodes_angstrom.chunks_exact_mut(dimension) {
            let place = turn(node);
            node.copy_from_slice(&place.as_slice()[..dimension]);
        }
        for vector in turned.cell_angstrom.iter_mut().take(dimension) {
            let place = turn(&vector[..dimension]);
            vector[..dimension].copy_from_slice(&place.as_slice()[..dimension]);
        }
        turned
    }

    /// The network with its nodes and cell here.
    pub fn place(&self, framework: &Framework) -> Framework {
        let dimension = framework.dimension();
        Framework {
            nodes_angstrom: self
                .nodes_angstrom
                .chunks_exact(dimension)
                .map(<[f64]>::to_vec)
                .collect(),
            cell_angstrom: self.cell_angstrom[..dimension]
                .iter()
                .map(|v| v[..dimension].to_vec())
                .collect(),
            ..framework.clone()
        }
    }
}

/// ε as a matrix from its components in the order of the [module](super).
pub(crate) fn strain_tensor(dimension: usize, strains: &[f64]) -> [[f64; 3]; 3] {
    let mut tensor = [[0.0; 3]; 3];
    for (index, strain) in strains.iter().enumerate() {
        let (i, j) = strain_axes(dimension, index);
        if i == j {
            tensor[i][i] += strain;
        } else {
            tensor[i][j] += 0.5 * strain;
            tensor[j][i] += 0.5 * strain;
        }
    }
    tensor
}

/// The two axes of a strain component.
pub(crate) fn strain_axes(dimension: usize, index: usize) -> (usize, usize) {
    match (dimension, index) {
        (2, 2) => (0, 1),
        (_, 3) => (1, 2),
        (_, 4) => (0, 2),
        (_, 5) => (0, 1),
        (_, axis) => (axis, axis),
    }
}

/// B_a D.
fn strained(dimension: usize, index: usize, d: &[f64; 3]) -> [f64; 3] {
    let mut moved = [0.0; 3];
    match strain_axes(dimension, index) {
        (i, j) if i == j => moved[i] = d[i],
        (i, j) => (moved[i], moved[j]) = (0.5 * d[j], 0.5 * d[i]),
    }
    moved
}

impl NetworkEnergy {
    /// The energy of this network; rest lengths and angles that are not given are those it is built
    /// with.
    ///
    /// # Errors
    /// As [`Framework::check`].
    pub fn new(framework: &Framework) -> Result<Self> {
        framework.check()?;
        let plane = framework.dimension() == 2;
        let here = Configuration::built(framework);
        let mut energy = Self {
            dimension: framework.dimension(),
            nodes: framework.nodes_angstrom.len(),
            terms: Vec::new(),
            entries: Vec::new(),
        };
        for rod in &framework.rods {
            let bonds = vec![bond(&Neighbour::here(rod.from), &rod.to)];
            energy.add(
                &here,
                Kind::Rod,
                rod.stiffness_kcal_mol_angstrom2,
                rod.rest_length_angstrom,
                bonds,
            );
        }
        for hinge in &framework.hinges {
            let vertex = Neighbour::here(hinge.vertex);
            let bonds = vec![
                bond(&vertex, &hinge.between[0]),
                bond(&vertex, &hinge.between[1]),
            ];
            let kind = if plane { Kind::PlaneHinge } else { Kind::Hinge };
            energy.add(
                &here,
                kind,
                hinge.stiffness_kcal_mol_rad2,
                hinge.rest_angle_rad,
                bonds,
            );
        }
        for torsion in &framework.torsions {
            let bonds = torsion
                .along
                .windows(2)
                .map(|pair| bond(&pair[0], &pair[1]))
                .collect();
            energy.add(
                &here,
                Kind::Torsion,
                torsion.stiffness_kcal_mol_rad2,
                torsion.rest_angle_rad,
                bonds,
            );
        }
        if let Some(index) = energy.terms.iter().position(|term| !term.rest.is_finite()) {
            return Err(CrystalError::BadNetwork(format!(
                "term {index} (rods, hinges and torsions counted through) has no defined length or angle as built"
            )));
        }
        energy.lay_out();
        Ok(energy)
    }

    fn add(
        &mut self,
        here: &Configuration,
        mut kind: Kind,
        stiffness: f64,
        rest: Option<f64>,
        bonds: Vec<Bond>,
    ) {
        let vectors: Vec<[f64; 3]> = bonds.iter().map(|bond| self.vector(here, bond)).collect();
        let built = measure(kind, &vectors);
        let rest = match (kind, rest) {
            (_, None) => built,
            // On the side on which it is built.
            (Kind::PlaneHinge, Some(angle)) if built < 0.0 => -angle,
            (_, Some(rest)) => rest,
        };
        if kind == Kind::Hinge && (PI - rest).abs() < NEARLY_STRAIGHT {
            kind = Kind::StraightHinge;
        }
        self.terms.push(Term {
            kind,
            stiffness,
            rest,
            bonds,
            blocks: Vec::new(),
        });
    }

    /// Finds the places of the Hessian.
    fn lay_out(&mut self) {
        let d = self.dimension;
        let mut starts: HashMap<(usize, usize), u32> = HashMap::new();
        let mut entries = Vec::new();
        let mut start_of = |row: usize, column: usize| {
            *starts.entry((row, column)).or_insert_with(|| {
                let start = entries.len() as u32;
                for a in 0..d {
                    for b in 0..if row == column { a + 1 } else { d } {
                        entries.push((d * row + a, d * column + b));
                    }
                }
                start
            })
        };
        for node in 0..self.nodes {
            start_of(node, node);
        }
        for term in &mut self.terms {
            let ends: Vec<usize> = term
                .bonds
                .iter()
                .flat_map(|bond| [bond.from, bond.to])
                .collect();
            for row in &ends {
                for column in &ends {
                    term.blocks.push(if row >= column {
                        start_of(*row, *column)
                    } else {
                        NONE
                    });
                }
            }
        }
        self.entries = entries;
    }

    /// The network with the rest lengths and angles written out that are otherwise those it is
    /// built with, so that its nodes and cell can be moved without changing its energy as a
    /// function of them.
    pub fn with_rests(&self, framework: &Framework) -> Framework {
        let mut fixed = framework.clone();
        let mut rests = self.terms.iter().map(|term| match term.kind {
            // The side is that on which it is built.
            Kind::PlaneHinge => term.rest.abs(),
            _ => term.rest,
        });
        fixed
            .rods
            .iter_mut()
            .for_each(|rod| rod.rest_length_angstrom = rests.next());
        fixed
            .hinges
            .iter_mut()
            .for_each(|hinge| hinge.rest_angle_rad = rests.next());
        fixed
            .torsions
            .iter_mut()
            .for_each(|torsion| torsion.rest_angle_rad = rests.next());
        fixed
    }

    /// Number of dimensions.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of node coordinates.
    pub fn coordinates(&self) -> usize {
        self.dimension * self.nodes
    }

    /// Places (row, column) of the lower triangle of the Hessian, in the order of
    /// [`Derivatives::hessian`].
    pub fn entries(&self) -> &[(usize, usize)] {
        &self.entries
    }

    fn vector(&self, at: &Configuration, bond: &Bond) -> [f64; 3] {
        let d = self.dimension;
        let mut vector = [0.0; 3];
        for (i, x) in vector.iter_mut().enumerate().take(d) {
            *x = at.nodes_angstrom[d * bond.to + i] - at.nodes_angstrom[d * bond.from + i];
            for (count, row) in bond.image.iter().zip(&at.cell_angstrom) {
                *x += f64::from(*count) * row[i];
            }
        }
        vector
    }

    /// The energy alone, kcal/mol.
    pub fn energy(&self, at: &Configuration) -> f64 {
        let one = |term: &Term| {
            let vectors: Vec<[f64; 3]> = term
                .bonds
                .iter()
                .map(|bond| self.vector(at, bond))
                .collect();
            let away = deviation(term.kind, measure(term.kind, &vectors), term.rest);
            0.5 * term.stiffness * away * away
        };
        self.terms.iter().map(one).sum()
    }

    /// Energy, first and second derivatives.
    pub fn derivatives(&self, at: &Configuration) -> Derivatives {
        let strains = if self.dimension == 2 { 3 } else { 6 };
        let mut sum = Derivatives {
            energy: 0.0,
            gradient: vec![0.0; self.coordinates()],
            strain_gradient: vec![0.0; strains],
            strain_hessian: DMatrix::zeros(strains, strains),
            mixed: DMatrix::zeros(self.coordinates(), strains),
            hessian: vec![0.0; self.entries.len()],
        };
        for term in &self.terms {
            let mut vectors = [[0.0; 3]; 3];
            for (vector, bond) in vectors.iter_mut().zip(&term.bonds) {
                *vector = self.vector(at, bond);
            }
            match term.kind {
                Kind::Rod => self.collect(term, &vectors, &rod_energy(term, &vectors), &mut sum),
                Kind::Torsion => {
                    self.collect(term, &vectors, &torsion_energy(term, &vectors), &mut sum)
                }
                _ => self.collect(term, &vectors, &hinge_energy(term, &vectors), &mut sum),
            }
        }
        sum
    }

    /// Adds one term's derivatives over its vectors to those over nodes and strains.
    fn collect<const N: usize>(
        &self,
        term: &Term,
        vectors: &[[f64; 3]; 3],
        local: &Jet<N>,
        sum: &mut Derivatives,
    ) {
        let (d, count) = (self.dimension, term.bonds.len());
        sum.energy += local.value;
        for (p, bond) in term.bonds.iter().enumerate() {
            for i in 0..d {
                sum.gradient[d * bond.to + i] += local.gradient[3 * p + i];
                sum.gradient[d * bond.from + i] -= local.gradient[3 * p + i];
            }
        }
        for a in 0..sum.strain_gradient.len() {
            // B_a D and H B_a D over all vectors of the term.
            let moved: [[f64; 3]; 3] = std::array::from_fn(|p| strained(d, a, &vectors[p]));
            let mut turned = [[0.0; 3]; 3];
            for p in 0..count {
                for i in 0..3 {
                    sum.strain_gradient[a] += local.gradient[3 * p + i] * moved[p][i];
                    turned[p][i] = (0..3 * count)
                        .map(|c| local.hessian[3 * p + i][c] * moved[c / 3][c % 3])
                        .sum();
                }
            }
            for b in 0..=a {
                let other: [[f64; 3]; 3] = std::array::from_fn(|p| strained(d, b, &vectors[p]));
                let product: f64 = (0..3 * count)
                    .map(|c| turned[c / 3][c % 3] * other[c / 3][c % 3])
                    .sum();
                sum.strain_hessian[(a, b)] += product;
                if a != b {
                    sum.strain_hessian[(b, a)] += product;
                }
            }
            for (p, bond) in term.bonds.iter().enumerate() {
                let g: [f64; 3] = std::array::from_fn(|i| local.gradient[3 * p + i]);
                let stretched = strained(d, a, &g);
                for i in 0..d {
                    let change = turned[p][i] + stretched[i];
                    sum.mixed[(d * bond.to + i, a)] += change;
                    sum.mixed[(d * bond.from + i, a)] -= change;
                }
            }
        }
        let mut block = 0;
        for row_end in 0..2 * count {
            for column_end in 0..2 * count {
                let start = term.blocks[block];
                block += 1;
                if start == NONE {
                    continue;
                }
                let (p, q) = (row_end / 2, column_end / 2);
                let sign = if row_end % 2 == column_end % 2 {
                    1.0
                } else {
                    -1.0
                };
                let ends = |end: usize| {
                    if end.is_multiple_of(2) {
                        term.bonds[end / 2].from
                    } else {
                        term.bonds[end / 2].to
                    }
                };
                let diagonal = ends(row_end) == ends(column_end);
                let mut entry = start as usize;
                for i in 0..d {
                    for j in 0..if diagonal { i + 1 } else { d } {
                        sum.hessian[entry] += sign * local.hessian[3 * p + i][3 * q + j];
                        entry += 1;
                    }
                }
            }
        }
    }
}

fn bond(from: &Neighbour, to: &Neighbour) -> Bond {
    let image =
        |neighbour: &Neighbour, axis: usize| neighbour.image.get(axis).copied().unwrap_or(0);
    Bond {
        from: from.node,
        to: to.node,
        image: std::array::from_fn(|axis| image(to, axis) - image(from, axis)),
    }
}

/// Length or angle of a term.
fn measure(kind: Kind, vectors: &[[f64; 3]]) -> f64 {
    let vector = |index: usize| vectors[index].map(Jet::<0>::constant);
    match kind {
        Kind::Rod => vectors[0].iter().map(|x| x * x).sum::<f64>().sqrt(),
        Kind::PlaneHinge => plane_angle(&vector(0), &vector(1)).value,
        Kind::Hinge | Kind::StraightHinge => angle(&vector(0), &vector(1)).value,
        Kind::Torsion => dihedral(&vector(0), &vector(1), &vector(2)).value,
    }
}

/// How far from rest, by the shorter way around for angles in a circle.
fn deviation(kind: Kind, value: f64, rest: f64) -> f64 {
    match kind {
        Kind::PlaneHinge | Kind::Torsion => {
            let away = value - rest;
            away - 2.0 * PI * (away / (2.0 * PI)).round()
        }
        _ => value - rest,
    }
}

fn variables<const N: usize>(vectors: &[[f64; 3]; 3], index: usize) -> [Jet<N>; 3] {
    std::array::from_fn(|i| Jet::variable(vectors[index][i], 3 * index + i))
}

/// ½ k (x - rest)², from the jet of x.
fn spring<const N: usize>(term: &Term, value: Jet<N>) -> Jet<N> {
    let away = deviation(term.kind, value.value, term.rest);
    value.chain(
        0.5 * term.stiffness * away * away,
        term.stiffness * away,
        term.stiffness,
    )
}

fn rod_energy(term: &Term, vectors: &[[f64; 3]; 3]) -> Jet<3> {
    let d = variables(vectors, 0);
    spring(term, dot(&d, &d).sqrt())
}

fn hinge_energy(term: &Term, vectors: &[[f64; 3]; 3]) -> Jet<6> {
    let (a, b) = (variables(vectors, 0), variables(vectors, 1));
    match term.kind {
        Kind::PlaneHinge => spring(term, plane_angle(&a, &b)),
        // (π - θ)² = 4 arcsin² (|û_a + û_b|/2), smooth where θ = π.
        Kind::StraightHinge => {
            let (la, lb) = (dot(&a, &a).sqrt().recip(), dot(&b, &b).sqrt().recip());
            let sum: [Jet<6>; 3] = std::array::from_fn(|i| a[i] * la + b[i] * lb);
            let quarter = dot(&sum, &sum) * 0.25;
            quarter.arcsine_of_root_squared() * (2.0 * term.stiffness)
        }
        _ => spring(term, angle(&a, &b)),
    }
}

fn torsion_energy(term: &Term, vectors: &[[f64; 3]; 3]) -> Jet<9> {
    spring(
        term,
        dihedral(
            &variables(vectors, 0),
            &variables(vectors, 1),
            &variables(vectors, 2),
        ),
    )
}

/// The angle from a to b in the plane, positive anticlockwise.
fn plane_angle<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> Jet<N> {
    Jet::atan2(&(a[0] * b[1] - a[1] * b[0]), &(a[0] * b[0] + a[1] * b[1]))
}

/// The angle between a and b, 0 to π.
fn angle<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> Jet<N> {
    let normal = cross(a, b);
    Jet::atan2(&dot(&normal, &normal).sqrt(), &dot(a, b))
}

/// The dihedral angle about b: atan2(|b| a · (b × c), (a × b) · (b × c)).
fn dihedral<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3], c: &[Jet<N>; 3]) -> Jet<N> {
    let (first, second) = (cross(a, b), cross(b, c));
    Jet::atan2(&(dot(b, b).sqrt() * dot(a, &second)), &dot(&first, &second))
}
