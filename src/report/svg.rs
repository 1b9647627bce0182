//! Charts as SVG 1.1: both axes logarithmic, a line and a mark a series, a legend, a text on each point for the pointer.

mod axis;

use axis::{Axis, number};
use std::fmt::Write;

/// Colours that are told apart with every kind of colour vision (Okabe and Ito 2008, "Color Universal Design"; the wine
/// red is of Tol's "muted" scheme, in place of a second blue).
const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#882255", "#444444"];

const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 560.0;
/// Plot area: left, top, right, bottom.
const PLOT: [f64; 4] = [78.0, 60.0, 700.0, 492.0];
/// Half the size of a mark.
const MARK: f64 = 5.0;

/// A point of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Dot {
    /// Place on the axes, above 0.
    pub at: (f64, f64),
    /// Shown where the pointer rests on the point.
    pub text: String,
    /// Ringed: on the front of all series.
    pub ringed: bool,
    /// How far repeated measurements of the horizontal value lie apart; drawn about the point.
    pub spread: f64,
}

/// Points of one kind.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// All of its points.
    pub dots: Vec<Dot>,
    /// Places that its line goes through, in order.
    pub line: Vec<(f64, f64)>,
}

/// A level drawn across the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Place on the vertical axis.
    pub at: f64,
    /// What it is.
    pub name: String,
}

/// A chart with two logarithmic axes; the vertical one is in percent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chart {
    /// First line at the top.
    pub title: String,
    /// Second, smaller.
    pub subtitle: String,
    /// Name of the horizontal axis with its unit.
    pub x: String,
    /// Name of the vertical axis.
    pub y: String,
    /// What is drawn, in the legend's order.
    pub series: Vec<Series>,
    /// Horizontal lines.
    pub levels: Vec<Level>,
}

/// Text that may stand in XML and HTML, in attributes too; what XML cannot hold at all is left out.
pub fn escape(text: &str) -> String {
    let legal = |c: &char| *c >= ' ' || matches!(c, '\t' | '\n' | '\r');
    text.chars().filter(legal).fold(String::new(), |mut out, letter| {
        match letter {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            other => out.push(other),
        }
        out
    })
}

impl Chart {
    /// The chart as a document of its own.
    pub fn svg(&self) -> String {
        let places = || self.series.iter().flat_map(|s| s.dots.iter().map(|dot| dot.at));
        let levels = self.levels.iter().map(|level| level.at);
        let x = Axis::over(places().map(|(x, _)| x), PLOT[0], PLOT[2]);
        let y = Axis::over(places().map(|(_, y)| y).chain(levels), PLOT[3], PLOT[1]);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" font-family=\"system-ui, Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n"
        );
        self.heads(&mut out);
        grid(&mut out, &x, &y);
        self.level_lines(&mut out, &y);
        if places().next().is_none() {
            text(&mut out, ((PLOT[0] + PLOT[2]) / 2.0, 280.0), "middle", "", "no points");
        }
        for (index, series) in self.series.iter().enumerate() {
            self.series(&mut out, index, series, (&x, &y));
        }
        self.legend(&mut out);
        out + "</svg>\n"
    }

    fn heads(&self, out: &mut String) {
        let middle = (PLOT[0] + PLOT[2]) / 2.0;
        text(out, (PLOT[0], 26.0), "start", "font-size=\"17\" font-weight=\"600\"", &self.title);
        text(out, (PLOT[0], 46.0), "start", "fill=\"#555\"", &self.subtitle);
        text(out, (middle, HEIGHT - 22.0), "middle", "", &self.x);
        let turn = format!("transform=\"rotate(-90 22 {})\"", (PLOT[1] + PLOT[3]) / 2.0);
        text(out, (22.0, (PLOT[1] + PLOT[3]) / 2.0), "middle", &turn, &self.y);
    }

    fn level_lines(&self, out: &mut String, y: &Axis) {
        for level in &self.levels {
            let at = y.place(level.at);
            let _ = writeln!(
                out,
                "<line x1=\"{}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#888\" stroke-dasharray=\"2 4\"/>",
                PLOT[0], PLOT[2]
            );
            text(out, (PLOT[0] + 6.0, at - 5.0), "start", "font-size=\"11\" fill=\"#666\"", &level.name);
        }
    }

    fn series(&self, out: &mut String, index: usize, series: &Series, (x, y): (&Axis, &Axis)) {
        let colour = COLOURS[index % COLOURS.len()];
        let place = |(a, b): (f64, f64)| (x.place(a), y.place(b));
        let path: Vec<String> =
            series.line.iter().map(|at| place(*at)).map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
        if path.len() > 1 {
            let dash = if index >= COLOURS.len() { " stroke-dasharray=\"6 3\"" } else { "" };
            let points = path.join(" ");
            let _ = writeln!(
                out,
                "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>"
            );
        }
        for dot in &series.dots {
            let (a, b) = place(dot.at);
            if dot.spread > 0.0 {
                // Half of it may be more than the middle value, which a logarithmic axis has no place for.
                let low = (dot.at.0 - 0.5 * dot.spread).max(0.5 * dot.at.0);
                let (from, to) = (x.place(low), x.place(dot.at.0 + 0.5 * dot.spread));
                let _ = writeln!(out, "<path d=\"M{from:.1} {b:.1}H{to:.1}\" stroke=\"{colour}\" opacity=\"0.6\"/>");
            }
            let fill = if series.line.contains(&dot.at) { colour } else { "#fff" };
            let _ = writeln!(
                out,
                "<g fill=\"{fill}\" stroke=\"{colour}\"><title>{}</title>{}</g>",
                escape(&dot.text),
                mark(index, a, b)
            );
            if dot.ringed {
                let _ = writeln!(out, "{}", ring(a, b));
            }
        }
    }

    fn legend(&self, out: &mut String) {
        let (left, mut y) = (PLOT[2] + 28.0, PLOT[1] + 8.0);
        for (index, series) in self.series.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let _ = writeln!(
                out,
                "<g fill=\"{colour}\"><line x1=\"{}\" x2=\"{}\" y1=\"{y}\" y2=\"{y}\" stroke=\"{colour}\" \
                 stroke-width=\"2\"/>{}</g>",
                left - 14.0,
                left + 14.0,
                mark(index, left, y)
            );
            text(out, (left + 22.0, y + 4.5), "start", "", &series.name);
            y += 24.0;
        }
        if self.series.iter().any(|s| s.dots.iter().any(|dot| dot.ringed)) {
            y += 6.0;
            let _ = writeln!(out, "{}", ring(left, y));
            text(out, (left + 22.0, y + 4.5), "start", "", "on the Pareto front:");
            text(out, (left + 22.0, y + 20.0), "start", "", "nothing is faster and better");
            y += 42.0;
            let faint = "font-size=\"11\" fill=\"#666\"";
            text(out, (left - 14.0, y), "start", faint, "Lines join a method’s best points;");
            text(out, (left - 14.0, y + 15.0), "start", faint, "its other settings are hollow.");
            if self.series.iter().any(|s| s.dots.iter().any(|dot| dot.spread > 0.0)) {
                text(out, (left - 14.0, y + 30.0), "start", faint, "Bars: spread of repeated timings.");
            }
        }
    }
}

fn grid(out: &mut String, x: &Axis, y: &Axis) {
    let [left, top, right, bottom] = PLOT;
    for value in x.ticks() {
        let at = x.place(value);
        line(out, (at, at), (top, bottom));
        text(out, (at, bottom + 19.0), "middle", "", &number(value));
    }
    for value in y.ticks() {
        let at = y.place(value);
        line(out, (left, right), (at, at));
        text(out, (left - 9.0, at + 4.5), "end", "", &format!("{} %", number(100.0 * value)));
    }
    let (width, height) = (right - left, bottom - top);
    let _ = writeln!(
        out,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#999\"/>"
    );
}

fn line(out: &mut String, (x1, x2): (f64, f64), (y1, y2): (f64, f64)) {
    let _ = writeln!(out, "<line x1=\"{x1:.1}\" x2=\"{x2:.1}\" y1=\"{y1:.1}\" y2=\"{y2:.1}\" stroke=\"#e3e3e3\"/>");
}

fn text(out: &mut String, (x, y): (f64, f64), anchor: &str, more: &str, words: &str) {
    let space = if more.is_empty() { "" } else { " " };
    let _ =
        writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{space}{more}>{}</text>", escape(words));
}

fn ring(x: f64, y: f64) -> String {
    let radius = MARK + 3.5;
    format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"none\" stroke=\"#111\" stroke-width=\"1.4\"/>")
}

/// Another shape for each series, so that nothing hangs on colour alone.
fn mark(index: usize, x: f64, y: f64) -> String {
    let polygon = |corners: &[(f64, f64)]| {
        let corners: Vec<String> =
            corners.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + MARK * dx, y + MARK * dy)).collect();
        format!("<polygon points=\"{}\"/>", corners.join(" "))
    };
    match index % 7 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{MARK}\"/>"),
        1 => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
        2 => polygon(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
        3 => polygon(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
        4 => polygon(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
        5 => polygon(&[(-1.2, 0.0), (-0.6, -1.0), (0.6, -1.0), (1.2, 0.0), (0.6, 1.0), (-0.6, 1.0)]),
        _ => polygon(&[
            (-1.2, -0.4),
            (-0.4, -0.4),
            (-0.4, -1.2),
            (0.4, -1.2),
            (0.4, -0.4),
            (1.2, -0.4),
            (1.2, 0.4),
            (0.4, 0.4),
            (0.4, 1.2),
            (-0.4, 1.2),
            (-0.4, 0.4),
            (-1.2, 0.4),
        ]),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Every tag is closed in order, attributes are quoted, and nothing but known entities stands in the text.
    pub(crate) fn assert_well_formed(xml: &str) {
        let mut open: Vec<&str> = Vec::new();
        let mut rest = xml;
        while let Some(begin) = rest.find('<') {
            assert!(!rest[..begin].contains('>'), "a stray >: {}", &rest[..begin]);
            let end = begin + rest[begin..].find('>').expect("a tag is closed");
            let tag = &rest[begin + 1..end];
            assert_eq!(tag.matches('"').count() % 2, 0, "quotes of <{tag}>");
            let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
            if tag.starts_with('/') {
                assert_eq!(open.pop(), Some(name));
            } else if !tag.ends_with('/') && !tag.starts_with('!') && !matches!(name, "meta" | "img" | "br") {
                open.push(name);
            }
            rest = &rest[end + 1..];
        }
        assert!(open.is_empty(), "left open: {open:?}");
        for (at, _) in xml.match_indices('&') {
            let known = ["&amp;", "&lt;", "&gt;", "&quot;", "&#39;"];
            assert!(known.iter().any(|entity| xml[at..].starts_with(entity)), "{}", &xml[at..xml.len().min(at + 12)]);
        }
    }

    fn sample() -> Chart {
        let dot = |x, y, ringed| Dot { at: (x, y), text: "a <b> & \"c\"\u{1}".into(), ringed, spread: x };
        let series = |name: &str, dots: Vec<Dot>| Series {
            name: name.into(),
            line: dots.iter().map(|dot| dot.at).collect(),
            dots,
        };
        Chart {
            title: "error < time".into(),
            series: vec![
                series("one", vec![dot(0.01, 0.3, true), dot(10.0, 0.01, false)]),
                series("other", vec![dot(1.0, 0.1, true)]),
            ],
            levels: vec![Level { at: 0.005, name: "noise".into() }],
            ..Chart::default()
        }
    }

    #[test]
    fn charts_are_well_formed() {
        let svg = sample().svg();
        assert_well_formed(&svg);
        assert_eq!(svg.matches("<title>").count(), 3);
        assert!(svg.contains("noise") && svg.contains("error &lt; time") && !svg.contains('\u{1}'));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<path d=\"M").count(), 3, "a bar a point that has a spread");
        assert_well_formed(&Chart::default().svg());
    }
}
