//! Where effective charges hold, and what is said where they do not.
//!
//! Charges are fitted to the potential in layers that begin 1.5 Å beyond the region which ions enter,
//! that is 3.5 Å beyond the atoms with ions of 2 Å. Nearer than that nothing ties them to the
//! potential, and the charges of a body in contact lie nearer. Desolvation of first order was compared
//! with solved fields of bodies at gaps of 3 Å and more.

use crate::stability::run::RunSettings;
use protomer_mc::System;
use protomer_mc::observables::contacts;

/// Surfaces that are nearer than this are outside the range of effective charges, Å.
pub const LEAST_GAP_ANGSTROM: f64 = 3.0;

/// A warning if bodies with effective charges are too near for them.
pub fn near_contact_warning(system: &System, run: &RunSettings) -> Option<String> {
    run.effective_charges?;
    let near = contacts(system, LEAST_GAP_ANGSTROM);
    let (first, second) = near.first()?;
    let others = match near.len() - 1 {
        0 => String::new(),
        1 => ", and those of one more pair,".to_owned(),
        more => format!(", and those of {more} more pairs,"),
    };
    let bodies = format!("the surfaces of bodies {first} and {second}{others}");
    Some(out_of_range(&bodies, run.desolvation))
}

/// The warning of a run: as [`near_contact_warning`] where its start is out of range, or that bodies
/// came into contact, where this many pairs of bodies were in contact on average.
pub fn run_warning(system: &System, run: &RunSettings, mean_contacts: f64) -> Option<String> {
    run.effective_charges?;
    near_contact_warning(system, run).or_else(|| {
        let gap_angstrom = run.contact_gap_angstrom;
        let bodies = format!("bodies came into contact (surfaces within {gap_angstrom} Å)");
        (mean_contacts > 0.0).then(|| warning_that(&bodies, run.desolvation))
    })
}

/// Warning about the energies of surfaces that are too near.
pub(crate) fn out_of_range(surfaces: &str, has_desolvation: bool) -> String {
    let near = format!("{surfaces} are nearer than {LEAST_GAP_ANGSTROM} Å");
    warning_that(&near, has_desolvation)
}

fn warning_that(happened: &str, has_desolvation: bool) -> String {
    let terms = match has_desolvation {
        true => "effective charges and desolvation",
        false => "effective charges",
    };
    format!(
        "warning: {happened}: {terms} hold where surfaces are {LEAST_GAP_ANGSTROM} Å apart or more, and \
         their energies at contact may be wrong by many kT; --interaction response is made for contacts"
    )
}
