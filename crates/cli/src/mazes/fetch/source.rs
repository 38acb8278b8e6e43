//! Reads an archive from a URL or a file.

use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;
use std::time::Duration;

use percent_encoding::percent_decode_str;
use ureq::tls::{RootCerts, TlsConfig};
use ureq::{Agent, Timeout};

use super::archive::MAX_ARCHIVE_BYTES;
use crate::output::own_command;
use crate::terminal::progress_bar;

/// The timeout for connecting, for waiting for the response, and for each read.
const TIMEOUT: Duration = Duration::from_secs(30);

/// The maximum duration of a download in minutes.
const MAX_MINUTES: u64 = 10;

/// Reads the archive at a URL or in a file.
///
/// # Errors
/// Returns an error if the archive cannot be read completely or is too large.
pub(super) fn read(from: &str) -> Result<Vec<u8>, String> {
    let path = match scheme(from).as_deref() {
        Some("https" | "http") => {
            return download(from).map_err(|error| {
                let fetch = own_command("mazes fetch --from FILE");
                format!("cannot download {from}: {error} (try again, or save it with a browser and run {fetch})")
            });
        }
        Some("file") => file_path(from)
            .ok_or_else(|| format!("cannot read {from}: not a local file (use file:///PATH)"))?,
        _ => PathBuf::from(from),
    };
    let content = File::open(path).and_then(|file| read_whole(file, None));
    content.map_err(|error| format!("cannot read {from}: {error}"))
}

/// Returns the scheme of a URL in lower case.
fn scheme(address: &str) -> Option<String> {
    address.split_once("://").map(|(scheme, _)| scheme.to_ascii_lowercase())
}

/// Returns the path in a `file://` URL, or `None` if the file is on another host.
fn file_path(url: &str) -> Option<PathBuf> {
    let (_, rest) = url.split_once("://")?;
    let rest = rest.split(['?', '#']).next()?;
    let (host, path) = rest.split_at(rest.find('/')?);
    let is_local = host.is_empty() || host.eq_ignore_ascii_case("localhost");
    // The path of a URL begins with `/`, but that of a Windows file begins with its drive.
    let path = if cfg!(windows) { &path[1..] } else { path };
    let bytes = percent_decode_str(path);
    #[cfg(unix)]
    let path: std::ffi::OsString = std::os::unix::ffi::OsStringExt::from_vec(bytes.collect());
    #[cfg(not(unix))]
    let path = bytes.decode_utf8().ok()?.into_owned();
    #[cfg(windows)]
    if !is_local {
        // A path of the network, such as \\server\share.
        return Some(PathBuf::from(format!(r"\\{host}\{}", path.replace('/', r"\"))));
    }
    is_local.then(|| PathBuf::from(path))
}

fn download(address: &str) -> Result<Vec<u8>, String> {
    // The system's certificates may include those of a school or company.
    match download_from_trusted(address, RootCerts::PlatformVerifier) {
        // A small system, such as a container, may have no certificates. Use Mozilla's.
        Err(error) if error.contains("No CA certificates") => {
            download_from_trusted(address, RootCerts::WebPki).map_err(|error| {
                let is_untrusted = error.contains("certificate");
                let why = " (this system has no CA certificates, so mmsim used its own)";
                error + if is_untrusted { why } else { "" }
            })
        }
        result => result,
    }
}

fn download_from_trusted(address: &str, roots: RootCerts) -> Result<Vec<u8>, String> {
    let tls = TlsConfig::builder().root_certs(roots).build();
    let agent: Agent = Agent::config_builder()
        .tls_config(tls)
        // A redirect must not downgrade https.
        .https_only(scheme(address).as_deref() == Some("https"))
        .user_agent(concat!("mmsim/", env!("CARGO_PKG_VERSION")))
        .timeout_global(Some(Duration::from_secs(MAX_MINUTES * 60)))
        .timeout_connect(Some(TIMEOUT))
        .timeout_recv_response(Some(TIMEOUT))
        .timeout_per_read(Some(TIMEOUT))
        .build()
        .into();
    let content = agent.get(address).call().and_then(|mut response| {
        let bytes = response.body().content_length();
        let of_all = bytes.map_or("", |_| " of {binary_total_bytes}");
        let progress = progress_bar(bytes, &["{binary_bytes}", of_all].concat());
        Ok(read_whole(progress.wrap_read(response.body_mut().as_reader()), bytes)?)
    });
    content.map_err(|error| match error {
        ureq::Error::Timeout(Timeout::Global) => {
            format!("not finished within {MAX_MINUTES} minutes")
        }
        ureq::Error::Rustls(error) => error.to_string(),
        error => error.into_io().to_string(),
    })
}

/// Reads all bytes, or returns an error if there are more than [`MAX_ARCHIVE_BYTES`]. `bytes` is
/// the expected number of bytes, if known.
fn read_whole(from: impl Read, bytes: Option<u64>) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    if bytes.is_none_or(|bytes| bytes <= MAX_ARCHIVE_BYTES) {
        let read = from.take(MAX_ARCHIVE_BYTES + 1).read_to_end(&mut content)?;
        if read as u64 <= MAX_ARCHIVE_BYTES {
            return Ok(content);
        }
    }
    Err(io::Error::other(format!("larger than {} MiB", MAX_ARCHIVE_BYTES >> 20)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_urls_contain_paths_of_local_files() {
        let start = if cfg!(windows) { "" } else { "/" };
        for (url, path) in [
            ("file:///C:/a%20b/%C3%A9.zip", "C:/a b/é.zip"),
            ("FILE:///C:/a%23b.zip?query#fragment", "C:/a#b.zip"),
            ("file://LocalHost/C:/a", "C:/a"),
        ] {
            assert_eq!(file_path(url), Some(PathBuf::from(format!("{start}{path}"))), "{url}");
        }
        #[cfg(unix)]
        assert_eq!(file_path("file:///%ff").unwrap().as_os_str().len(), 2, "any bytes");
        let shared = cfg!(windows).then(|| PathBuf::from(r"\\host\a\b.zip"));
        assert_eq!(file_path("file://host/a/b.zip"), shared);
        for other in ["file://a.zip", "file://", "file://?/a"] {
            assert_eq!(file_path(other), None, "{other}");
        }
    }
}
