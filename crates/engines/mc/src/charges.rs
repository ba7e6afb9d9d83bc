//! The charges of a body, laid out for vector units.

use protomer_kernel::Vec3;

/// Number of charges processed together. Sums use this many partial sums on every processor,
/// so energies are identical bit for bit everywhere.
pub const LANES: usize = 8;

/// Point charges in the body's frame, in groups of [`LANES`] near neighbours, each in its bounding
/// sphere. Sites without charge are omitted; the last group is padded with zero charges.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_mc::charges::ChargeCloud;
/// let dipole = ChargeCloud::new(&[(Vec3::x(), 1.0), (-Vec3::x(), -1.0)]);
/// assert_eq!((dipole.len(), dipole.net_charge_e()), (2, 0.0));
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChargeCloud {
    groups: Vec<ChargeGroup>,
    count: usize,
    net_charge_e: f64,
    sum_of_magnitudes_e: f64,
    radius_angstrom: f64,
}

/// [`LANES`] neighbouring charges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChargeGroup {
    /// Coordinates, Å.
    pub x: [f64; LANES],
    /// Coordinates, Å.
    pub y: [f64; LANES],
    /// Coordinates, Å.
    pub z: [f64; LANES],
    /// Charges, e.
    pub charge_e: [f64; LANES],
    /// Centre of the bounding sphere, Å.
    pub centre: Vec3,
    /// Radius of the bounding sphere, Å.
    pub radius_angstrom: f64,
}

impl ChargeCloud {
    /// Groups the charges (position in Å, charge in e).
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_mc::charges::ChargeCloud;
    /// let atoms = [(Vec3::zeros(), 0.0), (Vec3::x(), 0.5), (Vec3::y(), -1.5)];
    /// assert_eq!(ChargeCloud::new(&atoms).len(), 2, "an atom without charge is no site");
    /// ```
    pub fn new(charges: &[(Vec3, f64)]) -> Self {
        let mut charged: Vec<(Vec3, f64)> = charges
            .iter()
            // Sites without charge cost time in every pair sum and change nothing.
            .filter(|(_, charge)| *charge != 0.0)
            .copied()
            .collect();
        let radius_angstrom = charged
            .iter()
            .map(|(position, _)| position.norm_squared())
            .fold(0.0, f64::max)
            .sqrt();
        let mut groups = Vec::with_capacity(charged.len().div_ceil(LANES));
        near_neighbours(&mut charged, &mut |near| {
            groups.push(ChargeGroup::new(near))
        });
        Self {
            count: charged.len(),
            net_charge_e: charges.iter().map(|(_, charge)| charge).sum(),
            sum_of_magnitudes_e: charges.iter().map(|(_, charge)| charge.abs()).sum(),
            groups,
            radius_angstrom,
        }
    }

    /// The groups.
    pub fn groups(&self) -> &[ChargeGroup] {
        &self.groups
    }

    /// Number of sites that carry a charge.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no charges.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Sum of the charges, e.
    pub fn net_charge_e(&self) -> f64 {
        self.net_charge_e
    }

    /// Sum of the magnitudes of the charges, e.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_mc::charges::ChargeCloud;
    /// let cloud = ChargeCloud::new(&[(Vec3::x(), 0.5), (Vec3::y(), -1.5)]);
    /// assert_eq!((cloud.sum_of_magnitudes_e(), cloud.net_charge_e()), (2.0, -1.0));
    /// ```
    pub fn sum_of_magnitudes_e(&self) -> f64 {
        self.sum_of_magnitudes_e
    }

    /// Radius of the sphere around the body's origin that encloses all charges, Å.
    pub fn radius_angstrom(&self) -> f64 {
        self.radius_angstrom
    }

    /// The corners of the box that holds every charge, Å; the origin without charges.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_mc::charges::ChargeCloud;
    /// let cloud = ChargeCloud::new(&[(Vec3::new(1.0, -2.0, 0.0), 1.0), (Vec3::new(-3.0, 4.0, 0.0), 1.0)]);
    /// assert_eq!(cloud.bounds_angstrom(), (Vec3::new(-3.0, -2.0, 0.0), Vec3::new(1.0, 4.0, 0.0)));
    /// ```
    pub fn bounds_angstrom(&self) -> (Vec3, Vec3) {
        let mut sites = self.iter().map(|(position, _)| position);
        let first = sites.next().unwrap_or_else(Vec3::zeros);
        sites.fold((first, first), |(low, high), x| (low.inf(&x), high.sup(&x)))
    }

    /// The charges one by one: position (Å) and charge (e).
    pub fn iter(&self) -> impl Iterator<Item = (Vec3, f64)> + '_ {
        let sites = self
            .groups
            .iter()
            .flat_map(|g| (0..LANES).map(|k| (Vec3::new(g.x[k], g.y[k], g.z[k]), g.charge_e[k])));
        sites.filter(|(_, charge)| *charge != 0.0)
    }
}

/// Halves the sites at the median of their longest extent, at a multiple of [`LANES`], until groups
/// of near neighbours are left; hands each to `take`.
pub(crate) fn near_neighbours<T>(sites: &mut [(Vec3, T)], take: &mut impl FnMut(&[(Vec3, T)])) {
    let Some(&(start, _)) = sites.first() else {
        return;
    };
    if sites.len() <= LANES {
        take(sites);
        return;
    }
    let (mut low, mut high) = (start, start);
    for (position, _) in sites.iter() {
        low = low.inf(position);
        high = high.sup(position);
    }
    let axis = (high - low).imax();
    // At a multiple of the lanes: only the last group has empty ones.
    let middle = sites.len().div_ceil(LANES).div_ceil(2) * LANES;
    // A selection is linear; the order within the halves does not matter.
    sites.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (left, right) = sites.split_at_mut(middle);
    near_neighbours(left, take);
    near_neighbours(right, take);
}

impl ChargeGroup {
    /// A group of one to [`LANES`] charges; empty lanes repeat the first position with zero charge.
    fn new(charges: &[(Vec3, f64)]) -> Self {
        let place = |lane: usize| {
            charges
                .get(lane)
                .map_or(charges[0].0, |(position, _)| *position)
        };
        let centre =
            charges.iter().map(|(position, _)| position).sum::<Vec3>() / charges.len() as f64;
        let farthest = charges
            .iter()
            .map(|(position, _)| (position - centre).norm_squared())
            .fold(0.0, f64::max);
        Self {
            x: std::array::from_fn(|lane| place(lane).x),
            y: std::array::from_fn(|lane| place(lane).y),
            z: std::array::from_fn(|lane| place(lane).z),
            charge_e: std::array::from_fn(|lane| {
                charges.get(lane).map_or(0.0, |(_, charge)| *charge)
            }),
            centre,
            radius_angstrom: farthest.sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn grouping_keeps_every_charge_inside_its_sphere() {
        for count in [0, 1, 7, 8, 9, 16, 17, 1003] {
            let mut rng = CounterRng::new(2, 0, count);
            let mut charges: Vec<(Vec3, f64)> = (0..count)
                .map(|_| (rng.vector_in_ball(20.0), rng.uniform_in(-1.0, 1.0)))
                .collect();
            charges.push((Vec3::repeat(99.0), 0.0));
            let cloud = ChargeCloud::new(&charges);
            assert_eq!(cloud.len() as u64, count);
            assert_eq!(cloud.groups().len(), (count as usize).div_ceil(LANES));
            assert!(cloud.radius_angstrom() <= 20.0);
            let mut kept: Vec<f64> = cloud.iter().map(|(_, charge)| charge).collect();
            let mut given: Vec<f64> = charges
                .iter()
                .map(|(_, charge)| *charge)
                .filter(|q| *q != 0.0)
                .collect();
            kept.sort_by(f64::total_cmp);
            given.sort_by(f64::total_cmp);
            assert_eq!(kept, given);
            for group in cloud.groups() {
                for lane in 0..LANES {
                    let position = Vec3::new(group.x[lane], group.y[lane], group.z[lane]);
                    assert!((position - group.centre).norm() <= group.radius_angstrom + 1e-12);
                }
            }
        }
    }
}
