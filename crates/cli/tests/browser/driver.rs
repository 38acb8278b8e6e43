//! Starting and stopping chromedriver and Chromium.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::{env, fs};

use fantoccini::error::NewSessionError;
use fantoccini::wd::Capabilities;
use fantoccini::{Client, ClientBuilder};
use hyper_util::client::legacy::connect::HttpConnector;
use mmsim_tests::{TIMEOUT, within};
use serde_json::json;
use tempfile::TempDir;
use tokio::runtime::Runtime;
use tokio::time::timeout;

/// The browser's rules for resolving host names. Only this machine is reachable, and names such as
/// `mouse.example` resolve to it.
const NAMES: &str =
    "MAP *.example 127.0.0.1, MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost";

/// A running chromedriver. Dropping a `Driver` kills the process, which closes the browser.
pub(crate) struct Driver {
    process: Child,
    /// The URL of chromedriver, such as `http://127.0.0.1:9515`.
    pub(crate) address: String,
    /// The output pipe, kept open so that chromedriver can write to it.
    _stdout: BufReader<ChildStdout>,
    /// A temporary folder for the browser's profile and downloads.
    pub(crate) folder: TempDir,
}

impl Driver {
    /// Starts chromedriver. Returns `None` if chromedriver is not installed.
    pub(crate) fn start() -> Option<Self> {
        let mut command = Command::new("chromedriver");
        command.arg("--port=0").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().ok()?;
        let mut stdout = BufReader::new(process.stdout.take().unwrap());
        let (port, stdout) = within("the port of chromedriver", || {
            loop {
                let mut line = String::new();
                assert_ne!(stdout.read_line(&mut line).unwrap(), 0, "chromedriver exited");
                if let Some(rest) = line.trim().split("successfully on port ").nth(1) {
                    break (rest.trim_end_matches('.').to_string(), stdout);
                }
            }
        });
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("downloads")).unwrap();
        Some(Self { process, address: format!("http://127.0.0.1:{port}"), _stdout: stdout, folder })
    }

    /// Opens a browser window of this size. Returns `None` if no browser is installed.
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
            runtime.block_on(async { timeout(TIMEOUT, builder.connect(&self.address)).await });
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

/// Reports that no browser is available. Panics if `MMSIM_BROWSER=required` is set.
pub(crate) fn missing() {
    let what = "chromedriver or Chromium not found";
    assert!(env::var("MMSIM_BROWSER").as_deref() != Ok("required"), "{what}");
    // Written directly, since the test harness captures `eprintln!` of passing tests.
    let _ = writeln!(std::io::stderr(), "skipped: {what}");
}
