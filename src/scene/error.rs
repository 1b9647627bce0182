//! Why a scene could not be loaded: one line each, naming the file and the object in it.

use std::fmt;

/// Longest piece of a file's own text (a name, a URI) that a message repeats, in characters.
const LONGEST_QUOTE: usize = 80;

/// A scene that could not be loaded. The message is one line; `file` is the path as the user gave it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// The file, or one that it names, cannot be read.
    #[error("{file}: {what}")]
    Read {
        /// The scene's file.
        file: String,
        /// What was read and the system's reason.
        what: String,
    },
    /// Not a glTF 2.0 file at all.
    #[error("{file}: not a glTF 2.0 file: {what}")]
    NotGltf {
        /// The scene's file.
        file: String,
        /// What is wrong with it.
        what: String,
    },
    /// The file breaks a rule of the format, so that its meaning is unclear.
    #[error("{file}: {what}")]
    Invalid {
        /// The scene's file.
        file: String,
        /// The object and what is wrong with it.
        what: String,
    },
    /// The file needs a feature that this loader does not have.
    #[error("{file}: {what}")]
    Unsupported {
        /// The scene's file.
        file: String,
        /// The feature and the remedy.
        what: String,
    },
    /// The scene needs more memory than is allowed.
    #[error("{file}: {what}")]
    TooLarge {
        /// The scene's file.
        file: String,
        /// What is too large and the limit.
        what: String,
    },
    /// No triangle is left to render.
    #[error("{file}: the scene holds no triangles{what}")]
    Empty {
        /// The scene's file.
        file: String,
        /// What there was instead, if anything.
        what: String,
    },
    /// A camera was asked for that the scene does not have.
    #[error("{file}: {what}")]
    Camera {
        /// The scene's name.
        file: String,
        /// What was asked for and what there is.
        what: String,
    },
    /// A background that cannot be used.
    #[error("background {file}: {what}")]
    Background {
        /// The argument as given.
        file: String,
        /// What is wrong with it.
        what: String,
    },
}

/// Kind of a [`Fault`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Read,
    NotGltf,
    Invalid,
    Unsupported,
    TooLarge,
    Empty,
}

/// An error inside a file, before the file's name is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    pub kind: Kind,
    pub what: String,
}

pub(super) type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    pub fn new(kind: Kind, what: impl fmt::Display) -> Self {
        Self { kind, what: what.to_string() }
    }

    pub fn invalid(what: impl fmt::Display) -> Self {
        Self::new(Kind::Invalid, what)
    }

    /// The same fault, found while working on `object`.
    pub fn within(self, object: impl fmt::Display) -> Self {
        Self { kind: self.kind, what: format!("{object}: {}", self.what) }
    }

    pub fn in_file(self, file: &str) -> SceneError {
        let (file, what) = (one_line(file, usize::MAX), one_line(&self.what, usize::MAX));
        match self.kind {
            Kind::Read => SceneError::Read { file, what },
            Kind::NotGltf => SceneError::NotGltf { file, what },
            Kind::Invalid => SceneError::Invalid { file, what },
            Kind::Unsupported => SceneError::Unsupported { file, what },
            Kind::TooLarge => SceneError::TooLarge { file, what },
            Kind::Empty => SceneError::Empty { file, what },
        }
    }
}

/// Names the object that a fault was found in.
pub(super) trait Within<T> {
    /// The same result, its fault said to be in `object`.
    fn within<D: fmt::Display>(self, object: impl FnOnce() -> D) -> Result<T>;
}

impl<T> Within<T> for Result<T> {
    fn within<D: fmt::Display>(self, object: impl FnOnce() -> D) -> Result<T> {
        self.map_err(|fault| fault.within(object()))
    }
}

/// `kind index "name"`, as messages name an object of the file.
pub(super) fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} \"{}\"", quote(name)),
        _ => format!("{kind} {index}"),
    }
}

/// A file's own text, shortened and without control characters.
pub(super) fn quote(text: &str) -> String {
    one_line(text, LONGEST_QUOTE)
}

fn one_line(text: &str, longest: usize) -> String {
    let mut out: String = text.chars().take(longest).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(longest).is_some() {
        out.push('…');
    }
    out
}
