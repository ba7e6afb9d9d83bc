//! The energy model: decisions from the coarsest level that settles them.

use super::calibration::{Calibration, MULTIPLE};
use super::far::{Far, FarImages, Images};
use super::known::{Image, Known, Lists};
use super::lanes::prefetch;
use super::list::List;
use super::maker::COARSE_OPENING;
use super::sharpening::STEPS;
use super::table::{Estimate, Table, fine_deviation};
use crate::energy::direct::direct_energy_kt;
use crate::energy::reach::{Reach, require_room};
use crate::energy::{
    Effort, EnergyModel, LevelReport, PairEnergy, Pairs, SitePotential, all_pairs, finite,
    pair_energy_kt, sum_of_pairs,
};
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::{BodyType, Result};
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use serde::Serialize;
use smallvec::SmallVec;
use std::sync::{Arc, OnceLock};

/// How many decisions each level made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Decided {
    /// From lists of points, the far ones expanded about an earlier pose.
    pub expanded: u64,
    /// With all points of a list in coarse tables, for one pair of bodies or more.
    pub coarse: u64,
    /// With all charges in fine tables, for one pair of bodies or more, or all but the least certain.
    pub fine: u64,
    /// With a direct sum for one pair of bodies or more.
    pub direct: u64,
}

/// Energies by levels.
#[derive(Debug, Clone)]
pub struct Levels<P> {
    potential: P,
    tables: Vec<Arc<Table<P>>>,
    calibration: Calibration,
    tolerance_kt: Option<f64>,
    reach: Reach,
    far: Far,
    energies: PairTable<Arc<Known>>,
    proposed: Vec<(usize, usize, Arc<Known>)>,
    decided: Decided,
    first_energies: u64,
}

/// A pair in a decision: its energy after the move and before.
struct Change {
    partner: usize,
    new: Option<Arc<Known>>,
    old: Option<Arc<Known>>,
    level: usize,
    /// Of the energy, kT, and its standard deviation.
    change_kt: f64,
    deviation_kt: f64,
    /// Of images far away nothing is kept.
    images: Images,
}

/// What a decision rests on: pairs with what is known of them, and a bound for the others.
#[derive(Default)]
struct Changes {
    known: Vec<Change>,
    far: FarImages,
}

const EXPANDED: usize = 0;
const COARSE: usize = 1;
const FINE: usize = 2;
const DIRECT: usize = FINE + 1 + STEPS;

impl<P: SitePotential> Levels<P> {
    /// The model for this potential and system, with a table for each of its body types. Their levels
    /// are compared here.
    pub fn with_tables(potential: P, system: &System, tables: Vec<Arc<Table<P>>>) -> Self {
        let calibration = Calibration::of_system(&potential, system, &tables);
        Self::with_calibration(potential, tables, calibration)
    }

    /// The model with tables whose levels have been compared.
    pub fn with_calibration(
        potential: P,
        tables: Vec<Arc<Table<P>>>,
        calibration: Calibration,
    ) -> Self {
        Self {
            calibration,
            potential,
            tables,
            tolerance_kt: None,
            reach: Reach::default(),
            far: Far::default(),
            energies: PairTable::new(0),
            proposed: Vec::new(),
            decided: Decided::default(),
            first_energies: 0,
        }
    }

    /// The model with tables made here.
    pub fn for_system(potential: P, system: &System) -> Self {
        let reach = table_reach_angstrom(&potential, system);
        let table = |kind: &Arc<BodyType>| Arc::new(Table::new(&kind.charges, &potential, reach));
        let tables = system.types().iter().map(table).collect();
        Self::with_tables(potential, system, tables)
    }

    /// The same levels without the direct sum's decisions: each pair energy from the first level
    /// whose error is likely (within [`MULTIPLE`] standard deviations) below `tolerance_kt`.
    pub fn with_tolerance(mut self, tolerance_kt: f64) -> Self {
        self.tolerance_kt = Some(tolerance_kt);
        self
    }

    /// How many decisions each level made.
    pub fn decided(&self) -> Decided {
        self.decided
    }

    /// The built-in comparison.
    pub fn calibration(&self) -> Calibration {
        self.calibration
    }

    /// How many pair energies were found at the first level.
    pub fn first_energies(&self) -> u64 {
        self.first_energies
    }

    fn prepare(&mut self, system: &System) {
        self.reach = Reach::of_multipoles(system, &self.potential);
        self.far = Far::new(system, &self.potential, &self.reach, self.tolerance_kt);
        self.proposed.clear();
    }

    /// Asks for what is known of a body's pairs. In a large system it is far from the processor, in
    /// three steps from pointer to pointer; those of all pairs are taken at once.
    fn prefetch(&self, body: usize) {
        let known = self.energies.row(body).map(|(_, known)| known);
        known.clone().for_each(|known| prefetch(known.as_ref()));
        let images = known.flat_map(|known| &known.images);
        let lists = images.map(|image| image.list.as_ref());
        lists.clone().for_each(prefetch);
        lists.for_each(List::prefetch);
    }

    fn tables_of(&self, (first, second): (usize, usize)) -> (&Table<P>, &Table<P>) {
        (&self.tables[first], &self.tables[second])
    }

    /// The poses of the images in reach, the near ones or those farther away.
    fn image_poses(&self, pair: &Pair<'_>, images: Images) -> Vec<RelativePose> {
        let reach = match images {
            Images::Near => self.far.near(),
            Images::Far => &self.reach,
        };
        if !reach.is_met(pair) {
            return Vec::new();
        }
        let is_wanted = |image: &Vec3| self.far.which(pair, image) == images;
        let wanted = reach.images(pair).filter(is_wanted);
        wanted.map(|image| pair.relative_image(&image)).collect()
    }

    /// The energy of a pair from fine tables without lists, kT.
    fn energy_alone_kt(&self, pair: &Pair<'_>) -> Result<f64> {
        let (first, second) = self.tables_of(pair.type_indices());
        let mut energy_kt = 0.0;
        let near_and_far = [Images::Near, Images::Far].map(|images| self.image_poses(pair, images));
        for pose in near_and_far.into_iter().flatten() {
            let image = first.energy_alone_kt(second, &pose);
            energy_kt += image.unwrap_or_else(|| {
                pair_energy_kt(&self.potential, &first.charges, &second.charges, &pose)
            });
        }
        finite(pair.first, pair.second, energy_kt)
    }

    /// The pair at its present pose, with its near images or those farther away; `None` without any.
    fn known(&self, pair: &Pair<'_>, images: Images) -> Option<Arc<Known>> {
        let poses = self.image_poses(pair, images);
        match poses.is_empty() {
            true => None,
            false => Some(self.known_at(pair, poses, Lists::new())),
        }
    }

    /// The pair with images at these relative poses, and lists where some serve there.
    fn known_at(&self, pair: &Pair<'_>, poses: Vec<RelativePose>, mut lists: Lists) -> Arc<Known> {
        let (first, second) = self.tables_of(pair.type_indices());
        let (mut images, mut expanded_kt) = (SmallVec::with_capacity(poses.len()), Some(0.0));
        for (number, relative) in poses.into_iter().enumerate() {
            let kept = lists.get_mut(number).and_then(Option::take);
            let (list, slack_angstrom, energy) = match kept {
                Some((list, slack)) => {
                    let energy = list.energy(first, &relative);
                    (list, slack, energy)
                }
                None => {
                    let list = List::new(first, second, &relative, COARSE_OPENING);
                    let energy = list.energy_of_points(first, &relative);
                    let slack_angstrom = list.slack_angstrom(&relative);
                    (Arc::new(list), slack_angstrom, energy)
                }
            };
            let sum = expanded_kt.zip(energy);
            expanded_kt = sum.map(|(sum, energy)| sum + energy.expanded_kt);
            images.push(Image {
                relative,
                list,
                slack_angstrom,
                close_kt: energy.map_or(f64::NAN, |energy| energy.close_kt),
                expansion_variance: energy.map_or(0.0, |energy| energy.expansion_variance),
                ranking: OnceLock::new(),
            });
        }
        let mut known = Known {
            types: pair.type_indices(),
            images,
            expanded_kt: 0.0,
            coarse_kt: OnceLock::new(),
            fine: OnceLock::new(),
            direct_kt: OnceLock::new(),
        };
        // Where the tables end, the direct sum is all there is.
        known.expanded_kt = expanded_kt.unwrap_or_else(|| self.direct_kt(&known));
        Arc::new(known)
    }

    /// The change of the energy of a pair at one level, kT, with its standard deviation.
    fn change(&self, trial: &Trial<'_>, change: &Change, level: usize) -> Result<(f64, f64)> {
        let (new, old) = (change.new.as_deref(), change.old.as_deref());
        let of =
            |known: Option<&Known>| known.map_or((0.0, 0.0), |known| self.energy(known, level));
        let ((new_kt, new_variance), (old_kt, old_variance)) = (of(new), of(old));
        let variance = match (level, new, old) {
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

    /// The energy of a pair at one level, kT, and its variance.
    fn energy(&self, known: &Known, level: usize) -> (f64, f64) {
        match level {
            EXPANDED | COARSE => {
                let images = known.images.iter();
                let variances = images.map(|image| self.variance(image, level));
                let energy_kt = match level {
                    EXPANDED => known.expanded_kt,
                    _ => *known.coarse_kt.get_or_init(|| self.coarse_kt(known)),
                };
                (energy_kt, variances.sum())
            }
            FINE..DIRECT => {
                let estimate = self.fine_estimate(known, level - FINE);
                (estimate.energy_kt, estimate.variance)
            }
            _ => (self.direct_kt(known), 0.0),
        }
    }

    /// The energy of a pair that is reported: a function of its pose alone. With the level and the
    /// error it is likely within, kT.
    fn reported(&self, known: &Known, images: Images) -> (f64, usize, f64) {
        let first = match (images, self.tolerance_kt) {
            (Images::Near, None) => FINE,
            _ => COARSE,
        };
        let tolerance_kt = self.tolerance_kt.unwrap_or(f64::INFINITY);
        for level in first..DIRECT {
            let (energy_kt, variance) = self.energy(known, level);
            let error_kt = MULTIPLE * variance.sqrt();
            if error_kt <= tolerance_kt {
                return (energy_kt, level, error_kt);
            }
        }
        (self.direct_kt(known), DIRECT, 0.0)
    }

    /// The sum over the images, each with all points of its list.
    fn coarse_kt(&self, known: &Known) -> f64 {
        let first = self.tables_of(known.types).0;
        let energy = |image: &Image| {
            let far_kt = image.list.far_energy(first, &image.relative)?;
            Some(image.close_kt + far_kt)
        };
        let sum: Option<f64> = known.images.iter().map(energy).sum();
        let sum = sum.filter(|sum| sum.is_finite());
        sum.unwrap_or_else(|| self.direct_kt(known))
    }

    /// From the fine tables after so many steps of sharpening; the direct sum where they end before.
    fn fine_estimate(&self, known: &Known, steps: usize) -> Estimate {
        let fine = known.fine.get_or_init(Box::default);
        *fine[steps].get_or_init(|| {
            let estimate = match steps.checked_sub(1) {
                None => self.in_fine_tables(known),
                Some(step) => self.sharpened(known, step),
            };
            estimate.unwrap_or_else(|| Estimate {
                energy_kt: self.direct_kt(known),
                variance: 0.0,
            })
        })
    }

    /// The sum over the images, each with the charges of the second body in the fine table of the
    /// first.
    fn in_fine_tables(&self, known: &Known) -> Option<Estimate> {
        let (first, second) = self.tables_of(known.types);
        let (mut energy_kt, mut variance) = (0.0, 0.0);
        for image in &known.images {
            let fine = first.fine_energy(second, &image.list, &image.relative)?;
            energy_kt += fine.energy_kt;
            variance += self.fine_variance(image, 0, fine.variance);
        }
        Some(Estimate {
            energy_kt,
            variance,
        })
    }

    /// The estimate before this step of sharpening, with what the step adds.
    fn sharpened(&self, known: &Known, step: usize) -> Option<Estimate> {
        let (first, second) = self.tables_of(known.types);
        let (mut energy_kt, mut variance) = (self.fine_estimate(known, step).energy_kt, 0.0);
        for image in &known.images {
            let pose = &image.relative;
            let make = || first.ranking(second, pose).map(Box::new);
            let ranking = image.ranking.get_or_init(make);
            let ranking = ranking.as_ref()?;
            energy_kt += first.correction_kt(second, pose, ranking, step)?;
            variance += self.fine_variance(image, 1 + step, ranking.variance(step));
        }
        Some(Estimate {
            energy_kt,
            variance,
        })
    }

    /// Of the fine energy of an image after so many steps of sharpening, kT²; `modelled` by the error
    /// model.
    fn fine_variance(&self, image: &Image, steps: usize, modelled: f64) -> f64 {
        let scale = self.calibration.of(&image.list).fine[steps];
        (scale * fine_deviation(modelled)).powi(2)
    }

    fn direct_kt(&self, known: &Known) -> f64 {
        *known.direct_kt.get_or_init(|| {
            let (first, second) = self.tables_of(known.types);
            let energy = |image: &Image| {
                pair_energy_kt(
                    &self.potential,
                    &first.charges,
                    &second.charges,
                    &image.relative,
                )
            };
            known.images.iter().map(energy).sum()
        })
    }

    /// Of the energy of an image from its list, kT².
    fn variance(&self, image: &Image, level: usize) -> f64 {
        let scales = self.calibration.of(&image.list);
        let points = image.list.variance * scales.coarse.energy.powi(2);
        match level {
            EXPANDED => points + image.expansion_variance * scales.expansion.energy.powi(2),
            _ => points,
        }
    }

    /// Errors from the same points cancel, the more so the less the pair has moved.
    fn change_variance(&self, new: &Known, old: &Known, level: usize) -> f64 {
        let mut variance = 0.0;
        for number in 0..new.images.len().max(old.images.len()) {
            let (new, old) = (new.images.get(number), old.images.get(number));
            let images = new.into_iter().chain(old);
            let apart: f64 = images.map(|image| self.variance(image, level)).sum();
            variance += match (new, old) {
                (Some(new), Some(old)) if Arc::ptr_eq(&new.list, &old.list) => {
                    apart.min(self.moved_variance(new, old, level))
                }
                _ => apart,
            };
        }
        variance
    }

    /// Of the change of the energy of an image from one list at two poses, kT².
    fn moved_variance(&self, new: &Image, old: &Image, level: usize) -> f64 {
        let (list, from, to) = (&new.list, &old.relative, &new.relative);
        let scales = self.calibration.of(list);
        let points = list.change_variance(from, to) * scales.coarse.change.powi(2);
        if level == COARSE {
            return points;
        }
        let expansion = new.expansion_variance.max(old.expansion_variance);
        let expansion = expansion * list.expansion_shift(from, to).powi(2);
        points + expansion * scales.expansion.change.powi(2)
    }

    /// What becomes of the near images of one partner, at the first level.
    fn first_change(&mut self, trial: &Trial<'_>, partner: usize) -> Result<Option<Change>> {
        let present = trial.system.pair(trial.body, partner);
        let mut old = self.energies.get(trial.body, partner);
        // Rounding may move an image across the border where bodies moved as a group.
        if old.as_ref().map_or(0, |known| known.images.len()) != self.far.near_images(&present) {
            old = self.known(&present, Images::Near);
        }
        let poses = self.image_poses(&trial.pair(partner), Images::Near);
        // Within a tolerance energies are functions of the poses alone.
        let mut lists = Lists::new();
        if let Some(known) = old.as_deref().filter(|_| self.tolerance_kt.is_none()) {
            lists = known.lists_at(&poses);
            if known.is_due(&poses, &lists) {
                // New lists for where the pair is now.
                old = self.known(&present, Images::Near);
                if let Some(fresh) = &old {
                    lists = fresh.lists_at(&poses);
                    self.energies.set(trial.body, partner, Arc::clone(fresh));
                }
            }
        }
        self.change_to(trial, partner, (old, poses, lists), Images::Near)
    }

    /// What becomes of the images of one partner that are far away.
    fn far_change(&mut self, trial: &Trial<'_>, partner: usize) -> Result<Option<Change>> {
        let old = self.known(&trial.system.pair(trial.body, partner), Images::Far);
        let poses = self.image_poses(&trial.pair(partner), Images::Far);
        let lists = old.as_deref().map(|known| known.lists_at(&poses));
        let lists = lists.unwrap_or_default();
        self.change_to(trial, partner, (old, poses, lists), Images::Far)
    }

    /// The change of a partner's energy from what is known of it to these poses, where these lists
    /// serve.
    fn change_to(
        &mut self,
        trial: &Trial<'_>,
        partner: usize,
        (old, poses, lists): (Option<Arc<Known>>, Vec<RelativePose>, Lists),
        images: Images,
    ) -> Result<Option<Change>> {
        let new = match poses.is_empty() {
            true => None,
            false => Some(self.known_at(&trial.pair(partner), poses, lists)),
        };
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
    fn rises_less(
        &mut self,
        trial: &Trial<'_>,
        changes: &mut Changes,
        threshold_kt: f64,
    ) -> Result<bool> {
        if self.tolerance_kt.is_some() {
            return Ok(self.rises_less_within(&mut changes.known, threshold_kt));
        }
        loop {
            let known = &mut changes.known;
            let rise: f64 = known.iter().map(|change| change.change_kt).sum();
            let squares = known.iter().map(|change| change.deviation_kt.powi(2));
            let error = MULTIPLE * squares.sum::<f64>().sqrt();
            let far = changes.far.bound_kt();
            if (rise - threshold_kt).abs() > error + far {
                self.count(known);
                return Ok(rise < threshold_kt);
            }
            if far >= error
                && let Some(partner) = changes.far.take_widest()
            {
                changes.known.extend(self.far_change(trial, partner)?);
                continue;
            }
            let open = |change: &&mut Change| change.level < DIRECT;
            let widest = known.iter_mut().filter(open);
            let widest = widest.max_by(|a, b| a.deviation_kt.total_cmp(&b.deviation_kt));
            let Some(widest) = widest else {
                self.count(known);
                return Ok(rise < threshold_kt);
            };
            let level = widest.level + 1;
            let (change_kt, deviation_kt) = self.change(trial, widest, level)?;
            (widest.level, widest.change_kt, widest.deviation_kt) =
                (level, change_kt, deviation_kt);
        }
    }

    /// The same by energies to within a tolerance for each pair; images far away hold less.
    fn rises_less_within(&mut self, changes: &mut [Change], threshold_kt: f64) -> bool {
        let mut rise = 0.0;
        for change in changes.iter_mut() {
            for (known, sign) in [(&change.new, 1.0), (&change.old, -1.0)] {
                if let Some(known) = known {
                    let (energy_kt, level, _) = self.reported(known, Images::Near);
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

    /// All pairs in reach, ascending.
    fn all_reported<'a>(&'a self, system: &'a System) -> impl Iterator<Item = Reported> + 'a {
        let bodies = 0..system.len();
        let pairs =
            bodies.flat_map(|first| (first + 1..system.len()).map(move |second| (first, second)));
        pairs.filter_map(|(first, second)| {
            let near = self.energies.get(first, second);
            let far = self.known(&system.pair(first, second), Images::Far);
            let of_near = near
                .as_deref()
                .map(|known| self.reported(known, Images::Near));
            let of_far = far
                .as_deref()
                .map(|known| self.reported(known, Images::Far));
            let both = of_near.into_iter().chain(of_far);
            let sum = both.fold((0.0, 0.0), |sum, (energy_kt, _, error_kt)| {
                (sum.0 + energy_kt, sum.1 + error_kt)
            });
            (near.is_some() || far.is_some()).then_some(Reported {
                first,
                second,
                near,
                energy_kt: sum.0,
                error_kt: sum.1,
            })
        })
    }

    /// Nothing is kept of images far away.
    fn propose(&mut self, trial: &Trial<'_>, changes: Changes) {
        let near = |change: &Change| change.images == Images::Near;
        for change in changes.known.into_iter().filter(near) {
            let (first, second) = (
                trial.body.min(change.partner),
                trial.body.max(change.partner),
            );
            self.proposed
                .extend(change.new.map(|known| (first, second, known)));
        }
    }
}

/// What is known of a pair, if its energy is finite.
fn checked(pair: &Pair<'_>, known: Arc<Known>) -> Result<Arc<Known>> {
    finite(pair.first, pair.second, known.expanded_kt)?;
    Ok(known)
}

/// The energy of a pair as it is reported.
struct Reported {
    first: usize,
    second: usize,
    near: Option<Arc<Known>>,
    energy_kt: f64,
    error_kt: f64,
}

/// How far from its charges a table must reach for this system, Å.
pub fn table_reach_angstrom<P: SitePotential>(potential: &P, system: &System) -> f64 {
    Reach::of_multipoles(system, potential).largest_angstrom()
}

impl<P: SitePotential> EnergyModel for Levels<P> {
    /// That of the direct sum: a cluster move draws a random number for each body in the cells of this
    /// size around a place, and must draw the same ones.
    fn range_angstrom(&self, system: &System) -> f64 {
        Reach::new(system, &self.potential).largest_angstrom()
    }

    fn reach_angstrom(&self, system: &System) -> f64 {
        table_reach_angstrom(&self.potential, system)
    }

    fn require_room(&self, system: &System) -> Result<()> {
        require_room(system, &self.potential)
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| {
            let known = self.known(pair, Images::Near);
            known.map(|known| checked(pair, known)).transpose()
        })?;
        Ok(())
    }

    /// Energies from fine tables, whatever decisions asked for: functions of the poses alone. What is
    /// far away is found here.
    fn pairs(&self, system: &System) -> Vec<PairEnergy> {
        let reported = |pair: Reported| {
            let near = pair.near.as_deref().map_or(&[][..], |near| &near.images);
            let images = near.iter().map(|image| image.relative);
            PairEnergy::found_at(pair.first, pair.second, pair.energy_kt, images)
        };
        self.all_reported(system).map(reported).collect()
    }

    /// Energies are found anew where they were found first; lists are chosen there.
    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.prepare(system);
        self.energies = PairTable::new(system.len());
        for saved in pairs {
            let pair = system.pair(saved.first, saved.second);
            let poses = match saved.computed_at {
                Some(_) => saved.images(&pair).collect(),
                None => self.image_poses(&pair, Images::Near),
            };
            if !poses.is_empty() {
                let known = self.known_at(&pair, poses, Lists::new());
                let known = checked(&pair, known)?;
                self.energies.set(saved.first, saved.second, known);
            }
        }
        Ok(())
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        self.prefetch(trial.body);
        let row = self.energies.row(trial.body);
        let mut near: Vec<usize> = row.map(|(partner, _)| partner).collect();
        let mut changes = Changes::default();
        for &partner in partners {
            let [before, after] = [trial.system.pair(trial.body, partner), trial.pair(partner)];
            let bound_kt = self.far.bound_kt(&before) + self.far.bound_kt(&after);
            changes.far.add(partner, bound_kt);
            if self.far.near().is_met(&after) {
                near.push(partner);
            }
        }
        near.sort_unstable();
        near.dedup();
        for partner in near {
            changes.known.extend(self.first_change(trial, partner)?);
        }
        let accepted = self.rises_less(trial, &mut changes, budget_kt)?;
        self.propose(trial, changes);
        Ok(accepted)
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        let mut changes = Changes::default();
        let [before, after] = [trial.system.pair(trial.body, partner), trial.pair(partner)];
        let bound_kt = self.far.bound_kt(&before) + self.far.bound_kt(&after);
        changes.far.add(partner, bound_kt);
        changes.known.extend(self.first_change(trial, partner)?);
        let exceeds = !self.rises_less(trial, &mut changes, threshold_kt)?;
        self.propose(trial, changes);
        Ok(exceeds)
    }

    fn commit(&mut self, moved: &[usize]) {
        self.energies.take_over(moved, self.proposed.drain(..));
    }

    fn reject(&mut self) {
        self.proposed.clear();
    }

    fn error_bound_kt(&self, system: &System) -> f64 {
        let errors = self.all_reported(system).map(|pair| pair.error_kt);
        errors.fold(0.0, f64::max)
    }

    /// Quick energies are those of fine tables.
    fn energy_elsewhere_kt(&self, system: &System, of: Pairs<'_>, effort: Effort) -> Result<f64> {
        let reach_of_all = Reach::new(system, &self.potential);
        sum_of_pairs(system, of, |pair| match effort {
            Effort::Quick => self.energy_alone_kt(pair).map(Some),
            Effort::Full => direct_energy_kt(&self.potential, &reach_of_all, pair),
        })
    }

    fn levels(&self) -> Option<LevelReport> {
        Some(LevelReport::Calibrated {
            decided_by_level: self.decided,
            calibration: self.calibration,
        })
    }

    fn memory_bytes(&self) -> usize {
        self.tables.iter().map(|table| table.memory_bytes()).sum()
    }
}
