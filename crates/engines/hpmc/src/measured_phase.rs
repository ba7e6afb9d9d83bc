//! A phase by what simulations measured of it: its free energy per volume, with depletants.
//!
//! With Z = βP/ρ and the packing fraction φ of bodies of volume v, the excess free energy per body is
//!
//! f(φ) = f(φ₀) + ∫ (Z - 1)/φ' dφ' from φ₀ to φ,
//!
//! from f(0) = 0 for a fluid, from a free energy that was computed at φ₀ for a crystal. Depletants of
//! reservoir density n leave the grand potential per volume (free volume theory: Lekkerkerker et al.,
//! Europhys. Lett. 20, 559 (1992))
//!
//! βω v = φ (ln(φ/v) - 1 + f(φ)) - n v α(φ),
//!
//! with α the part of the volume that is free for a depletant. Polynomials are fitted to (Z - 1)/φ and
//! to (ln α)/φ; for a fluid the first begins at B2/v, and the second makes α(0) = 1.
//!
//! The degree of each polynomial is the lowest that the errors allow. A curve through every value
//! would have bends of noise. Tangents would touch them and give phases that are not there. The
//! same fits to values drawn within the errors give the errors of the results.

use crate::error::{Error, Result};
use crate::polynomial::{Measured, Polynomial};
use protomer_kernel::jet::Jet;
use protomer_kernel::random::CounterRng;

/// Smallest number of packing fractions for a branch.
pub const FEWEST_STATES: usize = 5;

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The value.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

/// Values measured at a packing fraction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// The part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Z = βP/ρ of the bodies without depletants.
    pub compressibility_factor: Estimated,
    /// Free volume fraction α, where it was measured.
    pub free_volume_fraction: Option<Estimated>,
}

/// Anchor of the free energy of a phase, from which it is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Anchor {
    /// Limit of no bodies, where (Z - 1)/φ is B2 over the volume of a body.
    IdealGas {
        /// B2 / v.
        b2_over_volume: f64,
    },
    /// Free energy computed at a packing fraction.
    Computed {
        /// Packing fraction φ₀.
        packing_fraction: f64,
        /// Excess free energy f(φ₀), kT per body.
        excess_free_energy_kt: Estimated,
    },
}

/// The states of a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredPhase {
    /// States in the order of their packing fractions.
    pub states: Vec<State>,
    /// Anchor of the free energy.
    pub anchor: Anchor,
}

/// The free energy of a phase, as functions of the packing fraction.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseCurves {
    /// The first and the last packing fraction.
    pub range: [f64; 2],
    factor_degree: usize,
    excess: Polynomial,
    log_free_volume_over_packing: Option<Polynomial>,
}

impl MeasuredPhase {
    /// The curves through the measured values.
    ///
    /// # Errors
    /// For fewer than [`FEWEST_STATES`] states, for packing fractions that do not ascend from above zero,
    /// and for errors that are not above zero.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// use protomer_hpmc::measured_phase::{Anchor, Estimated, MeasuredPhase, State};
    ///
    /// // Z = 1 + 4φ + 10φ²: f = 4φ + 5φ².
    /// let states = [0.1, 0.2, 0.3, 0.4, 0.5].map(|packing_fraction: f64| State {
    ///     packing_fraction,
    ///     compressibility_factor: Estimated {
    ///         value: 1.0 + 4.0 * packing_fraction + 10.0 * packing_fraction.powi(2),
    ///         standard_error: 1e-3,
    ///     },
    ///     free_volume_fraction: None,
    /// });
    /// let fluid = MeasuredPhase {
    ///     states: states.to_vec(),
    ///     anchor: Anchor::IdealGas { b2_over_volume: 4.0 },
    /// };
    /// let excess_kt = fluid.curves()?.excess_free_energy_kt(Jet::constant(0.3)).value;
    /// assert!((excess_kt - 1.65).abs() < 1e-12);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn curves(&self) -> Result<PhaseCurves> {
        self.check()?;
        // The lowest degree that the errors allow, or tangents would touch the noise.
        let factor = Polynomial::as_smooth_as(&self.factors())?;
        let free_volumes = self.free_volumes();
        let free_volume = match free_volumes.is_empty() {
            true => None,
            false => Some(Polynomial::as_smooth_as(&free_volumes)?),
        };
        Ok(self.curves_of(factor, free_volume))
    }

    /// Curves that might have been measured as well as the [`Self::curves`]: with values drawn from
    /// normal distributions about the measured ones, and polynomials of the same degrees.
    ///
    /// # Errors
    /// Those of [`Self::curves`].
    pub fn drawn_curves(
        &self,
        measured: &PhaseCurves,
        rng: &mut CounterRng,
    ) -> Result<PhaseCurves> {
        self.check()?;
        let drawn = self.drawn(rng);
        // The same degree as the measured curve: only the values vary.
        let factor = Polynomial::of_degree(&drawn.factors(), measured.factor_degree)?;
        let free_volume = match &measured.log_free_volume_over_packing {
            None => None,
            Some(curve) => Some(Polynomial::of_degree(
                &drawn.free_volumes(),
                curve.degree(),
            )?),
        };
        Ok(drawn.curves_of(factor, free_volume))
    }

    /// The phase with values drawn within their errors.
    fn drawn(&self, rng: &mut CounterRng) -> Self {
        let mut draw = |estimate: Estimated| Estimated {
            value: estimate.value + estimate.standard_error * rng.normal(),
            ..estimate
        };
        let states = self.states.iter().map(|state| State {
            compressibility_factor: draw(state.compressibility_factor),
            free_volume_fraction: state.free_volume_fraction.map(|estimate| {
                let drawn = draw(estimate);
                // A free volume has a logarithm.
                if drawn.value > 0.0 { drawn } else { estimate }
            }),
            ..*state
        });
        let states = states.collect();
        let anchor = match self.anchor {
            Anchor::Computed {
                packing_fraction,
                excess_free_energy_kt,
            } => Anchor::Computed {
                packing_fraction,
                excess_free_energy_kt: draw(excess_free_energy_kt),
            },
            ideal => ideal,
        };
        Self { states, anchor }
    }

    fn check(&self) -> Result<()> {
        if self.states.len() < FEWEST_STATES {
            return Err(Error::FewPoints {
                given: self.states.len(),
                fewest: FEWEST_STATES,
            });
        }
        let mut before = 0.0;
        for state in &self.states {
            if state.packing_fraction <= before {
                return Err(Error::NotAscending {
                    first: before,
                    second: state.packing_fraction,
                });
            }
            before = state.packing_fraction;
        }
        Ok(())
    }

    /// (Z - 1)/φ of a crystal; ((Z - 1)/φ - B2/v)/φ of a fluid.
    fn factors(&self) -> Vec<Measured> {
        let factor = |state: &State| {
            let x = state.packing_fraction;
            let Estimated {
                value,
                standard_error,
            } = state.compressibility_factor;
            let (value, standard_error) = ((value - 1.0) / x, standard_error / x);
            // Divided by φ once more, so that the polynomial times φ leaves B2 exact at zero.
            match self.anchor {
                Anchor::IdealGas { b2_over_volume } => Measured {
                    x,
                    value: (value - b2_over_volume) / x,
                    standard_error: standard_error / x,
                },
                Anchor::Computed { .. } => Measured {
                    x,
                    value,
                    standard_error,
                },
            }
        };
        self.states.iter().map(factor).collect()
    }

    /// (ln α)/φ, where it was measured.
    fn free_volumes(&self) -> Vec<Measured> {
        let log_free_volume = |state: &State| {
            let (x, fraction) = (state.packing_fraction, state.free_volume_fraction?);
            (fraction.value > 0.0).then(|| Measured {
                x,
                value: fraction.value.ln() / x,
                // d ln α = dα/α.
                standard_error: fraction.standard_error / fraction.value / x,
            })
        };
        self.states.iter().filter_map(log_free_volume).collect()
    }

    fn curves_of(&self, factor: Polynomial, free_volume: Option<Polynomial>) -> PhaseCurves {
        let factor_degree = factor.degree();
        let excess = match self.anchor {
            Anchor::IdealGas { b2_over_volume } => {
                factor.times_x_plus(b2_over_volume).integral(0.0, 0.0)
            }
            Anchor::Computed {
                packing_fraction,
                excess_free_energy_kt,
            } => factor.integral(packing_fraction, excess_free_energy_kt.value),
        };
        let last = self.states.len() - 1;
        PhaseCurves {
            range: [
                self.states[0].packing_fraction,
                self.states[last].packing_fraction,
            ],
            factor_degree,
            excess,
            log_free_volume_over_packing: free_volume,
        }
    }
}

impl PhaseCurves {
    /// f(φ), kT per body.
    pub fn excess_free_energy_kt(&self, packing_fraction: Jet) -> Jet {
        self.excess.evaluate(packing_fraction)
    }

    /// α(φ), if it was measured.
    pub fn free_volume_fraction(&self, packing_fraction: Jet) -> Option<Jet> {
        let over_packing = self.log_free_volume_over_packing.as_ref()?;
        Some((over_packing.evaluate(packing_fraction) * packing_fraction).exp_m1() + 1.0)
    }

    /// βω v: the grand potential per volume, times the volume of a body over kT, at a density of
    /// depletants in the reservoir, per volume of a body. Without free volumes there are no depletants.
    pub fn grand_potential(
        &self,
        packing_fraction: Jet,
        body_volume: f64,
        depletants_per_body_volume: f64,
    ) -> Jet {
        let ideal = (packing_fraction * body_volume.recip()).ln() + -1.0;
        let bodies = packing_fraction * (ideal + self.excess_free_energy_kt(packing_fraction));
        match self.free_volume_fraction(packing_fraction) {
            Some(free) => bodies - free * depletants_per_body_volume,
            None => bodies,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_volume_theory::Mixture;
    use crate::tangent::{Branch, coexistences, even_samples};

    fn exactly(value: f64) -> Estimated {
        Estimated {
            value,
            standard_error: 1e-9 * value.abs(),
        }
    }

    /// Spheres: the fluid of Carnahan and Starling, the cell model of the crystal, as if measured.
    fn spheres(q: f64) -> [MeasuredPhase; 2] {
        let mixture = Mixture::new(q, 0.1).unwrap();
        let state = |x: f64, z: f64| State {
            packing_fraction: x,
            compressibility_factor: exactly(z),
            free_volume_fraction: Some(exactly(mixture.free_volume(x))),
        };
        let fluid = (1..=27).map(|n| {
            let x = 0.02 * f64::from(n);
            state(x, (1.0 + x + x * x - x * x * x) / (1.0 - x).powi(3))
        });
        let dense = std::f64::consts::PI * 2.0_f64.sqrt() / 6.0;
        let crystal = (0..=14).map(|n| {
            let x = 0.5 + 0.01 * f64::from(n);
            state(x, 3.0 / (1.0 - x / dense))
        });
        let x0 = 0.545;
        // 2.1306 + 3 ln(φ/(1 - φ/φ₀)) + ln(v)... less ln φ - 1 of the ideal gas.
        let total = 2.1306 + 3.0 * (x0 / (1.0 - x0 / dense)).ln() - x0.ln() + 1.0;
        [
            MeasuredPhase {
                states: fluid.collect(),
                anchor: Anchor::IdealGas {
                    b2_over_volume: 4.0,
                },
            },
            MeasuredPhase {
                states: crystal.collect(),
                anchor: Anchor::Computed {
                    packing_fraction: x0,
                    excess_free_energy_kt: exactly(total),
                },
            },
        ]
    }

    #[test]
    fn spheres_have_the_coexistence_of_free_volume_theory() {
        let q = 0.4;
        for reservoir in [0.0, 0.1, 0.3] {
            let curves = spheres(q).map(|phase| phase.curves().unwrap());
            let depletants = reservoir / q.powi(3);
            let energies = curves
                .each_ref()
                .map(|curve| move |x: Jet| curve.grand_potential(x, 1.0, depletants));
            let branches = [0, 1].map(|n| Branch {
                name: "",
                free_energy: &energies[n],
                samples: even_samples(curves[n].range[0], curves[n].range[1], 2000),
            });
            let found = coexistences(&branches);
            let expected = Mixture::new(q, reservoir).unwrap().coexistences();
            assert_eq!((found.len(), expected.len()), (1, 1), "{reservoir}");
            for n in 0..2 {
                let difference = found[0].densities[n] - expected[0].densities[n];
                assert!(difference.abs() < 2e-4, "{reservoir}: {difference}");
            }
            let difference = found[0].chemical_potential - expected[0].chemical_potential;
            assert!(difference.abs() < 5e-3, "{reservoir}: {difference}");
        }
    }

    /// One state moves the anchored free energy by its own error.
    #[test]
    fn draws_scatter_by_the_errors() {
        let [_, mut crystal] = spheres(0.1);
        let Anchor::Computed {
            packing_fraction, ..
        } = crystal.anchor
        else {
            panic!()
        };
        crystal.anchor = Anchor::Computed {
            packing_fraction,
            excess_free_energy_kt: Estimated {
                value: 5.0,
                standard_error: 0.01,
            },
        };
        let measured = crystal.curves().unwrap();
        let mut rng = CounterRng::new(3, 0, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..1000 {
            let drawn = crystal.drawn_curves(&measured, &mut rng).unwrap();
            let shift = drawn
                .excess_free_energy_kt(Jet::constant(packing_fraction))
                .value
                - 5.0;
            sum += shift / 1000.0;
            squares += shift * shift / 1000.0;
        }
        assert!(
            sum.abs() < 2e-3 && (squares.sqrt() / 0.01 - 1.0).abs() < 0.1,
            "{sum} {squares}"
        );
    }

    #[test]
    fn few_states_and_a_wrong_order_are_refused() {
        let [fluid, _] = spheres(0.1);
        let mut few = fluid.clone();
        few.states.truncate(4);
        assert!(few.curves().unwrap_err().to_string().contains('4'));
        let mut wrong = fluid;
        wrong.states.swap(1, 2);
        assert!(wrong.curves().is_err());
    }
}
