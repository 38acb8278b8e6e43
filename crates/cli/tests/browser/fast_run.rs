//! Fast runs that the page plays in time, as ghosts of each other.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs::File;

use mmsim_fastrun::{FastRun, Planner, Route, Trajectory, Vehicle, fastest};
use mmsim_maze::{Heading, Maze, Walls};
use mmsim_protocol::Annotation;
use mmsim_run::DRIVEN_RUN;
use mmsim_solvers::BundledStrategy;
use serde_json::json;

use crate::browser::{wait_for, with_browser, with_page};
use crate::clock::Clock;
use crate::harness::{Home, recorded};
use crate::layout::{LAPTOP, PHONE, SMALL, assert_in_sight, assert_no_sideways_scrolling, resize};
use crate::notes::annotations;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled};
use crate::test_state::{TestState, VISITED};

/// The greatest distance between a mouse on the page and the mouse of the crate, in mm.
const TOLERANCE: f64 = 0.5;

/// Calculates the run along each route with the crate.
fn trajectories(maze: &Maze, vehicle: &Vehicle) -> [(&'static str, Trajectory); 3] {
    let (walls, start, goals) = (maze.walls(), maze.start().cell, maze.goals());
    let best = fastest(walls, start, goals, vehicle).unwrap();
    let along = |route: Route| {
        let cells = route.cells(walls, start, goals).unwrap();
        let mut planner = Planner::new(vehicle.clone());
        planner.plan_along(walls.size(), &cells).unwrap().drive(vehicle).unwrap()
    };
    [
        ("fastest", best.drive(vehicle).unwrap()),
        ("fewest-cells", along(Route::FewestCells)),
        ("fewest-turns", along(Route::FewestTurns)),
    ]
}

/// Returns the walls of a state. Everything that the mouse has not seen counts as a wall.
fn known_walls(state: &TestState) -> Walls {
    let mut walls = Walls::closed(state.size);
    let is_visited = |cell| state.walls[state.index(cell)] & VISITED != 0;
    for cell in state.size.cells().filter(|&cell| is_visited(cell)) {
        for side in Heading::ALL.into_iter().filter(|side| !state.has_wall(cell, side.letter())) {
            walls.set(cell, side, false);
        }
    }
    walls
}

/// The fast runs of a panel.
#[derive(Clone, Copy)]
struct Runs<'a>(Panel<'a>);

impl Runs<'_> {
    /// Waits until the panel shows the run along a route with this duration.
    fn wait_for_duration(self, route: &str, seconds: f64) {
        let expected = format!("{seconds:.3} s");
        let duration = format!(".routes [data-route={route}] .duration");
        self.0.browser.wait_for_text(&self.0.part(&duration), &expected);
    }

    /// Waits until the panel explains that there is no run over known walls.
    fn wait_for_unknown_path(self) {
        let reason = "The mouse does not know a path to the goal in this state.";
        wait_for("the reason", || {
            let row = ".routes [data-route=known-walls]";
            let is_listed = self.0.browser.exists(&self.0.part(row));
            (is_listed && self.0.attribute(row, "title") == reason).then_some(())
        });
    }

    /// Moves the slider to a time in ms, as if the user had dragged it.
    fn slide_to(self, ms: u32) {
        let script = "
            const slider = document.querySelector(arguments[0]);
            slider.value = arguments[1];
            slider.dispatchEvent(new Event('input', { bubbles: true }));";
        self.0.browser.run::<()>(script, &[json!(self.0.part("[name=time]")), json!(ms)]);
    }

    /// Returns the shown time in s.
    fn time(self) -> f64 {
        self.0.text(".clock").trim_end_matches(" s").parse().unwrap()
    }

    /// Returns the transformation of each mouse on the map.
    fn transforms(self) -> BTreeMap<String, String> {
        let script = "return Object.fromEntries([...document.querySelectorAll(arguments[0])]
            .map((mouse) => [mouse.dataset.route, mouse.getAttribute('transform')]))";
        self.0.browser.run(script, &[json!(self.0.part(".map .fast-mouse"))])
    }

    /// Asserts that the mice on the map are where the crate's mice are at a time in s.
    fn assert_are_at(self, maze: &Maze, driven: &[(&str, Trajectory)], time: f64) {
        let transforms = self.transforms();
        for (route, trajectory) in driven {
            let expected = trajectory.at(time);
            let transform = transforms[*route].as_str();
            let (x, y, heading) = position(transform, maze, trajectory.half_cell());
            let off = (x - expected.x).hypot(y - expected.y);
            assert!(off < TOLERANCE, "{route} at {time} s: {off} mm off");
            let turned = (heading - expected.heading * 180.0 / PI).rem_euclid(360.0);
            assert!(turned.min(360.0 - turned) < 0.1, "{route} at {time} s: {turned}° off");
        }
    }

    fn mice(self) -> usize {
        let script = "return document.querySelectorAll(arguments[0]).length";
        self.0.browser.run(script, &[json!(self.0.part(".map .fast-mouse"))])
    }

    fn is_playing(self) -> bool {
        self.0.attribute("[name=drive]", "aria-pressed") == "true"
    }
}

/// Returns the position in mm and the heading in degrees of a mouse with this transformation.
fn position(transform: &str, maze: &Maze, half_cell: f64) -> (f64, f64, f64) {
    let numbers: Vec<f64> = transform
        .split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
        .filter_map(|number| number.parse().ok())
        .collect();
    let [x, y, angle] = numbers[..] else { panic!("{transform}") };
    // A cell is 20 units wide. The page measures from the top and turns clockwise from north.
    let height = 20.0 * f64::from(maze.size().height());
    (x * half_cell / 10.0, (height - y) * half_cell / 10.0, 90.0 - angle)
}

#[test]
fn three_ghosts_are_where_the_crate_says() {
    with_page(&["winding-river"], |browser, _| {
        let (live, maze) = (Panel::live(browser), bundled("08-winding-river.txt"));
        live.wait_until_empty();
        live.click("[name=fast-run]");
        let runs = Runs(live);
        for vehicle in [Vehicle::expert(), Vehicle::ukmars(), Vehicle::ares(), Vehicle::kerise()] {
            live.choose("[name=vehicle]", vehicle.name());
            let driven = trajectories(&maze, &vehicle);
            for (route, trajectory) in &driven {
                runs.wait_for_duration(route, trajectory.duration());
            }
            assert_eq!(runs.mice(), 3);
            let longest = driven.iter().map(|(_, it)| it.duration()).fold(0.0, f64::max);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let end = (longest * 1000.0).ceil() as u32;
            for ms in (0..40).map(|step| step * end / 39) {
                runs.slide_to(ms);
                runs.assert_are_at(&maze, &driven, f64::from(ms) / 1000.0);
            }
            // The figures are those of the fastest run.
            let (_, best) = &driven[0];
            let expected = [
                format!("{:.3} s", best.duration()),
                format!("{:.3} s", best.gate_to_gate(maze.goals())),
                format!("{:.2} m", best.length() / 1000.0),
            ];
            let facts = [".facts .rest", ".facts .gate", ".facts .length"];
            assert_eq!(facts.map(|fact| live.text(fact)), expected);
            let ms = end / 3;
            runs.slide_to(ms);
            let speed = best.at(f64::from(ms) / 1000.0).speed / 1000.0;
            assert_eq!(live.text(".speed-now"), format!("{speed:.2} m/s"));
            let loss = 100.0 * (driven[2].1.duration() / best.duration() - 1.0);
            let loss = if loss < 0.05 { "same".into() } else { format!("+{loss:.1} %") };
            assert_eq!(live.text(".routes [data-route=fewest-turns] .loss"), loss);
            // The chart ends at the end of the longest run.
            let view_box = live.attribute(".speeds svg", "viewBox");
            assert_eq!(view_box, format!("0 0 {end} 100"));
        }
    });
}

#[test]
fn the_playback_runs_pauses_and_changes_its_speed() {
    with_page(&["winding-river"], |browser, _| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        browser.press(['f']);
        let (maze, runs) = (bundled("08-winding-river.txt"), Runs(live));
        let driven = trajectories(&maze, &Vehicle::expert());
        let duration = |index: usize| driven[index].1.duration();
        assert!(duration(0) + 0.1 < duration(1) && duration(1) + 0.1 < duration(2));
        let slowest = duration(2);
        runs.wait_for_duration("fewest-turns", slowest);
        assert_eq!(live.text(".clock"), "0.000 s");
        let clock = Clock::stop(browser);
        browser.press([' ']);
        assert!(runs.is_playing());
        let mut expected = 0.0;
        for (rate, factor) in [("1", 1.0), ("0.25", 0.25), ("0.5", 0.5), ("2", 2.0), ("4", 4.0)] {
            live.click(&format!("[name=rate][value='{rate}']"));
            clock.advance(0);
            for ms in [100, 17] {
                clock.advance(ms);
                expected += factor * f64::from(ms) / 1000.0;
                assert!((runs.time() - expected).abs() < 0.00051, "{} {expected}", runs.time());
                assert!(runs.is_playing());
            }
        }
        // A pause shows whole milliseconds, and the clock has no effect on it.
        live.click("[name=drive]");
        assert!(!runs.is_playing());
        clock.advance(100);
        let paused = runs.time();
        assert!((paused - expected).abs() < 0.00051, "{paused} {expected}");
        runs.assert_are_at(&maze, &driven, paused);
        clock.restart();
        // The keys move by hundredths and tenths of a second.
        runs.slide_to(500);
        browser.press(['\u{e014}', '\u{e014}']);
        assert_eq!(live.text(".clock"), "0.520 s");
        browser.press(['\u{e010}']);
        assert!((runs.time() - slowest).abs() < 0.001);
        // The playback begins again after the end, and ends with the last mouse.
        live.click("[name=rate][value='4']");
        let clock = Clock::stop(browser);
        browser.press([' ']);
        clock.advance(60_000);
        assert!(!runs.is_playing());
        clock.restart();
        assert!((runs.time() - slowest).abs() < 0.001);
        runs.assert_are_at(&maze, &driven, 100.0);
        // A hidden mouse no longer counts. The selected curve has the colours of the speed.
        live.click(".routes [data-route=fewest-turns] [name=show]");
        assert_eq!(runs.mice(), 2);
        assert!(live.text(".end").contains(&format!("{:.3}", duration(1))));
        live.click(".routes [data-route=fewest-cells] [name=select]");
        assert_eq!(live.text(".facts-title"), "Fewest cells");
        // Another vehicle changes neither the time nor the playback.
        runs.slide_to(1000);
        let clock = Clock::stop(browser);
        browser.press([' ']);
        clock.advance(0);
        live.choose("[name=vehicle]", "ares");
        let ares = trajectories(&maze, &Vehicle::ares());
        runs.wait_for_duration("fastest", ares[0].1.duration());
        assert!(runs.is_playing());
        clock.advance(2000);
        assert_eq!(live.text(".clock"), "9.000 s");
        runs.assert_are_at(&maze, &ares[..1], 9.0);
        clock.restart();
        live.click("[name=search]");
        assert!(!browser.is_visible(&live.part(".drive")) && runs.mice() == 0);
        assert!(browser.is_visible(&live.part(".history")));
    });
}

#[test]
fn an_unreachable_goal_and_unknown_walls_are_explained() {
    with_page(&["mirage"], |browser, simulator| {
        let (live, maze) = (Panel::live(browser), bundled("06-mirage.txt"));
        live.wait_until_empty();
        let states = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let last = states.len() - 1;
        live.wait_for_state(last);
        live.slide_to(3);
        live.click("[name=fast-run]");
        let (runs, vehicle) = (Runs(live), Vehicle::expert());
        runs.wait_for_duration("fastest", trajectories(&maze, &vehicle)[0].1.duration());
        runs.wait_for_unknown_path();
        // In the last state, the mouse knows a path.
        live.click("[name=search]");
        live.slide_to(last);
        live.click("[name=fast-run]");
        let walls = known_walls(&states[last]);
        let run = fastest(&walls, maze.start().cell, maze.goals(), &vehicle).unwrap();
        let trajectory = run.drive(&vehicle).unwrap();
        runs.wait_for_duration("known-walls", trajectory.duration());
        assert_eq!(runs.mice(), 3);
        live.click(".routes [data-route=known-walls] [name=show]");
        runs.slide_to(1700);
        runs.assert_are_at(&maze, &[("known-walls", trajectory)], 1.7);
        // Another maze replaces the runs.
        Page(browser).choose_maze("unreachable-closed-garden.txt");
        browser.click("#confirm [value=confirm]");
        let reason = "Goal unreachable from (0, 0): walls cut off every goal cell.";
        wait_for(reason, || (live.text(".message") == reason).then_some(()));
        assert_eq!(runs.mice(), 0);
        assert!(!browser.is_visible(&live.part(".facts")));
        assert_eq!(live.attribute("[name=drive]", "disabled"), "");
        assert!(!browser.is_visible("#error"));
    });
}

#[test]
fn a_run_that_the_mouse_has_driven_is_played_on_its_curves() {
    with_page(&["two-roads"], |browser, simulator| {
        let (live, maze, vehicle) =
            (Panel::live(browser), bundled("10-two-roads.txt"), Vehicle::expert());
        live.wait_until_empty();
        simulator.search(&maze, BundledStrategy::FloodFill);
        let planned = fastest(maze.walls(), maze.start().cell, maze.goals(), &Vehicle::ares());
        let text = planned.unwrap().to_string();
        simulator.send(&annotations(&[Annotation::Log(&format!("{DRIVEN_RUN}{text}"))]));
        live.click("[name=fast-run]");
        let run = FastRun::parse(maze.start().cell, &text).unwrap();
        let run = run.with_fastest_speeds(&vehicle).unwrap().drive(&vehicle).unwrap();
        let runs = Runs(live);
        runs.wait_for_duration("driven", run.duration());
        for ms in [500, 1000, 1500] {
            runs.slide_to(ms);
            runs.assert_are_at(&maze, &[("driven", run.clone())], f64::from(ms) / 1000.0);
        }
        assert!(!browser.is_visible("#error"));
    });
}

#[test]
fn a_driven_run_does_not_replace_the_route_that_the_user_has_chosen() {
    with_page(&["two-roads"], |browser, simulator| {
        let (live, maze) = (Panel::live(browser), bundled("10-two-roads.txt"));
        live.wait_until_empty();
        live.click("[name=fast-run]");
        let runs = Runs(live);
        let driven = trajectories(&maze, &Vehicle::expert());
        runs.wait_for_duration("fewest-turns", driven[2].1.duration());
        live.click("[data-route=fewest-turns] [name=select]");
        simulator.search(&maze, BundledStrategy::FloodFill);
        let planned = fastest(maze.walls(), maze.start().cell, maze.goals(), &Vehicle::ares());
        let text = format!("{DRIVEN_RUN}{}", planned.unwrap());
        simulator.send(&annotations(&[Annotation::Log(&text)]));
        simulator.send(&TestState::new(0, maze.size()).message('F', 'F'));
        wait_for("the driven run", || {
            browser.exists(&live.part(".routes [data-route=driven]")).then_some(())
        });
        let selected = ".routes [data-route=fewest-turns] [name=select]";
        assert_eq!(live.attribute(selected, "aria-pressed"), "true");
    });
}

#[test]
fn fast_runs_fit_into_windows_of_all_sizes() {
    with_page(&["two-roads"], |browser, _| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        live.click("[name=fast-run]");
        let driven = trajectories(&bundled("10-two-roads.txt"), &Vehicle::expert());
        Runs(live).wait_for_duration("fastest", driven[0].1.duration());
        for size in [PHONE, SMALL, LAPTOP] {
            resize(browser, size);
            assert_no_sideways_scrolling(browser);
            if size != PHONE {
                let parts =
                    [".map svg", ".speeds", "[name=time]", "[name=drive]", ".routes", ".scale"];
                assert_in_sight(browser, live, &parts);
            }
        }
    });
}

#[test]
fn a_vehicle_from_a_file_is_selected() {
    with_browser(|browser| {
        let home = Home::new();
        let text = "base = \"expert\"\nturns.l90.speed = 1300\n";
        let file = home.write("slower.toml", text);
        let file = file.to_str().unwrap();
        let simulator = Simulator::start_in(home, &["two-roads", "--vehicle", file]);
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        live.wait_until_empty();
        live.click("[name=fast-run]");
        let vehicle = Vehicle::from_toml(text, "slower").unwrap();
        let driven = trajectories(&bundled("10-two-roads.txt"), &vehicle);
        Runs(live).wait_for_duration("fastest", driven[0].1.duration());
        let names =
            "return [...document.querySelector(arguments[0]).options].map((name) => name.text)";
        let names: Vec<String> = browser.run(names, &[json!(live.part("[name=vehicle]"))]);
        assert_eq!(names, ["ukmars", "ares", "expert", "kerise", "slower"]);
        browser.leave();
    });
}

#[test]
fn an_exported_page_plays_fast_runs() {
    with_browser(|browser| {
        let simulator = Simulator::start(&["meadow", "--record", "kept"]);
        let maze = bundled("oblong-long-meadow.txt");
        simulator.send(&TestState::new(0, maze.size()).message('C', 'C'));
        simulator.send(b"reset");
        let home: &Home = &simulator.home;
        let recording = recorded(&home.path().join("kept"));
        let text = "base = \"expert\"\nturns.l90.speed = 1300\n";
        let vehicle = home.write("my mouse.toml", text);
        let page = home.path().join("page.html");
        let [from, to, vehicle] = [&recording, &page, &vehicle].map(|path| path.to_str().unwrap());
        assert_eq!(home.run(&["export", from, "-o", to, "--vehicle", vehicle]).code, Some(0));
        browser.open(&format!("file://{}", page.display()));
        let panel = Panel { browser, source: "1" };
        panel.wait_for_state(0);
        panel.click("[name=fast-run]");
        let runs = Runs(panel);
        let mine = Vehicle::from_toml(text, "my mouse").unwrap();
        let driven = trajectories(&maze, &mine);
        for (route, trajectory) in &driven {
            runs.wait_for_duration(route, trajectory.duration());
        }
        runs.slide_to(1234);
        runs.assert_are_at(&maze, &driven, 1.234);
        // No other vehicle is offered, because all times are those of this one.
        let names =
            "return [...document.querySelector(arguments[0]).options].map((name) => name.text)";
        let names: Vec<String> = browser.run(names, &[json!(panel.part("[name=vehicle]"))]);
        assert_eq!(names, ["my mouse"]);
        assert_eq!(panel.text(".phases .vehicle"), "Times of my mouse");
        // The mouse has seen only the start cell.
        runs.wait_for_unknown_path();
        browser.leave();
    });
}

/// A client that records its own states does not know the true maze.
#[test]
fn an_exported_page_without_the_true_maze_plays_the_run_over_known_walls() {
    with_browser(|browser| {
        let simulator = Simulator::start(&["mirage"]);
        let maze = bundled("06-mirage.txt");
        let states = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let home: &Home = &simulator.home;
        let info = mmsim_server::Simulation::new("mirage", maze.clone()).info();
        let messages = states.iter().map(|state| (0, vec![], state.message('C', 'F')));
        let recording = home.path().join("run.mcap");
        let file = File::create(&recording).unwrap();
        let trailing = mmsim_recording::TrailingAnnotations::default();
        mmsim_recording::save(file, &info, None, messages, &trailing).unwrap();
        let page = home.path().join("page.html");
        let [from, to] = [&recording, &page].map(|path| path.to_str().unwrap());
        assert_eq!(home.run(&["export", from, "-o", to]).code, Some(0));
        browser.open(&format!("file://{}", page.display()));
        let panel = Panel { browser, source: "1" };
        panel.wait_for_state(states.len() - 1);
        panel.click("[name=fast-run]");
        let walls = known_walls(states.last().unwrap());
        let run = fastest(&walls, maze.start().cell, maze.goals(), &Vehicle::expert()).unwrap();
        let trajectory = run.drive(&Vehicle::expert()).unwrap();
        let runs = Runs(panel);
        runs.wait_for_duration("known-walls", trajectory.duration());
        assert_eq!(runs.mice(), 1);
        runs.slide_to(1700);
        runs.assert_are_at(&maze, &[("known-walls", trajectory)], 1.7);
        browser.leave();
    });
}
