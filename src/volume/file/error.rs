//! Errors of reading a volume.

use super::VERSION;
use std::path::PathBuf;

/// A volume that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum VolumeError {
    /// The system cannot read the file.
    #[error("cannot read the volume {path:?}: {cause}")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: std::io::Error,
    },
    /// The file is not a volume's JSON, or ends too early.
    #[error("{path:?} is not a volume, or not whole: {cause}; bake it again with `hemicube bake volume`")]
    Torn {
        /// The file.
        path: PathBuf,
        /// The parser's error.
        cause: serde_json::Error,
    },
    /// The file has another version.
    #[error("{path:?} is a volume of version {version}; this program reads version {VERSION}: bake it again")]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        version: u32,
    },
    /// The contents contradict each other, or lie outside of what a volume can have.
    #[error("{path:?}: {what}; bake it again with `hemicube bake volume`")]
    Wrong {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}
