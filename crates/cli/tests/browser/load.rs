//! Limits on the bytes and requests needed to open the page.

use std::collections::BTreeSet;

use mmsim_tests::shared;
use serde::Deserialize;

use crate::browser::{Browser, wait_for, with_logged_requests};
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled};
use crate::test_state::TestState;

/// The limit for the initial load of the page, in bytes on the wire.
const MAX_BYTES: u64 = 150 * 1000;

#[derive(Debug, Deserialize)]
struct Resource {
    name: String,
    /// The transferred bytes, including headers.
    bytes: u64,
}

/// Returns the document and all resources that the page has fetched.
fn resources(browser: &Browser) -> Vec<Resource> {
    let script = "return [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')]
        .map((entry) => ({ name: entry.name, bytes: entry.transferSize }))";
    browser.run(script, &[])
}

/// Waits until the page, its list of mazes, the visible thumbnails and the chart have loaded. Returns
/// everything that the page has fetched.
fn wait_until_loaded(browser: &Browser, mazes: usize) -> Vec<Resource> {
    wait_for("all mazes", || (Page(browser).maze_names().len() == mazes).then_some(()));
    // A state is announced after the chart has been drawn.
    let live = Panel::live(browser);
    wait_for("the announcement", || {
        live.text(".announcement").starts_with("State 9 of 9").then_some(())
    });
    let script = "
        const list = document.querySelector('#mazes ul').getBoundingClientRect();
        return [...document.images].every((image) => {
            const { top, bottom } = image.getBoundingClientRect();
            return image.src ? image.complete : bottom <= list.top || list.bottom <= top;
        });";
    wait_for("the thumbnails", || browser.run::<bool>(script, &[]).then_some(()));
    resources(browser)
}

/// Returns the URLs that the page has requested since the last call.
pub(crate) fn take_requested_urls(browser: &Browser) -> BTreeSet<String> {
    let log = browser.take_log("performance");
    let sent = log.iter().filter_map(|entry| {
        let event: serde_json::Value = serde_json::from_str(&entry.message).unwrap();
        let event = &event["message"];
        (event["method"] == "Network.requestWillBeSent")
            .then(|| event["params"]["request"]["url"].as_str().unwrap().to_string())
    });
    sent.collect()
}

#[test]
fn the_first_load_is_small_and_comes_from_the_server_only() {
    let folder = shared("mazes");
    let folder = folder.as_ref().map(|folder| folder.to_str().unwrap());
    let arguments = folder.map_or(vec!["harbour"], |folder| vec![folder, "045"]);
    with_logged_requests(|browser| {
        let simulator = Simulator::start(&arguments);
        let size = bundled("01-harbour.txt").size();
        for number in 0..10 {
            simulator.send(&TestState::new(number, size).message('C', 'F'));
        }
        let mazes = crate::http::get(&simulator.url("/api/mazes")).json().as_array().unwrap().len();
        assert_eq!(folder.is_some(), mazes > 280, "{mazes} mazes");
        // The browser's own first page makes requests, too.
        browser.open("about:blank");
        take_requested_urls(browser);
        browser.open(&simulator.page);
        let mut fetched = wait_until_loaded(browser, mazes);
        // Later, the page loads the run to keep it.
        fetched.retain(|fetched| !fetched.name.contains("/data.html"));
        fetched.sort_by_key(|fetched| std::cmp::Reverse(fetched.bytes));
        let whole: u64 = fetched.iter().map(|fetched| fetched.bytes).sum();
        println!("{whole} bytes in {} resources with {mazes} mazes", fetched.len());
        for Resource { name, bytes } in &fetched {
            println!("{bytes:7} {name}");
        }
        assert!(whole < MAX_BYTES, "{whole} bytes, the heaviest of {fetched:#?}");
        assert!(
            fetched.iter().any(|fetched| fetched.name.ends_with("/page.js") && fetched.bytes > 500)
        );

        // All requests, including those missing from the page's resource timing.
        let all = take_requested_urls(browser);
        assert!(all.len() >= fetched.len(), "{all:#?}");
        for address in &all {
            let own = address.starts_with(&format!("{}/", simulator.page));
            assert!(
                own || address.starts_with("data:") || address.starts_with("blob:"),
                "{all:#?}"
            );
        }
        browser.leave();
    });
}
