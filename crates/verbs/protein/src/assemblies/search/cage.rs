//! Positions and orientations of bodies in a cubic group.
//!
//! A site is a direction from the centre, the distance relative to that of the first site, and an
//! orientation. Random sites are the starting points.

use super::{Arrangement, Closed, Found, Searched, Steps, search};
use protomer_body::assembly::{Cage, CageSite, CubicGroup, HardBodies, Placement};
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Rotation, Vec3};
use protomer_results::Execution;
use serde::Serialize;
use std::collections::BTreeMap;

/// Distances of further kinds of bodies over that of the first at the start.
const RELATIVE_RADII: [f64; 2] = [0.7, 1.4];
/// Least distance of a site over that of the first.
const LEAST_RELATIVE_RADIUS: f64 = 0.2;

/// Random starting points of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CageSamples {
    /// The group.
    pub group: CubicGroup,
    /// Number of kinds of bodies.
    pub kinds: usize,
    /// Number of starting points.
    pub samples: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// A cage that the search found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundCage {
    /// The group.
    pub group: CubicGroup,
    /// Number of bodies.
    pub bodies: usize,
    /// Distance of the bodies of the first kind from the centre, Å.
    pub radius_angstrom: f64,
    /// Energy of the whole cage, kT.
    pub energy_kt: f64,
    /// Energy for each body, kT.
    pub energy_per_body_kt: f64,
    /// Terms of the energy, kT.
    pub terms_kt: BTreeMap<&'static str, f64>,
    /// Whether the cage was refined, or is a starting point.
    pub is_refined: bool,
    /// Sites of the cage.
    #[serde(skip)]
    pub cage: Cage,
    /// Bodies and poses.
    #[serde(skip)]
    pub placements: Vec<Placement>,
}

/// Searches a cubic group for cages of low energy; `None` if the work was interrupted.
pub fn search_cages(
    searched: Searched,
    samples: &CageSamples,
    execution: &Execution,
) -> Option<Found<FoundCage>> {
    let starts = (0..samples.samples).map(|number| random(samples, number));
    search(searched, starts.collect(), execution, |point, terms_kt| {
        let bodies = point.closed.placements.len();
        let energy_kt = point.energy.total_kt();
        FoundCage {
            group: point.arrangement.group,
            bodies,
            radius_angstrom: point.closed.radius_angstrom,
            energy_kt,
            energy_per_body_kt: energy_kt / bodies as f64,
            terms_kt,
            is_refined: point.is_refined,
            cage: point.arrangement,
            placements: point.closed.placements,
        }
    })
}

/// A cage of random sites.
fn random(samples: &CageSamples, number: usize) -> Cage {
    // A stream for each sample: a longer search begins with the same cages.
    let mut stream = CounterRng::new(samples.seed, 0, number as u64);
    let mut sites = Vec::with_capacity(samples.kinds);
    for body in 0..samples.kinds {
        let radius = match body {
            0 => 1.0,
            _ => stream.uniform_in(RELATIVE_RADII[0], RELATIVE_RADII[1]),
        };
        sites.push(CageSite {
            body,
            position: stream.unit_vector() * radius,
            rotation: stream.rotation(),
        });
    }
    Cage {
        group: samples.group,
        sites,
    }
}

/// Free coordinates of each site: two of the direction, three of the orientation; and the distance, for all
/// sites but the first.
const COORDINATES_PER_SITE: usize = 6;

impl Arrangement for Cage {
    fn coordinates(&self) -> usize {
        COORDINATES_PER_SITE * self.sites.len()
    }

    fn moved(&self, coordinate: usize, steps: &Steps, sign: f64) -> Option<Self> {
        let (number, coordinate) = (
            coordinate / COORDINATES_PER_SITE,
            coordinate % COORDINATES_PER_SITE,
        );
        let mut cage = self.clone();
        let site = &mut cage.sites[number];
        let angle = sign * steps.angle_degrees.to_radians();
        let [across, along] = tangents(&site.position);
        let outward = site.position.normalize();
        match coordinate {
            // The body moves along and keeps its orientation towards the centre.
            0 | 1 => {
                let axis = [across, along][coordinate];
                let turn = Rotation::new(axis * angle);
                site.position = turn * site.position;
                site.rotation = turn * site.rotation;
            }
            2..=4 => {
                let axis = [across, along, outward][coordinate - 2];
                site.rotation = Rotation::new(axis * angle) * site.rotation;
            }
            _ if number > 0 => {
                site.position *= 1.0 + sign * steps.share;
                if site.position.norm() < LEAST_RELATIVE_RADIUS {
                    return None;
                }
            }
            _ => return None,
        }
        Some(cage)
    }

    fn close(&self, bodies: &HardBodies, gap_angstrom: f64, tolerance: f64) -> Option<Closed> {
        let overlap = |a: &_, b: &_| bodies.overlap_in_open_space(a, b);
        let closed = Cage::close(self, gap_angstrom, tolerance, overlap).ok()?;
        Some(Closed {
            placements: closed.placements,
            orbits: closed.orbits,
            radius_angstrom: closed.radius_angstrom,
            ring_distance_angstrom: 0.0,
        })
    }
}

/// Two directions across a position and across each other.
fn tangents(position: &Vec3) -> [Vec3; 2] {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let slope = |axis: &Vec3| axis.dot(position).abs();
    let mut across = axes[0];
    for axis in axes {
        if slope(&axis) < slope(&across) {
            across = axis;
        }
    }
    let first = position.cross(&across).normalize();
    [first, position.cross(&first).normalize()]
}
