//! Model and medium of a search.

use crate::assemblies::assemble::BodyFiles;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{Engine, RunSettings};
use anyhow::{Result, bail};
use protomer_body::Body;
use protomer_kernel::{Boundary, Pose};
use protomer_mc::energy::terms::TermsOfKinds;
use std::sync::Arc;

/// Model and medium of a search.
pub struct SearchMedium<'a> {
    /// The terms of the energy.
    pub run: &'a RunSettings,
    /// Medium between the bodies.
    pub interaction: ScreenedCoulomb,
    /// Makes the engine of an assembly, with the tables and the cache of the caller.
    pub prepare: &'a dyn Fn(Assembly) -> Result<Engine>,
}

impl SearchMedium<'_> {
    /// Terms of the energy of each two kinds of bodies, and the name of the model of these terms.
    ///
    /// # Errors
    /// For a medium without screening, and bodies without what a term needs.
    pub(super) fn potentials(&self, files: &BodyFiles) -> Result<(TermsOfKinds, &'static str)> {
        let yukawa = self.interaction.yukawa()?;
        if yukawa.inverse_debye_length_per_angstrom <= 0.0 {
            bail!("the charges have no screening without salt; give a --salt above zero");
        }
        let bodies: Vec<Arc<Body>> = files.bodies.iter().cloned().map(Arc::new).collect();
        let kinds = bodies.len();
        let engine = (self.prepare)(Assembly {
            bodies: bodies.clone(),
            kinds: (0..kinds).collect(),
            poses: vec![Pose::identity(); kinds],
            boundary: Boundary::Open,
            sha256: String::new(),
            path: None,
        })?;
        let engine = engine.in_medium(self.run, &self.interaction)?;
        let potentials = engine.pair_potentials(&self.interaction)?;
        Ok((potentials, self.run.model_name(&bodies)))
    }
}
