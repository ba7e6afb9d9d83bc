//! Points in space, and values between them.

use crate::{FieldError, Result};
use protomer_kernel::Vec3;
use serde::Serialize;

/// No machine holds more; below it no number of points overflows.
const MOST_POINTS: f64 = 1e13;

/// A regular grid of points. Values on it are stored with x running fastest, then y, then z.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grid {
    /// The lowest corner, Å.
    pub origin_angstrom: [f64; 3],
    /// Distance of neighbouring points, Å.
    pub spacing_angstrom: f64,
    /// Points along x, y and z.
    pub shape: [usize; 3],
}

impl Grid {
    /// The smallest grid of this spacing that holds a box (lowest and highest corner, Å) and has
    /// `multiple` · n + 1 points along each axis, centred on it.
    ///
    /// # Errors
    /// [`FieldError::BadSetting`] for a spacing that is not positive, [`FieldError::BadInput`] for
    /// more points than any machine holds.
    pub fn around(low: &Vec3, high: &Vec3, spacing_angstrom: f64, multiple: usize) -> Result<Self> {
        if !(spacing_angstrom.is_finite() && spacing_angstrom > 0.0) {
            return Err(FieldError::BadSetting {
                setting: "spacing",
                value: spacing_angstrom,
                requirement: "positive, Å",
            });
        }
        let extent = high - low;
        let points = extent
            .iter()
            .map(|length| length / spacing_angstrom + 1.0)
            .product::<f64>();
        if points.is_nan() || points > MOST_POINTS {
            return Err(FieldError::BadInput(format!(
                "a box of {:.0} x {:.0} x {:.0} Å at a spacing of {spacing_angstrom} Å has {points:.1e} points: look for atoms \
                 far from the others, or use a larger spacing",
                extent.x, extent.y, extent.z
            )));
        }
        let cells = |axis: usize| {
            let needed = (extent[axis] / spacing_angstrom - 1e-9).ceil().max(1.0) as usize;
            needed.div_ceil(multiple) * multiple
        };
        let shape = [cells(0) + 1, cells(1) + 1, cells(2) + 1];
        let middle = 0.5 * (low + high);
        let origin = std::array::from_fn(|axis| {
            middle[axis] - 0.5 * (shape[axis] - 1) as f64 * spacing_angstrom
        });
        Ok(Self {
            origin_angstrom: origin,
            spacing_angstrom,
            shape,
        })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where in a list of values the point (i, j, k) is.
    #[inline]
    pub fn index(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.shape[1] + j) * self.shape[0] + i
    }

    /// The place of point (i, j, k), Å.
    #[inline]
    pub fn point(&self, i: usize, j: usize, k: usize) -> Vec3 {
        let h = self.spacing_angstrom;
        let o = &self.origin_angstrom;
        Vec3::new(
            o[0] + h * i as f64,
            o[1] + h * j as f64,
            o[2] + h * k as f64,
        )
    }

    /// How far apart in a list of values neighbours along each axis are.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.shape[0], self.shape[0] * self.shape[1]]
    }

    /// The cell a place lies in and where in it, (0..1)³; `None` outside.
    pub fn locate(&self, place: &Vec3) -> Option<([usize; 3], [f64; 3])> {
        let mut cell = [0; 3];
        let mut part = [0.0; 3];
        for axis in 0..3 {
            let t = (place[axis] - self.origin_angstrom[axis]) / self.spacing_angstrom;
            let last = self.shape[axis] - 1;
            if t.is_nan() || t < 0.0 || t > last as f64 {
                return None;
            }
            cell[axis] = (t as usize).min(last - 1);
            part[axis] = t - cell[axis] as f64;
        }
        Some((cell, part))
    }
}

/// Values on a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarField {
    /// Where.
    pub grid: Grid,
    /// What, x fastest.
    pub values: Vec<f64>,
}

impl ScalarField {
    /// The trilinear interpolant; `None` outside the grid.
    pub fn at(&self, place: &Vec3) -> Option<f64> {
        let (cell, part) = self.grid.locate(place)?;
        Some(interpolate(&part, |di, dj, dk| {
            self.values[self.grid.index(cell[0] + di, cell[1] + dj, cell[2] + dk)]
        }))
    }
}

/// Trilinear interpolation between eight corners.
pub(crate) fn interpolate(
    part: &[f64; 3],
    mut corner: impl FnMut(usize, usize, usize) -> f64,
) -> f64 {
    let mut sum = 0.0;
    for dk in 0..2 {
        for dj in 0..2 {
            for di in 0..2 {
                let weight = |d: usize, t: f64| if d == 1 { t } else { 1.0 - t };
                let weight = weight(di, part[0]) * weight(dj, part[1]) * weight(dk, part[2]);
                if weight > 0.0 {
                    sum += weight * corner(di, dj, dk);
                }
            }
        }
    }
    sum
}

/// Interpolation by cubic polynomials through four points along each axis, for a cell that has all
/// its neighbours.
pub(crate) fn interpolate_cubically(
    part: &[f64; 3],
    mut point: impl FnMut(usize, usize, usize) -> f64,
) -> f64 {
    // Lagrange's weights for points at -1, 0, 1, 2.
    let weights = part.map(|t| {
        [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ]
    });
    let mut sum = 0.0;
    for (dk, wk) in weights[2].iter().enumerate() {
        for (dj, wj) in weights[1].iter().enumerate() {
            for (di, wi) in weights[0].iter().enumerate() {
                sum += wi * wj * wk * point(di, dj, dk);
            }
        }
    }
    sum
}
