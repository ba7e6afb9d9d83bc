//! The figures of a pair: B₂ against salt, one line per pH, and as a map over both.

use super::result::{ConditionResult, PairResult};
use super::settings::Energies;
use anyhow::Result;
use protomer_mc::pair::profile::MeanForceRow;
use protomer_plot::{Axis, ColourMap, Figure, Panel, Point, Series};
use std::path::Path;

/// Writes `pair.svg` and `pair.png` into a directory, and `pair_map.svg` and `pair_map.png` where
/// there is a map.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub fn write(result: &PairResult, directory: &Path) -> Result<()> {
    let figure = figure(result);
    figure.write_svg(&directory.join("pair.svg"))?;
    figure.write_png(&directory.join("pair.png"))?;
    if let Some(map) = map(result) {
        map.write_svg(&directory.join("pair_map.svg"))?;
        map.write_png(&directory.join("pair_map.png"))?;
    }
    Ok(())
}

/// B₂₂ against salt where there are several salts, otherwise w(r).
pub fn figure(result: &PairResult) -> Figure {
    let salts: Vec<f64> = result
        .conditions
        .iter()
        .filter_map(|condition| condition.salt_molar)
        .collect();
    let varies = salts.iter().any(|salt| *salt != salts[0]);
    match varies && salts.len() == result.conditions.len() {
        true => against_salt(result, salts.iter().all(|salt| *salt > 0.0)),
        false => against_distance(result),
    }
}

fn against_salt(result: &PairResult, is_logarithmic: bool) -> Figure {
    let in_mass = in_mass(result);
    let mut series: Vec<Series> = Vec::new();
    let mut hard = named("surfaces alone".into());
    let mut last_ph = None;
    for condition in &result.conditions {
        if series.is_empty() || condition.ph != last_ph {
            series.push(named(line_name(condition)));
            last_ph = condition.ph;
        }
        let factor = shown_per_b2(condition, in_mass).unwrap_or(f64::NAN);
        let x = 1e3 * condition.salt_molar.unwrap_or(0.0);
        if let Some(line) = series.last_mut() {
            line.points.push(Point {
                x,
                y: shown_b2(condition, in_mass),
                error: Some(factor * condition.b2_error_angstrom3),
            });
        }
        if series.len() == 1 {
            hard.points.push(Point {
                x,
                y: factor * condition.b2_hard_angstrom3,
                error: None,
            });
        }
    }
    series.push(hard);
    let axis = match in_mass {
        true => "B22 (10⁻⁴ mol mL/g²)",
        false => "B2 (10³ Å³)",
    };
    Figure {
        title: "Second virial coefficient against salt".into(),
        caption: caption(result),
        x: match is_logarithmic {
            true => Axis::log("salt (mM)"),
            false => Axis::linear("salt (mM)"),
        },
        panels: vec![Panel {
            y: Axis::linear(axis),
            series,
        }],
    }
}

/// w(r), a line for each condition.
pub fn against_distance(result: &PairResult) -> Figure {
    // Where no pose is free of overlap, w has no value; near it, it is all error.
    const LARGEST_ERROR_KT: f64 = 0.5;
    let mut series = Vec::new();
    let salts = distinct(
        result
            .conditions
            .iter()
            .map(|condition| condition.salt_molar),
    );
    let names_salt = salts.is_some_and(|salts| salts.len() > 1);
    for condition in &result.conditions {
        let mut line = named(match condition.salt_molar.filter(|_| names_salt) {
            Some(salt_molar) => name_with_salt(condition, salt_molar),
            None => line_name(condition),
        });
        for row in smoothed(&condition.mean_force) {
            if row.w_error_kt < LARGEST_ERROR_KT {
                line.points.push(Point {
                    x: row.distance_angstrom,
                    y: row.w_kt,
                    error: None,
                });
            }
        }
        series.push(line);
    }
    Figure {
        title: "Potential of mean force".into(),
        caption: caption(result),
        x: Axis::linear("distance of the origins (Å)"),
        panels: vec![Panel {
            y: Axis::linear("w (kT)"),
            series,
        }],
    }
}

/// B₂₂ (B₁₂ of different bodies) over salt and pH; `None` unless both have at least two values.
pub fn map(result: &PairResult) -> Option<ColourMap> {
    let salts = distinct(
        result
            .conditions
            .iter()
            .map(|condition| condition.salt_molar),
    )?;
    let phs = distinct(result.conditions.iter().map(|condition| condition.ph))?;
    if salts.len() < 2 || phs.len() < 2 {
        return None;
    }
    let in_mass = in_mass(result);
    let mut values = Vec::new();
    for ph in &phs {
        for salt in &salts {
            let mut conditions = result.conditions.iter();
            let found = conditions
                .find(|condition| condition.ph == Some(*ph) && condition.salt_molar == Some(*salt));
            values.push(found.map(|condition| shown_b2(condition, in_mass)));
        }
    }
    let [first, second] = &result.bodies;
    let indices = match first == second {
        true => "22",
        false => "12",
    };
    let unit = match in_mass {
        true => "10⁻⁴ mol mL/g²",
        false => "10³ Å³",
    };
    Some(ColourMap {
        title: "Second virial coefficient against salt and pH".into(),
        caption: format!("{}; thick line: change of sign", caption(result)),
        x: "salt (mM)".into(),
        columns: salts.iter().map(|salt| in_short(1e3 * salt)).collect(),
        y: "pH".into(),
        rows: phs.iter().map(f64::to_string).collect(),
        quantity: format!("B{indices} ({unit})"),
        values,
    })
}

/// The values in rising order, each once; `None` if a condition has none.
fn distinct(values: impl Iterator<Item = Option<f64>>) -> Option<Vec<f64>> {
    let mut values = values.collect::<Option<Vec<f64>>>()?;
    values.sort_by(f64::total_cmp);
    values.dedup();
    Some(values)
}

/// With at most four digits.
fn in_short(value: f64) -> String {
    let decimals = (3.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').into(),
        false => text,
    }
}

/// Whether B₂ can be stated in mol mL/g² under all conditions.
fn in_mass(result: &PairResult) -> bool {
    let mut conditions = result.conditions.iter();
    conditions.all(|condition| condition.b22_mol_ml_per_g2.is_some())
}

/// B₂ in the unit of the axes: 10⁻⁴ mol mL/g², or 10³ Å³.
fn shown_b2(condition: &ConditionResult, in_mass: bool) -> f64 {
    match condition.b22_mol_ml_per_g2.filter(|_| in_mass) {
        Some(b22) => 1e4 * b22,
        None => 1e-3 * condition.b2_angstrom3,
    }
}

/// From Å³ to the unit of the axes, as the two values of a condition have it; `None` where they are
/// zero.
fn shown_per_b2(condition: &ConditionResult, in_mass: bool) -> Option<f64> {
    let factor = shown_b2(condition, in_mass) / condition.b2_angstrom3;
    factor.is_finite().then_some(factor)
}

fn line_name(condition: &ConditionResult) -> String {
    match condition.ph {
        Some(ph) => format!("pH {ph}"),
        None => "bodies as they are".into(),
    }
}

fn name_with_salt(condition: &ConditionResult, salt_molar: f64) -> String {
    let salt = in_short(1e3 * salt_molar);
    match condition.ph {
        Some(ph) => format!("pH {ph}, {salt} mM"),
        None => format!("{salt} mM"),
    }
}

/// The rows with neighbours put together where their errors are large and w is small: far away, where bins of
/// half an Å would hide a weak attraction behind their noise. Where |w| exceeds kT, as near contact, the rows
/// stay as they are.
fn smoothed(rows: &[MeanForceRow]) -> Vec<MeanForceRow> {
    const WANTED_ERROR_KT: f64 = 0.03;
    /// Width that is put together at most.
    const WIDEST_ANGSTROM: f64 = 8.0;
    const LARGEST_W_KT: f64 = 1.0;
    let mut smooth = Vec::new();
    let mut first = 0;
    while first < rows.len() {
        let mut end = first + 1;
        let mut row = rows[first];
        while row.w_error_kt > WANTED_ERROR_KT
            && end < rows.len()
            && rows[first..=end]
                .iter()
                .all(|row| row.w_kt.abs() < LARGEST_W_KT)
            && rows[end].distance_angstrom - rows[first].distance_angstrom < WIDEST_ANGSTROM
        {
            end += 1;
            row = together(&rows[first..end]);
        }
        smooth.push(row);
        first = end;
    }
    smooth
}

/// Bins as one: the mean of exp(-w) by volume, with errors that are independent.
fn together(rows: &[MeanForceRow]) -> MeanForceRow {
    let (mut volume, mut distance, mut sum, mut variance) = (0.0, 0.0, 0.0, 0.0);
    for row in rows {
        let shell = row.distance_angstrom.powi(2);
        let boltzmann = shell * (-row.w_kt).exp();
        volume += shell;
        distance += row.distance_angstrom;
        sum += boltzmann;
        variance += (boltzmann * row.w_error_kt).powi(2);
    }
    MeanForceRow {
        distance_angstrom: distance / rows.len() as f64,
        w_kt: -(sum / volume).ln(),
        w_error_kt: variance.sqrt() / sum,
    }
}

fn named(name: String) -> Series {
    Series {
        name,
        line: true,
        ..Series::default()
    }
}

fn caption(result: &PairResult) -> String {
    let [first, second] = &result.bodies;
    let settings = &result.settings;
    let energies = match settings.energies {
        Energies::Hard => "hard surfaces only",
        Energies::Bare => "bare charges",
        Energies::Effective => "effective charges",
        Energies::Response => "charges, response of the solvent",
    };
    let contacts = match &settings.contacts {
        Some(contacts) => format!(", {}", contacts.describe()),
        None => String::new(),
    };
    format!(
        "{first} and {second}, {energies}{contacts}, {} K, seed {}",
        settings.medium.temperature_kelvin, settings.sampling.seed
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::pair::PairRunSettings;

    fn condition(ph: Option<f64>, salt_molar: Option<f64>, b2_angstrom3: f64) -> ConditionResult {
        ConditionResult {
            ph,
            salt_molar,
            debye_length_angstrom: None,
            bjerrum_length_angstrom: 7.0,
            b2_angstrom3,
            b2_error_angstrom3: 1.0,
            b2_hard_angstrom3: 2e4,
            b2_hard_error_angstrom3: 1.0,
            b22_mol_ml_per_g2: Some(3e-9 * b2_angstrom3),
            b22_error_mol_ml_per_g2: Some(3e-9),
            kd_molar: None,
            kd_error_molar: None,
            association_volume_angstrom3: 1.0,
            contact_volume_angstrom3: 1.0,
            net_charge_e: [1.0; 2],
            net_effective_charge_e: None,
            poses: Vec::new(),
            residues_by_plain_charges: false,
            warnings: Vec::new(),
            directions: 1,
            mean_force: Vec::new(),
        }
    }

    fn result(conditions: Vec<ConditionResult>) -> PairResult {
        PairResult {
            version: String::new(),
            model: String::new(),
            input_sha256: String::new(),
            bodies: ["a", "a"].map(str::to_owned),
            settings: PairRunSettings::default(),
            conditions,
        }
    }

    #[test]
    fn noise_far_away_is_averaged_and_wells_are_kept() {
        let row = |number: usize| {
            let distance_angstrom = 40.0 + 0.5 * number as f64;
            let noise = if number.is_multiple_of(2) { 0.4 } else { -0.4 };
            let well = -6.0 * (-(distance_angstrom - 42.0).powi(2)).exp();
            MeanForceRow {
                distance_angstrom,
                w_kt: well - 0.1 + if distance_angstrom > 45.0 { noise } else { 0.0 },
                w_error_kt: 0.4,
            }
        };
        let rows: Vec<MeanForceRow> = (0..400).map(row).collect();
        let smooth = smoothed(&rows);
        assert!(smooth.len() < 60, "{}", smooth.len());
        let least = smooth.iter().map(|row| row.w_kt).fold(0.0, f64::min);
        assert_eq!(least, rows[4].w_kt);
        for row in smooth.iter().filter(|row| row.distance_angstrom > 60.0) {
            assert!(
                (row.w_kt + 0.18).abs() < 0.12 && row.w_error_kt < 0.15,
                "{row:?}"
            );
        }
    }

    #[test]
    fn lines_over_distance_are_named_by_salt() {
        let names = |conditions: Vec<ConditionResult>| -> Vec<String> {
            let figure = against_distance(&result(conditions));
            figure.panels[0]
                .series
                .iter()
                .map(|line| line.name.clone())
                .collect()
        };
        let salts = [0.03, 0.094_868].map(|salt| condition(None, Some(salt), 1.0));
        assert_eq!(names(salts.into()), ["30 mM", "94.87 mM"]);
        assert_eq!(names(vec![condition(Some(7.0), Some(0.1), 1.0)]), ["pH 7"]);
        assert_eq!(names(grid())[0], "pH 7, 500 mM");
    }

    fn grid() -> Vec<ConditionResult> {
        let mut conditions = Vec::new();
        for (row, ph) in [7.0, 4.5].into_iter().enumerate() {
            for (column, salt) in [0.5, 0.03, 0.1].into_iter().enumerate() {
                let b2 = 1e5 * (10 * row + column) as f64 - 1e5;
                conditions.push(condition(Some(ph), Some(salt), b2));
            }
        }
        conditions
    }

    #[test]
    fn a_map_has_salt_and_ph_in_rising_order() {
        let found = map(&result(grid())).unwrap();
        assert_eq!(found.columns, ["30", "100", "500"]);
        assert_eq!(found.rows, ["4.5", "7"]);
        assert_eq!(found.quantity, "B22 (10⁻⁴ mol mL/g²)");
        // 10⁵ Å³ are 3·10⁻⁴ mol mL/g² of these bodies.
        let values: Vec<f64> = found.values.iter().map(|value| value.unwrap()).collect();
        for (value, expected) in values.iter().zip([30.0, 33.0, 27.0, 0.0, 3.0, -3.0]) {
            assert!((value - expected).abs() < 1e-9, "{values:?}");
        }
        let mut different = result(grid());
        different.bodies[1] = "b".into();
        different.conditions[2].b22_mol_ml_per_g2 = None;
        different.conditions.pop();
        let found = map(&different).unwrap();
        assert_eq!(found.quantity, "B12 (10³ Å³)");
        assert_eq!((found.values[1], found.values[5]), (None, Some(-100.0)));
    }

    #[test]
    fn a_line_of_conditions_has_no_map() {
        let figure = |kept: fn(&ConditionResult) -> bool| {
            map(&result(grid().into_iter().filter(kept).collect()))
        };
        assert!(figure(|_| true).is_some());
        assert!(figure(|condition| condition.ph == Some(7.0)).is_none());
        assert!(figure(|condition| condition.salt_molar == Some(0.1)).is_none());
        let mut unknown = grid();
        unknown[0].salt_molar = None;
        assert!(map(&result(unknown)).is_none());
        assert!(map(&result(Vec::new())).is_none());
    }

    #[test]
    fn the_map_is_written_where_there_is_one() {
        let directory = tempfile::tempdir().unwrap();
        let files = ["pair_map.svg", "pair_map.png"].map(|name| directory.path().join(name));
        let line = grid().into_iter().take(3).collect();
        write(&result(line), directory.path()).unwrap();
        assert!(files.iter().all(|file| !file.exists()));
        write(&result(grid()), directory.path()).unwrap();
        assert!(files.iter().all(|file| file.exists()));
        let svg = std::fs::read_to_string(&files[0]).unwrap();
        assert!(svg.contains(">33<") && svg.contains(">−3<"), "{svg}");
    }

    #[test]
    fn salts_are_written_in_short() {
        let written = [0.5, 1.0, 33.333_333, 100.0, 1000.0, 0.012].map(in_short);
        assert_eq!(written, ["0.5", "1", "33.33", "100", "1000", "0.012"]);
    }
}
