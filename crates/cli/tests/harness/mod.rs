//! Helpers for tests that run the `mmsim` command.
#![allow(dead_code, unreachable_pub, missing_docs)] // each test file uses its part

pub mod mice;
pub mod noise;
#[cfg(not(all(windows, target_env = "gnu")))] // needs a server of libzmq
pub mod wrong_server;

use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{self, Receiver};
use std::{fs, thread};

use mmsim_protocol::DEFAULT_PORT;
use mmsim_recording::Recording;
use mmsim_tests::{TIMEOUT, output, wait_for, wait_for_exit, within};
use serde_json::Value;

/// A temporary home folder for a test.
pub struct Home(tempfile::TempDir);

impl Home {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, creating missing parent folders.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, content).unwrap();
        path
    }

    /// Returns the command with this folder as home and working directory.
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

    /// Runs the command to completion.
    pub fn run(&self, arguments: &[&str]) -> Output {
        Output::new(&mut self.command(arguments))
    }

    /// Returns the command that starts a server. Disables the viewer page unless an argument
    /// contains `viewer`.
    pub fn server(&self, arguments: &[&str]) -> Command {
        let mut command = self.command(arguments);
        if !arguments.iter().any(|argument| argument.contains("viewer")) {
            command.arg("--no-viewer");
        }
        command
    }

    /// Starts a server and waits until it reports its address.
    pub fn serve(&self, arguments: &[&str]) -> Serving {
        self.serve_until(arguments, "tcp://")
    }

    /// Starts a server and waits until it prints `text` to stderr.
    pub fn serve_until(&self, arguments: &[&str], text: &str) -> Serving {
        Serving::start(self.server(arguments), text)
    }

    /// Starts a server and closes its stderr once it has reported its address.
    pub fn serve_unheard(&self, arguments: &[&str]) -> Serving {
        let mut child = self.server(arguments).stderr(Stdio::piped()).spawn().unwrap();
        let (stderr, mut serving) = (child.stderr.take().unwrap(), Serving::new(child));
        serving.set_messages(read_until(stderr, "tcp://").1);
        serving
    }
}

/// Returns the help of a command, whose words are separated by spaces.
pub fn help(home: &Home, command: &str) -> String {
    let words: Vec<&str> = ["help"].into_iter().chain(command.split_whitespace()).collect();
    home.run(&words).stdout
}

/// Returns the words of all commands.
pub fn commands(home: &Home) -> Vec<String> {
    let mut found = Vec::new();
    for parent in ["", "mazes "] {
        let help = help(home, parent);
        let (_, listed) = help.split_once("Commands:\n").unwrap();
        let listed = listed.lines().take_while(|line| !line.is_empty());
        let names = listed.filter(|line| !line.starts_with("   "));
        let names = names.filter_map(|line| line.split_whitespace().next());
        found.extend(names.map(|name| format!("{parent}{name}")));
    }
    found
}

/// Returns the command with a limit set by `ulimit`, such as `-v 1000`.
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

/// Returns the command with default signal handling. Otherwise the command would ignore the signals
/// that the test process ignores, such as SIGHUP under `nohup`.
fn mmsim() -> Command {
    let mmsim = env!("CARGO_BIN_EXE_mmsim");
    if !IS_IGNORING.get_or_init(is_ignoring) {
        return Command::new(mmsim);
    }
    let mut command = Command::new("/usr/bin/env");
    command.args([&format!("--default-signal={SIGNALS}"), mmsim]);
    command
}

/// The signals that stop a command.
pub const SIGNALS: &str = "HUP,INT,TERM";

static IS_IGNORING: OnceLock<bool> = OnceLock::new();

/// Returns true if this process ignores one of the [`SIGNALS`]. Bit n - 1 of the mask stands for
/// signal n.
fn is_ignoring() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(0) & (1 | 1 << 1 | 1 << 14) != 0
}

/// Returns the newest recording in a folder. The server may still be compressing an older
/// recording.
#[track_caller]
pub fn recorded(folder: &Path) -> PathBuf {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_recording = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "mcap");
    files.filter(is_recording).max().expect("a recording")
}

/// Returns the recordings in a folder, in the order in which they began. Skips files that contain no
/// description yet.
#[track_caller]
pub fn recordings(folder: &Path) -> Vec<(PathBuf, Recording)> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    // Skip the temporary file of a killed server.
    files.retain(|path| path.extension().is_some_and(|extension| extension == "mcap"));
    // Sort by the number at the end of the name, because the clock may go backwards.
    files.sort_by_key(|path| path.file_stem().unwrap().to_str().unwrap()[20..].to_string());
    let read = |path: PathBuf| match Recording::open(&path) {
        Ok(recording) => Some((path, recording)),
        Err(_) if fs::metadata(&path).unwrap().len() < 200 => None,
        Err(error) => panic!("{error}"),
    };
    files.into_iter().filter_map(read).collect()
}

/// Returns the JSON messages about the mouse in a recording, as the official MCAP library reads
/// them. The file may be truncated.
#[track_caller]
pub fn mouse_messages(path: &Path) -> Vec<Value> {
    let bytes = fs::read(path).unwrap();
    let options = mcap::read::Options::IgnoreEndMagic.into();
    let messages = mcap::MessageStream::new_with_options(&bytes, options).unwrap();
    let messages = messages.map_while(Result::ok).filter(|it| it.channel.topic == "/mouse");
    messages.map(|message| serde_json::from_slice(&message.data).unwrap()).collect()
}

/// Checks a JSON message about the mouse against a state printed by `mmsim replay --json`.
#[track_caller]
pub fn check_mouse_message(message: &Value, state: &Value) {
    assert_eq!((&message["x"], &message["y"]), (&state["cell"][0], &state["cell"][1]), "{state}");
    for key in ["heading", "visited_cells", "optimistic_distance", "pessimistic_distance"] {
        assert_eq!(message[key], state[key], "{key} in {message}, expected {state}");
    }
}

/// Reads stderr until `text` is printed. Returns the reader and the text read so far.
#[track_caller]
pub fn read_until(stderr: ChildStderr, text: &str) -> (BufReader<ChildStderr>, String) {
    read_on(BufReader::new(stderr), text)
}

/// Like [`read_until`], with a reader that it has returned.
#[track_caller]
pub fn read_on(mut stderr: BufReader<ChildStderr>, text: &str) -> (BufReader<ChildStderr>, String) {
    let expected = text.to_string();
    within(&format!("the command to print {text:?}"), move || {
        let mut messages = String::new();
        while !messages.contains(&expected) {
            assert_ne!(stderr.read_line(&mut messages).unwrap(), 0, "exited: {messages}");
        }
        (stderr, messages)
    })
}

/// Calls `run` while the default port of the simulator is in use. Another program may also use the
/// port, and stop using it at any time.
#[track_caller]
pub fn while_default_port_is_in_use(run: impl Fn() -> Output) -> Output {
    wait_for("a run while the default port is in use", || {
        let listener = TcpListener::bind(("127.0.0.1", DEFAULT_PORT));
        let ended = run();
        (listener.is_ok() || ended.stderr.contains("is already in use")).then_some(ended)
    })
}

/// Returns the reported address, or an empty string if there is none.
fn address(messages: &str) -> String {
    let rest = messages.split("tcp://").nth(1).and_then(|rest| rest.split(';').next());
    rest.map(|rest| format!("tcp://{rest}")).unwrap_or_default()
}

/// The exit code and the output of a command.
#[derive(Debug)]
pub struct Output {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Output {
    /// Runs a command to completion.
    pub fn new(command: &mut Command) -> Self {
        let output = output(command);
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().replace("\r\n", "\n");
        Self {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }
}

/// A server process that is killed on drop.
pub struct Serving {
    child: Child,
    pub address: String,
    /// The messages that the server printed to stderr before it was ready.
    pub messages: String,
    rest: Option<Receiver<String>>,
    /// True if the process has a child process, which must not outlive it.
    pub has_mouse: bool,
}

impl Serving {
    fn new(child: Child) -> Self {
        let (address, messages) = (String::new(), String::new());
        Self { child, address, messages, rest: None, has_mouse: false }
    }

    fn set_messages(&mut self, messages: String) {
        (self.address, self.messages) = (address(&messages), messages);
    }

    /// Starts a server command and waits until it prints `text` to stderr.
    pub fn start(command: Command, text: &str) -> Self {
        let (mut serving, mut stderr) = Self::start_reading(command, text);
        let (send, rest) = mpsc::channel();
        serving.rest = Some(rest);
        thread::spawn(move || {
            let mut rest = String::new();
            stderr.read_to_string(&mut rest).unwrap();
            let _ = send.send(rest);
        });
        serving
    }

    /// Like [`start`](Self::start), but returns the reader of the further messages.
    pub fn start_reading(mut command: Command, text: &str) -> (Self, BufReader<ChildStderr>) {
        let pipes = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = pipes.spawn().unwrap();
        // `serving` kills the process even if it never prints the text.
        let (stderr, mut serving) = (child.stderr.take().unwrap(), Self::new(child));
        let (stderr, messages) = read_until(stderr, text);
        serving.set_messages(messages);
        (serving, stderr)
    }

    /// Kills the process, as with `kill -9`.
    pub fn kill(&mut self) {
        self.child.kill().unwrap();
    }

    /// Returns the process ID.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Returns true if the process has exited.
    pub fn has_exited(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(Some(_)))
    }

    /// Waits until the process exits. Returns the exit status and all messages.
    pub fn wait(&mut self) -> (ExitStatus, String) {
        let status = wait_for_exit(&mut self.child);
        let rest = self.rest.take().unwrap().recv_timeout(TIMEOUT).expect("its stderr closes");
        (status, self.messages.clone() + &rest)
    }

    pub fn stdout(&mut self) -> String {
        let mut stdout = self.child.stdout.take().unwrap();
        within("the end of stdout", move || {
            let mut text = String::new();
            stdout.read_to_string(&mut text).unwrap();
            text
        })
    }

    /// Sends a signal. `name` is the name of the signal without the prefix SIG, such as `TERM`.
    #[cfg(unix)]
    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let kill = format!("kill -s {name} {id}");
        assert!(output(Command::new("sh").args(["-c", &kill])).status.success());
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        #[cfg(unix)]
        if self.has_mouse && matches!(self.child.try_wait(), Ok(None)) {
            self.signal("TERM");
            wait_for_exit(&mut self.child);
        }
        let _ = self.child.kill();
        let status = self.child.wait();
        if let Some(Ok(rest)) = self.rest.take().map(|rest| rest.recv_timeout(TIMEOUT))
            && thread::panicking()
        {
            eprintln!("the server's exit: {status:?}; its messages:\n{}{rest}", self.messages);
        }
    }
}
