//! The tables of energies by levels and the comparisons of their levels: made once per kind of body and
//! potential, kept on the disk for the next run, shared by all threads of a run, and bounded in memory.

use crate::stability::disk_cache::DiskCache;
use anyhow::{Result, bail};
use protomer_kernel::potential::Yukawa;
use protomer_mc::energy::certified::{Cells, Certified};
use protomer_mc::energy::levels::{Calibration, Levels, Table, table_reach_angstrom};
use protomer_mc::{BodyType, McError, System};
use std::collections::HashMap;
use std::io::{Read, Write};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The table of one kind of body.
pub type PotentialTable = Table;

/// Memory that tables may take where no limit is stated, bytes.
pub const DEFAULT_MEMORY_LIMIT_BYTES: u64 = 4_000_000_000;

/// Store of energy tables.
#[derive(Debug)]
pub struct EnergyTables {
    memory_limit_bytes: u64,
    made: Mutex<Made>,
    disk: Option<Disk>,
    computed: AtomicUsize,
    loaded: AtomicUsize,
}

/// Tables on the disk.
#[derive(Debug)]
struct Disk {
    cache: DiskCache,
    warn: fn(&str),
    /// Whether the folder has refused a table: it takes none of the others, and is warned of once.
    refused: AtomicBool,
}

#[derive(Debug, Default)]
struct Made {
    /// Tables by the hash of what they are made of.
    tables: HashMap<String, Arc<PotentialTable>>,
    /// Cells by the hash of what they are made of; never on the disk, because a cell is made where
    /// a charge comes.
    cells: HashMap<String, Arc<Cells>>,
    /// Calibrations by the hash of the tables that are compared.
    calibrations: HashMap<String, Calibration>,
    /// Locks held while a table or a comparison is made, so that nobody makes it a second time and
    /// different ones are made side by side.
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
        let (made, computed, loaded) = Default::default();
        Self {
            memory_limit_bytes,
            made,
            disk: None,
            computed,
            loaded,
        }
    }

    /// The same store with a cache on the disk, where it looks first and keeps its tables. An entry
    /// that cannot be used or written stops nothing: `warn` is told, and the table is made.
    pub fn with_cache(self, cache: DiskCache, warn: fn(&str)) -> Self {
        Self {
            disk: Some(Disk {
                cache,
                warn,
                refused: AtomicBool::new(false),
            }),
            ..self
        }
    }

    /// Whether there are tables and all of them came from the disk.
    pub fn all_from_cache(&self) -> bool {
        self.computed.load(Ordering::Relaxed) == 0 && self.loaded.load(Ordering::Relaxed) > 0
    }

    /// The tables of these kinds of bodies under this potential, for partners as far away as
    /// `reach_angstrom`. Whoever asks for the same ones
    /// shares them; who asks while they are being made waits. Tables that nobody uses any more are
    /// kept while there is room.
    ///
    /// # Errors
    /// If those in use take more memory than is allowed: says how much is needed and what to do.
    pub fn tables(
        &self,
        types: &[Arc<BodyType>],
        yukawa: &Yukawa,
        reach_angstrom: f64,
    ) -> Result<Vec<Arc<PotentialTable>>> {
        let table = |kind: &Arc<BodyType>| self.table(kind, yukawa, reach_angstrom);
        // Threads of their own: each may wait for the lock
        // of another, and would hold up the common pool.
        std::thread::scope(|scope| {
            let jobs: Vec<_> = types
                .iter()
                .map(|kind| scope.spawn(move || table(kind)))
                .collect();
            let done = jobs.into_iter().zip(types);
            // A thread that could not finish is replaced by doing its work here.
            done.map(|(job, kind)| job.join().unwrap_or_else(|_| table(kind)))
                .collect()
        })
    }

    /// The model of energies by levels for this system, with its tables and the comparison of their
    /// levels from here.
    ///
    /// # Errors
    /// As [`tables`](Self::tables).
    pub fn levels(&self, system: &System, yukawa: Yukawa) -> Result<Levels> {
        let reach_angstrom = table_reach_angstrom(&yukawa, system);
        let tables = self.tables(system.types(), &yukawa, reach_angstrom)?;
        let calibration = self.calibration(system, &yukawa, reach_angstrom, &tables);
        Ok(Levels::with_calibration(yukawa, tables, calibration))
    }

    /// The model of energies with proven bounds for this system, with cells that all its models share.
    pub fn certified(&self, system: &System, yukawa: Yukawa) -> Certified {
        let reach_angstrom = Certified::cell_reach_angstrom(&yukawa, system);
        let cells = |kind: &Arc<BodyType>| {
            let key = PotentialTable::fingerprint(&kind.charges, &yukawa, reach_angstrom);
            let new = || Arc::new(Cells::new(&kind.charges, &yukawa, reach_angstrom));
            Arc::clone(locked(&self.made).cells.entry(key).or_insert_with(new))
        };
        let cells = system.types().iter().map(cells).collect();
        Certified::with_cells(yukawa, system, cells)
    }

    /// The comparison of the levels of these tables: made once, then from memory or from the disk.
    fn calibration(
        &self,
        system: &System,
        yukawa: &Yukawa,
        reach_angstrom: f64,
        tables: &[Arc<PotentialTable>],
    ) -> Calibration {
        let fingerprint = |index: usize| {
            let charges = &system.types()[index].charges;
            PotentialTable::fingerprint(charges, yukawa, reach_angstrom)
        };
        // By the placed bodies: the comparison depends on which kinds meet.
        let placed: Vec<String> = system.placed_types().into_iter().map(fingerprint).collect();
        let key = Calibration::fingerprint(&placed);
        // The lock of this entry is taken while the map's is free: others go on with other entries.
        let making = Arc::clone(locked(&self.made).making.entry(key.clone()).or_default());
        let _mine = locked(&making);
        // Somebody else may have made it while we waited for the lock.
        if let Some(calibration) = locked(&self.made).calibrations.get(&key) {
            return *calibration;
        }
        let calibration =
            self.load_or_compare(&key, || Calibration::of_system(yukawa, system, tables));
        locked(&self.made).calibrations.insert(key, calibration);
        calibration
    }

    fn load_or_compare(&self, key: &str, compare: impl FnOnce() -> Calibration) -> Calibration {
        let Some(disk) = &self.disk else {
            return compare();
        };
        let stored_calibration = disk.load(key, |file| Calibration::read_from(file, key));
        stored_calibration.unwrap_or_else(|| {
            let calibration = compare();
            disk.store(key, |file| calibration.write_to(file, key));
            calibration
        })
    }

    /// Memory of the tables and cells that are there now, bytes.
    pub fn memory_bytes(&self) -> usize {
        let made = locked(&self.made);
        let tables = made.tables.values().map(|table| table.memory_bytes());
        let cells = made.cells.values().map(|cells| cells.memory_bytes());
        tables.sum::<usize>() + cells.sum::<usize>()
    }

    fn table(&self, kind: &BodyType, yukawa: &Yukawa, reach: f64) -> Result<Arc<PotentialTable>> {
        let key = PotentialTable::fingerprint(&kind.charges, yukawa, reach);
        let making = Arc::clone(locked(&self.made).making.entry(key.clone()).or_default());
        let _mine = locked(&making);
        // As above: looked up again under the lock of this key.
        if let Some(table) = locked(&self.made).tables.get(&key) {
            return Ok(Arc::clone(table));
        }
        let table = Arc::new(self.load_or_make(&key, kind, yukawa, reach));
        // Kept last: a table that does not fit is refused, and nobody waits for it in vain.
        locked(&self.made).keep(key, &table, &kind.name, self.memory_limit_bytes)?;
        Ok(table)
    }

    fn load_or_make(
        &self,
        key: &str,
        kind: &BodyType,
        yukawa: &Yukawa,
        reach: f64,
    ) -> PotentialTable {
        let on_disk = self.disk.as_ref().and_then(|disk| {
            disk.load(key, |file| {
                PotentialTable::read_from(file, &kind.charges, yukawa, reach)
            })
        });
        if let Some(table) = on_disk {
            self.loaded.fetch_add(1, Ordering::Relaxed);
            return table;
        }
        let table = PotentialTable::new(&kind.charges, yukawa, reach);
        self.computed.fetch_add(1, Ordering::Relaxed);
        if let Some(disk) = &self.disk {
            disk.store(key, |file| table.write_to(file, key));
        }
        table
    }
}

impl Disk {
    fn load<T>(
        &self,
        key: &str,
        read: impl FnOnce(&mut dyn Read) -> Result<T, McError>,
    ) -> Option<T> {
        self.cache.load(key, read).unwrap_or_else(|error| {
            (self.warn)(&format!("warning: {error:#}; they are computed"));
            None
        })
    }

    fn store(&self, key: &str, write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) {
        if let Err(error) = self.cache.store(key, write)
            // `swap` tells whether this is the first refusal: one warning for the folder.
            && !self.refused.swap(true, Ordering::Relaxed)
        {
            (self.warn)(&format!(
                "warning: energy tables are not kept for the next run: {error:#}"
            ));
        }
    }
}

impl Made {
    /// Takes in a new table; if there is no room, drops those that only this map still holds.
    fn keep(
        &mut self,
        key: String,
        table: &Arc<PotentialTable>,
        body: &str,
        limit_bytes: u64,
    ) -> Result<()> {
        let size = |table: &Arc<PotentialTable>| table.memory_bytes() as u64;
        if self.tables.values().map(size).sum::<u64>() + size(table) > limit_bytes {
            // A count of one: only this map holds it, so no model loses its table.
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
    // What a panic left behind is a whole map: entries are inserted whole.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes as people write them: `1.25 GB`, `37 MB`, `640 kB`.
///
/// ```
/// use protomer_protein_verbs::stability::energy_tables::in_units;
/// assert_eq!([1_250_000_000, 37_000_000, 640_000].map(in_units), ["1.25 GB", "37 MB", "640 kB"]);
/// ```
pub fn in_units(bytes: u64) -> String {
    match bytes {
        1_000_000_000.. => format!("{:.2} GB", bytes as f64 * 1e-9),
        1_000_000.. => format!("{:.0} MB", bytes as f64 * 1e-6),
        _ => format!("{:.0} kB", bytes as f64 * 1e-3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::bench::bodies::two_kinds;
    use protomer_kernel::{Boundary, Pose, Vec3};

    fn yukawa(debye_angstrom: f64) -> Yukawa {
        Yukawa::uncut(7.0, 1.0 / debye_angstrom).unwrap()
    }

    #[test]
    fn equal_charges_under_one_potential_share_a_table() {
        let (types, again) = (two_kinds(3, 4, 1).unwrap(), two_kinds(3, 4, 1).unwrap());
        let tables = EnergyTables::default();
        let first = tables.tables(&types, &yukawa(9.6), 40.0).unwrap();
        let second = tables.tables(&again, &yukawa(9.6), 40.0).unwrap();
        assert!(first.iter().zip(&second).all(|(a, b)| Arc::ptr_eq(a, b)));
        assert!(!Arc::ptr_eq(&first[0], &first[1]));
        let other = tables.tables(&types, &yukawa(3.0), 40.0).unwrap();
        assert!(!Arc::ptr_eq(&first[0], &other[0]));
    }

    #[test]
    fn tables_come_back_from_the_disk() {
        let folder = tempfile::tempdir().unwrap();
        let types = two_kinds(3, 4, 1).unwrap();
        let tables = || {
            EnergyTables::default()
                .with_cache(DiskCache::new(folder.path()), |line| panic!("{line}"))
        };
        let (cold, warm) = (tables(), tables());
        let made = cold.tables(&types, &yukawa(9.6), 40.0).unwrap();
        assert!(!cold.all_from_cache());
        assert_eq!(warm.tables(&types, &yukawa(9.6), 40.0).unwrap(), made);
        assert!(warm.all_from_cache());
        warm.tables(&types, &yukawa(9.5), 40.0).unwrap();
        assert!(!warm.all_from_cache());
    }

    #[test]
    fn comparisons_of_levels_come_back_from_memory_and_from_the_disk() {
        let folder = tempfile::tempdir().unwrap();
        let types = two_kinds(3, 4, 1).unwrap();
        let apart = Pose {
            position: Vec3::new(60.0, 0.0, 0.0),
            ..Pose::identity()
        };
        let bodies = [(0, Pose::identity()), (1, apart)];
        let system = System::new(types, &bodies, Boundary::Open).unwrap();
        let tables = || {
            EnergyTables::default()
                .with_cache(DiskCache::new(folder.path()), |line| panic!("{line}"))
        };
        let report = |tables: &EnergyTables| {
            let levels = tables.levels(&system, yukawa(9.6)).unwrap();
            levels.calibration()
        };
        let entries = || folder.path().read_dir().unwrap().count();
        let (cold, warm) = (tables(), tables());
        let made = report(&cold);
        assert!(made.poses > 0);
        // Two tables and their comparison.
        assert_eq!(entries(), 3);
        assert_eq!(report(&cold), made);
        assert_eq!(report(&warm), made);
        assert_eq!(entries(), 3);
        assert!(warm.all_from_cache());
    }

    #[test]
    fn a_folder_that_takes_nothing_stops_nothing() {
        static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "no folder").unwrap();
        let cache = DiskCache::new(file.join("cache"));
        let tables = EnergyTables::default()
            .with_cache(cache, |line| locked(&WARNINGS).push(line.to_owned()));
        tables
            .tables(&two_kinds(3, 4, 1).unwrap(), &yukawa(9.6), 40.0)
            .unwrap();
        let warnings = locked(&WARNINGS).clone();
        assert!(
            warnings.iter().any(|line| line.contains("are not kept")),
            "{warnings:?}"
        );
        assert!(
            warnings.iter().all(|line| line.contains("file")),
            "{warnings:?}"
        );
    }

    #[test]
    fn what_is_in_use_is_bounded_and_the_rest_makes_room() {
        let types = two_kinds(3, 4, 1).unwrap();
        let size: usize = EnergyTables::default()
            .tables(&types, &yukawa(9.6), 40.0)
            .unwrap()
            .iter()
            .map(|table| table.memory_bytes())
            .sum();
        let tables = EnergyTables::new(size as u64);
        let in_use = tables.tables(&types, &yukawa(9.6), 40.0).unwrap();
        let message = tables
            .tables(&types, &yukawa(9.5), 40.0)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("--memory-limit") && message.contains("--energy direct"),
            "{message}"
        );
        drop(in_use);
        let tables = EnergyTables::new(size as u64 * 3 / 2);
        drop(tables.tables(&types, &yukawa(9.6), 40.0).unwrap());
        tables.tables(&types, &yukawa(9.5), 40.0).unwrap();
    }

    #[test]
    fn bytes_read_like_memory() {
        assert_eq!(
            [
                in_units(1_250_000_000),
                in_units(37_200_000),
                in_units(640_000)
            ],
            ["1.25 GB", "37 MB", "640 kB"]
        );
    }
}
