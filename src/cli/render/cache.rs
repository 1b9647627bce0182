//! Records in a file: `--cache` and `--cache-ro`.

use crate::cli::common::check_output;
use crate::cli::stop;
use anyhow::Result;
use clap::Args;
use hemicube::methods::records::Stored;
use hemicube::methods::records::file::{self, Origin, Packed};
use hemicube::renderer::{Renderer, Settings};
use hemicube::scene::Scene;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Where records are kept.
#[derive(Args, Clone, Debug)]
pub struct CacheArgs {
    /// Use the records that FILE holds, and add new ones to it
    ///
    /// A run that needs no new record gives the same bits as the one that wrote the file. Records are of one scene, its lights and the
    /// settings of the irradiance cache: a file of others, or a damaged one, is refused. Views and image sizes may differ. The file
    /// is replaced as a whole, after each frame that needs new records; two runs must not write it at once.
    #[arg(long, value_name = "FILE", help_heading = "Irradiance cache")]
    cache: Option<PathBuf>,
    /// Use the records that FILE holds, and leave it as it is; any number of runs may read it
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with = "cache",
        help_heading = "Irradiance cache",
        hide_short_help = true
    )]
    cache_ro: Option<PathBuf>,
}

/// A file of records that a run uses.
pub struct RecordFile {
    path: PathBuf,
    writes: bool,
    origin: Origin,
    /// What it held.
    stored: Option<Stored>,
    /// Records in it.
    count: u32,
    read: u32,
    packed: Packed,
}

impl CacheArgs {
    /// Fails before any work if the file cannot be written or is none.
    pub fn check(&self) -> Result<()> {
        self.cache.as_deref().map_or(Ok(()), check_output)
    }

    /// Reads the file that the flags name, if they name one. One that is to be written need not be there yet.
    pub fn open(&self, scene: &Scene, settings: &Settings) -> Result<Option<RecordFile>> {
        let (path, writes) = match (&self.cache, &self.cache_ro) {
            (Some(path), _) => (path, true),
            (None, Some(path)) => (path, false),
            (None, None) => return Ok(None),
        };
        let origin = Origin::of(scene, settings);
        let begins = writes && !path.exists();
        let stored = if begins { None } else { Some(file::read(path, &origin)?) };
        let count = stored.as_ref().map_or(0, Stored::count);
        let file =
            RecordFile { path: path.clone(), writes, origin, stored, count, read: count, packed: Packed::default() };
        Ok(Some(file))
    }
}

impl RecordFile {
    /// Whether its records are of that scene.
    pub fn is_of(&self, scene: &Scene, settings: &Settings) -> bool {
        self.origin == Origin::of(scene, settings)
    }

    /// Gives the renderer what the file held.
    pub fn fill(&mut self, renderer: &mut Renderer<'_>) -> Result<()> {
        if let Some(stored) = self.stored.take() {
            renderer.use_records(&stored)?;
        }
        Ok(())
    }

    /// Writes the renderer's records, if there are more than the file has.
    pub fn save(&mut self, renderer: &Renderer<'_>) -> Result<()> {
        if !self.writes || renderer.record_count() <= self.count {
            return Ok(());
        }
        if let Some(stored) = renderer.records()? {
            self.packed.write(&self.path, &self.origin, &stored)?;
            self.count = stored.count();
            stop::keeps_records(format!("{} holds {} records", self.path.display(), self.count));
        }
        Ok(())
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was read and what it holds now, for the statistics.
    pub fn stats(&self) -> Value {
        json!({"file": self.path.display().to_string(), "read": self.read, "records": self.count})
    }
}
