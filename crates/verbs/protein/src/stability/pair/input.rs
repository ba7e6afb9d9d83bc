//! Two bodies, from body files, or from structure files at each pH.

use crate::bodies::body_file;
use crate::bodies::ingest::read_and_build;
use crate::stability::effective::EffectiveStore;
use crate::stability::pair::PairRunSettings;
use anyhow::{Context, Result, bail};
use protomer_body::chemistry::{StructureProtonation, StructureTitration};
use protomer_body::{Body, BodySettings};
use protomer_common::input::{path_from, stem};
use protomer_io::atomic::sha256_hex;
use protomer_mc::BodyType;
use protomer_results::Record;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The key of the files in the details of a record.
const FILES: &str = "bodies";

/// The bodies of a pair at every pH.
#[derive(Debug, Clone)]
pub struct PairBodies {
    /// SHA-256 of what the bodies are made of.
    pub sha256: String,
    /// Whether both are the same body.
    pub are_equal: bool,
    /// Warnings of the making of bodies.
    pub warnings: Vec<String>,
    files: [PathBuf; 2],
    ph: Vec<Option<f64>>,
    /// Pairs by pH: one for all salts, or one for each.
    pairs: Vec<Vec<[Prepared; 2]>>,
    pub(super) effective_store: Arc<EffectiveStore>,
}

/// A body, and what the engine knows about it.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub body: Arc<Body>,
    pub kind: Arc<BodyType>,
}

/// The warning for a body without a molar mass, whose B22 is only known as a volume. A body without
/// residues has none by its nature.
fn unknown_mass(body: &Body) -> Option<String> {
    let names: Vec<&str> = body.residues_of_unknown_mass().into_iter().collect();
    (!names.is_empty()).then(|| {
        format!(
            "{}: there is no B22 in mol mL/g², because the molar mass of {} is not known",
            body.name,
            names.join(", ")
        )
    })
}

impl PairBodies {
    /// Reads two files; two copies of the first body if the second is `None`. Structure files are
    /// made into bodies at each pH, with the default settings of `protomer ingest` otherwise.
    ///
    /// # Errors
    /// For a file that cannot be read, and for pH values or a protonation where both files are bodies,
    /// whose charges are fixed.
    pub fn read(first: &Path, second: Option<&Path>, settings: &PairRunSettings) -> Result<Self> {
        Self::read_with(first, second, settings, &BodySettings::default())
    }

    /// Reads like [`PairBodies::read`], with these settings for structure files.
    ///
    /// # Errors
    /// As [`PairBodies::read`].
    pub fn read_with(
        first: &Path,
        second: Option<&Path>,
        run: &PairRunSettings,
        settings: &BodySettings,
    ) -> Result<Self> {
        let ph = &run.ph;
        let files = [first, second.unwrap_or(first)];
        let are_equal = files[0] == files[1] || sha256(files[0])? == sha256(files[1])?;
        if !ph.is_empty() && files.iter().all(|file| is_body_file(file)) {
            bail!(
                "--ph applies to structure files only, but {} and {} are bodies, whose charges are \
                 fixed; give the structure files, or ingest them at this pH",
                files[0].display(),
                files[1].display()
            );
        }
        if run.protonation.is_some() && files.iter().all(|file| is_body_file(file)) {
            bail!(
                "--protonation applies to structure files only, but {} and {} are bodies, whose charges are \
                 fixed; give the structure files, or ingest them with --protonation",
                files[0].display(),
                files[1].display()
            );
        }
        let ph: Vec<Option<f64>> = match ph.is_empty() {
            true => vec![None],
            false => ph.iter().copied().map(Some).collect(),
        };
        let (mut pairs, mut warnings) = (Vec::new(), Vec::new());
        let protonations = protonations(
            run.protonation,
            &run.salt_molar,
            run.medium.temperature_kelvin,
        );
        for ph in &ph {
            let mut at_salts = Vec::with_capacity(protonations.len());
            for protonation in &protonations {
                let mut settings = settings.clone();
                settings.sites.ph = ph.unwrap_or(settings.sites.ph);
                settings.sites.structure = *protonation;
                let first = prepare(files[0], &settings, &mut warnings)?;
                let second = match are_equal {
                    true => first.clone(),
                    false => prepare(files[1], &settings, &mut warnings)?,
                };
                at_salts.push([first, second]);
            }
            pairs.push(at_salts);
        }
        for pair in pairs.iter().flatten() {
            warnings.extend(
                pair.iter()
                    .filter_map(|prepared| unknown_mass(&prepared.body)),
            );
        }
        warnings.dedup();
        let hashes = format!("{}{}", sha256(files[0])?, sha256(files[1])?);
        Ok(Self {
            sha256: sha256_hex(hashes.as_bytes()),
            are_equal,
            warnings,
            files: files.map(Path::to_owned),
            ph,
            pairs,
            effective_store: Arc::default(),
        })
    }

    /// Reads the bodies that the results of a directory were made from.
    ///
    /// # Errors
    /// If the record does not name their files, or these are gone or have changed.
    pub fn of_results(
        directory: &Path,
        record: &Record,
        settings: &PairRunSettings,
    ) -> Result<Self> {
        let named: Option<[PathBuf; 2]> =
            serde_json::from_value(record.details[FILES].clone()).unwrap_or_default();
        let Some(named) = named else {
            bail!("run.json names no files of bodies");
        };
        let [first, second] = named.map(|file| directory.join(file));
        let bodies = Self::read(&first, Some(&second), settings)?;
        if bodies.sha256 != record.input_sha256 {
            bail!(
                "{} or {} is not what these results were made from",
                first.display(),
                second.display()
            );
        }
        Ok(bodies)
    }

    /// The two bodies at the first pH.
    pub(super) fn first_pair(&self) -> Vec<Arc<Body>> {
        let bodies = self.pairs.iter().flatten().flatten().take(2);
        bodies.map(|prepared| Arc::clone(&prepared.body)).collect()
    }

    /// Details of a record that [`PairBodies::of_results`] needs.
    pub(super) fn details(&self, directory: &Path) -> Value {
        let [first, second] = self.files.each_ref().map(|file| path_from(file, directory));
        json!({ FILES: first.zip(second).map(|(first, second)| [first, second]) })
    }

    /// The two bodies at a pH that was stated, at the first salt; those of body files for `None`.
    pub fn bodies_at(&self, ph: Option<f64>) -> Option<[&Body; 2]> {
        let number = self.ph.iter().position(|listed| *listed == ph)?;
        Some(
            self.pairs[number][0]
                .each_ref()
                .map(|prepared| &*prepared.body),
        )
    }

    /// The same bodies with effective charges from elsewhere.
    pub fn with_effective_store(self, effective_store: Arc<EffectiveStore>) -> Self {
        Self {
            effective_store,
            ..self
        }
    }

    /// The bodies at each pH: one pair for all salts, or one for each.
    pub(super) fn at_each_ph(&self) -> impl Iterator<Item = (Option<f64>, &[[Prepared; 2]])> {
        self.ph
            .iter()
            .copied()
            .zip(self.pairs.iter().map(Vec::as_slice))
    }

    /// The names of the two bodies.
    pub fn names(&self) -> [&str; 2] {
        let [first, second] = &self.pairs[0][0];
        [&first.body.name, &second.body.name]
    }
}

/// Body files are told by their extension.
fn is_body_file(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "body")
}

fn sha256(file: &Path) -> Result<String> {
    let bytes = protomer_io::input::read(file).with_context(|| {
        format!(
            "cannot read {}; name a body or structure file",
            file.display()
        )
    })?;
    Ok(sha256_hex(&bytes))
}

/// Conditions of the protonation at each salt (mol/L); one that is none for pKa values in water.
pub(in crate::stability) fn protonations(
    titration: Option<StructureTitration>,
    salt_molar: &[f64],
    temperature_kelvin: f64,
) -> Vec<Option<StructureProtonation>> {
    let Some(titration) = titration else {
        return vec![None];
    };
    let conditions = |salt: &f64| Some(titration.conditions(*salt, temperature_kelvin));
    salt_molar.iter().map(conditions).collect()
}

fn prepare(file: &Path, settings: &BodySettings, warnings: &mut Vec<String>) -> Result<Prepared> {
    let body = match is_body_file(file) {
        true => body_file::read(file)?.0,
        false => {
            let name = stem(file);
            let built = read_and_build(file, &name, settings)?;
            let of_file = |warning: &String| format!("warning: {}: {warning}", file.display());
            warnings.extend(built.warnings.iter().map(of_file));
            built.body
        }
    };
    let kind = BodyType::from_body(&body).with_context(|| format!("body '{}'", body.name))?;
    Ok(Prepared {
        body: Arc::new(body),
        kind: Arc::new(kind),
    })
}
