//! glTF 2.0 in: container, document, buffers, accessors, and what is made of them.
//!
//! The `gltf` crate's own validation and readers are not used: they refuse files with required extensions that this
//! loader understands, and read single precision only.

pub(super) mod accessor;
pub(super) mod animation;
pub(super) mod assemble;
pub(super) mod buffers;
pub(super) mod compressed;
pub(super) mod container;
pub(super) mod deform;
pub(super) mod document;
pub(super) mod draco;
pub(super) mod extensions;
pub(super) mod lights;
pub(super) mod materials;
pub(super) mod nodes;
pub(super) mod primitive;
pub(super) mod tangents;
pub(super) mod textures;
pub(super) mod views;

use super::error;

/// Different notes kept: a file can be made that deserves any number.
const MOST_NOTES: usize = 100;

/// Remarks for the user, each one once, with a count where it repeats.
#[derive(Default)]
pub(super) struct Notes(Vec<(String, usize)>);

impl Notes {
    /// Remembers `note`; a repeated note is counted.
    pub fn add(&mut self, note: impl Into<String>) {
        self.add_times(note, 1);
    }

    /// Remembers `note` as seen `times` times.
    pub fn add_times(&mut self, note: impl Into<String>, times: usize) {
        let note = note.into();
        match self.0.iter().position(|(known, _)| *known == note) {
            Some(place) => self.0[place].1 += times,
            None if self.0.len() < MOST_NOTES => self.0.push((note, times)),
            None => {}
        }
    }

    /// Adds all of `other`.
    pub fn append(&mut self, other: Self) {
        other.0.into_iter().for_each(|(note, times)| self.add_times(note, times));
    }

    /// Remembers `note` if `seen`.
    pub fn add_if(&mut self, note: &str, seen: bool) {
        self.add_times_if(note, usize::from(seen));
    }

    /// Remembers `note` as seen `times` times, unless that is none.
    pub fn add_times_if(&mut self, note: &str, times: usize) {
        if times > 0 {
            self.add_times(note, times);
        }
    }

    /// One line a note.
    pub fn into_lines(self) -> Vec<String> {
        self.0.into_iter().map(|(note, n)| if n > 1 { format!("{note} ({n}×)") } else { note }).collect()
    }
}
