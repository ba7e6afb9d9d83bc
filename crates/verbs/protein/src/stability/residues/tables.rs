//! The answer as CSV.

use super::result::{MutationRow, PairRow, ResidueName, ResidueRow};
use anyhow::Result;
use protomer_io::csv::{Cell, Table};
use protomer_mc::pair::Term;

/// A row per residue.
pub fn residues(rows: &[ResidueRow]) -> Result<String> {
    let mut columns = name_columns("");
    columns.extend(["energy_kt", "error_kt"].map(str::to_owned));
    columns.extend(Term::ALL.map(|term| term.key().to_owned()));
    columns.extend(["touching", "surface_angstrom2", "buried"].map(str::to_owned));
    let mut table = Table::new(columns);
    for row in rows {
        let mut cells = name(&row.name);
        cells.extend([row.energy_kt.mean.into(), row.energy_kt.error.into()]);
        cells.extend(row.parts.values().map(Cell::from));
        cells.extend([
            row.touching.into(),
            row.surface_angstrom2.into(),
            Cell::Integer(i64::from(row.buried)),
        ]);
        table.push(cells)?;
    }
    Ok(table.to_csv()?)
}

/// A row per pair of residues.
pub fn pairs(rows: &[PairRow]) -> Result<String> {
    let mut columns = name_columns("first_");
    columns.extend(name_columns("second_"));
    columns.extend(["energy_kt", "error_kt"].map(str::to_owned));
    let of_pairs = Term::ALL
        .into_iter()
        .filter(|term| term.is_sum_over_pairs());
    columns.extend(of_pairs.map(|term| term.key().to_owned()));
    columns.extend(["touching", "contacts"].map(str::to_owned));
    let mut table = Table::new(columns);
    for row in rows {
        let mut cells = name(&row.first);
        cells.extend(name(&row.second));
        cells.extend([row.energy_kt.mean.into(), row.energy_kt.error.into()]);
        cells.extend(row.parts.values().map(Cell::from));
        cells.extend([row.touching.into(), row.contacts.into()]);
        table.push(cells)?;
    }
    Ok(table.to_csv()?)
}

/// A row per exchange.
pub fn mutations(rows: &[MutationRow]) -> Result<String> {
    let mut table = Table::new([
        "body",
        "mutation",
        "charge_change_e",
        "touching",
        "energy_change_kt",
        "energy_change_error_kt",
        "effective_frames",
        "first_order_half_salt_molar",
        "half_salt_molar",
        "half_salt_shift_molar",
        "half_salt_shift_error_molar",
    ]);
    for row in rows {
        let shift = row.half_salt_shift_molar;
        table.push([
            Cell::Text(row.name.body.clone()),
            Cell::Text(row.mutation.clone()),
            row.charge_change_e.into(),
            row.touching.into(),
            row.energy_change_kt.mean.into(),
            row.energy_change_kt.error.into(),
            row.effective_frames.into(),
            row.first_order_half_salt_molar.into(),
            row.half_salt_molar.into(),
            shift.map(|shift| shift.mean).into(),
            shift.and_then(|shift| shift.error).into(),
        ])?;
    }
    Ok(table.to_csv()?)
}

fn name_columns(which: &str) -> Vec<String> {
    ["body", "chain", "number", "insertion_code", "residue"]
        .map(|column| format!("{which}{column}"))
        .to_vec()
}

fn name(name: &ResidueName) -> Vec<Cell> {
    vec![
        Cell::Text(name.body.clone()),
        Cell::Text(name.chain.clone()),
        Cell::Integer(i64::from(name.number)),
        Cell::Text(name.insertion_code.clone()),
        Cell::Text(name.residue.clone()),
    ]
}
