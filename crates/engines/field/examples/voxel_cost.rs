//! CPU time of voxels per structure, with and without the Poisson-Boltzmann potential.
//!
//! ```text
//! cargo run --release -p protomer-field --example voxel_cost -- STRUCTURE...
//! ```
//!
//! Each structure is scaled to 64 voxels along each edge; those that would need voxels of more than
//! 2 Å, or that cannot be read, are passed over. One thread.

#![allow(clippy::print_stdout)]

use cpu_time::ProcessTime;
use protomer_body::chemistry::{ChargedSites, SiteSettings, build_sites};
use protomer_body::structure::{SelectionSettings, Structure};
use protomer_field::voxels::channels::{bounds, pose};
use protomer_field::voxels::lattice::SPACING_RANGE_ANGSTROM;
use protomer_field::voxels::{Channel, Lattice, Orientation, VoxelAtom, VoxelSettings, voxelise};
use protomer_field::{ChargedSphere, DielectricModel};
use protomer_io::gzip::read_maybe_gzip;
use protomer_kernel::{Electrolyte, Vec3};
use std::error::Error;
use std::path::Path;

/// Voxels along each edge.
const SIZE: usize = 64;

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build_global()?;
    let saline = Electrolyte::in_water(298.15, 0.15)?;
    let settings = VoxelSettings::new(DielectricModel::new(saline));
    let without_potential = VoxelSettings {
        channels: vec![Channel::Shape, Channel::Hydropathy],
        ..settings.clone()
    };
    let (mut structures, mut atom_count, mut seconds) = (0, 0, [0.0; 3]);
    for file in std::env::args().skip(1) {
        let start = ProcessTime::now();
        let Ok(sites) = sites_of(Path::new(&file)) else {
            println!("{file} cannot be read");
            continue;
        };
        let reading = start.elapsed().as_secs_f64();
        let mut atoms = atoms_of(&sites);
        let places: Vec<Vec3> = atoms.iter().map(|atom| atom.sphere.centre).collect();
        pose(&mut atoms, &Orientation::Random.rotation(&places, 1, 5));
        let (low, high) = bounds(&atoms);
        let spacing = (high - low).max() / (SIZE - 1) as f64 * (1.0 + 1e-9);
        if spacing > SPACING_RANGE_ANGSTROM.1 {
            continue;
        }
        let lattice = Lattice::new(SIZE, spacing.max(SPACING_RANGE_ANGSTROM.0))?;
        let residues = sites.residues.iter();
        let hydropathy: Vec<Option<f64>> = residues.map(|residue| residue.hydropathy).collect();
        seconds[0] += reading;
        for (place, settings) in [&without_potential, &settings].into_iter().enumerate() {
            let start = ProcessTime::now();
            voxelise(&atoms, &hydropathy, &lattice, settings)?;
            seconds[place + 1] += start.elapsed().as_secs_f64();
        }
        structures += 1;
        atom_count += atoms.len();
    }
    let [reading, without, with] = seconds.map(|seconds| seconds / f64::from(structures));
    println!(
        "{structures} structures of {:.0} atoms: read {reading:.4}, voxels without potential \
         {without:.4}, with {with:.4} CPU-s each",
        atom_count as f64 / f64::from(structures)
    );
    Ok(())
}

fn sites_of(file: &Path) -> Result<ChargedSites, Box<dyn Error>> {
    let bytes = read_maybe_gzip(file, 1 << 30)?;
    let structure = Structure::read(&file.display().to_string(), &bytes)?;
    let selection = structure.select(&SelectionSettings::default())?;
    Ok(build_sites(&selection, &SiteSettings::default())?)
}

fn atoms_of(sites: &ChargedSites) -> Vec<VoxelAtom> {
    let mut atoms = Vec::with_capacity(sites.sites.len());
    for site in &sites.sites {
        let sphere = ChargedSphere {
            centre: site.position,
            radius_angstrom: site.radius_angstrom,
            charge_e: site.charge_e,
        };
        atoms.push(VoxelAtom {
            sphere,
            residue: site.residue,
        });
    }
    atoms
}
