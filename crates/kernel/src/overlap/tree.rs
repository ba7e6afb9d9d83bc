//! The tree of bounding discs over the triangles of a body: eight children per node, stored lane by
//! lane.

use super::disc::Disc;
use super::lanes::{DiscBlock, WIDTH};
use crate::{TriangleMesh, Vec3};

/// A node: the discs of up to eight children, which are triangles in a leaf and nodes above.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub discs: DiscBlock,
    /// Triangle or node behind each lane.
    pub children: [u32; WIDTH],
    pub is_leaf: bool,
    /// The disc around all of it.
    pub bound: Disc,
}

/// A tree of discs; the root is the last node.
#[derive(Debug, Clone)]
pub(super) struct DiscTree {
    pub nodes: Vec<Node>,
}

impl DiscTree {
    pub fn new(mesh: &TriangleMesh) -> Self {
        let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len())
            .map(|triangle| mesh.corners(triangle))
            .collect();
        let mut builder = Builder {
            corners,
            nodes: Vec::new(),
        };
        let mut triangles: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        builder.build(&mut triangles);
        Self {
            nodes: builder.nodes,
        }
    }

    pub fn root(&self) -> u32 {
        self.nodes.len() as u32 - 1
    }
}

struct Builder {
    corners: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
}

impl Builder {
    /// Builds the node of these triangles and everything below it; returns its index.
    fn build(&mut self, triangles: &mut [u32]) -> u32 {
        let is_leaf = triangles.len() <= WIDTH;
        let (children, discs): (Vec<u32>, Vec<Disc>) = if is_leaf {
            triangles
                .iter()
                .map(|&t| (t, Disc::around_triangle(&self.corners[t as usize])))
                .unzip()
        } else {
            let parts = fan_out(triangles.len());
            let children = self.build_parts(triangles, parts);
            children
                .into_iter()
                .map(|node| (node, self.nodes[node as usize].bound))
                .unzip()
        };
        let corners: Vec<[Vec3; 3]> = triangles
            .iter()
            .map(|&t| self.corners[t as usize])
            .collect();
        self.nodes.push(Node {
            discs: DiscBlock::of(&discs),
            children: std::array::from_fn(|lane| children.get(lane).copied().unwrap_or(u32::MAX)),
            is_leaf,
            bound: Disc::around_triangles(&corners),
        });
        self.nodes.len() as u32 - 1
    }

    /// Cuts the triangles into compact parts by repeated halving and builds each.
    fn build_parts(&mut self, triangles: &mut [u32], parts: usize) -> Vec<u32> {
        if parts == 1 {
            return vec![self.build(triangles)];
        }
        let axis = self.longest_axis(triangles);
        let height = |&t: &u32| self.corners[t as usize].iter().sum::<Vec3>().dot(&axis);
        triangles.sort_by(|left, right| height(left).total_cmp(&height(right)));
        let left_parts = parts / 2;
        // Whole leaves on the left, so that lanes are not wasted.
        let cut = (triangles.len() * left_parts / parts)
            .next_multiple_of(WIDTH)
            .min(triangles.len() - 1);
        let (left, right) = triangles.split_at_mut(cut);
        let mut children = self.build_parts(left, left_parts);
        children.extend(self.build_parts(right, parts - left_parts));
        children
    }

    /// The principal axis of the largest spread of the triangles' centres.
    fn longest_axis(&self, triangles: &[u32]) -> Vec3 {
        let centres: Vec<Vec3> = triangles
            .iter()
            .map(|&t| self.corners[t as usize].iter().sum::<Vec3>() / 3.0)
            .collect();
        let mean = centres.iter().sum::<Vec3>() / centres.len() as f64;
        let spread: nalgebra::Matrix3<f64> = centres
            .iter()
            .map(|c| (c - mean) * (c - mean).transpose())
            .sum();
        let eigen = spread.symmetric_eigen();
        eigen.eigenvectors.column(eigen.eigenvalues.imax()).into()
    }
}

/// How many children a node of this many triangles gets so that all levels below it can be full.
fn fan_out(triangles: usize) -> usize {
    let leaves = triangles.div_ceil(WIDTH);
    let mut below = 1;
    while below * WIDTH < leaves {
        below *= WIDTH;
    }
    leaves.div_ceil(below)
}
