//! Ctrl-C: asks for an end at first, and ends the process the second time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use telamon::film::output::remove_temporaries;

/// 128 plus the number of SIGINT, as shells have it.
pub(super) const EXIT_CODE: u8 = 130;

/// From now on Ctrl-C (and a polite `kill`) makes the returned value true instead of ending the process.
pub(super) fn watch() -> Result<Arc<AtomicBool>, ctrlc::Error> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&interrupted);
    ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            end_at_once();
        }
    })?;
    Ok(interrupted)
}

#[expect(clippy::exit, reason = "who asks twice wants no further work, not even an orderly return")]
fn end_at_once() {
    remove_temporaries();
    std::process::exit(i32::from(EXIT_CODE));
}
