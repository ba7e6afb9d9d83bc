//! The `protomer` command.
fn main() {}
