//! The bodies of a sweep that are shown, their colours and their positions.
//!
//! Body files have charges and residues, so they are preferred. If they are missing, the
//! shapes come from the trajectory.

use crate::assemblies::assembly_file::Assembly;
use crate::export::{assembly_of, gather};
use crate::stability::run::RunSettings;
use crate::stability::run::replica_directory;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_body::chemistry::{HYDROPATHY_SCALE, LARGEST_HYDROPATHY};
use protomer_common::page::millimolar;
use protomer_common::page::scene::{Colouring, Film, Scene, Shown, ShownMesh};
use protomer_field::voxels::hydropathy::HydropathyMap;
use protomer_io::gsd::{GsdFile, TrajectoryReader};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Pose, TriangleMesh, Vec3};
use protomer_results::Record;
use rayon::prelude::*;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Number of vertices beyond which a page is slow to open.
pub(crate) const MOST_VERTICES: usize = 400_000;
/// Number of bodies beyond which a scene is slow to turn.
const MOST_BODIES: usize = 256;
/// Number of final states, and of films, in the menu.
const MOST_ENDS: usize = 8;
/// Number of frames of a film.
const MOST_FRAMES: usize = 200;
/// Number of poses in all films, some megabytes of text.
const MOST_POSES: usize = 60_000;
/// Range of the hydropathy: residues with an atom within this distance of a point count, Å;
/// the default of the voxel channel.
const HYDROPATHY_REACH_ANGSTROM: f64 = 5.0;
/// Possible upper limits of a potential scale, kT/e.
const POTENTIAL_LIMITS: [f64; 6] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];

/// The shown bodies, and remarks.
#[derive(Debug, Default)]
pub struct Collected {
    /// Data of the viewer; `None` if no shapes are known.
    pub shown: Option<Shown>,
    /// Remarks on what is missing or omitted, and why.
    pub notes: Vec<String>,
    /// The assembly, if it was found and matches the results.
    pub assembly: Option<Assembly>,
}

/// Collects the bodies of a directory; `assembly` replaces the file named in the record.
///
/// # Errors
/// If `assembly` is given and does not match the results.
pub fn collect(
    directory: &Path,
    settings: &RunSettings,
    record: Option<&Record>,
    periodic_box: Option<[f64; 3]>,
    assembly: Option<&Path>,
) -> Result<Collected> {
    let mut collected = Collected::default();
    match (assembly_of(directory, record, assembly), assembly) {
        (Ok(stored_assembly), _) => collected.assembly = Some(stored_assembly),
        // An assembly that was named must be the right one;
        // one that was only remembered may be missing.
        (Err(error), Some(_)) => return Err(error),
        (Err(error), None) => collected.notes.push(format!(
            "The body files were not found ({error:#}): the shapes come from the trajectory, without charges and \
             residues. Name the assembly with --assembly FILE."
        )),
    }
    let trajectories = trajectories(directory, settings);
    let mut shown = match (&collected.assembly, trajectories.first()) {
        (Some(assembly), _) => coloured(&assembly.bodies, settings),
        (None, Some((_, path))) => match shapes(path) {
            Ok(meshes) => Shown {
                meshes,
                ..Shown::default()
            },
            Err(error) => return Ok(without(collected, format!("No shapes: {error:#}"))),
        },
        (None, None) => {
            return Ok(without(
                collected,
                "No shapes are known: there is no trajectory either.".into(),
            ));
        }
    };
    let meshes = shown.meshes.iter();
    let vertices: usize = meshes.map(|shown| shown.mesh.vertices.len()).sum();
    if vertices > MOST_VERTICES {
        let note = format!(
            "The surfaces have {vertices} vertices, which is more than a page can show ({MOST_VERTICES})."
        );
        return Ok(without(collected, note));
    }
    let mut scenes = Vec::new();
    for (number, shown) in shown.meshes.iter().enumerate() {
        scenes.push(Scene {
            name: format!("body {}", shown.name),
            bodies: vec![(number, Pose::identity())],
            colouring: None,
            film: None,
        });
    }
    let (states, unread) = states(collected.assembly.as_ref(), &trajectories, periodic_box);
    scenes.extend(states);
    collected.notes.extend(unread);
    let numbers = scenes.iter().map(|scene| scene.bodies.len());
    let many = numbers.max().unwrap_or(0);
    if many > MOST_BODIES {
        collected.notes.push(format!(
            "States of {many} bodies are not drawn; OVITO opens the trajectories."
        ));
        scenes.retain(|scene| scene.bodies.len() <= MOST_BODIES);
    }
    shown.scenes = scenes;
    collected.shown = Some(shown);
    Ok(collected)
}

fn without(mut collected: Collected, note: String) -> Collected {
    collected.notes.push(note);
    collected
}

/// The first replica's trajectory of each salt concentration that has one.
fn trajectories(directory: &Path, settings: &RunSettings) -> Vec<(f64, PathBuf)> {
    let mut trajectories = Vec::new();
    for salt in &settings.salt_molar {
        let path = replica_directory(directory, *salt, 0).join("trajectory.gsd");
        if path.is_file() {
            trajectories.push((*salt, path));
        }
    }
    trajectories
}

/// The initial and the final states, with errors for those that cannot be read.
fn states(
    assembly: Option<&Assembly>,
    trajectories: &[(f64, PathBuf)],
    periodic_box: Option<[f64; 3]>,
) -> (Vec<Scene>, Vec<String>) {
    let (mut scenes, mut unread) = (Vec::new(), Vec::new());
    if let Some(assembly) = assembly {
        let kinds = assembly.kinds.iter().copied();
        scenes.push(Scene {
            name: "the start".into(),
            bodies: kinds.zip(assembly.poses.iter().copied()).collect(),
            colouring: None,
            film: None,
        });
    }
    // Evenly chosen salts, the first always among them.
    let step = trajectories.len().div_ceil(MOST_ENDS).max(1);
    for (salt, path) in trajectories.iter().step_by(step) {
        match last_frame(path) {
            Ok(bodies) => scenes.push(Scene {
                name: format!("the end at {} mM", millimolar(*salt)),
                bodies,
                colouring: None,
                film: None,
            }),
            Err(error) => unread.push(format!("{error:#}")),
        }
    }
    let box_angstrom = assembly.map_or(periodic_box, Assembly::box_angstrom);
    if let Some(lengths) = box_angstrom {
        for scene in &mut scenes {
            let positions = scene.bodies.iter_mut().map(|(_, pose)| &mut pose.position);
            // A cluster that crosses the border of the box is shown in one piece.
            gather(&mut positions.collect::<Vec<_>>(), lengths);
        }
    }
    match films(trajectories, step, box_angstrom) {
        Ok(films) => scenes.extend(films),
        Err(error) => unread.push(format!("{error:#}")),
    }
    (scenes, unread)
}

/// A film of the trajectories whose final states are shown: bodies where they are in the box.
fn films(
    trajectories: &[(f64, PathBuf)],
    step: usize,
    box_angstrom: Option<[f64; 3]>,
) -> Result<Vec<Scene>> {
    let chosen = trajectories.iter().step_by(step);
    let number = chosen.len();
    let mut films = Vec::new();
    for (salt, path) in chosen {
        let mut reader = TrajectoryReader::open(path)?;
        let total = reader.frames();
        // A film needs two frames.
        if total < 2 {
            continue;
        }
        let first = reader.frame(0)?;
        let bodies = first.poses.len().max(1);
        // All films together stay within the limit, and each has at least two frames.
        let most = (MOST_POSES / (number * bodies)).clamp(2, MOST_FRAMES) as u64;
        let frame_count = total.min(most);
        let mut frames = Vec::new();
        for place in 0..frame_count {
            // First and last frame are always chosen.
            let frame = reader.frame(place * (total - 1) / (frame_count - 1))?;
            frames.push((format!("sweep {}", frame.step), frame.poses));
        }
        let kinds = first.type_ids.into_iter().map(|kind| kind as usize);
        films.push(Scene {
            name: format!("film at {} mM", millimolar(*salt)),
            bodies: kinds.zip(first.poses).collect(),
            colouring: None,
            film: Some(Film {
                frames,
                box_angstrom,
            }),
        });
    }
    Ok(films)
}

/// Colours bodies by the potentials at the first and the last salt concentration, and by
/// hydropathy.
pub(crate) fn coloured(bodies: &[std::sync::Arc<Body>], settings: &RunSettings) -> Shown {
    let mut shown = Shown::default();
    for body in bodies {
        shown.meshes.push(ShownMesh {
            name: body.name.clone(),
            mesh: body.mesh.clone(),
            values: Vec::new(),
        });
    }
    let mut salts: Vec<f64> = settings.salt_molar.first().copied().into_iter().collect();
    salts.extend(settings.salt_molar.last());
    // A sweep of one salt names it twice.
    salts.dedup();
    let mut potentials = Vec::new();
    for salt in salts {
        if let Some(yukawa) = uncut(settings, salt) {
            let of_body = |body: &std::sync::Arc<Body>| potential_at_vertices(body, &yukawa);
            potentials.push((salt, bodies.iter().map(of_body).collect::<Vec<_>>()));
        }
    }
    let values = potentials.iter().flat_map(|(_, of_bodies)| of_bodies);
    // One limit for all salts and bodies, or colours could not be compared.
    let limit = limit_of(values.flatten().copied());
    for (salt, of_bodies) in potentials {
        shown.colourings.push(Colouring {
            name: format!("potential at {} mM", millimolar(salt)),
            unit: "screened potential of the body's charges, kT/e; beyond the ends: as at the ends"
                .into(),
            limit,
            colours: ["#c0282d", "#f7f7f7", "#2457b8"],
        });
        for (mesh, values) in shown.meshes.iter_mut().zip(of_bodies) {
            mesh.values.push(values);
        }
    }
    let mut residues = bodies.iter().flat_map(|body| &body.residues);
    if residues.any(|residue| residue.hydropathy.is_some()) {
        shown.colourings.push(Colouring {
            name: "hydropathy".into(),
            unit: format!(
                "{HYDROPATHY_SCALE} index, mean of residues within {HYDROPATHY_REACH_ANGSTROM} Å; positive: hydrophobic"
            ),
            limit: LARGEST_HYDROPATHY,
            colours: ["#1b8a9e", "#f7f7f7", "#b8741a"],
        });
        for (mesh, body) in shown.meshes.iter_mut().zip(bodies) {
            mesh.values.push(hydropathy_at_vertices(body));
        }
    }
    shown
}

/// The interaction of the run without its cut-off, because colours should not depend on the
/// cut-off.
fn uncut(settings: &RunSettings, salt_molar: f64) -> Option<Yukawa> {
    let interaction = settings.medium.interaction(Some(salt_molar)).ok()?;
    let electrolyte = &interaction.electrolyte;
    Yukawa::in_electrolyte(electrolyte, f64::INFINITY).ok()
}

/// Computes φ(r) = λ_B Σ q exp(-κ d)/d over the charges at distance d, kT/e.
fn potential_at_vertices(body: &Body, yukawa: &Yukawa) -> Vec<f64> {
    let evaluate = |vertex: &Vec3| {
        let mut potential = 0.0;
        for site in &body.sites {
            // Most sites have no charge.
            if site.charge_e != 0.0 {
                let distance = (vertex - site.position).norm();
                potential += site.charge_e * yukawa.energy_kt(distance);
            }
        }
        potential
    };
    body.mesh.vertices.par_iter().map(evaluate).collect()
}

fn hydropathy_at_vertices(body: &Body) -> Vec<f64> {
    let residues = body.residues.iter();
    let values: Vec<Option<f64>> = residues.map(|residue| residue.hydropathy).collect();
    let places = body.sites.iter().map(|site| (site.position, site.residue));
    let map = HydropathyMap::new(places, &values, HYDROPATHY_REACH_ANGSTROM);
    body.mesh
        .vertices
        .par_iter()
        .map(|vertex| map.value_at(vertex).unwrap_or(f64::NAN))
        .collect()
}

/// The smallest scale that covers 95 % of the values.
fn limit_of(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values
        .map(f64::abs)
        .filter(|size| size.is_finite())
        .collect();
    sizes.sort_by(f64::total_cmp);
    let most = sizes
        // The 95th percentile: a few vertices next to a charge would wash out the rest.
        .get((sizes.len() * 95 / 100).min(sizes.len().saturating_sub(1)))
        .copied()
        .unwrap_or(0.0);
    let [.., largest] = POTENTIAL_LIMITS;
    POTENTIAL_LIMITS
        .into_iter()
        .find(|limit| *limit >= most)
        .unwrap_or(largest)
}

/// A mesh in HOOMD's schema.
#[derive(Debug, Deserialize)]
struct Shape {
    vertices: Vec<[f64; 3]>,
    indices: Vec<[u32; 3]>,
}

/// The shapes of the particle types of a trajectory.
fn shapes(path: &Path) -> Result<Vec<ShownMesh>> {
    let mut file = GsdFile::open(path)?;
    let names = texts(&mut file, path, "particles/types")?;
    let shapes = texts(&mut file, path, "particles/type_shapes")?;
    let shown = names.into_iter().zip(shapes).map(|(name, text)| {
        let context = || format!("{} has no mesh of body '{name}'", path.display());
        let Shape { vertices, indices } = serde_json::from_str(&text).with_context(context)?;
        // Indices come from a file and are used to read vertices later.
        if indices
            .iter()
            .flatten()
            .any(|corner| *corner as usize >= vertices.len())
        {
            bail!(
                "{}: the mesh of body '{name}' refers to a vertex that does not exist",
                path.display()
            );
        }
        let mesh = TriangleMesh {
            vertices: vertices.into_iter().map(Vec3::from).collect(),
            triangles: indices,
        };
        Ok(ShownMesh {
            name,
            mesh,
            values: Vec::new(),
        })
    });
    shown.collect()
}

fn texts(file: &mut GsdFile, path: &Path, name: &str) -> Result<Vec<String>> {
    let texts = file.chunk(0, name)?.and_then(|chunk| chunk.texts());
    texts.with_context(|| format!("{} has no {name}", path.display()))
}

/// Reads type and pose of each body in the last frame.
fn last_frame(path: &Path) -> Result<Vec<(usize, Pose)>> {
    let mut reader = TrajectoryReader::open(path)?;
    let Some(last) = reader.frames().checked_sub(1) else {
        bail!("{} has no frame yet", path.display())
    };
    let frame = reader.frame(last)?;
    let kinds = frame.type_ids.into_iter().map(|kind| kind as usize);
    Ok(kinds.zip(frame.poses).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        assert_eq!(
            limit_of((0..100).map(|k| if k < 96 { -3.0 } else { 900.0 })),
            5.0
        );
        assert_eq!(limit_of(std::iter::empty()), 0.5);
        assert_eq!(limit_of(std::iter::once(1e9)), 20.0);
    }
}
