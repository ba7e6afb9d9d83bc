//! Observables: radius of gyration, contacts between surfaces, clusters.

use crate::system::{Pair, System};
use protomer_kernel::disjoint_sets::DisjointSets;
use protomer_kernel::overlap::comes_within;
use serde::{Deserialize, Serialize};

/// The observables of one state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Observables {
    /// Sweeps done.
    pub sweep: u64,
    /// Total energy, kT.
    pub energy_kt: f64,
    /// Radius of gyration of the origins, Å ([`r_g_angstrom`]).
    pub r_g_angstrom: f64,
    /// Radius of gyration with every body weighted by its volume, Å.
    pub r_g_volume_weighted_angstrom: f64,
    /// Fraction of the initial contacts that exist now; `None` if there were none.
    pub native_contacts: Option<f64>,
    /// Present contacts, native or not.
    pub contacts: usize,
    /// Bodies in the largest cluster of bodies in contact.
    pub largest_cluster: usize,
    /// Number of clusters, single bodies included.
    pub clusters: usize,
    /// Fraction of the bodies that touch another.
    pub bound_fraction: f64,
}

/// Radius of gyration of the bodies' origins, Å, from all pairs of bodies:
///
/// R_g² = Σ_{i<j} w_i w_j |r_ij|² / (Σ w_i)²,
///
/// the same as the mean square distance from the weighted centre. In a periodic box r_ij is the
/// shortest image, so the value depends on the configuration only: it is the usual one while the
/// assembly fits into half the box, and for a gas that fills the box it levels off at (1 - 1/N)
/// (Lx² + Ly² + Lz²)/24 for equal weights.
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, System, observables::r_g_angstrom};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// let place = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
/// let system = System::new(vec![cube], &[(0, place(0.0)), (0, place(20.0))], Boundary::Open)?;
/// assert_eq!(r_g_angstrom(&system, |_| 1.0), 10.0);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
pub fn r_g_angstrom(system: &System, weight: impl Fn(usize) -> f64) -> f64 {
    let (boundary, poses) = (system.boundary(), system.poses());
    let mut sum = 0.0;
    for (second, pose) in poses.iter().enumerate() {
        for (first, other) in poses[..second].iter().enumerate() {
            let distance_squared = boundary
                .displacement(&other.position, &pose.position)
                .norm_squared();
            sum += weight(first) * weight(second) * distance_squared;
        }
    }
    sum.sqrt() / (0..poses.len()).map(weight).sum::<f64>()
}

/// The pairs of bodies whose surfaces are closer than `gap_angstrom`; the smaller index first,
/// ascending.
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, System, observables::contacts};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// let place = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
/// let row = [(0, place(0.0)), (0, place(14.0)), (0, place(40.0))];
/// // Cubes with edges of 10 Å: 4 Å and 16 Å are between them.
/// let system = System::new(vec![cube], &row, Boundary::Open)?;
/// assert_eq!(contacts(&system, 5.0), [(0, 1)]);
/// assert!(contacts(&system, 3.0).is_empty());
/// # Ok::<(), protomer_mc::McError>(())
/// ```
pub fn contacts(system: &System, gap_angstrom: f64) -> Vec<(usize, usize)> {
    let pairs = (0..system.len())
        .flat_map(|first| (first + 1..system.len()).map(move |second| (first, second)));
    pairs
        .filter(|&(first, second)| in_contact(&system.pair(first, second), gap_angstrom))
        .collect()
}

pub(crate) fn in_contact(pair: &Pair<'_>, gap_angstrom: f64) -> bool {
    let (first, second) = pair.types();
    let reach = first.hard_radius_angstrom() + second.hard_radius_angstrom() + gap_angstrom;
    pair.displacement.norm_squared() < reach * reach
        && comes_within(&first.shape, &second.shape, &pair.relative(), gap_angstrom)
}

/// Fraction of the native contacts (ascending) that are among the present ones (ascending); `None`
/// without native ones.
///
/// ```
/// use protomer_mc::observables::survival;
/// assert_eq!(survival(&[(0, 1), (1, 2)], &[(0, 1), (0, 2)]), Some(0.5));
/// assert_eq!(survival(&[], &[(0, 1)]), None);
/// ```
pub fn survival(native: &[(usize, usize)], present: &[(usize, usize)]) -> Option<f64> {
    let survivors = native
        .iter()
        .filter(|pair| present.binary_search(pair).is_ok())
        .count();
    (!native.is_empty()).then(|| survivors as f64 / native.len() as f64)
}

/// Sizes of the clusters formed by these contacts, the largest first.
///
/// ```
/// use protomer_mc::observables::cluster_sizes;
/// assert_eq!(cluster_sizes(4, &[(0, 1), (1, 2)]), [3, 1]);
/// ```
pub fn cluster_sizes(bodies: usize, contacts: &[(usize, usize)]) -> Vec<usize> {
    let mut sets = DisjointSets::new(bodies);
    for &(first, second) in contacts {
        sets.join(first as u32, second as u32);
    }
    let mut sizes = vec![0; bodies];
    for root in sets.into_roots() {
        sizes[root as usize] += 1;
    }
    sizes.retain(|size| *size > 0);
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_and_survival_count_what_they_say() {
        let contacts = [(0, 3), (1, 2), (2, 5)];
        assert_eq!(cluster_sizes(7, &contacts), [3, 2, 1, 1]);
        assert_eq!(
            survival(&[(0, 1), (1, 2), (2, 5), (3, 4)], &contacts),
            Some(0.5)
        );
        assert_eq!(survival(&[], &contacts), None);
    }
}
