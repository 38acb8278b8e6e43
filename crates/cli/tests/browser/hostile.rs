//! Others who would like to read and to steer: pages elsewhere, names that lie, other machines.

use serde_json::json;

use crate::browser::{browse, wait_for, watch};
use crate::elsewhere::{Elsewhere, attack};
use crate::harness::Home;
use crate::http::{self, parts};
use crate::page::Panel;
use crate::simulator::{bundled, page_address};
use crate::told::Told;

#[test]
fn a_page_elsewhere_can_neither_read_nor_steer() {
    watch(&["--maze", "harbour", "--record", "kept"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let told: Vec<_> = (0..3).map(|number| Told::of(number, maze.size())).collect();
        for told in &told {
            simulator.send(&told.message('C', 'F'));
        }
        Panel::live(browser).wait_at(2);
        browser.leave();
        let run = simulator.run();
        let recording = simulator.at(&format!("/api/sources/live/recording.mcap?run={run}"));
        let recording = http::get(&recording).body;

        // What these attacks achieve against somebody who does not mind.
        let elsewhere = Elsewhere::serve("<!doctype html><title>elsewhere</title><body>");
        let prey = Elsewhere::serve("<!doctype html><title>prey</title><body id=panels>");
        let found =
            attack(browser, &elsewhere.at("evil.example"), &prey.at("127.0.0.1"), &recording);
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
        for from in [elsewhere.at("evil.example"), elsewhere.at("127.0.0.1")] {
            let found = attack(browser, &from, &simulator.page, &recording);
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
