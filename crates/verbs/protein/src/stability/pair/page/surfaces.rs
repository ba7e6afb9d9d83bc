//! The surfaces of two bodies in their best pose, coloured by what each residue contributes to its
//! energy.
//!
//! A vertex belongs to the residue of the nearest atom. Both bodies have separate meshes, also
//! where they are equal: their residues differ in what they contribute.

use crate::stability::pair::{
    ConditionResult, PairBodies, PairResult, PoseResult, ResiduePlaces, ResidueTable,
};
use crate::stability::sweep::page::bodies::MOST_VERTICES;
use anyhow::{Context, Result};
use protomer_body::Body;
use protomer_common::page::scene::{Colouring, Scene, Shown, ShownMesh};
use protomer_common::page::{Data, Part, Section, millimolar};
use protomer_kernel::{Pose, Vec3};
use protomer_results::Record;
use rayon::prelude::*;
use std::path::Path;

/// Conditions in the menu, evenly chosen from those with a bound pose.
const MOST_CONDITIONS: usize = 8;
/// Possible ends of the scale, kT.
const LIMITS_KT: [f64; 9] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

const UNIT: &str = "what a residue contributes to the energy of the best pose, kT; negative (red): it holds the bodies together";
const NOTE: &str = "Energies are shared out by residue, and a point of the surface belongs to the residue of the nearest atom. \
                    A pair of residues counts in full with both. The numbers, below 0.01 kT left out:";

/// The section, if a pose is bound and has surfaces to show; remarks on what is missing otherwise.
#[derive(Debug, Default)]
pub struct Collected {
    /// The viewer with its tables.
    pub section: Option<Section>,
    /// Remarks on what is missing, and why.
    pub notes: Vec<String>,
}

/// Collects the best poses of a directory.
///
/// # Errors
/// If a table of residues is damaged.
pub fn collect(
    directory: &Path,
    record: Option<&Record>,
    result: &PairResult,
) -> Result<Collected> {
    let folders = result.folders();
    let mut bound = Vec::new();
    // Conditions without a bound pose show nothing.
    for (condition, folder) in result.conditions.iter().zip(&folders) {
        if let Some(pose) = condition.poses.first() {
            bound.push((condition, pose, folder.as_str()));
        }
    }
    // Evenly chosen, so that the menu spans the whole range.
    let step = bound.len().div_ceil(MOST_CONDITIONS).max(1);
    let (Some(record), false) = (record, bound.is_empty()) else {
        return Ok(Collected::default());
    };
    let bodies = match PairBodies::of_results(directory, record, &result.settings) {
        Ok(bodies) => bodies,
        Err(error) => {
            return Ok(without(format!(
                "The surfaces are not shown, because the files of the bodies were not found ({error:#})."
            )));
        }
    };
    let mut surfaces = Surfaces::default();
    let mut tables = Vec::new();
    for (condition, pose, folder) in bound.into_iter().step_by(step) {
        let of_condition = bodies
            .bodies_at(condition.ph)
            .context("a condition at an unknown pH")?;
        let table = ResidueTable::read(&directory.join(folder))?;
        let energies_kt = table.energies_kt(of_condition, 1)?;
        surfaces.add(condition, pose, of_condition, energies_kt);
        tables.push(Part::Data(Data::Table {
            name: format!("{folder}/residues.csv"),
            csv: table.csv,
        }));
    }
    let vertices = surfaces.vertices();
    if vertices > MOST_VERTICES {
        return Ok(without(format!(
            "The surfaces have {vertices} vertices, which is more than a page can show ({MOST_VERTICES})."
        )));
    }
    let (note, tables) = match surfaces.have_residues() {
        true => (NOTE, tables),
        false => (
            "The bodies have no residues, so nothing is coloured.",
            Vec::new(),
        ),
    };
    let mut parts = vec![Part::Scenes(surfaces.shown()), Part::Paragraph(note.into())];
    parts.extend(tables);
    Ok(Collected {
        section: Some(Section::new("Bodies", parts)),
        notes: Vec::new(),
    })
}

fn without(note: String) -> Collected {
    Collected {
        section: None,
        notes: vec![note],
    }
}

/// The best poses of some conditions.
#[derive(Default)]
struct Surfaces {
    meshes: Vec<Surface>,
    poses: Vec<BestPose>,
}

/// The surface of the first or second body; at another pH it may be another.
struct Surface {
    /// Number of the body, 0 or 1.
    body: usize,
    shown: ShownMesh,
    /// The residue of each vertex.
    residues: Vec<Option<usize>>,
}

struct BestPose {
    name: String,
    meshes: [usize; 2],
    second: Pose,
    energies_kt: [Vec<f64>; 2],
}

impl Surfaces {
    fn add(
        &mut self,
        condition: &ConditionResult,
        pose: &PoseResult,
        bodies: [&Body; 2],
        energies_kt: [Vec<f64>; 2],
    ) {
        let meshes = [0, 1].map(|body| self.mesh_of(body, bodies[body]));
        let position = Vec3::from(pose.position_angstrom);
        self.poses.push(BestPose {
            name: name(condition),
            meshes,
            second: Pose::from_wxyz(position, pose.orientation_wxyz),
            energies_kt,
        });
    }

    /// The number of a body's surface, which is kept if it is new.
    fn mesh_of(&mut self, number: usize, body: &Body) -> usize {
        // Charges differ with pH, surfaces rarely: equal ones are stored once.
        let index = self.meshes.iter().position(|surface| {
            surface.body == number
                && surface.shown.mesh == body.mesh
                && surface.shown.name == body.name
        });
        index.unwrap_or_else(|| {
            let places = ResiduePlaces::from_body(body);
            let vertices = body.mesh.vertices.par_iter();
            let residues = vertices.map(|vertex| places.nearest(vertex));
            self.meshes.push(Surface {
                body: number,
                shown: ShownMesh {
                    name: body.name.clone(),
                    mesh: body.mesh.clone(),
                    values: Vec::new(),
                },
                residues: residues.collect(),
            });
            self.meshes.len() - 1
        })
    }

    fn vertices(&self) -> usize {
        let meshes = self.meshes.iter();
        meshes
            .map(|surface| surface.shown.mesh.vertices.len())
            .sum()
    }

    fn have_residues(&self) -> bool {
        let mut energies = self.poses.iter().flat_map(|pose| &pose.energies_kt);
        energies.any(|of_body| !of_body.is_empty())
    }

    /// One scale for all poses, so that they can be compared.
    fn limit_kt(&self) -> f64 {
        let energies = self.poses.iter().flat_map(|pose| &pose.energies_kt);
        limit_of(energies.flatten().copied())
    }

    fn shown(mut self) -> Shown {
        let (mut shown, limit) = (Shown::default(), self.limit_kt());
        let coloured = self.have_residues();
        for (number, pose) in self.poses.iter().enumerate() {
            let [first, second] = pose.meshes;
            shown.scenes.push(Scene {
                name: format!("best pose{}", pose.name),
                bodies: vec![(first, Pose::identity()), (second, pose.second)],
                colouring: coloured.then_some(number),
                film: None,
            });
            // Each pose has a colouring of its own, which its scene chooses.
            if coloured {
                shown.colourings.push(Colouring {
                    name: format!("residues{}", pose.name),
                    unit: UNIT.into(),
                    limit,
                    colours: ["#c0282d", "#f7f7f7", "#2457b8"],
                });
                for (mesh, surface) in self.meshes.iter_mut().enumerate() {
                    let energies_kt = match mesh {
                        mesh if mesh == first => pose.energies_kt[0].as_slice(),
                        mesh if mesh == second => pose.energies_kt[1].as_slice(),
                        // The surface of another pH.
                        _ => &[],
                    };
                    let of_residue = |residue: &Option<usize>| {
                        let energy_kt = residue.and_then(|residue| energies_kt.get(residue));
                        energy_kt.copied().unwrap_or(f64::NAN)
                    };
                    let values = surface.residues.iter().map(of_residue).collect();
                    surface.shown.values.push(values);
                }
            }
        }
        for (mesh, surface) in self.meshes.into_iter().enumerate() {
            let which = ["first", "second"][surface.body];
            shown.scenes.push(Scene {
                name: format!("{which} body, {}", surface.shown.name),
                bodies: vec![(mesh, Pose::identity())],
                colouring: None,
                film: None,
            });
            shown.meshes.push(surface.shown);
        }
        shown
    }
}

/// End of a name that tells a condition from others.
fn name(condition: &ConditionResult) -> String {
    let ph = condition.ph.map(|ph| format!("pH {ph}"));
    let salt = condition
        .salt_molar
        .map(|salt| format!("{} mM", millimolar(salt)));
    let parts: Vec<String> = ph.into_iter().chain(salt).collect();
    match parts.is_empty() {
        true => String::new(),
        false => format!(", {}", parts.join(", ")),
    }
}

/// The smallest scale that covers all values.
pub(crate) fn limit_of(values: impl Iterator<Item = f64>) -> f64 {
    let most = values.map(f64::abs).fold(0.0, f64::max);
    let [.., largest] = LIMITS_KT;
    let mut limits = LIMITS_KT.into_iter();
    limits.find(|limit| *limit >= most).unwrap_or(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_cover_all_values_and_end_at_round_numbers() {
        assert_eq!(limit_of([0.3, -1.7].into_iter()), 2.0);
        assert_eq!(limit_of([-5.0].into_iter()), 5.0);
        assert_eq!(limit_of(std::iter::empty()), 0.1);
        assert_eq!(limit_of([1e3].into_iter()), 50.0);
    }
}
