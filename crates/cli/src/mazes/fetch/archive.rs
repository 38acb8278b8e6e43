//! What is in an archive. Nothing of it is trusted, and nothing of it is written anywhere.

use std::collections::BTreeMap;
use std::io::{self, Read};

use flate2::bufread::{DeflateDecoder, GzDecoder};
use mmsim_formats::MAX_FILE_BYTES;
use rawzip::{CompressionMethod, ZipArchive, ZipFileHeaderRecord};
use tar::EntryType;

use super::path;

/// The largest archive that is read, in bytes; that of the public collection has less than one MiB.
pub(super) const MAX_ARCHIVE_BYTES: u64 = 32 << 20;
/// What all of it may be at most, in bytes.
const MAX_UNPACKED_BYTES: u64 = 32 << 20;
const MAX_ENTRIES: usize = 20_000;

/// The files of an archive, by their paths with `/` between.
pub(super) type Files = BTreeMap<String, Vec<u8>>;

/// What is wrong with an archive, and where in it.
#[derive(Debug, thiserror::Error)]
pub(super) enum Refused {
    #[error("expected {expected}, found {found}")]
    Archive { expected: String, found: String },
    #[error("its entry {name}: expected {expected}, found {found}")]
    Entry { name: String, expected: String, found: String },
    #[error("expected a whole archive, found a broken one: {0}")]
    Broken(String),
}

/// What an entry is.
enum Kind {
    File,
    Folder,
    /// Nothing that a collection of mazes needs.
    Other(&'static str),
}

/// All files of an archive, whose kind is told from its content.
///
/// # Errors
/// What is no archive, is broken or goes beyond a limit, an entry that leads out of it, and one that
/// is neither file nor folder.
pub(super) fn unpack(archive: &[u8]) -> Result<Contents, Refused> {
    const USTAR: std::ops::Range<usize> = 257..262;
    if archive.starts_with(&[0x1f, 0x8b]) {
        let mut tar = Vec::new();
        let unpacked = gunzip(archive, &mut tar);
        let is_whole = unpacked.map(|()| tar.len() as u64 <= MAX_UNPACKED_BYTES);
        // What is wrong with an entry says more than that there is too much of all.
        let contents = Contents::from_tar(&tar);
        match (is_whole, contents) {
            (_, Err(refused @ (Refused::Entry { .. } | Refused::Archive { .. }))) => Err(refused),
            (Err(error), _) => Err(Refused::Broken(error.to_string())),
            (Ok(false), _) => Err(too_large()),
            (Ok(true), contents) => contents,
        }
    } else if archive.starts_with(b"PK\x03\x04") || archive.starts_with(b"PK\x05\x06") {
        Contents::from_zip(archive)
    } else if archive.get(USTAR) == Some(b"ustar") {
        Contents::from_tar(archive)
    } else {
        let begin = String::from_utf8_lossy(&archive[..archive.len().min(40)]);
        let found = if archive.is_empty() { "an empty file".into() } else { format!("{begin:?}") };
        Err(Refused::Archive { expected: "a .tar.gz, .zip or .tar archive".into(), found })
    }
}

/// Unpacks up to a little more than an archive may have, from several parts, each packed on its own.
/// As with other tools zeros may follow, such as fill the last block of a tape.
fn gunzip(mut packed: &[u8], unpacked: &mut Vec<u8>) -> io::Result<()> {
    while packed.iter().any(|&byte| byte != 0) && unpacked.len() as u64 <= MAX_UNPACKED_BYTES {
        let left = MAX_UNPACKED_BYTES + 1 - unpacked.len() as u64;
        GzDecoder::new(&mut packed).take(left).read_to_end(unpacked)?;
    }
    Ok(())
}

/// What was read so far.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) files: Files,
    /// Files whose names not every system can have, as messages show them.
    pub(super) odd: Vec<String>,
    entries: usize,
    bytes: u64,
}

impl Contents {
    fn from_tar(tar: &[u8]) -> Result<Self, Refused> {
        let broken = |error: io::Error| Refused::Broken(error.to_string());
        let mut contents = Self::default();
        for entry in tar::Archive::new(tar).entries().map_err(broken)? {
            let entry = entry.map_err(broken)?;
            let kind = match entry.header().entry_type() {
                // What holds for all entries, such as the commit that the archive was made of.
                EntryType::XGlobalHeader => continue,
                EntryType::Directory => Kind::Folder,
                EntryType::Regular if entry.path_bytes().ends_with(b"/") => Kind::Folder,
                EntryType::Regular => Kind::File,
                EntryType::Symlink => Kind::Other("a symbolic link"),
                EntryType::Link => Kind::Other("a hard link"),
                EntryType::Char | EntryType::Block => Kind::Other("a device"),
                EntryType::Fifo => Kind::Other("a pipe"),
                _ => Kind::Other("something else"),
            };
            let (name, size) = (entry.path_bytes().into_owned(), entry.size());
            contents.add(&name, &kind, size, entry)?;
        }
        // Blocks of zeros mark the end.
        if !tar.ends_with(&[0; 512]) {
            return Err(Refused::Broken("its end is missing".into()));
        }
        Ok(contents)
    }

    fn from_zip(zip: &[u8]) -> Result<Self, Refused> {
        let broken = |error: rawzip::Error| Refused::Broken(error.to_string());
        let mut contents = Self::default();
        let archive = ZipArchive::from_slice(zip).map_err(broken)?;
        let mut entries = archive.entries();
        while let Some(entry) = entries.next_entry().map_err(broken)? {
            let (name, size) = (entry.file_path(), entry.uncompressed_size_hint());
            // Some tools for Windows write its separators.
            let name: Vec<u8> =
                name.as_ref().iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
            let kind = kind_in_zip(&entry, &name);
            if !matches!(kind, Kind::File) {
                contents.add(&name, &kind, size, io::empty())?;
                continue;
            }
            let data = archive.get_entry(entry.wayfinder()).map_err(broken)?;
            // Size and checksum are verified as it is read.
            if entry.compression_method() == CompressionMethod::STORE {
                contents.add(&name, &kind, size, data.verifying_reader(data.data()))?;
            } else {
                let content = data.verifying_reader(DeflateDecoder::new(data.data()));
                contents.add(&name, &kind, size, content)?;
            }
        }
        if contents.entries as u64 != archive.entries_hint() {
            return Err(Refused::Broken(format!("{} entries are missing", archive.entries_hint())));
        }
        Ok(contents)
    }

    /// Takes an entry in that says of itself to have `size` bytes.
    fn add(
        &mut self,
        name: &[u8],
        kind: &Kind,
        size: u64,
        content: impl Read,
    ) -> Result<(), Refused> {
        let refused = |(expected, found): (String, String)| Refused::Entry {
            name: path::shown(name),
            expected,
            found,
        };
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            let expected = format!("at most {MAX_ENTRIES} entries");
            return Err(Refused::Archive { expected, found: "more".into() });
        }
        if let Kind::Other(found) = *kind {
            return Err(refused(("a file or a folder".into(), found.into())));
        }
        let path = path::inside(name)
            .map_err(|found| refused(("a path inside of the archive".into(), found.into())))?;
        let at_most = || format!("at most {MAX_FILE_BYTES} bytes");
        if size > MAX_FILE_BYTES {
            return Err(refused((at_most(), size.to_string())));
        }
        if let Kind::Folder = kind {
            return Ok(());
        }
        let Some(path) = path else {
            self.odd.push(path::shown(name));
            return Ok(());
        };
        let mut bytes = Vec::new();
        content
            .take(MAX_FILE_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| refused(("its whole content".into(), error.to_string())))?;
        self.bytes += bytes.len() as u64;
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(refused((at_most(), "more".into())));
        }
        if self.bytes > MAX_UNPACKED_BYTES {
            return Err(too_large());
        }
        self.files.insert(path, bytes);
        Ok(())
    }
}

/// What an entry of this name is. Its mode is above the attributes that Windows has, and is believed
/// whatever system is said to have made it.
fn kind_in_zip(entry: &ZipFileHeaderRecord<'_>, name: &[u8]) -> Kind {
    const TYPE: u32 = 0o170_000;
    const METHODS: [CompressionMethod; 2] = [CompressionMethod::STORE, CompressionMethod::DEFLATE];
    match (entry.external_attributes() >> 16) & TYPE {
        0o120_000 => Kind::Other("a symbolic link"),
        0o040_000 => Kind::Folder,
        0 | 0o100_000 if name.ends_with(b"/") => Kind::Folder,
        // Not every tool says what it is.
        0 | 0o100_000 if entry.flags().is_encrypted() => Kind::Other("an encrypted file"),
        0 | 0o100_000 if METHODS.contains(&entry.compression_method()) => Kind::File,
        0 | 0o100_000 => Kind::Other("a file packed by another method than deflate"),
        _ => Kind::Other("a device or a pipe"),
    }
}

fn too_large() -> Refused {
    let expected = format!("at most {} MiB in all", MAX_UNPACKED_BYTES >> 20);
    Refused::Archive { expected, found: "more".into() }
}
