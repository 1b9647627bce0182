//! Ctrl-C, SIGTERM and `--time-limit`.

use super::{folder, names, read_json};
use crate::common::program::hemicube;
use hemicube::image::exr;
use hemicube::image::metrics::{mask, measure};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const LONG: &str = "render -o new.exr --width 640 --height 640 --accuracy 0.02 --min-radius 0.002";

/// Runs `arguments`, and sends `signals` after `delay`, when the run is not done yet.
fn stopped(folder: &Path, arguments: &str, signals: &[&str], delay: Duration) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemicube"));
    command.current_dir(folder).args(arguments.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    for signal in signals {
        std::thread::sleep(delay);
        assert!(child.try_wait().unwrap().is_none(), "{arguments}: done before it is stopped");
        assert!(Command::new("kill").arg(signal).arg(child.id().to_string()).status().unwrap().success());
    }
    child.wait_with_output().unwrap()
}

#[test]
fn a_stopped_run_says_what_it_keeps_and_leaves_nothing_else() {
    let folder = folder();
    let before = names(folder.path());
    // Until the first half minute is over, a reference has saved nothing.
    let long = "reference -o new.exr --width 64 --height 64 --time 600 --resume new.state";
    for signal in ["-INT", "-TERM"] {
        let run = stopped(folder.path(), long, &[signal], Duration::from_millis(800));
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.code() == Some(130) && said.ends_with("stopped: nothing was written\n"), "{said}");
        assert_eq!(names(folder.path()), before);
    }
    // A second signal does not wait for the picture.
    let large = "render -o new.exr --width 4096 --height 4096 --accuracy 0.02";
    let run = stopped(folder.path(), large, &["-INT", "-TERM"], Duration::from_millis(900));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.code() == Some(130) && said.ends_with("stopped: nothing was written\n"), "{said}");
    assert_eq!(names(folder.path()), before);
}

#[test]
fn a_render_that_is_stopped_makes_its_picture_of_what_there_is() {
    let folder = folder();
    let run = stopped(folder.path(), &format!("{LONG} --stats s.json"), &["-INT"], Duration::from_millis(1500));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.code() == Some(0) && said.contains("stopping: the picture is made of what there is"), "{said}");
    assert!(said.contains("note: stopped before all records were placed"), "{said}");
    assert_eq!(read_json(&folder.path().join("s.json"))["unfinished"], true);
    let picture = exr::read(&folder.path().join("new.exr")).unwrap();
    assert!(picture.non_finite().is_empty() && picture.rgb("").unwrap()[0].iter().any(|red| *red > 0.0));
}

/// The picture of less time is complete, and worse than that of all records.
#[test]
fn a_picture_in_a_given_time_is_complete_and_gets_better() {
    let folder = folder();
    let common = "--width 128 --height 128 --layers irradiance,mask,N --stats s.json";
    let render = |rest: &str| {
        let run = hemicube(folder.path(), &format!("render {common} {rest}"));
        assert_eq!(run.code, 0, "{run:?}");
        let stats = read_json(&folder.path().join("s.json"));
        (stats["unfinished"].as_bool().unwrap(), stats["records"].as_u64().unwrap(), run.err)
    };
    let (unfinished, all, _) = render("-o all.exr --time-limit 1e9");
    assert!(!unfinished);
    let (unfinished, few, said) = render("-o few.exr --time-limit 1e-3 --batch 200 --cache r.bin");
    assert!(unfinished && few > 0 && few < all && said.contains("is made of"), "{few} of {all}: {said}");
    assert!(!folder.path().join("r.bin").exists(), "records of a picture that is not finished are not kept");
    let read = |name: &str| exr::read(&folder.path().join(name)).unwrap();
    let (whole, part) = (read("all.exr"), read("few.exr"));
    let keep = mask(whole.scalar("mask").unwrap());
    let [a, b] = [&whole, &part].map(|picture| picture.layer("irradiance").unwrap());
    let bare = (0..keep.len()).filter(|i| keep[*i] && b.channels.iter().all(|channel| channel[*i] == 0.0)).count();
    assert_eq!(bare, 0, "pixels without light");
    let error = measure(&b, &a, 128, Some(&keep)).mae;
    eprintln!("{few} of {all} records: {error:.3} off");
    assert!(error > 0.01 && error < 0.5, "{error}");
}

/// A sequence that is killed again and again comes to the frames of one that was not.
#[test]
fn a_sequence_that_is_killed_goes_on_where_it_was() {
    let folder = folder();
    let walk = r#"{"keys": [{"time": 0, "eye": [0.28, 0.27, -0.8], "target": [0.28, 0.27, 0]},
        {"time": 5, "eye": [0.4, 0.27, -0.7], "target": [0.28, 0.27, 0]}]}"#;
    std::fs::write(folder.path().join("w.json"), walk).unwrap();
    let common = "render --frames 0-5 --fps 1 --walk w.json --width 48 --height 48 --surface-cells 4000";
    let run = |rest: &str| {
        let run = hemicube(folder.path(), &format!("{common} {rest}"));
        assert_eq!(run.code, 0, "{run:?}");
        run
    };
    let said = run("-o two.exr --time-limit 1e-3").out;
    assert!(said.contains("stopped before frame 0") && !folder.path().join("two.0000.exr").exists(), "{said}");
    let whole = run("-o one.exr --cache one.bin");
    let arguments = format!("{common} -o two.exr --resume --cache two.bin");
    let mut kills = 0;
    while !folder.path().join("two.0005.exr").exists() && kills < 100 {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hemicube"));
        command.current_dir(folder.path()).args(arguments.split_whitespace());
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(whole.time.mul_f64(0.15 + 0.02 * f64::from(kills)));
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
    }
    eprintln!("{kills} kills");
    assert!(kills > 1);
    run("-o two.exr --resume --cache two.bin");
    let file = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    for frame in 0..6 {
        assert!(file(&format!("one.{frame:04}.exr")) == file(&format!("two.{frame:04}.exr")), "frame {frame}");
    }
    assert!(file("one.bin") == file("two.bin"));
    assert!(run("-o one.exr --resume").out.contains("6 frames were there already"));
    let png = hemicube(folder.path(), &format!("{common} -o one.png --resume"));
    assert!(png.code == 2 && png.err.contains("--exposure STOPS"), "{png:?}");
}
