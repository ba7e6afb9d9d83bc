//! How finely to solve, and on which grid.

use crate::charged_sphere::{ChargedSphere, bounds};
use crate::grid::Grid;
use crate::ion_response::IonResponse;
use crate::{FieldError, Result};
use protomer_kernel::Vec3;
use std::ops::RangeInclusive;

/// The coarsest grid on which the surface is resolved, Å: signed distances are exact up to here on
/// either side of the surface, and the box around a point must not be larger.
pub const LARGEST_SPACING_ANGSTROM: f64 = 1.1;

protomer_kernel::choices! {
    /// The potential on the faces of the grid. The usual choice, screened atoms with ions up to their radii, ignores the
    /// solvent that the solute displaces: at 100 mM and a margin of 10 Å that is 1.5 % of the potential outside crambin.
    /// On the faces of the coarse grid the solute looks like one sphere; it takes a second, smaller solve.
    pub enum BoundaryCondition, default ScreenedAtoms {
        /// The sum of the atoms' Debye-Hückel potentials, each alone in the solvent.
        ScreenedAtoms = "screened-atoms",
        /// The solution on a coarse grid twice as large: almost independent of the margin.
        CoarseGrid = "coarse-grid",
    }
}

/// Settings of a solve.
///
/// ```
/// use protomer_field::{BoundaryCondition, SolveSettings};
/// let fine = SolveSettings { spacing_angstrom: 0.25, ..SolveSettings::default() };
/// assert_eq!((fine.margin_angstrom, fine.boundary), (10.0, BoundaryCondition::ScreenedAtoms));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveSettings {
    /// Grid spacing, Å.
    pub spacing_angstrom: f64,
    /// Least distance from the spheres to the faces of the grid, Å.
    pub margin_angstrom: f64,
    /// The grid has a multiple of this many cells along each axis, a power of two, so that it can be
    /// halved that often. The cells that this adds widen the margin, which makes the potential on the
    /// faces more exact. With 8 instead of 16 the grids of 60 proteins at 1 Å have 11 % fewer points.
    pub cells_multiple: usize,
    /// Potential on the faces.
    pub boundary: BoundaryCondition,
    /// Residual of the linear equations over its start.
    pub relative_tolerance: f64,
    /// Memory that a solve may take, bytes.
    pub memory_limit_bytes: usize,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            spacing_angstrom: 0.5,
            margin_angstrom: 10.0,
            cells_multiple: 16,
            boundary: BoundaryCondition::default(),
            relative_tolerance: 1e-6,
            memory_limit_bytes: 16 << 30,
        }
    }
}

/// Bytes per grid point that a solve takes: 59 to 68 measured for large grids (docs/guide/potential.md).
const BYTES_PER_POINT: usize = 70;
/// Bytes per grid point of Newton's method: a second operator, the step, and two residuals.
const BYTES_PER_POINT_OF_NEWTON: usize = 120;
/// Ratio of the extents of the coarse and the fine grid along each axis.
const COARSE_EXTENT: f64 = 2.0;
/// Ratio of the spacings of the coarse and the fine grid, up to [`COARSEST_SPACING_ANGSTROM`].
const COARSE_SPACING: f64 = 4.0;
/// Largest spacing of the coarse grid, Å, unless that of the fine one is larger.
const COARSEST_SPACING_ANGSTROM: f64 = 2.0;

impl SolveSettings {
    pub(super) fn check(&self) -> Result<()> {
        let spacings = 0.05..=LARGEST_SPACING_ANGSTROM;
        check_range("spacing", self.spacing_angstrom, spacings, "0.05 to 1.1 Å")?;
        let margins = 1.0..=1000.0;
        check_range("margin", self.margin_angstrom, margins, "1 to 1000 Å")?;
        if !(self.cells_multiple.is_power_of_two() && (4..=64).contains(&self.cells_multiple)) {
            return Err(FieldError::BadSetting {
                setting: "multiple of cells",
                value: self.cells_multiple as f64,
                requirement: "4, 8, 16, 32 or 64",
            });
        }
        let tolerances = 1e-12..=1e-2;
        check_range(
            "tolerance",
            self.relative_tolerance,
            tolerances,
            "1e-12 to 1e-2",
        )
    }

    /// A grid that holds a box, if a solve on it fits in memory.
    fn grid(
        &self,
        low: &Vec3,
        high: &Vec3,
        spacing_angstrom: f64,
        ions: IonResponse,
    ) -> Result<Grid> {
        let grid = Grid::around(low, high, spacing_angstrom, self.cells_multiple)?;
        let (points, allowed_bytes) = (grid.len(), self.memory_limit_bytes);
        // Saturating: a product beyond the range is too large in any case.
        let needed_bytes = points.saturating_mul(match ions {
            IonResponse::Linear => BYTES_PER_POINT,
            IonResponse::Boltzmann(_) => BYTES_PER_POINT_OF_NEWTON,
        });
        if needed_bytes > allowed_bytes {
            return Err(FieldError::TooLarge {
                points,
                needed_bytes,
                allowed_bytes,
            });
        }
        Ok(grid)
    }
}

/// Refuses a setting outside its range.
pub(super) fn check_range(
    setting: &'static str,
    value: f64,
    range: RangeInclusive<f64>,
    requirement: &'static str,
) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(FieldError::BadSetting {
        setting,
        value,
        requirement,
    })
}

/// The grid on which the potential of these spheres is solved.
///
/// ```
/// use protomer_field::poisson_boltzmann::grid_around;
/// use protomer_field::{ChargedSphere, SolveSettings};
/// use protomer_kernel::Vec3;
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 2.0, charge_e: 1.0 };
/// let grid = grid_around(&[ion], &SolveSettings::default())?;
/// // 24 Å with the margins are 48 cells of 0.5 Å, three times sixteen.
/// assert_eq!((grid.shape, grid.origin_angstrom), ([49; 3], [-12.0; 3]));
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
///
/// # Errors
/// [`FieldError::BadSetting`] names the setting; [`FieldError::BadInput`] and
/// [`FieldError::TooLarge`] for a grid that is too large.
pub fn grid_around(spheres: &[ChargedSphere], settings: &SolveSettings) -> Result<Grid> {
    grid_for(spheres, settings, IonResponse::Linear)
}

/// Variant of [`grid_around`] for ions of another response, whose solve takes more memory.
pub(crate) fn grid_for(
    spheres: &[ChargedSphere],
    settings: &SolveSettings,
    ions: IonResponse,
) -> Result<Grid> {
    settings.check()?;
    let (low, high) = bounds(spheres);
    let margin = Vec3::repeat(settings.margin_angstrom);
    let spacing = settings.spacing_angstrom;
    settings.grid(&(low - margin), &(high + margin), spacing, ions)
}

/// The coarse grid of [`BoundaryCondition::CoarseGrid`].
pub(super) fn coarse_grid_around(
    spheres: &[ChargedSphere],
    settings: &SolveSettings,
    ions: IonResponse,
) -> Result<Grid> {
    let (low, high) = bounds(spheres);
    let margin = Vec3::repeat(settings.margin_angstrom);
    let extent = high - low + 2.0 * margin;
    // Half of the added extent on either side.
    let wider = 0.5 * (COARSE_EXTENT - 1.0) * extent;
    let coarsest = COARSEST_SPACING_ANGSTROM.max(settings.spacing_angstrom);
    let spacing = (COARSE_SPACING * settings.spacing_angstrom).min(coarsest);
    settings.grid(
        &(low - margin - wider),
        &(high + margin + wider),
        spacing,
        ions,
    )
}
