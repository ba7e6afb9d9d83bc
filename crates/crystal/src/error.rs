//! The one error type of this crate.

/// What can go wrong with a lattice or a framework.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CrystalError {
    /// A network that contradicts itself.
    #[error("{0}")]
    BadNetwork(String),
    /// A setting out of its range.
    #[error("{setting} is {value}; it must be {requirement}")]
    BadSetting {
        /// The setting's name.
        setting: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A state that does not fit the network.
    #[error("{0}")]
    BadState(String),
    /// A minimum of the energy that was not found.
    #[error("{0}")]
    NoMinimum(String),
    /// Rods that cannot all keep their lengths independently of each other.
    #[error(
        "rod {rod} depends on the others at t = {time}: the rods over-constrain the squares; remove rods, or turn the \
         squares away from this singular position"
    )]
    OverConstrained {
        /// Index of the rod.
        rod: usize,
        /// Time.
        time: f64,
    },
    /// The positions at the end of a step could not be found.
    #[error(
        "the rods could not be brought back to their lengths in the step from t = {time} (rod {rod} is off by \
         {violation:e}): the time step {time_step} is too large for rods this short and squares this fast; try at most \
         {suggested_time_step:.2e}"
    )]
    StepTooLarge {
        /// Time at the start of the step.
        time: f64,
        /// The step.
        time_step: f64,
        /// The rod that is worst.
        rod: usize,
        /// Its length less what it should be.
        violation: f64,
        /// A step that should do.
        suggested_time_step: f64,
    },
    /// Bodies that overlap.
    #[error(
        "{first} and {second} overlap by {depth:e} at t = {time}; start from a state without overlaps, or take a smaller \
         time step"
    )]
    Overlap {
        /// One body.
        first: String,
        /// The other.
        second: String,
        /// How deep.
        depth: f64,
        /// Time.
        time: f64,
    },
    /// Impacts without end.
    #[error(
        "{events} impacts in the step from t = {time} and no end ({first} and {second} at last): the bodies are jammed; \
         take a smaller time step or start from a looser state"
    )]
    Jammed {
        /// Impacts in the step.
        events: usize,
        /// One body.
        first: String,
        /// The other.
        second: String,
        /// Time at the start of the step.
        time: f64,
    },
    /// A number that is not finite.
    #[error("square {square} has a position or velocity that is not finite at t = {time}")]
    NotFinite {
        /// Index of the square.
        square: usize,
        /// Time.
        time: f64,
    },
}

/// The result of anything here that can fail.
pub type Result<T> = std::result::Result<T, CrystalError>;
