//! Where an archive comes from.

use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;
use std::time::Duration;

use indicatif::ProgressBar;
use ureq::tls::{RootCerts, TlsConfig};
use ureq::{Agent, Timeout};
use url::Url;

use super::archive::MAX_ARCHIVE_BYTES;
use crate::output::{own_command, progress};

/// How long a server may take to answer, and to go on.
const PATIENCE: Duration = Duration::from_secs(30);

/// How many minutes all of it may take.
const MAX_MINUTES: u64 = 10;

/// The archive at this address, or in this file.
///
/// # Errors
/// What cannot be read to its end, or is too large.
pub(super) fn read(from: &str) -> Result<Vec<u8>, String> {
    let path = match scheme(from).as_deref() {
        Some("https" | "http") => {
            return download(from).map_err(|error| {
                let fetch = own_command("mazes fetch --from FILE");
                format!("{from}: cannot be downloaded: {error}; try again, or save it with a browser and take that file: {fetch}")
            });
        }
        Some("file") => {
            Url::parse(from).ok().and_then(|url| url.to_file_path().ok()).ok_or_else(|| {
                format!("{from}: expected a file of this machine, as file:///PATH, found none")
            })?
        }
        _ => PathBuf::from(from),
    };
    let error = |error: io::Error| format!("{from}: cannot be read: {error}");
    let file = File::open(path).map_err(error)?;
    let facts = file.metadata().map_err(error)?;
    // Of a pipe nobody knows how long it is.
    let bytes = facts.is_file().then_some(facts.len());
    read_whole(file, bytes, &ProgressBar::hidden()).map_err(error)
}

/// What an address begins with, in lower case.
fn scheme(address: &str) -> Option<String> {
    address.split_once("://").map(|(scheme, _)| scheme.to_ascii_lowercase())
}

fn download(address: &str) -> Result<Vec<u8>, String> {
    // Whom the system trusts, which schools add their own to.
    match download_from_trusted(address, RootCerts::PlatformVerifier) {
        // A small system, such as a container, may know nobody. Then it is those whom browsers trust.
        Err(ureq::Error::Rustls(error)) if error.to_string().contains("No CA certificates") => {
            download_from_trusted(address, RootCerts::WebPki).map_err(|error| {
                let error = told(error);
                let is_distrust = error.contains("certificate");
                let why = "; this system knows no CA certificates, so mmsim went by its own";
                error + if is_distrust { why } else { "" }
            })
        }
        result => result.map_err(told),
    }
}

/// What went wrong, in words that say what was expected where the library's do not.
fn told(error: ureq::Error) -> String {
    match error {
        ureq::Error::Timeout(Timeout::Global) => {
            format!("expected all of it within {MAX_MINUTES} minutes, found no end")
        }
        ureq::Error::Rustls(error) => error.to_string(),
        error => error.into_io().to_string(),
    }
}

fn download_from_trusted(address: &str, roots: RootCerts) -> Result<Vec<u8>, ureq::Error> {
    let tls = TlsConfig::builder().root_certs(roots).build();
    let agent: Agent = Agent::config_builder()
        .tls_config(tls)
        // What was asked for safely does not come from elsewhere unsafely.
        .https_only(scheme(address).as_deref() == Some("https"))
        .user_agent(concat!("mmsim/", env!("CARGO_PKG_VERSION")))
        .timeout_global(Some(Duration::from_secs(MAX_MINUTES * 60)))
        .timeout_connect(Some(PATIENCE))
        .timeout_recv_response(Some(PATIENCE))
        .timeout_per_read(Some(PATIENCE))
        .build()
        .into();
    let mut response = agent.get(address).call()?;
    let bytes = response.body().content_length();
    let bar = bar(bytes);
    let content = read_whole(response.body_mut().as_reader(), bytes, &bar);
    bar.finish_and_clear();
    Ok(content?)
}

/// Reads so many bytes, where it is known how many that are.
fn read_whole(mut from: impl Read, bytes: Option<u64>, bar: &ProgressBar) -> io::Result<Vec<u8>> {
    let too_large = |found: String| {
        let most = MAX_ARCHIVE_BYTES >> 20;
        Err(io::Error::other(format!("expected at most {most} MiB, found {found}")))
    };
    if let Some(bytes) = bytes.filter(|&bytes| bytes > MAX_ARCHIVE_BYTES) {
        return too_large(format!("{bytes} bytes"));
    }
    let mut content = Vec::new();
    while content.len() as u64 <= MAX_ARCHIVE_BYTES {
        let read = from.by_ref().take(1 << 16).read_to_end(&mut content)?;
        bar.inc(read as u64);
        if read == 0 {
            let found = content.len() as u64;
            return match bytes {
                Some(bytes) if bytes != found => {
                    Err(io::Error::other(format!("expected {bytes} bytes, found {found}")))
                }
                _ => Ok(content),
            };
        }
    }
    too_large("more".into())
}

/// How much is downloaded.
fn bar(bytes: Option<u64>) -> ProgressBar {
    match bytes {
        Some(bytes) => progress(ProgressBar::new(bytes), "{wide_bar} {bytes} of {total_bytes}"),
        None => progress(ProgressBar::no_length(), "{spinner} {bytes}"),
    }
}
