//! Reads the records of an MCAP file and of its chunks, which are compressed groups of records.
//!
//! ```text
//! chunk    start time 8 bytes, end time 8, uncompressed length 8, CRC-32 4, length of the
//!          compression's name 4, name, compressed length 8, compressed records
//! ```
//!
//! Records may have any length. Of a long record, only the first bytes are kept in memory.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use crc32fast::Hasher;
use lz4_flex::frame::FrameDecoder;
use zstd::stream::read::Decoder;

use crate::mcap::{HEAD_BYTES, MAGIC, kind};
use crate::memory;

/// The capacity of the buffer between the file and the reader, in bytes.
const BUFFER_BYTES: usize = 64 << 10;

/// The number of bytes of a record's body that are kept. Every record of a recording is shorter.
pub(crate) const MAX_BODY_BYTES: usize = 1 << 20;

/// The maximum length of a record in bytes. A greater length is damage, not the length of a file that
/// was truncated.
const MAX_RECORD_BYTES: u64 = 1 << 40;

/// The maximum total size of the decompressed chunks of a short file, in bytes. For longer files,
/// the limit increases in proportion to the file size (see `MAX_COMPRESSION_RATIO`).
pub(crate) const MAX_UNPACKED_BYTES: u64 = 64 << 20;

/// Each byte of a file raises the limit on its decompressed size by this number of bytes.
///
/// Without a limit, a small file could decompress to an unlimited number of states. Real recordings
/// are compressed by a factor of at most about 400.
pub(crate) const MAX_COMPRESSION_RATIO: u64 = 1000;

/// The binary logarithm of the number of earlier bytes that a zstd frame may refer to. They stay in
/// memory while the frame is decompressed.
const MAX_WINDOW_LOG: u32 = 24;

/// The maximum length of the name of a compression method in bytes.
const MAX_NAME_BYTES: u32 = 64;

/// Reads records one after another.
pub(crate) struct RecordReader<R> {
    source: CheckedReader<BufReader<R>>,
    /// The length of the file in bytes.
    pub(crate) length: u64,
    /// The first bytes of the body of the newest record.
    body: Vec<u8>,
    /// The number of bytes decompressed from chunks.
    unpacked: u64,
    has_footer: bool,
}

/// The reason why there is no further record.
#[derive(Debug)]
pub(crate) enum End<E> {
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
    /// The consumer of the records has failed.
    Failed(E),
}

impl<E> From<&str> for End<E> {
    fn from(reason: &str) -> Self {
        Self::Damaged(reason.into())
    }
}

impl<E> From<String> for End<E> {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

impl<E> From<io::Error> for End<E> {
    fn from(error: io::Error) -> Self {
        // Another program has truncated the file since its length was read.
        let is_truncated = error.kind() == io::ErrorKind::UnexpectedEof;
        if is_truncated { Self::Truncated } else { Self::Io(error) }
    }
}

impl<R: Read + Seek> RecordReader<R> {
    /// Reads the records of `source` from its beginning to its current end.
    pub(crate) fn new(mut source: R) -> io::Result<Self> {
        let length = source.seek(SeekFrom::End(0))?;
        source.rewind()?;
        let source = CheckedReader::new(BufReader::with_capacity(BUFFER_BYTES, source));
        Ok(Self { source, length, body: Vec::new(), unpacked: 0, has_footer: false })
    }

    /// Returns the number of bytes that have been read.
    pub(crate) const fn position(&self) -> u64 {
        self.source.count
    }

    /// Reads the next record of the file. Calls `on_record` with the kind and the body of the record
    /// or, if it is a chunk, with those of each record in the chunk. A long body is cut.
    pub(crate) fn read_next<E>(
        &mut self,
        mut on_record: impl FnMut(u8, &[u8]) -> Result<(), End<E>>,
    ) -> Result<(), End<E>> {
        if self.position() == 0 && self.read_magic()? != MAGIC {
            return Err(End::NotMcap);
        }
        if self.has_footer {
            let is_complete = self.read_magic()? == MAGIC;
            let other = "other data than the end of an MCAP file";
            return Err(if is_complete { End::Closed } else { other.into() });
        }
        let checksum = self.source.checksum.clone();
        self.check_rest(HEAD_BYTES as u64)?;
        let (kind, length) = read_head(&mut self.source)?;
        if length > MAX_RECORD_BYTES {
            let max = MAX_RECORD_BYTES;
            return Err(
                format!("a record of {length} bytes, which exceeds the limit of {max}").into()
            );
        }
        self.check_rest(length)?;
        if kind == kind::CHUNK {
            return self.read_chunk(length, on_record);
        }
        read_body(&mut self.source, length, &mut self.body)?;
        if kind == kind::DATA_END {
            let expected = self.body.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
            check_checksum("data", expected, checksum.finalize())?;
        }
        self.has_footer = kind == kind::FOOTER;
        on_record(kind, &self.body)
    }

    /// Returns the body of the first metadata record of up to `max` bytes for which `is_wanted`
    /// returns true, and rewinds the file. Does not read the bodies of other records.
    pub(crate) fn find_metadata(
        &mut self,
        max: u64,
        is_wanted: impl Fn(&[u8]) -> bool,
    ) -> io::Result<Option<Vec<u8>>> {
        let (source, mut position) = (&mut self.source.source, MAGIC.len() as u64);
        source.seek(SeekFrom::Start(position))?;
        let mut found = None;
        while found.is_none() && self.length.saturating_sub(position) >= HEAD_BYTES as u64 {
            let (kind, length) = read_head(source)?;
            position += HEAD_BYTES as u64;
            if length > self.length - position {
                break;
            }
            position += length;
            if kind == kind::METADATA && length <= max {
                read_body(source, length, &mut self.body)?;
                found = Some(&self.body).filter(|body| is_wanted(body)).cloned();
            } else {
                source.seek_relative(length.try_into().map_err(io::Error::other)?)?;
            }
        }
        source.rewind()?;
        Ok(found)
    }

    fn read_magic<E>(&mut self) -> Result<[u8; MAGIC.len()], End<E>> {
        self.check_rest(MAGIC.len() as u64)?;
        Ok(read_array(&mut self.source)?)
    }

    /// Fails if the file has fewer bytes left.
    fn check_rest<E>(&self, bytes: u64) -> Result<(), End<E>> {
        let rest = self.length.saturating_sub(self.position());
        if rest < bytes { Err(End::Truncated) } else { Ok(()) }
    }

    /// Reads a chunk of `length` bytes twice: calls `on_record` only if the whole chunk is intact.
    fn read_chunk<E>(
        &mut self,
        length: u64,
        mut on_record: impl FnMut(u8, &[u8]) -> Result<(), End<E>>,
    ) -> Result<(), End<E>> {
        let end = self.position() + length;
        let chunk = Chunk::read(&mut self.source.by_ref().take(length))?;
        let start = self.position();
        if chunk.packed_length > end - start {
            return Err(FIELD_TOO_LONG.into());
        }
        let max = MAX_UNPACKED_BYTES + MAX_COMPRESSION_RATIO * end;
        if chunk.length > max - self.unpacked {
            return Err(format!("chunks that decompress to more than {max} bytes").into());
        }
        self.unpacked += chunk.length;
        if !memory::is_available(1 << MAX_WINDOW_LOG) {
            return Err(End::OutOfMemory);
        }
        chunk.check(chunk.decompress(&mut self.source)?)?;
        let rest = end - self.position();
        io::copy(&mut self.source.by_ref().take(rest), &mut io::sink())?;

        let source = &mut self.source.source;
        source.seek(SeekFrom::Start(start))?;
        let (mut records, mut rest) = (chunk.decompress(source)?, chunk.length);
        while rest > 0 {
            let too_long = || End::from("a record that extends past the end of its chunk");
            rest = rest.checked_sub(HEAD_BYTES as u64).ok_or_else(too_long)?;
            let (kind, length) = read_head(&mut records).map_err(not_decompressed)?;
            rest = rest.checked_sub(length).ok_or_else(too_long)?;
            read_body(&mut records, length, &mut self.body).map_err(not_decompressed)?;
            on_record(kind, &self.body)?;
        }
        drop(records);
        source.seek(SeekFrom::Start(end))?;
        Ok(())
    }
}

/// The fields of a chunk before its compressed records.
struct Chunk {
    /// The uncompressed length in bytes.
    length: u64,
    /// The checksum of the uncompressed records, or 0 if the writer has left it out.
    checksum: u32,
    compression: Vec<u8>,
    packed_length: u64,
}

const FIELD_TOO_LONG: &str = "a field that extends past the end of its chunk";

impl Chunk {
    fn read<E>(chunk: &mut impl Read) -> Result<Self, End<E>> {
        let too_long = |_| FIELD_TOO_LONG.to_string();
        let _times: [u8; 16] = read_array(chunk).map_err(too_long)?;
        let length = u64::from_le_bytes(read_array(chunk).map_err(too_long)?);
        let checksum = u32::from_le_bytes(read_array(chunk).map_err(too_long)?);
        let name_length = u32::from_le_bytes(read_array(chunk).map_err(too_long)?);
        if name_length > MAX_NAME_BYTES {
            return Err(format!("a compression method with a name of {name_length} bytes").into());
        }
        let mut compression = vec![0; name_length as usize];
        chunk.read_exact(&mut compression).map_err(too_long)?;
        let packed_length = u64::from_le_bytes(read_array(chunk).map_err(too_long)?);
        Ok(Self { length, checksum, compression, packed_length })
    }

    /// Returns a reader of the decompressed records.
    fn decompress<'s>(&self, source: &'s mut impl Read) -> Result<Box<dyn Read + 's>, String> {
        let packed = source.take(self.packed_length);
        Ok(match &*self.compression {
            b"" => Box::new(packed),
            b"lz4" => Box::new(FrameDecoder::new(packed)),
            b"zstd" => {
                let mut decoder = Decoder::new(FullReader(packed)).map_err(not_decompressed)?;
                decoder.window_log_max(MAX_WINDOW_LOG).map_err(not_decompressed)?;
                Box::new(decoder)
            }
            other => {
                let other = other.escape_ascii();
                return Err(format!("a chunk with the unknown compression method \"{other}\""));
            }
        })
    }

    /// Fails if the decompressed records do not have the length and the checksum of the chunk.
    fn check(&self, records: impl Read) -> Result<(), String> {
        let mut records = CheckedReader::new(records.take(self.length.saturating_add(1)));
        let found = io::copy(&mut records, &mut io::sink()).map_err(not_decompressed)?;
        let expected = self.length;
        if found != expected {
            let or_more = if found > expected { " or more" } else { "" };
            return Err(format!(
                "a chunk of the wrong length (expected {expected} bytes, found {found}{or_more})"
            ));
        }
        check_checksum("a chunk", self.checksum, records.checksum.finalize())
    }
}

/// Fills the whole buffer unless the source ends. Which error `zstd` reports depends on the lengths
/// of its reads, so they must not depend on the source.
struct FullReader<R>(R);

impl<R: Read> Read for FullReader<R> {
    fn read(&mut self, mut to: &mut [u8]) -> io::Result<usize> {
        let length = to.len();
        io::copy(&mut self.0.by_ref().take(length as u64), &mut to)?;
        Ok(length - to.len())
    }
}

/// Counts the bytes that are read, and computes their checksum.
struct CheckedReader<R> {
    source: R,
    count: u64,
    checksum: Hasher,
}

impl<R> CheckedReader<R> {
    fn new(source: R) -> Self {
        Self { source, count: 0, checksum: Hasher::new() }
    }
}

impl<R: Read> Read for CheckedReader<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read(to)?;
        self.checksum.update(&to[..count]);
        self.count += count as u64;
        Ok(count)
    }
}

fn read_array<const N: usize>(source: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    source.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Reads the kind and the length of a record.
fn read_head(source: &mut impl Read) -> io::Result<(u8, u64)> {
    let [kind] = read_array(source)?;
    Ok((kind, u64::from_le_bytes(read_array(source)?)))
}

/// Reads a body of `length` bytes. Keeps its first bytes and skips the others.
fn read_body(source: &mut impl Read, length: u64, body: &mut Vec<u8>) -> io::Result<()> {
    body.clear();
    let kept = source.by_ref().take(length.min(MAX_BODY_BYTES as u64)).read_to_end(body)? as u64;
    let skipped = io::copy(&mut source.take(length - kept), &mut io::sink())?;
    if kept + skipped < length { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(()) }
}

#[expect(clippy::needless_pass_by_value, reason = "`map_err` passes errors by value")]
fn not_decompressed(error: io::Error) -> String {
    format!("a chunk that cannot be decompressed: {error}")
}

/// Fails if data does not have the expected checksum. Writers may leave it out; it is then 0.
fn check_checksum(what: &str, expected: u32, found: u32) -> Result<(), String> {
    if expected == 0 || expected == found {
        return Ok(());
    }
    Err(format!("{what} with the wrong checksum (expected {expected:08x}, found {found:08x})"))
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

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

    /// Returns the kinds and the bodies of the records, and why there is no further one.
    fn read_records(file: &[u8]) -> (Vec<(u8, Vec<u8>)>, End<()>) {
        read_source(Cursor::new(file))
    }

    fn read_source(source: impl Read + Seek) -> (Vec<(u8, Vec<u8>)>, End<()>) {
        let (mut reader, mut records) = (RecordReader::new(source).unwrap(), Vec::new());
        loop {
            let add = |kind, body: &[u8]| {
                records.push((kind, body.to_vec()));
                Ok(())
            };
            if let Err(end) = reader.read_next(add) {
                return (records, end);
            }
        }
    }

    fn read(file: &[u8]) -> (Vec<u8>, End<()>) {
        let (records, end) = read_records(file);
        (records.into_iter().map(|(kind, _)| kind).collect(), end)
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
        too_long[9..17].copy_from_slice(&(u64::from(u32::MAX)).to_le_bytes());
        assert!(matches!(read(&too_long).1, End::Truncated));
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

    /// Returns a file with a chunk, and an empty record of an unknown kind.
    fn file_with(chunk: &[u8]) -> Vec<u8> {
        let length = (chunk.len() as u64).to_le_bytes();
        [&MAGIC, &[kind::CHUNK][..], &length, chunk, b"\x77\0\0\0\0\0\0\0\0"].concat()
    }

    fn lz4(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn records_are_decompressed() {
        let (length, checksum) = (RECORDS.len() as u64, crc32fast::hash(RECORDS));
        let zstd = zstd::bulk::compress(RECORDS, 1).unwrap();
        for chunk in [
            chunk(length, checksum, b"", RECORDS),
            chunk(length, 0, b"", RECORDS),
            chunk(length, checksum, b"zstd", &zstd),
            chunk(length, checksum, b"lz4", &lz4(RECORDS)),
            [chunk(length, checksum, b"", RECORDS), b"rest".to_vec()].concat(),
        ] {
            let (records, end) = read_records(&file_with(&chunk));
            assert!(matches!(end, End::Truncated), "{end:?}");
            assert_eq!(records, [(5, b"abc".to_vec()), (6, vec![]), (0x77, vec![])]);
        }
    }

    #[test]
    fn of_long_records_only_the_beginning_is_kept() {
        let long = [&[9], &(40_u64 << 20).to_le_bytes()[..], &vec![7; 40 << 20]].concat();
        let records = [&long, RECORDS].concat();
        let count = records.len() as u64;
        let plain = [&MAGIC, &records[..]].concat();
        for file in [
            plain,
            file_with(&chunk(count, 0, b"zstd", &zstd::bulk::compress(&records, 1).unwrap())),
            file_with(&chunk(count, 0, b"lz4", &lz4(&records))),
        ] {
            let (records, _) = read_records(&file);
            assert_eq!(records[0], (9, vec![7; MAX_BODY_BYTES]));
            assert_eq!(records[1], (5, b"abc".to_vec()));
        }
    }

    #[test]
    fn inconsistent_chunks_are_errors() {
        let error = |chunk: &[u8]| {
            let (records, End::Damaged(reason)) = read_records(&file_with(chunk)) else { panic!() };
            assert_eq!(records, []);
            reason
        };
        insta::assert_snapshot!(error(&chunk(99, 0, b"", RECORDS)), @"a chunk of the wrong length (expected 99 bytes, found 21)");
        insta::assert_snapshot!(error(&chunk(7, 0, b"", RECORDS)), @"a chunk of the wrong length (expected 7 bytes, found 8 or more)");
        insta::assert_snapshot!(error(&chunk(21, 7, b"", RECORDS)), @"a chunk with the wrong checksum (expected 00000007, found 910bc603)");
        insta::assert_snapshot!(error(&chunk(18_000_000_000, 0, b"", RECORDS)), @"chunks that decompress to more than 67186864 bytes");
        insta::assert_snapshot!(error(&chunk(21, 0, b"lz4\x1b", RECORDS)), @r#"a chunk with the unknown compression method "lz4\x1b""#);
        insta::assert_snapshot!(error(&chunk(21, 0, &[b'x'; 65], RECORDS)), @"a compression method with a name of 65 bytes");
        insta::assert_snapshot!(error(&chunk(21, 0, b"zstd", RECORDS)), @"a chunk that cannot be decompressed: Unknown frame descriptor");
        insta::assert_snapshot!(error(&chunk(21, 0, b"lz4", RECORDS)), @"a chunk that cannot be decompressed: WrongMagicNumber");
        let whole = chunk(21, 0, b"", RECORDS);
        for length in 0..whole.len() {
            assert_eq!(error(&whole[..length]), "a field that extends past the end of its chunk");
        }
    }

    #[test]
    fn records_that_extend_past_the_end_of_their_chunk_are_errors() {
        for length in 0..RECORDS.len() {
            let chunk = chunk(length as u64, 0, b"", &RECORDS[..length]);
            let (records, end) = read_records(&file_with(&chunk));
            let is_whole = length == 0 || length == 12;
            assert_eq!(records.len(), usize::from(length >= 12) + usize::from(is_whole));
            match end {
                End::Damaged(reason) => {
                    assert_eq!(reason, "a record that extends past the end of its chunk");
                }
                end => assert!(is_whole && matches!(end, End::Truncated), "{end:?}"),
            }
        }
    }

    /// Reads up to seven bytes at once, even into a longer buffer.
    struct Trickle<'a>(Cursor<&'a [u8]>);

    impl Read for Trickle<'_> {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            let length = to.len().min(7);
            self.0.read(&mut to[..length])
        }
    }

    impl Seek for Trickle<'_> {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.seek(to)
        }
    }

    #[test]
    fn errors_do_not_depend_on_the_lengths_of_reads() {
        let records = RECORDS.repeat(9);
        for (compression, packed) in
            [(&b"zstd"[..], zstd::bulk::compress(&records, 1).unwrap()), (b"lz4", lz4(&records))]
        {
            let whole = file_with(&chunk(records.len() as u64, 0, compression, &packed));
            for (at, value) in (0..whole.len()).flat_map(|at| [0, 1, 0x7f, 0xff].map(|to| (at, to)))
            {
                let mut changed = whole.clone();
                changed[at] = value;
                if changed.starts_with(&MAGIC) {
                    let [one, other] =
                        [read_records(&changed), read_source(Trickle(Cursor::new(&changed)))]
                            .map(|result| format!("{result:?}"));
                    assert_eq!(one, other, "{value} at {at}");
                }
            }
        }
    }

    #[test]
    fn decompression_bombs_are_errors() {
        let bomb = vec![0; 3 << 20];
        let zstd = zstd::bulk::compress(&bomb, 1).unwrap();
        for (compression, packed) in [(&b"zstd"[..], &zstd), (b"lz4", &lz4(&bomb))] {
            let (_, end) = read_records(&file_with(&chunk(100, 0, compression, packed)));
            let End::Damaged(reason) = end else { panic!("{end:?}") };
            assert_eq!(
                reason,
                "a chunk of the wrong length (expected 100 bytes, found 101 or more)"
            );
        }
    }
}
