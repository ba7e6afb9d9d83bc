//! Decisions of overlap against integers: a million of them when requested, thousands in every run.
//!
//! Corners and offsets are multiples of 2⁻³⁶, so the test below computes with integers and is exact. To
//! the fast test they are numbers like any other: most of its products are rounded.

use protomer_kernel::bisection::halved;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::exact::overlap_exactly;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
use protomer_kernel::{Rotation, Vec3};

/// 2³⁶: differences of corners stay below 2⁴⁰, triple products below 2¹²³.
const UNITS: f64 = (1_u64 << 36) as f64;

fn to_grid(x: f64) -> f64 {
    (x * UNITS).round() / UNITS
}

fn integer(x: f64) -> i128 {
    let units = x * UNITS;
    assert_eq!(units, units.round(), "{x} is not on the grid");
    units as i128
}

type Point = [i128; 3];

fn minus(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|axis: usize| a[axis] - b[axis])
}

fn cross(a: &Point, b: &Point) -> Point {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j): (usize, usize)| a[i] * b[j] - a[j] * b[i])
}

/// Whether one body lies strictly above the other along an axis.
fn separates(axis: &Point, first: &[Point], second: &[Point]) -> bool {
    let height = |point: &Point| axis[0] * point[0] + axis[1] * point[1] + axis[2] * point[2];
    let (mut above, mut below) = (true, true);
    for a in first {
        for b in second {
            let side = height(&minus(b, a));
            above &= side > 0;
            below &= side < 0;
            if !above && !below {
                return false;
            }
        }
    }
    true
}

fn differences(corners: &[Point]) -> Vec<Point> {
    let pairs = (0..corners.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs
        .map(|(i, j)| minus(&corners[i], &corners[j]))
        .collect()
}

/// Whether two hulls are apart, by all axes that any corners give: the slow twin.
fn are_apart(dimension: usize, first: &[Point], second: &[Point]) -> bool {
    let sides = [differences(first), differences(second)];
    let separates = |axis: Point| separates(&axis, first, second);
    if dimension == 2 {
        let up = [0, 0, 1];
        return sides
            .iter()
            .flatten()
            .any(|side| separates(cross(side, &up)));
    }
    let of_a_face = |corners: &[Point], sides: &[Point]| {
        // Three corners: two of the differences that share the first.
        corners.len() > 2
            && sides
                .iter()
                .enumerate()
                .any(|(number, a)| sides[..number].iter().any(|b| separates(cross(a, b))))
    };
    sides[0]
        .iter()
        .any(|a| sides[1].iter().any(|b| separates(cross(a, b))))
        || of_a_face(first, &sides[0])
        || of_a_face(second, &sides[1])
}

/// A body whose corners are on the grid, and its faces.
struct Body {
    corners: Vec<Vec3>,
    faces: Vec<Vec<usize>>,
}

impl Body {
    fn named(name: &str, scale: f64) -> Self {
        let body = Polytope::from_shape(&by_name(name).unwrap()).unwrap();
        Self {
            corners: body.corners.iter().map(|x| x * scale).collect(),
            faces: body.faces.iter().map(|face| face.corners.clone()).collect(),
        }
    }

    fn placed(&self, turn: impl Fn(&Vec3) -> Vec3) -> Vec<Vec3> {
        self.corners.iter().map(|x| turn(x).map(to_grid)).collect()
    }

    fn size(&self) -> f64 {
        self.corners.iter().map(Vec3::norm).fold(0.0, f64::max)
    }
}

/// What was compared.
#[derive(Debug, Default)]
struct Tally {
    overlaps: usize,
    apart: usize,
    /// Decisions of which the fast test was not certain.
    asked: usize,
}

/// Two bodies with corners on the grid.
struct Case<'a, const D: usize> {
    bodies: [&'a Body; 2],
    corners: [Vec<Vec3>; 2],
}

impl<const D: usize> Case<'_, D> {
    fn fast(&self, offset: &Vec3, start: &Vec3, asked: &mut usize) -> bool {
        let flat = |x: &Vec3| -> [f64; D] { std::array::from_fn(|axis| x[axis]) };
        let packed = [0, 1].map(|body: usize| {
            pack(
                &self.corners[body]
                    .iter()
                    .map(flat)
                    .collect::<Vec<[f64; D]>>(),
            )
        });
        let size = self.bodies[0].size() + self.bodies[1].size();
        let pair = Pair {
            first: &packed[0],
            second: &packed[1],
            offset: flat(offset),
            reach: 0.0,
            error: error_of_heights(2.0 * D as f64 * size),
        };
        let mut direction = flat(start);
        let found = pair.overlap(&mut direction, || {
            *asked += 1;
            overlap_exactly(&pair, self.bodies.map(|body| &body.faces[..]))
        });
        if !found {
            // What is kept of the direction gives the same decision or none.
            let kept = direction.map(|x| f64::from(x as f32));
            assert_eq!(pair.overlap(&mut { kept }, || found), found);
        }
        found
    }

    fn compare(&self, offset: &Vec3, start: &Vec3, tally: &mut Tally) {
        let points = |corners: &[Vec3], shift: &Vec3| -> Vec<Point> {
            let place =
                |x: &Vec3| [0, 1, 2].map(|axis: usize| integer(x[axis]) + integer(shift[axis]));
            corners.iter().map(place).collect()
        };
        let first = points(&self.corners[0], &Vec3::zeros());
        let second = points(&self.corners[1], offset);
        let expected = !are_apart(D, &first, &second);
        let found = self.fast(offset, start, &mut tally.asked);
        assert_eq!(found, expected, "{offset:?} {:?}", self.corners);
        match expected {
            true => tally.overlaps += 1,
            false => tally.apart += 1,
        }
    }

    /// A random place, and places about contact along the line to it: a hundredth of the size away,
    /// and to a few units of the grid.
    fn about_contact(&self, line: &Vec3, rng: &mut CounterRng, tally: &mut Tally) {
        let shifted = |distance: f64| (line * distance).map(to_grid);
        let outside = 2.0 * (self.bodies[0].size() + self.bodies[1].size());
        let overlaps = |distance: f64| self.fast(&shifted(distance), &shifted(distance), &mut 0);
        let inside = halved([0.0, outside], 45, overlaps)[0];
        let axis = Vec3::ith(rng.index(D), 1.0 / UNITS);
        let contact = shifted(inside);
        for shift in [
            rng.uniform_in(-0.5, 0.5) * line,
            0.01 * line,
            -0.01 * line,
            Vec3::zeros(),
            rng.uniform_in(-3.5, 3.5).round() * axis,
        ] {
            let offset = (contact + shift).map(to_grid);
            let start = match rng.index(2) {
                0 => offset,
                _ => line_in::<D>(rng),
            };
            self.compare(&offset, &start, tally);
        }
    }

    /// A corner of one body in the place of a corner of the other, exactly, and a unit away.
    fn corner_on_corner(&self, rng: &mut CounterRng, tally: &mut Tally) {
        let [a, b] = [0, 1].map(|body: usize| {
            let corners = &self.corners[body];
            corners[rng.index(corners.len())]
        });
        let axis = Vec3::ith(rng.index(D), 1.0 / UNITS);
        for offset in [a - b, a - b + axis] {
            let start = match rng.index(2) {
                0 => offset,
                _ => line_in::<D>(rng),
            };
            self.compare(&offset, &start, tally);
        }
    }
}

fn line_in<const D: usize>(rng: &mut CounterRng) -> Vec3 {
    if D == 3 {
        return rng.unit_vector();
    }
    let angle = rng.uniform_in(0.0, 7.0);
    Vec3::new(angle.cos(), angle.sin(), 0.0)
}

fn rotation_in<const D: usize>(rng: &mut CounterRng) -> Rotation {
    if D == 3 {
        return rng.rotation();
    }
    Rotation::from_scaled_axis(rng.uniform_in(0.0, 7.0) * Vec3::z())
}

/// Poses of which half have parallel faces; seven decisions each.
fn compare_turned<const D: usize>(names: [&str; 2], poses: u64, tally: &mut Tally) {
    let bodies = names.map(|name| Body::named(name, 1.0));
    for number in 0..poses {
        let mut rng = CounterRng::new(21, D as u32, number);
        let turns = [rotation_in::<D>(&mut rng), rotation_in::<D>(&mut rng)];
        let turns = [turns[0], turns[usize::from(number % 2 == 0)]];
        let case = Case::<D> {
            bodies: [&bodies[0], &bodies[1]],
            corners: [0, 1].map(|body: usize| bodies[body].placed(|x| turns[body] * x)),
        };
        let line = line_in::<D>(&mut rng);
        case.about_contact(&line, &mut rng, tally);
        case.corner_on_corner(&mut rng, tally);
    }
}

/// A body and its mirror image with a face of each in one plane, exactly, and one unit off; five
/// decisions per pose.
fn compare_faces<const D: usize>(name: &str, scale: f64, poses: u64, tally: &mut Tally) {
    let body = Body::named(name, scale);
    let corners = [body.placed(|x| *x), body.placed(|x| -x)];
    // Corners that are multiples of 2⁻⁹ to within rounding are short binary numbers.
    let corners = corners.map(|corners| -> Vec<Vec3> {
        let short = |x: f64| (x * 512.0).round() / 512.0;
        corners.iter().map(|corner| corner.map(short)).collect()
    });
    let case = Case::<D> {
        bodies: [&body, &body],
        corners: corners.clone(),
    };
    for number in 0..poses {
        let mut rng = CounterRng::new(22, D as u32, number);
        let face = &body.faces[rng.index(body.faces.len())];
        let corner = |number: usize| corners[0][face[number % face.len()]];
        // From a corner of the face to that of its image, and along two of its edges.
        let mut offset = 2.0 * corner(0);
        for edge in 0..2 {
            let along = corner(edge + 1) - corner(edge);
            // Parts that keep the place on the grid, among them whole edges.
            let part = match rng.index(4) {
                0 => rng.uniform_in(-1.5, 1.5).round(),
                _ => (rng.uniform_in(-1.3, 1.3) * 1024.0).round() / 1024.0,
            };
            offset += part * along;
        }
        case.compare(&offset, &offset, tally);
        for _ in 0..4 {
            let axis = Vec3::ith(rng.index(D), 1.0 / UNITS);
            let near = offset + rng.uniform_in(-1.5, 1.5).round() * axis;
            let start = line_in::<D>(&mut rng);
            case.compare(&near, &start, tally);
        }
    }
}

/// So many poses of each kind, five or seven decisions each.
fn compare_all(poses: u64) -> Tally {
    let mut tally = Tally::default();
    for names in [
        ["cube", "cube"],
        ["tetrahedron", "octahedron"],
        ["truncated-tetrahedron:0.5", "truncated-tetrahedron:0.5"],
        ["truncated-tetrahedron:0.6667", "prism:3,0.2"],
    ] {
        compare_turned::<3>(names, poses, &mut tally);
    }
    for names in [
        ["polygon:4"; 2],
        ["polygon:5", "polygon:3"],
        ["polygon:6"; 2],
    ] {
        compare_turned::<2>(names, poses, &mut tally);
    }
    // Scales at which the corners are short binary numbers.
    compare_faces::<3>("cube", 1.0, poses, &mut tally);
    compare_faces::<3>("tetrahedron", 2.0_f64.sqrt(), poses, &mut tally);
    compare_faces::<2>("polygon:4", 2.0_f64.sqrt(), poses, &mut tally);
    tally
}

#[test]
fn decisions_are_exact() {
    let tally = compare_all(50);
    assert!(
        tally.overlaps > 500 && tally.apart > 500 && tally.asked > 250,
        "{tally:?}"
    );
}

#[test]
#[ignore = "a million decisions; minutes in a release build"]
fn a_million_decisions_are_exact() {
    let tally = compare_all(16_000);
    assert!(tally.overlaps + tally.apart >= 1_000_000, "{tally:?}");
    assert!(
        tally.overlaps > 200_000 && tally.apart > 200_000,
        "{tally:?}"
    );
    println!("{tally:?}");
}
