//! Lists that the steps hand to each other, reused from one target leaf to the next.

use super::super::leaves::LEAF;
use super::CHUNK;
use super::sources::Sources;

/// The t of entries that fill a list up: beyond any cut-off.
const FILLER: f32 = 1e9;

/// Reusable lists.
#[derive(Debug, Default)]
pub struct Lists {
    /// Leaves that straddle the cut-off, with D and |D|² - r_cut².
    pub leaves: Vec<u32>,
    pub shifts: [Vec<f32>; 4],
    pub straddling: usize,
    /// Leaves that may have near pairs.
    pub near_leaves: Vec<u32>,
    pub near: usize,
    /// The charges of straddling leaves by their place in `leaves`; one more place is filled with
    /// what has no effect.
    pub placed: Vec<Placed>,
    /// Charges to compare: [`LEAF`] times the place in `leaves`, and the place in the leaf.
    pub listed: Vec<u32>,
    pub count: usize,
}

/// Charges where they stand: d, charge and t.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub struct Placed(pub [[f32; LEAF]; 5]);

impl Lists {
    /// Room for everything that these sources can put in; vectors may be stored past the last
    /// entry.
    pub fn new(sources: &Sources) -> Self {
        let leaves = sources.spheres.len() * LEAF + LEAF;
        Self {
            leaves: vec![0; leaves],
            shifts: std::array::from_fn(|_| vec![0.0; leaves]),
            near_leaves: vec![0; leaves],
            placed: vec![Placed::default(); leaves],
            listed: vec![0; leaves * LEAF + CHUNK],
            ..Self::default()
        }
    }

    /// Fills the last chunk up with charges of no effect.
    #[inline(always)]
    pub fn fill(&mut self) {
        self.placed[self.straddling] = Placed([
            [0.0; LEAF],
            [0.0; LEAF],
            [0.0; LEAF],
            [0.0; LEAF],
            [FILLER; LEAF],
        ]);
        self.listed[self.count..self.count + CHUNK].fill((self.straddling * LEAF) as u32);
    }
}
