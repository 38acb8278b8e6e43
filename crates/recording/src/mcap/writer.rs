//! Writes MCAP files.

use std::io::{self, Write};

use crc32fast::Hasher;

use crate::mcap::reader::{MAX_COMPRESSION_RATIO, MAX_UNPACKED_BYTES};
use crate::mcap::{MAGIC, kind};

/// The minimum uncompressed size of a chunk in bytes, except for the last chunk before metadata.
const CHUNK_BYTES: usize = 1 << 20;

/// The zstd compression level. At level 3, files would be 10% larger. Levels above 8 are much
/// slower and save little.
const LEVEL: i32 = 8;

/// Writes records, and a summary at the end.
///
/// There are no indexes of chunks and messages, which would take as much space as the states.
/// Without indexes, readers read the file sequentially.
pub(crate) struct McapWriter<W> {
    to: W,
    /// The number of bytes written.
    position: u64,
    /// The checksum of the bytes written.
    checksum: Hasher,
    /// True if the records are in compressed chunks.
    is_compressed: bool,
    /// The records of the current chunk, or the record that is being written.
    records: Vec<u8>,
    /// The time of the first and of the last message in the current chunk.
    chunk_times: Option<(u64, u64)>,
    /// The time of the first and of the last message in the file.
    times: Option<(u64, u64)>,
    schemas: Group,
    channels: Group,
    metadata: Group,
    /// The number of messages in each channel.
    messages: Vec<u64>,
    chunks: u32,
    /// The uncompressed size of all chunks.
    unpacked: u64,
}

/// Records of one kind in the summary.
struct Group {
    kind: u8,
    records: Vec<u8>,
    count: u16,
}

impl Group {
    const fn new(kind: u8) -> Self {
        Self { kind, records: Vec::new(), count: 0 }
    }

    /// Adds a record, whose body may contain its number. Returns the number and the record.
    fn add(&mut self, put_body: impl FnOnce(u16, &mut Vec<u8>)) -> (u16, &[u8]) {
        self.count += 1;
        let start = self.records.len();
        put_record(&mut self.records, self.kind, |body| put_body(self.count, body));
        (self.count, &self.records[start..])
    }
}

/// The channel, the number and the time of a message.
#[derive(Clone, Copy)]
pub(crate) struct MessageHeader {
    pub(crate) channel: u16,
    pub(crate) sequence: u32,
    /// The time in nanoseconds since 1970 (UTC).
    pub(crate) time: u64,
}

impl<W: Write> McapWriter<W> {
    /// Begins a file. In a compressed file, records stay in memory until their chunk is complete.
    pub(crate) fn new(to: W, library: &str, is_compressed: bool) -> io::Result<Self> {
        let mut writer = Self {
            to,
            position: 0,
            checksum: Hasher::new(),
            is_compressed,
            records: Vec::new(),
            chunk_times: None,
            times: None,
            schemas: Group::new(kind::SCHEMA),
            channels: Group::new(kind::CHANNEL),
            metadata: Group::new(kind::METADATA_INDEX),
            messages: Vec::new(),
            chunks: 0,
            unpacked: 0,
        };
        let mut start = MAGIC.to_vec();
        put_record(&mut start, kind::HEADER, |body| {
            put_strings(body, &["", library]);
        });
        writer.put(&start)?;
        Ok(writer)
    }

    /// Returns the number of bytes written, without the current chunk.
    pub(crate) const fn position(&self) -> u64 {
        self.position
    }

    /// Adds a schema and returns its number.
    pub(crate) fn add_schema(&mut self, name: &str, encoding: &str, data: &str) -> io::Result<u16> {
        let (number, record) = self.schemas.add(|number, body| {
            body.extend(number.to_le_bytes());
            put_strings(body, &[name, encoding, data]);
        });
        self.records.extend_from_slice(record);
        self.end_record()?;
        Ok(number)
    }

    /// Adds a channel and returns its number. Schema 0 means that the channel has none.
    pub(crate) fn add_channel(
        &mut self,
        schema: u16,
        [topic, encoding]: [&str; 2],
    ) -> io::Result<u16> {
        let (number, record) = self.channels.add(|number, body| {
            body.extend([number, schema].map(u16::to_le_bytes).as_flattened());
            put_strings(body, &[topic, encoding]);
            put_sized(body, &[]);
        });
        self.records.extend_from_slice(record);
        self.messages.push(0);
        self.end_record()?;
        Ok(number)
    }

    /// Writes a message.
    pub(crate) fn write(&mut self, header: MessageHeader, data: &[u8]) -> io::Result<()> {
        if self.records.len() > CHUNK_BYTES {
            self.end_chunk()?;
        }
        let MessageHeader { channel, sequence, time } = header;
        let during = |times: Option<(u64, u64)>| {
            times.map_or((time, time), |(start, end)| (start.min(time), end.max(time)))
        };
        (self.chunk_times, self.times) = (Some(during(self.chunk_times)), Some(during(self.times)));
        if let Some(count) = self.messages.get_mut(usize::from(channel).wrapping_sub(1)) {
            *count += 1;
        }
        put_record(&mut self.records, kind::MESSAGE, |body| {
            body.extend(channel.to_le_bytes());
            body.extend(sequence.to_le_bytes());
            body.extend([time, time].map(u64::to_le_bytes).as_flattened());
            body.extend(data);
        });
        self.end_record()
    }

    /// Writes metadata, which is never compressed.
    pub(crate) fn write_metadata(&mut self, name: &str, map: &[(&str, &str)]) -> io::Result<()> {
        self.end_chunk()?;
        let mut record = Vec::new();
        put_record(&mut record, kind::METADATA, |body| {
            put_strings(body, &[name]);
            let mut entries = Vec::new();
            for (key, value) in map {
                put_strings(&mut entries, &[key, value]);
            }
            put_sized(body, &entries);
        });
        let (start, length) = (self.position, record.len() as u64);
        self.metadata.add(|_, body| {
            body.extend([start, length].map(u64::to_le_bytes).as_flattened());
            put_strings(body, &[name]);
        });
        self.put(&record)
    }

    /// Ends the current chunk and flushes the output.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.end_chunk()?;
        self.to.flush()
    }

    /// Writes the summary.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        self.end_chunk()?;
        let mut end = Vec::new();
        let checksum = self.checksum.clone().finalize();
        put_record(&mut end, kind::DATA_END, |body| body.extend(checksum.to_le_bytes()));
        self.put(&end)?;

        let (start, mut summary, mut offsets) = (self.position, Vec::new(), Vec::new());
        let statistics = self.statistics();
        for group in [&self.schemas, &self.channels, &statistics, &self.metadata] {
            if group.count > 0 {
                put_record(&mut offsets, kind::SUMMARY_OFFSET, |body| {
                    let place = [start + summary.len() as u64, group.records.len() as u64];
                    body.push(group.kind);
                    body.extend(place.map(u64::to_le_bytes).as_flattened());
                });
                summary.extend_from_slice(&group.records);
            }
        }
        let offsets_start = start + summary.len() as u64;
        summary.append(&mut offsets);
        put_record(&mut summary, kind::FOOTER, |body| {
            body.extend([start, offsets_start].map(u64::to_le_bytes).as_flattened());
            body.extend([0; 4]);
        });
        let checksum = summary.len() - 4;
        let (covered, field) = summary.split_at_mut(checksum);
        field.copy_from_slice(&crc32fast::hash(covered).to_le_bytes());
        summary.extend(MAGIC);
        self.put(&summary)?;
        self.to.flush()
    }

    fn statistics(&self) -> Group {
        let counts = self.messages.iter().zip(1_u16..).filter(|&(&count, _)| count > 0);
        let mut statistics = Group::new(kind::STATISTICS);
        statistics.add(|_, body| {
            body.extend(self.messages.iter().sum::<u64>().to_le_bytes());
            body.extend(self.schemas.count.to_le_bytes());
            let attachments = 0;
            let [channels, metadata] =
                [&self.channels, &self.metadata].map(|group| group.count.into());
            let counts32: [u32; 4] = [channels, attachments, metadata, self.chunks];
            body.extend(counts32.map(u32::to_le_bytes).as_flattened());
            let (first, last) = self.times.unwrap_or_default();
            body.extend([first, last].map(u64::to_le_bytes).as_flattened());
            let counts: Vec<u8> = counts
                .flat_map(|(count, channel)| {
                    channel.to_le_bytes().into_iter().chain(count.to_le_bytes())
                })
                .collect();
            put_sized(body, &counts);
        });
        statistics
    }

    /// Writes the record to the file unless it belongs to a chunk.
    fn end_record(&mut self) -> io::Result<()> {
        if self.is_compressed { Ok(()) } else { self.end_chunk() }
    }

    /// Writes all records to the file.
    fn end_chunk(&mut self) -> io::Result<()> {
        let records = std::mem::take(&mut self.records);
        if records.is_empty() {
            return Ok(());
        }
        let (start, end) = self.chunk_times.take().unwrap_or_default();
        if self.is_compressed {
            // Compressing all data in one call would choose a smaller window for short recordings,
            // which makes them larger.
            let packed = zstd::encode_all(&*records, LEVEL)?;
            self.unpacked += records.len() as u64;
            // Readers refuse files whose chunks are too much larger than the file.
            let max =
                MAX_UNPACKED_BYTES + MAX_COMPRESSION_RATIO * (self.position + packed.len() as u64);
            let (compression, data) =
                if self.unpacked <= max { ("zstd", &packed) } else { ("", &records) };
            let mut chunk = Vec::new();
            put_record(&mut chunk, kind::CHUNK, |body| {
                let numbers = [start, end, records.len() as u64];
                body.extend(numbers.map(u64::to_le_bytes).as_flattened());
                body.extend(crc32fast::hash(&records).to_le_bytes());
                put_strings(body, &[compression]);
                body.extend((data.len() as u64).to_le_bytes());
                body.extend(data);
            });
            self.chunks += 1;
            self.put(&chunk)?;
        } else {
            self.put(&records)?;
        }
        // Keeps the memory for the next records.
        self.records = records;
        self.records.clear();
        Ok(())
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to.write_all(bytes)?;
        self.checksum.update(bytes);
        self.position += bytes.len() as u64;
        Ok(())
    }
}

/// Appends a record. `put_body` appends its body.
fn put_record(to: &mut Vec<u8>, kind: u8, put_body: impl FnOnce(&mut Vec<u8>)) {
    to.push(kind);
    let start = to.len() + 8;
    to.extend([0; 8]);
    put_body(to);
    let length = (to.len() - start) as u64;
    to[start - 8..start].copy_from_slice(&length.to_le_bytes());
}

fn put_strings(to: &mut Vec<u8>, texts: &[&str]) {
    for text in texts {
        put_sized(to, text.as_bytes());
    }
}

/// Appends the length in four bytes, and the bytes.
fn put_sized(to: &mut Vec<u8>, bytes: &[u8]) {
    #[expect(clippy::cast_possible_truncation, reason = "names and descriptions are short")]
    to.extend((bytes.len() as u32).to_le_bytes());
    to.extend(bytes);
}

#[cfg(test)]
mod tests {
    use mcap::records::{Record, SummaryOffset};
    use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

    use super::*;
    use crate::mcap::reader::{End, RecordReader};

    /// Returns a file with metadata, a schema, three channels and 400 messages.
    fn file(is_compressed: bool) -> Vec<u8> {
        let mut file = Vec::new();
        let mut writer = McapWriter::new(&mut file, "mmsim 1", is_compressed).unwrap();
        writer.write_metadata("first", &[("a", "é"), ("b", "")]).unwrap();
        let state = writer.add_channel(0, ["/state", "bytes"]).unwrap();
        let unused = writer.add_channel(0, ["/unused", "bytes"]).unwrap();
        let schema = writer.add_schema("Pose", "jsonschema", "{}").unwrap();
        let pose = writer.add_channel(schema, ["/pose", "json"]).unwrap();
        assert_eq!((state, unused, pose, schema), (1, 2, 3, 1));
        for number in 0..400_u32 {
            let channel = if number % 4 == 0 { pose } else { state };
            let header =
                MessageHeader { channel, sequence: number, time: 1000 - u64::from(number) };
            writer.write(header, &data(number)).unwrap();
            if number == 1 {
                writer.write_metadata("second", &[]).unwrap();
            }
        }
        writer.finish().unwrap();
        file
    }

    fn data(number: u32) -> Vec<u8> {
        number.to_le_bytes().repeat(2000)
    }

    #[test]
    fn another_implementation_reads_the_messages_and_the_summary() {
        for is_compressed in [false, true] {
            let file = file(is_compressed);
            let messages = mcap::MessageStream::new(&file).unwrap().map(Result::unwrap);
            for (message, number) in messages.zip(0..) {
                let is_pose = number % 4 == 0;
                let channel = &message.channel;
                let expected = if is_pose { ("/pose", "json") } else { ("/state", "bytes") };
                assert_eq!((&*channel.topic, &*channel.message_encoding), expected);
                assert_eq!(
                    channel.schema.as_ref().map(|schema| &*schema.name),
                    is_pose.then_some("Pose")
                );
                let time = 1000 - u64::from(number);
                assert_eq!((message.log_time, message.publish_time), (time, time));
                assert_eq!((message.sequence, &*message.data), (number, &*data(number)));
            }
            let summary = mcap::Summary::read(&file).unwrap().unwrap();
            assert_eq!((summary.channels.len(), summary.schemas.len()), (3, 1));
            let statistics = summary.stats.unwrap();
            let counts = [(1, 300), (3, 100)].into();
            assert_eq!(
                (statistics.message_count, statistics.channel_message_counts),
                (400, counts)
            );
            // 1 MiB consists of 131 messages of about 8 kB. The second metadata ends a chunk.
            assert_eq!(statistics.chunk_count, if is_compressed { 5 } else { 0 });
            assert_eq!((statistics.schema_count, statistics.channel_count), (1, 3));
            assert_eq!((statistics.metadata_count, statistics.attachment_count), (2, 0));
            assert_eq!((statistics.message_start_time, statistics.message_end_time), (601, 1000));
            let metadata = summary.metadata_indexes.iter();
            let metadata: Vec<_> =
                metadata.map(|index| mcap::read::metadata(&file, index).unwrap()).collect();
            assert_eq!(
                metadata[0].metadata,
                [("a", "é"), ("b", "")].map(|(k, v)| (k.into(), v.into())).into()
            );
            assert_eq!((metadata[1].name.as_str(), metadata[1].metadata.len()), ("second", 0));
        }
    }

    #[test]
    fn files_that_compress_too_well_are_readable() {
        let (mut file, data) = (io::Cursor::new(Vec::new()), vec![0; 2 * CHUNK_BYTES]);
        let mut writer = McapWriter::new(&mut file, "", true).unwrap();
        let channel = writer.add_channel(0, ["/state", "bytes"]).unwrap();
        for sequence in 0..100 {
            writer.write(MessageHeader { channel, sequence, time: 0 }, &data).unwrap();
        }
        writer.finish().unwrap();
        assert!(file.get_ref().len() < 2 * data.len(), "{} bytes", file.get_ref().len());
        let (mut reader, mut messages) = (RecordReader::new(file).unwrap(), 0);
        let end = loop {
            let read = reader.read_next::<()>(|kind, _| {
                messages += u32::from(kind == kind::MESSAGE);
                Ok(())
            });
            if let Err(end) = read {
                break end;
            }
        };
        assert!(matches!((&end, messages), (End::Closed, 100)), "{messages} messages: {end:?}");
    }

    #[test]
    fn checksums_and_offsets_are_valid() {
        for is_compressed in [false, true] {
            let file = file(is_compressed);
            let options = LinearReaderOptions::default()
                .with_validate_chunk_crcs(true)
                .with_validate_data_section_crc(true)
                .with_validate_summary_section_crc(true);
            let mut reader = LinearReader::new_with_options(options);
            let (mut rest, mut offsets, mut kinds) = (&file[..], Vec::new(), Vec::new());
            while let Some(event) = reader.next_event() {
                match event.unwrap() {
                    LinearReadEvent::ReadRequest(bytes) => {
                        let (now, later) = rest.split_at(bytes.min(rest.len()));
                        reader.insert(now.len()).copy_from_slice(now);
                        reader.notify_read(now.len());
                        rest = later;
                    }
                    LinearReadEvent::Record { opcode, data } => {
                        kinds.push(opcode);
                        match mcap::parse_record(opcode, data).unwrap() {
                            Record::SummaryOffset(offset) => offsets.push(offset),
                            Record::DataEnd(end) => assert_ne!(end.data_section_crc, 0),
                            Record::Footer(footer) => {
                                assert_ne!(footer.summary_crc, 0);
                                let first = usize::try_from(footer.summary_offset_start).unwrap();
                                assert_eq!(file[first], kind::SUMMARY_OFFSET);
                                assert_eq!(footer.summary_start, offsets[0].group_start);
                            }
                            _ => {}
                        }
                    }
                }
            }
            assert_eq!(kinds.last(), Some(&kind::FOOTER));
            let kinds = [kind::SCHEMA, kind::CHANNEL, kind::STATISTICS, kind::METADATA_INDEX];
            assert_eq!(offsets.iter().map(|offset| offset.group_opcode).collect::<Vec<_>>(), kinds);
            for SummaryOffset { group_opcode, group_start, group_length } in offsets {
                let [start, length] =
                    [group_start, group_length].map(|number| usize::try_from(number).unwrap());
                assert_eq!(file[start], group_opcode);
                assert_ne!(file[start + length], group_opcode);
            }
        }
    }
}
