//! The rows of mmCIF's `_atom_site`, one atom each.

use super::cif_syntax::Row;
use super::contents::{Atom, Model, Structure};
use super::corrections::{Correction, describe};
use super::element::{self, Statement};
use super::messages::{parse_error, quoted};
use super::names::Names;
use crate::{BodyError, Result};
use protomer_kernel::Vec3;
use std::collections::HashMap;

/// Reads rows into the models of a structure.
#[derive(Default)]
pub(crate) struct AtomSites {
    /// Index of each model number.
    models: HashMap<i32, usize>,
    /// Positions of the items in a row.
    columns: Option<Columns>,
    serial: i64,
}

/// An item that a row may lack.
#[derive(Clone, Copy)]
enum Item {
    Group,
    Id,
    Symbol,
    LabelAtom,
    AuthorAtom,
    Alternate,
    LabelResidue,
    AuthorResidue,
    LabelChain,
    AuthorChain,
    LabelNumber,
    AuthorNumber,
    InsertionCode,
    Occupancy,
    BFactor,
    FormalCharge,
    Model,
}

/// Names of the items in lower case, in the order of [`Item`].
const ITEMS: [&str; 17] = [
    "group_pdb",
    "id",
    "type_symbol",
    "label_atom_id",
    "auth_atom_id",
    "label_alt_id",
    "label_comp_id",
    "auth_comp_id",
    "label_asym_id",
    "auth_asym_id",
    "label_seq_id",
    "auth_seq_id",
    "pdbx_pdb_ins_code",
    "occupancy",
    "b_iso_or_equiv",
    "pdbx_formal_charge",
    "pdbx_pdb_model_num",
];

/// Positions of the items of `_atom_site` in a row.
struct Columns {
    /// Number of items; a second loop must have the same.
    width: usize,
    coordinates: [usize; 3],
    optional: [Option<usize>; ITEMS.len()],
}

impl Columns {
    fn from_row(source: &str, row: &Row) -> Result<Self> {
        let find = |item: &str| row.items.iter().position(|name| name == item);
        let require = |item: &str| {
            let remedy = "give an mmCIF file with Cartesian coordinates";
            let cause = format!("_atom_site.{item} is missing");
            find(item).ok_or_else(|| parse_error(source, row.line, cause, remedy))
        };
        Ok(Self {
            width: row.items.len(),
            coordinates: [
                require("cartn_x")?,
                require("cartn_y")?,
                require("cartn_z")?,
            ],
            optional: ITEMS.map(find),
        })
    }
}

/// A row with the positions of its items.
struct Cells<'a, 'r> {
    source: &'r str,
    row: &'r Row<'a, 'r>,
    columns: &'r Columns,
}

impl<'a> Cells<'a, '_> {
    fn cell(&self, column: usize) -> Option<&'a str> {
        self.row.values.get(column).copied().flatten()
    }

    fn get(&self, item: Item) -> Option<&'a str> {
        self.cell(self.columns.optional[item as usize]?)
    }

    /// The first of two items that has a value.
    fn either(&self, first: Item, second: Item) -> Option<&'a str> {
        self.get(first).or_else(|| self.get(second))
    }

    fn error(&self, cause: String) -> BodyError {
        parse_error(
            self.source,
            self.row.line,
            cause,
            "correct or delete the row",
        )
    }

    fn position(&self) -> Result<Vec3> {
        let [x, y, z] = self.columns.coordinates;
        Ok(Vec3::new(
            self.coordinate("Cartn_x", x)?,
            self.coordinate("Cartn_y", y)?,
            self.coordinate("Cartn_z", z)?,
        ))
    }

    fn coordinate(&self, name: &str, column: usize) -> Result<f64> {
        const LARGEST_ANGSTROM: f64 = 1e6;
        let text = self.cell(column).unwrap_or("?");
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() && value.abs() <= LARGEST_ANGSTROM => Ok(value),
            _ => Err(self.error(format!("{name} is {}, not a coordinate in Å", quoted(text)))),
        }
    }

    /// A whole number, or `default` where there is none.
    fn whole_number(&self, name: &str, text: Option<&str>, default: i32) -> Result<i32> {
        let Some(text) = text else {
            return Ok(default);
        };
        text.parse()
            .map_err(|_| self.error(format!("{name} is {}", quoted(text))))
    }

    /// A number and whether it could be read; `default` where there is none or it could not.
    fn number_or(&self, item: Item, default: f64) -> (f64, bool) {
        match self.get(item).map(str::parse::<f64>) {
            Some(Ok(number)) if number.is_finite() => (number, true),
            Some(_) => (default, false),
            None => (default, true),
        }
    }

    /// Whether the row lacks a sequence number although the category has them: the atom is of a
    /// ligand.
    fn lacks_sequence_number(&self) -> bool {
        self.columns.optional[Item::LabelNumber as usize].is_some()
            && self.get(Item::LabelNumber).is_none()
    }
}

impl AtomSites {
    /// Adds the atom of a row to its model.
    pub(crate) fn read(
        &mut self,
        row: &Row,
        names: &mut Names,
        structure: &mut Structure,
    ) -> Result<()> {
        let columns = match self.columns.take() {
            Some(columns) if columns.width == row.items.len() => columns,
            _ => Columns::from_row(&structure.source, row)?,
        };
        let cells = Cells {
            source: &structure.source,
            row,
            columns: &columns,
        };
        let model = cells.whole_number("model number", cells.get(Item::Model), 1)?;
        let (atom, is_odd, has_odd_element) = self.atom(&cells, names)?;
        if is_odd {
            let message = "occupancy or B factor is not a number; 1 and 0 are used";
            structure.warnings.add(row.line, message);
        }
        if has_odd_element {
            structure
                .corrections
                .add(Correction::Element, row.line, || describe(&atom));
        }
        self.columns = Some(columns);
        self.model(model, structure).atoms.push(atom);
        Ok(())
    }

    fn model<'s>(&mut self, number: i32, structure: &'s mut Structure) -> &'s mut Model {
        let models = &mut structure.models;
        let index = *self.models.entry(number).or_insert_with(|| {
            models.push(Model {
                number,
                atoms: Vec::new(),
            });
            models.len() - 1
        });
        &mut models[index]
    }

    /// The atom of a row, whether its occupancy or B factor could not be read, and whether it is
    /// stated to be of another element than its name.
    fn atom(&mut self, cells: &Cells, names: &mut Names) -> Result<(Atom, bool, bool)> {
        let position = cells.position()?;
        let Some(name) = cells.either(Item::AuthorAtom, Item::LabelAtom) else {
            return Err(cells.error("the atom has no name".into()));
        };
        let residue_name = cells.either(Item::AuthorResidue, Item::LabelResidue);
        let number = cells.either(Item::AuthorNumber, Item::LabelNumber);
        let chain = cells.either(Item::AuthorChain, Item::LabelChain);
        let label_chain = cells.either(Item::LabelChain, Item::AuthorChain);
        let (occupancy, is_occupancy_read) = cells.number_or(Item::Occupancy, 1.0);
        let (b_factor_angstrom2, is_b_factor_read) = cells.number_or(Item::BFactor, 0.0);
        let hetero = cells.get(Item::Group) == Some("HETATM");
        let residue_name = residue_name.unwrap_or("UNK");
        let (element, has_odd_element) = element::of_atom(&Statement {
            symbol: cells.get(Item::Symbol).unwrap_or(""),
            name: &format!(" {name}"),
            residue_name,
            hetero,
        });
        let serial = cells.get(Item::Id).and_then(|id| id.parse().ok());
        self.serial = serial.unwrap_or(self.serial.saturating_add(1));
        let alternate = cells.get(Item::Alternate).unwrap_or("");
        let formal_charge = cells.get(Item::FormalCharge).unwrap_or("");
        let atom = Atom {
            serial: self.serial,
            name: names.share(name),
            alternate: alternate.chars().next(),
            residue_name: names.share(residue_name),
            chain: names.share(chain.unwrap_or("")),
            label_chain: names.share(label_chain.unwrap_or("")),
            segment: names.share(""),
            polymer: 0,
            residue_number: cells.whole_number("residue number", number, 0)?,
            insertion_code: names.share(cells.get(Item::InsertionCode).unwrap_or("")),
            element: names.share(element),
            occupancy,
            b_factor_angstrom2,
            formal_charge_e: formal_charge.parse().ok(),
            position,
            hetero,
            outside_polymer: hetero && cells.lacks_sequence_number(),
        };
        let is_odd = !(is_occupancy_read && is_b_factor_read);
        Ok((atom, is_odd, has_odd_element))
    }
}
