//! Tests of the server with libzmq clients, and of the client with libzmq servers.
#![cfg(not(all(windows, target_env = "gnu")))] // libzmq does not compile with MinGW

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{Answer, ClientId, RepServer, ReqClient, Service, Waker, listen};

/// The timeout of each socket operation, in milliseconds.
const TIMEOUT_MS: i32 = 20_000;

/// The time after which the reply to `later` is due.
const LATER: Duration = Duration::from_secs(3);

/// A service that replies at once, except to `later`.
#[derive(Default)]
struct Echo {
    /// The client that waits for the reply to `later`, and the time at which this reply is due.
    waiting: Option<(ClientId, Instant)>,
}

impl Service for Echo {
    fn answer(
        &mut self,
        client: ClientId,
        request: &[u8],
        frames: usize,
        reply: &mut Vec<u8>,
    ) -> Answer {
        if request == b"later" {
            self.waiting = Some((client, Instant::now() + LATER));
            return Answer::Later;
        }
        reply.clear();
        reply.extend_from_slice(request);
        reply.extend_from_slice(format!(" of {frames}").as_bytes());
        Answer::Reply { is_activity: true }
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = reason.to_string().into();
    }

    fn due_reply(&mut self, now: Instant, reply: &mut Vec<u8>) -> Option<ClientId> {
        *reply = b"now".to_vec();
        self.waiting.take_if(|&mut (_, due)| due <= now).map(|(client, _)| client)
    }

    fn next_due(&self) -> Option<Instant> {
        self.waiting.map(|(_, due)| due)
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
        let thread = thread::spawn(move || {
            server.run(&mut Echo::default(), || flag.load(Ordering::Acquire))
        });
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
fn heartbeats_and_other_clients_are_answered_while_a_reply_is_due_later() {
    let server = Background::start();
    let patient = zmq::Context::new().socket(zmq::DEALER).unwrap();
    patient.set_linger(0).unwrap();
    patient.set_rcvtimeo(TIMEOUT_MS).unwrap();
    patient.set_heartbeat_ivl(100).unwrap();
    patient.set_heartbeat_timeout(1500).unwrap();
    patient.connect(&server.address).unwrap();
    let (start, other) = (Instant::now(), server.connect(zmq::REQ));
    for request in ["later", "held"] {
        patient.send_multipart(["", request], 0).unwrap();
    }
    while patient.poll(zmq::POLLIN, 0).unwrap() == 0 {
        other.send("a", 0).unwrap();
        assert_eq!(other.recv_bytes(0).unwrap(), b"a of 1");
    }
    assert!(start.elapsed() >= LATER);
    assert_eq!(patient.recv_multipart(0).unwrap(), [&b""[..], b"now"]);
    assert_eq!(patient.recv_multipart(0).unwrap(), [&b""[..], b"held of 1"]);
    server.stop();
}

#[test]
fn routing_identity_can_be_reused() {
    let server = Background::start();
    for _ in 0..50 {
        let client = zmq::Context::new().socket(zmq::REQ).unwrap();
        client.set_identity(b"mouse").unwrap();
        client.set_linger(0).unwrap();
        client.set_rcvtimeo(TIMEOUT_MS).unwrap();
        client.connect(&server.address).unwrap();
        client.send("a", 0).unwrap();
        assert_eq!(client.recv_bytes(0).unwrap(), b"a of 1");
    }
    server.stop();
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

/// Opens a libzmq socket that listens on a free port, and a client that connects to it.
fn listen_with_libzmq(kind: zmq::SocketType) -> (zmq::Socket, ReqClient) {
    let socket = zmq::Context::new().socket(kind).unwrap();
    socket.set_rcvtimeo(TIMEOUT_MS).unwrap();
    socket.bind("tcp://127.0.0.1:*").unwrap();
    let endpoint = socket.get_last_endpoint().unwrap().unwrap();
    (socket, ReqClient::new(endpoint.parse().unwrap()).unwrap())
}

/// Waits for a reply. Returns its last frame and the number of its frames.
fn receive(client: &mut ReqClient) -> (Vec<u8>, usize) {
    let mut reply = Vec::new();
    let frames = client.receive(&mut reply, Duration::from_secs(20)).unwrap();
    (reply, frames.expect("a reply within 20 s"))
}

#[test]
fn client_gets_the_replies_of_a_rep_socket() {
    let (rep, mut client) = listen_with_libzmq(zmq::REP);
    let server = thread::spawn(move || {
        for _ in 0..4 {
            let request = rep.recv_multipart(0).unwrap();
            rep.send_multipart(request, 0).unwrap();
        }
    });
    let long = vec![7; 100_000];
    for frames in [&[&b"a"[..]][..], &[b""], &[b"a", &long, b"b"], &[&long]] {
        client.send(frames);
        assert!(receive(&mut client) == (frames[frames.len() - 1].to_vec(), frames.len()));
    }
    server.join().unwrap();
}

#[test]
fn client_gets_the_replies_of_a_router_socket() {
    let (router, mut client) = listen_with_libzmq(zmq::ROUTER);
    let (received, is_received) = mpsc::channel();
    let server = thread::spawn(move || {
        let [first, second] = [(), ()].map(|()| {
            let message = router.recv_multipart(0).unwrap();
            let _ = received.send(());
            message
        });
        assert_eq!([&first[2], &second[2]], [b"slow", b"next"]);
        for mut message in [first, second] {
            message.push(b"end".to_vec());
            // The first connection may have ended, and its reply is then dropped.
            router.send_multipart(message, 0).unwrap();
        }
    });
    client.send(&[b"slow"]);
    while is_received.try_recv().is_err() {
        assert_eq!(client.receive(&mut Vec::new(), Duration::from_millis(100)).unwrap(), None);
    }
    client.send(&[b"next"]);
    assert_eq!(receive(&mut client), (b"end".to_vec(), 2));
    server.join().unwrap();
}

#[test]
fn client_refuses_other_sockets() {
    let (_pull, mut client) = listen_with_libzmq(zmq::PULL);
    client.send(&[b"a"]);
    let error = client.receive(&mut Vec::new(), Duration::from_secs(20)).unwrap_err();
    assert_eq!(error.to_string(), ProtocolError::ServerSocketType.to_string());
}

#[test]
fn client_gets_the_replies_of_the_server() {
    let server = Background::start();
    let mut client = ReqClient::new(server.address.parse().unwrap()).unwrap();
    for (frames, expected) in [(&[&b"a"[..]][..], "a of 1"), (&[b"a", b"b"], "b of 2")] {
        client.send(frames);
        assert_eq!(receive(&mut client), (expected.into(), 1));
    }
    server.stop();
}
