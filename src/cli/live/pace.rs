//! How often a viewer gets something new.

use std::time::{Duration, Instant};

/// At most four times a second.
const LEAST: Duration = Duration::from_millis(250);
/// And never more than one part in so many of a thread's time.
const SHARE: u32 = 50;

/// When the next update may come.
#[derive(Debug)]
pub(super) struct Pace {
    next: Instant,
}

impl Pace {
    pub(super) fn new() -> Self {
        Self { next: Instant::now() }
    }

    /// Time until the next update.
    pub(super) fn left(&self) -> Duration {
        self.next.saturating_duration_since(Instant::now())
    }

    /// After an update that began at `begin` and took so much work.
    pub(super) fn worked(&mut self, begin: Instant, work: Duration) {
        self.next = begin + LEAST.max(work * SHARE);
    }

    /// After a failure: not before so much time is over.
    pub(super) fn pause(&mut self, time: Duration) {
        self.next = Instant::now() + time;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_much_to_do_waits_longer() {
        let mut pace = Pace::new();
        assert_eq!(pace.left(), Duration::ZERO);
        let begin = Instant::now() + Duration::from_secs(1000);
        for (work, interval) in [(0, 250), (5, 250), (6, 300), (100, 5000)] {
            pace.worked(begin, Duration::from_millis(work));
            assert_eq!(pace.next - begin, Duration::from_millis(interval));
        }
    }
}
