//! Young's and shear moduli and Poisson's ratios.
//!
//! From the compliance S = C⁻¹: E_i = 1/S_ii, ν_ij = -S_ji/S_ii, G_ij = 1/S of that shear (eq. 12
//! of the paper). Off the axes, a tensile stress along n costs s = nᵢnⱼnₖnₗ S_ijkl: E(n) = 1/s, and
//! the strain across it gives ν.

use super::elastic::{Elasticity, Mechanism};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::Serialize;

/// Moduli on the axes, GPa. They are absent where a mechanism leaves nothing to resist the load. If
/// it is the only one, it says how the network yields, and so what Poisson's ratio is.
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

/// How a network answers to uniaxial and shear loads, mechanisms or not.
struct Answers<'a> {
    /// Strain per stress; where there are mechanisms, that part of it which does not contain them.
    compliance: DMatrix<f64>,
    mechanisms: &'a [Mechanism],
}

/// The answer to one load.
struct Answer {
    /// Strain along the load per stress; absent where it has no end.
    give: Option<f64>,
    /// Minus the strain across over that along; absent where that depends on a mechanism that
    /// nothing decides.
    poissons: Option<f64>,
}

/// Strains below this, of a mechanism whose largest is one, are rounding.
const NOTHING: f64 = 1e-9;

impl<'a> Answers<'a> {
    fn new(elasticity: &'a Elasticity) -> Self {
        let mechanisms = &elasticity.mechanisms[..];
        let compliance = elasticity.compliance().unwrap_or_else(|| {
            let eigen = SymmetricEigen::new(elasticity.stiffness.clone());
            let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
            order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
            let mut inverse = DVector::zeros(order.len());
            for index in order.into_iter().skip(mechanisms.len()) {
                inverse[index] = 1.0 / eigen.eigenvalues[index];
            }
            &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
        });
        Self {
            compliance,
            mechanisms,
        }
    }

    /// The answer to a stress, where `across` projects a strain onto the other direction of
    /// interest.
    fn to(&self, stress: &[f64], across: &[f64]) -> Answer {
        let project =
            |onto: &[f64], strain: &[f64]| onto.iter().zip(strain).map(|(a, b)| a * b).sum::<f64>();
        // The work that the load does on a mechanism.
        let driven = self
            .mechanisms
            .iter()
            .any(|mechanism| project(stress, &mechanism.strain).abs() > NOTHING);
        if driven {
            let poissons = match self.mechanisms {
                [one] => Some(-project(across, &one.strain) / project(stress, &one.strain)),
                _ => None,
            };
            return Answer {
                give: None,
                poissons,
            };
        }
        let strain = &self.compliance * DVector::from_column_slice(stress);
        let give = project(stress, strain.as_slice());
        let decided = self
            .mechanisms
            .iter()
            .all(|mechanism| project(across, &mechanism.strain).abs() <= NOTHING);
        Answer {
            give: Some(give),
            poissons: decided.then(|| -project(across, strain.as_slice()) / give),
        }
    }
}

impl Moduli {
    /// The moduli of a network; `gpa` is what one kcal/mol/Å³ is worth.
    pub fn new(elasticity: &Elasticity, gpa: f64) -> Self {
        let (d, strains) = (elasticity.dimension, elasticity.stiffness.nrows());
        let answers = Answers::new(elasticity);
        let unit = |index: usize| -> Vec<f64> {
            (0..strains)
                .map(|i| if i == index { 1.0 } else { 0.0 })
                .collect()
        };
        let answer = |i: usize, j: usize| answers.to(&unit(i), &unit(j));
        let modulus = |i: usize| answer(i, i).give.map(|give| gpa / give);
        let ratio = |i: usize, j: usize| if i == j { None } else { answer(i, j).poissons };
        Self {
            youngs_gpa: (0..d).map(modulus).collect(),
            poissons: (0..d)
                .map(|i| (0..d).map(|j| ratio(i, j)).collect())
                .collect(),
            shear_gpa: (d..strains).map(modulus).collect(),
        }
    }
}

/// E and ν of a two-dimensional network against the direction of the load, `count` directions over
/// half a turn.
pub fn polar(elasticity: &Elasticity, gpa: f64, count: usize) -> Vec<Direction> {
    let answers = Answers::new(elasticity);
    let at = |index: usize| {
        let angle_deg = 180.0 * index as f64 / count as f64;
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        // n n, and its counterpart across; the shear counts half of an engineering strain, twice.
        let along = [cosine * cosine, sine * sine, sine * cosine];
        let across = [sine * sine, cosine * cosine, -sine * cosine];
        let answer = answers.to(&along, &across);
        Direction {
            angle_deg,
            youngs_gpa: answer.give.map(|give| gpa / give),
            poissons: answer.poissons,
        }
    };
    if elasticity.dimension == 2 {
        (0..count).map(at).collect()
    } else {
        Vec::new()
    }
}
