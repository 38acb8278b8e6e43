//! The page of a simulator: what a person finds there, by its names.

use mmsim_maze::{Cell, Maze};
use serde_json::json;

use crate::browser::{Browser, wait_for};
use crate::drawing::Drawing;
use crate::told::Told;

/// The page as a whole.
#[derive(Clone, Copy)]
pub(crate) struct Page<'a>(pub(crate) &'a Browser);

impl Page<'_> {
    /// A selector of the button of a maze.
    pub(crate) fn maze(path: &str) -> String {
        format!(r#"#mazes li[data-path="{path}"] button"#)
    }

    /// Chooses a maze of the list, which the page then serves or asks about.
    pub(crate) fn choose_maze(self, path: &str) {
        let maze = Self::maze(path);
        wait_for("the list", || self.0.is_there(&maze).then_some(()));
        self.0.click(&maze);
    }

    /// The names of the mazes that the list shows.
    pub(crate) fn mazes(self) -> Vec<String> {
        let script = "return [...document.querySelectorAll('#mazes li')]
            .filter((item) => item.offsetParent !== null)
            .map((item) => item.querySelector('.name').textContent)";
        self.0.run(script, &[])
    }
}

/// A panel of the page, which shows one source of states.
#[derive(Clone, Copy)]
pub(crate) struct Panel<'a> {
    pub(crate) browser: &'a Browser,
    pub(crate) source: &'a str,
}

impl<'a> Panel<'a> {
    pub(crate) fn live(browser: &'a Browser) -> Self {
        Self { browser, source: "live" }
    }

    /// A selector of something in this panel.
    pub(crate) fn part(&self, selector: &str) -> String {
        format!(r#".panel[data-source="{}"] {selector}"#, self.source)
    }

    pub(crate) fn text(&self, selector: &str) -> String {
        self.browser.text(&self.part(selector))
    }

    pub(crate) fn click(&self, selector: &str) {
        self.browser.click(&self.part(selector));
    }

    /// What it says of itself: `at`, `states`, `run`, `following`, `rush`, `solved`.
    pub(crate) fn says(&self, what: &str) -> String {
        let script = "return document.querySelector(arguments[0])?.dataset[arguments[1]] ?? 'none'";
        self.browser.run(script, &[json!(self.part("").trim_end()), json!(what)])
    }

    /// Waits until it shows the state with this number, counted from 0.
    pub(crate) fn wait_at(&self, at: usize) {
        let expected = at.to_string();
        wait_for(&format!("state {at} in {}", self.source), || {
            (self.says("at") == expected).then_some(())
        });
    }

    /// Waits until it is about this run.
    pub(crate) fn wait_run(&self, run: u64) {
        let expected = run.to_string();
        wait_for(&format!("run {run}"), || (self.says("run") == expected).then_some(()));
    }

    /// Waits until it shows this state of this run.
    pub(crate) fn wait_run_at(&self, run: u64, at: usize) {
        self.wait_run(run);
        self.wait_at(at);
    }

    /// An attribute of a part.
    pub(crate) fn says_of(&self, selector: &str, attribute: &str) -> String {
        let script =
            "return document.querySelector(arguments[0]).getAttribute(arguments[1]) ?? 'none'";
        self.browser.run(script, &[json!(self.part(selector)), json!(attribute)])
    }

    /// Chooses from a list by the value.
    pub(crate) fn choose(&self, selector: &str, value: &str) {
        let script = "
            const list = document.querySelector(arguments[0]);
            list.value = arguments[1];
            list.dispatchEvent(new Event('change', { bubbles: true }));
            return list.value;";
        let chosen: String = self.browser.run(script, &[json!(self.part(selector)), json!(value)]);
        assert_eq!(chosen, value);
    }

    /// Waits until there is a map without a state.
    pub(crate) fn wait_empty(&self) {
        wait_for("an empty map", || {
            (self.says("at").is_empty() && self.says("states") == "0").then_some(())
        });
    }

    /// Fails unless the state that was told last is shown, all of it, once states have stopped rushing.
    pub(crate) fn assert_shows(&self, maze: &Maze, told: &[Told]) {
        wait_for("a calm page", || (self.says("rush") == "false").then_some(()));
        let trail: Vec<Cell> = told.iter().rev().take(500).rev().map(|told| told.cell).collect();
        Drawing::of(maze, told.last(), &trail)
            .assert_shown(&Drawing::shown(self.browser, self.source));
        if let Some(last) = told.last() {
            let visited = last.walls.iter().filter(|&walls| walls & 1 != 0).count();
            assert_eq!(self.text(".visited dd"), visited.to_string());
        }
    }

    /// What stands beside the slider, such as `state 120 of 412`.
    pub(crate) fn place(&self) -> String {
        self.text(".place")
    }
}
