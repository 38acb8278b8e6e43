//! One test suite for both ZeroMQ transports: that of mmsim-zmtp, and with the feature `libzmq` that of
//! libzmq. The servers of the tests are sockets that send and expect exact bytes.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use mmsim_client::{Timeout, Transport, TransportError, Waiting, Zmq};
use mmsim_zmtp::codec::{GREETING, READY, push_request};

/// The limit for waits that should end earlier.
const LONG: Timeout = Timeout::After(Duration::from_secs(60));
/// The limit for waits that end without a reply.
const SHORT: Timeout = Timeout::After(Duration::from_millis(300));

type Connected = Result<Zmq<'static>, TransportError>;
type Connect = fn(&str, Timeout, Box<dyn FnMut(Waiting<'_>)>) -> Connected;

macro_rules! suite {
    ($($test:ident),*) => {
        mod zmtp {
            use super::*;
            const CONNECT: Connect = |endpoint, timeout, on_wait| Zmq::connect(endpoint, timeout, on_wait);
            $(#[test] fn $test() { super::$test(CONNECT) })*
        }

        #[cfg(feature = "libzmq")]
        mod libzmq {
            use super::*;
            const CONNECT: Connect =
                |endpoint, timeout, on_wait| Zmq::connect_with_libzmq(endpoint, timeout, on_wait);
            $(#[test] fn $test() { super::$test(CONNECT) })*
        }
    };
}

suite!(
    waits_for_a_missing_simulator_until_the_timeout,
    simulator_may_start_later,
    late_reply_is_never_taken_for_another,
    lost_connection_is_an_error_and_the_next_request_succeeds,
    simulator_may_restart_between_requests,
    handshake_that_the_simulator_ends_is_repeated,
    requests_and_replies_may_have_several_frames,
    other_socket_types_and_malformed_replies_are_errors,
    invalid_endpoints_are_errors,
    host_may_be_a_name_or_an_ipv6_address
);

/// A simulator that runs on its own thread.
struct Simulator {
    endpoint: String,
    thread: JoinHandle<()>,
}

impl Simulator {
    fn start(serve: impl FnOnce(TcpListener) + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp://{}", listener.local_addr().unwrap());
        Self { endpoint, thread: thread::spawn(move || serve(listener)) }
    }

    fn join(self) {
        self.thread.join().unwrap();
    }
}

fn open(connect: Connect, endpoint: &str, timeout: Timeout) -> Zmq<'static> {
    connect(endpoint, timeout, Box::new(|_| ())).unwrap()
}

fn ask(transport: &mut Zmq<'_>, request: &[u8]) -> Result<Vec<u8>, TransportError> {
    let mut reply = b"old".to_vec();
    transport.exchange(request, &mut reply).map(|()| reply)
}

fn accept(listener: &TcpListener) -> TcpStream {
    let stream = listener.accept().unwrap().0;
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

/// Accepts a connection and performs the handshake.
fn accept_client(listener: &TcpListener) -> TcpStream {
    let mut stream = accept(listener);
    shake_hands(&mut stream).unwrap();
    stream
}

fn shake_hands(stream: &mut TcpStream) -> io::Result<()> {
    stream.write_all(&[&GREETING[..], READY].concat())?;
    let mut greeting_and_header = [0; 64 + 2];
    stream.read_exact(&mut greeting_and_header)?;
    let mut ready = vec![0; greeting_and_header[65].into()];
    stream.read_exact(&mut ready)?;
    assert!(ready.starts_with(b"\x05READY\x0bSocket-Type\0\0\0\x03REQ"));
    Ok(())
}

/// Accepts connections until one receives the request `body`. A client of libzmq may have opened
/// others, to connect again before it gives up.
fn accept_request(listener: &TcpListener, body: &[u8]) -> TcpStream {
    let mut request = message(body);
    loop {
        let mut stream = accept(listener);
        let read = shake_hands(&mut stream).and_then(|()| stream.read_exact(&mut request));
        if read.is_ok() && request == message(body) {
            return stream;
        }
    }
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

fn waits_for_a_missing_simulator_until_the_timeout(connect: Connect) {
    let mut transport = open(connect, "tcp://127.0.0.1:1", SHORT);
    let error = ask(&mut transport, b"ping").unwrap_err();
    assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
    assert_eq!(error.to_string(), "no reply from tcp://127.0.0.1:1 within 0.3 s");
}

fn simulator_may_start_later(connect: Connect) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    let (sender, is_waiting) = mpsc::channel();
    let simulator = thread::spawn(move || {
        assert_eq!(is_waiting.recv(), Ok(1));
        echo(&mut accept_client(&TcpListener::bind(address).unwrap()), b"ping");
    });
    let endpoint = format!("tcp://{address}");
    // The simulator does not exist when the first notice arrives.
    let expected = endpoint.clone();
    let on_wait = move |waiting: Waiting<'_>| {
        assert!(!waiting.answered && waiting.endpoint == expected);
        let _ = sender.send(waiting.notices);
    };
    let mut transport = connect(&endpoint, LONG, Box::new(on_wait)).unwrap();
    assert_eq!(ask(&mut transport, b"ping").unwrap(), b"ping");
    simulator.join().unwrap();
}

fn late_reply_is_never_taken_for_another(connect: Connect) {
    // The number of bytes of the late reply that arrive before the next request.
    for early in [0, 5, message(b"late").len()] {
        let (received, is_received) = mpsc::channel();
        let (timed_out, has_timed_out) = mpsc::channel();
        let simulator = Simulator::start(move |listener| {
            let mut stream = accept_request(&listener, b"slow");
            received.send(()).unwrap();
            has_timed_out.recv().unwrap();
            stream.write_all(&message(b"late")[..early]).unwrap();
            received.send(()).unwrap();
            loop {
                let mut next = accept_request(&listener, b"next");
                // The client has closed the first connection, unless it is not done with it yet.
                let _ = stream.write_all(&message(b"late")[early..]);
                let _ = next.write_all(&message(b"next"));
            }
        });
        let mut transport = open(connect, &simulator.endpoint, SHORT);
        while is_received.try_recv().is_err() {
            let error = ask(&mut transport, b"slow").unwrap_err();
            assert!(matches!(error, TransportError::NoReply { .. }), "{error}");
        }
        timed_out.send(()).unwrap();
        is_received.recv().unwrap();
        let reply = loop {
            match ask(&mut transport, b"next") {
                Err(TransportError::NoReply { .. }) => {}
                reply => break reply.unwrap(),
            }
        };
        assert_eq!(reply, b"next", "{early} bytes arrived early");
    }
}

fn lost_connection_is_an_error_and_the_next_request_succeeds(connect: Connect) {
    let simulator = Simulator::start(|listener| {
        let mut stream = accept_client(&listener);
        expect(&mut stream, &message(b"a"));
        stream.write_all(&message(b"late")[..3]).unwrap();
        drop(stream);
        accept_request(&listener, b"b").write_all(&message(b"b")).unwrap();
    });
    let mut transport = open(connect, &simulator.endpoint, LONG);
    let error = ask(&mut transport, b"a").unwrap_err();
    assert!(matches!(error, TransportError::Disconnected { .. }), "{error}");
    let expected = format!("no reply from {}: closed by the peer", simulator.endpoint);
    assert_eq!(error.to_string(), expected);
    assert_eq!(ask(&mut transport, b"b").unwrap(), b"b");
    simulator.join();
}

fn simulator_may_restart_between_requests(connect: Connect) {
    let simulator = Simulator::start(|listener| {
        echo(&mut accept_client(&listener), b"a");
        accept_request(&listener, b"b").write_all(&message(b"b")).unwrap();
    });
    let mut transport = open(connect, &simulator.endpoint, LONG);
    assert_eq!(ask(&mut transport, b"a").unwrap(), b"a");
    // A request of libzmq fails if it is sent while the connection is closing.
    let reply = loop {
        match ask(&mut transport, b"b") {
            Err(TransportError::Disconnected { .. }) => {}
            reply => break reply.unwrap(),
        }
    };
    assert_eq!(reply, b"b");
    simulator.join();
}

fn handshake_that_the_simulator_ends_is_repeated(connect: Connect) {
    let simulator = Simulator::start(|listener| {
        for length in [0, 5, 11, 64, 70] {
            let handshake = [&GREETING[..], READY].concat();
            accept(&listener).write_all(&handshake[..length]).unwrap();
        }
        echo(&mut accept_client(&listener), b"a");
    });
    let mut transport = open(connect, &simulator.endpoint, LONG);
    assert_eq!(ask(&mut transport, b"a").unwrap(), b"a");
    simulator.join();
}

fn requests_and_replies_may_have_several_frames(connect: Connect) {
    let simulator = Simulator::start(|listener| {
        let mut stream = accept_client(&listener);
        expect(&mut stream, b"\x01\0\x01\x01a\x01\0\0\x01b");
        stream.write_all(&message(b"ok")).unwrap();
        expect(&mut stream, b"\x01\0\0\0");
        // The reply arrives in single bytes.
        for byte in b"\x01\0\x01\x01c\0\x01d" {
            stream.write_all(&[*byte]).unwrap();
        }
        echo(&mut stream, b"e");
    });
    let mut transport = open(connect, &simulator.endpoint, LONG);
    let mut reply = Vec::new();
    transport.exchange_frames(&[b"a", b"", b"b"], &mut reply).unwrap();
    assert_eq!(reply, b"ok");
    let error = transport.exchange_frames(&[], &mut reply).unwrap_err().to_string();
    let expected = format!("expected a reply of one frame from {}, found 2", simulator.endpoint);
    assert_eq!(error, expected);
    assert_eq!(ask(&mut transport, b"e").unwrap(), b"e");
    simulator.join();
}

fn other_socket_types_and_malformed_replies_are_errors(connect: Connect) {
    let pull = b"\x04\x1a\x05READY\x0bSocket-Type\0\0\0\x04PULL";
    for (ready, reply) in [
        (&pull[..], &b""[..]),
        (READY, b"\0\x02ok"),
        (READY, b"\x01\0\x02\x7f\xff\xff\xff\xff\xff\xff\xff"),
    ] {
        let simulator = Simulator::start(move |listener| {
            let mut stream = accept(&listener);
            stream.write_all(&[&GREETING[..], ready].concat()).unwrap();
            if !reply.is_empty() {
                // The request ends with the only byte `!`.
                let mut byte = [0];
                while byte != *b"!" {
                    stream.read_exact(&mut byte).unwrap();
                }
                stream.write_all(reply).unwrap();
            }
            // The client closes the connection.
            let _ = stream.read_to_end(&mut Vec::new());
            accept_request(&listener, b"b").write_all(&message(b"b")).unwrap();
        });
        let mut transport = open(connect, &simulator.endpoint, LONG);
        let error = ask(&mut transport, b"!").unwrap_err();
        assert!(matches!(error, TransportError::Disconnected { .. }), "{error}");
        assert_eq!(ask(&mut transport, b"b").unwrap(), b"b");
        simulator.join();
    }
}

fn invalid_endpoints_are_errors(connect: Connect) {
    let error =
        |endpoint: &str| connect(endpoint, LONG, Box::new(|_| ())).err().unwrap().to_string();
    for endpoint in ["127.0.0.1:6574", "inproc://maze", "TCP://host:1", ""] {
        let expected =
            format!("cannot reach {endpoint}: expected tcp://HOST:PORT, found {endpoint:?}");
        assert_eq!(error(endpoint), expected);
    }
    for port in ["99999", "0", "http", "127.0.0.1"] {
        let error = error(&format!("tcp://host:{port}"));
        assert!(error.contains("expected a port from 1 to 65535"), "{error}");
    }
}

fn host_may_be_a_name_or_an_ipv6_address(connect: Connect) {
    for host in ["localhost", "[::1]"] {
        let Ok(listener) = mmsim_zmtp::listen(host, 0) else {
            eprintln!("note: no address for {host} on this machine, skipped");
            continue;
        };
        let port = listener.local_addr().unwrap().port();
        let simulator = thread::spawn(move || echo(&mut accept_client(&listener), b"a"));
        let mut transport = open(connect, &format!("tcp://{host}:{port}"), LONG);
        assert_eq!(ask(&mut transport, b"a").unwrap(), b"a");
        simulator.join().unwrap();
    }
}

/// Only the transport of mmsim-zmtp recognizes that a server speaks another protocol.
#[test]
fn another_protocol_is_an_error() {
    let simulator = Simulator::start(|listener| {
        let mut stream = accept(&listener);
        stream.write_all(b"HTTP/1.1 400 Bad Request\r\n").unwrap();
        // Waits until the client closes the connection.
        let _ = stream.read_to_end(&mut Vec::new());
    });
    let mut transport = Zmq::connect(&simulator.endpoint, Timeout::Never, |_| {}).unwrap();
    let error = ask(&mut transport, b"ping").unwrap_err().to_string();
    let reason = "expected a ZMTP greeting, found other bytes";
    assert_eq!(error, format!("no reply from {}: {reason}", simulator.endpoint));
    simulator.join();
}

#[test]
fn only_libzmq_supports_ipc() {
    let error = Zmq::connect("ipc:///tmp/maze", LONG, |_| {}).err().unwrap().to_string();
    assert!(error.contains("expected tcp://HOST:PORT"), "{error}");
}

#[cfg(all(unix, feature = "libzmq"))]
#[test]
fn libzmq_asks_a_libzmq_server_over_ipc() {
    let path = std::env::temp_dir().join(format!("mmsim-client-{}", std::process::id()));
    let endpoint = format!("ipc://{}", path.display());
    let server = zmq::Context::new().socket(zmq::REP).unwrap();
    server.bind(&endpoint).unwrap();
    let answering = thread::spawn(move || {
        let request = server.recv_multipart(0).unwrap();
        server.send_multipart(request, 0).unwrap();
        server
    });
    let mut transport = Zmq::connect_with_libzmq(&endpoint, LONG, |_| {}).unwrap();
    assert_eq!(ask(&mut transport, b"ping").unwrap(), b"ping");
    drop(answering.join().unwrap());
    std::fs::remove_file(path).unwrap();
}
