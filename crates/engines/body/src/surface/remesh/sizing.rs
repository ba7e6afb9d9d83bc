//! How long the edges should be: by shell from the density, by vertex from the curvature.

use super::operations::Remesher;

/// Lower bound of the factor by which curvature grades the edge lengths.
const FINEST: f64 = 0.5;
/// Upper bound of that factor.
const COARSEST: f64 = 1.3;
/// Power of the ratio of vertex numbers by which lengths are corrected; 1/2 would do without lag.
const OVERSHOOT: f64 = 0.75;

impl Remesher<'_> {
    /// Edge lengths from the areas of the shells: a vertex of an equilateral mesh of edge L has the
    /// area (√3/2) L².
    pub(super) fn set_lengths(&mut self) {
        self.length.clear();
        for (area, count) in self.vertex_targets() {
            self.length.push((2.0 / 3f64.sqrt() * area / count).sqrt());
        }
    }

    /// The length that an edge should have, Å.
    pub(super) fn target_length(&self, half_edge: u32) -> f64 {
        let (a, b) = self.mesh.ends(half_edge);
        let shell = self.mesh.shell[a as usize];
        self.length[shell as usize] * 0.5 * (self.grade[a as usize] + self.grade[b as usize])
    }

    /// Area and vertex number wanted, by shell.
    fn vertex_targets(&self) -> Vec<(f64, f64)> {
        let mut areas = vec![0.0; self.mesh.shells];
        for triangle in self.mesh.triangles() {
            let shell = self.mesh.shell[self.mesh.triangle(triangle)[0] as usize];
            areas[shell as usize] += 0.5 * self.mesh.area_vector(triangle).norm();
        }
        let fewest = self.fewest_vertices as f64;
        let mut targets = Vec::with_capacity(areas.len());
        for area in areas {
            targets.push((area, (area * self.density).max(fewest)));
        }
        targets
    }

    /// Corrects the target lengths by the vertex numbers reached so far: N ∝ 1/L², and as splits and
    /// collapses leave alone what is nearly right, by somewhat more.
    pub(super) fn adjust_lengths(&mut self) {
        let mut counts = vec![0.0; self.mesh.shells];
        for vertex in self.mesh.vertices() {
            counts[self.mesh.shell[vertex as usize] as usize] += 1.0;
        }
        for (shell, (_, wanted)) in self.vertex_targets().into_iter().enumerate() {
            self.length[shell] *= (counts[shell] / wanted).powf(OVERSHOOT).clamp(0.8, 1.25);
        }
    }

    /// Grades the edge lengths by the curvature κ that the normals at the ends of the edges show:
    /// an edge of length L leaves a gap of κL²/8 to the surface, so that L ∝ κ^(-1/2) leaves the
    /// same gap everywhere.
    pub(super) fn grade_lengths(&mut self) {
        let vertices: Vec<u32> = self.mesh.vertices().collect();
        let mut curvature = vec![0.0f64; self.mesh.positions.len()];
        for half_edge in 0..self.mesh.half_edge_bound() {
            if !self.mesh.is_edge(half_edge) {
                continue;
            }
            let (a, b) = self.mesh.ends(half_edge);
            let bend = (self.normal[a as usize] - self.normal[b as usize]).norm();
            let length = self.mesh.length_squared(half_edge).sqrt();
            let edge_curvature = bend / length.max(f64::MIN_POSITIVE);
            for end in [a, b] {
                let at_end = &mut curvature[end as usize];
                *at_end = at_end.max(edge_curvature);
            }
        }
        let (mut sum, mut count) = (vec![0.0; self.mesh.shells], vec![0.0; self.mesh.shells]);
        for &vertex in &vertices {
            let shell = self.mesh.shell[vertex as usize] as usize;
            sum[shell] += curvature[vertex as usize];
            count[shell] += 1.0;
        }
        for &vertex in &vertices {
            let shell = self.mesh.shell[vertex as usize] as usize;
            let relative =
                curvature[vertex as usize] * count[shell] / sum[shell].max(f64::MIN_POSITIVE);
            let grade = relative
                .max(f64::MIN_POSITIVE)
                .powf(-0.5)
                .clamp(FINEST, COARSEST);
            self.grade[vertex as usize] = 0.5 * (self.grade[vertex as usize] + grade);
        }
    }
}
