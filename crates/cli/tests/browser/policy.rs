//! Checks that the content security policy allows only scripts from the server to run in the page.

use serde_json::json;

use crate::browser::{wait_for, with_browser, with_page};
use crate::foreign_site::ForeignSite;
use crate::harness::Home;
use crate::page::{Page, Panel};
use crate::simulator::Simulator;

/// A script that tries to run inline code in several ways.
pub(crate) const INLINE: &str = r#"
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
    // Each attempt either succeeds or violates the policy, except that no script notices the style.
    const check = () => {
        const ran = ["inline", "handler", "followed", "timer"].map((name) => name in window);
        const over = ran.filter(Boolean).length + violations.length;
        if (over < (violations.length > 0 ? 5 : 4)) setTimeout(check, 10);
        else done([...ran, violations.sort().join(" ")]);
    };
    check();
"#;

#[test]
fn only_scripts_of_the_server_run() {
    type Ran = (bool, bool, bool, bool, String);
    with_page(&["harbour"], |browser, simulator| {
        Panel::live(browser).wait_until_empty();
        browser.leave();
        let other_site = ForeignSite::serve("<!doctype html><title>other</title><body>");
        browser.open(&other_site.url("evil.example"));
        let ran: Ran = browser.run_async(INLINE, &[]);
        assert_eq!(ran, (true, true, true, true, String::new()), "without a policy");

        browser.open(&simulator.page);
        Panel::live(browser).wait_until_empty();
        let ran: Ran = browser.run_async(INLINE, &[]);
        assert!(!ran.0 && !ran.1 && !ran.2 && !ran.3, "{ran:?}");
        for directive in ["script-src-elem", "script-src-attr", "style-src-attr"] {
            assert!(ran.4.contains(directive), "{ran:?}");
        }
        // The page cannot load anything from other sites.
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
        let requests_before = other_site.request_count();
        let loaded: [String; 4] = browser.run_async(load, &[json!(other_site.url("evil.example"))]);
        assert_eq!(loaded, ["no"; 4]);
        assert_eq!(other_site.request_count(), requests_before, "no request is sent");
        browser.take_errors();
    });
}

#[test]
fn markup_in_names_is_text() {
    const NAME: &str = "<img src=x onerror=window.hacked=1>&amp;\"'";
    with_browser(|browser| {
        let home = Home::new();
        let small = "o---o---o\n| S   G |\no---o---o\n";
        home.write(&format!("mazes/{NAME}.txt"), small);
        home.write("mazes/a.txt", small);
        let simulator = Simulator::start_in(home, &["mazes", "a.txt"]);
        browser.open(&simulator.page);
        let (page, live) = (Page(browser), Panel::live(browser));
        live.wait_until_empty();
        wait_for("the list", || (page.maze_names().len() == 2).then_some(()));
        assert!(page.maze_names().contains(&NAME.to_string()), "{:?}", page.maze_names());
        browser.click("#mazes li:not([data-path='mazes/a.txt']) button");
        wait_for("the maze", || (live.text("h2") == NAME).then_some(()));
        assert_eq!(simulator.info().maze, NAME);
        assert!(!browser.run::<bool>("return 'hacked' in window", &[]));
        browser.leave();
    });
}
