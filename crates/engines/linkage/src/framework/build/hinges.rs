//! Which rods a hinge joins.

use crate::framework::model::{Framework, Hinge, Neighbour, Rod};

/// A hinge that is at rest as built.
pub(in crate::framework) fn hinge(
    vertex: usize,
    between: [Neighbour; 2],
    stiffness_kcal_mol_rad2: f64,
) -> Hinge {
    Hinge {
        vertex,
        between,
        stiffness_kcal_mol_rad2,
        rest_angle_rad: None,
    }
}

/// The other ends of the rods at a node, in the order of the rods.
pub(in crate::framework) fn rods_at(rods: &[Rod], vertex: usize) -> Vec<Neighbour> {
    let mut ends = Vec::new();
    for rod in rods {
        if rod.from == vertex {
            ends.push(rod.to.clone());
        }
        if rod.to.node == vertex {
            ends.push(Neighbour {
                node: rod.from,
                image: rod.to.image.iter().map(|cells| -cells).collect(),
            });
        }
    }
    ends
}

/// The angle in the plane under which a node sees a neighbour.
pub(super) fn bearing(framework: &Framework, vertex: usize, end: &Neighbour) -> f64 {
    let d = framework.difference(&Neighbour::in_own_cell(vertex), end);
    d[1].atan2(d[0])
}

/// Adds a hinge between any two rods that follow each other around a node.
pub(super) fn hinge_neighbouring_rods(framework: &mut Framework, kh: f64) {
    if kh == 0.0 {
        return;
    }
    for vertex in 0..framework.nodes_angstrom.len() {
        let mut around = rods_at(&framework.rods, vertex);
        around.sort_by(|a, b| {
            let (a, b) = (bearing(framework, vertex, a), bearing(framework, vertex, b));
            a.total_cmp(&b)
        });
        let count = around.len();
        // Two rods follow each other on either side, and need one hinge.
        for i in 0..if count == 2 { 1 } else { count } {
            let between = [around[i].clone(), around[(i + 1) % count].clone()];
            framework.hinges.push(hinge(vertex, between, kh));
        }
    }
}

/// Adds a hinge between every two rods that meet at a node.
pub(super) fn hinge_all_rods(framework: &mut Framework, kh: f64) {
    if kh == 0.0 {
        return;
    }
    for vertex in 0..framework.nodes_angstrom.len() {
        let around = rods_at(&framework.rods, vertex);
        for (index, first) in around.iter().enumerate() {
            for second in &around[index + 1..] {
                let between = [first.clone(), second.clone()];
                framework.hinges.push(hinge(vertex, between, kh));
            }
        }
    }
}
