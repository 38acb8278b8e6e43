//! The servers: REP sockets that send every request back. Errors of single messages are ignored.

use std::io;

use mmsim_zmtp::codec::ProtocolError;
use mmsim_zmtp::{Answer, ClientId, RepServer, Service, listen};
use tokio::runtime::Runtime;
use zeromq::{Socket as _, SocketRecv as _, SocketSend as _};

/// The name and the title of each server. `libzmq.py` contains the server `pyzmq`.
pub const SERVERS: [(&str, &str); 6] = [
    ("libzmq", "libzmq 4.3.4 (crate zmq 0.10.0)"),
    ("pyzmq", "libzmq 4.3.5 (pyzmq 27.3.0)"),
    ("zeromq", "zeromq 0.7.0"),
    ("rzmq", "rzmq 0.5.28"),
    ("omq", "omq-tokio 0.33.0"),
    ("mmsim", "mmsim-zmtp"),
];

pub fn serve(name: &str, port: u16) -> io::Result<()> {
    let endpoint = format!("tcp://127.0.0.1:{port}");
    match name {
        "libzmq" => serve_libzmq(&endpoint).map_err(io::Error::other),
        "zeromq" => Runtime::new()?.block_on(serve_zeromq(&endpoint)).map_err(io::Error::other),
        "rzmq" => Runtime::new()?.block_on(serve_rzmq(&endpoint)).map_err(io::Error::other),
        "omq" => Runtime::new()?.block_on(serve_omq(&endpoint)),
        "mmsim" => {
            let listener = listen("127.0.0.1", port).map_err(io::Error::other)?;
            RepServer::new(listener)?.run(&mut Echo, || false)
        }
        _ => Err(io::Error::other(format!("no server is named {name}"))),
    }
}

fn serve_libzmq(endpoint: &str) -> zmq::Result<()> {
    let socket = zmq::Context::new().socket(zmq::REP)?;
    socket.bind(endpoint)?;
    loop {
        if let Ok(request) = socket.recv_multipart(0) {
            let _ = socket.send_multipart(request, 0);
        }
    }
}

async fn serve_zeromq(endpoint: &str) -> zeromq::ZmqResult<()> {
    let mut socket = zeromq::RepSocket::new();
    socket.bind(endpoint).await?;
    loop {
        if let Ok(request) = socket.recv().await {
            let _ = socket.send(request).await;
        }
    }
}

async fn serve_rzmq(endpoint: &str) -> Result<(), rzmq::ZmqError> {
    let context = rzmq::Context::new()?;
    let socket = context.socket(rzmq::SocketType::Rep)?;
    socket.bind(endpoint).await?;
    loop {
        if let Ok(request) = socket.recv_multipart().await {
            let _ = socket.send_multipart(request).await;
        }
    }
}

async fn serve_omq(endpoint: &str) -> io::Result<()> {
    let context = omq_tokio::Context::new();
    let socket = context.socket(omq_tokio::SocketType::Rep, omq_tokio::Options::default());
    socket.bind(endpoint).await.map_err(io::Error::other)?;
    loop {
        if let Ok(request) = socket.recv().await {
            let _ = socket.send(request).await;
        }
    }
}

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
        Answer::Reply { is_activity: true }
    }

    fn refuse(&mut self, reason: &ProtocolError, reply: &mut Vec<u8>) {
        *reply = reason.to_string().into();
    }
}
