//! The page on which a search can be watched.

use std::error::Error;

use mmsim_server::BindError;
use mmsim_viewer::{DEFAULT_VIEWER_PORT, Viewer, ViewerConfig};

use crate::args::ViewerArgs;
use crate::output::{complain, say};

/// Listens for browsers, if that is wanted, or says what to try where it fails. A second simulator
/// that was not told a port for its page serves all the same, without one.
pub(crate) fn bind(args: &ViewerArgs, host: &str) -> Result<Option<Viewer>, String> {
    if args.no_viewer {
        return Ok(None);
    }
    let error = match Viewer::bind(host, args.viewer_port.unwrap_or(DEFAULT_VIEWER_PORT)) {
        Ok(viewer) => return Ok(Some(viewer)),
        Err(error @ BindError::InUse { .. }) => {
            format!("{error} (try --viewer-port 0)")
        }
        Err(error) => error.to_string(),
    };
    if args.viewer_port.is_some() || args.open {
        return Err(format!("no page to watch: {error}"));
    }
    complain(format_args!("no page to watch: {error}"));
    Ok(None)
}

/// Lets browsers watch, says where, and opens one if that is wanted. Gives the address of the page.
pub(crate) fn begin(
    viewer: Option<Viewer>,
    show: ViewerConfig,
    args: &ViewerArgs,
) -> Result<Option<String>, Box<dyn Error>> {
    let Some(viewer) = viewer else { return Ok(None) };
    let serving = viewer.spawn(show).map_err(|error| format!("cannot serve the page: {error}"))?;
    // It serves until the process ends.
    let address = reachable(serving.address());
    say(format_args!("watch at {address}"));
    if args.open
        && let Err(error) = opener::open_browser(&address)
    {
        complain(format_args!("cannot open a browser: {error}"));
    }
    Ok(Some(address))
}

/// The address by a name that others can use: a server that listens everywhere has none.
fn reachable(address: &str) -> String {
    let host = host_name().unwrap_or_else(|| "localhost".into());
    ["//0.0.0.0:", "//[::]:"].iter().fold(address.to_string(), |address, everywhere| {
        address.replace(everywhere, &format!("//{host}:"))
    })
}

fn host_name() -> Option<String> {
    #[cfg(unix)]
    let name = rustix::system::uname().nodename().to_str().ok().map(String::from);
    #[cfg(not(unix))]
    let name = sysinfo::System::host_name();
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_can_be_opened() {
        assert_eq!(reachable("http://127.0.0.1:6575"), "http://127.0.0.1:6575");
        let everywhere = reachable("http://0.0.0.0:6575/?token=a");
        assert!(everywhere.ends_with(":6575/?token=a") && !everywhere.contains("0.0.0.0"));
    }
}
