//! Attacks on the page from another web site in the same browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;

use serde_json::{Value, json};

use crate::browser::Browser;

/// A web server that allows every origin and records the requests that it receives. The server runs
/// until the process exits.
pub(crate) struct ForeignSite {
    port: String,
    requests: Arc<Mutex<Vec<String>>>,
}

impl ForeignSite {
    /// Starts a server that returns `page` for paths ending in `/`, and small dummy files for all
    /// other paths.
    pub(crate) fn serve(page: &'static str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port().to_string();
        let requests = Arc::new(Mutex::new(Vec::new()));
        let log = Arc::clone(&requests);
        thread::spawn(move || {
            for stream in listener.incoming() {
                let log = Arc::clone(&log);
                thread::spawn(move || answer(stream.unwrap(), page, &log));
            }
        });
        Self { port, requests }
    }

    /// Returns the URL of the site under the given host name.
    pub(crate) fn url(&self, host: &str) -> String {
        format!("http://{host}:{}", self.port)
    }

    pub(crate) fn request_count(&self) -> usize {
        self.requests.lock().unwrap().len()
    }

    pub(crate) fn has_request(&self, start: &str) -> bool {
        self.requests.lock().unwrap().iter().any(|request| request.starts_with(start))
    }
}

fn answer(stream: TcpStream, page: &str, log: &Mutex<Vec<String>>) -> Option<()> {
    let mut stream = BufReader::new(stream);
    let (mut head, mut length) = (String::new(), 0);
    while !head.ends_with("\r\n\r\n") {
        let mut line = String::new();
        if stream.read_line(&mut line).ok()? == 0 {
            return None;
        }
        if let Some(value) = line.to_ascii_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().ok()?;
        }
        head += &line;
    }
    stream.read_exact(&mut vec![0; length]).ok()?;
    let request = head.lines().next()?;
    log.lock().ok()?.push(request.to_string());
    let path = request.split(' ').nth(1)?.split('?').next()?;
    let (kind, body) = match path.rsplit(['/', '.']).next()? {
        "" => ("text/html", page),
        "events" => ("text/event-stream", "data: {\"states\":1}\n\n"),
        "svg" => {
            ("image/svg+xml", "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'/>")
        }
        "js" => ("text/javascript", "window.scripted = true;"),
        "css" => ("text/css", "body { color: rgb(1, 2, 3) }"),
        _ => ("application/json", "{}"),
    };
    let reply = format!(
        "HTTP/1.1 200 OK\r\ncontent-type: {kind}\r\ncontent-length: {}\r\nconnection: close\r\n\
         access-control-allow-origin: *\r\naccess-control-allow-headers: content-type\r\n\r\n{body}",
        body.len()
    );
    stream.get_mut().write_all(reply.as_bytes()).ok()
}

/// A script that tries everything that a page can do to another site, and returns the results.
const ATTACK: &str = r#"
    const [target, recording, done] = arguments;
    const settle = (promise) =>
        Promise.race([promise, new Promise((_, no) => setTimeout(() => no("late"), 60000))]).catch((e) => `no: ${e}`);
    const element = (name, attributes, parent = document.body) => settle(new Promise((yes, no) => {
        const made = Object.assign(document.createElement(name), attributes);
        made.onload = () => yes("loaded");
        made.onerror = () => no("error");
        parent.append(made);
    }));
    const text = JSON.stringify({ path: "oblong-long-meadow.txt", strategy: "flood-fill", pace_ms: 0 });
    const form = (path) => {
        const frame = Object.assign(document.createElement("iframe"), { name: `to${path}` });
        document.body.append(frame);
        const made = Object.assign(document.createElement("form"), {
            method: "post", action: target + path, target: frame.name, enctype: "text/plain",
        });
        made.append(Object.assign(document.createElement("input"), { name: text.slice(0, -1) + ',"x":"', value: '"}' }));
        document.body.append(made);
        return settle(new Promise((yes) => { frame.onload = () => yes("answered"); made.submit(); }));
    };
    const post = (path, mode, type) => settle(
        fetch(target + path, { method: "POST", mode, body: text, headers: { "content-type": type } })
            .then((reply) => reply.type));
    (async () => done({
        read: await settle(fetch(target + "/api/mazes").then((reply) => reply.text()).then(() => "read")),
        page: await settle(fetch(target + "/").then((reply) => reply.text()).then(() => "read")),
        blind: await settle(fetch(target + "/api/page", { mode: "no-cors" }).then((reply) => reply.type)),
        json: await post("/api/maze", "cors", "application/json"),
        plain: await post("/api/maze", "no-cors", "text/plain"),
        run: await post("/api/mouse", "no-cors", "text/plain"),
        upload: await settle(fetch(target + "/api/recordings?name=x.mcap",
            { method: "POST", mode: "no-cors", body: new Uint8Array(recording) }).then((reply) => reply.type)),
        beacon: navigator.sendBeacon(target + "/api/mouse", text),
        form: await form("/api/maze"),
        image: await element("img", { src: target + "/api/mazes/picture.svg?path=01-harbour.txt" }),
        drawing: await element("img", { src: target + "/api/sources/live/drawing.svg?run=1" }),
        script: await element("script", { src: target + "/page.js", type: "module" }),
        plainscript: await element("script", { src: target + "/dom.js" }),
        style: await element("link", { rel: "stylesheet", href: target + "/page.css" }, document.head),
        events: await settle(new Promise((yes, no) => {
            const stream = new EventSource(target + "/events");
            stream.onmessage = () => yes("heard");
            stream.onerror = () => { stream.close(); no("error"); };
        })),
        frame: await element("iframe", { src: target + "/", id: "frame" }),
    }))();
"#;

/// Runs the attacks on `target` from the page `from`, including an upload of `recording`.
pub(crate) fn attack(browser: &Browser, from: &str, target: &str, recording: &[u8]) -> Value {
    browser.open(from);
    browser.run_async(ATTACK, &[json!(target), json!(recording)])
}
