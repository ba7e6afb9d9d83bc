//! The square that stands for a body: seen along its symmetry axis, how large it is, how it is
//! turned, how hard to spin, and where its charges are.
//!
//! * The axis is the principal axis of inertia whose other two moments differ least (they are equal
//!   for three-fold symmetry and higher), unless it is given.
//! * The outline is the support function of the mesh, h(φ) = max (x cos φ + y sin φ). Its harmonics
//!   tell the symmetry: the order n from 2 to 8 with the largest |c_n|. The corners are where the
//!   fourth harmonic is largest.
//! * The half-diagonal reaches to the corners (the mean of h there), or makes the square that holds
//!   the outline, or the one of equal area.
//! * The inertia about the axis is that of a solid of uniform density, in units of m l²; it is 1/3
//!   for a square.

use super::settings::LatticeSettings;
use crate::answer::Answer;
use anyhow::{Result, bail};
use protomer_body::Body;
use protomer_crystal::lattice::Square;
use protomer_crystal::lattice::pair::SquareCharge;
use protomer_kernel::Vec3;
use protomer_results::keys::to_toml;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2, TAU};

/// Directions in which the outline is looked at.
const DIRECTIONS: usize = 720;
/// Orders of symmetry that are told apart.
const HIGHEST_ORDER: usize = 8;

/// What the half-diagonal is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Size {
    /// The reach of the outline at the corners.
    Corners,
    /// Of the smallest square that holds the outline.
    Outside,
    /// Of the square with the area of the outline.
    Area,
}

/// The axis to look along.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// Found from the moments of inertia.
    Auto,
    /// The body's x axis.
    X,
    /// The body's y axis.
    Y,
    /// The body's z axis.
    Z,
}

/// A body as a square.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodySquare {
    /// Name of the body.
    pub body: String,
    /// The axis, a unit vector in the frame of the body.
    pub axis: [f64; 3],
    /// Relative difference of the moments of inertia about the two other principal axes: 0 for
    /// symmetry.
    pub moments_differ: f64,
    /// Order of the symmetry that the outline shows most.
    pub symmetry_order: usize,
    /// How much the outline changes when it is turned by 90° (root mean square, in parts of its
    /// mean radius).
    pub deviation_from_fourfold: f64,
    /// From the centre to a corner, Å, as chosen.
    pub half_diagonal_angstrom: f64,
    /// What was chosen.
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
    /// The charges, gathered by sign in the four quarters between the sides' normals, in units of
    /// l, corner 2 at 45°.
    pub charges: Vec<SquareCharge>,
}

/// The square of a body.
///
/// # Errors
/// If the body has no extent across the axis.
pub fn square_of_body(body: &Body, axis: Axis, size: Size) -> Result<BodySquare> {
    let (axis, moments_differ) = choose_axis(body, axis);
    let [across, along] = plane(&axis);
    let centre = body.mass_properties.centroid;
    let flat = |point: &Vec3| {
        let from_centre = point - centre;
        [from_centre.dot(&across), from_centre.dot(&along)]
    };
    let points: Vec<[f64; 2]> = body.mesh.vertices.iter().map(flat).collect();
    let reach = |angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        points
            .iter()
            .map(|[x, y]| x * cosine + y * sine)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let outline: Vec<f64> = (0..DIRECTIONS)
        .map(|k| reach(TAU * k as f64 / DIRECTIONS as f64))
        .collect();
    let mean = outline.iter().sum::<f64>() / DIRECTIONS as f64;
    if !(mean.is_finite() && mean > 0.0) {
        bail!(
            "the body {} has no extent across the axis; give another with --axis",
            body.name
        );
    }
    let harmonic = |order: usize| {
        let sums = outline
            .iter()
            .enumerate()
            .fold([0.0; 2], |[re, im], (k, h)| {
                let (sine, cosine) = (TAU * (order * k) as f64 / DIRECTIONS as f64).sin_cos();
                [re + h * cosine, im + h * sine]
            });
        (
            sums[0].hypot(sums[1]) / DIRECTIONS as f64,
            sums[1].atan2(sums[0]) / order as f64,
        )
    };
    let strongest = (2..=HIGHEST_ORDER)
        .max_by(|a, b| harmonic(*a).0.total_cmp(&harmonic(*b).0))
        .unwrap_or(4);
    let quarter = DIRECTIONS / 4;
    let turned = (0..DIRECTIONS)
        .map(|k| (outline[k] - outline[(k + quarter) % DIRECTIONS]).powi(2))
        .sum::<f64>();
    let corner = harmonic(4).1;
    let at_corners = (0..4)
        .map(|k| reach(corner + FRAC_PI_2 * f64::from(k)))
        .sum::<f64>()
        / 4.0;
    let at_sides = (0..4)
        .map(|k| reach(corner + FRAC_PI_4 + FRAC_PI_2 * f64::from(k)))
        .fold(0.0, f64::max);
    let equal_area = (0.5 * hull_area(&outline)).sqrt();
    let half_diagonal = match size {
        Size::Corners => at_corners,
        Size::Outside => SQRT_2 * at_sides,
        Size::Area => equal_area,
    };
    let heights: Vec<f64> = body
        .mesh
        .vertices
        .iter()
        .map(|vertex| vertex.dot(&axis))
        .collect();
    let height = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        - heights.iter().copied().fold(f64::INFINITY, f64::min);
    let moment = axis.dot(&(body.mass_properties.inertia_angstrom5 * axis))
        / body.mass_properties.volume_angstrom3;
    let sites = body
        .sites
        .iter()
        .map(|site| (flat(&site.position), site.charge_e));
    Ok(BodySquare {
        body: body.name.clone(),
        axis: axis.into(),
        moments_differ,
        symmetry_order: strongest,
        deviation_from_fourfold: (turned / DIRECTIONS as f64).sqrt() / mean,
        half_diagonal_angstrom: half_diagonal,
        size,
        corner_reach_angstrom: at_corners,
        outside_half_diagonal_angstrom: SQRT_2 * at_sides,
        equal_area_half_diagonal_angstrom: equal_area,
        height_angstrom: height,
        inertia: moment / (half_diagonal * half_diagonal),
        net_charge_e: body.net_charge_e(),
        charges: gather(sites, corner - FRAC_PI_4, half_diagonal),
    })
}

/// The axis and the relative difference of the two moments across it.
fn choose_axis(body: &Body, axis: Axis) -> (Vec3, f64) {
    let inertia = body.mass_properties.inertia_angstrom5;
    let eigen = inertia.symmetric_eigen();
    let difference = |k: usize| {
        let (a, b) = (
            eigen.eigenvalues[(k + 1) % 3],
            eigen.eigenvalues[(k + 2) % 3],
        );
        2.0 * (a - b).abs() / (a + b)
    };
    let given = |axis: Vec3| {
        let [across, along] = plane(&axis);
        let (a, b, c) = (
            across.dot(&(inertia * across)),
            along.dot(&(inertia * along)),
            across.dot(&(inertia * along)),
        );
        (axis, 2.0 * (a - b).hypot(2.0 * c) / (a + b))
    };
    match axis {
        Axis::X => given(Vec3::x()),
        Axis::Y => given(Vec3::y()),
        Axis::Z => given(Vec3::z()),
        Axis::Auto => {
            let best = (0..3)
                .min_by(|a, b| difference(*a).total_cmp(&difference(*b)))
                .unwrap_or(2);
            let axis: Vec3 = eigen.eigenvectors.column(best).into_owned();
            // Of the two directions, the one that points along the largest component.
            let sign = axis[axis.iamax()].signum();
            (axis * sign, difference(best))
        }
    }
}

/// Two unit vectors across the axis, right-handed with it.
fn plane(axis: &Vec3) -> [Vec3; 2] {
    let mut helper = Vec3::zeros();
    helper[axis.iamin()] = 1.0;
    // For the z axis these are x and y.
    let across = (helper - axis * axis.dot(&helper)).normalize();
    [across, axis.cross(&across)]
}

/// Area of the convex shape with this support function, ½ ∮ h (h + h'') dφ = ½ ∮ (h² - h'²) dφ.
fn hull_area(support: &[f64]) -> f64 {
    let step = TAU / support.len() as f64;
    let next = support.iter().skip(1).chain(support.first());
    let terms = support
        .iter()
        .zip(next)
        .map(|(a, b)| 0.5 * (a * a + b * b) - ((b - a) / step).powi(2));
    0.5 * step * terms.sum::<f64>()
}

/// Charges of each sign in each quarter, at their mean place. The square at θ = 0 has its sides
/// along x and y.
fn gather(
    sites: impl Iterator<Item = ([f64; 2], f64)>,
    turn: f64,
    half_diagonal: f64,
) -> Vec<SquareCharge> {
    let (sine, cosine) = turn.sin_cos();
    let mut sums = [[0.0; 3]; 8];
    for ([x, y], charge) in sites.filter(|(_, charge)| *charge != 0.0) {
        let (x, y) = (x * cosine + y * sine, y * cosine - x * sine);
        let quarter = match (x >= 0.0, y >= 0.0) {
            (true, true) => 0,
            (false, true) => 1,
            (false, false) => 2,
            (true, false) => 3,
        };
        let sum = &mut sums[2 * quarter + usize::from(charge < 0.0)];
        for (sum, term) in sum.iter_mut().zip([charge * x, charge * y, charge]) {
            *sum += term;
        }
    }
    let present = sums.iter().filter(|sum| sum[2] != 0.0);
    let charge = |[x, y, charge]: &[f64; 3]| SquareCharge {
        position: [x / charge / half_diagonal, y / charge / half_diagonal],
        charge: *charge,
    };
    present.map(charge).collect()
}

impl BodySquare {
    /// The part of a configuration that stands for the body.
    ///
    /// # Errors
    /// If it cannot be written down.
    pub fn to_toml(&self) -> Result<String> {
        let settings = LatticeSettings {
            half_diagonal_angstrom: Some(self.half_diagonal_angstrom),
            square: Square {
                inertia: self.inertia,
                ..Square::default()
            },
            charges: self.charges.clone(),
            ..LatticeSettings::default()
        };
        let whole: toml::Table = toml::from_str(&to_toml("the settings", &settings)?)?;
        let wanted = ["half_diagonal_angstrom", "square", "charges"];
        let part: toml::Table = whole
            .into_iter()
            .filter(|(key, _)| wanted.contains(&key.as_str()))
            .collect();
        Ok(format!(
            "# {}, {}\n{}",
            self.body,
            self.text(),
            toml::to_string_pretty(&part)?
        ))
    }
}

impl Answer for BodySquare {
    fn text(&self) -> String {
        let [x, y, z] = self.axis;
        format!(
            "axis ({x:.3}, {y:.3}, {z:.3}), outline most {}-fold, {:.1} % off four-fold, half-diagonal {:.2} Å, inertia \
             {:.4} m l², net charge {:+.2} e",
            self.symmetry_order,
            100.0 * self.deviation_from_fourfold,
            self.half_diagonal_angstrom,
            self.inertia,
            self.net_charge_e
        )
    }
}
