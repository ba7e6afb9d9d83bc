//! Energies of a pair of bodies at one pose, and the lists that serve it at another.

use super::list::List;
use super::motion::Motion;
use super::sharpening::{Ranking, STEPS};
use super::table::Estimate;
use protomer_kernel::pose::RelativePose;
use smallvec::SmallVec;
use std::sync::{Arc, OnceLock};

/// Energies of one pair of bodies at one pose.
#[derive(Debug)]
pub(super) struct PoseEnergies {
    /// The types of the two bodies.
    pub types: (usize, usize),
    /// Images of the second body; most pairs have one.
    pub images: SmallVec<[Image; 1]>,
    pub expanded_kt: f64,
    pub coarse_kt: OnceLock<f64>,
    /// Energies with all charges in the table, and after each step of sharpening, which few pairs
    /// need.
    pub fine: OnceLock<Box<[OnceLock<Estimate>; 1 + STEPS]>>,
    pub direct_kt: OnceLock<f64>,
}

/// One image of the second body that counts.
#[derive(Debug)]
pub(super) struct Image {
    pub relative: RelativePose,
    pub list: Arc<List>,
    /// Lower bound of the list's [slack](List::slack_angstrom) at this pose, Å.
    pub slack_angstrom: f32,
    /// The energy without the list's far points, kT.
    pub close_kt: f64,
    /// Variance of the list's expansion by the error model, kT².
    pub expansion_variance: f64,
    /// The order in which charges leave the fine table; `None` where that ends before.
    pub ranking: OnceLock<Option<Box<Ranking>>>,
}

/// Lists that serve at the poses of a pair's images, with their slack there, Å.
pub(super) type Lists = SmallVec<[Option<(Arc<List>, f32)>; 1]>;

impl PoseEnergies {
    /// The lists of the images that serve at these poses.
    pub fn lists_at(&self, poses: &[RelativePose]) -> Lists {
        let images = self.images.iter().zip(poses);
        images.map(|(image, pose)| image.list_at(pose)).collect()
    }

    /// Whether lists made where the pair is would serve where its own do not. None would where a
    /// cluster move takes it.
    pub fn is_due(&self, poses: &[RelativePose], lists: &Lists) -> bool {
        let mut images = self.images.iter().zip(poses).zip(lists);
        let spans = |((image, pose), list): ((&Image, &RelativePose), &Option<_>)| {
            list.is_some() || image.list.spans(&image.relative, pose)
        };
        // One list fails and all could be made to serve:
        // new ones pay. After a cluster move none would.
        lists.iter().any(Option::is_none) && images.all(spans)
    }
}

impl Image {
    /// The list, if it serves at this pose, and its slack there, Å. Most moves are shorter than the
    /// slack that was left, and the parts need not be looked at.
    fn list_at(&self, pose: &RelativePose) -> Option<(Arc<List>, f32)> {
        // A bound on how far any charge has moved: one distance instead of a loop over the parts.
        let distance = Motion::between(&self.relative, pose).distance([0.0; 3], self.list.radius);
        let remaining_slack = self.slack_angstrom - distance;
        let slack = match remaining_slack >= 0.0 {
            true => remaining_slack,
            false => self.list.slack_angstrom(pose),
        };
        (slack >= 0.0).then(|| (Arc::clone(&self.list), slack))
    }
}
