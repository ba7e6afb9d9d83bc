//! OpenDX scalar fields as APBS writes them: z running fastest, three values on a line.

use super::Volume;
use std::fmt::Write;

/// The text of a volume; `title` goes into a comment.
///
/// ```
/// use protomer_io::volume::{Volume, dx::write_dx};
/// let volume = Volume { shape: [2, 1, 1], origin_angstrom: [0.0; 3], spacing_angstrom: 0.5, values: vec![1.0, 2.0] };
/// assert!(write_dx("potential, kT/e", &volume).contains("object 1 class gridpositions counts 2 1 1"));
/// ```
pub fn write_dx(title: &str, volume: &Volume) -> String {
    let [nx, ny, nz] = volume.shape;
    let [x, y, z] = volume.origin_angstrom;
    let h = volume.spacing_angstrom;
    let mut text = format!("# {title}\n");
    let counts = format!("counts {nx} {ny} {nz}");
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "object 1 class gridpositions {counts}\norigin {x:.9e} {y:.9e} {z:.9e}"
    );
    let _ = writeln!(
        text,
        "delta {h:.9e} 0 0\ndelta 0 {h:.9e} 0\ndelta 0 0 {h:.9e}"
    );
    let _ = writeln!(text, "object 2 class gridconnections {counts}");
    let _ = writeln!(
        text,
        "object 3 class array type double rank 0 items {} data follows",
        nx * ny * nz
    );
    let mut written = 0;
    for i in 0..nx {
        for j in 0..ny {
            for k in 0..nz {
                written += 1;
                let end = if written % 3 == 0 || written == nx * ny * nz {
                    '\n'
                } else {
                    ' '
                };
                let _ = write!(text, "{:.6e}{end}", volume.values[(k * ny + j) * nx + i]);
            }
        }
    }
    text.push_str(
        "attribute \"dep\" string \"positions\"\nobject \"regular positions regular connections\" class field\n",
    );
    text.push_str("component \"positions\" value 1\ncomponent \"connections\" value 2\ncomponent \"data\" value 3\n");
    text
}
