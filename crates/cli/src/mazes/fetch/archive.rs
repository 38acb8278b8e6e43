//! Unpacks an untrusted archive in memory, and validates its paths.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::io::Read;

use flate2::bufread::{DeflateDecoder, GzDecoder};
use mmsim_formats::MAX_FILE_BYTES;
use mmsim_maze::Excerpt;
use rawzip::{CompressionMethod, ZipArchive};
use tar::EntryType;

/// The maximum size of an archive in bytes. The archive of the public collection is under 1 MiB.
pub(super) const MAX_ARCHIVE_BYTES: u64 = 32 << 20;
/// The maximum total size of the unpacked files in bytes.
const MAX_UNPACKED_BYTES: u64 = 32 << 20;
const MAX_ENTRIES: usize = 20_000;

/// Maps relative file paths, with `/` as the separator, to file contents.
pub(super) type Files = BTreeMap<String, Vec<u8>>;

/// The unpacked content of an archive.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) files: Files,
    /// The names of skipped files, quoted for messages. A file is skipped if its name is not valid
    /// on every system.
    pub(super) invalid_names: Vec<String>,
    entries: usize,
    bytes: u64,
}

/// Detects and unpacks a .tar.gz, .zip or .tar archive.
///
/// # Errors
/// Returns an error if the archive is damaged or exceeds a limit, if the path of an entry leads
/// outside the target folder, or if an entry is neither a file nor a folder.
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

/// Decompresses all members of a gzip file. Like GNU gzip, ignores trailing zeros.
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
            let kind = entry.header().entry_type();
            // A global header describes all entries, for example with the commit of the archive.
            if !kind.is_pax_global_extensions() {
                let name = entry.path_bytes().into_owned();
                contents.add(&name, kind, Ok(entry))?;
            }
        }
        // Blocks of zeros mark the end.
        if !tar.ends_with(&[0; 512]) {
            return Err(damaged("the end is missing"));
        }
        Ok(contents)
    }

    fn from_zip(zip: &[u8]) -> Result<Self, String> {
        let mut contents = Self::default();
        let archive = ZipArchive::from_slice(zip).map_err(damaged)?;
        for entry in archive.entries() {
            let entry = entry.map_err(damaged)?;
            // The Unix mode, or 0 from tools that do not set the mode. The originating system is
            // ignored.
            let kind = match (entry.external_attributes() >> 16) & 0o170_000 {
                0 | 0o100_000 => EntryType::Regular,
                0o040_000 => EntryType::Directory,
                0o120_000 => EntryType::Symlink,
                // A device, a pipe or a socket; all are refused.
                _ => EntryType::Block,
            };
            // Some tools for Windows write backslashes.
            let slash = |&byte: &u8| if byte == b'\\' { b'/' } else { byte };
            let name: Vec<u8> = entry.file_path().as_ref().iter().map(slash).collect();
            let data = archive.get_entry(entry.wayfinder()).map_err(damaged)?;
            let content: Result<Box<dyn Read>, _> = match entry.compression_method() {
                _ if entry.flags().is_encrypted() => Err("is encrypted"),
                CompressionMethod::STORE => Ok(Box::new(data.data())),
                CompressionMethod::DEFLATE => Ok(Box::new(DeflateDecoder::new(data.data()))),
                _ => Err("is compressed with a method other than deflate"),
            };
            // The verifying reader checks size and checksum.
            contents.add(&name, kind, content.map(|content| data.verifying_reader(content)))?;
        }
        let (found, expected) = (contents.entries, archive.entries_hint());
        if found as u64 != expected {
            return Err(damaged(format!("expected {expected} entries, found {found}")));
        }
        Ok(contents)
    }

    /// Adds a file. Skips folders, and files whose names are not valid on every system.
    fn add(
        &mut self,
        name: &[u8],
        kind: EntryType,
        content: Result<impl Read, &str>,
    ) -> Result<(), String> {
        let shown = Excerpt::<80>::new(name);
        let refused = |problem: &str| format!("entry {shown} {problem}");
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(format!("more than {MAX_ENTRIES} entries"));
        }
        let path = path_inside(name).map_err(refused)?;
        let content = match kind {
            EntryType::Directory => return Ok(()),
            EntryType::Regular if name.ends_with(b"/") => return Ok(()),
            EntryType::Regular => content.map_err(refused)?,
            EntryType::Symlink => return Err(refused("is a symbolic link")),
            EntryType::Link => return Err(refused("is a hard link")),
            _ => return Err(refused("is neither a file nor a folder")),
        };
        let Some(path) = path else {
            self.invalid_names.push(shown.to_string());
            return Ok(());
        };
        let mut bytes = Vec::new();
        (content.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
            .map_err(|error| refused(&format!("is damaged: {error}")))?;
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(refused(&format!("is larger than {MAX_FILE_BYTES} bytes")));
        }
        self.bytes += bytes.len() as u64;
        check_unpacked(self.bytes)?;
        self.files.insert(path, bytes);
        Ok(())
    }
}

fn check_unpacked(bytes: u64) -> Result<(), String> {
    if bytes > MAX_UNPACKED_BYTES {
        return Err(format!("content is larger than {} MiB", MAX_UNPACKED_BYTES >> 20));
    }
    Ok(())
}

fn damaged(error: impl Display) -> String {
    format!("damaged archive: {error}")
}

/// The maximum length of a path in bytes. Every system supports paths of this length.
const MAX_PATH_BYTES: usize = 200;

/// The names that Windows reserves for devices, in addition to numbered ports such as `COM1`.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// Returns the path with `/` as separator, or `None` if the path is not valid on every system.
///
/// # Errors
/// Returns an error if the path leads outside the target folder on any system.
fn path_inside(path: &[u8]) -> Result<Option<String>, &'static str> {
    if path.starts_with(b"/") || path.starts_with(b"\\") {
        return Err("has an absolute path");
    }
    if let [drive, b':', ..] = path
        && drive.is_ascii_alphabetic()
    {
        return Err("has a path with a drive letter");
    }
    // Windows has two separators.
    if path.split(|byte| b"/\\".contains(byte)).any(|name| name == b"..") {
        return Err("has a path with \"..\"");
    }
    let text = str::from_utf8(path).ok().filter(|text| text.len() <= MAX_PATH_BYTES);
    let names = text.unwrap_or_default().split('/').filter(|name| !name.is_empty() && *name != ".");
    let names: Vec<&str> = names.collect();
    let is_portable = !names.is_empty() && names.iter().all(|name| is_portable_name(name));
    Ok(is_portable.then(|| names.join("/")))
}

fn is_portable_name(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_lowercase();
    let is_port =
        |port: &str| stem.strip_prefix(port).is_some_and(|number| number.chars().count() == 1);
    let is_device = DEVICES.contains(&&stem[..]) || is_port("com") || is_port("lpt");
    let is_reserved = name.chars().any(|sign| sign.is_control() || "\\:*?\"<>|".contains(sign));
    !is_device && !is_reserved && !name.ends_with(['.', ' '])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_paths_are_kept() {
        for (path, kept) in [
            ("a.txt", "a.txt"),
            (
                "./mazes-master/classic//Other(uk2000)__2000 é.txt",
                "mazes-master/classic/Other(uk2000)__2000 é.txt",
            ),
            ("folder/", "folder"),
            (".hidden/..a/b..txt", ".hidden/..a/b..txt"),
            ("command.txt", "command.txt"),
            ("company/lpt", "company/lpt"),
        ] {
            assert_eq!(path_inside(path.as_bytes()), Ok(Some(kept.to_string())));
        }
    }

    #[test]
    fn outside_paths_are_refused() {
        for path in [
            "/etc/passwd",
            "//server/share",
            "..",
            "../a",
            "a/../../b",
            "a/..",
            "C:\\a",
            "C:a",
            "c:/a",
            "\\a",
            "a\\..\\b",
            "?/../a",
        ] {
            assert!(path_inside(path.as_bytes()).is_err(), "{path:?}");
        }
        assert!(path_inside(b"\xff/../a").is_err());
        assert!(path_inside(&[b"../", &[b'a'; MAX_PATH_BYTES][..]].concat()).is_err());
    }

    #[test]
    fn unportable_paths_return_none() {
        for path in [
            "",
            "./",
            "a\\b",
            "12:30.txt",
            "a.txt:stream",
            "a\"b.txt",
            "b?.txt",
            "nul",
            "a/CON.txt",
            "com1",
            "Lpt9.maz",
            "aux .txt",
            "a./b",
            "a /b",
            "... ",
            "a\0b",
            "a\nb",
            "a\u{7f}",
        ] {
            assert_eq!(path_inside(path.as_bytes()), Ok(None), "{path:?}");
        }
        assert_eq!(path_inside(b"\x81.txt"), Ok(None));
        let long = |names| path_inside("é/".repeat(names).as_bytes()).unwrap();
        assert!(long(66).is_some());
        assert_eq!(long(67), None);
    }
}
