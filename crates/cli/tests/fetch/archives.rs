//! Builds valid and malicious archives.

use std::io::Write;

use flate2::Compression;
use flate2::write::{DeflateEncoder, GzEncoder};
use tar::{EntryType, Header};

/// The number of 1 MiB parts in a 10 GiB decompression bomb.
const BOMB_PARTS: usize = 10 << 10;
const PART: &[u8] = &[0; 1 << 20];

/// Pairs of a file name and the file's content.
pub(crate) type Contents<'a> = &'a [(&'a str, &'a str)];

pub(crate) fn tar(contents: Contents) -> Vec<u8> {
    let mut tar = Vec::new();
    for (name, content) in contents {
        tar.extend(tar_entry(name.as_bytes(), EntryType::Regular, content.as_bytes()));
    }
    tar.extend([0; 1024]);
    tar
}

pub(crate) fn tar_gz(contents: Contents) -> Vec<u8> {
    gz(&tar(contents))
}

pub(crate) fn gz(content: &[u8]) -> Vec<u8> {
    let mut gz = GzEncoder::new(Vec::new(), Compression::best());
    gz.write_all(content).unwrap();
    gz.finish().unwrap()
}

/// Returns a tar archive with one entry, whose name is not checked.
pub(crate) fn tar_of(name: &[u8], kind: EntryType, content: &[u8]) -> Vec<u8> {
    [tar_entry(name, kind, content), vec![0; 1024]].concat()
}

/// Returns an entry of a tar archive, padded to whole blocks.
pub(crate) fn tar_entry(name: &[u8], kind: EntryType, content: &[u8]) -> Vec<u8> {
    let header = tar_header(name, kind, content.len() as u64);
    let fill = content.len().next_multiple_of(512) - content.len();
    [&header[..], content, &vec![0; fill]].concat()
}

fn tar_header(name: &[u8], kind: EntryType, size: u64) -> Vec<u8> {
    let mut header = Header::new_gnu();
    header.as_old_mut().name[..name.len()].copy_from_slice(name);
    header.set_entry_type(kind);
    header.set_size(size);
    header.set_mode(0o644);
    if kind.is_symlink() || kind.is_hard_link() {
        header.set_link_name("/etc/passwd").unwrap();
    }
    header.set_cksum();
    header.as_bytes().to_vec()
}

/// Returns a .tar.gz archive with an entry of 10 GiB of zeros.
pub(crate) fn tar_gz_bomb(kind: EntryType) -> Vec<u8> {
    let header = gz(&tar_header(b"bomb.txt", kind, (BOMB_PARTS * PART.len()) as u64));
    [header, gz(PART).repeat(BOMB_PARTS)].concat()
}

/// A file in a zip archive, with the fields of its headers.
pub(crate) struct Zipped<'a> {
    pub(crate) name: &'a [u8],
    pub(crate) data: Vec<u8>,
    /// The number of the compression method.
    pub(crate) method: u16,
    /// The Unix file type and permissions.
    pub(crate) mode: u32,
    /// The number of the system on which the entry was created.
    pub(crate) system: u8,
    pub(crate) checksum: u32,
    pub(crate) bytes: u32,
}

impl<'a> Zipped<'a> {
    pub(crate) fn new(name: &'a [u8], content: &[u8]) -> Self {
        let mut deflate = DeflateEncoder::new(Vec::new(), Compression::best());
        deflate.write_all(content).unwrap();
        Self {
            name,
            data: deflate.finish().unwrap(),
            method: 8,
            mode: 0o100_644,
            system: 3,
            checksum: crc32fast::hash(content),
            bytes: content.len().try_into().unwrap(),
        }
    }

    /// Returns a file of 10 GiB of zeros, whose header claims 100 bytes.
    pub(crate) fn bomb() -> Self {
        let mut deflate = DeflateEncoder::new(Vec::new(), Compression::best());
        deflate.write_all(PART).unwrap();
        deflate.flush().unwrap();
        // A flushed part ends on a byte boundary and does not refer to earlier data.
        let part = deflate.get_ref().clone();
        let end = [3, 0];
        let data = [part.repeat(BOMB_PARTS), end.to_vec()].concat();
        Self { data, bytes: 100, ..Self::new(b"bomb.txt", b"") }
    }

    fn header(&self) -> Vec<u8> {
        let length = |data: &[u8]| u32::try_from(data.len()).unwrap().to_le_bytes();
        let mut header = vec![20, 0, 0, 0];
        header.extend(self.method.to_le_bytes());
        header.extend([0; 4]);
        header.extend(self.checksum.to_le_bytes());
        header.extend(length(&self.data));
        header.extend(self.bytes.to_le_bytes());
        header.extend(u16::try_from(self.name.len()).unwrap().to_le_bytes());
        header.extend([0; 2]);
        header
    }
}

/// Builds a zip archive, as specified in PKWARE's APPNOTE.TXT 6.3.
pub(crate) fn zip_of(files: &[Zipped]) -> Vec<u8> {
    let (mut zip, mut directory) = (Vec::new(), Vec::new());
    for file in files {
        let offset = u32::try_from(zip.len()).unwrap();
        let local = [b"PK\x03\x04", &file.header()[..], file.name, &file.data].concat();
        zip.extend(local);
        let version = [20, file.system];
        directory.extend([&b"PK\x01\x02"[..], &version, &file.header()[..], &[0; 6]].concat());
        directory.extend((file.mode << 16).to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(file.name);
    }
    let end = u32::try_from(zip.len()).unwrap();
    let count = u16::try_from(files.len()).unwrap().to_le_bytes();
    let bytes = u32::try_from(directory.len()).unwrap();
    zip.extend(directory);
    zip.extend([&b"PK\x05\x06\0\0\0\0"[..], &count, &count].concat());
    zip.extend(bytes.to_le_bytes());
    zip.extend(end.to_le_bytes());
    zip.extend([0; 2]);
    zip
}

pub(crate) fn zip(contents: Contents) -> Vec<u8> {
    zip_of(
        &contents
            .iter()
            .map(|&(name, content)| Zipped::new(name.as_bytes(), content.as_bytes()))
            .collect::<Vec<_>>(),
    )
}
