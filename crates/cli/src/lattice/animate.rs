//! `protomer lattice animate`: a run as a page that plays it.

use super::super::{Global, Outcome, output};
use anyhow::{Context, Result, bail};
use clap::Args;
use protomer::lattice::animation::Animation;
use protomer_io::atomic::write_atomically;
use protomer_results::ResultKind;
use std::path::{Path, PathBuf};

/// Make a page that plays a run in any browser: one HTML file that needs nothing else.
#[derive(Debug, Args)]
pub struct AnimateArgs {
    /// Directory of a run.
    directory: PathBuf,
    /// The page [default: lattice.html in the directory].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Write the frames as SVG files into this directory as well.
    #[arg(long)]
    frames: Option<PathBuf>,
    /// Frames to show at most, spread evenly over the run.
    #[arg(long, default_value_t = 1000)]
    most_frames: usize,
}

impl AnimateArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let animation = Animation::read(&self.directory, self.most_frames)?;
        let page = self
            .output
            .clone()
            .unwrap_or_else(|| self.directory.join("lattice.html"));
        require_free(&page, global)?;
        let html = animation.to_html();
        write_atomically(&page, |file| file.write_all(html.as_bytes()))?;
        if let Some(folder) = &self.frames {
            ResultKind::VoxelSet.refuse_in(folder)?;
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make {}", folder.display()))?;
            for frame in 0..animation.len() {
                let path = folder.join(format!("frame_{frame:05}.svg"));
                require_free(&path, global)?;
                let svg = animation.to_svg(frame);
                write_atomically(&path, |file| file.write_all(svg.as_bytes()))?;
            }
        }
        if global.json {
            output::json(&serde_json::json!({ "page": page, "frames": animation.len() }))?;
        } else if !global.quiet {
            output::text(&format!("{} frames in {}", animation.len(), page.display()))?;
        }
        Ok(Outcome::Done)
    }
}

fn require_free(path: &Path, global: &Global) -> Result<()> {
    if path.exists() && !global.force {
        bail!(
            "{} is there already; give --force to replace it",
            path.display()
        );
    }
    Ok(())
}
