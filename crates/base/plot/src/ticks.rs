//! Which values an axis marks, and how they are written.

/// A marked value; minor ticks have no label.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub value: f64,
    pub label: Option<String>,
}

/// The ticks of a linear axis: multiples of 1, 2 or 5 times a power of ten, about `count` of them.
pub(crate) fn linear([from, to]: [f64; 2], count: usize) -> Vec<Tick> {
    let rough = (to - from) / count.max(1) as f64;
    let power = rough.log10().floor();
    let mantissa = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        // 0.8 lets a step be a little smaller than asked for, rather than jump to the next.
        .find(|m| m * 10f64.powf(power) >= rough * 0.8)
        .unwrap_or(10.0);
    let step = mantissa * 10f64.powf(power);
    // The digits that tell one step from the next; the tiny shift keeps 0.1 at one decimal.
    let decimals = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
    // Multiples as integers: adding steps would let rounding grow along the axis.
    let first = (from / step - 1e-9).ceil() as i64;
    let last = (to / step + 1e-9).floor() as i64;
    let tick = |multiple: i64| {
        let value = multiple as f64 * step;
        Tick {
            value,
            label: Some(decimal(value, decimals)),
        }
    };
    (first..=last).map(tick).collect()
}

/// Variant of [`linear`] with ticks at whole numbers only.
pub(crate) fn whole([from, to]: [f64; 2], count: usize) -> Vec<Tick> {
    // A step is at least one if at most one tick is requested per whole number.
    let most = (to - from).floor().max(1.0) as usize;
    let mut ticks = linear([from, to], count.min(most));
    // A step of 2.5 cannot occur, but one of 0.5 can, where the range is short.
    ticks.retain(|tick| tick.value.fract() == 0.0);
    for tick in &mut ticks {
        tick.label = Some(decimal(tick.value, 0));
    }
    ticks
}

/// The ticks of a logarithmic axis: labels at 1, 2, 3, 5 of each decade, fewer over many decades;
/// minor ticks at every digit. A range of less than a decade gets the ticks of a linear axis.
pub(crate) fn logarithmic([from, to]: [f64; 2]) -> Vec<Tick> {
    let decades = (to / from).log10();
    // Within 0.7 decades hardly two of 1, 2, 3, 5 lie in the range.
    if decades < 0.7 {
        return linear([from, to], 6);
    }
    let labelled: &[i32] = match decades {
        d if d < 2.2 => &[1, 2, 3, 5],
        d if d < 3.5 => &[1, 2, 5],
        _ => &[1],
    };
    let (first, last) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    let mut ticks = Vec::new();
    for exponent in first..=last {
        for digit in 1..10 {
            let value = f64::from(digit) * 10f64.powi(exponent);
            // The ends themselves must not fall out by rounding.
            if value >= from * (1.0 - 1e-9) && value <= to * (1.0 + 1e-9) {
                let label = labelled
                    .contains(&digit)
                    .then(|| power_label(digit, exponent));
                ticks.push(Tick { value, label });
            }
        }
    }
    ticks
}

fn power_label(digit: i32, exponent: i32) -> String {
    // Plain numbers from 0.0001 to 900 000; beyond, zeros are hard to count.
    if (-4..6).contains(&exponent) {
        decimal(
            f64::from(digit) * 10f64.powi(exponent),
            exponent.min(0).unsigned_abs() as usize,
        )
    } else if digit == 1 {
        format!("10^{{{}}}", with_minus_sign(exponent.to_string()))
    } else {
        format!("{digit}·10^{{{}}}", with_minus_sign(exponent.to_string()))
    }
}

/// A number with this many decimals.
pub(crate) fn decimal(value: f64, decimals: usize) -> String {
    // Adding zero keeps -0 from being written.
    with_minus_sign(format!("{:.decimals$}", value + 0.0))
}

fn with_minus_sign(number: String) -> String {
    number.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks
            .iter()
            .filter_map(|tick| tick.label.as_deref())
            .collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(&linear([0.0, 1.1], 3)), ["0.0", "0.5", "1.0"]);
        assert_eq!(
            labels(&linear([0.0, 1.1], 6)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            labels(&linear([-21.0, 20.0], 5)),
            ["−20", "−10", "0", "10", "20"]
        );
        assert_eq!(
            labels(&linear([51.2, 133.0], 5)),
            ["60", "80", "100", "120"]
        );
        assert_eq!(
            labels(&linear([0.011, 0.0142], 4)),
            ["0.011", "0.012", "0.013", "0.014"]
        );
    }

    #[test]
    fn counts_are_marked_at_whole_numbers() {
        assert_eq!(labels(&whole([0.9, 3.1], 6)), ["1", "2", "3"]);
        assert_eq!(labels(&whole([0.96, 2.04], 6)), ["1", "2"]);
        assert_eq!(labels(&whole([0.5, 1.5], 6)), ["1"]);
        assert_eq!(
            labels(&whole([0.0, 40.0], 5)),
            ["0", "10", "20", "30", "40"]
        );
    }

    #[test]
    fn logarithmic_ticks_read_like_salt_concentrations() {
        assert_eq!(
            labels(&logarithmic([9.0, 330.0])),
            ["10", "20", "30", "50", "100", "200", "300"]
        );
        assert_eq!(
            labels(&logarithmic([0.01, 0.3])),
            ["0.01", "0.02", "0.03", "0.05", "0.1", "0.2", "0.3"]
        );
        assert_eq!(
            labels(&logarithmic([1e-7, 1e-2])),
            ["10^{−7}", "10^{−6}", "10^{−5}", "0.0001", "0.001", "0.01"]
        );
        assert_eq!(logarithmic([1.0, 10.0]).len(), 10);
        assert_eq!(
            labels(&logarithmic([48.0, 140.0])),
            ["60", "80", "100", "120", "140"]
        );
    }
}
