//! The interaction of simulations for the pose of a complex, by terms: the charges of the bodies, and
//! the response of the salt water that both displace.

use super::input::Partners;
use super::settings::BindingSettings;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::inspect::inspection_settings;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{EnergyMode, Engine, RunSettings};
use anyhow::Result;
use protomer_body::residue_contacts::beads_of;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{Boundary, Pose};
use protomer_mc::DEFAULT_CONTACT_GAP_ANGSTROM;
use protomer_mc::energy::terms::Term;
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::pair::BodyPair;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Two bodies prepared for the interaction of simulations.
pub(in crate::stability) struct FastInteraction {
    engine: Engine,
    settings: RunSettings,
}

/// Two bodies prepared for the interaction of simulations, in one medium.
pub(in crate::stability) struct FastMedium {
    engine: Engine,
    settings: RunSettings,
    interaction: ScreenedCoulomb,
}

/// The energy of a pose.
pub(in crate::stability) struct FastEnergy {
    /// Terms of the energy, kT.
    pub terms_kt: BTreeMap<&'static str, f64>,
}

impl FastEnergy {
    /// The sum of the terms, kT.
    pub fn total_kt(&self) -> f64 {
        self.terms_kt.values().sum()
    }
}

impl FastInteraction {
    /// # Errors
    /// Names the body whose mesh does not bound a solid.
    pub fn new(partners: &Partners, settings: &BindingSettings) -> Result<Self> {
        let pose = |number: usize| Pose {
            position: partners.bodies[number].provenance.origin_angstrom,
            ..Pose::identity()
        };
        let assembly = Assembly {
            bodies: partners.bodies.iter().map(Arc::clone).collect(),
            kinds: vec![0, 1],
            poses: vec![pose(0), pose(1)],
            boundary: Boundary::Open,
            sha256: String::new(),
            path: None,
        };
        // A scale of contacts needs beads on both bodies.
        let has_beads = partners
            .bodies
            .iter()
            .all(|body| !beads_of(body).is_empty());
        Ok(Self {
            engine: Engine::new(assembly)?,
            settings: RunSettings {
                solvent_response: settings.model.solvent_response(),
                contacts: settings.contacts.filter(|_| has_beads),
                ..inspection_settings(EnergyMode::Direct, None, DEFAULT_CONTACT_GAP_ANGSTROM)
            },
        })
    }

    /// Whether the hard bodies overlap.
    ///
    /// # Errors
    /// If the bodies cannot be placed.
    pub fn overlaps(&self) -> Result<bool> {
        Ok(!overlapping_pairs(&self.engine.system()?).is_empty())
    }

    /// Name of the model of this energy.
    pub fn model_name(&self) -> &'static str {
        self.settings.model_name(&self.engine.assembly().bodies)
    }

    /// The two bodies in a medium; the response of the solvent is solved here.
    ///
    /// # Errors
    /// If the response cannot be solved.
    pub fn in_medium(&self, interaction: &ScreenedCoulomb) -> Result<FastMedium> {
        Ok(FastMedium {
            engine: self.engine.in_medium(&self.settings, interaction)?,
            settings: self.settings.clone(),
            interaction: *interaction,
        })
    }
}

impl FastMedium {
    /// The energy that `inspect` prints for this pose with the same model, by terms.
    ///
    /// # Errors
    /// If the energy is not finite.
    pub fn energy(&self) -> Result<FastEnergy> {
        let system = self.engine.system()?;
        let mut model = self
            .engine
            .energy_model(&self.settings, &self.interaction)?;
        model.reset(&system)?;
        let mut charges_kt = 0.0;
        for pair in model.pairs(&system) {
            charges_kt += pair.energy_kt;
        }
        // Summed per term: several entries of one term belong together.
        let mut terms_kt = BTreeMap::from([(Term::Charges.name(), charges_kt)]);
        let poses = &self.engine.assembly().poses;
        let displacement = poses[1].position - poses[0].position;
        let relative = RelativePose::new(&poses[0], &poses[1], &displacement);
        for term in self
            .engine
            .terms()
            .into_iter()
            .flat_map(|terms| &terms.terms((0, 1)).0)
        {
            *terms_kt.entry(term.term().name()).or_default() += term.energy_kt(&relative);
        }
        Ok(FastEnergy { terms_kt })
    }

    /// The bodies and what acts between them.
    ///
    /// # Errors
    /// If the charges have no screening.
    pub fn pair(&self) -> Result<BodyPair> {
        let gap_angstrom = self.settings.contact_gap_angstrom;
        self.engine
            .body_pair(&self.interaction, gap_angstrom, false)
    }

    /// The bodies and what acts between them without the response of the solvent, with tables of
    /// the charges for many energies.
    ///
    /// # Errors
    /// If the charges have no screening.
    pub fn pair_without_response(&self) -> Result<BodyPair> {
        let gap_angstrom = self.settings.contact_gap_angstrom;
        let mut pair = self
            .engine
            .body_pair(&self.interaction, gap_angstrom, true)?;
        // It costs most of an energy; see the module.
        pair.potential
            .0
            .retain(|term| term.term() != Term::SolventResponse);
        Ok(pair)
    }

    /// The second body in the frame of the first; both have the orientation of their file.
    pub fn pose(&self) -> Pose {
        let poses = &self.engine.assembly().poses;
        Pose {
            position: poses[1].position - poses[0].position,
            ..Pose::identity()
        }
    }
}
