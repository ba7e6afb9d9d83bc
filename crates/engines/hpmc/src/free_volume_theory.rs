//! Free volume theory: phases of hard spheres among penetrable depletants.
//!
//! The grand potential per volume of a phase with packing fraction η is, times the volume v₀ of a sphere
//! and over kT (Lekkerkerker, Poon, Pusey, Stroobants and Warren, Europhys. Lett. 20, 559 (1992)),
//!
//! ω(η) = f(η) - φ_r α(η, q) / q³,
//!
//! with the free energy f of the spheres alone, the packing fraction φ_r of the depletants in the reservoir,
//! their size ratio q and the free volume fraction α. The fluid is that of Carnahan and Starling,
//! f = η (ln η - 1) + (4η² - 3η³)/(1 - η)²; the crystal is that of the cell model,
//! f = 2.1306 η + 3 η ln(η/(1 - η/η_cp)) with η_cp = π/(3√2). α is that of scaled particle theory in both.

use crate::tangent::{Branch, Coexistence, coexistences, even_samples};
use crate::{Result, error::require};
use protomer_kernel::jet::Jet;
use std::f64::consts::{PI, SQRT_2};

/// Close packing of spheres.
const CLOSE_PACKING: f64 = PI / (3.0 * SQRT_2);
/// The lowest packing fraction of a gas that is looked at.
const THINNEST: f64 = 1e-100;
/// The densest fluid, near random close packing.
const DENSEST_FLUID: f64 = 0.64;
/// Packing fraction at which the search for a critical point begins.
const THINNEST_LIQUID: f64 = 1e-3;
/// Samples of a branch.
const SAMPLES: usize = 4000;
/// The relative accuracy of critical and triple points.
const ACCURACY: f64 = 1e-12;
/// Reservoirs beyond this packing fraction are not searched for a triple point.
const FULLEST: f64 = 50.0;

/// Names of the branches, in their order.
pub const PHASES: [&str; 2] = ["fluid", "solid"];

/// Measures of a convex body that scaled particle theory needs.
///
/// ```
/// use protomer_hpmc::free_volume_theory::BodyMeasures;
/// let cube = BodyMeasures {
///     volume: 1.0,
///     surface: 6.0,
///     integrated_mean_curvature: 3.0 * std::f64::consts::PI,
/// };
/// // Points see what the bodies leave free.
/// assert!((cube.free_volume(0.3, 0.0) - 0.7).abs() < 1e-12);
/// assert!(cube.free_volume(0.3, 0.1) < 0.7);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyMeasures {
    /// Volume.
    pub volume: f64,
    /// Surface.
    pub surface: f64,
    /// Integral of the mean curvature over the surface.
    pub integrated_mean_curvature: f64,
}

impl BodyMeasures {
    /// Measures of a sphere.
    ///
    /// ```
    /// use protomer_hpmc::free_volume_theory::BodyMeasures;
    /// let sphere = BodyMeasures::sphere(2.0);
    /// assert!((sphere.surface / sphere.volume - 1.5).abs() < 1e-12);
    /// ```
    pub fn sphere(radius: f64) -> Self {
        Self {
            volume: 4.0 / 3.0 * PI * radius.powi(3),
            surface: 4.0 * PI * radius * radius,
            integrated_mean_curvature: 4.0 * PI * radius,
        }
    }

    /// ln α of depletants of a radius among these bodies, by scaled particle theory.
    ///
    /// -ln α = -ln(1-φ) + r x₂/(1-φ) + 4π r² (x₁/(1-φ) + x₂²/(8π(1-φ)²)) + (4π/3) r³ P,
    /// P = x₀/(1-φ) + x₁x₂/(1-φ)² + x₂³/(12π(1-φ)³), with x₀ = n, x₁ = n M/4π, x₂ = n S.
    pub fn ln_free_volume(&self, packing_fraction: Jet, radius: f64) -> Jet {
        let density = packing_fraction * self.volume.recip();
        let (x1, x2) = (
            density * (self.integrated_mean_curvature / (4.0 * PI)),
            density * self.surface,
        );
        let open = (-packing_fraction + 1.0).recip();
        let pressure = density * open
            + x1 * x2 * open * open
            + x2 * x2 * x2 * open * open * open * (12.0 * PI).recip();
        (-packing_fraction).ln_1p()
            - x2 * open * radius
            - (x1 * open + x2 * x2 * open * open * (8.0 * PI).recip())
                * (4.0 * PI * radius * radius)
            - pressure * (4.0 / 3.0 * PI * radius.powi(3))
    }

    /// The free volume of depletants of a radius, as a part of the box.
    ///
    /// ```
    /// use protomer_hpmc::free_volume_theory::BodyMeasures;
    /// let alpha = BodyMeasures::sphere(1.0).free_volume(0.25, 0.4);
    /// assert!((alpha - 0.37626565710018645).abs() < 1e-12);
    /// ```
    pub fn free_volume(&self, packing_fraction: f64, radius: f64) -> f64 {
        self.ln_free_volume_fraction(packing_fraction, radius).exp()
    }

    /// The logarithm of [`free_volume`](Self::free_volume), which is minus the excess chemical potential of a depletant
    /// over kT.
    pub fn ln_free_volume_fraction(&self, packing_fraction: f64, radius: f64) -> f64 {
        self.ln_free_volume(Jet::constant(packing_fraction), radius)
            .value
    }
}

/// Spheres and depletants.
///
/// ```
/// use protomer_hpmc::free_volume_theory::Mixture;
/// let found = Mixture::new(0.1, 0.05)?.coexistences();
/// assert!((found[0].densities[1] - 0.5547827041583091).abs() < 1e-9);
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixture {
    size_ratio: f64,
    reservoir: f64,
}

/// Critical point, at which gas and liquid become one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticalPoint {
    /// Packing fraction of the spheres.
    pub packing_fraction: f64,
    /// Packing fraction of the depletants in the reservoir.
    pub reservoir: f64,
    /// Whether a solid is not more stable at the critical point.
    pub is_stable: bool,
}

/// Triple point, at which gas, liquid and solid coexist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriplePoint {
    /// Packing fraction of the depletants in the reservoir.
    pub reservoir: f64,
    /// Packing fractions of the spheres in gas, liquid and solid.
    pub packing_fractions: [f64; 3],
}

impl Mixture {
    /// A mixture with depletants of the size ratio q (their radius over that of the spheres) whose
    /// reservoir has the packing fraction φ_r.
    ///
    /// ```
    /// use protomer_hpmc::free_volume_theory::Mixture;
    /// assert_eq!(Mixture::new(0.5, 0.25)?.reservoir_pressure(), 2.0);
    /// assert!(Mixture::new(0.0, 0.25).is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// For a size ratio that is not positive and a negative packing fraction.
    pub fn new(size_ratio: f64, reservoir: f64) -> Result<Self> {
        require("the size ratio", size_ratio, "positive", size_ratio > 0.0)?;
        require(
            "the packing fraction of the reservoir",
            reservoir,
            "zero or positive",
            reservoir >= 0.0,
        )?;
        Ok(Self {
            size_ratio,
            reservoir,
        })
    }

    /// The free volume of the depletants at a packing fraction of the spheres, as a part of the box.
    pub fn free_volume(&self, packing_fraction: f64) -> f64 {
        BodyMeasures::sphere(1.0).free_volume(packing_fraction, self.size_ratio)
    }

    /// The pressure of the reservoir, times v₀/kT.
    pub fn reservoir_pressure(&self) -> f64 {
        self.reservoir / self.size_ratio.powi(3)
    }

    /// Contribution of the depletants to the grand potential, less that of the reservoir:
    /// -φ_r (α - 1)/q³.
    fn depletion(&self, packing_fraction: Jet) -> Jet {
        let ln = BodyMeasures::sphere(1.0).ln_free_volume(packing_fraction, self.size_ratio);
        ln.exp_m1() * -self.reservoir_pressure()
    }

    /// Coexisting phases, by packing fraction: slope and intercept are the chemical potential of the
    /// spheres (up to ln Λ³/v₀) in kT and the osmotic pressure times v₀/kT.
    pub fn coexistences(&self) -> Vec<Coexistence> {
        self.beyond(0.0, coexistences)
    }

    /// Coexistence of gas and liquid, whether or not a solid is more stable.
    ///
    /// ```
    /// use protomer_hpmc::free_volume_theory::Mixture;
    /// let phases = Mixture::new(0.8, 1.0)?.gas_and_liquid();
    /// assert!(phases.is_some_and(|phases| phases.densities[0] < 0.05 && phases.densities[1] > 0.3));
    /// assert!(Mixture::new(0.8, 0.1)?.gas_and_liquid().is_none(), "below the critical point");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn gas_and_liquid(&self) -> Option<Coexistence> {
        let tangents = self.beyond(0.0, |branches| coexistences(&branches[..1]));
        tangents.first().copied()
    }

    /// Calls a function with the branches of the fluid, sampled beyond a packing fraction, and the
    /// solid.
    fn beyond<T>(&self, thinnest: f64, call: impl FnOnce(&[Branch<'_>]) -> T) -> T {
        let fluid_energy = |eta: Jet| fluid(eta) + self.depletion(eta);
        let solid_energy = |eta: Jet| solid(eta) + self.depletion(eta);
        let mut samples: Vec<f64> = Vec::new();
        // Equal ratios where a gas is thin, equal distances beyond.
        let decades = (0.01 / THINNEST).ln();
        // Down to 10⁻¹⁰⁰: gases of strong attraction are that thin.
        for number in 0..SAMPLES {
            samples.push(THINNEST * (decades * number as f64 / SAMPLES as f64).exp());
        }
        samples.extend(even_samples(0.01, DENSEST_FLUID, SAMPLES));
        samples.retain(|eta| *eta > thinnest);
        let branches = [
            Branch {
                name: PHASES[0],
                free_energy: &fluid_energy,
                samples,
            },
            Branch {
                name: PHASES[1],
                free_energy: &solid_energy,
                samples: even_samples(0.35, CLOSE_PACKING - 1e-6, SAMPLES),
            },
        ];
        call(&branches)
    }

    /// The critical point of gas and liquid for a size ratio: the reservoir at which a fluid first
    /// becomes unstable, f''(η) = φ_r α''(η)/q³; `None` where that is beyond any fluid.
    ///
    /// ```
    /// use protomer_hpmc::free_volume_theory::Mixture;
    /// let [short, long] = [0.1, 0.8].map(Mixture::critical_point);
    /// assert!(short?.is_some_and(|point| !point.is_stable));
    /// assert!(long?.is_some_and(|point| point.is_stable));
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// For a size ratio that is not positive.
    pub fn critical_point(size_ratio: f64) -> Result<Option<CriticalPoint>> {
        let unit = Self::new(size_ratio, 1.0)?;
        // The reservoir at which a fluid is just unstable; infinite where none makes it so.
        let limit = |eta: f64| {
            let eta = Jet::variable(eta, 0);
            let pull = -unit.depletion(eta).second();
            match pull > 0.0 {
                true => fluid(eta).second() / pull,
                false => f64::INFINITY,
            }
        };
        let mut best = (0.1, f64::INFINITY);
        // A scan before the search, as the limit has infinite branches.
        for eta in even_samples(THINNEST_LIQUID, DENSEST_FLUID, SAMPLES) {
            if limit(eta) < best.1 {
                best = (eta, limit(eta));
            }
        }
        let width = DENSEST_FLUID / SAMPLES as f64;
        // The least at the end of the range is no critical point.
        if best.0 > DENSEST_FLUID - width {
            return Ok(None);
        }
        let eta = least(limit, [best.0 - width, best.0 + width]);
        let reservoir = limit(eta);
        // A little above: at the point itself both phases are one.
        let above = Self::new(size_ratio, reservoir * (1.0 + 1e-4))?;
        Ok(Some(CriticalPoint {
            packing_fraction: eta,
            reservoir,
            is_stable: above.coexistences().len() > 1,
        }))
    }

    /// The triple point for a size ratio; `None` if gas and liquid never coexist in equilibrium.
    ///
    /// ```
    /// use protomer_hpmc::free_volume_theory::Mixture;
    /// let triple = Mixture::triple_point(0.6)?;
    /// assert!(triple.is_some_and(|triple| triple.packing_fractions.is_sorted()));
    /// assert_eq!(Mixture::triple_point(0.1)?, None, "its liquid is not stable");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// For a size ratio that is not positive.
    pub fn triple_point(size_ratio: f64) -> Result<Option<TriplePoint>> {
        let critical = Self::critical_point(size_ratio)?.filter(|point| point.is_stable);
        let Some(critical) = critical else {
            return Ok(None);
        };
        // The chemical potential of gas and liquid less that of liquid and solid grows with the
        // reservoir, and is zero at the triple point.
        let both = |reservoir: f64| {
            let mixture = Self {
                // Beyond the critical density the liquid is the only fluid.
                size_ratio,
                reservoir,
            };
            let thin = mixture.gas_and_liquid()?;
            let thick = mixture.beyond(critical.packing_fraction, coexistences);
            Some((thin, *thick.first()?))
        };
        let is_below = |reservoir: f64| {
            let phases = both(reservoir);
            phases.is_some_and(|(thin, thick)| thin.chemical_potential < thick.chemical_potential)
        };
        let mut low = critical.reservoir * (1.0 + 1e-4);
        let mut high = low;
        // By steps of a tenth until the order changes, then bisection.
        while is_below(high) {
            low = high;
            high *= 1.1;
            if high > FULLEST {
                return Ok(None);
            }
        }
        while high - low > ACCURACY * high {
            let middle = f64::midpoint(low, high);
            if is_below(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(both(low).map(|(thin, thick)| TriplePoint {
            reservoir: low,
            packing_fractions: [thin.densities[0], thin.densities[1], thick.densities[1]],
        }))
    }
}

/// Carnahan and Starling, J. Chem. Phys. 51, 635 (1969), with the ideal part η (ln η - 1).
fn fluid(eta: Jet) -> Jet {
    let open = (-eta + 1.0).recip();
    eta * (eta.ln() - 1.0) + eta * eta * (eta * -3.0 + 4.0) * open * open
}

/// The cell model of a face-centred cubic crystal, with its ideal part.
fn solid(eta: Jet) -> Jet {
    let open = (-eta * CLOSE_PACKING.recip()).ln_1p();
    eta * 2.1306 + eta * (eta.ln() - open) * 3.0
}

/// Place of the minimum of a function between two places, where it has one minimum (golden
/// sections).
fn least(function: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    let part = 0.5 * (5.0_f64.sqrt() - 1.0);
    while high - low > 1e-9 {
        let (left, right) = (high - part * (high - low), low + part * (high - low));
        if function(left) < function(right) {
            // Golden sections: no derivative, one minimum.
            high = right;
        } else {
            low = left;
        }
    }
    f64::midpoint(low, high)
}
