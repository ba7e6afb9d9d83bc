//! Which bodies hold together, and the parts that this makes.

use super::StabilitySettings;
use super::interacting::Interacting;
use super::species::species;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::run::Engine;
use anyhow::{Result, bail};
use protomer_kernel::Pose;
use protomer_mc::parts::{Arrangement, BodyEnergies, ConnectedParts, PlacedBody, connected_parts};

/// Energy of two bodies in contact that holds them together, kT.
const HOLDS_KT: f64 = -1.0;
/// The assembly and its parts, the same at every salt and pH.
pub(super) struct Plan {
    pub arrangement: Arrangement,
    pub parts: ConnectedParts,
    /// Kind of body that names each species.
    pub species: Vec<usize>,
}

impl Plan {
    /// The parts of the assembly, by the energies at the lowest salt.
    ///
    /// # Errors
    /// For bodies that touch nothing, and as [`Engine::in_medium`].
    pub fn new(
        assembly: &Assembly,
        names: &[String],
        settings: &StabilitySettings,
        prepare: &dyn Fn(Assembly) -> Result<Engine>,
    ) -> Result<Self> {
        let lowest = settings
            .salt_molar
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let engine = in_medium(assembly, settings, lowest, prepare)?;
        let interacting = Interacting::new(&engine, settings, lowest)?;
        let (copies, names_of_species) = species(&assembly.bodies);
        let types = engine.body_types();
        let body = |(kind, pose): (&usize, &Pose)| PlacedBody {
            species: copies[*kind].species,
            pose: *pose,
            frame: copies[*kind].frame.then(pose),
            square_of_gyration_angstrom2: types[*kind].square_of_gyration_angstrom2(),
        };
        let bodies: Vec<PlacedBody> = assembly
            .kinds
            .iter()
            .zip(&assembly.poses)
            .map(body)
            .collect();
        let energies_kt = native_kt(&interacting, &assembly.poses, names)?;
        let touching = interacting.touching(&assembly.poses, settings.contact_gap_angstrom);
        let mut arrangement = Arrangement {
            neighbours: neighbours(&touching, |i, j| energies_kt[i][j] <= HOLDS_KT),
            bodies,
            energies_kt,
        };
        let most = settings.parts_of_a_size;
        let mut parts = connected_parts(&arrangement, most);
        if parts.is_none() {
            // What does not attract at the lowest salt may do so at a higher one.
            arrangement.neighbours = neighbours(&touching, |_, _| true);
            parts = connected_parts(&arrangement, most);
        }
        let Some(parts) = parts else {
            bail!(apart(&arrangement, names, settings.contact_gap_angstrom));
        };
        Ok(Self {
            arrangement,
            parts,
            species: names_of_species,
        })
    }
}

/// The engine of an assembly at one salt.
pub(super) fn in_medium(
    assembly: &Assembly,
    settings: &StabilitySettings,
    salt_molar: f64,
    prepare: &dyn Fn(Assembly) -> Result<Engine>,
) -> Result<Engine> {
    let interaction = settings.medium.interaction(Some(salt_molar))?;
    prepare(assembly.clone())?.in_medium(&settings.run(), &interaction)
}

/// Energies of each two bodies in the assembly, kT.
fn native_kt(interacting: &Interacting, poses: &[Pose], names: &[String]) -> Result<Vec<Vec<f64>>> {
    let mut energies_kt = vec![vec![0.0; poses.len()]; poses.len()];
    for j in 0..poses.len() {
        for i in 0..j {
            if interacting.overlap(i, j, &poses[i], &poses[j]) {
                bail!(
                    "{} and {} overlap as hard bodies in the assembly, so it has no energy; make the bodies with --core \
                     native, or move them apart with assemble structure --relax",
                    names[i],
                    names[j]
                );
            }
            energies_kt[i][j] = interacting.energy_kt(i, j, &poses[i], &poses[j]);
            energies_kt[j][i] = energies_kt[i][j];
        }
    }
    Ok(energies_kt)
}

fn neighbours(touching: &[Vec<bool>], holds: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let neighbours_of = |i: usize| {
        let others = 0..touching.len();
        others.filter(|j| touching[i][*j] && holds(i, *j)).collect()
    };
    (0..touching.len()).map(neighbours_of).collect()
}

/// Error for bodies that are not connected.
fn apart(arrangement: &Arrangement, names: &[String], gap_angstrom: f64) -> String {
    let mut reached = vec![0];
    while let Some(next) = (0..names.len()).find(|body| {
        !reached.contains(body)
            && arrangement.neighbours[*body]
                .iter()
                .any(|other| reached.contains(other))
    }) {
        reached.push(next);
    }
    let outside: Vec<&str> = (0..names.len())
        .filter(|body| !reached.contains(body))
        .map(|body| names[body].as_str())
        .take(5)
        .collect();
    format!(
        "{} and {} do not touch, directly or through others (gap at most {gap_angstrom} Å), so they are no assembly; \
         give the biological assembly with --assembly 1, the chains that belong together with --chain, or a wider \
         --contact-gap",
        names[0],
        outside.join(", ")
    )
}
