//! A server that gives one answer to everybody.

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener};
use std::thread;

/// The address at which whatever is asked for is answered by these bytes; the connection ends then.
pub(crate) fn serve(answer: Vec<u8>) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let request = BufReader::new(stream.try_clone().unwrap()).lines();
            // A blank line ends it.
            request.map_while(Result::ok).take_while(|line| !line.is_empty()).count();
            // Who has read enough goes.
            let _ = stream.write_all(&answer);
        }
    });
    address
}

/// The same for content, in an answer that is in order.
pub(crate) fn serve_content(content: &[u8]) -> SocketAddr {
    serve(answer("200 OK", content.len(), content))
}

/// An answer that says to have so many bytes.
pub(crate) fn answer(status: &str, bytes: usize, content: &[u8]) -> Vec<u8> {
    let head = format!("HTTP/1.1 {status}\r\nContent-Length: {bytes}\r\nConnection: close\r\n\r\n");
    [head.as_bytes(), content].concat()
}
