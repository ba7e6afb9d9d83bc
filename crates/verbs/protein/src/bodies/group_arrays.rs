//! Titratable groups of a body as the arrays of its file.

use anyhow::{Result, bail};
use protomer_body::chemistry::titration::{BodyGroup, BodyTitration};
use protomer_io::container::{Array, Container};
use protomer_kernel::point_record::LARGEST_CHARGE_E;

/// Array with a row for each group: charge, model pKa, shift, charged share, whether there are tautomers, their energy.
const VALUES: &str = "group_values";
/// Array with a row for each change of charge: group, site, charge.
const CHANGES: &str = "group_changes";
const PAIRS: &str = "group_pair_kt";
const TAUTOMER_PAIRS: &str = "group_tautomer_pair_kt";
/// Largest magnitude of an energy or a pKa that is taken for one.
const LARGEST_ENERGY_KT: f64 = 1e6;

/// Adds the arrays to the file of a body.
///
/// # Errors
/// For tables whose sizes do not fit.
pub(super) fn insert(container: &mut Container, titration: &BodyTitration) -> Result<()> {
    let (mut values, mut changes) = (Vec::new(), Vec::new());
    for (number, group) in titration.groups.iter().enumerate() {
        values.extend([
            group.charge_e,
            group.model_pka,
            group.shift_kt,
            group.charged_share,
            f64::from(u8::from(group.tautomer_kt.is_some())),
            group.tautomer_kt.unwrap_or(0.0),
        ]);
        for (site, charge_e) in &group.change_e {
            changes.extend([number as f64, f64::from(*site), *charge_e]);
        }
    }
    let (groups, rows) = (titration.groups.len(), changes.len() / 3);
    container.insert(VALUES, Array::f64(values, [groups, 6])?);
    container.insert(CHANGES, Array::f64(changes, [rows, 3])?);
    let squared = [groups, groups];
    container.insert(PAIRS, Array::f64(titration.pair_kt.clone(), squared)?);
    let tautomers = Array::f64(titration.tautomer_pair_kt.clone(), squared)?;
    container.insert(TAUTOMER_PAIRS, tautomers);
    Ok(())
}

/// The titration with the arrays of the file of a body of so many sites.
///
/// # Errors
/// For arrays that are missing or contradict each other.
pub(super) fn read(
    file: &str,
    container: &Container,
    conditions: BodyTitration,
    sites: usize,
) -> Result<BodyTitration> {
    let numbers = |name: &str, columns: Option<usize>| -> Result<&[f64]> {
        let values = container.f64(file, name, &[None, columns])?;
        if values
            .iter()
            .any(|value| !value.is_finite() || value.abs() > LARGEST_ENERGY_KT)
        {
            bail!("array '{name}' has a value that is no energy, charge or pKa");
        }
        Ok(values)
    };
    let mut titration = conditions;
    let conditions = [
        titration.ph,
        titration.salt_molar,
        titration.temperature_kelvin,
    ];
    if !conditions.iter().all(|number| number.is_finite()) {
        bail!("the conditions of its titratable groups are no numbers");
    }
    for row in numbers(VALUES, Some(6))?.as_chunks::<6>().0 {
        let [
            charge_e,
            model_pka,
            shift_kt,
            charged_share,
            has_tautomers,
            tautomer_kt,
        ] = *row;
        if charge_e.abs() != 1.0 || !(0.0..=1.0).contains(&charged_share) {
            bail!("array '{VALUES}' has a row that is no titratable group");
        }
        titration.groups.push(BodyGroup {
            charge_e,
            model_pka,
            shift_kt,
            tautomer_kt: (has_tautomers != 0.0).then_some(tautomer_kt),
            charged_share,
            change_e: Vec::new(),
        });
    }
    for row in numbers(CHANGES, Some(3))?.as_chunks::<3>().0 {
        let [group, site, charge_e] = *row;
        let is_index =
            |value: f64, end: usize| value.fract() == 0.0 && (0.0..end as f64).contains(&value);
        let is_change = is_index(group, titration.groups.len())
            && is_index(site, sites)
            && charge_e.abs() <= LARGEST_CHARGE_E;
        if !is_change {
            bail!("array '{CHANGES}' has a row that is no change of charge of a site");
        }
        titration.groups[group as usize]
            .change_e
            .push((site as u32, charge_e));
    }
    titration.pair_kt = numbers(PAIRS, None)?.to_vec();
    titration.tautomer_pair_kt = numbers(TAUTOMER_PAIRS, None)?.to_vec();
    let squared = titration.groups.len() * titration.groups.len();
    if [titration.pair_kt.len(), titration.tautomer_pair_kt.len()] != [squared; 2] {
        bail!("its tables of titratable groups differ in size");
    }
    Ok(titration)
}
