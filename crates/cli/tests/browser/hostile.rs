//! Others who would like to read and to steer: pages elsewhere, names that lie, files with markup
//! for a name.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;

use serde_json::{Value, json};

use crate::browser::{Browser, browse, wait_for, watch};
use crate::harness::Home;
use crate::http::{self, parts};
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled, page_address};
use crate::told::Told;

/// A web server that lets everybody do everything, and notes what is asked for. It ends with the
/// process.
struct Elsewhere {
    port: String,
    asked: Arc<Mutex<Vec<String>>>,
}

impl Elsewhere {
    /// Each page of it is this one; all other requests get a short text.
    fn serve(page: &'static str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port().to_string();
        let asked = Arc::new(Mutex::new(Vec::new()));
        let notes = Arc::clone(&asked);
        thread::spawn(move || {
            for stream in listener.incoming() {
                let notes = Arc::clone(&notes);
                thread::spawn(move || answer(stream.unwrap(), page, &notes));
            }
        });
        Self { port, asked }
    }

    /// Its address by a name, of this machine or not.
    fn at(&self, host: &str) -> String {
        format!("http://{host}:{}", self.port)
    }

    fn was_asked(&self, what: &str) -> bool {
        self.asked.lock().unwrap().iter().any(|asked| asked.starts_with(what))
    }
}

fn answer(stream: TcpStream, page: &str, asked: &Mutex<Vec<String>>) -> Option<()> {
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
    asked.lock().ok()?.push(request.to_string());
    let path = request.split(' ').nth(1)?.split('?').next()?;
    let (kind, body) = match path {
        "/" | "/page" => ("text/html", page),
        "/events" => ("text/event-stream", "data: {\"states\":1}\n\n"),
        path if path.ends_with(".svg") => {
            ("image/svg+xml", "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'/>")
        }
        path if path.ends_with(".js") => ("text/javascript", "window.scripted = true;"),
        path if path.ends_with(".css") => ("text/css", "body { color: rgb(1, 2, 3) }"),
        _ => ("application/json", "{}"),
    };
    let reply = format!(
        "HTTP/1.1 200 OK\r\ncontent-type: {kind}\r\ncontent-length: {}\r\nconnection: close\r\n\
         access-control-allow-origin: *\r\naccess-control-allow-headers: content-type\r\n\r\n{body}",
        body.len()
    );
    stream.get_mut().write_all(reply.as_bytes()).ok()
}

/// Tries all that a page can do to another one, and says what came of it.
const ATTACK: &str = r#"
    const [target, done] = arguments;
    const settle = (promise) =>
        Promise.race([promise, new Promise((_, no) => setTimeout(() => no("late"), 5000))]).catch((e) => `no: ${e}`);
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
        run: await post("/api/mouse/run", "no-cors", "text/plain"),
        bring: await post("/api/recordings?name=x.mcap", "no-cors", "text/plain"),
        beacon: navigator.sendBeacon(target + "/api/mouse/stop", text),
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

/// What a page elsewhere achieves against an address.
fn attack(browser: &Browser, from: &str, target: &str) -> Value {
    browser.open(from);
    browser.run_async(ATTACK, &[json!(target)])
}

#[test]
fn a_page_elsewhere_can_neither_read_nor_steer() {
    watch(&["--maze", "harbour", "--record", "kept"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let told: Vec<_> = (0..3).map(|number| Told::of(number, maze.size())).collect();
        told.iter().for_each(|told| simulator.send(&told.message('C', 'F')));
        Panel::live(browser).wait_at(2);
        browser.leave();

        // What these attacks achieve against somebody who does not mind.
        let elsewhere = Elsewhere::serve("<!doctype html><title>elsewhere</title><body>");
        let prey = Elsewhere::serve("<!doctype html><title>prey</title><body id=panels>");
        let found = attack(browser, &elsewhere.at("evil.example"), &prey.at("127.0.0.1"));
        for (what, expected) in [
            ("read", "read"),
            ("page", "read"),
            ("blind", "opaque"),
            ("json", "cors"),
            ("plain", "opaque"),
            ("form", "answered"),
            ("image", "loaded"),
            ("script", "loaded"),
            ("style", "loaded"),
            ("events", "heard"),
            ("frame", "loaded"),
        ] {
            assert_eq!(found[what], expected, "{found:#}");
        }
        for path in ["maze", "mouse/run", "mouse/stop", "recordings"] {
            wait_for(path, || prey.was_asked(&format!("POST /api/{path}")).then_some(()));
        }
        assert!(browser.frame_has("#frame", "#panels"));

        // From another site, and from another port of this one.
        let run = simulator.run();
        for from in [elsewhere.at("evil.example"), elsewhere.at("127.0.0.1")] {
            let found = attack(browser, &from, &simulator.page);
            for what in [
                "read",
                "page",
                "json",
                "image",
                "drawing",
                "script",
                "plainscript",
                "style",
                "events",
            ] {
                let said = found[what].as_str().unwrap();
                assert!(said.starts_with("no: ") && !said.contains("late"), "{what}: {found:#}");
            }
            assert!(!browser.frame_has("#frame", "#panels"), "{found:#}");
            assert_eq!(browser.run::<Option<bool>>("return window.scripted", &[]), None);
        }
        // By a name that somebody has pointed at this machine, it is no page of ours at all.
        let (host, _) = parts(&simulator.page);
        let port = host.rsplit(':').next().unwrap();
        let rebound = format!("http://rebound.example:{port}");
        browser.open(&rebound);
        assert!(!browser.is_there("#panels"));
        let said: String = browser.run("return document.body.innerText", &[]);
        assert!(said.contains("expected a name of this machine"), "{said}");
        let read = "const [path, done] = arguments;
            fetch(path, { method: 'POST', body: '{}' }).then((reply) => reply.status).then(done);";
        assert_eq!(browser.run_async::<u16>(read, &[json!("/api/mouse/stop")]), 403);

        // All of it was in vain.
        let info = simulator.info();
        assert_eq!((info.name.as_str(), info.states), ("01-harbour", 3));
        assert_eq!(simulator.run(), run);
        let page = http::get(&simulator.at("/api/page")).json();
        assert_eq!(page["opened"], json!([]), "no recording was brought");
        browser.complaints();
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        live.wait_at(2);
        live.assert_shows(&maze, &told);
        assert_eq!(live.text(".run .says"), "", "no mouse was started");

        // A link to it may be followed, as from a chat.
        browser.open(&elsewhere.at("evil.example"));
        browser.complaints();
        let follow = "const link = document.createElement('a');
            link.href = arguments[0]; document.body.append(link); link.click();";
        browser.run::<()>(follow, &[json!(simulator.page)]);
        wait_for("the page", || browser.is_there(&live.part(".map svg")).then_some(()));
    });
}

#[test]
fn hostile_headers_are_refused() {
    watch(&["--maze", "harbour"], |browser, simulator| {
        Panel::live(browser).wait_empty();
        let (host, _) = parts(&simulator.page);
        let own = format!("http://{host}");
        let stop = |headers: &[(&str, &str)]| {
            let json = ("content-type", "application/json");
            let headers = [&[json], headers].concat();
            http::request("POST", &simulator.at("/api/mouse/stop"), &headers, b"{}").status
        };
        assert_eq!(stop(&[("origin", &own)]), 204);
        assert_eq!(stop(&[]), 403);
        for origin in [
            "http://evil.example",
            "null",
            "http://127.0.0.1:1",
            &own.replace("127.0.0.1", "localhost"),
        ] {
            assert_eq!(stop(&[("origin", origin)]), 403, "{origin}");
        }
        let get =
            |host: &str| http::request("GET", &simulator.at("/"), &[("host", host)], b"").status;
        assert_eq!(get(host), 200);
        for host in [
            "evil.example",
            &host.replace("127.0.0.1", "rebound.example"),
            "127.0.0.1.evil.example",
        ] {
            assert_eq!(get(host), 403, "{host}");
        }
    });
}

/// Tries to run a script that did not come from the server.
const INLINE: &str = r#"
    const done = arguments[0];
    const violations = [];
    document.addEventListener("securitypolicyviolation", (event) => violations.push(event.effectiveDirective));
    const script = document.createElement("script");
    script.textContent = "window.inline = true";
    document.body.append(script);
    document.body.insertAdjacentHTML("beforeend", '<img src="data:," onerror="window.handler = true" style="color: red">');
    document.body.insertAdjacentHTML("beforeend", '<a id="link" href="javascript:window.followed = true">x</a>');
    document.querySelector('#link').click();
    setTimeout("window.timer = true", 0);
    setTimeout(() => done([window.inline ?? false, window.handler ?? false, window.followed ?? false,
        window.timer ?? false, violations.sort().join(" ")]), 300);
"#;

#[test]
fn nothing_runs_but_what_the_server_brings() {
    type Ran = (bool, bool, bool, bool, String);
    watch(&["--maze", "harbour"], |browser, simulator| {
        Panel::live(browser).wait_empty();
        browser.leave();
        let elsewhere = Elsewhere::serve("<!doctype html><title>elsewhere</title><body>");
        browser.open(&elsewhere.at("evil.example"));
        let ran: Ran = browser.run_async(INLINE, &[]);
        assert_eq!(ran, (true, true, true, true, String::new()), "without a policy");

        browser.open(&simulator.page);
        Panel::live(browser).wait_empty();
        let ran: Ran = browser.run_async(INLINE, &[]);
        assert!(!ran.0 && !ran.1 && !ran.2 && !ran.3, "{ran:?}");
        for directive in ["script-src-elem", "script-src-attr", "style-src-attr"] {
            assert!(ran.4.contains(directive), "{ran:?}");
        }
        // Nor does the page get anything from elsewhere.
        let load = "
            const [address, done] = arguments;
            const element = (name, attributes) => new Promise((yes) => {
                const made = Object.assign(document.createElement(name), attributes);
                made.onload = () => yes('loaded');
                made.onerror = () => yes('no');
                document.body.append(made);
            });
            (async () => done([
                await fetch(address).then(() => 'loaded', () => 'no'),
                await element('script', { src: address + '/a.js' }),
                await element('img', { src: address + '/a.svg' }),
                await element('link', { rel: 'stylesheet', href: address + '/a.css' }),
            ]))();";
        let asked_before = elsewhere.asked.lock().unwrap().len();
        let loaded: [String; 4] = browser.run_async(load, &[json!(elsewhere.at("evil.example"))]);
        assert_eq!(loaded, ["no"; 4]);
        assert_eq!(elsewhere.asked.lock().unwrap().len(), asked_before, "not even asked for");
        browser.complaints();
    });
}

/// Where file names may have such characters.
#[cfg(unix)]
#[test]
fn names_with_markup_are_names() {
    const NAME: &str = "<img src=x onerror=window.hacked=1>&amp;\"'";
    browse(|browser| {
        let home = Home::new();
        let small = "o---o---o\n| S   G |\no---o---o\n";
        home.write(&format!("mazes/{NAME}.txt"), small);
        home.write("mazes/a.txt", small);
        let simulator = Simulator::start_in(home, &["mazes", "--maze", "a.txt"]);
        browser.open(&simulator.page);
        let (page, live) = (Page(browser), Panel::live(browser));
        live.wait_empty();
        wait_for("the list", || (page.mazes().len() == 2).then_some(()));
        assert!(page.mazes().contains(&NAME.to_string()), "{:?}", page.mazes());
        browser.click("#mazes li:not([data-path='mazes/a.txt']) button");
        wait_for("the maze", || (live.text("h2") == NAME).then_some(()));
        assert_eq!(simulator.info().name, NAME);
        assert!(!browser.run::<bool>("return 'hacked' in window", &[]));
        browser.leave();
    });
}

#[test]
fn other_machines_need_the_token() {
    browse(|browser| {
        let home = Home::new();
        let arguments =
            ["--port", "0", "--viewer-port", "0", "--host", "0.0.0.0", "--maze", "harbour"];
        let serving = home.serve_until(&arguments, "watch at");
        let address = page_address(&serving);
        let (host, path) = parts(&address);
        let port = host.rsplit(':').next().unwrap();
        let token = path.strip_prefix("/?token=").unwrap();
        assert_eq!(token.len(), 32);
        // By a name, as from another machine.
        let page = format!("http://mouse.example:{port}");

        browser.open(&page);
        assert!(!browser.is_there("#panels"));
        let said: String = browser.run("return document.body.innerText", &[]);
        assert!(said.starts_with("expected the token"), "{said}");
        let local = format!("http://127.0.0.1:{port}");
        for path in ["/", "/page.js", "/api/mazes", "/events", "/?token=", "/api/page?token=0"] {
            assert_eq!(http::get(&format!("{local}{path}")).status, 401, "{path}");
        }
        assert_eq!(http::get(&format!("{local}/api/page?token={token}")).status, 200);
        browser.complaints();

        browser.open(&format!("{page}{path}"));
        let live = Panel::live(browser);
        live.wait_empty();
        live.assert_shows(&bundled("01-harbour.txt"), &[]);
        assert_eq!(browser.address(), format!("{page}/"), "the token is not left in the address");
        assert_eq!(browser.run::<String>("return document.cookie", &[]), "", "no script reads it");
        // It can steer.
        live.click(".run [name=run]");
        wait_for("a search", || (live.says("states") != "0").then_some(()));
        live.click(".run [name=stop]");
        browser.open(&page);
        wait_for("the page", || browser.is_there(&live.part(".map svg")).then_some(()));
        browser.leave();
    });
}
