//! Saving, uploading, listing and serving recordings, and exporting pictures.

use std::fs;
use std::path::{Path, PathBuf};

use mmsim_maze::Maze;
use mmsim_recording::Recording;

use crate::browser::{Browser, wait_for, with_browser, with_page};
use crate::harness::{Home, Serving, recorded};
use crate::http;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled, page_address};
use crate::test_state::TestState;

const FILE: &str = "#recordings [name=file]";

/// Returns `count` states of a maze and the messages that encode them.
fn history(maze: &Maze, count: usize) -> (Vec<TestState>, Vec<Vec<u8>>) {
    let states: Vec<_> = (0..count).map(|number| TestState::new(number, maze.size())).collect();
    let messages = states.iter().map(|state| state.message('C', 'F')).collect();
    (states, messages)
}

/// Asserts that a panel has these states and shows the first, second and last ones correctly.
fn assert_history(panel: Panel<'_>, maze: &Maze, states: &[TestState]) {
    let last = states.len() - 1;
    panel.wait_for_state(last);
    panel.assert_shows(maze, states);
    for (button, at) in [("first", 0), ("next", 1), ("follow", last)] {
        panel.click(&format!("button[name={button}]"));
        panel.wait_for_state(at);
        panel.assert_shows(maze, &states[..=at]);
    }
}

/// Waits for a download and returns its path. The file stays empty until the download is complete.
pub(crate) fn downloaded(browser: &Browser, ending: &str) -> PathBuf {
    wait_for(ending, || {
        let entries = fs::read_dir(browser.downloads()).unwrap().map(|entry| entry.unwrap().path());
        let is_whole = |path: &PathBuf| fs::metadata(path).is_ok_and(|file| file.len() > 0);
        let is_wanted = |path: &PathBuf| path.extension().is_some_and(|found| found == ending);
        entries.into_iter().find(|path| is_wanted(path) && is_whole(path))
    })
}

fn assert_holds(file: &Path, messages: &[Vec<u8>]) {
    let recording = Recording::open(file).unwrap();
    assert!(recording.history().iter().eq(messages.iter().cloned()), "{}", file.display());
}

#[test]
fn a_saved_run_opens_next_to_the_live_run() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let (states, messages) = history(&maze, 300);
        simulator.send_all(&messages);
        let live = Panel::live(browser);
        live.wait_for_state(299);
        live.click(".export [data-export='recording.mcap']");
        let file = downloaded(browser, "mcap");
        assert_holds(&file, &messages);

        // The live simulation continues with other states.
        simulator.send(b"reset");
        live.wait_until_empty();
        let other = TestState::new(777, maze.size());
        simulator.send(&other.message('F', 'C'));
        browser.type_into(FILE, file.to_str().unwrap());
        let opened = Panel { browser, source: "1" };
        browser.wait_until_exists(&opened.part(".map svg"));
        assert_history(opened, &maze, &states);
        live.wait_for_state(0);
        live.assert_shows(&maze, std::slice::from_ref(&other));
        assert_eq!(
            browser.run::<usize>("return document.querySelectorAll('.panel').length", &[]),
            2
        );

        // A reloaded page shows both histories.
        browser.open(&simulator.page);
        assert_history(opened, &maze, &states);
        live.wait_for_state(0);
        opened.click("button[name=close]");
        wait_for("the panel to close", || (!browser.exists(&opened.part(".map"))).then_some(()));
        live.assert_shows(&maze, &[other]);
        // A recording closed on the page is also closed on the server.
        wait_for("the server", || {
            let address = simulator.url("/api/sources/1");
            (http::get(&address).status == 404).then_some(())
        });
    });
}

#[test]
fn an_invalid_recording_shows_an_error() {
    with_page(&["meadow"], |browser, simulator| {
        Panel::live(browser).wait_until_empty();
        let file = simulator.home.write("rubbish.mcap", "rubbish");
        browser.type_into(FILE, file.to_str().unwrap());
        let message = wait_for("the error", || {
            let message = browser.text("#error span");
            (!message.is_empty()).then_some(message)
        });
        assert!(message.starts_with("rubbish.mcap: "), "{message}");
        assert_eq!(
            browser.run::<usize>("return document.querySelectorAll('.panel').length", &[]),
            1
        );
        let errors = browser.take_errors();
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(errors[0].message.contains("400 (Bad Request)"), "{errors:?}");
    });
}

#[test]
fn recordings_are_listed_and_open() {
    with_page(&["meadow", "--record", "kept"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let names = || -> Vec<String> {
            let script = "return [...document.querySelectorAll('#recordings li .name')]
                .map((name) => name.textContent)";
            browser.run(script, &[])
        };
        let mut runs = Vec::new();
        for count in [3, 5, 4] {
            let (states, messages) = history(&maze, count);
            simulator.send_all(&messages);
            runs.push(states);
            wait_for("the list", || (names().len() == runs.len()).then_some(()));
            simulator.send(b"reset");
        }
        // The newest recording is listed first.
        let listed = names();
        let (mut sorted, mut newest) = (listed.clone(), runs.iter().rev());
        sorted.sort_unstable();
        sorted.reverse();
        assert_eq!(listed, sorted);
        for (number, name) in listed.iter().enumerate() {
            assert!(name.contains("oblong-long-meadow"), "{name}");
            browser.click(&format!("#recordings li:nth-child({}) button", number + 1));
            let id = (number + 1).to_string();
            let opened = Panel { browser, source: &id };
            browser.wait_until_exists(&opened.part(".map svg"));
            assert_history(opened, &maze, newest.next().unwrap());
        }
        Panel::live(browser).wait_until_empty();
    });
}

#[test]
fn recordings_are_told_apart_renamed_and_deleted() {
    with_page(&["hedgerow", "--record", "kept"], |browser, simulator| {
        let live = Panel::live(browser);
        let strategies = ["flood-fill", "shortest-path-search"];
        for strategy in strategies {
            browser.wait_until_exists(&live.part(".run [name=run]:enabled"));
            live.choose("[name=strategy]", strategy);
            live.set_pace("no limit");
            live.click(".run [name=run]");
            let is_shown = || live.text(".run .name") == strategy;
            let has_ended = || is_shown() && live.text(".run .phase") == "ended";
            wait_for("the end", || has_ended().then_some(()));
        }
        let text = |item: usize, part: &str| {
            browser.text(&format!("#recordings li:nth-child({item}) .{part}"))
        };
        let wait = |item, part: &str, expected: &str| {
            wait_for(expected, || (text(item, part) == expected).then_some(()));
        };
        let button = |item: usize, name: &str| {
            browser.click(&format!("#recordings li:nth-child({item}) [name={name}]"));
        };
        wait(1, "result", "recording…");
        wait(2, "name", "flood-fill · 05-hedgerow");
        assert!(browser.exists("#recordings li:nth-child(1) [name=delete]:disabled"));
        simulator.send(b"reset");
        wait(1, "name", "shortest-path-search · 05-hedgerow");
        assert!(text(1, "result").contains(", path proven"), "{}", text(1, "result"));
        assert!(text(2, "result").starts_with("goal after "), "{}", text(2, "result"));

        button(1, "rename");
        browser.clear("#rename input");
        browser.type_into("#rename input", "best run");
        browser.click("#rename .primary");
        wait(1, "name", "best run");
        wait_for("the result", || {
            text(1, "result").starts_with("shortest-path-search · 05-hedgerow · goal").then_some(())
        });
        button(2, "delete");
        browser.click("#confirm button[value='']");
        button(2, "delete");
        assert_eq!(browser.text("#confirm .name"), "flood-fill · 05-hedgerow");
        browser.click("#confirm [value=confirm]");
        let second = "#recordings li:nth-child(2)";
        wait_for("the deletion", || (!browser.exists(second)).then_some(()));
        let kept = fs::read_dir(simulator.home.path().join("kept")).unwrap();
        let kept: Vec<_> = kept.map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(kept, ["best run.mcap"]);
    });
}

#[test]
fn recorded_states_are_replaced_without_a_question() {
    with_page(&["meadow", "--record", "kept"], |browser, simulator| {
        let (_, messages) = history(&bundled("oblong-long-meadow.txt"), 3);
        simulator.send_all(&messages);
        let live = Panel::live(browser);
        live.wait_for_state(2);
        Page(browser).choose_maze("half-size-old-quarter.txt");
        wait_for("the maze", || (simulator.info().maze == "half-size-old-quarter").then_some(()));
        live.wait_until_empty();
        let recording = Recording::open(&recorded(&simulator.home.path().join("kept"))).unwrap();
        assert_eq!(recording.history().len(), messages.len());
    });
}

#[test]
fn a_recording_is_served_without_a_simulator() {
    with_browser(|browser| {
        let maze = bundled("oblong-long-meadow.txt");
        let (states, messages) = history(&maze, 20);
        let home = Home::new();
        let simulator = Simulator::start_in(home, &["meadow", "--record", "kept"]);
        simulator.send_all(&messages);
        simulator.send(b"reset");
        let file = recorded(&simulator.home.path().join("kept"));
        let arguments = ["replay", file.to_str().unwrap(), "--serve", "--viewer-port", "0"];
        let replay = Serving::start(simulator.home.command(&arguments), "watch at");
        browser.open(&page_address(&replay));
        let opened = Panel { browser, source: "1" };
        browser.wait_until_exists(&opened.part(".map svg"));
        assert_history(opened, &maze, &states);
        assert!(!browser.exists(&Panel::live(browser).part(".map")));
        browser.leave();
    });
}

#[test]
fn the_shown_state_can_be_exported() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let (_, messages) = history(&maze, 4);
        simulator.send_all(&messages);
        let live = Panel::live(browser);
        live.wait_for_state(3);
        live.click("button[name=first]");
        live.wait_for_state(0);
        for (what, kind, begins) in [
            ("picture.svg", "image/svg+xml", &b"<svg "[..]),
            ("picture.png", "image/png", b"\x89PNG\r\n"),
            ("animation.gif", "image/gif", b"GIF89a"),
            ("recording.mcap", "application/octet-stream", b"\x89MCAP0"),
            ("page.html", "application/octet-stream", b"<!doctype html>"),
        ] {
            let link = format!("[data-export='{what}']");
            live.click(&link);
            let file = downloaded(browser, what.rsplit('.').next().unwrap());
            let saved = fs::read(&file).unwrap();
            assert!(saved.starts_with(begins), "{what}");
            let name = file.file_name().unwrap().to_string_lossy();
            assert!(name.starts_with("oblong-long-meadow"), "{name}");
            let path = live.attribute(&link, "href");
            let reply = http::get(&simulator.url(&path));
            assert_eq!((reply.status, reply.header("content-type")), (200, Some(kind)), "{path}");
            assert!(reply.header("content-disposition").unwrap().starts_with("attachment; "));
            if what == "picture.svg" {
                assert_draws(&String::from_utf8(saved).unwrap(), &TestState::new(0, maze.size()));
            }
        }
    });
}

/// Asserts that a picture shows the weights of this state.
fn assert_draws(svg: &str, state: &TestState) {
    for (cell, &weight) in state.size.cells().zip(&state.weights) {
        let number = svg.lines().find(|line| {
            line.starts_with("<path class=\"number\"")
                && line.contains(&format!(r#"data-cell="{},{}""#, cell.x, cell.y))
        });
        let path = mmsim_drawing::weight(weight);
        assert!(number.unwrap().contains(&format!(r#"d="{path}""#)), "{cell:?}");
    }
}
