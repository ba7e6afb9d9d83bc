//! Passages of a quantity through a level.
//!
//! The amplitude θ_c of the checkerboard mode passes through the open state, π/4, once per half
//! period. In the coherent motion its rate there is the same every time (eq. 29b of the paper), so
//! the rates of a run say how much of the coherent motion is left: they are a section through the
//! phase space of the paper's figure 9.

use serde::{Deserialize, Serialize};

/// A passage through a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// Time of the passage.
    pub time: f64,
    /// Rate of change at the passage, with its sign.
    pub rate: f64,
}

/// The passages of a series of (time, value) through a level, by linear interpolation between
/// samples. A series that only touches the level and turns back does not pass.
///
/// ```
/// use protomer_linkage::analysis::crossings::crossings;
/// let series: Vec<[f64; 2]> = (0..1000)
///     .map(|step| 0.01 * f64::from(step))
///     .map(|time| [time, time.sin()])
///     .collect();
/// let found = crossings(&series, 0.0);
/// assert_eq!(found.len(), 3); // at π, 2π, 3π; the start at 0 is no passage
/// assert!((found[1].time - std::f64::consts::TAU).abs() < 1e-4);
/// assert!((found[1].rate - 1.0).abs() < 1e-4);
/// ```
pub fn crossings(series: &[[f64; 2]], level: f64) -> Vec<Crossing> {
    let mut crossings = Vec::new();
    // The last sample that was not on the level.
    let mut last: Option<[f64; 2]> = None;
    for &[time, value] in series {
        let height = value - level;
        if height == 0.0 || height.is_nan() {
            continue;
        }
        if let Some([before, height_before]) = last
            && (height > 0.0) != (height_before > 0.0)
        {
            let rate = (height - height_before) / (time - before);
            crossings.push(Crossing {
                time: before - height_before / rate,
                rate,
            });
        }
        last = Some([time, height]);
    }
    crossings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_on_the_level_count_once_or_not_at_all() {
        let through = [[0.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
        let found = crossings(&through, 0.0);
        assert_eq!(found.len(), 1);
        assert!((found[0].time - 1.0).abs() < 1e-15 && (found[0].rate - 1.0).abs() < 1e-15);
        let touching = [[0.0, 1.0], [1.0, 0.0], [2.0, 1.0]];
        assert_eq!(crossings(&touching, 0.0), []);
        assert_eq!(crossings(&[], 0.0), []);
    }

    #[test]
    fn straight_lines_are_found_exactly_in_both_directions() {
        let series = [[0.0, 5.0], [1.0, 1.0], [4.0, 7.0]];
        let found = crossings(&series, 2.0);
        assert_eq!(found.len(), 2);
        assert!((found[0].time - 0.75).abs() < 1e-15 && (found[0].rate + 4.0).abs() < 1e-15);
        assert!((found[1].time - 1.5).abs() < 1e-15 && (found[1].rate - 2.0).abs() < 1e-15);
    }
}
