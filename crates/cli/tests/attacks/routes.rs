//! Hostile requests to every route of the page.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;

use mmsim_fastrun::Vehicle;
use mmsim_maze::WyRand;

use crate::*;

/// Hostile values of path and query parameters, percent-encoded.
const VALUES: [&str; 28] = [
    "",
    "0",
    "1",
    "-1",
    "1e999",
    "NaN",
    "0x10",
    "1.5",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "true",
    "dark",
    "live",
    "x",
    "01-harbour.txt",
    "..",
    "..%2f..%2f..%2fetc%2fpasswd",
    "%2Fetc%2Fpasswd",
    "%00",
    "%0d%0aset-cookie:%20a=b",
    "%1b%5b2J%7f",
    "%ff%fe",
    "%zz%",
    "%E2%80%AE%F0%9F%90%AD",
    "%3Cscript%3Ealert(1)%3C%2Fscript%3E",
    "a&run=2&a",
];

/// Hostile values of the fields of a JSON object.
const JSON_VALUES: [&str; 16] = [
    "null",
    "true",
    "-1",
    "0.5",
    "1e308",
    "1e999",
    "18446744073709551616",
    "NaN",
    "[]",
    "{}",
    r#""""#,
    r#""1""#,
    r#""\u0000\u001b[2J""#,
    r#""\ud800""#,
    r#""../../../etc/passwd""#,
    r#""broken.mcap""#,
];

/// The values that a parameter may need before the server looks at the next parameter.
const ACCEPTED: [&str; 5] = ["1", "x", "true", "light", "0.5"];
const JSON_ACCEPTED: [&str; 4] = [r#""x""#, "1", "true", "null"];

/// Statuses of responses to hostile requests. A panic is a 500, or no response.
const STATUSES: [u16; 13] = [200, 204, 400, 403, 404, 405, 406, 409, 410, 413, 415, 422, 503];

#[derive(Debug)]
struct Response {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Response {
    fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    fn header(&self, name: &str) -> Option<&str> {
        let mut lines = self.head.lines().filter_map(|line| line.split_once(": "));
        lines.find(|line| line.0 == name).map(|line| line.1)
    }
}

/// A page and a folder whose name must not appear in responses.
struct Page<'a> {
    host: &'a str,
    folder: &'a str,
}

impl Page<'_> {
    /// Sends bytes. Returns the response, or `None` if the server closes the connection instead.
    fn exchange(&self, bytes: &[u8]) -> Option<Response> {
        let mut stream = raw::connect(&format!("tcp://{}", self.host));
        raw::send(&mut stream, bytes);
        let (mut received, mut chunk) = (Vec::new(), [0; 16_384]);
        let end = loop {
            let end = received.windows(4).position(|bytes| bytes == b"\r\n\r\n");
            let head = String::from_utf8_lossy(&received[..end.unwrap_or_default()]).into_owned();
            if head.contains("text/event-stream") {
                break end; // the stream has no end
            }
            match stream.read(&mut chunk) {
                Ok(length @ 1..) => received.extend(&chunk[..length]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => panic!("no end: {head}"),
                _ => break end,
            }
        };
        let body = received.split_off(end? + 4);
        let head = String::from_utf8(received).unwrap();
        let status = head.split(' ').nth(1)?.parse().unwrap();
        Some(Response { status, head, body })
    }

    /// Returns the bytes of a request.
    fn request(&self, method: &str, path: &str, body: &[u8]) -> Vec<u8> {
        let (host, length) = (self.host, body.len());
        let head = format!(
            "{method} {path} HTTP/1.1\r\nhost: {host}\r\norigin: http://{host}\r\nconnection: close\
             \r\ncontent-type: application/json\r\ncontent-length: {length}\r\n\r\n"
        );
        [head.as_bytes(), body].concat()
    }

    /// Sends a request, and checks what holds for all responses.
    fn ask(&self, method: &str, path: &str, body: &[u8]) -> Response {
        let request = self.request(method, path, body);
        let response = self.exchange(&request);
        let start = request[..request.len().min(1000)].escape_ascii();
        let response = response.unwrap_or_else(|| panic!("no response to {start}"));
        self.check(&response, &start.to_string(), request.len());
        response
    }

    fn check(&self, response: &Response, request: &str, length: usize) {
        let Response { status, head, body } = response;
        let (start, text) =
            (String::from_utf8_lossy(&body[..body.len().min(1000)]), response.text());
        let shown = format!("{head}{start}\nto {request}");
        assert!(STATUSES.contains(status), "{shown}");
        for (name, value) in [
            ("content-security-policy", "default-src 'none'; script-src 'self'; "),
            ("x-content-type-options", "nosniff"),
            ("x-frame-options", "DENY"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-resource-policy", "same-origin"),
            ("cross-origin-opener-policy", "same-origin"),
        ] {
            assert!(response.header(name).is_some_and(|it| it.starts_with(value)), "{shown}");
        }
        for forbidden in ["access-control-allow-origin", "set-cookie: a=b"] {
            assert!(!head.contains(forbidden), "{shown}");
        }
        assert!(!text.contains(self.folder) && !text.contains("panicked"), "{shown}");
        if *status >= 400 && !request.starts_with("HEAD") {
            // The text may repeat a value of the request, escaped.
            assert!(text.contains(' ') && text.len() < 500 + 6 * length, "{shown}");
            let kind = response.header("content-type");
            assert_eq!(kind, Some("text/plain; charset=utf-8"), "{shown}");
        }
    }
}

/// A route, and the parameters that it reads: in the query, or in a JSON body if it is read.
#[derive(Debug)]
struct Route {
    path: String,
    methods: Vec<String>,
    query: Vec<Parameter>,
    fields: Vec<Parameter>,
}

/// The name of a parameter, and values that are accepted.
type Parameter = (String, Vec<String>);

/// Returns the name of the parameter that an error is about.
fn named(error: &str) -> Option<&str> {
    let error = error.split_once(": ")?.1;
    if error.contains("field `") {
        error.split('`').nth(1)
    } else {
        Some(error.split_once(": ")?.0)
    }
}

/// Finds the parameters of a route. The server names a parameter that is missing, repeated or
/// malformed.
struct Probe<'a> {
    /// Possible names of parameters.
    words: &'a [String],
    /// Values to try.
    values: &'a [&'a str],
    /// Values of parameters whose names may not exist.
    fillers: &'a [&'a str],
    /// Sends parameters and returns the response.
    ask: &'a Ask<'a>,
}

type Ask<'a> = dyn Fn(&[(&str, &str)]) -> Response + 'a;

impl Probe<'_> {
    /// Sends the first value of each known parameter, then another parameter, and then each other
    /// name twice. Returns the error, or an empty text.
    fn error(&self, known: &[Parameter], more: Option<(&str, &str)>, filler: &str) -> String {
        let known = known.iter().map(|(name, values)| (&name[..], &values[0][..]));
        let mut all: Vec<_> = known.chain(more).collect();
        let is_other = |word: &&String| all.iter().all(|pair| pair.0 != *word);
        let others: Vec<_> = self.words.iter().filter(is_other).collect();
        all.extend(others.into_iter().flat_map(|word| [(&word[..], filler); 2]));
        let response = (self.ask)(&all);
        if response.status < 400 { String::new() } else { response.text() }
    }

    /// Returns the next name in an error.
    fn next(&self, known: &[Parameter], filler: &str) -> Option<String> {
        let error = self.error(known, None, filler);
        named(&error).filter(|name| self.words.iter().any(|word| word == name)).map(str::to_string)
    }

    /// Adds parameters to those that are known. Each choice of a variant may have other parameters.
    fn add_to(&self, mut known: Vec<Parameter>) -> Vec<Parameter> {
        while let Some(name) = self.fillers.iter().find_map(|filler| self.next(&known, filler)) {
            let error = |value: &str| self.error(&known, Some((&name, value)), self.values[0]);
            let text = error(self.values[0]);
            // An error lists the variants of a choice.
            let variants = text.split_once(", expected").map_or("", |it| it.1).split('`');
            let quote = if self.values[0].starts_with('"') { "\"" } else { "" };
            let variants = variants.skip(1).step_by(2).map(|it| format!("{quote}{it}{quote}"));
            let mut values: Vec<_> = variants.collect();
            if values.is_empty() {
                let is_accepted = |value: &&&str| named(&error(value)) != Some(&name);
                values.extend(self.values.iter().find(is_accepted).map(ToString::to_string));
            }
            assert!(!values.is_empty() && known.iter().all(|it| it.0 != name), "{name}: {text}");
            let at = known.len();
            known.push((name, values));
            for other in 1..known[at].1.len() {
                let mut with_other = known[..=at].to_vec();
                with_other[at].1.swap(0, other);
                for parameter in self.add_to(with_other).split_off(at + 1) {
                    if known.iter().all(|it| it.0 != parameter.0) {
                        known.push(parameter);
                    }
                }
            }
        }
        known
    }
}

/// Returns all routes with their methods and parameters.
fn routes(page: &Page<'_>) -> Vec<Route> {
    let is_letter = |c: char| c.is_ascii_lowercase();
    let scripts = mmsim_viewer::routes().filter(|path| path.rsplit('.').next() == Some("js"));
    let scripts: String = scripts.map(|path| page.ask("GET", &path, b"").text()).collect();
    let words: BTreeSet<_> = scripts.split(|c| !is_letter(c)).map(str::to_string).collect();
    let words: &Vec<_> = &words.into_iter().filter(|word| (2..12).contains(&word.len())).collect();
    let paths: BTreeSet<_> = mmsim_viewer::routes().collect();
    let route = |path: String| {
        let other = page.ask("ATTACK", &path, b"");
        assert_eq!(other.status, 405, "{path}");
        let methods = other.header("allow").unwrap().split(',').map(str::to_string).collect();
        let mut route = Route { path, methods, query: vec![], fields: vec![] };
        let path = route.path.replace("{id}", "live").replace("{vehicle}", Vehicle::PRESETS[0]);
        let join = |pairs: &[(&str, &str)], quote: &str, is: &str, and: &str| {
            let pairs =
                pairs.iter().map(|(name, value)| format!("{quote}{name}{quote}{is}{value}"));
            pairs.collect::<Vec<_>>().join(and)
        };
        for method in route.methods.iter().filter(|method| *method != "HEAD") {
            let in_query = |pairs: &[(&str, &str)]| {
                page.ask(method, &format!("{path}?{}", join(pairs, "", "=", "&")), b"")
            };
            let (values, fillers) = (&ACCEPTED, &ACCEPTED[..1]);
            route.query.extend(Probe { words, values, fillers, ask: &in_query }.add_to(vec![]));
        }
        if route.methods.iter().any(|method| method == "POST") {
            let known: Vec<_> = route.query.iter().map(|it| (&it.0[..], &it.1[0][..])).collect();
            let path = format!("{path}?{}", join(&known, "", "=", "&"));
            let in_body = |pairs: &[(&str, &str)]| {
                let body = format!("{{{}}}", join(pairs, "\"", ":", ","));
                page.ask("POST", &path, body.as_bytes())
            };
            let (values, fillers) = (&JSON_ACCEPTED, &JSON_ACCEPTED);
            route.fields = Probe { words, values, fillers, ask: &in_body }.add_to(vec![]);
        }
        route
    };
    paths.into_iter().map(route).collect()
}

/// Hostile request bodies.
fn bodies() -> Vec<Vec<u8>> {
    let texts = ["", "null", "{", "{}", "[]", "\"x\"", "1e999", "{\"action\":", "\0", "a=b&c=d"];
    let mut bodies: Vec<_> = texts.iter().map(|text| text.as_bytes().to_vec()).collect();
    bodies.extend([b"[".repeat(60_000), b"{\"a\":".repeat(10_000), vec![0xff; 100]]);
    bodies
}

/// Returns a request with random hostile values, and sometimes with values that are accepted.
fn hostile_request(route: &Route, method: &str, rng: &mut WyRand) -> (String, Vec<u8>) {
    let value =
        |accepted: &[String], hostile: &[&str], long: &str, rng: &mut WyRand| match rng.below(8) {
            0 => long.to_string(),
            1..=4 => hostile[rng.index(hostile.len())].to_string(),
            _ => accepted[rng.index(accepted.len())].clone(),
        };
    let pairs = |parameters: &[Parameter], hostile: &[&str], form: [&str; 3], rng: &mut WyRand| {
        let [quote, is, and] = form;
        // Even if all values are long, the request is not.
        let long = format!("{quote}{}{quote}", "x".repeat(20_000 / (1 + parameters.len())));
        let mut pairs = Vec::new();
        for (name, accepted) in parameters {
            // Sometimes missing or repeated.
            for _ in 0..[0, 1, 1, 1, 1, 1, 1, 2][rng.index(8)] {
                let value = value(accepted, hostile, &long, rng);
                pairs.push(format!("{quote}{name}{quote}{is}{value}"));
            }
        }
        rng.shuffle(&mut pairs);
        pairs.join(and)
    };
    let (mut path, long) = (route.path.clone(), "x".repeat(10_000));
    let vehicles = Vehicle::PRESETS.map(str::to_string);
    for (name, accepted) in [("{id}", &["live".to_string()][..]), ("{vehicle}", &vehicles)] {
        if path.contains(name) {
            path = path.replace(name, &value(accepted, &VALUES, &long, rng));
        }
    }
    let query = pairs(&route.query, &VALUES, ["", "=", "&"], rng);
    let body = match (method, rng.below(4)) {
        ("POST", 0) => {
            let mut bodies = bodies();
            bodies.swap_remove(rng.index(bodies.len()))
        }
        ("POST", _) => {
            let pairs = pairs(&route.fields, &JSON_VALUES, ["\"", ":", ","], rng);
            format!("{{{pairs}}}").into_bytes()
        }
        _ => Vec::new(),
    };
    (format!("{path}?{query}"), body)
}

/// Sends each hostile value of each parameter to every route, with accepted values of the others.
fn attack_each_value(page: &Page<'_>, routes: &[Route]) {
    for route in routes.iter().filter(|route| route.methods.iter().any(|method| method == "GET")) {
        let pair = |(name, values): &Parameter| format!("{name}={}", values[0]);
        let query: Vec<_> = route.query.iter().map(pair).collect();
        let parameters = route.query.iter().enumerate();
        for value in VALUES {
            let named = route.path.replace("{id}", "live");
            for path in [named.replace("{vehicle}", value), route.path.replace("{id}", value)] {
                if path != route.path && path != named {
                    page.ask("GET", &format!("{path}?{}", query.join("&")), b"");
                }
            }
            let path = named.replace("{vehicle}", Vehicle::PRESETS[0]);
            for (at, (name, values)) in parameters.clone() {
                if !values.iter().any(|accepted| accepted == value) {
                    let mut query = query.clone();
                    query[at] = format!("{name}={value}");
                    page.ask("GET", &format!("{path}?{}", query.join("&")), b"");
                }
            }
        }
    }
}

/// Sends hostile requests with one of the methods to every route.
fn attack_values(page: &Page<'_>, routes: &[Route], is_attacked: fn(&str) -> bool, seed: u64) {
    let (mut rng, mut statuses) = (WyRand::new(seed), BTreeMap::new());
    for route in routes {
        for method in route.methods.iter().filter(|method| is_attacked(method)) {
            let has_values =
                route.path.contains('{') || !route.query.is_empty() || method == "POST";
            let count = if has_values && method != "HEAD" { 10 } else { 2 };
            for _ in 0..count * force() {
                let (path, body) = hostile_request(route, method, &mut rng);
                *statuses.entry(page.ask(method, &path, &body).status).or_insert(0) += 1;
            }
        }
    }
    println!("  seed {seed}: responses by status {statuses:?}");
}

/// Sends hostile headers and bodies to every route.
fn attack_headers(page: &Page<'_>, routes: &[Route]) {
    let host = page.host;
    let cookies = "cookie: a=b\r\n".repeat(200);
    let huge = format!("x: {}\r\n", "x".repeat(600_000));
    for route in routes {
        let path = route.path.replace("{id}", "live").replace("{vehicle}", Vehicle::PRESETS[0]);
        let (method, origin) = (&route.methods[0], format!("origin: http://{host}\r\n"));
        let whole = String::from_utf8(page.request(method, &path, b"{}")).unwrap();
        let with = |header: &str| whole.replacen("connection", &format!("{header}connection"), 1);
        let host = |hosts: &str| whole.replacen(&format!("host: {host}\r\n"), hosts, 1);
        let origin = |new: &str| whole.replacen(&origin, new, 1);
        for (request, expected) in [
            (host("host: evil.example\r\n"), Some(403)),
            (host("host: 127.0.0.1.evil.example\r\n"), Some(403)),
            (host("host: \r\n"), Some(403)),
            (host(""), Some(400)),
            (host("host: localhost\r\nhost: localhost\r\n"), Some(400)),
            (whole.replacen(&path, &format!("http://evil.example{path}"), 1), Some(400)),
            (origin("origin: http://evil.example\r\n"), Some(403)),
            (origin("origin: null\r\n"), Some(403)),
            (origin("origin: \u{e9}\r\n"), Some(403)),
            (with("sec-fetch-site: cross-site\r\n"), Some(403)),
            (with("transfer-encoding: chunked\r\n"), None),
            (with("range: bytes=0-0\r\n"), None),
            (with("if-none-match: *\r\n"), None),
            (with("accept-encoding: *;q=x,,;q\r\n"), None),
            (with("upgrade: websocket\r\nconnection: upgrade\r\n"), None),
            (with(&format!("cookie: {}\r\n", "x".repeat(100_000))), None),
            (whole.replacen("HTTP/1.1", "HTTP/1.0", 1), None),
        ] {
            let start = request[..request.len().min(1000)].to_string();
            let response = page.exchange(request.as_bytes()).expect(&start);
            page.check(&response, &start, request.len());
            assert!(expected.is_none_or(|it| it == response.status), "{response:?} to {start}");
        }
        // The HTTP library refuses these requests.
        for request in [
            with("content-length: 3\r\n"),
            with("content-length: -1\r\n"),
            with("transfer-encoding: chunked, x\r\n"),
            with("no colon\r\n"),
            with("x: \0\r\n"),
            with(&cookies),
            with(&huge),
            whole.replacen("HTTP/1.1", "HTTP/9", 1),
            whole.replacen(&path, &format!("/{}", "x".repeat(70_000)), 1),
            whole.replacen(&path, "x", 1),
        ] {
            if let Some(response) = page.exchange(request.as_bytes()) {
                assert_eq!(response.status / 100, 4, "{response:?} to {:?}", &request.get(..300));
            }
        }
        // Half a body and the end of the stream, and a body over the limit.
        let mut half = raw::connect(&format!("tcp://{}", page.host));
        raw::send(&mut half, whole.replacen("length: 2", "length: 99", 1).as_bytes());
        let _ = half.shutdown(Shutdown::Write);
        raw::wait_until_cut_off(half);
        if method == "POST" {
            let large = page.request(method, &path, &vec![b' '; 10 << 20]);
            if let Some(response) = page.exchange(&large) {
                assert_eq!(response.status, 413, "{response:?} to {path}");
            }
        }
    }
}

/// Starts a server, and returns it and the host of its page.
fn start(home: &Home, options: &[&str]) -> (Target, String) {
    let arguments = ["--port", "0", "--viewer-port", "0", searcher::MAZE];
    let serving = home.serve_until(&[&arguments[..], options].concat(), "watch at http://");
    let host = serving.messages.split("watch at http://").nth(1).unwrap().trim().to_string();
    (Target(serving), host)
}

#[test]
fn hostile_routes() {
    let home = Home::new();
    let folder = home.path().to_str().unwrap();
    let broken = home.write("r/broken.mcap", "broken");
    let records = broken.parent().unwrap().to_str().unwrap();
    let (mut target, host) = start(&home, &["--record", records]);
    let page = Page { host: &host, folder };
    let routes = routes(&page);
    let found: Vec<_> =
        routes.iter().flat_map(|route| [&route.query, &route.fields]).flatten().collect();
    println!("{} routes, {} parameters", routes.len(), found.len());
    for name in ["run", "path", "count", "theme", "filter", "action", "strategy", "pace"] {
        assert!(found.iter().any(|it| it.0 == name), "{name} is missing in {routes:?}");
    }
    let client = socket(&zmq::Context::new(), zmq::REQ, target.address());
    let ask = |request: &[u8]| {
        client.send(request, 0).unwrap();
        client.recv_bytes(0).unwrap()
    };
    for seed in 0..3 {
        assert_eq!(ask(&noise(seed)), b"ok");
    }
    let shown = || {
        let paths = ["page", "mazes", "recordings", "sources/live", "sources/live/events?run=1"];
        let states = "sources/live/states?run=1&from=0&count=3";
        let paths = paths.into_iter().chain([states]);
        paths.map(|path| page.ask("GET", &format!("/api/{path}"), b"").body).collect::<Vec<_>>()
    };
    let before = (shown(), ask(b"info"));
    attack_each_value(&page, &routes);
    attack_values(&page, &routes, |method| method != "POST", 1);
    assert!((shown(), ask(b"info")) == before, "a GET request has changed something");
    attack_values(&page, &routes, |method| method == "POST", 2);
    assert_no_panic(&mut target);
    // Idle threads end late, so count the threads of a new server.
    let (mut target, host) = start(&home, &[]);
    let page = Page { host: &host, folder };
    target.run_attack("hostile values, headers and bodies for every route", |_| {
        attack_values(&page, &routes, |_| true, 3);
        attack_headers(&page, &routes);
    });
    assert_no_panic(&mut target);
}

/// Kills the server.
fn assert_no_panic(Target(server): &mut Target) {
    server.kill();
    let messages = server.wait().1;
    assert!(!messages.contains("panicked"), "{messages}");
}

#[test]
fn every_route_requires_the_token() {
    let arguments = ["--port", "0", "--viewer-port", "0", "--host", "0.0.0.0"];
    let server = Home::new().serve_until(&arguments, "watch at http://");
    let url = server.messages.split("watch at http://").nth(1).unwrap().trim();
    let (host, token) = url.split_once("/?token=").unwrap();
    let host = format!("127.0.0.1:{}", host.rsplit(':').next().unwrap());
    let page = Page { host: &host, folder: "" };
    let status = |method: &str, path: &str| {
        page.exchange(&page.request(method, path, b"")).expect(path).status
    };
    let half = &token[..token.len() / 2];
    let wrong =
        ["", "?token=", "?token=%00", "?", &format!("?token={half}"), &format!("?Token={token}")];
    for path in mmsim_viewer::routes() {
        for (method, query) in
            ["GET", "HEAD", "POST", "ATTACK"].iter().flat_map(|it| wrong.map(|wrong| (it, wrong)))
        {
            assert_eq!(status(method, &format!("{path}{query}")), 401, "{method} {path}{query}");
        }
        let found = status("GET", &format!("{path}?token={token}"));
        assert!([200, 303, 400, 404, 405].contains(&found), "{found} for {path}");
    }
}
