//! `hemicube reference` as its user meets it.

use assert_cmd::Command;
use hemicube::image::exr;
use std::path::Path;

fn reference(arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("hemicube").expect("cargo builds the command").arg("reference").args(arguments).assert()
}

/// The one line on the error output of a run that fails by its input.
fn fails(arguments: &[&str]) -> String {
    let output = reference(arguments).code(2).get_output().clone();
    String::from_utf8(output.stderr).expect("messages are UTF-8")
}

fn text(path: &Path) -> String {
    path.to_str().expect("temporary folders have plain names").to_owned()
}

#[test]
fn the_built_in_box_with_all_layers() {
    let folder = tempfile::tempdir().unwrap();
    let (out, stats) = (text(&folder.path().join("box.exr")), text(&folder.path().join("box.json")));
    let small = ["--width", "16", "--spp", "8", "--bounces", "all"];
    let run = reference(&[&["-o", &out, "--stats", &stats], &small[..]].concat()).success();
    let told = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    assert!(told.contains("16 × 16") && told.contains("M rays a CPU second"), "{told}");
    let picture = exr::read(Path::new(&out)).unwrap();
    for layer in ["", "direct", "indirect", "irradiance", "b3plus", "stderr.irradiance", "albedo", "emission"] {
        assert!(picture.rgb(layer).is_some(), "{layer} is missing");
    }
    assert!(picture.xyz("N").is_some() && picture.scalar("Z").is_some() && picture.scalar("mask").is_some());
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(stats).unwrap()).unwrap();
    assert_eq!((stats["method"].as_str(), stats["spp"].as_u64()), (Some("path"), Some(8)));
    assert!(stats["rays"].as_u64().unwrap() > 0 && stats["wall_ms"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_run_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| text(&folder.path().join(name));
    let (out, state) = (file("a.exr"), file("a.state"));
    let run = |spp: &str, out: &str, state: &str| {
        reference(&["-o", out, "--width", "12", "--spp", spp, "--resume", state, "-q"]).success();
        exr::read(Path::new(out)).unwrap()
    };
    run("16", &out, &state);
    assert_eq!(run("32", &out, &state), run("32", &file("b.exr"), &file("b.state")));
    let message = fails(&["-o", &out, "--width", "13", "--spp", "16", "--resume", &state]);
    assert!(message.contains("another scene, view"), "{message}");
}

#[test]
fn the_cache_draws_its_records() {
    let folder = tempfile::tempdir().unwrap();
    let (exr_out, png_out) = (text(&folder.path().join("ward.exr")), text(&folder.path().join("ward.png")));
    let settings = ["--method", "ward", "--width", "24", "--rays", "32", "--spp", "4", "--show", "records", "-q"];
    for out in [&exr_out, &png_out] {
        reference(&[&["-o", out.as_str()], &settings[..]].concat()).success();
    }
    assert!(exr::read(Path::new(&exr_out)).unwrap().scalar("records").is_some());
    assert!(std::fs::read(&png_out).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn bad_input_is_one_clear_line_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = text(&folder.path().join("out.exr"));
    let o = out.as_str();
    for (arguments, part) in [
        (&["nowhere.gltf", "-o", o][..], "nowhere.gltf"),
        (&["-o", "out.jpg"], "neither .exr nor .png"),
        (&["-o", o, "--method", "ward", "--bounces", "0"], "--bounces 1"),
        (&["-o", o, "--show", "records"], "--method ward"),
        (&["-o", o, "--method", "ward", "--time", "3"], "--method path alone"),
        (&["-o", o, "--camera", "7"], "no camera \"7\""),
        (&["-o", o, "--width", "0"], "0 × "),
        (&["-o", o, "--background", "1,2"], "1,2"),
        (&["-o", o, "--bounces", "many"], "neither a number nor all"),
        (&["-o", o, "--relative-error=-1"], "-1 is not above 0"),
        (&["-o", "no/such/folder/out.exr"], "no folder"),
        (&["-o", o, "--threads", "0"], "--threads 0"),
    ] {
        let message = fails(arguments);
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert!(!Path::new(&out).exists(), "{arguments:?} leaves a file");
    }
}
