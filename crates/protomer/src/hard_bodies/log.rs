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
    /// Between walls: what they bear, and how high the bodies are.
    pub walls: Option<Walls>,
}

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
        ]
    }

    /// Free volumes of several depletants are in one cell, with blanks between them.
    fn to_cells(&self) -> Vec<String> {
        let volumes: Vec<String> = self.free_volume.iter().map(f64::to_string).collect();
        let of_walls = |value: fn(&Walls) -> f64| {
            self.walls
                .map_or_else(String::new, |walls| value(&walls).to_string())
        };
        vec![
            self.sweep.to_string(),
            self.compressibility_factor.to_string(),
            self.insertion_probability
                .map_or_else(String::new, |p| p.to_string()),
            volumes.join(" "),
            self.packing_fraction.to_string(),
            of_walls(|walls| walls.pressures[0]),
            of_walls(|walls| walls.pressures[1]),
            of_walls(|walls| walls.mean_height),
        ]
    }

    fn from_cells(cells: &[String]) -> Option<Self> {
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
        let volumes = volumes.split_whitespace().map(|number| number.parse().ok());
        Some(Self {
            sweep: sweep.parse().ok()?,
            compressibility_factor: factor.parse().ok()?,
            insertion_probability,
            free_volume: volumes.collect::<Option<_>>()?,
            packing_fraction: packing.parse().ok()?,
            walls,
        })
    }
}
