//! OpenDX scalar fields as APBS writes them: z running fastest, three values on a line.

use super::grid::Volume;
use std::fmt::Write;

const FOOT: &str = "attribute \"dep\" string \"positions\"\n\
                    object \"regular positions regular connections\" class field\n\
                    component \"positions\" value 1\n\
                    component \"connections\" value 2\n\
                    component \"data\" value 3\n";

/// The text of a volume; `title` goes into a comment.
///
/// ```
/// use protomer_io::volume::{Volume, dx::write_dx};
/// let volume = Volume {
///     shape: [2, 1, 1],
///     origin_angstrom: [0.0; 3],
///     spacing_angstrom: 0.5,
///     values: vec![1.0, 2.0],
/// };
/// let text = write_dx("potential, kT/e", &volume);
/// assert!(text.contains("object 1 class gridpositions counts 2 1 1"));
/// ```
pub fn write_dx(title: &str, volume: &Volume) -> String {
    let [nx, ny, nz] = volume.shape;
    let points = nx * ny * nz;
    let mut text = head(title, volume);
    let mut written = 0;
    // The values lie with x running fastest; the format
    // wants z fastest, so the loops turn it round.
    for i in 0..nx {
        for j in 0..ny {
            for k in 0..nz {
                written += 1;
                let ends_line = written % 3 == 0 || written == points;
                let end = if ends_line { '\n' } else { ' ' };
                let value = volume.values[(k * ny + j) * nx + i];
                let _ = write!(text, "{value:.6e}{end}");
            }
        }
    }
    text.push_str(FOOT);
    text
}

fn head(title: &str, volume: &Volume) -> String {
    let [nx, ny, nz] = volume.shape;
    let [x, y, z] = volume.origin_angstrom;
    let h = volume.spacing_angstrom;
    let points = nx * ny * nz;
    format!(
        "# {title}\n\
         object 1 class gridpositions counts {nx} {ny} {nz}\n\
         origin {x:.9e} {y:.9e} {z:.9e}\n\
         delta {h:.9e} 0 0\ndelta 0 {h:.9e} 0\ndelta 0 0 {h:.9e}\n\
         object 2 class gridconnections counts {nx} {ny} {nz}\n\
         object 3 class array type double rank 0 items {points} data follows\n"
    )
}
