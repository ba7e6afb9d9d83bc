//! Directories of results that state their content, and one driver for everything that can be
//! started, advanced, saved, continued and recorded.
//!
//! ```text
//! settings --ResultsDirectory::enter--> a directory that is ours alone
//! Run      --drive-->   checkpoint.bin, run.json, its own files --> End::Finished(answer) or End::Stopped
//! Campaign --conduct--> many runs in one directory              --> tables and figures
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`run`] | one run: started or continued, saved regularly, recorded |
//! | [`campaign`] | many runs that share a directory, whole or in parts |
//! | [`directory`] | the owner of a directory, and the files that may be removed |
//! | [`lock`] | which process works in it |
//! | [`settings`] | which settings can continue which |
//! | [`kind`], `contents` | the kinds of results; the kind in a directory |
//! | [`record`] | `run.json`: the work, its input, and how it ended |
//! | [`checkpoint`] | `checkpoint.bin`: the state from which a run continues |
//! | [`file_record`] | what the tables of a folder say of an input file |
//! | [`log`] | tables that grow by rows and can be truncated to a checkpoint |
//! | [`execution`], [`interrupt`], [`shard`], [`end`] | how a run is carried out, and how it ends |
//! | [`keys`] | JSON and TOML with helpful errors |
//!
//! Two promises hold for every run. The same command continues it, whatever ended it. A run that
//! was interrupted anywhere and continued equals an uninterrupted one byte for byte.
//!
//! `tests/integration/walk/mod.rs` is a complete engine in a few dozen lines, a template for new ones.

mod at_work;
pub mod campaign;
pub mod checkpoint;
mod contents;
pub mod directory;
pub mod end;
mod error;
pub mod execution;
pub mod file_record;
pub mod interrupt;
pub mod keys;
pub mod kind;
pub mod lock;
pub mod log;
pub mod record;
pub mod run;
pub mod settings;
pub mod shard;

pub use campaign::{Campaign, carry_out, carry_out_shard, conduct, conduct_shard, each, recorded};
pub use checkpoint::{CHECKPOINT, Checkpoint};
pub use directory::{Layout, ResultsDirectory};
pub use end::End;
pub use error::{Error, Result};
pub use execution::{Execution, Progress};
pub use file_record::FileRecord;
pub use interrupt::Interrupt;
pub use kind::ResultKind;
pub use lock::Hold;
pub use log::{Log, LogMark, Row};
pub use record::{Exit, Record, Work};
pub use run::{Run, Turn, drive, extend, proceed};
pub use settings::Settings;
pub use shard::Shard;
