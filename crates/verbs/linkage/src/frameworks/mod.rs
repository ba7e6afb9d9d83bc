//! Networks of rods and hinges: their elastic constants, their response to loads, and figures of
//! both.
//!
//! | module | one idea |
//! |---|---|
//! | [`network_file`] | networks as TOML |
//! | [`report`] | elastic constants with their units, closed formulas next to them |
//! | [`curve`] | a network under increasing loads |
//! | [`competition`] | a warning where rods and hinges share the strain |
//! | [`scan`] | a network over ranges of its parameters |
//! | [`answer`] | the verb, and its answer as text and figure |
//! | [`figure`], [`drawing`], [`film`] | moduli against direction; the cells, unloaded and loaded; their motion |
//! | [`directory`] | the files of a result |
//! | [`page`] | the page of a result |
//! | `text` | formatted numbers |
//! | [`tables`] | tables 2 to 4 of Grima et al., Mol. Simul. 31, 925 (2005), printed and recomputed |

pub mod answer;
pub mod competition;
pub mod curve;
pub mod directory;
pub mod drawing;
pub mod figure;
pub mod film;
pub mod network_file;
pub mod page;
pub mod report;
pub mod scan;
pub mod tables;
mod text;

/// Names of the axes of two- and three-dimensional networks.
///
/// ```
/// use protomer_linkage_verbs::frameworks::{axes, strain_names};
/// assert_eq!((axes(2), strain_names(2)), (&["y", "z"][..], &["yy", "zz", "yz"][..]));
/// ```
pub fn axes(dimension: usize) -> &'static [&'static str] {
    if dimension == 2 {
        &["y", "z"]
    } else {
        &["x", "y", "z"]
    }
}

/// Names of the strain components, in the order of all matrices.
pub fn strain_names(dimension: usize) -> &'static [&'static str] {
    if dimension == 2 {
        &["yy", "zz", "yz"]
    } else {
        &["xx", "yy", "zz", "yz", "xz", "xy"]
    }
}
