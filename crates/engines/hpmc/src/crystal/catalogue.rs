//! The unit cells that have names.

use super::unit_cell::{SAME, Site, UnitCell};
use crate::symmetry::frame;
use crate::{Error, Result};
use nalgebra::Rotation3;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::{Rotation, Vec3};

/// Names of unit cells, by dimension.
pub const NAMES: [&[&str]; 3] = [
    &["row"],
    &["square", "hexagonal"],
    &[
        "simple-cubic",
        "fcc",
        "bcc",
        "hcp",
        "diamond",
        "hexagonal-diamond",
        "a15",
    ],
];

/// Names of unit cells with sites for several kinds of bodies, by dimension.
pub const NAMES_OF_SEVERAL: [&[&str]; 3] = [
    &["alternating"],
    &["checkerboard"],
    &["nacl", "cscl", "zincblende", "wurtzite"],
];

const SQRT_3: f64 = 1.732_050_807_568_877_2;
const SQRT_8_3: f64 = 1.632_993_161_855_452;
const THIRD: f64 = 1.0 / 3.0;
const FCC: [&[f64]; 4] = [
    &[0.0, 0.0, 0.0],
    &[0.0, 0.5, 0.5],
    &[0.5, 0.0, 0.5],
    &[0.5, 0.5, 0.0],
];
const ROCK_SALT: [&[f64]; 8] = [
    &[0.0, 0.0, 0.0],
    &[0.0, 0.5, 0.5],
    &[0.5, 0.0, 0.5],
    &[0.5, 0.5, 0.0],
    &[0.5, 0.0, 0.0],
    &[0.5, 0.5, 0.5],
    &[0.0, 0.0, 0.5],
    &[0.0, 0.5, 0.0],
];
const HCP: [&[f64]; 4] = [
    &[0.0, 0.0, 0.0],
    &[0.5, 0.5, 0.0],
    &[0.0, THIRD, 0.5],
    &[0.5, 0.5 + THIRD, 0.5],
];
/// β-tungsten or Cr₃Si (Strukturbericht A15): a body-centred lattice, and on the faces chains along the three axes.
const A15: [&[f64]; 8] = [
    &[0.0, 0.0, 0.0],
    &[0.5, 0.5, 0.5],
    &[0.0, 0.5, 0.25],
    &[0.0, 0.5, 0.75],
    &[0.25, 0.0, 0.5],
    &[0.75, 0.0, 0.5],
    &[0.5, 0.25, 0.0],
    &[0.5, 0.75, 0.0],
];
const DIAMOND: [&[f64]; 8] = [
    &[0.0, 0.0, 0.0],
    &[0.0, 0.5, 0.5],
    &[0.5, 0.0, 0.5],
    &[0.5, 0.5, 0.0],
    &[0.25, 0.25, 0.25],
    &[0.25, 0.75, 0.75],
    &[0.75, 0.25, 0.75],
    &[0.75, 0.75, 0.25],
];
const HEXAGONAL_DIAMOND: [&[f64]; 8] = [
    &[0.0, THIRD, 0.0625],
    &[0.5, THIRD + 0.5, 0.0625],
    &[0.0, THIRD, 0.4375],
    &[0.5, THIRD + 0.5, 0.4375],
    &[0.5, 0.5 * THIRD, 0.5625],
    &[0.0, 0.5 * THIRD + 0.5, 0.5625],
    &[0.5, 0.5 * THIRD, 0.9375],
    &[0.0, 0.5 * THIRD + 0.5, 0.9375],
];

impl<const D: usize> UnitCell<D> {
    /// The unit cell of this name, with bodies as their shapes have them.
    ///
    /// In the diamonds, the bodies of the two kinds of sites are turned so that the faces of a (truncated)
    /// tetrahedron by name look at the four neighbours. In the hexagonal crystal, nearest neighbours
    /// are at odd multiples of 30 degrees from the first axis, where hexagons by name have their
    /// edges. The cells of several kinds are a row and a square with two kinds alternating, rock salt, caesium chloride, and the
    /// two diamonds with a kind on either kind of site.
    ///
    /// # Errors
    /// For an unknown name, which lists the [`NAMES`] and the [`NAMES_OF_SEVERAL`].
    ///
    /// ```
    /// use protomer_hpmc::crystal::UnitCell;
    /// assert_eq!(UnitCell::<3>::by_name("fcc")?.sites.len(), 4);
    /// assert_eq!(UnitCell::<3>::by_name("nacl")?.composition(), [4, 4]);
    /// assert!(UnitCell::<2>::by_name("fcc").is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn by_name(name: &str) -> Result<Self> {
        let (edges, places): (&[f64], &[&[f64]]) = match (D, name) {
            (1, "row") => (&[1.0], &[&[0.0]]),
            (2, "square") => (&[1.0; 2], &[&[0.0; 2]]),
            (2, "hexagonal" | "triangular") => (&[SQRT_3, 1.0], &[&[0.0; 2], &[0.5; 2]]),
            (3, "simple-cubic" | "sc") => (&[1.0; 3], &[&[0.0; 3]]),
            (3, "bcc") => (&[1.0; 3], &[&[0.0; 3], &[0.5; 3]]),
            (3, "fcc") => (&[1.0; 3], &FCC),
            (3, "hcp") => (&[1.0, SQRT_3, SQRT_8_3], &HCP),
            (3, "a15") => (&[1.0; 3], &A15),
            (3, "diamond" | "zincblende") => (&[1.0; 3], &DIAMOND),
            (3, "hexagonal-diamond" | "wurtzite") => (&[1.0, SQRT_3, SQRT_8_3], &HEXAGONAL_DIAMOND),
            (1, "alternating") => (&[1.0], &[&[0.0], &[0.5]]),
            (2, "checkerboard") => (&[1.0; 2], &[&[0.0; 2], &[0.5; 2]]),
            (3, "cscl") => (&[1.0; 3], &[&[0.0; 3], &[0.5; 3]]),
            (3, "nacl") => (&[1.0; 3], &ROCK_SALT),
            _ => {
                return Err(Error::UnknownCrystal {
                    name: name.to_owned(),
                    dimension: D,
                    names: [NAMES[D - 1], NAMES_OF_SEVERAL[D - 1]].concat(),
                });
            }
        };
        let mut cell = Self {
            space: PeriodicBox::rectangular(std::array::from_fn(|axis| edges[axis]))?,
            sites: Vec::new(),
        };
        let is_of_several = NAMES_OF_SEVERAL[D - 1].contains(&name);
        for (number, place) in places.iter().enumerate() {
            // Sites of the second kind are the second half, but for wurtzite, whose layers come in pairs.
            let second = match name {
                "wurtzite" => number / 2 % 2,
                _ => 2 * number / places.len(),
            };
            cell.sites.push(Site {
                place: std::array::from_fn(|axis| place[axis]),
                rotation: Rotation::identity(),
                kind: if is_of_several { second as u32 } else { 0 },
            });
        }
        if name.ends_with("diamond") || ["zincblende", "wurtzite"].contains(&name) {
            cell.turn_to_neighbours();
        }
        Ok(cell)
    }

    /// Turns each body so that the faces of a tetrahedron look at the four nearest sites.
    fn turn_to_neighbours(&mut self) {
        for number in 0..self.sites.len() {
            let mut bonds = Vec::new();
            for other in 0..self.sites.len() {
                // The 27 images around: nearest sites may be in the next cell.
                for image in 0..27 {
                    let shift = [image % 3, image / 3 % 3, image / 9].map(|x| f64::from(x) - 1.0);
                    let parts = std::array::from_fn(|axis| {
                        let [from, to] = [number, other].map(|site| self.sites[site].place[axis]);
                        to - from + shift[axis]
                    });
                    let vector = self.space.point(&parts);
                    let bond = Vec3::from_fn(|axis, _| vector.get(axis).copied().unwrap_or(0.0));
                    if bond.norm() > SAME {
                        bonds.push(bond);
                    }
                }
            }
            // The four shortest vectors are the bonds of a diamond.
            bonds.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
            bonds.truncate(4);
            self.sites[number].rotation = faces_along(&bonds);
        }
    }
}

/// A rotation that takes the faces of a tetrahedron by name to four directions.
fn faces_along(directions: &[Vec3]) -> Rotation {
    let face = |x: f64, y: f64, z: f64| Vec3::new(-x, -y, -z).normalize();
    let faces = [
        face(1.0, 1.0, 1.0),
        face(1.0, -1.0, -1.0),
        face(-1.0, 1.0, -1.0),
        face(-1.0, -1.0, 1.0),
    ];
    // Two faces fix the orientation; the others check it.
    let from = frame(&faces[0], &faces[1]);
    for first in directions {
        for second in directions {
            if (first - second).norm() < SAME {
                continue;
            }
            // Any pair of bonds may stand for the first two faces.
            let matrix = frame(first, second) * from.transpose();
            let looks_along = |face: &Vec3| {
                let normal = matrix * face;
                let is_near = |way: &Vec3| (way.normalize() - normal).norm() < 1e-3;
                directions.iter().any(is_near)
            };
            if faces.iter().all(looks_along) {
                let rotation = Rotation3::from_matrix_unchecked(matrix);
                return Rotation::from_rotation_matrix(&rotation);
            }
        }
    }
    Rotation::identity()
}
