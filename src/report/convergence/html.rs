//! One page without other files: charts, tables, pictures.

use super::front::{pareto, places, time_to_reach};
use super::point::{Point, Time, seconds, short};
use crate::image::png;
use crate::report::svg::escape;
use crate::report::table::percent;
use std::fmt::Write;
use std::io;

/// Errors that the page says the time for.
const LEVELS: [f64; 6] = [0.2, 0.1, 0.05, 0.03, 0.02, 0.01];

/// A picture beside its difference from the reference, each as the text of an image's address.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shot {
    /// What it is.
    pub caption: String,
    /// The picture.
    pub picture: String,
    /// The difference in false colour; none of the reference itself.
    pub difference: Option<String>,
}

/// What the page holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Page<'a> {
    /// Heading.
    pub title: String,
    /// Names and values under it: machine, device, command, reference.
    pub facts: Vec<(&'static str, String)>,
    /// Remarks on how to read it.
    pub notes: Vec<String>,
    /// Charts as SVG.
    pub charts: Vec<String>,
    /// All points.
    pub points: &'a [Point],
    /// Indices of those on the front.
    pub front: Vec<usize>,
    /// Column of the error that times are given for.
    pub error: String,
    /// Pictures.
    pub shots: Vec<Shot>,
}

const STYLE: &str = "\
body{font:15px/1.5 system-ui,Helvetica,Arial,sans-serif;color:#222;background:#fff;max-width:1100px;margin:2em auto;\
padding:0 1em}h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}svg{max-width:100%;height:auto;display:block;\
margin:1em 0}table{border-collapse:collapse;font-size:13px}td,th{padding:.25em .7em;border-bottom:1px solid #ddd;\
text-align:right;white-space:nowrap}td:first-child,th:first-child,td.words,th.words{text-align:left}\
tr.front td{background:#f2f7fb;font-weight:600}dl{display:grid;grid-template-columns:max-content 1fr;gap:.2em 1em}\
dt{color:#666}dd{margin:0;overflow-wrap:anywhere}.wide{overflow-x:auto}.shots{display:flex;flex-wrap:wrap;gap:1.5em}\
figure{margin:0}figure img{max-width:256px;image-rendering:auto;margin-right:6px}figcaption{font-size:13px;\
max-width:520px}";

impl Page<'_> {
    /// The page's text.
    pub fn html(&self) -> String {
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <title>{title}</title><style>{STYLE}</style></head>\n<body><h1>{title}</h1>\n<dl>",
            title = escape(&self.title)
        );
        for (name, value) in &self.facts {
            let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", escape(name), escape(value));
        }
        out += "</dl>\n";
        self.charts.iter().for_each(|chart| out += chart);
        for note in &self.notes {
            let _ = writeln!(out, "<p>{}</p>", escape(note));
        }
        self.reach(&mut out);
        self.shots(&mut out);
        self.table(&mut out);
        out + "</body></html>\n"
    }

    /// Time that each method needs for given errors.
    fn reach(&self, out: &mut String) {
        for (time, name) in [(Time::Cpu, "Processor"), (Time::Wall, "Clock")] {
            let rows = reach(self.points, time, &self.error);
            if rows.is_empty() {
                continue;
            }
            let _ = write!(
                out,
                "<h2>{name} seconds to an error ({}) of</h2>\n<div class=\"wide\"><table><tr><th></th>",
                escape(&self.error)
            );
            LEVELS.iter().for_each(|level| *out += &format!("<th>{}</th>", percent(*level)));
            *out += "</tr>\n";
            for (series, times) in rows {
                let _ = write!(out, "<tr><td>{}</td>", escape(&series));
                times.iter().for_each(|time| *out += &format!("<td>{}</td>", escape(time)));
                *out += "</tr>\n";
            }
            *out += "</table></div>\n";
        }
        *out += "<p>Interpolated between a method’s best points; ≤ where the fastest of them is better already, – where none \
                 gets there.</p>\n";
    }

    fn shots(&self, out: &mut String) {
        if self.shots.is_empty() {
            return;
        }
        *out += "<h2>Irradiance, and relative error in false colour (dark blue 0, dark red 25 % and more)</h2>\n\
                 <div class=\"shots\">\n";
        for shot in &self.shots {
            let image = |data: &str| format!("<img alt=\"\" src=\"{}\"/>", escape(data));
            let difference = shot.difference.as_deref().map_or_else(String::new, image);
            let caption = escape(&shot.caption);
            let picture = image(&shot.picture);
            let _ = writeln!(out, "<figure>{picture}{difference}<figcaption>{caption}</figcaption></figure>");
        }
        *out += "</div>\n";
    }

    fn table(&self, out: &mut String) {
        *out += "<h2>All points</h2>\n<div class=\"wide\"><table><tr><th>method</th><th class=\"words\">settings</th>";
        let heads = "records,CPU s,± ,clock s,± ,GPU ms,device MB,host MB,mae,4×4,rms,p99,energy,flip";
        heads.split(',').for_each(|head| *out += &format!("<th>{}</th>", escape(head)));
        *out += "</tr>\n";
        for (index, point) in self.points.iter().enumerate() {
            let class = if self.front.contains(&index) { " class=\"front\"" } else { "" };
            let (series, settings, words) = (point.series(), point.text("settings"), point.words());
            let _ = write!(
                out,
                "<tr{class}><td>{}</td><td class=\"words\" title=\"{}\">{}</td>",
                escape(&series),
                escape(settings),
                escape(&words)
            );
            figures(point).into_iter().for_each(|cell| *out += &format!("<td>{}</td>", escape(&cell)));
            *out += "</tr>\n";
        }
        *out += "</table></div>\n<p>Bold: on the Pareto front of processor or clock time. ± is longest less shortest of \
                 the repeats; mae, rms: error / mean; 4×4: mae of averages over 4 × 4 pixels, from which noise is \
                 gone; energy: sum / sum of the reference.</p>\n";
    }
}

fn figures(point: &Point) -> Vec<String> {
    let with = |column: &str, shown: &dyn Fn(f64) -> String| point.number(column).map_or_else(|| "–".into(), shown);
    let megabytes = |value: f64| format!("{:.0}", value / f64::from(1 << 20));
    vec![
        with("records", &|n| if n > 0.0 { short(n) } else { "–".into() }),
        with("indirect_cpu_s", &seconds),
        with("indirect_cpu_spread_s", &seconds),
        with("indirect_wall_s", &seconds),
        with("wall_spread_s", &seconds),
        with("gpu_ms", &|ms| format!("{ms:.1}")),
        with("device_bytes", &megabytes),
        with("host_bytes", &megabytes),
        with("mae", &percent),
        with("block_mae", &percent),
        with("rms", &percent),
        with("p99", &percent),
        with("energy", &|e| format!("{e:.3}")),
        with("flip", &|e| format!("{e:.4}")),
    ]
}

/// Times to each of the levels, a row a series.
fn reach(points: &[Point], time: Time, error: &str) -> Vec<(String, Vec<String>)> {
    let places = places(points, time, error);
    let mut names: Vec<String> = places.iter().map(|(index, ..)| points[*index].series()).collect();
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| seen.insert(name.clone()));
    let times = |name: String| {
        let own: Vec<(f64, f64)> =
            places.iter().filter(|(i, ..)| points[*i].series() == name).map(|(_, t, e)| (*t, *e)).collect();
        let front: Vec<(f64, f64)> = pareto(&own).into_iter().map(|i| own[i]).collect();
        let cell = |level: &f64| {
            let bound = if front.first().is_some_and(|(_, e)| e <= level) { "≤ " } else { "" };
            time_to_reach(&front, *level).map_or_else(|| "–".into(), |time| format!("{bound}{}", seconds(time)))
        };
        (name, LEVELS.iter().map(cell).collect())
    };
    names.into_iter().map(times).collect()
}

/// A picture of 8-bit sRGB code values as the text of an image's address (RFC 2397).
pub fn png_address(width: u32, height: u32, codes: &[u8]) -> io::Result<String> {
    let mut bytes = Vec::new();
    png::encode(&mut bytes, width, height, codes)?;
    Ok(format!("data:image/png;base64,{}", base64(&bytes)))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i)) as usize & 63] as char;
            out.push(if i <= chunk.len() { letter } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::point::tests::sample;
    use super::*;
    use crate::report::svg::tests::assert_well_formed;

    #[test]
    fn base64_as_in_the_rfc() {
        let pairs = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        pairs.iter().for_each(|(plain, coded)| assert_eq!(base64(plain.as_bytes()), *coded));
    }

    #[test]
    fn pages_are_well_formed_and_stand_alone() {
        let points = [sample("splatting", 0.3, 1.0, 0.04), sample("path<&>", 0.2, 2.0, 0.2)];
        let picture = png_address(2, 1, &[0, 0, 0, 255, 255, 255]).unwrap();
        let page = Page {
            title: "a < b & \"c\"".into(),
            facts: vec![("command", "hemicube convergence 'a&b' -o <dir>".into())],
            notes: vec!["x > y".into()],
            charts: vec!["<svg></svg>".into()],
            points: &points,
            front: vec![0],
            error: "mae".into(),
            shots: vec![Shot { caption: "c".into(), difference: Some(picture.clone()), picture }],
        };
        let html = page.html();
        assert_well_formed(html.trim_start_matches("<!DOCTYPE html>"));
        assert!(html.contains("data:image/png;base64,iVBOR") && html.contains("path&lt;&amp;&gt;"), "{html}");
        assert!(!html.contains("http"), "nothing is loaded from elsewhere");
        assert!(html.contains("tr class=\"front\""));
    }

    #[test]
    fn times_to_errors_stand_in_a_row() {
        let points = [sample("ward", 0.3, 1.0, 0.4), sample("ward", 0.1, 4.0, 0.1)];
        let rows = reach(&points, Time::Cpu, "mae");
        assert_eq!((rows.len(), rows[0].0.as_str()), (1, "Ward's cache"));
        assert_eq!(rows[0].1, ["2.00", "4.00", "–", "–", "–", "–"]);
        let coarse = [sample("ward", 0.3, 1.0, 0.15)];
        assert_eq!(reach(&coarse, Time::Cpu, "mae")[0].1[..2], ["≤ 1.00", "–"]);
    }
}
