//! The part of a body's surface that each residue has.

use protomer_body::Body;
use protomer_mc::contributions::ResiduePlaces;

/// A residue with less surface is buried in its own body, Å².
const LEAST_AREA_ANGSTROM2: f64 = 10.0;

/// Whether a residue with this much surface is buried in its own body: hardly any water reaches it, with
/// or without a partner.
pub fn is_buried(area_angstrom2: f64) -> bool {
    area_angstrom2 < LEAST_AREA_ANGSTROM2
}

/// The area of each residue's part of the surface, Å²: a point of the mesh belongs to the residue of
/// the nearest atom.
pub fn areas_angstrom2(body: &Body) -> Vec<f64> {
    let places = ResiduePlaces::from_body(body);
    let mut areas = vec![0.0; body.residues.len()];
    let vertices = &body.mesh.vertices;
    let per_vertex = body.mesh.area_angstrom2() / vertices.len().max(1) as f64;
    for vertex in vertices {
        if let Some(residue) = places.nearest(vertex) {
            areas[residue] += per_vertex;
        }
    }
    areas
}
