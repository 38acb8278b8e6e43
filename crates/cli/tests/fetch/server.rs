//! An HTTP server that sends the same response to every request.

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener};
use std::thread;

/// Sends these bytes in reply to every request and then closes the connection. Returns the address
/// of the server.
pub(crate) fn serve(answer: Vec<u8>) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let request = BufReader::new(stream.try_clone().unwrap()).lines();
            // A blank line ends the request.
            request.map_while(Result::ok).take_while(|line| !line.is_empty()).count();
            // The client may close the connection early.
            let _ = stream.write_all(&answer);
        }
    });
    address
}

/// Serves content in a valid response.
pub(crate) fn serve_content(content: &[u8]) -> SocketAddr {
    serve(answer("200 OK", content.len(), content))
}

/// Returns a response whose header claims a length of `bytes`.
pub(crate) fn answer(status: &str, bytes: usize, content: &[u8]) -> Vec<u8> {
    let head = format!("HTTP/1.1 {status}\r\nContent-Length: {bytes}\r\nConnection: close\r\n\r\n");
    [head.as_bytes(), content].concat()
}
