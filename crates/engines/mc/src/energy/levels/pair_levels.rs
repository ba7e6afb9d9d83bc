//! One pair of bodies: which images count, what is known of it at a pose, and its energy at each level
//! with the variance of its error.

use super::calibration::MULTIPLE;
use super::far::Images;
use super::list::List;
use super::maker::COARSE_OPENING;
use super::model::Levels;
use super::sharpening::STEPS;
use super::stored::{Image, Lists, PoseEnergies};
use super::table::{Estimate, Table, fine_deviation};
use crate::Result;
use crate::energy::{finite, pair_energy_kt};
use crate::system::Pair;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use smallvec::SmallVec;
use std::sync::{Arc, OnceLock};

pub(super) const EXPANDED: usize = 0;
pub(super) const COARSE: usize = 1;
pub(super) const FINE: usize = 2;
pub(super) const DIRECT: usize = FINE + 1 + STEPS;

impl Levels {
    fn tables_of(&self, (first, second): (usize, usize)) -> (&Table, &Table) {
        (&self.tables[first], &self.tables[second])
    }

    /// The poses of the images in reach, the near ones or those farther away.
    pub(super) fn image_poses(&self, pair: &Pair<'_>, images: Images) -> Vec<RelativePose> {
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
    pub(super) fn energy_alone_kt(&self, pair: &Pair<'_>) -> Result<f64> {
        let (first, second) = self.tables_of(pair.type_indices());
        let mut energy_kt = 0.0;
        let near_and_far = [Images::Near, Images::Far].map(|images| self.image_poses(pair, images));
        for pose in near_and_far.into_iter().flatten() {
            let image = first.energy_alone_kt(second, &pose);
            energy_kt += image.unwrap_or_else(|| {
                // Beyond the table: rare, and the direct sum is exact.
                pair_energy_kt(&self.potential, &first.charges, &second.charges, &pose)
            });
        }
        finite(pair.first, pair.second, energy_kt)
    }

    /// The pair at its present pose, with its near images or those farther away; `None` without any.
    pub(super) fn stored(&self, pair: &Pair<'_>, images: Images) -> Option<Arc<PoseEnergies>> {
        let poses = self.image_poses(pair, images);
        match poses.is_empty() {
            true => None,
            false => Some(self.known_at(pair, poses, Lists::new())),
        }
    }

    /// The pair with images at these relative poses, and lists where some serve there.
    pub(super) fn known_at(
        &self,
        pair: &Pair<'_>,
        poses: Vec<RelativePose>,
        mut lists: Lists,
    ) -> Arc<PoseEnergies> {
        let (first, second) = self.tables_of(pair.type_indices());
        let (mut images, mut expanded_kt) = (SmallVec::with_capacity(poses.len()), Some(0.0));
        for (number, relative) in poses.into_iter().enumerate() {
            // A list from before the move is used again; it is taken, as the lists are handed over.
            let reusable_list = lists.get_mut(number).and_then(Option::take);
            let (list, slack_angstrom, energy) = match reusable_list {
                Some((list, slack)) => {
                    let energy = list.energy(first, &relative);
                    (list, slack, energy)
                }
                None => {
                    let list = List::new(first, second, &relative, COARSE_OPENING);
                    // Without the expansion: it is made once the list has proved to be used again.
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
                // NaN marks an image without a table; `coarse_kt` then takes the direct sum.
                close_kt: energy.map_or(f64::NAN, |energy| energy.close_kt),
                expansion_variance: energy.map_or(0.0, |energy| energy.expansion_variance),
                ranking: OnceLock::new(),
            });
        }
        let mut energies = PoseEnergies {
            types: pair.type_indices(),
            images,
            expanded_kt: 0.0,
            coarse_kt: OnceLock::new(),
            fine: OnceLock::new(),
            direct_kt: OnceLock::new(),
        };
        // Where the tables end, the direct sum is all there is.
        energies.expanded_kt = expanded_kt.unwrap_or_else(|| self.direct_kt(&energies));
        Arc::new(energies)
    }

    /// The energy of a pair at one level, kT, and its variance.
    pub(super) fn energy(&self, energies: &PoseEnergies, level: usize) -> (f64, f64) {
        match level {
            EXPANDED | COARSE => {
                let images = energies.images.iter();
                let variances = images.map(|image| self.variance(image, level));
                // Computed at most once per pose, by whoever asks first.
                let energy_kt = match level {
                    EXPANDED => energies.expanded_kt,
                    _ => *energies.coarse_kt.get_or_init(|| self.coarse_kt(energies)),
                };
                (energy_kt, variances.sum())
            }
            FINE..DIRECT => {
                let estimate = self.fine_estimate(energies, level - FINE);
                (estimate.energy_kt, estimate.variance)
            }
            _ => (self.direct_kt(energies), 0.0),
        }
    }

    /// The energy of a pair that is reported: a function of its pose alone. With the level and the
    /// error it is likely within, kT.
    pub(super) fn reported(&self, energies: &PoseEnergies, images: Images) -> (f64, usize, f64) {
        let first = match (images, self.tolerance_kt) {
            (Images::Near, None) => FINE,
            _ => COARSE,
        };
        let tolerance_kt = self.tolerance_kt.unwrap_or(f64::INFINITY);
        // The first level that is good enough; far images begin lower, as they hold little.
        for level in first..DIRECT {
            let (energy_kt, variance) = self.energy(energies, level);
            let error_kt = MULTIPLE * variance.sqrt();
            if error_kt <= tolerance_kt {
                return (energy_kt, level, error_kt);
            }
        }
        (self.direct_kt(energies), DIRECT, 0.0)
    }

    /// The sum over the images, each with all points of its list.
    fn coarse_kt(&self, energies: &PoseEnergies) -> f64 {
        let first = self.tables_of(energies.types).0;
        let energy = |image: &Image| {
            let far_kt = image.list.far_energy(first, &image.relative)?;
            Some(image.close_kt + far_kt)
        };
        let sum: Option<f64> = energies.images.iter().map(energy).sum();
        // A NaN from an image beyond the table.
        let sum = sum.filter(|sum| sum.is_finite());
        sum.unwrap_or_else(|| self.direct_kt(energies))
    }

    /// The energy from the fine tables after so many steps of sharpening; the direct sum where they
    /// end before.
    fn fine_estimate(&self, energies: &PoseEnergies, steps: usize) -> Estimate {
        let fine = energies.fine.get_or_init(Box::default);
        *fine[steps].get_or_init(|| {
            let estimate = match steps.checked_sub(1) {
                None => self.in_fine_tables(energies),
                Some(step) => self.sharpened(energies, step),
            };
            estimate.unwrap_or_else(|| Estimate {
                energy_kt: self.direct_kt(energies),
                variance: 0.0,
            })
        })
    }

    /// The sum over the images, each with the charges of the second body in the fine table of the
    /// first.
    fn in_fine_tables(&self, energies: &PoseEnergies) -> Option<Estimate> {
        let (first, second) = self.tables_of(energies.types);
        let (mut energy_kt, mut variance) = (0.0, 0.0);
        for image in &energies.images {
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
    fn sharpened(&self, energies: &PoseEnergies, step: usize) -> Option<Estimate> {
        let (first, second) = self.tables_of(energies.types);
        // Each step builds on the one before, which is computed here if it was not yet.
        let (mut energy_kt, mut variance) = (self.fine_estimate(energies, step).energy_kt, 0.0);
        for image in &energies.images {
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

    /// Variance of the fine energy of an image after so many steps of sharpening, kT²; `modelled`
    /// is that of the error model.
    fn fine_variance(&self, image: &Image, steps: usize, modelled: f64) -> f64 {
        let scale = self.calibration.scales(&image.list).fine[steps];
        (scale * fine_deviation(modelled)).powi(2)
    }

    fn direct_kt(&self, energies: &PoseEnergies) -> f64 {
        // Kept: the most expensive number of the pair.
        *energies.direct_kt.get_or_init(|| {
            let (first, second) = self.tables_of(energies.types);
            let energy = |image: &Image| {
                pair_energy_kt(
                    &self.potential,
                    &first.charges,
                    &second.charges,
                    &image.relative,
                )
            };
            energies.images.iter().map(energy).sum()
        })
    }

    /// Variance of the energy of an image from its list, kT².
    fn variance(&self, image: &Image, level: usize) -> f64 {
        let scales = self.calibration.scales(&image.list);
        let points = image.list.variance * scales.coarse.energy.powi(2);
        match level {
            EXPANDED => points + image.expansion_variance * scales.expansion.energy.powi(2),
            _ => points,
        }
    }

    /// Variance of the change of the energy of a pair, kT². Errors from the same points cancel, the
    /// more so the less the pair has moved.
    pub(super) fn change_variance(
        &self,
        new: &PoseEnergies,
        old: &PoseEnergies,
        level: usize,
    ) -> f64 {
        let mut variance = 0.0;
        // Images appear and vanish at the border; one
        // without a partner counts with its whole error.
        for number in 0..new.images.len().max(old.images.len()) {
            let (new, old) = (new.images.get(number), old.images.get(number));
            let images = new.into_iter().chain(old);
            let apart: f64 = images.map(|image| self.variance(image, level)).sum();
            variance += match (new, old) {
                // The very same list, by its address: only
                // then do the same points stand at both ends.
                (Some(new), Some(old)) if Arc::ptr_eq(&new.list, &old.list) => {
                    apart.min(self.moved_variance(new, old, level))
                }
                _ => apart,
            };
        }
        variance
    }

    /// Variance of the change of the energy of an image from one list at two poses, kT².
    fn moved_variance(&self, new: &Image, old: &Image, level: usize) -> f64 {
        let (list, from, to) = (&new.list, &old.relative, &new.relative);
        let scales = self.calibration.scales(list);
        let points = list.change_variance(from, to) * scales.coarse.change.powi(2);
        if level == COARSE {
            return points;
        }
        // The larger variance of both ends, so that the estimate does not depend on the direction.
        let expansion = new.expansion_variance.max(old.expansion_variance);
        let expansion = expansion * list.expansion_shift(from, to).powi(2);
        points + expansion * scales.expansion.change.powi(2)
    }
}
