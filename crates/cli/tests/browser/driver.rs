//! Chromium and the program that drives it: found, started, and ended whatever happens.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::{env, fs};

use fantoccini::error::NewSessionError;
use fantoccini::wd::Capabilities;
use fantoccini::{Client, ClientBuilder};
use hyper_util::client::legacy::connect::HttpConnector;
use mmsim_tests::{PATIENCE, within};
use serde_json::json;
use tempfile::TempDir;
use tokio::runtime::Runtime;
use tokio::time::timeout;

/// No name but those of this machine leads anywhere, and names of examples lead to it.
const NAMES: &str =
    "MAP *.example 127.0.0.1, MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost";

/// A running chromedriver. It ends with this, and with it the browser that it has started.
pub(crate) struct Driver {
    process: Child,
    /// Where it listens, such as `http://127.0.0.1:9515`.
    pub(crate) address: String,
    /// What it may still say has somewhere to go.
    _said: BufReader<ChildStdout>,
    /// Holds the browser's profile and what it downloads.
    pub(crate) folder: TempDir,
}

impl Driver {
    /// None if there is none on this machine.
    pub(crate) fn start() -> Option<Self> {
        let mut command = Command::new("chromedriver");
        command.arg("--port=0").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().ok()?;
        let mut said = BufReader::new(process.stdout.take().unwrap());
        let (port, said) = within("the port of chromedriver", || {
            loop {
                let mut line = String::new();
                assert_ne!(said.read_line(&mut line).unwrap(), 0, "chromedriver has ended");
                if let Some(rest) = line.trim().split("successfully on port ").nth(1) {
                    break (rest.trim_end_matches('.').to_string(), said);
                }
            }
        });
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("downloads")).unwrap();
        Some(Self { process, address: format!("http://127.0.0.1:{port}"), _said: said, folder })
    }

    /// A browser of this size; none if there is none on this machine.
    pub(crate) fn open(&self, runtime: &Runtime, (width, height): (u32, u32)) -> Option<Client> {
        let profile = self.folder.path().join("profile");
        let arguments = [
            "--headless".to_string(),
            "--no-sandbox".into(),
            "--disable-gpu".into(),
            "--disable-quic".into(),
            "--disable-dev-shm-usage".into(),
            "--no-first-run".into(),
            "--disable-background-networking".into(),
            "--disable-component-update".into(),
            "--disable-sync".into(),
            format!("--window-size={width},{height}"),
            format!("--user-data-dir={}", profile.display()),
            format!("--host-resolver-rules={NAMES}"),
        ];
        let capabilities = json!({
            "browserName": "chrome",
            "goog:chromeOptions": {
                "args": arguments,
                "prefs": { "download.default_directory": self.folder.path().join("downloads") },
            },
            "goog:loggingPrefs": { "browser": "ALL", "performance": "ALL" },
        });
        let capabilities: Capabilities = serde_json::from_value(capabilities).unwrap();
        let mut builder = ClientBuilder::new(HttpConnector::new());
        builder.capabilities(capabilities);
        let connected =
            runtime.block_on(async { timeout(PATIENCE, builder.connect(&self.address)).await });
        match connected.expect("the browser to open") {
            Ok(client) => Some(client),
            Err(NewSessionError::SessionNotCreated(error))
                if ["cannot find", "binary"].iter().all(|part| error.message.contains(part)) =>
            {
                None
            }
            Err(error) => panic!("{error}"),
        }
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// What to do where there is no browser: to say so, or to fail where one is required.
pub(crate) fn missing() {
    let what = "no chromedriver, or no Chromium that it finds";
    assert!(env::var("MMSIM_BROWSER").as_deref() != Ok("required"), "{what}");
    // Past the test harness, which keeps to itself what passing tests print.
    let _ = writeln!(std::io::stderr(), "skipped, {what}");
}
