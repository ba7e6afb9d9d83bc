//! A whole engine as small as can be, a model for new ones: a random walk in a directory.

use protomer_results::{
    Campaign, End, Error, Execution, Layout, Log, LogMark, Result, ResultKind, ResultsDirectory,
    Run, Settings, Turn, Work, drive, log, settings,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The registration: the kind of result, and what lies in its directories.
pub const LAYOUT: Layout = Layout {
    kind: ResultKind::Other(std::borrow::Cow::Borrowed("walk")),
    settings: "run.toml",
    results: &["run.json", "log.csv", "checkpoint.bin"],
    is_result: |_| false,
};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Walk {
    pub seed: u64,
    pub steps: u64,
}

impl Settings for Walk {
    fn essential(&self) -> Self {
        Self {
            steps: 0,
            ..self.clone()
        }
    }
}

protomer_results::log_row! {
    /// Where the walker is; also a row of the log, and the answer.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
    pub struct Place {
        pub step: u64,
        pub position: i64,
    }
}

#[derive(Serialize, Deserialize)]
pub struct Saved {
    place: Place,
    log: LogMark,
}

impl Run for Walk {
    type State = (Place, Log);
    type Checkpoint = Saved;
    type Answer = Place;
    type Error = Error;

    fn work(&self) -> Work {
        Work {
            kind: LAYOUT.kind,
            verb: "walk",
            identity: settings::identity(self, "").unwrap(),
            input_sha256: String::new(),
        }
    }

    fn length(&self) -> u64 {
        self.steps
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<(Place, Log)> {
        let (place, mark) = saved.map_or_else(Default::default, |saved| (saved.place, saved.log));
        let log = Log::open::<Place>(&directory.join("log.csv"), &mark)?;
        Ok((place, log))
    }

    fn done(&self, (place, _): &(Place, Log)) -> u64 {
        place.step
    }

    fn advance(&self, (place, log): &mut (Place, Log), _turn: &Turn) -> Result<()> {
        // The randomness depends on the seed and the step only.
        let noise = (self.seed + place.step).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 63;
        place.position += 2 * noise as i64 - 1;
        place.step += 1;
        log.append(place)
    }

    fn save(&self, (place, log): &mut (Place, Log)) -> Result<Saved> {
        Ok(Saved {
            place: *place,
            log: log.sync()?,
        })
    }

    fn answer(&self, (place, _): &mut (Place, Log), _directory: &Path) -> Result<Place> {
        Ok(*place)
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        log::check(&directory.join("log.csv"), &saved.log)
    }
}

/// Walks or continues in a directory: the whole of a verb.
pub fn walk(walk: &Walk, path: &Path, execution: &Execution) -> Result<End<Place>> {
    let _ours = ResultsDirectory::enter(path, &LAYOUT, walk, &walk.work().identity, execution)?;
    drive(walk, path, execution)
}

/// Walks with several seeds in one directory.
pub struct Walks {
    pub settings: Walk,
    walks: Vec<Walk>,
    pub path: PathBuf,
}

impl Walks {
    pub fn new(seeds: u64, steps: u64, path: &Path) -> Self {
        Self {
            settings: Walk { seed: seeds, steps },
            walks: (0..seeds).map(|seed| Walk { seed, steps }).collect(),
            path: path.to_owned(),
        }
    }
}

impl Campaign for Walks {
    type Task = Walk;
    type Part = Place;
    type Answer = i64;
    type Error = Error;

    fn work(&self) -> Work {
        self.settings.work()
    }

    fn tasks(&self) -> &[Walk] {
        &self.walks
    }

    fn directory(&self, walk: &Walk) -> PathBuf {
        self.path.join(format!("seed_{}", walk.seed))
    }

    fn run(&self, walk: &Walk, directory: &Path, execution: &Execution) -> Result<End<Place>> {
        drive(walk, directory, execution)
    }

    fn collect(&self, places: Vec<Place>) -> Result<i64> {
        let sum = places.iter().map(|place| place.position).sum();
        std::fs::write(self.path.join("sum.txt"), format!("{sum}\n")).unwrap();
        Ok(sum)
    }
}

/// Every file below a folder but the locks.
pub fn contents(folder: &Path) -> std::collections::BTreeMap<PathBuf, Vec<u8>> {
    let mut files = std::collections::BTreeMap::new();
    for entry in folder
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().path())
    {
        if entry.is_dir() {
            files.extend(
                contents(&entry)
                    .into_iter()
                    .map(|(name, bytes)| (Path::new(entry.file_name().unwrap()).join(name), bytes)),
            );
        } else if !entry.ends_with(".lock") {
            files.insert(
                entry.file_name().unwrap().into(),
                std::fs::read(&entry).unwrap(),
            );
        }
    }
    files
}
