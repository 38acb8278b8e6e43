//! The viewer page of a server.

use std::error::Error;
use std::{env, io};

use mmsim_server::BindError;
use mmsim_viewer::{DEFAULT_VIEWER_PORT, Vehicles, Viewer, ViewerConfig};

use crate::args::ViewerArgs;
use crate::output::{note, warn, with_port_hint};
use crate::vehicle::warn_about;

/// Binds the viewer page to a port unless `--no-viewer` is set. If the default port is in use, for
/// example by another simulator, this binds a free port with `--open` or if `may_be_free` is true.
/// Otherwise, this prints a warning and returns `None`.
pub(crate) fn bind(
    args: &ViewerArgs,
    host: &str,
    may_be_free: bool,
) -> Result<Option<Viewer>, String> {
    if args.no_viewer {
        return Ok(None);
    }
    let mut bound = Viewer::bind(host, args.viewer_port.unwrap_or(DEFAULT_VIEWER_PORT));
    if args.viewer_port.is_none()
        && (args.open || may_be_free)
        && matches!(bound, Err(BindError::InUse { .. }))
    {
        bound = Viewer::bind(host, 0);
    }
    let error = match bound {
        Ok(viewer) => return Ok(Some(viewer)),
        Err(error) => with_port_hint(&error, "--viewer-port"),
    };
    let error = format!("cannot serve the viewer page: {error}");
    if args.viewer_port.is_some() || args.open {
        return Err(error);
    }
    warn(error);
    Ok(None)
}

/// Serves the page, prints its address, and opens the page in a browser if `--open` is set. Returns
/// the address.
pub(crate) fn serve(
    viewer: Option<Viewer>,
    config: ViewerConfig,
    args: &ViewerArgs,
) -> Result<Option<String>, Box<dyn Error>> {
    let Some(viewer) = viewer else { return Ok(None) };
    args.vehicle.iter().for_each(warn_about);
    let config = config.with_vehicles(Vehicles::new(args.vehicle.clone())?);
    // The page is served until the process exits.
    let serving =
        viewer.spawn(config).map_err(|error| format!("cannot serve the viewer page: {error}"))?;
    let address = reachable(serving.address());
    note(format_args!("watch at {address}"));
    if args.open
        && let Err(error) = open_browser(&address)
    {
        warn(format_args!("cannot open a browser: {error}"));
    }
    Ok(Some(address))
}

/// Opens a URL in the default browser, or in the one that `BROWSER` names if this system has no
/// program that opens URLs.
fn open_browser(address: &str) -> io::Result<()> {
    open::that_detached(address).or_else(|error| match env::var("BROWSER") {
        Ok(browser) => open::with_detached(address, browser),
        Err(_) => Err(error),
    })
}

/// Replaces the wildcard host in a URL with a host name that other machines can use.
fn reachable(address: &str) -> String {
    let host = format!("//{}:", host_name().as_deref().unwrap_or("localhost"));
    address.replace("//0.0.0.0:", &host).replace("//[::]:", &host)
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
    fn wildcard_hosts_are_replaced() {
        assert_eq!(reachable("http://127.0.0.1:6575"), "http://127.0.0.1:6575");
        let wildcard = reachable("http://0.0.0.0:6575/?token=a");
        assert!(wildcard.ends_with(":6575/?token=a") && !wildcard.contains("0.0.0.0"));
    }
}
