//! Robots of the user in the two-run trial: `mmsim trial MAZE -- COMMAND` and `--published`.

use std::ffi::OsStr;
#[cfg(unix)]
use std::fs;
#[cfg(unix)]
use std::process::{Command, Stdio};

use mmsim_tests::shared;
#[cfg(unix)]
use mmsim_tests::{wait_for, wait_for_exit};
use serde_json::Value;

use crate::client;
use crate::harness::{Home, Output};

/// A robot for the published tester, which goes where it has been least often.
const PUBLISHED: &str = r"
import random

class Robot(object):
    def __init__(self, maze_dim):
        self.location, self.heading = [0, 0], 'up'
        self.maze_dim, self.racing = maze_dim, False
        self.visits, self.exits = {}, {}
        print('a robot for', maze_dim)

    def next_move(self, sensors):
        headings = ['up', 'right', 'down', 'left']
        steps = {'up': (0, 1), 'right': (1, 0), 'down': (0, -1), 'left': (-1, 0)}
        here, middle = tuple(self.location), self.maze_dim // 2
        if not self.racing and all(side in (middle - 1, middle) for side in here):
            self.location, self.heading, self.racing = [0, 0], 'up', True
            return 'Reset', 'Reset'
        self.visits[here] = self.visits.get(here, 0) + 1
        choices = []
        for rotation, seen in zip((-90, 0, 90), sensors):
            heading = headings[(headings.index(self.heading) + rotation // 90) % 4]
            beyond = (here[0] + steps[heading][0], here[1] + steps[heading][1])
            if seen > 0 and (not self.racing or self.exits[here] == heading):
                choices.append((self.visits.get(beyond, 0), abs(rotation), rotation, heading, beyond))
        if not choices:
            self.heading = headings[(headings.index(self.heading) + 1) % 4]
            return 90, 0
        _, _, rotation, self.heading, beyond = min(choices)
        self.exits[here], self.location = self.heading, list(beyond)
        return rotation, 1.0
";

/// Returns the folders with mazes of the trial: the bundled ones, and the published ones if they are
/// available.
fn maze_folders(home: &Home) -> Vec<String> {
    let bundled = home.run(&["mazes", "fetch", "--from", "bundled", "fetched"]);
    assert_eq!(bundled.code, Some(0), "{bundled:?}");
    let names = ["12-orchard", "12-wrong-turn", "14-terraces", "16-citadel"];
    let bundled = names.map(|name| format!("fetched/fetched/mmsim/trial-{name}.txt"));
    let published = shared("mazes/trial").map(|folder| folder.display().to_string());
    bundled.into_iter().chain(published).collect()
}

/// Runs `mmsim trial`.
fn trial(home: &Home, arguments: &[&str], robot: &[&OsStr]) -> Output {
    let mut command = home.command(&[&["trial"], arguments].concat());
    command.arg("--").args(robot).env("PYTHONDONTWRITEBYTECODE", "1");
    let ended = mmsim_tests::output(&mut command);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Output { code: ended.status.code(), stdout: text(ended.stdout), stderr: text(ended.stderr) }
}

fn assert_scores(ended: &Output, name: &str) {
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
    let report = ended.json();
    let trials = report.as_array().unwrap();
    assert!(trials.len() >= 4);
    for trial in trials {
        assert_eq!(
            (&trial["robot"], &trial["ending"]),
            (&name.into(), &"scored".into()),
            "{trial}"
        );
        assert!(trial["race_steps"].as_u64() >= trial["race_optimum"].as_u64(), "{trial}");
    }
}

#[test]
fn the_example_robots_score_in_each_maze_of_the_trial() {
    let home = Home::new();
    let mazes = maze_folders(&home);
    let arguments: Vec<&str> = mazes.iter().map(String::as_str).chain(["--json"]).collect();
    if let Some(python) = client::python() {
        let file = client::file("examples/python/trial_robot.py");
        let robot = [python.get_program(), file.as_os_str()];
        assert_scores(&trial(&home, &arguments, &robot), "trial_robot.py");
    }
    if let Some(program) = client::c_program("examples/c/trial_robot.c", &home) {
        assert_scores(&trial(&home, &arguments, &[program.as_os_str()]), "built");
    }
}

#[test]
fn a_robot_with_the_published_interface_scores_and_is_compared() {
    if client::python().is_none() {
        return;
    }
    let home = Home::new();
    home.write("robots/robot.py", PUBLISHED);
    let mazes = maze_folders(&home);
    let mazes: Vec<&str> = mazes.iter().map(String::as_str).collect();
    let published = ["--published", "robots/robot.py"];
    let ended = home.run(&[&["trial"], &mazes[..], &published, &["--json"]].concat());
    assert_scores(&ended, "robot.py");
    // With bundled robots in one table. What the robot prints is shown only if it runs alone.
    let bundled = ["--robot", "swing", "--as-published"];
    let ended = home.run(&[&["trial", mazes[0]], &published[..], &bundled].concat());
    let robots: Vec<_> =
        ended.stdout.lines().skip(1).filter_map(|line| line.split_whitespace().nth(1)).collect();
    assert_eq!((robots, &ended.stderr[..]), (vec!["swing-as-published", "robot.py"], ""));
    let ended = home.run(&[&["trial", mazes[0]], &published[..]].concat());
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), "a robot for 12\n"));
    let ended = home.run(&[&["trial", mazes[0], "--compare"], &published[..]].concat());
    let robots = ended.stdout.split("\n\n").find(|table| table.starts_with("Robots ")).unwrap();
    assert!(robots.lines().any(|line| line.starts_with("robot.py ") && line.contains(" = ")));
}

/// Returns the error of a robot in a small maze, which must fail.
fn error(home: &Home, options: &[&str], robot: &[&str]) -> String {
    let robot: Vec<&OsStr> = robot.iter().map(OsStr::new).collect();
    let ended = trial(home, &[&["training-first-steps", "--json"], options].concat(), &robot);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(1), ""), "{ended:?}");
    let report: Value = ended.json();
    assert_eq!((&report[0]["ending"], &report[0]["score"]), (&"failed".into(), &Value::Null));
    report[0]["error"].as_str().unwrap().to_string()
}

#[test]
fn robots_that_fail_are_reported_with_the_step() {
    let Some(python) = client::python() else { return };
    let python = python.get_program().to_str().unwrap();
    let home = Home::new();
    let run = |program: &str| error(&home, &["--answer-limit", "600"], &[python, "-c", program]);
    assert_eq!(
        run("print('0 1')\nprint('hello, world')\ninput(); input(); input()"),
        "step 2: expected a rotation and a movement, or reset, found \"hello, world\""
    );
    assert_eq!(
        run("input(); input(); print('0 1', flush=True); raise ValueError('no idea')"),
        "step 2: exited with code 1: ValueError: no idea"
    );
    assert_eq!(run("pass"), "step 1: exited with code 0");
    assert!(run("while True: print('x' * 9999)").contains("found a longer line that starts with "));
    assert_eq!(
        run("import os\nos.write(1, b'\\xff\\n'); input(); input()"),
        "step 1: expected a rotation and a movement, or reset, found \"\\xff\""
    );
    let hangs = "input(); input(); print('0 1', flush=True)\nwhile True: pass";
    let late = error(&home, &["--answer-limit", "0.5"], &[python, "-c", hangs]);
    // A slow machine may take longer than the limit to start Python.
    assert!(late.ends_with(": no answer within 0.5 s"), "{late}");
    let missing = error(&home, &[], &["./no-such-robot"]);
    assert!(missing.starts_with("step 1: cannot start "), "{missing}");
}

#[test]
fn robots_with_the_published_interface_fail_as_in_the_published_tester() {
    if client::python().is_none() {
        return;
    }
    let home = Home::new();
    home.write("oblong.txt", "o---o---o\n| S   G |\no---o---o\n");
    let run = |maze: &str, robot: &str| {
        home.write("robot.py", robot);
        let ended = home.run(&["trial", maze, "--published", "robot.py", "--json"]);
        ended.json()[0]["error"].as_str().map(str::to_string)
    };
    let class = |body: &str| {
        format!(
            "class Robot:\n  def __init__(self, maze_dim): pass\n  def next_move(self, sensors): {body}\n"
        )
    };
    for (body, expected) in [
        ("return None", "TypeError: cannot unpack non-iterable NoneType object"),
        ("return 0, 'far'", "TypeError: bad operand type for abs(): 'str'"),
        ("return 1 // 0, 0", "ZeroDivisionError: "),
    ] {
        let error = run("training-first-steps", &class(body)).unwrap();
        assert!(
            error.starts_with("step 1: exited with code 1: ") && error.contains(expected),
            "{error}"
        );
    }
    // Output of every kind goes to stderr, and the module has its name.
    let noisy = "\
from __future__ import annotations
import os, pickle
class Node: pass
class Robot:
  def __init__(self, maze_dim): pickle.dumps(Node())
  def next_move(self, sensors):
    print('a'); os.system('echo b'); os.write(1, b'c\\n')
    return 90, 10 ** 25
";
    assert_eq!(run("training-first-steps", noisy), None);
    // An invalid rotation counts as none, and a reset needs both words.
    assert_eq!(run("training-first-steps", &class("return 'Reset', 0")), None);
    let error = run("training-first-steps", "print 'Python 2'\n").unwrap();
    assert!(error.contains("SyntaxError"), "{error}");
    let error = run("training-first-steps", "robot = 1\n").unwrap();
    assert!(error.contains("AttributeError: module 'robot' has no attribute 'Robot'"), "{error}");
    let error = run("oblong.txt", &class("return 0, 0")).unwrap();
    assert!(error.ends_with("the published interface has only square mazes, found 2x1"), "{error}");
    let ended = home.run(&["trial", "oblong.txt", "--published", "absent.py"]);
    assert_eq!(ended.code, Some(2), "{ended:?}");
    assert!(ended.stderr.contains("--published: absent.py is not a file"), "{ended:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_kills_the_robots() {
    let robot = "echo $$ > new && mv new pid; while :; do :; done";
    let serve = ["--serve", "--port", "0", "--viewer-port", "0"];
    for (options, code) in [(&[][..], 130), (&serve, 0), (&["--serve", "--port", "0", "--once"], 0)]
    {
        let home = Home::new();
        let trial = ["trial", "training-first-steps", "--answer-limit", "600"];
        let command = ["--", "sh", "-c", robot];
        let arguments = [&trial[..], options, &command].concat();
        let pipes = |command: &mut Command| {
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        };
        let mut child = pipes(&mut home.command(&arguments));
        let pid = wait_for("the robot", || fs::read_to_string(home.path().join("pid")).ok());
        let kill = |signal: &str, id: &str| {
            let mut kill = Command::new("kill");
            kill.args([signal, id.trim()]).stderr(Stdio::null()).status().unwrap().success()
        };
        assert!(kill("-INT", &child.id().to_string()));
        assert_eq!(wait_for_exit(&mut child).code(), Some(code), "{options:?}");
        wait_for("the end of the robot", || (!kill("-0", &pid)).then_some(()));
    }
}

#[cfg(unix)]
#[test]
fn a_child_process_of_a_dead_robot_does_not_delay_its_report() {
    let home = Home::new();
    let robot = ["sh", "-c", "sleep 600 & echo no idea >&2; exit 7"];
    let found = error(&home, &["--answer-limit", "600"], &robot);
    assert_eq!(found, "step 1: exited with code 7: no idea");
}
