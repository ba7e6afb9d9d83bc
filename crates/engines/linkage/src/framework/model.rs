//! The network as data.

use serde::{Deserialize, Serialize};

/// A periodic network of nodes.
///
/// Node i and its images stand at `nodes_angstrom[i]` + n · `cell_angstrom`. In two dimensions the
/// first coordinate (x) of everything is zero and the cell has two vectors, in the plane of y and
/// z.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, Framework, Moduli, Neighbour, Rod};
/// let spring = |image: [i32; 2], k: f64| Rod {
///     from: 0,
///     to: Neighbour::in_image(0, &image),
///     stiffness_kcal_mol_angstrom2: k,
///     rest_length_angstrom: None,
/// };
/// // A square net of springs, with springs along its diagonals.
/// let net = Framework {
///     cell_angstrom: vec![vec![2.0, 0.0], vec![0.0, 2.0]],
///     thickness_angstrom: 1.0,
///     nodes_angstrom: vec![vec![0.0, 0.0]],
///     rods: vec![
///         spring([1, 0], 4.0),
///         spring([0, 1], 4.0),
///         spring([1, 1], 1.0),
///         spring([1, -1], 1.0),
///     ],
///     hinges: Vec::new(),
///     torsions: Vec::new(),
/// };
/// let moduli = Moduli::new(&Elasticity::from_framework(&net)?, 1.0);
/// // C11 = k + k', C12 = C33 = k'.
/// assert!((moduli.poissons[0][1].unwrap() - 1.0 / 5.0).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Framework {
    /// Cell vectors, Å: two of (y, z) or three of (x, y, z).
    pub cell_angstrom: Vec<Vec<f64>>,
    /// Extent along x of a two-dimensional network, Å; it makes a volume of the area.
    #[serde(default = "one")]
    pub thickness_angstrom: f64,
    /// Positions of the nodes, Å: (y, z) or (x, y, z).
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
///
/// ```
/// use protomer_linkage::framework::Neighbour;
/// let right = Neighbour::in_image(0, &[1, 0]);
/// assert_eq!((right.node, right.image), (0, vec![1, 0]));
/// assert!(Neighbour::in_own_cell(3).image.is_empty());
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Neighbour {
    /// Index of the node.
    pub node: usize,
    /// The image: how many cells away along each cell vector; empty for the cell itself.
    #[serde(default)]
    pub image: Vec<i32>,
}

/// A spring between two nodes, ½ k (|r_j - r_i| - L)².
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

/// A spring between two directions, ½ k (θ - θ0)², θ the angle at the vertex between two neighbours.
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

/// A spring about an axis, ½ k (φ - φ0)², φ the dihedral angle of four nodes in a row.
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

impl Neighbour {
    /// A node of the cell itself.
    pub fn in_own_cell(node: usize) -> Self {
        Self {
            node,
            image: Vec::new(),
        }
    }

    /// A node of another cell.
    pub fn in_image(node: usize, image: &[i32]) -> Self {
        Self {
            node,
            image: image.to_vec(),
        }
    }
}

impl Framework {
    /// Number of dimensions, 2 or 3.
    pub fn dimension(&self) -> usize {
        self.cell_angstrom.len()
    }

    /// Number of strain components: 3 (yy, zz, yz) or 6 (xx, yy, zz, yz, xz, xy).
    pub fn strains(&self) -> usize {
        if self.dimension() == 2 { 3 } else { 6 }
    }

    /// Volume of the cell, Å³; in two dimensions its area times the thickness.
    ///
    /// ```
    /// use protomer_linkage::framework::build::rotating_squares;
    /// let mut network = rotating_squares(2.0, 0.0, 100.0, 1.0)?;
    /// let volume = network.volume_angstrom3();
    /// network.thickness_angstrom *= 3.0;
    /// assert_eq!((network.volume_angstrom3() / volume, network.strains()), (3.0, 3));
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn volume_angstrom3(&self) -> f64 {
        let c = &self.cell_angstrom;
        if self.dimension() == 2 {
            (c[0][0] * c[1][1] - c[0][1] * c[1][0]).abs() * self.thickness_angstrom
        } else {
            let [x, y, z] =
                [(1, 2), (2, 0), (0, 1)].map(|(i, j)| c[1][i] * c[2][j] - c[1][j] * c[2][i]);
            (c[0][0] * x + c[0][1] * y + c[0][2] * z).abs()
        }
    }

    /// Vector from the cell itself to this image of it, Å, as (x, y, z) or (y, z, 0).
    pub(crate) fn offset(&self, image: &[i32]) -> [f64; 3] {
        let mut offset = [0.0; 3];
        for (count, vector) in image.iter().zip(&self.cell_angstrom) {
            for (component, x) in vector.iter().enumerate() {
                offset[component] += f64::from(*count) * x;
            }
        }
        offset
    }

    /// Position of a node or its image, Å, as (x, y, z) or (y, z, 0).
    pub(crate) fn place(&self, neighbour: &Neighbour) -> [f64; 3] {
        let mut place = self.offset(&neighbour.image);
        for (component, x) in self.nodes_angstrom[neighbour.node].iter().enumerate() {
            place[component] += x;
        }
        place
    }

    /// Vector from one node or image to another, Å.
    pub(crate) fn difference(&self, from: &Neighbour, to: &Neighbour) -> [f64; 3] {
        let (a, b) = (self.place(from), self.place(to));
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
    }
}
