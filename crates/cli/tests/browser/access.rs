//! Access control: requests from other sites and machines, DNS rebinding, and forged headers.

use serde_json::json;

use crate::browser::{wait_for, with_browser, with_page};
use crate::foreign_site::{ForeignSite, attack};
use crate::harness::Home;
use crate::http::{self, split_url};
use crate::page::Panel;
use crate::simulator::{bundled, page_address};
use crate::test_state::TestState;

#[test]
fn other_sites_can_neither_read_nor_control() {
    with_page(&["harbour", "--record", "kept"], |browser, simulator| {
        let maze = bundled("01-harbour.txt");
        let states: Vec<_> = (0..3).map(|number| TestState::new(number, maze.size())).collect();
        for state in &states {
            simulator.send(&state.message('C', 'F'));
        }
        Panel::live(browser).wait_for_state(2);
        browser.leave();
        let run = simulator.run_number();
        let recording = simulator.url(&format!("/api/sources/live/recording.mcap?run={run}"));
        let recording = http::get(&recording).body;

        // The attacks succeed against a server without access control.
        let attacker = ForeignSite::serve("<!doctype html><title>attacker</title><body>");
        let victim = ForeignSite::serve("<!doctype html><title>victim</title><body id=panels>");
        let found =
            attack(browser, &attacker.url("evil.example"), &victim.url("127.0.0.1"), &recording);
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
        for path in ["maze", "mouse", "recordings"] {
            wait_for(path, || victim.has_request(&format!("POST /api/{path}")).then_some(()));
        }
        assert!(browser.frame_has("#frame", "#panels"));

        // The attacks come from another site, and from another port of the same host.
        for from in [attacker.url("evil.example"), attacker.url("127.0.0.1")] {
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
                let result = found[what].as_str().unwrap();
                assert!(
                    result.starts_with("no: ") && !result.contains("late"),
                    "{what}: {found:#}"
                );
            }
            assert!(!browser.frame_has("#frame", "#panels"), "{found:#}");
            assert_eq!(browser.run::<Option<bool>>("return window.scripted", &[]), None);
        }
        // DNS rebinding: a foreign name that resolves to this machine.
        let (host, _) = split_url(&simulator.page);
        let port = host.rsplit(':').next().unwrap();
        let rebound = format!("http://rebound.example:{port}");
        browser.open(&rebound);
        assert!(!browser.exists("#panels"));
        let text: String = browser.run("return document.body.innerText", &[]);
        assert!(text.contains("is not allowed (use localhost or 127.0.0.1)"), "{text}");
        let read = "const [path, done] = arguments;
            fetch(path, { method: 'POST', body: '{}' }).then((reply) => reply.status).then(done);";
        assert_eq!(browser.run_async::<u16>(read, &[json!("/api/mouse")]), 403);

        // None of the attacks had an effect.
        let info = simulator.info();
        assert_eq!((info.maze.as_str(), info.states), ("01-harbour", 3));
        assert_eq!(simulator.run_number(), run);
        let page = http::get(&simulator.url("/api/page")).json();
        assert_eq!(page["opened"], json!([]), "no recording was uploaded");
        browser.take_errors();
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        live.wait_for_state(2);
        live.assert_shows(&maze, &states);
        assert_eq!(live.text(".run .result"), "", "no mouse was started");

        // Links from other sites work.
        browser.open(&attacker.url("evil.example"));
        browser.take_errors();
        let follow = "const link = document.createElement('a');
            link.href = arguments[0]; document.body.append(link); link.click();";
        browser.run::<()>(follow, &[json!(simulator.page)]);
        wait_for("the page", || browser.exists(&live.part(".map svg")).then_some(()));
    });
}

#[test]
fn hostile_headers_are_refused() {
    with_page(&["harbour"], |browser, simulator| {
        Panel::live(browser).wait_until_empty();
        let (host, _) = split_url(&simulator.page);
        let own = format!("http://{host}");
        let stop = |headers: &[(&str, &str)]| {
            let json = ("content-type", "application/json");
            let headers = [&[json], headers].concat();
            let body = br#"{"action":"stop"}"#;
            http::request("POST", &simulator.url("/api/mouse"), &headers, body).status
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
            |host: &str| http::request("GET", &simulator.url("/"), &[("host", host)], b"").status;
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
    with_browser(|browser| {
        let home = Home::new();
        let arguments = ["--port", "0", "--viewer-port", "0", "--host", "0.0.0.0", "harbour"];
        let serving = home.serve_until(&arguments, "watch at");
        let address = page_address(&serving);
        let (host, path) = split_url(&address);
        let port = host.rsplit(':').next().unwrap();
        let token = path.strip_prefix("/?token=").unwrap();
        assert_eq!(token.len(), 32);
        // The page is opened under a host name, as from another machine.
        let page = format!("http://mouse.example:{port}");

        browser.open(&page);
        assert!(!browser.exists("#panels"));
        let text: String = browser.run("return document.body.innerText", &[]);
        assert!(text.starts_with("the token is missing or wrong"), "{text}");
        let local = format!("http://127.0.0.1:{port}");
        for path in ["/", "/page.js", "/api/mazes", "/events", "/?token=", "/api/page?token=0"] {
            assert_eq!(http::get(&format!("{local}{path}")).status, 401, "{path}");
        }
        assert_eq!(http::get(&format!("{local}/api/page?token={token}")).status, 200);
        browser.take_errors();

        browser.open(&format!("{page}{path}"));
        let live = Panel::live(browser);
        live.wait_until_empty();
        live.assert_shows(&bundled("01-harbour.txt"), &[]);
        assert_eq!(browser.address(), format!("{page}/"), "the token is removed from the URL");
        assert_eq!(
            browser.run::<String>("return document.cookie", &[]),
            "",
            "scripts cannot read it"
        );
        // The page can control the simulator.
        live.click(".run [name=run]");
        wait_for("states", || (live.data("states") != "0").then_some(()));
        live.click(".run [name=stop]");
        browser.open(&page);
        browser.wait_until_exists(&live.part(".map svg"));
        browser.leave();
    });
}
