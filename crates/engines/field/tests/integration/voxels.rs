//! Voxels of bodies with closed forms, and properties that hold for any body.

use protomer_body::chemistry::{SiteSettings, build_sites};
use protomer_body::structure::{SelectionSettings, Structure};
use protomer_body::surface::{Arrangement, ImplicitSolid, SesSolid};
use protomer_field::surface::solvent_excluded;
use protomer_field::voxels::channels::pose;
use protomer_field::voxels::hydropathy::HydropathyMap;
use protomer_field::voxels::shell::occupied;
use protomer_field::voxels::{
    Channel, Lattice, PotentialModel, VoxelAtom, VoxelSettings, voxelise,
};
use protomer_field::{ChargedSphere, DielectricModel};
use protomer_io::gzip::read_maybe_gzip_from;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Electrolyte, Rotation, Vec3};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

fn dielectric() -> DielectricModel {
    DielectricModel::new(Electrolyte::in_water(298.15, 0.15).unwrap())
}

fn atom(centre: Vec3, radius_angstrom: f64, charge_e: f64) -> VoxelAtom {
    VoxelAtom {
        sphere: ChargedSphere {
            centre,
            radius_angstrom,
            charge_e,
        },
        residue: None,
    }
}

/// Settings with a potential solved at this spacing, Å.
fn solved_at(spacing_angstrom: f64) -> VoxelSettings {
    let mut settings = VoxelSettings::new(dielectric());
    settings.solve.spacing_angstrom = spacing_angstrom;
    settings
}

/// A clump of charged atoms that touch.
fn clump(seed: u64, count: usize) -> Vec<VoxelAtom> {
    let mut rng = CounterRng::new(seed, 0, 0);
    let mut atoms = vec![atom(Vec3::zeros(), 1.7, 0.3)];
    while atoms.len() < count {
        let from = atoms[rng.index(atoms.len())].sphere.centre;
        let centre = from + 1.5 * rng.unit_vector();
        atoms.push(atom(
            centre,
            rng.uniform_in(1.4, 1.9),
            rng.uniform_in(-0.5, 0.5),
        ));
    }
    atoms
}

fn solid_of(atoms: &[VoxelAtom]) -> SesSolid {
    let centres: Vec<Vec3> = atoms.iter().map(|atom| atom.sphere.centre).collect();
    let radii: Vec<f64> = atoms
        .iter()
        .map(|atom| atom.sphere.radius_angstrom)
        .collect();
    SesSolid::new(&Arrangement::new(&centres, &radii, 1.4).unwrap())
}

#[test]
fn a_ball_is_where_its_radius_says() {
    let lattice = Lattice::new(32, 0.75).unwrap();
    let settings = VoxelSettings {
        channels: vec![Channel::Shape, Channel::Solid],
        ..VoxelSettings::new(dielectric())
    };
    let radius = 8.0;
    let voxels = voxelise(
        &[atom(Vec3::zeros(), radius, 0.0)],
        &[],
        &lattice,
        &settings,
    )
    .unwrap();
    let found: BTreeMap<u32, [f32; 2]> = voxels
        .index
        .iter()
        .enumerate()
        .map(|(at, index)| (*index, [voxels.values[0][at], voxels.values[1][at]]))
        .collect();
    let mut inside = 0.0;
    for index in 0..32_u32.pow(3) {
        let distance = lattice.centre(index).norm() - radius;
        assert!(
            (distance.abs() - 0.375).abs() > 1e-6 && distance.abs() > 1e-6,
            "a tie says nothing"
        );
        let expected = [
            f32::from(distance.abs() <= 0.375),
            f32::from(distance < 0.0),
        ];
        assert_eq!(
            found.get(&index).copied().unwrap_or_default(),
            expected,
            "voxel {index}"
        );
        inside += f64::from(expected[1]);
    }
    let volume = inside * 0.75_f64.powi(3);
    assert!(
        (volume / (4.0 / 3.0 * PI * radius.powi(3)) - 1.0).abs() < 0.01,
        "{volume}"
    );
}

#[test]
fn a_charged_ball_has_the_potential_of_debye_and_hueckel_on_its_surface() {
    let (radius, charge) = (8.0, 5.0);
    let dielectric = dielectric();
    let lattice = Lattice::new(32, 1.0).unwrap();
    let on_surface = |potential, spacing_angstrom| {
        let settings = VoxelSettings {
            channels: vec![Channel::Shape, Channel::Potential],
            potential,
            ..solved_at(spacing_angstrom)
        };
        let charged = [atom(Vec3::zeros(), radius, charge)];
        voxelise(&charged, &[], &lattice, &settings)
            .unwrap()
            .values
            .swap_remove(1)
    };
    // Between the ball and the ions at b: φ = λ_B q (1/r - 1/b + 1/(b (1 + κb))).
    let (kappa, b) = (
        dielectric.electrolyte.inverse_debye_length_per_angstrom(),
        radius + dielectric.ion_radius_angstrom,
    );
    let strength = dielectric.electrolyte.bjerrum_length_angstrom() * charge;
    let solved = strength * (1.0 / radius - 1.0 / b + 1.0 / (b * (1.0 + kappa * b)));
    // The fitted plane ignores the curvature φ'' = 2 λ_B q / r³, an error of some 2 % at 1 Å; the
    // solve adds its own. Both fall with the square of the spacing.
    let mut coarser = f64::INFINITY;
    for (spacing, most) in [(1.0, 0.05), (0.5, 0.025)] {
        let values = on_surface(PotentialModel::PoissonBoltzmann, spacing);
        let errors: Vec<f64> = values
            .iter()
            .map(|value| f64::from(*value) / solved - 1.0)
            .collect();
        let rms =
            (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
        let worst = errors
            .iter()
            .fold(0.0_f64, |worst, error| worst.max(error.abs()));
        eprintln!(
            "ball, solved at {spacing} Å: relative error of the potential {rms:.4} rms, \
             {worst:.4} at worst"
        );
        assert!(
            errors.len() > 500 && worst < most && rms < 0.6 * coarser,
            "{rms} {worst}, coarser {coarser}"
        );
        coarser = rms;
    }
    let screened = strength * (kappa * (b - radius)).exp() / (radius * (1.0 + kappa * b));
    for value in on_surface(PotentialModel::DebyeHueckel, 1.0) {
        assert!(
            (f64::from(value) / screened - 1.0).abs() < 1e-5,
            "{value} instead of {screened}"
        );
    }
}

/// Voxel sets are solved at 1 Å, which is accurate enough for a network. This measures the error on
/// the surface of a protein, against 0.4 Å.
#[test]
fn the_potential_on_a_protein_solved_at_one_angstrom_is_that_of_a_finer_grid() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../data/structures/5pti.cif.gz"
    );
    let bytes =
        read_maybe_gzip_from("5pti", std::fs::read(path).unwrap().as_slice(), 1 << 24).unwrap();
    let selection = Structure::read("5pti.cif", &bytes)
        .unwrap()
        .select(&SelectionSettings::default())
        .unwrap();
    let sites = build_sites(&selection, &SiteSettings::default()).unwrap();
    let mut atoms: Vec<VoxelAtom> = sites
        .sites
        .iter()
        .map(|site| atom(site.position, site.radius_angstrom, site.charge_e))
        .collect();
    pose(&mut atoms, &CounterRng::new(1, 1, 0).rotation());
    let lattice = Lattice::new(64, 1.0).unwrap();
    let on_surface = |spacing_angstrom| {
        let settings = VoxelSettings {
            channels: vec![Channel::Potential],
            ..solved_at(spacing_angstrom)
        };
        voxelise(&atoms, &[], &lattice, &settings)
            .unwrap()
            .values
            .swap_remove(0)
    };
    let fine = on_surface(0.4);
    let mut coarser = 0.2;
    for spacing in [1.0, 0.7] {
        let values = on_surface(spacing);
        let pairs = || {
            values
                .iter()
                .zip(&fine)
                .map(|(a, b)| (f64::from(*a), f64::from(*b)))
        };
        let mut differences: Vec<f64> = pairs().map(|(a, b)| (a - b).abs()).collect();
        differences.sort_by(f64::total_cmp);
        let quantile = |share: f64| differences[(share * (differences.len() - 1) as f64) as usize];
        let square = |measure: fn((f64, f64)) -> f64| pairs().map(measure).sum::<f64>();
        let rms = (square(|(a, b)| (a - b).powi(2)) / square(|(_, b)| b * b)).sqrt();
        eprintln!(
            "{} voxels, solved at {spacing} Å: relative difference {rms:.4} rms; median {:.3} \
             kT/e, 95 % below {:.3}",
            differences.len(),
            quantile(0.5),
            quantile(0.95)
        );
        assert!(rms < coarser, "{rms} at {spacing} Å, {coarser} before");
        coarser = 0.75 * rms;
    }
}

#[test]
fn shells_have_no_holes_and_are_as_thick_as_a_voxel() {
    for seed in 0..8 {
        let mut atoms = clump(seed, 60);
        pose(&mut atoms, &CounterRng::new(seed, 1, 0).rotation());
        let solid = solid_of(&atoms);
        let lattice = Lattice::new(40, [0.5, 0.8, 1.0, 1.5, 2.0][seed as usize % 5]).unwrap();
        let (size, half) = (lattice.size(), 0.5 * lattice.spacing_angstrom());
        let found = occupied(&lattice, &solid);
        // The twin: every voxel of the lattice, one by one.
        let all = 0..size.pow(3) as u32;
        let distance = |index: &u32| solid.signed_distance(&lattice.centre(*index));
        assert_eq!(
            found.shell,
            all.clone()
                .filter(|index| distance(index).abs() < half)
                .collect::<Vec<u32>>()
        );
        assert_eq!(
            found.inside,
            all.filter(|index| distance(index) < 0.0)
                .collect::<Vec<u32>>()
        );
        let has = |list: &[u32], index: u32| list.binary_search(&index).is_ok();
        for (axis, step) in [(0, 1), (1, size as u32), (2, (size * size) as u32)] {
            for index in 0..size.pow(3) as u32 - step {
                let coordinate = index as usize / size.pow(axis) % size;
                let next = index + step;
                if coordinate + 1 < size && has(&found.inside, index) != has(&found.inside, next) {
                    assert!(
                        has(&found.shell, index) || has(&found.shell, next),
                        "a hole at {index}"
                    );
                }
            }
        }
    }
}

/// Distances are cut off at 1 Å: half of the largest voxel.
#[test]
fn shells_of_the_largest_voxels_are_shells() {
    for (seed, probe) in [(1, 1.4), (2, 0.5)] {
        let mut atoms = clump(seed, 200);
        pose(&mut atoms, &CounterRng::new(seed, 1, 0).rotation());
        let spheres: Vec<_> = atoms.iter().map(|atom| atom.sphere).collect();
        let solid = solvent_excluded(&spheres, probe).unwrap();
        let shell = |spacing| {
            occupied(&Lattice::new(40, spacing).unwrap(), &solid)
                .shell
                .len() as f64
        };
        assert!(
            (shell(2.0) / shell(1.98) - 1.0).abs() < 0.1,
            "{} {}",
            shell(2.0),
            shell(1.98)
        );
    }
}

#[test]
fn hydropathy_is_the_mean_over_residues_within_reach() {
    let mut rng = CounterRng::new(9, 0, 0);
    let values: Vec<Option<f64>> = (0..40)
        .map(|n| (n % 7 != 0).then(|| rng.uniform_in(-4.5, 4.5)))
        .collect();
    let atoms: Vec<(Vec3, Option<u32>)> = (0..400)
        .map(|n| (rng.vector_in_ball(15.0), (n % 11 != 0).then_some(n % 40)))
        .collect();
    let reach = 3.0;
    let map = HydropathyMap::new(atoms.iter().copied(), &values, reach);
    let mut lonely = 0;
    for _ in 0..500 {
        let place = rng.vector_in_ball(18.0);
        let valued = || {
            atoms.iter().filter_map(|(at, residue)| {
                Some(((at - place).norm(), values[(*residue)? as usize]?, *residue))
            })
        };
        let mut near: BTreeMap<Option<u32>, f64> = valued()
            .filter(|(distance, ..)| *distance <= reach)
            .map(|(_, value, residue)| (residue, value))
            .collect();
        if near.is_empty() {
            lonely += 1;
            let nearest = valued().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            near.insert(nearest.2, nearest.1);
        }
        let mean = near.values().sum::<f64>() / near.len() as f64;
        assert!((map.value_at(&place).unwrap() - mean).abs() < 1e-12);
    }
    assert!(lonely > 10, "no place was far from all");
    assert_eq!(
        HydropathyMap::new(atoms.into_iter(), &[], reach).value_at(&Vec3::zeros()),
        None
    );
}

#[test]
fn a_quarter_turn_of_the_atoms_turns_the_voxels() {
    let lattice = Lattice::new(32, 1.0).unwrap();
    let settings = VoxelSettings::new(dielectric());
    let voxels_of = |rotation: &Rotation| {
        let mut atoms = clump(4, 80);
        for (number, atom) in atoms.iter_mut().enumerate() {
            atom.residue = Some(number as u32 / 8);
        }
        let hydropathy: Vec<Option<f64>> = (0..10)
            .map(|residue| Some(f64::from(residue) - 4.5))
            .collect();
        pose(&mut atoms, rotation);
        let voxels = voxelise(&atoms, &hydropathy, &lattice, &settings).unwrap();
        let value = |index: usize| [voxels.values[1][index], voxels.values[2][index]];
        voxels
            .index
            .iter()
            .enumerate()
            .map(|(at, index)| (*index, value(at)))
            .collect::<BTreeMap<u32, [f32; 2]>>()
    };
    let start = voxels_of(&Rotation::identity());
    for (axis, turn) in [
        (
            Vec3::z_axis(),
            (|[x, y, z]| [31 - y, x, z]) as fn([usize; 3]) -> [usize; 3],
        ),
        (Vec3::x_axis(), |[x, y, z]| [x, 31 - z, y]),
    ] {
        let turned = voxels_of(&Rotation::from_axis_angle(&axis, FRAC_PI_2));
        let (mut same, mut worst) = (0, [0.0_f32; 2]);
        for (index, values) in &start {
            let index = *index as usize;
            let [x, y, z] = turn([index % 32, index / 32 % 32, index / 1024]);
            // The surface is perturbed by less than a thousandth of an Å: voxels at the very edge
            // of the shell may differ.
            if let Some(other) = turned.get(&lattice.index(x, y, z)) {
                same += 1;
                for channel in 0..2 {
                    worst[channel] = worst[channel].max((values[channel] - other[channel]).abs());
                }
            }
        }
        assert!(
            start.len() > 200 && start.len() - same < 4 && turned.len() - same < 4,
            "{} {same}",
            start.len()
        );
        assert!(worst[0] < 0.05 && worst[1] < 1e-5, "{worst:?}");
    }
}

#[test]
fn invalid_input_is_refused() {
    assert!(
        Lattice::new(4, 1.0).is_err()
            && Lattice::new(64, 2.5).is_err()
            && Lattice::new(64, f64::NAN).is_err()
    );
    let lattice = Lattice::new(16, 1.0).unwrap();
    let settings = VoxelSettings::new(dielectric());
    let refusal = |atoms: &[VoxelAtom], settings: &VoxelSettings| {
        voxelise(atoms, &[], &lattice, settings)
            .unwrap_err()
            .to_string()
    };
    let fits = [atom(Vec3::zeros(), 7.0, 0.0)];
    assert!(refusal(&[atom(Vec3::zeros(), 7.6, 0.0)], &settings).contains("room"));
    assert!(refusal(&[atom(Vec3::x(), 7.0, 0.0)], &settings).contains("room"));
    assert!(refusal(&[], &settings).contains("no atom"));
    assert!(
        refusal(
            &fits,
            &VoxelSettings {
                channels: vec![],
                ..settings.clone()
            }
        )
        .contains("channels")
    );
    assert!(
        refusal(
            &fits,
            &VoxelSettings {
                hydropathy_reach_angstrom: 0.0,
                ..settings.clone()
            }
        )
        .contains("reach")
    );
    assert!(refusal(&[fits[0], atom(9.0 * Vec3::x(), 0.0, 1.0)], &settings).contains("room"));
    assert!(
        refusal(&[fits[0], atom(7.2 * Vec3::x(), 0.0, 1.0)], &settings)
            .contains("outside the surface")
    );
}
