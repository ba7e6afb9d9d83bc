//! A simulation is a directory: settings, log, trajectory, checkpoint, and a record of how it was
//! made. The same command continues it; a run cut anywhere and continued equals the uninterrupted
//! one bit for bit.

mod checkpoint_file;
mod contents;
mod directory;
mod engine;
mod execution;
mod log;
mod record;
mod replica;
mod settings;
mod trajectory;

pub(crate) use checkpoint_file::{read_checkpoint, write_checkpoint};
pub(crate) use contents::{
    ELASTIC_CONSTANTS, LATTICE_RUN, LATTICE_SWEEP, SWEEP, TABLES, refuse_other, refuse_set,
};
pub use directory::{Hold, Layout, ResultsDirectory, refuse};
pub(crate) use directory::{lock, lock_file};
pub use engine::{Engine, require_room};
pub use execution::Execution;
pub(crate) use log::{Log, LogMark, check_log, complete_lines, read_text};
pub use log::{LogRow, read_log, read_log_so_far};
pub use record::{RunRecord, read_record};
pub use replica::{ReplicaCounts, ReplicaEnd, ReplicaTask, run_replica};
pub use settings::{DEFAULT_TOLERANCE_KT, EnergyMode, RunSettings, salt_label};
