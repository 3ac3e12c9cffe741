//! How much memory there is, and how much of it has been asked for: what cannot fit is refused before it
//! is begun, and not hours later by the system.
//!
//! Estimates are made before the first allocation that grows with a film or a file, from sizes, headers and
//! counts. They leave out what is small beside that, so what is refused cannot fit; what is allowed may
//! still fail on a machine that has other things to do.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a compressed file may unpack to, if it is small.
const UNPACKED: u64 = 256 << 20;

/// What it may unpack to, in sizes of the file. Text and binary meshes are packed three- to tenfold.
const EXPANSION: u64 = 64;

/// Bounds on memory. Clones share what has been claimed.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    memory: Option<Arc<Account>>,
    /// The most bytes that a compressed file may unpack to; `None` for 64 times the file's size, or 256 MiB
    /// if that is more.
    pub unpacked: Option<u64>,
}

#[derive(Debug)]
struct Account {
    there: u64,
    claimed: AtomicU64,
}

/// More memory is needed than there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} of memory are needed at least, and there are {}", readable(*.needed), readable(*.there))]
pub struct OutOfMemory {
    /// Bytes that have been claimed in all.
    pub needed: u64,
    /// Bytes that there are.
    pub there: u64,
}

impl Limits {
    /// Limits for a process that may use so many bytes; `None` for any number.
    #[must_use]
    pub fn new(memory: Option<u64>, unpacked: Option<u64>) -> Self {
        let account = |there| Arc::new(Account { there, claimed: AtomicU64::new(0) });
        Self { memory: memory.map(account), unpacked }
    }

    /// Asks for so many bytes beside those that were claimed before. They are never given back: what is
    /// claimed is what stays to the end.
    ///
    /// # Errors
    /// There are fewer.
    pub fn claim(&self, bytes: u64) -> Result<(), OutOfMemory> {
        let Some(Account { there, claimed }) = self.memory.as_deref() else { return Ok(()) };
        let add = |sum: u64| Some(sum.saturating_add(bytes));
        let before = claimed.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add).unwrap_or(0);
        let needed = before.saturating_add(bytes);
        if needed > *there {
            return Err(OutOfMemory { needed, there: *there });
        }
        Ok(())
    }

    /// The most bytes that a compressed file of that size may unpack to.
    #[must_use]
    pub fn largest_unpacked(&self, compressed: u64) -> u64 {
        self.unpacked.unwrap_or(UNPACKED.max(compressed.saturating_mul(EXPANSION)))
    }
}

/// A number of bytes with three digits that count: `20.5 GB`.
#[must_use]
pub fn readable(bytes: u64) -> String {
    let mut value = bytes as f64;
    for unit in ["B", "kB", "MB", "GB", "TB"] {
        // What would be rounded to 1000 takes the next unit.
        if value < 999.5 {
            let decimals = if unit == "B" || value >= 99.95 { 0 } else { 1 };
            return format!("{value:.decimals$} {unit}");
        }
        value /= 1000.0;
    }
    format!("{value:.1} PB")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_have_three_digits() {
        for (count, text) in [
            (0, "0 B"),
            (999, "999 B"),
            (1000, "1.0 kB"),
            (99_949, "99.9 kB"),
            (99_950, "100 kB"),
            (999_499, "999 kB"),
            (999_500, "1.0 MB"),
            (20_500_000_000, "20.5 GB"),
            (1 << 44, "17.6 TB"),
            (u64::MAX, "18446.7 PB"),
        ] {
            assert_eq!(readable(count), text);
        }
    }

    #[test]
    fn what_is_claimed_adds_up() {
        let limits = Limits::new(Some(1000), None);
        let same = limits.clone();
        limits.claim(600).expect("there is room");
        same.claim(400).expect("there is room");
        let error = limits.claim(1).expect_err("full");
        assert_eq!(error, OutOfMemory { needed: 1001, there: 1000 });
        let told = "1.0 kB of memory are needed at least, and there are 1.0 kB";
        assert_eq!(error.to_string(), told);
        assert_eq!(same.claim(u64::MAX).expect_err("more than all").needed, u64::MAX);
        Limits::default().claim(u64::MAX).expect("no limit");
    }

    #[test]
    fn small_files_may_unpack_to_more_than_their_share() {
        let limits = Limits::default();
        assert_eq!(limits.largest_unpacked(3 << 20), 256 << 20);
        assert_eq!(limits.largest_unpacked(1 << 30), 64 << 30);
        assert_eq!(Limits::new(None, Some(7)).largest_unpacked(1 << 30), 7);
    }
}
