//! Runs the command as its users do.
#![allow(dead_code, unreachable_pub, missing_docs)] // each test file uses its part

pub mod noise;

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{self, Receiver};
use std::{fs, thread};

use mmsim_tests::{PATIENCE, output, wait_for_exit, within};

/// A folder that is the user's home while a test runs, with files of its own.
pub struct Home(tempfile::TempDir);

impl Home {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, creating the folders it is in.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, content).unwrap();
        path
    }

    /// The command, with this folder as home and as current folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = mmsim();
        command
            .args(arguments)
            .current_dir(self.path())
            .env("HOME", self.path())
            .env("USERPROFILE", self.path())
            .env("NO_PROXY", "127.0.0.1")
            .env_remove("RUST_LOG")
            .env_remove("CARGO_MANIFEST_DIR")
            .env_remove("COLUMNS");
        command
    }

    /// Runs the command to its end.
    pub fn run(&self, arguments: &[&str]) -> Ended {
        let output = output(&mut self.command(arguments));
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().replace("\r\n", "\n");
        Ended {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// The same for a server, without the page to watch unless the arguments say something of it.
    pub fn server(&self, arguments: &[&str]) -> Command {
        let mut command = self.command(arguments);
        if !arguments.iter().any(|argument| argument.contains("viewer")) {
            command.arg("--no-viewer");
        }
        command
    }

    /// Starts the command as a server and waits until it says where it serves.
    pub fn serve(&self, arguments: &[&str]) -> Serving {
        self.serve_until(arguments, "tcp://")
    }

    /// Starts the command as a server and waits until it has said this.
    pub fn serve_until(&self, arguments: &[&str], text: &str) -> Serving {
        Serving::start(self.server(arguments), text)
    }

    /// Starts the command as a server and closes its stderr once it has said where it serves.
    pub fn serve_unheard(&self, arguments: &[&str]) -> Serving {
        let mut child = self.server(arguments).stderr(Stdio::piped()).spawn().unwrap();
        let (stderr, mut serving) = (child.stderr.take().unwrap(), Serving::new(child));
        serving.has_said(read_until(stderr, "tcp://").1);
        serving
    }
}

/// The same command under this limit of the shell, such as `-v 1000`.
#[cfg(unix)]
pub fn limited(command: &Command, limit: &str) -> Command {
    let mut limited = Command::new("bash");
    limited.args(["-c", &format!("ulimit {limit}; exec \"$0\" \"$@\"")]);
    limited.arg(command.get_program()).args(command.get_args());
    limited.current_dir(command.get_current_dir().unwrap());
    for (key, value) in command.get_envs() {
        match value {
            Some(value) => limited.env(key, value),
            None => limited.env_remove(key),
        };
    }
    limited
}

/// The command, without signals that these tests were started to ignore, as by `nohup`: it would
/// ignore them, too.
fn mmsim() -> Command {
    let mmsim = env!("CARGO_BIN_EXE_mmsim");
    if !IS_IGNORING.get_or_init(is_ignoring) {
        return Command::new(mmsim);
    }
    let mut command = Command::new("env");
    command.args([&format!("--default-signal={SIGNALS}"), mmsim]);
    command
}

/// The signals that end a command.
pub const SIGNALS: &str = "HUP,INT,TERM";

static IS_IGNORING: OnceLock<bool> = OnceLock::new();

/// Whether this process ignores one of the signals, of which signal n is bit n - 1.
fn is_ignoring() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(0) & (1 | 1 << 1 | 1 << 14) != 0
}

/// The newest recording in a folder, beside which the server may be packing another.
#[track_caller]
pub fn recorded(folder: &Path) -> PathBuf {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_recording = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "mcap");
    files.filter(is_recording).max().expect("a recording")
}

/// Reads until this was said; gives what was said by then.
#[track_caller]
pub fn read_until(stderr: ChildStderr, text: &str) -> (BufReader<ChildStderr>, String) {
    let expected = text.to_string();
    within(&format!("the command to say {text:?}"), move || {
        let (mut stderr, mut said) = (BufReader::new(stderr), String::new());
        while !said.contains(&expected) {
            assert_ne!(stderr.read_line(&mut said).unwrap(), 0, "it has ended: {said}");
        }
        (stderr, said)
    })
}

/// Where it serves; nothing for a command that does not.
fn address(said: &str) -> String {
    let rest = said.split("tcp://").nth(1).and_then(|rest| rest.split(';').next());
    rest.map(|rest| format!("tcp://{rest}")).unwrap_or_default()
}

/// How a command ended.
#[derive(Debug)]
pub struct Ended {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }
}

/// A server in a process of its own, killed at the end of the test.
pub struct Serving {
    child: Child,
    pub address: String,
    /// What it said until it served.
    pub said: String,
    rest: Option<Receiver<String>>,
}

impl Serving {
    fn new(child: Child) -> Self {
        Self { child, address: String::new(), said: String::new(), rest: None }
    }

    fn has_said(&mut self, said: String) {
        (self.address, self.said) = (address(&said), said);
    }

    /// Starts a command that serves and waits until it has said this.
    pub fn start(mut command: Command, text: &str) -> Self {
        let pipes = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = pipes.spawn().unwrap();
        // Ends with this, even if it does not say that.
        let (stderr, mut serving) = (child.stderr.take().unwrap(), Self::new(child));
        let (mut stderr, said) = read_until(stderr, text);
        serving.has_said(said);
        let (send, rest) = mpsc::channel();
        serving.rest = Some(rest);
        thread::spawn(move || {
            let mut rest = String::new();
            stderr.read_to_string(&mut rest).unwrap();
            let _ = send.send(rest);
        });
        serving
    }

    /// Kills it, as `kill -9` does.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
    }

    /// The number of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Waits until it has ended; gives its exit status and all that it said.
    pub fn wait(&mut self) -> (ExitStatus, String) {
        let status = wait_for_exit(&mut self.child);
        let rest = self.rest.take().unwrap().recv_timeout(PATIENCE).expect("its stderr closes");
        (status, self.said.clone() + &rest)
    }

    pub fn stdout(&mut self) -> String {
        let mut stdout = self.child.stdout.take().unwrap();
        within("the end of stdout", move || {
            let mut text = String::new();
            stdout.read_to_string(&mut text).unwrap();
            text
        })
    }

    /// Sends a signal, by its name without SIG.
    #[cfg(unix)]
    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let kill = format!("kill -s {name} {id}");
        assert!(output(Command::new("sh").args(["-c", &kill])).status.success());
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
