//! Charges of common cofactors, nucleotides, buffers and glycans at neutral pH, by their residue names.
//!
//! The charge of each group is shared by its atoms; all other atoms stay neutral. Atom names are those of
//! the wwPDB chemical component dictionary. Groups that titrate near neutral pH, such as the last phosphate
//! of a nucleotide (pKa 6 to 7), count as charged in full.

use crate::structure::SelectedResidue;

/// A charged group of a cofactor: its atoms and its charge, e.
pub(crate) type CofactorGroup = (&'static [&'static str], f64);

/// A molecule of known charge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cofactor {
    /// Residue names of the molecules with these groups.
    names: &'static [&'static str],
    /// Description for reports.
    pub description: &'static str,
    /// Charged groups.
    pub groups: &'static [CofactorGroup],
}

const ALPHA: CofactorGroup = (&["O1A", "O2A"], -1.0);
const BETA: CofactorGroup = (&["O1B", "O2B"], -1.0);
const LAST_BETA: CofactorGroup = (&["O1B", "O2B", "O3B"], -2.0);
const GAMMA: CofactorGroup = (&["O1G", "O2G", "O3G"], -2.0);
const SINGLE: CofactorGroup = (&["O1P", "O2P", "O3P"], -2.0);
const NICOTINAMIDE_PHOSPHATE: CofactorGroup = (&["O1N", "O2N"], -1.0);
const NICOTINAMIDE: CofactorGroup = (&["N1N"], 1.0);
const RIBOSE_PHOSPHATE: CofactorGroup = (&["O1X", "O2X", "O3X"], -2.0);
const AMMONIUM: CofactorGroup = (&["N"], 1.0);
const CARBOXYLATE: CofactorGroup = (&["O", "OXT"], -1.0);

const COFACTORS: &[Cofactor] = &[
    Cofactor {
        names: &["HEM", "HEC"],
        description: "haem with iron(II)",
        groups: &[(&["O1A", "O2A"], -1.0), (&["O1D", "O2D"], -1.0)],
    },
    Cofactor {
        names: &[
            "ATP", "GTP", "CTP", "UTP", "TTP", "DTP", "ANP", "ACP", "GNP", "GCP",
        ],
        description: "nucleoside triphosphate",
        groups: &[ALPHA, BETA, GAMMA],
    },
    Cofactor {
        names: &["ADP", "GDP", "CDP", "UDP", "TYD"],
        description: "nucleoside diphosphate",
        groups: &[ALPHA, LAST_BETA],
    },
    Cofactor {
        names: &["AMP", "5GP", "C5P", "U5P", "TMP"],
        description: "nucleoside monophosphate",
        groups: &[SINGLE],
    },
    Cofactor {
        names: &["NAD"],
        description: "oxidised NAD",
        groups: &[ALPHA, NICOTINAMIDE_PHOSPHATE, NICOTINAMIDE],
    },
    Cofactor {
        names: &["NAI"],
        description: "reduced NAD",
        groups: &[ALPHA, NICOTINAMIDE_PHOSPHATE],
    },
    Cofactor {
        names: &["NAP"],
        description: "oxidised NADP",
        groups: &[
            ALPHA,
            NICOTINAMIDE_PHOSPHATE,
            NICOTINAMIDE,
            RIBOSE_PHOSPHATE,
        ],
    },
    Cofactor {
        names: &["NDP"],
        description: "reduced NADP",
        groups: &[ALPHA, NICOTINAMIDE_PHOSPHATE, RIBOSE_PHOSPHATE],
    },
    Cofactor {
        names: &["FAD"],
        description: "FAD",
        groups: &[ALPHA, (&["O1P", "O2P"], -1.0)],
    },
    Cofactor {
        names: &["FMN"],
        description: "FMN",
        groups: &[SINGLE],
    },
    Cofactor {
        names: &["COA", "ACO"],
        description: "coenzyme A",
        groups: &[
            ALPHA,
            (&["O4A", "O5A"], -1.0),
            (&["O7A", "O8A", "O9A"], -2.0),
        ],
    },
    Cofactor {
        names: &["PLP"],
        description: "pyridoxal phosphate, its ring neutral",
        groups: &[SINGLE],
    },
    Cofactor {
        names: &["TPP"],
        description: "thiamine diphosphate",
        groups: &[ALPHA, LAST_BETA, (&["N3"], 1.0)],
    },
    Cofactor {
        names: &["SAM"],
        description: "S-adenosylmethionine",
        groups: &[AMMONIUM, CARBOXYLATE, (&["SD"], 1.0)],
    },
    Cofactor {
        names: &["SAH"],
        description: "S-adenosylhomocysteine",
        groups: &[AMMONIUM, CARBOXYLATE],
    },
    Cofactor {
        names: &["ACT"],
        description: "acetate",
        groups: &[CARBOXYLATE],
    },
    Cofactor {
        names: &["FMT"],
        description: "formate",
        groups: &[(&["O1", "O2"], -1.0)],
    },
    Cofactor {
        names: &["CIT"],
        description: "citrate",
        groups: &[
            (&["O1", "O2"], -1.0),
            (&["O3", "O4"], -1.0),
            (&["O5", "O6"], -1.0),
        ],
    },
    Cofactor {
        names: &["FLC"],
        description: "citrate",
        groups: &[
            (&["OA1", "OA2"], -1.0),
            (&["OB1", "OB2"], -1.0),
            (&["OG1", "OG2"], -1.0),
        ],
    },
    Cofactor {
        names: &["SIA", "SLB"],
        description: "sialic acid",
        groups: &[(&["O1A", "O1B"], -1.0)],
    },
    Cofactor {
        names: &[
            "NAG", "NDG", "NGA", "A2G", "BMA", "MAN", "GAL", "GLA", "GLC", "BGC", "FUC", "FUL",
            "XYP",
        ],
        description: "sugar without charge",
        groups: &[],
    },
];

/// The cofactor of a residue; `None` for other molecules, and where the file states formal charges itself.
pub(crate) fn cofactor_of(residue: &SelectedResidue) -> Option<&'static Cofactor> {
    let states_charges = residue
        .atoms
        .iter()
        .any(|atom| atom.formal_charge_e.is_some());
    if states_charges {
        return None;
    }
    COFACTORS
        .iter()
        .find(|cofactor| cofactor.names.contains(&&*residue.name))
}

impl Cofactor {
    /// Net charge, e.
    pub fn charge_e(&self) -> f64 {
        self.groups.iter().map(|(_, charge_e)| charge_e).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chemistry::ions::ion_charge_e;
    use crate::chemistry::residue_names::{is_polymer, is_water};
    use crate::chemistry::{SiteSettings, build_sites};
    use crate::structure::{SelectionSettings, Structure};

    #[test]
    fn every_name_means_one_molecule() {
        let mut names: Vec<&str> = COFACTORS
            .iter()
            .flat_map(|cofactor| cofactor.names)
            .copied()
            .collect();
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all);
        for name in names {
            assert!(
                !is_polymer(name) && !is_water(name) && ion_charge_e(name, 20).is_none(),
                "{name}"
            );
        }
    }

    /// Charges of the atoms of a haem, from a file that states this formal charge of its iron or none.
    fn haem(iron: &str) -> Vec<(String, f64)> {
        let atom = |number: usize, name: &str, element: &str, formal: &str| {
            format!(
                "HETATM{number:>5} {name:<4} HEM A 142    {:>8.3}{:>8.3}{:>8.3}  1.00 10.00          {element:>2}{formal}\n",
                3.0 * number as f64,
                1.0,
                2.0
            )
        };
        let text = [
            atom(1, "FE", "FE", iron),
            atom(2, " NA", "N", "  "),
            atom(3, " O1A", "O", "  "),
            atom(4, " O2A", "O", "  "),
            atom(5, " O1D", "O", "  "),
            atom(6, " O2D", "O", "  "),
        ]
        .concat();
        let structure = Structure::read("haem.pdb", text.as_bytes()).unwrap();
        let settings = SelectionSettings {
            keep_ligands: true,
            ..SelectionSettings::default()
        };
        let selection = structure.select(&settings).unwrap();
        let sites = build_sites(&selection, &SiteSettings::default()).unwrap();
        let charged = sites.sites.iter();
        charged
            .map(|site| (site.atom_name.clone(), site.charge_e))
            .collect()
    }

    #[test]
    fn groups_carry_the_charge_unless_the_file_states_another() {
        for (name, charge_e) in haem("  ") {
            let expected = if name.starts_with('O') { -0.5 } else { 0.0 };
            assert!((charge_e - expected).abs() < 1e-12, "{name} {charge_e}");
        }
        let stated: f64 = haem("2+").iter().map(|(_, charge_e)| charge_e).sum();
        assert!((stated - 2.0).abs() < 1e-12);
    }

    #[test]
    fn charges_are_those_of_the_textbook() {
        let charge = |name: &str| {
            let cofactor = COFACTORS.iter().find(|each| each.names.contains(&name));
            cofactor.unwrap().charge_e()
        };
        for (name, expected) in [
            ("HEM", -2.0),
            ("ATP", -4.0),
            ("GDP", -3.0),
            ("AMP", -2.0),
            ("NAD", -1.0),
            ("NDP", -4.0),
            ("FAD", -2.0),
            ("COA", -4.0),
            ("SAM", 1.0),
            ("CIT", -3.0),
            ("NAG", 0.0),
        ] {
            assert_eq!(charge(name), expected, "{name}");
        }
    }

    /// Each molecule with the phosphorus atoms and the carboxylates of its formula in the chemical component dictionary, its
    /// positive groups, and its charge near pH 7 (textbooks; ChEBI's species at pH 7.3 for coenzyme A 57287, thiamine diphosphate
    /// 58937, pyridoxal phosphate 597326, citrate 16947, N-acetylneuraminate 35418).
    const FORMULAS: &[(&[&str], usize, usize, usize, f64)] = &[
        (&["HEM", "HEC"], 0, 2, 0, -2.0),
        (
            &[
                "ATP", "GTP", "CTP", "UTP", "TTP", "DTP", "ANP", "ACP", "GNP", "GCP",
            ],
            3,
            0,
            0,
            -4.0,
        ),
        (&["ADP", "GDP", "CDP", "UDP", "TYD"], 2, 0, 0, -3.0),
        (
            &["AMP", "5GP", "C5P", "U5P", "TMP", "FMN", "PLP"],
            1,
            0,
            0,
            -2.0,
        ),
        (&["NAD"], 2, 0, 1, -1.0),
        (&["NAI", "FAD"], 2, 0, 0, -2.0),
        (&["NAP"], 3, 0, 1, -3.0),
        (&["NDP", "COA", "ACO"], 3, 0, 0, -4.0),
        (&["TPP"], 2, 0, 1, -2.0),
        (&["SAM"], 0, 1, 2, 1.0),
        (&["SAH"], 0, 1, 1, 0.0),
        (&["ACT", "FMT", "SIA", "SLB"], 0, 1, 0, -1.0),
        (&["CIT", "FLC"], 0, 3, 0, -3.0),
        (
            &[
                "NAG", "NDG", "NGA", "A2G", "BMA", "MAN", "GAL", "GLA", "GLC", "BGC", "FUC", "FUL",
                "XYP",
            ],
            0,
            0,
            0,
            0.0,
        ),
    ];

    /// Every molecule of the table is among the formulas. Its negative groups are oxygens: two with -1 e for a carboxylate or a
    /// phosphate with two bridges, three with -2 e for one with a single bridge. No atom is in two groups.
    #[test]
    fn groups_agree_with_the_formula_and_the_charge_of_each_molecule() {
        for cofactor in COFACTORS {
            for name in cofactor.names {
                let formula = FORMULAS.iter().find(|formula| formula.0.contains(name));
                let (_, phosphorus, carboxylates, positive, charge_e) = formula.unwrap();
                assert_eq!(cofactor.charge_e(), *charge_e, "{name}");
                let (mut negative_groups, mut positive_groups) = (0, 0);
                let mut atoms: Vec<&str> = Vec::new();
                for (members, charge_e) in cofactor.groups {
                    atoms.extend(*members);
                    let all = |elements: &[char]| {
                        members
                            .iter()
                            .all(|atom| elements.iter().any(|element| atom.starts_with(*element)))
                    };
                    match (members.len(), *charge_e) {
                        (2, -1.0) | (3, -2.0) => {
                            assert!(all(&['O']), "{name} {members:?}");
                            negative_groups += 1;
                        }
                        (1, 1.0) => {
                            assert!(all(&['N', 'S']), "{name} {members:?}");
                            positive_groups += 1;
                        }
                        _ => panic!("{name}: {members:?} with {charge_e} e"),
                    }
                }
                assert_eq!(negative_groups, phosphorus + carboxylates, "{name}");
                assert_eq!(positive_groups, *positive, "{name}");
                let count = atoms.len();
                atoms.sort_unstable();
                atoms.dedup();
                assert_eq!(atoms.len(), count, "{name}");
            }
        }
    }
}
