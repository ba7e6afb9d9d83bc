//! Reading, selecting and charging the structures that come with the repository.

use crate::common::{bundled, bytes, read, select};
use protomer_body::assembly::body_types;
use protomer_body::chemistry::{ChargeModel, SiteSettings, build_sites, mutate, parse_mutations};
use protomer_body::structure::{MissingAtoms, SelectionSettings, Structure};
use protomer_body::{BodySettings, BuiltBody, Source, SurfaceSettings, build_body};
use sha2::{Digest, Sha256};

#[test]
fn the_bundled_files_are_those_of_the_provenance() {
    let provenance = std::fs::read_to_string(bundled().join("PROVENANCE.md")).unwrap();
    for name in [
        "5pti.cif.gz",
        "4e43.pdb.gz",
        "1bd2_short.pdb.gz",
        "1bd2_short.cif.gz",
    ] {
        let file = std::fs::read(bundled().join(name)).unwrap();
        for content in [file, bytes(&bundled(), name)] {
            let hash: String = Sha256::digest(&content)
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect();
            assert!(provenance.contains(&hash), "{name} {hash}");
        }
    }
}

#[test]
fn bpti_is_read_whole_and_selected_without_hydrogens() {
    let structure = read(&bundled(), "5pti.cif.gz");
    let header = &structure.header;
    assert_eq!(
        (&*header.entry, header.resolution_angstrom),
        ("5PTI", Some(1.0))
    );
    assert_eq!(
        (
            header.space_group.as_deref(),
            header.cell.unwrap().lengths_angstrom[0]
        ),
        (Some("P 21 21 21"), 74.1)
    );
    let model = &structure.models[0];
    assert_eq!(model.atoms.len(), 1104);
    let count = |element: &str| {
        model
            .atoms
            .iter()
            .filter(|atom| &*atom.element == element)
            .count()
    };
    assert_eq!((count("H"), count("D")), (344, 229));
    let selection = select(&structure);
    assert_eq!(
        (selection.residues.len(), selection.report.atoms),
        (58, 454)
    );
    assert_eq!(
        selection
            .residues
            .iter()
            .filter(|residue| residue.in_disulfide)
            .count(),
        6
    );
    assert!(selection.report.incomplete.is_empty() && selection.report.chain_breaks.is_empty());
    let skipped: usize = selection.report.skipped.values().sum();
    assert_eq!(skipped + selection.report.atoms, selection.report.records);
}

#[test]
fn every_record_is_selected_or_counted() {
    for name in ["5pti.cif.gz", "4e43.pdb.gz", "1bd2_short.cif.gz"] {
        let structure = read(&bundled(), name);
        for bits in 0..16 {
            let settings = SelectionSettings {
                keep_ligands: bits & 1 != 0,
                keep_waters: bits & 2 != 0,
                keep_hydrogens: bits & 4 != 0,
                missing: if bits & 8 != 0 {
                    MissingAtoms::Skip
                } else {
                    MissingAtoms::Keep
                },
                ..SelectionSettings::default()
            };
            let report = structure.select(&settings).unwrap().report;
            assert_eq!(
                report.skipped.values().sum::<usize>() + report.atoms,
                report.records,
                "{name} {bits}"
            );
        }
    }
}

/// Charges of this model at pH 7.4.
fn usual(charges: ChargeModel) -> SiteSettings {
    SiteSettings {
        ph: 7.4,
        charges,
        ..SiteSettings::default()
    }
}

#[test]
fn the_net_charge_of_bpti_is_its_protonation_sum_in_every_model() {
    let selection = select(&read(&bundled(), "5pti.cif.gz"));
    // 6 ARG + 4 LYS - 2 ASP - 2 GLU; the amine is four fifths protonated at pH 7.4.
    for charges in [ChargeModel::ForceField, ChargeModel::Formal] {
        let sites = build_sites(&selection, &usual(charges)).unwrap();
        assert!(
            (sites.net_charge_e() - 5.79).abs() < 0.01,
            "{charges:?} {}",
            sites.net_charge_e()
        );
        let residues: f64 = sites.residues.iter().map(|residue| residue.charge_e).sum();
        assert!((sites.net_charge_e() - residues).abs() < 1e-9);
    }
    let none = build_sites(
        &selection,
        &SiteSettings {
            ph: 7.4,
            charges: ChargeModel::None,
            ..SiteSettings::default()
        },
    )
    .unwrap();
    assert!(none.sites.iter().all(|site| site.charge_e == 0.0) && none.net_charge_e() == 0.0);
}

#[test]
fn the_charge_falls_with_ph_from_all_bases_to_all_acids() {
    let selection = select(&read(&bundled(), "5pti.cif.gz"));
    let net = |ph| {
        build_sites(
            &selection,
            &SiteSettings {
                ph,
                ..SiteSettings::default()
            },
        )
        .unwrap()
        .net_charge_e()
    };
    // 6 ARG, 4 LYS and the amine; 2 ASP, 2 GLU, 4 TYR and the carboxylate, none of which are at
    // their last proton at the ends of the scale.
    assert!((net(0.0) - 11.0).abs() < 2e-3 && (net(14.0) + 9.0).abs() < 0.2);
    let curve: Vec<f64> = (0..=140)
        .map(|tenth| net(f64::from(tenth) / 10.0))
        .collect();
    assert!(curve.windows(2).all(|pair| pair[1] < pair[0]));
}

#[test]
fn a_ph_outside_the_scale_is_refused() {
    let selection = select(&read(&bundled(), "5pti.cif.gz"));
    for (ph, is_accepted) in [
        (0.0, true),
        (14.0, true),
        (-0.1, false),
        (14.1, false),
        (f64::NAN, false),
        (f64::INFINITY, false),
    ] {
        let settings = SiteSettings {
            ph,
            ..SiteSettings::default()
        };
        let sites = build_sites(&selection, &settings);
        assert_eq!(sites.is_ok(), is_accepted, "{ph}");
        if let Err(error) = sites {
            assert!(error.to_string().contains("between 0 and 14"), "{error}");
        }
    }
}

#[test]
fn sites_stand_about_their_centroid() {
    let selection = select(&read(&bundled(), "5pti.cif.gz"));
    let sites = build_sites(&selection, &SiteSettings::default()).unwrap();
    let sum: protomer_kernel::Vec3 = sites.sites.iter().map(|site| site.position).sum();
    assert!(sum.norm() < 1e-9 * sites.sites.len() as f64);
    let first = &selection.residues[0].atoms[0];
    assert!((sites.sites[0].position + sites.origin_angstrom - first.position).norm() < 1e-12);
    assert!(sites.sites.iter().all(|site| site.radius_angstrom > 1.0));
}

#[test]
fn formal_charges_sit_on_the_charged_groups() {
    let selection = select(&read(&bundled(), "5pti.cif.gz"));
    let settings = SiteSettings {
        charges: ChargeModel::Formal,
        ..SiteSettings::default()
    };
    let sites = build_sites(&selection, &settings).unwrap();
    for site in &sites.sites {
        let residue = &sites.residues[site.residue.unwrap() as usize];
        let expected: f64 = match (&*residue.name, &*site.atom_name) {
            ("LYS", "NZ") => 1.0,
            ("ARG", "NH1" | "NH2") => 0.5,
            ("ASP", "OD1" | "OD2") | ("GLU", "OE1" | "OE2") => -0.5,
            (_, "N") if residue.number == 1 => 0.8,
            (_, "O" | "OXT") if residue.number == 58 => -0.5,
            _ => 0.0,
        };
        assert!(
            (site.charge_e - expected).abs() < 0.005,
            "{} {} {}",
            residue.name,
            site.atom_name,
            site.charge_e
        );
    }
}

#[test]
fn both_formats_of_one_entry_agree() {
    let (pdb, cif) = (
        read(&bundled(), "1bd2_short.pdb.gz"),
        read(&bundled(), "1bd2_short.cif.gz"),
    );
    assert_eq!(pdb.models[0].atoms.len(), cif.models[0].atoms.len());
    for (a, b) in pdb.models[0].atoms.iter().zip(&cif.models[0].atoms) {
        assert_eq!(
            (&a.name, &a.residue_name, &a.chain, &a.element),
            (&b.name, &b.residue_name, &b.chain, &b.element)
        );
        assert_eq!(
            (a.residue_number, &a.insertion_code),
            (b.residue_number, &b.insertion_code)
        );
        assert!((a.position - b.position).norm() < 1e-9);
    }
    assert_eq!(cif.header.cell, None, "a cell of 1 Å is no crystal");
}

#[test]
fn missing_atoms_are_listed_skipped_or_refused() {
    let structure = read(&bundled(), "1bd2_short.pdb.gz");
    let select = |missing| {
        structure.select(&SelectionSettings {
            missing,
            ..SelectionSettings::default()
        })
    };
    let kept = select(MissingAtoms::Keep).unwrap();
    let lysine = kept
        .report
        .incomplete
        .iter()
        .find(|entry| entry.residue.to_string() == "D:54A")
        .unwrap();
    assert_eq!(
        (&*lysine.name, &*lysine.missing_atoms),
        ("LYS", &["CG", "CD", "CE", "NZ"][..])
    );
    let skipped = select(MissingAtoms::Skip).unwrap();
    assert_eq!(
        skipped.residues.len() + kept.report.incomplete.len(),
        kept.residues.len()
    );
    let refused = select(MissingAtoms::Fail).unwrap_err().to_string();
    assert!(refused.contains("LYS D:54A lacks CG CD CE NZ"), "{refused}");
    // An incomplete residue still carries its whole charge.
    let sites = build_sites(&kept, &SiteSettings::default()).unwrap();
    let index = kept
        .residues
        .iter()
        .position(|residue| residue.key == lysine.residue)
        .unwrap();
    let sum: f64 = sites
        .sites
        .iter()
        .filter(|site| site.residue == Some(index as u32))
        .map(|site| site.charge_e)
        .sum();
    assert!((sum - 0.999).abs() < 1e-3 && (sum - sites.residues[index].charge_e).abs() < 1e-12);
}

#[test]
fn the_protease_is_two_copies_of_one_chain_about_a_twofold_axis() {
    let structure = read(&bundled(), "4e43.pdb.gz");
    let selection = select(&structure);
    let types = body_types(&selection).unwrap();
    let protease = &types[0];
    assert_eq!(protease.copies.len(), 2);
    assert_eq!(
        protease.reference,
        protease.selection.residues[0].key.chain.to_string()
    );
    let [a, b] = [&protease.copies[0], &protease.copies[1]];
    assert!(
        a.rmsd_angstrom < 1e-9 && b.rmsd_angstrom > 0.05 && b.rmsd_angstrom < 1.0,
        "{}",
        b.rmsd_angstrom
    );
    let turn = a.pose.rotation.angle_to(&b.pose.rotation).to_degrees();
    assert!((turn - 180.0).abs() < 3.0, "{turn}");
    // The pose puts the reference's atoms onto the copy's.
    let sites = build_sites(&protease.selection, &SiteSettings::default()).unwrap();
    let ca = protease.selection.residues[20].atom("CA").unwrap();
    let partner = selection.residues.iter().find(|residue| {
        *residue.key.chain == *b.chain
            && residue.key.number == protease.selection.residues[20].key.number
    });
    let image = b
        .pose
        .transform_point(&(ca.position - sites.origin_angstrom));
    assert!((image - partner.unwrap().atom("CA").unwrap().position).norm() < 1.5);
}

#[test]
fn a_mutation_changes_charge_and_hydropathy_and_nothing_else() {
    let structure = read(&bundled(), "5pti.cif.gz");
    let wild = build_sites(&select(&structure), &SiteSettings::default()).unwrap();
    let cases = [
        ("A:K15E", -1.999),
        ("A:R1G", -1.0),
        ("A:G12K", 1.0),
        ("A:K15E,A:K26E", -3.997),
        ("A:D3N", 1.0),
        ("A:C5S", -0.0245),
    ];
    for charges in [ChargeModel::ForceField, ChargeModel::Formal] {
        let wild_net = build_sites(&select(&structure), &usual(charges))
            .unwrap()
            .net_charge_e();
        for (list, change) in cases {
            let mut selection = select(&structure);
            mutate(&mut selection, &parse_mutations(list).unwrap()).unwrap();
            let mutant = build_sites(&selection, &usual(charges)).unwrap();
            assert!(
                (mutant.net_charge_e() - wild_net - change).abs() < 2e-3,
                "{list} {}",
                mutant.net_charge_e()
            );
            let sum: f64 = mutant.residues.iter().map(|residue| residue.charge_e).sum();
            assert!((sum - mutant.net_charge_e()).abs() < 1e-9);
            assert!(
                mutant
                    .sites
                    .iter()
                    .zip(&wild.sites)
                    .all(|(a, b)| a.position == b.position)
            );
        }
    }
    let mut selection = select(&structure);
    mutate(&mut selection, &parse_mutations("A:K15E").unwrap()).unwrap();
    let mutant = build_sites(&selection, &SiteSettings::default()).unwrap();
    let index = mutant
        .residues
        .iter()
        .position(|residue| residue.number == 15)
        .unwrap();
    assert_eq!(
        (
            &*mutant.residues[index].name,
            mutant.residues[index].hydropathy
        ),
        ("GLU", Some(-3.5))
    );
    // The charge is at the end of the old side chain.
    let most_negative = mutant
        .sites
        .iter()
        .filter(|site| site.residue == Some(index as u32))
        .min_by(|a, b| a.charge_e.total_cmp(&b.charge_e));
    assert_eq!(most_negative.unwrap().atom_name, "NZ");
}

#[test]
fn a_mutation_that_does_not_fit_names_what_is_there() {
    let mut selection = select(&read(&bundled(), "5pti.cif.gz"));
    for (list, clue) in [
        ("A:D15E", "residue A:15 is LYS, not ASP"),
        ("A:K99E", "from 1 to 58"),
        ("B:K15E", "chain B"),
    ] {
        let message = mutate(&mut selection, &parse_mutations(list).unwrap())
            .unwrap_err()
            .to_string();
        assert!(message.contains(clue), "{message}");
    }
}

#[test]
fn what_the_file_does_not_have_is_named() {
    let structure = read(&bundled(), "4e43.pdb.gz");
    let refused =
        |settings: SelectionSettings| structure.select(&settings).unwrap_err().to_string();
    let chain = refused(SelectionSettings {
        chains: vec!["Q".into()],
        ..SelectionSettings::default()
    });
    assert!(
        chain.contains("no chain Q") && chain.contains("`A`, `B`"),
        "{chain}"
    );
    let model = refused(SelectionSettings {
        model: Some(7),
        ..SelectionSettings::default()
    });
    assert!(model.contains("no model 7"), "{model}");
    let assembly = refused(SelectionSettings {
        assembly: Some("9".into()),
        ..SelectionSettings::default()
    });
    assert!(assembly.contains("no biological assembly 9"), "{assembly}");
}

#[test]
fn a_file_cut_anywhere_is_read_or_refused_with_its_line() {
    for name in ["1bd2_short.pdb.gz", "1bd2_short.cif.gz"] {
        let whole = bytes(&bundled(), name);
        for length in 0..whole.len() {
            if let Err(error) = Structure::read("cut", &whole[..length]) {
                assert!(error.to_string().starts_with("cut:"), "{error}");
            }
        }
    }
}

fn body_on_lattice(spacing_angstrom: f64) -> Result<BuiltBody, String> {
    let settings = BodySettings {
        surface: SurfaceSettings {
            lattice_spacing_angstrom: spacing_angstrom,
            ..SurfaceSettings::default()
        },
        ..BodySettings::default()
    };
    let source = Source {
        file: "5pti.cif",
        sha256: "",
    };
    let text = bytes(&bundled(), "5pti.cif.gz");
    build_body("5pti", source, &text, &settings).map_err(|error| error.to_string())
}

#[test]
fn a_coarser_lattice_finds_the_same_surface_and_is_recorded() {
    let default = SurfaceSettings::LATTICE_SPACING_ANGSTROM;
    let (fine, coarse) = (
        body_on_lattice(default).unwrap(),
        body_on_lattice(0.5).unwrap(),
    );
    let recorded = |built: &BuiltBody| {
        let settings = &built.body.provenance.settings;
        settings.get("lattice_spacing_angstrom").cloned()
    };
    assert_eq!(
        (recorded(&fine), recorded(&coarse).as_deref()),
        (None, Some("0.5"))
    );
    // Both are calibrated to the exact measures, so that these say little; the meshes must also be as
    // near to the exact surface.
    let (a, b) = (&fine.body.mesh, &coarse.body.mesh);
    assert!((a.area_angstrom2() / b.area_angstrom2() - 1.0).abs() < 1e-3);
    assert!((a.volume_angstrom3() / b.volume_angstrom3() - 1.0).abs() < 1e-3);
    let (near, far) = (fine.deviation, coarse.deviation);
    assert!(
        far.rms_angstrom < 1.15 * near.rms_angstrom,
        "{near:?} {far:?}"
    );
    assert_ne!(a.vertices, b.vertices);
}

#[test]
fn a_lattice_that_finds_no_clefts_is_refused() {
    for spacing_angstrom in [0.0, -0.3, 1.5, f64::NAN] {
        let error = body_on_lattice(spacing_angstrom).unwrap_err();
        assert!(
            error.contains("a lattice with a spacing of") && error.contains("0.05 to 1 Å"),
            "{error}"
        );
    }
}
