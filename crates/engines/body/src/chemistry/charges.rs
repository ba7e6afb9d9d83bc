//! One residue's charge on its atoms.
//!
//! The residue's charge is the sum of the mean charges of its titratable groups
//! ([`residue_charge_e`]). The models differ in how they distribute it over the atoms
//! ([`atom_charges_e`]); in each of them the atoms' charges add up to it exactly:
//!
//! * force field: template charges, hydrogens added to their heavy atom, interpolated between the
//!   protonated and the deprotonated form; the charge left over by missing or unknown atoms is
//!   spread evenly over the heavy atoms present;
//! * formal: the groups' charges on the atoms of the groups only.
//!
//! Hydrogens that are kept have no charge; it is on their heavy atom.

use super::amino_acid::{AminoAcid, BACKBONE};
use super::cofactors::cofactor_of;
use super::protonation::{C_TERMINUS, Group, N_TERMINUS, ResidueProtonation, side_chain_groups};
use super::templates::{self, Template, forms};
use super::treatment::{formal_charge_e, ion_of};
use crate::structure::{Atom, ResidueClass, SelectedResidue};

protomer_kernel::choices! {
    /// Distribution of the charge of a residue over its atoms.
    ///
    /// ```
    /// use protomer_body::chemistry::{ChargeModel, SiteSettings, build_sites};
    /// use protomer_body::structure::{SelectionSettings, Structure};
    /// # let text = "\
    /// # ATOM      1  NZ  LYS A   1      11.104   6.134  -6.504  1.00 10.00           N
    /// # ATOM      2  CE  LYS A   1      11.639   6.071  -5.147  1.00 10.00           C";
    /// let selection = Structure::read("lysine.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
    /// let settings = SiteSettings { charges: ChargeModel::Formal, ph: 10.5, ..SiteSettings::default() };
    /// let sites = build_sites(&selection, &settings)?.sites;
    /// assert!((sites[0].charge_e - 0.5).abs() < 0.01 && sites[1].charge_e.abs() < 0.01);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub enum ChargeModel, default ForceField {
        /// Partial charges of AMBER ff94 on every heavy atom.
        ForceField = "force-field",
        /// Formal charges on the charged groups.
        Formal = "formal",
        /// No charges.
        None = "none",
    }
}

/// The titratable groups of the side chain.
pub fn side_groups(residue: &SelectedResidue) -> &'static [Group] {
    if let ResidueClass::Modified(modified) = residue.class
        && let Some(groups) = modified.groups
    {
        return groups;
    }
    match residue.class.amino_acid() {
        Some(amino_acid) if !residue.in_disulfide => side_chain_groups(amino_acid),
        _ => &[],
    }
}

/// Net charge of a residue, e: side chain, ends of the chain, and the fixed charge of ions, ligands
/// and phosphates.
///
/// ```
/// use protomer_body::chemistry::ResidueProtonation;
/// use protomer_body::chemistry::charges::{residue_charge_e, side_groups};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// # let text = "ATOM      1  CA  GLU A   1      11.639   6.071  -5.147  1.00 10.00           C";
/// let selection = Structure::read("e.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
/// let mut glutamate = selection.residues[0].clone();
/// (glutamate.n_terminus, glutamate.c_terminus) = (false, false);
/// let protonation = ResidueProtonation::in_water(side_groups(&glutamate), 4.5);
/// assert!((residue_charge_e(&glutamate, &protonation) + 0.5).abs() < 1e-12, "the pKa is 4.5");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn residue_charge_e(residue: &SelectedResidue, protonation: &ResidueProtonation) -> f64 {
    let mut charge = fixed_charge_e(residue);
    for (group, protonated) in side_groups(residue).iter().zip(&protonation.side) {
        charge += group.mean_charge_e(*protonated);
    }
    if residue.n_terminus {
        charge += N_TERMINUS.mean_charge_e(protonation.n_terminus);
    }
    if residue.c_terminus {
        charge += C_TERMINUS.mean_charge_e(protonation.c_terminus);
    }
    charge
}

/// Charges that no pH changes: one per phosphate of a nucleic acid, ions and cofactors by their name,
/// other ligands and residues in no table as the file states.
fn fixed_charge_e(residue: &SelectedResidue) -> f64 {
    match residue.class {
        ResidueClass::Nucleotide if residue.atom("P").is_some() => -1.0,
        ResidueClass::Ligand => match ion_of(residue) {
            Some(charge) => f64::from(charge),
            None => match cofactor_of(residue) {
                Some(cofactor) => cofactor.charge_e(),
                None => f64::from(formal_charge_e(residue)),
            },
        },
        ResidueClass::UnknownAminoAcid => f64::from(formal_charge_e(residue)),
        _ => 0.0,
    }
}

/// The charges of the residue's atoms, e, in their order.
pub fn atom_charges_e(
    residue: &SelectedResidue,
    protonation: &ResidueProtonation,
    model: ChargeModel,
) -> Vec<f64> {
    let mut charges = Charges::new(residue, protonation.clone());
    match model {
        ChargeModel::None => return charges.values,
        ChargeModel::Formal => charges.formal(),
        ChargeModel::ForceField => charges.force_field(),
    }
    charges.spread_remainder(residue_charge_e(residue, protonation));
    charges.values
}

/// Capacitances of the residue's atoms, e², in their order: those of the groups, on the atoms that carry
/// the formal charge. Zeros where none is known.
pub fn atom_capacitances_e2(
    residue: &SelectedResidue,
    protonation: &ResidueProtonation,
) -> Vec<f64> {
    let mut placed = Charges::new(residue, uniform(residue, 0.0));
    let side = side_groups(residue).iter().copied();
    let groups = side.chain([N_TERMINUS, C_TERMINUS]);
    for (group, capacitance_e2) in groups.zip(&protonation.capacitance_e2) {
        placed.place_group(&group, *capacitance_e2);
    }
    placed.values
}

/// Charges of the residue's atoms with every titratable group in its neutral form, e. A neutral
/// histidine is the mean of its two tautomers.
pub(crate) fn neutral_charges_e(residue: &SelectedResidue) -> Vec<f64> {
    let residue = &without_ends(residue);
    let mut charges = Charges::charged(residue, 1.0);
    for (place, group) in side_groups(residue).iter().enumerate() {
        if group.protonated_charge_e > 0.5 {
            let change = side_chain_change_e(residue, place);
            for (value, change) in charges.values.iter_mut().zip(change) {
                *value -= change;
            }
        }
    }
    share_between_equals(residue, &mut charges.values);
    charges.values
}

/// Change of the charges of the residue's atoms between the neutral and the charged form of a group
/// of the side chain, e. It adds up to ±1 e.
pub(crate) fn side_chain_change_e(residue: &SelectedResidue, place: usize) -> Vec<f64> {
    let residue = &without_ends(residue);
    let groups = side_groups(residue);
    let group = &groups[place];
    let total = if group.protonated_charge_e > 0.5 {
        1.0
    } else {
        -1.0
    };
    let has_templates = match residue.class.amino_acid() {
        Some(amino_acid) => !forms(amino_acid, false).deprotonated.is_empty(),
        None => false,
    };
    if groups.len() > 1 || !has_templates {
        let mut change = Charges::new(residue, uniform(residue, 0.0));
        change.place_group(group, total);
        return change.values;
    }
    let mut change = Charges::charged(residue, 1.0).values;
    // Protonated minus deprotonated is +1 e; the charged form of an acid is the deprotonated one.
    for (value, deprotonated) in change.iter_mut().zip(Charges::charged(residue, 0.0).values) {
        *value = total * (*value - deprotonated);
    }
    share_between_equals(residue, &mut change);
    change
}

/// Gives the two oxygens of a carboxylate the same charge: the proton of the neutral form is on either.
fn share_between_equals(residue: &SelectedResidue, values: &mut [f64]) {
    for names in [["OD1", "OD2"], ["OE1", "OE2"]] {
        let amino_acid = residue.class.amino_acid();
        if !matches!(amino_acid, Some(AminoAcid::Asp | AminoAcid::Glu)) {
            continue;
        }
        let mut pair = Vec::new();
        for (index, atom) in residue.atoms.iter().enumerate() {
            if names.contains(&&*atom.name) {
                pair.push(index);
            }
        }
        if let [first, second] = pair[..] {
            let mean = 0.5 * (values[first] + values[second]);
            (values[first], values[second]) = (mean, mean);
        }
    }
}

/// Half the difference of the two neutral tautomers of histidine, e: the proton on Nδ minus that on
/// Nε. Zero for any other residue.
pub(crate) fn tautomer_change_e(residue: &SelectedResidue) -> Vec<f64> {
    let mut change = Charges::new(residue, uniform(residue, 0.0));
    if residue.class.amino_acid() == Some(AminoAcid::His)
        && let [delta, epsilon] = forms(AminoAcid::His, false).deprotonated
    {
        change.add(&[delta], 0.5);
        change.add(&[epsilon], -0.5);
        change.spread_remainder(0.0);
    }
    change.values
}

/// The same protonated fraction for every group of the residue.
fn uniform(residue: &SelectedResidue, protonated: f64) -> ResidueProtonation {
    ResidueProtonation {
        side: vec![protonated; side_groups(residue).len()],
        n_terminus: protonated,
        c_terminus: protonated,
        capacitance_e2: Vec::new(),
    }
}

/// The residue in the middle of a chain.
fn without_ends(residue: &SelectedResidue) -> SelectedResidue {
    SelectedResidue {
        n_terminus: false,
        c_terminus: false,
        ..residue.clone()
    }
}

struct Charges<'a> {
    residue: &'a SelectedResidue,
    protonation: ResidueProtonation,
    values: Vec<f64>,
}

impl<'a> Charges<'a> {
    fn new(residue: &'a SelectedResidue, protonation: ResidueProtonation) -> Self {
        Self {
            residue,
            protonation,
            values: vec![0.0; residue.atoms.len()],
        }
    }

    /// Charges of the force field with the same protonated fraction for every group.
    fn charged(residue: &'a SelectedResidue, protonated: f64) -> Self {
        let protonation = uniform(residue, protonated);
        let total_e = residue_charge_e(residue, &protonation);
        let mut charges = Self::new(residue, protonation);
        charges.force_field();
        charges.spread_remainder(total_e);
        charges
    }

    fn formal(&mut self) {
        self.place_groups(side_groups(self.residue));
        if self.residue.n_terminus {
            self.place(N_TERMINUS.atoms, self.n_terminus_e());
        }
        if self.residue.c_terminus {
            self.place(C_TERMINUS.atoms, self.c_terminus_e());
        }
        self.place_fixed();
    }

    fn force_field(&mut self) {
        match self.residue.class {
            ResidueClass::AminoAcid(amino_acid) if self.residue.mutated_from.is_some() => {
                self.mutated(amino_acid);
            }
            ResidueClass::AminoAcid(amino_acid) | ResidueClass::LikeAminoAcid(amino_acid) => {
                self.template(amino_acid);
            }
            ResidueClass::Modified(modified) => match (modified.parent, modified.groups) {
                (Some(parent), None) => self.template(parent),
                (parent, groups) => {
                    if let Some(parent) = parent {
                        self.neutral_template(parent);
                    }
                    self.place_groups(groups.unwrap_or(&[]));
                }
            },
            _ => self.place_fixed(),
        }
        self.add_termini();
    }

    /// The residue's template at the pH.
    fn template(&mut self, amino_acid: AminoAcid) {
        let forms = forms(amino_acid, self.residue.in_disulfide);
        let group = match side_chain_groups(amino_acid).first() {
            Some(group) if !self.residue.in_disulfide => group,
            _ => return self.add(forms.protonated, 1.0),
        };
        // A residue without groups has no other form.
        let protonated = self.protonation.side.first().copied().unwrap_or(1.0);
        if forms.deprotonated.is_empty() {
            self.add(forms.protonated, 1.0);
            self.place_group(group, protonated - 1.0);
        } else {
            self.add(forms.protonated, protonated);
            self.add(forms.deprotonated, 1.0 - protonated);
        }
    }

    /// The uncharged form of the parent, for residues with their own titratable groups.
    fn neutral_template(&mut self, parent: AminoAcid) {
        let forms = forms(parent, false);
        let is_base = match side_chain_groups(parent).first() {
            Some(group) => group.protonated_charge_e > 0.5,
            None => false,
        };
        if is_base && !forms.deprotonated.is_empty() {
            self.add(forms.deprotonated, 1.0);
        } else {
            self.add(forms.protonated, 1.0);
        }
    }

    /// A mutated residue, which has the atoms of the old one: the new residue's template on the
    /// backbone, and the net charge of the new side chain on the outermost atoms present.
    fn mutated(&mut self, amino_acid: AminoAcid) {
        self.template(amino_acid);
        let mut backbone = 0.0;
        for (atom, value) in self.residue.atoms.iter().zip(&mut self.values) {
            if !BACKBONE.contains(&&*atom.name) {
                *value = 0.0;
            }
            backbone += *value;
        }
        let mut net = 0.0;
        for (group, protonated) in side_groups(self.residue).iter().zip(&self.protonation.side) {
            net += group.mean_charge_e(*protonated);
        }
        self.place_outermost(net - backbone);
    }

    fn n_terminus_e(&self) -> f64 {
        N_TERMINUS.mean_charge_e(self.protonation.n_terminus)
    }

    fn c_terminus_e(&self) -> f64 {
        C_TERMINUS.mean_charge_e(self.protonation.c_terminus)
    }

    fn add_termini(&mut self) {
        if self.residue.n_terminus {
            let charge = self.n_terminus_e();
            for (atom, share) in templates::N_TERMINUS {
                self.add_to(atom, charge * share);
            }
        }
        if self.residue.c_terminus {
            let charge = -self.c_terminus_e();
            for (atom, share) in templates::C_TERMINUS {
                self.add_to(atom, charge * share);
            }
        }
    }

    /// Phosphates, groups of cofactors, and the formal charges of other ligands and of residues in no table. The charge of an
    /// ion is assigned later, as the remainder.
    fn place_fixed(&mut self) {
        match self.residue.class {
            ResidueClass::Nucleotide if self.residue.atom("P").is_some() => {
                self.place(&["OP1", "OP2", "O1P", "O2P"], -1.0);
            }
            ResidueClass::Ligand if ion_of(self.residue).is_some() => {}
            ResidueClass::Ligand if cofactor_of(self.residue).is_some() => {
                let cofactor = cofactor_of(self.residue);
                for (atoms, charge_e) in cofactor.into_iter().flat_map(|found| found.groups) {
                    self.place(atoms, *charge_e);
                }
            }
            ResidueClass::Ligand | ResidueClass::UnknownAminoAcid => {
                for (atom, value) in self.residue.atoms.iter().zip(&mut self.values) {
                    *value += f64::from(atom.formal_charge_e.unwrap_or(0));
                }
            }
            _ => {}
        }
    }

    fn add(&mut self, templates: &[Template], weight: f64) {
        let share = weight / templates.len() as f64;
        for (name, own, hydrogens) in templates.iter().copied().flatten() {
            self.add_to(name, share * (own + hydrogens));
        }
    }

    fn add_to(&mut self, name: &str, charge: f64) {
        for (atom, value) in self.residue.atoms.iter().zip(&mut self.values) {
            if &*atom.name == name {
                *value += charge;
                return;
            }
        }
    }

    fn place_groups(&mut self, groups: &[Group]) {
        let fractions = self.protonation.side.clone();
        for (group, protonated) in groups.iter().zip(fractions) {
            self.place_group(group, group.mean_charge_e(protonated));
        }
    }

    /// Puts a group's charge on its atoms; in a mutated residue, which lacks them, on the outermost
    /// atoms.
    fn place_group(&mut self, group: &Group, charge: f64) {
        if self.residue.mutated_from.is_some() {
            self.place_outermost(charge);
        } else {
            self.place(group.atoms, charge);
        }
    }

    /// Shares a charge equally between those of the named atoms that are present, or puts it on the
    /// outermost atoms.
    fn place(&mut self, names: &[&str], charge: f64) {
        let present = self.indices(|atom| names.contains(&&*atom.name));
        if present.is_empty() {
            self.place_outermost(charge)
        } else {
            self.share(&present, charge)
        }
    }

    fn place_outermost(&mut self, charge: f64) {
        self.share(&outermost(self.residue), charge);
    }

    fn share(&mut self, atoms: &[usize], charge: f64) {
        for &index in atoms {
            self.values[index] += charge / atoms.len() as f64;
        }
    }

    /// Spreads the remainder of the residue's charge evenly over its heavy atoms.
    fn spread_remainder(&mut self, charge: f64) {
        let mut atoms = self.indices(|atom| !atom.is_hydrogen());
        if atoms.is_empty() {
            atoms = (0..self.values.len()).collect();
        }
        let remainder = charge - self.values.iter().sum::<f64>();
        self.share(&atoms, remainder);
    }

    /// Indices of the atoms that `is_wanted`.
    fn indices(&self, is_wanted: impl Fn(&Atom) -> bool) -> Vec<usize> {
        let mut indices = Vec::new();
        for (index, atom) in self.residue.atoms.iter().enumerate() {
            if is_wanted(atom) {
                indices.push(index);
            }
        }
        indices
    }
}

/// The heavy atoms of the side chain farthest from the backbone by the letter of their names (B, G,
/// D, E, Z, H); CA, or any heavy atom, where there is no side chain.
fn outermost(residue: &SelectedResidue) -> Vec<usize> {
    let mut farthest = 0;
    let mut outermost = Vec::new();
    for (index, atom) in residue.atoms.iter().enumerate() {
        let remoteness = remoteness(atom);
        if remoteness > farthest {
            farthest = remoteness;
            outermost.clear();
        }
        if remoteness == farthest {
            outermost.push(index);
        }
    }
    outermost
}

/// Rank of an atom by its distance from the backbone, from the letter of its name.
fn remoteness(atom: &Atom) -> usize {
    let name = &*atom.name;
    let is_side = !BACKBONE.contains(&name) && name != "OXT" && !atom.is_hydrogen();
    let letter = name.chars().nth(1).unwrap_or(' ');
    match "BGDEZH".find(letter) {
        Some(rank) if is_side => 2 + rank,
        _ if name == "CA" => 1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{SelectionSettings, Structure};

    /// A residue with all its heavy atoms, in the middle of a chain.
    fn whole(amino_acid: AminoAcid) -> SelectedResidue {
        let names = BACKBONE.iter().chain(amino_acid.side_chain());
        let line = |(place, name): (usize, &&str)| {
            format!(
                "ATOM      1  {name:<3} {} A   1    {:8.3}   0.000   0.000\n",
                amino_acid.name(),
                1.5 * place as f64
            )
        };
        let text: String = names.enumerate().map(line).collect();
        let structure = Structure::read("test.pdb", text.as_bytes()).unwrap();
        let mut residue = structure
            .select(&SelectionSettings::default())
            .unwrap()
            .residues
            .remove(0);
        (residue.n_terminus, residue.c_terminus) = (false, false);
        residue
    }

    fn charges_at(residue: &SelectedResidue, ph: f64) -> Vec<f64> {
        let protonation = ResidueProtonation::in_water(side_groups(residue), ph);
        atom_charges_e(residue, &protonation, ChargeModel::ForceField)
    }

    /// Far from the pKa a whole residue has exactly the charges of the published template.
    #[test]
    fn a_whole_residue_has_its_template() {
        for amino_acid in AminoAcid::all() {
            let residue = whole(amino_acid);
            let forms = forms(amino_acid, false);
            for (ph, templates) in [(-10.0, forms.protonated), (30.0, forms.deprotonated)] {
                let charges = charges_at(&residue, ph);
                for (atom, charge) in residue.atoms.iter().zip(charges) {
                    let total = |template: &Template| {
                        template
                            .iter()
                            .find(|entry| entry.0 == &*atom.name)
                            .unwrap()
                    };
                    let sum: f64 = templates
                        .iter()
                        .map(total)
                        .map(|entry| entry.1 + entry.2)
                        .sum();
                    if !templates.is_empty() {
                        assert!(
                            (charge - sum / templates.len() as f64).abs() < 1e-6,
                            "{amino_acid:?} {}",
                            atom.name
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn without_a_template_the_lost_proton_is_on_the_group() {
        for (amino_acid, group) in [(AminoAcid::Tyr, "OH"), (AminoAcid::Arg, "NH1")] {
            let residue = whole(amino_acid);
            let charged = |ph| charges_at(&residue, ph);
            let change: Vec<f64> = charged(30.0)
                .iter()
                .zip(charged(-10.0))
                .map(|(a, b)| a - b)
                .collect();
            let index = residue
                .atoms
                .iter()
                .position(|atom| &*atom.name == group)
                .unwrap();
            assert!(change[index] < -0.49 && (change.iter().sum::<f64>() + 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn outermost_atoms_by_their_letters() {
        for (amino_acid, names) in [
            (AminoAcid::Lys, &["NZ"][..]),
            (AminoAcid::Arg, &["NH1", "NH2"]),
            (AminoAcid::Gly, &["CA"]),
            (AminoAcid::Ser, &["OG"]),
        ] {
            let residue = whole(amino_acid);
            let outermost: Vec<&str> = outermost(&residue)
                .iter()
                .map(|index| &*residue.atoms[*index].name)
                .collect();
            assert_eq!(outermost, names);
        }
    }
}
