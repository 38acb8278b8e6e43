//! Compresses responses with gzip.

use std::io::Cursor;

use axum::body::{Body, HttpBody, to_bytes};
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use flate2::Compression;
use flate2::bufread::GzEncoder;

use crate::api_error::ApiError;
use crate::stream;

/// The minimum size, in bytes, at which a response is compressed. Frequent responses, such as the
/// view of a single state, are smaller and therefore not compressed.
const MIN_COMPRESSED_BYTES: u64 = 4096;

/// Compresses the response of a handler if this makes it smaller and the client accepts it.
pub(crate) async fn compress(request: Request, next: Next) -> Response {
    let is_accepted = accepts_gzip(request.headers());
    let mut response = next.run(request).await;
    if !is_compressible(&response) {
        return response;
    }
    response.headers_mut().append(header::VARY, HeaderValue::from_static("accept-encoding"));
    if !is_accepted {
        return response;
    }
    let (mut head, body) = response.into_parts();
    // Waits for nothing, because a body of known length is in memory already.
    let content = match to_bytes(body, usize::MAX).await {
        Ok(content) => content,
        Err(error) => return ApiError::internal(error).into_response(),
    };
    head.headers.remove(header::CONTENT_LENGTH);
    head.headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    let gzip = GzEncoder::new(Cursor::new(content), Compression::default());
    Response::from_parts(head, Body::from_stream(stream::from_reader(gzip)))
}

/// Returns true if a response is long and likely to become shorter. Streams, such as events, have
/// no known length and are sent as they are.
fn is_compressible(response: &Response) -> bool {
    let media_type = response.headers().get(header::CONTENT_TYPE);
    let media_type = media_type.and_then(|value| value.to_str().ok()).unwrap_or_default();
    let is_text = ["text/", "application/json", "image/svg+xml"]
        .iter()
        .any(|start| media_type.starts_with(start));
    let bytes = response.body().size_hint().exact();
    is_text && bytes.is_some_and(|bytes| bytes >= MIN_COMPRESSED_BYTES)
}

/// Returns true if the client accepts gzip. Other clients receive the original.
fn accepts_gzip(headers: &HeaderMap) -> bool {
    let values = headers.get_all(header::ACCEPT_ENCODING).iter();
    values.filter_map(|value| value.to_str().ok()).flat_map(|value| value.split(',')).any(
        |coding| {
            let (name, quality) = coding.split_once(';').unwrap_or((coding, "q=1"));
            let quality = quality.trim().to_ascii_lowercase();
            let quality = quality.strip_prefix("q=").and_then(|number| number.parse().ok());
            name.trim().eq_ignore_ascii_case("gzip")
                && quality.is_some_and(|quality: f32| quality > 0.0)
        },
    )
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use axum::response::Sse;
    use axum::response::sse::Event;
    use futures_util::stream;

    use super::*;

    #[test]
    fn only_long_texts_of_known_length_are_compressed() {
        let response = |media_type: &'static str, bytes: usize| {
            ([(header::CONTENT_TYPE, media_type)], vec![b'a'; bytes]).into_response()
        };
        for media_type in ["text/css; charset=utf-8", "application/json", "image/svg+xml"] {
            assert!(is_compressible(&response(media_type, 4096)), "{media_type}");
            assert!(!is_compressible(&response(media_type, 4095)), "{media_type}");
        }
        for media_type in ["image/png", "application/octet-stream"] {
            assert!(!is_compressible(&response(media_type, 4096)), "{media_type}");
        }
        let events = Sse::new(stream::empty::<Result<Event, Infallible>>()).into_response();
        assert_eq!(events.headers()[header::CONTENT_TYPE], "text/event-stream");
        assert!(!is_compressible(&events));
    }

    #[test]
    fn clients_may_refuse_gzip() {
        let accepts = |values: &[&'static str]| {
            let value = |&value| (header::ACCEPT_ENCODING, HeaderValue::from_static(value));
            accepts_gzip(&values.iter().map(value).collect())
        };
        for accepted in ["gzip", "br, GZIP ;q=0.5", "deflate;q=1.0,gzip; Q=0.001"] {
            assert!(accepts(&[accepted]), "{accepted}");
        }
        assert!(accepts(&["br", "gzip"]));
        for refused in ["", "br", "gzip;q=0", "gzip; q=0.000, deflate", "gzip;x", "xgzip"] {
            assert!(!accepts(&[refused]), "{refused}");
        }
        assert!(!accepts(&[]));
    }
}
