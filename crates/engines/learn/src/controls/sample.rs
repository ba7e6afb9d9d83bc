//! Each control's samples: what is drawn, how it is labelled, what belongs to one cluster.

use super::assemblies::{COPIES, ring, voxels};
use super::blob::Blob;
use super::protein::{EXTENT_ANGSTROM, Protein, SITES};
use super::raster::{filled, volume};
use super::solids::{SOLIDS, random_solid};
use super::{Control, Variant};
use crate::sample::{Description, SparseGrid};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::{PI, TAU};

/// Orientations of each protein of the control `identity`.
const ORIENTATIONS: usize = 16;
/// Orientations of each protein of the control `permuted`.
const SIBLINGS: usize = 4;
/// Volume of a residue, Å³.
const RESIDUE_ANGSTROM3: f64 = 135.0;

/// Settings that all samples of a set share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Recipe {
    pub(super) control: Control,
    pub(super) variant: Variant,
    pub(super) samples: usize,
    pub(super) size: usize,
    pub(super) seed: u64,
}

impl Recipe {
    fn random(&self, purpose: Purpose, step: usize) -> CounterRng {
        CounterRng::for_purpose(self.seed, self.control as u32, step as u64, purpose)
    }

    /// A sample and what is known of it.
    pub(super) fn sample(&self, number: usize) -> (Description, SparseGrid) {
        match self.control {
            Control::Shapes => self.shape(number),
            Control::Charge => self.charged(number, false),
            Control::HeavyTails => self.charged(number, true),
            Control::Patch => self.patch(number),
            Control::Xor => self.xor(number),
            Control::Assemblies => self.assembly(number),
            Control::Permuted => self.permuted(number),
            Control::Identity => self.identity(number),
            Control::Orientation => self.orientation(number),
            Control::Size => self.size(number),
        }
    }

    fn shape(&self, number: usize) -> (Description, SparseGrid) {
        let kind = number % SOLIDS.len();
        let voxels = random_solid(kind, self.size, &mut self.random(Purpose::Object, number));
        let label = SOLIDS.get(kind).copied().unwrap_or_default();
        (
            plain(number, label, volume(&voxels)),
            one_channel(self.size, voxels),
        )
    }

    /// Net charge of one sign or the other, spread over the whole protein among neutral pairs.
    fn charged(&self, number: usize, heavy_tails: bool) -> (Description, SparseGrid) {
        let is_positive = number.is_multiple_of(2);
        let protein = self.charged_protein(number, is_positive);
        let label = if is_positive { "positive" } else { "negative" };
        let (description, mut grid) = self.render(number, label, &name(number), &protein);
        if heavy_tails {
            self.damage(number, &mut grid);
        }
        (description, grid)
    }

    /// A protein with a net charge of 4 to 9 e of this sign.
    fn charged_protein(&self, number: usize, is_positive: bool) -> Protein {
        let random = &mut self.random(Purpose::Object, number);
        let mut protein = Protein::random(random);
        let (pairs, net) = (6 + random.index(5), 4 + random.index(6));
        if is_positive {
            protein.charge(pairs + net, pairs, random);
        } else {
            protein.charge(pairs, pairs + net, random);
        }
        protein
    }

    /// Puts potentials of random sign from 10 to 10⁵ kT/e into one surface voxel in fifty, as next
    /// to a charge that touches the surface or where a solver failed.
    fn damage(&self, number: usize, grid: &mut SparseGrid) {
        let random = &mut self.random(Purpose::Damage, number);
        let count = grid.index.len();
        for value in &mut grid.values[count..2 * count] {
            if random.uniform() < 0.02 {
                let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
                *value = (sign * 10f64.powf(random.uniform_in(1.0, 5.0))) as f32;
            }
        }
    }

    /// A hydrophobic patch over much or little of the surface.
    fn patch(&self, number: usize) -> (Description, SparseGrid) {
        let random = &mut self.random(Purpose::Object, number);
        let mut protein = Protein::random(random);
        let is_large = number.is_multiple_of(2);
        let share = if is_large {
            random.uniform_in(0.45, 0.65)
        } else {
            random.uniform_in(0.05, 0.25)
        };
        let painted = patch_of_sites(&protein, share, random);
        for ((_, hydropathy), is_painted) in protein.sites.iter_mut().zip(painted) {
            *hydropathy = if is_painted {
                random.uniform_in(1.5, 4.5)
            } else {
                random.uniform_in(-4.5, 0.5)
            };
        }
        let label = if is_large { "large" } else { "small" };
        self.render(number, label, &name(number), &protein)
    }

    /// A patch that is positive or negative, and hydrophobic or hydrophilic: the label is whether
    /// the signs agree.
    fn xor(&self, number: usize) -> (Description, SparseGrid) {
        let random = &mut self.random(Purpose::Object, number);
        let mut protein = Protein::random(random);
        let share = random.uniform_in(0.35, 0.55);
        let painted = patch_of_sites(&protein, share, random);
        let (is_positive, is_hydrophobic) = (number & 1 == 0, number & 2 == 0);
        for ((_, hydropathy), is_painted) in protein.sites.iter_mut().zip(&painted) {
            *hydropathy = if *is_painted {
                sign(is_hydrophobic) * random.uniform_in(1.5, 4.5)
            } else {
                random.uniform_in(-2.0, 2.0)
            };
        }
        let mut places = Vec::new();
        for ((place, _), is_painted) in protein.sites.iter().zip(painted) {
            if is_painted {
                places.push(*place);
            }
        }
        for _ in 0..8 {
            // Below the surface, under a random site of the patch, which has one or more.
            let below = places[random.index(places.len())] * 0.8;
            protein.charges.push((below, sign(is_positive)));
        }
        let label = if is_positive == is_hydrophobic {
            "agree"
        } else {
            "disagree"
        };
        self.render(number, label, &name(number), &protein)
    }

    /// All numbers of copies of each blob, which is their cluster.
    fn assembly(&self, number: usize) -> (Description, SparseGrid) {
        let (which, copies) = (number / COPIES.len(), COPIES[number % COPIES.len()]);
        let blob = Blob::random(&mut self.random(Purpose::Object, which));
        let turn = &mut self.random(Purpose::Turn, number);
        let voxels = voxels(&ring(&blob, copies), self.size, turn);
        let mut description = plain(number, &format!("C{copies}"), volume(&voxels));
        description.cluster = name(which);
        (description, one_channel(self.size, voxels))
    }

    /// The charge control in several orientations, with labels dealt out to the proteins at random.
    fn permuted(&self, number: usize) -> (Description, SparseGrid) {
        let which = number / SIBLINGS;
        let protein = self.charged_protein(which, which.is_multiple_of(2));
        let proteins = self.samples.div_ceil(SIBLINGS);
        let is_positive = self.dealt(which, proteins).is_multiple_of(2);
        let label = if is_positive { "positive" } else { "negative" };
        self.render(number, label, &name(which), &protein)
    }

    /// One protein in several orientations, with a label that follows from nothing but which
    /// protein it is.
    fn identity(&self, number: usize) -> (Description, SparseGrid) {
        let which = number / ORIENTATIONS;
        let random = &mut self.random(Purpose::Object, which);
        let mut protein = Protein::random(random);
        let (positive, negative) = (4 + random.index(8), 4 + random.index(8));
        protein.charge(positive, negative, random);
        let proteins = self.samples.div_ceil(ORIENTATIONS);
        let is_even = self.dealt(which, proteins).is_multiple_of(2);
        let label = if is_even { "even" } else { "odd" };
        self.render(number, label, &name(which), &protein)
    }

    /// Place of `which` among `count` in an order that depends on the seed alone: labels by it are
    /// balanced.
    fn dealt(&self, which: usize, count: usize) -> usize {
        let key = |i: usize| (self.random(Purpose::Label, i).uniform(), i);
        let limit = key(which);
        (0..count).filter(|i| key(*i) < limit).count()
    }

    /// A rod deposited along an axis of the frame or along a diagonal.
    fn orientation(&self, number: usize) -> (Description, SparseGrid) {
        let is_along_axis = number.is_multiple_of(2);
        let rod = Blob::rod(&mut self.random(Purpose::Object, number));
        let turn = &mut self.random(Purpose::Turn, number);
        let direction = if is_along_axis {
            [Vec3::x(), Vec3::y(), Vec3::z()][turn.index(3)]
        } else {
            let (x, y) = (sign(turn.uniform() >= 0.5), sign(turn.uniform() >= 0.5));
            Vec3::new(x, y, 1.0).normalize()
        };
        let about_itself = Rotation::from_axis_angle(&Vec3::z_axis(), turn.uniform_in(0.0, TAU));
        let half_turn = Rotation::from_axis_angle(&Vec3::x_axis(), PI);
        let upright = Rotation::rotation_between(&Vec3::z(), &direction).unwrap_or(half_turn);
        let deposited = upright * about_itself;
        let rotation = match self.variant {
            Variant::Turned => turn.rotation() * deposited,
            _ => deposited,
        };
        let placed = rod.turned(&rotation).scaled(self.widest());
        let voxels = filled(self.size, |p| placed.distance(p));
        let label = match is_along_axis {
            true => "along an axis",
            false => "along a diagonal",
        };
        let description = plain(number, label, volume(&voxels));
        (description, one_channel(self.size, voxels))
    }

    /// Blobs of one kind whose volume says how many residues they have. Scaled to one extent it
    /// says nothing.
    fn size(&self, number: usize) -> (Description, SparseGrid) {
        const MEDIAN: f64 = 200.0;
        let random = &mut self.random(Purpose::Object, number);
        let is_large = number.is_multiple_of(2);
        let spread = 4f64.powf(random.uniform());
        let residues = if is_large {
            MEDIAN * spread
        } else {
            MEDIAN / spread
        };
        let blob = Blob::random(random).turned(&self.random(Purpose::Turn, number).rotation());
        let full = blob.scaled(self.widest());
        let draw = |blob: &Blob| filled(self.size, |p| blob.distance(p));
        let mut voxels = draw(&full);
        if self.variant != Variant::FillingTheBox {
            // A volume in proportion to the residues; the largest of the thinnest blobs still fit
            // the box.
            let wanted = 0.11 * (2.0 * self.widest()).powi(3) * residues / (4.0 * MEDIAN);
            voxels = draw(&full.scaled((wanted / volume(&voxels)).cbrt().min(1.0)));
        }
        let mut description = plain(number, if is_large { "large" } else { "small" }, 0.0);
        description.residues = residues.round();
        (description, one_channel(self.size, voxels))
    }

    /// The largest extent that leaves a margin of one voxel, in voxels.
    fn widest(&self) -> f64 {
        self.size as f64 / 2.0 - 1.0
    }

    /// The three channels of a protein, turned at random, and what is known of it.
    fn render(
        &self,
        number: usize,
        label: &str,
        cluster: &str,
        protein: &Protein,
    ) -> (Description, SparseGrid) {
        let rotation = self.random(Purpose::Turn, number).rotation();
        let (index, values) = protein.voxels(self.size, &rotation);
        let volume_angstrom3 = 0.25 * (2.0 * EXTENT_ANGSTROM).powi(3);
        let description = Description {
            name: name(number),
            label: label.into(),
            cluster: cluster.into(),
            residues: (volume_angstrom3 / RESIDUE_ANGSTROM3).round(),
            radius_of_gyration_angstrom: protein.blob.radius_of_gyration(),
            extents_angstrom: protein.blob.extents(),
            net_charge_e: protein.net_charge(),
            composition: [0.05; 20],
            ..Description::default()
        };
        let grid = SparseGrid {
            size: self.size,
            channels: values.len(),
            index,
            values: values.concat(),
        };
        (description, grid)
    }
}

fn sign(is_positive: bool) -> f64 {
    if is_positive { 1.0 } else { -1.0 }
}

/// Whether each site belongs to a patch over this share of the sites: those farthest along a random
/// direction do.
fn patch_of_sites(protein: &Protein, share: f64, random: &mut CounterRng) -> Vec<bool> {
    let direction = random.unit_vector();
    let heights: Vec<f64> = protein
        .sites
        .iter()
        .map(|site| direction.dot(&site.0))
        .collect();
    let mut descending = heights.clone();
    descending.sort_by(|a, b| b.total_cmp(a));
    let last = ((share * SITES as f64).round() as usize).clamp(1, SITES) - 1;
    heights
        .into_iter()
        .map(|height| height >= descending[last])
        .collect()
}

/// A name that sorts by number.
fn name(number: usize) -> String {
    format!("{number:06}")
}

/// A sample in a separate cluster, of so many filled voxels, taken to be of 3 Å.
fn plain(number: usize, label: &str, volume_voxels: f64) -> Description {
    const VOXEL_ANGSTROM3: f64 = 27.0;
    Description {
        name: name(number),
        label: label.into(),
        cluster: name(number),
        residues: (volume_voxels * VOXEL_ANGSTROM3 / RESIDUE_ANGSTROM3).round(),
        composition: [0.05; 20],
        ..Description::default()
    }
}

fn one_channel(size: usize, voxels: Vec<(u32, f32)>) -> SparseGrid {
    let (index, values) = voxels.into_iter().unzip();
    SparseGrid {
        size,
        channels: 1,
        index,
        values,
    }
}
