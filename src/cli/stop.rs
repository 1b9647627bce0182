//! Ctrl-C and SIGTERM: a run that is stopped says what it keeps, and leaves no unfinished file.

use super::say::remark;
use hemicube::image::write::remove_unfinished;
use std::sync::{Mutex, PoisonError};

/// Exit code of a stopped run, that of shells for Ctrl-C.
const STOPPED: i32 = 130;

/// What a stopped run keeps.
static KEPT: Mutex<Option<String>> = Mutex::new(None);

/// Notes what the run would keep if it were stopped now: `the state in a.state`.
pub fn keeps(what: String) {
    *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(what);
}

/// Ends the program on these signals. Where they cannot be handled, the system ends it, and the next run removes what is left.
pub fn handle_signals() {
    let stop = || {
        remove_unfinished();
        match KEPT.lock().unwrap_or_else(PoisonError::into_inner).as_deref() {
            Some(kept) => remark!("stopped: {kept}"),
            None => remark!("stopped: nothing was written"),
        }
        std::process::exit(STOPPED);
    };
    let _ = ctrlc::set_handler(stop);
}
