//! Compiled pipelines kept on disk, so that a later run starts sooner.
//!
//! A file for each device, driver version and set of shaders, in the platform's cache directory or in the one that
//! [`VARIABLE`] names; where that is empty, nothing is kept. A file that is torn or not of this program is not handed to the
//! driver.

use super::error::{Context, Result};
use super::instance::{Instance, PhysicalDevice};
use ash::vk;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The environment variable that names another directory; empty: none.
pub const VARIABLE: &str = "HEMICUBE_CACHE_DIR";

const MAGIC: &[u8; 8] = b"HEMIPC01";
const HEADER: usize = MAGIC.len() + 8;

/// The driver's cache, and the file that it comes from and goes to.
pub(super) struct PipelineCache {
    pub(super) raw: vk::PipelineCache,
    file: Option<PathBuf>,
    loaded: Vec<u8>,
    /// What happened to the file, in words.
    pub(super) note: String,
}

impl PipelineCache {
    /// A cache for `device`, filled from its file in `directory` where there is one that fits.
    pub(super) fn load(
        instance: &Instance,
        physical: &PhysicalDevice,
        device: &ash::Device,
        directory: Option<&Path>,
    ) -> Result<Self> {
        let file = directory.map(|directory| directory.join(file_name(instance, physical)));
        let (loaded, note) = match &file {
            None => (Vec::new(), "compiled pipelines are not kept".to_owned()),
            Some(file) => match std::fs::read(file) {
                Err(_) => (Vec::new(), format!("compiled pipelines: no {} yet", file.display())),
                Ok(bytes) => match checked(&bytes) {
                    Some(data) => {
                        (data.to_vec(), format!("compiled pipelines: {} kB of {}", data.len() / 1000, file.display()))
                    }
                    None => {
                        (Vec::new(), format!("compiled pipelines: {} is torn or foreign, and ignored", file.display()))
                    }
                },
            },
        };
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&loaded);
        // SAFETY: the data was written by this driver for this device, and is whole.
        let raw = unsafe { device.create_pipeline_cache(&info, None) }.during("creating the pipeline cache")?;
        Ok(Self { raw, file, loaded, note })
    }

    /// Writes the file, whole or not at all, where it has grown. What fails costs the next run time, and nothing else.
    pub(super) fn save(&self, device: &ash::Device) {
        let Some(file) = &self.file else { return };
        // SAFETY: the cache is alive.
        let Ok(data) = (unsafe { device.get_pipeline_cache_data(self.raw) }) else { return };
        if data != self.loaded {
            let _ = write(file, &data);
        }
    }
}

/// The directory by [`VARIABLE`], else the platform's.
pub(super) fn directory() -> Option<PathBuf> {
    let path = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    if std::env::var_os(VARIABLE).is_some() {
        return path(VARIABLE);
    }
    let caches = if cfg!(target_os = "windows") {
        path("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        path("HOME").map(|home| home.join("Library/Caches"))
    } else {
        path("XDG_CACHE_HOME").or_else(|| path("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("hemicube"))
}

/// By the device, its driver's version, and this program's shaders.
fn file_name(instance: &Instance, physical: &PhysicalDevice) -> String {
    // SAFETY: the handle comes from this instance.
    let properties = unsafe { instance.raw.get_physical_device_properties(physical.raw) };
    let uuid: String = properties.pipeline_cache_uuid.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("pipelines-{uuid}-{:08x}-{}.bin", properties.driver_version, env!("HEMICUBE_SHADERS"))
}

/// The content of a file, where its header and its sum are right.
fn checked(bytes: &[u8]) -> Option<&[u8]> {
    let (header, data) = bytes.split_at_checked(HEADER)?;
    (header == header_of(data)).then_some(data)
}

fn header_of(data: &[u8]) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    header[..MAGIC.len()].copy_from_slice(MAGIC);
    header[MAGIC.len()..].copy_from_slice(&sum(data).to_le_bytes());
    header
}

/// FNV-1a over the bytes (Fowler, Noll and Vo 1991), 64 bits.
fn sum(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

fn write(file: &Path, data: &[u8]) -> std::io::Result<()> {
    let directory = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(directory)?;
    let mut temporary = tempfile::NamedTempFile::new_in(directory)?;
    temporary.write_all(&header_of(data))?;
    temporary.write_all(data)?;
    temporary.persist(file)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_back_and_a_torn_or_foreign_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deeper/pipelines.bin");
        write(&file, b"compiled").unwrap();
        let bytes = std::fs::read(&file).unwrap();
        assert_eq!(checked(&bytes), Some(b"compiled".as_slice()));
        assert_eq!(checked(&bytes[..bytes.len() - 1]), None, "torn");
        assert_eq!(checked(b"something else altogether"), None, "foreign");
        assert_eq!(checked(b""), None);
    }
}
