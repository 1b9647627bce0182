//! `hemicube convergence` as its user meets it; and the two irradiance caches against each other.

use assert_cmd::Command;
use hemicube::image::metrics::{mask, measure};
use hemicube::image::{Picture, exr};
use hemicube::passes::resolve::Plane;
use hemicube::passes::splat::Weight;
use hemicube::reference::{Tracer, View, ward};
use hemicube::renderer::{Settings, render};
use hemicube::report::convergence::{COLUMNS, Point};
use hemicube::report::csv;
use hemicube::scene;
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::path::Path;
use std::time::SystemTime;

/// Exit code, standard output and standard error of `hemicube convergence` in the folder.
fn convergence(folder: &Path, arguments: &str) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hemicube"));
    let output = command.current_dir(folder).arg("convergence").args(arguments.split_whitespace()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn points(folder: &Path) -> Vec<Point> {
    let text = std::fs::read_to_string(folder.join("out/points.csv")).unwrap();
    csv::read(&text).unwrap().into_iter().map(|row| Point { row }).collect()
}

fn changed(folder: &Path, name: &str) -> SystemTime {
    std::fs::metadata(folder.join("out").join(name)).unwrap().modified().unwrap()
}

/// As an XML reader sees it: tags are closed in order. What stands in them is checked beside the writers.
fn assert_closed(xml: &str) {
    let mut open = Vec::new();
    for tag in xml.split('<').skip(1).map(|rest| rest.split('>').next().unwrap()) {
        let name = tag.trim_start_matches('/').split([' ', '\n']).next().unwrap();
        match tag.as_bytes() {
            [b'/', ..] => assert_eq!(open.pop(), Some(name)),
            [b'!', ..] | [.., b'/'] => (),
            _ => open.push(name),
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

const TINY: &str = "-o out --width 48 --height 48 --reference-time 1 --repeats 2";

#[test]
fn a_tiny_run_writes_everything_and_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let run = |more: &str| {
        let (code, out, error) = convergence(here, &format!("{TINY} {more}"));
        assert_eq!(code, 0, "{error}");
        (out, error)
    };
    let methods = "--methods splatting,path --accuracy 0.5 --capture-size 16 --spp 4";
    let (out, error) = run(methods);
    assert!(
        out.contains("2 points") && error.contains("1/2 splatting accuracy 0.5") && error.contains("1 left, about")
    );
    let first = points(here);
    assert_eq!(first.iter().map(|p| p.text("method")).collect::<Vec<_>>(), ["splatting", "path"]);
    for point in &first {
        assert!(point.row.keys().all(|column| COLUMNS.contains(&column.as_str())));
        for column in ["mae", "rms", "relmse", "p99", "energy", "block_mae", "wall_s", "host_bytes"] {
            assert!(point.number(column).is_some_and(|value| value > 0.0), "{column}: {:?}", point.text(column));
        }
        // Differences of two measured times: on so small a picture their sign is the machine's mood.
        assert!(point.number("indirect_wall_s").is_some() && point.number("indirect_cpu_s").is_some());
        assert_eq!((point.text("repeats"), point.text("width")), ("2", "48"));
        let picture = exr::read(&here.join("out").join(point.text("picture"))).unwrap();
        assert!(picture.rgb("irradiance").is_some());
    }
    assert!(first[0].number("records").unwrap() > 10.0 && first[0].number("device_bytes").unwrap() > 1e6);
    let passes: serde_json::Value = serde_json::from_str(first[0].text("passes_ms")).unwrap();
    assert!(["gbuffer", "splat", "integrate"].iter().all(|pass| passes[pass].as_f64().is_some_and(|ms| ms > 0.0)));
    for file in ["error-cpu.svg", "error-wall.svg", "index.html"] {
        let text = std::fs::read_to_string(here.join("out").join(file)).unwrap();
        assert_closed(&text);
        for (point, name) in first.iter().zip(["Irradiance splatting", "Path tracing"]) {
            let time = if file == "error-cpu.svg" { "indirect_cpu_s" } else { "indirect_wall_s" };
            // A logarithmic axis has no place for a time that is not positive; the page lists every point.
            let shown = file == "index.html" || point.number(time).is_some_and(|seconds| seconds > 0.0);
            assert!(!shown || text.contains(name), "{file}: {name}");
        }
    }
    let page = std::fs::read_to_string(here.join("out/index.html")).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("hemicube convergence -o out"), "{page}");

    // Nothing twice: not a point, not the reference; and a new point beside the old ones.
    let (table, reference) = (first.clone(), changed(here, "reference.exr"));
    let (_, error) = run(methods);
    assert!(!error.contains("1/"), "{error}");
    run(&methods.replace("--spp 4", "--spp 4,8"));
    let second = points(here);
    assert_eq!((second.len(), &second[..2], changed(here, "reference.exr")), (3, &table[..], reference));
    run("--fresh --methods path --spp 2");
    assert_eq!(points(here).len(), 1);

    // The folder is of one scene, view and size.
    let (code, _, error) = convergence(here, &format!("{} --methods path --spp 2", TINY.replace("48", "40")));
    assert!(code == 2 && error.contains("--fresh"), "{error}");
}

#[test]
fn peers_and_given_references_are_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut truth = Picture::new(24, 16);
    truth.insert_rgb("b1", vec![[0.1, 0.08, 0.05]; 384]);
    truth.insert_scalar("mask", (0..384).map(|i| if i < 300 { 1.0 } else { 0.0 }));
    exr::write(&here.join("truth.exr"), &truth, &[]).unwrap();
    let head = "scene,width,height,bounces,method,settings,threads,indirect_cpu_s,indirect_wall_s,mae,unknown";
    let row = |size: &str, peer: &str| format!("cornell,{size},1,{peer},\"{{\"\"spp\"\": 16}}\",1,2.5,2.5,0.05,x");
    let text = [head, &row("24,16", "mitsuba"), &row("24,16", "radiance"), &row("99,16", "mitsuba"), ""].join("\n");
    std::fs::write(here.join("peers.csv"), text).unwrap();
    let arguments = "-o out --reference truth.exr --methods path --spp 4 --repeats 1 --flip --peers peers.csv";
    for _ in 0..2 {
        let (code, _, error) = convergence(here, arguments);
        assert!(code == 0 && error.contains("1 of 3 points are of another"), "{error}");
        let points = points(here);
        assert_eq!(points.len(), 3, "peers' points are replaced, not doubled");
        assert!(points[0].number("flip").is_some() && points[0].text("reference") == "truth.exr");
    }
    let chart = std::fs::read_to_string(here.join("out/error-cpu.svg")).unwrap();
    assert!(chart.contains("Mitsuba 3 path, 1 thread") && chart.contains("Radiance, 1 thread"));
}

#[test]
fn bad_input_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let mut small = Picture::new(8, 8);
    small.insert_rgb("glow", vec![[1.0; 3]; 64]);
    exr::write(&folder.path().join("small.exr"), &small, &[]).unwrap();
    std::fs::write(folder.path().join("broken.csv"), "a,b\n1\n").unwrap();
    std::fs::write(folder.path().join("other.csv"), "a,b\n1,2\n").unwrap();
    for (arguments, part) in [
        ("nowhere.gltf -o out", "nowhere.gltf"),
        ("-o small.exr", "it is a file"),
        ("-o out --reference small.exr --width 9", "8 × 8"),
        ("-o out --reference small.exr", "it has glow"),
        ("-o out --reference none.exr", "none.exr"),
        ("-o out --peers broken.csv", "row 2"),
        ("-o out --peers other.csv", "no column \"scene\""),
        ("-o out --width 0", "0 × "),
        ("-o out --methods path,magic", "magic"),
        ("-o out --spp 0", "--spp"),
        ("-o out --width 8 --reference-time 0.1 --capture-size 7", "--capture-size 7"),
        ("-o out --accuracy nan", "--accuracy"),
    ] {
        let (code, out, error) = convergence(folder.path(), arguments);
        assert!(code == 2 && error.contains(part) && out.is_empty(), "{arguments}: {code} {error}");
    }
}

/// Ward's cache by rays on the CPU and splatting by rasterisation: other places for the records, other ways to see the
/// scene, the same light.
#[test]
fn both_caches_agree() {
    let scene = scene::cornell();
    let (camera, _) = scene.camera(None).unwrap();
    let side = 128;
    let mut settings = Settings { width: side, height: side, planes: vec![Plane::Irradiance], ..Settings::default() };
    let cache = &mut settings.cache;
    (cache.accuracy, cache.capture_size, cache.weight) = (0.2, 64, Weight::Bounded);
    let same = ward::Settings {
        accuracy: 0.2,
        rays: 4096,
        weight: ward::Weight::Bounded,
        gradients: ward::Gradients::Both,
        min_radius: (f64::from(cache.min_radius) * f64::from(side)).max(2.0),
        max_radius: f64::from(cache.max_radius) * f64::from(side),
        neighbour_clamping: false,
        ..ward::Settings::default()
    };
    let device = Device::new(Instance::new(false).unwrap(), &DeviceChoice::Best).unwrap();
    let splatted = render(&device, &scene, &camera, &settings, &mut |_, _, _| ()).unwrap().picture;
    let tracer = Tracer::new(&scene);
    let cached = hemicube::reference::ward(&tracer, View::new(&camera, side, side), &same, 1, |_, _| ()).picture;
    let mask = mask(cached.scalar("mask").unwrap());
    let layers = (splatted.layer("irradiance").unwrap(), cached.layer("irradiance").unwrap());
    let metrics = measure(&layers.0, &layers.1, side as usize, Some(&mask));
    let energy = metrics.energy.unwrap();
    eprintln!("splatting against Ward's cache: energy {energy:.4}, mean absolute difference {:.4}", metrics.mae);
    assert!((energy - 1.0).abs() <= 0.02, "means differ: {energy}");
    assert!(metrics.mae <= 0.02, "mean absolute difference {}", metrics.mae);
}
