//! What it takes to open the page.

use std::collections::BTreeSet;

use mmsim_tests::shared;
use serde::Deserialize;

use crate::browser::{Browser, wait_for, watch};
use crate::page::{Page, Panel};
use crate::simulator::bundled;
use crate::told::Told;

/// The most that the page and all that it needs at first may weigh, in bytes on the wire.
const HEAVIEST: u64 = 150 * 1000;

/// Something that was fetched.
#[derive(Debug, Deserialize)]
struct Fetched {
    name: String,
    /// In bytes, with its head.
    weight: u64,
}

/// All that the page has fetched so far, itself first.
fn fetched(browser: &Browser) -> Vec<Fetched> {
    let script = "return [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')]
        .map((entry) => ({ name: entry.name, weight: entry.transferSize }))";
    browser.run(script, &[])
}

/// Waits until the page is there: the list, the pictures in sight, and nothing that is still to come.
fn wait_whole(browser: &Browser, mazes: usize) -> Vec<Fetched> {
    wait_for("all mazes", || (Page(browser).mazes().len() == mazes).then_some(()));
    Panel::live(browser).wait_at(9);
    let mut before = 0;
    wait_for("the end of it", || {
        std::thread::sleep(std::time::Duration::from_millis(300));
        let now = fetched(browser).len();
        let is_whole = now == before
            && browser.run(
                "return [...document.images].every((image) => !image.src || image.complete)",
                &[],
            );
        before = now;
        is_whole.then_some(())
    });
    fetched(browser)
}

/// The addresses that the browser has asked for since it was asked last.
fn asked(browser: &Browser) -> BTreeSet<String> {
    let said = browser.said("performance");
    let sent = said.iter().filter_map(|said| {
        let event: serde_json::Value = serde_json::from_str(&said.message).unwrap();
        let event = &event["message"];
        (event["method"] == "Network.requestWillBeSent")
            .then(|| event["params"]["request"]["url"].as_str().unwrap().to_string())
    });
    sent.collect()
}

#[test]
fn the_first_load_is_light_and_all_of_it_comes_from_here() {
    let folder = shared("mazes");
    let folder = folder.as_ref().map(|folder| folder.to_str().unwrap());
    let arguments =
        folder.map_or(vec!["--maze", "harbour"], |folder| vec![folder, "--maze", "045"]);
    watch(&arguments, |browser, simulator| {
        let size = bundled("01-harbour.txt").size();
        for number in 0..10 {
            simulator.send(&Told::of(number, size).message('C', 'F'));
        }
        let mazes = crate::http::get(&simulator.at("/api/mazes")).json().as_array().unwrap().len();
        assert_eq!(folder.is_some(), mazes > 280, "{mazes} mazes");
        // Anew, with states.
        browser.open("about:blank");
        asked(browser);
        browser.open(&simulator.page);
        let mut fetched = wait_whole(browser, mazes);
        fetched.sort_by_key(|fetched| std::cmp::Reverse(fetched.weight));
        let whole: u64 = fetched.iter().map(|fetched| fetched.weight).sum();
        println!("{whole} bytes in {} pieces with {mazes} mazes", fetched.len());
        for Fetched { name, weight } in &fetched {
            println!("{weight:7} {name}");
        }
        assert!(whole < HEAVIEST, "{whole} bytes, the heaviest of {fetched:#?}");
        assert!(
            fetched
                .iter()
                .any(|fetched| fetched.name.ends_with("/page.js") && fetched.weight > 500)
        );

        // All that was sent, not only what the page knows of.
        let all = asked(browser);
        assert!(
            all.len() >= fetched.len() && all.iter().any(|address| address.ends_with("/events"))
        );
        for address in &all {
            let own = address.starts_with(&format!("{}/", simulator.page));
            assert!(
                own || address.starts_with("data:") || address.starts_with("blob:"),
                "{all:#?}"
            );
        }
    });
}
