//! Effective charges, each fitted once, shared by whoever asks, and kept on the disk for the next
//! run.
//!
//! Fits run one at a time, on separate threads. A fit uses all threads. A thread of the common pool
//! that waited for it would begin another simulation, which may wait for this very fit.
//!
//! An entry holds, in little-endian numbers:
//!
//! ```text
//! FIRST_LINE  key  net charge  net effective charge  residual  condition  number of charges
//! x y z charge, for each  SHA-256 of everything before it, in hexadecimal digits
//! ```

use super::SoluteModel;
use super::problem::Problem;
use crate::stability::disk_cache::DiskCache;
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, anyhow};
use protomer_body::Body;
use protomer_field::effective_charges::EffectiveCharges;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::Vec3;
use std::collections::HashMap;
use std::io::{Error, Read};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

const FIRST_LINE: &[u8] = b"protomer effective charges 1\n";
/// Digits of a SHA-256.
const DIGITS: usize = 64;
/// Bytes of a number.
const NUMBER: usize = 8;

/// Store of effective charges. Whoever asks for the same ones shares them; who asks while they are
/// being fitted waits.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::body_file;
/// use protomer_protein_verbs::stability::disk_cache::DiskCache;
/// use protomer_protein_verbs::stability::effective::{EffectiveStore, SoluteModel};
/// use protomer_protein_verbs::stability::interaction::InteractionSettings;
/// use std::path::Path;
/// let store = EffectiveStore::default().with_cache(DiskCache::new("cache"), |_| ());
/// let (body, _) = body_file::read(Path::new("4lzt.body"))?;
/// let saline = InteractionSettings::default().interaction(Some(0.1))?;
/// let fitted = store.charges(&body, &saline, &SoluteModel::default())?;
/// let shared = store.charges(&body, &saline, &SoluteModel::default())?;
/// assert!(std::sync::Arc::ptr_eq(&fitted, &shared));
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct EffectiveStore {
    disk: Option<Disk>,
    /// Fitted charges by the hash of what they are made of. Held while one is fitted: a fit uses
    /// all threads.
    made: Mutex<HashMap<String, Arc<EffectiveCharges>>>,
    fitted: AtomicUsize,
}

#[derive(Debug)]
struct Disk {
    cache: DiskCache,
    warn: fn(&str),
    /// Whether the folder has refused an entry: it takes none of the others, and is warned of once.
    refused: AtomicBool,
}

impl EffectiveStore {
    /// The same store with a cache on the disk, where it looks first and keeps what it fits. An
    /// entry that cannot be used or written stops nothing: `warn` is told, and the charges are
    /// fitted.
    pub fn with_cache(self, cache: DiskCache, warn: fn(&str)) -> Self {
        let disk = Some(Disk {
            cache,
            warn,
            refused: AtomicBool::new(false),
        });
        Self { disk, ..self }
    }

    /// Number of fits that were made here, because neither memory nor disk had them.
    pub fn fitted(&self) -> usize {
        self.fitted.load(Ordering::Relaxed)
    }

    /// The effective charges of a body in a medium.
    ///
    /// # Errors
    /// As [`effective_charges_of`](super::effective_charges_of).
    pub fn charges(
        &self,
        body: &Body,
        interaction: &ScreenedCoulomb,
        solute: &SoluteModel,
    ) -> Result<Arc<EffectiveCharges>> {
        let problem = Problem::new(body, interaction, solute)?;
        let key = problem.key();
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(charges) = made.get(&key) {
            return Ok(Arc::clone(charges));
        }
        let stored_charges = self.disk.as_ref().and_then(|disk| disk.load(&key));
        let charges = match stored_charges {
            Some(charges) => charges,
            None => self.fit(&key, &problem)?,
        };
        let charges = Arc::new(charges);
        made.insert(key, Arc::clone(&charges));
        Ok(charges)
    }

    fn fit(&self, key: &str, problem: &Problem<'_>) -> Result<EffectiveCharges> {
        let charges = on_threads_of_its_own(|| problem.solve())??;
        self.fitted.fetch_add(1, Ordering::Relaxed);
        if let Some(disk) = &self.disk {
            disk.store(key, &charges);
        }
        Ok(charges)
    }
}

/// Does work on separate threads. A thread of the common pool that waits for its share of a fit
/// would meanwhile begin another simulation, which may wait for this very fit.
fn on_threads_of_its_own<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads())
        .build()
        .context("cannot start threads for the fit of effective charges")?;
    std::thread::scope(|scope| {
        let thread = scope.spawn(|| pool.install(work));
        thread
            .join()
            .map_err(|_| anyhow!("the fit of effective charges ended unexpectedly"))
    })
}

impl Disk {
    fn load(&self, key: &str) -> Option<EffectiveCharges> {
        let read = |file: &mut dyn Read| {
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes)?;
            from_bytes(key, &bytes).map_err(Error::other)
        };
        self.cache.load(key, read).unwrap_or_else(|error| {
            (self.warn)(&format!("warning: {error:#}; they are computed"));
            None
        })
    }

    fn store(&self, key: &str, charges: &EffectiveCharges) {
        let bytes = to_bytes(key, charges);
        if let Err(error) = self.cache.store(key, |file| file.write_all(&bytes))
            && !self.refused.swap(true, Ordering::Relaxed)
        {
            (self.warn)(&format!(
                "warning: effective charges are not kept for the next run: {error:#}"
            ));
        }
    }
}

fn to_bytes(key: &str, effective_charges: &EffectiveCharges) -> Vec<u8> {
    let mut numbers = vec![
        effective_charges.net_charge_e,
        effective_charges.net_effective_charge_e,
        effective_charges.relative_residual,
        effective_charges.condition,
        effective_charges.charges.len() as f64,
    ];
    for (place, charge) in &effective_charges.charges {
        numbers.extend([place.x, place.y, place.z, *charge]);
    }
    let mut bytes = [FIRST_LINE, key.as_bytes()].concat();
    bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
    // Over everything before it, key and version included.
    let sum = sha256_hex(&bytes);
    bytes.extend(sum.as_bytes());
    bytes
}

fn from_bytes(key: &str, bytes: &[u8]) -> Result<EffectiveCharges, &'static str> {
    const ENDED: &str = "they end too early";
    // The checksum is cut off first, as it covers the rest.
    let (content, sum) = bytes.split_last_chunk::<DIGITS>().ok_or(ENDED)?;
    let remainder = content
        .strip_prefix(FIRST_LINE)
        .ok_or("they are of another kind or version")?;
    // Before any number is believed.
    if sha256_hex(content).as_bytes() != sum {
        return Err("their checksum is wrong");
    }
    let remainder = remainder
        .strip_prefix(key.as_bytes())
        .ok_or("they are of another body or medium")?;
    let (numbers, []) = remainder.as_chunks::<NUMBER>() else {
        return Err(ENDED);
    };
    let numbers: Vec<f64> = numbers.iter().copied().map(f64::from_le_bytes).collect();
    let (fit, charges) = numbers.split_first_chunk::<5>().ok_or(ENDED)?;
    let [
        net_charge_e,
        net_effective_charge_e,
        relative_residual,
        condition,
        count,
    ] = *fit;
    let (charges, []) = charges.as_chunks::<4>() else {
        return Err(ENDED);
    };
    // The count is stored as a number like the others; it must agree with what is there.
    if charges.len() as f64 != count {
        return Err(ENDED);
    }
    let of_numbers = |[x, y, z, charge]: &[f64; 4]| (Vec3::new(*x, *y, *z), *charge);
    Ok(EffectiveCharges {
        charges: charges.iter().map(of_numbers).collect(),
        net_charge_e,
        net_effective_charge_e,
        relative_residual,
        condition,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn charges() -> EffectiveCharges {
        EffectiveCharges {
            charges: vec![
                (Vec3::new(0.1 + 0.2, -1e-300, 5.0), 1.0 / 3.0),
                (Vec3::zeros(), -2.5),
            ],
            net_charge_e: 1.0,
            net_effective_charge_e: 4.0 / 3.0,
            relative_residual: 0.01,
            condition: f64::INFINITY,
        }
    }

    #[test]
    fn an_entry_comes_back_bit_for_bit() {
        let key = sha256_hex(b"a body");
        assert_eq!(from_bytes(&key, &to_bytes(&key, &charges())), Ok(charges()));
    }

    #[test]
    fn what_was_changed_or_belongs_elsewhere_is_refused() {
        let key = sha256_hex(b"a body");
        let bytes = to_bytes(&key, &charges());
        for length in 0..bytes.len() {
            assert!(from_bytes(&key, &bytes[..length]).is_err(), "{length}");
        }
        for position in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[position] ^= 1;
            assert!(from_bytes(&key, &changed).is_err(), "{position}");
        }
        let other = sha256_hex(b"another body");
        let refusal = from_bytes(&other, &bytes).unwrap_err();
        assert!(refusal.contains("another body"), "{refusal}");
    }
}
