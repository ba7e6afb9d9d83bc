//! A sum over the features of both bodies whose force and torques are its exact gradient.
//!
//! U = Σ over corners v of A of U(d(v, B)) + Σ over corners w of B of U(d(w, A))
//!   + Σ over edges e of A and f of B of w(e, f) U(d(e, f))      (in three dimensions)
//!
//! The distance of a point from a convex body has a continuous gradient everywhere outside, through
//! all changes of face, so the corners need no choice of a face and no weight. In two dimensions
//! they are all: one of the closest points of two polygons is a corner.
//!
//! The distance of two lines has no gradient where they are parallel, and where the closest points
//! reach the end of an edge, corners take over. So a pair of edges has the weight
//!
//! w = g(ℓ sin θ / σ_c) h(s) h(1 - s) h(t) h(1 - t)   with   g(q) = q⁴/(1 + q⁴)
//!
//! with the angle θ between the edges, the shorter length ℓ, and the places s and t of the closest
//! points along the edges. h rises from 0 at the end of an edge to 1 at σ_c (or half of the edge)
//! from it with two continuous derivatives. A tilt δ of two nearly parallel edges towards each other
//! shifts their closest points by about δ/θ², so a weight that rises with θ² would leave a torque that
//! depends on the way to θ = 0; with θ⁴ the torque vanishes there. Energies, forces and torques are continuous everywhere.
//! Rounding takes the radii from the distances, and changes nothing else.
//! Parallel squares have four times the energy of a corner on a face, parallel cubes eight times.

use super::Placed;
use super::features::Features;
use super::step::{step, step_slope};
use super::terms::Terms;
use protomer_kernel::Vec3;
use protomer_kernel::shape::closest::ClosestPoints;

/// Adds all terms.
pub fn add(terms: &mut Terms, pair: &Placed, features: &[Features; 2]) {
    let [first_features, second_features] = features;
    for corner in &first_features.corners {
        terms.repel(&ClosestPoints {
            on_first: *corner,
            on_second: second_features.nearest(corner),
        });
    }
    for corner in &second_features.corners {
        terms.repel(&ClosestPoints {
            on_first: first_features.nearest(corner),
            on_second: *corner,
        });
    }
    if pair.bodies[0].dimension == 2 {
        return;
    }
    let reach = terms.radial.range() + terms.radii;
    for first in &first_features.edges {
        for second in &second_features.edges {
            if let Some(crossing) = Crossing::find(*first, *second, reach) {
                crossing.add(terms);
            }
        }
    }
}

/// Two edges whose lines come closest within both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// Starts of the edges.
    starts: [Vec3; 2],
    /// Vectors u and v from the start of each edge to its end.
    edges: [Vec3; 2],
    /// Vector r from the start of the second edge to that of the first.
    between: Vec3,
    /// Squares u·u and v·v.
    squares: [f64; 2],
    /// Products u·v, u·r and v·r.
    products: [f64; 3],
    /// Determinant (u·u)(v·v) - (u·v)².
    determinant: f64,
    /// Places s and t of the closest points along the edges, between 0 and 1.
    places: [f64; 2],
    distance: f64,
}

impl Crossing {
    /// The crossing of two edges; `None` if they are parallel, farther apart than the reach, or
    /// closest at an end.
    pub(crate) fn find(first: [Vec3; 2], second: [Vec3; 2], reach: f64) -> Option<Self> {
        let (u, v) = (first[1] - first[0], second[1] - second[0]);
        let r = first[0] - second[0];
        let (a, b, c) = (u.norm_squared(), u.dot(&v), v.norm_squared());
        let (d, e) = (u.dot(&r), v.dot(&r));
        // (b e - c d)/(a c - b²) and (a e - b d)/(a c - b²), written with products that keep their
        // digits where the edges are nearly parallel.
        let normal = u.cross(&v);
        let determinant = normal.norm_squared();
        let places = [v.cross(&r), u.cross(&r)].map(|x| x.dot(&normal) / determinant);
        let is_within = places.iter().all(|place| *place > 0.0 && *place < 1.0);
        if !is_within {
            return None;
        }
        let distance = (r + places[0] * u - places[1] * v).norm();
        (distance < reach).then_some(Self {
            starts: [first[0], second[0]],
            edges: [u, v],
            between: r,
            squares: [a, c],
            products: [b, d, e],
            determinant,
            places,
            distance,
        })
    }

    /// Adds the term. With s and t as functions of b = u·v, d = u·r and e = v·r, the energy is a
    /// function of b, d, e and r², and its gradients by r, u and v follow from four derivatives.
    pub(crate) fn add(&self, terms: &mut Terms) {
        let radial = terms.radial;
        let [a, c] = self.squares;
        let [b, d, e] = self.products;
        let [s, t] = self.places;
        let [u, v] = self.edges;
        let r = self.between;

        let angle = AngleWeight::new(a.min(c) / radial.sigma.powi(2), self.determinant, a * c);
        let ends = [
            EndWeight::new(s, a.sqrt(), radial.sigma),
            EndWeight::new(t, c.sqrt(), radial.sigma),
        ];
        let [energy, slope] = radial.energy_and_slope(self.distance - terms.radii);
        let weight = angle.value * ends[0].value * ends[1].value;
        terms.energy += weight * energy;

        // Derivatives of s and t by b, d, e.
        let of_s = [e + 2.0 * b * s, -c, b].map(|x| x / self.determinant);
        let of_t = [2.0 * b * t - d, -b, a].map(|x| x / self.determinant);
        // Derivatives of the squared distance by b, d, e at its minimum; that by r² is 1.
        let of_square = [-2.0 * s * t, 2.0 * s, -2.0 * t];
        let by_square = weight * slope / (2.0 * self.distance);
        let by_s = angle.value * ends[0].slope * ends[1].value * energy;
        let by_t = angle.value * ends[0].value * ends[1].slope * energy;
        let mut derivatives =
            [0, 1, 2].map(|n| by_square * of_square[n] + by_s * of_s[n] + by_t * of_t[n]);
        derivatives[0] += ends[0].value * ends[1].value * energy * angle.slope(b);

        let [by_b, by_d, by_e] = derivatives;
        let force = -(by_d * u + by_e * v + 2.0 * by_square * r);
        terms.push(self.starts, force);
        terms.torques[0] -= u.cross(&(by_b * v + by_d * r));
        terms.torques[1] -= v.cross(&(by_b * u + by_e * r));
    }
}

/// Weight of the angle, g(q) = q⁴/(1 + q⁴) with q² = (ℓ/σ_c)² sin² θ.
#[derive(Debug, Clone, Copy)]
struct AngleWeight {
    value: f64,
    /// The derivative by q².
    by_square: f64,
    squared_ratio: f64,
    product: f64,
}

impl AngleWeight {
    /// Computes the weight from (ℓ/σ_c)², |u × v|² and |u|² |v|².
    fn new(squared_ratio: f64, determinant: f64, product: f64) -> Self {
        let square = squared_ratio * determinant / product;
        let below = 1.0 / (1.0 + square * square);
        Self {
            value: square * square * below,
            by_square: 2.0 * square * below * below,
            squared_ratio,
            product,
        }
    }

    /// The derivative by u·v: sin² θ is 1 - (u·v)²/(|u|² |v|²).
    fn slope(&self, dot: f64) -> f64 {
        self.by_square * self.squared_ratio * (-2.0 * dot / self.product)
    }
}

/// Weight of the ends, h(s) h(1 - s).
#[derive(Debug, Clone, Copy)]
struct EndWeight {
    value: f64,
    slope: f64,
}

impl EndWeight {
    fn new(place: f64, length: f64, sigma: f64) -> Self {
        let rise = (sigma / length).min(0.5);
        let (near, far) = (place / rise, (1.0 - place) / rise);
        Self {
            value: step(near) * step(far),
            slope: (step_slope(near) * step(far) - step(near) * step_slope(far)) / rise,
        }
    }
}
