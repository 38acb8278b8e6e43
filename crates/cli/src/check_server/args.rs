//! Arguments of `mmsim check-server`.

use std::env;
use std::time::Duration;

use clap::Args;
use mmsim_maze::MazeSize;
use mmsim_mouse::ENDPOINT_VARIABLE;
use mmsim_protocol::DEFAULT_PORT;

use crate::args::{parse_seconds, parse_size};
use crate::connection::{ENDPOINT_FORM, endpoint};

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
    #[arg(help = format!(
        "Address of the server as {ENDPOINT_FORM} [default: the environment variable {ENDPOINT_VARIABLE}, \
        or else tcp://127.0.0.1:{DEFAULT_PORT}]"
    ))]
    endpoint: Option<String>,
    /// Width and height of the server's maze in cells
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "16x16")]
    pub(crate) size: MazeSize,
    /// Also send info and malformed requests; not for the reference server, which stops replying
    #[arg(long)]
    pub(crate) malformed: bool,
    /// Report a fault if a reply takes longer than S seconds
    #[arg(long, value_name = "S", value_parser = parse_seconds, default_value = "5")]
    pub(crate) timeout: Duration,
    /// Print the checks as a JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

impl CheckServerArgs {
    /// Returns the `ZeroMQ` address of the server.
    pub(crate) fn endpoint(&self) -> String {
        let variable = || env::var(ENDPOINT_VARIABLE).ok().filter(|address| !address.is_empty());
        let default = || format!("127.0.0.1:{DEFAULT_PORT}");
        endpoint(&self.endpoint.clone().or_else(variable).unwrap_or_else(default))
    }
}
