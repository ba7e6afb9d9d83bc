//! The network as data.

use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};

/// A periodic network of nodes.
///
/// Node i and its images stand at `nodes_angstrom[i]` + n · `cell_angstrom`. In two dimensions the
/// first coordinate (x) of everything is zero and the cell has two vectors, in the plane of y and
/// z.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Framework {
    /// Cell vectors, Å: two of (y, z) or three of (x, y, z).
    pub cell_angstrom: Vec<Vec<f64>>,
    /// Extent along x of a two-dimensional network, Å; it makes a volume of the area.
    #[serde(default = "one")]
    pub thickness_angstrom: f64,
    /// Where the nodes are, Å: (y, z) or (x, y, z).
    pub nodes_angstrom: Vec<Vec<f64>>,
    /// Springs between two nodes.
    #[serde(default)]
    pub rods: Vec<Rod>,
    /// Springs between two directions at a node.
    #[serde(default)]
    pub hinges: Vec<Hinge>,
    /// Springs about an axis, in three dimensions.
    #[serde(default)]
    pub torsions: Vec<Torsion>,
}

fn one() -> f64 {
    1.0
}

/// A node or one of its periodic images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Neighbour {
    /// Index of the node.
    pub node: usize,
    /// The image: how many cells away along each cell vector; none is all zero.
    #[serde(default)]
    pub image: Vec<i32>,
}

/// ½ k (|r_j - r_i| - L)².
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// Index of the first node.
    pub from: usize,
    /// The second node or an image of it.
    pub to: Neighbour,
    /// k, kcal/mol/Å².
    pub stiffness_kcal_mol_angstrom2: f64,
    /// L, Å; as built if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_length_angstrom: Option<f64>,
}

/// ½ k (θ - θ0)², θ the angle at the vertex between two neighbours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hinge {
    /// Index of the node at the vertex.
    pub vertex: usize,
    /// The two neighbours.
    pub between: [Neighbour; 2],
    /// k, kcal/mol/rad².
    pub stiffness_kcal_mol_rad2: f64,
    /// θ0, rad; as built if absent. In two dimensions it is taken on the side on which the angle is
    /// built.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_angle_rad: Option<f64>,
}

/// ½ k (φ - φ0)², φ the dihedral angle of four nodes in a row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torsion {
    /// The four nodes.
    pub along: [Neighbour; 4],
    /// k, kcal/mol/rad².
    pub stiffness_kcal_mol_rad2: f64,
    /// φ0, rad; as built if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_angle_rad: Option<f64>,
}

/// A rod, or a cell, shorter or flatter than this (Å) has collapsed.
const SMALLEST_LENGTH_ANGSTROM: f64 = 1e-9;

/// No term reaches over more cells than this; it keeps sums of images from overflowing.
const FARTHEST_IMAGE: u32 = 1_000_000;

impl Neighbour {
    /// A node of the cell itself.
    pub fn here(node: usize) -> Self {
        Self {
            node,
            image: Vec::new(),
        }
    }

    /// A node of another cell.
    pub fn there(node: usize, image: &[i32]) -> Self {
        Self {
            node,
            image: image.to_vec(),
        }
    }
}

impl Framework {
    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        self.cell_angstrom.len()
    }

    /// Number of strain components: 3 (yy, zz, yz) or 6 (xx, yy, zz, yz, xz, xy).
    pub fn strains(&self) -> usize {
        if self.dimension() == 2 { 3 } else { 6 }
    }

    /// Volume of the cell, Å³; in two dimensions its area times the thickness.
    pub fn volume_angstrom3(&self) -> f64 {
        let c = &self.cell_angstrom;
        if self.dimension() == 2 {
            (c[0][0] * c[1][1] - c[0][1] * c[1][0]).abs() * self.thickness_angstrom
        } else {
            let cross = |i: usize, j: usize| c[1][i] * c[2][j] - c[1][j] * c[2][i];
            (c[0][0] * cross(1, 2) + c[0][1] * cross(2, 0) + c[0][2] * cross(0, 1)).abs()
        }
    }

    /// The way from the cell's own image to this one, Å, as (x, y, z) or (y, z, 0).
    pub(crate) fn offset(&self, image: &[i32]) -> [f64; 3] {
        let mut offset = [0.0; 3];
        for (count, vector) in image.iter().zip(&self.cell_angstrom) {
            for (component, x) in vector.iter().enumerate() {
                offset[component] += f64::from(*count) * x;
            }
        }
        offset
    }

    /// Where a node or its image is, Å, as (x, y, z) or (y, z, 0).
    pub(crate) fn place(&self, neighbour: &Neighbour) -> [f64; 3] {
        let mut place = self.offset(&neighbour.image);
        for (component, x) in self.nodes_angstrom[neighbour.node].iter().enumerate() {
            place[component] += x;
        }
        place
    }

    /// From one node or image to another, Å.
    pub(crate) fn difference(&self, from: &Neighbour, to: &Neighbour) -> [f64; 3] {
        let (a, b) = (self.place(from), self.place(to));
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
    }

    /// Checks what the types cannot.
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] says which node, rod, hinge or cell vector makes no sense, and
    /// why.
    pub fn check(&self) -> Result<()> {
        let bad = |problem: String| Err(CrystalError::BadNetwork(problem));
        let dimension = self.dimension();
        if !(2..=3).contains(&dimension) {
            return bad(format!(
                "cell_angstrom has {dimension} vectors; a network has 2 or 3 dimensions"
            ));
        }
        for (what, rows) in [
            ("cell vector", &self.cell_angstrom),
            ("node", &self.nodes_angstrom),
        ] {
            for (index, row) in rows.iter().enumerate() {
                if row.len() != dimension || row.iter().any(|x| !x.is_finite()) {
                    return bad(format!(
                        "{what} {index} is {row:?}; give {dimension} finite numbers, Å"
                    ));
                }
            }
        }
        if self.nodes_angstrom.is_empty() {
            return bad("the network has no nodes".into());
        }
        let thickness = self.thickness_angstrom;
        if !(thickness.is_finite() && thickness > 0.0) {
            return bad(format!(
                "thickness_angstrom is {thickness}; it must be positive"
            ));
        }
        let longest = self
            .cell_angstrom
            .iter()
            .map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt())
            .fold(0.0, f64::max);
        let across = self.volume_angstrom3() / longest.powi(dimension as i32 - 1);
        if across.is_nan() || across < SMALLEST_LENGTH_ANGSTROM {
            return bad(format!(
                "the cell has collapsed: its volume is {:e} Å³",
                self.volume_angstrom3()
            ));
        }
        self.check_terms()
    }

    fn check_terms(&self) -> Result<()> {
        let bad = |problem: String| Err(CrystalError::BadNetwork(problem));
        let mut has_rod = vec![false; self.nodes_angstrom.len()];
        let neighbour = |what: &str, index: usize, neighbour: &Neighbour| {
            if neighbour.node >= self.nodes_angstrom.len() {
                let count = self.nodes_angstrom.len();
                return bad(format!(
                    "{what} {index} names node {}, but there are {count}",
                    neighbour.node
                ));
            }
            if !(neighbour.image.is_empty() || neighbour.image.len() == self.dimension()) {
                let dimension = self.dimension();
                return bad(format!(
                    "{what} {index} has image {:?}; give {dimension} whole numbers",
                    neighbour.image
                ));
            }
            if neighbour
                .image
                .iter()
                .any(|count| count.unsigned_abs() > FARTHEST_IMAGE)
            {
                return bad(format!(
                    "{what} {index} has image {:?}; {FARTHEST_IMAGE} cells is far enough",
                    neighbour.image
                ));
            }
            Ok(())
        };
        let stiffness = |what: &str, index: usize, k: f64| {
            if k.is_finite() && k >= 0.0 {
                Ok(())
            } else {
                bad(format!(
                    "{what} {index} has stiffness {k}; it must be zero or positive"
                ))
            }
        };
        let apart = |what: &str, index: usize, a: &Neighbour, b: &Neighbour| {
            let d = self.difference(a, b);
            if d.iter().map(|x| x * x).sum::<f64>().sqrt() < SMALLEST_LENGTH_ANGSTROM {
                return bad(format!(
                    "{what} {index} joins two places that coincide (nodes {} and {})",
                    a.node, b.node
                ));
            }
            Ok(())
        };
        for (index, rod) in self.rods.iter().enumerate() {
            let from = Neighbour::here(rod.from);
            neighbour("rod", index, &from)?;
            neighbour("rod", index, &rod.to)?;
            stiffness("rod", index, rod.stiffness_kcal_mol_angstrom2)?;
            apart("rod", index, &from, &rod.to)?;
            if let Some(length) = rod
                .rest_length_angstrom
                .filter(|length| !(length.is_finite() && *length > 0.0))
            {
                return bad(format!(
                    "rod {index} has rest length {length} Å; it must be positive"
                ));
            }
            has_rod[rod.from] = true;
            has_rod[rod.to.node] = true;
        }
        for (index, hinge) in self.hinges.iter().enumerate() {
            let vertex = Neighbour::here(hinge.vertex);
            neighbour("hinge", index, &vertex)?;
            for end in &hinge.between {
                neighbour("hinge", index, end)?;
                apart("hinge", index, &vertex, end)?;
            }
            stiffness("hinge", index, hinge.stiffness_kcal_mol_rad2)?;
        }
        if !self.torsions.is_empty() && self.dimension() == 2 {
            return bad("torsions need three dimensions; in the plane they do nothing".into());
        }
        for (index, torsion) in self.torsions.iter().enumerate() {
            for node in &torsion.along {
                neighbour("torsion", index, node)?;
            }
            for pair in torsion.along.windows(2) {
                apart("torsion", index, &pair[0], &pair[1])?;
            }
            stiffness("torsion", index, torsion.stiffness_kcal_mol_rad2)?;
        }
        match has_rod.iter().position(|has| !has) {
            Some(node) => bad(format!(
                "node {node} has no rod: nothing holds it; remove it or join it"
            )),
            None => Ok(()),
        }
    }

    /// The same network with a cell of so many of its cells.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a count of zero, [`CrystalError::BadNetwork`] for one count
    /// too many or too few.
    pub fn supercell(&self, counts: &[usize]) -> Result<Self> {
        let dimension = self.dimension();
        if counts.len() != dimension {
            return Err(CrystalError::BadNetwork(format!(
                "{} cell counts for {dimension} dimensions",
                counts.len()
            )));
        }
        if counts.contains(&0) {
            return Err(CrystalError::BadSetting {
                setting: "cells",
                value: 0.0,
                requirement: "at least 1 in each direction",
            });
        }
        let mut full = [1; 3];
        full[..dimension].copy_from_slice(counts);
        let cells: Vec<[i32; 3]> = (0..full[0] * full[1] * full[2])
            .map(|c| {
                [c / (full[1] * full[2]), c / full[2] % full[1], c % full[2]].map(|x| x as i32)
            })
            .collect();
        let base = self.nodes_angstrom.len();
        let moved = |neighbour: &Neighbour, cell: &[i32; 3]| {
            let (mut index, mut image) = (0, vec![0; dimension]);
            for axis in 0..3 {
                let count = full[axis] as i32;
                let target = cell[axis] + neighbour.image.get(axis).copied().unwrap_or(0);
                index = index * full[axis] + target.rem_euclid(count) as usize;
                if let Some(image) = image.get_mut(axis) {
                    *image = target.div_euclid(count);
                }
            }
            Neighbour {
                node: index * base + neighbour.node,
                image,
            }
        };
        let mut large = Self {
            nodes_angstrom: Vec::new(),
            rods: Vec::new(),
            hinges: Vec::new(),
            torsions: Vec::new(),
            ..self.clone()
        };
        for (vector, count) in large.cell_angstrom.iter_mut().zip(counts) {
            vector.iter_mut().for_each(|x| *x *= *count as f64);
        }
        for (number, cell) in cells.iter().enumerate() {
            let offset = self.offset(&cell[..dimension]);
            for node in &self.nodes_angstrom {
                large
                    .nodes_angstrom
                    .push(node.iter().zip(offset).map(|(x, o)| x + o).collect());
            }
            let own = number * base;
            large.rods.extend(self.rods.iter().map(|rod| Rod {
                from: own + rod.from,
                to: moved(&rod.to, cell),
                ..rod.clone()
            }));
            large.hinges.extend(self.hinges.iter().map(|hinge| Hinge {
                vertex: own + hinge.vertex,
                between: [
                    moved(&hinge.between[0], cell),
                    moved(&hinge.between[1], cell),
                ],
                ..hinge.clone()
            }));
            large
                .torsions
                .extend(self.torsions.iter().map(|torsion| Torsion {
                    along: std::array::from_fn(|i| moved(&torsion.along[i], cell)),
                    ..torsion.clone()
                }));
        }
        Ok(large)
    }
}
