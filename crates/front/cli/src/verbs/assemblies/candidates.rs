//! `protomer candidates`: the up/down arrangements of a ring or stack that are different under its
//! symmetry, and their tilts and spins of low energy.

use crate::flags::medium::ConditionArgs;
use crate::flags::model::ModelArgs;
use crate::flags::settings::choice;
use crate::flags::solute::ChargesArgs;
use crate::flags::space::SpaceArgs;
use crate::flags::tables::TablesArgs;
use crate::flags::terms::TermsArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_body::assembly::{CubicGroup, Symmetry};
use protomer_common::answer::Answer;
use protomer_common::{quantity, range};
use protomer_protein_verbs::assemblies::candidates::cages::{
    CagesSettings, search_cage_candidates,
};
use protomer_protein_verbs::assemblies::candidates::rings::search_candidates;
use protomer_protein_verbs::assemblies::candidates::{
    CandidatesSettings, SearchMedium, candidates,
};
use protomer_protein_verbs::assemblies::search::Searched;
use protomer_protein_verbs::assemblies::search::ring::RingGrid;
use protomer_protein_verbs::stability::DEFAULT_CONTACT_GAP_ANGSTROM;
use protomer_protein_verbs::stability::inspect::inspection_settings;
use protomer_protein_verbs::stability::run::EnergyMode;
use protomer_results::End;
use std::path::PathBuf;

/// Salt of a search without one, mol/L.
const USUAL_SALT_MOLAR: f64 = 0.15;
/// Arrangements of the grid at most: a day of one processor for large bodies.
const MOST_POINTS: usize = 10_000_000;

/// Enumerate the distinct up/down arrangements of bodies in a ring or a stack of two
/// rings, up to the symmetry of the stack, and write each as an assembly closed to contact; or search
/// their tilts and spins, or cages of a cubic group, for low energies.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "candidates a.body b.body --ring 8 --stack 2",
    "candidates a.body b.body --ring 4 --stack 2 --box 320 -o candidates"
))]
pub struct CandidatesArgs {
    /// Body files, in the order in which they alternate.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// Bodies per ring.
    #[arg(long, required_unless_present = "group", value_parser = range::MEMBERS.number::<usize>())]
    ring: Option<usize>,
    /// Number of rings: one or two.
    #[arg(long, default_value_t = 1)]
    stack: usize,
    /// Symmetry required of an arrangement.
    #[arg(long, value_parser = choice::<Symmetry>(), default_value = "dihedral")]
    symmetry: Symmetry,
    /// Gap between neighbours in the ring, and between the rings, beyond contact, Å.
    #[arg(long, default_value_t = 0.5, value_parser = range::GAP.number())]
    gap: f64,
    #[command(flatten)]
    space: SpaceArgs,
    /// Folder for the assemblies; if omitted, they are only counted or listed.
    #[arg(short, long)]
    output: Option<PathBuf>,
    #[command(flatten)]
    search: SearchArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    charges: ChargesArgs,
    #[command(flatten)]
    terms: TermsArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

/// The search of tilts and spins.
#[derive(Debug, Args)]
#[command(next_help_heading = "Search")]
pub struct SearchArgs {
    /// Search these leans of the bodies' axes about the outward direction, degrees: a list such as
    /// 0,40,90 or a range such as 0..90/7, for each kind of body.
    #[arg(long, allow_hyphen_values = true)]
    tilt: Option<String>,
    /// Search these turns of the bodies about their own axes, degrees, as --tilt.
    #[arg(long, allow_hyphen_values = true)]
    spin: Option<String>,
    /// Number of the lowest arrangements that are refined: tilts, spins, stagger of the rings, and the
    /// opening between neighbours [default: 12].
    #[arg(long, value_parser = range::TABLE_ROWS.number::<usize>())]
    refine: Option<usize>,
    /// Search cages of this group in the place of rings.
    #[arg(long, value_parser = choice::<CubicGroup>(), conflicts_with_all = ["ring", "stack", "symmetry", "tilt", "spin"])]
    group: Option<CubicGroup>,
    /// Random cages at the start of a search.
    #[arg(long, default_value_t = 2000, value_parser = range::OBJECTS.number::<usize>())]
    samples: usize,
    /// Seed of the random cages.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl CandidatesArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        if let Some(group) = self.search.group {
            return self.search_cages(group, front);
        }
        let settings = CandidatesSettings {
            bodies: self.bodies.clone(),
            ring: self.ring.unwrap_or(1),
            stack: self.stack,
            symmetry: self.symmetry,
            gap_angstrom: self.gap,
            box_angstrom: self.space.box_angstrom()?,
            output: self.output.clone(),
            force: front.force(),
        };
        match self.grid()? {
            Some(grid) => self.search_rings(&settings, &grid, front),
            None => Ok(Reply::data(candidates(&settings)?)),
        }
    }

    /// The grid of a search of rings, if one is requested.
    fn grid(&self) -> Result<Option<RingGrid>> {
        let SearchArgs { tilt, spin, .. } = &self.search;
        if tilt.is_none() && spin.is_none() {
            let energies = self.conditions.salt.is_some()
                || self.model.model.is_some()
                || self.charges.interaction.is_some()
                || self.terms.is_given();
            if self.search.refine.is_some() || energies {
                bail!(
                    "without --tilt or --spin no energies are computed; give --tilt 0..90/7 --spin 0..90/7 for a \
                     search of low energies"
                );
            }
            return Ok(None);
        }
        let angles = |text: &Option<String>| match text {
            Some(text) => quantity::angle_list(text),
            None => Ok(vec![0.0]),
        };
        let (tilts_degrees, spins_degrees) = (angles(tilt)?, angles(spin)?);
        let choices = (tilts_degrees.len() * spins_degrees.len()) as f64;
        let points = choices.powi(self.bodies.len() as i32);
        if points > MOST_POINTS as f64 {
            bail!(
                "{points:.0} combinations of tilts and spins are too many; give at most {MOST_POINTS}, and let \
                 --refine find the angles between them"
            );
        }
        Ok(Some(RingGrid {
            tilts_degrees,
            spins_degrees,
        }))
    }

    fn search_rings(
        &self,
        settings: &CandidatesSettings,
        grid: &RingGrid,
        front: &Front,
    ) -> Result<Reply> {
        let execution = front.execution("stopping the search", None)?;
        let end = self.in_medium(front, |medium| {
            search_candidates(settings, grid, self.refined(), medium, &execution)
        })?;
        Ok(reply(end))
    }

    fn search_cages(&self, group: CubicGroup, front: &Front) -> Result<Reply> {
        let settings = CagesSettings {
            bodies: self.bodies.clone(),
            group,
            samples: self.search.samples,
            refined: self.refined(),
            seed: self.search.seed,
            gap_angstrom: self.gap,
            box_angstrom: self.space.box_angstrom()?,
            output: self.output.clone(),
            force: front.force(),
        };
        let execution = front.execution("stopping the search", None)?;
        let end = self.in_medium(front, |medium| {
            search_cage_candidates(&settings, medium, &execution)
        })?;
        Ok(reply(end))
    }

    fn refined(&self) -> usize {
        self.search.refine.unwrap_or(Searched::REFINED)
    }

    /// Result of a search with the model and in the medium of the flags.
    fn in_medium<T>(
        &self,
        front: &Front,
        search: impl FnOnce(&SearchMedium) -> Result<T>,
    ) -> Result<T> {
        let conditions = &self.conditions;
        let has_screening = conditions.salt.is_some() || conditions.medium.debye.is_some();
        let salt = conditions
            .salt
            .or((!has_screening).then_some(USUAL_SALT_MOLAR));
        front.warn(quantity::salt_warning(salt));
        let interaction = conditions.medium.medium().interaction(salt)?;
        let usual = inspection_settings(EnergyMode::Direct, None, DEFAULT_CONTACT_GAP_ANGSTROM);
        let run = self.model.acting(&self.charges, &self.terms, usual)?;
        search(&SearchMedium {
            run: &run,
            interaction,
            prepare: &|assembly| {
                front.warn(self.model.body_warning(&assembly));
                self.tables.engine(assembly, front)
            },
        })
    }
}

fn reply(end: End<impl Answer + Send + 'static>) -> Reply {
    match end {
        End::Finished(report) => Reply::data(report),
        End::Stopped => Reply::stopped("stopped; nothing was written".into()),
    }
}
