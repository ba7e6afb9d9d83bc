//! `log.csv`: the measurements of a run.

use protomer_hpmc::heights::Walls;
use protomer_results::Row;

/// One measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct LogRow {
    /// Sweeps done, with those of the equilibration.
    pub sweep: u64,
    /// Compressibility factor.
    pub compressibility_factor: f64,
    /// The part of inserted bodies that overlap none.
    pub insertion_probability: Option<f64>,
    /// Free volume of each depletant, as a part of the box.
    pub free_volume: Vec<f64>,
    /// The part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Pressures on the walls and mean height of the bodies, between walls.
    pub walls: Option<Walls>,
    /// Lengths of the box, where more than its volume changes.
    pub box_lengths: Vec<f64>,
    /// Tilt factors of the box, where more than its volume changes.
    pub box_tilt_factors: Vec<f64>,
}

/// Columns of logs that were begun before boxes changed their shape.
const WITHOUT_BOX: usize = 8;

impl Row for LogRow {
    fn columns() -> Vec<&'static str> {
        vec![
            "sweep",
            "compressibility_factor",
            "insertion_probability",
            "free_volume_fraction",
            "packing_fraction",
            "lower_wall_pressure",
            "upper_wall_pressure",
            "mean_height",
            "box_lengths",
            "box_tilt_factors",
        ]
    }

    /// Writes several numbers into one cell, with blanks between them.
    fn to_cells(&self) -> Vec<String> {
        let several = |numbers: &[f64]| {
            let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
            words.join(" ")
        };
        let of_walls = |value: fn(&Walls) -> f64| {
            self.walls
                .map_or_else(String::new, |walls| value(&walls).to_string())
        };
        vec![
            self.sweep.to_string(),
            self.compressibility_factor.to_string(),
            self.insertion_probability
                .map_or_else(String::new, |p| p.to_string()),
            several(&self.free_volume),
            self.packing_fraction.to_string(),
            of_walls(|walls| walls.pressures[0]),
            of_walls(|walls| walls.pressures[1]),
            of_walls(|walls| walls.mean_height),
            several(&self.box_lengths),
            several(&self.box_tilt_factors),
        ]
    }

    fn from_cells(cells: &[String]) -> Option<Self> {
        let (cells, in_box) = cells.split_at_checked(WITHOUT_BOX)?;
        let [
            sweep,
            factor,
            insertion,
            volumes,
            packing,
            low,
            high,
            height,
        ] = cells
        else {
            return None;
        };
        let [lengths, tilt_factors] = match in_box {
            [] => ["", ""],
            [lengths, tilt_factors] => [lengths.as_str(), tilt_factors.as_str()],
            _ => return None,
        };
        let insertion_probability = match insertion.as_str() {
            "" => None,
            number => Some(number.parse().ok()?),
        };
        let walls = match low.as_str() {
            "" => None,
            low => Some(Walls {
                pressures: [low.parse().ok()?, high.parse().ok()?],
                mean_height: height.parse().ok()?,
            }),
        };
        let several = |words: &str| {
            let numbers = words.split_whitespace().map(|word| word.parse().ok());
            numbers.collect::<Option<Vec<f64>>>()
        };
        Some(Self {
            sweep: sweep.parse().ok()?,
            compressibility_factor: factor.parse().ok()?,
            insertion_probability,
            free_volume: several(volumes)?,
            packing_fraction: packing.parse().ok()?,
            walls,
            box_lengths: several(lengths)?,
            box_tilt_factors: several(tilt_factors)?,
        })
    }
}
