//! Exported pages, which are opened from disk.

use std::fs;
use std::path::{Path, PathBuf};

use mmsim_protocol::{Annotation, Colour};
use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser, with_logged_requests, with_page};
use crate::harness::{Home, Serving, recorded};
use crate::layout::{LAPTOP, PHONE, SMALL, assert_in_sight, assert_no_sideways_scrolling, resize};
use crate::load::take_requested_urls;
use crate::notes::{annotations, send_notes};
use crate::page::Panel;
use crate::policy::INLINE;
use crate::recordings::downloaded;
use crate::simulator::{Simulator, bundled, page_address};
use crate::test_state::TestState;

/// The only panel of an exported page.
fn panel(browser: &Browser) -> Panel<'_> {
    Panel { browser, source: "1" }
}

/// Opens a file from disk.
fn open(browser: &Browser, file: &Path) {
    browser.open(&format!("file://{}", file.display()));
}

/// Records the states that `send` sends, and returns the recording.
fn record(home: Home, maze: &[&str], send: impl FnOnce(&Simulator)) -> (Home, PathBuf) {
    let simulator = Simulator::start_in(home, &[maze, &["--record", "kept"]].concat());
    send(&simulator);
    simulator.send(b"reset");
    let file = simulator.home.path().join("run.mcap");
    fs::rename(recorded(&simulator.home.path().join("kept")), &file).unwrap();
    (simulator.home, file)
}

/// Exports a recording, and returns the file.
fn export(home: &Home, recording: &Path) -> PathBuf {
    let file = recording.with_extension("html");
    let [from, to] = [recording, &file].map(|path| path.to_str().unwrap());
    let ended = home.run(&["export", from, "-o", to]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""));
    file
}

/// Sends 30 states with all kinds of annotations, then 300 states with a log line in each fifth one.
/// Some states put the mouse back at the start.
fn send_run(simulator: &Simulator) {
    let size = bundled("oblong-long-meadow.txt").size();
    send_notes(simulator, size);
    for number in 0..300 {
        if number % 5 == 0 {
            let line = format!("line {number} of the second part");
            simulator.send(&annotations(&[Annotation::Log(&line)]));
        }
        simulator.send(&TestState::new(number, size).message('C', 'F'));
    }
}

/// Shows a state, waits until the panel is complete, and returns its content without the parts that
/// an exported page does not have.
fn content(panel: Panel<'_>, at: usize) -> String {
    panel.slide_to(at);
    let script = "
        const panel = document.querySelector(arguments[0]);
        const text = (selector) => panel.querySelector(selector).textContent;
        const lines = panel.querySelectorAll('.log li').length;
        const announced = text('.announcement');
        const isComplete = announced.startsWith(text('.position')) && announced.includes(' visited');
        const [, state, states] = text('.position').match(/State (\\S+) of (\\S+)/);
        const hasResult = !panel.querySelector('.outcome').hidden;
        if (!isComplete || lines !== arguments[1] || hasResult !== (state === states)) return null;
        const copy = panel.cloneNode(true);
        for (const part of copy.querySelectorAll('.export, .run, [name=close], [name=vehicle]')) part.remove();
        delete copy.dataset.kept;
        return copy.outerHTML.replaceAll('><', '>\\n<');";
    let lines = if at < 30 { at + 1 } else { 30 + (at - 30) / 5 + 1 };
    let arguments = [json!(panel.part("").trim_end()), json!(lines)];
    wait_for(&format!("everything about state {at}"), || panel.browser.run(script, &arguments))
}

/// Every state of an exported page looks like the same state on the page of a server.
#[test]
fn an_exported_page_shows_what_the_server_shows() {
    with_logged_requests(|browser| {
        let (home, recording) = record(Home::new(), &["meadow"], send_run);
        let arguments = ["replay", "run.mcap", "--serve", "--viewer-port", "0"];
        let server = Serving::start(home.command(&arguments), "watch at");
        let states = [329, 0, 1, 12, 29, 30, 255, 256, 128, 328];
        // In a narrow window, both pages have the same layout.
        let contents = || {
            resize(browser, PHONE);
            panel(browser).wait_for_state(329);
            states.map(|at| content(panel(browser), at))
        };
        browser.open(&page_address(&server));
        let expected = contents();
        browser.leave();
        drop(server);

        let file = export(&home, &recording);
        browser.take_log("performance");
        open(browser, &file);
        for (shown, expected) in contents().iter().zip(&expected) {
            let differing = shown.lines().zip(expected.lines()).find(|(a, b)| a != b);
            assert_eq!((differing, shown.len()), (None, expected.len()));
        }
        let filter = panel(browser).part("[name=filter]");
        browser.type_into(&filter, "line 200 of");
        let found = ".log li:only-child button";
        browser.wait_until_exists(&panel(browser).part(found));
        panel(browser).click(found);
        panel(browser).wait_for_state(230);
        browser.assert_no_errors();
        let requested = take_requested_urls(browser);
        let own = format!("file://{}", file.display());
        let is_local = |url: &&String| **url == own || url.starts_with("data:");
        assert_eq!(requested.iter().find(|url| !is_local(url)), None);
        assert!(requested.contains(&own), "{requested:?}");
        browser.leave();
    });
}

#[test]
fn an_exported_page_opens_at_the_last_state_and_plays() {
    with_browser(|browser| {
        let (home, recording) = record(Home::new(), &["meadow"], |simulator| {
            let size = bundled("oblong-long-meadow.txt").size();
            (0..4).for_each(|at| simulator.send(&TestState::new(at, size).message('C', 'C')));
        });
        open(browser, &export(&home, &recording));
        let panel = panel(browser);
        panel.wait_for_state(3);
        assert_eq!(panel.position(), "State 3 of 3");
        let title: String = browser.run("return document.title", &[]);
        assert_eq!(title, "run.mcap: oblong-long-meadow – mmsim");
        let hidden = "return [...document.querySelectorAll(arguments[0])]
            .filter((part) => part.checkVisibility()).map((part) => part.outerHTML)";
        let online =
            "aside, .bar a, #zmq, .export a, .run, [name=close], .online, #offline, #error";
        assert_eq!(browser.run::<Vec<String>>(hidden, &[json!(online)]), [""; 0]);
        for size in [LAPTOP, SMALL, PHONE] {
            resize(browser, size);
            assert_no_sideways_scrolling(browser);
            assert_in_sight(browser, panel, &["h2", ".map", "[name=play]"]);
        }
        resize(browser, LAPTOP);
        assert_in_sight(browser, panel, &["[name=slider]", "[name=jump]", ".figures", ".bounds"]);
        // The playback starts at the first state and ends at the last one.
        panel.set_pace("×64");
        browser.press([' ']);
        wait_for("the end of the playback", || {
            (panel.data("following") == "false" && panel.data("index") == "3").then_some(())
        });
        // A dropped file neither opens nor replaces the page.
        let drop = "
            const event = (name) => new DragEvent(name, { dataTransfer: new DataTransfer(), cancelable: true });
            return ['dragover', 'drop'].map((name) => document.body.dispatchEvent(event(name)))
                .concat(document.body.classList.contains('dropping'));";
        assert_eq!(browser.run::<[bool; 3]>(drop, &[]), [false; 3]);
        // A link opens the file at a state.
        let page = format!("file://{}", recording.with_extension("html").display());
        browser.open("about:blank");
        browser.open(&format!("{page}#server=&recording=1:run.mcap@1"));
        panel.wait_for_state(1);
        // Previews of files show pages in a sandbox, without access to any storage.
        let preview = home.write("preview.html", "<iframe sandbox='allow-scripts' src='run.html'>");
        open(browser, &preview);
        let shown = ".panel[data-index='3']";
        wait_for("the preview", || browser.frame_has("iframe", shown).then_some(()));
        browser.leave();
    });
}

#[test]
fn the_live_run_is_exported() {
    with_page(&["meadow"], |browser, simulator| {
        let maze = bundled("oblong-long-meadow.txt");
        let states: Vec<_> = (0..300).map(|number| TestState::new(number, maze.size())).collect();
        for state in &states {
            simulator.send(&state.message('C', 'F'));
        }
        let live = Panel::live(browser);
        live.wait_for_state(299);
        live.choose("[name=vehicle]", "ares");
        live.click("[data-export='page.html']");
        let file = downloaded(browser, "html");
        assert_eq!(file.file_name().unwrap(), "oblong-long-meadow.html");
        open(browser, &file);
        browser.wait_for_text(&panel(browser).part(".phases .vehicle"), "Times of ares");
        for at in [299, 255, 256, 0] {
            panel(browser).slide_to(at);
            panel(browser).assert_shows(&maze, &states[..=at]);
        }
    });
}

#[test]
fn a_recording_without_states_shows_the_maze() {
    with_browser(|browser| {
        let (home, maze) = (Home::new(), bundled("oblong-long-meadow.txt"));
        let simulation = mmsim_server::Simulation::new("meadow", maze.clone());
        let recording = home.path().join("empty.mcap");
        let info = simulation.info();
        mmsim_recording::RecordingWriter::create(&recording, &info, Some(&maze))
            .unwrap()
            .close()
            .unwrap();
        open(browser, &export(&home, &recording));
        panel(browser).wait_until_empty();
        assert_eq!(panel(browser).position(), "No states yet");
        panel(browser).assert_shows(&maze, &[]);
        browser.leave();
    });
}

#[test]
fn markup_in_a_recording_is_text() {
    const NAME: &str = "<img src=x onerror=window.hacked=1>\"'&amp;";
    const LINES: [&str; 3] =
        ["</script><script>window.hacked=1</script>", "<!--<script>", "--></body>"];
    with_browser(|browser| {
        let home = Home::new();
        home.write(&format!("mazes/{NAME}.txt"), "o---o---o\n| S   G |\no---o---o\n");
        let (home, recording) = record(home, &["mazes"], |simulator| {
            let cell = mmsim_maze::Cell::new(1, 0);
            let [a, b, c] = LINES.map(Annotation::Log);
            let text = Annotation::Text { cell, text: "</script>" };
            let colour = Annotation::Colour { cell, colour: Some(Colour::ALL[0]) };
            let names = [Annotation::Mouse(LINES[0]), Annotation::Strategy(LINES[1])];
            simulator.send(&annotations(&[names[0], names[1], text, colour, a, b, c]));
            simulator.send(b"S\0\0EC\x01\0C\x01\0");
        });
        let hostile = recording.with_file_name(format!("{NAME}.mcap"));
        fs::rename(&recording, &hostile).unwrap();
        let page = recording.with_file_name("page.html");
        let [from, to] = [&hostile, &page].map(|path| path.to_str().unwrap());
        assert_eq!(home.run(&["export", from, "-o", to]).code, Some(0));
        open(browser, &page);
        let panel = panel(browser);
        panel.wait_for_state(0);
        assert_eq!(panel.text("h2"), format!("{NAME}.mcap"));
        assert_eq!(panel.text(".about-maze"), format!("maze {NAME}"));
        assert_eq!(panel.text(".about-mouse"), format!("{} · {}", LINES[0], LINES[1]));
        let title: String = browser.run("return document.title", &[]);
        assert_eq!(title, format!("{NAME}.mcap: {NAME}, {} – mmsim", LINES[0]));
        let lines =
            "return [...document.querySelectorAll('.log li span')].map((line) => line.textContent)";
        wait_for("the log", || (browser.run::<Vec<String>>(lines, &[]) == LINES).then_some(()));
        assert!(!browser.run::<bool>("return 'hacked' in window", &[]));
        browser.leave();
    });
}

#[test]
fn other_scripts_do_not_run_on_an_exported_page() {
    with_browser(|browser| {
        let (home, recording) = record(Home::new(), &["meadow"], |simulator| {
            let size = bundled("oblong-long-meadow.txt").size();
            simulator.send(&TestState::new(0, size).message('C', 'C'));
        });
        open(browser, &export(&home, &recording));
        panel(browser).wait_for_state(0);
        browser.assert_no_errors();
        let ran: (bool, bool, bool, bool, String) = browser.run_async(INLINE, &[]);
        assert!(!ran.0 && !ran.1 && !ran.2 && !ran.3, "{ran:?}");
        for directive in ["script-src-elem", "script-src-attr", "style-src-attr"] {
            assert!(ran.4.contains(directive), "{ran:?}");
        }
        // Nothing can be loaded from a web site.
        let load = "const done = arguments[0];
            document.addEventListener('securitypolicyviolation', (event) => done(event.effectiveDirective));
            fetch('http://127.0.0.1:9/').then(() => done('loaded'), () => {});";
        assert_eq!(browser.run_async::<String>(load, &[]), "connect-src");
        browser.take_errors();
        browser.open("about:blank");
    });
}
