//! The settings of a simulation.

use crate::Result;
use crate::depletants::Depletants;
use crate::energy::certified::Certified;
use crate::energy::levels::Levels;
use crate::energy::{DirectSum, EnergyModel, NoCharges};
use crate::error::require;
use crate::system::System;
use protomer_kernel::potential::Yukawa;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Surfaces closer than this are in contact where nothing else is stated, Å.
pub const DEFAULT_CONTACT_GAP_ANGSTROM: f64 = 5.0;

/// The interaction of bodies, in addition to their hard cores.
///
/// ```
/// use protomer_kernel::potential::Yukawa;
/// use protomer_mc::Interaction;
/// let (bjerrum_angstrom, debye_angstrom, cutoff_angstrom) = (7.0, 9.6, 48.0);
/// let yukawa = Yukawa::new(bjerrum_angstrom, 1.0 / debye_angstrom, cutoff_angstrom)?;
/// let interaction = Interaction::YukawaDirect(yukawa);
/// assert_ne!(interaction, Interaction::YukawaCalibrated(yukawa));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Interaction {
    /// No interaction in addition to the hard cores.
    HardOnly,
    /// Screened point charges, summed pair by pair.
    YukawaDirect(Yukawa),
    /// Screened point charges, with the decisions of the direct sum by proven bounds.
    YukawaCertified(Yukawa),
    /// Screened point charges, with the decisions of the direct sum by a model of the errors, by
    /// levels of rising accuracy.
    YukawaCalibrated(Yukawa),
    /// Screened point charges to within a likely error for each pair of bodies.
    YukawaApproximate {
        /// The potential.
        yukawa: Yukawa,
        /// Largest error of the energy of two bodies, kT.
        tolerance_kt: f64,
    },
}

impl Interaction {
    /// The energy model that computes this interaction in this system.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose, potential::Yukawa};
    /// use protomer_mc::{BodyType, Interaction, System};
    /// # use protomer_kernel::{TriangleMesh, Vec3};
    /// # use std::sync::Arc;
    /// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// # let charged = Arc::new(BodyType::new("cube", &mesh, &[(Vec3::zeros(), 2.0)])?);
    /// let system = System::new(vec![charged], &[(0, Pose::identity())], Boundary::Open)?;
    /// let cut = Interaction::YukawaDirect(Yukawa::new(7.0, 0.1, 48.0)?);
    /// assert_eq!(cut.model(&system).range_angstrom(&system), 48.0);
    /// assert_eq!(Interaction::HardOnly.model(&system).range_angstrom(&system), 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn model(&self, system: &System) -> Box<dyn EnergyModel> {
        match self {
            Interaction::HardOnly => Box::new(NoCharges),
            Interaction::YukawaDirect(yukawa) => Box::new(DirectSum::new(*yukawa)),
            Interaction::YukawaCertified(yukawa) => {
                Box::new(Certified::for_system(*yukawa, system))
            }
            Interaction::YukawaCalibrated(yukawa) => Box::new(Levels::for_system(*yukawa, system)),
            Interaction::YukawaApproximate {
                yukawa,
                tolerance_kt,
            } => Box::new(Levels::for_system(*yukawa, system).with_tolerance(*tolerance_kt)),
        }
    }
}

/// The settings of a simulation; they travel with its checkpoint.
///
/// ```
/// use protomer_mc::{Interaction, Settings};
/// let settings = Settings {
///     equilibration_sweeps: 500,
///     cluster_moves_per_sweep: 0,
///     ..Settings::new(Interaction::HardOnly)
/// };
/// assert_eq!(settings.target_acceptance, 0.4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Interaction of the bodies.
    pub interaction: Interaction,
    /// Initial value of the largest displacement of a trial move, Å.
    pub translation_step_angstrom: f64,
    /// Initial value of the largest angle of a trial move, rad.
    pub rotation_step_rad: f64,
    /// Sweeps during which steps are tuned; acceptance counts restart after them.
    pub equilibration_sweeps: u64,
    /// The acceptance ratio that tuning aims for.
    pub target_acceptance: f64,
    /// Fraction of the trial moves that are rotations.
    pub rotation_fraction: f64,
    /// Geometric cluster moves in each sweep, in addition to one trial move per body.
    pub cluster_moves_per_sweep: u32,
    /// Moves that form and dissolve contacts ([`BindingMove`](crate::moves::BindingMove)) in each
    /// sweep, in addition to the others.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub binding_moves_per_sweep: u32,
    /// Moves in each sweep that change protons of a random body, for models with titratable groups
    /// ([`DirectSum::regulated`](crate::energy::DirectSum::regulated)).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub proton_moves_per_sweep: u32,
    /// Penetrable hard spheres around the bodies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depletants: Option<Depletants>,
    /// Largest distance between the axis of a cluster move and the seed body, Å; `None` for the
    /// diameter of the largest body.
    pub cluster_axis_reach_angstrom: Option<f64>,
    /// Two bodies are in contact if their surfaces are closer than this, vertex to vertex, Å.
    pub contact_gap_angstrom: f64,
}

fn is_zero(number: &u32) -> bool {
    *number == 0
}

impl Settings {
    /// The default settings for this interaction.
    ///
    /// ```
    /// use protomer_mc::{DEFAULT_CONTACT_GAP_ANGSTROM, Interaction, Settings};
    /// let settings = Settings::new(Interaction::HardOnly);
    /// assert_eq!(settings.contact_gap_angstrom, DEFAULT_CONTACT_GAP_ANGSTROM);
    /// ```
    pub fn new(interaction: Interaction) -> Self {
        Self {
            interaction,
            translation_step_angstrom: 0.5,
            rotation_step_rad: 0.05,
            equilibration_sweeps: 1000,
            target_acceptance: 0.4,
            rotation_fraction: 0.5,
            cluster_moves_per_sweep: 1,
            binding_moves_per_sweep: 0,
            proton_moves_per_sweep: 0,
            depletants: None,
            cluster_axis_reach_angstrom: None,
            contact_gap_angstrom: DEFAULT_CONTACT_GAP_ANGSTROM,
        }
    }

    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) names the first setting out of range.
    pub(crate) fn check(&self) -> Result<()> {
        if let Some(depletants) = &self.depletants {
            depletants.check()?;
        }
        let reach = self.cluster_axis_reach_angstrom.unwrap_or(1.0);
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let fraction = (0.0..=1.0).contains(&self.rotation_fraction);
        let tolerance = match self.interaction {
            Interaction::YukawaApproximate { tolerance_kt, .. } => tolerance_kt,
            _ => 1.0,
        };
        let (step, angle) = (self.translation_step_angstrom, self.rotation_step_rad);
        let checks = [
            ("tolerance_kt", tolerance, positive(tolerance), "positive"),
            (
                "translation_step_angstrom",
                step,
                positive(step),
                "positive",
            ),
            (
                "rotation_step_rad",
                angle,
                positive(angle) && angle <= PI,
                "positive and at most π",
            ),
            (
                "target_acceptance",
                self.target_acceptance,
                (0.01..=0.99).contains(&self.target_acceptance),
                "0.01 to 0.99",
            ),
            (
                "rotation_fraction",
                self.rotation_fraction,
                fraction,
                "0 to 1",
            ),
            (
                "cluster_axis_reach_angstrom",
                reach,
                positive(reach),
                "positive",
            ),
            (
                "contact_gap_angstrom",
                self.contact_gap_angstrom,
                positive(self.contact_gap_angstrom),
                "positive",
            ),
        ];
        checks
            .into_iter()
            .try_for_each(|(setting, value, holds, requirement)| {
                require(setting, value, requirement, holds)
            })
    }
}
