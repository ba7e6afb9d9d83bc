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

pub use super::configuration::Configuration;
use super::configuration::strained;
use super::model::{Framework, Neighbour};
use super::term::{Bond, Kind, Term};
use crate::{CrystalError, Result};
use nalgebra::DMatrix;
use protomer_kernel::jet::Jet;
use std::collections::HashMap;

/// The energy of a network as a function of its nodes and cell. Rest lengths and angles "as built"
/// are fixed when it is made.
#[derive(Debug, Clone)]
pub struct NetworkEnergy {
    dimension: usize,
    nodes: usize,
    terms: Vec<Term>,
    entries: Vec<(usize, usize)>,
}

/// The energy of a network and its derivatives, kcal/mol, Å.
#[derive(Debug, Clone)]
pub struct Derivatives {
    /// Energy, kcal/mol.
    pub energy: f64,
    /// Gradient over node coordinates, kcal/mol/Å.
    pub gradient: Vec<f64>,
    /// Gradient over strains, kcal/mol.
    pub strain_gradient: Vec<f64>,
    /// Second derivatives over strains, kcal/mol.
    pub strain_hessian: DMatrix<f64>,
    /// Second derivatives over node coordinates (rows) and strains, kcal/mol/Å.
    pub mixed: DMatrix<f64>,
    /// Second derivatives over node coordinates, at [`NetworkEnergy::entries`], kcal/mol/Å².
    pub hessian: Vec<f64>,
}

/// The vectors of a term's bonds; those it does not have are zero.
type Vectors = [[f64; 3]; 3];

impl NetworkEnergy {
    /// The energy of this network; rest lengths and angles that are not given are those it is built
    /// with.
    ///
    /// # Errors
    /// As [`Framework::check`], and [`CrystalError::BadNetwork`] for a spring without a defined
    /// length or angle.
    pub fn new(framework: &Framework) -> Result<Self> {
        framework.check()?;
        let mut energy = Self {
            dimension: framework.dimension(),
            nodes: framework.nodes_angstrom.len(),
            terms: Vec::new(),
            entries: Vec::new(),
        };
        let built = Configuration::built(framework);
        energy.add_rods(framework, &built);
        energy.add_hinges(framework, &built);
        energy.add_torsions(framework, &built);
        if let Some(index) = energy
            .terms
            .iter()
            .position(|term| !term.rest_value.is_finite())
        {
            return Err(CrystalError::BadNetwork(format!(
                "term {index} (rods, then hinges, then torsions) has no defined length or angle as \
                 built"
            )));
        }
        energy.lay_out();
        Ok(energy)
    }

    fn add_rods(&mut self, framework: &Framework, built: &Configuration) {
        for rod in &framework.rods {
            let bonds = vec![bond(&Neighbour::in_own_cell(rod.from), &rod.to)];
            let (stiffness, rest_value) =
                (rod.stiffness_kcal_mol_angstrom2, rod.rest_length_angstrom);
            self.add(built, Kind::Rod, stiffness, rest_value, bonds);
        }
    }

    fn add_hinges(&mut self, framework: &Framework, built: &Configuration) {
        let kind = if self.dimension == 2 {
            Kind::PlaneHinge
        } else {
            Kind::Hinge
        };
        for hinge in &framework.hinges {
            let vertex = Neighbour::in_own_cell(hinge.vertex);
            let [first, second] = &hinge.between;
            let bonds = vec![bond(&vertex, first), bond(&vertex, second)];
            let (stiffness, rest_value) = (hinge.stiffness_kcal_mol_rad2, hinge.rest_angle_rad);
            self.add(built, kind, stiffness, rest_value, bonds);
        }
    }

    fn add_torsions(&mut self, framework: &Framework, built: &Configuration) {
        for torsion in &framework.torsions {
            let pairs = torsion.along.windows(2);
            let bonds = pairs.map(|pair| bond(&pair[0], &pair[1])).collect();
            let (stiffness, rest_value) = (torsion.stiffness_kcal_mol_rad2, torsion.rest_angle_rad);
            self.add(built, Kind::Torsion, stiffness, rest_value, bonds);
        }
    }

    fn add(
        &mut self,
        built: &Configuration,
        kind: Kind,
        stiffness: f64,
        rest_value: Option<f64>,
        bonds: Vec<Bond>,
    ) {
        let vectors = self.vectors(built, &bonds);
        let vectors = &vectors[..bonds.len()];
        self.terms
            .push(Term::new(kind, stiffness, rest_value, bonds, vectors));
    }

    /// Finds the places of the Hessian.
    fn lay_out(&mut self) {
        // Diagonal blocks first, so that every node has one, also without terms.
        let mut layout = Layout::new(self.dimension);
        for node in 0..self.nodes {
            layout.block(node, node);
        }
        for term in &mut self.terms {
            let ends = term.ends();
            for row in &ends {
                for column in &ends {
                    // Lower triangle by nodes; the other half is not stored.
                    let block = (row >= column).then(|| layout.block(*row, *column));
                    term.blocks.push(block);
                }
            }
        }
        self.entries = layout.entries;
    }

    /// The network with the rest lengths and angles written out that are otherwise those it is
    /// built with, so that its nodes and cell can be moved without changing its energy as a
    /// function of them.
    pub fn with_rests(&self, framework: &Framework) -> Framework {
        let mut fixed = framework.clone();
        let mut rests = self.terms.iter().map(|term| match term.kind {
            // The side is that on which it is built.
            Kind::PlaneHinge => term.rest_value.abs(),
            _ => term.rest_value,
        });
        for rod in &mut fixed.rods {
            rod.rest_length_angstrom = rests.next();
        }
        for hinge in &mut fixed.hinges {
            hinge.rest_angle_rad = rests.next();
        }
        for torsion in &mut fixed.torsions {
            torsion.rest_angle_rad = rests.next();
        }
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

    fn vectors(&self, configuration: &Configuration, bonds: &[Bond]) -> Vectors {
        let mut vectors = [[0.0; 3]; 3];
        for (vector, bond) in vectors.iter_mut().zip(bonds) {
            *vector = self.vector(configuration, bond);
        }
        vectors
    }

    fn vector(&self, configuration: &Configuration, bond: &Bond) -> [f64; 3] {
        let d = self.dimension;
        let mut vector = [0.0; 3];
        for (i, x) in vector.iter_mut().enumerate().take(d) {
            *x = configuration.nodes_angstrom[d * bond.to + i]
                - configuration.nodes_angstrom[d * bond.from + i];
            // Images by whole cell vectors, which follow the strain as nodes do.
            for (count, row) in bond.image.iter().zip(&configuration.cell_angstrom) {
                *x += f64::from(*count) * row[i];
            }
        }
        vector
    }

    /// The energy alone, kcal/mol.
    pub fn energy(&self, configuration: &Configuration) -> f64 {
        let mut energy = 0.0;
        for term in &self.terms {
            let vectors = self.vectors(configuration, &term.bonds);
            energy += term.energy(&vectors[..term.bonds.len()]);
        }
        energy
    }

    /// Energy, first and second derivatives.
    pub fn derivatives(&self, configuration: &Configuration) -> Derivatives {
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
            let v = self.vectors(configuration, &term.bonds);
            match term.kind {
                Kind::Rod => self.collect(term, &v, &term.rod_energy(&v), &mut sum),
                Kind::Torsion => self.collect(term, &v, &term.torsion_energy(&v), &mut sum),
                _ => self.collect(term, &v, &term.hinge_energy(&v), &mut sum),
            }
        }
        sum
    }

    /// Adds one term's derivatives over its vectors to those over nodes and strains.
    fn collect<const N: usize>(
        &self,
        term: &Term,
        vectors: &Vectors,
        local: &Jet<N>,
        sum: &mut Derivatives,
    ) {
        sum.energy += local.value;
        for (p, bond) in term.bonds.iter().enumerate() {
            let d = self.dimension;
            // ∂D/∂x is +1 at the end and -1 at the start of a bond.
            for i in 0..d {
                sum.gradient[d * bond.to + i] += local.gradient[3 * p + i];
                sum.gradient[d * bond.from + i] -= local.gradient[3 * p + i];
            }
        }
        for a in 0..sum.strain_gradient.len() {
            self.collect_strain(term, vectors, local, a, sum);
        }
        self.collect_hessian(term, local, &mut sum.hessian);
    }

    /// The derivatives over strain a: once, with other strains, and with nodes.
    fn collect_strain<const N: usize>(
        &self,
        term: &Term,
        vectors: &Vectors,
        local: &Jet<N>,
        a: usize,
        sum: &mut Derivatives,
    ) {
        let d = self.dimension;
        // B_a D and H B_a D over all vectors of the term.
        let strained_bonds: [f64; N] = flattened(&vectors.map(|vector| strained(d, a, &vector)));
        // H times the strained bonds serves other strains and nodes alike.
        let pushed = local.hessian.map(|row| product(&row, &strained_bonds));
        for (g, change) in local.gradient.iter().zip(strained_bonds) {
            sum.strain_gradient[a] += g * change;
        }
        // Symmetric: each pair once, written to both places.
        for b in 0..=a {
            let other: [f64; N] = flattened(&vectors.map(|vector| strained(d, b, &vector)));
            let second = product(&pushed, &other);
            sum.strain_hessian[(a, b)] += second;
            if a != b {
                sum.strain_hessian[(b, a)] += second;
            }
        }
        for (p, bond) in term.bonds.iter().enumerate() {
            let gradient = [0, 1, 2].map(|i| local.gradient[3 * p + i]);
            let strained_gradient = strained(d, a, &gradient);
            for i in 0..d {
                // H B D + B g: the second term, as strains act on displaced nodes too.
                let change = pushed[3 * p + i] + strained_gradient[i];
                sum.mixed[(d * bond.to + i, a)] += change;
                sum.mixed[(d * bond.from + i, a)] -= change;
            }
        }
    }

    /// Aᵀ H A: every end of a bond against every other, with the sign of the difference.
    fn collect_hessian<const N: usize>(&self, term: &Term, local: &Jet<N>, hessian: &mut [f64]) {
        let (d, ends) = (self.dimension, term.ends());
        for (row_end, row) in ends.iter().enumerate() {
            for (column_end, column) in ends.iter().enumerate() {
                let Some(start) = term.blocks[row_end * ends.len() + column_end] else {
                    continue;
                };
                let (p, q) = (row_end / 2, column_end / 2);
                // Signs of both ends: +1 for two ends or two starts, -1 for one of each.
                let same_sign = row_end % 2 == column_end % 2;
                let sign = if same_sign { 1.0 } else { -1.0 };
                let mut entry = start as usize;
                for i in 0..d {
                    // A diagonal block keeps its lower triangle only.
                    for j in 0..if row == column { i + 1 } else { d } {
                        hessian[entry] += sign * local.hessian[3 * p + i][3 * q + j];
                        entry += 1;
                    }
                }
            }
        }
    }
}

/// Hands out the blocks of the Hessian, node by node.
struct Layout {
    dimension: usize,
    starts: HashMap<(usize, usize), u32>,
    entries: Vec<(usize, usize)>,
}

impl Layout {
    fn new(dimension: usize) -> Self {
        Self {
            dimension,
            starts: HashMap::new(),
            entries: Vec::new(),
        }
    }

    /// Index at which the block of these nodes begins; a diagonal block has only a lower triangle.
    fn block(&mut self, row: usize, column: usize) -> u32 {
        if let Some(start) = self.starts.get(&(row, column)) {
            return *start;
        }
        let (start, d) = (self.entries.len() as u32, self.dimension);
        for a in 0..d {
            for b in 0..if row == column { a + 1 } else { d } {
                self.entries.push((d * row + a, d * column + b));
            }
        }
        self.starts.insert((row, column), start);
        start
    }
}

fn bond(from: &Neighbour, to: &Neighbour) -> Bond {
    let cells =
        |neighbour: &Neighbour, axis: usize| neighbour.image.get(axis).copied().unwrap_or(0);
    Bond {
        from: from.node,
        to: to.node,
        image: [0, 1, 2].map(|axis| cells(to, axis) - cells(from, axis)),
    }
}

/// The first N components of some vectors.
fn flattened<const N: usize>(vectors: &Vectors) -> [f64; N] {
    let mut flat = [0.0; N];
    flat.copy_from_slice(&vectors.as_flattened()[..N]);
    flat
}

fn product<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}
