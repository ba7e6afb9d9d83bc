//! `log.csv`: the measurements of a run.

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
}

impl Row for LogRow {
    fn columns() -> Vec<&'static str> {
        vec![
            "sweep",
            "compressibility_factor",
            "insertion_probability",
            "free_volume_fraction",
        ]
    }

    /// Free volumes of several depletants are in one cell, with blanks between them.
    fn to_cells(&self) -> Vec<String> {
        let volumes: Vec<String> = self.free_volume.iter().map(f64::to_string).collect();
        vec![
            self.sweep.to_string(),
            self.compressibility_factor.to_string(),
            self.insertion_probability
                .map_or_else(String::new, |p| p.to_string()),
            volumes.join(" "),
        ]
    }

    fn from_cells(cells: &[String]) -> Option<Self> {
        let [sweep, factor, insertion, volumes] = cells else {
            return None;
        };
        let insertion_probability = match insertion.as_str() {
            "" => None,
            number => Some(number.parse().ok()?),
        };
        let volumes = volumes.split_whitespace().map(|number| number.parse().ok());
        Some(Self {
            sweep: sweep.parse().ok()?,
            compressibility_factor: factor.parse().ok()?,
            insertion_probability,
            free_volume: volumes.collect::<Option<_>>()?,
        })
    }
}
