//! Where to listen.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};

/// An address on which no server can listen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// Somebody listens there already.
    #[error(
        "expected port {port} of {host} to be free, found it in use; is another server running?"
    )]
    InUse {
        /// The host.
        host: String,
        /// The port.
        port: u16,
    },
    /// The host is not one of this machine.
    #[error("expected the name or address of this machine, found {host:?}: {source}")]
    Host {
        /// What was given as host.
        host: String,
        /// What the name service says.
        source: io::Error,
    },
    /// Anything else that the system says.
    #[error("cannot listen on port {port} of {host}: {source}")]
    Listen {
        /// The host.
        host: String,
        /// The port.
        port: u16,
        /// What the system says.
        source: io::Error,
    },
}

/// Listens on a port of this machine; port 0 takes a free one. The host may be a name, an address,
/// or `*` for every IPv4 address of the machine.
///
/// # Errors
/// The port is in use, or the host is not one of this machine's.
pub fn listen(host: &str, port: u16) -> Result<TcpListener, BindError> {
    let resolved =
        resolve(host, port).map_err(|source| BindError::Host { host: host.into(), source })?;
    TcpListener::bind(resolved).map_err(|source| match source.kind() {
        ErrorKind::AddrInUse => BindError::InUse { host: host.into(), port },
        _ => BindError::Listen { host: host.into(), port, source },
    })
}

/// The address to listen on; of several, the first of the old kind, which clients try first.
fn resolve(host: &str, port: u16) -> io::Result<SocketAddr> {
    let host = match host {
        "*" => "0.0.0.0",
        host => host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host),
    };
    let mut addresses = (host, port).to_socket_addrs()?.collect::<Vec<_>>();
    addresses.sort_by_key(SocketAddr::is_ipv6);
    addresses.first().copied().ok_or(io::ErrorKind::NotFound.into())
}
