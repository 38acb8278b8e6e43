//! Peers that send raw ZMTP bytes, both valid and invalid.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use mmsim_tests::TIMEOUT;
use socket2::SockRef;

/// The greeting of ZMTP 3.1 with the mechanism NULL.
pub(crate) fn greeting() -> Vec<u8> {
    [&[0xff, 0, 0, 0, 0, 0, 0, 0, 0, 0x7f, 3, 1][..], b"NULL", &[0; 48]].concat()
}

/// Returns the READY command of a socket of type `kind`, with an extra property of `more` bytes.
pub(crate) fn ready(kind: &str, more: usize) -> Vec<u8> {
    let property = |name: &str, value: &[u8]| {
        let lengths = (
            [u8::try_from(name.len()).unwrap()],
            u32::try_from(value.len()).unwrap().to_be_bytes(),
        );
        [&lengths.0[..], name.as_bytes(), &lengths.1, value].concat()
    };
    let mut body = [&b"\x05READY"[..], &property("Socket-Type", kind.as_bytes())].concat();
    if more > 0 {
        body.extend(property("X-More", &vec![b'x'; more]));
    }
    frame(4, &body)
}

/// Returns a frame with the given flags. Adds the flag for a long frame if needed.
pub(crate) fn frame(flags: u8, body: &[u8]) -> Vec<u8> {
    match u8::try_from(body.len()) {
        Ok(length) => [&[flags, length][..], body].concat(),
        Err(_) => [&[flags | 2][..], &(body.len() as u64).to_be_bytes(), body].concat(),
    }
}

/// Returns the bytes that a REQ socket sends for a request.
pub(crate) fn request(body: &[u8]) -> Vec<u8> {
    [&frame(1, b"")[..], &frame(0, body)].concat()
}

/// Returns a ZMTP command with the given name.
pub(crate) fn command(name: &str, rest: &[u8]) -> Vec<u8> {
    frame(4, &[&[u8::try_from(name.len()).unwrap()][..], name.as_bytes(), rest].concat())
}

/// Opens a TCP connection with a long timeout and sends no greeting.
pub(crate) fn connect(address: &str) -> TcpStream {
    with_timeouts(TcpStream::connect(address.strip_prefix("tcp://").unwrap()).unwrap())
}

/// Sets a long timeout, and sends without delay.
pub(crate) fn with_timeouts(stream: TcpStream) -> TcpStream {
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    stream.set_write_timeout(Some(TIMEOUT)).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

/// Connects and completes the handshake.
pub(crate) fn greet(address: &str) -> TcpStream {
    let mut stream = connect(address);
    stream.write_all(&[greeting(), ready("DEALER", 0)].concat()).unwrap();
    let (mut theirs, mut head) = ([0; 64], [0; 2]);
    stream.read_exact(&mut theirs).unwrap();
    stream.read_exact(&mut head).unwrap();
    let mut body = vec![0; head[1].into()];
    stream.read_exact(&mut body).unwrap();
    assert!(theirs[0] == 0xff && body.starts_with(b"\x05READY"));
    stream
}

/// Sends a ping and expects a pong.
pub(crate) fn ping(stream: &mut TcpStream) {
    stream.write_all(&request(b"ping")).unwrap();
    let mut reply = [0; 8];
    stream.read_exact(&mut reply).unwrap();
    assert_eq!(&reply, b"\x01\0\0\x04pong");
}

/// Requests the walls at the start cell and expects a valid reply.
pub(crate) fn walls(stream: &mut TcpStream) {
    stream.write_all(&request(b"W\0\0N")).unwrap();
    let mut reply = [0; 7];
    stream.read_exact(&mut reply).unwrap();
    assert_eq!(reply[..4], [1, 0, 0, 3]);
}

/// Sends bytes; the server may close the connection before it receives all of them.
pub(crate) fn send(stream: &mut TcpStream, bytes: &[u8]) {
    if let Err(error) = stream.write_all(bytes) {
        let gone =
            [ErrorKind::ConnectionReset, ErrorKind::BrokenPipe, ErrorKind::ConnectionAborted];
        assert!(gone.contains(&error.kind()), "{error}");
    }
}

/// Waits until the server closes the connection.
pub(crate) fn wait_until_cut_off(mut stream: TcpStream) {
    let mut rest = [0; 4096];
    loop {
        match stream.read(&mut rest) {
            Ok(0) => return,
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => panic!("still connected"),
            Err(_) => return,
        }
    }
}

/// Closes the connection with a TCP reset, as when a process dies with unread data.
pub(crate) fn reset(stream: TcpStream) {
    SockRef::from(&stream).set_linger(Some(Duration::ZERO)).unwrap();
    drop(stream);
}
