//! The one error type of this crate.

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// A file that cannot be read: where, why, and what to do about it.
    #[error("{}: {cause}; {remedy}", place(file, *line))]
    Parse {
        /// Name of the file as the user gave it.
        file: String,
        /// Line, counted from one; zero for the whole file.
        line: usize,
        /// Cause of the error.
        cause: String,
        /// Remedy: what the user can do.
        remedy: String,
    },
    /// A selection, option or table entry that does not fit the structure.
    #[error("{cause}; {remedy}")]
    Invalid {
        /// Cause of the error, naming the residue, chain or option.
        cause: String,
        /// Remedy: what the user can do.
        remedy: String,
    },
    /// A Cα trace: a protein without any other atoms.
    #[error(
        "the protein is a trace: of its {residues} residues there are only the Cα atoms; give a \
         structure with all heavy atoms, deposited or rebuilt from the trace"
    )]
    Trace {
        /// Residues of the protein.
        residues: usize,
    },
    /// Two bodies that no small displacement frees of each other.
    #[error(
        "bodies {} and {} interlock: no displacement of a few Å frees them; make them one body",
        first + 1,
        second + 1
    )]
    Interlocked {
        /// The first body, by its place in the list.
        first: usize,
        /// The second body, by its place in the list.
        second: usize,
    },
    /// A box too full for another body to be inserted at random.
    #[error(
        "no room for body {} in the box after {attempts} attempts; enlarge the box, or ask for \
         fewer bodies",
        inserted + 1
    )]
    NoRoom {
        /// Bodies inserted so far.
        inserted: usize,
        /// Attempts made.
        attempts: u64,
    },
    /// An error of the geometry kernel.
    #[error(transparent)]
    Kernel(#[from] protomer_kernel::KernelError),
}

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, BodyError>;

fn place(file: &str, line: usize) -> String {
    if line == 0 {
        file.to_owned()
    } else {
        format!("{file}:{line}")
    }
}
