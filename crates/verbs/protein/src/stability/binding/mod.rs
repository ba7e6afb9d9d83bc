//! What holds a complex together by its charges, against salt and pH: the charge part of the binding
//! free energy by the Poisson-Boltzmann equation, and the energy of the fast interaction for the same
//! pose.
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what is asked |
//! | `input` | two bodies in one frame, from two files or from the chains of one |
//! | `interface` | which residues touch, and whether the bodies are in one frame at all |
//! | `estimate` | the calibrated estimate of the affinity against salt and pH |
//! | `bound_state` | the dissociation constant of the pose by integration |
//! | `fast` | the interaction of simulations for the pose, by terms |
//! | `uptake` | protons taken up on binding |
//! | `exchanges` | what single exchanges of charge at the interface would change |
//! | `result` | the answer, as JSON has it |
//! | `answer` | the answer in words |

mod answer;
mod bound_state;
mod estimate;
mod exchanges;
pub(super) mod fast;
pub(super) mod input;
pub(super) mod interface;
mod result;
mod settings;
mod uptake;

pub use bound_state::BoundStateSummary;
pub use result::{Binding, BindingCondition, BoundBody, ExchangeRow, SlopeAtPh};
pub use settings::BindingSettings;

use anyhow::Result;
use estimate::Estimate;
use exchanges::InterfaceCharge;
use fast::FastInteraction;
use input::{Inputs, Partners};
use interface::Interface;
use protomer_field::FieldError;
use protomer_field::binding::{BindingEnergy, BoundPair};
use protomer_kernel::Electrolyte;
use protomer_results::{End, Execution};
use uptake::ProtonUptake;

/// The charge part of the binding free energy of the two bodies of a complex.
///
/// ```no_run
/// use protomer_protein_verbs::stability::binding::{BindingSettings, binding};
/// use protomer_common::answer::Answer;
/// use protomer_results::{End, Execution};
/// let settings = BindingSettings {
///     receptor: "protease.pdb".into(),
///     bodies: vec!["A".parse()?, "B".parse()?],
///     salt_molar: vec![0.05, 0.15],
///     ..BindingSettings::default()
/// };
/// if let End::Finished(found) = binding(&settings, &Execution::default())? {
///     println!("{}", found.text());
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// For settings out of range, files that cannot be read or hold other than two bodies, bodies far from
/// each other or within each other, and as [`BoundPair::binding_energy`].
pub fn binding(settings: &BindingSettings, execution: &Execution) -> Result<End<Binding>> {
    let electrolytes = settings.electrolytes()?;
    let inputs = Inputs::read(settings)?;
    let uptake = match settings.proton_uptake {
        true => match ProtonUptake::new(&inputs, settings, execution)? {
            End::Finished(uptake) => Some(uptake),
            End::Stopped => return Ok(End::Stopped),
        },
        false => None,
    };
    let mut result = Binding::new(settings, &inputs);
    for (number, ph) in inputs.ph.iter().enumerate() {
        let partners = inputs.partners(*ph)?;
        let interface = Interface::find(&partners)?;
        let fast = FastInteraction::new(&partners, settings)?;
        let charges = match settings.exchanges {
            true => exchanges::at_interface(&partners, &interface),
            false => Vec::new(),
        };
        if number == 0 {
            let solves = BoundPair::solves(electrolytes.len(), charges.len());
            let total = solves * inputs.ph.len();
            execution.progress.begin(total as u64, "solves");
            result.describe(&partners, &interface, &fast)?;
        }
        let solved = solve(&partners, settings, &electrolytes, &charges, execution)?;
        let End::Finished(energy) = solved else {
            return Ok(End::Stopped);
        };
        let contacts = interface.affinity(&partners);
        let estimate = Estimate::new(&inputs, &partners, contacts, *ph, settings, &energy)?;
        result.add(*ph, settings, &energy, &fast, &estimate, execution)?;
        if execution.interrupt.is_requested() {
            return Ok(End::Stopped);
        }
        result.add_exchanges(*ph, &charges, &energy);
        if let Some(uptake) = &uptake {
            result.add_uptake(*ph, uptake);
        }
    }
    result.finish();
    Ok(End::Finished(result))
}

/// Reasons for an early end of the solves.
enum Early {
    Stopped,
    Failed(FieldError),
}

impl From<FieldError> for Early {
    fn from(error: FieldError) -> Self {
        Self::Failed(error)
    }
}

/// The Poisson-Boltzmann energies at one pH.
fn solve(
    partners: &Partners,
    settings: &BindingSettings,
    electrolytes: &[Electrolyte],
    charges: &[InterfaceCharge],
    execution: &Execution,
) -> Result<End<BindingEnergy>> {
    let [first, second] = partners.spheres();
    let (dielectric, numerical) = (settings.dielectric(electrolytes[0]), settings.solve());
    let pair = BoundPair {
        parts: [&first, &second],
        dielectric: &dielectric,
        settings: &numerical,
    };
    let added: Vec<_> = charges.iter().map(InterfaceCharge::one_charge).collect();
    let mut solved = || {
        execution.progress.advance(1);
        match execution.interrupt.is_requested() {
            true => Err(Early::Stopped),
            false => Ok(()),
        }
    };
    match pair.binding_energy(electrolytes, &added, &mut solved) {
        Ok(energy) => Ok(End::Finished(energy)),
        Err(Early::Stopped) => Ok(End::Stopped),
        Err(Early::Failed(error)) => Err(error.into()),
    }
}
