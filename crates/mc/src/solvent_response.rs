//! The response of the solvent that two bodies displace, as a term of their energy.
//!
//! A body has a table, what it does to charge and to displaced volume at a place, and sites, where its
//! own charge and volume are (`protomer_field::solvent_response` has the equation and makes both). The
//! energy of a pose is the sum over the sites of each body in the table of the other. Sites gather the
//! charges of several residues, so shares of residues come from the charges at their own places.

use crate::energy::terms::{PairPotential, Term};
use crate::{McError, Result};
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use std::sync::Arc;

/// Charge (e), volume of low permittivity and volume without ions (Å³).
pub type Amounts = [f64; 3];

/// Values on the points of a grid, with x running fastest.
#[derive(Debug, Clone)]
pub struct ResponseGrid {
    /// The lowest corner in the frame of the body, Å.
    pub origin_angstrom: Vec3,
    /// Distance between neighbouring points, Å.
    pub spacing_angstrom: f64,
    /// Points along x, y and z.
    pub shape: [usize; 3],
    /// Energy per amount, kT/e and kT/Å³.
    pub values: Vec<[f32; 3]>,
}

/// Tables and sites of one kind of body in one medium, for the response.
#[derive(Debug)]
pub struct ResponseBody {
    grid: ResponseGrid,
    /// Four numbers each, so that a point is one load; the last is zero.
    values: Vec<[f32; 4]>,
    sites: Vec<(Vec3, [f32; 4])>,
    /// The charges at their own places (Å, e).
    charges: Vec<(Vec3, f64)>,
    /// The farthest site from the origin, Å.
    radius_angstrom: f64,
    /// The farthest corner of the grid from the origin, Å.
    reach_angstrom: f64,
}

impl ResponseBody {
    /// A table, the sites of the same body, and its charges (Å, e), which the sites hold as well.
    ///
    /// # Errors
    /// [`McError::BadSetting`] for a grid without cells, or with another number of values than points.
    pub fn new(
        mut grid: ResponseGrid,
        sites: &[(Vec3, Amounts)],
        charges: Vec<(Vec3, f64)>,
    ) -> Result<Self> {
        let points: usize = grid.shape.iter().product();
        let has_cells = grid.shape.iter().all(|points| *points > 1);
        if !has_cells || grid.values.len() != points || grid.spacing_angstrom <= 0.0 {
            return Err(McError::BadSetting {
                setting: "points of the solvent's response",
                value: points as f64,
                requirement: "two at least along each axis, with a value each",
            });
        }
        let values = std::mem::take(&mut grid.values);
        let steps = grid.shape.map(|points| (points - 1) as f64);
        let high = grid.origin_angstrom + grid.spacing_angstrom * Vec3::from(steps);
        let reach_angstrom = grid.origin_angstrom.abs().sup(&high.abs()).norm();
        let radius_angstrom = sites
            .iter()
            .fold(0.0, |radius: f64, (place, _)| radius.max(place.norm()));
        Ok(Self {
            values: values.iter().map(|[a, b, c]| [*a, *b, *c, 0.0]).collect(),
            sites: sites
                .iter()
                .map(|(place, [a, b, c])| (*place, [*a as f32, *b as f32, *c as f32, 0.0]))
                .collect(),
            charges,
            grid,
            radius_angstrom,
            reach_angstrom,
        })
    }

    /// The energy of another body's sites in the table of this one, at a pose of the other body in the
    /// frame of this one, kT.
    fn acting_on(&self, other: &Self, pose: &RelativePose) -> f64 {
        let mut sum = 0.0;
        for (place, amounts) in &other.sites {
            sum += self.energy_of_site(&pose.transform_point(place), amounts);
        }
        sum
    }

    /// The energy of one site, kT; zero beyond the table.
    // Tables of two bodies are larger than the cache, and a step costs its eight loads: amounts and
    // values are four lanes wide, so that a corner is one load, one product and one sum.
    #[inline]
    fn energy_of_site(&self, place: &Vec3, amounts: &[f32; 4]) -> f64 {
        let shape = &self.grid.shape;
        let mut cell = [0; 3];
        let mut part = [0.0_f32; 3];
        for axis in 0..3 {
            let steps =
                (place[axis] - self.grid.origin_angstrom[axis]) / self.grid.spacing_angstrom;
            if !(0.0..(shape[axis] - 1) as f64).contains(&steps) {
                return 0.0;
            }
            cell[axis] = steps as usize;
            part[axis] = (steps - cell[axis] as f64) as f32;
        }
        let first = (cell[2] * shape[1] + cell[1]) * shape[0] + cell[0];
        let mut sum = [0.0_f32; 4];
        for (dz, wz) in [(0, 1.0 - part[2]), (1, part[2])] {
            for (dy, wy) in [(0, 1.0 - part[1]), (1, part[1])] {
                let row = first + (dz * shape[1] + dy) * shape[0];
                for (dx, wx) in [(0, 1.0 - part[0]), (1, part[0])] {
                    let (value, weight) = (&self.values[row + dx], wz * wy * wx);
                    for lane in 0..4 {
                        sum[lane] += weight * value[lane];
                    }
                }
            }
        }
        let energy: f32 = (0..4).map(|lane| sum[lane] * amounts[lane]).sum();
        f64::from(energy)
    }
}

/// The response of the solvent to two bodies.
#[derive(Debug, Clone)]
pub struct SolventResponse {
    first: Arc<ResponseBody>,
    second: Arc<ResponseBody>,
}

impl SolventResponse {
    /// Two bodies.
    pub fn new(first: Arc<ResponseBody>, second: Arc<ResponseBody>) -> Self {
        Self { first, second }
    }
}

impl PairPotential for SolventResponse {
    fn term(&self) -> Term {
        Term::SolventResponse
    }

    fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
        let inverse = second_in_first.inverse();
        self.first.acting_on(&self.second, second_in_first)
            + self.second.acting_on(&self.first, &inverse)
    }

    fn shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64)) {
        let inverse = second_in_first.inverse();
        let acting = [
            (0, &self.second, &self.first, &inverse),
            (1, &self.first, &self.second, second_in_first),
        ];
        for (number, acting, other, pose) in acting {
            let mut share = |place: &Vec3, amounts: &[f32; 4]| {
                let energy_kt = acting.energy_of_site(&pose.transform_point(place), amounts);
                if energy_kt != 0.0 {
                    take(number, place, energy_kt);
                }
            };
            for (place, charge_e) in &other.charges {
                share(place, &[*charge_e as f32, 0.0, 0.0, 0.0]);
            }
            for (place, [_, dielectric, ionic, _]) in &other.sites {
                share(place, &[0.0, *dielectric, *ionic, 0.0]);
            }
        }
    }

    fn reach_angstrom(&self, _: f64) -> f64 {
        let of_first = self.first.reach_angstrom + self.second.radius_angstrom;
        let of_second = self.second.reach_angstrom + self.first.radius_angstrom;
        of_first.max(of_second)
    }

    fn tail_angstrom3(&self, _: f64) -> f64 {
        0.0
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Rotation};

    /// A body whose table holds `value` at the places of its points.
    fn body(value: impl Fn(&Vec3) -> [f64; 3], sites: &[(Vec3, Amounts)]) -> Arc<ResponseBody> {
        let (shape, spacing_angstrom) = ([21, 25, 23], 1.0);
        let origin_angstrom = Vec3::new(-10.0, -12.0, -11.0);
        let mut values = Vec::new();
        for k in 0..shape[2] {
            for j in 0..shape[1] {
                for i in 0..shape[0] {
                    let place = origin_angstrom + Vec3::new(i as f64, j as f64, k as f64);
                    values.push(value(&place).map(|number| number as f32));
                }
            }
        }
        let grid = ResponseGrid {
            origin_angstrom,
            spacing_angstrom,
            shape,
            values,
        };
        let charges = sites.iter().map(|(place, amounts)| (*place, amounts[0]));
        Arc::new(ResponseBody::new(grid, sites, charges.collect()).unwrap())
    }

    /// Linear tables are interpolated without error, so the energy is the sum written out.
    #[test]
    fn the_energy_is_that_of_the_sites_in_both_tables() {
        let value = |place: &Vec3| [place.x + 0.5, 2.0 - place.y, place.z * 0.25];
        let other = |place: &Vec3| [place.z, place.x - place.y, 1.0];
        let mut rng = CounterRng::new(4, 0, 0);
        let mut draw = || {
            (
                rng.vector_in_ball(3.0),
                [rng.uniform(), rng.uniform(), rng.uniform()],
            )
        };
        let sites: [Vec<(Vec3, Amounts)>; 2] = [
            (0..5).map(|_| draw()).collect(),
            (0..7).map(|_| draw()).collect(),
        ];
        let response = SolventResponse::new(body(value, &sites[0]), body(other, &sites[1]));
        let turn = Rotation::from_axis_angle(&Vec3::y_axis(), 0.7);
        let place = Vec3::new(2.0, -1.0, 3.0);
        let pose = Pose {
            position: place,
            rotation: turn,
        };
        let relative = RelativePose::new(&Pose::identity(), &pose, &place);
        let mut expected = 0.0;
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for (at, amounts) in &sites[1] {
            expected += dot(value(&(turn * at + place)), *amounts);
        }
        for (at, amounts) in &sites[0] {
            expected += dot(other(&(turn.inverse() * (at - place))), *amounts);
        }
        let found = response.energy_kt(&relative);
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        let mut shared = 0.0;
        response.shares(&relative, &mut |_, _, energy_kt| shared += energy_kt);
        assert!((found - shared).abs() < 1e-5, "{found} {shared}");
    }

    #[test]
    fn beyond_its_reach_there_is_nothing() {
        let constant = body(|_| [1.0; 3], &[(Vec3::zeros(), [1.0; 3])]);
        let response = SolventResponse::new(Arc::clone(&constant), constant);
        let place = Vec3::new(0.0, 0.0, response.reach_angstrom(0.0) + 0.1);
        let pose = Pose {
            position: place,
            rotation: Rotation::identity(),
        };
        let relative = RelativePose::new(&Pose::identity(), &pose, &place);
        assert_eq!(response.energy_kt(&relative), 0.0);
    }

    #[test]
    fn values_must_fit_the_points() {
        let grid = ResponseGrid {
            origin_angstrom: Vec3::zeros(),
            spacing_angstrom: 1.0,
            shape: [2, 2, 2],
            values: vec![[0.0; 3]; 7],
        };
        assert!(ResponseBody::new(grid, &[], Vec::new()).is_err());
    }
}
