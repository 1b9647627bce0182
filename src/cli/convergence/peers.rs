//! Points of other renderers.

use anyhow::{Context, Result, anyhow, ensure};
use hemicube::report::convergence::Point;
use hemicube::report::csv;
use std::path::Path;

/// What a file of `tools/peers/run.py` has for this scene and view.
pub struct Peers {
    pub points: Vec<Point>,
    /// What is odd about them.
    pub notes: Vec<String>,
}

/// Columns without which a point cannot be shown.
const NEEDED: [&str; 9] =
    ["scene", "width", "height", "bounces", "method", "settings", "threads", "indirect_wall_s", "mae"];

/// Reads the file, and leaves out what is of another scene, size or number of bounces.
pub fn read(path: &Path, scene: &str, (width, height): (u32, u32)) -> Result<Peers> {
    let text = std::fs::read_to_string(path).with_context(|| format!("--peers: cannot read {path:?}"))?;
    let rows = csv::read(&text).map_err(|what| anyhow!("--peers {path:?}: {what}"))?;
    let points: Vec<Point> = rows.into_iter().map(|row| Point { row }).collect();
    for column in NEEDED {
        let missing = points.iter().any(|point| !point.row.contains_key(column));
        ensure!(!missing, "--peers {path:?}: there is no column {column:?}; is it by tools/peers/run.py?");
    }
    let all = points.len();
    let wanted = [scene.to_owned(), width.to_string(), height.to_string(), "1".into()];
    let same =
        |point: &Point| ["scene", "width", "height", "bounces"].iter().zip(&wanted).all(|(c, w)| point.text(c) == w);
    let points: Vec<Point> = points.into_iter().filter(same).collect();
    let mut notes = Vec::new();
    if points.len() < all {
        let left_out = all - points.len();
        notes.push(format!("--peers: {left_out} of {all} points are of another scene, size or number of bounces than {scene}, {width} × {height}, 1"));
    }
    Ok(Peers { points, notes })
}
