//! A list that is serialised item by item, as an iterator gives them, without being in memory.

use anyhow::Result;
use serde::ser::{Error, SerializeSeq};
use serde::{Serialize, Serializer};

/// The items of the iterator that the function returns. An error among them is that of the
/// serialisation.
pub struct Listed<F>(pub F);

impl<F, I, T> Serialize for Listed<F>
where
    F: Fn() -> I,
    I: Iterator<Item = Result<T>>,
    T: Serialize,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(None)?;
        for item in (self.0)() {
            let item = item.map_err(|error| S::Error::custom(format!("{error:#}")))?;
            list.serialize_element(&item)?;
        }
        list.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::anyhow;

    /// The twin: all items in a vector.
    #[test]
    fn the_text_is_that_of_a_vector() {
        for length in 0..3 {
            let listed = Listed(|| (0..length).map(Ok));
            let vector: Vec<u32> = (0..length).collect();
            assert_eq!(
                serde_json::to_string_pretty(&listed).unwrap(),
                serde_json::to_string_pretty(&vector).unwrap()
            );
        }
    }

    #[test]
    fn an_item_that_is_an_error_ends_it() {
        let listed = Listed(|| [Ok(1), Err(anyhow!("no second"))].into_iter());
        let error = serde_json::to_string(&listed).unwrap_err();
        assert!(error.to_string().contains("no second"), "{error}");
    }
}
