//! What holds an assembly together: the energy by residues and by pairs of residues, averaged over
//! the frames of a run, and what other charges would change.
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what is asked |
//! | `frames` | the bodies and the frames of a run, or the one pose of an assembly |
//! | `bound` | frames in which the assembly holds |
//! | `analysis` | from frames to averages |
//! | `surface` | the part of a body's surface that each residue has |
//! | `mutations` | exchanges of single charges, and the half salt they lead to |
//! | `result` | the answer, as JSON has it |
//! | `answer` | the answer in words and as a figure |
//! | `tables` | the same as CSV |
//! | `page` | what the page of a run shows of it |
//! | `maps` | contacts and energies of pairs of residues as maps |
//! | `files` | what is written, with a structure coloured by energy |

mod analysis;
mod answer;
mod bound;
mod files;
mod frames;
mod maps;
mod mutations;
pub(crate) mod page;
mod result;
mod settings;
mod surface;
mod tables;

pub use files::FOLDER;
pub use maps::{contact_map, energy_map};
pub(crate) use mutations::exchanges_of;
pub use result::{
    Change, MutationAtSalt, MutationRow, PairRow, ResidueName, ResidueRow, ResiduesResult,
    SharedBy, WholeEnergy,
};
pub use settings::{PoseSettings, ResiduesSettings};

use crate::stability::effective::EffectiveStore;
use anyhow::Result;
use frames::Run;
use protomer_results::Progress;
use std::sync::Arc;

/// Finds the residues that hold an assembly together.
///
/// # Errors
/// For an input without bodies or frames, bodies without residues, a medium that is missing, and
/// files that exist or cannot be written.
///
/// ```no_run
/// use protomer_protein_verbs::stability::residues::{ResiduesSettings, residues};
/// use protomer_common::answer::Answer;
/// let settings = ResiduesSettings {
///     input: "stability".into(),
///     ..ResiduesSettings::default()
/// };
/// println!("{}", residues(&settings, Default::default(), &())?.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn residues(
    settings: &ResiduesSettings,
    store: Arc<EffectiveStore>,
    progress: &dyn Progress,
) -> Result<ResiduesResult> {
    settings.check()?;
    let run = Run::open(settings, store)?;
    files::require_writable(settings, &run)?;
    let shown = run.shown_salt(settings)?;
    let salts = match settings.mutations {
        true => run.salts(),
        false => vec![shown.salt_molar],
    };
    progress.begin(0, "frames");
    let scan = settings.mutations.then(|| mutations::Scan::from_run(&run));
    let scan = scan.transpose()?;
    let mut shown_analysis = None;
    let mut scanned = Vec::new();
    for salt_molar in salts {
        let at_salt = run.ensemble(settings, salt_molar)?;
        let is_shown = salt_molar == shown.salt_molar;
        let (averages, of_scan) =
            analysis::analyse(settings, &at_salt, scan.as_ref(), is_shown, progress)?;
        scanned.extend(of_scan);
        if is_shown {
            shown_analysis = Some((at_salt, averages));
        }
    }
    let Some((at_salt, averages)) = shown_analysis else {
        anyhow::bail!("no salt concentration was chosen; give --salt 100mM");
    };
    let mut result = ResiduesResult::new(settings, &run, &shown, &at_salt, &averages);
    if result.shared_by == SharedBy::PlainCharges || result.has_response() {
        result.effective_energy_kt = Some(run.mean_energy_kt(&at_salt, shown.salt_molar)?);
    }
    if let Some(scan) = &scan {
        let sweep = run.answer()?;
        let rise_kt = run.rise_with_salt_kt(&at_salt, shown.salt_molar)?;
        let rows = scan.rows(&scanned, shown.salt_molar, &sweep, rise_kt, &averages);
        result.mutations_note = mutations::note(&run, &sweep).map(Into::into);
        result.mutations = Some(rows);
    }
    result
        .warnings
        .extend(at_salt.near_contact_warning(&run.settings)?);
    files::write(&mut result, settings, &run, &at_salt)?;
    Ok(result)
}
