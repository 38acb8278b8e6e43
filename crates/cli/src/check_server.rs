//! `mmsim check-server`: check that a server follows the protocol.

use std::time::Duration;

use clap::Args;
use mmsim_client::{ServerCheck, check_server};
use mmsim_maze::{Escaped, MazeSize, counted};
use serde::Serialize;

use crate::args::{CommandResult, parse_seconds, parse_size};
use crate::connection::{connect, endpoint, endpoint_help};
use crate::output::{own_command, print, print_json, warn};

const AFTER_HELP: &str = "\
Examples:
  mmsim check-server                                  check the server on port 6574
  mmsim check-server tcp://192.168.1.7:6574 --size 32x32
                                                      check a server with a 32x32 maze
  mmsim check-server --malformed                      also send malformed requests

Sends each request of the protocol and checks the replies: ping, reset, S in both matrix orders, and
W in several cells in all four headings. The replies to W must agree with each other: two replies
about the same wall must be equal, and the outer walls must be present.

The requests include reset, which deletes the states that the server has stored. By default, all
requests are valid, so the reference server can be checked, too. Do not use --malformed with the
reference server: after a malformed request, it replies to no client until it is restarted.

The exit code is 0 if all replies are right, and 1 otherwise.";

#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(crate) struct CheckServerArgs {
    #[arg(help = endpoint_help("Address of the server"))]
    endpoint: Option<String>,
    /// Width and height of the server's maze in cells
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "16x16")]
    size: MazeSize,
    /// Also send info and malformed requests; not for the reference server, which stops replying
    #[arg(long)]
    malformed: bool,
    /// Report a fault if a reply takes longer than S seconds
    #[arg(long, value_name = "S", value_parser = parse_seconds, default_value = "5")]
    timeout: Duration,
    /// Print the checks as a JSON array
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &CheckServerArgs) -> CommandResult {
    let endpoint = endpoint(args.endpoint.as_deref());
    let mut transport = connect(&endpoint, Some(args.timeout), false)?;
    let (mut checks, mut printed) = (Vec::new(), Ok(()));
    let exchange = |frames: &[&[u8]], reply: &mut _| transport.exchange_frames(frames, reply);
    let is_replying = check_server(exchange, args.size, args.malformed, |check| {
        if !args.json && printed.is_ok() {
            printed = print(&line(&check));
        }
        checks.push(check);
    });
    printed?;
    let faults = checks.iter().filter(|check| check.fault.is_some()).count();
    if args.json {
        print_json(&checks.iter().map(CheckReport::new).collect::<Vec<_>>())?;
    } else {
        let number = counted(checks.len(), "check");
        print(&format!("{number}, {}\n", counted(faults, "fault")))?;
    }
    if !is_replying {
        warn(why_stopped(&endpoint, &checks));
    }
    Ok(faults == 0)
}

/// Formats a check as a line of text.
fn line(ServerCheck { request, reply, fault }: &ServerCheck) -> String {
    let line = match fault {
        None => format!("ok     {request}: {}", reply.as_deref().unwrap_or_default()),
        Some(fault) => format!("wrong  {request}: {fault}"),
    };
    format!("{}\n", Escaped(line))
}

/// The JSON report on a check.
#[derive(Serialize)]
struct CheckReport<'a> {
    request: &'a str,
    reply: Option<&'a str>,
    ok: bool,
    fault: Option<&'a str>,
}

impl<'a> CheckReport<'a> {
    fn new(ServerCheck { request, reply, fault }: &'a ServerCheck) -> Self {
        let (reply, fault) = (reply.as_deref(), fault.as_deref());
        Self { request, reply, ok: fault.is_none(), fault }
    }
}

/// Explains why no further checks were made.
fn why_stopped(endpoint: &str, checks: &[ServerCheck]) -> String {
    if checks.iter().any(|check| check.reply.is_some()) {
        return format!("stopped, because {endpoint} no longer replies (restart the server)");
    }
    format!("no reply from {endpoint} (start a simulator with {})", own_command(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hint_depends_on_whether_the_server_has_ever_replied() {
        let fault = || Some("no reply to ping within 10 s".into());
        let silent = ServerCheck { request: "ping".into(), reply: None, fault: fault() };
        let replied = ServerCheck { reply: Some("\"pong\"".into()), fault: None, ..silent.clone() };
        let hint = why_stopped("tcp://a:1", std::slice::from_ref(&silent));
        assert!(hint.starts_with("no reply from tcp://a:1 (start"), "{hint}");
        let hint = why_stopped("tcp://a:1", &[replied, silent]);
        assert!(hint.contains("tcp://a:1 no longer replies"), "{hint}");
    }
}
