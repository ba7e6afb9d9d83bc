//! Named tensors and a description as one block of bytes, in the format safetensors.

use crate::{LearnError, Result};
use candle_core::{Device, Tensor};
use safetensors::SafeTensors;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::HashMap;

/// The entry of the metadata that holds the description.
const DESCRIPTION: &str = "protomer";

/// Tensors and description as bytes.
///
/// # Errors
/// [`LearnError::Settings`] if the description cannot be written as JSON.
pub(super) fn pack(tensors: &[(String, Tensor)], description: &impl Serialize) -> Result<Vec<u8>> {
    let unwritable = |reason: String| LearnError::Settings(reason);
    let text = serde_json::to_string(description).map_err(|error| unwritable(error.to_string()))?;
    let metadata = HashMap::from([(DESCRIPTION.to_string(), text)]);
    let pairs = tensors.iter().map(|(name, tensor)| (name.as_str(), tensor));
    safetensors::serialize(pairs, Some(metadata)).map_err(|error| unwritable(error.to_string()))
}

/// Unpacks what [`pack`] packed: the tensors by name, and the description.
///
/// # Errors
/// [`LearnError::Settings`] if the bytes are damaged or hold something else than `kind`.
pub(super) fn unpack<D: DeserializeOwned>(
    bytes: &[u8],
    kind: &str,
    device: &Device,
) -> Result<(Vec<(String, Tensor)>, D)> {
    let damaged =
        |reason: String| LearnError::Settings(format!("this is not a usable {kind}: {reason}"));
    let (_, header) =
        SafeTensors::read_metadata(bytes).map_err(|error| damaged(error.to_string()))?;
    let entries = header.metadata().as_ref();
    let Some(text) = entries.and_then(|entries| entries.get(DESCRIPTION)) else {
        return Err(damaged(format!(
            "its metadata has no entry {DESCRIPTION:?}"
        )));
    };
    let description = serde_json::from_str(text).map_err(|error| damaged(error.to_string()))?;
    let tensors = candle_core::safetensors::load_buffer(bytes, device)
        .map_err(|error| damaged(error.to_string()))?;
    let mut tensors: Vec<(String, Tensor)> = tensors.into_iter().collect();
    tensors.sort_by(|(first, _), (second, _)| first.cmp(second));
    Ok((tensors, description))
}
