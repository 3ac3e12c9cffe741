//! Signals that ask for an end: the first one is obeyed in an orderly way, the second one at once.

use std::fs;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use telamon::film::output::remove_temporaries;

/// Ctrl-C, a polite `kill`, and the end of the terminal.
const ENDING: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// The first of them that came; 0 before. Signals are the process's, and so is this.
static FIRST: AtomicI32 = AtomicI32::new(0);

/// 128 plus the number of the signal that asked for the end, as shells have it.
pub(super) fn exit_code() -> u8 {
    // Where none came, only Ctrl-C can be meant.
    let signal = match FIRST.load(Ordering::Relaxed) {
        0 => SIGINT,
        signal => signal,
    };
    128 + signal as u8
}

/// From now on the first signal that asks for an end makes the returned value true instead of ending the
/// process. Those that were ignored when the process started (SIGHUP by `nohup`, SIGINT by a shell that
/// runs a script's job in the background) stay ignored.
pub(super) fn watch() -> io::Result<Arc<AtomicBool>> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let ignored = ignored(&fs::read_to_string("/proc/self/status").unwrap_or_default());
    let mut signals = Signals::new(ENDING.into_iter().filter(|&s| ignored >> (s - 1) & 1 == 0))?;
    let seen = Arc::clone(&interrupted);
    std::thread::spawn(move || {
        for signal in signals.forever() {
            if FIRST.swap(signal, Ordering::Relaxed) != 0 {
                end_at_once(signal);
            }
            // Who sees this sees the signal's number as well.
            seen.store(true, Ordering::Release);
        }
    });
    Ok(interrupted)
}

/// The signals that a process ignores, the lowest bit for signal 1, from its `/proc/…/status`; none where
/// there is no such file.
fn ignored(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok()).unwrap_or(0)
}

#[expect(clippy::exit, reason = "who asks twice wants no further work, not even an orderly return")]
fn end_at_once(signal: i32) {
    remove_temporaries();
    std::process::exit(128 + signal);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_says_what_is_ignored() {
        let status =
            "Name:\ttelamon\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000001003\nSigCgt:\t0";
        assert_eq!(ignored(status), 0x1003);
        assert!([SIGHUP, SIGINT].iter().all(|s| ignored(status) >> (s - 1) & 1 == 1));
        assert_eq!(ignored(status) >> (SIGTERM - 1) & 1, 0);
        assert_eq!(ignored(""), 0);
    }
}
