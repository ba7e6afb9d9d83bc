//! Shared strings: a structure has many atoms and few different names.

use std::collections::HashSet;
use std::sync::Arc;

/// Gives one shared string for equal texts.
#[derive(Debug, Default)]
pub(crate) struct Names {
    strings: HashSet<Arc<str>>,
}

impl Names {
    pub(crate) fn share(&mut self, text: &str) -> Arc<str> {
        if let Some(name) = self.strings.get(text) {
            return name.clone();
        }
        let name: Arc<str> = Arc::from(text);
        self.strings.insert(name.clone());
        name
    }
}
