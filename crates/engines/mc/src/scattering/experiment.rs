//! What is measured of one state.

use super::capacity::{Patches, capacity_angstrom};
use super::clusters::{Cluster, clusters};
use super::directions::Directions;
use super::scatterers::{Distances, Scatterers};
use super::structure_factor::{evaluate, open};
use super::wave_vectors::{Shell, shells};
use crate::error::require;
use crate::observables::contacts;
use crate::{McError, Result, System};
use nalgebra::Complex;
use protomer_body::Body;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The settings of a measurement.
///
/// ```
/// use protomer_mc::scattering::experiment::Settings;
/// let wide = Settings { largest_q_per_angstrom: 1.0, ..Settings::default() };
/// assert!(wide.check().is_ok());
/// assert!(Settings { directions: 0, ..wide }.check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The largest wave number, Å⁻¹.
    pub largest_q_per_angstrom: f64,
    /// Number of wave numbers.
    pub wave_numbers: usize,
    /// Directions of the wave vector for each wave number and state, at most.
    pub directions: usize,
    /// Bodies whose surfaces are closer than this are in contact, Å.
    pub contact_gap_angstrom: f64,
    /// Thickness of the water that moves with a body, Å.
    pub hydration_angstrom: f64,
    /// Wave number of the dynamic light scattering, Å⁻¹.
    pub light_q_per_angstrom: f64,
    /// Seed of the random directions.
    pub seed: u64,
}

impl Default for Settings {
    /// Light of 633 nm in water, scattered by 173°. The shell of water is that of Garcia de la Torre,
    /// Huertas and Carrasco, Biophys. J. 78, 719 (2000): atoms with 2.9 Å, of which 1.8 Å are their own.
    fn default() -> Self {
        Self {
            largest_q_per_angstrom: 0.3,
            wave_numbers: 60,
            directions: 24,
            contact_gap_angstrom: crate::DEFAULT_CONTACT_GAP_ANGSTROM,
            hydration_angstrom: 1.1,
            light_q_per_angstrom: 0.00264,
            seed: 1,
        }
    }
}

impl Settings {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`McError::BadSetting`] names the setting.
    pub fn check(&self) -> Result<()> {
        let positive = [
            ("largest_q_per_angstrom", self.largest_q_per_angstrom),
            ("wave_numbers", self.wave_numbers as f64),
            ("directions", self.directions as f64),
            ("contact_gap_angstrom", self.contact_gap_angstrom),
            ("light_q_per_angstrom", self.light_q_per_angstrom),
        ];
        for (setting, value) in positive {
            require(setting, value, "positive", value.is_finite() && value > 0.0)?;
        }
        let depth = self.hydration_angstrom;
        let is_between = (0.0..=100.0).contains(&depth);
        require("hydration_angstrom", depth, "from 0 to 100 Å", is_between)
    }
}

/// Data of a kind of body that depend on no state.
#[derive(Debug)]
struct Kind {
    scatterers: Scatterers,
    /// P(q) at the wave numbers of the experiment.
    form_factor: Vec<f64>,
    distances: Distances,
    /// Patches of the surface, fine to coarse.
    patches: Vec<Patches>,
    capacity_angstrom: f64,
}

/// Patches of a body, for clusters of few and of many bodies.
const PATCHES: [usize; 3] = [128, 40, 12];
/// More patches than this are not solved for together, if there are coarser ones.
const MOST_PATCHES: usize = 2600;
/// Degree beyond 2qR at which averages over directions are exact to some 10⁻⁶.
const FURTHER_DEGREES: usize = 10;

/// An experiment on bodies of these kinds in this space.
#[derive(Debug)]
pub struct Experiment {
    settings: Settings,
    kinds: Vec<Kind>,
    q_per_angstrom: Vec<f64>,
    /// Wave vectors of a periodic box, in shells.
    shells: Option<Vec<Shell>>,
}

/// A cluster as it scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClusterMeasure {
    /// Number of bodies.
    pub bodies: usize,
    /// Hydrodynamic radius, Å; `None` for a cluster that touches its own image.
    pub hydrodynamic_radius_angstrom: Option<f64>,
    /// Intensity at the wave number of the light, Å⁶: V² P(q).
    pub light_angstrom6: f64,
}

/// Results of measuring a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// S(q) between the origins of the bodies.
    pub structure_factor: Vec<f64>,
    /// I(q) over the sum of the squared volumes of the bodies: 1 at q = 0 for bodies far apart.
    pub intensity: Vec<f64>,
    /// The clusters, single bodies included.
    pub clusters: Vec<ClusterMeasure>,
}

impl Experiment {
    /// Prepares an experiment: form factors and capacities of the bodies, wave numbers.
    ///
    /// # Errors
    /// For settings out of range, bodies without volume, and a box too small for any wave vector.
    pub fn new(bodies: &[Arc<Body>], boundary: &Boundary, settings: Settings) -> Result<Self> {
        settings.check()?;
        // A periodic state has only wave vectors of its box; others see the edges.
        let shells = match boundary {
            Boundary::Periodic { lengths_angstrom } => Some(shells(
                (*lengths_angstrom).into(),
                settings.largest_q_per_angstrom,
                settings.wave_numbers,
                settings.directions,
                settings.seed,
            )),
            Boundary::Open | Boundary::SphereWall { .. } => None,
        };
        let q_per_angstrom = match &shells {
            Some(shells) => shells.iter().map(|shell| shell.q_per_angstrom).collect(),
            None => even_wave_numbers(&settings),
        };
        require(
            "largest_q_per_angstrom",
            settings.largest_q_per_angstrom,
            "at least the shortest wave vector of the box, 2π over its length",
            !q_per_angstrom.is_empty(),
        )?;
        let mut kinds = Vec::with_capacity(bodies.len());
        for body in bodies {
            kinds.push(Kind::new(body, &settings, &q_per_angstrom)?);
        }
        Ok(Self {
            settings,
            kinds,
            q_per_angstrom,
            shells,
        })
    }

    /// The wave numbers, Å⁻¹.
    pub fn q_per_angstrom(&self) -> &[f64] {
        &self.q_per_angstrom
    }

    /// P(q) of a kind of body.
    pub fn form_factor(&self, kind: usize) -> &[f64] {
        &self.kinds[kind].form_factor
    }

    /// Hydrodynamic radius of a kind of body, Å.
    pub fn hydrodynamic_radius_angstrom(&self, kind: usize) -> f64 {
        self.kinds[kind].capacity_angstrom
    }

    /// P(q) of these bodies together, each weighted with its squared volume.
    pub fn mean_form_factor(&self, system: &System) -> Vec<f64> {
        let mut mean = vec![0.0; self.q_per_angstrom.len()];
        let mut total = 0.0;
        for body in 0..system.len() {
            let kind = &self.kinds[system.type_index(body)];
            let weight = kind.scatterers.volume_angstrom3().powi(2);
            total += weight;
            for (sum, factor) in mean.iter_mut().zip(&kind.form_factor) {
                *sum += weight * factor;
            }
        }
        mean.into_iter().map(|sum| sum / total).collect()
    }

    /// Measures a state. `number` is that of the state: in open space it chooses the directions.
    pub fn measure(&self, system: &System, number: u64) -> Measured {
        let touching = contacts(system, self.settings.contact_gap_angstrom);
        let touching_clusters = clusters(system, &touching);
        let (structure_factor, intensity) = match &self.shells {
            Some(shells) => self.in_box(system, shells),
            None => self.in_open_space(system, number),
        };
        Measured {
            structure_factor,
            intensity,
            clusters: touching_clusters
                .iter()
                .map(|cluster| self.measured(system, cluster))
                .collect(),
        }
    }

    fn in_box(&self, system: &System, shells: &[Shell]) -> (Vec<f64>, Vec<f64>) {
        // Averages over the directions of each shell.
        let positions = positions(system);
        let (mut structure_factor, mut intensity) = (Vec::new(), Vec::new());
        let total = self.squared_volumes(system);
        for shell in shells {
            let share = 1.0 / shell.vectors.len() as f64;
            let (mut s, mut i) = (0.0, 0.0);
            for vector in &shell.vectors {
                s += share * evaluate(&positions, vector);
                i += share * self.amplitude(system, vector).norm_sqr();
            }
            structure_factor.push(s);
            intensity.push(i / total);
        }
        (structure_factor, intensity)
    }

    fn in_open_space(&self, system: &System, number: u64) -> (Vec<f64>, Vec<f64>) {
        let positions = positions(system);
        let centre = positions.iter().sum::<Vec3>() / positions.len() as f64;
        // The radius of everything decides how many directions an average needs.
        let mut radius = 0.0_f64;
        for (body, position) in positions.iter().enumerate() {
            let body_radius = self.kinds[system.type_index(body)]
                .scatterers
                .radius_angstrom();
            radius = radius.max((position - centre).norm() + body_radius);
        }
        let mut rng = CounterRng::new(self.settings.seed, 0, number);
        let few = Directions::at_most(self.settings.directions);
        let total = self.squared_volumes(system);
        let (mut structure_factor, mut intensity) = (Vec::new(), Vec::new());
        for q in &self.q_per_angstrom {
            structure_factor.push(open(&positions, *q));
            // |amplitude|² is a polynomial of about this degree in the direction.
            let degree = (2.0 * q * radius).ceil() as usize + FURTHER_DEGREES;
            let is_few = Directions::count(degree) <= self.settings.directions;
            let directions = match is_few {
                // Exact where few directions suffice; else a set that is turned at
                // random for each state, which has no bias in the mean over states.
                true => Directions::exact_to_degree(degree),
                false => few.turned(&rng.rotation()),
            };
            let mut sum = 0.0;
            for (direction, weight) in directions.iter() {
                sum += weight * self.amplitude(system, &(direction * *q)).norm_sqr();
            }
            intensity.push(sum / total);
        }
        (structure_factor, intensity)
    }

    fn squared_volumes(&self, system: &System) -> f64 {
        let kinds = (0..system.len()).map(|body| &self.kinds[system.type_index(body)]);
        kinds
            .map(|kind| kind.scatterers.volume_angstrom3().powi(2))
            .sum()
    }

    /// The amplitude of all bodies, Å³.
    fn amplitude(&self, system: &System, wave_vector: &Vec3) -> Complex<f64> {
        let mut sum = Complex::new(0.0, 0.0);
        for body in 0..system.len() {
            sum += self.amplitude_of(system.type_index(body), system.pose(body), wave_vector);
        }
        sum
    }

    fn amplitude_of(&self, kind: usize, pose: &Pose, wave_vector: &Vec3) -> Complex<f64> {
        // The wave vector is turned into the body, not the body's scatterers into space.
        let body_wave_vector = pose.rotation.inverse_transform_vector(wave_vector);
        let phase = wave_vector.dot(&pose.position);
        self.kinds[kind].scatterers.amplitude(&body_wave_vector)
            * Complex::new(phase.cos(), phase.sin())
    }

    fn measured(&self, system: &System, cluster: &Cluster) -> ClusterMeasure {
        let kind = |body: &usize| system.type_index(*body);
        if let [only] = cluster.members[..] {
            // Single bodies, most of all clusters: everything is known beforehand.
            let kind = &self.kinds[kind(&only)];
            let volume = kind.scatterers.volume_angstrom3();
            let q = self.settings.light_q_per_angstrom;
            return ClusterMeasure {
                bodies: 1,
                hydrodynamic_radius_angstrom: Some(kind.capacity_angstrom),
                light_angstrom6: volume * volume * kind.distances.form_factor(q),
            };
        }
        let mut poses = Vec::with_capacity(cluster.members.len());
        for (body, position) in cluster.members.iter().zip(&cluster.positions_angstrom) {
            // Positions along contacts, as a cluster may reach across the box.
            let pose = Pose {
                position: *position,
                ..*system.pose(*body)
            };
            poses.push((kind(body), pose));
        }
        let radius = match cluster.is_endless {
            // Through the boundary to itself: it has no end, and no hydrodynamic radius.
            true => None,
            false => self.capacity(&poses),
        };
        ClusterMeasure {
            bodies: poses.len(),
            hydrodynamic_radius_angstrom: radius,
            light_angstrom6: self.light(&poses),
        }
    }

    fn capacity(&self, poses: &[(usize, Pose)]) -> Option<f64> {
        let with = |level: usize| -> Vec<(&Patches, Pose)> {
            let kinds = poses.iter();
            kinds
                .map(|(kind, pose)| (&self.kinds[*kind].patches[level], *pose))
                .collect()
        };
        let count = |bodies: &[(&Patches, Pose)]| -> usize {
            bodies.iter().map(|(patches, _)| patches.len()).sum()
        };
        let last = PATCHES.len() - 1;
        // As fine as can be solved together.
        let level = (0..last).find(|level| count(&with(*level)) <= MOST_PATCHES);
        capacity_angstrom(&with(level.unwrap_or(last)))
    }

    /// Intensity of a cluster at the wave number of the light, averaged over all orientations, Å⁶.
    fn light(&self, poses: &[(usize, Pose)]) -> f64 {
        let q = self.settings.light_q_per_angstrom;
        let middle = poses.iter().map(|(_, pose)| pose.position).sum::<Vec3>() / poses.len() as f64;
        let mut radius = 0.0_f64;
        for (kind, pose) in poses {
            let body_radius = self.kinds[*kind].scatterers.radius_angstrom();
            radius = radius.max((pose.position - middle).norm() + body_radius);
        }
        // The error of degree d is of the order (qR)^d/d!: few directions are enough for small qR.
        let degree = (2.0 * q * radius).ceil() as usize + 4;
        let mut sum = 0.0;
        for (direction, weight) in Directions::exact_to_degree(degree).iter() {
            let vector = direction * q;
            let mut amplitude = Complex::new(0.0, 0.0);
            for (kind, pose) in poses {
                amplitude += self.amplitude_of(*kind, pose, &vector);
            }
            sum += weight * amplitude.norm_sqr();
        }
        sum
    }
}

impl Kind {
    fn new(body: &Body, settings: &Settings, q_per_angstrom: &[f64]) -> Result<Self> {
        let scatterers = Scatterers::of_body(body)?;
        let distances = scatterers.distances();
        let surface = |count| Patches::new(&body.mesh, settings.hydration_angstrom, count);
        let patches: Vec<Patches> = PATCHES.map(surface).to_vec();
        let capacity = patches
            .first()
            .map(|fine| capacity_angstrom(&[(fine, Pose::identity())]));
        let Some(capacity_angstrom) = capacity.flatten().filter(|_| !scatterers.is_empty()) else {
            return Err(McError::BadSystem(format!(
                "body '{}' has no surface whose hydrodynamic radius can be found; make it again with \
                 'protomer ingest'",
                body.name
            )));
        };
        Ok(Self {
            form_factor: q_per_angstrom
                .iter()
                .map(|q| distances.form_factor(*q))
                .collect(),
            scatterers,
            distances,
            patches,
            capacity_angstrom,
        })
    }
}

fn even_wave_numbers(settings: &Settings) -> Vec<f64> {
    let step = settings.largest_q_per_angstrom / settings.wave_numbers as f64;
    (1..=settings.wave_numbers)
        .map(|number| step * number as f64)
        .collect()
}

fn positions(system: &System) -> Vec<Vec3> {
    system.poses().iter().map(|pose| pose.position).collect()
}
