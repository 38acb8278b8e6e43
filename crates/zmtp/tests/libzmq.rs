//! Tests of the server with libzmq clients.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{ClientId, RepServer, Service, Waker, listen};

/// The timeout of each socket operation, in milliseconds.
const TIMEOUT_MS: i32 = 20_000;

struct Echo;

impl Service for Echo {
    fn answer(&mut self, _: ClientId, request: &[u8], frames: usize, reply: &mut Vec<u8>) -> bool {
        reply.clear();
        reply.extend_from_slice(request);
        reply.extend_from_slice(format!(" of {frames}").as_bytes());
        true
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = reason.to_string().into();
    }
}

/// A server that runs on its own thread.
struct Background {
    address: String,
    is_stopping: Arc<AtomicBool>,
    waker: Waker,
    thread: JoinHandle<std::io::Result<()>>,
}

impl Background {
    fn start() -> Self {
        let mut server = RepServer::new(listen("127.0.0.1", 0).unwrap()).unwrap();
        let address = format!("tcp://{}", server.local_address().unwrap());
        let (waker, is_stopping) = (server.waker(), Arc::new(AtomicBool::new(false)));
        let flag = Arc::clone(&is_stopping);
        let thread = thread::spawn(move || server.run(&mut Echo, || flag.load(Ordering::Acquire)));
        Self { address, is_stopping, waker, thread }
    }

    fn connect(&self, kind: zmq::SocketType) -> zmq::Socket {
        let socket = zmq::Context::new().socket(kind).unwrap();
        socket.set_linger(0).unwrap();
        socket.set_rcvtimeo(TIMEOUT_MS).unwrap();
        socket.set_sndtimeo(TIMEOUT_MS).unwrap();
        socket.connect(&self.address).unwrap();
        socket
    }

    fn stop(self) {
        self.is_stopping.store(true, Ordering::Release);
        self.waker.wake();
        self.thread.join().unwrap().unwrap();
    }
}

#[test]
fn req_and_dealer_get_their_replies() {
    let server = Background::start();
    let (req, dealer) = (server.connect(zmq::REQ), server.connect(zmq::DEALER));
    req.send_multipart(["a", "b"], 0).unwrap();
    assert_eq!(req.recv_multipart(0).unwrap(), [b"b of 2"]);
    for request in ["c", "d"] {
        dealer.send_multipart(["id", "", request], 0).unwrap();
    }
    for reply in [b"c of 1", b"d of 1"] {
        assert_eq!(dealer.recv_multipart(0).unwrap(), [&b"id"[..], b"", reply]);
    }
    server.stop();
}

#[test]
fn requests_before_the_stop_are_answered() {
    let server = Background::start();
    let clients = [(); 20].map(|()| server.connect(zmq::REQ));
    for client in &clients {
        client.send("a", 0).unwrap();
    }
    server.stop();
    for client in &clients {
        assert_eq!(client.recv_bytes(0).unwrap(), b"a of 1");
    }
}

#[test]
fn other_socket_types_are_disconnected() {
    let server = Background::start();
    let (other, req) = (server.connect(zmq::PUSH), server.connect(zmq::REQ));
    other.set_sndtimeo(300).unwrap();
    let _ = other.send("a", 0);
    req.send("b", 0).unwrap();
    assert_eq!(req.recv_bytes(0).unwrap(), b"b of 1");
    server.stop();
}
