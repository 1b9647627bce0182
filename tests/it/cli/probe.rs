//! `hemicube probe`: its result's shape, and bad input.

use super::{assert_refused, folder, names};
use crate::common::program::hemicube;
use serde_json::Value;
use std::path::Path;

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

fn result(folder: &Path, name: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["points"].as_array().unwrap().clone()
}

#[test]
fn probes_have_coefficients_and_six_irradiances() {
    let folder = folder();
    write(folder.path(), "points.json", "{\"points\": [[0.2, 0.3, 0.2], [0.4, 0.1, 0.3]]}");
    let orders = [2, 4].map(|order| {
        let run = hemicube(folder.path(), &format!("probe --points points.json -o out.json --order {order}"));
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.out.contains("2 points"), "{run:?}");
        result(folder.path(), "out.json")
    });
    for (order, points) in [4, 16].into_iter().zip(&orders) {
        assert_eq!(points.len(), 2);
        for point in points {
            assert_eq!(point["sh"].as_array().unwrap().len(), order);
            assert_eq!(point["irradiance"].as_array().unwrap().len(), 6);
            assert!(point["sh"][0][0].as_f64().unwrap() > 0.0);
        }
    }
    // A higher order adds coefficients, and changes nothing else.
    for (low, high) in orders[0].iter().zip(&orders[1]) {
        assert_eq!(low["sh"].as_array().unwrap()[..], high["sh"].as_array().unwrap()[..4]);
        assert_eq!(low["irradiance"], high["irradiance"]);
    }
}

#[test]
fn bad_probes_are_one_line_and_leave_nothing() {
    let folder = folder();
    write(folder.path(), "points.json", "{\"points\": [[0.2, 0.3, 0.2]]}");
    write(folder.path(), "torn.json", "{\"points\": [[0.2, 0.3");
    write(folder.path(), "none.json", "{\"points\": []}");
    write(folder.path(), "far.json", "{\"points\": [[0.2, 0.3, 0.2], [90, 0, 0]]}");
    let before = names(folder.path());
    for (arguments, code, words) in [
        ("--points points.json -o out.json --order 7", 2, "--order 7"),
        ("--points points.json -o out.json --order 1", 2, "from 2 to 6"),
        ("--points points.json -o out.json --capture-size 9", 2, "--capture-size 9"),
        ("--points torn.json -o out.json", 2, "torn.json"),
        ("--points none.json -o out.json", 2, "empty"),
        ("--points far.json -o out.json", 2, "points[1] = [90, 0, 0]"),
        ("--points gone.json -o out.json", 2, "gone.json"),
        ("--points points.json -o no/out.json", 2, "no/out.json"),
        ("--points points.json -o out.json --device 99", 3, "99"),
    ] {
        assert_refused(&hemicube(folder.path(), &format!("probe {arguments}")), code, words);
        assert_eq!(names(folder.path()), before, "{arguments} leaves something behind");
    }
}
