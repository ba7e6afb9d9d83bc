//! Exact areas and volumes of the accessible and the excluded surface.
//!
//! Every point between both surfaces has its nearest accessible point on a face, an arc or a
//! vertex, so the layer between them falls into pieces with closed forms (solid angle Ω, expanded
//! radius R, atomic radius r, probe p):
//!
//! | nearest feature | excluded surface | layer |
//! |---|---|---|
//! | face | convex patch r² Ω | (R³ - r³) Ω / 3 |
//! | arc | toroidal patch (`torus`) | sector of a torus, ended at the circle's axis |
//! | vertex | concave patch (`concave`) | cone of the probe, ended half-way to other probes |
//!
//! An arc's pieces meet no other piece than their own mirror image beyond the circle's axis: with s
//! in the triangle of c and the two atoms, any allowed probe position y has |y - s| >= |c - s|,
//! because it is at least as far from both atoms as c is. The same holds for a vertex and the
//! tetrahedron it makes with its three atoms; only a probe that reaches through the plane of its
//! atoms is ended by other probes at vertices, half-way between the two. The accessible volume
//! follows from the divergence theorem, V = ⅓ Σ R³ Ω + R² c·∫u dΩ, and the excluded volume is the
//! accessible one less the layer.

mod concave;
mod torus;

use super::arrangement::Arrangement;
use protomer_kernel::Vec3;
use protomer_kernel::disjoint_sets::DisjointSets;
use std::ops::{Add, AddAssign};

/// Relative error that rounding leaves in sums over many patches.
const ROUNDING: f64 = 1e-12;

/// Areas and volumes of a shell or of several together.
///
/// ```
/// use protomer_body::surface::SurfaceMeasure;
/// let shell = SurfaceMeasure {
///     convex_area_angstrom2: 30.0,
///     toroidal_area_angstrom2: 15.0,
///     concave_area_angstrom2: 5.0,
///     ..SurfaceMeasure::default()
/// };
/// assert_eq!(shell.ses_area_angstrom2(), 50.0);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SurfaceMeasure {
    /// Area of the accessible surface, Å².
    pub sas_area_angstrom2: f64,
    /// Volume that the accessible surface encloses, Å³; negative for the shell of a cavity.
    pub sas_volume_angstrom3: f64,
    /// Area of the convex patches of the excluded surface, Å².
    pub convex_area_angstrom2: f64,
    /// Area of the toroidal patches of the excluded surface, Å².
    pub toroidal_area_angstrom2: f64,
    /// Area of the concave patches of the excluded surface, Å².
    pub concave_area_angstrom2: f64,
    /// Volume that the excluded surface encloses, Å³; negative for the shell of a cavity.
    pub ses_volume_angstrom3: f64,
    /// Estimate of the error of any of the areas, Å².
    pub area_error_estimate_angstrom2: f64,
    /// Estimate of the error of any of the volumes, Å³.
    pub volume_error_estimate_angstrom3: f64,
}

impl SurfaceMeasure {
    /// Area of the excluded surface, Å².
    pub fn ses_area_angstrom2(&self) -> f64 {
        self.convex_area_angstrom2 + self.toroidal_area_angstrom2 + self.concave_area_angstrom2
    }

    /// Whether this is the shell of a cavity.
    pub fn is_cavity(&self) -> bool {
        self.sas_volume_angstrom3 < 0.0
    }
}

impl Add for SurfaceMeasure {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            sas_area_angstrom2: self.sas_area_angstrom2 + other.sas_area_angstrom2,
            sas_volume_angstrom3: self.sas_volume_angstrom3 + other.sas_volume_angstrom3,
            convex_area_angstrom2: self.convex_area_angstrom2 + other.convex_area_angstrom2,
            toroidal_area_angstrom2: self.toroidal_area_angstrom2 + other.toroidal_area_angstrom2,
            concave_area_angstrom2: self.concave_area_angstrom2 + other.concave_area_angstrom2,
            ses_volume_angstrom3: self.ses_volume_angstrom3 + other.ses_volume_angstrom3,
            area_error_estimate_angstrom2: self.area_error_estimate_angstrom2
                + other.area_error_estimate_angstrom2,
            volume_error_estimate_angstrom3: self.volume_error_estimate_angstrom3
                + other.volume_error_estimate_angstrom3,
        }
    }
}

impl AddAssign for SurfaceMeasure {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Areas and volumes of both surfaces of an arrangement.
///
/// ```
/// use protomer_body::surface::{Arrangement, Measure};
/// use protomer_kernel::Vec3;
/// let measure = Measure::new(&Arrangement::new(&[Vec3::zeros()], &[1.7], 1.4)?);
/// assert!((measure.total().ses_area_angstrom2() - 36.316_811_08).abs() < 1e-5);
/// assert_eq!(measure.cavity_count(), 0);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measure {
    /// One entry per shell. Shells of the accessible surface whose probes cut each other's patches
    /// count as one: the excluded surface joins them.
    pub shells: Vec<SurfaceMeasure>,
    /// Arcs that are whole circles.
    pub free_arcs: usize,
    /// Arcs whose toroidal patch ends in cusps on the circle's axis.
    pub singular_arcs: usize,
    /// Concave patches that other probes cut.
    pub cut_concave_patches: usize,
    /// Patches whose area had to be estimated by sampling; zero unless rounding defeated the closed
    /// form.
    pub sampled_patches: usize,
}

impl Measure {
    /// Measures both surfaces.
    pub fn new(accessible: &Arrangement) -> Self {
        let mut measure = Self {
            shells: vec![SurfaceMeasure::default(); accessible.shell_count()],
            ..Self::default()
        };
        measure.add_faces(accessible);
        let mut merged = DisjointSets::new(accessible.shell_count());
        if accessible.probe_radius_angstrom() > 0.0 {
            measure.add_arcs(accessible);
            measure.add_vertices(accessible, &mut merged);
        }
        measure.merge(merged);
        measure.estimate_errors(accessible);
        measure
    }

    /// Areas and volumes of all shells together: the areas include the walls of cavities, the
    /// volumes exclude the cavities.
    ///
    /// ```
    /// use protomer_body::surface::{Arrangement, Measure};
    /// use protomer_kernel::Vec3;
    /// let far_apart = [Vec3::zeros(), Vec3::new(20.0, 0.0, 0.0)];
    /// let measure = Measure::new(&Arrangement::new(&far_apart, &[1.5, 1.5], 1.5)?);
    /// assert_eq!(measure.shells.len(), 2);
    /// let two_spheres = 2.0 * 4.0 * std::f64::consts::PI * 3.0_f64.powi(2);
    /// assert!((measure.total().sas_area_angstrom2 - two_spheres).abs() < 1e-5);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn total(&self) -> SurfaceMeasure {
        let mut sum = SurfaceMeasure::default();
        for shell in &self.shells {
            sum += *shell;
        }
        sum
    }

    /// Areas and volumes of the outer shells only: areas without the walls of cavities, volumes
    /// with the cavities filled.
    pub fn without_cavities(&self) -> SurfaceMeasure {
        let mut sum = SurfaceMeasure::default();
        for shell in &self.shells {
            if !shell.is_cavity() {
                sum += *shell;
            }
        }
        sum
    }

    /// The shells of cavities that a probe fits into.
    pub fn cavities(&self) -> Vec<SurfaceMeasure> {
        let mut cavities = self.shells.clone();
        cavities.retain(SurfaceMeasure::is_cavity);
        cavities
    }

    /// Number of cavities that a probe fits into.
    pub fn cavity_count(&self) -> usize {
        self.cavities().len()
    }

    fn add_faces(&mut self, accessible: &Arrangement) {
        let mut origins: Vec<Option<Vec3>> = vec![None; self.shells.len()];
        let mut closures = vec![(Vec3::zeros(), 0.0_f64); self.shells.len()];
        for face in accessible.faces() {
            let outer = accessible.expanded_radii_angstrom()[face.atom as usize];
            let inner = (outer - accessible.probe_radius_angstrom()).max(0.0);
            let shell = &mut self.shells[face.shell as usize];
            let centre = accessible.centres()[face.atom as usize];
            // Relative to the shell's first atom: large coordinates would cancel in the sum.
            let offset = centre - *origins[face.shell as usize].get_or_insert(centre);
            // Divergence theorem: V = ⅓ ∮ x·n dA with x = offset + R u on the ball.
            let enclosed = (outer.powi(3) * face.solid_angle
                + outer.powi(2) * offset.dot(&face.vector_angle))
                / 3.0;
            shell.sas_area_angstrom2 += outer * outer * face.solid_angle;
            shell.sas_volume_angstrom3 += enclosed;
            shell.convex_area_angstrom2 += inner * inner * face.solid_angle;
            shell.ses_volume_angstrom3 +=
                // The layer between R and r over this solid angle.
                enclosed - (outer.powi(3) - inner.powi(3)) * face.solid_angle / 3.0;
            let (closure, extent) = &mut closures[face.shell as usize];
            *closure += outer.powi(2) * face.vector_angle;
            *extent = extent.max(offset.norm());
        }
        // The normals of a closed surface cancel; what is left shows by how much the ends of arcs
        // miss each other.
        for (shell, (closure, extent)) in self.shells.iter_mut().zip(closures) {
            shell.area_error_estimate_angstrom2 += closure.norm();
            shell.volume_error_estimate_angstrom3 += closure.norm() * extent;
        }
    }

    fn add_arcs(&mut self, accessible: &Arrangement) {
        let probe = accessible.probe_radius_angstrom();
        for (number, arc) in accessible.arcs().iter().enumerate() {
            let Some(shell) = accessible.shell_of_arc(number) else {
                continue;
            };
            let [first, second] = arc.atoms.map(|atom| accessible.centres()[atom as usize]);
            let patch = torus::patch(
                arc.radius,
                probe,
                [arc.height, (second - first).norm() - arc.height],
                arc.angle,
            );
            self.free_arcs += usize::from(arc.vertices.is_none());
            self.singular_arcs += usize::from(patch.is_singular);
            let shell = &mut self.shells[shell as usize];
            shell.toroidal_area_angstrom2 += patch.area;
            shell.ses_volume_angstrom3 -= patch.layer_volume;
        }
    }

    fn add_vertices(&mut self, accessible: &Arrangement, merged: &mut DisjointSets) {
        let shell_of = |vertex: u32| {
            let arc = accessible.vertices()[vertex as usize].arcs[0];
            accessible.shell_of_arc(arc as usize).unwrap_or(0)
        };
        let probes = concave::Probes::new(accessible);
        for number in 0..accessible.vertices().len() as u32 {
            let patch = probes.patch(number);
            let shell = shell_of(number);
            for &cutter in &patch.cut_by {
                merged.join(shell, shell_of(cutter));
            }
            self.cut_concave_patches += usize::from(!patch.cut_by.is_empty());
            self.sampled_patches += usize::from(patch.is_sampled);
            let shell = &mut self.shells[shell as usize];
            shell.concave_area_angstrom2 += patch.area;
            shell.ses_volume_angstrom3 -= patch.layer_volume;
            shell.area_error_estimate_angstrom2 += patch.area_error;
            shell.volume_error_estimate_angstrom3 +=
                patch.area_error * accessible.probe_radius_angstrom();
        }
    }

    /// Adds up shells that count as one.
    fn merge(&mut self, mut merged: DisjointSets) {
        let mut sums: Vec<Option<SurfaceMeasure>> = vec![None; self.shells.len()];
        for (number, shell) in self.shells.iter().enumerate() {
            let sum = &mut sums[merged.root(number as u32) as usize];
            *sum = Some(sum.unwrap_or_default() + *shell);
        }
        self.shells = sums.into_iter().flatten().collect();
    }

    /// Estimates the errors. A growth of all radii by ε adds ε A to a volume and about 2 ε A / r to
    /// an area; with ε the amplitude of the perturbation this bounds its effect. A face that did
    /// not close spoils everything.
    fn estimate_errors(&mut self, accessible: &Arrangement) {
        let amplitude = accessible.perturbation_angstrom();
        let probe = accessible.probe_radius_angstrom();
        let mut smallest = f64::INFINITY;
        for face in accessible.faces() {
            let expanded = accessible.expanded_radii_angstrom()[face.atom as usize];
            // The smallest radius bends the most: dA/dr = 2 A / r is largest there.
            smallest = smallest.min(expanded - probe);
        }
        let mut curvature = 0.0;
        for radius in [smallest, probe] {
            // A point has no area of its own, and would make the estimate infinite.
            if radius > 1e-3 {
                curvature += 2.0 / radius;
            }
        }
        for shell in &mut self.shells {
            let area = shell.sas_area_angstrom2;
            shell.area_error_estimate_angstrom2 += area * (amplitude * curvature + ROUNDING);
            shell.volume_error_estimate_angstrom3 +=
                area * amplitude + (shell.sas_volume_angstrom3.abs() + area) * ROUNDING;
            if accessible.defects() > 0 {
                shell.area_error_estimate_angstrom2 = f64::INFINITY;
                shell.volume_error_estimate_angstrom3 = f64::INFINITY;
            }
        }
    }
}

#[cfg(test)]
mod tests;
