//! Random requests, valid and malformed.

use mmsim_maze::{MazeSize, WyRand};

/// The maximum length of a frame.
const MAX_BYTES: usize = 64 << 10;

/// Lengths at which a limit of the protocol begins.
const LENGTHS: [usize; 6] = [0, 4095, 4096, 4097, MAX_BYTES - 1, MAX_BYTES];

/// Characters of texts. The last ones are not printable.
const CHARACTERS: [char; 14] =
    ['0', '1', '9', 'a', '~', ' ', 'é', '∞', '東', '🐭', '\t', '\n', '\u{202e}', '\u{9f}'];

/// The number of [`CHARACTERS`] that are printable.
const PRINTABLE: usize = 10;

/// Random requests for a maze of one size.
pub(crate) struct Requests {
    pub(crate) rng: WyRand,
    size: MazeSize,
    /// The newest state. The next one may be similar.
    state: Vec<u8>,
}

impl Requests {
    pub(crate) fn new(rng: WyRand, size: MazeSize) -> Self {
        Self { rng, size, state: vec![0; 6 + 2 * size.area()] }
    }

    /// Returns some requests, of which this part is malformed.
    pub(crate) fn batch(&mut self, malformed: f64) -> Vec<Vec<u8>> {
        if self.rng.chance(0.01) {
            // As many annotations as the server keeps before a state, and one more.
            let line = |length: u16| {
                [&b"L"[..], &length.to_le_bytes(), &vec![b'x'; length.into()]].concat()
            };
            let mut full = vec![line(1000).repeat(4); 16];
            full.extend([line(1000), line(338), b"t".into()]);
            let full = full.into_iter().map(|entries| [&b"A"[..], &entries].concat());
            return [self.state()].into_iter().chain(full).collect();
        }
        let count = 1 + self.rng.index(12);
        (0..count).map(|_| self.request(malformed)).collect()
    }

    fn request(&mut self, malformed: f64) -> Vec<u8> {
        let mut request = self.valid();
        if self.rng.chance(malformed) {
            for _ in 0..=self.rng.below(2) {
                self.mutate(&mut request);
            }
            // The server disconnects a peer some time after a longer frame.
            request.truncate(MAX_BYTES);
        }
        request
    }

    fn valid(&mut self) -> Vec<u8> {
        match self.rng.weighted([1, 10, 10, 30, 60, 40]) {
            Some(0) => b"reset".into(),
            Some(1) => b"ping".into(),
            Some(2) => b"info".into(),
            Some(3) => [&b"W"[..], &self.cell(), &[self.one_of(b"NESW")]].concat(),
            Some(4) => self.state(),
            _ => {
                let count = 1 + self.rng.index(5);
                let entries = (0..count).flat_map(|_| self.entry());
                [b'A'].into_iter().chain(entries).collect()
            }
        }
    }

    fn state(&mut self) -> Vec<u8> {
        let (byte, kind) = (self.byte(), self.rng.below(8));
        match kind {
            0 => self.state.fill_with(|| self.rng.next_u64().to_be_bytes()[0]),
            1 => self.state.fill(byte),
            _ => {
                for _ in 0..4 {
                    let index = self.rng.index(self.state.len());
                    self.state[index] = self.byte();
                }
            }
        }
        let [x, y] = self.cell();
        let head = [b'S', x, y, self.one_of(b"NESW"), self.one_of(b"CF")];
        self.state[..head.len()].copy_from_slice(&head);
        self.state[head.len() + self.size.area()] = self.one_of(b"CF");
        self.state.clone()
    }

    fn entry(&mut self) -> Vec<u8> {
        let letter = self.one_of(b"TTTTCCCDDDLLLMSRtcd");
        let mut entry = vec![letter];
        if b"TCD".contains(&letter) {
            entry.extend(self.cell());
        }
        match letter {
            b'T' => entry.extend(self.text(11, 1)),
            b'C' => entry.push(self.one_of(b"kbacgorwyBCAGORVY-")),
            b'D' => entry.extend([self.one_of(b"NESW"), self.one_of(b"10?-")]),
            b'L' if self.rng.chance(0.9) => entry.extend(self.text(40, 2)),
            b'L' => entry.extend(self.text(1002, 2)),
            b'M' | b'S' => entry.extend(self.text(60, 1)),
            _ => {}
        }
        entry
    }

    /// Returns a text of fewer than `max` characters, after its length in `length_bytes` bytes.
    fn text(&mut self, max: usize, length_bytes: usize) -> Vec<u8> {
        let count = self.rng.index(max);
        let choices = if self.rng.chance(0.02) { CHARACTERS.len() } else { PRINTABLE };
        let text: String = (0..count).map(|_| CHARACTERS[self.rng.index(choices)]).collect();
        [&text.len().to_le_bytes()[..length_bytes], text.as_bytes()].concat()
    }

    fn mutate(&mut self, request: &mut Vec<u8>) {
        let (index, other) = (self.rng.index(request.len()), self.rng.index(request.len()));
        let byte = self.byte();
        match self.rng.below(9) {
            0 | 1 if !request.is_empty() => request[index] = byte,
            2 if !request.is_empty() => request.swap(index, other),
            3 if !request.is_empty() => drop(request.remove(index)),
            4 => request.truncate(index),
            5 => request.insert(index, byte),
            6 => request.extend((0..=self.rng.below(9)).map(|_| self.byte())),
            7 => request.extend(self.valid()),
            _ => {
                let sizes = [(16, 16), (1, 1), (2, 1), (21, 21), (32, 32)];
                let states = sizes.map(|(width, height)| 6 + 2 * width * height);
                let own = self.state.len();
                let lengths = [&LENGTHS[..], &states, &[own - 1, own + 1]].concat();
                request.resize(lengths[self.rng.index(lengths.len())], byte);
            }
        }
    }

    fn cell(&mut self) -> [u8; 2] {
        let (width, height) = (self.size.width(), self.size.height());
        [width, height].map(|side| u8::try_from(self.rng.below(side.into())).unwrap())
    }

    fn byte(&mut self) -> u8 {
        if self.rng.flip() {
            self.one_of(b"\0\x01\x7f\xff ASWNESWCFTLDMRtcd\n")
        } else {
            self.rng.next_u64().to_be_bytes()[0]
        }
    }

    fn one_of(&mut self, bytes: &[u8]) -> u8 {
        bytes[self.rng.index(bytes.len())]
    }
}
