//! Charts and the page, from the points and pictures of the folder.

use super::ConvergenceArgs;
use super::folder::Folder;
use super::truth::Truth;
use crate::cli::say::say;
use anyhow::Result;
use hemicube::image::metrics::difference_map;
use hemicube::image::tone::{Look, luminance, turbo};
use hemicube::image::write::write_atomic;
use hemicube::image::{Kind, Layer};
use hemicube::report::convergence::{Axes, Machine, Page, Point, Shot, Time, chart, front, png_address, seconds};
use hemicube::report::table::percent;
use std::collections::BTreeSet;

/// Relative error that the last colour shows.
const DIFFERENCE_TOP: f32 = 0.25;

/// A point's figures in a line.
pub fn one_line(point: &Point) -> String {
    let seconds = |column: &str| point.number(column).map_or_else(|| "–".into(), seconds);
    let error = point.number("mae").map_or_else(|| "–".into(), percent);
    let records = point.number("records").filter(|n| *n > 0.0).map_or_else(String::new, |n| format!("{n} records, "));
    format!("{records}{} CPU s, {} s, error {error}", seconds("indirect_cpu_s"), seconds("indirect_wall_s"))
}

/// Writes the charts and the page.
pub fn write(
    args: &ConvergenceArgs,
    folder: &Folder,
    truth: &Truth,
    (width, height): (u32, u32),
    device: Option<&str>,
) -> Result<()> {
    let points = &folder.points;
    let devices: BTreeSet<&str> =
        points.iter().map(|p| p.text("device")).filter(|d| !matches!(*d, "" | "CPU")).collect();
    let device = match (devices.len(), device) {
        (0, None) => "none: no splatting was measured".into(),
        (0, Some(name)) => name.to_owned(),
        _ => devices.into_iter().collect::<Vec<_>>().join("; "),
    };
    let title = format!("{}, {width} × {height}: error against time", args.name());
    let mut charts = Vec::new();
    let mut best = BTreeSet::new();
    for (time, file) in [(Time::Cpu, "error-cpu.svg"), (Time::Wall, "error-wall.svg")] {
        let noise = truth.noise.filter(|_| args.error.column() == "mae");
        let axes = Axes { time, error: args.error.column().into(), error_name: args.error.words().into(), noise };
        let subtitle = format!("one bounce; {device}");
        let svg = chart(&title, &subtitle, points, &axes, Point::series).svg();
        write_atomic(&folder.path.join(file), |sink| sink.write_all(svg.as_bytes()))?;
        best.extend(front(points, time, args.error.column()));
        charts.push(svg);
    }
    charts.extend(settings_chart(args, folder, truth)?);
    let page = Page {
        title,
        facts: facts(truth, device),
        notes: notes(points),
        charts,
        points,
        front: best.into_iter().collect(),
        error: args.error.column().into(),
        shots: shots(args, folder, truth, (width, height))?,
    };
    let file = folder.path.join("index.html");
    write_atomic(&file, |sink| sink.write_all(page.html().as_bytes()))?;
    if !args.quiet {
        say!("{} points; wrote {} with its table and charts beside it", points.len(), file.display());
    }
    Ok(())
}

/// Splatting alone, a line for each way to capture; none where there is only one.
fn settings_chart(args: &ConvergenceArgs, folder: &Folder, truth: &Truth) -> Result<Option<String>> {
    let own: Vec<Point> = folder.points.iter().filter(|p| p.text("method") == "splatting").cloned().collect();
    let variants: BTreeSet<String> = own.iter().map(Point::variant).collect();
    if variants.len() < 2 {
        return Ok(None);
    }
    let on_cpu = own.iter().any(|point| point.seconds(Time::Cpu).is_some());
    let axes = Axes {
        time: if on_cpu { Time::Cpu } else { Time::Wall },
        error: args.error.column().into(),
        error_name: args.error.words().into(),
        noise: truth.noise.filter(|_| args.error.column() == "mae"),
    };
    let title = format!("{}: settings of splatting", args.name());
    let svg = chart(&title, "lines go over the accuracy", &own, &axes, Point::variant).svg();
    write_atomic(&folder.path.join("splatting.svg"), |sink| sink.write_all(svg.as_bytes()))?;
    Ok(Some(svg))
}

fn facts(truth: &Truth, device: String) -> Vec<(&'static str, String)> {
    let noise =
        truth.noise.map_or_else(String::new, |noise| format!("; its noise shows as an error of {}", percent(noise)));
    let words: Vec<String> = std::env::args().map(|word| quoted(&word)).collect();
    vec![
        ("machine", Machine::this().to_string()),
        ("device of splatting", device),
        ("reference", format!("{}{noise}", truth.words)),
        ("made by", format!("hemicube {}", env!("CARGO_PKG_VERSION"))),
        ("command", words.join(" ")),
    ]
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

fn notes(points: &[Point]) -> Vec<String> {
    let mut notes = vec![
        "Times are those of the indirect light: setting up is left out, and the time of the same picture without \
         indirect light is taken off. Of repeated timings the median counts. Points can be pointed at for their settings."
            .to_owned(),
    ];
    let single = points.iter().filter(|point| point.number("repeats").is_some_and(|n| n < 2.0)).count();
    if single > 0 {
        notes.push(format!("{single} of {} points were timed once: they have no spread.", points.len()));
    }
    let wild = |point: &&Point| {
        let (wall, spread) = (point.number("wall_s"), point.number("wall_spread_s"));
        wall.zip(spread).is_some_and(|(wall, spread)| spread > 0.2 * wall)
    };
    let wild = points.iter().filter(wild).count();
    if wild > 0 {
        notes.push(format!(
            "{wild} points have clock times that differ by more than a fifth: the machine was busy with other things, and \
             processor times say more."
        ));
    }
    notes
}

/// The reference, and of each method of ours the most exact point and the one in default settings.
fn shots(args: &ConvergenceArgs, folder: &Folder, truth: &Truth, (width, height): (u32, u32)) -> Result<Vec<Shot>> {
    let layer = truth.layer();
    let kept = truth.mask.iter().filter(|kept| **kept).count().max(1) as f64;
    let sum = |p: &[f32]| p.iter().zip(&truth.mask).filter(|(_, k)| **k).map(|(v, _)| f64::from(v.abs())).sum::<f64>();
    let mean = layer.channels.iter().map(|p| sum(p)).sum::<f64>() / (3.0 * kept);
    let at = |planes: &[&[f32]], i: usize| [planes[0][i], planes[1][i], planes[2][i]];
    let bright = (0..truth.mask.len()).map(|i| f64::from(luminance(at(&layer.channels, i)))).sum::<f64>() / kept;
    let stops = if bright > 0.0 { (0.3 / bright).log2() as f32 } else { 0.0 };
    let look = Look { stops, ..Look::default() };
    let shown = |planes: &[&[f32]]| -> Result<String> {
        let codes: Vec<u8> = (0..truth.mask.len()).flat_map(|i| look.apply(at(planes, i))).collect();
        Ok(png_address(width, height, &codes)?)
    };
    let mut shots = vec![Shot {
        caption: format!("Reference: {}", truth.words),
        picture: shown(&layer.channels)?,
        difference: None,
    }];
    for point in chosen(args, &folder.points) {
        let Some(picture) = folder.picture(point).filter(|p| (p.width, p.height) == (width, height)) else { continue };
        let Some(rgb) = picture.rgb("irradiance") else { continue };
        let test = Layer { kind: Kind::Colour, channels: rgb.to_vec() };
        let map = difference_map(&test, &layer, Some(&truth.mask), mean);
        let codes: Vec<u8> = map.iter().flat_map(|error| turbo(error / DIFFERENCE_TOP)).collect();
        shots.push(Shot {
            caption: format!("{}: {}; {}", point.series(), point.words(), one_line(point)),
            picture: shown(&rgb)?,
            difference: Some(png_address(width, height, &codes)?),
        });
    }
    Ok(shots)
}

fn chosen<'a>(args: &ConvergenceArgs, points: &'a [Point]) -> Vec<&'a Point> {
    let error = args.error.column();
    let mut chosen: Vec<&Point> = Vec::new();
    for method in ["splatting", "ward", "path"] {
        let own = || points.iter().filter(move |p| p.text("method") == method && p.number(error).is_some());
        let exact = own().min_by(|a, b| a.number(error).unwrap_or(0.0).total_cmp(&b.number(error).unwrap_or(0.0)));
        let usual = own().find(|point| is_default(point));
        chosen.extend(usual.into_iter().chain(exact).fold(Vec::new(), |mut all: Vec<&Point>, point| {
            if !all.contains(&point) {
                all.push(point);
            }
            all
        }));
    }
    chosen
}

/// Whether a point has the settings that its method has without any flags.
fn is_default(point: &Point) -> bool {
    let settings = point.settings();
    let is = |name: &str, value: f64| settings.get(name).and_then(serde_json::Value::as_f64) == Some(value);
    match point.text("method") {
        "splatting" => {
            is("accuracy", 0.3) && is("capture_size", 32.0) && settings.get("gradients").is_some_and(|g| g == "both")
        }
        "ward" => is("accuracy", 0.2) && is("rays", 1024.0),
        _ => is("spp", 256.0),
    }
}
