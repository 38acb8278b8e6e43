//! Robots of the user in the two-run trial: `mmsim trial MAZE -- COMMAND` and `--published`.

use std::ffi::OsStr;
use std::fs;
use std::process::Command;
#[cfg(unix)]
use std::process::Stdio;

use mmsim_tests::shared;
#[cfg(unix)]
use mmsim_tests::{wait_for, wait_for_exit};
use serde_json::Value;

use crate::client;
use crate::harness::mice::{interpreter, python2};
use crate::harness::{Home, Output};

/// Copies the robots with the published interface to a folder of the home folder, whose name has a blank.
fn write_robots(home: &Home) {
    for file in fs::read_dir(client::file("tests/strangers/robots")).unwrap() {
        let file = file.unwrap().path();
        let name = file.file_name().unwrap().to_str().unwrap();
        if file.is_file() {
            home.write(&format!("my robots/{name}"), fs::read(&file).unwrap());
        }
    }
}

/// Returns the path of a copied robot.
fn robot_file(name: &str) -> String {
    format!("my robots/{name}")
}

/// Returns the path of Python 3, or `None` if there is none.
fn python3() -> Option<String> {
    let name = client::python_with("sys")?.get_program().to_str().unwrap().to_string();
    interpreter(&[&[&name, "-c", "import sys; print(sys.executable)"]])
}

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
            (&trial["mouse"], &trial["ending"]),
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
    if python3().is_none() {
        return;
    }
    let home = Home::new();
    write_robots(&home);
    let mazes = maze_folders(&home);
    let mazes: Vec<&str> = mazes.iter().map(String::as_str).collect();
    let file = robot_file("python3.py");
    let published = ["--published", &file];
    let ended = home.run(&[&["trial"], &mazes[..], &published, &["--json"]].concat());
    assert_scores(&ended, "python3.py");
    // With bundled robots in one table. What the robot prints is shown only if it runs alone.
    let bundled = ["--robot", "swing", "--as-published"];
    let ended = home.run(&[&["trial", mazes[0]], &published[..], &bundled].concat());
    let rows = ended.stdout.lines().skip(2).filter_map(|line| line.strip_prefix("  "));
    let robots: Vec<_> = rows.filter_map(|row| row.split_whitespace().next()).collect();
    assert_eq!((robots, &ended.stderr[..]), (vec!["swing-as-published", "python3.py"], ""));
    // Mazes may follow a file after `=`.
    let ended = home.run(&["trial", &format!("--published={file}"), mazes[0]]);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), "a robot for 12\n"));
    let ended = home.run(&[&["trial", mazes[0], "--compare"], &published[..]].concat());
    let robots = ended.stdout.split("\n\n").find(|table| table.starts_with("Robots ")).unwrap();
    assert!(robots.lines().any(|line| line.starts_with("python3.py ") && line.contains(" = ")));
}

#[test]
fn robots_find_the_words_after_their_file_and_the_files_beside_it() {
    if python3().is_none() {
        return;
    }
    let home = Home::new();
    write_robots(&home);
    let (word, data) = (robot_file("word.py"), robot_file("data_file.py"));
    let left = ["--published", &word, "left", "--published", &word, "right", "more"];
    let arguments = [&["trial", "orchard", "--json"], &left[..], &["--published", &data]].concat();
    let ended = home.run(&arguments);
    assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
    let report = ended.json();
    let trials = report.as_array().unwrap().iter();
    let names: Vec<_> = trials.clone().map(|trial| trial["mouse"].as_str().unwrap()).collect();
    assert_eq!(names, ["word.py left", "word.py right more", "data_file.py"]);
    // The words change what the robot does.
    let scores: Vec<_> = trials.map(|trial| &trial["score"]).collect();
    assert!(scores.iter().all(|score| score.is_f64()) && scores[0] != scores[1], "{scores:?}");
    let ended = home.run(&["trial", "orchard", "--json", "--published", &word]);
    let error = ended.json()[0]["error"].as_str().unwrap().to_string();
    assert_eq!(error, "step 1: exited with code 1: IndexError: list index out of range");
}

#[test]
fn robots_in_python_2_run_in_python_2() {
    let Some(python2) = python2() else { return };
    let home = Home::new();
    write_robots(&home);
    home.write("my robots/broken.py", "print 'Python 2'\nimport no_such_module\n");
    for name in ["python2_print.py", "python2_names.py", "python2_module.py"] {
        let ended = home.run(&["trial", "orchard", "--json", "--published", &robot_file(name)]);
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
        assert_eq!(ended.json()[0]["ending"], "scored");
        let file = robot_file(name);
        let mut command = home.command(&["trial", "orchard", "--published", &file]);
        let ended = Output::new(command.args(["--python", &python2]).env("PATH", ""));
        assert_eq!(ended.code, Some(0), "{ended:?}");
    }
    // A missing module counts less than syntax.
    let ended = home.run(&["trial", "orchard", "--json", "--published", &robot_file("broken.py")]);
    let error = ended.json()[0]["error"].as_str().unwrap().to_string();
    assert_eq!(error, "step 1: exited with code 1: ImportError: No module named no_such_module");
}

#[test]
fn python_checks_a_robot_without_running_anything() {
    let Some(python3) = python3() else { return };
    let home = Home::new();
    let robot = "class Robot(object):\n    def __init__(self, maze_dim): pass\n    \
                 def next_move(self, sensors): return 0, 0\n";
    let check = |name: &str, start: &str| {
        home.write(&format!("robots/{name}.py"), format!("{start}\n{robot}"));
        let file = client::file("crates/mouse/src/check_robot.py");
        let mut command = Command::new(&python3);
        command.args(["-c", &fs::read_to_string(file).unwrap(), &format!("{name}.py")]);
        let ended = Output::new(command.current_dir(home.path().join("robots")));
        assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{ended:?}");
        ended.stdout.trim_end().split_once(' ').unwrap().1.to_string()
    };
    // Modules beside the robot that Python imports itself, and one that warns.
    for module in ["ast", "os", "builtins", "linecache", "tokenize", "re", "warnings", "traceback"]
    {
        home.write(&format!("robots/{module}.py"), "open('executed', 'w')\n");
    }
    assert_eq!(check("warned", "WARNED = '\\d' is 1\nimport re, linecache"), "0");
    assert!(!home.path().join("robots/executed").exists());
    // A package, a module that is missing, and more terms than Python compiles.
    home.write("robots/package/__init__.py", "");
    assert_eq!(check("packages", "import package\nimport no_such_module"), "1");
    assert_eq!(check("long", &format!("x = 1{}", "+1".repeat(9000))), "0");
    // A robot never runs as the program, and may not call its functions.
    home.write("robots/tester.py", "print 'Python 2'\n");
    assert_eq!(check("main", "if __name__ == '__main__':\n    import tester"), "0");
    assert_eq!(check("late", "def test():\n    import tester"), "1");
    assert!(check("early", "import tester").starts_with("1000 tester.py, line 1: "));
}

#[test]
fn a_missing_python_is_reported_before_the_trial() {
    let home = Home::new();
    write_robots(&home);
    let file = robot_file("python2_print.py");
    let run = |path: &str| {
        let mut command = home.command(&["trial", "orchard", "--published", &file]);
        let ended = Output::new(command.env("PATH", path));
        assert_eq!((ended.code, &ended.stdout[..]), (Some(1), ""), "{ended:?}");
        ended.stderr
    };
    // Windows also finds its launcher `py` if the PATH is empty.
    let error = run("");
    assert!(error.starts_with("mmsim: cannot run my robots/python2_print.py: "), "{error}");
    assert!(error.contains("Python 2 ") && error.lines().count() == 1, "{error}");
    #[cfg(unix)]
    if let Some(python3) = python3() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        // A python2 of pyenv, if no version is selected.
        let shim =
            home.write("bin/python2", "#!/bin/sh\necho pyenv: command not found >&2\nexit 127\n");
        fs::set_permissions(&shim, fs::Permissions::from_mode(0o755)).unwrap();
        symlink(python3, home.path().join("bin/python3")).unwrap();
        let error = run(home.path().join("bin").to_str().unwrap());
        let place = "python2_print.py: it is not Python 3 (python2_print.py, line 8: Missing paren";
        assert!(error.contains(place), "{error}");
        let step =
            "), and no Python 2 was found (install it, or give its path with --python EXE)\n";
        assert!(error.ends_with(step) && error.lines().count() == 1, "{error}");
    }
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
    let Some(python) = python3() else { return };
    let home = Home::new();
    home.write("oblong.txt", "o---o---o\n| S   G |\no---o---o\n");
    let run = |maze: &str, robot: &str| {
        home.write("robot.py", robot);
        let published = ["--published", "robot.py", "--python", &python];
        let ended = home.run(&[&["trial", maze, "--json"], &published[..]].concat());
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
