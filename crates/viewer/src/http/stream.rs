//! Streams a file as the body of a response.

use std::io::{self, Read};

use futures_util::stream::{self, Stream};

const CHUNK_BYTES: usize = 256 * 1024;

/// Streams all bytes of a reader. Each chunk is read only after the previous one has been sent.
pub(crate) fn from_reader<R: Read + Send + 'static>(
    reader: R,
) -> impl Stream<Item = io::Result<Vec<u8>>> {
    stream::unfold(Some(reader), |reader| async {
        let mut reader = reader?;
        let read = tokio::task::spawn_blocking(move || {
            let mut chunk = Vec::with_capacity(CHUNK_BYTES);
            let count = reader.by_ref().take(CHUNK_BYTES as u64).read_to_end(&mut chunk)?;
            Ok((count > 0).then_some((chunk, reader)))
        });
        match read.await.map_err(io::Error::other).and_then(|read| read) {
            Ok(Some((chunk, reader))) => Some((Ok(chunk), Some(reader))),
            Ok(None) => None,
            Err(error) => Some((Err(error), None)),
        }
    })
}
