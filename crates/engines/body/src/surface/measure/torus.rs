//! The toroidal patch along an arc: the probe turns about the axis of two atoms.
//!
//! In the half-plane of the probe let ψ be the angle from the direction towards the axis. The
//! surface point at ψ is a - p cos ψ from the axis (a: radius of the arc's circle), and the probe
//! touches the two atoms at ψ = -α₁ and α₂ with tan α = h / a (h: distance of the atom from the
//! circle's plane). With Φ the angle of the arc
//!
//! * area Φ p ∫ (a - p cos ψ) dψ,
//! * layer Φ ∫∫ (a - ρ cos ψ) ρ dρ dψ = Φ ∫ (a p²/2 - p³ cos ψ / 3) dψ.
//!
//! If a < p the torus meets itself on the axis, at cos ψ = a / p. Between both cusps there is no
//! surface, and the layer ends at the axis, ρ = a / cos ψ, which gives Φ ∫ a³ / (6 cos² ψ) dψ.

/// Area and layer of a toroidal patch.
pub(super) struct Patch {
    pub(super) area: f64,
    pub(super) layer_volume: f64,
    pub(super) is_singular: bool,
}

/// The patch of an arc of `angle` on a circle of radius `circle`, with the atoms at `heights` on
/// both sides.
pub(super) fn patch(circle: f64, probe: f64, heights: [f64; 2], angle: f64) -> Patch {
    let (low, high) = (-heights[0].atan2(circle), heights[1].atan2(circle));
    let cusp = if circle < probe {
        (circle / probe).acos()
    } else {
        0.0
    };
    let outer = [(low, high.min(-cusp)), (low.max(cusp), high)];
    let (mut area, mut layer) = (0.0, 0.0);
    for (from, to) in outer.into_iter().filter(|(from, to)| from < to) {
        let (span, sines) = (to - from, to.sin() - from.sin());
        area += probe * (circle * span - probe * sines);
        layer += circle * probe * probe * span / 2.0 - probe.powi(3) * sines / 3.0;
    }
    let (from, to) = (low.max(-cusp), high.min(cusp));
    let is_singular = from < to;
    if is_singular {
        layer += circle.powi(3) / 6.0 * (to.tan() - from.tan());
    }
    Patch {
        area: angle * area,
        layer_volume: angle * layer,
        is_singular,
    }
}
