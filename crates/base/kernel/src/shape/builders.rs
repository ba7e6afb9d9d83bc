//! Shapes by name.
//!
//! Solids have edges of length one, truncated tetrahedra those of the tetrahedron before it was cut.
//! Polygons have an area of one and a corner on the x axis.

use super::Shape;
use crate::{KernelError, Result, Vec3};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Names of the shapes, with their numbers, as help and errors list them.
pub const NAMES: &str = "tetrahedron, cube, octahedron, dodecahedron, icosahedron, \
     truncated-octahedron, rhombic-dodecahedron, truncated-tetrahedron:T (0 to 1: twice the part of \
     an edge that is cut off), cuboid:A,B,C, prism:N,HEIGHT and polygon:N";

/// Largest number of corners of a polygon, or of the base of a prism.
const MOST_CORNERS: f64 = 1000.0;

/// The shape of this name.
///
/// ```
/// use protomer_kernel::shape::builders::by_name;
/// assert_eq!(by_name("icosahedron")?.corners(), 12);
/// assert_eq!(by_name("prism:6,2")?.corners(), 12);
/// assert!(by_name("sphere").is_err());
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
///
/// # Errors
/// [`KernelError::BadShape`] for an unknown name, which lists the [`NAMES`], or for numbers that do
/// not make the shape.
pub fn by_name(name: &str) -> Result<Shape> {
    let (kind, numbers) = name.split_once(':').unwrap_or((name, ""));
    let numbers = numbers.split(',').filter(|number| !number.is_empty());
    let numbers: Option<Vec<f64>> = numbers.map(|number| number.trim().parse().ok()).collect();
    let numbers = numbers.ok_or_else(|| unknown(name))?;
    match (kind, numbers.as_slice()) {
        ("tetrahedron", []) => Shape::solid(&tetrahedron()),
        ("cube", []) => Shape::solid(&cuboid([1.0; 3])),
        ("octahedron", []) => Shape::solid(&signed([FRAC_1_SQRT_2, 0.0, 0.0])),
        ("dodecahedron", []) => Shape::solid(&dodecahedron()),
        ("icosahedron", []) => Shape::solid(&signed([0.0, 0.5, 0.5 * golden_ratio()])),
        ("truncated-octahedron", []) => Shape::solid(&truncated_octahedron()),
        ("rhombic-dodecahedron", []) => Shape::solid(&rhombic_dodecahedron()),
        ("truncated-tetrahedron", [part]) if (0.0..=1.0).contains(part) => {
            Shape::solid(&truncated_tetrahedron(*part))
        }
        ("cuboid", [a, b, c]) if [a, b, c].iter().all(|edge| **edge > 0.0) => {
            Shape::solid(&cuboid([*a, *b, *c]))
        }
        ("prism", [number, height]) if is_count(*number) && *height > 0.0 => {
            Shape::solid(&prism(*number as u32, *height))
        }
        ("polygon", [number]) if is_count(*number) => {
            let number = *number as u32;
            // A regular polygon of circumradius R has the area n R² sin(2π/n) / 2.
            let angle = TAU / f64::from(number);
            let radius = (2.0 / (f64::from(number) * angle.sin())).sqrt();
            Shape::flat(&regular(number, radius))
        }
        _ => Err(unknown(name)),
    }
}

fn unknown(name: &str) -> KernelError {
    KernelError::BadShape(format!(
        "'{name}' is neither a file nor the name of a shape; known are {NAMES}"
    ))
}

fn is_count(number: f64) -> bool {
    (3.0..=MOST_CORNERS).contains(&number) && number.fract() == 0.0
}

fn golden_ratio() -> f64 {
    (1.0 + 5.0_f64.sqrt()) / 2.0
}

fn tetrahedron() -> [Vec3; 4] {
    let corner = |x: f64, y: f64, z: f64| Vec3::new(x, y, z) * FRAC_1_SQRT_2 / 2.0;
    [
        corner(1.0, 1.0, 1.0),
        corner(1.0, -1.0, -1.0),
        corner(-1.0, 1.0, -1.0),
        corner(-1.0, -1.0, 1.0),
    ]
}

/// Corners of a truncated tetrahedron: the points that divide the edges at half of `part` from each
/// corner.
fn truncated_tetrahedron(part: f64) -> Vec<Vec3> {
    let corners = tetrahedron();
    let mut points = Vec::new();
    for (number, corner) in corners.iter().enumerate() {
        for (other_number, other) in corners.iter().enumerate() {
            if number != other_number {
                points.push(corner + (other - corner) * (0.5 * part));
            }
        }
    }
    points
}

fn cuboid(edges: [f64; 3]) -> Vec<Vec3> {
    let corner = |n: usize| {
        let coordinate = |axis: usize| edges[axis] * if n >> axis & 1 == 0 { -0.5 } else { 0.5 };
        Vec3::new(coordinate(0), coordinate(1), coordinate(2))
    };
    (0..8).map(corner).collect()
}

fn dodecahedron() -> Vec<Vec3> {
    let half = golden_ratio() / 2.0;
    let mut points = cuboid([2.0 * half; 3]);
    points.extend(signed([0.0, half / golden_ratio(), half * golden_ratio()]));
    points
}

/// Corners of a truncated octahedron: all permutations of 0, 1 and 2 with all signs, which are √2
/// apart.
fn truncated_octahedron() -> Vec<Vec3> {
    let [one, two] = [FRAC_1_SQRT_2, 2.0 * FRAC_1_SQRT_2];
    let mut points = signed([0.0, one, two]);
    points.extend(signed([0.0, two, one]));
    points
}

/// Corners of a rhombic dodecahedron: those of a cube, and one above each of its faces.
fn rhombic_dodecahedron() -> Vec<Vec3> {
    let edge = 2.0 / 3.0_f64.sqrt();
    let mut points = cuboid([edge; 3]);
    points.extend(signed([edge, 0.0, 0.0]));
    points
}

/// The even permutations of three numbers with all signs.
fn signed([a, b, c]: [f64; 3]) -> Vec<Vec3> {
    let mut points = Vec::new();
    for signs in 0..8 {
        let sign = |axis: usize| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let [a, b, c] = [a * sign(0), b * sign(1), c * sign(2)];
        points.extend([Vec3::new(a, b, c), Vec3::new(c, a, b), Vec3::new(b, c, a)]);
    }
    points
}

fn prism(number: u32, height: f64) -> Vec<Vec3> {
    let radius = 0.5 / (TAU / f64::from(number) / 2.0).sin();
    let base = regular(number, radius).into_iter();
    base.flat_map(|[x, y]| [-0.5, 0.5].map(|side| Vec3::new(x, y, side * height)))
        .collect()
}

fn regular(number: u32, radius: f64) -> Vec<[f64; 2]> {
    let corner = |k: u32| {
        let angle = TAU * f64::from(k) / f64::from(number);
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..number).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::super::measures::Measures;
    use super::*;

    #[test]
    fn names_have_the_corners_and_sizes_they_say() {
        let g = golden_ratio();
        for (name, corners, volume) in [
            ("icosahedron", 12, 5.0 * g * g / 6.0),
            ("dodecahedron", 20, (15.0 + 7.0 * 5.0_f64.sqrt()) / 4.0),
            (
                "truncated-tetrahedron:0.5",
                12,
                2.0_f64.sqrt() / 12.0 * (1.0 - 4.0 / 64.0),
            ),
            ("truncated-tetrahedron:1", 6, 2.0_f64.sqrt() / 24.0),
            ("truncated-tetrahedron:0", 4, 2.0_f64.sqrt() / 12.0),
            ("truncated-octahedron", 24, 8.0 * 2.0_f64.sqrt()),
            ("rhombic-dodecahedron", 14, 16.0 / 9.0 * 3.0_f64.sqrt()),
            ("prism:6,2", 12, 3.0 * 3.0_f64.sqrt()),
            ("polygon:7", 7, 1.0),
        ] {
            let shape = by_name(name).unwrap();
            assert_eq!(shape.corners(), corners, "{name}");
            let found = Measures::from_shape(&shape, 0.0).unwrap().volume;
            assert!(
                (found / volume - 1.0).abs() < 1e-12,
                "{name} {found} {volume}"
            );
        }
    }

    #[test]
    fn what_is_no_name_is_refused_with_the_names() {
        for name in [
            "cub",
            "cube:2",
            "polygon:2",
            "cuboid:1,2",
            "polygon:x",
            "prism:5,-1",
        ] {
            let words = by_name(name).unwrap_err().to_string();
            assert!(words.contains("icosahedron"), "{words}");
        }
    }
}
