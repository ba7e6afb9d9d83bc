//! `protomer binding`: the charge part of the binding free energy of a complex.

use crate::flags::body::{ChainGroupArgs, ProtonationArgs, SelectionArgs};
use crate::flags::model::ModelArgs;
use crate::flags::settings::choice;
use crate::flags::terms::ContactArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_field::IonModel;
use protomer_protein_verbs::stability::binding::{BindingSettings, binding};
use protomer_protein_verbs::stability::contacts::ContactCore;
use protomer_results::End;
use std::path::PathBuf;

/// Estimate how strongly a complex of known pose binds, and the effect of salt, pH and charges: affinity
/// from its contacts, charge part by the Poisson-Boltzmann equation, dissociation constant by
/// integration over the poses nearby.
#[derive(Debug, Args)]
// `--model` names what acts between the bodies here.
#[command(mut_arg(SelectionArgs::MODEL, |model| model.long("structure-model").value_name("NUMBER")))]
#[command(after_long_help = examples!(
    "binding receptor.pdb ligand.pdb --salt 50mM,150mM,500mM",
    "binding complex.cif.gz --body H,L --body A --salt 150mM,50mM --ph 6,7.4 --exchanges"
))]
pub struct BindingArgs {
    /// Receptor, or the whole complex: a structure, PQR or body file.
    receptor: PathBuf,
    /// Ligand in the same frame; without it the two bodies are chains of the first file.
    ligand: Option<PathBuf>,
    #[command(flatten)]
    bodies: ChainGroupArgs,
    /// Concentrations of a 1:1 salt: a list such as 50mM,150mM or a range such as 10mM..1M/5. Differences
    /// are from the first.
    #[arg(long, allow_hyphen_values = true)]
    salt: String,
    /// pH values at which structure files are charged, such as 6,7.4 [default: 7.4].
    #[arg(long, value_delimiter = ',', value_parser = range::PH.number())]
    ph: Vec<f64>,
    #[command(flatten)]
    protonation: ProtonationArgs,
    /// Temperature, K.
    #[arg(long, default_value = "298.15", allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    temperature: f64,
    /// Leave out the integration of the dissociation constant over the poses around the given one.
    #[arg(long)]
    no_kd: bool,
    /// Seed of the random numbers of the integration.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Find what each exchange of charge at the interface (heavy atoms within 5 Å of the partner) would
    /// change, at the first salt: two more solves for each residue.
    #[arg(long)]
    exchanges: bool,
    /// Find how many protons the bodies take up on binding, d log K_D / d pH, by titrations of the complex and of
    /// each body at every salt.
    #[arg(long)]
    proton_uptake: bool,
    /// Spacing of the fine grid, Å; a second grid is 1.4 times coarser.
    #[arg(long, default_value_t = BindingSettings::SPACING_ANGSTROM)]
    spacing: f64,
    /// Minimum distance between the atoms and the faces of the fine grid, Å.
    #[arg(long, default_value_t = BindingSettings::MARGIN_ANGSTROM)]
    margin: f64,
    /// Relative permittivity inside the bodies.
    #[arg(long, default_value_t = 2.0, value_parser = range::PERMITTIVITY.number())]
    inner_permittivity: f64,
    /// Relative permittivity of the solvent; that of water at the temperature if omitted.
    #[arg(long, value_parser = range::PERMITTIVITY.number())]
    outer_permittivity: Option<f64>,
    /// Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface.
    #[arg(long, default_value_t = 2.0, value_parser = range::RADIUS.number())]
    ion_radius: f64,
    /// Response of the ions: proportional to the potential, or by Boltzmann factors (the nonlinear
    /// equation; about twice as slow).
    #[arg(long, value_parser = choice::<IonModel>(), default_value = "linear")]
    ions: IonModel,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    attraction: ContactArgs,
    #[command(flatten)]
    selection: SelectionArgs,
}

impl BindingArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let end = binding(&settings, &front.execution_without_signals())?;
        let End::Finished(result) = end else {
            return Ok(Reply::stopped("stopped; nothing was kept".into()));
        };
        let warnings = result.warnings.clone();
        Ok(Reply::data(result).with_notes(warnings))
    }

    fn settings(&self) -> Result<BindingSettings> {
        let model = self
            .model
            .model()
            .unwrap_or(BindingSettings::default().model);
        Ok(BindingSettings {
            receptor: self.receptor.clone(),
            ligand: self.ligand.clone(),
            bodies: self.bodies.body.clone(),
            ligand_motion: None,
            model,
            contacts: self
                .attraction
                .over(model.contacts(), ContactCore::Surface)?,
            selection: self.selection.settings(),
            ph: self.ph.clone(),
            titration: self.protonation.titration_over(model.titration())?,
            salt_molar: quantity::salt_list(&self.salt)?,
            temperature_kelvin: self.temperature,
            outer_permittivity: self.outer_permittivity,
            inner_permittivity: self.inner_permittivity,
            ion_radius_angstrom: self.ion_radius,
            ions: self.ions,
            spacing_angstrom: self.spacing,
            margin_angstrom: self.margin,
            integrates: !self.no_kd,
            seed: self.seed,
            exchanges: self.exchanges,
            proton_uptake: self.proton_uptake,
        })
    }
}
