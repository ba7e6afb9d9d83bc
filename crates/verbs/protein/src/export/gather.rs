//! A cluster across the border of a periodic box in one piece.

use protomer_kernel::Vec3;
use std::f64::consts::TAU;

/// Moves positions by whole box lengths to their images nearest to the circular mean of all, so that
/// a cluster across the border appears in one piece.
///
/// ```
/// use protomer_protein_verbs::export::gather;
/// use protomer_kernel::Vec3;
/// let (mut first, mut second) = (Vec3::new(-48.0, 0.0, 0.0), Vec3::new(47.0, 0.0, 0.0));
/// gather(&mut [&mut first, &mut second], [100.0; 3]);
/// assert!((first.x - second.x - 5.0).abs() < 1e-9);
/// ```
pub fn gather(positions: &mut [&mut Vec3], lengths_angstrom: [f64; 3]) {
    for (axis, length) in lengths_angstrom.into_iter().enumerate() {
        let (mut sine, mut cosine) = (0.0, 0.0);
        for position in positions.iter() {
            let angle = TAU * position[axis] / length;
            (sine, cosine) = (sine + angle.sin(), cosine + angle.cos());
        }
        let middle: f64 = sine.atan2(cosine) / TAU * length;
        for position in positions.iter_mut() {
            let offset = position[axis] - middle;
            position[axis] = middle + offset - length * (offset / length).round();
        }
    }
}
