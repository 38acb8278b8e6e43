//! Streams a file as the body of a response.

use std::fs::File;
use std::io::{self, Read};

use futures_util::stream::{self, Stream};

const CHUNK_BYTES: usize = 256 * 1024;

/// Streams the content of a file. Each chunk is read only after the previous one has been sent.
pub(crate) fn from_file(file: File) -> impl Stream<Item = io::Result<Vec<u8>>> {
    stream::unfold(Some(file), |file| async {
        let mut file = file?;
        let read = tokio::task::spawn_blocking(move || {
            let mut chunk = Vec::with_capacity(CHUNK_BYTES);
            let count = file.by_ref().take(CHUNK_BYTES as u64).read_to_end(&mut chunk)?;
            Ok((count > 0).then_some((chunk, file)))
        });
        match read.await.map_err(io::Error::other).and_then(|read| read) {
            Ok(Some((chunk, file))) => Some((Ok(chunk), Some(file))),
            Ok(None) => None,
            Err(error) => Some((Err(error), None)),
        }
    })
}
