//! Named tensors and a description in one block of bytes, in the format safetensors.

use crate::{LearnError, Result};
use candle_core::{Device, Tensor};
use safetensors::SafeTensors;
use serde::{Serialize, de::DeserializeOwned};
use std::collections::HashMap;

/// The entry of the metadata that holds the description.
const DESCRIPTION: &str = "protomer";

pub(super) fn pack(tensors: &[(String, Tensor)], description: &impl Serialize) -> Result<Vec<u8>> {
    let text = serde_json::to_string(description)
        .map_err(|error| LearnError::Settings(error.to_string()))?;
    let metadata = HashMap::from([(DESCRIPTION.to_string(), text)]);
    let pairs = tensors.iter().map(|(name, tensor)| (name.as_str(), tensor));
    safetensors::serialize(pairs, Some(metadata))
        .map_err(|error| LearnError::Settings(error.to_string()))
}

/// # Errors
/// [`LearnError::Settings`] if the bytes are damaged or hold something else than `what`.
pub(super) fn unpack<D: DeserializeOwned>(
    bytes: &[u8],
    what: &str,
    device: &Device,
) -> Result<(Vec<(String, Tensor)>, D)> {
    let damaged =
        |reason: String| LearnError::Settings(format!("this is no usable {what}: {reason}"));
    let (_, metadata) =
        SafeTensors::read_metadata(bytes).map_err(|error| damaged(error.to_string()))?;
    let Some(text) = metadata
        .metadata()
        .as_ref()
        .and_then(|entries| entries.get(DESCRIPTION))
    else {
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
