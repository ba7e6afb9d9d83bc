//! Ribs that flex: rods as chains of segments with bending stiffness, joined rigidly.
//!
//! A rib of length L in n segments has hinges of stiffness n EI/L between two segments, and half
//! a segment, 2 n EI/L, between its end and a joint that turns freely as a whole. The joint itself
//! needs no coordinate: hinges of stiffness k_i k_j / Σ k between every two ribs at it (the
//! star-mesh transform) have the same energy, minimised over the angle of the joint. The moments of
//! a beam are then summed by trapezia, so that a rib whose ends stay parallel resists with
//! 12 EI/L³ / (1 + 2/n²).

use super::build::{hinge, rods_at};
use super::model::{Framework, Hinge, Neighbour, Rod};
use crate::error::{CrystalError, Result, require, require_positive};

/// The largest number of segments of a rib.
const MOST_SEGMENTS: usize = 1000;

/// The bending of ribs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flexure {
    /// EI, the bending stiffness, kcal Å/mol.
    pub bending_stiffness_kcal_angstrom_mol: f64,
    /// Segments of each rib.
    pub segments: usize,
}

impl Framework {
    /// The same network with ribs that flex: rods from this index on, joined rigidly to each other
    /// and to the rods before it, which stay straight and make rigid bodies.
    ///
    /// ```
    /// use protomer_linkage::framework::analytic::Honeycomb;
    /// use protomer_linkage::framework::{Elasticity, Flexure, Moduli, build::honeycomb};
    /// let mut made_of = Honeycomb {
    ///     h_angstrom: 2.0,
    ///     l_angstrom: 1.0,
    ///     theta_rad: 60_f64.to_radians(),
    ///     hinge_stiffness_kcal_mol_rad2: 0.0,
    ///     rod_stiffness_kcal_mol_angstrom2: 10_000.0,
    ///     thickness_angstrom: 1.0,
    /// };
    /// let bending = Flexure { bending_stiffness_kcal_angstrom_mol: 8.0, segments: 6 };
    /// let flexing = honeycomb(&made_of)?.flexing(0, &bending)?;
    /// let moduli = Moduli::new(&Elasticity::from_framework(&flexing)?, 1.0);
    /// // A rib that flexes between parallel ends resists as one with hinges of 6 EI/l at both.
    /// made_of.hinge_stiffness_kcal_mol_rad2 = 6.0 * 8.0 / (1.0 + 2.0 / 36.0);
    /// let hinging = made_of.both(1.0);
    /// assert!((moduli.youngs_gpa[0].unwrap() / hinging.e_y_gpa - 1.0).abs() < 1e-9);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a stiffness that is not positive or a number of segments out
    /// of range, [`CrystalError::BadNetwork`] for a network in space or one with hinges.
    pub fn flexing(&self, first_rib: usize, flexure: &Flexure) -> Result<Self> {
        let stiffness = flexure.bending_stiffness_kcal_angstrom_mol;
        require_positive("flexure", stiffness)?;
        let segments = flexure.segments;
        require(
            "segments",
            segments as f64,
            (1..=MOST_SEGMENTS).contains(&segments),
            "from 1 to 1000",
        )?;
        if self.dimension() != 2 {
            return Err(CrystalError::BadNetwork(
                "only ribs in the plane flex; this network has three dimensions".into(),
            ));
        }
        let is_hinged = |hinge: &Hinge| hinge.stiffness_kcal_mol_rad2 != 0.0;
        if self.hinges.iter().any(is_hinged) {
            return Err(CrystalError::BadNetwork(
                "ribs that flex are joined rigidly; leave the hinges out (--kh 0)".into(),
            ));
        }
        let mut flexing = Self {
            rods: self.rods[..first_rib].to_vec(),
            hinges: Vec::new(),
            ..self.clone()
        };
        let mut ends: Vec<Vec<End>> = vec![Vec::new(); self.nodes_angstrom.len()];
        for rib in &self.rods[first_rib..] {
            let [first, last] = flexing.add_rib(self, rib, flexure);
            let half = 2.0 * segments as f64 * stiffness / length(self, rib);
            ends[rib.from].push(End {
                towards: first,
                stiffness: half,
            });
            ends[rib.to.node].push(End {
                towards: last,
                stiffness: half,
            });
        }
        for (vertex, ends) in ends.iter().enumerate() {
            // Rods that stay straight are a rigid body, to which every rib is tied by its own half segment.
            match rods_at(&self.rods[..first_rib], vertex).first() {
                Some(rigid) => {
                    for end in ends {
                        let between = [rigid.clone(), end.towards.clone()];
                        flexing.hinges.push(hinge(vertex, between, end.stiffness));
                    }
                }
                None => flexing.join(vertex, ends),
            }
        }
        Ok(flexing)
    }

    /// Adds the segments of a rib and the hinges between them; gives the nodes next to its two ends, as
    /// seen from these.
    fn add_rib(&mut self, straight: &Framework, rib: &Rod, flexure: &Flexure) -> [Neighbour; 2] {
        let segments = flexure.segments;
        let from = Neighbour::in_own_cell(rib.from);
        let (start, way) = (straight.place(&from), straight.difference(&from, &rib.to));
        let first_inside = self.nodes_angstrom.len();
        for segment in 1..segments {
            let part = segment as f64 / segments as f64;
            let node = (0..2).map(|axis| start[axis] + part * way[axis]);
            self.nodes_angstrom.push(node.collect());
        }
        // Nodes along the rib in the cell of its start; only the last may be in another.
        let mut chain = vec![from];
        chain.extend(
            (1..segments).map(|segment| Neighbour::in_own_cell(first_inside + segment - 1)),
        );
        chain.push(rib.to.clone());
        for pair in chain.windows(2) {
            self.rods.push(Rod {
                from: pair[0].node,
                to: pair[1].clone(),
                stiffness_kcal_mol_angstrom2: segments as f64 * rib.stiffness_kcal_mol_angstrom2,
                rest_length_angstrom: rib
                    .rest_length_angstrom
                    .map(|length| length / segments as f64),
            });
        }
        let stiffness =
            segments as f64 * flexure.bending_stiffness_kcal_angstrom_mol / length(straight, rib);
        for triple in chain.windows(3) {
            let between = [triple[0].clone(), triple[2].clone()];
            self.hinges.push(hinge(triple[1].node, between, stiffness));
        }
        let mut last = chain[segments - 1].clone();
        last.image = rib.to.image.iter().map(|cells| -cells).collect();
        [chain[1].clone(), last]
    }

    /// Joins ribs at a node rigidly.
    fn join(&mut self, vertex: usize, ends: &[End]) {
        let mut sum = 0.0;
        for end in ends {
            sum += end.stiffness;
        }
        for (index, first) in ends.iter().enumerate() {
            for second in &ends[index + 1..] {
                let between = [first.towards.clone(), second.towards.clone()];
                let stiffness = first.stiffness * second.stiffness / sum;
                self.hinges.push(hinge(vertex, between, stiffness));
            }
        }
    }
}

/// The end of a rib at a joint.
#[derive(Debug, Clone)]
struct End {
    /// The next node along the rib.
    towards: Neighbour,
    /// Stiffness of half a segment, kcal/mol/rad².
    stiffness: f64,
}

fn length(framework: &Framework, rod: &Rod) -> f64 {
    let way = framework.difference(&Neighbour::in_own_cell(rod.from), &rod.to);
    way.iter().map(|x| x * x).sum::<f64>().sqrt()
}
