//! The stability suite: records against closed forms and at the extremes, on the device, through the real passes.
//!
//! The rows are those of `hemicube convergence --stability`. What needs a whole image is in `frames`.

mod frames;

use crate::common::gpu;
use hemicube::methods::captures::CaptureMode;
use hemicube::methods::probes::ProbeError;
use hemicube::report::stability::{Bench, GROUPS, KINDS, Kind, Row, closed_forms, evaluate};
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::sync::Arc;

/// Runs `measure` with every kind of capture that `name` concerns; a validation message fails the test.
fn checked(name: &str, measure: impl Fn(&Bench) -> Result<Vec<Row>, ProbeError>) -> Vec<Row> {
    let kinds: Vec<_> = KINDS.iter().filter(|kind| kind.covers(name)).collect();
    checked_on(&gpu(), &kinds, measure)
}

fn checked_on(
    device: &Arc<Device>,
    kinds: &[&Kind],
    measure: impl Fn(&Bench) -> Result<Vec<Row>, ProbeError>,
) -> Vec<Row> {
    let before = device.instance.validation_messages();
    let rows: Vec<Row> = kinds.iter().flat_map(|kind| kind.rows(device, &measure).unwrap()).collect();
    assert_eq!(device.instance.validation_messages() - before, 0, "validation messages; they are printed above");
    assert!(!rows.is_empty());
    for row in &rows {
        let order = row.order().map_or_else(String::new, |order| format!(", order {order:.2}"));
        let Row { capture, case, quantity, expected, got, errors, .. } = row;
        let mark = if row.holds() { "" } else { "  <-- out of bounds" };
        let errors: Vec<String> = errors.iter().map(|(size, error)| format!("{size}: {error:.1e}")).collect();
        let (errors, limit) = (errors.join(", "), row.tolerance());
        eprintln!(
            "{capture}, {case}: {quantity} {got:.6} for {expected:.6}; {errors}, at most {limit:.1e}{order}{mark}"
        );
    }
    let failed: Vec<_> =
        rows.iter().filter(|row| !row.holds()).map(|r| format!("{}, {}: {}", r.capture, r.case, r.quantity)).collect();
    assert!(failed.is_empty(), "out of bounds: {failed:#?}");
    rows
}

/// Errors above this at the coarsest capture are those of texels, not of facets or rounding.
const OF_TEXELS: f64 = 2e-3;

fn case(name: &str) {
    let case = closed_forms().into_iter().find(|case| case.name == name).unwrap();
    let rows = checked(name, |bench| evaluate(bench, &case));
    let texels = rows.iter().filter(|row| row.errors[0].1 > OF_TEXELS);
    let orders: Vec<f64> = texels.filter_map(Row::order).collect();
    if orders.len() > 2 {
        let mean = orders.iter().sum::<f64>() / orders.len() as f64;
        eprintln!("{name}: errors fall with the texel's width to the power {mean:.2} in the mean of {}", orders.len());
        assert!(mean > 1.0, "{name}: order {mean} of convergence");
    }
}

fn group(name: &str) {
    let (_, measure) = GROUPS.into_iter().find(|(group, _)| *group == name).unwrap();
    let _ = checked(name, measure);
}

macro_rules! rows {
    ($of:ident: $($test:ident = $name:literal),* $(,)?) => {
        const _: &[&str] = &[$($name),*];
        $(#[test] fn $test() { $of($name); })*
    };
}

rows!(case:
    rectangle = "rectangle",
    rectangle_ahead = "rectangle ahead",
    polygon = "polygon",
    parallel_plates = "parallel plates",
    sphere_light = "sphere light",
    integrating_sphere = "integrating sphere",
    wall = "wall",
    perpendicular_wall = "perpendicular wall",
    wedge_5 = "wedge of 5°",
    wedge_45 = "wedge of 45°",
    wedge_90 = "wedge of 90°",
    wedge_135 = "wedge of 135°",
    wedge_175 = "wedge of 175°",
    furnace = "furnace",
    linear_sky = "linear sky",
    half_a_sky = "half a sky",
);

rows!(group:
    cube_faces = "cube faces",
    cornell_gradients = "Cornell gradients",
    world_by_powers_of_two = "world × 2^k",
    emission_by_powers_of_two = "emission × 2^k",
    scales = "scale",
    far_origin = "far origin",
    radiance_range = "radiance 10⁶ : 1",
    near_black = "near-black",
    thin_wall = "thin wall",
    two_rooms = "two rooms",
    needles = "needles",
    bad_triangles = "bad triangles",
    one_texel_light = "one-texel light",
    slit = "slit",
);

/// By whole workgroups, which capture where subgroups cannot talk to each other.
#[test]
fn cornell_gradients_by_workgroups() {
    let (_, measure) = GROUPS.into_iter().find(|(group, _)| *group == "Cornell gradients").unwrap();
    let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    Arc::get_mut(&mut device).unwrap().capabilities.subgroup = None;
    let compute: Vec<_> = KINDS.iter().filter(|kind| kind.mode == CaptureMode::Compute).collect();
    let _ = checked_on(&device, &compute, measure);
}

/// No case and no group is left out above.
#[test]
fn every_row_is_tested() {
    let source = include_str!("mod.rs");
    let names = closed_forms().into_iter().map(|c| c.name).chain(GROUPS.into_iter().map(|(name, _)| name));
    let missing: Vec<_> = names.filter(|name| !source.contains(&format!("= \"{name}\""))).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
