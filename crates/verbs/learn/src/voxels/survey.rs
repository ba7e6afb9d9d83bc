//! How many structures will not fit, before any is voxelised, and what would take them all.

use super::manifest::Manifest;
use super::settings::{Spacing, VoxelizeSettings};
use super::structure::{extent_angstrom, voxels_needed};
use protomer_field::voxels::lattice::{SIZE_RANGE, SPACING_RANGE_ANGSTROM};
use protomer_results::Shard;
use rayon::prelude::*;

/// Sizes of the structures of a manifest, compared with the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Survey {
    /// Structures that can be read and are proteins.
    pub structures: usize,
    /// Structures that do not fit in the grid.
    pub too_large: usize,
    /// The largest extent along an axis of the grid, as the structures will be turned, Å.
    pub largest_extent_angstrom: f64,
    /// Spacing of the grid that the structures were held against, Å: for `fit` the largest.
    pub spacing_angstrom: f64,
    /// Voxels along each edge.
    pub size: usize,
}

/// Reads every structure of a part of a manifest, but voxelises none. This takes about a hundredth
/// of the time of voxelising.
///
/// ```no_run
/// use protomer_learn_verbs::voxels::{VoxelizeSettings, manifest::Manifest, survey::survey};
/// use protomer_results::Shard;
/// use std::path::Path;
/// let manifest = Manifest::read(Path::new("set.csv"))?;
/// let survey = survey(&manifest, Shard::WHOLE, &VoxelizeSettings::default());
/// println!("{}", survey.note().unwrap_or_default());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn survey(manifest: &Manifest, shard: Shard, settings: &VoxelizeSettings) -> Survey {
    let numbers = (0..manifest.len()).into_par_iter();
    let numbers = numbers.filter(|number| shard.has(*number));
    let extent = |number: usize| extent_angstrom(&manifest.entry(number).ok()?, settings);
    let extents: Vec<f64> = numbers.filter_map(extent).collect();
    Survey::of_extents(&extents, settings)
}

impl Survey {
    fn of_extents(extents: &[f64], settings: &VoxelizeSettings) -> Self {
        let spacing_angstrom = match settings.spacing {
            Spacing::Angstrom(spacing) => spacing,
            Spacing::Fit(_) => SPACING_RANGE_ANGSTROM.1,
        };
        let fits = |extent: &f64| voxels_needed(*extent, spacing_angstrom) <= settings.size;
        Self {
            structures: extents.len(),
            too_large: extents.iter().filter(|extent| !fits(extent)).count(),
            largest_extent_angstrom: extents.iter().fold(0.0, |most, extent| extent.max(most)),
            spacing_angstrom,
            size: settings.size,
        }
    }

    /// The warning before the work, if structures will be left out.
    pub fn note(&self) -> Option<String> {
        if self.too_large == 0 {
            return None;
        }
        let (largest, coarsest) = (self.largest_extent_angstrom, SPACING_RANGE_ANGSTROM.1);
        let mut remedies = Vec::new();
        let size = voxels_needed(largest, self.spacing_angstrom);
        if size <= SIZE_RANGE.1 {
            remedies.push(format!("--size {size}"));
        }
        // Rounded up to what a command can say.
        let spacing = (100.0 * largest / (self.size as f64 - 1.0)).ceil() / 100.0;
        if spacing <= coarsest && self.spacing_angstrom < coarsest {
            remedies.push(format!("--spacing {spacing}"));
            remedies.push("--spacing fit".to_owned());
        } else if self.spacing_angstrom < coarsest {
            let size = voxels_needed(largest, coarsest);
            remedies.push(format!("--size {size} --spacing fit"));
        }
        Some(format!(
            "warning: {} of {} structures do not fit {} voxels of {} Å and will be left out; the \
             largest is {largest:.0} Å across: all would fit with {}",
            self.too_large,
            self.structures,
            self.size,
            self.spacing_angstrom,
            remedies.join(", or with ")
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::Fit;

    #[test]
    fn the_note_counts_what_does_not_fit_and_names_what_would_do() {
        let settings = VoxelizeSettings {
            size: 64,
            ..VoxelizeSettings::default()
        };
        let note = |extents: &[f64], settings: &VoxelizeSettings| {
            Survey::of_extents(extents, settings).note()
        };
        assert_eq!(note(&[20.0, 63.0], &settings), None);
        let advice = note(&[20.0, 63.5, 100.0], &settings).unwrap();
        assert!(
            advice.contains("2 of 3")
                && advice.ends_with("--size 101, or with --spacing 1.59, or with --spacing fit"),
            "{advice}"
        );
        // What is named does take them all.
        let spacing = Spacing::Angstrom(1.59);
        let larger = VoxelizeSettings {
            spacing,
            ..settings.clone()
        };
        assert_eq!(note(&[20.0, 63.5, 100.0], &larger), None);
        let advice = note(&[300.0], &settings).unwrap();
        assert!(
            advice.ends_with("--size 301, or with --size 151 --spacing fit"),
            "{advice}"
        );
        let fitted = VoxelizeSettings {
            spacing: Spacing::Fit(Fit::Fit),
            ..settings
        };
        assert_eq!(note(&[100.0], &fitted), None);
        assert!(
            note(&[300.0], &fitted)
                .unwrap()
                .ends_with("with --size 151")
        );
    }
}
