//! The `protomer` command.

mod allocator;
mod signals;

use std::process::ExitCode;

fn main() -> ExitCode {
    allocator::keep_freed_memory();
    signals::report_large_files();
    ExitCode::from(protomer_cli::run(std::env::args_os()))
}
