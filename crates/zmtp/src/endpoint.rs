//! Endpoints such as `tcp://127.0.0.1:6574`, and the resolution of host names.

use std::fmt;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::str::FromStr;

/// The TCP endpoint of a server: a host and a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// A host name or an IP address. An IPv6 address may be in brackets.
    host: String,
    port: u16,
}

/// An error from parsing an [`Endpoint`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EndpointError {
    /// The endpoint does not begin with `tcp://`, or has no port.
    #[error("expected tcp://HOST:PORT, found {0:?}")]
    Transport(String),
    /// The port is not a number from 1 to 65535.
    #[error("expected a port from 1 to 65535, found {0:?}")]
    Port(String),
    /// The host is missing or a wildcard.
    #[error("expected a host name or an IP address, found {0:?}")]
    Host(String),
}

impl FromStr for Endpoint {
    type Err = EndpointError;

    fn from_str(endpoint: &str) -> Result<Self, EndpointError> {
        let address = endpoint.strip_prefix("tcp://").and_then(|address| address.rsplit_once(':'));
        let (host, port) = address.ok_or_else(|| EndpointError::Transport(endpoint.into()))?;
        let number = port.parse().ok().filter(|&port| port > 0);
        let port = number.ok_or_else(|| EndpointError::Port(port.into()))?;
        if matches!(host, "" | "*") {
            return Err(EndpointError::Host(host.into()));
        }
        Ok(Self { host: host.into(), port })
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tcp://{}:{}", self.host, self.port)
    }
}

impl Endpoint {
    /// Returns the addresses of the host. IPv4 addresses come first, because most ZeroMQ peers try
    /// IPv4 first.
    pub(crate) fn resolve(&self) -> io::Result<Vec<SocketAddr>> {
        let host = self.host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        let host = host.unwrap_or(&self.host);
        let mut addresses: Vec<_> = (host, self.port).to_socket_addrs()?.collect();
        addresses.sort_by_key(SocketAddr::is_ipv6);
        Ok(addresses)
    }
}

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
        address_of(host, port).map_err(|source| BindError::Host { host: host.into(), source })?;
    TcpListener::bind(address).map_err(|source| match source.kind() {
        ErrorKind::AddrInUse => BindError::InUse { host: host.into(), port },
        _ => BindError::Listen { host: host.into(), port, source },
    })
}

/// Returns the address to listen on. If the host has IPv4 and IPv6 addresses, it is an IPv4 address.
fn address_of(host: &str, port: u16) -> io::Result<SocketAddr> {
    let host = if host == "*" { "0.0.0.0" } else { host };
    let addresses = Endpoint { host: host.into(), port }.resolve()?;
    addresses.into_iter().next().ok_or(ErrorKind::NotFound.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoint_is_parsed_and_resolved() {
        for (text, addresses) in [
            ("tcp://127.0.0.1:6574", &["127.0.0.1:6574"][..]),
            ("tcp://[::1]:65535", &["[::1]:65535"]),
            ("tcp://::1:1", &["[::1]:1"]),
        ] {
            let endpoint: Endpoint = text.parse().unwrap();
            assert_eq!(endpoint.to_string(), text);
            let addresses: Vec<SocketAddr> = addresses.iter().map(|a| a.parse().unwrap()).collect();
            assert_eq!(endpoint.resolve().unwrap(), addresses);
        }
        let local = "tcp://localhost:7".parse::<Endpoint>().unwrap().resolve().unwrap();
        assert_eq!(local[0], "127.0.0.1:7".parse().unwrap());
        assert!("tcp://no such host:7".parse::<Endpoint>().unwrap().resolve().is_err());
    }

    #[test]
    fn invalid_endpoint_is_refused() {
        let error = |text: &str| text.parse::<Endpoint>().unwrap_err().to_string();
        let others = ["ipc:///tmp/maze", "inproc://maze", "127.0.0.1:6574", "TCP://host:1", ""];
        for text in others.into_iter().chain(["tcp://127.0.0.1", "tcp://6574"]) {
            assert_eq!(error(text), format!("expected tcp://HOST:PORT, found {text:?}"));
        }
        for port in ["99999", "0", "http", "127.0.0.1", ""] {
            let expected = format!("expected a port from 1 to 65535, found {port:?}");
            assert_eq!(error(&format!("tcp://host:{port}")), expected);
        }
        assert_eq!(error("tcp://*:6574"), "expected a host name or an IP address, found \"*\"");
        assert_eq!(error("tcp://:6574"), "expected a host name or an IP address, found \"\"");
    }

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
        assert!(address_of("localhost", 7).unwrap().is_ipv4());
        assert_eq!(address_of("[::1]", 7).unwrap(), "[::1]:7".parse().unwrap());
        let error = |host| listen(host, 0).unwrap_err().to_string();
        assert!(error("no such host").starts_with("cannot resolve host \"no such host\": "));
        assert!(error("192.0.2.1").starts_with("cannot listen on port 0 on 192.0.2.1: "));
    }
}
