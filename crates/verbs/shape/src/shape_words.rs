//! A shape in the words of the schema of GSD files.

use serde::Deserialize;
use std::fmt;

/// Largest difference of two coordinates of one shape, as a part of its size: files in single precision round.
const SAME: f64 = 1e-4;

/// A shape in the words of the schema.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub(crate) struct ShapeWords {
    /// Name of the kind of shape; empty where nothing is stated.
    #[serde(rename = "type")]
    pub kind: String,
    /// Half axes of an ellipsoid.
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub diameter: f64,
    pub rounding_radius: f64,
    pub vertices: Vec<Vec<f64>>,
    /// Corners of the triangles of a mesh.
    pub indices: Vec<[u32; 3]>,
    /// Centres of the balls of a union.
    pub centers: Vec<Vec<f64>>,
    pub diameters: Vec<f64>,
}

impl fmt::Display for ShapeWords {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.kind.as_str(), self.vertices.len()) {
            ("Sphere", _) => write!(f, "a Sphere of diameter {:.5}", self.diameter),
            ("Ellipsoid", _) => write!(
                f,
                "an Ellipsoid {:.5}, {:.5}, {:.5}",
                self.a, self.b, self.c
            ),
            (kind, corners) => write!(
                f,
                "a {kind} with {corners} corners, {:.5} from the centre, rounded by {:.5}",
                self.size(),
                self.rounding_radius
            ),
        }
    }
}

impl ShapeWords {
    /// Whether nothing is stated.
    pub(crate) fn is_empty(&self) -> bool {
        self.kind.is_empty()
    }

    /// Largest distance from the centre.
    fn size(&self) -> f64 {
        let corners = self.vertices.iter().chain(&self.centers);
        let radii = corners.map(|corner| corner.iter().map(|x| x * x).sum::<f64>().sqrt());
        radii.fold(self.diameter.max(self.a).max(self.b), f64::max)
    }

    /// Whether the shapes are the same to within single precision, whatever the order of their corners.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let tolerance = SAME * other.size().max(self.size()).max(f64::MIN_POSITIVE);
        let numbers = |shape: &Self| {
            let axes = [shape.a, shape.b, shape.c];
            [&axes[..], &[shape.diameter, shape.rounding_radius]].concat()
        };
        let are_close = |first: &[f64], second: &[f64]| {
            // A polygon may have been written with a third coordinate of zero.
            (0..first.len().max(second.len())).all(|axis| {
                let coordinate = |place: &[f64]| place.get(axis).copied().unwrap_or(0.0);
                (coordinate(first) - coordinate(second)).abs() <= tolerance
            })
        };
        let have_same = |first: &[Vec<f64>], second: &[Vec<f64>]| {
            first
                .iter()
                .all(|place| second.iter().any(|other| are_close(place, other)))
        };
        let have_same_corners = |first: &Self, second: &Self| {
            have_same(&first.vertices, &second.vertices)
                && have_same(&first.centers, &second.centers)
        };
        self.kind == other.kind
            && are_close(&numbers(self), &numbers(other))
            && have_same_corners(self, other)
            && have_same_corners(other, self)
    }
}
