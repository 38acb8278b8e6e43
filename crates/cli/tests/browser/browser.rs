//! Controlling a browser: actions, queries and logs.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use fantoccini::actions::{InputSource, KeyAction, KeyActions};
use fantoccini::elements::Element;
use fantoccini::error::CmdError;
use fantoccini::key::Key;
use fantoccini::wd::WindowHandle;
use fantoccini::{Client, Locator};
use mmsim_tests::TIMEOUT;
pub(crate) use mmsim_tests::wait_for;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tokio::runtime::{self, Runtime};
use tokio::time::timeout;

use crate::clock::SHORT_PAUSES;
use crate::driver::{DRIVER, missing};
use crate::http;
use crate::simulator::Simulator;

/// The size of the browser window in pixels, as on a laptop.
pub(crate) const WINDOW_SIZE: (u32, u32) = (1280, 860);

/// The started browsers that no test is using. Starting a browser takes longer than most tests.
static IDLE: Mutex<Vec<Browser>> = Mutex::new(Vec::new());

/// A browser with one page.
pub(crate) struct Browser {
    client: Client,
    runtime: Runtime,
    /// The URL of the browser's session in chromedriver.
    session: String,
    downloads: PathBuf,
}

/// An entry in one of the browser's logs.
#[derive(Debug, Deserialize)]
pub(crate) struct LogEntry {
    pub(crate) level: String,
    pub(crate) message: String,
}

/// Runs a test in a browser that no other test uses, and asserts that the browser logs no errors. Skips
/// the test if no browser is installed.
pub(crate) fn with_browser(test: impl FnOnce(&Browser)) {
    let idle = locked(&IDLE).pop();
    let browser = run_test(idle.or_else(|| Browser::start(&["browser"])), test);
    // After a failed test, the browser is not reused.
    locked(&IDLE).extend(browser);
}

/// Does the same as [`with_browser`], but in a new browser that also logs its requests, which makes it
/// slower.
pub(crate) fn with_logged_requests(test: impl FnOnce(&Browser)) {
    run_test(Browser::start(&["browser", "performance"]), test);
}

fn run_test(browser: Option<Browser>, test: impl FnOnce(&Browser)) -> Option<Browser> {
    let Some(browser) = browser else {
        missing();
        return None;
    };
    browser.reset();
    test(&browser);
    browser.assert_no_errors();
    Some(browser)
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts a simulator with these arguments, opens the simulator's page in a browser, and runs a
/// test.
pub(crate) fn with_page(arguments: &[&str], test: impl FnOnce(&Browser, &Simulator)) {
    with_browser(|browser| {
        let simulator = Simulator::start(arguments);
        browser.open(&simulator.page);
        test(browser, &simulator);
        browser.leave();
    });
}

impl Browser {
    fn start(logs: &[&str]) -> Option<Self> {
        let runtime = runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let driver = DRIVER.as_ref()?;
        let (client, downloads) = driver.open(&runtime, WINDOW_SIZE, logs)?;
        let mut browser = Self { client, runtime, session: String::new(), downloads };
        let id = browser.wait(browser.client.session_id()).unwrap();
        browser.session = format!("{}/session/{id}", driver.address);
        browser.command("timeouts", &json!({ "script": TIMEOUT.as_millis() }));
        Some(browser)
    }

    /// Prepares a test: opens a new tab and removes the cookies, downloads and logs of the previous
    /// test.
    fn reset(&self) {
        let old_tab = self.wait(self.client.window());
        let tab = self.wait(self.client.new_window(true));
        self.wait(self.client.switch_to_window(old_tab));
        self.wait(self.client.close_window());
        self.wait(self.client.switch_to_window(tab.handle));
        self.wait(self.client.delete_all_cookies());
        for download in fs::read_dir(self.downloads()).unwrap() {
            fs::remove_file(download.unwrap().path()).unwrap();
        }
        self.take_log("browser");
        let script = json!({ "source": SHORT_PAUSES });
        self.devtools("Page.addScriptToEvaluateOnNewDocument", &script);
    }

    /// Opens a page in a new window, and returns the handle of the window.
    pub(crate) fn open_window(&self, url: &str) -> WindowHandle {
        self.open_in(false, url)
    }

    /// Opens a page in a new tab, which hides the tab of the current page.
    pub(crate) fn open_tab(&self, url: &str) -> WindowHandle {
        self.open_in(true, url)
    }

    fn open_in(&self, is_tab: bool, url: &str) -> WindowHandle {
        let window = self.wait(self.client.new_window(is_tab)).handle;
        self.wait(self.client.switch_to_window(window.clone()));
        self.open(url);
        window
    }

    pub(crate) fn switch_to(&self, window: &WindowHandle) {
        self.wait(self.client.switch_to_window(window.clone()));
    }

    pub(crate) fn close_window(&self) {
        self.wait(self.client.close_window());
    }

    pub(crate) fn window(&self) -> WindowHandle {
        self.wait(self.client.window())
    }

    #[track_caller]
    fn wait<T, E: std::fmt::Display>(&self, answer: impl Future<Output = Result<T, E>>) -> T {
        self.try_wait(answer).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn try_wait<T>(&self, answer: impl Future<Output = T>) -> T {
        let answer = self.runtime.block_on(async { timeout(TIMEOUT, answer).await });
        answer.unwrap_or_else(|_| panic!("no reply from the browser within {TIMEOUT:?}"))
    }

    pub(crate) fn open(&self, address: &str) {
        self.wait(self.client.goto(address));
    }

    /// Asserts that the page has logged no errors, then closes the page so that its simulator can
    /// exit.
    pub(crate) fn leave(&self) {
        self.assert_no_errors();
        self.open("about:blank");
    }

    pub(crate) fn address(&self) -> String {
        self.wait(self.client.current_url()).to_string()
    }

    /// Runs a script as the body of a function and returns its result.
    pub(crate) fn run<T: DeserializeOwned>(&self, script: &str, arguments: &[Value]) -> T {
        let value = self.wait(self.client.execute(script, arguments.to_vec()));
        serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}: {script}"))
    }

    /// Runs an asynchronous script and returns its result. The last argument of the script
    /// is the callback that receives the result.
    pub(crate) fn run_async<T: DeserializeOwned>(&self, script: &str, arguments: &[Value]) -> T {
        let value = self.wait(self.client.execute_async(script, arguments.to_vec()));
        serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}: {script}"))
    }

    /// Waits until a script returns a value that counts as true, and returns the value. The script may run
    /// many times. It must not open another page.
    #[track_caller]
    pub(crate) fn wait_until<T: DeserializeOwned>(
        &self,
        what: &str,
        script: &str,
        arguments: &[Value],
    ) -> T {
        let script = format!(
            "const done = arguments[arguments.length - 1];
            const condition = () => {{ {script} }};
            const check = () => {{
                const value = condition();
                if (value) done(value);
                else setTimeout(check, 50);
            }};
            check();"
        );
        let value = self.try_wait(self.client.execute_async(&script, arguments.to_vec()));
        let value = value.unwrap_or_else(|error| panic!("waited for {what}: {error}"));
        serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}: {script}"))
    }

    /// Waits until an element exists.
    #[track_caller]
    pub(crate) fn wait_until_exists(&self, selector: &str) {
        let script = "return document.querySelector(arguments[0]) !== null";
        let _: bool = self.wait_until(selector, script, &[json!(selector)]);
    }

    /// Waits until the text of an element contains `part`, and returns the text.
    #[track_caller]
    pub(crate) fn wait_for_text(&self, selector: &str, part: &str) -> String {
        let script = "
            const text = document.querySelector(arguments[0])?.textContent;
            return text?.includes(arguments[1]) && text;";
        self.wait_until(part, script, &[json!(selector), json!(part)])
    }

    pub(crate) fn find(&self, selector: &str) -> Element {
        self.wait(self.client.find(Locator::Css(selector)))
    }

    pub(crate) fn click(&self, selector: &str) {
        wait_for(selector, || match self.try_wait(self.find(selector).click()) {
            Ok(()) => Some(()),
            // The page has replaced the element.
            Err(error) if error.is_stale_element_reference() => None,
            Err(error) => panic!("{selector}: {error}"),
        });
    }

    pub(crate) fn exists(&self, selector: &str) -> bool {
        self.run("return document.querySelector(arguments[0]) !== null", &[json!(selector)])
    }

    /// Returns true if an element exists and is not hidden.
    pub(crate) fn is_visible(&self, selector: &str) -> bool {
        let script = "return document.querySelector(arguments[0])?.checkVisibility() ?? false";
        self.run(script, &[json!(selector)])
    }

    /// Returns true if the frame contains an element that matches `selector`. Both arguments are
    /// CSS selectors.
    pub(crate) fn frame_has(&self, frame: &str, selector: &str) -> bool {
        self.wait(async {
            self.client.find(Locator::Css(frame)).await?.enter_frame().await?;
            let found = self.client.find(Locator::Css(selector)).await.is_ok();
            self.client.enter_parent_frame().await?;
            Ok::<_, CmdError>(found)
        })
    }

    /// Clears an input field with the keyboard.
    pub(crate) fn clear(&self, selector: &str) {
        let all = [Key::Control, Key::Delete].map(char::from);
        self.type_into(selector, &format!("{}a{}{}", all[0], all[0], all[1]));
    }

    /// Focuses an element and types into it.
    pub(crate) fn type_into(&self, selector: &str, text: &str) {
        self.wait(self.find(selector).send_keys(text));
    }

    /// Presses keys one after the other, without moving the focus.
    pub(crate) fn press(&self, keys: impl IntoIterator<Item = char>) {
        let actions = keys.into_iter().fold(KeyActions::new("keys".into()), |actions, key| {
            actions.then(KeyAction::Down { value: key }).then(KeyAction::Up { value: key })
        });
        self.wait(self.client.perform_actions(actions));
    }

    /// Presses `key` while holding down `held`.
    pub(crate) fn press_with(&self, held: Key, key: char) {
        let held = char::from(held);
        let actions = [held, key, key, held].into_iter().zip([true, true, false, false]);
        let actions = actions.fold(KeyActions::new("keys".into()), |actions, (value, down)| {
            actions.then(if down { KeyAction::Down { value } } else { KeyAction::Up { value } })
        });
        self.wait(self.client.perform_actions(actions));
    }

    /// Returns the `textContent` of an element, which CSS such as `text-transform` does not affect.
    pub(crate) fn text(&self, selector: &str) -> String {
        self.run("return document.querySelector(arguments[0]).textContent", &[json!(selector)])
    }

    /// Returns a picture of the window as a PNG image.
    pub(crate) fn picture(&self) -> Vec<u8> {
        self.wait(self.client.screenshot())
    }

    /// Sends a command of the Chrome `DevTools` protocol.
    pub(crate) fn devtools(&self, command: &str, parameters: &Value) -> Value {
        self.command("goog/cdp/execute", &json!({ "cmd": command, "params": parameters }))
    }

    fn command(&self, name: &str, body: &Value) -> Value {
        let address = format!("{}/{name}", self.session);
        let body = body.to_string();
        let headers = [("content-type", "application/json")];
        let reply = http::request("POST", &address, &headers, body.as_bytes());
        assert_eq!(reply.status, 200, "{}", reply.text());
        reply.json()["value"].take()
    }

    /// Returns the entries of a log and clears the log. The console log is called `browser`.
    pub(crate) fn take_log(&self, kind: &str) -> Vec<LogEntry> {
        serde_json::from_value(self.command("se/log", &json!({ "type": kind }))).unwrap()
    }

    /// Returns the errors and warnings in the console log, and clears the log.
    pub(crate) fn take_errors(&self) -> Vec<LogEntry> {
        let is_error = |entry: &LogEntry| {
            (entry.level == "SEVERE" || entry.level == "WARNING")
                // Requests for a run that has just ended are expected.
                && !entry.message.ends_with("the server responded with a status of 410 (Gone)")
        };
        self.take_log("browser").into_iter().filter(is_error).collect()
    }

    pub(crate) fn assert_no_errors(&self) {
        let errors = self.take_errors();
        assert!(errors.is_empty(), "{errors:#?}");
    }

    /// Returns the folder for downloads.
    pub(crate) fn downloads(&self) -> &Path {
        &self.downloads
    }

    /// Prints the state of the page after a failed test.
    fn report(&self) -> Option<()> {
        self.runtime.block_on(async {
            let limit = Duration::from_secs(5);
            let shown = "return [location.href, document.body.innerText]";
            let result = timeout(limit, self.client.execute(shown, Vec::new()));
            let shown = result.await.ok()?.ok()?;
            eprintln!("text of {}:\n{}", shown[0].as_str()?, shown[1].as_str()?);
            eprintln!("console: {:#?}", self.take_log("browser"));
            let picture = timeout(limit, self.client.screenshot()).await.ok()?.ok()?;
            let name = thread::current().name()?.replace("::", "-");
            let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
            let file = folder.join(format!("{name}.png"));
            fs::write(&file, picture).ok()?;
            eprintln!("screenshot: {}", file.display());
            Some(())
        })
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        if thread::panicking() {
            self.report();
        }
        let closing = self.client.clone().close();
        let _ = self.runtime.block_on(async { timeout(Duration::from_secs(10), closing).await });
    }
}
