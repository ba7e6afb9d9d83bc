//! What can go wrong.

/// The errors of this crate.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// A sample that cannot be used.
    #[error("sample {name}: {reason}")]
    Sample {
        /// The sample.
        name: String,
        /// Cause of the error, and what to do.
        reason: String,
    },
    /// Settings or data that do not fit together.
    #[error("{0}")]
    Settings(String),
    /// Weights or gradients are no longer finite.
    #[error("training diverged: {0}; lower learning_rate or scale the channels")]
    Diverged(String),
    /// A tensor operation failed.
    #[error("tensor: {0}")]
    Tensor(#[from] candle_core::Error),
    /// A convolution that no kernel computes.
    #[error(transparent)]
    Convolution(#[from] protomer_convolution::ConvolutionError),
}

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, LearnError>;

/// Refuses settings or data, for a reason that also says what to do.
pub(crate) fn refuse<T>(reason: impl Into<String>) -> Result<T> {
    Err(LearnError::Settings(reason.into()))
}

/// Error for voxels that cannot be used. [`crate::scaling::read_checked`] puts the sample's name
/// in.
pub(crate) fn damaged(reason: impl Into<String>) -> LearnError {
    LearnError::Sample {
        name: "voxels".into(),
        reason: reason.into(),
    }
}
