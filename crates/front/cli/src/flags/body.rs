//! How a body is made from a structure: atoms, charges and surface.

use super::settings::choice;
use anyhow::{Result, bail};
use clap::Args;
use protomer_body::chemistry::{
    ChargeModel, PkaSource, SiteSettings, StructureTitration, parse_mutations,
};
use protomer_body::structure::{MissingAtoms, ResidueRange, SelectionSettings};
use protomer_body::{BodySettings, HardCore, SurfaceSettings};
use protomer_common::{quantity, range};
use protomer_protein_verbs::bodies::chain_groups::ChainNames;

/// Selection of atoms.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Selection")]
pub struct SelectionArgs {
    /// Chains, by author name; all if omitted.
    #[arg(long, value_delimiter = ',')]
    chain: Vec<String>,
    /// Residues to keep of a chain, such as A:5-120, A:5- or A:45; other chains stay whole.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    residues: Vec<ResidueRange>,
    /// Model number; the first if omitted.
    #[arg(id = SelectionArgs::MODEL, long = "model", value_name = "MODEL")]
    model: Option<i32>,
    /// Number of the biological assembly; the deposited coordinates if omitted.
    #[arg(long)]
    assembly: Option<String>,
    /// Preferred alternate location; the highest occupancy if omitted.
    #[arg(long)]
    altloc: Option<char>,
    /// Keep ligands, ions and sugars.
    #[arg(long)]
    keep_ligands: bool,
    /// Keep waters.
    #[arg(long)]
    keep_waters: bool,
    /// Keep hydrogens.
    #[arg(long)]
    keep_hydrogens: bool,
    /// Keep nucleic acids.
    #[arg(long)]
    keep_nucleic_acids: bool,
    /// Treatment of residues that lack heavy atoms.
    #[arg(long, value_parser = choice::<MissingAtoms>(), default_value = "keep")]
    missing: MissingAtoms,
}

/// Groups of chains, each of which makes up one body.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Bodies")]
pub struct ChainGroupArgs {
    /// Chains that make up one body, such as H,L; once for each body.
    #[arg(long)]
    pub body: Vec<ChainNames>,
}

/// Model of the charges.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Charges")]
pub struct ChargeArgs {
    /// pH of the protonation equilibria.
    #[arg(long, default_value_t = 7.4, value_parser = range::PH.number())]
    ph: f64,
    /// Model of the charges.
    #[arg(long, value_parser = choice::<ChargeModel>(), default_value = "force-field")]
    charges: ChargeModel,
    #[command(flatten)]
    protonation: ProtonationArgs,
    /// Salt for which --protonation structure is solved, such as 100mM.
    #[arg(long, default_value = "100mM", value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    protonation_salt: f64,
    /// Keep the titratable groups with the body, for simulations that change their protons (simulate
    /// --proton-moves); with --protonation structure.
    #[arg(long)]
    titratable: bool,
    /// Point mutations, such as A:K45E,B:N12D; side chains are replaced in place.
    #[arg(long)]
    mutate: Option<String>,
}

/// Source of the charges of titratable groups.
#[derive(Debug, Clone, Copy, Args)]
pub struct ProtonationArgs {
    /// Source of the pKa values of structure files [default: water, or that of the model].
    #[arg(long, value_parser = choice::<PkaSource>(), help_heading = "Charges")]
    protonation: Option<PkaSource>,
    /// Constant of the binding of the salt's anion to a positive group, L/mol, with
    /// --protonation structure; a group with a bound anion has no charge [default: 0, or that of the model].
    #[arg(long, value_parser = range::ANION_BINDING.number(), help_heading = "Charges")]
    anion_binding: Option<f64>,
}

impl ProtonationArgs {
    /// The titration of structures; `None` for pKa values in water.
    ///
    /// # Errors
    /// For a binding constant without a titration.
    pub fn titration(&self) -> Result<Option<StructureTitration>> {
        self.titration_over(None)
    }

    /// The titration of a model, overridden by the flags.
    ///
    /// # Errors
    /// As [`titration`](Self::titration).
    pub fn titration_over(
        &self,
        of_model: Option<StructureTitration>,
    ) -> Result<Option<StructureTitration>> {
        let present = match self.protonation {
            None => of_model,
            Some(PkaSource::Water) => None,
            Some(PkaSource::Structure) => Some(of_model.unwrap_or(StructureTitration {
                anion_binding_per_molar: 0.0,
            })),
        };
        match (present, self.anion_binding) {
            (Some(_), Some(anion_binding_per_molar)) => Ok(Some(StructureTitration {
                anion_binding_per_molar,
            })),
            (None, Some(_)) => bail!(
                "--anion-binding is part of the titration of a structure; add --protonation structure"
            ),
            (present, None) => Ok(present),
        }
    }
}

/// Temperature of the protonation of bodies, K, for which the pKa values of `titrate` were fitted.
const PROTONATION_KELVIN: f64 = 298.15;

/// Parameters of the surface.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceFlags {
    /// Mesh vertices per Å².
    #[arg(long, default_value_t = 1.0, value_parser = range::MESH_DENSITY.number())]
    density: f64,
    /// Spacing of the lattice on which the surface is first found, Å; a coarser one is faster and
    /// may close or open what is narrower.
    #[arg(long, default_value_t = SurfaceSettings::LATTICE_SPACING_ANGSTROM)]
    lattice_spacing: f64,
    /// Probe radius, Å.
    #[arg(long, default_value_t = 1.4, value_parser = range::RADIUS.number())]
    probe: f64,
    /// Treatment of cavities; if omitted, a body drops them and `surface` keeps them.
    #[arg(long, value_parser = choice::<Cavities>())]
    cavities: Option<Cavities>,
    /// A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors
    /// are never filled, because other bodies may be inside.
    #[arg(long, default_value_t = SurfaceSettings::INTERIOR_RADIUS_ANGSTROM, value_parser = range::RADIUS.number())]
    interior_radius: f64,
    /// Move the surface inward by this much, Å; for a body with a native core, move that core
    /// instead, by 0.5 if omitted.
    #[arg(long, value_parser = range::RADIUS.number())]
    offset: Option<f64>,
}

/// Choice of the hard core of a body.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Surface")]
pub struct CoreArgs {
    /// Hard core of the body; native for structures and surface for PQR files if omitted.
    #[arg(long, value_parser = choice::<HardCore>())]
    core: Option<HardCore>,
}

protomer_kernel::choices! {
    /// Treatments of cavities.
    pub enum Cavities {
        /// Fill them, except for enclosed interiors.
        Drop = "drop",
        /// Keep their walls as part of the mesh.
        Keep = "keep",
    }
}

impl SelectionArgs {
    /// The argument that chooses a model of a file, for verbs that call it otherwise.
    pub const MODEL: &str = "structure_model";

    pub fn settings(&self) -> SelectionSettings {
        SelectionSettings {
            model: self.model,
            chains: self.chain.clone(),
            residues: self.residues.clone(),
            assembly: self.assembly.clone(),
            alternate: self.altloc,
            keep_ligands: self.keep_ligands,
            keep_waters: self.keep_waters,
            keep_hydrogens: self.keep_hydrogens,
            keep_nucleic_acids: self.keep_nucleic_acids,
            missing: self.missing,
        }
    }
}

impl SurfaceFlags {
    /// Converts the flags to settings; `cavities` holds unless the user states a treatment.
    pub fn settings(&self, cavities: Cavities) -> SurfaceSettings {
        SurfaceSettings {
            density_per_angstrom2: self.density,
            lattice_spacing_angstrom: self.lattice_spacing,
            probe_radius_angstrom: self.probe,
            keep_cavities: self.cavities.unwrap_or(cavities) == Cavities::Keep,
            interior_radius_angstrom: self.interior_radius,
            core: None,
            inward_offset_angstrom: self.offset,
        }
    }
}

/// Converts the flags to settings.
pub fn body_settings(
    selection: &SelectionArgs,
    charges: &ChargeArgs,
    surface: &SurfaceFlags,
    core: CoreArgs,
) -> Result<BodySettings> {
    let mutations = charges.mutate.as_deref().map(parse_mutations).transpose()?;
    let titration = charges.protonation.titration()?;
    if charges.titratable && titration.is_some_and(|model| model.anion_binding_per_molar > 0.0) {
        bail!(
            "--titratable keeps groups with two forms, and a group with a bound anion has a third; leave out \
             --anion-binding, or --titratable"
        );
    }
    Ok(BodySettings {
        selection: selection.settings(),
        sites: SiteSettings {
            ph: charges.ph,
            charges: charges.charges,
            structure: titration.map(|titration| {
                titration.conditions(charges.protonation_salt, PROTONATION_KELVIN)
            }),
            titratable: charges.titratable,
        },
        mutations: mutations.unwrap_or_default(),
        surface: SurfaceSettings {
            core: core.core,
            ..surface.settings(Cavities::Drop)
        },
    })
}
