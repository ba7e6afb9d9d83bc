//! The `protomer` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(protomer_cli::run(std::env::args_os()))
}
