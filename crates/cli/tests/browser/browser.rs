//! A browser in a test: what it shows, what is done in it, and what it complains of.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use std::{fs, path::PathBuf};

use fantoccini::actions::{InputSource, KeyAction, KeyActions};
use fantoccini::elements::Element;
use fantoccini::key::Key;
use fantoccini::{Client, Locator};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use tokio::runtime::{self, Runtime};

use crate::driver::{Driver, missing};
use crate::http;

/// A condition that does not come true in this time never will.
const PATIENCE: Duration = Duration::from_secs(20);

/// Between two looks at a condition.
const LOOK: Duration = Duration::from_millis(10);

/// A laptop's screen.
pub(crate) const USUAL: (u32, u32) = (1280, 860);

/// One browser at a time: they take a processor each, and more.
static TURN: Mutex<()> = Mutex::new(());

/// A browser with one page.
pub(crate) struct Browser {
    client: Client,
    runtime: Runtime,
    driver: Driver,
    session: String,
    _turn: MutexGuard<'static, ()>,
}

/// Something that the browser says.
#[derive(Debug, Deserialize)]
pub(crate) struct Said {
    pub(crate) level: String,
    pub(crate) message: String,
}

/// Runs a test in a browser, which may complain of nothing. Where there is none there is no test.
pub(crate) fn browse(test: impl FnOnce(&Browser)) {
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let runtime = runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let Some(driver) = Driver::start() else { return missing() };
    let Some(client) = driver.open(&runtime, USUAL) else { return missing() };
    let session = runtime.block_on(client.session_id()).unwrap().unwrap();
    let browser = Browser { client, runtime, driver, session, _turn: turn };
    test(&browser);
    browser.assert_no_complaints();
}

impl Browser {
    fn wait<T, E: std::fmt::Display>(&self, answer: impl Future<Output = Result<T, E>>) -> T {
        self.runtime.block_on(answer).unwrap_or_else(|error| panic!("{error}"))
    }

    pub(crate) fn open(&self, address: &str) {
        self.wait(self.client.goto(address));
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

    /// Waits until an expression is true.
    pub(crate) fn until(&self, expression: &str) {
        let is = || self.run::<bool>(&format!("return Boolean({expression})"), &[]).then_some(());
        wait_for(expression, is);
    }

    pub(crate) fn find(&self, selector: &str) -> Element {
        self.wait(self.client.find(Locator::Css(selector)))
    }

    pub(crate) fn click(&self, selector: &str) {
        self.wait(self.find(selector).click());
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
        let is_one = |said: &Said| said.level == "SEVERE" || said.level == "WARNING";
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
            let asked = tokio::time::timeout(limit, self.client.execute(shown, Vec::new()));
            let shown = asked.await.ok()?.ok()?;
            eprintln!("the page {} showed:\n{}", shown[0], shown[1].as_str()?);
            let picture = tokio::time::timeout(limit, self.client.screenshot()).await.ok()?.ok()?;
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
        let _ = self
            .runtime
            .block_on(async { tokio::time::timeout(Duration::from_secs(10), closing).await });
    }
}

/// Waits until there is something, looking again and again.
pub(crate) fn wait_for<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(begun.elapsed() < PATIENCE, "waited in vain for {what}");
        thread::sleep(LOOK);
    }
}
