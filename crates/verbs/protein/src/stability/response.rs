//! The response of the solvent to the bodies of a simulation, from their atoms.

use crate::stability::effective::{SoluteModel, require_electrolyte};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_field::solvent_response::regulated_response;
use protomer_field::{ChargedSphere, IonModel};
use protomer_kernel::Vec3;
use protomer_mc::solvent_response::{ResponseBody, ResponseGrid};

/// Solves for the response of a body in a medium: two solves of the Poisson-Boltzmann equation.
///
/// # Errors
/// As [`require_electrolyte`] and [`regulated_response`], and for ions that do not respond linearly; names
/// the body.
pub fn response_of(
    body: &Body,
    interaction: &ScreenedCoulomb,
    solute: &SoluteModel,
) -> Result<ResponseBody> {
    require_electrolyte(interaction, "response")?;
    if solute.ions != IonModel::Linear {
        bail!(
            "--interaction response is the response of linear ions; leave out --ions boltzmann, or use \
             --interaction effective"
        );
    }
    let dielectric = solute.dielectric(interaction.electrolyte);
    let spheres: Vec<ChargedSphere> = body.sites.iter().map(ChargedSphere::from).collect();
    let capacitances_e2 = match solute.regulation {
        true => &*body.capacitances_e2,
        false => &[],
    };
    if solute.regulation && capacitances_e2.is_empty() {
        bail!(
            "--regulation: the charges of body '{}' have no capacitances; make it with ingest --protonation \
             structure, or leave out --regulation",
            body.name
        );
    }
    let response = regulated_response(&spheres, capacitances_e2, &dielectric)
        .with_context(|| format!("response of the solvent to body '{}'", body.name))?;
    let table = response.table;
    let grid = ResponseGrid {
        origin_angstrom: Vec3::from(table.grid.origin_angstrom),
        spacing_angstrom: table.grid.spacing_angstrom,
        shape: table.grid.shape,
        values: table.values,
    };
    let sites: Vec<_> = response
        .sites
        .iter()
        .map(|site| {
            let amounts = [
                site.charge_e,
                site.dielectric_angstrom3,
                site.ionic_angstrom3,
                site.capacitance_e2,
            ];
            (site.place, amounts)
        })
        .collect();
    let charges = spheres
        .iter()
        .map(|sphere| (sphere.centre, sphere.charge_e));
    Ok(ResponseBody::new(grid, &sites, charges.collect())?)
}
