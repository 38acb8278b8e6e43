//! Reads the records of an MCAP file and of its chunks, which are compressed groups of records.
//!
//! ```text
//! chunk    start time 8 bytes, end time 8, uncompressed length 8, CRC-32 4, length of the
//!          compression's name 4, name, compressed length 8, compressed records
//! ```

use std::borrow::Cow;
use std::io::{self, BufReader, Read};

use crc32fast::Hasher;

use crate::mcap::{HEAD_BYTES, MAGIC, kind, sized, take};
use crate::memory;

/// The maximum number of bytes per read. Long records are read in several steps, because a length
/// field may claim more bytes than the file contains.
const STEP_BYTES: usize = 64 * 1024;

/// Reads records one after another.
pub(crate) struct RecordReader<R> {
    source: BufReader<R>,
    /// The maximum length of a record in bytes.
    max_bytes: usize,
    /// The data of the newest [`fill`](Self::fill).
    buffer: Vec<u8>,
    /// The checksum of all bytes that have been read.
    checksum: Hasher,
    /// The number of bytes that have been read.
    pub(crate) position: u64,
    has_footer: bool,
}

/// The reason why there is no further record.
#[derive(Debug)]
pub(crate) enum End {
    /// The file is complete.
    Closed,
    /// The file ends early.
    Truncated,
    /// The next record is invalid.
    Damaged(String),
    /// The file is not an MCAP file.
    NotMcap,
    OutOfMemory,
    Io(io::Error),
}

impl<R: Read> RecordReader<R> {
    /// Reads records of up to `max_bytes` bytes.
    pub(crate) fn new(source: R, max_bytes: usize) -> Self {
        Self {
            source: BufReader::with_capacity(STEP_BYTES, source),
            max_bytes,
            buffer: Vec::new(),
            checksum: Hasher::new(),
            position: 0,
            has_footer: false,
        }
    }

    /// Returns the kind and the body of the next record.
    pub(crate) fn next_record(&mut self) -> Result<(u8, &[u8]), End> {
        if self.position == 0 {
            self.fill(MAGIC.len())?;
            if self.buffer != MAGIC {
                return Err(End::NotMcap);
            }
        }
        if self.has_footer {
            self.fill(MAGIC.len())?;
            let is_complete = self.buffer == MAGIC;
            let other = || End::Damaged("other data than the end of an MCAP file".into());
            return Err(if is_complete { End::Closed } else { other() });
        }
        let checksum = self.checksum.clone();
        self.fill(HEAD_BYTES)?;
        let (kind, length) = self.buffer.split_at(1);
        let (kind, length) = (kind[0], length.try_into().map_or(u64::MAX, u64::from_le_bytes));
        let length = check_length("record", length, self.max_bytes).map_err(End::Damaged)?;
        self.fill(length)?;
        if kind == kind::DATA_END {
            let expected = self.buffer.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
            check_checksum("data", expected, checksum.finalize()).map_err(End::Damaged)?;
        }
        self.has_footer = kind == kind::FOOTER;
        Ok((kind, &self.buffer))
    }

    /// Reads exactly this many bytes into the buffer, which grows as bytes arrive, up to twice what
    /// is needed.
    fn fill(&mut self, bytes: usize) -> Result<(), End> {
        if bytes > STEP_BYTES && !memory::is_available(2 * bytes) {
            return Err(End::OutOfMemory);
        }
        self.buffer.clear();
        let read = self.source.by_ref().take(bytes as u64).read_to_end(&mut self.buffer);
        self.checksum.update(&self.buffer);
        self.position += self.buffer.len() as u64;
        match read {
            Ok(count) if count == bytes => Ok(()),
            Ok(_) => Err(End::Truncated),
            Err(error) => Err(End::Io(error)),
        }
    }
}

/// Decompresses the records of a chunk. Fails if the decompressed records take more than `max`
/// bytes.
pub(crate) fn unpack_chunk(chunk: &[u8], max: usize) -> Result<Cow<'_, [u8]>, String> {
    let (length, checksum, compression, packed) =
        split(chunk).ok_or("a field that extends past the end of its chunk")?;
    let length = check_length("chunk", length, max)?;
    let records = match compression {
        b"" => Cow::Borrowed(packed),
        b"zstd" => zstd::bulk::decompress(packed, length)
            .map(Cow::Owned)
            .map_err(|error| format!("a chunk that cannot be decompressed: {error}"))?,
        other => {
            let other = other.escape_ascii();
            return Err(format!("a chunk with the unknown compression method \"{other}\""));
        }
    };
    let found = records.len();
    if found != length {
        return Err(format!(
            "a chunk of the wrong length (expected {length} bytes, found {found})"
        ));
    }
    check_checksum("a chunk", checksum, crc32fast::hash(&records))?;
    Ok(records)
}

/// Returns the length of a record or chunk. Fails if it is greater than `max`.
fn check_length(what: &str, length: u64, max: usize) -> Result<usize, String> {
    let valid = usize::try_from(length).ok().filter(|&length| length <= max);
    valid.ok_or_else(|| format!("a {what} of {length} bytes, which exceeds the limit of {max}"))
}

/// Fails if data does not have the expected checksum. Writers may leave it out; it is then 0.
fn check_checksum(what: &str, expected: u32, found: u32) -> Result<(), String> {
    if expected == 0 || expected == found {
        return Ok(());
    }
    Err(format!("{what} with the wrong checksum (expected {expected:08x}, found {found:08x})"))
}

/// Splits a chunk into its uncompressed length, its checksum (0 if absent), the name of its
/// compression method and its compressed records.
fn split(mut chunk: &[u8]) -> Option<(u64, u32, &[u8], &[u8])> {
    let _times: [u8; 16] = take(&mut chunk).ok()?;
    let length = u64::from_le_bytes(take(&mut chunk).ok()?);
    let checksum = u32::from_le_bytes(take(&mut chunk).ok()?);
    let compression = sized(&mut chunk).ok()?;
    let packed_length = u64::from_le_bytes(take(&mut chunk).ok()?);
    let packed = chunk.get(..usize::try_from(packed_length).ok()?)?;
    Some((length, checksum, compression, packed))
}

/// Removes the first record and returns its kind and body. Returns `None` if the record extends
/// past the end of `records`.
pub(crate) fn take_record<'c>(records: &mut &'c [u8]) -> Option<(u8, &'c [u8])> {
    let [kind] = take(records).ok()?;
    let length = u64::from_le_bytes(take(records).ok()?);
    Some((kind, records.split_off(..usize::try_from(length).ok()?)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcap::writer::McapWriter;

    /// Returns a short file.
    fn file() -> Vec<u8> {
        let mut file = Vec::new();
        let mut writer = McapWriter::new(&mut file, "mmsim", false).unwrap();
        writer.write_metadata("name", &[("key", "value")]).unwrap();
        writer.finish().unwrap();
        file
    }

    /// Returns the kinds of the records, and why there is no further one.
    fn read(file: &[u8]) -> (Vec<u8>, End) {
        let (mut reader, mut kinds) = (RecordReader::new(file, 1000), Vec::new());
        loop {
            match reader.next_record() {
                Ok((kind, _)) => kinds.push(kind),
                Err(end) => return (kinds, end),
            }
        }
    }

    fn damage(file: &[u8]) -> String {
        match read(file) {
            (_, End::Damaged(reason)) => reason,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn records_are_read_up_to_the_end() {
        let all = [1, 12, 15, 11, 13, 14, 14, 2];
        let (kinds, end) = read(&file());
        assert!(kinds == all && matches!(end, End::Closed), "{kinds:?} {end:?}");
        // Records of an unknown kind may be added in later versions of the format.
        let unknown = [&file()[..8], b"\x77\x01\0\0\0\0\0\0\0?", &file()[8..]].concat();
        let (kinds, end) = read(&unknown);
        assert!(kinds[..2] == [0x77, 1] && matches!(end, End::Damaged(_)), "{kinds:?} {end:?}");
        for length in 0..file().len() {
            let (kinds, end) = read(&file()[..length]);
            assert!(all.starts_with(&kinds) && matches!(end, End::Truncated), "{length}: {end:?}");
        }
    }

    #[test]
    fn damage_is_reported() {
        assert!(matches!(read(b"o---o---o").1, End::NotMcap));
        let mut changed = file();
        changed[20] ^= 1;
        assert!(damage(&changed).starts_with("data with the wrong checksum (expected "));
        let mut without_checksum = changed;
        let at = without_checksum.windows(9).position(|bytes| bytes == b"\x0f\x04\0\0\0\0\0\0\0");
        without_checksum[at.unwrap() + 9..][..4].fill(0);
        assert!(matches!(read(&without_checksum).1, End::Closed));
        let mut too_long = file();
        too_long[9..17].copy_from_slice(&1001_u64.to_le_bytes());
        assert_eq!(damage(&too_long), "a record of 1001 bytes, which exceeds the limit of 1000");
        too_long[9..17].fill(0xff);
        assert!(damage(&too_long).starts_with("a record of 18446744073709551615 bytes"));
        let mut other_end = file();
        *other_end.last_mut().unwrap() = b'?';
        assert_eq!(damage(&other_end), "other data than the end of an MCAP file");
    }

    const RECORDS: &[u8] = b"\x05\x03\0\0\0\0\0\0\0abc\x06\0\0\0\0\0\0\0\0";

    fn chunk(length: u64, checksum: u32, compression: &[u8], packed: &[u8]) -> Vec<u8> {
        let name_length = u32::try_from(compression.len()).unwrap();
        [
            &[7; 16][..],
            &length.to_le_bytes(),
            &checksum.to_le_bytes(),
            &name_length.to_le_bytes(),
            compression,
            &(packed.len() as u64).to_le_bytes(),
            packed,
        ]
        .concat()
    }

    #[test]
    fn records_are_decompressed() {
        let (length, checksum) = (RECORDS.len() as u64, crc32fast::hash(RECORDS));
        let zstd = zstd::bulk::compress(RECORDS, 1).unwrap();
        for chunk in [
            chunk(length, checksum, b"", RECORDS),
            chunk(length, 0, b"", RECORDS),
            chunk(length, checksum, b"zstd", &zstd),
        ] {
            let unpacked = unpack_chunk(&chunk, 100).unwrap();
            let mut records = &*unpacked;
            assert_eq!(take_record(&mut records), Some((5, &b"abc"[..])));
            assert_eq!(take_record(&mut records), Some((6, &b""[..])));
            assert!(records.is_empty());
        }
    }

    #[test]
    fn inconsistent_chunks_are_errors() {
        let error = |chunk: &[u8]| unpack_chunk(chunk, 100).unwrap_err();
        insta::assert_snapshot!(error(&chunk(99, 0, b"", RECORDS)), @"a chunk of the wrong length (expected 99 bytes, found 21)");
        insta::assert_snapshot!(error(&chunk(21, 7, b"", RECORDS)), @"a chunk with the wrong checksum (expected 00000007, found 910bc603)");
        insta::assert_snapshot!(error(&chunk(101, 0, b"", RECORDS)), @"a chunk of 101 bytes, which exceeds the limit of 100");
        insta::assert_snapshot!(error(&chunk(21, 0, b"lz4\x1b", RECORDS)), @r#"a chunk with the unknown compression method "lz4\x1b""#);
        insta::assert_snapshot!(error(&chunk(21, 0, b"zstd", RECORDS)), @"a chunk that cannot be decompressed: Unknown frame descriptor");
        let whole = chunk(21, 0, b"", RECORDS);
        for length in 0..whole.len() {
            assert_eq!(error(&whole[..length]), "a field that extends past the end of its chunk");
        }
        for length in 0..RECORDS.len() {
            let mut records = &RECORDS[..length];
            assert_eq!(take_record(&mut records).is_some(), length >= 12, "{length}");
            assert_eq!(take_record(&mut records), None, "{length}");
        }
    }
}
