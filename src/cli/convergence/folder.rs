//! The folder of a run: the points so far, their pictures, and what they belong to.

use super::ConvergenceArgs;
use super::truth::Truth;
use anyhow::{Context, Result, anyhow, ensure};
use hemicube::image::write::write_atomic;
use hemicube::image::{Picture, exr};
use hemicube::reference::{Progressive, Settings, Tracer, View};
use hemicube::report::convergence::{COLUMNS, Point};
use hemicube::report::csv;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Results on disk, and the same in memory.
pub struct Folder {
    pub path: PathBuf,
    pub points: Vec<Point>,
}

impl Folder {
    /// Opens the folder, or makes it.
    pub fn open(args: &ConvergenceArgs) -> Result<Self> {
        let path = args.output.clone();
        ensure!(!path.exists() || path.is_dir(), "cannot write into {path:?}: it is a file");
        std::fs::create_dir_all(path.join("pictures")).with_context(|| format!("cannot make the folder {path:?}"))?;
        let mut folder = Self { path, points: Vec::new() };
        if args.fresh {
            for old in ["points.csv", "run.json", "reference.state", "reference.exr"] {
                let old = folder.path.join(old);
                if old.exists() {
                    std::fs::remove_file(&old).with_context(|| format!("cannot remove {old:?}"))?;
                }
            }
        } else if folder.table().exists() {
            let table = folder.table();
            let text = std::fs::read_to_string(&table).with_context(|| format!("cannot read {table:?}"))?;
            let rows = csv::read(&text).map_err(|what| anyhow!("{table:?} is damaged: {what}; --fresh starts anew"))?;
            folder.points = rows.into_iter().map(|row| Point { row }).collect();
        }
        Ok(folder)
    }

    /// Makes sure that the folder's points are of this scene, view and reference.
    pub fn claim(&self, tracer: &Tracer, view: &View, truth: &Truth) -> Result<()> {
        let view = Progressive::new(tracer, view.clone(), Settings { bounces: 1, seed: 0, batch: 1 }).fingerprint();
        let bits = truth.irradiance.iter().flatten().map(|value| u64::from(value.to_bits()));
        let mask = truth.mask.iter().map(|kept| u64::from(*kept));
        // FNV-1a, a word at a time.
        let reference =
            bits.chain(mask).fold(0xcbf2_9ce4_8422_2325_u64, |h, word| (h ^ word).wrapping_mul(0x0100_0000_01b3));
        let own = json!({"scene_and_view": format!("{view:016x}"), "reference": format!("{reference:016x}")});
        let file = self.path.join("run.json");
        match std::fs::read(&file) {
            Ok(bytes) => {
                let old: Value = serde_json::from_slice(&bytes).unwrap_or_default();
                for (key, what) in [("scene_and_view", "scene, view or size"), ("reference", "reference")] {
                    let same = old[key] == own[key] || self.points.is_empty();
                    ensure!(same, "{:?} holds points of another {what}: choose another folder, or --fresh", self.path);
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => (),
            Err(error) => return Err(error).with_context(|| format!("cannot read {file:?}")),
        }
        write_atomic(&file, |sink| writeln!(sink, "{own:#}"))?;
        Ok(())
    }

    /// Whether a point of this key is there.
    pub fn has(&self, key: &str) -> bool {
        self.points.iter().any(|point| point.key() == key)
    }

    /// Adds a point with its picture; both are on disk when this returns.
    pub fn add(&mut self, mut point: Point, picture: &Picture) -> Result<()> {
        let name = format!("pictures/{}-{}.exr", point.text("method"), slug(&point));
        let settings = point.text("settings").to_owned();
        exr::write(&self.path.join(&name), picture, &[("settings", settings.as_str())])?;
        point.set("picture", name);
        self.points.push(point);
        self.save()
    }

    /// Takes over points of other programs; a newer one replaces that of the same key.
    pub fn merge(&mut self, others: Vec<Point>) -> Result<()> {
        for other in others {
            self.points.retain(|point| point.key() != other.key());
            self.points.push(other);
        }
        self.save()
    }

    fn save(&self) -> Result<()> {
        let rows: Vec<_> = self.points.iter().map(|point| point.row.clone()).collect();
        let text = csv::write(&COLUMNS, &rows);
        Ok(write_atomic(&self.table(), |sink| sink.write_all(text.as_bytes()))?)
    }

    /// The CSV file.
    pub fn table(&self) -> PathBuf {
        self.path.join("points.csv")
    }

    /// The picture of a point, where it has one that can be read.
    pub fn picture(&self, point: &Point) -> Option<Picture> {
        let name = point.text("picture");
        let file = Path::new(name);
        let inside = !name.is_empty() && file.components().all(|part| matches!(part, std::path::Component::Normal(_)));
        inside.then(|| exr::read(&self.path.join(file)).ok()).flatten()
    }
}

/// A file's name from the settings that points differ in, and the device: letters and digits, no two the same.
fn slug(point: &Point) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
    let words: String = point.words().replace(", ", "-").chars().map(plain).collect();
    let hash = point.key().bytes().fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
    format!("{words}-{hash:08x}")
}
