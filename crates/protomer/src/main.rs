//! The `protomer` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    protomer::cli::run()
}
