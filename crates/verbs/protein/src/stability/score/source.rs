//! The complexes of a folder or a table.
//!
//! In a folder each structure file is a complex. Two files whose names differ in one part, `receptor` in one and
//! `ligand` in the other (or `r` and `l`), are the two bodies of one complex. A table (CSV) has the columns `name`,
//! and `file` or `receptor` and `ligand`; `receptor_chains` and `ligand_chains` say which chains make up a body. Its
//! other columns are copied into the results.

use super::ScoreSettings;
use crate::bodies::chain_groups::ChainNames;
use crate::stability::binding::BindingSettings;
use anyhow::{Context, Result, bail};
use protomer_body::crystal::{CrystalContact, crystal_contacts};
use protomer_body::structure::{SelectionSettings, Structure};
use protomer_common::input::{InputFile, expand, stem};
use protomer_io::csv::cells;
use protomer_kernel::Pose;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// The columns of a table that say what a complex is.
const COLUMNS: [&str; 6] = [
    "name",
    "file",
    "receptor",
    "ligand",
    "receptor_chains",
    "ligand_chains",
];
/// Parts of the names of files that are the two bodies of one complex.
const ROLES: [[&str; 2]; 2] = [["receptor", "ligand"], ["r", "l"]];
/// Characters between the parts of a name.
const SEPARATORS: [char; 3] = ['_', '-', '.'];
/// Longest name of a complex, which is the name of a folder.
const LONGEST_NAME: usize = 120;

/// Complexes in the order of their source.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Complexes(pub Vec<StatedComplex>);

/// A complex as its source states it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StatedComplex {
    /// Name of the complex.
    pub name: String,
    /// File of the receptor, or of both bodies.
    pub receptor: PathBuf,
    /// File of the ligand; `None` if both bodies are in one file.
    pub ligand: Option<PathBuf>,
    /// Chains of the two bodies; empty for whole files, and for the two chains of one file.
    pub bodies: Vec<Vec<String>>,
    /// Motion of the second body from its place in the file.
    pub motion: Option<Pose>,
    /// Further columns of the table, and their cells.
    pub further: Vec<(String, String)>,
    /// Reason why this is no complex.
    pub problem: Option<String>,
}

impl Complexes {
    /// Reads a folder of structure files, a list of them (NAME.txt) or a table (NAME.csv). `bodies` are the chains
    /// of both bodies of each file that does not state its own.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::score::Complexes;
    /// # let folder = tempfile::tempdir()?;
    /// for file in ["1abc_receptor.pdb", "1abc_ligand.pdb", "design_7.cif"] {
    ///     std::fs::write(folder.path().join(file), "")?;
    /// }
    /// let complexes = Complexes::read(folder.path(), &[])?;
    /// let names: Vec<&str> = complexes.0.iter().map(|complex| complex.name.as_str()).collect();
    /// assert_eq!(names, ["1abc", "design_7"]);
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the source cannot be read or holds nothing, a column is missing or misspelt, or a name appears twice.
    pub fn read(source: &Path, bodies: &[ChainNames]) -> Result<Self> {
        require_source(source)?;
        let is_table = source
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
        let mut complexes = match is_table {
            true => of_table(source)?,
            false => of_files(expand(&[source.to_owned()])?),
        };
        for complex in complexes
            .iter_mut()
            .filter(|complex| complex.bodies.is_empty())
        {
            complex.bodies = bodies.iter().map(|names| names.0.clone()).collect();
        }
        require_names(source, &complexes)?;
        Ok(Self(complexes))
    }
}

impl Complexes {
    /// All contacts of the crystals in structure files: chains and their symmetry copies that touch. A file whose contacts
    /// cannot be found is a complex with the reason.
    ///
    /// # Errors
    /// If the source cannot be read, or two files have one name.
    pub fn of_crystals(source: &Path, selection: &SelectionSettings) -> Result<Self> {
        require_source(source)?;
        let files = expand(&[source.to_owned()])?;
        let found: Vec<Vec<StatedComplex>> = files
            .par_iter()
            .map(|file| {
                of_crystal(file, selection).unwrap_or_else(|error| {
                    vec![StatedComplex {
                        name: stem(file),
                        receptor: file.clone(),
                        problem: Some(format!("{error:#}")),
                        ..StatedComplex::default()
                    }]
                })
            })
            .collect();
        let mut complexes: Vec<StatedComplex> = found.into_iter().flatten().collect();
        // The first row names the columns.
        complexes.sort_by_key(|complex| complex.further.is_empty());
        require_names(source, &complexes)?;
        Ok(Self(complexes))
    }
}

/// The contacts in the crystal of a structure file.
fn of_crystal(file: &Path, selection: &SelectionSettings) -> Result<Vec<StatedComplex>> {
    let input = InputFile::read(file)?;
    let structure = Structure::read(&input.name, &input.bytes)?;
    let selected = structure.select(selection)?;
    let contacts = crystal_contacts(&structure.header, &structure.assemblies, &selected)?;
    if contacts.is_empty() {
        bail!("no protein chain touches another one or a symmetry copy");
    }
    let entry = stem(file);
    let complex = |(number, contact): (usize, CrystalContact)| {
        let [first, second] = &contact.chains;
        let answer = |is: Option<bool>| is.map_or("", |is| if is { "yes" } else { "no" });
        let further = [
            ("entry", entry.clone()),
            ("chains", format!("{first}:{second}")),
            ("symmetry", contact.symmetry.clone()),
            ("closed", answer(contact.is_closed).to_owned()),
            ("in_assembly", answer(contact.in_assembly).to_owned()),
        ];
        StatedComplex {
            name: format!("{entry}_{first}_{second}_{}", number + 1),
            receptor: file.to_owned(),
            bodies: contact
                .chains
                .iter()
                .map(|name| vec![name.clone()])
                .collect(),
            motion: Some(contact.pose),
            further: further.map(|(name, text)| (name.to_owned(), text)).to_vec(),
            ..StatedComplex::default()
        }
    };
    Ok(contacts.into_iter().enumerate().map(complex).collect())
}

impl StatedComplex {
    /// The files of the complex.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.receptor).chain(&self.ligand)
    }

    /// The chains of the two bodies.
    ///
    /// # Errors
    /// Never for chains that were read.
    pub(super) fn chain_names(&self) -> Result<Vec<ChainNames>> {
        self.bodies
            .iter()
            .map(|names| names.join(",").parse())
            .collect()
    }

    /// The settings of `binding` for this complex.
    ///
    /// # Errors
    /// If this is no complex.
    pub(super) fn binding(&self, settings: &ScoreSettings) -> Result<BindingSettings> {
        if let Some(problem) = &self.problem {
            bail!("{problem}");
        }
        Ok(BindingSettings {
            receptor: self.receptor.clone(),
            ligand: self.ligand.clone(),
            ligand_motion: self.motion,
            ..settings.binding()
        })
    }
}

fn require_source(source: &Path) -> Result<()> {
    if !source.exists() {
        bail!(
            "there is no {}; give a folder of structure files, a list of them (NAME.txt), or a table (NAME.csv)",
            source.display()
        );
    }
    Ok(())
}

/// Complexes of structure files, by name: pairs of a receptor and a ligand, and single files.
fn of_files(files: Vec<PathBuf>) -> Vec<StatedComplex> {
    let mut complexes: BTreeMap<String, StatedComplex> = BTreeMap::new();
    for file in files {
        let stem = stem(&file);
        match role(&stem) {
            None => {
                let complex = StatedComplex {
                    name: stem.clone(),
                    receptor: file,
                    ..StatedComplex::default()
                };
                complexes.insert(stem, complex);
            }
            Some((name, is_ligand)) => {
                let pair = complexes.entry(name.clone()).or_default();
                pair.name = name;
                match is_ligand {
                    true => pair.ligand = Some(file),
                    false => pair.receptor = file,
                }
            }
        }
    }
    let mut complexes: Vec<StatedComplex> = complexes.into_values().collect();
    for complex in &mut complexes {
        complex.require_both();
    }
    complexes
}

impl StatedComplex {
    /// Notes a ligand without its receptor, or a receptor without its ligand.
    fn require_both(&mut self) {
        let lonely = match (&self.ligand, self.receptor.as_os_str().is_empty()) {
            (Some(ligand), true) => (ligand.clone(), "receptor"),
            (None, false) if role(&stem(&self.receptor)).is_some() => {
                (self.receptor.clone(), "ligand")
            }
            _ => return,
        };
        let (file, missing) = lonely;
        self.problem = Some(format!(
            "{} has no {missing} of the same name next to it; add the file, or give a table with the columns \
             receptor and ligand",
            file.display()
        ));
        (self.receptor, self.ligand) = (file, None);
    }
}

/// The name of the complex of a file, and whether the file is its ligand; `None` for a name without such a part.
fn role(stem: &str) -> Option<(String, bool)> {
    let parts: Vec<&str> = stem.split(SEPARATORS).collect();
    for roles in ROLES {
        for (is_ligand, word) in [(false, roles[0]), (true, roles[1])] {
            let place = parts
                .iter()
                .position(|part| part.eq_ignore_ascii_case(word));
            if let Some(place) = place.filter(|_| parts.len() > 1) {
                let mut others = parts.clone();
                others.remove(place);
                return Some((others.join("_"), is_ligand));
            }
        }
    }
    None
}

/// Complexes of the rows of a table.
fn of_table(path: &Path) -> Result<Vec<StatedComplex>> {
    let shown = path.display();
    let text =
        protomer_io::input::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
    let text = text.trim_start_matches('\u{feff}');
    let file = shown.to_string();
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let Some((_, heading)) = lines.next() else {
        bail!(
            "{shown} is empty; write a heading with the columns {}",
            COLUMNS.join(", ")
        );
    };
    let heading: Vec<String> = cells(&file, 1, heading)?
        .iter()
        .map(|cell| cell.trim().to_owned())
        .collect();
    check_heading(&file, &heading)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut complexes = Vec::new();
    for (number, line) in lines {
        let row = cells(&file, number + 1, line)?;
        if row.len() != heading.len() {
            bail!(
                "{shown}, line {}: {} cells for {} columns; give a cell for each column",
                number + 1,
                row.len(),
                heading.len()
            );
        }
        let complex = of_row(&heading, &row, folder);
        complexes.push(complex.with_context(|| format!("{shown}, line {}", number + 1))?);
    }
    if complexes.is_empty() {
        bail!("{shown} has a heading and no rows; write a complex a line");
    }
    Ok(complexes)
}

fn check_heading(file: &str, heading: &[String]) -> Result<()> {
    let mut met = HashSet::new();
    for name in heading {
        if !met.insert(name) {
            bail!("{file} has the column {name} twice; rename one");
        }
        let nearest = COLUMNS
            .iter()
            .find(|column| strsim::levenshtein(column, &name.to_lowercase()) <= 2);
        if let Some(nearest) = nearest.filter(|nearest| *nearest != name) {
            bail!("{file} has the column '{name}'; did you mean '{nearest}'?");
        }
    }
    let has = |name: &str| heading.iter().any(|column| column == name);
    if heading.iter().any(|name| name.contains(';')) {
        bail!("{file} separates its columns by semicolons; separate them by commas");
    }
    if !has("file") && !has("receptor") {
        bail!(
            "{file} names no structures; add the column file, or the columns receptor and ligand"
        );
    }
    Ok(())
}

fn of_row(heading: &[String], row: &[String], folder: &Path) -> Result<StatedComplex> {
    let mut complex = StatedComplex::default();
    let (mut file, mut chains) = (None, [None, None]);
    for (column, cell) in heading.iter().zip(row) {
        let cell = cell.trim();
        let stated = (!cell.is_empty()).then_some(cell);
        let path = || stated.map(|cell| folder.join(cell));
        match column.as_str() {
            "name" => complex.name = cell.to_owned(),
            "file" => file = path(),
            "receptor" => complex.receptor = path().unwrap_or_default(),
            "ligand" => complex.ligand = path(),
            "receptor_chains" => chains[0] = stated,
            "ligand_chains" => chains[1] = stated,
            _ => complex.further.push((column.clone(), cell.to_owned())),
        }
    }
    match (file, complex.receptor.as_os_str().is_empty()) {
        (Some(file), true) => complex.receptor = file,
        (Some(_), false) => bail!("both a file and a receptor are stated; leave one cell empty"),
        (None, true) => bail!("no structure is stated; fill the column file or receptor"),
        (None, false) => {}
    }
    complex.bodies = match chains {
        [None, None] => Vec::new(),
        [Some(receptor), Some(ligand)] => vec![chain_list(receptor)?, chain_list(ligand)?],
        _ => bail!(
            "the chains of one body are stated and those of the other are not; fill both cells"
        ),
    };
    if complex.name.is_empty() {
        complex.name = stem(&complex.receptor);
    }
    Ok(complex)
}

/// Names of chains, separated by commas, blanks, semicolons or plus signs.
fn chain_list(text: &str) -> Result<Vec<String>> {
    let names = text
        .split([',', ' ', ';', '+'])
        .filter(|name| !name.is_empty());
    let names: ChainNames = names.collect::<Vec<_>>().join(",").parse()?;
    Ok(names.0)
}

/// Refuses names that cannot be those of folders, and names that appear twice.
fn require_names(source: &Path, complexes: &[StatedComplex]) -> Result<()> {
    let mut met = HashSet::new();
    for complex in complexes {
        let name = &complex.name;
        let is_plain = |c: char| c.is_alphanumeric() || "._-+ ()=,@#".contains(c);
        if !name.chars().all(is_plain) || name.starts_with('.') || name.len() > LONGEST_NAME {
            bail!(
                "{}: '{name}' cannot be the name of a complex; use letters, digits, '_', '-' and '.', \
                 {LONGEST_NAME} characters at most",
                source.display()
            );
        }
        // Some file systems do not tell capitals apart.
        if !met.insert(name.to_lowercase()) {
            bail!(
                "{}: two complexes have the name {name}; give a table with a different name for each",
                source.display()
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Complexes> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("designs.csv");
        std::fs::write(&path, text).unwrap();
        Complexes::read(&path, &[])
    }

    #[test]
    fn files_pair_by_the_part_that_differs() {
        let files = [
            "1a2k_ligand_bound.pdb.gz",
            "1a2k_ligand_unbound.pdb.gz",
            "1a2k_receptor_bound.pdb.gz",
            "1a2k_receptor_unbound.pdb.gz",
            "2b3c_r_b.pdb",
            "2b3c_l_b.pdb",
            "3d4e_receptor.pdb",
            "rank_1.cif",
        ];
        let complexes = of_files(files.map(PathBuf::from).to_vec());
        let names: Vec<&str> = complexes
            .iter()
            .map(|complex| complex.name.as_str())
            .collect();
        assert_eq!(
            names,
            ["1a2k_bound", "1a2k_unbound", "2b3c_b", "3d4e", "rank_1"]
        );
        assert_eq!(
            complexes[0].receptor,
            Path::new("1a2k_receptor_bound.pdb.gz")
        );
        assert_eq!(complexes[0].ligand, Some("1a2k_ligand_bound.pdb.gz".into()));
        let lonely: Vec<bool> = complexes
            .iter()
            .map(|complex| complex.problem.is_some())
            .collect();
        assert_eq!(lonely, [false, false, false, true, false]);
    }

    #[test]
    fn a_table_states_files_chains_and_further_columns() {
        let text = "name,file,receptor_chains,ligand_chains,measured\nx,sub/a.cif,\"H,L\",A,-9.5\ny,b.cif,,,\n";
        let complexes = table(text).unwrap().0;
        assert_eq!(complexes[0].bodies, [vec!["H", "L"], vec!["A"]]);
        assert!(complexes[0].receptor.ends_with("sub/a.cif"));
        assert_eq!(
            complexes[0].further,
            [("measured".to_owned(), "-9.5".to_owned())]
        );
        assert!(complexes[1].bodies.is_empty());
    }

    #[test]
    fn wrong_tables_are_refused_with_the_line() {
        let cases = [
            ("", "is empty"),
            ("name,file\n", "no rows"),
            ("name,sequence\na,MK\n", "names no structures"),
            (
                "name;file\na;b.pdb\n",
                "separates its columns by semicolons",
            ),
            (
                "name,file,ligand_chain\na,b.pdb,A\n",
                "did you mean 'ligand_chains'",
            ),
            ("name,file\na\n", "line 2: 1 cells for 2 columns"),
            (
                "name,file\na,b.pdb\na,c.pdb\n",
                "two complexes have the name a",
            ),
            ("name,file\n../a,b.pdb\n", "cannot be the name"),
            ("name,receptor,ligand\na,,b.pdb\n", "no structure is stated"),
            (
                "file,receptor_chains,ligand_chains\nb.pdb,A,\n",
                "fill both cells",
            ),
        ];
        for (text, told) in cases {
            let error = format!("{:#}", table(text).unwrap_err());
            assert!(error.contains(told), "{error}");
        }
    }
}
