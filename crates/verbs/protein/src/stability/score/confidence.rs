//! Confidences that predictors of complexes write next to a structure.
//!
//! | program | structure | confidences |
//! |---|---|---|
//! | AlphaFold 3 | `NAME_model.cif` | `NAME_summary_confidences.json` |
//! | Boltz | `NAME_model_0.cif` | `confidence_NAME_model_0.json` |
//! | ColabFold | `NAME_unrelaxed_rank_001_MODEL.pdb` | `NAME_scores_rank_001_MODEL.json` |

use super::record::number;
use protomer_common::input::stem;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The columns: confidences of the interface and of the whole, null where no file next to the structure has them.
pub(super) fn columns(structure: &Path) -> Vec<(String, Value)> {
    let found = candidates(structure).iter().find_map(|path| read(path));
    let value = |key: &str| {
        let value = found
            .as_ref()
            .and_then(|confidences| confidences.get(key)?.as_f64());
        number(key, value.unwrap_or(f64::NAN))
    };
    vec![value("iptm"), value("ptm")]
}

/// Files that may hold the confidences of a structure.
fn candidates(structure: &Path) -> Vec<PathBuf> {
    let name = stem(structure);
    let folder = structure.parent().unwrap_or(Path::new(""));
    let mut files = vec![format!("confidence_{name}.json")];
    if let Some(job) = name.strip_suffix("_model") {
        files.push(format!("{job}_summary_confidences.json"));
    }
    for relaxation in ["_unrelaxed_rank_", "_relaxed_rank_"] {
        if let Some((job, rank)) = name.split_once(relaxation) {
            files.push(format!("{job}_scores_rank_{rank}.json"));
        }
    }
    files.iter().map(|file| folder.join(file)).collect()
}

fn read(path: &Path) -> Option<Value> {
    serde_json::from_str(&protomer_io::input::read_to_string(path).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confidences_are_found_beside_the_structure() {
        let folder = tempfile::tempdir().unwrap();
        for (structure, confidences) in [
            ("fold_x_model.cif", "fold_x_summary_confidences.json"),
            ("x_model_0.cif", "confidence_x_model_0.json"),
            (
                "x_unrelaxed_rank_001_alphafold2_multimer_v3_model_1_seed_000.pdb",
                "x_scores_rank_001_alphafold2_multimer_v3_model_1_seed_000.json",
            ),
        ] {
            let path = folder.path().join(confidences);
            std::fs::write(&path, "{\"iptm\": 0.75, \"ptm\": 0.5}").unwrap();
            let columns = columns(&folder.path().join(structure));
            assert_eq!(columns, [number("iptm", 0.75), number("ptm", 0.5)]);
        }
        let columns = columns(&folder.path().join("other.pdb"));
        assert_eq!(columns[0].1, Value::Null);
    }
}
