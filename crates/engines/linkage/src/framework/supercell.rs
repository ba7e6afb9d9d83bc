//! The same network with a larger cell.

use super::model::{Framework, Hinge, Neighbour, Rod, Torsion};
use crate::error::{CrystalError, Result, require};

impl Framework {
    /// The same network with a cell of so many of its cells along each cell vector.
    ///
    /// ```
    /// use protomer_linkage::framework::build::face_centred_cubic;
    /// let net = face_centred_cubic(3.0, 7.0)?;
    /// let large = net.supercell(&[2, 1, 3])?;
    /// assert_eq!(large.nodes_angstrom.len(), 6 * net.nodes_angstrom.len());
    /// assert_eq!(large.cell_angstrom[2], [0.0, 0.0, 9.0]);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
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
        let has_cells = !counts.contains(&0);
        require("cells", 0.0, has_cells, "at least 1 in each direction")?;
        let copies = Copies::new(counts, self.nodes_angstrom.len());
        let mut large = Self {
            nodes_angstrom: Vec::new(),
            rods: Vec::new(),
            hinges: Vec::new(),
            torsions: Vec::new(),
            ..self.clone()
        };
        for (vector, count) in large.cell_angstrom.iter_mut().zip(counts) {
            for x in vector {
                *x *= *count as f64;
            }
        }
        // Copies in order, the last axis fastest; nodes of copy n begin at n · nodes per cell.
        for number in 0..copies.count() {
            self.copy_into(&mut large, &copies, number);
        }
        Ok(large)
    }

    /// Adds the nodes and terms of one copy of the cell.
    fn copy_into(&self, large: &mut Self, copies: &Copies, number: usize) {
        let cell = copies.cell(number);
        let offset = self.offset(&cell[..self.dimension()]);
        for node in &self.nodes_angstrom {
            let place = node.iter().zip(offset).map(|(x, o)| x + o);
            large.nodes_angstrom.push(place.collect());
        }
        for rod in &self.rods {
            large.rods.push(Rod {
                from: copies.node(number, rod.from),
                to: copies.neighbour(&rod.to, cell),
                ..rod.clone()
            });
        }
        for hinge in &self.hinges {
            large.hinges.push(Hinge {
                vertex: copies.node(number, hinge.vertex),
                between: hinge
                    .between
                    .each_ref()
                    .map(|end| copies.neighbour(end, cell)),
                ..hinge.clone()
            });
        }
        for torsion in &self.torsions {
            large.torsions.push(Torsion {
                along: torsion
                    .along
                    .each_ref()
                    .map(|end| copies.neighbour(end, cell)),
                ..torsion.clone()
            });
        }
    }
}

/// The copies of a cell in a supercell, the last axis fastest.
struct Copies {
    dimension: usize,
    /// Copies along each axis; 1 along axes beyond the dimension.
    counts: [usize; 3],
    nodes_per_cell: usize,
}

impl Copies {
    fn new(counts: &[usize], nodes_per_cell: usize) -> Self {
        let mut full = [1; 3];
        full[..counts.len()].copy_from_slice(counts);
        Self {
            dimension: counts.len(),
            counts: full,
            nodes_per_cell,
        }
    }

    fn count(&self) -> usize {
        self.counts.iter().product()
    }

    /// The place of a copy, in cells along each axis.
    fn cell(&self, number: usize) -> [i32; 3] {
        let [_, second, third] = self.counts;
        [
            number / (second * third),
            number / third % second,
            number % third,
        ]
        .map(|cells| cells as i32)
    }

    /// A node of a copy.
    fn node(&self, number: usize, node: usize) -> usize {
        number * self.nodes_per_cell + node
    }

    /// A neighbour as seen from this copy.
    fn neighbour(&self, neighbour: &Neighbour, cell: [i32; 3]) -> Neighbour {
        let (mut number, mut image) = (0, vec![0; self.dimension]);
        for axis in 0..3 {
            let count = self.counts[axis] as i32;
            let target = cell[axis] + neighbour.image.get(axis).copied().unwrap_or(0);
            // Inside the supercell by the remainder, its image by the quotient.
            number = number * self.counts[axis] + target.rem_euclid(count) as usize;
            if axis < self.dimension {
                image[axis] = target.div_euclid(count);
            }
        }
        Neighbour {
            node: self.node(number, neighbour.node),
            image,
        }
    }
}
