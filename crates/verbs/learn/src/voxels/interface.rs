//! A pose of two bodies to one sample. Bodies are made once and placed for each of their poses.

use super::manifest::{Entry, Partner};
use super::settings::{Spacing, VoxelizeSettings};
use super::structure::{
    Checked, Excluded, MOST_WARNINGS, Properties, Reason, Sample, amino_acids_of, at_most,
    check_values, composition, density_of, extents, key_of, no_voxels, radius_of_gyration, read,
};
use anyhow::anyhow;
use protomer_body::chemistry::AminoAcid;
use protomer_field::ChargedSphere;
use protomer_field::voxels::interface::{InterfaceBody, interface_middle, voxelise_interface};
use protomer_field::voxels::{Lattice, VoxelAtom};
use protomer_kernel::{Pose, Vec3};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Bodies that are kept for their next poses: a few per thread of a usual machine.
const MOST_KEPT: usize = 24;

/// A body of an interface with what is known of it besides its voxels.
struct ReadBody {
    body: InterfaceBody,
    /// Atoms in the frame of the body.
    atoms: Vec<VoxelAtom>,
    /// Origin of the frame in the file, Å.
    origin: Vec3,
    amino_acids: Vec<AminoAcid>,
    net_charge_e: f64,
    warnings: Vec<String>,
}

/// The bodies of the latest poses, by file and chains.
#[derive(Default)]
pub struct InterfaceBodies {
    latest: Mutex<VecDeque<(String, Arc<ReadBody>)>>,
}

impl InterfaceBodies {
    /// A body, made unless it is kept. Two threads may make the same one, which costs time only.
    fn get(
        &self,
        path: &Path,
        chains: &[String],
        settings: &VoxelizeSettings,
    ) -> Checked<Arc<ReadBody>> {
        let key = format!("{} {}", path.display(), chains.join("+"));
        let latest = || self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let earlier = latest().iter().find(|(name, _)| *name == key).cloned();
        if let Some((_, body)) = earlier {
            return Ok(body);
        }
        // Not under the lock: others go on with bodies that are there.
        let body = Arc::new(ReadBody::new(path, chains, settings)?);
        let mut latest = latest();
        latest.push_back((key, body.clone()));
        if latest.len() > MOST_KEPT {
            latest.pop_front();
        }
        Ok(body)
    }

    /// The sample of a pose.
    ///
    /// # Errors
    /// The reason why there is none.
    pub(super) fn sample(
        &self,
        entry: &Entry,
        partner: &Partner,
        settings: &VoxelizeSettings,
    ) -> Checked<Sample> {
        let pair = [
            self.get(&entry.path, &partner.chains, settings)?,
            self.get(&partner.path, &partner.partner_chains, settings)?,
        ];
        let bodies = pair.each_ref().map(|read| &read.body);
        let pose_of = |origin: Vec3, outer: &Pose| {
            let at_origin = Pose {
                position: origin,
                ..Pose::identity()
            };
            at_origin.then(outer)
        };
        let in_file = [
            pose_of(pair[0].origin, &Pose::identity()),
            pose_of(pair[1].origin, &partner.pose),
        ];
        let middle = interface_middle(bodies, &in_file).map_err(no_voxels)?;
        let mut positions = Vec::new();
        for (read, pose) in pair.iter().zip(&in_file) {
            let places = read.atoms.iter().map(|atom| &atom.sphere.centre);
            positions.extend(places.map(|place| pose.transform_point(place)));
        }
        let key = key_of(&entry.name);
        let rotation = settings
            .orientation
            .rotation(&positions, settings.seed, key);
        // A point p of the first file goes to R p - R m.
        let turned_middle = rotation * middle;
        let turn = Pose {
            position: -turned_middle,
            rotation,
        };
        let poses = in_file.each_ref().map(|pose| pose.then(&turn));
        let spacing = match settings.spacing {
            Spacing::Angstrom(spacing) => spacing,
            Spacing::Fit(_) => {
                let error = anyhow!("interfaces have voxels of one size; give --spacing in Å");
                return Err(Excluded(Reason::Failed, error));
            }
        };
        let lattice = Lattice::new(settings.size, spacing);
        let lattice = lattice.map_err(no_voxels)?;
        let failed = |error| Excluded(Reason::Failed, error);
        let voxel_settings = settings.voxel_settings().map_err(failed)?;
        let voxels = voxelise_interface(bodies, &poses, &lattice, &voxel_settings);
        let voxels = voxels.map_err(no_voxels)?;
        if voxels.index.is_empty() {
            let error = anyhow!("the bodies do not touch: no voxel of one is near the other");
            return Err(Excluded(Reason::Failed, error));
        }
        check_values(&voxels, &settings.channels)
            .map_err(|error| Excluded(Reason::Potential, error))?;
        let atoms: Vec<VoxelAtom> = pair
            .iter()
            .zip(&poses)
            .flat_map(|(read, pose)| read.atoms.iter().map(move |atom| placed(atom, pose)))
            .collect();
        let amino_acids = [&pair[0].amino_acids[..], &pair[1].amino_acids[..]].concat();
        let warnings = [&pair[0].warnings[..], &pair[1].warnings[..]].concat();
        Ok(Sample {
            properties: Properties {
                residues: amino_acids.len(),
                radius_of_gyration_angstrom: radius_of_gyration(&positions),
                extents_angstrom: extents(&atoms),
                net_charge_e: pair[0].net_charge_e + pair[1].net_charge_e,
                spacing_angstrom: spacing,
                rotation_wxyz: turn.wxyz(),
                middle_angstrom: turned_middle.into(),
                composition: composition(&amino_acids),
            },
            voxels,
            warnings: at_most(MOST_WARNINGS, warnings),
        })
    }
}

fn placed(atom: &VoxelAtom, pose: &Pose) -> VoxelAtom {
    VoxelAtom {
        sphere: ChargedSphere {
            centre: pose.transform_point(&atom.sphere.centre),
            ..atom.sphere
        },
        ..*atom
    }
}

impl ReadBody {
    fn new(path: &Path, chains: &[String], settings: &VoxelizeSettings) -> Checked<Self> {
        let content = read("body", path, chains, settings, density_of(None))?;
        let amino_acids = amino_acids_of(&content, settings)?;
        let surface = content.draft.exact_surface();
        let surface = surface.map_err(|error| Excluded(Reason::Failed, error.into()))?;
        let sites = content.draft.sites();
        let atom = |site: &protomer_body::Site| VoxelAtom {
            sphere: ChargedSphere {
                centre: site.position,
                radius_angstrom: site.radius_angstrom,
                charge_e: site.charge_e,
            },
            residue: site.residue,
        };
        let atoms: Vec<VoxelAtom> = sites.sites.iter().map(atom).collect();
        let residues = sites.residues.iter();
        let hydropathy: Vec<Option<f64>> = residues.map(|residue| residue.hydropathy).collect();
        let voxel_settings = settings.voxel_settings();
        let voxel_settings = voxel_settings.map_err(|error| Excluded(Reason::Failed, error))?;
        let reach = settings
            .interface_reach_angstrom
            .unwrap_or(VoxelizeSettings::INTERFACE_REACH_ANGSTROM);
        let body = InterfaceBody::new(surface, &atoms, &hydropathy, &voxel_settings, reach);
        Ok(Self {
            body: body.map_err(no_voxels)?,
            atoms,
            origin: sites.origin_angstrom,
            amino_acids,
            net_charge_e: sites.net_charge_e(),
            warnings: content.warnings,
        })
    }
}
