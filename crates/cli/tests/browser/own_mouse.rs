//! The page of `mmsim run`: controlling the user's own mouse.

use std::fs;

use mmsim_solvers::BundledStrategy;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser};
use crate::harness::Home;
use crate::http;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled, connect};
use crate::test_state::TestState;

const MMSIM: &str = env!("CARGO_BIN_EXE_mmsim");

/// A mouse that searches the maze.
const SEARCHES: [&str; 7] =
    [MMSIM, "solve", "flood-fill", "--goal", "server", "--connect", "{endpoint}"];

/// A mouse that neither moves nor exits: a server.
const WAITS: [&str; 4] = [MMSIM, "--no-viewer", "--port", "0"];

/// Starts `mmsim run`, opens its page in a browser, and runs a test.
fn with_mouse(options: &[&str], mouse: &[&str], test: impl FnOnce(&Browser, &Simulator)) {
    with_browser(|browser| {
        let simulator = Simulator::start_mouse(Home::new(), options, mouse);
        open(browser, &simulator);
        test(browser, &simulator);
        browser.leave();
    });
}

/// Opens the page and waits for its controls.
fn open(browser: &Browser, simulator: &Simulator) {
    browser.open(&simulator.page);
    let controls = Panel::live(browser).part(".run .phase");
    browser.wait_until_exists(&controls);
}

fn click(live: Panel<'_>, name: &str) {
    live.click(&format!(".run [name={name}]"));
}

fn wait_for_phase(live: Panel<'_>, phase: &str) {
    assert_eq!(live.browser.wait_for_text(&live.part(".run .phase"), phase), phase);
}

/// Waits until the page shows an outcome that contains `text`. Returns the outcome.
fn wait_for_result(live: Panel<'_>, text: &str) -> String {
    live.browser.wait_for_text(&live.part(".run .result"), text)
}

fn is_shown(browser: &Browser, live: Panel<'_>, selector: &str) -> bool {
    let script = "return document.querySelector(arguments[0]).offsetParent !== null";
    browser.run(script, &[json!(live.part(selector))])
}

/// Requests an action of the mouse without the page's script. Returns the status.
fn act(page: &str, body: &str) -> u16 {
    let headers = [("content-type", "application/json"), ("origin", page)];
    http::request("POST", &format!("{page}/api/mouse"), &headers, body.as_bytes()).status
}

/// A mouse for mms that turns in the start cell, three times around.
const TURNS: [&str; 3] =
    ["sh", "-c", "for turn in 1 2 3 4 5 6 7 8 9 10 11 12; do echo turnRight; read reply; done"];

#[test]
fn the_page_states_why_a_mouse_failed_and_opens_at_the_state() {
    let options = ["--maze", "hedgerow", "--stay", "--record", "runs"];
    with_mouse(&options, &TURNS, |browser, simulator| {
        let live = Panel::live(browser);
        let cause = "turns without leaving (0, 0), since state 0";
        wait_for_result(live, cause);
        let opens_at_cause = |panel: Panel<'_>| {
            panel.wait_for_state(0);
            let result = panel.part(".outcome:not([hidden]) li");
            browser.wait_for_text(&result, &format!("Goal not found: {cause}"));
        };
        opens_at_cause(live);
        // A user who has gone to another state stays there, and can go back.
        let button = ".outcome [name=show-cause]";
        assert!(!is_shown(browser, live, button));
        let last = simulator.info().states - 1;
        live.click("[name=follow]");
        live.wait_for_state(last);
        let is_visible = "return document.querySelector(arguments[0])?.checkVisibility()";
        let _: bool = browser.wait_until("a result", is_visible, &[json!(live.part(button))]);
        assert_eq!(live.data("index"), last.to_string());
        live.click(button);
        opens_at_cause(live);

        browser.click("#recordings [name=open]");
        let recording = Panel { browser, source: "1" };
        browser.wait_until_exists(&recording.part(".map svg"));
        opens_at_cause(recording);
    });
}

#[test]
fn a_mouse_runs_again_and_shows_how_it_ended() {
    with_mouse(&["--maze", "hedgerow", "--stay"], &SEARCHES, |browser, simulator| {
        let live = Panel::live(browser);
        let result = wait_for_result(live, "exited with code 0; goal reached, ");
        assert_eq!(live.text(".run .name"), "mmsim");
        assert_eq!(live.attribute(".run", "data-ending"), "finished");
        let states = simulator.info().states;
        assert!(result.ends_with(&format!(" {states} states")), "{result}");
        let run = simulator.run_number();
        live.wait_for_run_state(run, states - 1);

        // Run it again, slowly. Stop it.
        live.set_pace("×¼");
        click(live, "again");
        wait_for_phase(live, "running");
        wait_for("another run", || (simulator.run_number() > run).then_some(()));
        wait_for("two states", || (simulator.info().states >= 2).then_some(()));
        click(live, "stop");
        let result = wait_for_result(live, "stopped; goal not reached, ");
        assert_eq!(live.attribute(".run", "data-ending"), "stopped");
        let stopped = simulator.info().states;
        assert!(result.contains(&format!(" {stopped} state")), "{result}");

        // A run that has not ended is stopped when the next one starts.
        click(live, "again");
        wait_for_phase(live, "running");
        let run = simulator.run_number();
        click(live, "again");
        wait_for("another run", || (simulator.run_number() > run).then_some(()));
        live.set_pace("no limit");
        wait_for_result(live, "exited with code 0; goal reached, ");
        assert_eq!(simulator.info().states, states, "each run begins at the start");
    });
}

#[test]
fn pause_step_and_pace_hold_the_mouse() {
    with_mouse(&["--maze", "steps"], &WAITS, |browser, simulator| {
        let maze = bundled("training-first-steps.txt");
        let live = Panel::live(browser);
        wait_for_phase(live, "running");
        live.wait_until_empty();
        // The mouse never connects. The test sends states in its place.
        let socket = connect(&simulator.serving.address);
        let send = |number: usize| {
            socket.send(TestState::new(number, maze.size()).message('C', 'C'), 0).unwrap();
            live.wait_for_state(number);
        };
        let expect_ok = || assert_eq!(socket.recv_bytes(0).unwrap(), b"ok");
        let is_held = || socket.poll(zmq::POLLIN, 0).unwrap() == 0;
        send(0);
        expect_ok();

        click(live, "pause");
        wait_for_phase(live, "paused");
        for number in 1..4 {
            send(number);
            assert!(is_held());
            click(live, "step");
            expect_ok();
        }
        send(4);
        assert!(is_held());
        assert_eq!(live.text(".run [name=pause]"), "Resume");
        click(live, "pause");
        expect_ok();
        wait_for_phase(live, "running");

        // A new pace applies at once.
        assert_eq!(act(&simulator.page, r#"{"action":"set-pace","pace":0.01}"#), 204);
        wait_for("the pace", || (live.text(".pace output") == "0.01/s").then_some(()));
        send(5);
        assert!(is_held(), "the next step is due in 100 s");
        live.set_pace("no limit");
        expect_ok();
        (6..20).for_each(|number| {
            send(number);
            expect_ok();
        });

        // A mouse that is stopped during a pause does not continue.
        click(live, "pause");
        wait_for_phase(live, "paused");
        send(20);
        click(live, "stop");
        let result = wait_for_result(live, "stopped; goal ");
        assert!(result.contains(" 21 states"), "{result}");
    });
}

#[test]
fn another_maze_stops_the_mouse_and_offers_to_run_it_there() {
    with_mouse(&["--maze", "hedgerow", "--pace", "3600000"], &SEARCHES, |browser, simulator| {
        let (page, live) = (Page(browser), Panel::live(browser));
        let is_asking =
            || browser.run::<bool>("return document.querySelector('#confirm').open", &[]);
        let choose = |path: &str, answer: &str| {
            page.choose_maze(path);
            wait_for("the dialog", || is_asking().then_some(()));
            assert_eq!(browser.text("#confirm [value=run]"), "Load and run mmsim");
            browser.click(&format!("#confirm [value='{answer}']"));
            wait_for("the dialog to close", || (!is_asking()).then_some(()));
        };
        live.wait_for_state(0);
        wait_for_phase(live, "running");
        choose("half-size-old-quarter.txt", "");
        assert_eq!(live.text(".run .phase"), "running");
        assert!(browser.text("#confirm .warning").starts_with("mmsim is running. "));

        choose("half-size-old-quarter.txt", "confirm");
        wait_for_result(live, "stopped: another maze was loaded; ");
        assert_eq!(
            (simulator.info().maze.as_str(), simulator.info().states),
            ("half-size-old-quarter", 0)
        );

        // Without states there is nothing to confirm. The mouse does not start by itself.
        page.choose_maze("05-hedgerow.txt");
        wait_for("hedgerow", || (simulator.info().maze == "05-hedgerow").then_some(()));
        assert!(!is_asking());
        wait_for("no outcome", || live.text(".run .result").is_empty().then_some(()));
        click(live, "again");
        live.wait_for_state(0);
        wait_for_phase(live, "running");
        choose("oblong-long-meadow.txt", "run");
        live.set_pace("no limit");
        wait_for_result(live, "exited with code 0; goal reached, ");
        assert_eq!(simulator.info().maze, "oblong-long-meadow");
        live.wait_for_run_state(simulator.run_number(), simulator.info().states - 1);
    });
}

#[test]
fn bundled_strategies_are_offered_between_runs_of_the_mouse() {
    with_mouse(&["--maze", "hedgerow"], &WAITS, |browser, simulator| {
        let live = Panel::live(browser);
        let primary = ".primary:not([hidden], dialog *)";
        let count = "return document.querySelectorAll(arguments[0]).length";
        assert_eq!(browser.run::<usize>(count, &[json!(primary)]), 1);
        let run = r#"{"action":"run","strategy":"flood-fill"}"#;
        wait_for_phase(live, "running");
        assert!(!is_shown(browser, live, ".run [name=run]"));
        assert_eq!(act(&simulator.page, run), 409);
        click(live, "stop");
        wait_for_result(live, "stopped; goal not reached, no command of mms and no request");
        assert!(is_shown(browser, live, ".run [name=run]"));
        live.set_pace("no limit");
        live.choose("[name=strategy]", "flood-fill");
        click(live, "run");
        wait_for_result(live, "goal reached; ");
        assert_eq!(live.text(".run .name"), "flood-fill");
        let states = simulator.info().states;
        let expected = simulator.search(&bundled("05-hedgerow.txt"), BundledStrategy::FloodFill);
        assert_eq!(states, expected.len());
        assert_eq!(live.text(".run [name=again]"), "Run mmsim");
        click(live, "again");
        wait_for_phase(live, "running");
        assert_eq!(live.text(".run .name"), "mmsim");
        assert_eq!(live.text(".run [name=again]"), "Run again");
    });
}

#[test]
fn running_again_deletes_states_of_another_client_only_after_confirmation() {
    with_mouse(&["--maze", "hedgerow", "--stay"], &WAITS, |browser, simulator| {
        let live = Panel::live(browser);
        wait_for_phase(live, "running");
        click(live, "stop");
        wait_for_phase(live, "ended");
        let size = bundled("05-hedgerow.txt").size();
        simulator.send(&TestState::new(0, size).message('C', 'C'));
        live.wait_for_state(0);
        wait_for("the client", || {
            live.text(".run .blocked").starts_with("Another client is searching").then_some(())
        });
        let run = simulator.run_number();
        let answer = |answer: &str| {
            let is_asking = "return document.querySelector('#confirm').open";
            click(live, "again");
            wait_for("the dialog", || browser.run::<bool>(is_asking, &[]).then_some(()));
            assert!(browser.text("#confirm .warning").starts_with("Another client"));
            browser.click(&format!("#confirm [value='{answer}']"));
        };
        answer("");
        assert_eq!((simulator.run_number(), simulator.info().states), (run, 1));
        answer("confirm");
        wait_for_phase(live, "running");
        wait_for("another run", || (simulator.run_number() > run).then_some(()));
        assert_eq!(simulator.info().states, 0);
    });
}

#[test]
fn a_mouse_that_fails_is_reported() {
    let mouse = [MMSIM, "solve", "no-such-strategy"];
    with_mouse(&["--maze", "steps", "--stay"], &mouse, |browser, simulator| {
        let live = Panel::live(browser);
        wait_for_result(
            live,
            "exited with code 2; goal not reached, no command of mms and no request",
        );
        assert_eq!(live.attribute(".run", "data-ending"), "failed");
        assert_eq!(simulator.info().states, 0);
    });
    // A copy of the program, which can be deleted.
    with_browser(|browser| {
        let home = Home::new();
        let program = home.path().join("copy").with_extension(std::env::consts::EXE_EXTENSION);
        fs::copy(MMSIM, &program).unwrap();
        let name = program.file_name().unwrap().to_str().unwrap().to_string();
        let mouse = [program.to_str().unwrap(), "solve", "no-such-strategy"];
        let simulator = Simulator::start_mouse(home, &["--stay"], &mouse);
        open(browser, &simulator);
        let live = Panel::live(browser);
        wait_for_result(live, "exited with code 2");
        assert_eq!(live.text(".run .name"), name);
        fs::remove_file(&program).unwrap();
        click(live, "again");
        wait_for_result(live, "cannot start the mouse ");
        assert_eq!(live.attribute(".run", "data-ending"), "failed");
        browser.leave();
    });
}

/// A mouse for mms that turns, crashes, and waits for its reset button.
const MMS_MOUSE: &str = r#"
ask() { echo "$1"; read -r reply; }
for turn in 1 2 3 4; do ask turnLeft; done
ask "moveForward 0"
until ask wasReset; [ "$reply" = true ]; do sleep 0.05; done
ask ackReset
exit 3
"#;

#[test]
fn a_mouse_of_mms_is_controlled_too() {
    with_browser(|browser| {
        let home = Home::new();
        home.write("mouse.sh", MMS_MOUSE);
        let options = ["--maze", "hedgerow", "--stay", "--pace", "3600000"];
        let simulator = Simulator::start_mouse(home, &options, &["sh", "mouse.sh"]);
        open(browser, &simulator);
        let live = Panel::live(browser);
        let wait_for_states = |states: usize| {
            wait_for(&format!("{states} states"), || {
                assert!(simulator.info().states <= states, "the mouse takes one step at a time");
                (simulator.info().states == states).then_some(())
            });
            live.wait_for_state(states - 1);
        };
        // The mouse waits for an hour after its first turn.
        wait_for_states(2);
        assert_eq!(live.text(".run .name"), "mouse.sh");
        wait_for_phase(live, "running");
        click(live, "pause");
        wait_for_phase(live, "paused");
        for states in 3..6 {
            click(live, "step");
            wait_for_states(states);
        }
        live.set_pace("no limit");
        click(live, "pause");
        wait_for_phase(live, "running");
        click(live, "reset");
        let result = wait_for_result(live, "exited with code 3");
        // How many commands were executed depends on when the button was pressed.
        let rest = result.strip_prefix("exited with code 3 after command ").expect(&result);
        assert!(rest.ends_with("; goal not reached, score 2000; 1 crashed movement"), "{result}");
        assert_eq!(live.attribute(".run", "data-ending"), "failed");

        let run = simulator.run_number();
        click(live, "again");
        wait_for("another run", || (simulator.run_number() > run).then_some(()));
        wait_for("the last turn", || (simulator.info().states == 5).then_some(()));
        click(live, "stop");
        wait_for_result(live, "stopped; goal not reached, score 2000; 1 crashed movement");

        // The mouse runs in another maze, with the start and the size of that maze.
        Page(browser).choose_maze("oblong-long-meadow.txt");
        let is_asking =
            || browser.run::<bool>("return document.querySelector('#confirm').open", &[]);
        wait_for("the dialog", || is_asking().then_some(()));
        browser.click("#confirm [value=run]");
        wait_for("the last turn in the other maze", || {
            let info = simulator.info();
            (info.maze == "oblong-long-meadow" && info.states == 5).then_some(())
        });
        click(live, "reset");
        wait_for_result(live, "exited with code 3");
        browser.leave();
    });
}

#[test]
fn a_changed_file_runs_the_mouse_again() {
    with_browser(|browser| {
        let home = Home::new();
        let maze = home.write("maze.txt", "o---o---o\n| S   G |\no---o---o\n");
        // A copy of the program, which can be changed.
        let program = home.path().join("copy").with_extension(std::env::consts::EXE_EXTENSION);
        fs::copy(MMSIM, &program).unwrap();
        let name = program.file_name().unwrap().to_str().unwrap().to_string();
        let program = program.to_str().unwrap();
        let mouse = [program, "mazes", "check", maze.to_str().unwrap()];
        let simulator = Simulator::start_mouse(home, &["--watch"], &mouse);
        open(browser, &simulator);
        let live = Panel::live(browser);
        wait_for_result(live, "exited with code 0");
        fs::write(&maze, "no maze").unwrap();
        fs::File::options()
            .append(true)
            .open(program)
            .unwrap()
            .set_modified(std::time::SystemTime::UNIX_EPOCH)
            .unwrap();
        wait_for_result(live, "exited with code 1");
        let reason = format!("Restarted because {name} has changed.");
        assert_eq!(live.text(".run .reason"), reason);
        browser.leave();
    });
}

/// A run that the user requests while a change waits for another client uses the change.
#[test]
fn a_run_requested_by_the_user_uses_a_waiting_change() {
    use mmsim_tests::ask;

    use crate::harness::{Serving, read_on};
    use crate::simulator::page_address;

    let home = Home::new();
    home.write("mouse.sh", "exit 0");
    let options = ["run", "--port", "0", "--viewer-port", "0", "--watch"];
    let command = home.command(&[&options[..], &["--", "sh", "mouse.sh"]].concat());
    let (serving, stderr) = Serving::start_reading(command, "still serving");
    let client = connect(&serving.address);
    assert_eq!(ask(&client, b"reset"), b"ok");
    home.write("mouse.sh", "exit 0 # changed");
    let (stderr, _) = read_on(stderr, "waiting for another client");
    assert_eq!(act(&page_address(&serving), r#"{"action":"run-again"}"#), 204);
    let (stderr, _) = read_on(stderr, "running mouse.sh again");
    let (stderr, _) = read_on(stderr, "exited with code 0");
    // Only the next change waits now.
    assert_eq!(ask(&client, b"reset"), b"ok");
    home.write("mouse.sh", "exit 1 # changed again");
    let (stderr, _) = read_on(stderr, "waiting for another client");
    drop(client);
    read_on(stderr, "running mouse.sh again because mouse.sh has changed");
}
