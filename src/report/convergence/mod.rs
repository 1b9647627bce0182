//! Error against time: measured points of several methods, which of them are worth having, and how they are shown.

mod chart;
mod front;
mod html;
mod machine;
mod point;

pub use chart::{Axes, chart};
pub use front::{front, pareto, places, time_to_reach};
pub use html::{Page, Shot, png_address};
pub use machine::{Machine, peak_memory, reset_peak_memory};
pub use point::{COLUMNS, Point, Time, median_and_spread, method_name, seconds, short};
