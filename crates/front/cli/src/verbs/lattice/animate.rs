//! `protomer lattice animate`: a run as a page that plays it.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_linkage_verbs::lattice::animation::{AnimationSettings, animate};
use std::path::PathBuf;

/// Make a self-contained HTML page that plays a run in any browser.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "lattice animate coherent",
    "lattice animate coherent -o coherent.html --frames frames"
))]
pub struct AnimateArgs {
    /// Directory of a run.
    directory: PathBuf,
    /// The page [default: lattice.html in the directory].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Write the frames as SVG files into this directory as well.
    #[arg(long)]
    frames: Option<PathBuf>,
    /// Maximum number of frames, evenly spaced over the run.
    #[arg(long, default_value_t = 1000)]
    most_frames: usize,
}

impl AnimateArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = AnimationSettings {
            page: self.output.clone(),
            frames: self.frames.clone(),
            most_frames: self.most_frames,
            force: front.force(),
        };
        Ok(Reply::from_answer(animate(&self.directory, &settings)?))
    }
}
