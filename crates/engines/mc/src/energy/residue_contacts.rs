//! Attraction between residues: the sum over pairs of beads of two bodies.

use crate::Result;
use crate::beads::{BeadCloud, BeadGroup, EMPTY_LANE};
use crate::charges::LANES;
use crate::error::require;
use protomer_body::chemistry::AminoAcid;
use protomer_body::residue_contacts::{CONTACT_CUTOFF_ANGSTROM, ContactScale};
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::units::kilojoule_per_mol_per_kt;

/// Amino acids, and the kind of empty lanes.
const KINDS: usize = EMPTY_LANE as usize + 1;
/// (2^(1/6))², where the square of r/σ has the minimum of a Lennard-Jones potential.
const SQUARE_OF_MINIMUM: f64 = 1.259_921_049_894_873_2;

/// A contact potential at one temperature and strength.
///
/// ```text
/// u(r) = d w(r/σ) + c h(r/σ),   w(x) = -1                x⁶ < 2    h(x) = 4 (x⁻¹² - x⁻⁶) + 1
///                               w(x) = 4 (x⁻¹² - x⁻⁶)    beyond    h(x) = 0
/// ```
///
/// shifted to zero at the cut-off. The depth d and the diameter σ are those of the scale; the cores
/// c are zero unless beads replace the hard surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPotential {
    rows: Vec<[PairOfKinds; KINDS]>,
    square_cutoff: f64,
}

/// Two beads, both in the frame of the first body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeadPair {
    /// The bead of the first body, Å.
    pub first: Vec3,
    /// The bead of the second body, Å.
    pub second: Vec3,
    /// Energy of the two beads, kT.
    pub energy_kt: f64,
}

/// The parameters of two kinds of beads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct PairOfKinds {
    depth_kt: f64,
    core_kt: f64,
    square_diameter: f64,
    /// d w at the cut-off, kT.
    shift_kt: f64,
}

impl ContactPotential {
    /// The attraction of a scale, multiplied by `strength`, at a temperature (K).
    ///
    /// ```
    /// use protomer_body::residue_contacts::ContactScale;
    /// use protomer_mc::energy::ContactPotential;
    /// let potential = ContactPotential::new(ContactScale::Calvados3, 1.0, 298.15)?;
    /// assert!((potential.cutoff_angstrom() - 20.0).abs() < 1e-12);
    /// assert!(ContactPotential::new(ContactScale::Calvados3, -1.0, 298.15).is_err());
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    ///
    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) for a strength that is not between 0 and 100.
    pub fn new(scale: ContactScale, strength: f64, temperature_kelvin: f64) -> Result<Self> {
        require(
            "strength of the contact term",
            strength,
            "from 0 to 100; 1 is the published scale",
            (0.0..=100.0).contains(&strength),
        )?;
        let per_kt = strength / kilojoule_per_mol_per_kt(temperature_kelvin);
        let mut rows = vec![[PairOfKinds::default(); KINDS]; KINDS];
        for first in AminoAcid::all() {
            for second in AminoAcid::all() {
                let diameter = scale.diameter_angstrom(first, second);
                let depth_kt = per_kt * scale.depth_kj_per_mol(first, second);
                // Subtracted everywhere, so that the energy has no step at the cut-off.
                let end = lennard_jones((diameter / CONTACT_CUTOFF_ANGSTROM).powi(2));
                rows[first as usize][second as usize] = PairOfKinds {
                    depth_kt,
                    core_kt: 0.0,
                    square_diameter: diameter * diameter,
                    shift_kt: depth_kt * end,
                };
            }
        }
        Ok(Self {
            rows,
            square_cutoff: CONTACT_CUTOFF_ANGSTROM * CONTACT_CUTOFF_ANGSTROM,
        })
    }

    /// The published force field as it stands, with the cores of the beads, at a temperature (K).
    /// The strength multiplies the attraction only.
    ///
    /// # Errors
    /// As [`ContactPotential::new`].
    pub fn with_cores(scale: ContactScale, strength: f64, temperature_kelvin: f64) -> Result<Self> {
        let mut potential = Self::new(scale, strength, temperature_kelvin)?;
        let rt = kilojoule_per_mol_per_kt(temperature_kelvin);
        for first in AminoAcid::all() {
            for second in AminoAcid::all() {
                let core_kt = scale.core_kj_per_mol(first, second) / rt;
                potential.rows[first as usize][second as usize].core_kt = core_kt;
            }
        }
        Ok(potential)
    }

    /// Beads further apart do not interact, Å.
    pub fn cutoff_angstrom(&self) -> f64 {
        self.square_cutoff.sqrt()
    }

    /// The energy of two bodies, kT; `relative` is the pose of the second body in the frame of the
    /// first.
    pub fn energy_kt(&self, first: &BeadCloud, second: &BeadCloud, relative: &RelativePose) -> f64 {
        let mut total = [0.0; LANES];
        self.near_groups(first, second, relative, |one, other| {
            for lane in 0..LANES {
                // Empty lanes stand at the end of a group.
                if one.kind[lane] == EMPTY_LANE {
                    break;
                }
                let energies = self.lane_energies(one, lane, other);
                for (total, energy) in total.iter_mut().zip(energies) {
                    *total += energy;
                }
            }
        });
        total.iter().sum()
    }

    /// Hands every pair of beads with its energy to `take`; pairs beyond the cut-off are left out.
    pub fn for_each_pair(
        &self,
        first: &BeadCloud,
        second: &BeadCloud,
        relative: &RelativePose,
        mut take: impl FnMut(&BeadPair),
    ) {
        self.near_groups(first, second, relative, |one, other| {
            for lane in 0..LANES {
                let energies = self.lane_energies(one, lane, other);
                for (of_other, energy) in energies.into_iter().enumerate() {
                    // Zero beyond the cut-off: such pairs have no share.
                    if energy != 0.0 {
                        take(&BeadPair {
                            first: one.place(lane),
                            second: other.place(of_other),
                            energy_kt: energy,
                        });
                    }
                }
            }
        });
    }

    /// All pairs of groups in reach of each other, those of the second body moved.
    #[inline(always)]
    fn near_groups(
        &self,
        first: &BeadCloud,
        second: &BeadCloud,
        relative: &RelativePose,
        mut visit: impl FnMut(&BeadGroup, &BeadGroup),
    ) {
        let cutoff = self.cutoff_angstrom();
        for group in second.groups() {
            let centre = relative.transform_point(&group.centre);
            // The sphere around the whole first body drops most groups of the second at once.
            if centre.norm() > first.radius_angstrom() + cutoff + group.radius_angstrom {
                continue;
            }
            let image = transform(group, centre, relative);
            for one in first.groups() {
                // What is left is decided by the spheres of both groups.
                let limit = cutoff + one.radius_angstrom + image.radius_angstrom;
                if (one.centre - image.centre).norm_squared() < limit * limit {
                    visit(one, &image);
                }
            }
        }
    }

    /// The energies of one bead with the beads of a group, kT.
    #[inline(always)]
    fn lane_energies(&self, one: &BeadGroup, lane: usize, other: &BeadGroup) -> [f64; LANES] {
        let row = &self.rows[usize::from(one.kind[lane])];
        let (x, y, z) = (one.x[lane], one.y[lane], one.z[lane]);
        let mut energies = [0.0; LANES];
        for (k, energy) in energies.iter_mut().enumerate() {
            let pair = &row[usize::from(other.kind[k])];
            let (dx, dy, dz) = (other.x[k] - x, other.y[k] - y, other.z[k] - z);
            let square = dx * dx + dy * dy + dz * dz;
            // Computed for all lanes and selected afterwards: no branch stops the vectors.
            *energy = if square < self.square_cutoff {
                pair.at_square(square)
            } else {
                0.0
            };
        }
        energies
    }
}

impl PairOfKinds {
    /// The energy at a squared distance below the cut-off (Å²), kT.
    #[inline(always)]
    fn at_square(&self, square: f64) -> f64 {
        let potential = lennard_jones(self.square_diameter / square);
        // Below its minimum the well is flat, as the hard
        // surfaces repel; only beads have a core there.
        if square < SQUARE_OF_MINIMUM * self.square_diameter {
            // 0 · ∞ for beads in one place would be no number.
            let core = if self.core_kt == 0.0 {
                0.0
            } else {
                // Shifted up by the depth of the well, so the
                // core ends at zero where it meets the minimum.
                self.core_kt * (potential + 1.0)
            };
            core - self.depth_kt - self.shift_kt
        } else {
            self.depth_kt * potential - self.shift_kt
        }
    }
}

/// 4 (x⁻¹² - x⁻⁶) for x⁻² = (σ/r)².
#[inline(always)]
fn lennard_jones(inverse_square: f64) -> f64 {
    let inverse_sixth = inverse_square * inverse_square * inverse_square;
    4.0 * inverse_sixth * (inverse_sixth - 1.0)
}

fn transform(group: &BeadGroup, centre: Vec3, relative: &RelativePose) -> BeadGroup {
    let (r, t) = (&relative.rotation, &relative.translation);
    let mut image = BeadGroup { centre, ..*group };
    for lane in 0..LANES {
        let (x, y, z) = (group.x[lane], group.y[lane], group.z[lane]);
        image.x[lane] = r.m11 * x + r.m12 * y + r.m13 * z + t.x;
        image.y[lane] = r.m21 * x + r.m22 * y + r.m23 * z + t.y;
        image.z[lane] = r.m31 * x + r.m32 * y + r.m33 * z + t.z;
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::residue_contacts::Bead;
    use protomer_kernel::Pose;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::setting::Choices;

    fn beads(rng: &mut CounterRng, count: usize) -> Vec<Bead> {
        let kinds: Vec<AminoAcid> = AminoAcid::all().collect();
        let mut beads = Vec::new();
        for residue in 0..count {
            beads.push(Bead {
                position: rng.vector_in_ball(18.0),
                amino_acid: kinds[(rng.uniform() * 20.0) as usize],
                residue,
            });
        }
        beads
    }

    /// The slow, obvious twin: the published forms, written out.
    fn published(scale: ContactScale, a: &Bead, b: &Bead, r: f64, cores: bool) -> f64 {
        let kt = kilojoule_per_mol_per_kt(310.0);
        let sigma = scale.diameter_angstrom(a.amino_acid, b.amino_acid);
        let lj = |r: f64| 4.0 * ((sigma / r).powi(12) - (sigma / r).powi(6));
        let depth = scale.depth_kj_per_mol(a.amino_acid, b.amino_acid) / kt;
        let (inside, end) = (r < 2.0_f64.powf(1.0 / 6.0) * sigma, lj(20.0));
        if r >= 20.0 {
            return 0.0;
        }
        let of_scale = match (scale, inside) {
            // Ashbaugh and Hatch: LJ + ε (1 - λ) inside, λ LJ beyond.
            (ContactScale::Calvados3, true) if cores => {
                let epsilon = 0.8368 / kt;
                epsilon * lj(r) + epsilon - depth
            }
            // Kim and Hummer: for attraction LJ; for repulsion LJ + 2ε inside, -LJ beyond.
            (ContactScale::KimHummer, true) if cores => match depth > 0.0 {
                true => depth * lj(r),
                false => -depth * lj(r) - 2.0 * depth,
            },
            (_, true) => -depth,
            (_, false) => depth * lj(r),
        };
        of_scale - depth * end
    }

    #[test]
    fn sums_of_groups_are_those_of_the_published_forms() {
        let mut rng = CounterRng::new(23, 0, 0);
        for case in 0..24 {
            let (a, b) = (beads(&mut rng, 1 + 9 * case), beads(&mut rng, 3 + 7 * case));
            let pose = Pose {
                position: rng.unit_vector() * (20.0 + 2.0 * case as f64),
                rotation: rng.rotation(),
            };
            let relative = RelativePose::from(&pose);
            for &scale in ContactScale::ALL {
                for cores in [false, true] {
                    let potential = match cores {
                        true => ContactPotential::with_cores(scale, 1.0, 310.0).unwrap(),
                        false => ContactPotential::new(scale, 1.0, 310.0).unwrap(),
                    };
                    let (mut expected, mut scale_of_sum) = (0.0, 1.0);
                    for one in &a {
                        for other in &b {
                            let place: Vec3 = relative.transform_point(&other.position);
                            let r = (place - one.position).norm();
                            let energy = published(scale, one, other, r, cores);
                            expected += energy;
                            scale_of_sum += energy.abs();
                        }
                    }
                    let clouds = (BeadCloud::new(&a), BeadCloud::new(&b));
                    let sum = potential.energy_kt(&clouds.0, &clouds.1, &relative);
                    assert!(
                        (sum - expected).abs() < 1e-12 * scale_of_sum,
                        "case {case} {scale:?} {cores}: {sum} {expected}"
                    );
                    let mut parts = 0.0;
                    potential.for_each_pair(&clouds.0, &clouds.1, &relative, |pair| {
                        parts += pair.energy_kt;
                    });
                    assert!((parts - expected).abs() < 1e-12 * scale_of_sum);
                }
            }
        }
    }

    #[test]
    fn it_is_continuous_with_its_slope_at_the_minimum_and_ends_at_the_cutoff() {
        let potential = ContactPotential::new(ContactScale::Calvados3, 1.0, 298.15).unwrap();
        let pair = potential.rows[0][1];
        let minimum = (SQUARE_OF_MINIMUM * pair.square_diameter).sqrt();
        let energy = |r: f64| pair.at_square(r * r);
        assert!((energy(minimum + 1e-4) - energy(minimum - 1e-4)).abs() < 1e-6);
        assert!(energy(19.999_999).abs() < 1e-9);
        assert!(energy(minimum) < energy(minimum + 1.0));
    }

    #[test]
    fn strengths_out_of_range_are_refused() {
        for strength in [-0.1, f64::NAN, 1000.0] {
            assert!(ContactPotential::new(ContactScale::KimHummer, strength, 298.15).is_err());
        }
    }
}
