//! mmCIF categories: atoms, cell, symmetry, method, resolution, title, unobserved residues,
//! assemblies, disulfide bonds.

use super::atom_site::AtomSites;
use super::biological_assembly::{
    AssemblyPart, BiologicalAssembly, MOST_OPERATORS, Operator, evaluate,
};
use super::cif_syntax::{Row, read_rows};
use super::contents::{RecordedDisulfide, Structure, UnitCell, UnobservedResidue};
use super::ending::Ending;
use super::messages::{parse_error, quoted};
use super::names::Names;
use super::residue_key::ResidueKey;
use crate::{BodyError, Result};
use nalgebra::Matrix3;
use protomer_kernel::Vec3;
use std::cell::Cell;
use std::collections::HashMap;

/// Categories that are read; the rest is skipped.
const WANTED: [&str; 15] = [
    "atom_site",
    "entry",
    "struct",
    "struct_conn",
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

/// Categories that identify an entry of the archive.
const OF_ENTRIES: [&str; 3] = ["audit_conform", "database_2", "pdbx_database_status"];

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
    let structure = &mut reader.structure;
    structure.ending = ending(text, is_entry.get(), atoms_are_last.get());
    if let Ending::CutOff(message) = &structure.ending {
        structure.warnings.add(text.lines().count(), message);
    }
    reader.finish()
}

/// Ending of the file. A row that is not complete is an error of the grammar. A cut between two
/// rows shows only in entries of the archive, where a line of `#` ends every category.
fn ending(text: &str, is_entry: bool, atoms_are_last: bool) -> Ending {
    let last_line = text.trim_end().lines().next_back().unwrap_or("");
    if last_line.starts_with('#') {
        return Ending::Whole;
    }
    if is_entry && text.lines().any(|line| line.trim_end() == "#") {
        let message = "a line of # ends every category of the file but the last: it may have been \
                       cut off; compare it with the entry, or fetch it again; if it is complete, \
                       add a line #";
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
    atoms: AtomSites,
    details: HashMap<String, String>,
    generators: Vec<Generator>,
    operators: HashMap<String, Operator>,
}

/// A row of `_pdbx_struct_assembly_gen`.
struct Generator {
    assembly: String,
    expression: String,
    chains: String,
    line: usize,
}

impl Reader {
    fn row(&mut self, row: &Row) -> Result<()> {
        let header = &mut self.structure.header;
        match row.category {
            "atom_site" => self.atoms.read(row, &mut self.names, &mut self.structure)?,
            "entry" => header.entry = text(row, "id"),
            "struct" => header.title = text(row, "title"),
            "exptl" => {
                if !header.method.is_empty() {
                    header.method.push_str("; ");
                }
                header.method.push_str(row.get("method").unwrap_or(""));
            }
            "refine" => self.resolution(row, "ls_d_res_high"),
            "reflns" => self.resolution(row, "d_resolution_high"),
            "em_3d_reconstruction" => self.resolution(row, "resolution"),
            "cell" => header.cell = cell(row),
            "symmetry" => self.space_group(row, "space_group_name_h-m"),
            "space_group" => self.space_group(row, "name_h-m_alt"),
            "struct_conn" => self.connection(row),
            "pdbx_unobs_or_zero_occ_residues" => self.unobserved(row),
            "pdbx_struct_assembly" => {
                let details = row.get("oligomeric_details").or(row.get("details"));
                let details = details.unwrap_or("").to_string();
                self.details.insert(text(row, "id"), details);
            }
            "pdbx_struct_assembly_gen" => self.generators.push(Generator {
                assembly: text(row, "assembly_id"),
                expression: text(row, "oper_expression"),
                chains: text(row, "asym_id_list"),
                line: row.line,
            }),
            "pdbx_struct_oper_list" => self.operator(row),
            _ => {}
        }
        Ok(())
    }

    /// Takes the first resolution that the file states.
    fn resolution(&mut self, row: &Row, item: &str) {
        let value = number(row, item);
        let stated = &mut self.structure.header.resolution_angstrom;
        if stated.is_none() && value.is_finite() && value > 0.0 {
            *stated = Some(value);
        }
    }

    fn space_group(&mut self, row: &Row, item: &str) {
        if let Some(symbol) = row.get(item) {
            self.structure.header.space_group = Some(symbol.to_string());
        }
    }

    fn unobserved(&mut self, row: &Row) {
        let is_missing = row.get("occupancy_flag").is_none_or(|flag| flag == "1");
        let items = ["auth_asym_id", "auth_seq_id", "pdb_ins_code"];
        if let (true, Some(key)) = (is_missing, self.residue_key(row, items)) {
            let name = row.get("auth_comp_id").unwrap_or("UNK");
            let name = self.names.share(name);
            let residue = UnobservedResidue { key, name };
            self.structure.header.unobserved.push(residue);
        }
    }

    /// Keeps disulfide bonds; other connections are not used.
    fn connection(&mut self, row: &Row) {
        if row.get("conn_type_id") != Some("disulf") {
            return;
        }
        let first = self.residue_key(
            row,
            [
                "ptnr1_auth_asym_id",
                "ptnr1_auth_seq_id",
                "pdbx_ptnr1_pdb_ins_code",
            ],
        );
        let second = self.residue_key(
            row,
            [
                "ptnr2_auth_asym_id",
                "ptnr2_auth_seq_id",
                "pdbx_ptnr2_pdb_ins_code",
            ],
        );
        let symmetry = ["ptnr1_symmetry", "ptnr2_symmetry"];
        if let (Some(first), Some(second)) = (first, second) {
            self.structure.disulfides.push(RecordedDisulfide {
                residues: [first, second],
                symmetry: symmetry.map(|item| self.names.share(row.get(item).unwrap_or(""))),
            });
        }
    }

    /// The residue that a row names by chain, number and insertion code.
    fn residue_key(&mut self, row: &Row, items: [&str; 3]) -> Option<ResidueKey> {
        let [chain, number, code] = items.map(|item| row.get(item));
        Some(ResidueKey {
            chain: self.names.share(chain.unwrap_or("")),
            number: number?.parse().ok()?,
            insertion_code: self.names.share(code.unwrap_or("")),
        })
    }

    fn operator(&mut self, row: &Row) {
        let element = |i, j| number(row, &format!("matrix[{}][{}]", i + 1, j + 1));
        let component = |i, _| number(row, &format!("vector[{}]", i + 1));
        let name = text(row, "id");
        let operator = Operator {
            name: name.clone(),
            rotation: Matrix3::from_fn(element),
            translation: Vec3::from_fn(component),
        };
        self.operators.insert(name, operator);
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
        let mut total = 0;
        for generator in std::mem::take(&mut self.generators) {
            let operators = match evaluate(&generator.expression, &self.operators) {
                Ok(operators) => operators,
                Err(cause) => return Err(self.bad_expression(&generator, &cause)),
            };
            total += operators.len();
            if total > MOST_OPERATORS {
                let cause = format!("with it there are more than {MOST_OPERATORS} operators");
                return Err(self.bad_expression(&generator, &cause));
            }
            let mut chains = Vec::new();
            for chain in generator.chains.split(',').map(str::trim) {
                if !chain.is_empty() {
                    chains.push(self.names.share(chain));
                }
            }
            let part = AssemblyPart { chains, operators };
            self.assembly(&generator.assembly).parts.push(part);
        }
        Ok(())
    }

    /// The assembly of this identifier, a new one if there is none yet.
    fn assembly(&mut self, id: &str) -> &mut BiologicalAssembly {
        let assemblies = &mut self.structure.assemblies;
        let index = match assemblies.iter().position(|assembly| assembly.id == id) {
            Some(index) => index,
            None => {
                assemblies.push(BiologicalAssembly {
                    id: id.to_string(),
                    details: self.details.get(id).cloned().unwrap_or_default(),
                    parts: Vec::new(),
                });
                assemblies.len() - 1
            }
        };
        &mut assemblies[index]
    }

    fn bad_expression(&self, generator: &Generator, cause: &str) -> BodyError {
        let expression = quoted(&generator.expression);
        parse_error(
            &self.structure.source,
            generator.line,
            format!("operator expression {expression}: {cause}"),
            "correct _pdbx_struct_assembly_gen or remove it",
        )
    }
}

/// The text of an item; empty where there is none.
fn text(row: &Row, item: &str) -> String {
    row.get(item).unwrap_or("").to_string()
}

/// The number of an item; NaN where there is none.
fn number(row: &Row, item: &str) -> f64 {
    let text = row.get(item).unwrap_or("");
    text.parse().unwrap_or(f64::NAN)
}

fn cell(row: &Row) -> Option<UnitCell> {
    UnitCell::of_crystal(
        ["length_a", "length_b", "length_c"].map(|item| number(row, item)),
        ["angle_alpha", "angle_beta", "angle_gamma"].map(|item| number(row, item)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entry as the archive writes it, shortened.
    const ENTRY: &str = "data_1ABC\n#\n_audit_conform.dict_name mmcif_pdbx.dic\n#\nloop_\n_atom_site.group_PDB\n\
                         _atom_site.label_atom_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n\
                         _atom_site.pdbx_PDB_model_num\nATOM N 1.25 2.50 3.75 10\nATOM CA 4.25 5.50 6.75 10\n#\n";

    #[test]
    fn an_entry_that_was_cut_off_anywhere_in_its_atoms_is_known() {
        let parsed = |text: &str| {
            read("1abc.cif", text).map(|structure| (structure.ending, structure.warnings.count))
        };
        assert_eq!(parsed(ENTRY).unwrap(), (Ending::Whole, 0));
        let whole = ENTRY.trim_end().len();
        let atoms = ENTRY.find("ATOM").unwrap();
        for cut in atoms..whole {
            let found = parsed(&ENTRY[..cut]);
            assert!(
                matches!(found, Err(_) | Ok((Ending::CutOff(_), 1))),
                "{cut}: {found:?}"
            );
        }
        // Cut within a row, it cannot be read, and the message says where and what to do.
        let message = parsed(&ENTRY[..ENTRY.find(" 6.75").unwrap()])
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
    fn disulfide_bonds_are_read_and_other_connections_are_not() {
        let connections = "data_x\nloop_\n_struct_conn.id\n_struct_conn.conn_type_id\n\
            _struct_conn.ptnr1_auth_asym_id\n_struct_conn.ptnr1_auth_seq_id\n\
            _struct_conn.pdbx_ptnr1_PDB_ins_code\n_struct_conn.ptnr1_symmetry\n\
            _struct_conn.ptnr2_auth_asym_id\n_struct_conn.ptnr2_auth_seq_id\n\
            _struct_conn.ptnr2_symmetry\n\
            disulf1 disulf A 22 ? 1_555 B 27 1_555\n\
            disulf2 disulf A 30 C 1_555 A 30 2_655\n\
            covale1 covale A 31 ? 1_555 A 32 1_555\n";
        let found = read("x.cif", connections).unwrap().disulfides;
        let names = |bond: &RecordedDisulfide| {
            bond.residues
                .each_ref()
                .map(ResidueKey::to_string)
                .join("-")
        };
        assert_eq!(found.len(), 2);
        assert_eq!(names(&found[0]), "A:22-B:27");
        assert!(!found[0].is_between_symmetry_copies());
        assert_eq!(names(&found[1]), "A:30C-A:30");
        assert!(found[1].is_between_symmetry_copies());
    }

    #[test]
    fn a_file_made_by_hand_needs_no_mark_of_its_end() {
        let by_hand = ENTRY
            .replace("#\n", "")
            .replace("_audit_conform.dict_name mmcif_pdbx.dic\n", "");
        let parsed = |text: &str| read("own.cif", text).unwrap();
        assert_eq!(
            (parsed(&by_hand).ending, parsed(&by_hand).warnings.count),
            (Ending::Unknown, 0)
        );
        // If another category follows, no atom is missing.
        assert_eq!(
            parsed(&format!("{by_hand}_cell.length_a 10\n")).ending,
            Ending::Whole
        );
    }
}
