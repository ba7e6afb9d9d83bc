//! The tree of bounding discs over the triangles of a body: eight children per node, stored lane by
//! lane.

use super::disc::{Disc, covariance};
use super::lanes::{DiscBlock, WIDTH};
use crate::{TriangleMesh, Vec3};

/// A node: the discs of up to eight children, which are triangles in a leaf and nodes elsewhere.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub discs: DiscBlock,
    /// Triangle or node behind each lane.
    pub children: [u32; WIDTH],
    pub is_leaf: bool,
    /// The disc around the whole node.
    pub bound: Disc,
}

/// A tree of discs; the root is the last node.
#[derive(Debug, Clone)]
pub(super) struct DiscTree {
    pub nodes: Vec<Node>,
}

impl DiscTree {
    pub fn new(mesh: &TriangleMesh) -> Self {
        // One array of numbers, sorted in place: every node owns a contiguous part of it.
        let mut triangles: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let mut builder = Builder {
            mesh,
            nodes: Vec::new(),
        };
        builder.build(&mut triangles);
        Self {
            nodes: builder.nodes,
        }
    }

    pub fn root(&self) -> u32 {
        self.nodes.len() as u32 - 1
    }
}

struct Builder<'a> {
    mesh: &'a TriangleMesh,
    nodes: Vec<Node>,
}

impl Builder<'_> {
    /// Builds the node of these triangles and everything below it; returns its index.
    fn build(&mut self, triangles: &mut [u32]) -> u32 {
        let is_leaf = triangles.len() <= WIDTH;
        let mut children = [u32::MAX; WIDTH];
        let mut discs = Vec::with_capacity(WIDTH);
        if is_leaf {
            for (child, triangle) in children.iter_mut().zip(&*triangles) {
                *child = *triangle;
                discs.push(Disc::around_triangle(&self.corners(*triangle)));
            }
        } else {
            let parts = self.build_parts(triangles, fan_out(triangles.len()));
            for (child, node) in children.iter_mut().zip(parts) {
                *child = node;
                discs.push(self.nodes[node as usize].bound);
            }
        }
        let mut corners = Vec::with_capacity(triangles.len());
        // Around the triangles themselves, not around the
        // discs of the children, which would be wider.
        for triangle in triangles {
            corners.push(self.corners(*triangle));
        }
        self.nodes.push(Node {
            discs: DiscBlock::from_discs(&discs),
            children,
            is_leaf,
            bound: Disc::around_triangles(&corners),
        });
        self.nodes.len() as u32 - 1
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.mesh.corners(triangle as usize)
    }

    /// Cuts the triangles into compact parts by repeated halving and builds each.
    fn build_parts(&mut self, triangles: &mut [u32], parts: usize) -> Vec<u32> {
        if parts == 1 {
            return vec![self.build(triangles)];
        }
        let axis = self.longest_axis(triangles);
        // The sum of three corners is three times the centre; the factor does not change the order.
        let height = |triangle: u32| self.corners(triangle).iter().sum::<Vec3>().dot(&axis);
        triangles.sort_by(|left, right| height(*left).total_cmp(&height(*right)));
        let left_parts = parts / 2;
        // Whole leaves on the left, so that lanes are not wasted.
        let even_cut = triangles.len() * left_parts / parts;
        // At least one triangle stays on the right: an empty node would have no disc.
        let cut = even_cut.next_multiple_of(WIDTH).min(triangles.len() - 1);
        let (left, right) = triangles.split_at_mut(cut);
        let mut children = self.build_parts(left, left_parts);
        children.extend(self.build_parts(right, parts - left_parts));
        children
    }

    /// The principal axis of the largest spread of the centres of the triangles.
    fn longest_axis(&self, triangles: &[u32]) -> Vec3 {
        let mut centres = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            centres.push(self.corners(*triangle).iter().sum::<Vec3>() / 3.0);
        }
        let eigen = covariance(&centres).symmetric_eigen();
        eigen.eigenvectors.column(eigen.eigenvalues.imax()).into()
    }
}

/// Number of children of a node of this many triangles, chosen so that all levels below it can be
/// full.
fn fan_out(triangles: usize) -> usize {
    // With L leaves and 8ᵏ the largest power of eight below L, ⌈L/8ᵏ⌉ children suffice.
    let leaves = triangles.div_ceil(WIDTH);
    let mut below = 1;
    while below * WIDTH < leaves {
        below *= WIDTH;
    }
    leaves.div_ceil(below)
}
