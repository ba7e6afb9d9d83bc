//! A decision: the changes of all pairs that a move concerns, refined until they settle it.

use super::calibration::MULTIPLE;
use super::far::{FarImages, Images};
use super::model::Levels;
use super::pair_levels::{COARSE, DIRECT, EXPANDED, FINE};
use super::stored::{Lists, PoseEnergies};
use crate::Result;
use crate::energy::finite;
use crate::system::{Pair, Trial};
use protomer_kernel::pose::RelativePose;
use serde::Serialize;
use std::sync::Arc;

/// Number of decisions at each level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Decided {
    /// Decisions from lists of points, the far ones expanded about an earlier pose.
    pub expanded: u64,
    /// Decisions with all points of a list in coarse tables, for one pair of bodies or more.
    pub coarse: u64,
    /// Decisions with all charges in fine tables, for one pair of bodies or more, or all but the
    /// least certain.
    pub fine: u64,
    /// Decisions with a direct sum for one pair of bodies or more.
    pub direct: u64,
}

/// A pair in a decision: its energy after the move and before.
pub(super) struct Change {
    partner: usize,
    new: Option<Arc<PoseEnergies>>,
    old: Option<Arc<PoseEnergies>>,
    level: usize,
    /// Change of the energy, kT, and its standard deviation.
    change_kt: f64,
    deviation_kt: f64,
    /// Kind of images, near or far away; nothing is kept of those far away.
    images: Images,
}

/// Basis of a decision: pairs with what is known of them, and a bound for the others.
#[derive(Default)]
pub(super) struct Changes {
    pub pairs: Vec<Change>,
    pub far: FarImages,
}

impl Levels {
    /// The change of the energy of a pair at one level, kT, with its standard deviation.
    fn change(&self, trial: &Trial<'_>, change: &Change, level: usize) -> Result<(f64, f64)> {
        let (new, old) = (change.new.as_deref(), change.old.as_deref());
        let energy = |energies: Option<&PoseEnergies>| {
            energies.map_or((0.0, 0.0), |energies| self.energy(energies, level))
        };
        let ((new_kt, new_variance), (old_kt, old_variance)) = (energy(new), energy(old));
        let variance = match (level, new, old) {
            // From one list, most errors cancel in the
            // difference; at finer levels they are independent.
            (EXPANDED | COARSE, Some(new), Some(old)) => self.change_variance(new, old, level),
            _ => new_variance + old_variance,
        };
        let (first, second) = (
            trial.body.min(change.partner),
            trial.body.max(change.partner),
        );
        let change_kt = finite(first, second, new_kt - old_kt)?;
        Ok((change_kt, variance.sqrt()))
    }

    /// Adds a bound of the change of the energy of the images of one partner that are far away.
    pub(super) fn add_far(
        &self,
        changes: &mut Changes,
        trial: &Trial<'_>,
        partner: usize,
        after: &Pair<'_>,
    ) {
        let before = trial.system.pair(trial.body, partner);
        // Both ends of the move may contribute, so both bounds count.
        let bound_kt = self.far.bound_kt(&before) + self.far.bound_kt(after);
        changes.far.add(partner, bound_kt);
    }

    /// Change of the energy of the near images of one partner, at the first level.
    pub(super) fn first_change(
        &mut self,
        trial: &Trial<'_>,
        partner: usize,
    ) -> Result<Option<Change>> {
        let present = trial.system.pair(trial.body, partner);
        let mut old = self.energies.get(trial.body, partner);
        // Rounding may move an image across the border where bodies moved as a group.
        if old.as_ref().map_or(0, |energies| energies.images.len())
            != self.far.near_images(&present)
        {
            old = self.stored(&present, Images::Near);
        }
        let poses = self.image_poses(&trial.pair(partner), Images::Near);
        // Within a tolerance energies are functions of the poses alone.
        let mut lists = Lists::new();
        // A list remembers where it was made; within a tolerance that history must not show.
        if let Some(energies) = old.as_deref().filter(|_| self.tolerance_kt.is_none()) {
            lists = energies.lists_at(&poses);
            // Due after some drift: errors have grown, and
            // new points are cheaper than finer levels.
            if energies.is_due(&poses, &lists) {
                // New lists for where the pair is now.
                old = self.stored(&present, Images::Near);
                if let Some(fresh) = &old {
                    lists = fresh.lists_at(&poses);
                    // The old energy is replaced for good, so that
                    // the next move begins from the new list.
                    self.energies.set(trial.body, partner, Arc::clone(fresh));
                }
            }
        }
        self.change_to(trial, partner, (old, poses, lists), Images::Near)
    }

    /// Change of the energy of the images of one partner that are far away.
    fn far_change(&mut self, trial: &Trial<'_>, partner: usize) -> Result<Option<Change>> {
        let old = self.stored(&trial.system.pair(trial.body, partner), Images::Far);
        let poses = self.image_poses(&trial.pair(partner), Images::Far);
        let lists = old.as_deref().map(|energies| energies.lists_at(&poses));
        let lists = lists.unwrap_or_default();
        self.change_to(trial, partner, (old, poses, lists), Images::Far)
    }

    /// The change of a partner's energy from what is known of it to these poses, where these lists
    /// serve.
    fn change_to(
        &mut self,
        trial: &Trial<'_>,
        partner: usize,
        (old, poses, lists): (Option<Arc<PoseEnergies>>, Vec<RelativePose>, Lists),
        images: Images,
    ) -> Result<Option<Change>> {
        let new = match poses.is_empty() {
            true => None,
            false => Some(self.known_at(&trial.pair(partner), poses, lists)),
        };
        // Out of range before and after: no term of the sum.
        if new.is_none() && old.is_none() {
            return Ok(None);
        }
        self.first_energies += 1;
        let mut change = Change {
            partner,
            new,
            old,
            level: EXPANDED,
            change_kt: 0.0,
            deviation_kt: 0.0,
            images,
        };
        (change.change_kt, change.deviation_kt) = self.change(trial, &change, EXPANDED)?;
        Ok(Some(change))
    }

    /// Whether the energy rises by less than the threshold: from the coarsest levels that leave no
    /// doubt.
    pub(super) fn rises_less(
        &mut self,
        trial: &Trial<'_>,
        changes: &mut Changes,
        threshold_kt: f64,
    ) -> Result<bool> {
        if self.tolerance_kt.is_some() {
            return Ok(self.rises_less_within(&mut changes.pairs, threshold_kt));
        }
        loop {
            let pairs = &changes.pairs;
            let rise: f64 = pairs.iter().map(|change| change.change_kt).sum();
            // Independent errors: variances add. Bounds of far images add as they are.
            let squares = pairs.iter().map(|change| change.deviation_kt.powi(2));
            let error = MULTIPLE * squares.sum::<f64>().sqrt();
            let is_open = (rise - threshold_kt).abs() <= error + changes.far.bound_kt();
            // Stops as soon as the threshold is outside the error, or nothing is left to refine.
            if !(is_open && self.refine(trial, changes, error)?) {
                self.count(&changes.pairs);
                return Ok(rise < threshold_kt);
            }
        }
    }

    /// Looks more closely where least is known: at images far away where their bound is as large as
    /// the likely error of the others (kT), else at the least certain of these. Returns whether
    /// anything was left to look at.
    fn refine(&mut self, trial: &Trial<'_>, changes: &mut Changes, error_kt: f64) -> Result<bool> {
        // While the far bound is the larger part of the doubt, near levels cannot settle it.
        if changes.far.bound_kt() >= error_kt
            && let Some(partner) = changes.far.take_widest()
        {
            changes.pairs.extend(self.far_change(trial, partner)?);
            return Ok(true);
        }
        let open = |change: &&mut Change| change.level < DIRECT;
        let widest = changes.pairs.iter_mut().filter(open);
        // One pair, one level: the sum is judged again after each step.
        let widest = widest.max_by(|a, b| a.deviation_kt.total_cmp(&b.deviation_kt));
        let Some(widest) = widest else {
            return Ok(false);
        };
        let level = widest.level + 1;
        let (change_kt, deviation_kt) = self.change(trial, widest, level)?;
        (widest.level, widest.change_kt, widest.deviation_kt) = (level, change_kt, deviation_kt);
        Ok(true)
    }

    /// Variant of [`rises_less`](Self::rises_less) by energies to within a tolerance for each pair;
    /// images far away hold less.
    fn rises_less_within(&mut self, changes: &mut [Change], threshold_kt: f64) -> bool {
        let mut rise = 0.0;
        for change in changes.iter_mut() {
            for (energies, sign) in [(&change.new, 1.0), (&change.old, -1.0)] {
                if let Some(energies) = energies {
                    let (energy_kt, level, _) = self.reported(energies, Images::Near);
                    // New minus old by the sign; both at the level that their tolerance needs.
                    rise += sign * energy_kt;
                    change.level = change.level.max(level);
                }
            }
        }
        self.count(changes);
        rise < threshold_kt
    }

    fn count(&mut self, changes: &[Change]) {
        match changes
            .iter()
            .map(|change| change.level)
            .max()
            .unwrap_or(EXPANDED)
        {
            EXPANDED => self.decided.expanded += 1,
            COARSE => self.decided.coarse += 1,
            FINE..DIRECT => self.decided.fine += 1,
            _ => self.decided.direct += 1,
        }
    }

    /// Proposes the new energies of the pairs; nothing is kept of images far away.
    pub(super) fn propose(&mut self, trial: &Trial<'_>, changes: Changes) {
        let near = |change: &Change| change.images == Images::Near;
        for change in changes.pairs.into_iter().filter(near) {
            let (first, second) = (
                trial.body.min(change.partner),
                trial.body.max(change.partner),
            );
            self.proposed
                .extend(change.new.map(|energies| (first, second, energies)));
        }
    }
}
