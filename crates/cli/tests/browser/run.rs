//! Running and stopping the bundled strategies on the page.

use mmsim_solvers::BundledStrategy;

use crate::browser::{Browser, wait_for, with_page};
use crate::page::Panel;
use crate::simulator::bundled;

const RUN: &str = ".run [name=run]";
const STOP: &str = ".run [name=stop]";

fn is_running(live: Panel<'_>) -> bool {
    live.attribute(".run", "data-running") == "true"
}

fn options(browser: &Browser, live: Panel<'_>) -> Vec<String> {
    let script =
        "return [...document.querySelectorAll(arguments[0])].map((option) => option.value)";
    browser.run(script, &[live.part("[name=strategy] option").into()])
}

#[test]
fn each_strategy_runs_and_stops() {
    // A maze in which wall followers reach the goal.
    with_page(&["hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_until_empty();
        let names: Vec<_> = BundledStrategy::ALL.iter().map(|one| one.name()).collect();
        assert_eq!(options(browser, live), names);
        for &strategy in BundledStrategy::ALL {
            let name = strategy.name();
            // Run the strategy slowly, then stop it.
            live.choose("[name=strategy]", name);
            assert_eq!(live.text(".run .about"), strategy.about());
            live.set_pace("×¼");
            let is_first = simulator.info().states == 0;
            live.click(RUN);
            if !is_first {
                // The states of the client below are not deleted without confirmation.
                let is_asking = "return document.querySelector('#confirm').open";
                wait_for("the dialog", || browser.run::<bool>(is_asking, &[]).then_some(()));
                browser.click("#confirm [value=confirm]");
            }
            wait_for("a mouse", || is_running(live).then_some(()));
            wait_for("some states", || {
                let states = live.data("states").parse::<usize>().unwrap();
                (states > 2).then_some(())
            });
            live.click(STOP);
            wait_for("the mouse to stop", || (!is_running(live)).then_some(()));
            let result = live.text(".run .result");
            assert!(result.starts_with("stopped; goal "), "{result}");
            assert_eq!(live.text(".run .name"), name);
            let states = simulator.info().states;
            live.wait_for_run_state(simulator.run_number(), states - 1);
            assert_eq!(live.position(), format!("State {0} of {0}", states - 1));

            // Run the strategy at full speed to the goal.
            live.set_pace("no limit");
            live.click(RUN);
            let result = wait_for("the goal", || {
                let result = live.text(".run .result");
                result.contains("goal reached").then_some(result)
            });
            assert!(!is_running(live));
            let steps = simulator.info().states - 1;
            live.wait_for_run_state(simulator.run_number(), steps);
            assert_eq!(live.text(".steps dd"), steps.to_string());
            let visited = live.text(".visited dd");
            // In between, the text may list the steps of each phase.
            assert!(result.starts_with(&format!("goal reached; {steps} steps")), "{result}");
            assert!(result.ends_with(&format!(", {visited} cells visited")), "{result}");
            // The page shows the same states as a client's search.
            let states = simulator.search(&maze, strategy);
            live.wait_for_run_state(simulator.run_number(), states.len() - 1);
            assert_eq!(states.len() - 1, steps);
            live.assert_shows(&maze, &states);
        }
    });
}

#[test]
fn the_result_of_a_search_is_shown() {
    with_page(&["two-roads"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        live.set_pace("no limit");
        let script = "return [...document.querySelectorAll(arguments[0])]
            .filter((line) => line.checkVisibility()).map((line) => line.textContent)";
        let lines =
            || browser.run::<Vec<String>>(script, &[live.part(".outcome:not([hidden]) li").into()]);
        let has = |expected: &str| lines().iter().any(|line| line.starts_with(expected));
        let wait = |expected: &str| wait_for(expected, || has(expected).then_some(()));
        assert_eq!(lines(), [""; 0]);
        live.choose("[name=strategy]", "flood-fill");
        live.click(RUN);
        browser.wait_for_text(&live.part(".run .result"), "goal reached");
        wait(&format!("Goal found after {} steps", simulator.info().states - 1));
        wait("Shortest path not proven: unknown walls leave room for a path of ");
        assert!(has("Path found: "), "{:?}", lines());
        // Only the last state has a result.
        live.click("button[name=first]");
        live.wait_for_state(0);
        assert_eq!(lines(), [""; 0]);

        live.choose("[name=strategy]", "shortest-path-search");
        live.click(RUN);
        wait("Shortest path proven after ");
        wait("Path found: 44 steps, the optimum");
        assert!(has("Goal found after "), "{:?}", lines());
    });
}
