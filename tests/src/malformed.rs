//! Malformed requests.

use mmsim_protocol::{MapState, Order};

use crate::classic_map;

/// Returns the encoded state (518 bytes) of a mouse at the start of a 16×16 maze.
///
/// # Panics
/// Never.
pub fn good_state() -> Vec<u8> {
    let (map, start) = classic_map();
    let mut state = vec![0; 518];
    MapState::new(start, &map, |cell| cell.x.into(), Order::C).encode(&mut state).unwrap();
    state
}

/// Returns [`good_state`] with one byte changed.
fn changed(index: usize, byte: u8) -> Vec<u8> {
    let mut state = good_state();
    state[index] = byte;
    state
}

/// Returns malformed requests for a maze of 16×16 cells. The requests cover every kind of malformed
/// request in docs/protocol.md that consists of a single frame.
///
/// # Panics
/// Never.
pub fn malformed_requests() -> Vec<Vec<u8>> {
    let mut requests: Vec<Vec<u8>> =
        [&b"foo"[..], b"", b"PING", b"ping\n", b"reset "].map(<[u8]>::to_vec).to_vec();
    requests.extend([&b"W"[..], b"W\0", b"W\0\0", b"W\0\0NN", b"WW\0\0N"].map(<[u8]>::to_vec));
    for (x, y) in
        [(16, 16), (15, 16), (16, 15), (255, 0), (255, 255), (0x57, 0), (0x57, 0x57), (0, 0x57)]
    {
        requests.push(vec![b'W', x, y, b'N']);
    }
    requests.extend([b'X', b'n', 0, 0xff].map(|heading| vec![b'W', 0, 0, heading]));
    for length in [1, 2, 4, 6, 517, 519] {
        let mut state = good_state();
        state.resize(length, 0);
        requests.push(state);
    }
    for order in [b'Z', b'c', b'f'] {
        requests.extend([changed(4, order), changed(261, order)]);
    }
    requests.push(changed(3, b'X'));
    for cell in [[200, 0], [0x53, 0x53]] {
        let mut state = good_state();
        state[1..3].copy_from_slice(&cell);
        requests.push(state);
    }
    requests
}
