//! Malformed requests.

use mmsim_maze::{Cell, Excerpt, Heading, MazeSize, Pose};
use mmsim_protocol::Request;

/// The length of a request above the limit of every server.
const TOO_LONG: usize = 1 << 20;

/// A malformed request: its description and its frames.
type Malformed = (String, Vec<Vec<u8>>);

/// Returns requests that are malformed for a maze of this size. `walls` and `state` are valid `W`
/// and `S` requests.
pub(super) fn malformed_requests(size: MazeSize, walls: &[u8], state: &[u8]) -> Vec<Malformed> {
    let too_long = vec![b'x'; TOO_LONG];
    let unknown = [&b"foo"[..], b"", b"PING", b"ping\n", b"reset ", b"A", &too_long];
    let mut requests: Vec<_> = unknown.iter().map(|request| one_frame(request, "")).collect();
    let (width, height) = (size.width(), size.height());
    for (x, y) in [(width, height), (width - 1, height), (width, height - 1), (255, 0), (255, 255)]
    {
        let mut request = walls.to_vec();
        let outside = Request::Walls(Pose::new(Cell::new(x, y), Heading::North));
        if outside.encode(&mut request).is_ok() {
            requests.push(one_frame(&request, ""));
        }
    }
    for valid in [walls, state] {
        for length in [1, 2, 4, 6, valid.len() - 1, valid.len() + 1] {
            let mut request = valid.to_vec();
            request.resize(length, 0);
            requests.push(one_frame(&request, ""));
        }
        // The codec decides which values are invalid.
        for (at, &byte) in valid.iter().enumerate() {
            for wrong in [b'X', byte.to_ascii_lowercase(), u8::MAX] {
                let mut request = valid.to_vec();
                request[at] = wrong;
                let note = format!(" (byte {at} is {})", Excerpt::<1>::new(&[wrong]));
                requests.push(one_frame(&request, &note));
            }
        }
    }
    requests.retain(|(_, frames)| Request::decode(&frames[0], size).is_err());
    let (start, end) = walls.split_at(walls.len() - 1);
    let messages: [&[&[u8]]; 7] = [
        &[b"ping", b"x"],
        &[b"foo", b"ping"],
        &[b"", b"ping"],
        &[b"ping", b""],
        &[b"ping", b"ping"],
        &[walls, state],
        &[start, end],
    ];
    requests.extend(messages.map(|frames| {
        let names: Vec<_> = frames.iter().map(|frame| excerpt(frame)).collect();
        let name = format!("malformed frames {}", names.join(", "));
        (name, frames.iter().map(|frame| frame.to_vec()).collect())
    }));
    requests
}

fn one_frame(request: &[u8], note: &str) -> Malformed {
    (format!("malformed {}{note}", excerpt(request)), vec![request.into()])
}

fn excerpt(frame: &[u8]) -> String {
    if frame.is_empty() { "\"\"".into() } else { Excerpt::<8>::new(frame).to_string() }
}
