//! Which residues of two bodies touch, and whether the bodies are in one frame at all.

use super::input::{Partners, in_frame};
use crate::stability::affinity::{ContactAffinity, FARTHEST_CONTACT_ANGSTROM};
use anyhow::{Result, bail};
use protomer_body::chemistry::residue_names::parent_amino_acid;
use protomer_body::structure::IncompleteResidue;
use protomer_body::{Body, Residue};
use protomer_common::answer::counted;
use protomer_kernel::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Heavy atoms nearer than this are a contact of their residues, Å.
const CONTACT_ANGSTROM: f64 = 4.5;
/// A residue with a heavy atom nearer than this to the partner is at the interface, Å.
pub(in crate::stability) const NEAR_ANGSTROM: f64 = 5.0;
/// Bodies farther apart than this form no complex, Å.
const FARTHEST_ANGSTROM: f64 = 10.0;
/// Atoms of two molecules that are nearer than this are in conflict, Å: a hydrogen bond has 2.5 Å, a
/// disulfide 2.05 Å.
const CONFLICT_ANGSTROM: f64 = 2.0;
/// Largest share of the atoms of the smaller body in conflict; with more, one body is within the
/// other.
const MOST_IN_CONFLICT: f64 = 0.05;
/// Residues that a warning names.
const MOST_NAMED: usize = 12;

/// Interface of two bodies.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::stability) struct Interface {
    /// Distance of the closest heavy atoms, Å.
    pub closest_angstrom: f64,
    /// Distance of the closest heavy atoms of pairs of residues, Å, as far as contacts of any kind reach.
    pub nearest_angstrom: BTreeMap<(u32, u32), f64>,
    /// Residues of each body at the interface.
    pub near: [BTreeSet<u32>; 2],
    /// Atoms of the body that has more of them too close to the other.
    pub clashing_atoms: usize,
    /// Warnings about the interface.
    pub warnings: Vec<String>,
}

/// A heavy atom in the frame of the files.
struct Atom {
    place: Vec3,
    residue: Option<u32>,
}

impl Interface {
    /// # Errors
    /// For bodies that are far from each other or within each other.
    pub fn find(partners: &Partners) -> Result<Self> {
        let [first, second] = partners.bodies.each_ref().map(|body| heavy_atoms(body));
        let mut interface = Self {
            closest_angstrom: f64::INFINITY,
            nearest_angstrom: BTreeMap::new(),
            near: [BTreeSet::new(), BTreeSet::new()],
            clashing_atoms: 0,
            warnings: Vec::new(),
        };
        let mut in_conflict = [BTreeSet::new(), BTreeSet::new()];
        for (i, a) in first.iter().enumerate() {
            for (j, b) in second.iter().enumerate() {
                let distance = (a.place - b.place).norm();
                interface.closest_angstrom = interface.closest_angstrom.min(distance);
                if distance < NEAR_ANGSTROM {
                    interface.near[0].extend(a.residue);
                    interface.near[1].extend(b.residue);
                }
                if let (true, Some(a), Some(b)) =
                    (distance < FARTHEST_CONTACT_ANGSTROM, a.residue, b.residue)
                {
                    let nearest = interface.nearest_angstrom.entry((a, b)).or_insert(distance);
                    *nearest = nearest.min(distance);
                }
                if distance < CONFLICT_ANGSTROM {
                    in_conflict[0].insert(i);
                    in_conflict[1].insert(j);
                }
            }
        }
        let shares = [
            in_conflict[0].len() as f64 / first.len().max(1) as f64,
            in_conflict[1].len() as f64 / second.len().max(1) as f64,
        ];
        interface.require_one_frame(partners, shares)?;
        interface.clashing_atoms = in_conflict[0].len().max(in_conflict[1].len());
        interface.warn_of_place();
        interface.warn_of_missing_atoms(partners);
        interface.warn_of_residues_without_scale(partners);
        Ok(interface)
    }

    /// Pairs of residues in contact.
    pub fn contacts(&self) -> usize {
        let distances = self.nearest_angstrom.values();
        distances
            .filter(|distance| **distance < CONTACT_ANGSTROM)
            .count()
    }

    /// The contacts as the calibrated affinity counts them.
    pub fn affinity(&self, partners: &Partners) -> ContactAffinity {
        let residues = partners
            .bodies
            .each_ref()
            .map(|body| body.residues.as_slice());
        ContactAffinity::new(residues, &self.nearest_angstrom)
    }

    fn require_one_frame(&self, partners: &Partners, in_conflict: [f64; 2]) -> Result<()> {
        let [first, second] = partners.bodies.each_ref().map(|body| &body.name);
        let closest = self.closest_angstrom;
        if closest > FARTHEST_ANGSTROM {
            bail!(
                "{first} and {second} are {closest:.1} Å apart, so they form no complex here: one of them is \
                 in another frame, or these chains do not touch; superpose them on the complex, or choose \
                 other chains with --body"
            );
        }
        let share = in_conflict[0].max(in_conflict[1]);
        if share > MOST_IN_CONFLICT {
            bail!(
                "{:.0} % of the atoms of {first} or {second} are within {CONFLICT_ANGSTROM} Å of atoms of \
                 the other: the bodies are within each other, so one of them is in another frame, or both \
                 are the same; superpose them on the complex",
                100.0 * share
            );
        }
        Ok(())
    }

    fn warn_of_place(&mut self) {
        if self.clashing_atoms > 0 {
            let atoms = counted(self.clashing_atoms, "atom is", "atoms are");
            self.warnings.push(format!(
                "warning: {atoms} within {CONFLICT_ANGSTROM} Å of atoms of the other body \
                 ({:.2} Å at least): their charges dominate the energy; check the structure, or relax it first",
                self.closest_angstrom
            ));
        }
        if self.contacts() == 0 {
            self.warnings.push(format!(
                "warning: no residues touch, the closest atoms are {:.1} Å apart: this is no complex; if the \
                 ligand is in another frame, superpose it first",
                self.closest_angstrom
            ));
        }
    }

    /// Warns of residues at the interface that are no amino acids.
    fn warn_of_residues_without_scale(&mut self, partners: &Partners) {
        let mut names = BTreeSet::new();
        for (body, near) in partners.bodies.iter().zip(&self.near) {
            let residues = near.iter().map(|index| &body.residues[*index as usize]);
            names.extend(
                residues
                    .filter(|residue| parent_amino_acid(&residue.name).is_none())
                    .map(|residue| residue.name.clone()),
            );
        }
        if !names.is_empty() {
            let names: Vec<String> = names.into_iter().collect();
            self.warnings.push(format!(
                "warning: {} at the interface: the estimate of the affinity and the attraction between residues count \
                 amino acids only, so both leave this out; take the charge part alone as a result",
                names.join(", ")
            ));
        }
    }

    /// Warns of residues at the interface that lack atoms.
    fn warn_of_missing_atoms(&mut self, partners: &Partners) {
        let mut names = Vec::new();
        for side in 0..2 {
            let (body, near) = (&partners.bodies[side], &self.near[side]);
            for incomplete in &partners.incomplete[side] {
                let is_it = |index: &&u32| is_residue(&body.residues[**index as usize], incomplete);
                if near.iter().any(|index| is_it(&index)) {
                    let missing = incomplete.missing_atoms.join(" ");
                    names.push(format!(
                        "{} {} of {} ({missing})",
                        incomplete.name, incomplete.residue, body.name
                    ));
                }
            }
        }
        if names.is_empty() {
            return;
        }
        let count = names.len();
        let more = match count > MOST_NAMED {
            true => format!(" and {} more", count - MOST_NAMED),
            false => String::new(),
        };
        names.truncate(MOST_NAMED);
        self.warnings.push(format!(
            "warning: residues at the interface lack atoms, which leaves holes and misplaces charges: {}{more}; \
             complete them first, with PDBFixer or MODELLER for example",
            names.join(", ")
        ));
    }
}

fn is_residue(residue: &Residue, incomplete: &IncompleteResidue) -> bool {
    let key = &incomplete.residue;
    residue.chain == *key.chain
        && residue.number == key.number
        && residue.insertion_code == *key.insertion_code
}

fn heavy_atoms(body: &Body) -> Vec<Atom> {
    let mut atoms = Vec::with_capacity(body.sites.len());
    for site in &body.sites {
        if site.radius_angstrom > 0.0 && !site.is_hydrogen() {
            atoms.push(Atom {
                place: in_frame(body, &site.position),
                residue: site.residue,
            });
        }
    }
    atoms
}
