//! Vehicles by name or file.

use alloc::string::{String, ToString as _};
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use mmsim_maze::Escaped;

use super::VehicleFileError;
use crate::vehicle::Vehicle;

/// The maximum size of a file, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The error for a text that names neither a preset nor the file of a vehicle.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadVehicleError {
    /// The text is the name of neither a preset nor a file.
    #[error("expected {} or a TOML file, found {found:?}", Vehicle::PRESETS.join(", "))]
    Unknown {
        /// The text.
        found: String,
    },
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The path.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file does not describe a possible vehicle.
    #[error("{}: {source}", path.display())]
    Invalid {
        /// The path.
        path: PathBuf,
        /// What is wrong.
        source: VehicleFileError,
    },
}

impl Vehicle {
    /// Returns the preset with this name, or reads a TOML file of at most 1 MiB. Without a name of its
    /// own, the vehicle is named after the file.
    ///
    /// ```
    /// use mmsim_fastrun::Vehicle;
    /// assert_eq!(Vehicle::load("ares")?, Vehicle::ares());
    /// # Ok::<(), mmsim_fastrun::LoadVehicleError>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if there is neither such a preset nor such a file, or if the file is invalid.
    pub fn load(text: &str) -> Result<Self, LoadVehicleError> {
        if let Some(vehicle) = Self::preset(text) {
            return Ok(vehicle);
        }
        let path = Path::new(text);
        let is_name = path.components().count() == 1 && path.extension().is_none();
        if is_name && !path.exists() {
            return Err(LoadVehicleError::Unknown { found: text.into() });
        }
        let toml =
            read(path).map_err(|source| LoadVehicleError::Read { path: path.into(), source });
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::from_toml(&toml?, &Escaped(name).to_string())
            .map_err(|source| LoadVehicleError::Invalid { path: path.into(), source })
    }
}

fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(io::Error::other("larger than 1 MiB"));
    }
    Ok(text)
}
