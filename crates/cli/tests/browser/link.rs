//! Links that open a run at a state.

use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser};
use crate::harness::{Home, Serving, recorded};
use crate::http;
use crate::page::Panel;
use crate::side_by_side::{send_states, with_two_panels};
use crate::simulator::{Simulator, page_address};

/// Makes the browser store copied texts instead of writing them to the clipboard.
fn store_copies(browser: &Browser) {
    let script = "navigator.clipboard.writeText = async (text) => { window.copied = text; };";
    browser.run::<()>(script, &[]);
}

/// Clicks a button that copies a link, and returns the link.
fn copy(browser: &Browser, button: &str) -> String {
    browser.run::<()>("window.copied = ''", &[]);
    browser.click(button);
    wait_for("the link", || {
        let copied: String = browser.run("return window.copied", &[]);
        (!copied.is_empty()).then_some(copied)
    })
}

/// Loads the page again at this address.
fn open_anew(browser: &Browser, address: &str) {
    browser.open("about:blank");
    browser.open(address);
}

/// Waits for an error message that contains `text`.
fn wait_for_error(browser: &Browser, text: &str) {
    wait_for("the error", || {
        (browser.is_visible("#error") && browser.text("#error span").contains(text)).then_some(())
    });
}

const COPY: &str = ".title [name=copy-link]";
const COPY_ALL: &str = "#compare [name=copy-link]";

#[test]
fn a_link_opens_a_run_at_a_state() {
    with_two_panels(40, 30, |simulator, live, recording| {
        let browser = live.browser;
        store_copies(browser);
        browser.click("#compare [value=off]");
        live.slide_to(11);
        recording.slide_to(24);
        let live_link = copy(browser, &live.part(COPY));
        let recording_link = copy(browser, &recording.part(COPY));
        browser.click("#compare [value=step]");
        live.slide_to(17);
        recording.slide_to(5);
        let (run, steps) = (simulator.run_number(), recording.text(".steps dd"));
        let path = format!("/api/sources/live/find?run={run}&steps={steps}");
        let index = http::get(&simulator.url(&path)).json()["at"].as_u64().unwrap();
        let index = usize::try_from(index).unwrap();
        live.wait_for_state(index);
        let both = copy(browser, COPY_ALL);
        for link in [&live_link, &recording_link, &both] {
            assert!(link.starts_with(&format!("{}/#server=", simulator.page)), "{link}");
        }

        // The linked run shows the state, and the other panel the newest state.
        open_anew(browser, &live_link);
        live.wait_for_state(11);
        recording.wait_for_state(39);
        assert_eq!(browser.address(), format!("{}/", simulator.page));
        // A link to a recording does not open the live run.
        open_anew(browser, &recording_link);
        recording.wait_for_state(24);
        assert!(!browser.exists(&live.part("h2")));
        open_anew(browser, &both);
        recording.wait_for_state(5);
        live.wait_for_state(index);
        let kind = "return document.querySelector('#compare [aria-pressed=true]').value";
        assert_eq!(browser.run::<String>(kind, &[]), "step");
        // A link that is pasted into the address of the open page.
        let paste = "location.hash = arguments[0]";
        browser.run::<()>(paste, &[json!(live_link.split_once('#').unwrap().1)]);
        live.wait_for_state(11);
        assert_eq!(recording.data("index"), "5", "linked panels do not move");

        // The recording is opened again from the folder.
        recording.click("[name=close]");
        wait_for("the panel to close", || (!browser.exists(&recording.part("h2"))).then_some(()));
        open_anew(browser, &recording_link);
        let opened = Panel { browser, source: "2" };
        opened.wait_for_state(24);

        // After a reset, the linked states are gone.
        simulator.send(b"reset");
        open_anew(browser, &live_link);
        wait_for_error(browser, "The live run of this link has been reset since");
        live.wait_until_empty();
        send_states(simulator, 0, 13);
        live.wait_for_state(12);
    });
}

#[test]
fn links_to_recordings_work_without_a_simulator_and_after_a_restart() {
    with_browser(|browser| {
        let simulator = Simulator::start_in(Home::new(), &["meadow", "--record", "kept"]);
        send_states(&simulator, 0, 9);
        simulator.send(b"reset");
        let folder = simulator.home.path().join("kept");
        let file = recorded(&folder);
        let serve = || {
            let arguments = ["replay", file.to_str().unwrap(), "--serve", "--viewer-port", "0"];
            Serving::start(simulator.home.command(&arguments), "watch at")
        };
        let replay = serve();
        browser.open(&page_address(&replay));
        let opened = Panel { browser, source: "1" };
        opened.wait_for_state(8);
        // Without the clipboard, the page shows the link for copying.
        let refuse = "navigator.clipboard.writeText = () => Promise.reject(new Error('refused'))";
        browser.run::<()>(refuse, &[]);
        opened.slide_to(3);
        opened.click(COPY);
        wait_for("the dialog", || browser.is_visible("#link-dialog").then_some(()));
        let selected = "return getSelection().toString()";
        let link: String = browser.run(selected, &[]);
        browser.click("#link-dialog button");
        assert!(!browser.is_visible("#link-dialog"));
        open_anew(browser, &link);
        opened.wait_for_state(3);
        browser.leave();
        drop(replay);

        // A new server has another address and other IDs, but the recording has the same name.
        let replay = serve();
        let (_, fragment) = link.split_once('#').unwrap();
        browser.open(&format!("{}/#{fragment}", page_address(&replay)));
        opened.wait_for_state(3);
        browser.open("about:blank");
        browser.open(&format!("{}/#{}", page_address(&replay), fragment.replace("meadow", "gone")));
        wait_for_error(browser, "The recording of this link is not available: ");
        browser.open(&format!("{}/#live=1@0", page_address(&replay)));
        wait_for_error(browser, "The live run of this link is not available");
        let errors = browser.take_errors();
        assert!(errors.iter().all(|error| error.message.contains("404")), "{errors:?}");
        browser.leave();
    });
}

#[test]
fn parts_of_the_address_that_are_no_link_are_ignored() {
    with_two_panels(5, 3, |simulator, live, recording| {
        let browser = live.browser;
        let paste = |fragment: &str| {
            browser.run::<()>("location.hash = arguments[0]", &[json!(fragment)]);
        };
        store_copies(browser);
        live.slide_to(1);
        let link = copy(browser, &live.part(COPY));
        live.slide_to(0);
        for fragment in [
            "mazes",
            "live=",
            "live=1",
            "live=1@-1",
            "live=x@1",
            "recording=1@2",
            "recording=:@",
            "link=step",
            "%",
        ] {
            paste(fragment);
        }
        // The page handles the fragments one after the other.
        paste(link.split_once('#').unwrap().1);
        live.wait_for_state(1);
        assert!(!browser.is_visible("#error"));
        for fragment in ["%", "live=1@999999999999999999999"] {
            open_anew(browser, &format!("{}/#{fragment}", simulator.page));
            recording.wait_for_state(4);
            assert!(fragment != "%" || !browser.is_visible("#error"));
            assert!(browser.exists(&live.part("h2")), "{fragment}");
        }
    });
}
