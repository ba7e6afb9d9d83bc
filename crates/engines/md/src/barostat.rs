//! Constant pressure: now and then the box and the centres in it are scaled at random.
//!
//! A trial draws the change of ln V evenly between -δ and δ and accepts with the probability
//! (Eppenga and Frenkel, Mol. Phys. 52, 1303 (1984))
//!
//! ```text
//! min(1, exp(-(U' - U + P (V' - V))/kT + (N + 1) ln(V'/V)))
//! ```
//!
//! The momenta stay. With the global thermostat between trials, whose momenta and positions have the
//! canonical distribution, volumes and configurations have that of constant pressure, whatever δ is:
//! δ is drawn again for every trial, evenly in its logarithm between 10⁻³/√N and 1/√N, the spread
//! of ln V in an ideal gas. So small and large changes are tried at every density, and nothing
//! needs to be tuned. A trial moves all centres at once: displacements on times longer than that
//! between trials are those of the bodies and of the box together.

use crate::engine::Engine;
use crate::{Error, Result};
use protomer_kernel::random::CounterRng;

/// Decades of the widths of the trials.
const DECADES: f64 = 3.0;

impl Engine {
    /// Tries one change of the volume. Bodies that would touch refuse it.
    pub(crate) fn try_volume(
        &mut self,
        temperature: f64,
        pressure: f64,
        rng: &mut CounterRng,
    ) -> Result<()> {
        let (count, dimension) = (self.bodies.count() as f64, self.bodies.dimension());
        let width = 10.0_f64.powf(-DECADES * rng.uniform()) / count.sqrt();
        let change = width * (2.0 * rng.uniform() - 1.0);
        // Drawn before the forces, so the stream does not depend on overlaps.
        let chance = rng.uniform();
        let scale = (change / dimension as f64).exp();
        let before = self.motion.placement();
        let energy = self.motion.potential_energy;
        let volume = self.motion.state.volume(dimension);
        self.shrink(scale);
        self.motion
            .neighbours
            .refresh(&self.bodies, &self.motion.state)?;
        let accepted = match self.find_forces() {
            Ok(()) => {
                // ΔU + P ΔV, with ΔV = V (e^x - 1).
                let work =
                    self.motion.potential_energy - energy + pressure * volume * change.exp_m1();
                // (N + 1) ln(V'/V): N centres that scale with the box, and evenly drawn ln V.
                (-work / temperature + (count + 1.0) * change).exp() > chance
            }
            // A refused trial, not an error: bodies would touch.
            Err(Error::Met { .. } | Error::Diverged) => false,
            Err(error) => return Err(error),
        };
        self.motion.volume_trials[usize::from(accepted)] += 1;
        match accepted {
            // What the barostat gives is no error of the integrator.
            true => self.motion.heat += self.motion.potential_energy - energy,
            false => {
                // The list's places shrank with the box; the list itself holds for both sizes.
                self.motion.neighbours.shrink(1.0 / scale);
                self.motion.put_back(before);
            }
        }
        Ok(())
    }
}
