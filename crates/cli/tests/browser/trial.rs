//! Checks the page of a two-run trial at every kind of state.

use std::fs;
use std::path::PathBuf;

use fantoccini::key::Key;
use serde_json::Value;

use crate::browser::{Browser, wait_for, with_browser};
use crate::harness::Home;
use crate::page::Panel;
use crate::simulator::page_address;
use crate::{harness, http};

/// Returns the text of each cell in a row of the table of runs.
fn row(browser: &Browser, live: Panel<'_>, run: &str) -> [String; 3] {
    let script = "return [...document.querySelectorAll(arguments[0])].map((it) => it.textContent)";
    browser.run(script, &[live.part(&format!(".phases .{run} td")).into()])
}

fn is_visible(browser: &Browser, selector: &str) -> bool {
    let script = "return document.querySelector(arguments[0])?.offsetParent != null";
    browser.run(script, &[selector.into()])
}

/// Checks the figures of a trial in several states. The table of `report` is that of `mmsim trial`.
fn check_states(browser: &Browser, panel: Panel<'_>, report: &Value) {
    let number = |key: &str| usize::try_from(report[key].as_u64().unwrap()).unwrap();
    let (explore, race) = (number("explore_steps"), number("race_steps"));
    let (last, optimum) = (explore + race, number("race_optimum"));
    panel.wait_for_state(last);
    let text = |selector: &str| panel.text(selector);
    for at in [last, 0, 1, explore / 2, explore - 1, explore, explore + 1, last - 1, last] {
        browser.press(format!("g{}{}", at, char::from(Key::Enter)).chars());
        panel.wait_for_state(at);
        let [first, second] = ["run-1", "run-2"].map(|run| row(browser, panel, run)[0].clone());
        assert_eq!(first, at.min(explore).to_string(), "state {at}");
        let raced = at.checked_sub(explore).map_or("–".into(), |steps| steps.to_string());
        assert_eq!(second, raced, "state {at}");
        assert_eq!(text(".steps dd"), at.to_string());
        let (status, score) = match at {
            _ if at < explore => ("run 1", "–".into()),
            _ if at < last => ("run 2", "–".into()),
            _ => ("scored", format!("{:.3}", report["score"].as_f64().unwrap())),
        };
        assert_eq!((text(".trial .status").as_str(), text(".score dd")), (status, score));
        assert_eq!(text(".trial .robot dd"), report["mouse"].as_str().unwrap());
        assert_eq!(text(".actual dd"), optimum.to_string());
        let lower: usize = text(".optimistic dd").parse().unwrap();
        let upper = text(".pessimistic dd").parse().unwrap_or(usize::MAX);
        assert!(lower <= optimum && optimum <= upper, "state {at}: {lower} to {upper}");
    }
    let events = wait_for("the events", || {
        let script = "return [...document.querySelectorAll(arguments[0])]
            .flatMap((mark) => mark.title.split('\\n'))";
        let marks: Vec<String> = browser.run(script, &[panel.part(".marks button").into()]);
        marks.contains(&format!("trial scored, state {last}")).then_some(marks)
    });
    for (event, at) in [("run 1 begins", 0), ("run 2 begins", explore)] {
        assert!(events.contains(&format!("{event}, state {at}")), "{events:?}");
    }
    assert!(events.iter().any(|event| event.starts_with("goal reached")), "{events:?}");
    assert!(!events.iter().any(|event| event.starts_with("fast run")), "{events:?}");
    assert_eq!((text(".path-name"), text(".actual dt")), ("Fastest race".into(), "optimum".into()));
}

#[test]
fn a_trial_shows_its_runs_and_its_score_at_every_state() {
    with_browser(|browser| {
        let home = Home::new();
        let trial = ["trial", "harbour", "--robot", "swing"];
        let report = home.run(&[&trial[..], &["--json"]].concat()).json();
        let options = ["--serve", "--port", "0", "--viewer-port", "0", "--record", "r"];
        let mut server = home.serve_until(&[&trial[..], &options].concat(), "still serving");
        let page = page_address(&server).lines().next().unwrap().to_string();
        browser.open(&page);
        let live = Panel::live(browser);
        check_states(browser, live, &report[0]);
        for hidden in [".run .bundled", "#mazes", ".runs", ".bar a"] {
            assert!(!is_visible(browser, hidden), "{hidden}");
        }
        assert!(is_visible(browser, ".trial") && is_visible(browser, ".trial-runs"));
        // Another page cannot start a mouse either.
        let start = r#"{"action":"run","strategy":"flood-fill"}"#;
        let headers = [("content-type", "application/json"), ("origin", page.as_str())];
        let url = format!("{page}/api/mouse");
        let reply = http::request("POST", &url, &headers, start.as_bytes());
        assert_eq!(reply.status, 409, "{}", reply.text());

        // The robot can run again.
        let score = format!("score {}", live.text(".score dd"));
        assert_eq!(live.text(".run .result"), score);
        let run: u64 = live.data("run").parse().unwrap();
        live.click(".run [name=again]");
        live.wait_for_run(run + 1);
        wait_for("the end of the trial", || (live.text(".run .result") == score).then_some(()));
        check_states(browser, live, &report[0]);

        // The recording shows the same figures.
        browser.leave();
        server.kill();
        let recordings = fs::read_dir(home.path().join("r")).unwrap();
        let recordings = recordings.map(|entry| entry.unwrap().path());
        let is_recording = |path: &PathBuf| path.extension().is_some_and(|it| it == "mcap");
        let recording = recordings.filter(is_recording).max().unwrap();
        let command = ["replay", recording.to_str().unwrap(), "--serve", "--viewer-port", "0"];
        let viewer = harness::Serving::start(home.command(&command), "watch at http://");
        browser.open(&page_address(&viewer));
        check_states(browser, Panel { browser, source: "1" }, &report[0]);
        browser.leave();
    });
}
