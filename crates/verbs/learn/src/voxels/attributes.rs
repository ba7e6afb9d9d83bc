//! The attributes of a set. They are serialised straight into their file: those of the samples one
//! after another, never all in memory.

use super::content::Content;
use super::identity::fixed_conditions;
use super::listed::Listed;
use super::origin::Origin;
use super::records::Exclusion;
use super::row::Row;
use super::settings::{Spacing, VoxelizeSettings};
use super::statistics::Statistics;
use anyhow::Result;
use protomer_body::chemistry::HYDROPATHY_SCALE;
use protomer_field::voxels::Channel;
use protomer_io::zarr;
use protomer_kernel::setting::Choices;
use protomer_results::ResultKind;
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Settings, manifests and identity of a set: all that it is made of besides its content.
#[derive(Debug, Clone, Copy)]
pub struct Making<'a> {
    /// The settings.
    pub settings: &'a VoxelizeSettings,
    /// The manifests, in order.
    pub origins: &'a [Origin],
    /// The identity of the set.
    pub identity: &'a str,
}

/// The attributes; their names and order belong to the format of a set.
#[derive(Serialize)]
pub struct Attributes<'a> {
    kind: ResultKind,
    made_by: String,
    identity: &'a str,
    manifest_sha256: &'a str,
    manifests: &'a [Origin],
    settings: &'a VoxelizeSettings,
    spacing_angstrom: Spacing,
    conditions: Value,
    channel_meanings: Map<String, Value>,
    samples: Words<'a>,
    excluded: &'a [Exclusion],
    warnings: &'a BTreeMap<String, Vec<String>>,
    statistics: Statistics,
}

impl<'a> Attributes<'a> {
    /// The attributes of a set.
    ///
    /// # Errors
    /// For unphysical solvent conditions.
    pub fn new(
        making: Making<'a>,
        content: &'a dyn Content,
        statistics: Statistics,
    ) -> Result<Self> {
        let Making {
            settings,
            origins,
            identity,
        } = making;
        let manifest_sha256 = match origins {
            [only] => only.manifest_sha256.as_str(),
            _ => "",
        };
        Ok(Self {
            kind: ResultKind::VoxelSet,
            made_by: format!("protomer {}", env!("CARGO_PKG_VERSION")),
            identity,
            manifest_sha256,
            manifests: origins,
            settings,
            spacing_angstrom: settings.spacing,
            conditions: json!({
                "salt_molar": settings.salt_molar,
                "temperature_kelvin": settings.temperature_kelvin,
                "ph": settings.ph,
                "poisson_boltzmann": fixed_conditions(settings)?,
            }),
            channel_meanings: meanings(&settings.channels),
            samples: Words(content),
            excluded: content.excluded(),
            warnings: content.warnings(),
            statistics,
        })
    }
}

/// Attributes of [`Attributes`] that tell a reader where a set comes from; sets of earlier versions may
/// lack some.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Stated {
    /// Program and version that made the set.
    pub made_by: Option<String>,
    /// Hash of settings and input.
    pub identity: Option<String>,
    /// Hash of the manifest; empty for several manifests.
    pub manifest_sha256: Option<String>,
    /// Meaning of the values of each channel.
    #[serde(default)]
    pub channel_meanings: BTreeMap<String, String>,
}

impl Stated {
    /// Reads them from a set.
    ///
    /// # Errors
    /// If the attributes are damaged.
    pub fn read(set: &Path) -> Result<Self> {
        Ok(zarr::attributes(set)?)
    }
}

fn meanings(channels: &[Channel]) -> Map<String, Value> {
    let mut meanings = Map::new();
    for channel in channels {
        meanings.insert(channel.name().to_owned(), meaning(*channel).into());
    }
    meanings
}

/// Meaning of the values of a channel.
fn meaning(channel: Channel) -> String {
    let text = match channel {
        Channel::Shape => {
            "1 where the surface passes through: centres at most half an edge from it"
        }
        Channel::Solid => "1 where the centre is inside the surface",
        Channel::Potential => "kT/e, at the point of the surface nearest to the centre",
        Channel::Hydropathy => {
            return format!("{HYDROPATHY_SCALE} index, averaged over nearby residues");
        }
        Channel::Spacing => "edge of the voxels of this sample, Å",
        Channel::PartnerShape => "1 where the surface of the second body passes through",
        Channel::PartnerPotential => {
            "kT/e of the second body alone, at the point of its surface nearest to the centre"
        }
        Channel::PartnerHydropathy => {
            return format!("{} of the second body", meaning(Channel::Hydropathy));
        }
    };
    text.to_owned()
}

/// The string properties of the samples, a list for each.
struct Words<'a>(&'a dyn Content);

impl Serialize for Words<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let content = self.0;
        let mut lists = serializer.serialize_map(Some(Row::WORDS.len()))?;
        for (place, name) in Row::WORDS.into_iter().enumerate() {
            let word = |row: Row| row.words()[place].to_owned();
            let list = Listed(|| (0..content.len()).map(|n| content.row(n).map(word)));
            lists.serialize_entry(name, &list)?;
        }
        lists.end()
    }
}
