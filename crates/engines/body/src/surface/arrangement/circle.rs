//! One circle on a unit sphere and what half-spaces leave of it.
//!
//! A cap (axis n, height h) takes the points u with n·u > h away from the unit sphere. The rim of
//! cap j is the circle u = h_j n_j + s_j (x e₁ + y e₂) with x² + y² = 1 and s_j² = 1 - h_j². Cap k
//! leaves the part of it where A x + B y ≥ C: in the plane of the circle a cap is a half-plane, so
//! arcs are clipped without trigonometry.

use protomer_kernel::Vec3;

/// A cap taken away from a unit sphere: the points u with `axis`·u > `height`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cap {
    /// Unit normal of the cap's plane, pointing into the cap.
    pub(crate) axis: Vec3,
    /// Distance of the plane from the sphere's centre, in radii, within (-1, 1).
    pub(crate) height: f64,
    /// Number of the ball or plane that takes the cap away.
    pub(crate) owner: u32,
}

/// A part of a circle, counter-clockwise about the axis of its cap, in the frame of
/// [`CircleFrame`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct CircleArc {
    /// Unit vectors of the two ends in the circle's plane.
    pub(crate) ends: [[f64; 2]; 2],
    /// Owners of the caps that bound the arc at its two ends.
    pub(crate) owners: [u32; 2],
}

/// Exposed part of a circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exposure {
    /// The arcs that were returned, perhaps none.
    Arcs,
    /// The whole circle.
    Whole,
}

/// Axes in the plane of a circle; `e1`, `e2`, `axis` is right-handed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CircleFrame {
    pub(crate) axis: Vec3,
    pub(crate) e1: Vec3,
    pub(crate) e2: Vec3,
    pub(crate) height: f64,
    pub(crate) radius: f64,
}

impl CircleFrame {
    pub(crate) fn new(cap: &Cap) -> Self {
        let (e1, e2) = perpendicular_axes(&cap.axis);
        // 1 - h² as a product, which keeps its digits where h is near 1.
        let radius = ((1.0 - cap.height) * (1.0 + cap.height)).max(0.0).sqrt();
        Self {
            axis: cap.axis,
            e1,
            e2,
            height: cap.height,
            radius,
        }
    }

    /// The unit vector in the circle's plane with these coordinates.
    pub(crate) fn direction(&self, [x, y]: [f64; 2]) -> Vec3 {
        self.e1 * x + self.e2 * y
    }
}

/// Two unit vectors that make a right-handed frame with `axis`.
pub(crate) fn perpendicular_axes(axis: &Vec3) -> (Vec3, Vec3) {
    // |x| >= 0.6 leaves |y| <= 0.8: the cross product is never shorter than 0.6.
    let least = if axis.x.abs() < 0.6 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let e1 = least.cross(axis).normalize();
    (e1, axis.cross(&e1))
}

/// Clips the rim of `caps[index]` by all other caps and leaves what remains in `arcs` (emptied
/// first).
///
/// Caps in order of falling size make buried circles vanish after a few steps.
pub(crate) fn exposed_arcs(
    caps: &[Cap],
    index: usize,
    frame: &CircleFrame,
    arcs: &mut Vec<CircleArc>,
) -> Exposure {
    arcs.clear();
    let mut whole = true;
    for (other, cap) in caps.iter().enumerate() {
        if other == index {
            continue;
        }
        // A x + B y >= C keeps; A² + B² = s² (1 - (n_j·n_k)²).
        let a = -frame.radius * cap.axis.dot(&frame.e1);
        let b = -frame.radius * cap.axis.dot(&frame.e2);
        let c = frame.height * cap.axis.dot(&frame.axis) - cap.height;
        let square = a * a + b * b;
        // The half-plane holds the whole circle or nothing
        // of it: C > √(A² + B²) or C < -√(A² + B²).
        if c * c >= square {
            if c <= 0.0 {
                continue;
            }
            arcs.clear();
            // All of the circle is in another ball: the rest cannot bring anything back.
            return Exposure::Arcs;
        }
        clip(arcs, whole, [a, b, c], square, cap.owner);
        whole = false;
        if arcs.is_empty() {
            return Exposure::Arcs;
        }
    }
    if whole {
        Exposure::Whole
    } else {
        Exposure::Arcs
    }
}

/// Intersects the arcs with the half-plane a x + b y >= c that cuts the unit circle.
fn clip(arcs: &mut Vec<CircleArc>, whole: bool, [a, b, c]: [f64; 3], square: f64, owner: u32) {
    // Positive: c² < a² + b² was checked.
    let scale = square.sqrt().recip();
    let (mx, my, cosine) = (a * scale, b * scale, c * scale);
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    // The two points with m·p = cosine, one turn of ±acos to either side of m.
    let enter = [mx * cosine + my * sine, my * cosine - mx * sine];
    let leave = [mx * cosine - my * sine, my * cosine + mx * sine];
    if whole {
        arcs.push(CircleArc {
            ends: [enter, leave],
            owners: [owner, owner],
        });
        return;
    }
    let is_kept = |p: &[f64; 2]| a * p[0] + b * p[1] >= c;
    // Backwards, so that what is pushed or swapped in was already clipped.
    for index in (0..arcs.len()).rev() {
        let arc = arcs[index];
        let [start, end] = arc.ends;
        let within = |p: &[f64; 2]| turn(&start, p) < turn(&start, &end);
        match (is_kept(&start), is_kept(&end)) {
            (true, false) => {
                arcs[index] = CircleArc {
                    ends: [start, leave],
                    owners: [arc.owners[0], owner],
                }
            }
            (false, true) => {
                arcs[index] = CircleArc {
                    ends: [enter, end],
                    owners: [owner, arc.owners[1]],
                }
            }
            (true, true) => {
                // The half-plane takes a piece out of the middle only if both of its ends lie on
                // the arc, in this order.
                if within(&leave) && turn(&start, &leave) < turn(&start, &enter) {
                    arcs[index] = CircleArc {
                        ends: [start, leave],
                        owners: [arc.owners[0], owner],
                    };
                    arcs.push(CircleArc {
                        ends: [enter, end],
                        owners: [owner, arc.owners[1]],
                    });
                }
            }
            (false, false) => {
                if within(&enter) && turn(&start, &enter) < turn(&start, &leave) {
                    arcs[index] = CircleArc {
                        ends: [enter, leave],
                        owners: [owner, owner],
                    };
                } else {
                    arcs.swap_remove(index);
                }
            }
        }
    }
}

/// A number in [0, 4) that grows with the counter-clockwise angle from unit vector `from` to `to`.
pub(crate) fn turn(from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let cosine = from[0] * to[0] + from[1] * to[1];
    let sine = from[0] * to[1] - from[1] * to[0];
    let ratio = sine / (cosine.abs() + sine.abs());
    if cosine >= 0.0 {
        if sine >= 0.0 { ratio } else { 4.0 + ratio }
    } else {
        2.0 - ratio
    }
}

/// The counter-clockwise angle from unit vector `from` to `to`, within (0, 2π].
pub(crate) fn counter_clockwise_angle(from: &[f64; 2], to: &[f64; 2]) -> f64 {
    let cosine = from[0] * to[0] + from[1] * to[1];
    let sine = from[0] * to[1] - from[1] * to[0];
    let angle = sine.atan2(cosine);
    if angle <= 0.0 {
        angle + std::f64::consts::TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn turn_grows_with_the_angle() {
        let from = [0.6, 0.8];
        let mut last = -1.0;
        for step in 0..1000 {
            let angle = TAU * f64::from(step) / 1000.0 + 1e-4;
            let to = [
                0.6 * angle.cos() - 0.8 * angle.sin(),
                0.8 * angle.cos() + 0.6 * angle.sin(),
            ];
            let value = turn(&from, &to);
            assert!(value > last && value < 4.0);
            assert!((counter_clockwise_angle(&from, &to) - angle).abs() < 1e-12);
            last = value;
        }
    }

    #[test]
    fn clipped_arcs_agree_with_sampling() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 * 2.0 - 1.0
        };
        for _ in 0..2000 {
            let caps: Vec<Cap> = (0..6)
                .map(|owner| Cap {
                    axis: Vec3::new(random(), random(), random()).normalize(),
                    height: random() * 0.6 + 0.3,
                    owner,
                })
                .collect();
            let frame = CircleFrame::new(&caps[0]);
            let mut arcs = Vec::new();
            let exposure = exposed_arcs(&caps, 0, &frame, &mut arcs);
            let length: f64 = match exposure {
                Exposure::Whole => TAU,
                Exposure::Arcs => arcs
                    .iter()
                    .map(|arc| counter_clockwise_angle(&arc.ends[0], &arc.ends[1]))
                    .sum(),
            };
            let samples = 2000;
            let outside = (0..samples)
                .filter(|&sample| {
                    let angle = TAU * (f64::from(sample) + 0.5) / f64::from(samples);
                    let u = frame.axis * frame.height
                        + frame.direction([angle.cos(), angle.sin()]) * frame.radius;
                    caps[1..].iter().all(|cap| cap.axis.dot(&u) <= cap.height)
                })
                .count();
            let sampled = TAU * outside as f64 / f64::from(samples);
            assert!(
                (sampled - length).abs() < 12.0 * PI / f64::from(samples),
                "{sampled} {length}"
            );
        }
    }
}
