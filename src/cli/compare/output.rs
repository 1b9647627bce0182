//! The table, the JSON file and the difference picture.

use super::{CompareArgs, Compared};
use crate::cli::say::say;
use anyhow::Result;
use hemicube::image::metrics::{Metrics, difference_map};
use hemicube::image::{png, write::write_atomic};
use hemicube::report::table::{Table, percent};
use serde_json::{Value, json};
use std::path::Path;

/// Writes whatever the arguments ask for.
pub fn write(args: &CompareArgs, compared: &[Compared], size: (u32, u32), mask: Option<&[bool]>) -> Result<()> {
    if let (Some(path), [layer]) = (&args.diff, compared) {
        let mean = layer.metrics.mean_reference;
        let map = difference_map(&layer.pair.test_layer(), &layer.pair.reference_layer(), mask, mean);
        png::write_false_colour(path, size.0, size.1, &map, args.diff_top)?;
    }
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    match &args.json {
        Some(_) if to_stdout => say!("{:#}", json(args, compared, size)),
        Some(path) => write_atomic(path, |sink| writeln!(sink, "{:#}", json(args, compared, size)))?,
        None => (),
    }
    if !to_stdout {
        say!("{}", text(args, compared, size, mask));
    }
    Ok(())
}

fn text(args: &CompareArgs, compared: &[Compared], (width, height): (u32, u32), mask: Option<&[bool]>) -> String {
    let kept =
        mask.map_or(String::new(), |mask| format!(", {} within the mask", mask.iter().filter(|&&kept| kept).count()));
    let mut out = format!("{} against {}\n", args.test.display(), args.reference.display());
    out += &format!("{width} × {height} pixels{kept}\n\n{}", table(compared));
    for layer in compared {
        let Metrics { non_finite_test: test, non_finite_reference: reference, .. } = layer.metrics;
        if test + reference > 0 {
            out += &format!(
                "\n{}: NaN or infinite in {test} pixels of the test, {reference} of the reference",
                layer.pair.name
            );
        }
        if let Some(line) = verdict(args, layer) {
            out += &format!("\n{line}");
        }
    }
    out.trim_end().to_owned()
}

fn table(compared: &[Compared]) -> Table {
    let heads = ["layer", "mean", "mae", "rms", "relmse", "p95", "p99", "max", "energy", "4×4 mae", "flip"];
    let mut table = Table::new(&heads);
    for Compared { pair, metrics: m, .. } in compared {
        let cells = [
            pair.name.clone(),
            significant(m.mean_reference),
            percent(m.mae),
            percent(m.rms),
            significant(m.relmse),
            percent(m.p95),
            percent(m.p99),
            percent(m.max),
            m.energy.map_or("–".into(), |energy| format!("{energy:.4}")),
            percent(m.block_mae),
            m.flip.map_or("–".into(), |flip| format!("{flip:.4}")),
        ];
        table.row(cells);
    }
    table
}

/// Four significant digits.
fn significant(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 7) as usize;
        return if value == 0.0 { "0".into() } else { format!("{value:.digits$}") };
    }
    format!("{value:.3e}")
}

fn verdict(args: &CompareArgs, layer: &Compared) -> Option<String> {
    let ((figure, passed), threshold) = (layer.verdict?, args.threshold?);
    let (name, metric) = (&layer.pair.name, args.metric.name());
    Some(match (passed, figure <= threshold) {
        (true, _) => format!("passed: {name}: {metric} {} ≤ {threshold}", significant(figure)),
        (false, false) => format!("FAILED: {name}: {metric} {} > {threshold}", significant(figure)),
        (false, true) => format!("FAILED: {name}: there are values that are no numbers"),
    })
}

fn json(args: &CompareArgs, compared: &[Compared], (width, height): (u32, u32)) -> Value {
    let layer = |layer: &Compared| {
        let mut value = json!({"layer": layer.pair.name, "passed": layer.verdict.map(|(_, passed)| passed)});
        if let (Value::Object(value), Ok(Value::Object(figures))) = (&mut value, serde_json::to_value(&layer.metrics)) {
            value.extend(figures);
        }
        value
    };
    let threshold = args.threshold.map(|value| json!({"metric": args.metric.name(), "value": value}));
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "test": args.test.to_string_lossy(),
        "reference": args.reference.to_string_lossy(),
        "width": width,
        "height": height,
        "mask": args.mask,
        "threshold": threshold,
        "layers": compared.iter().map(layer).collect::<Vec<Value>>(),
    })
}
