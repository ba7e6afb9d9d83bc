//! Bodies in three dimensions: meshes with colours, and how they stand together.

use protomer_kernel::{Pose, TriangleMesh};

/// A mesh with its values.
#[derive(Debug, Clone)]
pub struct ShownMesh {
    /// Name of the body.
    pub name: String,
    /// Surface of the body, Å.
    pub mesh: TriangleMesh,
    /// Values of the vertices for each colouring; NaN for none.
    pub values: Vec<Vec<f64>>,
}

/// A colour scale.
#[derive(Debug, Clone)]
pub struct Colouring {
    /// Name in the menu.
    pub name: String,
    /// Quantity and unit, below the scale.
    pub unit: String,
    /// The value at the upper end; the lower end is its negative.
    pub limit: f64,
    /// Colours of the lower end, the middle and the upper end.
    pub colours: [&'static str; 3],
}

/// Bodies shown together.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Name in the menu.
    pub name: String,
    /// The mesh and the pose of each body.
    pub bodies: Vec<(usize, Pose)>,
    /// The colouring that is chosen with the scene; `None` for the one that is shown.
    pub colouring: Option<usize>,
    /// Motion of the bodies, if any.
    pub film: Option<Film>,
}

/// Bodies that move.
#[derive(Debug, Clone)]
pub struct Film {
    /// Text next to each frame, and the pose of each body in it.
    pub frames: Vec<(String, Vec<Pose>)>,
    /// Edge lengths of the box about the origin, Å.
    pub box_angstrom: Option<[f64; 3]>,
}

/// The data of the viewer.
#[derive(Debug, Clone, Default)]
pub struct Shown {
    /// The meshes.
    pub meshes: Vec<ShownMesh>,
    /// The colourings; the first is shown initially.
    pub colourings: Vec<Colouring>,
    /// The scenes; the first is shown initially.
    pub scenes: Vec<Scene>,
}
