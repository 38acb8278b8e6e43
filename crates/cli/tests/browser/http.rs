//! A minimal HTTP client for requests that no browser sends and for chromedriver commands that
//! fantoccini does not support.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;

use mmsim_tests::TIMEOUT;

#[derive(Debug)]
pub(crate) struct Reply {
    pub(crate) status: u16,
    /// The header names, in lowercase, and their values.
    pub(crate) headers: Vec<(String, String)>,
    pub(crate) body: Vec<u8>,
}

impl Reply {
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|header| header.0 == name).map(|header| header.1.as_str())
    }

    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }
}

/// Splits a URL such as `http://127.0.0.1:6575/page.js?a=b` into host:port and path.
pub(crate) fn split_url(url: &str) -> (&str, &str) {
    let rest = url.strip_prefix("http://").unwrap();
    rest.find('/').map_or((rest, "/"), |at| rest.split_at(at))
}

pub(crate) fn get(url: &str) -> Reply {
    request("GET", url, &[], b"")
}

/// Sends one request. `headers` override the default headers.
pub(crate) fn request(method: &str, url: &str, headers: &[(&str, &str)], body: &[u8]) -> Reply {
    let (host, path) = split_url(url);
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    let length = body.len().to_string();
    let mut all = headers.to_vec();
    for default in [("host", host), ("content-length", &length), ("connection", "close")] {
        if !headers.iter().any(|(name, _)| name.eq_ignore_ascii_case(default.0)) {
            all.push(default);
        }
    }
    let mut head = format!("{method} {path} HTTP/1.1\r\n");
    for (name, value) in all {
        head.extend([name, ": ", value, "\r\n"]);
    }
    stream.write_all((head + "\r\n").as_bytes()).unwrap();
    stream.write_all(body).unwrap();
    read(&mut BufReader::new(stream))
}

/// Returns the first event of a page, which has the status of the mouse.
#[allow(dead_code, reason = "browser tests read no events")]
pub(crate) fn first_event(page: &str) -> serde_json::Value {
    let (host, _) = split_url(page);
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(TIMEOUT)).unwrap();
    write!(stream, "GET /events HTTP/1.1\r\nhost: {host}\r\n\r\n").unwrap();
    let mut lines = BufReader::new(stream).lines().map(Result::unwrap);
    let data = lines.find_map(|line| line.strip_prefix("data:").map(String::from));
    serde_json::from_str(&data.expect("an event")).unwrap()
}

fn read(stream: &mut impl BufRead) -> Reply {
    let line = |stream: &mut dyn BufRead| {
        let mut line = String::new();
        stream.read_line(&mut line).unwrap();
        line.trim_end().to_string()
    };
    let status = line(stream).split(' ').nth(1).and_then(|status| status.parse().ok());
    let mut reply =
        Reply { status: status.expect("a status line"), headers: Vec::new(), body: Vec::new() };
    while let Some((name, value)) = line(stream).split_once(':') {
        reply.headers.push((name.to_ascii_lowercase(), value.trim().to_string()));
    }
    if let Some(length) = reply.header("content-length") {
        reply.body.resize(length.parse().unwrap(), 0);
        stream.read_exact(&mut reply.body).unwrap();
    } else if reply.header("transfer-encoding") == Some("chunked") {
        loop {
            let length = usize::from_str_radix(&line(stream), 16).unwrap();
            let mut chunk = vec![0; length];
            stream.read_exact(&mut chunk).unwrap();
            reply.body.extend(chunk);
            line(stream);
            if length == 0 {
                break;
            }
        }
    } else {
        stream.read_to_end(&mut reply.body).unwrap();
    }
    reply
}
