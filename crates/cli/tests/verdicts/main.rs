//! The verdict on a mouse is the same wherever it runs and wherever its states are shown.

#[path = "../harness/mod.rs"]
mod harness;
#[path = "../browser/http.rs"]
#[allow(dead_code, reason = "browser tests use the rest")]
mod http;

use std::path::{Path, PathBuf};
use std::thread;

use harness::mice::works;
use harness::{Home, recorded};
use mmsim_tests::wait_for;
use serde::Deserialize;
use serde_json::{Value, json};

/// The mice, which the tests of the Python package read too.
const MICE: &str = include_str!("mice.json");

#[derive(Deserialize)]
struct Mice {
    maze: String,
    mice: Vec<Mouse>,
}

#[derive(Deserialize)]
struct Mouse {
    name: String,
    /// The poses in its states, such as `00N 01N`, and `reset` and `restart` between them.
    poses: String,
    /// The commands of a mouse for mms that does the same, if there can be one.
    commands: Option<String>,
    goal_reached: bool,
    ending: String,
    /// The text, in which MESSAGE stands for the last request or command.
    error: Option<String>,
    /// The kind of the cause.
    cause: Option<String>,
    /// The number of movements that a wall blocks, if the mouse misreads walls.
    crashes: Option<u32>,
}

impl Mouse {
    /// Returns the error. `is_mms` is true if the mouse writes commands.
    fn error(&self, is_mms: bool) -> Option<String> {
        let words = self.poses.split(' ').filter(|word| word.as_bytes()[0].is_ascii_digit());
        // The client also sends info and reset, and two requests for each pose.
        let message = match &self.commands {
            Some(commands) if is_mms => format!("command {}", commands.split(' ').count()),
            _ => format!("request {}", 2 + 2 * words.count()),
        };
        self.error.as_ref().map(|error| error.replace("MESSAGE", &message))
    }

    /// Returns the sentence about the cause.
    fn sentence(&self, is_mms: bool) -> Option<String> {
        self.cause.as_ref()?;
        let error = self.error(is_mms)?;
        Some(error.split_once(": ").map_or(error.clone(), |(_, sentence)| sentence.into()))
    }

    /// Checks the keys of a verdict. An error may say more, such as the last line of stderr.
    #[track_caller]
    fn check(&self, place: &str, verdict: &Value) {
        let found = (&verdict["goal_reached"], &verdict["ending"]);
        let expected = (&json!(self.goal_reached), &json!(self.ending));
        assert_eq!(found, expected, "{} in {place}: {verdict}", self.name);
        if !place.starts_with("contest") {
            let cause = &verdict["cause"]["kind"];
            assert_eq!(cause, &json!(self.cause), "{} in {place}: {verdict}", self.name);
        }
        let error = &verdict["error"];
        let is_equal = match (&self.error(place.ends_with("mms")), error.as_str()) {
            (Some(expected), Some(found)) => found.contains(expected),
            (expected, found) => expected.is_none() && found.is_none(),
        };
        assert!(is_equal, "{} in {place}: {error}", self.name);
    }

    /// Returns the options of a simulator that lets the mouse misread walls.
    fn misread(&self) -> &'static [&'static str] {
        if self.crashes.is_some() { &["--misread", "100%"] } else { &[] }
    }

    fn hangs(&self) -> bool {
        self.ending == "time_limit"
    }

    /// Returns the option that limits the time in s. Only the mouse that hangs reaches its limit, so a
    /// busy machine does not change the verdict on another mouse.
    fn time_limit(&self) -> [&'static str; 2] {
        ["--time-limit", if self.hangs() { "10" } else { "600" }]
    }

    /// Returns true if the states alone show that the mouse has failed.
    fn has_jumped(&self) -> bool {
        self.error.as_ref().is_some_and(|error| error.starts_with("jumped"))
    }

    /// Returns the command of the mouse. `mouse` is the program, and `way` its poses or commands.
    fn command(&self, mouse: &Path, way: &str) -> Vec<String> {
        let program = ["python3".into(), mouse.display().to_string()];
        [&program[..], &[way.into(), self.name.clone()]].concat()
    }
}

fn strs(command: &[String]) -> Vec<&str> {
    command.iter().map(String::as_str).collect()
}

/// Returns a home with the maze and the mice, or `None` without Python.
fn home() -> Option<(Home, Mice, [PathBuf; 2])> {
    let (home, mice): (_, Mice) = (Home::new(), serde_json::from_str(MICE).unwrap());
    home.write("maze.txt", &mice.maze);
    let client = home.write("client.py", include_str!("client.py"));
    let mms = home.write("mms.py", include_str!("mms.py"));
    works("python3", &["--version"]).then_some((home, mice, [client, mms]))
}

#[test]
fn commands_agree_on_each_mouse() {
    let Some((home, Mice { mice, .. }, programs)) = home() else { return };
    let (misreading, others): (Vec<_>, Vec<_>) =
        mice.iter().partition(|mouse| mouse.crashes.is_some());
    let (hanging, others): (Vec<_>, Vec<_>) = others.into_iter().partition(|mouse| mouse.hangs());
    // A mouse that hangs does not change the verdict on a mouse beside it.
    let hanging = [hanging, others[..1].to_vec()].concat();
    for command in ["compare", "contest"] {
        for mice in [&hanging, &others, &misreading] {
            check_command(&home, command, mice, &programs);
        }
    }
}

/// Checks the verdicts of a command on mice that have the same options.
fn check_command(home: &Home, command: &str, mice: &[&Mouse], [client, mms]: &[PathBuf; 2]) {
    let mut arguments = vec![command.into(), "maze.txt".into(), "--json".into()];
    arguments.extend(["--strategies", "none"].map(String::from));
    let options = mice[0].time_limit();
    arguments.extend(options.iter().chain(mice[0].misread()).copied().map(String::from));
    let mut named = Vec::new();
    for &mouse in mice {
        let mut add = |name: String, command: Vec<String>| {
            let quoted: Vec<_> = command.iter().map(|word| format!("'{word}'")).collect();
            arguments.extend(["--mouse".into(), format!("{name}={}", quoted.join(" "))]);
            named.push((name, mouse));
        };
        add(mouse.name.clone(), mouse.command(client, &mouse.poses));
        if let Some(commands) = &mouse.commands {
            add(format!("{} mms", mouse.name), mouse.command(mms, commands));
        }
    }
    let ended = home.run(&strs(&arguments));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let report = ended.json();
    for (name, mouse) in named {
        let verdict = match command {
            "compare" => find(&report, "mouse", &name)["mazes"][0].clone(),
            _ => find(&report["mazes"][0]["entries"], "mouse", &name),
        };
        let kind = if name.ends_with(" mms") { " mms" } else { "" };
        mouse.check(&format!("{command}{kind}"), &verdict);
        if let Some(crashes) = mouse.crashes {
            // A contest counts touches.
            let (key, expected) = match command {
                "compare" => ("crashes", json!(crashes)),
                _ => ("touched", json!(true)),
            };
            assert_eq!(verdict[key], expected, "{name} in {command}: {verdict}");
        }
    }
}

/// Returns the object of a list whose `key` is `name`.
#[track_caller]
fn find(list: &Value, key: &str, name: &str) -> Value {
    list.as_array().unwrap().iter().find(|one| one[key] == name).expect("the mouse").clone()
}

#[test]
fn runs_and_recordings_agree_on_each_mouse() {
    let Some((home, Mice { mice, .. }, [client, _])) = home() else { return };
    thread::scope(|scope| {
        for mouse in &mice {
            scope.spawn(|| check_run(&home, mouse, &client));
        }
    });
}

fn check_run(home: &Home, mouse: &Mouse, client: &Path) {
    let folder = format!("runs-{}", mouse.name);
    let options = ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer", "--json"];
    let record = ["--record", &folder];
    let options = [&options[..], &record, &mouse.time_limit(), mouse.misread()].concat();
    let command = mouse.command(client, &mouse.poses);
    let ended = home.run(&[&options[..], &strs(&command)].concat());
    mouse.check("run", &ended.json());
    let has_finished = mouse.ending == "finished" || mouse.ending == "gave_up";
    let code = if mouse.name == "killed" { 128 + 9 } else { i32::from(!has_finished) };
    assert_eq!(ended.code, Some(code), "{}: {ended:?}", mouse.name);
    let outcome = ended.stderr.lines().last().unwrap();
    let goal = if mouse.goal_reached { "goal reached" } else { "goal not reached" };
    assert!(outcome.contains(&format!("; {goal}, ")), "{outcome}");
    let crashes = mouse.crashes.map(|crashes| format!(", {crashes} crashed movement"));
    assert!(crashes.is_none_or(|crashes| outcome.contains(&crashes)), "{}: {outcome}", mouse.name);
    let text = mouse.sentence(false).or_else(|| mouse.error(false));
    assert!(text.is_none_or(|text| outcome.contains(&text)), "{}: {outcome}", mouse.name);

    let file = recorded(&home.path().join(&folder));
    let replayed = home.run(&["replay", file.to_str().unwrap()]);
    let jump = mouse.error(false).filter(|_| mouse.has_jumped());
    let why = jump.or_else(|| mouse.sentence(false));
    let verdict = why.as_ref().map_or(goal.into(), |why| format!("{goal}: {why}"));
    let is_shown = |line: &str| line.starts_with(&verdict);
    assert!(replayed.stdout.lines().any(is_shown), "{}: {replayed:?}", mouse.name);
    let state = &home.run(&["replay", file.to_str().unwrap(), "--json"]).json()["state"];
    assert_eq!(state["goal_reached"], mouse.goal_reached, "{}", mouse.name);
    assert_eq!(state["cause"]["kind"], json!(mouse.cause), "{}: {state}", mouse.name);
    let error = state["error"].as_str();
    let is_equal = error.zip(why.as_deref()).is_some_and(|(error, why)| error.starts_with(why));
    assert!(is_equal || error.is_none() && why.is_none(), "{}: {error:?}", mouse.name);
}

/// A mouse that drives further each time.
const RANDOM: &str = "import os, sys
file = sys.argv[1]
runs = os.path.getsize(file) if os.path.exists(file) else 0
open(file, 'a').write('x')
for command in ['moveForward', 'turnRight', 'moveForward', 'moveForward'][: 1 + 2 * runs]:
    print(command, flush=True)
    input()
";

#[test]
fn a_mouse_whose_runs_differ_is_random() {
    let Some((home, ..)) = home() else { return };
    let (mouse, file) = (home.write("random.py", RANDOM), home.path().join("runs"));
    let lost = format!("lost=python3 '{}' '{}'", mouse.display(), file.display());
    let command = ["compare", "maze.txt", "--strategies", "none", "--time-limit", "600"];
    let mouse = ["--mouse", &lost];
    let once = home.run(&[&command[..], &mouse, &["--json"]].concat()).json();
    assert_eq!(once[0]["mazes"][0]["random"], json!(null));
    std::fs::remove_file(&file).unwrap();
    let twice = ["--repeat", "2"];
    let report = home.run(&[&command[..], &mouse, &twice, &["--json"]].concat()).json();
    let search = &report[0]["mazes"][0];
    assert_eq!(search["random"], json!({ "runs": [1, 2], "steps": 1 }));
    assert_eq!(search["cause"]["kind"], "gave_up", "of the first run: {search}");
    std::fs::remove_file(&file).unwrap();
    let ended = home.run(&[&command[..], &mouse, &twice].concat());
    let note = "lost is random in 1 maze, such as maze: runs 1 and 2 differ from step 2 on.";
    assert!(ended.stdout.contains(note), "{ended:?}");
}

#[test]
fn runs_in_a_row_show_whether_a_mouse_is_random() {
    let Some((home, ..)) = home() else { return };
    let (mouse, file) = (home.write("random.py", RANDOM), home.path().join("runs"));
    let options = ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer", "--repeat"];
    let command = ["python3", mouse.to_str().unwrap(), file.to_str().unwrap()];
    let ended = home.run(&[&options[..], &["2", "--json"], &command].concat());
    let lines: Vec<Value> =
        ended.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let random: Vec<&Value> = lines.iter().map(|report| &report["random"]).collect();
    assert_eq!(random, [&json!(null), &json!({ "runs": [1, 2], "steps": 1 })]);
    let note = "random.py is random: runs 1 and 2 differ from step 2 on";
    assert!(ended.stderr.contains(note), "{ended:?}");
    // From the fifth run on, the mouse does the same.
    let ended = home.run(&[&options[..], &["3", "--score"], &command].concat());
    assert!(ended.stderr.contains("runs 1 and 3 do not differ"), "{ended:?}");
    assert_eq!(std::fs::read_to_string(file).unwrap(), "xxxxx", "five runs");
}

/// A mouse for mms that waits for the reply to an invalid line.
#[test]
fn a_mouse_that_waits_after_an_invalid_line_says_so() {
    let Some((home, _, [_, mms])) = home() else { return };
    let options = ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer", "--json"];
    let mouse = ["--time-limit", "5", "python3", mms.to_str().unwrap(), "moveForward nonsense", ""];
    let report = home.run(&[&options[..], &mouse].concat()).json();
    let error = "stopped after 5 s: waits for a reply to the invalid line after command 1";
    assert_eq!((&report["error"], &report["cause"]["commands"]), (&json!(error), &json!(1)));
}

#[test]
fn mms_agrees_on_each_mouse() {
    let Some((home, Mice { mice, .. }, [_, mms])) = home() else { return };
    for mouse in &mice {
        let Some(commands) = &mouse.commands else { continue };
        let command = mouse.command(&mms, commands);
        let options = ["run", "--maze", "maze.txt", "--port", "0", "--no-viewer", "--json"];
        let options = [&options[..], &mouse.time_limit(), mouse.misread()].concat();
        let ended = home.run(&[&options[..], &["--"], &strs(&command)].concat());
        let verdict = ended.json();
        mouse.check("run of a mouse for mms", &verdict);
        assert_eq!(verdict["kind"], "mms", "{}", mouse.name);
        let crashes = mouse.crashes.map_or(0, u64::from);
        assert_eq!(verdict["crashes"], json!(crashes), "{}: {verdict}", mouse.name);
    }
}

#[test]
fn a_mouse_that_is_stopped_at_the_goal_has_finished() {
    let Some((home, Mice { mice, .. }, [client, mms])) = home() else { return };
    for mouse in mice.iter().filter(|mouse| mouse.goal_reached) {
        // Whatever the mouse does after it has reached the goal.
        let name = if mouse.has_jumped() { &mouse.name } else { "hangs" };
        let stopped = |program: &Path, way: &str| {
            let command = mouse.command(program, way);
            [&command[..command.len() - 1], &[name.into()]].concat()
        };
        let (client, misread) = (stopped(&client, &mouse.poses), mouse.misread());
        let options = ["--port", "0", "--no-viewer", "--stop-at-goal", "--time-limit", "600"];
        let run = |mouse: &[String]| {
            let options =
                [&["run", "--maze", "maze.txt", "--json"], &options[..], misread].concat();
            home.run(&[&options[..], &strs(mouse)].concat())
        };
        let ended = run(&client);
        assert_eq!(ended.code, Some(0), "{}: {ended:?}", mouse.name);
        assert!(ended.stderr.contains("stopped at the goal; goal reached, "), "{ended:?}");
        let verdict = json!({ "goal_reached": true, "ending": "finished", "error": null });
        let check = |place: &str, found: &Value| {
            for (key, value) in verdict.as_object().unwrap() {
                assert_eq!(&found[key], value, "{} in {place}: {found}", mouse.name);
            }
        };
        check("run", &ended.json());
        let own = format!("one='{}'", client.join("' '"));
        let compare = ["compare", "maze.txt", "--strategies", "none", "--json", "--stop-at-goal"];
        let limit = ["--mouse", &own, "--time-limit", "600"];
        let ended = home.run(&[&compare[..], &limit, misread].concat());
        check("compare", &ended.json()[0]["mazes"][0]);
        if let Some(commands) = &mouse.commands {
            let ended = run(&stopped(&mms, commands));
            assert_eq!(ended.code, Some(0), "{}: {ended:?}", mouse.name);
            check("run of a mouse for mms", &ended.json());
        }
    }
}

#[test]
fn the_page_agrees_on_each_mouse() {
    let Some((home, Mice { mice, .. }, [client, _])) = home() else { return };
    thread::scope(|scope| {
        for mouse in &mice {
            scope.spawn(|| check_page(&home, mouse, &client));
        }
    });
}

fn check_page(home: &Home, mouse: &Mouse, client: &Path) {
    let options = ["run", "--maze", "maze.txt", "--port", "0", "--viewer-port", "0", "--stay"];
    let options = [&options[..], &mouse.time_limit(), mouse.misread()].concat();
    let command = mouse.command(client, &mouse.poses);
    let arguments = [&options[..], &["--"], &strs(&command)].concat();
    let serving = home.serve_until(&arguments, "still serving");
    let page = serving.messages.split_whitespace().find(|word| word.starts_with("http://"));
    let page = page.expect("the address of the page").trim_end_matches(['/', ';', ',']);
    let info = http::get(&format!("{page}/api/sources/live")).json();
    let at = info["states"].as_u64().unwrap() - 1;
    let view = format!("{page}/api/sources/live/moment?run={}&at={at}", info["run"]);
    let view = http::get(&view).json();
    let jump = mouse.error.as_ref().filter(|_| mouse.has_jumped());
    let found = (&view["goal_reached"], &view["error"]);
    assert_eq!(found, (&json!(mouse.goal_reached), &json!(jump)), "{}", mouse.name);
    let status = wait_for("the outcome", || {
        let status = http::first_event(page);
        (!status["mouse_status"]["outcome"].is_null()).then_some(status)
    });
    mouse.check("the page", &status["mouse_status"]["outcome"]);
}
