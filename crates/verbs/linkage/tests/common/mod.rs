//! A watcher of work: it keeps what it is told, and asks for a stop.

#![allow(dead_code)] // each test program uses its part

use protomer_results::{Execution, Interrupt, Progress};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// Keeps what it is told of some work, and asks for a stop when enough is done.
#[derive(Default)]
pub struct Watcher {
    /// Units in all.
    pub total: AtomicU64,
    /// Units done.
    pub done: AtomicU64,
    /// What was done, in order.
    pub described: Mutex<Vec<String>>,
    interrupt: Interrupt,
    /// Units, or descriptions, after which it asks for a stop.
    most: Option<u64>,
}

impl Watcher {
    /// Asks for a stop after so many units or descriptions.
    pub fn stopping_after(most: u64) -> Arc<Self> {
        Arc::new(Self {
            most: Some(most),
            ..Self::default()
        })
    }

    /// An execution that this watches.
    pub fn execution(self: &Arc<Self>) -> Execution {
        Execution {
            interrupt: self.interrupt.clone(),
            progress: Arc::clone(self) as Arc<dyn Progress>,
            ..Execution::default()
        }
    }

    fn stop_if_enough(&self, count: u64) {
        if self.most.is_some_and(|most| count >= most) {
            self.interrupt.request();
        }
    }
}

impl Progress for Watcher {
    fn begin(&self, total: u64, _unit: &'static str) {
        self.total.store(total, Ordering::Relaxed);
    }

    fn advance(&self, units: u64) {
        let done = self.done.fetch_add(units, Ordering::Relaxed) + units;
        self.stop_if_enough(done);
    }

    fn describe(&self, what: &str) {
        let mut described = self.described.lock().unwrap();
        described.push(what.to_owned());
        self.stop_if_enough(described.len() as u64);
    }
}
