//! A body as a set of volume elements.

use protomer_kernel::Vec3;
use protomer_kernel::overlap::CollisionShape;
use rayon::prelude::*;

/// Edge of the cubes that are tested for being inside, Å.
const VOXEL_ANGSTROM: f64 = 0.5;
/// Voxels along the edge of an element.
const VOXELS_PER_ELEMENT: usize = 4;

/// A piece of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeElement {
    /// Centre, Å.
    pub place: Vec3,
    /// The volume of low permittivity, Å³; later, the factor of the square of a gradient.
    pub dielectric: f64,
    /// The volume without ions, Å³; later, the factor of the square of a potential.
    pub ionic: f64,
}

/// A grid of voxels around a body.
struct Voxels {
    low: Vec3,
    counts: [usize; 3],
    inside: Vec<bool>,
}

/// The volume inside a surface, and that which the centres of ions cannot enter, in cubes of 2 Å;
/// those at the surface weigh what lies inside.
pub fn volume_elements(shape: &CollisionShape, ion_radius_angstrom: f64) -> Vec<VolumeElement> {
    let voxels = Voxels::new(shape, ion_radius_angstrom);
    let excluded = voxels.grown(ion_radius_angstrom);
    let mut elements = Vec::new();
    for corner in voxels.element_corners() {
        if let Some(element) = voxels.element(corner, &excluded) {
            elements.push(element);
        }
    }
    elements
}

impl Voxels {
    fn new(shape: &CollisionShape, margin_angstrom: f64) -> Self {
        let mesh = shape.mesh();
        let first = mesh.vertices.first().copied().unwrap_or_else(Vec3::zeros);
        let (mut low, mut high) = (first, first);
        for vertex in &mesh.vertices {
            low = low.inf(vertex);
            high = high.sup(vertex);
        }
        // Room for the layer that ions cannot enter, and
        // one voxel so that a surface voxel has neighbours.
        let margin = Vec3::repeat(margin_angstrom + VOXEL_ANGSTROM);
        let (low, high) = (low - margin, high + margin);
        let edge = VOXEL_ANGSTROM * VOXELS_PER_ELEMENT as f64;
        let counts: [usize; 3] = std::array::from_fn(|axis| {
            let elements = ((high[axis] - low[axis]) / edge).ceil().max(1.0) as usize;
            // Whole elements, so none is cut at the edge of the grid.
            elements * VOXELS_PER_ELEMENT
        });
        let mut voxels = Self {
            low,
            counts,
            inside: Vec::new(),
        };
        let total = counts[0] * counts[1] * counts[2];
        voxels.inside = (0..total)
            // Parallel: each voxel is a ray through the mesh.
            .into_par_iter()
            .map(|index| shape.contains_point(&voxels.centre(voxels.place(index))))
            .collect();
        voxels
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        // z runs fastest: (i n_y + j) n_z + k.
        (i * self.counts[1] + j) * self.counts[2] + k
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let plane = index / self.counts[2];
        [
            plane / self.counts[1],
            plane % self.counts[1],
            index % self.counts[2],
        ]
    }

    fn centre(&self, place: [usize; 3]) -> Vec3 {
        let offset = Vec3::from(place.map(|number| number as f64 + 0.5));
        self.low + VOXEL_ANGSTROM * offset
    }

    /// The voxels at most `distance_angstrom` from one that is inside.
    fn grown(&self, distance_angstrom: f64) -> Vec<bool> {
        let mut grown = self.inside.clone();
        let reach = (distance_angstrom / VOXEL_ANGSTROM).floor() as i64;
        // Thinner than a voxel: no layer.
        if reach == 0 {
            return grown;
        }
        let mut ball = Vec::new();
        for x in -reach..=reach {
            for y in -reach..=reach {
                for z in -reach..=reach {
                    let square = (x * x + y * y + z * z) as f64;
                    if square.sqrt() * VOXEL_ANGSTROM <= distance_angstrom {
                        ball.push([x, y, z]);
                    }
                }
            }
        }
        for (index, inside) in self.inside.iter().enumerate() {
            let place = self.place(index);
            // Only voxels at the surface: balls around inner ones add nothing new.
            if *inside && self.is_at_surface(place) {
                for offset in &ball {
                    if let Some(near) = self.shifted(place, *offset) {
                        grown[self.index(near)] = true;
                    }
                }
            }
        }
        grown
    }

    fn is_at_surface(&self, place: [usize; 3]) -> bool {
        const FACES: [[i64; 3]; 6] = [
            [1, 0, 0],
            [-1, 0, 0],
            [0, 1, 0],
            [0, -1, 0],
            [0, 0, 1],
            [0, 0, -1],
        ];
        FACES
            .iter()
            .any(|offset| match self.shifted(place, *offset) {
                Some(near) => !self.inside[self.index(near)],
                None => true,
            })
    }

    fn shifted(&self, place: [usize; 3], offset: [i64; 3]) -> Option<[usize; 3]> {
        let mut shifted = place;
        for axis in 0..3 {
            let coordinate = place[axis] as i64 + offset[axis];
            if coordinate < 0 || coordinate >= self.counts[axis] as i64 {
                return None;
            }
            shifted[axis] = coordinate as usize;
        }
        Some(shifted)
    }

    /// The first voxels of all elements.
    fn element_corners(&self) -> impl Iterator<Item = [usize; 3]> + '_ {
        let coordinates = |axis: usize| (0..self.counts[axis]).step_by(VOXELS_PER_ELEMENT);
        coordinates(0).flat_map(move |i| {
            coordinates(1).flat_map(move |j| coordinates(2).map(move |k| [i, j, k]))
        })
    }

    /// The element with this first voxel, unless it is empty.
    fn element(&self, [i, j, k]: [usize; 3], excluded: &[bool]) -> Option<VolumeElement> {
        let (mut inside, mut without_ions, mut sum) = (0.0, 0.0, Vec3::zeros());
        for x in i..i + VOXELS_PER_ELEMENT {
            for y in j..j + VOXELS_PER_ELEMENT {
                for z in k..k + VOXELS_PER_ELEMENT {
                    let index = self.index([x, y, z]);
                    if excluded[index] {
                        without_ions += 1.0;
                        // The mean place of what counts, not the middle of
                        // the cube: elements at the surface are partial.
                        sum += self.centre([x, y, z]);
                    }
                    if self.inside[index] {
                        inside += 1.0;
                    }
                }
            }
        }
        let volume = VOXEL_ANGSTROM.powi(3);
        // Without ions is the wider volume: where it is empty, both are.
        (without_ions > 0.0).then(|| VolumeElement {
            place: sum / without_ions,
            dielectric: inside * volume,
            ionic: without_ions * volume,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::TriangleMesh;

    #[test]
    fn a_cube_has_its_volume_and_grows_by_its_ions() {
        let cube = TriangleMesh::cuboid(&Vec3::repeat(-6.0), &Vec3::repeat(6.0));
        let shape = CollisionShape::new(&cube).unwrap();
        let sums = |ion_radius| {
            let mut sums = [0.0; 2];
            for element in volume_elements(&shape, ion_radius) {
                sums[0] += element.dielectric;
                sums[1] += element.ionic;
            }
            sums
        };
        let edge: f64 = 12.0;
        let [inside, excluded] = sums(0.0);
        assert_eq!(inside, excluded);
        assert!((inside / edge.powi(3) - 1.0).abs() < 0.05, "{inside}");
        // The Minkowski sum of a cube and a ball of radius 2.
        let grown = edge.powi(3)
            + 6.0 * edge * edge * 2.0
            + 3.0 * std::f64::consts::PI * edge * 4.0
            + 4.0 / 3.0 * std::f64::consts::PI * 8.0;
        let [again, excluded] = sums(2.0);
        assert_eq!(inside, again);
        assert!((excluded / grown - 1.0).abs() < 0.05, "{excluded} {grown}");
    }
}
