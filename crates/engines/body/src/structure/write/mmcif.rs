//! mmCIF text: `_atom_site` with what viewers need, entities, and the origin of the copies.
//!
//! `auth_asym_id` is the new chain. `label_asym_id` is the same for its polymer; each ligand, and the
//! waters of a chain together, have separate identifiers after those, as in the archive.

use super::chains::{Chain, Layout, is_standard, letters};
use super::{PlacedBodies, plain, rounded};
use crate::chemistry::residue_names::is_water;
use std::collections::HashMap;
use std::fmt::Write;

/// The text of an mmCIF file.
pub(super) fn text(bodies: &PlacedBodies, layout: &Layout) -> String {
    let mut text = String::from("data_protomer\n#\n_entry.id protomer\n#\n");
    let title = value(&plain(&bodies.title));
    let _ = writeln!(text, "_struct.entry_id protomer\n_struct.title {title}\n#");
    copies(&mut text, bodies);
    chains(&mut text, layout);
    if let Some(lengths) = bodies.box_angstrom {
        cell(&mut text, lengths);
    }
    let units = Units::from_layout(layout);
    units.tables(&mut text);
    atoms(&mut text, layout, &units);
    text
}

/// The bodies of the copies, and how the atoms of their sources were moved.
fn copies(text: &mut String, bodies: &PlacedBodies) {
    let mut items = vec![
        "id".to_owned(),
        "body".into(),
        "source".into(),
        "mutations".into(),
    ];
    for row in 1..=3 {
        items.extend((1..=3).map(|column| format!("matrix[{row}][{column}]")));
    }
    items.extend((1..=3).map(|row| format!("vector[{row}]")));
    begin_loop(text, "protomer_copy", items.iter().map(String::as_str));
    for (number, copy) in bodies.copies.iter().enumerate() {
        let provenance = &copy.body.provenance;
        let mutations = provenance.settings.get("mutations");
        let mut row = vec![
            number.to_string(),
            value(&plain(&copy.body.name)),
            value(&plain(&provenance.source)),
            value(&plain(mutations.map_or("", String::as_str))),
        ];
        let motion = copy.motion_of_source();
        let matrix = motion.rotation.to_rotation_matrix();
        for i in 0..3 {
            row.extend((0..3).map(|j| rounded(matrix[(i, j)], 10)));
        }
        row.extend(motion.position.iter().map(|x| rounded(*x, 5)));
        add_row(text, &row);
    }
    text.push_str("#\n");
}

/// Writes the copy to which each chain belongs, and the chain of its source.
fn chains(text: &mut String, layout: &Layout) {
    let items = ["auth_asym_id", "copy_id", "source_chain"];
    begin_loop(text, "protomer_chain", items);
    for chain in layout.table() {
        let source = value(&plain(&chain.source_chain));
        add_row(text, &[chain.chain, chain.copy.to_string(), source]);
    }
    text.push_str("#\n");
}

fn cell(text: &mut String, lengths_angstrom: [f64; 3]) {
    text.push_str("_cell.entry_id protomer\n");
    for (axis, length) in ["a", "b", "c"].into_iter().zip(lengths_angstrom) {
        let _ = writeln!(text, "_cell.length_{axis} {}", rounded(length, 3));
    }
    for angle in ["alpha", "beta", "gamma"] {
        let _ = writeln!(text, "_cell.angle_{angle} 90.00");
    }
    text.push_str("#\n_symmetry.entry_id protomer\n_symmetry.space_group_name_H-M 'P 1'\n#\n");
}

/// A molecule of the file: the polymer of a chain, a ligand, or the waters of a chain.
struct Unit {
    label: String,
    /// Index of its entity.
    entity: usize,
}

/// The molecules of the file, and what each is.
#[derive(Default)]
struct Units {
    /// Molecules in the order of the chains: the polymer of each, if there is one, then the others.
    units: Vec<Unit>,
    /// Type and description of each entity.
    entities: Vec<(&'static str, String)>,
    entity_of: HashMap<String, usize>,
}

impl Units {
    fn from_layout(layout: &Layout) -> Self {
        let mut units = Self::default();
        let mut labels_used = layout.chains.len();
        for chain in &layout.chains {
            let part = layout.part(chain);
            let residues = &chain.placed.body.residues;
            if !part.polymer.is_empty() {
                let names = part
                    .polymer
                    .iter()
                    .map(|(index, _)| &*residues[*index].name);
                let sequence = names.collect::<Vec<_>>().join(" ");
                let description = format!("chain {} of {}", part.name, chain.placed.body.name);
                units.add(chain.id.clone(), "polymer", sequence, plain(&description));
            }
            let mut has_water = false;
            for index in &part.others {
                let name = &residues[*index].name;
                let is_water = is_water(name);
                if is_water && has_water {
                    continue;
                }
                has_water |= is_water;
                let label = letters(labels_used);
                labels_used += 1;
                match is_water {
                    true => units.add(label, "water", "water".into(), "water".into()),
                    false => {
                        let key = format!("non-polymer {name}");
                        units.add(label, "non-polymer", key, plain(name));
                    }
                }
            }
        }
        units
    }

    /// Adds a molecule. Molecules with the same key are the same entity.
    fn add(&mut self, label: String, kind: &'static str, key: String, description: String) {
        let next = self.entities.len();
        let entity = *self.entity_of.entry(key).or_insert(next);
        if entity == next {
            self.entities.push((kind, description));
        }
        self.units.push(Unit { label, entity });
    }

    fn tables(&self, text: &mut String) {
        begin_loop(text, "entity", ["id", "type", "pdbx_description"]);
        for (number, (kind, description)) in self.entities.iter().enumerate() {
            add_row(
                text,
                &[(number + 1).to_string(), (*kind).into(), value(description)],
            );
        }
        text.push_str("#\n");
        begin_loop(text, "struct_asym", ["id", "entity_id"]);
        for unit in &self.units {
            add_row(text, &[unit.label.clone(), (unit.entity + 1).to_string()]);
        }
        text.push_str("#\n");
    }
}

/// Items of `_atom_site`, in the order of the archive.
const ATOM_SITE: [&str; 20] = [
    "group_PDB",
    "id",
    "type_symbol",
    "label_atom_id",
    "label_alt_id",
    "label_comp_id",
    "label_asym_id",
    "label_entity_id",
    "label_seq_id",
    "pdbx_PDB_ins_code",
    "Cartn_x",
    "Cartn_y",
    "Cartn_z",
    "occupancy",
    "B_iso_or_equiv",
    "auth_seq_id",
    "auth_comp_id",
    "auth_asym_id",
    "auth_atom_id",
    "pdbx_PDB_model_num",
];

fn atoms(text: &mut String, layout: &Layout, units: &Units) {
    begin_loop(text, "atom_site", ATOM_SITE);
    let mut units = units.units.iter();
    let mut serial = 0;
    for chain in &layout.chains {
        let part = layout.part(chain);
        if !part.polymer.is_empty()
            && let Some(unit) = units.next()
        {
            for (residue, number) in &part.polymer {
                let row = Row {
                    layout,
                    chain,
                    unit,
                    residue: *residue,
                    sequence_number: Some(*number),
                };
                row.atoms(text, &mut serial);
            }
        }
        let mut water = None;
        for residue in &part.others {
            let is_water = is_water(&chain.placed.body.residues[*residue].name);
            let shared_unit = water.filter(|_| is_water);
            let Some(unit) = shared_unit.or_else(|| units.next()) else {
                continue;
            };
            if is_water {
                water = Some(unit);
            }
            let row = Row {
                layout,
                chain,
                unit,
                residue: *residue,
                sequence_number: None,
            };
            row.atoms(text, &mut serial);
        }
    }
    text.push_str("#\n");
}

/// The atoms of one residue.
struct Row<'a, 'l> {
    layout: &'l Layout<'a>,
    chain: &'l Chain<'a>,
    unit: &'l Unit,
    residue: usize,
    /// Number in the sequence; `None` outside polymers.
    sequence_number: Option<i64>,
}

impl Row<'_, '_> {
    fn atoms(&self, text: &mut String, serial: &mut u64) {
        let placed = self.chain.placed;
        let residue = &placed.body.residues[self.residue];
        let group = if is_standard(&residue.name) {
            "ATOM"
        } else {
            "HETATM"
        };
        let component = value(&plain(&residue.name));
        let sequence = self
            .sequence_number
            .map_or(".".into(), |number| number.to_string());
        let code = match plain(&residue.insertion_code) {
            empty if empty.is_empty() => "?".into(),
            code => value(&code),
        };
        let factor = rounded(placed.value(self.residue), 2);
        let (label, entity) = (&self.unit.label, self.unit.entity + 1);
        let (number, chain) = (residue.number, &self.chain.id);
        for (site, symbol) in self.layout.atoms(self.chain, self.residue) {
            *serial += 1;
            let site = &placed.body.sites[site];
            let name = value(&plain(&site.atom_name));
            let position = placed.pose.transform_point(&site.position);
            let [x, y, z] = [position.x, position.y, position.z].map(|x| rounded(x, 3));
            let _ = writeln!(
                text,
                "{group} {serial} {symbol} {name} . {component} {label} {entity} {sequence} {code} \
                 {x} {y} {z} 1.00 {factor} {number} {component} {chain} {name} 1"
            );
        }
    }
}

fn begin_loop<'a>(text: &mut String, category: &str, items: impl IntoIterator<Item = &'a str>) {
    text.push_str("loop_\n");
    for item in items {
        let _ = writeln!(text, "_{category}.{item}");
    }
}

fn add_row(text: &mut String, values: &[String]) {
    text.push_str(&values.join(" "));
    text.push('\n');
}

/// A text as a value: bare if it can be, otherwise in quotes that it does not hold before a blank,
/// otherwise between semicolons. A dot where there is none.
fn value(text: &str) -> String {
    if text.is_empty() {
        return ".".into();
    }
    if is_bare(text) {
        return text.to_owned();
    }
    for quote in ['\'', '"'] {
        let closes_early = text.contains(&format!("{quote} "));
        if !closes_early && !text.contains(quote) {
            return format!("{quote}{text}{quote}");
        }
    }
    for quote in ['\'', '"'] {
        if !text.contains(&format!("{quote} ")) {
            return format!("{quote}{text}{quote}");
        }
    }
    format!("\n;{text}\n;")
}

fn is_bare(text: &str) -> bool {
    const RESERVED: [&str; 5] = ["data_", "loop_", "save_", "stop_", "global_"];
    let lower = text.to_ascii_lowercase();
    let is_reserved = RESERVED.iter().any(|word| lower.starts_with(word));
    let begins_badly = text.starts_with(['_', '#', '$', '\'', '"', '[', ']', ';']);
    let has_quote_or_blank = text.contains([' ', '\'', '"']);
    !(is_reserved || begins_badly || has_quote_or_blank || text == "." || text == "?")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_quoted_where_the_grammar_asks_for_it() {
        for (text, written) in [
            ("CA", "CA"),
            ("", "."),
            (".", "'.'"),
            ("?", "'?'"),
            ("O5'", "\"O5'\""),
            ("O5''", "\"O5''\""),
            ("H\"", "'H\"'"),
            ("two words", "'two words'"),
            ("_tag", "'_tag'"),
            ("#1", "'#1'"),
            ("data_x", "'data_x'"),
            ("LOOP_", "'LOOP_'"),
            ("a'b\"c", "'a'b\"c'"),
            ("a' b\" c", "\n;a' b\" c\n;"),
            ("5\" disc's", "'5\" disc's'"),
        ] {
            assert_eq!(value(text), written, "{text}");
        }
    }
}
