//! Scripts that open a structure file in a viewer, show a surface of each copy, and colour it.

use anyhow::{Result, bail};
use protomer_body::structure::write::{PlacedBodies, WrittenChain};
use protomer_io::written::script_words;
use protomer_kernel::name::printable;
use std::path::{Path, PathBuf};

protomer_kernel::choices! {
    /// Program that shows molecules.
    pub enum Viewer {
        /// UCSF ChimeraX: a .cxc file.
        Chimerax = "chimerax",
        /// PyMOL: a .pml file.
        Pymol = "pymol",
    }
}

/// A copy of a body in the file.
struct Copy<'a> {
    number: usize,
    body: String,
    chains: Vec<&'a str>,
    /// Number of the kind of body, by name, in the order of first copies.
    kind: usize,
}

/// Share of the light that surfaces let through, so that the chains inside are seen.
const TRANSPARENCY: f64 = 0.6;

impl Viewer {
    /// The script's path: that of the structure file with another extension.
    ///
    /// ```
    /// use protomer_protein_verbs::export::Viewer;
    /// use std::path::Path;
    /// let script = Viewer::Chimerax.path_beside(Path::new("out/ring.cif"));
    /// assert_eq!(script, Path::new("out/ring.cxc"));
    /// ```
    pub fn path_beside(self, structure: &Path) -> PathBuf {
        structure.with_extension(match self {
            Self::Chimerax => "cxc",
            Self::Pymol => "pml",
        })
    }

    /// The script for a structure file in the same folder. Each kind of body has a colour, and surfaces are
    /// transparent; with a limit, surfaces have the colours of their residues' B factors, from red (-limit)
    /// over white to blue.
    ///
    /// # Errors
    /// If the name of the structure file would be something else in a script.
    pub fn script(
        self,
        structure: &Path,
        placed: &PlacedBodies,
        chains: &[WrittenChain],
        limit: Option<f64>,
    ) -> Result<String> {
        let file = name_in_script(structure)?;
        let mut copies = Vec::with_capacity(placed.copies.len());
        let mut kinds: Vec<&str> = Vec::new();
        for (number, copy) in placed.copies.iter().enumerate() {
            let name = copy.body.name.as_str();
            let kind = kinds.iter().position(|earlier| *earlier == name);
            let kind = kind.unwrap_or_else(|| {
                kinds.push(name);
                kinds.len() - 1
            });
            copies.push(Copy {
                number,
                body: script_words(&copy.body.name),
                chains: Vec::new(),
                kind,
            });
        }
        for chain in chains {
            if let Some(copy) = copies.get_mut(chain.copy) {
                copy.chains.push(&chain.chain);
            }
        }
        copies.retain(|copy| !copy.chains.is_empty());
        Ok(match self {
            Self::Chimerax => chimerax(&file, &copies, limit),
            Self::Pymol => pymol(&file, &copies, limit),
        })
    }
}

/// The name of a file as a script names it: viewers read commas, quotes, semicolons and brackets in it
/// as parts of the command.
fn name_in_script(structure: &Path) -> Result<String> {
    let file = structure.file_name().unwrap_or_default().to_string_lossy();
    let is_harmless = |character: char| character.is_alphanumeric() || "._-+ ".contains(character);
    if !file.chars().all(is_harmless) {
        bail!(
            "a script cannot name the file '{}'; choose a name of letters, digits, blanks and . _ - +",
            printable(&file)
        );
    }
    Ok(file.into_owned())
}

fn chimerax(file: &str, copies: &[Copy], limit: Option<f64>) -> String {
    let mut lines = vec![
        "# Open it in ChimeraX with no other model open: the structure becomes model 1.".to_owned(),
        format!("open \"{file}\""),
        "hide #1 atoms".into(),
        "cartoon #1".into(),
    ];
    for copy in copies {
        let chains = format!("#1/{}", copy.chains.join(","));
        lines.push(format!("# copy {} of {}", copy.number, copy.body));
        lines.push(format!("surface {chains} enclose {chains}"));
        lines.push(format!("color {chains} {}", hexadecimal(colour(copy.kind))));
    }
    lines.push(match limit {
        Some(limit) => format!(
            "color byattribute bfactor #1 target s palette #c0282d:#f7f7f7:#2457b8 range -{limit},{limit}"
        ),
        None => format!("transparency #1 {:.0} target s", 100.0 * TRANSPARENCY),
    });
    lines.extend(["graphics silhouettes true", "lighting soft", "view"].map(str::to_owned));
    lines.join("\n") + "\n"
}

fn pymol(file: &str, copies: &[Copy], limit: Option<f64>) -> String {
    let mut lines = vec![
        "# Start PyMOL in the folder of this file.".to_owned(),
        format!("load {file}, protomer_all"),
        "hide everything".into(),
    ];
    let mut defined = Vec::new();
    for copy in copies {
        let name = format!("copy_{}", copy.number);
        lines.push(format!("# copy {} of {}", copy.number, copy.body));
        if !defined.contains(&copy.kind) {
            let [red, green, blue] = colour(copy.kind);
            lines.push(format!(
                "set_color colour_{}, [{red}, {green}, {blue}]",
                copy.kind
            ));
            defined.push(copy.kind);
        }
        lines.extend([
            format!(
                "create {name}, protomer_all and chain {}",
                copy.chains.join("+")
            ),
            format!("color colour_{}, {name}", copy.kind),
        ]);
    }
    lines.extend(["delete protomer_all", "show cartoon", "show surface"].map(str::to_owned));
    lines.push(match limit {
        Some(limit) => format!("spectrum b, red_white_blue, minimum=-{limit}, maximum={limit}"),
        None => format!("set transparency, {TRANSPARENCY}"),
    });
    lines.extend(["bg_color white", "orient"].map(str::to_owned));
    lines.join("\n") + "\n"
}

fn hexadecimal([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A colour for each kind of body: hues by the golden angle, so that neighbours in number differ and none
/// repeats.
fn colour(number: usize) -> [u8; 3] {
    const GOLDEN_TURN: f64 = 0.381_966_011_250_105;
    const SATURATION: f64 = 0.55;
    const VALUE: f64 = 0.85;
    let hue = 6.0 * (0.58 + GOLDEN_TURN * number as f64).fract();
    let channel = |offset: f64| {
        let place = (offset + hue) % 6.0;
        let share = place.min(4.0 - place).clamp(0.0, 1.0);
        (255.0 * VALUE * (1.0 - SATURATION * share)).round() as u8
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn colours_of_kinds_differ() {
        let colours: HashSet<[u8; 3]> = (0..200).map(colour).collect();
        assert_eq!(colours.len(), 200);
        for [red, green, blue] in colours {
            let brightest = red.max(green).max(blue);
            assert_eq!(brightest, 217);
            assert!(brightest - red.min(green).min(blue) > 100);
        }
    }

    #[test]
    fn scripts_stand_beside_their_structure() {
        let structure = Path::new("poses/ring.v2.cif");
        assert_eq!(
            Viewer::Pymol.path_beside(structure),
            Path::new("poses/ring.v2.pml")
        );
        assert_eq!(
            Viewer::Chimerax.path_beside(structure),
            Path::new("poses/ring.v2.cxc")
        );
    }

    #[test]
    fn copies_of_a_kind_have_one_colour_and_transparent_surfaces() {
        let copy = |number: usize, chains: Vec<&'static str>, kind: usize| Copy {
            number,
            body: "dimer".into(),
            chains,
            kind,
        };
        let copies = [
            copy(0, vec!["A", "B"], 0),
            copy(1, vec!["C"], 1),
            copy(2, vec!["D", "E"], 0),
        ];
        let chimerax = super::chimerax("x.cif", &copies, None);
        assert!(chimerax.contains("open \"x.cif\"\n"));
        for (chains, kind) in [("A,B", 0), ("C", 1), ("D,E", 0)] {
            let line = format!("color #1/{chains} {}\n", hexadecimal(colour(kind)));
            assert!(chimerax.contains(&line), "{chimerax}");
        }
        assert!(chimerax.contains("transparency #1 60 target s\n"));
        assert!(!chimerax.contains("bfactor"));
        let pymol = super::pymol("x.cif", &copies, Some(4.5));
        assert!(pymol.contains("create copy_0, protomer_all and chain A+B\n"));
        assert_eq!(pymol.matches("set_color colour_0, ").count(), 1);
        assert!(
            pymol.contains("color colour_0, copy_2\n")
                && pymol.contains("color colour_1, copy_1\n")
        );
        assert!(pymol.contains("spectrum b, red_white_blue, minimum=-4.5, maximum=4.5\n"));
        assert!(
            !pymol.contains("transparency"),
            "values are seen on opaque surfaces"
        );
        assert!(super::pymol("x.cif", &copies, None).contains("set transparency, 0.6\n"));
    }
}
