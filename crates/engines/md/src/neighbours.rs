//! Pairs of bodies that can feel each other before one of them has moved by half of a skin.
//!
//! Each pair of their convex parts is a separate entry; a part reaches as far as its body, however
//! that is turned.

use crate::near::{Hint, Law};
use crate::pair::Interaction;
use crate::state::{Bodies, State};
use crate::{Error, Result};
use protomer_kernel::cells::CellList;
use protomer_kernel::{Boundary, Vec3};
use serde::{Deserialize, Serialize};

/// Width of the skin over σ.
const SKIN_RATIO: f64 = 0.35;

/// A pair of parts, with a hint kept from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// The bodies; the first has the lower number.
    pub bodies: [u32; 2],
    /// Numbers of the parts in their bodies; zero for bodies of one part.
    pub parts: [u16; 2],
    /// Numbers of boxes between the nearest image of the second body and that body itself.
    pub images: [i32; 3],
    /// Hint kept from one step to the next.
    pub hint: Hint,
}

impl Pair {
    /// The vector from the first body to the image of the second.
    pub(crate) fn between(&self, state: &State) -> Vec3 {
        let [first, second] = self.bodies.map(|body| state.positions[body as usize]);
        second - first + shift(&state.space, self.images)
    }
}

/// List of pairs, in ascending order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Neighbours {
    /// The pairs.
    pub pairs: Vec<Pair>,
    /// Positions of the bodies when the pairs were found; a box that shrinks takes them with it.
    places: Vec<Vec3>,
    /// Largest distance at which bodies may interact, centre to centre.
    range: f64,
    skin: f64,
    /// Factor by which the box has shrunk since the pairs were found.
    scale: f64,
    /// Number of times that the pairs were sought.
    pub rebuilds: u64,
}

impl Neighbours {
    /// Finds the pairs.
    ///
    /// # Errors
    /// [`Error::SmallBox`] if a body would meet two images of another.
    pub fn find(bodies: &Bodies, state: &State, interaction: &Interaction) -> Result<Self> {
        Self::find_within(bodies, state, interaction, 0.0)
    }

    /// Finds the pairs whose parts may interact, and those whose centres are closer than a distance.
    ///
    /// # Errors
    /// As [`Neighbours::find`].
    pub fn find_within(
        bodies: &Bodies,
        state: &State,
        interaction: &Interaction,
        distance: f64,
    ) -> Result<Self> {
        let range = range(bodies, interaction).max(distance);
        let mut list = Self {
            pairs: Vec::new(),
            places: Vec::new(),
            range,
            skin: SKIN_RATIO * bodies.sigma(),
            scale: 1.0,
            rebuilds: 0,
        };
        list.rebuild(bodies, state)?;
        Ok(list)
    }

    /// Notes that the box and everything in it has shrunk, or grown.
    pub fn shrink(&mut self, factor: f64) {
        self.scale *= factor;
        for place in &mut self.places {
            *place *= factor;
        }
    }

    /// Finds the pairs again if they may be incomplete.
    ///
    /// # Errors
    /// As [`Neighbours::find`].
    pub fn refresh(&mut self, bodies: &Bodies, state: &State) -> Result<()> {
        // A box that shrinks by 1 - s brings bodies nearer by (1 - s) times their distance.
        let slack = self.skin - (1.0 - self.scale).abs() * (self.range + self.skin);
        // Two bodies may come nearer by twice what one moves.
        let half = 0.5 * slack;
        let far =
            |(position, place): (&Vec3, &Vec3)| (position - place).norm_squared() > half * half;
        let is_stale = half <= 0.0 || state.positions.iter().zip(&self.places).any(far);
        if is_stale {
            self.rebuild(bodies, state)?;
        }
        Ok(())
    }

    fn rebuild(&mut self, bodies: &Bodies, state: &State) -> Result<()> {
        let range = self.range + self.skin;
        let smallest = match state.space {
            Boundary::Periodic { lengths_angstrom } => lengths_angstrom.min(),
            Boundary::Open | Boundary::SphereWall { .. } => f64::INFINITY,
        };
        // Each body meets one image of another at most.
        if 2.0 * range > smallest {
            return Err(Error::SmallBox {
                smallest,
                needed: 2.0 * range,
            });
        }
        self.places.clone_from(&state.positions);
        self.scale = 1.0;
        self.rebuilds += 1;
        self.pairs.clear();
        let cells = CellList::new(&state.space, range, &state.positions);
        let mut near = Vec::new();
        for (first, position) in state.positions.iter().enumerate() {
            cells.candidates(position, &mut near);
            // Each pair once, the lower number first.
            for second in near.iter().copied().filter(|second| *second > first) {
                let between = state.positions[second] - position;
                let images = images(&state.space, &between);
                // By centres: parts reach as far as their body, however it turns.
                if (between + shift(&state.space, images)).norm_squared() < range * range {
                    let parts = [first, second].map(|body| bodies.kind(body).parts.len());
                    for entry in 0..parts[0] * parts[1] {
                        self.pairs.push(Pair {
                            bodies: [first as u32, second as u32],
                            parts: [(entry / parts[1]) as u16, (entry % parts[1]) as u16],
                            images,
                            hint: Hint::default(),
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Largest distance at which bodies may interact, centre to centre.
fn range(bodies: &Bodies, interaction: &Interaction) -> f64 {
    let parts: Vec<_> = bodies.kinds.iter().flat_map(|kind| &kind.parts).collect();
    let mut range = 0.0_f64;
    for (number, first) in parts.iter().enumerate() {
        for second in &parts[number..] {
            let law = Law::between(first, second, interaction);
            let arms = first.centre.norm() + second.centre.norm();
            range = range.max(arms + law.range);
        }
    }
    range
}

/// Numbers of boxes that lead to the nearest image.
fn images(space: &Boundary, between: &Vec3) -> [i32; 3] {
    match space {
        Boundary::Periodic { lengths_angstrom } => between
            .zip_map(lengths_angstrom, |d, length| -(d / length).round())
            .map(|boxes| boxes as i32)
            .into(),
        Boundary::Open | Boundary::SphereWall { .. } => [0; 3],
    }
}

/// The vector that leads over so many boxes.
pub(crate) fn shift(space: &Boundary, images: [i32; 3]) -> Vec3 {
    match space {
        Boundary::Periodic { lengths_angstrom } => {
            let boxes = Vec3::from(images.map(f64::from));
            boxes.component_mul(lengths_angstrom)
        }
        Boundary::Open | Boundary::SphereWall { .. } => Vec3::zeros(),
    }
}
