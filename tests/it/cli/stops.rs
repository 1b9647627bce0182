//! Ctrl-C and SIGTERM.

use super::{folder, names};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Runs `arguments`, and sends `signal` after `delay`, when the run is not done yet.
fn stopped(folder: &Path, arguments: &str, signal: &str, delay: Duration) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemicube"));
    command.current_dir(folder).args(arguments.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    std::thread::sleep(delay);
    assert!(child.try_wait().unwrap().is_none(), "{arguments}: done before it is stopped");
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[test]
fn a_stopped_run_says_what_it_keeps_and_leaves_nothing_else() {
    let folder = folder();
    let before = names(folder.path());
    for signal in ["-INT", "-TERM"] {
        let large = "render -o new.exr --width 1600 --height 1600 --accuracy 0.05";
        let run = stopped(folder.path(), large, signal, Duration::from_millis(1500));
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.code() == Some(130) && said.ends_with("stopped: nothing was written\n"), "{said}");
        assert!(run.stdout.is_empty() && names(folder.path()) == before, "{:?}", names(folder.path()));
    }
    // Until the first half minute is over, a reference has saved nothing.
    let long = "reference -o new.exr --width 64 --height 64 --time 600 --resume new.state";
    let run = stopped(folder.path(), long, "-INT", Duration::from_millis(800));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.code() == Some(130) && said.ends_with("stopped: nothing was written\n"), "{said}");
    assert_eq!(names(folder.path()), before);
}
