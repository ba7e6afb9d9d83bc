//! From selected residues to their protonation, for bodies.

use super::{TitrationModel, group_energies, solve_settings};
use crate::dielectric::DielectricModel;
use crate::{FieldError, Result};
use protomer_body::BodyError;
use protomer_body::chemistry::titration::{
    BodyGroup, BodyTitration, change_on_atoms_e, formal_changes_e, protonation_of_residues,
    titratable_sites,
};
use protomer_body::chemistry::{Protonate, Protonated, StructureProtonation};
use protomer_body::structure::Selection;
use protomer_kernel::Electrolyte;

/// Protonation by the solved energies of [`group_energies`].
///
/// ```
/// use protomer_body::chemistry::{SiteSettings, StructureProtonation};
/// use protomer_body::structure::Structure;
/// use protomer_body::{BodySettings, Draft, Source};
/// use protomer_field::titration::SolvedProtonation;
/// // The amine and the side chain of a lysine, stretched.
/// let mut text = String::new();
/// for (place, name) in ["N", "CA", "CB", "CG", "CD", "CE", "NZ"].iter().enumerate() {
///     let (x, y) = (1.25 * place as f64, 0.8 * (place % 2) as f64);
///     text += &format!("ATOM      1  {name:<3} LYS A   1    {x:8.3}{y:8.3}   0.000\n");
/// }
/// let conditions = StructureProtonation {
///     salt_molar: 0.1,
///     temperature_kelvin: 298.15,
///     anion_binding_per_molar: 0.0,
/// };
/// let settings = BodySettings {
///     sites: SiteSettings { structure: Some(conditions), ..SiteSettings::default() },
///     ..BodySettings::default()
/// };
/// let selection = Structure::read("lysine.pdb", text.as_bytes())?.select(&settings.selection)?;
/// let source = Source { file: "lysine.pdb", sha256: "" };
/// let solved = &SolvedProtonation;
/// let draft = Draft::of_protonated_selection("lysine", source, selection, &settings, solved)?;
/// // The side chain is charged, and the amine for the most part.
/// let net_charge_e = draft.sites().net_charge_e();
/// assert!(net_charge_e > 1.5 && net_charge_e < 1.9, "{net_charge_e}");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SolvedProtonation;

impl Protonate for SolvedProtonation {
    fn protonate(
        &self,
        selection: &Selection,
        ph: f64,
        conditions: &StructureProtonation,
    ) -> protomer_body::Result<Protonated> {
        protonation(selection, ph, conditions).map_err(|error| match error {
            FieldError::Body(error) => error,
            error => BodyError::Invalid {
                cause: format!("a protonation that cannot be solved for ({error})"),
                remedy: "use pKa values in water".into(),
            },
        })
    }
}

fn protonation(
    selection: &Selection,
    ph: f64,
    conditions: &StructureProtonation,
) -> Result<Protonated> {
    let sites = titratable_sites(selection);
    let mut titration = BodyTitration {
        ph,
        salt_molar: conditions.salt_molar,
        temperature_kelvin: conditions.temperature_kelvin,
        groups: Vec::new(),
        pair_kt: Vec::new(),
        tautomer_pair_kt: Vec::new(),
    };
    if sites.groups.is_empty() {
        let residues = protonation_of_residues(selection, &[], &[], &[]);
        return Ok(Protonated {
            residues,
            titration,
            formal_changes_e: Vec::new(),
        });
    }
    let salt_molar = conditions.salt_molar;
    let electrolyte = Electrolyte::in_water(conditions.temperature_kelvin, salt_molar)?;
    let model = TitrationModel {
        anion_binding_per_molar: conditions.anion_binding_per_molar,
        ..TitrationModel::default()
    };
    let dielectric = model.dielectric(electrolyte);
    let energies = group_energies(&sites, &dielectric, &solve_settings(), &|| true)?;
    let groups = model.groups(&sites, &energies, salt_molar);
    let shares = groups.charged_shares(ph);
    let capacitances = groups.capacitances_e2(ph);
    let residues = protonation_of_residues(selection, &sites.groups, &shares, &capacitances);
    for (number, share) in shares.iter().enumerate() {
        titration.groups.push(BodyGroup {
            charge_e: groups.charge_e[number],
            model_pka: groups.model_pka[number],
            shift_kt: groups.shift_kt[number],
            tautomer_kt: groups.tautomer_kt[number],
            charged_share: *share,
            change_e: change_on_atoms_e(&sites, number),
        });
    }
    titration.pair_kt = groups.pair_kt;
    titration.tautomer_pair_kt = groups.tautomer_pair_kt;
    Ok(Protonated {
        residues,
        titration,
        formal_changes_e: formal_changes_e(selection, &sites.groups),
    })
}

impl TitrationModel {
    /// A protein of this model in an electrolyte.
    ///
    /// ```
    /// use protomer_field::titration::TitrationModel;
    /// use protomer_kernel::Electrolyte;
    /// let dielectric = TitrationModel::default().dielectric(Electrolyte::in_water(298.15, 0.1)?);
    /// assert_eq!(dielectric.inner_permittivity, 20.0);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn dielectric(&self, electrolyte: Electrolyte) -> DielectricModel {
        DielectricModel {
            inner_permittivity: self.inner_permittivity,
            ..DielectricModel::new(electrolyte)
        }
    }
}
