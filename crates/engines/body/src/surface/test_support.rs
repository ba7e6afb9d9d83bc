//! Inputs and slow twins for the tests of the surface.

use crate::surface::arrangement::hashed_fraction;
use protomer_kernel::Vec3;
use std::ops::Range;

/// The fixed pseudo-random number in [0, 1) of this index.
pub(crate) fn fraction(index: u64) -> f64 {
    hashed_fraction(index)
}

/// Random and awkward clusters: loose, dense, nearly tangent, duplicated, on lattices.
pub(crate) fn clusters(count: usize, sizes: Range<usize>) -> Vec<(Vec<Vec3>, Vec<f64>)> {
    (0..count)
        .map(|number| {
            let mut counter = number as u64 * 1_000_003;
            let mut random = || {
                counter += 1;
                fraction(counter)
            };
            let size = sizes.start + (random() * (sizes.end - sizes.start) as f64) as usize;
            let spread = (size as f64).cbrt() * (1.0 + 1.5 * random());
            let radius_spread = if number % 2 == 0 { 0.0 } else { 0.4 };
            let mut centres: Vec<Vec3> = Vec::new();
            let mut radii: Vec<f64> = Vec::new();
            for atom in 0..size {
                let cell = Vec3::new((atom % 3) as f64, (atom / 3 % 3) as f64, (atom / 9) as f64);
                let anywhere = Vec3::new(random(), random(), random()) * (2.0 * spread);
                let radius = 1.5 + radius_spread * (random() - 0.5);
                let centre = match number % 5 {
                    0 | 1 => anywhere,
                    2 => cell * 2.3,
                    3 if atom % 3 == 2 => {
                        centres[atom - 1] + Vec3::new(1e-9, 0.0, 0.0) * (atom % 2) as f64
                    }
                    4 if atom > 0 => {
                        // Tangent to the atom before, as an expanded ball or as an atom.
                        let reach =
                            radii[atom - 1] + radius + if atom % 2 == 0 { 2.8 } else { 0.0 };
                        centres[atom - 1] + (anywhere - Vec3::repeat(spread)).normalize() * reach
                    }
                    _ => anywhere,
                };
                centres.push(centre);
                radii.push(radius);
            }
            (centres, radii)
        })
        .collect()
}

/// Probe positions that touch three balls, two for every three that have them.
pub(crate) fn probe_contacts(centres: &[Vec3], radii: &[f64]) -> Vec<Vec3> {
    let mut contacts = Vec::new();
    for i in 0..centres.len() {
        for j in i + 1..centres.len() {
            for k in j + 1..centres.len() {
                let (a, b) = (centres[j] - centres[i], centres[k] - centres[i]);
                let normal = a.cross(&b);
                let (p, q) = (
                    (a.norm_squared() + radii[i].powi(2) - radii[j].powi(2)) / 2.0,
                    (b.norm_squared() + radii[i].powi(2) - radii[k].powi(2)) / 2.0,
                );
                let square = normal.norm_squared();
                let base = (b.cross(&normal) * p + normal.cross(&a) * q) / square;
                let height = (radii[i].powi(2) - base.norm_squared()) / square;
                if height >= 0.0 && square > 0.0 {
                    contacts.push(centres[i] + base + normal * height.sqrt());
                    contacts.push(centres[i] + base - normal * height.sqrt());
                }
            }
        }
    }
    contacts
}

#[path = "../../../../../tests/test_data.rs"]
mod test_data;

/// A file of the reference surfaces, which are not part of the repository.
pub(crate) fn reference_file(name: &str) -> String {
    let path = test_data::test_data(&format!("reference/surface/{name}"));
    std::fs::read_to_string(path).unwrap()
}

/// Centres and radii of a reference file.
pub(crate) fn read_reference(name: &str) -> (Vec<Vec3>, Vec<f64>) {
    let (mut centres, mut radii) = (Vec::new(), Vec::new());
    for line in reference_file(name).lines() {
        let words = line.split_whitespace();
        let row: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        if let [x, y, z, radius] = row[..] {
            centres.push(Vec3::new(x, y, z));
            radii.push(radius);
        }
    }
    (centres, radii)
}
