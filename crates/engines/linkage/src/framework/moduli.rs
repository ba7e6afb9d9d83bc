//! Young's and shear moduli and Poisson's ratios.
//!
//! From the compliance S = C⁻¹: E_i = 1/S_ii, ν_ij = -S_ji/S_ii, G_ij = 1/S of that shear (eq. 12
//! of the paper). Off the axes, a tensile stress along n costs s = nᵢnⱼnₖnₗ S_ijkl: E(n) = 1/s, and
//! the strain across it gives ν.

use super::elastic::{Elasticity, Mechanism};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::Serialize;

/// Moduli on the axes, GPa. They are absent where a mechanism leaves nothing to resist the load. A
/// single mechanism says how the network yields, and so what Poisson's ratio is.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, Moduli, build::rotating_squares};
/// // Without hinges rotating squares open and close freely, alike in both directions.
/// let moduli = Moduli::new(&Elasticity::from_framework(&rotating_squares(2.0, 0.3, 100.0, 0.0)?)?, 1.0);
/// assert_eq!(moduli.youngs_gpa[0], None);
/// assert!((moduli.poissons[0][1].unwrap() + 1.0).abs() < 1e-9);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
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

/// Response of a network to uniaxial and shear loads, with or without mechanisms.
struct Answers<'a> {
    /// Strain per stress; where there are mechanisms, without their part.
    compliance: DMatrix<f64>,
    mechanisms: &'a [Mechanism],
}

/// The answer to one load.
struct Answer {
    /// Strain along the load per stress; absent where a mechanism yields.
    give: Option<f64>,
    /// Minus the strain across the load over the strain along it; absent where mechanisms
    /// leave it undetermined.
    poissons: Option<f64>,
}

/// Strains below this, of a mechanism whose largest is one, are rounding.
const NOTHING: f64 = 1e-9;

impl<'a> Answers<'a> {
    fn new(elasticity: &'a Elasticity) -> Self {
        let mechanisms = &elasticity.mechanisms[..];
        let compliance = elasticity
            .compliance()
            .unwrap_or_else(|| pseudo_inverse(&elasticity.stiffness, mechanisms.len()));
        Self {
            compliance,
            mechanisms,
        }
    }

    /// The answer to a stress, where `projection` projects a strain onto the other direction of
    /// interest.
    fn answer(&self, stress: &[f64], projection: &[f64]) -> Answer {
        if self.drives_a_mechanism(stress) {
            let poissons = match self.mechanisms {
                [one] => Some(-product(projection, &one.strain) / product(stress, &one.strain)),
                _ => None,
            };
            return Answer {
                give: None,
                poissons,
            };
        }
        let strain = &self.compliance * DVector::from_column_slice(stress);
        let give = product(stress, strain.as_slice());
        let is_decided = !self.drives_a_mechanism(projection);
        Answer {
            give: Some(give),
            poissons: is_decided.then(|| -product(projection, strain.as_slice()) / give),
        }
    }

    /// Whether a stress does work on a mechanism.
    fn drives_a_mechanism(&self, stress: &[f64]) -> bool {
        let mut works = self
            .mechanisms
            .iter()
            .map(|one| product(stress, &one.strain));
        works.any(|work| work.abs() > NOTHING)
    }
}

/// The inverse without the softest strains, as many as there are mechanisms.
fn pseudo_inverse(stiffness: &DMatrix<f64>, mechanisms: usize) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(stiffness.clone());
    let values = &eigen.eigenvalues;
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut inverse = DVector::zeros(order.len());
    for index in order.into_iter().skip(mechanisms) {
        inverse[index] = 1.0 / values[index];
    }
    &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Moduli {
    /// The moduli of a network; `gpa` is what one kcal/mol/Å³ is worth.
    pub fn new(elasticity: &Elasticity, gpa: f64) -> Self {
        let (dimension, strains) = (elasticity.dimension, elasticity.stiffness.nrows());
        let answers = Answers::new(elasticity);
        let answer = |i: usize, j: usize| answers.answer(&unit(strains, i), &unit(strains, j));
        let modulus = |i: usize| answer(i, i).give.map(|give| gpa / give);
        let mut poissons = vec![vec![None; dimension]; dimension];
        for (i, row) in poissons.iter_mut().enumerate() {
            for (j, ratio) in row.iter_mut().enumerate() {
                *ratio = if i == j { None } else { answer(i, j).poissons };
            }
        }
        Self {
            youngs_gpa: (0..dimension).map(modulus).collect(),
            poissons,
            shear_gpa: (dimension..strains).map(modulus).collect(),
        }
    }
}

fn unit(length: usize, index: usize) -> Vec<f64> {
    let mut unit = vec![0.0; length];
    unit[index] = 1.0;
    unit
}

/// E and ν of a two-dimensional network against the direction of the load, `count` directions over
/// half a turn; none in three dimensions.
pub fn polar(elasticity: &Elasticity, gpa: f64, count: usize) -> Vec<Direction> {
    let mut directions = Vec::with_capacity(count);
    if elasticity.dimension != 2 {
        return directions;
    }
    let answers = Answers::new(elasticity);
    for index in 0..count {
        let angle_deg = 180.0 * index as f64 / count as f64;
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        // n n, and its counterpart across; the shear counts half of an engineering strain, twice.
        let stress = [cosine * cosine, sine * sine, sine * cosine];
        let projection = [sine * sine, cosine * cosine, -sine * cosine];
        let answer = answers.answer(&stress, &projection);
        directions.push(Direction {
            angle_deg,
            youngs_gpa: answer.give.map(|give| gpa / give),
            poissons: answer.poissons,
        });
    }
    directions
}
