//! No mouse and none of its descendants outlives the command, or its own search.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use mmsim_maze::WyRand;
use mmsim_tests::{output, wait_for, wait_for_exit};

use crate::force;
use crate::harness::mice::works;
use crate::harness::{Home, Serving};

const MAZE: &str = "o---o---o\n| S   G |\no---o---o\n";

/// A mouse that starts [`DESCENDANTS`] processes, which ignore SIGTERM. Some have a session of their
/// own, and the parents of some have exited. With an argument, the mouse exits when all are running.
const TREE: &str = "
import os, signal, sys, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
read, write = os.pipe()
for branch in range(20):
    if os.fork() == 0:
        if branch % 2:
            os.setsid()
        if branch % 3 == 0 and os.fork():
            os._exit(0)
        for leaf in range(9):
            if os.fork() == 0:
                if leaf % 2:
                    os.setsid()
                break
        os.write(write, b'x')
        time.sleep(1000)
        os._exit(0)
for process in range(200):
    os.read(read, 1)
if len(sys.argv) == 1:
    time.sleep(1000)
";

/// A mouse that starts a tree of processes with its arguments: a seed, the depth and the width. Some
/// processes ignore signals, have a session of their own, or have lost their parent, which has exited.
/// With a fourth argument, the mouse exits when all are running.
const RANDOM_TREE: &str = "
import os, random, signal, sys, time
depth, width = map(int, sys.argv[2:4])
read, write = os.pipe()
def grow(path):
    rng = random.Random(f'{sys.argv[1]} {path}')
    if path and rng.random() < 0.3:
        os.setsid()
    for name in rng.sample(['SIGTERM', 'SIGINT', 'SIGHUP', 'SIGPIPE'], rng.randrange(5)):
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    for child in range(width if len(path) < depth else 0):
        is_orphan = rng.random() < 0.3
        if os.fork() == 0:
            if is_orphan and os.fork():
                os._exit(0)
            grow(path + str(child))
            time.sleep(1000)
            os._exit(0)
    os.write(write, b'x')
grow('')
for process in range(sum(width**level for level in range(depth + 1))):
    os.read(read, 1)
if len(sys.argv) == 4:
    time.sleep(1000)
";

/// The number of descendants of [`TREE`].
const DESCENDANTS: usize = 200;

/// The arguments of the commands that run a program as a mouse.
const PAGE: &[&str] = &["run", "--port", "0", "--viewer-port", "0", "--", "python3"];
const RUN: &[&str] = &["run", "--port", "0", "--no-viewer", "--", "python3"];
const CLIENT: &[&str] = &["run", "--as", "client", "--port", "0", "--no-viewer", "--", "python3"];
const MMS: &[&str] = &["run", "--as", "mms", "--port", "0", "--no-viewer", "--", "python3"];
const TRIAL: &[&str] = &["trial", "mazes", "--answer-limit", "600", "--", "python3"];
const COMPARE: &[&str] = &["compare", "--strategies", "none", "--time-limit", "600"];
const CONTEST: &[&str] = &["contest", "--time-limit", "600"];

/// Writes a mouse and a maze, and returns a command whose processes have this folder in their command
/// lines.
fn command(home: &Home, arguments: &[&str], mouse: &str, options: &[&str]) -> Command {
    let path = home.write("mouse.py", mouse);
    home.write("mazes/a.txt", MAZE);
    let mut command = home.command(arguments);
    if arguments.contains(&"--") {
        command.arg(path).args(options);
    } else {
        let mouse = format!("m=python3 '{}' {}", path.display(), options.join(" "));
        command.args(["--mouse", &mouse, "mazes"]);
    }
    command
}

fn has_python() -> bool {
    works("python3", &["--version"])
}

/// Returns the processes whose command lines contain a path. Zombies have no command line.
fn processes(path: &Path) -> Vec<String> {
    let path = path.to_str().unwrap();
    let lines = fs::read_dir("/proc").unwrap().flatten().map(|entry| entry.path().join("cmdline"));
    let lines = lines.filter_map(|file| fs::read(file).ok());
    let lines = lines.map(|line| String::from_utf8_lossy(&line).replace('\0', " "));
    lines.filter(|line| line.contains(path)).collect()
}

fn wait_for_processes(home: &Home, count: usize) {
    let started = || (processes(home.path()).len() >= count).then_some(());
    wait_for(&format!("{count} processes"), started);
}

fn wait_for_end(home: &Home) {
    wait_for("the end of all processes", || processes(home.path()).is_empty().then_some(()));
}

fn spawn(mut command: Command) -> Child {
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

#[test]
fn none_outlives_a_killed_command() {
    if !has_python() {
        return;
    }
    for arguments in [RUN, CLIENT, MMS, TRIAL, COMPARE, CONTEST] {
        let home = Home::new();
        let mut child = spawn(command(&home, arguments, TREE, &[]));
        wait_for_processes(&home, DESCENDANTS);
        child.kill().unwrap();
        wait_for_exit(&mut child);
        wait_for_end(&home);
    }
}

/// The command is killed or stopped while the tree grows, or the mouse exits.
#[test]
fn none_of_a_random_tree_outlives_its_end() {
    if !has_python() {
        return;
    }
    let commands = [PAGE, RUN, CLIENT, MMS, TRIAL, COMPARE, CONTEST];
    for case in 0..12 * force() {
        let mut rng = WyRand::new(case as u64);
        let [depth, width] = [1 + rng.below(3), 1 + rng.below(4)];
        let all = (0..=depth).map(|level| width.pow(level)).sum::<u32>() as usize;
        let ends = ["KILL", "KILL", "TERM", "INT", "exit"];
        let (arguments, end) = (commands[case % commands.len()], ends[rng.index(ends.len())]);
        let mut options = vec![case.to_string(), depth.to_string(), width.to_string()];
        options.extend((end == "exit").then(|| end.into()));
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        println!("case {case}: {} with a tree of {options:?}, {end}", arguments[0]);
        let home = Home::new();
        let mut child = spawn(command(&home, arguments, RANDOM_TREE, &options));
        if end != "exit" {
            // The command line of the command contains the path, too.
            wait_for_processes(&home, 1 + rng.index(all) + 1);
            let kill = ["-s", end, &child.id().to_string()];
            assert!(output(Command::new("kill").args(kill)).status.success());
        }
        wait_for_exit(&mut child);
        wait_for_end(&home);
    }
}

#[test]
fn none_of_300_parallel_mice_outlives_a_killed_command() {
    const JOBS: usize = 300;
    let home = Home::new();
    (0..JOBS).for_each(|index| drop(home.write(&format!("mazes/{index}.txt"), MAZE)));
    let sleep = output(Command::new("sh").args(["-c", "command -v sleep"])).stdout;
    let sleep = String::from_utf8(sleep).unwrap();
    let link = home.path().join("sleep");
    std::os::unix::fs::symlink(sleep.trim(), &link).unwrap();
    let mouse = format!("m={} 1000", link.display());
    let jobs = JOBS.to_string();
    let mut compare = home.command(COMPARE);
    compare.args(["mazes", "--jobs", &jobs, "--mouse", &mouse]);
    let mut child = spawn(compare);
    wait_for("all mice", || {
        let is_mouse = |line: &&String| line.starts_with(link.to_str().unwrap());
        (processes(home.path()).iter().filter(is_mouse).count() == JOBS).then_some(())
    });
    child.kill().unwrap();
    wait_for_exit(&mut child);
    wait_for_end(&home);
}

#[test]
fn none_outlives_an_interrupted_run() {
    if !has_python() {
        return;
    }
    let home = Home::new();
    let mut serving = Serving::start(command(&home, RUN, TREE, &[]), "tcp://");
    wait_for_processes(&home, DESCENDANTS);
    serving.signal("INT");
    assert_eq!(serving.wait().0.code(), Some(130));
    assert_eq!(processes(home.path()), [""; 0]);
}

#[test]
fn none_outlives_its_own_search() {
    if !has_python() {
        return;
    }
    let home = Home::new();
    // Each mouse looks for processes of the previous one, and adds their numbers to a file.
    let look = "
import glob
mine = open('/proc/self/cmdline').read()
def line(path):
    try:
        return open(path).read()
    except OSError:
        return ''
found = sum(line(path) == mine for path in glob.glob('/proc/[0-9]*/cmdline'))
open('found', 'a').write(f'{found}\\n')
";
    let mouse = look.to_string() + TREE;
    (0..3).for_each(|index| drop(home.write(&format!("mazes/{index}.txt"), MAZE)));
    let mut compare = command(&home, COMPARE, &mouse, &["exit"]);
    let ended = output(compare.args(["--jobs", "1"]));
    assert!(ended.status.success(), "{ended:?}");
    assert_eq!(fs::read_to_string(home.path().join("found")).unwrap(), "1\n".repeat(4));
    assert_eq!(processes(home.path()), [""; 0]);
}

#[test]
fn none_outlives_its_guard() {
    if !has_python() {
        return;
    }
    let home = Home::new();
    let kill = "import os, time\nif os.fork():\n    os.kill(os.getppid(), 9)\ntime.sleep(1000)\n";
    let ended = output(&mut command(&home, MMS, kill, &[]));
    let messages = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{messages}");
    assert!(messages.contains("its guard process has ended"), "{messages}");
    wait_for_end(&home);
}

#[test]
fn mice_get_their_streams_and_no_other_files() {
    let home = Home::new();
    let list = ["sh", "-c", "ls /proc/self/fd >&2"];
    let direct = output(Command::new(list[0]).args(&list[1..]).stdin(Stdio::null()));
    let guarded = home.run(&[&MMS[..MMS.len() - 1], &list].concat());
    let direct = String::from_utf8(direct.stderr).unwrap();
    assert!(guarded.stderr.contains(&format!("\n{direct}mouse ")), "{guarded:?}, {direct}");
}
