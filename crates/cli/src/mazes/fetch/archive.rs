//! Unpacking an archive in memory. Its content is not trusted.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::{self, Read};

use flate2::bufread::{DeflateDecoder, GzDecoder};
use mmsim_formats::MAX_FILE_BYTES;
use rawzip::{CompressionMethod, ZipArchive, ZipFileHeaderRecord};
use tar::EntryType;

use super::path;

/// The maximum size of an archive in bytes. The public collection has less than 1 MiB.
pub(super) const MAX_ARCHIVE_BYTES: u64 = 32 << 20;
/// The maximum size of its content in bytes.
const MAX_UNPACKED_BYTES: u64 = 32 << 20;
const MAX_ENTRIES: usize = 20_000;

/// The files of an archive by their paths, which are relative and separated by `/`.
pub(super) type Files = BTreeMap<String, Vec<u8>>;

/// The content of an archive.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) files: Files,
    /// The names of skipped files, which are not valid on every system, quoted for messages.
    pub(super) invalid_names: Vec<String>,
    entries: usize,
    bytes: u64,
}

/// Unpacks a .tar.gz, .zip or .tar archive, detected from its content.
///
/// # Errors
/// The archive is damaged or over a limit, or an entry leads outside or is neither file nor folder.
pub(super) fn unpack(archive: &[u8]) -> Result<Contents, String> {
    const USTAR: std::ops::Range<usize> = 257..262;
    if archive.starts_with(&[0x1f, 0x8b]) {
        Contents::from_tar(&gunzip(archive)?)
    } else if archive.starts_with(b"PK\x03\x04") || archive.starts_with(b"PK\x05\x06") {
        Contents::from_zip(archive)
    } else if archive.get(USTAR) == Some(b"ustar") {
        Contents::from_tar(archive)
    } else {
        let start = String::from_utf8_lossy(&archive[..archive.len().min(40)]);
        let found = if archive.is_empty() { "an empty file".into() } else { format!("{start:?}") };
        Err(format!("expected a .tar.gz, .zip or .tar archive, found {found}"))
    }
}

/// Decompresses all members of a gzip file. Zeros may follow, as with GNU gzip.
fn gunzip(mut packed: &[u8]) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::new();
    while packed.iter().any(|&byte| byte != 0) {
        let left = MAX_UNPACKED_BYTES + 1 - unpacked.len() as u64;
        GzDecoder::new(&mut packed).take(left).read_to_end(&mut unpacked).map_err(damaged)?;
        if unpacked.len() as u64 > MAX_UNPACKED_BYTES {
            return Err(too_large());
        }
    }
    Ok(unpacked)
}

impl Contents {
    fn from_tar(tar: &[u8]) -> Result<Self, String> {
        let mut contents = Self::default();
        for entry in tar::Archive::new(tar).entries().map_err(damaged)? {
            let entry = entry.map_err(damaged)?;
            let name = entry.path_bytes().into_owned();
            let is_folder = match entry.header().entry_type() {
                // Metadata for all entries, such as the commit of the archive.
                EntryType::XGlobalHeader => continue,
                EntryType::Directory => true,
                EntryType::Regular => name.ends_with(b"/"),
                EntryType::Symlink => return Err(unsupported(&name, "a symbolic link")),
                EntryType::Link => return Err(unsupported(&name, "a hard link")),
                _ => return Err(unsupported(&name, "neither a file nor a folder")),
            };
            contents.add(&name, is_folder, entry)?;
        }
        // Blocks of zeros mark the end.
        if !tar.ends_with(&[0; 512]) {
            return Err(damaged("its end is missing"));
        }
        Ok(contents)
    }

    fn from_zip(zip: &[u8]) -> Result<Self, String> {
        let mut contents = Self::default();
        let archive = ZipArchive::from_slice(zip).map_err(damaged)?;
        let mut entries = archive.entries();
        while let Some(entry) = entries.next_entry().map_err(damaged)? {
            // Some tools for Windows write backslashes.
            let name = entry.file_path().as_ref().to_vec();
            let name: Vec<u8> =
                name.into_iter().map(|b| if b == b'\\' { b'/' } else { b }).collect();
            if is_folder_in_zip(&entry, &name)? {
                contents.add(&name, true, io::empty())?;
                continue;
            }
            let data = archive.get_entry(entry.wayfinder()).map_err(damaged)?;
            // The readers verify size and checksum.
            if entry.compression_method() == CompressionMethod::STORE {
                contents.add(&name, false, data.verifying_reader(data.data()))?;
            } else {
                let content = data.verifying_reader(DeflateDecoder::new(data.data()));
                contents.add(&name, false, content)?;
            }
        }
        if contents.entries as u64 != archive.entries_hint() {
            return Err(damaged(format!("{} entries are missing", archive.entries_hint())));
        }
        Ok(contents)
    }

    fn add(&mut self, name: &[u8], is_folder: bool, content: impl Read) -> Result<(), String> {
        let shown = path::shown(name);
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(format!("more than {MAX_ENTRIES} entries"));
        }
        let path = path::inside(name).map_err(|problem| format!("entry {shown} {problem}"))?;
        if is_folder {
            return Ok(());
        }
        let Some(path) = path else {
            self.invalid_names.push(shown);
            return Ok(());
        };
        let mut bytes = Vec::new();
        let mut content = content.take(MAX_FILE_BYTES + 1);
        content
            .read_to_end(&mut bytes)
            .map_err(|error| format!("entry {shown} is damaged: {error}"))?;
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(format!("entry {shown} is larger than {MAX_FILE_BYTES} bytes"));
        }
        self.bytes += bytes.len() as u64;
        if self.bytes > MAX_UNPACKED_BYTES {
            return Err(too_large());
        }
        self.files.insert(path, bytes);
        Ok(())
    }
}

/// Whether an entry is a folder. Its Unix mode, in the upper half of the attributes, is used whatever
/// system it claims to come from; not every tool sets it.
fn is_folder_in_zip(entry: &ZipFileHeaderRecord<'_>, name: &[u8]) -> Result<bool, String> {
    const TYPE: u32 = 0o170_000;
    const METHODS: [CompressionMethod; 2] = [CompressionMethod::STORE, CompressionMethod::DEFLATE];
    match (entry.external_attributes() >> 16) & TYPE {
        0o040_000 => Ok(true),
        0 | 0o100_000 if name.ends_with(b"/") => Ok(true),
        0 | 0o100_000 if entry.flags().is_encrypted() => Err(unsupported(name, "encrypted")),
        0 | 0o100_000 if METHODS.contains(&entry.compression_method()) => Ok(false),
        0 | 0o100_000 => Err(unsupported(name, "compressed by another method than deflate")),
        0o120_000 => Err(unsupported(name, "a symbolic link")),
        _ => Err(unsupported(name, "neither a file nor a folder")),
    }
}

fn unsupported(name: &[u8], what: &str) -> String {
    format!("entry {} is {what}", path::shown(name))
}

fn damaged(error: impl Display) -> String {
    format!("damaged archive: {error}")
}

fn too_large() -> String {
    format!("content is larger than {} MiB", MAX_UNPACKED_BYTES >> 20)
}
