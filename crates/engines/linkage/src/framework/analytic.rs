//! The closed formulas for hexagonal honeycombs (eqs. 2 to 8, 16 and 20 of the paper).
//!
//! With X1 = 2 l sin θ and X2 = 2 (h - l cos θ), thickness b, and a rib hinged at both of its ends,
//! K_h = 2 k_h:
//!
//! | | hinging | stretching |
//! |---|---|---|
//! | E1 | K_h X1 / (b l² cos²θ X2) | K_s X1 / (b sin²θ X2) |
//! | E2 | K_h X2 / (b l² sin²θ X1) | K_s X2 / (b (2 + cos²θ) X1) |
//! | ν12 | -tan θ X1/X2 | cot θ X1/X2 |
//! | ν21 | -cot θ X2/X1 | sin θ cos θ X2 / ((2 + cos²θ) X1) |
//! | 1/G12 | 4 b h² l² sin²θ / (K_h X1 X2) | 4 b (h cos θ - l)² / (K_s X1 X2) |
//!
//! The shear modulus is not in the paper. It follows from the balance of moments: under a shear
//! stress τ a vertical rib passes on a force τ b X1 across itself, so each hinge turns under the
//! moment τ b h l sin θ / 2, and an inclined rib is pulled by τ b (h cos θ - l); twice the energy
//! stored in the 8 hinges and 4 inclined ribs of a cell is τ²/G of its volume.
//!
//! A rib's K_s does not depend on its length. The paper's second line of eq. 6 repeats the
//! denominator of the first; loading along 1 stretches only the inclined ribs, so that ν12 = cot θ
//! X1/X2. Where ribs hinge and stretch, compliances add (eqs. 16, 20), which is exact for this model.

use protomer_kernel::null;
use serde::{Deserialize, Serialize};

/// The lengths, angle and stiffnesses of a honeycomb.
///
/// ```
/// use protomer_linkage::framework::analytic::Honeycomb;
/// let regular = Honeycomb {
///     h_angstrom: 1.0,
///     l_angstrom: 1.0,
///     theta_rad: 120_f64.to_radians(),
///     hinge_stiffness_kcal_mol_rad2: 50.0,
///     rod_stiffness_kcal_mol_angstrom2: 10_000.0,
///     thickness_angstrom: 1.0,
/// };
/// // Regular hexagons that hinge keep their area.
/// assert!((regular.hinging(1.0).nu_yz - 1.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Honeycomb {
    /// Length of the vertical ribs, Å.
    pub h_angstrom: f64,
    /// Length of the inclined ribs, Å.
    pub l_angstrom: f64,
    /// Angle between vertical and inclined ribs, rad; below π/2 the honeycomb is re-entrant.
    pub theta_rad: f64,
    /// Stiffness k_h of the hinges, kcal/mol/rad².
    pub hinge_stiffness_kcal_mol_rad2: f64,
    /// Stiffness k_s of the rods, kcal/mol/Å².
    pub rod_stiffness_kcal_mol_angstrom2: f64,
    /// Thickness b, Å.
    pub thickness_angstrom: f64,
}

/// Moduli along the two axes.
///
/// ```
/// use protomer_linkage::framework::analytic::AxialModuli;
/// let isotropic = AxialModuli { e_y_gpa: 3.0, e_z_gpa: 3.0, nu_yz: 0.5, nu_zy: 0.5, g_yz_gpa: 1.0 };
/// let expected = [[4.0, 2.0, 0.0], [2.0, 4.0, 0.0], [0.0, 0.0, 1.0]];
/// assert_eq!(isotropic.stiffness_gpa(), Some(expected));
/// assert_eq!(AxialModuli { nu_yz: 1.0, nu_zy: 1.0, ..isotropic }.stiffness_gpa(), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AxialModuli {
    /// E_1 = E_y, GPa.
    #[serde(deserialize_with = "null::as_nan")]
    pub e_y_gpa: f64,
    /// E_2 = E_z, GPa.
    #[serde(deserialize_with = "null::as_nan")]
    pub e_z_gpa: f64,
    /// ν_12 = ν_yz.
    #[serde(deserialize_with = "null::as_nan")]
    pub nu_yz: f64,
    /// ν_21 = ν_zy.
    #[serde(deserialize_with = "null::as_nan")]
    pub nu_zy: f64,
    /// G_12 = G_yz, GPa.
    #[serde(deserialize_with = "null::as_nan")]
    pub g_yz_gpa: f64,
}

impl AxialModuli {
    /// The stiffness in the order yy, zz, yz, GPa; `None` where it is infinite (ν_12 ν_21 = 1), as
    /// when a honeycomb only hinges: one freedom cannot make two strains.
    pub fn stiffness_gpa(&self) -> Option<[[f64; 3]; 3]> {
        let determinant = 1.0 - self.nu_yz * self.nu_zy;
        let coupled = self.nu_zy * self.e_y_gpa / determinant;
        let stiffness = [
            [self.e_y_gpa / determinant, coupled, 0.0],
            [coupled, self.e_z_gpa / determinant, 0.0],
            [0.0, 0.0, self.g_yz_gpa],
        ];
        (determinant.abs() > 1e-9).then_some(stiffness)
    }
}

impl Honeycomb {
    /// Edges X1 and X2 of the cell, Å.
    ///
    /// ```
    /// use protomer_linkage::framework::analytic::Honeycomb;
    /// let regular = Honeycomb {
    ///     h_angstrom: 1.0,
    ///     l_angstrom: 1.0,
    ///     theta_rad: 120_f64.to_radians(),
    ///     hinge_stiffness_kcal_mol_rad2: 50.0,
    ///     rod_stiffness_kcal_mol_angstrom2: 10_000.0,
    ///     thickness_angstrom: 1.0,
    /// };
    /// let [x1, x2] = regular.cell_angstrom();
    /// assert!((x1 - 3.0_f64.sqrt()).abs() < 1e-12 && (x2 - 3.0).abs() < 1e-12);
    /// ```
    pub fn cell_angstrom(&self) -> [f64; 2] {
        let (sine, cosine) = self.theta_rad.sin_cos();
        [
            2.0 * self.l_angstrom * sine,
            2.0 * (self.h_angstrom - self.l_angstrom * cosine),
        ]
    }

    /// Moduli of a honeycomb in which only the angles change.
    ///
    /// ```
    /// use protomer_linkage::framework::analytic::Honeycomb;
    /// let re_entrant = Honeycomb {
    ///     h_angstrom: 2.0,
    ///     l_angstrom: 1.0,
    ///     theta_rad: 60_f64.to_radians(),
    ///     hinge_stiffness_kcal_mol_rad2: 50.0,
    ///     rod_stiffness_kcal_mol_angstrom2: 10_000.0,
    ///     thickness_angstrom: 1.0,
    /// };
    /// // -tan 60° times √3 over 3
    /// assert!((re_entrant.hinging(1.0).nu_yz + 1.0).abs() < 1e-12, "it is auxetic");
    /// ```
    pub fn hinging(&self, gpa: f64) -> AxialModuli {
        let ([x1, x2], (sine, cosine)) = (self.cell_angstrom(), self.theta_rad.sin_cos());
        let k = 2.0 * self.hinge_stiffness_kcal_mol_rad2 * gpa
            / (self.thickness_angstrom * self.l_angstrom.powi(2));
        let nu_yz = -sine / cosine * x1 / x2;
        AxialModuli {
            e_y_gpa: k / (cosine * cosine) * x1 / x2,
            e_z_gpa: k / (sine * sine) * x2 / x1,
            nu_yz,
            nu_zy: 1.0 / nu_yz,
            g_yz_gpa: k * x1 * x2 / (2.0 * self.h_angstrom * sine).powi(2),
        }
    }

    /// Moduli of a honeycomb in which only the lengths change.
    pub fn stretching(&self, gpa: f64) -> AxialModuli {
        let ([x1, x2], (sine, cosine)) = (self.cell_angstrom(), self.theta_rad.sin_cos());
        let k = self.rod_stiffness_kcal_mol_angstrom2 * gpa / self.thickness_angstrom;
        let along_z = 2.0 + cosine * cosine;
        AxialModuli {
            e_y_gpa: k / (sine * sine) * x1 / x2,
            e_z_gpa: k / along_z * x2 / x1,
            nu_yz: cosine / sine * x1 / x2,
            nu_zy: sine * cosine / along_z * x2 / x1,
            g_yz_gpa: k * x1 * x2 / (2.0 * (self.h_angstrom * cosine - self.l_angstrom)).powi(2),
        }
    }

    /// Moduli of a honeycomb in which angles and lengths change: compliances add.
    pub fn both(&self, gpa: f64) -> AxialModuli {
        let (h, s) = (self.hinging(gpa), self.stretching(gpa));
        AxialModuli {
            e_y_gpa: in_series(h.e_y_gpa, s.e_y_gpa),
            e_z_gpa: in_series(h.e_z_gpa, s.e_z_gpa),
            nu_yz: mean_ratio(h.nu_yz, h.e_y_gpa, s.nu_yz, s.e_y_gpa),
            nu_zy: mean_ratio(h.nu_zy, h.e_z_gpa, s.nu_zy, s.e_z_gpa),
            g_yz_gpa: in_series(h.g_yz_gpa, s.g_yz_gpa),
        }
    }
}

/// 1/(1/a + 1/b), also where one is infinite: at h cos θ = l shear stretches nothing.
fn in_series(a: f64, b: f64) -> f64 {
    1.0 / (1.0 / a + 1.0 / b)
}

/// Poisson's ratio of two mechanisms whose compliances add.
fn mean_ratio(nu_h: f64, e_h: f64, nu_s: f64, e_s: f64) -> f64 {
    (nu_s * e_h + nu_h * e_s) / (e_s + e_h)
}
