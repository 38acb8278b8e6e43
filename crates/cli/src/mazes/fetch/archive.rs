//! Unpacking an archive in memory. Its content is not trusted.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::Read;

use flate2::bufread::{DeflateDecoder, GzDecoder};
use mmsim_formats::MAX_FILE_BYTES;
use mmsim_maze::Excerpt;
use rawzip::{CompressionMethod, ZipArchive};
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

enum Kind {
    File,
    Folder,
    Unsupported(&'static str),
}

const LINK: Kind = Kind::Unsupported("a symbolic link");
const SPECIAL: Kind = Kind::Unsupported("neither a file nor a folder");

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
        let start = Excerpt::<40>::new(archive).to_string();
        let found = if archive.is_empty() { "an empty file" } else { &start };
        Err(format!("expected a .tar.gz, .zip or .tar archive, found {found}"))
    }
}

/// Decompresses all members of a gzip file. Zeros may follow, as with GNU gzip.
fn gunzip(mut packed: &[u8]) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::new();
    while packed.iter().any(|&byte| byte != 0) {
        let left = MAX_UNPACKED_BYTES + 1 - unpacked.len() as u64;
        GzDecoder::new(&mut packed).take(left).read_to_end(&mut unpacked).map_err(damaged)?;
        check_unpacked(unpacked.len() as u64)?;
    }
    Ok(unpacked)
}

impl Contents {
    fn from_tar(tar: &[u8]) -> Result<Self, String> {
        let mut contents = Self::default();
        for entry in tar::Archive::new(tar).entries().map_err(damaged)? {
            let entry = entry.map_err(damaged)?;
            let kind = match entry.header().entry_type() {
                // Metadata for all entries, such as the commit of the archive.
                EntryType::XGlobalHeader => continue,
                EntryType::Directory => Kind::Folder,
                EntryType::Regular => Kind::File,
                EntryType::Symlink => LINK,
                EntryType::Link => Kind::Unsupported("a hard link"),
                _ => SPECIAL,
            };
            let name = entry.path_bytes().into_owned();
            contents.add(&name, &kind, entry)?;
        }
        // Blocks of zeros mark the end.
        if !tar.ends_with(&[0; 512]) {
            return Err(damaged("its end is missing"));
        }
        Ok(contents)
    }

    fn from_zip(zip: &[u8]) -> Result<Self, String> {
        const METHODS: [CompressionMethod; 2] =
            [CompressionMethod::STORE, CompressionMethod::DEFLATE];
        let mut contents = Self::default();
        let archive = ZipArchive::from_slice(zip).map_err(damaged)?;
        let mut entries = archive.entries();
        while let Some(entry) = entries.next_entry().map_err(damaged)? {
            let method = entry.compression_method();
            // The Unix mode, whatever system the entry claims to come from; not every tool sets it.
            let kind = match (entry.external_attributes() >> 16) & 0o170_000 {
                0o040_000 => Kind::Folder,
                0o120_000 => LINK,
                0 | 0o100_000 if entry.flags().is_encrypted() => Kind::Unsupported("encrypted"),
                0 | 0o100_000 if METHODS.contains(&method) => Kind::File,
                0 | 0o100_000 => Kind::Unsupported("compressed by another method than deflate"),
                _ => SPECIAL,
            };
            // Some tools for Windows write backslashes.
            let slash = |&byte: &u8| if byte == b'\\' { b'/' } else { byte };
            let name: Vec<u8> = entry.file_path().as_ref().iter().map(slash).collect();
            let data = archive.get_entry(entry.wayfinder()).map_err(damaged)?;
            // The readers verify size and checksum.
            if method == CompressionMethod::STORE {
                contents.add(&name, &kind, data.verifying_reader(data.data()))?;
            } else {
                let content = data.verifying_reader(DeflateDecoder::new(data.data()));
                contents.add(&name, &kind, content)?;
            }
        }
        if contents.entries as u64 != archive.entries_hint() {
            return Err(damaged(format!("{} entries are missing", archive.entries_hint())));
        }
        Ok(contents)
    }

    fn add(&mut self, name: &[u8], kind: &Kind, content: impl Read) -> Result<(), String> {
        let shown = Excerpt::<80>::new(name);
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(format!("more than {MAX_ENTRIES} entries"));
        }
        let path = path::inside(name).map_err(|problem| format!("entry {shown} {problem}"))?;
        match (kind, path) {
            (Kind::Unsupported(what), _) => return Err(format!("entry {shown} is {what}")),
            (Kind::Folder, _) => {}
            (Kind::File, _) if name.ends_with(b"/") => {}
            (Kind::File, None) => self.invalid_names.push(shown.to_string()),
            (Kind::File, Some(path)) => {
                let mut bytes = Vec::new();
                (content.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
                    .map_err(|error| format!("entry {shown} is damaged: {error}"))?;
                if bytes.len() as u64 > MAX_FILE_BYTES {
                    return Err(format!("entry {shown} is larger than {MAX_FILE_BYTES} bytes"));
                }
                self.bytes += bytes.len() as u64;
                check_unpacked(self.bytes)?;
                self.files.insert(path, bytes);
            }
        }
        Ok(())
    }
}

fn check_unpacked(bytes: u64) -> Result<(), String> {
    let is_within = bytes <= MAX_UNPACKED_BYTES;
    let error = || format!("content is larger than {} MiB", MAX_UNPACKED_BYTES >> 20);
    is_within.then_some(()).ok_or_else(error)
}

fn damaged(error: impl Display) -> String {
    format!("damaged archive: {error}")
}
