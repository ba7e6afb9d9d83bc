//! The square that stands for a body: seen along its symmetry axis, how large it is, how it is
//! turned, how hard to spin, and where its charges are.
//!
//! * The axis is the principal axis of inertia whose other two moments differ least (they are equal
//!   for three-fold symmetry and higher), unless it is given.
//! * The outline is the support function of the mesh, h(φ) = max (x cos φ + y sin φ). Its harmonics
//!   tell the symmetry: the order n from 2 to 8 with the largest |c_n|. The corners are where the
//!   fourth harmonic is largest.
//! * The half-diagonal reaches to the corners (the mean of h there), or is that of the square that
//!   holds the outline, or that of the square of equal area.
//! * The inertia about the axis is that of a solid of uniform density, in units of m l²; it is 1/3
//!   for a square.
//! * The charges are those of the body on the sites of a square grid, see `Sites` below.

use super::pair::SquareCharge;
use crate::plane::{Vector, direction, dot};
use crate::{CrystalError, Result};
use protomer_kernel::Vec3;
use protomer_kernel::mesh::{MassProperties, TriangleMesh};
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2, TAU};

/// Directions in which the outline is measured.
const DIRECTIONS: usize = 720;
/// Orders of symmetry that are told apart.
const HIGHEST_ORDER: usize = 8;
/// Sites are at most this far apart, Å.
const SITE_SPACING_ANGSTROM: f64 = 6.0;
/// Sites stay this far inside the sides, Å, or at half the way to the centre of a very small square:
/// where corners meet, charges of neighbours are as far apart as atoms in contact.
const INSET_ANGSTROM: f64 = 2.0;
/// Sites along an axis on which a charge is placed.
const STENCIL: usize = 4;

protomer_kernel::choices! {
    /// Measure of the outline from which the half-diagonal is taken.
    pub enum Size {
        /// The distance from the centre to the outline at the corners.
        Corners = "corners",
        /// Half-diagonal of the smallest square that contains the outline.
        Outside = "outside",
        /// Half-diagonal of the square with the area of the outline.
        Area = "area",
    }
}

protomer_kernel::choices! {
    /// Axis of projection.
    pub enum Axis {
        /// The axis found from the moments of inertia.
        Auto = "auto",
        /// The body's x axis.
        X = "x",
        /// The body's y axis.
        Y = "y",
        /// The body's z axis.
        Z = "z",
    }
}

/// A body as the solid inside a mesh, with point charges.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    /// The surface, Å.
    pub mesh: &'a TriangleMesh,
    /// Mass properties of the mesh.
    pub mass_properties: &'a MassProperties,
    /// Places (Å) and charges (e).
    pub charges: &'a [(Vec3, f64)],
}

/// A body as a square.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodySquare {
    /// The axis, a unit vector in the frame of the body.
    pub axis: [f64; 3],
    /// Relative difference of the moments of inertia about the two other principal axes: 0 for
    /// symmetry.
    pub moments_differ: f64,
    /// Order of the symmetry that the outline shows most.
    pub symmetry_order: usize,
    /// Change of the outline when it is turned by 90° (root mean square, in parts of its mean
    /// radius).
    pub deviation_from_fourfold: f64,
    /// Direction from the centre to corner 2, a unit vector in the frame of the body.
    pub corner: [f64; 3],
    /// Distance from the centre to a corner, Å, as chosen.
    pub half_diagonal_angstrom: f64,
    /// Measure from which the half-diagonal was taken.
    pub size: Size,
    /// The reach of the outline at the corners, Å.
    pub corner_reach_angstrom: f64,
    /// Half-diagonal of the smallest square that holds the outline, Å.
    pub outside_half_diagonal_angstrom: f64,
    /// Half-diagonal of the square with the area of the outline (its convex hull), Å.
    pub equal_area_half_diagonal_angstrom: f64,
    /// Extent along the axis, Å.
    pub height_angstrom: f64,
    /// Moment of inertia about the axis in units of m l².
    pub inertia: f64,
    /// Net charge, e.
    pub net_charge_e: f64,
    /// The net charges of the sites, places in units of l, corner 2 at 45°.
    pub charges: Vec<SquareCharge>,
    /// Charges of the body that stand out of the square and were moved to its outermost sites.
    pub moved: MovedCharges,
}

/// Count of the charges that stand out of a square and were moved.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct MovedCharges {
    /// Number of charges moved.
    pub count: usize,
    /// Number of all charges.
    pub out_of: usize,
    /// Sum of the positive charges moved, e.
    pub positive_e: f64,
    /// Sum of the negative charges moved, e.
    pub negative_e: f64,
    /// Farthest distance by which a charge was moved, Å.
    pub farthest_angstrom: f64,
}

impl BodySquare {
    /// The square of a body.
    ///
    /// ```
    /// use protomer_linkage::lattice::square_of_body::{Axis, BodySquare, Size, Solid};
    /// use protomer_kernel::{Vec3, mesh::TriangleMesh};
    /// // A cube with an edge of 10 Å.
    /// let mesh = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(10.0));
    /// let mass_properties = mesh.mass_properties()?;
    /// let cube = Solid { mesh: &mesh, mass_properties: &mass_properties, charges: &[] };
    /// let square = BodySquare::from_solid(&cube, Axis::Z, Size::Corners)?;
    /// assert!((square.half_diagonal_angstrom - 50f64.sqrt()).abs() < 1e-9);
    /// assert!((square.inertia - 1.0 / 3.0).abs() < 1e-9 && square.symmetry_order == 4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadState`] if the body has no extent across the axis.
    pub fn from_solid(solid: &Solid, axis: Axis, size: Size) -> Result<Self> {
        let (axis, moments_differ) = choose_axis(solid, axis);
        let view = View::from_axis(solid, axis);
        let outline = Outline::from_solid(solid, &view);
        let mean = outline.mean();
        if !(mean.is_finite() && mean > 0.0) {
            return Err(CrystalError::BadState(
                "the body has no extent across the axis; choose another axis".into(),
            ));
        }
        let corner = outline.harmonic(4).angle;
        let corner_reach_angstrom = outline.mean_reach_at_corners(corner);
        let outside_half_diagonal_angstrom = SQRT_2 * outline.farthest_side(corner);
        let equal_area_half_diagonal_angstrom = (0.5 * outline.hull_area()).sqrt();
        let half_diagonal_angstrom = match size {
            Size::Corners => corner_reach_angstrom,
            Size::Outside => outside_half_diagonal_angstrom,
            Size::Area => equal_area_half_diagonal_angstrom,
        };
        let turn = direction(corner - FRAC_PI_4);
        let mut sites = Sites::within(half_diagonal_angstrom);
        for (place, charge) in solid.charges.iter().filter(|(_, charge)| *charge != 0.0) {
            sites.add(turned_back(view.flatten(place), turn), *charge);
        }
        Ok(Self {
            axis: axis.into(),
            moments_differ,
            symmetry_order: outline.strongest_order(),
            deviation_from_fourfold: outline.change_by_quarter_turn() / mean,
            corner: view.direction(corner).into(),
            half_diagonal_angstrom,
            size,
            corner_reach_angstrom,
            outside_half_diagonal_angstrom,
            equal_area_half_diagonal_angstrom,
            height_angstrom: height(solid, &axis),
            inertia: moment_about(solid, &axis) / (half_diagonal_angstrom * half_diagonal_angstrom),
            net_charge_e: solid.charges.iter().map(|(_, charge)| charge).sum(),
            charges: sites.charges(half_diagonal_angstrom),
            moved: sites.moved_charges,
        })
    }
}

/// The axis and the relative difference of the two moments across it.
fn choose_axis(solid: &Solid, axis: Axis) -> (Vec3, f64) {
    let given = match axis {
        Axis::X => Vec3::x(),
        Axis::Y => Vec3::y(),
        Axis::Z => Vec3::z(),
        Axis::Auto => return principal_axis(solid),
    };
    let inertia = solid.mass_properties.inertia_angstrom5;
    let [first, second] = plane_across(&given);
    let (a, b) = (
        first.dot(&(inertia * first)),
        second.dot(&(inertia * second)),
    );
    let c = first.dot(&(inertia * second));
    (given, 2.0 * (a - b).hypot(2.0 * c) / (a + b))
}

/// The principal axis whose other two moments differ least.
fn principal_axis(solid: &Solid) -> (Vec3, f64) {
    let eigen = solid.mass_properties.inertia_angstrom5.symmetric_eigen();
    let (mut best, mut least) = (2, f64::INFINITY);
    for axis in 0..3 {
        let a = eigen.eigenvalues[(axis + 1) % 3];
        let b = eigen.eigenvalues[(axis + 2) % 3];
        let difference = 2.0 * (a - b).abs() / (a + b);
        if difference < least {
            (best, least) = (axis, difference);
        }
    }
    let axis: Vec3 = eigen.eigenvectors.column(best).into_owned();
    // Of the two directions, the one that points along the largest component.
    let sign = axis[axis.iamax()].signum();
    (axis * sign, least)
}

/// Two unit vectors across the axis, right-handed with it.
fn plane_across(axis: &Vec3) -> [Vec3; 2] {
    let mut helper = Vec3::zeros();
    helper[axis.iamin()] = 1.0;
    // For the z axis these are x and y.
    let perpendicular = (helper - axis * axis.dot(&helper)).normalize();
    [perpendicular, axis.cross(&perpendicular)]
}

fn height(solid: &Solid, axis: &Vec3) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for vertex in &solid.mesh.vertices {
        let place = vertex.dot(axis);
        low = low.min(place);
        high = high.max(place);
    }
    high - low
}

/// The moment of inertia about the axis, over the mass, Å².
fn moment_about(solid: &Solid, axis: &Vec3) -> f64 {
    let inertia = solid.mass_properties.inertia_angstrom5;
    axis.dot(&(inertia * axis)) / solid.mass_properties.volume_angstrom3
}

/// The plane across the axis, through the centre of the body.
struct View {
    centre: Vec3,
    axes: [Vec3; 2],
}

impl View {
    fn from_axis(solid: &Solid, axis: Vec3) -> Self {
        Self {
            centre: solid.mass_properties.centroid,
            axes: plane_across(&axis),
        }
    }

    /// The direction at an angle, in the frame of the body.
    fn direction(&self, angle: f64) -> Vec3 {
        let [cosine, sine] = direction(angle);
        self.axes[0] * cosine + self.axes[1] * sine
    }

    fn flatten(&self, point: &Vec3) -> Vector {
        let from_centre = point - self.centre;
        [
            from_centre.dot(&self.axes[0]),
            from_centre.dot(&self.axes[1]),
        ]
    }
}

/// The support function of a body seen along an axis.
struct Outline {
    points: Vec<Vector>,
    /// h in equally spaced directions.
    support: Vec<f64>,
}

/// |c_n| and the angle at which the harmonic is largest.
struct Harmonic {
    size: f64,
    angle: f64,
}

impl Outline {
    fn from_solid(solid: &Solid, view: &View) -> Self {
        let vertices = &solid.mesh.vertices;
        let mut outline = Self {
            points: vertices.iter().map(|vertex| view.flatten(vertex)).collect(),
            support: Vec::with_capacity(DIRECTIONS),
        };
        for k in 0..DIRECTIONS {
            let reach = outline.reach(TAU * k as f64 / DIRECTIONS as f64);
            outline.support.push(reach);
        }
        outline
    }

    /// Value h of the support function at this angle.
    fn reach(&self, angle: f64) -> f64 {
        let unit_vector = direction(angle);
        let mut reach = f64::NEG_INFINITY;
        for point in &self.points {
            reach = reach.max(dot(*point, unit_vector));
        }
        reach
    }

    fn mean(&self) -> f64 {
        self.support.iter().sum::<f64>() / DIRECTIONS as f64
    }

    fn harmonic(&self, order: usize) -> Harmonic {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, h) in self.support.iter().enumerate() {
            let [cosine, sine] = direction(TAU * (order * k) as f64 / DIRECTIONS as f64);
            re += h * cosine;
            im += h * sine;
        }
        Harmonic {
            size: re.hypot(im) / DIRECTIONS as f64,
            angle: im.atan2(re) / order as f64,
        }
    }

    /// The order with the largest harmonic; the higher one of equals.
    fn strongest_order(&self) -> usize {
        let (mut strongest, mut largest) = (4, f64::NEG_INFINITY);
        for order in 2..=HIGHEST_ORDER {
            let size = self.harmonic(order).size;
            if size >= largest {
                (strongest, largest) = (order, size);
            }
        }
        strongest
    }

    /// Root mean square of h(φ) - h(φ + 90°).
    fn change_by_quarter_turn(&self) -> f64 {
        let mut squares = 0.0;
        for k in 0..DIRECTIONS {
            let rotated = self.support[(k + DIRECTIONS / 4) % DIRECTIONS];
            squares += (self.support[k] - rotated).powi(2);
        }
        (squares / DIRECTIONS as f64).sqrt()
    }

    fn mean_reach_at_corners(&self, corner: f64) -> f64 {
        let mut sum = 0.0;
        for k in 0..4 {
            sum += self.reach(corner + FRAC_PI_2 * f64::from(k));
        }
        sum / 4.0
    }

    fn farthest_side(&self, corner: f64) -> f64 {
        let mut farthest = 0.0_f64;
        for k in 0..4 {
            farthest = farthest.max(self.reach(corner + FRAC_PI_4 + FRAC_PI_2 * f64::from(k)));
        }
        farthest
    }

    /// Area of the convex shape with this support function, ½ ∮ h (h + h'') dφ = ½ ∮ (h² - h'²) dφ.
    fn hull_area(&self) -> f64 {
        let step = TAU / DIRECTIONS as f64;
        let mut sum = 0.0;
        for (k, a) in self.support.iter().enumerate() {
            let b = self.support[(k + 1) % DIRECTIONS];
            sum += 0.5 * (a * a + b * b) - ((b - a) / step).powi(2);
        }
        0.5 * step * sum
    }
}

/// A place in the frame of the square at θ = 0, whose sides are along x and y.
fn turned_back([x, y]: Vector, [cosine, sine]: Vector) -> Vector {
    [x * cosine + y * sine, y * cosine - x * sine]
}

/// The sites of a square: the nodes of a regular grid, on which charges are placed.
///
/// A charge at (x, y) goes to the 4 x 4 sites around it with the weights of cubic interpolation along
/// either axis. Sums of the charges times 1, x, y and all products up to x³ y³ then stay what they
/// were. Positive and negative charges of one place cancel on the sites as they do in the body. At a
/// Debye length of 9.6 Å the potential of a charge is off by 8 % (root mean square over places) 4 Å
/// from the outermost sites, by 3 % at 8 Å and by 1 % at 16 Å. Heights along the axis are lost.
struct Sites {
    /// Place of the outermost sites along either axis, Å.
    reach: f64,
    /// Distance between sites, Å.
    spacing: f64,
    /// Number of sites along an axis.
    count: usize,
    /// Charges, row by row along y, e.
    charges: Vec<f64>,
    moved_charges: MovedCharges,
}

impl Sites {
    fn within(half_diagonal_angstrom: f64) -> Self {
        let half_side = half_diagonal_angstrom / SQRT_2;
        let reach = (half_side - INSET_ANGSTROM).max(0.5 * half_side);
        let intervals = (2.0 * reach / SITE_SPACING_ANGSTROM).ceil() as usize;
        let count = (intervals + 1).max(STENCIL);
        Self {
            reach,
            spacing: 2.0 * reach / (count - 1) as f64,
            count,
            charges: vec![0.0; count * count],
            moved_charges: MovedCharges::default(),
        }
    }

    fn add(&mut self, [x, y]: Vector, charge: f64) {
        let inside = [x, y].map(|place| place.clamp(-self.reach, self.reach));
        self.moved_charges
            .count((x - inside[0]).hypot(y - inside[1]), charge);
        let [(column, weights_x), (row, weights_y)] = inside.map(|place| self.weights(place));
        for (j, weight_y) in weights_y.iter().enumerate() {
            for (i, weight_x) in weights_x.iter().enumerate() {
                self.charges[(row + j) * self.count + column + i] += charge * weight_x * weight_y;
            }
        }
    }

    /// The first of the four sites around a place, and the weights of Lagrange's interpolation.
    fn weights(&self, place: f64) -> (usize, [f64; STENCIL]) {
        let coordinate = (place + self.reach) / self.spacing;
        let last = self.count - STENCIL;
        let first = (coordinate.floor() as usize).saturating_sub(1).min(last);
        let t = coordinate - first as f64;
        let weights = [
            -(t - 1.0) * (t - 2.0) * (t - 3.0) / 6.0,
            t * (t - 2.0) * (t - 3.0) / 2.0,
            -t * (t - 1.0) * (t - 3.0) / 2.0,
            t * (t - 1.0) * (t - 2.0) / 6.0,
        ];
        (first, weights)
    }

    /// The sites with a charge.
    fn charges(&self, half_diagonal_angstrom: f64) -> Vec<SquareCharge> {
        let place =
            |index: usize| (index as f64 * self.spacing - self.reach) / half_diagonal_angstrom;
        let mut charges = Vec::new();
        for (site, charge) in self.charges.iter().enumerate() {
            if *charge != 0.0 {
                charges.push(SquareCharge {
                    position: [place(site % self.count), place(site / self.count)],
                    charge: *charge,
                });
            }
        }
        charges
    }
}

impl MovedCharges {
    fn count(&mut self, distance_angstrom: f64, charge_e: f64) {
        self.out_of += 1;
        if distance_angstrom == 0.0 {
            return;
        }
        self.count += 1;
        self.positive_e += charge_e.max(0.0);
        self.negative_e += charge_e.min(0.0);
        self.farthest_angstrom = self.farthest_angstrom.max(distance_angstrom);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// exp(-κ r)/r of charges at some places, Å.
    fn potential(charges: &[(Vector, f64)], [x, y]: Vector, debye_length: f64) -> f64 {
        let mut sum = 0.0;
        for ([a, b], charge) in charges {
            let distance = (x - a).hypot(y - b);
            sum += charge * (-distance / debye_length).exp() / distance;
        }
        sum
    }

    fn on_sites(charges: &[(Vector, f64)], half_diagonal: f64) -> (Vec<(Vector, f64)>, Sites) {
        let mut sites = Sites::within(half_diagonal);
        for (place, charge) in charges {
            sites.add(*place, *charge);
        }
        let placed = sites.charges(half_diagonal);
        let mut listed = Vec::with_capacity(placed.len());
        for SquareCharge { position, charge } in placed {
            listed.push((position.map(|x| x * half_diagonal), charge));
        }
        (listed, sites)
    }

    /// Four hundred charges of ±1 e with a net charge of +4 e, all over a square with a half-diagonal
    /// of 59 Å, as in a tetramer.
    fn tetramer() -> Vec<(Vector, f64)> {
        let mut rng = CounterRng::new(11, 0, 0);
        let mut charges = Vec::new();
        for index in 0..400 {
            let charge = if index < 202 { 1.0 } else { -1.0 };
            let place = [rng.uniform_in(-39.0, 39.0), rng.uniform_in(-39.0, 39.0)];
            charges.push((place, charge));
        }
        charges
    }

    #[test]
    fn sites_keep_the_net_charge_and_the_dipole_and_make_no_lumps() {
        let charges = tetramer();
        let (sites, _) = on_sites(&charges, 59.2);
        for moment in [
            |_: Vector| 1.0,
            |[x, _]: Vector| x,
            |[_, y]: Vector| y,
            |[x, y]: Vector| x * y,
            |[x, _]: Vector| x * x,
        ] {
            let over = |list: &[(Vector, f64)]| -> f64 {
                list.iter()
                    .map(|(place, charge)| charge * moment(*place))
                    .sum()
            };
            let (fitted, direct) = (over(&charges), over(&sites));
            assert!(
                (fitted - direct).abs() < 1e-8 * (1.0 + fitted.abs()),
                "{fitted} {direct}"
            );
        }
        let largest = sites
            .iter()
            .map(|(_, charge)| charge.abs())
            .fold(0.0, f64::max);
        assert!(largest < 8.0, "{largest}");
    }

    /// The potential next to a square of a charge anywhere near that side, at 100 mM: as stated
    /// above.
    #[test]
    fn the_potential_beside_a_square_is_that_of_its_charges() {
        let mut rng = CounterRng::new(12, 0, 0);
        let side = 59.2 / SQRT_2 - INSET_ANGSTROM;
        for (apart, error) in [(4.0, 0.1), (8.0, 0.04), (16.0, 0.015)] {
            let (mut misses, mut all) = (0.0, 0.0);
            for _ in 0..300 {
                let place = [
                    rng.uniform_in(side - 20.0, side),
                    rng.uniform_in(-20.0, 20.0),
                ];
                let charge = [(place, 1.0)];
                let (sites, _) = on_sites(&charge, 59.2);
                let beside = [side + apart, rng.uniform_in(-20.0, 20.0)];
                let exact = potential(&charge, beside, 9.6);
                misses += (potential(&sites, beside, 9.6) - exact).powi(2);
                all += exact * exact;
            }
            assert!(
                (misses / all).sqrt() < error,
                "{apart}: {}",
                (misses / all).sqrt()
            );
        }
    }

    #[test]
    fn charges_that_stand_out_are_moved_and_counted() {
        let (_, sites) = on_sites(
            &[([60.0, 0.0], 1.0), ([0.0, -45.0], -2.0), ([0.0, 0.0], 1.0)],
            59.2,
        );
        let reach = 59.2 / SQRT_2 - INSET_ANGSTROM;
        let moved = sites.moved_charges;
        assert_eq!((moved.count, moved.out_of), (2, 3));
        assert_eq!((moved.positive_e, moved.negative_e), (1.0, -2.0));
        assert!((moved.farthest_angstrom - (60.0 - reach)).abs() < 1e-12);
        let net: f64 = sites.charges.iter().sum();
        assert!(net.abs() < 1e-12);
    }
}
