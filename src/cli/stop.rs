//! Ctrl-C and SIGTERM: a run that is stopped says what it keeps, and leaves no unfinished file.

use super::say::remark;
use hemicube::image::write::remove_unfinished;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Exit code of a stopped run, that of shells for Ctrl-C.
const STOPPED: i32 = 130;

/// What a stopped run keeps: pictures or states, and records.
static KEPT: Mutex<[Option<String>; 2]> = Mutex::new([None, None]);

/// Notes what the run would keep if it were stopped now: `the state in a.state`.
pub fn keeps(what: String) {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)[0] = Some(what);
}

/// Notes the records that it would keep.
pub fn keeps_records(what: String) {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)[1] = Some(what);
}

/// Whether a first signal lets the run end by itself.
static MAY_FINISH: AtomicBool = AtomicBool::new(false);
/// Whether it came.
static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on, or no longer, the run ends soon by itself when it is stopped: a second signal ends it at once.
pub fn finishes(may: bool) {
    MAY_FINISH.store(may, Ordering::Relaxed);
}

/// Whether the run is to end.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Ends the program on these signals. Where they cannot be handled, the system ends it, and the next run removes what is left.
pub fn handle_signals() {
    let stop = || {
        if MAY_FINISH.load(Ordering::Relaxed) && !ASKED.swap(true, Ordering::Relaxed) {
            remark!("stopping: the picture is made of what there is; a second signal stops at once");
            return;
        }
        remove_unfinished();
        let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        match kept.iter().flatten().map(String::as_str).collect::<Vec<_>>().join("; ").as_str() {
            "" => remark!("stopped: nothing was written"),
            kept => remark!("stopped: {kept}"),
        }
        std::process::exit(STOPPED);
    };
    let _ = ctrlc::set_handler(stop);
}
