//! One pass of each remeshing operation, with the geometric guards that keep triangles from folding
//! over.

use super::half_edge::HalfEdgeMesh;
use crate::surface::implicit::ImplicitSolid;
use protomer_kernel::Vec3;

/// Length in target lengths above which an edge is split.
const LONG: f64 = 4.0 / 3.0;
/// Length in target lengths below which an edge is collapsed.
const SHORT: f64 = 4.0 / 5.0;
/// Cosine of the largest angle by which one operation may turn a triangle.
const LARGEST_TURN: f64 = 0.49;
/// Least quality of triangles after a change, unless they are better than before.
const LEAST_QUALITY: f64 = 0.2;
/// Factor by which a quality must grow to be better: more than rounding, so that equal choices are
/// made equally in every orientation of the body.
const BETTER: f64 = 1.0 + 1e-9;
/// An edge is not split where an apex is closer to its middle than this fraction of its length; not
/// 1/4, at which halved edges tie.
const CROWDED: f64 = 0.27;
/// Quality below which the direction of a triangle means nothing.
const DEGENERATE: f64 = 0.02;
/// No triangle may shrink below this area, Å², or [`SMALLEST_SHARE`] if that is less: a shell
/// around a cavity that is next to nothing keeps a size.
const SMALLEST_AREA: f64 = 5e-5;
/// The same limit as a share of the area of a vertex.
const SMALLEST_SHARE: f64 = 0.02;
/// Largest number of passes of splitting, each of which halves edges: so many shorten them a
/// thousandfold.
const SPLIT_PASSES: usize = 10;
/// Number of half-edges per split above which splitting ends; the rest can wait for the next round.
const FEW: u32 = 200;

/// [`Pull::flatness`] above which the triangles at a vertex are nearly in a plane.
const FLAT: f64 = 0.85;

/// Target onto which relaxed vertices are moved.
#[derive(Debug, Clone, Copy)]
pub(super) enum Onto {
    /// The mean plane of the triangles around them where these are nearly in a plane, without asking
    /// for the surface; elsewhere as [`Self::About`].
    PlaneWhereFlat,
    /// The surface, as far as one step takes them.
    About,
    /// The surface.
    Exactly,
}

/// A mesh on its way to a density.
pub(super) struct Remesher<'a> {
    pub(super) mesh: HalfEdgeMesh,
    solid: &'a dyn ImplicitSolid,
    /// Requested vertices per Å².
    pub(super) density: f64,
    /// Vertices that every shell gets at least.
    pub(super) fewest_vertices: usize,
    /// Target edge length of each shell, Å.
    pub(super) length: Vec<f64>,
    /// Factor of the target edge length at each vertex, about 1: shorter where the surface bends
    /// more.
    pub(super) grade: Vec<f64>,
    /// Outward unit normal of the surface at each vertex, zero where not known yet.
    pub(super) normal: Vec<Vec3>,
}

impl<'a> Remesher<'a> {
    pub(super) fn new(
        mesh: HalfEdgeMesh,
        solid: &'a dyn ImplicitSolid,
        density: f64,
        fewest_vertices: usize,
    ) -> Self {
        let vertices = mesh.positions.len();
        let (grade, normal) = (vec![1.0; vertices], vec![Vec3::zeros(); vertices]);
        let mut remesher = Self {
            mesh,
            solid,
            density,
            fewest_vertices,
            length: Vec::new(),
            grade,
            normal,
        };
        remesher.set_lengths();
        remesher
    }

    pub(super) fn into_mesh(self) -> HalfEdgeMesh {
        self.mesh
    }

    /// Splits edges that are too long, in passes, until there are next to none.
    pub(super) fn split_long_edges(&mut self) {
        for _ in 0..SPLIT_PASSES {
            let mut splits = 0;
            // Half-edges that a split adds lie behind the bound and wait for the next pass.
            for half_edge in 0..self.mesh.half_edge_bound() {
                if self.mesh.is_edge(half_edge) && self.try_split(half_edge) {
                    splits += 1;
                }
            }
            if splits == 0 {
                break;
            }
            // A split leaves vertices of valence 4, which a
            // flip turns into better ones before the next.
            self.flip_towards_six();
            if splits * FEW < self.mesh.half_edge_bound() {
                break;
            }
        }
    }

    /// Splits an edge in the middle if it is too long. Where an apex is close to the middle a flip
    /// is due, not one more vertex next to the apex.
    fn try_split(&mut self, half_edge: u32) -> bool {
        let longest = LONG * self.target_length(half_edge);
        let square = self.mesh.length_squared(half_edge);
        if square <= longest * longest {
            return false;
        }
        let (a, b) = self.mesh.ends(half_edge);
        let middle = 0.5 * (self.mesh.position(a) + self.mesh.position(b));
        for side in [half_edge, self.mesh.twin(half_edge)] {
            let apex = self.mesh.position(self.mesh.apex(side));
            if (apex - middle).norm_squared() < CROWDED * CROWDED * square {
                return false;
            }
        }
        self.mesh.split(half_edge, middle);
        let (a, b) = (a as usize, b as usize);
        // What is known at both ends carries over; the next round corrects it.
        self.grade.push(0.5 * (self.grade[a] + self.grade[b]));
        self.normal.push(0.5 * (self.normal[a] + self.normal[b]));
        true
    }

    /// Collapses edges that are too short.
    pub(super) fn collapse_short_edges(&mut self) {
        for half_edge in 0..self.mesh.half_edge_bound() {
            if !self.mesh.is_edge(half_edge) {
                continue;
            }
            let target = self.target_length(half_edge);
            let shortest = SHORT * target;
            if self.mesh.length_squared(half_edge) < shortest * shortest {
                self.try_collapse(half_edge, LONG * target);
            }
        }
    }

    /// Collapses an edge into one of its ends, if that neither changes the topology nor turns a
    /// triangle over nor makes an edge longer than `longest`.
    fn try_collapse(&mut self, half_edge: u32, longest: f64) -> bool {
        // Into either end: often only one keeps the other triangles in shape.
        for candidate in [half_edge, self.mesh.twin(half_edge)] {
            // The geometric test first; the topological one marks a neighbourhood.
            if self.keeps_shape(candidate, longest) && self.mesh.can_collapse(candidate) {
                self.mesh.collapse(candidate);
                return true;
            }
        }
        false
    }

    /// Whether moving the end of a half-edge onto its start leaves the other triangles there in
    /// shape.
    fn keeps_shape(&self, half_edge: u32, longest: f64) -> bool {
        let (a, b) = self.mesh.ends(half_edge);
        let twin = self.mesh.twin(half_edge);
        let (target, moved) = (self.mesh.position(a), self.mesh.position(b));
        self.mesh.leaving(b).all(|spoke| {
            if spoke / 3 == half_edge / 3 || spoke / 3 == twin / 3 {
                return true; // one of the two triangles that vanish
            }
            let p = self.mesh.position(self.mesh.ends(spoke).1);
            if (p - target).norm_squared() > longest * longest {
                return false;
            }
            let q = self.mesh.position(self.mesh.apex(spoke));
            let before = (p - moved).cross(&(q - moved));
            let after = (p - target).cross(&(q - target));
            // A triangle that was degenerate has no direction that could turn.
            (is_small_turn(&before, &after) || quality(&[moved, p, q]) < DEGENERATE)
                && acceptable(&[target, p, q], &[moved, p, q])
        })
    }

    /// Flips edges where that brings the four vertices concerned closer to six neighbours.
    pub(super) fn flip_towards_six(&mut self) {
        self.flip_where(|mesh, half_edge| {
            let (a, b) = mesh.ends(half_edge);
            let (c, d) = (mesh.apex(half_edge), mesh.apex(mesh.twin(half_edge)));
            let (mut before, mut after) = (0, 0);
            // A flip takes an edge from a and b and gives one to c and d.
            for (vertex, change) in [(a, -1), (b, -1), (c, 1), (d, 1)] {
                let excess = i64::from(mesh.valence(vertex)) - 6;
                before += excess.pow(2);
                after += (excess + change).pow(2);
            }
            after < before
        });
    }

    /// Flips edges where that makes the worse of the two triangles next to them better (Delaunay,
    /// on a flat surface).
    pub(super) fn flip_towards_equal_angles(&mut self) {
        self.flip_where(|mesh, half_edge| {
            let [a, b, c, d] = quadrangle(mesh, half_edge);
            quality_squared(&[c, a, d]).min(quality_squared(&[d, b, c]))
                // More than 5 % better, so that a pair does not flip back and forth.
                > 1.05 * 1.05 * quality_squared(&[a, b, c]).min(quality_squared(&[b, a, d]))
        });
    }

    fn flip_where(&mut self, wanted: impl Fn(&HalfEdgeMesh, u32) -> bool) {
        for half_edge in 0..self.mesh.half_edge_bound() {
            // The cheap tests first: most edges are not wanted.
            if self.mesh.is_edge(half_edge)
                && wanted(&self.mesh, half_edge)
                && self.flip_keeps_shape(half_edge)
                && self.mesh.can_flip(half_edge)
            {
                self.mesh.flip(half_edge);
            }
        }
    }

    /// Whether the two triangles after a flip face the way the two before do, and are in shape.
    fn flip_keeps_shape(&self, half_edge: u32) -> bool {
        let [a, b, c, d] = quadrangle(&self.mesh, half_edge);
        let before = (b - a).cross(&(c - a)) + (a - b).cross(&(d - b));
        let after = [[c, a, d], [d, b, c]];
        let old = quality(&[a, b, c]).min(quality(&[b, a, d]));
        after.iter().all(|[p, q, r]| {
            let shape = quality(&[*p, *q, *r]);
            is_small_turn(&before, &(q - p).cross(&(r - p)))
                && (shape > LEAST_QUALITY || shape > old * BETTER)
        })
    }

    /// Moves every vertex towards the area-weighted centre of its neighbourhood, and onto the
    /// surface.
    pub(super) fn relax(&mut self, onto: Onto) {
        let mut ring = Vec::new();
        for vertex in 0..self.mesh.positions.len() as u32 {
            ring.clear();
            for spoke in self.mesh.leaving(vertex) {
                ring.push(self.mesh.position(self.mesh.ends(spoke).1));
            }
            if let Some(pull) = Pull::from_ring(&self.mesh.position(vertex), &ring) {
                self.move_along_surface(vertex, &pull, onto, &ring);
            }
        }
    }

    /// Moves a vertex by a pull, or half of it, or none, and onto the surface: as far as the triangles
    /// at it stay in shape. `ring` are its neighbours.
    fn move_along_surface(&mut self, vertex: u32, pull: &Pull, onto: Onto, ring: &[Vec3]) {
        let position = self.mesh.position(vertex);
        let reach = self.length[self.mesh.shell[vertex as usize] as usize];
        // 0 puts the vertex back on the surface where it stands, if its pull leads nowhere.
        for fraction in [1.0, 0.5, 0.0] {
            let place = position + pull.displacement * fraction;
            let (projected, normal) = match onto {
                Onto::PlaneWhereFlat if pull.flatness > FLAT => (place, pull.normal),
                Onto::PlaneWhereFlat | Onto::About => self.solid.pull(&place),
                Onto::Exactly => self.solid.project(&place),
            };
            let is_near =
                // A projection may jump to another wall of a
                // thin slit; nothing moves by more than an edge.
                projected.iter().all(|x| x.is_finite()) && (projected - position).norm() < reach;
            if is_near && self.move_keeps_shape(&position, &projected, ring) {
                self.mesh.positions[vertex as usize] = projected;
                self.normal[vertex as usize] = normal;
                return;
            }
        }
    }

    fn move_keeps_shape(&self, position: &Vec3, target: &Vec3, ring: &[Vec3]) -> bool {
        let smallest = SMALLEST_AREA.min(SMALLEST_SHARE / self.density);
        sides(ring).all(|(p, q)| {
            let (before, after) = (
                (p - position).cross(&(q - position)),
                (p - target).cross(&(q - target)),
            );
            let (area, area_before) = (after.norm_squared(), before.norm_squared());
            is_small_turn(&before, &after)
                && (area > (2.0 * smallest).powi(2) || area > area_before * BETTER * BETTER)
                && acceptable(&[*target, *p, *q], &[*position, *p, *q])
        })
    }

    /// Collapses the shortest edge of every triangle that is still badly shaped, or flips its
    /// longest.
    pub(super) fn remove_slivers(&mut self) {
        for triangle in 0..self.mesh.half_edge_bound() / 3 {
            let corners = self.mesh.triangle(triangle);
            if corners[0] == u32::MAX {
                continue;
            }
            let points = corners.map(|vertex| self.mesh.position(vertex));
            if quality(&points) <= LEAST_QUALITY {
                self.remove_sliver(triangle);
            }
        }
    }

    fn remove_sliver(&mut self, triangle: u32) {
        let mut sides = [3 * triangle, 3 * triangle + 1, 3 * triangle + 2];
        sides.sort_by(|&a, &b| {
            let (a, b) = (self.mesh.length_squared(a), self.mesh.length_squared(b));
            a.total_cmp(&b)
        });
        let [shortest, _, longest] = sides;
        let [a, b, c, d] = quadrangle(&self.mesh, longest);
        let improves = quality(&[c, a, d]).min(quality(&[d, b, c]))
            > quality(&[a, b, c]).min(quality(&[b, a, d]));
        if improves && self.flip_keeps_shape(longest) && self.mesh.can_flip(longest) {
            self.mesh.flip(longest);
        } else {
            self.try_collapse(shortest, f64::INFINITY);
        }
    }
}

/// The triangles at a vertex, each by its other two corners; `ring` are the neighbours, clockwise.
fn sides(ring: &[Vec3]) -> impl Iterator<Item = (&Vec3, &Vec3)> {
    // Clockwise neighbours: p and the one before it make the triangle's orientation outward.
    let before = ring.last().into_iter().chain(ring);
    ring.iter().zip(before)
}

/// Pull on a vertex towards the middle of its neighbourhood.
struct Pull {
    /// Displacement to the area-weighted centre, within the mean plane of the triangles at the
    /// vertex.
    displacement: Vec3,
    /// Unit normal of that plane.
    normal: Vec3,
    /// The share of the triangles' area that is seen along the normal: 1 where they are in a plane.
    flatness: f64,
}

impl Pull {
    /// The pull on a vertex; `None` without triangles, or with triangles without area.
    fn from_ring(position: &Vec3, ring: &[Vec3]) -> Option<Self> {
        let (mut area, mut centre, mut vector) = (0.0, Vec3::zeros(), Vec3::zeros());
        for (p, q) in sides(ring) {
            let (p, q) = (p - position, q - position);
            let normal = p.cross(&q);
            let size = normal.norm();
            area += size;
            vector += normal;
            centre += (p + q) * size;
        }
        let normal = vector.try_normalize(f64::MIN_POSITIVE)?;
        // The centroid of a triangle with its corner at 0 is (p + q) / 3.
        let pull = centre / (3.0 * area);
        Some(Self {
            // The part along the normal would shrink the body.
            displacement: pull - normal * pull.dot(&normal),
            normal,
            flatness: vector.dot(&normal) / area,
        })
    }
}

/// Corners of the two triangles (a, b, c) and (b, a, d) next to an edge a-b.
fn quadrangle(mesh: &HalfEdgeMesh, half_edge: u32) -> [Vec3; 4] {
    let (a, b) = mesh.ends(half_edge);
    [a, b, mesh.apex(half_edge), mesh.apex(mesh.twin(half_edge))]
        .map(|vertex| mesh.position(vertex))
}

/// Shape of a triangle: 4√3 area / sum of squared sides; 1 for equilateral, 0 for degenerate.
pub(crate) fn quality([a, b, c]: &[Vec3; 3]) -> f64 {
    let sides = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    2.0 * 3f64.sqrt() * (b - a).cross(&(c - a)).norm() / sides.max(f64::MIN_POSITIVE)
}

/// The square of [`quality`], which needs no root.
fn quality_squared([a, b, c]: &[Vec3; 3]) -> f64 {
    let sides = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    let area = (b - a).cross(&(c - a)).norm_squared();
    12.0 * area / (sides * sides).max(f64::MIN_POSITIVE)
}

fn acceptable(after: &[Vec3; 3], before: &[Vec3; 3]) -> bool {
    let shape = quality_squared(after);
    shape > LEAST_QUALITY * LEAST_QUALITY || shape > quality_squared(before) * (BETTER * BETTER)
}

/// Whether two area vectors enclose less than 60°.
fn is_small_turn(before: &Vec3, after: &Vec3) -> bool {
    let cosine = before.dot(after);
    // Squared, to spare two roots; the sign is checked apart.
    let least = LARGEST_TURN * LARGEST_TURN * before.norm_squared() * after.norm_squared();
    cosine > 0.0 && cosine * cosine > least
}
