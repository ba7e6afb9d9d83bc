//! What charges do at an edge of a grid: the potential and its slope where the surface crosses the
//! edge, and the flux through the face in its middle.
//!
//! All three follow from the derivatives along the edge of φ = Σ s_i / r_i at the middle m, by
//! Taylor's series at a distance δ of the middle, and because φ is harmonic, for a face of edge h:
//!
//! flux of -∇φ = -h² (φ' - h²/24 φ''').
//!
//! The series up to φ'''' leaves at most 10⁻⁵ s/r of a potential, 4 · 10⁻⁴ s/r² of a slope and
//! 10⁻³ s/r² of a mean flux of charges at a distance of six edges, and all of these fall with r⁻⁴ and
//! faster. For nearer charges potential and slope are exact, and the flux follows from an expansion of the
//! solid angle of the face. Charges are summed in single precision, sixteen at a time, about an origin
//! nearby; those nearer than 2.25 edges one by one in double precision, with the exact solid angle.

use crate::point_charges::Source;
use protomer_kernel::Vec3;
use protomer_kernel::vectorised;
use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Range, Sub};

/// Charges in a group.
const LANES: usize = 16;
/// Charges nearer than this many edges have an exact potential and slope.
pub(crate) const EXACT_IN_EDGES: f64 = 6.0;
/// Charges nearer than this many edges are summed one by one: for others an expansion of the solid
/// angle is within 2 · 10⁻⁴ of h²/r².
const NEAR_IN_EDGES: f64 = 2.25;

/// An edge of a grid, and a place on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EdgePlace {
    /// The middle of the edge.
    pub middle: Vec3,
    pub axis: usize,
    /// The length of the edge, and the edge of the square face in its middle.
    pub length: f64,
    /// Offset of the place from the middle, along the axis.
    pub offset: f64,
}

/// Potential and slope along the axis at the place on the edge, and the flux of -∇φ through the face
/// in the direction of the axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct AtEdge {
    pub value: f64,
    pub slope: f64,
    pub flux: f64,
}

/// Sixteen charges; unused lanes have no strength.
#[derive(Debug, Clone)]
struct Group {
    /// Coordinates from the origin, by axis.
    places: [[f32; LANES]; 3],
    strength: [f32; LANES],
}

/// Charges that act on edges near an origin.
#[derive(Debug, Clone)]
pub(crate) struct EdgeCharges {
    origin: Vec3,
    sources: Vec<Source>,
    groups: Vec<Group>,
}

impl EdgeCharges {
    pub fn new(sources: Vec<Source>, origin: Vec3) -> Self {
        let groups = sources.chunks(LANES).map(|sources| {
            let mut group = Group {
                places: [[0.0; LANES]; 3],
                strength: [0.0; LANES],
            };
            for (lane, source) in sources.iter().enumerate() {
                let place = source.place - origin;
                for axis in 0..3 {
                    group.places[axis][lane] = place[axis] as f32;
                }
                group.strength[lane] = source.strength as f32;
            }
            group
        });
        Self {
            origin,
            groups: groups.collect(),
            sources,
        }
    }

    vectorised!(
        /// Sums over all charges.
        pub fn value_at[value_at_avx512, value_at_avx2, value_at_any](self: &Self, edge: &EdgePlace) -> AtEdge
    );

    #[inline(always)]
    fn value_at_any(&self, edge: &EdgePlace) -> AtEdge {
        let length = edge.length as f32;
        let [exact, near] = [EXACT_IN_EDGES as f32, NEAR_IN_EDGES as f32];
        // Squared, as distances are compared without their roots.
        let [exact, near] = [exact, near].map(|edges| (edges * length).powi(2));
        let middle = edge.middle - self.origin;
        let axes @ [third, first, second] = edge.axes();
        let coordinates = axes.map(|axis| middle[axis] as f32);
        let (mut of_far, mut of_exact) = ([[0.0_f32; LANES]; 5], [[0.0_f32; LANES]; 3]);
        let mut of_near = AtEdge::default();
        for (number, group) in self.groups.iter().enumerate() {
            let [z, x, y] = [third, first, second].map(|axis| &group.places[axis]);
            // Offsets and squares of a group are found once and used by all three ways of summing.
            let mut offsets = [[0.0; LANES]; 3];
            let mut squares = [0.0; LANES];
            let (mut exact_lanes, mut near_lanes) = (0, 0);
            for lane in 0..LANES {
                let (dz, dx, dy) = (
                    coordinates[0] - z[lane],
                    coordinates[1] - x[lane],
                    coordinates[2] - y[lane],
                );
                let square = dx * dx + dy * dy + dz * dz;
                [offsets[0][lane], offsets[1][lane], offsets[2][lane]] = [dz, dx, dy];
                squares[lane] = square;
                // Counted without a branch; the rarer ways run only if a lane needs them.
                exact_lanes += i32::from(square <= exact);
                near_lanes += i32::from(square <= near);
            }
            // Always, as nearly all charges are far.
            group.add_far(&offsets, &squares, exact, &mut of_far);
            if exact_lanes > 0 {
                group.add_exact(&offsets, &squares, near..exact, edge, &mut of_exact);
            }
            if near_lanes > 0 {
                // The same comparison as above, so that no charge is lost or counted twice.
                let sources = self.sources[number * LANES..].iter();
                for (source, square) in sources.zip(squares) {
                    if square <= near {
                        edge.add(source, &mut of_near);
                    }
                }
            }
        }
        let [value, slope, flux] = of_exact.map(|lanes| sum_of(&lanes));
        let of_exact = AtEdge { value, slope, flux };
        of_near + of_exact + edge.with_derivatives(of_far.map(|lanes| sum_of(&lanes)))
    }
}

/// The sum over lanes, in double precision.
#[inline(always)]
fn sum_of(lanes: &[f32; LANES]) -> f64 {
    lanes.iter().map(|value| f64::from(*value)).sum()
}

impl Group {
    /// Adds the potential and its derivatives along z at the middle of an edge, up to the fourth, of
    /// charges at a squared distance of more than `exact`, given the offsets of the middle from the
    /// charges along z, x and y and their squares.
    #[inline(always)]
    fn add_far(
        &self,
        [dz, _, _]: &[[f32; LANES]; 3],
        squares: &[f32; LANES],
        exact: f32,
        sums: &mut [[f32; LANES]; 5],
    ) {
        for lane in 0..LANES {
            // A lane that is not far gets no strength and a
            // harmless distance: no branch, no division by zero.
            let is_far = squares[lane] > exact;
            let strength = if is_far { self.strength[lane] } else { 0.0 };
            let inverse = 1.0 / if is_far { squares[lane] } else { exact };
            let value = strength * inverse.sqrt();
            // The derivatives of 1/r along z, with c = z/r: Legendre polynomials.
            // d^n (1/r)/dz^n = (-1)^n n! P_n(c)/r^{n+1}: P_1 to P_4 follow.
            let (slope, second) = (dz[lane] * inverse, dz[lane] * dz[lane] * inverse);
            let per_square = value * inverse;
            sums[0][lane] += value;
            sums[1][lane] -= value * slope;
            sums[2][lane] += per_square * (3.0 * second - 1.0);
            sums[3][lane] += per_square * slope * (9.0 - 15.0 * second);
            sums[4][lane] += per_square * inverse * ((105.0 * second - 90.0) * second + 9.0);
        }
    }

    /// Adds potential and slope at the place on the edge and the flux through the face, of charges at a
    /// squared distance between these.
    #[inline(always)]
    fn add_exact(
        &self,
        [dz, dx, dy]: &[[f32; LANES]; 3],
        squares: &[f32; LANES],
        between: Range<f32>,
        edge: &EdgePlace,
        sums: &mut [[f32; LANES]; 3],
    ) {
        let (offset, length) = (edge.offset as f32, edge.length as f32);
        for lane in 0..LANES {
            // `&`, not `&&`: the compiler keeps it free of branches.
            let is_between = (squares[lane] > between.start) & (squares[lane] <= between.end);
            let strength = if is_between { self.strength[lane] } else { 0.0 };
            let square = if is_between {
                squares[lane]
            } else {
                between.end
            };
            // Potential and slope at the place itself; the flux is that through the middle.
            let axial_offset = dz[lane] + offset;
            let radial_square = dx[lane] * dx[lane] + dy[lane] * dy[lane];
            let to_place = radial_square + axial_offset * axial_offset;
            let inverse = 1.0 / if is_between { to_place } else { between.end };
            let value = strength * inverse.sqrt();
            sums[0][lane] += value;
            sums[1][lane] -= value * axial_offset * inverse;
            let offsets = [dz[lane], dx[lane], dy[lane]];
            let angle = expanded_solid_angle(offsets, (1.0 / square).sqrt(), length);
            sums[2][lane] += strength * angle;
        }
    }
}

impl Add for AtEdge {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: self.slope + other.slope,
            flux: self.flux + other.flux,
        }
    }
}

impl EdgePlace {
    /// The axis of the edge and the two that follow.
    pub fn axes(&self) -> [usize; 3] {
        [self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// Potential and slope at the place and flux through the face, of a potential with this value
    /// and these derivatives along the edge in its middle, up to the fourth.
    #[inline(always)]
    pub fn with_derivatives(&self, derivatives: [f64; 5]) -> AtEdge {
        let [value, slope, second, third, fourth] = derivatives;
        let (d, h) = (self.offset, self.length);
        AtEdge {
            // Taylor's series by Horner's rule.
            value: value + d * (slope + d / 2.0 * (second + d / 3.0 * (third + d / 4.0 * fourth))),
            slope: slope + d * (second + d / 2.0 * (third + d / 3.0 * fourth)),
            flux: -h * h * (slope - h * h / 24.0 * third),
        }
    }

    /// Adds the potential, the slope and the flux of one charge.
    fn add(&self, source: &Source, sum: &mut AtEdge) {
        let from_charge = self.middle - source.place;
        let [z, x, y] = self.axes().map(|axis| from_charge[axis]);
        let radial_square = x * x + y * y;
        let (distance, axial_offset) = ((radial_square + z * z).sqrt(), z + self.offset);
        let to_place = (radial_square + axial_offset * axial_offset).sqrt();
        // A place at a charge has the potential at its least distance.
        let inverse = 1.0 / to_place.max(source.least_distance_angstrom);
        sum.value += source.strength * inverse;
        sum.slope -= source.strength * axial_offset * inverse.powi(3);
        let angle = if distance <= NEAR_IN_EDGES * self.length {
            solid_angle([z, x, y], self.length)
        } else {
            expanded_solid_angle([z, x, y], 1.0 / distance, self.length)
        };
        sum.flux += source.strength * angle;
    }
}

/// The solid angle of a square with its middle at z along its axis and x, y across, negative for
/// negative z: the sum of ± atan(x y / (z r)) over its corners, the argument of a product of complex
/// numbers.
fn solid_angle([z, x, y]: [f64; 3], edge: f64) -> f64 {
    let half = 0.5 * edge;
    // A corner as a complex number whose argument is ± atan(x y/(|z| r)).
    let corner = |right: f64, up: f64| {
        let (x, y) = (x + half * right, y + half * up);
        let distance = (x * x + y * y + z * z).sqrt();
        (z.abs() * distance, right * up * x * y)
    };
    let product = |(a, b): (f64, f64), (c, d): (f64, f64)| (a * c - b * d, a * d + b * c);
    let (real, imaginary) = product(
        product(corner(1.0, 1.0), corner(-1.0, -1.0)),
        product(corner(-1.0, 1.0), corner(1.0, -1.0)),
    );
    let argument = imaginary.atan2(real);
    // The argument is the angle up to a multiple of 2π. The angle itself lies between 0 and π next
    // to the square and, up to ten edges away, between 0.01 and 2π in front of it, give or
    // take rounding.
    let is_in_front = x.abs().max(y.abs()) <= half;
    let least = if is_in_front { 0.01 } else { -1.0 };
    let angle = if argument < least {
        argument + 2.0 * PI
    } else {
        argument
    };
    if z < 0.0 { -angle } else { angle }
}

/// The solid angle from a distance r, given by its inverse, by Taylor's series of f = z/r³ about
/// the middle of the square. f is harmonic, so that f_xx + f_yy = -f_zz and
/// f_xxxx + f_yyyy = f_zzzz - 2 f_xxyy:
///
/// Ω = h² (f - h²/24 f_zz + h⁴/1920 f_zzzz + h⁴/1440 f_xxyy).
#[inline(always)]
fn expanded_solid_angle<T: Real>([z, x, y]: [T; 3], inverse_distance: T, edge: T) -> T {
    let number = T::from;
    let inverse = inverse_distance * inverse_distance;
    let [xx, yy, zz] = [x, y, z].map(|coordinate| coordinate * coordinate * inverse);
    let area = edge * edge;
    let small = area * inverse;
    // Derivatives of z/r³ over z/r³, times powers of r².
    let second = number(15.0) * zz - number(9.0);
    let fourth = (number(945.0) * zz - number(1050.0)) * zz + number(225.0);
    let lateral = number(15.0) - number(105.0) * (xx + yy) + number(945.0) * xx * yy;
    let of_fourth = fourth / number(1920.0) + lateral / number(1440.0);
    let series = number(1.0) - small / number(24.0) * second + small * small * of_fourth;
    area * z * inverse * inverse_distance * series
}

/// A number in single or double precision.
trait Real:
    Copy + From<f32> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl Real for f32 {}
impl Real for f64 {}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    pub(crate) fn source(place: Vec3, strength: f64) -> Source {
        Source {
            place,
            strength,
            least_distance_angstrom: 1e-3,
        }
    }

    /// The slow twin: a term for each corner.
    fn slow_solid_angle([z, x, y]: [f64; 3], edge: f64) -> f64 {
        let mut angle = 0.0;
        for (right, up) in [(1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)] {
            let (x, y) = (x + 0.5 * edge * right, y + 0.5 * edge * up);
            let distance = (x * x + y * y + z * z).sqrt();
            angle += right * up * (x * y).atan2(z.abs() * distance);
        }
        if z < 0.0 { -angle } else { angle }
    }

    #[test]
    fn solid_angles_are_sums_over_corners() {
        let mut rng = CounterRng::new(64, 0, 0);
        for turn in 0..3000 {
            let mut place: [f64; 3] = rng.vector_in_ball([0.5, 1.0, 4.0][turn % 3]).into();
            place[0] *= [1.0, 1e-7, 1e-12, 0.0][turn % 4];
            let (angle, slow) = (solid_angle(place, 0.7), slow_solid_angle(place, 0.7));
            assert!((angle - slow).abs() < 1e-12, "{place:?}: {angle} {slow}");
        }
    }

    #[test]
    fn expanded_solid_angles_are_solid_angles() {
        let mut rng = CounterRng::new(65, 0, 0);
        let edge = 0.7;
        for _ in 0..20_000 {
            let r = rng.uniform_in(NEAR_IN_EDGES, 2.0 * NEAR_IN_EDGES) * edge;
            let place: [f64; 3] = (rng.unit_vector() * r).into();
            let (expanded, slow) = (
                expanded_solid_angle(place, 1.0 / r, edge),
                slow_solid_angle(place, edge),
            );
            let whole = (edge / r).powi(2);
            assert!(
                (expanded - slow).abs() < 2e-4 * whole,
                "{place:?}: {expanded} {slow}"
            );
        }
    }

    /// Flux through a square, by many points.
    fn slow_flux(edge: &EdgePlace, source: &Source) -> f64 {
        let n = 200;
        let coordinate = |index: usize| edge.length * ((index as f64 + 0.5) / n as f64 - 0.5);
        let mut sum = 0.0;
        for code in 0..n * n {
            let mut offset = edge.middle - source.place;
            offset[(edge.axis + 1) % 3] += coordinate(code % n);
            offset[(edge.axis + 2) % 3] += coordinate(code / n);
            sum += offset[edge.axis] / offset.norm().powi(3);
        }
        source.strength * sum * (edge.length / n as f64).powi(2)
    }

    #[test]
    fn one_charge_has_its_potential_slope_and_flux() {
        let mut rng = CounterRng::new(62, 0, 0);
        for turn in 0..90 {
            let reach = [1.5, 4.0, 8.0][turn / 30];
            let charge = source(rng.vector_in_ball(reach), 1.3);
            let edge = EdgePlace {
                middle: Vec3::new(0.1, -0.2, 0.3),
                axis: turn % 3,
                length: 0.7,
                offset: rng.uniform_in(-0.35, 0.35),
            };
            let charges = EdgeCharges::new(vec![charge], Vec3::new(1.0, -3.0, 2.0));
            let potential = charges.value_at(&edge);
            let mut offset = edge.middle - charge.place;
            let r = offset.norm();
            let whole = 1.3 * (edge.length / r).powi(2);
            assert!((potential.flux - slow_flux(&edge, &charge)).abs() < 1e-3 * whole);
            offset[edge.axis] += edge.offset;
            let value = 1.3 / offset.norm();
            let slope = -1.3 * offset[edge.axis] / offset.norm().powi(3);
            assert!(
                (potential.value - value).abs() < 1e-5 * 1.3 / r,
                "{r}: {potential:?}"
            );
            assert!(
                (potential.slope - slope).abs() < 4e-4 * 1.3 / (r * r),
                "{r}: {potential:?}"
            );
            assert_eq!(potential, charges.value_at_any(&edge));
        }
    }

    #[test]
    fn many_charges_are_the_sum_of_each() {
        let mut rng = CounterRng::new(63, 0, 0);
        for count in [0, 1, 15, 16, 45, 2000] {
            let charges: Vec<Source> = (0..count)
                .map(|_| source(rng.vector_in_ball(20.0), rng.uniform_in(-1.0, 1.0)))
                .collect();
            let together = EdgeCharges::new(charges.clone(), Vec3::new(8.0, 0.0, -4.0));
            for turn in 0..20 {
                let edge = EdgePlace {
                    middle: Vec3::new(10.0, 0.0, 0.0) + rng.vector_in_ball(8.0),
                    axis: turn % 3,
                    length: 1.0,
                    offset: rng.uniform_in(-0.5, 0.5),
                };
                let (mut slow, mut scale) = (AtEdge::default(), 1e-300);
                for charge in &charges {
                    edge.add(charge, &mut slow);
                    scale += charge.strength.abs() / (edge.middle - charge.place).norm();
                }
                let fast = together.value_at(&edge);
                assert!(
                    (fast.value - slow.value).abs() < 1e-6 * scale,
                    "{fast:?} {slow:?}"
                );
                assert!(
                    (fast.slope - slow.slope).abs() < 3e-6 * scale,
                    "{fast:?} {slow:?}"
                );
                assert!(
                    (fast.flux - slow.flux).abs() < 1e-6 * scale,
                    "{fast:?} {slow:?}"
                );
                assert_eq!(fast, together.value_at_any(&edge));
            }
        }
    }
}
