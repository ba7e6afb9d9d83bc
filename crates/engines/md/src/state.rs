//! Where bodies are, how they are turned, and how they move.

use crate::body::Kind;
use protomer_kernel::{Boundary, Rotation, Vec3};
use serde::{Deserialize, Serialize};

/// Bodies of one or several kinds.
///
/// ```
/// use protomer_md::{body::Kind, state::Bodies};
/// let bodies = Bodies {
///     kinds: vec![Kind::ball(2, 0.5)?, Kind::ball(2, 1.0)?],
///     kind_of: vec![0, 0, 1],
/// };
/// assert_eq!((bodies.count(), bodies.dimension(), bodies.turns()), (3, 2, 0));
/// assert!((bodies.sigma() - 4.0 / 3.0).abs() < 1e-12, "the mean diameter");
/// # Ok::<(), protomer_md::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Bodies {
    /// The kinds.
    pub kinds: Vec<Kind>,
    /// Number of the kind of each body.
    pub kind_of: Vec<usize>,
}

impl Bodies {
    /// Bodies of one kind.
    ///
    /// ```
    /// use protomer_md::{body::Kind, state::Bodies};
    /// let bodies = Bodies::of_one_kind(Kind::ball(3, 1.0)?, 100);
    /// assert_eq!((bodies.count(), bodies.kinds.len()), (100, 1));
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn of_one_kind(kind: Kind, count: usize) -> Self {
        Self {
            kinds: vec![kind],
            kind_of: vec![0; count],
        }
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.kind_of.len()
    }

    /// The kind of a body.
    ///
    /// ```
    /// use protomer_md::{body::Kind, state::Bodies};
    /// let kinds = vec![Kind::ball(2, 0.5)?, Kind::ball(2, 1.0)?];
    /// let bodies = Bodies { kinds, kind_of: vec![0, 1, 0] };
    /// assert_eq!(bodies.kind(1).inradius(), 1.0);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn kind(&self, body: usize) -> &Kind {
        &self.kinds[self.kind_of[body]]
    }

    /// Whether a state has as many bodies as these, in as many dimensions.
    pub(crate) fn fit(&self, state: &State) -> bool {
        let count = self.count();
        let orientation_counts = match self.dimension() {
            2 => [0, count],
            _ => [count, 0],
        };
        [
            state.positions.len(),
            state.velocities.len(),
            state.spins.len(),
        ] == [count; 3]
            && [state.rotations.len(), state.angles_rad.len()] == orientation_counts
    }

    /// Number of dimensions, 2 or 3.
    pub fn dimension(&self) -> usize {
        self.kinds.first().map_or(3, |kind| kind.dimension)
    }

    /// Length σ: the mean of the diameters of the largest balls about the centres that fit in.
    pub fn sigma(&self) -> f64 {
        let diameters = (0..self.count()).map(|body| 2.0 * self.kind(body).inradius());
        diameters.sum::<f64>() / self.count().max(1) as f64
    }

    /// Number of rotational degrees of freedom of all bodies.
    pub fn turns(&self) -> usize {
        (0..self.count()).map(|body| self.kind(body).turns()).sum()
    }
}

/// The motion of bodies. Reduced units: density 1, energy ε, lengths in the unit of the shapes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// The space. In a plane the third length of a box plays no part.
    pub space: Boundary,
    /// Centres; they are not wrapped into the box, so that displacements can be followed.
    pub positions: Vec<Vec3>,
    /// Velocities of the centres.
    pub velocities: Vec<Vec3>,
    /// Orientations of bodies in space; empty in a plane.
    pub rotations: Vec<Rotation>,
    /// Orientations in a plane, radians, not wrapped; empty in space.
    pub angles_rad: Vec<f64>,
    /// Angular momenta in the frame of each body; in a plane the third component.
    pub spins: Vec<Vec3>,
}

impl State {
    /// Bodies at rest, not turned.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// use protomer_md::{body::Kind, state::{Bodies, State}};
    /// let bodies = Bodies::of_one_kind(Kind::ball(3, 0.5)?, 2);
    /// let state = State::at_rest(&bodies, Boundary::Open, vec![Vec3::zeros(), Vec3::x()]);
    /// assert_eq!(state.kinetic_energies(&bodies), [0.0, 0.0]);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn at_rest(bodies: &Bodies, space: Boundary, positions: Vec<Vec3>) -> Self {
        let count = positions.len();
        let is_flat = bodies.dimension() == 2;
        Self {
            space,
            velocities: vec![Vec3::zeros(); count],
            rotations: vec![Rotation::identity(); if is_flat { 0 } else { count }],
            angles_rad: vec![0.0; if is_flat { count } else { 0 }],
            spins: vec![Vec3::zeros(); count],
            positions,
        }
    }

    /// The orientation of a body.
    pub fn rotation(&self, body: usize) -> Rotation {
        match self.angles_rad.get(body) {
            Some(angle) => Rotation::from_axis_angle(&Vec3::z_axis(), *angle),
            None => self.rotations[body],
        }
    }

    /// Area or volume of the box; infinite without one.
    pub fn volume(&self, dimension: usize) -> f64 {
        match self.space {
            Boundary::Periodic { lengths_angstrom } => {
                lengths_angstrom.iter().take(dimension).product()
            }
            Boundary::Open | Boundary::SphereWall { .. } => f64::INFINITY,
        }
    }

    /// Kinetic energies of the centres and of the rotations.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// use protomer_md::{body::Kind, state::{Bodies, State}};
    /// let ball = Kind::ball(3, 0.5)?.of_unit_volume()?;
    /// let bodies = Bodies::of_one_kind(ball, 1);
    /// let mut state = State::at_rest(&bodies, Boundary::Open, vec![Vec3::zeros()]);
    /// state.velocities[0] = Vec3::new(3.0, 4.0, 0.0);
    /// let [moving, turning] = state.kinetic_energies(&bodies);
    /// assert!((moving - 12.5).abs() < 1e-9 && turning == 0.0);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn kinetic_energies(&self, bodies: &Bodies) -> [f64; 2] {
        let (mut moving, mut turning) = (0.0, 0.0);
        for body in 0..bodies.count() {
            let kind = bodies.kind(body);
            moving += 0.5 * kind.mass * self.velocities[body].norm_squared();
            let spin = self.spins[body];
            turning += 0.5 * spin.dot(&spin.component_div(&kind.moments));
        }
        [moving, turning]
    }

    /// Total momentum.
    pub fn momentum(&self, bodies: &Bodies) -> Vec3 {
        let contribution = |body: usize| bodies.kind(body).mass * self.velocities[body];
        (0..bodies.count()).map(contribution).sum()
    }

    /// Total angular momentum about the origin. Only open space keeps it.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// use protomer_md::{body::Kind, state::{Bodies, State}};
    /// let bodies = Bodies::of_one_kind(Kind::ball(3, 0.5)?.of_unit_volume()?, 1);
    /// let mut state = State::at_rest(&bodies, Boundary::Open, vec![2.0 * Vec3::x()]);
    /// state.velocities[0] = 3.0 * Vec3::y();
    /// state.spins[0] = Vec3::z();
    /// assert!((state.angular_momentum(&bodies) - 7.0 * Vec3::z()).norm() < 1e-9);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn angular_momentum(&self, bodies: &Bodies) -> Vec3 {
        let contribution = |body: usize| {
            let momentum = bodies.kind(body).mass * self.velocities[body];
            self.positions[body].cross(&momentum) + self.rotation(body) * self.spins[body]
        };
        (0..bodies.count()).map(contribution).sum()
    }
}
