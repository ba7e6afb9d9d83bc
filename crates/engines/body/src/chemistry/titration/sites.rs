//! Atoms, hydrogens and groups of a selection together.

use super::super::radii::radius_angstrom;
use super::super::templates;
use super::groups::{TitratableGroup, background_e, groups_of_residue};
use super::hydrogens::{Hydrogen, hydroxyl, hydroxyl_hydrogen, polar_hydrogens};
use crate::structure::{SelectedResidue, Selection};
use protomer_kernel::Vec3;

/// Radius of a hydrogen on a polar atom, Å.
const HYDROGEN_RADIUS_ANGSTROM: f64 = 1.10;

/// Atoms of a protein with the charges of its neutral form, and the groups that titrate.
#[derive(Debug, Clone, PartialEq)]
pub struct TitratableSites {
    /// Positions of atoms, then of added hydrogens, Å, in the coordinates of the file.
    pub positions_angstrom: Vec<Vec3>,
    /// Radii, Å.
    pub radii_angstrom: Vec<f64>,
    /// Charges with every group neutral, e.
    pub background_e: Vec<f64>,
    /// Index of the residue of each site.
    pub residue_of_site: Vec<usize>,
    /// Name of each atom; an added hydrogen is `H` with the name of its heavy atom, that of an amide `H`.
    pub names: Vec<String>,
    /// Number of atoms; hydrogens follow.
    pub atoms: usize,
    /// Titratable groups in the order of the residues.
    pub groups: Vec<TitratableGroup>,
}

/// The titratable sites of a selection.
pub fn titratable_sites(selection: &Selection) -> TitratableSites {
    let mut sites = TitratableSites {
        positions_angstrom: Vec::new(),
        radii_angstrom: Vec::new(),
        background_e: Vec::new(),
        residue_of_site: Vec::new(),
        names: Vec::new(),
        atoms: 0,
        groups: Vec::new(),
    };
    for (index, residue) in selection.residues.iter().enumerate() {
        let first = sites.positions_angstrom.len();
        sites
            .groups
            .extend(groups_of_residue(residue, index, first));
        for (atom, charge_e) in residue.atoms.iter().zip(background_e(residue)) {
            let radius = radius_angstrom(&atom.element);
            sites.push(atom.position, radius, charge_e, index, &atom.name);
        }
    }
    sites.atoms = sites.positions_angstrom.len();
    let mut first = 0;
    for (index, residue) in selection.residues.iter().enumerate() {
        let previous = index.checked_sub(1).map(|place| &selection.residues[place]);
        let hydrogens = polar_hydrogens(residue, previous);
        sites.add_hydrogens(residue, index, first, &hydrogens);
        first += residue.atoms.len();
    }
    sites.add_hydroxyls(selection);
    sites
}

/// Name of the hydrogen on a heavy atom.
fn hydrogen_name(parent: &str) -> String {
    match parent {
        "N" => "H".into(),
        _ => format!("H{parent}"),
    }
}

impl TitratableSites {
    fn push(&mut self, position: Vec3, radius: f64, charge_e: f64, residue: usize, name: &str) {
        self.positions_angstrom.push(position);
        self.radii_angstrom.push(radius);
        self.background_e.push(charge_e);
        self.residue_of_site.push(residue);
        self.names.push(name.to_owned());
    }

    /// Moves the charges of hydrogens from their heavy atoms to their own places.
    fn add_hydrogens(
        &mut self,
        residue: &SelectedResidue,
        index: usize,
        first: usize,
        hydrogens: &[Hydrogen],
    ) {
        for hydrogen in hydrogens {
            let siblings = hydrogens
                .iter()
                .filter(|other| other.parent == hydrogen.parent);
            let name = &residue.atoms[hydrogen.parent].name;
            let total = templates::hydrogen_charge_e(residue.class.amino_acid(), name);
            let charge_e = total / siblings.count() as f64;
            self.background_e[first + hydrogen.parent] -= charge_e;
            let radius = HYDROGEN_RADIUS_ANGSTROM;
            let name = hydrogen_name(name);
            self.push(hydrogen.position, radius, charge_e, index, &name);
        }
    }

    /// Turns every hydroxyl in the field of the charged forms, and gives its hydrogen a place.
    fn add_hydroxyls(&mut self, selection: &Selection) {
        let mut charges: Vec<(Vec3, f64)> = Vec::new();
        for (place, charge_e) in self.positions_angstrom.iter().zip(&self.background_e) {
            charges.push((*place, *charge_e));
        }
        for group in &self.groups {
            if group.is_charged_in_water() {
                for &(site, change_e) in &group.change_e {
                    charges[site].1 += change_e;
                }
            }
        }
        let mut first = 0;
        for (index, residue) in selection.residues.iter().enumerate() {
            if let Some([oxygen, carbon]) = hydroxyl(residue) {
                let [oxygen_place, carbon_place] =
                    [oxygen, carbon].map(|atom| residue.atoms[atom].position);
                if let Some(place) = hydroxyl_hydrogen(oxygen_place, carbon_place, &charges) {
                    self.add_hydroxyl(residue, index, first + oxygen, place);
                }
            }
            first += residue.atoms.len();
        }
    }

    /// Moves the charge of a hydroxyl hydrogen to its place, also in the group that loses it.
    fn add_hydroxyl(
        &mut self,
        residue: &SelectedResidue,
        index: usize,
        oxygen: usize,
        place: Vec3,
    ) {
        let name = self.names[oxygen].clone();
        let charge_e = templates::hydrogen_charge_e(residue.class.amino_acid(), &name);
        self.background_e[oxygen] -= charge_e;
        let hydrogen = self.positions_angstrom.len();
        self.push(
            place,
            HYDROGEN_RADIUS_ANGSTROM,
            charge_e,
            index,
            &hydrogen_name(&name),
        );
        for group in &mut self.groups {
            if group.residue == index && group.change_e.iter().any(|change| change.0 == oxygen) {
                for change in &mut group.change_e {
                    if change.0 == oxygen {
                        change.1 += charge_e;
                    }
                }
                group.change_e.push((hydrogen, -charge_e));
            }
        }
    }
}
