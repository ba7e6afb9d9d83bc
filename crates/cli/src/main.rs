//! The `protomer` command.

mod allocator;

use std::process::ExitCode;

fn main() -> ExitCode {
    allocator::keep_freed_memory();
    ExitCode::from(protomer_cli::run(std::env::args_os()))
}
