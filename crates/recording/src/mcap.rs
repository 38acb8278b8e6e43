//! The kinds of MCAP records that mmsim reads and writes. Source: <https://mcap.dev/spec>.
//!
//! ```text
//! record     kind 1 byte, length of the body 8, body
//! string     length 4 bytes, UTF-8
//! map        length 4 bytes, a key and a value for each entry
//!
//! schema     number 2 bytes, name, encoding, length of the data 4, data
//! channel    number 2 bytes, schema 2, topic, message encoding, map
//! message    channel 2 bytes, sequence 4, time of the log 8, time of publication 8, data
//! metadata   name, map
//! ```

pub(crate) mod reader;
pub(crate) mod writer;

/// The bytes at the beginning and at the end of a file.
pub(crate) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// The length of the kind and the length of a record in bytes.
pub(crate) const HEAD_BYTES: usize = 9;

/// The kinds of records.
pub(crate) mod kind {
    pub(crate) const HEADER: u8 = 1;
    pub(crate) const FOOTER: u8 = 2;
    pub(crate) const SCHEMA: u8 = 3;
    pub(crate) const CHANNEL: u8 = 4;
    pub(crate) const MESSAGE: u8 = 5;
    pub(crate) const CHUNK: u8 = 6;
    pub(crate) const ATTACHMENT: u8 = 9;
    pub(crate) const STATISTICS: u8 = 11;
    pub(crate) const METADATA: u8 = 12;
    pub(crate) const METADATA_INDEX: u8 = 13;
    pub(crate) const SUMMARY_OFFSET: u8 = 14;
    pub(crate) const DATA_END: u8 = 15;
}

/// The body of a channel record.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Channel<'a> {
    pub(crate) number: u16,
    pub(crate) topic: &'a str,
    pub(crate) encoding: &'a str,
}

/// The body of a message record.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Message<'a> {
    pub(crate) channel: u16,
    /// The time in nanoseconds since 1970 (UTC).
    pub(crate) time: u64,
    pub(crate) data: &'a [u8],
}

/// The body of a metadata record.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Metadata<'a> {
    pub(crate) name: &'a str,
    entries: Vec<(&'a str, &'a str)>,
}

/// The error if a field is not valid.
const INVALID_TEXT: &str = "a text that is not UTF-8";
const TOO_SHORT: &str = "a field that extends past the end of its record";

impl<'a> Channel<'a> {
    pub(crate) fn decode(mut body: &'a [u8]) -> Result<Self, &'static str> {
        let [number, _schema] = [take(&mut body)?, take(&mut body)?].map(u16::from_le_bytes);
        let channel = Self { number, topic: string(&mut body)?, encoding: string(&mut body)? };
        map(&mut body).map(|_| channel)
    }
}

impl<'a> Message<'a> {
    pub(crate) fn decode(mut body: &'a [u8]) -> Result<Self, &'static str> {
        let channel = u16::from_le_bytes(take(&mut body)?);
        let _sequence: [u8; 4] = take(&mut body)?;
        let [time, _published] = [take(&mut body)?, take(&mut body)?].map(u64::from_le_bytes);
        Ok(Self { channel, time, data: body })
    }
}

impl<'a> Metadata<'a> {
    pub(crate) fn decode(mut body: &'a [u8]) -> Result<Self, &'static str> {
        Ok(Self { name: string(&mut body)?, entries: map(&mut body)? })
    }

    /// Returns the value of a key.
    pub(crate) fn get(&self, key: &str) -> Option<&'a str> {
        self.entries.iter().find(|entry| entry.0 == key).map(|entry| entry.1)
    }
}

/// Removes the first `N` bytes.
fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], &'static str> {
    let (bytes, after) = rest.split_first_chunk().ok_or(TOO_SHORT)?;
    *rest = after;
    Ok(*bytes)
}

/// Removes a length field of four bytes and the bytes that follow.
fn sized<'a>(rest: &mut &'a [u8]) -> Result<&'a [u8], &'static str> {
    let length = usize::try_from(u32::from_le_bytes(take(rest)?)).map_err(|_| TOO_SHORT)?;
    rest.split_off(..length).ok_or(TOO_SHORT)
}

fn string<'a>(rest: &mut &'a [u8]) -> Result<&'a str, &'static str> {
    str::from_utf8(sized(rest)?).map_err(|_| INVALID_TEXT)
}

fn map<'a>(rest: &mut &'a [u8]) -> Result<Vec<(&'a str, &'a str)>, &'static str> {
    let (mut map, mut entries) = (sized(rest)?, Vec::new());
    while !map.is_empty() {
        entries.push((string(&mut map)?, string(&mut map)?));
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_decoded() {
        let channel = b"\x07\0\x01\0\x02\0\0\0/a\x01\0\0\0b\0\0\0\0";
        let decoded = Channel { number: 7, topic: "/a", encoding: "b" };
        assert_eq!(Channel::decode(channel), Ok(decoded));
        let message = b"\x01\x02\x09\0\0\0\x08\x07\x06\x05\x04\x03\x02\x01\0\0\0\0\0\0\0\0data";
        let decoded = Message { channel: 0x201, time: 0x0102_0304_0506_0708, data: b"data" };
        assert_eq!(Message::decode(message), Ok(decoded));
        let metadata = b"\x01\0\0\0n\x0c\0\0\0\x02\0\0\0ab\x02\0\0\0\xc3\xa9";
        let decoded = Metadata::decode(metadata).unwrap();
        assert_eq!(decoded, Metadata { name: "n", entries: vec![("ab", "é")] });
        assert_eq!([decoded.get("ab"), decoded.get("a")], [Some("é"), None]);
    }

    #[test]
    fn bodies_that_are_too_short_are_errors() {
        let channel = b"\x07\0\x01\0\x02\0\0\0/a\x01\0\0\0b\0\0\0\0";
        let metadata = b"\x01\0\0\0n\x0c\0\0\0\x02\0\0\0ab\x02\0\0\0\xc3\xa9";
        for length in 0..channel.len() {
            assert_eq!(Channel::decode(&channel[..length]), Err(TOO_SHORT));
        }
        for length in 0..metadata.len() {
            assert_eq!(Metadata::decode(&metadata[..length]), Err(TOO_SHORT));
        }
        assert_eq!(Message::decode(&[0; 21]), Err(TOO_SHORT));
        assert_eq!(Metadata::decode(b"\x01\0\0\0\xff\0\0\0\0"), Err(INVALID_TEXT));
        let half_entry = b"\0\0\0\0\x05\0\0\0\x01\0\0\0ab";
        assert_eq!(Metadata::decode(half_entry), Err(TOO_SHORT));
    }
}
