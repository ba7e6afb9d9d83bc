//! The flag of the cache, shared by the verbs that keep results in it.

use crate::front::Front;
use clap::Args;
use protomer_protein_verbs::stability::disk_cache::DiskCache;
use protomer_protein_verbs::stability::effective::EffectiveStore;
use std::sync::Arc;

/// Options of the cache that is kept from one run to the next.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Cache")]
pub struct CacheArgs {
    /// Do not read or write the cache of tables of energies by levels and of effective charges. The
    /// cache folder is PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or
    /// ~/.cache; it holds at most 2 GB.
    #[arg(long)]
    pub no_cache: bool,
}

impl CacheArgs {
    /// The user's cache, if there is one and it may be used.
    pub fn cache(&self, front: &Front) -> Option<DiskCache> {
        let cache = DiskCache::of_user().filter(|_| !self.no_cache)?;
        front.explain(&cache.describe());
        Some(cache.telling(front.warner()))
    }

    /// The effective charges of a run.
    pub fn effective_store(&self, front: &Front) -> Arc<EffectiveStore> {
        let store = EffectiveStore::default();
        Arc::new(match self.cache(front) {
            Some(cache) => store.with_cache(cache, front.warner()),
            None => store,
        })
    }
}
