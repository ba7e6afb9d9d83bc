//! The error type of this crate, and the checks of single numbers that every module makes.

use protomer_kernel::Number;

/// Errors of lattices and frameworks.
///
/// ```
/// use protomer_linkage::CrystalError;
/// use protomer_linkage::lattice::Langevin;
/// let error = Langevin::new(-1.0, 1.0, 7, 0).unwrap_err();
/// assert!(matches!(error, CrystalError::BadSetting { setting: "kt", .. }));
/// assert_eq!(error.to_string(), "kt is -1; it must be zero or positive");
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CrystalError {
    /// A network that contradicts itself.
    #[error("{0}")]
    BadNetwork(String),
    /// A setting outside its range.
    #[error("{setting} is {}; it must be {requirement}", Number(*value))]
    BadSetting {
        /// The setting's name.
        setting: &'static str,
        /// Value of the setting.
        value: f64,
        /// The values it may have.
        requirement: &'static str,
    },
    /// A setting that names a square outside the lattice.
    #[error(
        "{setting} names the square in row {row} and column {column}; rows go from 0 to {}, \
         columns from 0 to {}",
        rows - 1,
        columns - 1
    )]
    NoSuchSquare {
        /// The setting's name.
        setting: &'static str,
        /// The row it names.
        row: usize,
        /// The column it names.
        column: usize,
        /// Rows of the lattice.
        rows: usize,
        /// Columns of the lattice.
        columns: usize,
    },
    /// A setting that names a vertex that no square has.
    #[error("{setting} names vertex {vertex}; vertices are 1 (upper left), 2, 3 (lower left), 4")]
    NoSuchVertex {
        /// The setting's name.
        setting: &'static str,
        /// The vertex it names.
        vertex: usize,
    },
    /// A rod that is to be removed but does not exist.
    #[error("removed_rods names {end:?}, where no rod ends; leave it out")]
    NoSuchRod {
        /// Row, column and vertex at which no rod ends.
        end: [usize; 3],
    },
    /// A state that does not fit the network.
    #[error("{0}")]
    BadState(String),
    /// The search for a minimum of the energy failed.
    #[error("{0}")]
    NoMinimum(String),
    /// Rods that cannot all keep their lengths independently of each other.
    #[error(
        "rod {rod} depends on the others at t = {time}: the rods over-constrain the squares; \
         remove rods, or turn the squares away from this singular position"
    )]
    OverConstrained {
        /// Index of the rod.
        rod: usize,
        /// Time.
        time: f64,
    },
    /// The positions at the end of a step could not be found.
    #[error(
        "the rods could not be brought back to their lengths in the step from t = {time} (rod \
         {rod} is off by {violation:e}): the time step {time_step} is too large for rods this \
         short and squares this fast; try at most {suggested_time_step:.2e}"
    )]
    StepTooLarge {
        /// Time at the start of the step.
        time: f64,
        /// Length of the step.
        time_step: f64,
        /// The rod that is farthest from its length.
        rod: usize,
        /// Length of that rod less the length it should have.
        violation: f64,
        /// A step that should work.
        suggested_time_step: f64,
    },
    /// Bodies that overlap.
    #[error(
        "{first} and {second} overlap by {depth:e} at t = {time}; start from a state without \
         overlaps, or take a smaller time step"
    )]
    Overlap {
        /// One body.
        first: String,
        /// The other body.
        second: String,
        /// The depth of the overlap.
        depth: f64,
        /// Time.
        time: f64,
    },
    /// A step in which impacts follow each other without end.
    #[error(
        "{events} impacts in the step from t = {time}, the last between {first} and {second}: the \
         bodies are jammed; take a smaller time step or start from a looser state"
    )]
    Jammed {
        /// Impacts in the step.
        events: usize,
        /// One body.
        first: String,
        /// The other body.
        second: String,
        /// Time at the start of the step.
        time: f64,
    },
    /// Work that was asked to stop.
    #[error("stopped on request")]
    Stopped,
    /// A number that is not finite.
    #[error("square {square} has a position or velocity that is not finite at t = {time}")]
    NotFinite {
        /// Index of the square.
        square: usize,
        /// Time.
        time: f64,
    },
    /// A potential or mesh that the kernels refuse.
    #[error(transparent)]
    Kernel(#[from] protomer_kernel::KernelError),
}

/// The result of everything in this crate that can fail.
pub type Result<T> = std::result::Result<T, CrystalError>;

/// Refuses a value unless `holds`, and NaN and infinities always.
pub(crate) fn require(
    setting: &'static str,
    value: f64,
    holds: bool,
    requirement: &'static str,
) -> Result<()> {
    if value.is_finite() && holds {
        return Ok(());
    }
    Err(CrystalError::BadSetting {
        setting,
        value,
        requirement,
    })
}

pub(crate) fn require_positive(setting: &'static str, value: f64) -> Result<()> {
    require(setting, value, value > 0.0, "positive")
}

pub(crate) fn require_not_negative(setting: &'static str, value: f64) -> Result<()> {
    require(setting, value, value >= 0.0, "zero or positive")
}

pub(crate) fn require_finite(setting: &'static str, value: f64) -> Result<()> {
    require(setting, value, true, "finite")
}
