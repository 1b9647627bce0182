//! From points to a chart: one line a method, the common front ringed.

use super::front::{front, pareto, places};
use super::point::{Point, Time, short};
use crate::report::svg::{Chart, Dot, Level, Series};
use crate::report::table::percent;

/// What a chart is over.
#[derive(Debug, Clone)]
pub struct Axes {
    /// The horizontal axis.
    pub time: Time,
    /// Column of the vertical axis.
    pub error: String,
    /// What the error is called.
    pub error_name: String,
    /// Error that the reference's own noise shows, if that is known.
    pub noise: Option<f64>,
}

/// Draws `points`, a line for each name that `series` gives; they stand in the order of their methods, then of
/// their first points.
pub fn chart(title: &str, subtitle: &str, points: &[Point], axes: &Axes, series: impl Fn(&Point) -> String) -> Chart {
    let series_of = series;
    let places = places(points, axes.time, &axes.error);
    let best = front(points, axes.time, &axes.error);
    let mut names: Vec<(usize, String)> = Vec::new();
    for &(index, ..) in &places {
        let name = series_of(&points[index]);
        if !names.iter().any(|(_, known)| *known == name) {
            names.push((rank(points[index].text("method")), name));
        }
    }
    names.sort_by_key(|(rank, _)| *rank);
    let series = names.into_iter().map(|(_, name)| {
        let own: Vec<_> = places.iter().filter(|(index, ..)| series_of(&points[*index]) == name).collect();
        let at: Vec<(f64, f64)> = own.iter().map(|(_, t, e)| (*t, *e)).collect();
        let dot = |&&(index, t, e): &&(usize, f64, f64)| Dot {
            at: (t, e),
            text: describe(&points[index], axes, (t, e)),
            ringed: best.contains(&index),
            spread: spread(&points[index], axes.time).unwrap_or(0.0),
        };
        Series { dots: own.iter().map(dot).collect(), line: pareto(&at).into_iter().map(|i| at[i]).collect(), name }
    });
    let x = match axes.time {
        Time::Cpu => "processor time for the indirect light, all threads together, s",
        Time::Wall => "time on the clock for the indirect light, s",
    };
    Chart {
        title: title.into(),
        subtitle: subtitle.into(),
        x: x.into(),
        y: axes.error_name.clone(),
        series: series.collect(),
        levels: axes.noise.map(|at| Level { at, name: "noise of the reference".into() }).into_iter().collect(),
    }
}

/// Place of a method in every legend.
fn rank(method: &str) -> usize {
    ["splatting", "ward", "path", "radiance", "mitsuba"].iter().position(|known| *known == method).unwrap_or(usize::MAX)
}

/// Longest less shortest of the repeated timings; none of a point that was timed once.
fn spread(point: &Point, time: Time) -> Option<f64> {
    let spread = match time {
        Time::Cpu => point.number("indirect_cpu_spread_s"),
        Time::Wall => point.number("wall_spread_s"),
    };
    spread.filter(|_| point.number("repeats").is_some_and(|n| n > 1.0))
}

fn describe(point: &Point, axes: &Axes, (time, error): (f64, f64)) -> String {
    let spread = spread(point, axes.time).map_or_else(String::new, |s| format!(" (spread {} s)", short(s)));
    let records = point.number("records").filter(|n| *n > 0.0).map_or_else(String::new, |n| format!(", {n} records"));
    let (series, words) = (point.series(), point.words());
    format!("{series}: {words}{records}\n{} s{spread}, {} {}", short(time), axes.error, percent(error))
}

#[cfg(test)]
mod tests {
    use super::super::point::tests::sample;
    use super::*;
    use crate::report::svg::tests::assert_well_formed;

    #[test]
    fn a_line_goes_through_a_methods_best_points() {
        let points = [
            sample("splatting", 0.6, 0.1, 0.1),
            sample("splatting", 0.3, 1.0, 0.03),
            sample("splatting", 0.2, 2.0, 0.05),
            sample("path", 0.1, 5.0, 0.05),
            sample("path", 0.2, 8.0, 0.02),
        ];
        let axes = Axes { time: Time::Cpu, error: "mae".into(), error_name: "e".into(), noise: Some(0.01) };
        let chart = chart("t", "s", &points, &axes, Point::series);
        assert_eq!(chart.series.len(), 2);
        assert_eq!(chart.series[0].line, [(0.1, 0.1), (1.0, 0.03)]);
        let ringed = |s: &Series| s.dots.iter().map(|dot| dot.ringed).collect::<Vec<_>>();
        assert_eq!((ringed(&chart.series[0]), ringed(&chart.series[1])), (vec![true, true, false], vec![false, true]));
        assert!(
            chart.series[0].dots[1].text.contains("accuracy 0.3") && chart.series[0].dots[1].text.contains("3.00 %")
        );
        assert_well_formed(&chart.svg());
    }
}
