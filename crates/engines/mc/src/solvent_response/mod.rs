//! The response of the solvent that two bodies displace, as a term of their energy.
//!
//! A body has a table, what it does to charge and to displaced volume at a place, and sites, where its
//! own charge and volume are (`protomer_field::solvent_response` has the equation and makes both). The
//! energy of a pose is the sum over the sites of each body in the table of the other. Sites gather the
//! charges of several residues, so shares of residues come from the charges at their own places.
//!
//! | module | one idea |
//! |---|---|
//! | `lookup` | four numbers at each point of a grid, and between the points |
//! | `quadratics` | the table as a polynomial about each point of a coarser grid |
//! | `blocks` | sites gathered in blocks, whose moments stand for them where the table is smooth |

mod blocks;
mod lookup;
mod quadratics;
#[cfg(test)]
mod tests;

use crate::Result;
use crate::energy::terms::{PairPotential, Term};
use crate::error::require;
use blocks::{Block, LEVELS, View};
use lookup::{Cell, Lanes, Lookup, SinglePose, Site};
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use quadratics::{Near, Quadratics};
use std::ops::Range;
use std::sync::Arc;

/// Charge (e), volume of low permittivity and volume without ions (Å³), capacitance (e²).
pub type Amounts = [f64; 4];

/// Values on the points of a grid, with x running fastest.
#[derive(Debug, Clone)]
pub struct ResponseGrid {
    /// The lowest corner in the frame of the body, Å.
    pub origin_angstrom: Vec3,
    /// Distance between neighbouring points, Å.
    pub spacing_angstrom: f64,
    /// Points along x, y and z.
    pub shape: [usize; 3],
    /// Energy per amount, kT/e, kT/Å³ and kT/e².
    pub values: Vec<[f32; 4]>,
}

/// Tables and sites of one kind of body in one medium, for the response.
#[derive(Debug)]
pub struct ResponseBody {
    table: Lookup,
    /// The table for the blocks of each level.
    quadratics: [Quadratics; LEVELS],
    /// Blocks of blocks of sites, by level.
    blocks: [Vec<Block>; LEVELS],
    sites: Vec<Site>,
    /// Sites that have a capacitance, one by one: polynomials of the table leave it out.
    responding: Vec<Site>,
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
    /// [`McError::BadSetting`](crate::McError::BadSetting) for a grid without cells, or with another number of values than points.
    pub fn new(
        grid: ResponseGrid,
        sites: &[(Vec3, Amounts)],
        charges: Vec<(Vec3, f64)>,
    ) -> Result<Self> {
        let points: usize = grid.shape.iter().product();
        let has_cells = grid.shape.iter().all(|points| *points > 1);
        require(
            "points of the solvent's response",
            points as f64,
            "two at least along each axis, with a value each",
            has_cells && grid.values.len() == points && grid.spacing_angstrom > 0.0,
        )?;
        let table = Lookup::new(grid);
        let low = table.origin_angstrom.abs();
        // The farthest corner of the grid, by the larger magnitude along each axis.
        let reach_angstrom = low.sup(&table.high_angstrom().abs()).norm();
        let radius_angstrom = sites
            .iter()
            .fold(0.0, |radius: f64, (place, _)| radius.max(place.norm()));
        let mut sites: Vec<Site> = sites.iter().map(site).collect();
        let mut responding = Vec::new();
        for site in &mut sites {
            let capacitance = std::mem::take(&mut site.amounts[3]);
            if capacitance != 0.0 {
                responding.push(Site {
                    place: site.place,
                    amounts: [0.0, 0.0, 0.0, capacitance],
                });
            }
        }
        sites.retain(|site| site.amounts != [0.0; 4]);
        let (blocks, sites) = Block::gather(&sites);
        Ok(Self {
            // Each level has polynomials of the width that its blocks need.
            quadratics: std::array::from_fn(|level| {
                Quadratics::new(&table, &blocks::resolution(level))
            }),
            table,
            blocks,
            sites,
            responding,
            charges,
            radius_angstrom,
            reach_angstrom,
        })
    }

    /// The energy of another body's sites in the table of this one, at a pose of the other body in the
    /// frame of this one, kT.
    fn acting_on(&self, other: &Self, pose: &RelativePose, room: &mut Room) -> f64 {
        let touches = self
            .table
            .touches_sphere(&pose.translation, other.radius_angstrom);
        // Nothing of the other body reaches the table: the usual case in a dilute system.
        if !touches {
            return 0.0;
        }
        let view = View::new(pose);
        let mut sum_kt = 0.0;
        room.open.clear();
        room.open.push(0..other.blocks[0].len());
        // Level by level and not block by block, so that many loads are on their way at once.
        for level in 0..LEVELS {
            let (quadratics, blocks) = (&self.quadratics[level], &other.blocks[level]);
            sum_kt += quadratics.energy_of_blocks_kt(blocks, &view, room);
        }
        let (table, pose) = (&self.table, &view.pose);
        sum_kt += table.energy_of_sites_kt(&other.sites, &room.open, pose, &mut room.cells);
        let all = 0..other.responding.len();
        let all = std::slice::from_ref(&all);
        sum_kt + table.energy_of_sites_kt(&other.responding, all, pose, &mut room.cells)
    }
}

/// Lists of what is left to do, kept from one level and one body to the next.
#[derive(Default)]
struct Room {
    /// Ranges of blocks, or of sites, that no larger block stands for.
    open: Vec<Range<usize>>,
    /// Parts of the blocks of this level that are left open.
    parts: Vec<Range<usize>>,
    /// Blocks of this level and the polynomials next to them.
    places: Vec<(Near, usize)>,
    /// Cells of sites, and the amounts in them.
    cells: Vec<(Cell, Lanes)>,
}

fn site((place, amounts): &(Vec3, Amounts)) -> Site {
    Site {
        place: [0, 1, 2].map(|axis| place[axis] as f32),
        amounts: amounts.map(|amount| amount as f32),
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
        let (inverse, mut room) = (second_in_first.inverse(), Room::default());
        let first = &self.first;
        first.acting_on(&self.second, second_in_first, &mut room)
            + self.second.acting_on(first, &inverse, &mut room)
    }

    fn shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64)) {
        let inverse = second_in_first.inverse();
        let acting = [
            (0, &self.second, &self.first, &inverse),
            (1, &self.first, &self.second, second_in_first),
        ];
        for (number, acting, other, pose) in acting {
            let pose = SinglePose::new(pose);
            let mut share = |site: &Site, place: &Vec3| {
                let energy_kt = acting.table.energy_kt(site, &pose);
                if energy_kt != 0.0 {
                    take(number, place, energy_kt);
                }
            };
            // Charges at their own places, not where sites
            // have gathered them: shares are by residue.
            for (place, charge_e) in &other.charges {
                share(&site(&(*place, [*charge_e, 0.0, 0.0, 0.0])), place);
            }
            for gathered in &other.responding {
                share(gathered, &Vec3::from(gathered.place.map(f64::from)));
            }
            for gathered in &other.sites {
                let mut volume = *gathered;
                // Its charge has been handed out above.
                volume.amounts[0] = 0.0;
                share(&volume, &Vec3::from(gathered.place.map(f64::from)));
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
