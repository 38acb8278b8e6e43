//! Attacks ZeroMQ REP servers with a stranger's bytes, each server in a child process, and prints
//! what happened to it.
//!
//! `cargo run --release -- NAME...` compares the given servers (default: all), and
//! `cargo run --release -- serve NAME PORT` only serves. Resources are read from `/proc`, so the
//! comparison needs Linux.

mod attacks;
mod servers;

use std::env;
use std::fs::{self, File};
use std::io::{self, Read};
use std::net::{SocketAddr, TcpListener};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use attacks::ATTACKS;
use mmsim_zmtp::ReqClient;
use servers::SERVERS;

/// The time in which a server that works answers a request.
const PATIENCE: Duration = Duration::from_secs(5);

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [command, name, port] = &arguments[..]
        && command == "serve"
    {
        let port = port.parse().map_err(io::Error::other)?;
        return servers::serve(name, port);
    }
    println!("| server | attack | what happened | peak memory |\n|---|---|---|---|");
    for (name, title) in SERVERS {
        if arguments.is_empty() || arguments.iter().any(|argument| argument == name) {
            for (description, attack) in ATTACKS {
                let Some(mut target) = Target::start(name)? else {
                    println!("| {title} | {description} | cannot be started here | |");
                    break;
                };
                let outcome = attack(&mut target);
                println!("| {title} | {description} | {} |", target.report(outcome)?);
            }
        }
    }
    Ok(())
}

/// A server in a child process.
struct Target {
    process: Child,
    address: SocketAddr,
    stderr: tempfile::NamedTempFile,
}

impl Target {
    /// Starts a server, and waits until it answers. Returns `None` if it does not, for example because
    /// Python has no pyzmq.
    fn start(name: &str) -> io::Result<Option<Self>> {
        let address = TcpListener::bind("127.0.0.1:0")?.local_addr()?;
        let stderr = tempfile::NamedTempFile::new()?;
        let mut command = match name {
            "pyzmq" => {
                let python = env::var("PYTHON").unwrap_or_else(|_| "python3".into());
                let mut command = Command::new(python);
                command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/libzmq.py"));
                command
            }
            _ => {
                let mut command = Command::new(env::current_exe()?);
                command.args(["serve", name]);
                command
            }
        };
        command.arg(address.port().to_string()).stderr(File::create(stderr.path())?);
        let mut target = Self { process: command.spawn()?, address, stderr };
        let answers = target.answers(6 * PATIENCE);
        Ok(answers.then_some(target))
    }

    /// Returns true if the process has not ended.
    fn is_running(&mut self) -> bool {
        matches!(self.process.try_wait(), Ok(None))
    }

    /// Returns true if the server answers a good client in time.
    fn answers(&mut self, patience: Duration) -> bool {
        let deadline = Instant::now() + patience;
        let Ok(mut client) = self.client() else { return false };
        client.send(&[b"good"]);
        let mut reply = Vec::new();
        while self.is_running() && Instant::now() < deadline {
            match client.receive(&mut reply, Duration::from_millis(100)) {
                Ok(None) => {}
                Ok(Some(_)) => return reply == b"good",
                Err(_) => client.send(&[b"good"]),
            }
        }
        false
    }

    fn client(&self) -> io::Result<ReqClient> {
        ReqClient::new(format!("tcp://{}", self.address).parse().map_err(io::Error::other)?)
    }

    /// Describes the state of the server after an attack.
    fn report(mut self, outcome: String) -> io::Result<String> {
        let memory = self.peak_memory();
        let answers = self.answers(PATIENCE);
        let mut log = String::new();
        self.stderr.reopen()?.take(1 << 20).read_to_string(&mut log)?;
        let panics = log.matches("panicked at").count();
        let state = match (self.process.try_wait()?, answers) {
            (Some(status), _) => {
                let line = log.lines().find(|line| line.contains("ssertion")).unwrap_or_default();
                let assertion = line.split_once('(').map_or("", |(text, _)| text).trim();
                let signal =
                    status.signal().map_or("exit".into(), |signal| format!("signal {signal}"));
                format!("**ended ({signal})** {assertion}")
            }
            (None, false) => "**stops answering**".into(),
            (None, true) => "holds".into(),
        };
        let panics = if panics > 0 { format!(", {panics} panics") } else { String::new() };
        let megabytes = memory.map_or("".into(), |kib| format!("{} MB", kib / 1000));
        Ok(format!("{}{panics}; {outcome} | {megabytes}", state.trim()))
    }

    /// Returns the peak memory of the process in KiB.
    fn peak_memory(&self) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{}/status", self.process.id())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        line.trim().strip_suffix(" kB")?.parse().ok()
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
