//! Tests of the client with servers that stop, misbehave, or send their bytes slowly.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use mmsim_zmtp::codec::{GREETING, ProtocolError, READY, REQ_READY, push_request};
use mmsim_zmtp::connection::DisconnectReason;
use mmsim_zmtp::{ClientConfig, ReqClient, listen};

/// The time limit for waits that should end earlier.
const TIMEOUT: Duration = Duration::from_secs(60);
/// The time limit for waits that end without a reply.
const SHORT: Duration = Duration::from_millis(150);

fn connect(listener: &TcpListener) -> ReqClient {
    let address = listener.local_addr().unwrap();
    ReqClient::new(format!("tcp://{address}").parse().unwrap()).unwrap()
}

/// Sends a request and returns the reply of one frame.
fn ask(client: &mut ReqClient, request: &[u8]) -> Result<Vec<u8>, DisconnectReason> {
    let mut reply = Vec::new();
    client.send(&[request]);
    let frames = client.receive(&mut reply, TIMEOUT)?;
    assert_eq!(frames, Some(1), "reply to {request:?}");
    Ok(reply)
}

fn accept(listener: &TcpListener) -> TcpStream {
    let stream = listener.accept().unwrap().0;
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

/// Accepts a connection and performs the handshake.
fn accept_client(listener: &TcpListener) -> TcpStream {
    let mut stream = accept(listener);
    stream.write_all(&[&GREETING[..], READY].concat()).unwrap();
    expect(&mut stream, &[&GREETING[..], REQ_READY].concat());
    stream
}

fn expect(stream: &mut TcpStream, expected: &[u8]) {
    let mut found = vec![0; expected.len()];
    stream.read_exact(&mut found).unwrap();
    assert_eq!(found, expected);
}

fn message(body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    push_request(&mut bytes, &[body]);
    bytes
}

/// Reads the request `body` and sends it back.
fn echo(stream: &mut TcpStream, body: &[u8]) {
    expect(stream, &message(body));
    stream.write_all(&message(body)).unwrap();
}

#[test]
fn server_may_start_later() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (mut client, address) = (connect(&listener), listener.local_addr().unwrap());
    drop(listener);
    let mut reply = Vec::new();
    client.send(&[b"dropped"]);
    assert_eq!(client.receive(&mut reply, SHORT).unwrap(), None);
    client.send(&[b"a", b"", b"b"]);
    assert_eq!(client.receive(&mut reply, SHORT).unwrap(), None);
    let listener = TcpListener::bind(address).unwrap();
    let server = thread::spawn(move || {
        let mut stream = accept_client(&listener);
        expect(&mut stream, b"\x01\0\x01\x01a\x01\0\0\x01b");
        // The reply arrives in single bytes.
        for byte in b"\x01\0\x01\x01c\0\x01d" {
            stream.write_all(&[*byte]).unwrap();
        }
        stream
    });
    assert_eq!(client.receive(&mut reply, TIMEOUT).unwrap(), Some(2));
    assert_eq!(reply, b"d");
    server.join().unwrap();
}

#[test]
fn client_reconnects_after_a_restart_of_the_server() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut client = connect(&listener);
    let server = thread::spawn(move || {
        echo(&mut accept_client(&listener), b"a");
        listener
    });
    assert_eq!(ask(&mut client, b"a").unwrap(), b"a");
    let listener = server.join().unwrap();
    let server = thread::spawn(move || {
        let mut stream = accept_client(&listener);
        expect(&mut stream, &message(b"b"));
        stream.write_all(b"\x04\x08\x04PING\0\x01x").unwrap();
        expect(&mut stream, b"\x04\x06\x04PONGx");
        stream.write_all(&message(b"b")).unwrap();
        echo(&mut stream, b"c");
        // A second reply that no request belongs to.
        stream.write_all(&message(b"c")).unwrap();
        (listener, stream)
    });
    assert_eq!(ask(&mut client, b"b").unwrap(), b"b");
    assert_eq!(ask(&mut client, b"c").unwrap(), b"c");
    let (listener, _stream) = server.join().unwrap();
    let server = thread::spawn(move || echo(&mut accept_client(&listener), b"d"));
    assert_eq!(ask(&mut client, b"d").unwrap(), b"d");
    server.join().unwrap();
}

#[test]
fn lost_connection_is_an_error_and_the_request_is_not_repeated() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut client = connect(&listener);
    let server = thread::spawn(move || {
        let mut stream = accept_client(&listener);
        expect(&mut stream, &message(b"a"));
        stream.write_all(&message(b"late")[..3]).unwrap();
        drop(stream);
        echo(&mut accept_client(&listener), b"b");
    });
    let error = ask(&mut client, b"a").unwrap_err();
    assert!(matches!(error, DisconnectReason::Closed), "{error}");
    assert_eq!(ask(&mut client, b"b").unwrap(), b"b");
    server.join().unwrap();
}

#[test]
fn late_reply_is_never_returned() {
    // The number of bytes of the reply that arrive before the next request.
    for early in [0, 5, message(b"late").len()] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut client = connect(&listener);
        let (timed_out, has_timed_out) = mpsc::channel();
        let (received, is_received) = mpsc::channel();
        let server = thread::spawn(move || {
            let mut stream = accept_client(&listener);
            expect(&mut stream, &message(b"slow"));
            received.send(()).unwrap();
            has_timed_out.recv_timeout(TIMEOUT).unwrap();
            stream.write_all(&message(b"late")[..early]).unwrap();
            received.send(()).unwrap();
            has_timed_out.recv_timeout(TIMEOUT).unwrap();
            // The client may have closed the connection.
            let _ = stream.write_all(&message(b"late")[early..]);
            echo(&mut accept_client(&listener), b"next");
        });
        let mut reply = Vec::new();
        client.send(&[b"slow"]);
        while is_received.try_recv().is_err() {
            assert_eq!(client.receive(&mut reply, SHORT).unwrap(), None);
        }
        timed_out.send(()).unwrap();
        is_received.recv_timeout(TIMEOUT).unwrap();
        client.send(&[b"next"]);
        timed_out.send(()).unwrap();
        assert_eq!(client.receive(&mut reply, TIMEOUT).unwrap(), Some(1));
        assert_eq!(reply, b"next", "with {early} bytes of the late reply");
        server.join().unwrap();
    }
}

#[test]
fn handshake_that_the_server_ends_is_repeated() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut client = connect(&listener);
    let server = thread::spawn(move || {
        for length in [0, 5, 11, 64, 70] {
            let handshake = [&GREETING[..], READY].concat();
            accept(&listener).write_all(&handshake[..length]).unwrap();
        }
        // A reply before the request.
        let early = [&GREETING[..], READY, &message(b"early")].concat();
        let mut stream = accept(&listener);
        stream.write_all(&early).unwrap();
        echo(&mut accept_client(&listener), b"a");
    });
    assert_eq!(ask(&mut client, b"a").unwrap(), b"a");
    server.join().unwrap();
}

#[test]
fn violation_of_the_protocol_is_an_error() {
    let handshake = [&GREETING[..], READY].concat();
    let max = ClientConfig::DEFAULT.max_reply_bytes;
    for (bytes, expected) in [
        (b"HTTP/1.1 400 Bad Request\r\n\r\n".to_vec(), ProtocolError::Greeting),
        ([&GREETING[..10], &[1, 4]].concat(), ProtocolError::Version),
        ([&GREETING[..], REQ_READY].concat(), ProtocolError::ServerSocketType),
        (
            [&handshake[..], b"\x01\0\x02\x7f\xff\xff\xff\xff\xff\xff\xff"].concat(),
            ProtocolError::FrameTooLong { max, found: u64::MAX >> 1 },
        ),
        ([&handshake[..], b"\0\x02ok"].concat(), ProtocolError::Delimiter),
    ] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut client = connect(&listener);
        let server = thread::spawn(move || {
            let mut stream = accept(&listener);
            let (first, second) = bytes.split_at(bytes.len().min(GREETING.len() + READY.len()));
            stream.write_all(first).unwrap();
            if !second.is_empty() {
                expect(&mut stream, &[&GREETING[..], REQ_READY, &message(b"a")].concat());
                stream.write_all(second).unwrap();
            }
            // The client closes the connection.
            let _ = stream.read_to_end(&mut Vec::new());
            echo(&mut accept_client(&listener), b"b");
        });
        match ask(&mut client, b"a").unwrap_err() {
            DisconnectReason::Protocol(error) => assert_eq!(error, expected),
            other => panic!("expected {expected}, found {other}"),
        }
        assert_eq!(ask(&mut client, b"b").unwrap(), b"b");
        server.join().unwrap();
    }
}

#[test]
fn host_may_be_a_name_or_an_ipv6_address() {
    for host in ["localhost", "[::1]"] {
        let Ok(listener) = listen(host, 0) else {
            eprintln!("note: no address for {host} on this machine, skipped");
            continue;
        };
        let port = listener.local_addr().unwrap().port();
        let endpoint = format!("tcp://{host}:{port}").parse().unwrap();
        let server = thread::spawn(move || echo(&mut accept_client(&listener), b"a"));
        assert_eq!(ask(&mut ReqClient::new(endpoint).unwrap(), b"a").unwrap(), b"a");
        server.join().unwrap();
    }
    let unknown = "tcp://no such host:1".parse().unwrap();
    let mut client = ReqClient::new(unknown).unwrap();
    client.send(&[b"a"]);
    assert_eq!(client.receive(&mut Vec::new(), SHORT).unwrap(), None);
}
