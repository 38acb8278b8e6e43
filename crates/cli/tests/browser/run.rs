//! Run and Stop.

use mmsim_solvers::BundledStrategy;

use crate::browser::{Browser, wait_for, watch};
use crate::page::Panel;
use crate::simulator::bundled;

const RUN: &str = ".run [name=run]";
const STOP: &str = ".run [name=stop]";

fn is_running(live: Panel<'_>) -> bool {
    live.says_of(".run", "data-running") == "true"
}

fn options(browser: &Browser, live: Panel<'_>) -> Vec<String> {
    let script =
        "return [...document.querySelectorAll(arguments[0])].map((option) => option.value)";
    browser.run(script, &[live.part("[name=strategy] option").into()])
}

#[test]
fn each_bundled_mouse_runs_and_stops() {
    // Where a wall follower reaches the goal as well.
    watch(&["--maze", "hedgerow"], |browser, simulator| {
        let maze = bundled("05-hedgerow.txt");
        let live = Panel::live(browser);
        live.wait_empty();
        assert_eq!(
            options(browser, live),
            BundledStrategy::ALL.iter().map(|one| one.name()).collect::<Vec<_>>()
        );
        for strategy in BundledStrategy::ALL {
            let name = strategy.name();
            // Slowly, until it is stopped.
            live.choose("[name=strategy]", name);
            assert_eq!(live.text(".run .about"), strategy.about());
            live.choose("[name=pace]", "50");
            live.click(RUN);
            wait_for("a mouse", || is_running(live).then_some(()));
            wait_for("some states", || {
                let places = live.says("states").parse::<usize>().unwrap();
                (places > 2 && places < 20).then_some(())
            });
            live.click(STOP);
            wait_for("its end", || (!is_running(live)).then_some(()));
            let said = live.text(".run .says");
            assert!(said.starts_with(&format!("{name}: stopped after ")), "{said}");
            let states = simulator.info().states;
            live.wait_run_at(simulator.run(), states - 1);
            assert_eq!(live.place(), format!("state {states} of {states}"));

            // At full speed, to the goal.
            live.choose("[name=pace]", "0");
            live.click(RUN);
            let said = wait_for("the goal", || {
                let said = live.text(".run .says");
                said.contains("goal reached").then_some(said)
            });
            assert!(!is_running(live));
            let steps = simulator.info().states - 1;
            live.wait_run_at(simulator.run(), steps);
            assert_eq!(live.text(".steps dd"), steps.to_string());
            let visited = live.text(".visited dd");
            let expected =
                format!("{name}: goal reached after {steps} steps, {visited} cells visited");
            assert_eq!(said, expected);
            // What the same mouse tells is what it did.
            let told = simulator.search(&maze, strategy);
            live.wait_run_at(simulator.run(), told.len() - 1);
            assert_eq!(told.len() - 1, steps);
            live.assert_shows(&maze, &told);
        }
    });
}
