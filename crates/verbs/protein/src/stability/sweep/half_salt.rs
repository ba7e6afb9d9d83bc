//! The salt at which a fraction has fallen to one half.

use protomer_kernel::random::{CounterRng, Purpose};
use serde::Serialize;

/// A fraction at one salt concentration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FractionAt {
    /// Salt concentration, mol/L.
    pub salt_molar: f64,
    /// The fraction, 0 to 1.
    pub fraction: f64,
    /// Standard error of the fraction.
    pub error: f64,
}

/// A salt concentration with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HalfSalt {
    /// The concentration, mol/L.
    pub salt_molar: f64,
    /// Interval of 95 %, mol/L. An end is `None` where the curves that the errors allow do not
    /// cross one half within the salt concentrations of the sweep.
    pub interval_molar: [Option<f64>; 2],
}

const HALF: f64 = 0.5;
/// Number of curves drawn within the errors.
const CURVES: u64 = 2000;
/// Share of these curves beyond each end of the interval.
const TAIL: f64 = 0.025;

/// Crossing of a curve with one half.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Crossing {
    BelowAll,
    At(f64),
    AboveAll,
}

impl Crossing {
    fn order(self) -> f64 {
        match self {
            Crossing::BelowAll => f64::NEG_INFINITY,
            Crossing::At(salt_molar) => salt_molar,
            Crossing::AboveAll => f64::INFINITY,
        }
    }

    fn salt_molar(self) -> Option<f64> {
        match self {
            Crossing::At(salt_molar) => Some(salt_molar),
            _ => None,
        }
    }
}

/// The salt at which the fraction is one half: the falling curve that is nearest to the points
/// (least squares), between them linear in the logarithm of the salt. The interval comes from curves
/// drawn within the errors, which may fall anywhere between two points: of a fraction that falls from
/// one to zero, they say no more than that. `None` if the curve does not cross one half.
///
/// ```
/// use protomer_protein_verbs::stability::sweep::half_salt::{FractionAt, half_salt};
/// let points = [(0.01, 1.0), (0.1, 0.75), (1.0, 0.25)];
/// let points = points.map(|(salt_molar, fraction)| FractionAt { salt_molar, fraction, error: 0.0 });
/// let half = half_salt(&points, 1);
/// // Half-way between 0.1 M and 1 M on the logarithmic axis.
/// assert!(half.is_some_and(|half| (half.salt_molar - 0.1 * 10_f64.sqrt()).abs() < 1e-9));
/// assert_eq!(half_salt(&points[..2], 1), None, "it has not fallen to one half");
/// ```
pub fn half_salt(points: &[FractionAt], seed: u64) -> Option<HalfSalt> {
    let mut points = points.to_vec();
    // A salt whose runs left no number says nothing of the curve.
    points.retain(|point| point.fraction.is_finite());
    points.sort_by(|a, b| a.salt_molar.total_cmp(&b.salt_molar));
    let salt_molar = crossing_molar(&points)?;
    let mut drawn = Vec::with_capacity(CURVES as usize);
    for curve in 0..CURVES {
        let mut rng = CounterRng::for_purpose(seed, 0, curve, Purpose::Bootstrap);
        // Each point moves within its own error; the curve is then made to fall again.
        let fraction = |point: &FractionAt| point.fraction + point.error * rng.normal();
        let fractions: Vec<f64> = points.iter().map(fraction).collect();
        // Once for the whole curve, from the same stream,
        // so that curves differ by their points alone.
        let uniform = rng.uniform();
        // Between two points a steep curve may cross
        // anywhere, a flat one only where the line has it.
        let anywhere = |part: f64, fall: f64| part + (uniform - part) * fall.min(1.0);
        drawn.push(crossing(&points, &fractions, anywhere));
    }
    drawn.sort_by(|a, b| a.order().total_cmp(&b.order()));
    let quantile = |part: f64| {
        // Curves that do not cross count as beyond the ends, so the quantiles keep their places.
        let index = (part * (drawn.len() - 1) as f64).round() as usize;
        drawn.get(index).and_then(|crossing| crossing.salt_molar())
    };
    Some(HalfSalt {
        salt_molar,
        interval_molar: [quantile(TAIL), quantile(1.0 - TAIL)],
    })
}

/// The salt at which the fraction is one half, mol/L, without an interval; for points in the order
/// of the salt.
///
/// ```
/// use protomer_protein_verbs::stability::sweep::half_salt::{FractionAt, crossing_molar};
/// let points = [(0.01, 0.9), (1.0, 0.1)];
/// let points = points.map(|(salt_molar, fraction)| FractionAt { salt_molar, fraction, error: 0.1 });
/// assert!(crossing_molar(&points).is_some_and(|salt_molar| (salt_molar - 0.1).abs() < 1e-9));
/// ```
pub fn crossing_molar(points: &[FractionAt]) -> Option<f64> {
    let fractions: Vec<f64> = points.iter().map(|point| point.fraction).collect();
    if fractions.iter().any(|fraction| !fraction.is_finite()) {
        return None;
    }
    let linear = |part: f64, _: f64| part;
    crossing(points, &fractions, linear).salt_molar()
}

/// Finds the crossing of a curve with one half. `between_points` says which part of the way between
/// two points it is at, from where a line would have it and from how far the fraction falls.
fn crossing(
    points: &[FractionAt],
    fractions: &[f64],
    between_points: impl Fn(f64, f64) -> f64,
) -> Crossing {
    let fractions = falling(fractions);
    if fractions.first().is_none_or(|first| *first < HALF) {
        return Crossing::BelowAll;
    }
    for (points, fractions) in points.windows(2).zip(fractions.windows(2)) {
        // `falling` leaves no other crossing: the first is the only one.
        if fractions[1] < HALF {
            // Positive: one end is at least one half, the other is below it.
            let fall = fractions[0] - fractions[1];
            let part = between_points((fractions[0] - HALF) / fall, fall);
            return Crossing::At(salt_between(
                points[0].salt_molar,
                points[1].salt_molar,
                part,
            ));
        }
    }
    Crossing::AboveAll
}

/// Salt at a part of the way from one to another, even in its logarithm; from pure water on, even in
/// the salt.
pub(crate) fn salt_between(low: f64, high: f64, part: f64) -> f64 {
    match low > 0.0 {
        true => low * (high / low).powf(part),
        false => high * part,
    }
}

/// The falling sequence nearest to these values: neighbours that rise take their mean.
fn falling(values: &[f64]) -> Vec<f64> {
    // Pool adjacent violators: each block has a mean and a number of values.
    let mut blocks: Vec<(f64, usize)> = Vec::with_capacity(values.len());
    for value in values {
        let (mut mean, mut count) = (*value, 1);
        // Blocks that would rise are merged, backwards, until the sequence falls again.
        while let Some((before, number)) = blocks.last().copied()
            && before < mean
        {
            blocks.pop();
            mean = (mean * count as f64 + before * number as f64) / (count + number) as f64;
            count += number;
        }
        blocks.push((mean, count));
    }
    let values = blocks
        .into_iter()
        .flat_map(|(mean, count)| std::iter::repeat_n(mean, count));
    values.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(fractions: &[(f64, f64)], error: f64) -> Vec<FractionAt> {
        let point = |(salt_molar, fraction): &(f64, f64)| FractionAt {
            salt_molar: *salt_molar,
            fraction: *fraction,
            error,
        };
        fractions.iter().map(point).collect()
    }

    #[test]
    fn a_line_in_the_logarithm_crosses_where_it_does() {
        // In any order; the fraction is 1 - log10(salt / 10 mM) / 2.
        let curve = points(&[(1.0, 0.0), (0.01, 1.0), (0.1, 0.5 + 1e-9)], 0.0);
        let half = half_salt(&curve, 1).unwrap();
        assert!((half.salt_molar / 0.1 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_interval_is_that_of_the_errors() {
        let error = 0.03;
        let half = half_salt(&points(&[(0.095, 0.51), (0.105, 0.49)], error), 1).unwrap();
        // The error of both points shifts the line, whose slope is small; most crossings are beyond
        // the points.
        assert_eq!(half.interval_molar, [None, None]);
        let steep = [
            (0.08, 0.7),
            (0.09, 0.6),
            (0.1, 0.5001),
            (0.11, 0.4),
            (0.12, 0.3),
        ];
        let half = half_salt(&points(&steep, error), 1).unwrap();
        let [low, high] = half.interval_molar.map(Option::unwrap);
        // A fraction known to ± 0.06 on a slope of 10 per mol/L; neighbours help.
        assert!((0.0030..0.0070).contains(&(half.salt_molar - low)), "{low}");
        assert!(
            (0.0030..0.0070).contains(&(high - half.salt_molar)),
            "{high}"
        );
    }

    #[test]
    fn where_it_falls_between_two_points_is_not_known() {
        let half = half_salt(&points(&[(0.01, 1.0), (1.0, 0.0)], 0.0), 1).unwrap();
        assert!((half.salt_molar - 0.1).abs() < 1e-9);
        let [low, high] = half.interval_molar.map(Option::unwrap);
        assert!((low / 0.01).log10() / 2.0 < 0.04 && (1.0 / high).log10() / 2.0 < 0.04);
    }

    #[test]
    fn curves_that_do_not_cross_have_none_and_open_ends_stay_open() {
        assert_eq!(half_salt(&points(&[(0.1, 0.9), (0.3, 0.7)], 0.01), 1), None);
        assert_eq!(half_salt(&points(&[(0.1, 0.4), (0.3, 0.1)], 0.01), 1), None);
        assert_eq!(half_salt(&[], 1), None);
        let half = half_salt(&points(&[(0.1, 0.9), (0.3, 0.49)], 0.1), 1).unwrap();
        assert!(half.interval_molar[0].is_some());
        assert_eq!(half.interval_molar[1], None);
    }

    #[test]
    fn what_rises_is_levelled() {
        for (values, wanted) in [
            ([1.0, 0.25, 0.75, 0.0], [1.0, 0.5, 0.5, 0.0]),
            ([0.0, 0.25, 0.5, 0.25], [0.25, 0.25, 0.25, 0.25]),
        ] {
            assert_eq!(falling(&values), wanted);
        }
    }
}
