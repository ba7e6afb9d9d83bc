//! PDB text (wwPDB format 3.3). What does not fit its columns is an error, never cut.

use super::chains::{Chain, Layout, is_standard};
use super::{PlacedBodies, PlacedBody, WrittenChain, plain, rounded};
use crate::{BodyError, Result};

/// The largest serial number that fits five columns.
const LARGEST_SERIAL: u32 = 99_999;

/// The text of a PDB file.
pub(super) fn text(bodies: &PlacedBodies, layout: &Layout) -> Result<String> {
    let mut writer = Writer {
        text: String::new(),
        serial: 0,
    };
    writer.title(&plain(&bodies.title));
    writer.table(bodies, layout);
    if let Some(lengths) = bodies.box_angstrom {
        writer.cell(lengths)?;
    }
    for chain in &layout.chains {
        writer.chain(layout, chain)?;
    }
    writer.line("END");
    Ok(writer.text)
}

struct Writer {
    text: String,
    /// Serial number of the last record.
    serial: u32,
}

impl Writer {
    /// A line of 80 columns, as the format has them.
    fn line(&mut self, line: &str) {
        self.text += &format!("{line:<80}\n");
    }

    fn title(&mut self, title: &str) {
        const COLUMNS: usize = 70;
        for (number, part) in wrapped(title, COLUMNS).iter().enumerate() {
            match number {
                0 => self.line(&format!("TITLE     {part}")),
                _ => self.line(&format!("TITLE   {:>2} {part}", number + 1)),
            }
        }
    }

    /// A line of free text.
    fn remark(&mut self, text: &str) {
        self.line(&format!("REMARK   6 {text}"));
    }

    /// Free text, in as many lines as it needs.
    fn remarks(&mut self, text: &str) {
        const COLUMNS: usize = 69;
        for part in wrapped(text, COLUMNS) {
            self.remark(&part);
        }
    }

    /// Writes the copy to which each chain belongs, and the motion of the atoms of each copy's
    /// source.
    fn table(&mut self, bodies: &PlacedBodies, layout: &Layout) {
        self.remark("");
        self.remark("CHAINS OF THIS FILE; COPIES OF BODIES ARE COUNTED FROM 0");
        for chain in layout.table() {
            let WrittenChain {
                chain,
                copy,
                body,
                source_chain,
            } = chain;
            let source_chain = match plain(&source_chain) {
                empty if empty.is_empty() => "-".into(),
                name => name,
            };
            let row = format!("CHAIN {chain} COPY {copy} SOURCE CHAIN {source_chain} BODY {body}");
            self.remarks(&plain(&row));
        }
        for (number, copy) in bodies.copies.iter().enumerate() {
            self.copy(number, copy);
        }
    }

    fn copy(&mut self, number: usize, copy: &PlacedBody) {
        let provenance = &copy.body.provenance;
        self.remark("");
        self.remarks(&plain(&format!(
            "COPY {number}: ATOMS OF {} WERE MOVED BY THIS MATRIX AND SHIFT",
            provenance.source
        )));
        let motion = copy.motion_of_source();
        let matrix = motion.rotation.to_rotation_matrix();
        for row in 0..3 {
            let numbers: String = (0..3)
                .map(|column| format!("{:>10}", rounded(matrix[(row, column)], 6)))
                .collect();
            let shift = rounded(motion.position[row], 5);
            self.remark(&format!("  MATRIX{} {numbers}{shift:>15}", row + 1));
        }
        if let Some(mutations) = provenance.settings.get("mutations") {
            self.remarks(&plain(&format!(
                "COPY {number}: NEW NAMES ON THE ATOMS OF THE SOURCE: {}",
                mutations.replace(',', ", ")
            )));
        }
    }

    fn cell(&mut self, lengths_angstrom: [f64; 3]) -> Result<()> {
        let mut line = "CRYST1".to_owned();
        for length in lengths_angstrom {
            line += &fitting(length, 3, 9, || "the box".into())?;
        }
        self.line(&format!("{line}  90.00  90.00  90.00 P 1           1"));
        Ok(())
    }

    fn chain(&mut self, layout: &Layout, chain: &Chain) -> Result<()> {
        let part = layout.part(chain);
        for (residue, _) in &part.polymer {
            self.residue(layout, chain, *residue)?;
        }
        if let Some((last, _)) = part.polymer.last() {
            let serial = self.next_serial()?;
            let place = place(chain, *last)?;
            self.line(&format!("TER   {serial:>5}      {place}"));
        }
        for residue in &part.others {
            self.residue(layout, chain, *residue)?;
        }
        Ok(())
    }

    fn residue(&mut self, layout: &Layout, chain: &Chain, index: usize) -> Result<()> {
        let body = chain.placed.body;
        let residue = &body.residues[index];
        let record = if is_standard(&residue.name) {
            "ATOM"
        } else {
            "HETATM"
        };
        let place = place(chain, index)?;
        let where_it_is = || {
            format!(
                "residue {}:{}{} of copy {} of body '{}'",
                residue.chain, residue.number, residue.insertion_code, chain.copy, body.name
            )
        };
        let value = fitting(chain.placed.value(index), 2, 6, where_it_is)?;
        for (site, symbol) in layout.atoms(chain, index) {
            let site = &body.sites[site];
            let name = atom_name(&site.atom_name, symbol)?;
            let position = chain.placed.pose.transform_point(&site.position);
            let mut coordinates = String::new();
            for x in [position.x, position.y, position.z] {
                coordinates += &fitting(x, 3, 8, where_it_is)?;
            }
            let serial = self.next_serial()?;
            self.line(&format!(
                "{record:<6}{serial:>5} {name} {place}   {coordinates}  1.00{value}          {symbol:>2}"
            ));
        }
        Ok(())
    }

    fn next_serial(&mut self) -> Result<u32> {
        if self.serial >= LARGEST_SERIAL {
            return Err(too_large(format!(
                "more than {LARGEST_SERIAL} atoms and ends of chains"
            )));
        }
        self.serial += 1;
        Ok(self.serial)
    }
}

/// Columns 18 to 27: residue name, chain, number, insertion code.
fn place(chain: &Chain, index: usize) -> Result<String> {
    let residue = &chain.placed.body.residues[index];
    let (name, number) = (plain(&residue.name), residue.number.to_string());
    let code = plain(&residue.insertion_code);
    if name.len() > 3 || number.len() > 4 || code.len() > 1 {
        return Err(too_large(format!(
            "residue {name} {}:{number}{code} of body '{}', which needs more columns",
            residue.chain, chain.placed.body.name
        )));
    }
    Ok(format!("{name:>3} {}{number:>4}{code:<1}", chain.id))
}

/// Columns 13 to 16: a symbol of one letter is in the second.
fn atom_name(name: &str, symbol: &str) -> Result<String> {
    let name = plain(name);
    if name.len() > 4 {
        return Err(too_large(format!("the atom name '{name}'")));
    }
    let upper = name.to_ascii_uppercase();
    let begins_in_first = name.len() == 4 || (symbol.len() == 2 && upper.starts_with(symbol));
    Ok(match begins_in_first {
        true => format!("{name:<4}"),
        false => format!(" {name:<3}"),
    })
}

/// A number in a field of fixed width.
fn fitting(
    value: f64,
    decimals: usize,
    width: usize,
    label: impl Fn() -> String,
) -> Result<String> {
    let text = rounded(value, decimals);
    if text.len() > width {
        return Err(too_large(format!("the number {text} of {}", label())));
    }
    Ok(format!("{text:>width$}"))
}

fn too_large(content: String) -> BodyError {
    BodyError::Invalid {
        cause: format!("a PDB file cannot hold {content}"),
        remedy: "write mmCIF instead".into(),
    }
}

/// Words in lines of at most `width` columns; a longer word is divided. At least one line.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let mut remainder = word;
        while !remainder.is_empty() {
            let Some(line) = lines.last_mut() else { break };
            let needed = remainder.len() + usize::from(!line.is_empty());
            if line.len() + needed <= width {
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(remainder);
                remainder = "";
            } else if line.is_empty() {
                let (start, end) = remainder.split_at(width);
                line.push_str(start);
                lines.push(String::new());
                remainder = end;
            } else {
                lines.push(String::new());
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn atom_names_stand_where_their_elements_end() {
        for (name, symbol, columns) in [
            ("CA", "C", " CA "),
            ("CA", "CA", "CA  "),
            ("HG11", "H", "HG11"),
            ("O5'", "O", " O5'"),
            ("FE", "FE", "FE  "),
            ("N", "N", " N  "),
        ] {
            assert_eq!(atom_name(name, symbol).unwrap(), columns);
        }
        assert!(atom_name("H5'11", "H").is_err());
    }

    #[test]
    fn lines_are_wrapped_between_words_where_they_can_be() {
        assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
        assert_eq!(wrapped("a abcdefghij", 4), ["a", "abcd", "efgh", "ij"]);
        assert_eq!(wrapped("", 4), [""]);
        assert_eq!(fitting(-0.0004, 3, 8, String::new).unwrap(), "   0.000");
        assert!(fitting(-1000.0, 3, 8, String::new).is_err());
    }
}
