//! Recordings: saved, loaded, listed, served; and pictures of them.

use std::fs;
use std::path::{Path, PathBuf};

use mmsim_maze::Maze;
use mmsim_recording::Recording;

use crate::browser::{Browser, browse, wait_for, watch};
use crate::harness::{Home, Serving, recorded};
use crate::http;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled, page_address};
use crate::told::Told;

const FILE: &str = "#recordings [name=file]";

/// States of a maze, and their messages.
fn history(maze: &Maze, count: usize) -> (Vec<Told>, Vec<Vec<u8>>) {
    let told: Vec<_> = (0..count).map(|number| Told::of(number, maze.size())).collect();
    let messages = told.iter().map(|told| told.message('C', 'F')).collect();
    (told, messages)
}

/// Goes through a panel's history and looks whether it is this one.
fn assert_has(panel: Panel<'_>, maze: &Maze, told: &[Told]) {
    let last = told.len() - 1;
    panel.wait_at(last);
    panel.assert_shows(maze, told);
    for (button, at) in [("first", 0), ("on", 1), ("follow", last)] {
        panel.click(&format!("button[name={button}]"));
        panel.wait_at(at);
        panel.assert_shows(maze, &told[..=at]);
    }
}

/// A file that has been downloaded in whole: until then its place is held by an empty one.
fn downloaded(browser: &Browser, ending: &str) -> PathBuf {
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
fn a_saved_run_opens_beside_the_live_one() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let (told, messages) = history(&maze, 300);
        simulator.send_all(&messages);
        let live = Panel::live(browser);
        live.wait_at(299);
        live.click(".export [data-export='recording.mcap']");
        let file = downloaded(browser, "mcap");
        assert_holds(&file, &messages);

        // The live one goes on to something else.
        simulator.send(b"reset");
        live.wait_empty();
        let other = Told::of(777, maze.size());
        simulator.send(&other.message('F', 'C'));
        browser.type_into(FILE, file.to_str().unwrap());
        let opened = Panel { browser, source: "1" };
        wait_for("a panel", || browser.is_there(&opened.part(".map svg")).then_some(()));
        assert_has(opened, &maze, &told);
        live.wait_at(0);
        live.assert_shows(&maze, std::slice::from_ref(&other));
        assert_eq!(
            browser.run::<usize>("return document.querySelectorAll('.panel').length", &[]),
            2
        );

        // A page that is opened anew shows both.
        browser.open(&simulator.page);
        assert_has(opened, &maze, &told);
        live.wait_at(0);
        opened.click("button[name=close]");
        wait_for("its end", || (!browser.is_there(&opened.part(".map"))).then_some(()));
        live.assert_shows(&maze, &[other]);
        // It is closed for everybody.
        wait_for("the server", || {
            let address = simulator.at("/api/sources/1");
            (http::get(&address).status == 404).then_some(())
        });
    });
}

#[test]
fn what_is_no_recording_is_refused_in_words() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        Panel::live(browser).wait_empty();
        let file = simulator.home.write("rubbish.mcap", "rubbish");
        browser.type_into(FILE, file.to_str().unwrap());
        let said = wait_for("why", || {
            let said = browser.text("#problem span");
            (!said.is_empty()).then_some(said)
        });
        assert!(said.starts_with("rubbish.mcap: "), "{said}");
        assert_eq!(
            browser.run::<usize>("return document.querySelectorAll('.panel').length", &[]),
            1
        );
        let complaints = browser.complaints();
        assert_eq!(complaints.len(), 1, "{complaints:?}");
        assert!(complaints[0].message.contains("400 (Bad Request)"), "{complaints:?}");
    });
}

#[test]
fn earlier_searches_are_listed_and_open() {
    watch(&["--maze", "meadow", "--record", "kept"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let names = || -> Vec<String> {
            let script = "return [...document.querySelectorAll('#recordings li .name')]
                .map((name) => name.textContent)";
            browser.run(script, &[])
        };
        let mut runs = Vec::new();
        for count in [3, 5, 4] {
            let (told, messages) = history(&maze, count);
            simulator.send_all(&messages);
            runs.push(told);
            wait_for("the list", || (names().len() == runs.len()).then_some(()));
            simulator.send(b"reset");
        }
        // The newest first.
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
            wait_for("a panel", || browser.is_there(&opened.part(".map svg")).then_some(()));
            assert_has(opened, &maze, newest.next().unwrap());
        }
        Panel::live(browser).wait_empty();
    });
}

#[test]
fn a_recording_is_served_without_a_simulator() {
    browse(|browser| {
        let maze = bundled("oblong-long-meadow.txt");
        let (told, messages) = history(&maze, 20);
        let home = Home::new();
        let simulator = Simulator::start_in(home, &["--maze", "meadow", "--record", "kept"]);
        simulator.send_all(&messages);
        simulator.send(b"reset");
        let file = recorded(&simulator.home.path().join("kept"));
        let arguments = ["replay", file.to_str().unwrap(), "--serve", "--viewer-port", "0"];
        let replay = Serving::start(simulator.home.command(&arguments), "watch at");
        browser.open(&page_address(&replay));
        let opened = Panel { browser, source: "1" };
        wait_for("a panel", || browser.is_there(&opened.part(".map svg")).then_some(()));
        assert_has(opened, &maze, &told);
        assert!(!browser.is_there(&Panel::live(browser).part(".map")));
        browser.leave();
    });
}

#[test]
fn what_is_shown_can_be_saved_as_a_picture() {
    watch(&["--maze", "meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let (_, messages) = history(&maze, 4);
        simulator.send_all(&messages);
        let live = Panel::live(browser);
        live.wait_at(3);
        live.click("button[name=first]");
        live.wait_at(0);
        for (what, kind, begins) in [
            ("picture.svg", "image/svg+xml", &b"<svg "[..]),
            ("picture.png", "image/png", b"\x89PNG\r\n"),
            ("animation.gif", "image/gif", b"GIF89a"),
            ("recording.mcap", "application/octet-stream", b"\x89MCAP0"),
        ] {
            let link = format!("[data-export='{what}']");
            live.click(&link);
            let file = downloaded(browser, what.rsplit('.').next().unwrap());
            let saved = fs::read(&file).unwrap();
            assert!(saved.starts_with(begins), "{what}");
            let name = file.file_name().unwrap().to_string_lossy();
            assert!(name.starts_with("oblong-long-meadow"), "{name}");
            let path = live.says_of(&link, "href");
            let reply = http::get(&simulator.at(&path));
            assert_eq!((reply.status, reply.header("content-type")), (200, Some(kind)), "{path}");
            assert!(reply.header("content-disposition").unwrap().starts_with("attachment; "));
            if what == "picture.svg" {
                assert_first_is_drawn(
                    &String::from_utf8(saved).unwrap(),
                    &Told::of(0, maze.size()),
                );
            }
        }
    });
}

/// The picture is that of the shown state.
fn assert_first_is_drawn(svg: &str, told: &Told) {
    for (cell, &weight) in told.size.cells().zip(&told.weights) {
        let number = svg.lines().find(|line| {
            line.starts_with("<path class=\"number\"")
                && line.contains(&format!(r#"data-cell="{},{}""#, cell.x, cell.y))
        });
        let path = mmsim_drawing::digits(weight.into());
        assert!(number.unwrap().contains(&format!(r#"d="{path}""#)), "{cell:?}");
    }
}
