//! mmCIF categories: atom_site, cell, symmetry, exptl, refine, struct, unobserved residues,
//! assemblies.

use super::biological_assembly::{
    AssemblyPart, BiologicalAssembly, MOST_OPERATORS, Operator, evaluate,
};
use super::cif_syntax::{Row, read_rows};
use super::ending::Ending;
use super::{
    Atom, Model, Names, ResidueKey, Structure, UnitCell, UnobservedResidue, element, parse_error,
    quoted,
};
use crate::Result;
use nalgebra::Matrix3;
use protomer_kernel::Vec3;
use std::cell::Cell;
use std::collections::HashMap;

/// Categories that are read; the rest is skipped.
const WANTED: [&str; 14] = [
    "atom_site",
    "entry",
    "struct",
    "exptl",
    "refine",
    "em_3d_reconstruction",
    "cell",
    "symmetry",
    "space_group",
    "pdbx_unobs_or_zero_occ_residues",
    "pdbx_struct_assembly",
    "pdbx_struct_assembly_gen",
    "pdbx_struct_oper_list",
    "reflns",
];

/// Reads an mmCIF file.
pub(crate) fn read(source: &str, text: &str) -> Result<Structure> {
    let mut reader = Reader {
        structure: Structure {
            source: source.to_string(),
            ..Structure::default()
        },
        ..Reader::default()
    };
    let (atoms_are_last, is_entry) = (Cell::new(false), Cell::new(false));
    let wants = |category: &str| {
        atoms_are_last.set(category == "atom_site");
        is_entry.set(is_entry.get() || OF_ENTRIES.contains(&category));
        WANTED.contains(&category)
    };
    read_rows(source, text, wants, |row| reader.row(row))?;
    reader.structure.ending = ending(text, is_entry.get(), atoms_are_last.get());
    if let Ending::CutOff(message) = &reader.structure.ending {
        reader.structure.warnings.add(text.lines().count(), message);
    }
    reader.finish()
}

/// Categories that show a file to be an entry of the archive.
const OF_ENTRIES: [&str; 3] = ["audit_conform", "database_2", "pdbx_database_status"];

/// A row that is not whole is an error of the grammar. A cut between two rows shows in entries of
/// the archive only, where a line of `#` ends every category.
fn ending(text: &str, is_entry: bool, atoms_are_last: bool) -> Ending {
    let is_mark = |line: &str| line.starts_with('#');
    if text
        .lines()
        .rfind(|line| !line.trim().is_empty())
        .is_some_and(is_mark)
    {
        return Ending::Whole;
    }
    if is_entry && text.lines().any(|line| line.trim_end() == "#") {
        let message = "a line of # ends every category of the file but the last: it may have been cut off; compare it with \
                       the entry, or fetch it again; if it is whole, add a line #";
        return Ending::CutOff(message.into());
    }
    if atoms_are_last {
        Ending::Unknown
    } else {
        Ending::Whole
    }
}

#[derive(Default)]
struct Reader {
    structure: Structure,
    names: Names,
    /// Index of each model number.
    models: HashMap<i32, usize>,
    /// Where the items of atom_site stand in its rows.
    columns: Option<Columns>,
    details: HashMap<String, String>,
    /// Assembly, expression, chains, line.
    generators: Vec<(String, String, String, usize)>,
    operators: HashMap<String, Operator>,
    serial: i64,
}

/// Columns of atom_site.
struct Columns {
    /// Number of items, to see that the rows of a second loop agree.
    width: usize,
    required: [usize; 3],
    optional: [Option<usize>; ITEMS.len()],
}

/// Optional items of atom_site, in the order of the constants below.
const ITEMS: [&str; 19] = [
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
    "label_entity_id",
    "calc_flag",
];
const GROUP: usize = 0;
const ID: usize = 1;
const SYMBOL: usize = 2;
const LABEL_ATOM: usize = 3;
const AUTHOR_ATOM: usize = 4;
const ALTERNATE: usize = 5;
const LABEL_RESIDUE: usize = 6;
const AUTHOR_RESIDUE: usize = 7;
const LABEL_CHAIN: usize = 8;
const AUTHOR_CHAIN: usize = 9;
const LABEL_NUMBER: usize = 10;
const AUTHOR_NUMBER: usize = 11;
const INSERTION_CODE: usize = 12;
const OCCUPANCY: usize = 13;
const B_FACTOR: usize = 14;
const FORMAL_CHARGE: usize = 15;
const MODEL: usize = 16;

impl Reader {
    fn row(&mut self, row: &Row) -> Result<()> {
        let text = |item: &str| row.get(item).unwrap_or("").to_string();
        let header = &mut self.structure.header;
        match row.category {
            "atom_site" => self.atom(row)?,
            "entry" => header.entry = text("id"),
            "struct" => header.title = text("title"),
            "exptl" => {
                if !header.method.is_empty() {
                    header.method.push_str("; ");
                }
                header.method.push_str(row.get("method").unwrap_or(""));
            }
            "refine" | "em_3d_reconstruction" | "reflns" => {
                let item = match row.category {
                    "refine" => "ls_d_res_high",
                    "reflns" => "d_resolution_high",
                    _ => "resolution",
                };
                let value = row.get(item).and_then(|value| value.parse::<f64>().ok());
                let value = value.filter(|value| value.is_finite() && *value > 0.0);
                header.resolution_angstrom = header.resolution_angstrom.or(value);
            }
            "cell" => header.cell = cell(row),
            "symmetry" | "space_group" => {
                let symbol = row
                    .get("space_group_name_h-m")
                    .or_else(|| row.get("name_h-m_alt"));
                header.space_group = symbol
                    .map(str::to_string)
                    .or_else(|| header.space_group.take());
            }
            "pdbx_unobs_or_zero_occ_residues" => self.unobserved(row),
            "pdbx_struct_assembly" => {
                let details = row
                    .get("oligomeric_details")
                    .or_else(|| row.get("details"))
                    .unwrap_or("");
                self.details.insert(text("id"), details.to_string());
            }
            "pdbx_struct_assembly_gen" => {
                let generator = (
                    text("assembly_id"),
                    text("oper_expression"),
                    text("asym_id_list"),
                    row.line,
                );
                self.generators.push(generator);
            }
            "pdbx_struct_oper_list" => self.operator(row),
            _ => {}
        }
        Ok(())
    }

    fn columns(&mut self, row: &Row) -> Result<()> {
        if self
            .columns
            .as_ref()
            .is_some_and(|columns| columns.width == row.items.len())
        {
            return Ok(());
        }
        let find = |item: &str| row.items.iter().position(|name| name == item);
        let missing = |item: &str| {
            let cause = format!("_atom_site.{item} is missing");
            parse_error(
                &self.structure.source,
                row.line,
                cause,
                "give an mmCIF file with Cartesian coordinates",
            )
        };
        let require = |item: &str| find(item).ok_or_else(|| missing(item));
        self.columns = Some(Columns {
            width: row.items.len(),
            required: [
                require("cartn_x")?,
                require("cartn_y")?,
                require("cartn_z")?,
            ],
            optional: ITEMS.map(find),
        });
        Ok(())
    }

    fn atom(&mut self, row: &Row) -> Result<()> {
        self.columns(row)?;
        let Some(columns) = &self.columns else {
            return Ok(());
        };
        let source = &self.structure.source;
        let raw = |index: usize| row.values.get(index).copied().flatten();
        let value = |item: usize| columns.optional[item].and_then(raw);
        let author_or_label = |author: usize, label: usize| value(author).or_else(|| value(label));
        let error = |cause: String| parse_error(source, row.line, cause, "mend or delete the row");
        let number =
            |index: usize, name: &str| match raw(index).and_then(|text| text.parse::<f64>().ok()) {
                Some(value) if value.is_finite() && value.abs() <= 1e6 => Ok(value),
                _ => Err(error(format!(
                    "{name} is {}, not a coordinate in Å",
                    quoted(raw(index).unwrap_or("?"))
                ))),
            };
        let [x, y, z] = columns.required;
        let position = Vec3::new(
            number(x, "Cartn_x")?,
            number(y, "Cartn_y")?,
            number(z, "Cartn_z")?,
        );
        let name = author_or_label(AUTHOR_ATOM, LABEL_ATOM)
            .ok_or_else(|| error("the atom has no name".into()))?;
        let residue_number =
            match author_or_label(AUTHOR_NUMBER, LABEL_NUMBER).map(str::parse::<i32>) {
                Some(Ok(number)) => number,
                None => 0,
                Some(Err(_)) => {
                    let text = author_or_label(AUTHOR_NUMBER, LABEL_NUMBER).unwrap_or("?");
                    return Err(error(format!("residue number is {}", quoted(text))));
                }
            };
        let model = match value(MODEL).map(str::parse::<i32>) {
            None => 1,
            Some(Ok(number)) => number,
            Some(Err(_)) => {
                return Err(error(format!(
                    "model number is {}",
                    quoted(value(MODEL).unwrap_or("?"))
                )));
            }
        };
        let lenient = |item: usize, default: f64| match value(item).map(str::parse::<f64>) {
            Some(Ok(number)) if number.is_finite() => (number, false),
            None => (default, false),
            Some(_) => (default, true),
        };
        let (occupancy, odd_occupancy) = lenient(OCCUPANCY, 1.0);
        let (b_factor_angstrom2, odd_b_factor) = lenient(B_FACTOR, 0.0);
        let hetero = value(GROUP) == Some("HETATM");
        let element = value(SYMBOL)
            .and_then(element::known)
            .unwrap_or_else(|| element::from_name(name));
        self.serial = value(ID)
            .and_then(|id| id.parse().ok())
            .unwrap_or(self.serial.saturating_add(1));
        let label_chain = value(LABEL_CHAIN).or(value(AUTHOR_CHAIN)).unwrap_or("");
        let atom = Atom {
            serial: self.serial,
            name: self.names.share(name),
            alternate: value(ALTERNATE).and_then(|text| text.chars().next()),
            residue_name: self
                .names
                .share(author_or_label(AUTHOR_RESIDUE, LABEL_RESIDUE).unwrap_or("UNK")),
            chain: self
                .names
                .share(author_or_label(AUTHOR_CHAIN, LABEL_CHAIN).unwrap_or("")),
            label_chain: self.names.share(label_chain),
            residue_number,
            insertion_code: self.names.share(value(INSERTION_CODE).unwrap_or("")),
            element: self.names.share(element),
            occupancy,
            b_factor_angstrom2,
            formal_charge_e: value(FORMAL_CHARGE).and_then(|text| text.parse().ok()),
            position,
            hetero,
            outside_polymer: hetero
                && columns.optional[LABEL_NUMBER].is_some()
                && value(LABEL_NUMBER).is_none(),
        };
        if odd_occupancy || odd_b_factor {
            self.structure.warnings.add(
                row.line,
                "occupancy or B factor is not a number; 1 and 0 are used",
            );
        }
        let models = &mut self.structure.models;
        let index = *self.models.entry(model).or_insert_with(|| {
            models.push(Model {
                number: model,
                atoms: Vec::new(),
            });
            models.len() - 1
        });
        models[index].atoms.push(atom);
        Ok(())
    }

    fn unobserved(&mut self, row: &Row) {
        let is_missing = row.get("occupancy_flag").is_none_or(|flag| flag == "1");
        let number = row
            .get("auth_seq_id")
            .and_then(|number| number.parse().ok());
        if let (true, Some(number)) = (is_missing, number) {
            let key = ResidueKey {
                chain: self.names.share(row.get("auth_asym_id").unwrap_or("")),
                number,
                insertion_code: self.names.share(row.get("pdb_ins_code").unwrap_or("")),
            };
            let name = self.names.share(row.get("auth_comp_id").unwrap_or("UNK"));
            self.structure
                .header
                .unobserved
                .push(UnobservedResidue { key, name });
        }
    }

    fn operator(&mut self, row: &Row) {
        let number = |item: String| {
            row.get(&item)
                .and_then(|text| text.parse::<f64>().ok())
                .unwrap_or(f64::NAN)
        };
        let rotation = Matrix3::from_fn(|i, j| number(format!("matrix[{}][{}]", i + 1, j + 1)));
        let translation = Vec3::from_fn(|i, _| number(format!("vector[{}]", i + 1)));
        let name = row.get("id").unwrap_or("").to_string();
        self.operators.insert(
            name.clone(),
            Operator {
                name,
                rotation,
                translation,
            },
        );
    }

    fn finish(mut self) -> Result<Structure> {
        self.assemblies()?;
        if self.structure.header.cell.is_none() {
            self.structure.header.space_group = None;
        }
        Ok(self.structure)
    }

    /// Evaluates the generators, now that all operators are known.
    fn assemblies(&mut self) -> Result<()> {
        let assemblies = &mut self.structure.assemblies;
        let mut index_of: HashMap<String, usize> = HashMap::new();
        let mut total = 0;
        for (id, expression, chains, line) in std::mem::take(&mut self.generators) {
            let error = |cause: String| {
                let cause = format!("operator expression {}: {cause}", quoted(&expression));
                parse_error(
                    &self.structure.source,
                    line,
                    cause,
                    "mend _pdbx_struct_assembly_gen or remove it",
                )
            };
            let operators = evaluate(&expression, &self.operators).map_err(error)?;
            total += operators.len();
            if total > MOST_OPERATORS {
                return Err(error(format!(
                    "with it there are more than {MOST_OPERATORS} operators"
                )));
            }
            let chains = chains
                .split(',')
                .map(str::trim)
                .filter(|chain| !chain.is_empty());
            let part = AssemblyPart {
                chains: chains.map(|chain| self.names.share(chain)).collect(),
                operators,
            };
            let index = *index_of.entry(id.clone()).or_insert_with(|| {
                let details = self.details.get(&id).cloned().unwrap_or_default();
                assemblies.push(BiologicalAssembly {
                    id,
                    details,
                    parts: Vec::new(),
                });
                assemblies.len() - 1
            });
            assemblies[index].parts.push(part);
        }
        Ok(())
    }
}

fn cell(row: &Row) -> Option<UnitCell> {
    let number = |item: &str| {
        row.get(item)
            .and_then(|text| text.parse::<f64>().ok())
            .unwrap_or(f64::NAN)
    };
    UnitCell::of_crystal(
        ["length_a", "length_b", "length_c"].map(number),
        ["angle_alpha", "angle_beta", "angle_gamma"].map(number),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the archive writes it, shortened.
    const ENTRY: &str = "data_1ABC\n#\n_audit_conform.dict_name mmcif_pdbx.dic\n#\nloop_\n_atom_site.group_PDB\n\
                         _atom_site.label_atom_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n\
                         _atom_site.pdbx_PDB_model_num\nATOM N 1.25 2.50 3.75 10\nATOM CA 4.25 5.50 6.75 10\n#\n";

    #[test]
    fn an_entry_that_was_cut_off_anywhere_in_its_atoms_is_known() {
        let of = |text: &str| {
            read("1abc.cif", text).map(|structure| (structure.ending, structure.warnings.count))
        };
        assert_eq!(of(ENTRY).unwrap(), (Ending::Whole, 0));
        let whole = ENTRY.trim_end().len();
        let atoms = ENTRY.find("ATOM").unwrap();
        for cut in atoms..whole {
            let found = of(&ENTRY[..cut]);
            assert!(
                matches!(found, Err(_) | Ok((Ending::CutOff(_), 1))),
                "{cut}: {found:?}"
            );
        }
        // Within a row it cannot be read at all, and the message says where and what to do.
        let message = of(&ENTRY[..ENTRY.find(" 6.75").unwrap()])
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("1abc.cif:13:")
                && message.contains("4 of 6")
                && message.contains("fetch"),
            "{message}"
        );
    }

    #[test]
    fn a_file_by_hand_needs_no_mark_of_its_end() {
        let by_hand = ENTRY
            .replace("#\n", "")
            .replace("_audit_conform.dict_name mmcif_pdbx.dic\n", "");
        let of = |text: &str| read("own.cif", text).unwrap();
        assert_eq!(
            (of(&by_hand).ending, of(&by_hand).warnings.count),
            (Ending::Unknown, 0)
        );
        // Where something follows the atoms, they are all there.
        assert_eq!(
            of(&format!("{by_hand}_cell.length_a 10\n")).ending,
            Ending::Whole
        );
    }
}
