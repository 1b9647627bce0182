//! Outputs that nobody reads, or that cannot be written.

use super::{folder, read_json};
use crate::common::program::unread;

/// Whoever reads what is said may stop at once, as `| head -0` does: nothing is said of it, and files are whole.
#[test]
fn what_nobody_reads_ends_no_run() {
    let size = "--width 16 --height 16 --background 1,1,1";
    let runs = [
        "--help",
        "render --help",
        "info",
        "info good.gltf",
        &format!("render good.gltf -v {size} -o out.exr --stats stats.json --trace trace.json"),
        &format!("reference good.gltf {size} --spp 4 -o truth.exr"),
        "compare out.exr truth.exr",
        "compare out.exr truth.exr --json -",
        "export good.gltf --width 16 --height 16 -o arrays",
        "convergence good.gltf -o plots --width 16 --height 16 --background 1,1,1 --methods path --spp 4 --reference-time 1",
    ];
    for neither in [false, true] {
        let folder = folder();
        let has = |name: &str| folder.path().join(name);
        for arguments in runs {
            let (code, said) = unread(folder.path(), arguments, neither);
            let failed = |line: &str| line.starts_with("error") || line.contains("panicked");
            assert!(code == Some(0) && !said.lines().any(failed), "{arguments}: {code:?} {said}");
        }
        for name in ["out.exr", "truth.exr"] {
            hemicube::image::exr::read(&has(name)).unwrap();
        }
        read_json(&has("stats.json"));
        read_json(&has("trace.json"));
        assert!(has("arrays").is_dir() && has("plots/index.html").is_file());
        // The exit code is the same, whoever hears why.
        assert_eq!(unread(folder.path(), "info none.gltf", neither).0, Some(2));
    }
}

/// What cannot be said for another reason is an error.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let folder = folder();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_hemicube"));
    let output = command.current_dir(folder.path()).args(["info", "good.gltf"]).stdout(full).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.lines().count() == 1, "{:?}: {said}", output.status);
    assert!(said.contains("cannot write the standard output"), "{said}");
}
