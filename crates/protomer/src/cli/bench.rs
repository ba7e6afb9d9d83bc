//! temporary
use super::{Global, Outcome};
use anyhow::Result;
use clap::Args;
/// Bench
#[derive(Debug, Args)]
pub struct BenchArgs {}
impl BenchArgs {
    pub(super) fn run(&self, _: &Global) -> Result<Outcome> {
        Ok(Outcome::Done)
    }
}
