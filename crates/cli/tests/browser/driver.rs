//! Starting chromedriver and Chromium.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::LazyLock;
use std::{env, fs};

use fantoccini::error::NewSessionError;
use fantoccini::wd::Capabilities;
use fantoccini::{Client, ClientBuilder};
use hyper_util::client::legacy::connect::HttpConnector;
use mmsim_tests::{TIMEOUT, within};
use serde_json::json;
use tokio::runtime::Runtime;
use tokio::time::timeout;

/// The browser's rules for resolving host names. Only this machine is reachable, and names such as
/// `mouse.example` resolve to it.
const NAMES: &str =
    "MAP *.example 127.0.0.1, MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost";

/// Runs chromedriver until stdin closes, then kills its process group, which includes all browsers. The
/// operating system closes the pipe even if the test process is killed. `$1` is a folder to remove at
/// the end.
const SCRIPT: &str = "
    set -m
    trap : HUP INT TERM
    chromedriver --port=0 </dev/null &
    exec >&-
    read -r end
    kill -KILL -- -$!
    wait
    until rm -rf \"$1\"; do :; done";

/// A running chromedriver.
pub(crate) struct Driver {
    /// The URL, such as `http://127.0.0.1:9515`.
    pub(crate) address: String,
    /// A folder for the profiles and downloads of the browsers.
    folder: PathBuf,
    _stdin: ChildStdin,
    /// The output pipe, kept open so that chromedriver can write to it.
    _stdout: BufReader<ChildStdout>,
}

/// The chromedriver of all tests, or `None` if chromedriver is not installed.
pub(crate) static DRIVER: LazyLock<Option<Driver>> = LazyLock::new(Driver::start);

impl Driver {
    fn start() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap().keep();
        let mut command = Command::new("bash");
        command.args(["-c", SCRIPT, "bash"]).arg(&folder);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut shell = pipes.spawn().ok()?;
        let mut stdout = BufReader::new(shell.stdout.take().unwrap());
        let (port, stdout) = within("the port of chromedriver", || {
            loop {
                let mut line = String::new();
                if stdout.read_line(&mut line).unwrap() == 0 {
                    break None;
                }
                if let Some(rest) = line.trim().split("successfully on port ").nth(1) {
                    break Some((rest.trim_end_matches('.').to_string(), stdout));
                }
            }
        })?;
        let address = format!("http://127.0.0.1:{port}");
        Some(Self { address, folder, _stdin: shell.stdin.take().unwrap(), _stdout: stdout })
    }

    /// Starts a browser with a window of this size that keeps these logs. Returns it and its folder for
    /// downloads, or `None` if no browser is installed.
    pub(crate) fn open(
        &self,
        runtime: &Runtime,
        (width, height): (u32, u32),
        logs: &[&str],
    ) -> Option<(Client, PathBuf)> {
        let folder = tempfile::tempdir_in(&self.folder).unwrap().keep();
        let (profile, downloads) = (folder.join("profile"), folder.join("downloads"));
        fs::create_dir(&downloads).unwrap();
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
            // Starting a process takes longer than most tests.
            "--renderer-process-limit=1".into(),
            format!("--window-size={width},{height}"),
            format!("--user-data-dir={}", profile.display()),
            format!("--host-resolver-rules={NAMES}"),
        ];
        let capabilities = json!({
            "browserName": "chrome",
            "goog:chromeOptions": {
                "args": arguments,
                "prefs": { "download.default_directory": downloads },
            },
            "goog:loggingPrefs": logs.iter().map(|log| (*log, "ALL")).collect::<BTreeMap<_, _>>(),
        });
        let capabilities: Capabilities = serde_json::from_value(capabilities).unwrap();
        let mut builder = ClientBuilder::new(HttpConnector::new());
        builder.capabilities(capabilities);
        let connected =
            runtime.block_on(async { timeout(TIMEOUT, builder.connect(&self.address)).await });
        match connected.expect("the browser to open") {
            Ok(client) => Some((client, downloads)),
            Err(NewSessionError::SessionNotCreated(error))
                if ["cannot find", "binary"].iter().all(|part| error.message.contains(part)) =>
            {
                None
            }
            Err(error) => panic!("{error}"),
        }
    }
}

/// Reports that no browser is available. Panics if `MMSIM_BROWSER=required` is set.
pub(crate) fn missing() {
    let what = "chromedriver or Chromium not found";
    assert!(env::var("MMSIM_BROWSER").as_deref() != Ok("required"), "{what}");
    // Written directly, since the test harness captures `eprintln!` of passing tests.
    let _ = writeln!(std::io::stderr(), "skipped: {what}");
}
