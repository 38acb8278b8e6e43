//! The function [`listen`], which opens a listening TCP socket.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener};

use crate::endpoint;

/// An error from [`listen`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// The port is in use.
    #[error("port {port} on {host} is already in use")]
    InUse {
        /// The host, as passed to [`listen`].
        host: String,
        /// The port.
        port: u16,
    },
    /// The host name cannot be resolved.
    #[error("cannot resolve host {host:?}: {source}")]
    Host {
        /// The host, as passed to [`listen`].
        host: String,
        /// The error from name resolution.
        source: io::Error,
    },
    /// The operating system does not allow the program to listen on the port. For example, the
    /// address does not belong to this machine, or the port requires privileges.
    #[error("cannot listen on port {port} on {host}: {source}")]
    Listen {
        /// The host, as passed to [`listen`].
        host: String,
        /// The port.
        port: u16,
        /// The error from the operating system.
        source: io::Error,
    },
}

/// Opens a listening TCP socket. `host` is a host name, an IP address, or `*` for all IPv4
/// addresses of this machine. If `port` is 0, the operating system chooses a free port.
///
/// # Errors
/// Returns an error if the port is in use ([`BindError::InUse`]), if the host name cannot be
/// resolved ([`BindError::Host`]), or if listening fails for another reason
/// ([`BindError::Listen`]).
pub fn listen(host: &str, port: u16) -> Result<TcpListener, BindError> {
    let address =
        resolve(host, port).map_err(|source| BindError::Host { host: host.into(), source })?;
    TcpListener::bind(address).map_err(|source| match source.kind() {
        ErrorKind::AddrInUse => BindError::InUse { host: host.into(), port },
        _ => BindError::Listen { host: host.into(), port, source },
    })
}

/// Returns the address to listen on. If the host has IPv4 and IPv6 addresses, it is an IPv4 address.
fn resolve(host: &str, port: u16) -> io::Result<SocketAddr> {
    let host = if host == "*" { "0.0.0.0" } else { host };
    endpoint::resolve(host, port)?.into_iter().next().ok_or(ErrorKind::NotFound.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn used_port_is_reported() {
        let listener = listen("127.0.0.1", 0).unwrap();
        let port = listener.local_addr().unwrap().port();
        let error = listen("127.0.0.1", port).unwrap_err();
        assert_eq!(error.to_string(), format!("port {port} on 127.0.0.1 is already in use"));
    }

    #[test]
    fn host_is_a_name_or_an_address_of_this_machine() {
        for host in ["127.0.0.1", "localhost", "*"] {
            let address = listen(host, 0).unwrap().local_addr().unwrap();
            assert_eq!(address.ip().is_loopback(), host != "*");
        }
        assert!(resolve("localhost", 7).unwrap().is_ipv4());
        assert_eq!(resolve("[::1]", 7).unwrap(), "[::1]:7".parse().unwrap());
        let error = |host| listen(host, 0).unwrap_err().to_string();
        assert!(error("no such host").starts_with("cannot resolve host \"no such host\": "));
        assert!(error("192.0.2.1").starts_with("cannot listen on port 0 on 192.0.2.1: "));
    }
}
