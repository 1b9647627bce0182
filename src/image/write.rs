//! Files that are either complete or not there.
//!
//! A file is written under a temporary name and renamed. A program that is stopped removes its temporary files
//! ([`remove_unfinished`]); those of one that was killed are removed by the next one that writes into the folder.

use std::fs::{self, File};
use std::io::{self, BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use thiserror::Error;

/// A file that could not be written; nothing of it is left, and a file that was there before is as it was.
#[derive(Debug, Error)]
#[error("cannot write {path:?}: {cause} ({remedy})", remedy = remedy(.cause))]
pub struct WriteError {
    /// The file that was asked for.
    pub path: PathBuf,
    /// What the system or the encoder said; part of the message, so no source of its own.
    pub cause: io::Error,
}

/// What an encoder writes into.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Writes `path` through `fill`: into a temporary file of the same folder, renamed over `path` when complete.
///
/// Links are followed. Something that is no plain file (`/dev/null`, a pipe) is written to directly, from memory.
pub fn write_atomic(path: &Path, fill: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<(), WriteError> {
    try_write(path, fill).map_err(|error| WriteError { path: path.to_owned(), cause: plain(error) })
}

/// The system's error without the temporary file's name, which means nothing to the reader.
fn plain(error: io::Error) -> io::Error {
    match error.to_string().split_once(" at path ") {
        Some((words, _)) => io::Error::new(error.kind(), words.to_owned()),
        None => error,
    }
}

fn try_write(path: &Path, fill: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> io::Result<()> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if target.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if target.exists() && !target.is_file() {
        let mut bytes = Cursor::new(Vec::new());
        fill(&mut bytes)?;
        return File::options().write(true).open(&target)?.write_all(bytes.get_ref());
    }
    // A rename would replace a protected file without asking it.
    if fs::metadata(&target).is_ok_and(|known| known.permissions().readonly()) {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    builder.permissions(permissions(&target));
    remove_abandoned(folder);
    let temporary = builder.tempfile_in(folder)?;
    let _registered = Registered::new(temporary.path());
    // Where a file system has no locks, age alone protects the file.
    let _ = temporary.as_file().lock();
    let mut buffered = BufWriter::new(temporary);
    fill(&mut buffered)?;
    let temporary = buffered.into_inner().map_err(|error| error.into_error())?;
    temporary.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

/// Start of a temporary file's name.
const PREFIX: &str = ".hemicube-";

/// Age from which an unlocked temporary file was left by a program that was killed: a live one locks its file at once.
const ABANDONED: Duration = Duration::from_secs(60);

/// Temporary files that this process writes now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

struct Registered(PathBuf);

impl Registered {
    fn new(path: &Path) -> Self {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.0);
    }
}

/// Removes the temporary files of this process, which is about to end; nothing of what they were to become is left.
pub fn remove_unfinished() {
    for path in UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        // It may have been renamed a moment ago.
        let _ = fs::remove_file(path);
    }
}

/// Removes temporary files that nobody writes: old and not locked. What cannot be read or removed stays.
fn remove_abandoned(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(PREFIX)) {
        let age = entry.metadata().ok().filter(fs::Metadata::is_file).and_then(|m| m.modified().ok()?.elapsed().ok());
        let is_free = || File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if age.is_some_and(|age| age >= ABANDONED) && is_free() {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Those of the file that is replaced, else the usual ones: temporary files are private by default, results are not.
#[cfg(unix)]
fn permissions(target: &Path) -> fs::Permissions {
    use std::os::unix::fs::PermissionsExt;
    fs::metadata(target).map_or_else(|_| fs::Permissions::from_mode(0o644), |known| known.permissions())
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "create the folder first",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "choose a file or folder that you may write to"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free some space or choose another folder",
        io::ErrorKind::IsADirectory => "name a file inside it",
        io::ErrorKind::NotADirectory => "a part of the path is a file; choose another folder",
        _ => "nothing was written; an older file of that name is unchanged",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomic(&path, |sink| sink.write_all(b"old")).unwrap();
        let error = write_atomic(&path, |sink| {
            sink.write_all(b"half of the n")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        let message = error.unwrap_err().to_string();
        assert!(message.contains("a.txt") && message.contains("free some space"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn files_of_killed_programs_are_removed_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let make = |name: &str, age: u64| {
            let file = File::create(folder.path().join(name)).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(age)).unwrap();
            file
        };
        make(".hemicube-old", 3600);
        make(".hemicube-new", 1);
        make(".other-old", 3600);
        let locked = make(".hemicube-locked", 3600);
        locked.lock().unwrap();
        write_atomic(&folder.path().join("a.txt"), |_| Ok(())).unwrap();
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, [".hemicube-locked", ".hemicube-new", ".other-old", "a.txt"]);
    }

    #[test]
    fn missing_folder_names_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_atomic(&folder.path().join("no/such/a.txt"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("create the folder first"), "{error}");
        assert!(!error.to_string().contains(".hemicube-"), "the temporary name is nobody's business: {error}");
        let error = write_atomic(folder.path(), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("name a file inside it"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_stay_as_they_are() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.txt"), folder.path().join("link.txt"));
        write_atomic(&path, |_| Ok(())).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o700, 0o600);
        assert_ne!(fs::metadata(&path).unwrap().permissions().mode() & 0o077, 0, "readable beyond the owner");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o400)).unwrap();
        let error = write_atomic(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(error.contains("read-only"), "{error}");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_atomic(&link, |sink| sink.write_all(b"through")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"through");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640, "as the old file");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_stay_devices() {
        write_atomic(Path::new("/dev/null"), |sink| sink.write_all(b"gone")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
