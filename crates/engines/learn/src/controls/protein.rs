//! A blob with charges inside and hydropathy on its surface, and the three channels it gives.

use super::blob::Blob;
use super::raster::shell;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Rotation, Vec3};

/// Bjerrum length of water at room temperature, Å.
const BJERRUM_ANGSTROM: f64 = 7.1;
/// Debye length at about 0.1 mol/L, Å.
const DEBYE_ANGSTROM: f64 = 9.6;
/// Extent of every protein here, Å: the farthest point of its surface from its middle.
pub(super) const EXTENT_ANGSTROM: f64 = 24.0;
/// Half the thickness of the surface, in voxels.
const HALF_SHELL: f64 = 0.6;
/// Sites on the surface, each with its own hydropathy.
pub(super) const SITES: usize = 60;

/// A synthetic protein in its own frame, Å.
#[derive(Debug, Clone)]
pub(super) struct Protein {
    pub(super) blob: Blob,
    /// Place and charge (e) of each charge.
    pub(super) charges: Vec<(Vec3, f64)>,
    /// Place and hydropathy (Kyte-Doolittle, from -4.5 to 4.5) of each site; a voxel takes that of
    /// the nearest.
    pub(super) sites: Vec<(Vec3, f64)>,
}

impl Protein {
    /// A protein without charges whose sites are hydrophobic or hydrophilic at random.
    pub(super) fn random(random: &mut CounterRng) -> Self {
        let blob = Blob::random(random).with_extent(EXTENT_ANGSTROM);
        let mut sites = Vec::with_capacity(SITES);
        for _ in 0..SITES {
            let place = blob.point_on_surface(&random.unit_vector());
            sites.push((place, random.uniform_in(-4.5, 4.5)));
        }
        Self {
            blob,
            charges: Vec::new(),
            sites,
        }
    }

    /// Puts so many charges of each sign at random places inside.
    pub(super) fn charge(&mut self, positive: usize, negative: usize, random: &mut CounterRng) {
        for i in 0..positive + negative {
            let charge = if i < positive { 1.0 } else { -1.0 };
            self.charges.push((self.blob.point_inside(random), charge));
        }
    }

    /// Net charge, e.
    pub(super) fn net_charge(&self) -> f64 {
        self.charges.iter().map(|(_, charge)| charge).sum()
    }

    /// Screened Coulomb potential, kT/e: φ(p) = l_B Σ q exp(-r/λ) / r, with r at least 1 Å.
    fn potential(&self, p: &Vec3) -> f64 {
        let mut sum = 0.0;
        for (position, charge) in &self.charges {
            let r = (p - position).norm().max(1.0);
            sum += charge * (-r / DEBYE_ANGSTROM).exp() / r;
        }
        BJERRUM_ANGSTROM * sum
    }

    /// Hydropathy of the nearest site.
    fn hydropathy(&self, p: &Vec3) -> f64 {
        let (mut nearest, mut hydropathy) = (f64::INFINITY, 0.0);
        for (position, of_site) in &self.sites {
            let distance = (p - position).norm_squared();
            if distance < nearest {
                (nearest, hydropathy) = (distance, *of_site);
            }
        }
        hydropathy
    }

    /// The surface, turned, in a box that it fills up to a margin of one voxel: voxels, and the
    /// channels shape (1), potential (kT/e) and hydropathy there.
    pub(super) fn voxels(&self, size: usize, rotation: &Rotation) -> (Vec<u32>, [Vec<f32>; 3]) {
        let voxel_angstrom = EXTENT_ANGSTROM / (size as f64 / 2.0 - 1.0);
        let back = rotation.inverse();
        let into_frame = |p: &Vec3| back * p * voxel_angstrom;
        let surface = shell(size, HALF_SHELL, |p| {
            self.blob.distance(&into_frame(p)) / voxel_angstrom
        });
        let mut index = Vec::with_capacity(surface.len());
        let mut values = [Vec::new(), Vec::new(), Vec::new()];
        for (voxel, middle) in &surface {
            let p = into_frame(middle);
            index.push(*voxel);
            values[0].push(1.0);
            values[1].push(self.potential(&p) as f32);
            values[2].push(self.hydropathy(&p) as f32);
        }
        (index, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_by_a_quarter_only_moves_the_values() {
        let mut random = CounterRng::new(3, 0, 0);
        let mut protein = Protein::random(&mut random);
        protein.charge(6, 3, &mut random);
        assert_eq!(protein.net_charge(), 3.0);
        let quarter = Rotation::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
        let sums = |rotation: &Rotation| {
            let (index, values) = protein.voxels(16, rotation);
            let sum = |channel: Vec<f32>| channel.into_iter().map(f64::from).sum::<f64>();
            (index.len(), values.map(sum))
        };
        let (count, straight) = sums(&Rotation::identity());
        let (turned_count, turned) = sums(&quarter);
        assert_eq!(count, turned_count);
        assert!(count > 200, "{count}");
        for (a, b) in straight.iter().zip(&turned) {
            assert!((a - b).abs() < 1e-2 * (1.0 + a.abs()), "{a} {b}");
        }
    }

    #[test]
    fn the_potential_of_one_charge_is_the_screened_one() {
        let mut protein = Protein::random(&mut CounterRng::new(4, 0, 0));
        protein.charges.push((Vec3::zeros(), -2.0));
        let expected = -2.0 * 7.1 * (-1.0f64).exp() / 9.6;
        assert!((protein.potential(&Vec3::new(0.0, 9.6, 0.0)) - expected).abs() < 1e-12);
    }
}
