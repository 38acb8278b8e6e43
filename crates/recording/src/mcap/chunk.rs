//! Decodes chunks, which are compressed groups of records.
//!
//! ```text
//! chunk    start time 8 bytes, end time 8, uncompressed length 8, CRC-32 4, length of the
//!          compression's name 4, name, compressed length 8, compressed records
//! record   kind 1 byte, length of the body 8, body
//! ```

use std::borrow::Cow;

/// Decompresses the records of a chunk. Fails if the decompressed records take more than `max`
/// bytes.
pub(crate) fn unpack(chunk: &[u8], max: usize) -> Result<Cow<'_, [u8]>, String> {
    let (length, checksum, compression, packed) =
        split(chunk).ok_or("a field that extends past the end of its chunk")?;
    let length = usize::try_from(length)
        .ok()
        .filter(|&length| length <= max)
        .ok_or_else(|| format!("a chunk of {length} bytes, which exceeds the limit of {max}"))?;
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
    match crc32fast::hash(&records) {
        found if checksum != 0 && found != checksum => Err(format!(
            "a chunk with the wrong checksum (expected {checksum:08x}, found {found:08x})"
        )),
        _ => Ok(records),
    }
}

/// Splits a chunk into its uncompressed length, its checksum (0 if absent), the name of its
/// compression method and its compressed records.
fn split(chunk: &[u8]) -> Option<(u64, u32, &[u8], &[u8])> {
    let (_times, rest) = chunk.split_first_chunk::<16>()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (checksum, rest) = rest.split_first_chunk()?;
    let (name_length, rest) = rest.split_first_chunk()?;
    let (name, rest) = rest.split_at_checked(u32::from_le_bytes(*name_length).try_into().ok()?)?;
    let (packed_length, rest) = rest.split_first_chunk()?;
    let packed = rest.get(..usize::try_from(u64::from_le_bytes(*packed_length)).ok()?)?;
    Some((u64::from_le_bytes(*length), u32::from_le_bytes(*checksum), name, packed))
}

/// Removes the first record and returns its kind and body. Returns `None` if the record extends
/// past the end of `records`.
pub(crate) fn take_record<'c>(records: &mut &'c [u8]) -> Option<(u8, &'c [u8])> {
    let (&kind, rest) = records.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (body, rest) = rest.split_at_checked(u64::from_le_bytes(*length).try_into().ok()?)?;
    *records = rest;
    Some((kind, body))
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let unpacked = unpack(&chunk, 100).unwrap();
            let mut records = &*unpacked;
            assert_eq!(take_record(&mut records), Some((5, &b"abc"[..])));
            assert_eq!(take_record(&mut records), Some((6, &b""[..])));
            assert!(records.is_empty());
        }
    }

    #[test]
    fn inconsistent_chunks_are_errors() {
        let error = |chunk: &[u8]| unpack(chunk, 100).unwrap_err();
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
