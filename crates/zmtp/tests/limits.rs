//! Tests of servers with small limits.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::thread;
use std::time::Duration;

use mmsim_zmtp::codec::{GREETING, ProtocolError, READY, REQ_READY};
use mmsim_zmtp::{Answer, ClientId, ConfigError, RepServer, ServerConfig, Service, listen};

/// Replies with the request. The request `p` does not count as activity.
struct Echo;

impl Service for Echo {
    fn answer(
        &mut self,
        _: ClientId,
        request: &[u8],
        _frames: usize,
        reply: &mut Vec<u8>,
    ) -> Answer {
        *reply = request.to_vec();
        Answer::Reply { is_activity: request != b"p" }
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = reason.to_string().into();
    }
}

/// Starts a server that runs until the process ends.
fn serve(config: ServerConfig) -> SocketAddr {
    let mut server = RepServer::with_config(listen("127.0.0.1", 0).unwrap(), config).unwrap();
    let address = server.local_address().unwrap();
    thread::spawn(move || server.run(&mut Echo, || false));
    address
}

fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    stream
}

/// Performs the handshake.
fn greet(mut stream: TcpStream) -> io::Result<TcpStream> {
    stream.write_all(&[&GREETING[..], REQ_READY].concat())?;
    stream.read_exact(&mut [0; GREETING.len() + READY.len()])?;
    Ok(stream)
}

/// Sends a request of one byte and reads its reply.
fn ask(stream: &mut TcpStream, request: u8) -> io::Result<()> {
    let message = [1, 0, 0, 1, request];
    stream.write_all(&message)?;
    let mut reply = [0; 5];
    stream.read_exact(&mut reply)?;
    assert_eq!(reply, message);
    Ok(())
}

#[test]
fn impossible_limits_are_refused() {
    let config = ServerConfig { max_connections: 0, ..ServerConfig::DEFAULT };
    let error = RepServer::with_config(listen("127.0.0.1", 0).unwrap(), config).err().unwrap();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    let error = error.into_inner().unwrap().downcast::<ConfigError>().unwrap();
    assert_eq!(error.limit, "max_connections");
}

#[test]
fn requests_before_the_stop_are_answered() {
    let mut server = RepServer::new(listen("127.0.0.1", 0).unwrap()).unwrap();
    let address = server.local_address().unwrap();
    let request = [1, 0, 0, 1, b'a'];
    let mut clients: Vec<_> = (0..20).map(|_| connect(address)).collect();
    for client in &mut clients {
        client.write_all(&[&GREETING[..], REQ_READY, &request].concat()).unwrap();
    }
    server.run(&mut Echo, || true).unwrap();
    drop(server);
    for client in &mut clients {
        let mut received = Vec::new();
        client.read_to_end(&mut received).unwrap();
        assert_eq!(received[GREETING.len() + READY.len()..], request);
    }
}

#[test]
fn slow_client_stays_connected_among_clients_that_only_ping() {
    let config =
        ServerConfig { max_connections: 4, silence: Duration::ZERO, ..ServerConfig::DEFAULT };
    let address = serve(config);
    let mut slow = greet(connect(address)).unwrap();
    ask(&mut slow, b'a').unwrap();
    let mut others = Vec::new();
    for _ in 0..40 {
        // Replaces another one, because none of them counts as active.
        let mut other = greet(connect(address)).unwrap();
        ask(&mut other, b'p').unwrap();
        others.push(other);
    }
    ask(&mut slow, b'b').unwrap();
    let connected = others.iter_mut().filter_map(|other| ask(other, b'p').ok());
    assert_eq!(connected.count(), 3);
}

/// This test connects from 127.0.0.2, which not every system provides by default.
#[cfg(target_os = "linux")]
#[test]
fn one_address_cannot_take_all_connections() {
    use socket2::{Domain, Socket, Type};

    let silence = Duration::from_secs(3600);
    let config = ServerConfig { max_connections: 4, silence, ..ServerConfig::DEFAULT };
    let address = serve(config);
    let mut busy: Vec<_> = (0..4).map(|_| greet(connect(address)).unwrap()).collect();
    for client in &mut busy {
        ask(client, b'a').unwrap();
    }
    assert!(greet(connect(address)).is_err(), "the server must be full");
    let other = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
    other.bind(&SocketAddr::from(([127, 0, 0, 2], 0)).into()).unwrap();
    other.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    other.connect(&address.into()).unwrap();
    ask(&mut greet(other.into()).unwrap(), b'b').unwrap();
    assert_eq!(busy.iter_mut().filter_map(|client| ask(client, b'c').ok()).count(), 3);
}

#[test]
fn slow_handshake_and_silence_after_an_oversized_frame_end_the_connection() {
    let short = Duration::from_millis(50);
    let config = ServerConfig {
        max_request_bytes: 10,
        max_kept_bytes: 4,
        handshake_time: short,
        oversized_time: short,
        ..ServerConfig::DEFAULT
    };
    let address = serve(config);
    let mut silent = connect(address);
    assert_eq!(silent.read_to_end(&mut Vec::new()).unwrap(), 10, "only the signature");
    // A client that is connected for longer than these times.
    let mut client = loop {
        if let Ok(client) = greet(connect(address)) {
            break client;
        }
    };
    connect(address).read_to_end(&mut Vec::new()).unwrap();
    client.write_all(b"\x01\0\0\x0a0123456789").unwrap();
    let mut reply = [0; 14];
    client.read_exact(&mut reply).unwrap();
    assert_eq!(reply, *b"\x01\0\0\x0a0123\0\0\0\0\0\0");
    client.write_all(b"\x01\0\0\x0b0123456789a").unwrap();
    let mut rest = Vec::new();
    client.read_to_end(&mut rest).unwrap();
    let expected = "expected a frame of at most 10 bytes, found 11";
    assert_eq!(rest[4..], *expected.as_bytes());
}
