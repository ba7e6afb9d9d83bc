//! Young's and shear moduli and Poisson's ratios.
//!
//! From the compliance S = C⁻¹: E_i = 1/S_ii, ν_ij = -S_ji/S_ii, G_ij = 1/S of that shear (eq. 12 of the paper). Off the
//! axes, a tensile stress along n costs s = nᵢnⱼnₖnₗ S_ijkl: E(n) = 1/s, and the strain across it gives ν.

use super::elastic::{Elasticity, Mechanism};
use nalgebra::DMatrix;
use serde::Serialize;

/// Moduli on the axes, GPa. Where a mechanism leaves nothing to resist a load they are absent, and the mechanism says how
/// the network yields.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Moduli {
    /// E along each axis: (y, z) or (x, y, z).
    pub youngs_gpa: Vec<Option<f64>>,
    /// ν_ij of loading along i, strain along j, by rows i.
    pub poissons: Vec<Vec<Option<f64>>>,
    /// G of each shear: (yz) or (yz, xz, xy).
    pub shear_gpa: Vec<Option<f64>>,
}

/// E and ν in one direction of the plane of y and z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Direction {
    /// Angle of the load from the first axis (y), degrees.
    pub angle_deg: f64,
    /// E, GPa.
    pub youngs_gpa: Option<f64>,
    /// Minus the strain across the load over the strain along it, in the plane.
    pub poissons: Option<f64>,
}

impl Moduli {
    /// The moduli of a network; `gpa` is what one kcal/mol/Å³ is worth.
    pub fn new(elasticity: &Elasticity, gpa: f64) -> Self {
        let d = elasticity.dimension;
        let compliance = elasticity.compliance();
        let of = |value: &dyn Fn(&DMatrix<f64>) -> f64| compliance.as_ref().map(value);
        let poisson = |i: usize, j: usize| match (&compliance, &elasticity.mechanisms[..]) {
            (Some(s), _) => Some(-s[(j, i)] / s[(i, i)]),
            // A single mechanism is how the network yields to any load that drives it.
            (None, [Mechanism { strain, .. }]) if strain[i] != 0.0 => Some(-strain[j] / strain[i]),
            _ => None,
        };
        Self {
            youngs_gpa: (0..d).map(|i| of(&|s| gpa / s[(i, i)])).collect(),
            poissons: (0..d).map(|i| (0..d).map(|j| if i == j { None } else { poisson(i, j) }).collect()).collect(),
            shear_gpa: (d..elasticity.stiffness.nrows()).map(|i| of(&|s| gpa / s[(i, i)])).collect(),
        }
    }
}

/// E and ν of a two-dimensional network against the direction of the load, `count` directions over half a turn.
pub fn polar(elasticity: &Elasticity, gpa: f64, count: usize) -> Vec<Direction> {
    let compliance = elasticity.compliance();
    let at = |index: usize| {
        let angle_deg = 180.0 * index as f64 / count as f64;
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        // n n as strain components, shear as engineering strain, and its counterpart across.
        let along = [cosine * cosine, sine * sine, 2.0 * sine * cosine];
        let across = [sine * sine, cosine * cosine, -2.0 * sine * cosine];
        let stress = [along[0], along[1], sine * cosine];
        let direction = |strain: &dyn Fn(usize) -> f64| {
            let project = |onto: &[f64; 3]| onto[0] * strain(0) + onto[1] * strain(1) + 0.5 * onto[2] * strain(2);
            (project(&along), project(&across))
        };
        match &compliance {
            Some(s) => {
                let (e, t) = direction(&|i| (0..3).map(|j| s[(i, j)] * stress[j]).sum());
                Direction { angle_deg, youngs_gpa: Some(gpa / e), poissons: Some(-t / e) }
            }
            None => {
                let poissons = match &elasticity.mechanisms[..] {
                    [mechanism] => {
                        let (e, t) = direction(&|i| mechanism.strain[i]);
                        (e.abs() > 1e-9).then(|| -t / e)
                    }
                    _ => None,
                };
                Direction { angle_deg, youngs_gpa: None, poissons }
            }
        }
    };
    if elasticity.dimension == 2 { (0..count).map(at).collect() } else { Vec::new() }
}
