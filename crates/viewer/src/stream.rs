//! A file as the body of a reply.

use std::fs::File;
use std::io::{self, Read};

use futures_util::stream::{self, Stream};

/// Bytes of a piece.
const PIECE_BYTES: usize = 256 * 1024;

/// The content of a file, piece by piece, each read once the one before it has gone out.
pub(crate) fn from_file(file: File) -> impl Stream<Item = io::Result<Vec<u8>>> {
    stream::unfold(Some(file), |file| async {
        let mut file = file?;
        let read = tokio::task::spawn_blocking(move || {
            let mut piece = Vec::with_capacity(PIECE_BYTES);
            let count = file.by_ref().take(PIECE_BYTES as u64).read_to_end(&mut piece)?;
            Ok((count > 0).then_some((piece, file)))
        });
        match read.await.map_err(io::Error::other).and_then(|read| read) {
            Ok(Some((piece, file))) => Some((Ok(piece), Some(file))),
            Ok(None) => None,
            Err(error) => Some((Err(error), None)),
        }
    })
}
