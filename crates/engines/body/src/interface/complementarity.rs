//! Fit of two surfaces, by the statistic of Lawrence and Colman (J. Mol. Biol. 234, 946 (1993)).
//!
//! ```text
//! S(1→2) = median over x of (n · n') exp(-w d²),    Sc = (S(1→2) + S(2→1)) / 2,    w = 0.5 Å⁻²
//! ```
//!
//! x is a point of the buried part of the first molecular surface, n its outward normal, d the distance to the nearest
//! point of the buried part of the second surface, and n' the inward normal there. A point is buried if a probe that
//! touches the surface in it would enter the partner. A band of 1.5 Å along the edge of the buried part is left out.
//! Instead of dots of equal density the points are the triangles of a mesh, by their areas, and the nearest point lies
//! anywhere on the triangles of the partner. Atoms have united-atom radii as in the paper; with the smaller radii of the
//! bodies' own surfaces a gap would open between atoms in contact.

use super::Partner;
use super::partner::Neighbourhood;
use crate::Result;
use crate::chemistry::radii::united_atom_radius_angstrom;
use crate::chemistry::residue_names::parent_amino_acid;
use crate::surface::{ExactSurface, MeshSettings};
use protomer_kernel::{TriangleMesh, Vec3};

/// Atoms within this of the partner make the surfaces, Å: a buried point has its own atoms and the partner's
/// within some 6 Å.
const NEAR_ANGSTROM: f64 = 12.0;
/// Vertices of the meshes, Å⁻². With 8 instead of 4, Sc changes by at most 0.01.
const DENSITY_PER_ANGSTROM2: f64 = 4.0;

/// Decay w of the fit with the square of the distance, Å⁻².
const DECAY_PER_ANGSTROM2: f64 = 0.5;
/// Width of the edge that is left out, Å.
const EDGE_ANGSTROM: f64 = 1.5;
/// Points farther apart than this have no fit, Å: exp(-w d²) is below 4e-6 there.
const FARTHEST_ANGSTROM: f64 = 5.0;

/// A triangle of a molecular surface.
#[derive(Debug, Clone, Copy)]
struct Facet {
    corners: [Vec3; 3],
    centre: Vec3,
    /// Outward, of unit length.
    normal: Vec3,
    area_angstrom2: f64,
}

/// The shape complementarity Sc of two bodies, between -1 and 1; `None` for bodies without a buried surface.
///
/// # Errors
/// As [`ExactSurface::mesh`].
///
/// ```
/// use protomer_body::interface::{Partner, shape_complementarity};
/// # use protomer_body::{Source, SurfaceSettings, build_body_of_points};
/// # use protomer_kernel::{PointRecord, Vec3};
/// # let ball = PointRecord { radius_angstrom: 6.0, ..PointRecord::default() };
/// # let source = Source { file: "ball.xyzr", sha256: "" };
/// # let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
/// let place = |x| Partner { body: &body, origin_angstrom: Vec3::new(x, 0.0, 0.0) };
/// assert!(shape_complementarity([place(0.0), place(11.0)], 1.4)?.is_some());
/// assert!(shape_complementarity([place(0.0), place(30.0)], 1.4)?.is_none());
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn shape_complementarity(
    partners: [Partner<'_>; 2],
    probe_radius_angstrom: f64,
) -> Result<Option<f64>> {
    let atoms = partners.map(|partner| united_atoms(&partner));
    let near = [near(&atoms[0], &atoms[1]), near(&atoms[1], &atoms[0])];
    if near.iter().any(Vec::is_empty) {
        return Ok(None);
    }
    let mut buried = Vec::new();
    for (own, other) in [(0, 1), (1, 0)] {
        let mesh = surface(&near[own], probe_radius_angstrom)?;
        buried.push(buried_facets(&mesh, &near[other], probe_radius_angstrom));
    }
    let sides = [fit(&buried[0], &buried[1]), fit(&buried[1], &buried[0])];
    Ok(match sides {
        [Some(first), Some(second)] => Some((first + second) / 2.0),
        _ => None,
    })
}

/// An atom as a ball.
#[derive(Debug, Clone, Copy)]
struct BallAtom {
    centre: Vec3,
    radius_angstrom: f64,
}

/// The heavy atoms with the radii of united atoms, those of the body for atoms of other residues.
fn united_atoms(partner: &Partner<'_>) -> Vec<BallAtom> {
    let radius = |site: &crate::Site| {
        let residue = &partner.body.residues[site.residue? as usize];
        united_atom_radius_angstrom(parent_amino_acid(&residue.name)?, &site.atom_name)
    };
    let atoms = partner.heavy_atoms().into_iter();
    atoms
        .map(|atom| BallAtom {
            centre: atom.position,
            radius_angstrom: radius(atom.site).unwrap_or(atom.site.radius_angstrom),
        })
        .collect()
}

/// Atoms that are near to the partner.
fn near(atoms: &[BallAtom], partner: &[BallAtom]) -> Vec<BallAtom> {
    let centres = partner.iter().map(|atom| atom.centre).collect();
    let neighbourhood = Neighbourhood::new(centres, NEAR_ANGSTROM);
    let mut found = Vec::new();
    let mut is_near = |atom: &&BallAtom| {
        neighbourhood.within(&atom.centre, &mut found);
        !found.is_empty()
    };
    atoms.iter().filter(|atom| is_near(atom)).copied().collect()
}

fn surface(atoms: &[BallAtom], probe_radius_angstrom: f64) -> Result<TriangleMesh> {
    let centres: Vec<Vec3> = atoms.iter().map(|atom| atom.centre).collect();
    let radii: Vec<f64> = atoms.iter().map(|atom| atom.radius_angstrom).collect();
    let settings = MeshSettings {
        density_per_angstrom2: DENSITY_PER_ANGSTROM2,
        ..MeshSettings::default()
    };
    let exact = ExactSurface::new(&centres, &radii, probe_radius_angstrom)?;
    Ok(exact.mesh(&settings, None)?.mesh)
}

/// Triangles of a surface that a partner buries, without those near the edge.
fn buried_facets(mesh: &TriangleMesh, partner: &[BallAtom], probe_angstrom: f64) -> Vec<Facet> {
    let reach = |atom: &BallAtom| atom.radius_angstrom + probe_angstrom;
    let largest = partner.iter().map(reach).fold(0.0, f64::max);
    let centres = partner.iter().map(|atom| atom.centre).collect();
    let neighbourhood = Neighbourhood::new(centres, largest);
    let mut found = Vec::new();
    let (mut buried, mut free) = (Vec::new(), Vec::new());
    for facet in facets(mesh) {
        let probe = facet.centre + probe_angstrom * facet.normal;
        neighbourhood.within(&probe, &mut found);
        let mut atoms = found.iter().map(|index| &partner[*index]);
        match atoms.any(|atom| (atom.centre - probe).norm() < reach(atom)) {
            true => buried.push(facet),
            false => free.push(facet.centre),
        }
    }
    let free = Neighbourhood::new(free, EDGE_ANGSTROM);
    buried.retain(|facet| {
        free.within(&facet.centre, &mut found);
        found.is_empty()
    });
    buried
}

fn facets(mesh: &TriangleMesh) -> Vec<Facet> {
    let mut facets = Vec::with_capacity(mesh.triangles.len());
    for triangle in 0..mesh.triangles.len() {
        let corners = mesh.corners(triangle);
        let [a, b, c] = corners;
        let doubled = (b - a).cross(&(c - a));
        let length = doubled.norm();
        if length > 0.0 {
            facets.push(Facet {
                corners,
                centre: (a + b + c) / 3.0,
                normal: doubled / length,
                area_angstrom2: 0.5 * length,
            });
        }
    }
    facets
}

/// Median fit of the points of one surface to another, by area; `None` without points.
fn fit(points: &[Facet], surface: &[Facet]) -> Option<f64> {
    if surface.is_empty() {
        return None;
    }
    let centres = surface.iter().map(|facet| facet.centre).collect();
    let neighbourhood = Neighbourhood::new(centres, FARTHEST_ANGSTROM);
    let mut near = Vec::new();
    let mut fits = Vec::with_capacity(points.len());
    for point in points {
        neighbourhood.within(&point.centre, &mut near);
        let (mut nearest, mut value) = (f64::INFINITY, 0.0);
        for index in &near {
            let facet = &surface[*index];
            let square =
                (nearest_point(&facet.corners, &point.centre) - point.centre).norm_squared();
            if square < nearest {
                nearest = square;
                value = -point.normal.dot(&facet.normal) * (-DECAY_PER_ANGSTROM2 * square).exp();
            }
        }
        fits.push((value, point.area_angstrom2));
    }
    weighted_median(fits)
}

fn weighted_median(mut values: Vec<(f64, f64)>) -> Option<f64> {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = values.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
    let mut passed = 0.0;
    for (value, weight) in values {
        passed += weight;
        if passed >= half {
            return Some(value);
        }
    }
    None
}

/// The point of a triangle that is nearest to another point: inside by its plane, else on the nearest edge.
fn nearest_point([a, b, c]: &[Vec3; 3], point: &Vec3) -> Vec3 {
    let normal = (b - a).cross(&(c - a));
    let inside = |from: &Vec3, to: &Vec3| (to - from).cross(&(point - from)).dot(&normal) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        let above = (point - a).dot(&normal) / normal.norm_squared();
        return point - above * normal;
    }
    let on_edge = |from: &Vec3, to: &Vec3| {
        let along = to - from;
        let share = (point - from).dot(&along) / along.norm_squared();
        from + share.clamp(0.0, 1.0) * along
    };
    let mut nearest = on_edge(a, b);
    for other in [on_edge(b, c), on_edge(c, a)] {
        if (other - point).norm_squared() < (nearest - point).norm_squared() {
            nearest = other;
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle_is_that_of_a_fine_search() {
        let triangle = [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(2.0, 0.0, 0.5),
            Vec3::new(0.3, 1.5, -0.2),
        ];
        let [a, b, c] = triangle;
        let mut points = Vec::new();
        for i in 0..5 {
            for j in 0..5 {
                points.push(Vec3::new(f64::from(i) - 1.5, f64::from(j) - 1.5, 0.7));
            }
        }
        for point in points {
            let mut searched = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=(200 - i) {
                    let (u, v) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                    let place = a + u * (b - a) + v * (c - a);
                    searched = searched.min((place - point).norm());
                }
            }
            let found = (nearest_point(&triangle, &point) - point).norm();
            assert!(
                found <= searched + 1e-12 && found > searched - 1e-3,
                "{found} {searched}"
            );
        }
    }

    /// Two flat plates face to face: n · n' = 1, and the fit is exp(-w d²).
    #[test]
    fn the_fit_of_parallel_plates_is_that_of_their_distance() {
        let plate = |height: f64, up: bool| {
            let mut facets = Vec::new();
            for i in 0..6 {
                for j in 0..6 {
                    let corner = |x: i32, y: i32| Vec3::new(f64::from(x), f64::from(y), height);
                    for corners in [
                        [corner(i, j), corner(i + 1, j), corner(i, j + 1)],
                        [corner(i + 1, j + 1), corner(i, j + 1), corner(i + 1, j)],
                    ] {
                        facets.push(Facet {
                            corners,
                            centre: (corners[0] + corners[1] + corners[2]) / 3.0,
                            normal: Vec3::new(0.0, 0.0, if up { 1.0 } else { -1.0 }),
                            area_angstrom2: 0.5,
                        });
                    }
                }
            }
            facets
        };
        for distance in [0.0, 0.5, 1.3] {
            let value = fit(&plate(0.0, true), &plate(distance, false));
            let expected = (-0.5 * distance * distance).exp();
            assert!(value.is_some_and(|value| (value - expected).abs() < 1e-12));
        }
        assert_eq!(fit(&plate(0.0, true), &[]), None);
        assert_eq!(fit(&[], &plate(0.0, true)), None);
    }

    #[test]
    fn the_median_counts_areas() {
        let values = vec![(3.0, 1.0), (1.0, 5.0), (2.0, 1.0)];
        assert_eq!(weighted_median(values), Some(1.0));
        assert_eq!(weighted_median(Vec::new()), None);
    }
}
