//! The energy of a body by its height, from a table.
//!
//! Monte Carlo takes straight lines between the rows ([`HeightTable`]). Dynamics needs a force that does not jump, in a box
//! that begins again at its end as well: a cubic spline through the rows, level at both ends, whose energies are equal
//! ([`HeightCurve`]).

use crate::error::{KernelError, Result, require};
use crate::spline::{Ends, Spline};
use serde::{Deserialize, Serialize};

/// Largest energy of a field, kT.
const LARGEST_ENERGY_KT: f64 = 1e6;

/// An energy of each body by its last coordinate: straight lines between the rows of a table.
///
/// ```
/// use protomer_kernel::height_energy::HeightTable;
/// let valley = HeightTable { heights: vec![0.0, 1.0, 2.0], energies_kt: vec![4.0, 0.0, 4.0] };
/// assert!(valley.check().is_ok());
/// assert_eq!((valley.energy_kt(0.5), valley.energy_kt(3.0)), (2.0, 4.0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeightTable {
    /// Heights over the lower end of the last axis, rising, in the unit of the shape.
    pub heights: Vec<f64>,
    /// Energies at these heights, kT. Beyond the table its ends hold.
    pub energies_kt: Vec<f64>,
}

impl HeightTable {
    /// Checks the numbers.
    ///
    /// ```
    /// use protomer_kernel::height_energy::HeightTable;
    /// let falling = HeightTable { heights: vec![1.0, 0.0], energies_kt: vec![0.0, 0.0] };
    /// assert!(falling.check().is_err(), "heights rise");
    /// ```
    ///
    /// # Errors
    /// Names the number that cannot be.
    pub fn check(&self) -> Result<()> {
        let (rows, energies) = (self.heights.len(), self.energies_kt.len());
        let count = (1..=100_000).contains(&rows);
        require(
            "the number of heights of a field",
            rows as f64,
            "from 1 to 100000",
            count,
        )?;
        require(
            "the number of energies of a field",
            energies as f64,
            "that of its heights",
            rows == energies,
        )?;
        for energy in &self.energies_kt {
            let holds = energy.abs() <= LARGEST_ENERGY_KT;
            require(
                "an energy of a field (kT)",
                *energy,
                "from -1e6 to 1e6",
                holds,
            )?;
        }
        for pair in self.heights.windows(2) {
            let is_rising = pair[1] > pair[0];
            require(
                "a height of a field",
                pair[1],
                "above the one before",
                is_rising,
            )?;
        }
        let first = self.heights[0];
        require(
            "a height of a field",
            first,
            "a finite number",
            first.is_finite(),
        )
    }

    /// Energy at a height, kT.
    ///
    /// ```
    /// use protomer_kernel::height_energy::HeightTable;
    /// let slope = HeightTable { heights: vec![1.0, 3.0], energies_kt: vec![0.0, 4.0] };
    /// assert_eq!([0.0, 2.0, 9.0].map(|height| slope.energy_kt(height)), [0.0, 2.0, 4.0]);
    /// ```
    pub fn energy_kt(&self, height: f64) -> f64 {
        let above = self.heights.partition_point(|row| *row <= height);
        match above {
            0 => self.energies_kt[0],
            all if all == self.heights.len() => self.energies_kt[all - 1],
            row => {
                let [low, high] = [self.heights[row - 1], self.heights[row]];
                let [first, second] = [self.energies_kt[row - 1], self.energies_kt[row]];
                first + (second - first) * (height - low) / (high - low)
            }
        }
    }
}

/// The smooth curve through a table whose first and last energies are equal.
///
/// ```
/// use protomer_kernel::height_energy::{HeightCurve, HeightTable};
/// let valley = HeightTable { heights: vec![0.0, 1.0, 2.0], energies_kt: vec![4.0, 0.0, 4.0] };
/// let curve = HeightCurve::through(&valley)?;
/// assert_eq!([0.0, 1.0, 2.0, 3.0].map(|height| curve.evaluate(height)[0]), [4.0, 0.0, 4.0, 4.0]);
/// let step = HeightTable { heights: vec![0.0, 1.0, 2.0], energies_kt: vec![4.0, 0.0, 0.0] };
/// assert!(HeightCurve::through(&step).is_err(), "it would jump where the box begins again");
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HeightCurve {
    spline: Spline,
    /// Energy below the first and above the last row, kT.
    outer_energy_kt: f64,
}

impl HeightCurve {
    /// The curve.
    ///
    /// # Errors
    /// As [`HeightTable::check`]; also for fewer than three rows, and for a last energy that is not the first.
    pub fn through(table: &HeightTable) -> Result<Self> {
        table.check()?;
        let (first, last) = (
            table.energies_kt[0],
            table.energies_kt[table.energies_kt.len() - 1],
        );
        if first != last {
            return Err(KernelError::OutOfRange {
                quantity: "the last energy of a field (kT)",
                value: last,
                requirement: "the first one for bodies in motion, so that nothing jumps where the box begins again; let it \
                              rise at an end, as at a wall",
            });
        }
        Ok(Self {
            spline: Spline::through(&table.heights, &table.energies_kt, Ends::Level)?,
            outer_energy_kt: first,
        })
    }

    /// First and last height of the table.
    pub fn range(&self) -> [f64; 2] {
        self.spline.range()
    }

    /// Energy at a height, kT, and its slope, kT per length.
    ///
    /// ```
    /// use protomer_kernel::height_energy::{HeightCurve, HeightTable};
    /// let heights: Vec<f64> = (0..=20).map(|row| 0.1 * f64::from(row)).collect();
    /// let energies_kt = heights.iter().map(|z| (std::f64::consts::PI * z).cos()).collect::<Vec<_>>();
    /// let wave = HeightTable { energies_kt: [&energies_kt[..20], &[1.0]].concat(), heights };
    /// let [energy, slope] = HeightCurve::through(&wave)?.evaluate(0.5);
    /// assert!(energy.abs() < 1e-3 && (slope + std::f64::consts::PI).abs() < 1e-2);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn evaluate(&self, height: f64) -> [f64; 2] {
        let [first, last] = self.range();
        if height <= first || height >= last {
            return [self.outer_energy_kt, 0.0];
        }
        let [energy, slope, _] = self.spline.evaluate(height);
        [energy, slope]
    }
}
