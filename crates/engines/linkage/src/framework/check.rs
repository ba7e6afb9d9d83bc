//! What is wrong with a network.

use super::model::{Framework, Hinge, Neighbour, Rod, Torsion};
use crate::{CrystalError, Result};
use protomer_kernel::Number;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// A rod, or a cell, shorter or flatter than this (Å) has collapsed.
const SMALLEST_LENGTH_ANGSTROM: f64 = 1e-9;
/// Coordinates, Å.
const LARGEST_COORDINATE_ANGSTROM: f64 = 1e6;
/// Lengths at which rods are at rest, and the thickness, Å.
const LENGTHS_ANGSTROM: RangeInclusive<f64> = 1e-6..=1e6;
/// Stiffnesses that are not zero, in their units.
const STIFFNESSES: RangeInclusive<f64> = 1e-9..=1e12;
/// No term reaches over more cells than this; it keeps sums of images from overflowing.
const FARTHEST_IMAGE: u32 = 1_000_000;

impl Framework {
    /// Checks what the types cannot.
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] says which node, rod, hinge or cell vector makes no sense, and
    /// why.
    pub fn check(&self) -> Result<()> {
        let dimension = self.dimension();
        if !(2..=3).contains(&dimension) {
            return bad(format!(
                "cell_angstrom has {dimension} vectors; a network has 2 or 3 dimensions"
            ));
        }
        self.check_vectors("cell vector", &self.cell_angstrom)?;
        self.check_vectors("node", &self.nodes_angstrom)?;
        if self.nodes_angstrom.is_empty() {
            return bad("the network has no nodes".into());
        }
        let thickness = self.thickness_angstrom;
        if !LENGTHS_ANGSTROM.contains(&thickness) {
            return bad(format!(
                "thickness_angstrom is {}; it must be {}",
                Number(thickness),
                from_to(&LENGTHS_ANGSTROM)
            ));
        }
        self.check_cell()?;
        for (index, rod) in self.rods.iter().enumerate() {
            self.check_rod(index, rod)?;
        }
        for (index, hinge) in self.hinges.iter().enumerate() {
            self.check_hinge(index, hinge)?;
        }
        self.check_torsions()?;
        self.check_nodes_have_rods()
    }

    fn check_vectors(&self, name: &str, vectors: &[Vec<f64>]) -> Result<()> {
        let dimension = self.dimension();
        for (index, vector) in vectors.iter().enumerate() {
            let fits = |x: &f64| x.abs() <= LARGEST_COORDINATE_ANGSTROM;
            if vector.len() != dimension || !vector.iter().all(fits) {
                return bad(format!(
                    "{name} {index} is {vector:?}; give {dimension} numbers within \
                     {LARGEST_COORDINATE_ANGSTROM} Å of zero"
                ));
            }
        }
        Ok(())
    }

    fn check_cell(&self) -> Result<()> {
        let mut longest = 0.0_f64;
        for vector in &self.cell_angstrom {
            longest = longest.max(length(vector));
        }
        let volume = self.volume_angstrom3();
        let width = volume / longest.powi(self.dimension() as i32 - 1);
        if width.is_nan() || width < SMALLEST_LENGTH_ANGSTROM {
            return bad(format!(
                "the cell has collapsed: its volume is {volume:e} Å³"
            ));
        }
        Ok(())
    }

    fn check_rod(&self, index: usize, rod: &Rod) -> Result<()> {
        let term = TermName("rod", index);
        let from = Neighbour::in_own_cell(rod.from);
        self.check_neighbour(term, &from)?;
        self.check_neighbour(term, &rod.to)?;
        term.check_stiffness(rod.stiffness_kcal_mol_angstrom2)?;
        self.check_apart(term, &from, &rod.to)?;
        match rod.rest_length_angstrom {
            Some(length) if !LENGTHS_ANGSTROM.contains(&length) => bad(format!(
                "rod {index} has rest length {} Å; it must be {}",
                Number(length),
                from_to(&LENGTHS_ANGSTROM)
            )),
            _ => Ok(()),
        }
    }

    fn check_hinge(&self, index: usize, hinge: &Hinge) -> Result<()> {
        let term = TermName("hinge", index);
        let vertex = Neighbour::in_own_cell(hinge.vertex);
        self.check_neighbour(term, &vertex)?;
        for end in &hinge.between {
            self.check_neighbour(term, end)?;
            self.check_apart(term, &vertex, end)?;
        }
        term.check_rest_angle(hinge.rest_angle_rad)?;
        term.check_stiffness(hinge.stiffness_kcal_mol_rad2)
    }

    fn check_torsions(&self) -> Result<()> {
        if !self.torsions.is_empty() && self.dimension() == 2 {
            return bad("torsions need three dimensions; in the plane they do nothing".into());
        }
        for (index, torsion) in self.torsions.iter().enumerate() {
            self.check_torsion(TermName("torsion", index), torsion)?;
        }
        Ok(())
    }

    fn check_torsion(&self, term: TermName, torsion: &Torsion) -> Result<()> {
        for node in &torsion.along {
            self.check_neighbour(term, node)?;
        }
        for pair in torsion.along.windows(2) {
            self.check_apart(term, &pair[0], &pair[1])?;
        }
        term.check_rest_angle(torsion.rest_angle_rad)?;
        term.check_stiffness(torsion.stiffness_kcal_mol_rad2)
    }

    fn check_neighbour(&self, term: TermName, neighbour: &Neighbour) -> Result<()> {
        let Neighbour { node, image } = neighbour;
        let (count, dimension) = (self.nodes_angstrom.len(), self.dimension());
        if *node >= count {
            return bad(format!("{term} names node {node}, but there are {count}"));
        }
        if !(image.is_empty() || image.len() == dimension) {
            return bad(format!(
                "{term} has image {image:?}; give {dimension} whole numbers"
            ));
        }
        if image
            .iter()
            .any(|cells| cells.unsigned_abs() > FARTHEST_IMAGE)
        {
            return bad(format!(
                "{term} has image {image:?}; {FARTHEST_IMAGE} cells is far enough"
            ));
        }
        Ok(())
    }

    fn check_apart(&self, term: TermName, a: &Neighbour, b: &Neighbour) -> Result<()> {
        if length(&self.difference(a, b)) < SMALLEST_LENGTH_ANGSTROM {
            return bad(format!(
                "{term} joins two places that coincide (nodes {} and {})",
                a.node, b.node
            ));
        }
        Ok(())
    }

    fn check_nodes_have_rods(&self) -> Result<()> {
        let mut has_rod = vec![false; self.nodes_angstrom.len()];
        for rod in &self.rods {
            has_rod[rod.from] = true;
            has_rod[rod.to.node] = true;
        }
        match has_rod.iter().position(|has| !has) {
            Some(node) => bad(format!(
                "node {node} has no rod: nothing holds it; remove it or join it"
            )),
            None => Ok(()),
        }
    }
}

/// A term in a message: its kind and its index.
#[derive(Clone, Copy)]
struct TermName(&'static str, usize);

impl std::fmt::Display for TermName {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "{} {}", self.0, self.1)
    }
}

impl TermName {
    fn check_stiffness(self, stiffness: f64) -> Result<()> {
        if stiffness == 0.0 || STIFFNESSES.contains(&stiffness) {
            return Ok(());
        }
        bad(format!(
            "{self} has stiffness {}; it must be 0, or {}",
            Number(stiffness),
            from_to(&STIFFNESSES)
        ))
    }

    fn check_rest_angle(self, angle_rad: Option<f64>) -> Result<()> {
        match angle_rad {
            Some(angle) if !(-TAU..=TAU).contains(&angle) => bad(format!(
                "{self} has rest angle {} rad; it must be within one turn of zero, from {:.4} to {:.4}",
                Number(angle),
                -TAU,
                TAU
            )),
            _ => Ok(()),
        }
    }
}

fn from_to(range: &RangeInclusive<f64>) -> String {
    format!(
        "from {} to {}",
        Number(*range.start()),
        Number(*range.end())
    )
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn bad(problem: String) -> Result<()> {
    Err(CrystalError::BadNetwork(problem))
}
