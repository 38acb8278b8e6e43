//! A browser in a test: what it shows, what is done in it, and what it complains of.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::Duration;
use std::{fs, path::PathBuf};

use fantoccini::actions::{InputSource, KeyAction, KeyActions};
use fantoccini::elements::Element;
use fantoccini::error::CmdError;
use fantoccini::key::Key;
use fantoccini::{Client, Locator};
use mmsim_tests::PATIENCE;
pub(crate) use mmsim_tests::wait_for;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tokio::runtime::{self, Runtime};
use tokio::time::timeout;

use crate::driver::{Driver, missing};
use crate::http;
use crate::simulator::Simulator;

/// A laptop's screen.
pub(crate) const USUAL: (u32, u32) = (1280, 860);

/// A browser that one test after the other uses, as long as another one waits for it: starting one
/// takes longer than most tests. The last test ends it.
static SHARED: Mutex<Weak<Mutex<Option<Browser>>>> = Mutex::new(Weak::new());

/// A browser with one page.
pub(crate) struct Browser {
    client: Client,
    runtime: Runtime,
    driver: Driver,
    session: String,
}

/// Something that the browser says.
#[derive(Debug, Deserialize)]
pub(crate) struct Said {
    pub(crate) level: String,
    pub(crate) message: String,
}

/// Runs a test in a browser, which may complain of nothing. Where there is none there is no test.
pub(crate) fn browse(test: impl FnOnce(&Browser)) {
    let shared = {
        let mut shared = locked(&SHARED);
        shared.upgrade().unwrap_or_else(|| {
            let first = Arc::default();
            *shared = Arc::downgrade(&first);
            first
        })
    };
    let mut slot = locked(&shared);
    let Some(browser) = slot.take().or_else(Browser::start) else { return missing() };
    browser.begin();
    test(&browser);
    browser.assert_no_complaints();
    // One whose test has failed is not used again.
    *slot = Some(browser);
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The same with a simulator that serves with these arguments.
pub(crate) fn watch(arguments: &[&str], test: impl FnOnce(&Browser, &Simulator)) {
    browse(|browser| {
        let simulator = Simulator::start(arguments);
        browser.open(&simulator.page);
        test(browser, &simulator);
        browser.leave();
    });
}

impl Browser {
    fn start() -> Option<Self> {
        let runtime = runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let driver = Driver::start()?;
        let client = driver.open(&runtime, USUAL)?;
        let mut browser = Self { client, runtime, driver, session: String::new() };
        browser.session = browser.wait(browser.client.session_id()).unwrap();
        Some(browser)
    }

    /// Begins a test: a tab of its own, and nothing of the test before.
    fn begin(&self) {
        let before = self.wait(self.client.window());
        let tab = self.wait(self.client.new_window(true));
        self.wait(self.client.switch_to_window(before));
        self.wait(self.client.close_window());
        self.wait(self.client.switch_to_window(tab.handle));
        self.wait(self.client.delete_all_cookies());
        for download in fs::read_dir(self.downloads()).unwrap() {
            fs::remove_file(download.unwrap().path()).unwrap();
        }
        for kind in ["browser", "performance"] {
            self.said(kind);
        }
    }

    #[track_caller]
    fn wait<T, E: std::fmt::Display>(&self, answer: impl Future<Output = Result<T, E>>) -> T {
        self.try_wait(answer).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn try_wait<T>(&self, answer: impl Future<Output = T>) -> T {
        let answer = self.runtime.block_on(async { timeout(PATIENCE, answer).await });
        answer.unwrap_or_else(|_| panic!("waited {PATIENCE:?} for the browser to answer"))
    }

    pub(crate) fn open(&self, address: &str) {
        self.wait(self.client.goto(address));
    }

    /// Leaves the page, which may have complained of nothing, so that its simulator can end.
    pub(crate) fn leave(&self) {
        self.assert_no_complaints();
        self.open("about:blank");
    }

    pub(crate) fn address(&self) -> String {
        self.wait(self.client.current_url()).to_string()
    }

    /// Runs a script, the body of a function, and gives what it returns.
    pub(crate) fn run<T: DeserializeOwned>(&self, script: &str, arguments: &[Value]) -> T {
        let value = self.wait(self.client.execute(script, arguments.to_vec()));
        serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}: {script}"))
    }

    /// The same for a script that ends by calling its last argument.
    pub(crate) fn run_async<T: DeserializeOwned>(&self, script: &str, arguments: &[Value]) -> T {
        let value = self.wait(self.client.execute_async(script, arguments.to_vec()));
        serde_json::from_value(value).unwrap_or_else(|error| panic!("{error}: {script}"))
    }

    pub(crate) fn find(&self, selector: &str) -> Element {
        self.wait(self.client.find(Locator::Css(selector)))
    }

    pub(crate) fn click(&self, selector: &str) {
        wait_for(selector, || match self.try_wait(self.find(selector).click()) {
            Ok(()) => Some(()),
            // It has been made anew.
            Err(error) if error.is_stale_element_reference() => None,
            Err(error) => panic!("{selector}: {error}"),
        });
    }

    pub(crate) fn is_there(&self, selector: &str) -> bool {
        self.run("return document.querySelector(arguments[0]) !== null", &[json!(selector)])
    }

    /// Whether the page in a frame has something.
    pub(crate) fn frame_has(&self, frame: &str, selector: &str) -> bool {
        self.wait(async {
            self.client.find(Locator::Css(frame)).await?.enter_frame().await?;
            let found = self.client.find(Locator::Css(selector)).await.is_ok();
            self.client.enter_parent_frame().await?;
            Ok::<_, CmdError>(found)
        })
    }

    /// Empties a field as a person does.
    pub(crate) fn clear(&self, selector: &str) {
        let all = [Key::Control, Key::Delete].map(char::from);
        self.type_into(selector, &format!("{}a{}{}", all[0], all[0], all[1]));
    }

    /// Types into an element, which gets the focus.
    pub(crate) fn type_into(&self, selector: &str, text: &str) {
        self.wait(self.find(selector).send_keys(text));
    }

    /// Presses keys, one after the other, wherever the focus is.
    pub(crate) fn press(&self, keys: impl IntoIterator<Item = char>) {
        let actions = keys.into_iter().fold(KeyActions::new("keys".into()), |actions, key| {
            actions.then(KeyAction::Down { value: key }).then(KeyAction::Up { value: key })
        });
        self.wait(self.client.perform_actions(actions));
    }

    /// Presses a key while another one is held.
    pub(crate) fn press_with(&self, held: Key, key: char) {
        let held = char::from(held);
        let actions = [held, key, key, held].into_iter().zip([true, true, false, false]);
        let actions = actions.fold(KeyActions::new("keys".into()), |actions, (value, down)| {
            actions.then(if down { KeyAction::Down { value } } else { KeyAction::Up { value } })
        });
        self.wait(self.client.perform_actions(actions));
    }

    /// The text of an element as it is written, not as it is seen.
    pub(crate) fn text(&self, selector: &str) -> String {
        self.run("return document.querySelector(arguments[0]).textContent", &[json!(selector)])
    }

    /// A command of the browser's own protocol for developers.
    pub(crate) fn tell(&self, command: &str, parameters: &Value) -> Value {
        self.ask("goog/cdp/execute", &json!({ "cmd": command, "params": parameters }))
    }

    fn ask(&self, what: &str, question: &Value) -> Value {
        let address = format!("{}/session/{}/{what}", self.driver.address, self.session);
        let body = question.to_string();
        let headers = [("content-type", "application/json")];
        let reply = http::request("POST", &address, &headers, body.as_bytes());
        assert_eq!(reply.status, 200, "{}", reply.text());
        reply.json()["value"].take()
    }

    /// What was said since this was asked last: `browser` is the console.
    pub(crate) fn said(&self, kind: &str) -> Vec<Said> {
        serde_json::from_value(self.ask("se/log", &json!({ "type": kind }))).unwrap()
    }

    /// What the console has of errors and warnings since this was asked last.
    pub(crate) fn complaints(&self) -> Vec<Said> {
        let is_one = |said: &Said| {
            (said.level == "SEVERE" || said.level == "WARNING")
                // The run that was asked about is over, which only the reply could tell.
                && !said.message.ends_with("the server responded with a status of 410 (Gone)")
        };
        self.said("browser").into_iter().filter(is_one).collect()
    }

    pub(crate) fn assert_no_complaints(&self) {
        let complaints = self.complaints();
        assert!(complaints.is_empty(), "{complaints:#?}");
    }

    /// The folder where downloads go.
    pub(crate) fn downloads(&self) -> PathBuf {
        self.driver.folder.path().join("downloads")
    }

    /// Writes down what the page showed when a test failed.
    fn report(&self) -> Option<()> {
        self.runtime.block_on(async {
            let limit = Duration::from_secs(5);
            let shown = "return [location.href, document.body.innerText]";
            let asked = timeout(limit, self.client.execute(shown, Vec::new()));
            let shown = asked.await.ok()?.ok()?;
            eprintln!("the page {} showed:\n{}", shown[0].as_str()?, shown[1].as_str()?);
            eprintln!("the console had {:#?}", self.said("browser"));
            let picture = timeout(limit, self.client.screenshot()).await.ok()?.ok()?;
            let name = thread::current().name()?.replace("::", "-");
            let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
            let file = folder.join(format!("{name}.png"));
            fs::write(&file, picture).ok()?;
            eprintln!("a screenshot of it: {}", file.display());
            Some(())
        })
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        if thread::panicking() {
            self.report();
        }
        // Then the driver is ended in any case.
        let closing = self.client.clone().close();
        let _ = self.runtime.block_on(async { timeout(Duration::from_secs(10), closing).await });
    }
}
