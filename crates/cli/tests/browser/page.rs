//! Page objects: the page of a simulator and its panels.

use mmsim_maze::{Heading, Maze, Pose};
use mmsim_run::{MovementRules, Phases, Trail};
use serde_json::json;

use crate::browser::Browser;
use crate::drawing::Drawing;
use crate::test_state::TestState;

#[derive(Clone, Copy)]
pub(crate) struct Page<'a>(pub(crate) &'a Browser);

impl Page<'_> {
    /// Returns the selector of a maze's button.
    pub(crate) fn maze_selector(path: &str) -> String {
        format!(r#"#mazes li[data-path="{path}"] button"#)
    }

    /// Clicks a maze in the list.
    pub(crate) fn choose_maze(self, path: &str) {
        let maze = Self::maze_selector(path);
        self.0.wait_until_exists(&maze);
        self.0.click(&maze);
    }

    /// Returns the names of the visible mazes in the list.
    pub(crate) fn maze_names(self) -> Vec<String> {
        let script = "return [...document.querySelectorAll('#mazes li[data-path]')]
            .filter((item) => item.offsetParent !== null)
            .map((item) => item.querySelector('.name').textContent)";
        self.0.run(script, &[])
    }
}

/// A panel, which shows one source of states.
#[derive(Clone, Copy)]
pub(crate) struct Panel<'a> {
    pub(crate) browser: &'a Browser,
    pub(crate) source: &'a str,
}

impl<'a> Panel<'a> {
    pub(crate) fn live(browser: &'a Browser) -> Self {
        Self { browser, source: "live" }
    }

    /// Returns the selector restricted to this panel.
    pub(crate) fn part(&self, selector: &str) -> String {
        format!(r#".panel[data-source="{}"] {selector}"#, self.source)
    }

    pub(crate) fn text(&self, selector: &str) -> String {
        self.browser.text(&self.part(selector))
    }

    pub(crate) fn click(&self, selector: &str) {
        self.browser.click(&self.part(selector));
    }

    /// Returns one of the data attributes `index`, `states`, `run`, `following`, `kept` or `proven`.
    pub(crate) fn data(&self, name: &str) -> String {
        let script = "return document.querySelector(arguments[0])?.dataset[arguments[1]] ?? 'none'";
        self.browser.run(script, &[json!(self.part("").trim_end()), json!(name)])
    }

    /// Waits until the data attributes have these values.
    fn wait_for_data(&self, what: &str, expected: &[(&str, &str)]) {
        let script = "
            const { dataset } = document.querySelector(arguments[0]) ?? {};
            return dataset && arguments[1].every(([name, value]) => dataset[name] === value);";
        let arguments = [json!(self.part("").trim_end()), json!(expected)];
        let _: bool = self.browser.wait_until(what, script, &arguments);
    }

    /// Waits until the panel shows the state with this index.
    pub(crate) fn wait_for_state(&self, at: usize) {
        let what = format!("state {at} in {}", self.source);
        self.wait_for_data(&what, &[("index", &at.to_string())]);
    }

    /// Moves the slider to the state with this index, as if the user had dragged it. Waits until the
    /// panel shows the state.
    pub(crate) fn slide_to(&self, at: usize) {
        let script = "
            const slider = document.querySelector(arguments[0]);
            slider.value = arguments[1];
            slider.dispatchEvent(new Event('input', { bubbles: true }));";
        self.browser.run::<()>(script, &[json!(self.part("[name=slider]")), json!(at)]);
        self.wait_for_state(at);
    }

    /// Waits until the page keeps this number of states, so that it can show them without the simulator.
    pub(crate) fn wait_until_kept(&self, states: usize) {
        self.wait_for_data("a kept run", &[("kept", &states.to_string())]);
    }

    /// Waits until the panel has loaded this run.
    pub(crate) fn wait_for_run(&self, run: u64) {
        self.wait_for_data(&format!("run {run}"), &[("run", &run.to_string())]);
    }

    /// Waits until the panel shows this state of this run.
    pub(crate) fn wait_for_run_state(&self, run: u64, at: usize) {
        self.wait_for_run(run);
        self.wait_for_state(at);
    }

    /// Returns an attribute of an element in this panel.
    pub(crate) fn attribute(&self, selector: &str, attribute: &str) -> String {
        let script =
            "return document.querySelector(arguments[0]).getAttribute(arguments[1]) ?? 'none'";
        self.browser.run(script, &[json!(self.part(selector)), json!(attribute)])
    }

    /// Chooses the option with this value in a list.
    pub(crate) fn choose(&self, selector: &str, value: &str) {
        let script = "
            const list = document.querySelector(arguments[0]);
            list.value = arguments[1];
            list.dispatchEvent(new Event('change', { bubbles: true }));
            return list.value;";
        let chosen: String = self.browser.run(script, &[json!(self.part(selector)), json!(value)]);
        assert_eq!(chosen, value);
    }

    /// Moves the slider to a pace such as `×1` or `no limit`.
    pub(crate) fn set_pace(&self, pace: &str) {
        let script = "
            const slider = document.querySelector(arguments[0]);
            const output = document.querySelector(arguments[1]);
            for (let at = 0; at <= Number(slider.max); at++) {
                slider.value = at;
                slider.dispatchEvent(new Event('input', { bubbles: true }));
                if (output.textContent === arguments[2]) return true;
            }
            return false;";
        let parts = ["[name=pace]", ".pace output"].map(|part| json!(self.part(part)));
        let [slider, output] = parts;
        assert!(self.browser.run::<bool>(script, &[slider, output, json!(pace)]), "{pace}");
    }

    /// Waits until the panel shows a maze without states.
    pub(crate) fn wait_until_empty(&self) {
        self.wait_for_data("an empty map", &[("index", ""), ("states", "0")]);
    }

    /// Asserts that the map and the number of visited cells match the last state.
    pub(crate) fn assert_shows(&self, maze: &Maze, states: &[TestState]) {
        let (mut trail, mut phases) = (Trail::new(maze.size()), Phases::default());
        let rules = MovementRules::from_maze(maze);
        for state in states {
            let pose = Pose::new(state.cell, Heading::from_letter(state.heading).unwrap());
            phases.add(&rules, pose, false);
            trail.add(&rules, &phases);
        }
        Drawing::expected(maze, states.last(), &trail.passages())
            .assert_shown(&Drawing::on_page(self.browser, self.source));
        if let Some(last) = states.last() {
            let visited = last.walls.iter().filter(|&walls| walls & 1 != 0).count();
            assert_eq!(self.text(".visited dd"), visited.to_string());
        }
    }

    /// Returns the text next to the slider, such as `State 119 of 411`.
    pub(crate) fn position(&self) -> String {
        self.text(".position")
    }
}
