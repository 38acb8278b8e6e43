//! A client of a simulator over a serial port: the socket type REQ of ZMTP 3.0, with the security
//! mechanism NULL (see <https://rfc.zeromq.org/spec/23/>).

/// A connection that transfers bytes.
pub(crate) trait Port {
    fn send(&mut self, byte: u8);

    /// Waits for a byte.
    fn receive(&mut self) -> u8;
}

/// The command READY with the property `Socket-Type: REQ`.
const READY: &[u8] = b"\x05READY\x0bSocket-Type\0\0\0\x03REQ";

/// The flags of a frame.
const MORE: u8 = 1;
const LONG: u8 = 2;
const COMMAND: u8 = 4;

/// A connected client.
pub(crate) struct Client<P>(P);

impl<P: Port> Client<P> {
    /// Connects to a simulator.
    pub(crate) fn new(port: P) -> Self {
        let mut client = Self(port);
        let mut greeting = [0; 64];
        // The signature, the version, and the mechanism.
        (greeting[0], greeting[9]) = (0xff, 0x7f);
        greeting[10..16].copy_from_slice(b"\x03\0NULL");
        greeting.into_iter().for_each(|byte| client.0.send(byte));
        greeting.fill_with(|| client.0.receive());
        client.send_frame(COMMAND, READY);
        // The peer's READY.
        client.receive_frame(&mut []);
        client
    }

    /// Sends the first `length` bytes of `buffer`, and returns the reply, which overwrites the
    /// buffer. A longer reply is cut off.
    pub(crate) fn ask<'b>(&mut self, buffer: &'b mut [u8], length: usize) -> &'b [u8] {
        // An empty frame precedes each request and reply.
        self.send_frame(MORE, &[]);
        self.send_frame(0, &buffer[..length]);
        while self.receive_frame(&mut []).0 & MORE == 0 {}
        let (_, length) = self.receive_frame(buffer);
        &buffer[..length]
    }

    fn send_frame(&mut self, flags: u8, body: &[u8]) {
        let length = (body.len() as u64).to_be_bytes();
        let is_long = body.len() > usize::from(u8::MAX);
        self.0.send(if is_long { flags | LONG } else { flags });
        let length = if is_long { &length[..] } else { &length[7..] };
        length.iter().chain(body).for_each(|&byte| self.0.send(byte));
    }

    /// Receives a frame. Returns its flags, and the number of bytes written to `buffer`.
    fn receive_frame(&mut self, buffer: &mut [u8]) -> (u8, usize) {
        let flags = self.0.receive();
        let bytes = if flags & LONG > 0 { 8 } else { 1 };
        let length = (0..bytes).fold(0, |length, _| length << 8 | u64::from(self.0.receive()));
        let mut place = buffer.iter_mut();
        let mut received = 0;
        for _ in 0..length {
            let byte = self.0.receive();
            if let Some(place) = place.next() {
                *place = byte;
                received += 1;
            }
        }
        (flags, received)
    }
}
