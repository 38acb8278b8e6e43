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
    requests.extend(malformed_annotations());
    requests
}

/// Returns malformed annotations requests for a maze of 16×16 cells. Some of them begin with valid
/// annotations.
fn malformed_annotations() -> Vec<Vec<u8>> {
    let mut requests = vec![b"A".to_vec(), [&b"A"[..], &[b't'; 4096]].concat()];
    let text = |text: &[u8]| {
        let length = u8::try_from(text.len()).unwrap();
        [&b"T\0\0"[..], &[length], text].concat()
    };
    let line = |announced: u16, length: usize| {
        [&b"L"[..], &announced.to_le_bytes(), &vec![b'x'; length]].concat()
    };
    let name =
        |letter: &[u8], length: u8| [letter, &[length], &vec![b'x'; usize::from(length)]].concat();
    let mut malformed = vec![
        text(b"12345678901"),
        text(&[b'x'; 41]),
        text("\u{221e}".repeat(11).as_bytes()),
        text(b"\xff"),
        text(b"\xed\xa0\x80"),
        text(b"\x1b"),
        text(b"a\t"),
        text("\u{202e}".as_bytes()),
        text("\u{2028}".as_bytes()),
        line(1001, 1001),
        line(0xffff, 3),
        name(b"M", 101),
        name(b"S", 101),
    ];
    malformed.extend(
        [
            &b"X"[..],
            b"A",
            b"r",
            b"\0",
            b"T",
            b"T\0",
            b"T\0\0",
            b"T\0\0\x02a",
            b"T\x10\0\0",
            b"T\0\x10\0",
            b"C",
            b"C\0",
            b"C\0\0",
            b"C\0\0x",
            b"C\x10\0g",
            b"D",
            b"D\0\0",
            b"D\0\0N",
            b"D\0\0n1",
            b"D\0\0N2",
            b"D\x10\0N1",
            b"L",
            b"L\0",
            b"L\x02\0a",
            b"L\x02\0a\n",
            b"L\x03\0\xe2\x80\xae",
            b"M",
            b"M\x02a",
            b"M\x01\t",
            b"S",
            b"S\x02a",
        ]
        .map(<[u8]>::to_vec),
    );
    for malformed in malformed {
        for valid in [&b""[..], b"T\0\0\x02noC\0\0gD\0\0E?L\x02\0noM\x02noS\x02no"] {
            requests.push([b"A", valid, &malformed].concat());
        }
    }
    requests
}
