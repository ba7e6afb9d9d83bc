//! The one error type of this crate.

use protomer_kernel::{KernelError, Number};

/// Errors of a simulation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum McError {
    /// Bodies that overlap before the first move.
    #[error(
        "{} pair(s) of bodies overlap at the start: {}; move them apart or shrink their surfaces",
        pairs.len(), list(pairs)
    )]
    OverlappingStart {
        /// Indices of the bodies, the smaller first, ascending.
        pairs: Vec<(usize, usize)>,
    },
    /// An energy that is NaN or infinite: two coincident charges, or a charge that is NaN.
    #[error(
        "the energy of bodies {first} and {second} is {energy_kt} kT at trial move {step}; two of their charges \
         coincide, so the charges reach outside the hard surface"
    )]
    NonFiniteEnergy {
        /// The trial move, counted from the start of the run; zero at the start.
        step: u64,
        /// Index of the first body.
        first: usize,
        /// Index of the second body.
        second: usize,
        /// The computed energy.
        energy_kt: f64,
    },
    /// Unscreened charges in a periodic box, where the sum over images has no value.
    #[error(
        "without salt the sum over the images of a periodic box does not converge; add salt, or \
         use open space or a wall"
    )]
    UnscreenedInBox,
    /// An interaction that reaches over many images of a small box.
    #[error(
        "the interaction reaches {range_angstrom:.0} Å, over more images than can be summed in a \
         box of {smallest_length_angstrom:.0} Å; make every box length at least \
         {needed_length_angstrom:.0} Å, or add salt until the Debye length is shorter by a factor \
         of {:.2}",
        needed_length_angstrom / smallest_length_angstrom
    )]
    ReachesTooFar {
        /// Distance of the origins up to which bodies interact, Å.
        range_angstrom: f64,
        /// The smallest box length, Å.
        smallest_length_angstrom: f64,
        /// The smallest box length that would do, Å.
        needed_length_angstrom: f64,
    },
    /// An inconsistent system.
    #[error("{0}")]
    BadSystem(String),
    /// A setting out of its range.
    #[error("{setting} is {}; it must be {requirement}", Number(*value))]
    BadSetting {
        /// The setting's name.
        setting: &'static str,
        /// The value given.
        value: f64,
        /// The valid range.
        requirement: &'static str,
    },
    /// A checkpoint of another system.
    #[error(
        "the checkpoint does not belong to this system: {0}; start again, or use the system it was written from"
    )]
    ForeignCheckpoint(String),
    /// Stored energy tables that are damaged or not the requested ones.
    #[error("the stored energy tables cannot be used: {0}; make them again")]
    UnusableTable(String),
    /// An error of the kernel crate.
    #[error(transparent)]
    Kernel(#[from] KernelError),
}

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, McError>;

/// `Ok` if it `holds`, otherwise the error that names the setting.
pub(crate) fn require(
    setting: &'static str,
    value: f64,
    requirement: &'static str,
    holds: bool,
) -> Result<()> {
    match holds {
        true => Ok(()),
        false => Err(McError::BadSetting {
            setting,
            value,
            requirement,
        }),
    }
}

/// The first few pairs, formatted for a message.
fn list(pairs: &[(usize, usize)]) -> String {
    const SHOWN: usize = 12;
    let mut text: Vec<String> = pairs
        .iter()
        .take(SHOWN)
        .map(|(i, j)| format!("({i}, {j})"))
        .collect();
    if pairs.len() > SHOWN {
        text.push(format!("and {} more", pairs.len() - SHOWN));
    }
    text.join(", ")
}
