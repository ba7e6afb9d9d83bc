//! The tables of certified energies: made once per kind of body and potential, shared by all threads of a run, and bounded
//! in memory.

use anyhow::{Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_kernel::potential::Yukawa;
use protomer_mc::BodyType;
use protomer_mc::energy::certified::ChargeTable;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Memory that tables may take where no limit is stated, bytes.
pub const DEFAULT_MEMORY_LIMIT_BYTES: u64 = 4_000_000_000;

/// Raised when the tables of equal charges become other tables.
const FORMAT: &str = "charge table 2";

/// Where tables come from.
#[derive(Debug)]
pub struct EnergyTables {
    memory_limit_bytes: u64,
    made: Mutex<Made>,
}

#[derive(Debug, Default)]
struct Made {
    /// By the hash of what they are made of.
    tables: HashMap<String, Arc<ChargeTable>>,
    /// Held while a table is made, so that nobody makes it a second time and different ones are made side by side.
    making: HashMap<String, Arc<Mutex<()>>>,
}

impl Default for EnergyTables {
    fn default() -> Self {
        Self::new(DEFAULT_MEMORY_LIMIT_BYTES)
    }
}

impl EnergyTables {
    /// Tables that may take this much memory together, bytes.
    pub fn new(memory_limit_bytes: u64) -> Self {
        Self { memory_limit_bytes, made: Mutex::default() }
    }

    /// The tables of these kinds of bodies under this potential. Whoever asks for the same ones shares them; who asks while
    /// they are being made waits. Tables that nobody uses any more are kept while there is room.
    ///
    /// # Errors
    /// If those in use take more memory than is allowed: says how much is needed and what to do.
    pub fn of(&self, types: &[Arc<BodyType>], yukawa: &Yukawa) -> Result<Vec<Arc<ChargeTable>>> {
        let table = |kind: &Arc<BodyType>| self.table(kind, yukawa);
        std::thread::scope(|scope| {
            let jobs: Vec<_> = types.iter().map(|kind| scope.spawn(move || table(kind))).collect();
            let done = jobs.into_iter().zip(types);
            // A thread that could not finish is replaced by doing its work here.
            done.map(|(job, kind)| job.join().unwrap_or_else(|_| table(kind))).collect()
        })
    }

    /// Memory of the tables that are there now, bytes.
    pub fn memory_bytes(&self) -> usize {
        locked(&self.made).tables.values().map(|table| table.memory_bytes()).sum()
    }

    fn table(&self, kind: &BodyType, yukawa: &Yukawa) -> Result<Arc<ChargeTable>> {
        let key = key(kind, yukawa);
        let making = Arc::clone(locked(&self.made).making.entry(key.clone()).or_default());
        let _mine = locked(&making);
        if let Some(table) = locked(&self.made).tables.get(&key) {
            return Ok(Arc::clone(table));
        }
        let table = Arc::new(ChargeTable::new(&kind.charges, yukawa));
        locked(&self.made).keep(key, &table, &kind.name, self.memory_limit_bytes)?;
        Ok(table)
    }
}

impl Made {
    /// Takes a new table in; if there is no room, those go that only this map still holds.
    fn keep(&mut self, key: String, table: &Arc<ChargeTable>, body: &str, limit_bytes: u64) -> Result<()> {
        let size = |table: &Arc<ChargeTable>| table.memory_bytes() as u64;
        if self.tables.values().map(size).sum::<u64>() + size(table) > limit_bytes {
            self.tables.retain(|_, table| Arc::strong_count(table) > 1);
        }
        let needed_bytes = self.tables.values().map(size).sum::<u64>() + size(table);
        if needed_bytes > limit_bytes {
            bail!(
                "the energy tables of body '{body}' take {} and those in use with them {}, more than the limit of {}; \
                 raise --memory-limit, use fewer --threads (salt concentrations that run side by side have tables of \
                 their own), or compute with --energy direct",
                in_units(size(table)),
                in_units(needed_bytes),
                in_units(limit_bytes)
            );
        }
        self.tables.insert(key, Arc::clone(table));
        Ok(())
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// SHA-256 of everything a table depends on: the charges in their order, the potential, and the version of the tables.
fn key(kind: &BodyType, yukawa: &Yukawa) -> String {
    let mut bytes = FORMAT.as_bytes().to_vec();
    let lengths = [yukawa.bjerrum_length_angstrom, yukawa.inverse_debye_length_per_angstrom, yukawa.cutoff_angstrom];
    let charges = kind.charges.iter().flat_map(|(place, charge)| [place.x, place.y, place.z, charge]);
    for number in lengths.into_iter().chain(charges) {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    sha256_hex(&bytes)
}

/// Bytes as people write them: `1.25 GB`, `37 MB`, `640 kB`.
pub fn in_units(bytes: u64) -> String {
    match bytes {
        1_000_000_000.. => format!("{:.2} GB", bytes as f64 * 1e-9),
        1_000_000.. => format!("{:.0} MB", bytes as f64 * 1e-6),
        _ => format!("{:.0} kB", bytes as f64 * 1e-3),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::bench::bodies::two_kinds;

    fn yukawa(debye_angstrom: f64) -> Yukawa {
        Yukawa::new(7.0, 1.0 / debye_angstrom, 60.0).unwrap()
    }

    #[test]
    fn equal_charges_under_one_potential_share_a_table() {
        let (types, again) = (two_kinds(3, 4, 1).unwrap(), two_kinds(3, 4, 1).unwrap());
        let tables = EnergyTables::default();
        let first = tables.of(&types, &yukawa(9.6)).unwrap();
        let second = tables.of(&again, &yukawa(9.6)).unwrap();
        assert!(first.iter().zip(&second).all(|(a, b)| Arc::ptr_eq(a, b)));
        assert!(!Arc::ptr_eq(&first[0], &first[1]));
        let other = tables.of(&types, &yukawa(3.0)).unwrap();
        assert!(!Arc::ptr_eq(&first[0], &other[0]));
    }

    #[test]
    fn what_is_in_use_is_bounded_and_the_rest_makes_room() {
        let types = two_kinds(3, 4, 1).unwrap();
        let size: usize =
            EnergyTables::default().of(&types, &yukawa(9.6)).unwrap().iter().map(|table| table.memory_bytes()).sum();
        let tables = EnergyTables::new(size as u64);
        let in_use = tables.of(&types, &yukawa(9.6)).unwrap();
        let message = tables.of(&types, &yukawa(9.5)).unwrap_err().to_string();
        assert!(message.contains("--memory-limit") && message.contains("--energy direct"), "{message}");
        drop(in_use);
        let tables = EnergyTables::new(size as u64 * 3 / 2);
        drop(tables.of(&types, &yukawa(9.6)).unwrap());
        tables.of(&types, &yukawa(9.5)).unwrap();
    }

    #[test]
    fn bytes_read_like_memory() {
        assert_eq!([in_units(1_250_000_000), in_units(37_200_000), in_units(640_000)], ["1.25 GB", "37 MB", "640 kB"]);
    }
}
