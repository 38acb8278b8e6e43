//! Measurements of the page: its latency, its processor time, and how much it slows down the simulator. They print
//! results but do not check them against limits. Run them with:
//!
//! `cargo test --release -p mmsim --test browser -- --ignored --nocapture --test-threads=1`

use std::fs;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use mmsim_maze::WyRand;
use mmsim_solvers::BundledStrategy;
use serde_json::json;

use crate::browser::{Browser, with_browser, with_page};
use crate::harness::recorded;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled, connect};

/// The maximum number of unacknowledged states.
const MAX_PENDING: usize = 64;

/// The duration of each measurement.
const SPAN: Duration = Duration::from_secs(5);

/// Runs a search and returns its states as messages.
fn search(simulator: &Simulator) -> Vec<Vec<u8>> {
    let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
    simulator.send(b"reset");
    states.iter().map(|state| state.message('C', 'C')).collect()
}

/// Sends up to `rate` states per second without waiting for each reply, until `is_enough` returns
/// true for the number of acknowledged states. Returns that number.
fn stream(
    address: &str,
    messages: &[Vec<u8>],
    rate: f64,
    is_enough: impl Fn(usize) -> bool,
) -> usize {
    let socket = zmq::Context::new().socket(zmq::DEALER).unwrap();
    socket.set_linger(0).unwrap();
    socket.set_rcvtimeo(mmsim_tests::TIMEOUT_MS).unwrap();
    socket.connect(address).unwrap();
    let (begun, mut sent, mut acknowledged) = (Instant::now(), 0_usize, 0);
    let mut messages = messages.iter().cycle();
    while !is_enough(acknowledged) {
        #[expect(clippy::cast_precision_loss, reason = "far fewer than would lose any")]
        let is_due = (sent as f64) < begun.elapsed().as_secs_f64() * rate;
        if is_due && sent - acknowledged < MAX_PENDING {
            socket.send_multipart([&b""[..], messages.next().unwrap()], 0).unwrap();
            sent += 1;
        } else if sent > acknowledged {
            assert_eq!(socket.recv_multipart(0).unwrap()[1], b"ok");
            acknowledged += 1;
        } else {
            thread::sleep(Duration::from_micros(200));
        }
    }
    acknowledged
}

fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index of a short list"
    )]
    let index = ((values.len() - 1) as f64 * part).round() as usize;
    values[index]
}

fn summary(values: &mut [f64]) -> String {
    let [median, high, max] = [0.5, 0.95, 1.0].map(|part| quantile(values, part));
    format!("median {median:.1}, 95th percentile {high:.1}, max {max:.1} ms of {}", values.len())
}

fn print_load() {
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load before: {}", load.trim());
}

/// Measures frame times and counts the shown states while `work` runs.
fn frames(browser: &Browser, name: &str, work: impl FnOnce()) {
    let begin = r#"
        const recorded = window.recorded = { frames: [], shown: 0, ended: false };
        const record = (now) => {
            recorded.frames.push(now);
            if (!recorded.ended) requestAnimationFrame(record);
        };
        requestAnimationFrame(record);
        new MutationObserver(() => recorded.shown++)
            .observe(document.querySelector('[data-source="live"]'), { attributeFilter: ["data-index"] });"#;
    browser.run::<()>(begin, &[]);
    work();
    let end =
        "window.recorded.ended = true; return [window.recorded.frames, window.recorded.shown]";
    let (times, shown): (Vec<f64>, u32) = browser.run(end, &[]);
    let mut intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let span = times.last().unwrap() - times.first().unwrap();
    let rate = f64::from(shown) * 1e3 / span;
    println!("{name}: frames {}; {rate:.0} states shown per second", summary(&mut intervals));
}

#[test]
#[ignore = "measurement"]
fn frames_while_states_stream_in() {
    print_load();
    with_page(&["harbour"], |browser, simulator| {
        let messages = search(simulator);
        let live = Panel::live(browser);
        live.wait_until_empty();
        frames(browser, "idle", || thread::sleep(SPAN));
        for (name, rate) in [("20,000 states per second", 20_000.0), ("unlimited rate", 1e9)] {
            frames(browser, name, || {
                let begun = Instant::now();
                let sent = stream(&simulator.serving.address, &messages, rate, |_| {
                    begun.elapsed() >= SPAN
                });
                println!("{sent} states in {:.2} s", begun.elapsed().as_secs_f64());
            });
            live.wait_for_state(simulator.info().states - 1);
            simulator.send(b"reset");
            live.wait_for_run(simulator.run_number());
            live.wait_until_empty();
        }
    });
}

/// Measures the processor time of the page for each state that the slider shows.
#[test]
#[ignore = "measurement"]
fn the_processor_time_of_a_shown_state() {
    const ROUNDS: usize = 5;
    print_load();
    with_page(&["harbour"], |browser, simulator| {
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        Panel::live(browser).wait_for_state(states.len() - 1);
        browser.devtools("Performance.enable", &json!({}));
        let seconds = |metric: &str| {
            let metrics = browser.devtools("Performance.getMetrics", &json!({}));
            let mut metrics = metrics["metrics"].as_array().unwrap().iter();
            metrics.find(|one| one["name"] == metric).unwrap()["value"].as_f64().unwrap()
        };
        let metrics = ["TaskDuration", "ScriptDuration", "RecalcStyleDuration", "LayoutDuration"];
        let positions: Vec<usize> = (0..states.len()).collect();
        let mut times = metrics.map(|_| Vec::new());
        for _ in 0..ROUNDS {
            let before = metrics.map(&seconds);
            let shown: Vec<(f64, f64)> = browser.run_async(SCRUB, &[json!(positions)]);
            assert_eq!(shown.len(), states.len());
            for ((times, metric), before) in times.iter_mut().zip(metrics).zip(before) {
                let ms = (seconds(metric) - before) * 1e3;
                #[expect(clippy::cast_precision_loss, reason = "few states")]
                times.push(ms / states.len() as f64);
            }
        }
        for (metric, times) in metrics.iter().zip(&mut times) {
            println!("{metric}: {:.2} ms for each shown state", quantile(times, 0.5));
        }
    });
}

/// Measures how much open windows slow down the requests of a mouse. The client and the server stay
/// on one processor. Otherwise the rate depends most on the processors that they are moved to.
#[test]
#[ignore = "measurement"]
fn the_rate_of_states_beside_open_windows() {
    const ROUNDS: usize = 15;
    const WINDOWS: [usize; 3] = [0, 1, 6];
    print_load();
    with_browser(|browser| {
        let simulator = Simulator::start(&["harbour"]);
        let messages = search(&simulator);
        let thread = fs::read_link("/proc/thread-self").unwrap();
        let thread = thread.file_name().unwrap().to_str().unwrap();
        for arguments in [["-p", "1", thread], ["-ap", "1", &simulator.serving.id().to_string()]] {
            assert!(Command::new("taskset").args(arguments).status().unwrap().success());
        }
        let socket = connect(&simulator.serving.address);
        let rate = |span: Duration| {
            let (begun, mut count) = (Instant::now(), 0_u32);
            for message in messages.iter().cycle() {
                socket.send(message, 0).unwrap();
                assert_eq!(socket.recv_bytes(0).unwrap(), b"ok");
                count += 1;
                if begun.elapsed() >= span {
                    break;
                }
            }
            f64::from(count) / begun.elapsed().as_secs_f64()
        };
        simulator.send(&messages[0]);
        let first = browser.window();
        let measure = |count: usize| {
            let windows: Vec<_> =
                (0..count).map(|_| browser.open_window(&simulator.page)).collect();
            for window in &windows {
                browser.switch_to(window);
                Panel::live(browser).wait_for_state(simulator.info().states - 1);
            }
            rate(Duration::from_millis(300));
            let rate = rate(Duration::from_secs(2));
            for window in &windows {
                browser.switch_to(window);
                browser.close_window();
            }
            browser.switch_to(&first);
            rate
        };
        let mut rates = WINDOWS.map(|_| Vec::new());
        for round in 0..ROUNDS {
            for turn in 0..WINDOWS.len() {
                let at = (round + turn) % WINDOWS.len();
                rates[at].push(measure(WINDOWS[at]));
            }
        }
        for (windows, counted) in WINDOWS.iter().zip(&rates) {
            let mut ratios: Vec<_> =
                counted.iter().zip(&rates[1]).map(|(rate, beside_one)| rate / beside_one).collect();
            println!(
                "{windows} windows: {:.0} round trips per second; of the rate beside one window: \
                 median {:.2}, from {:.2} to {:.2}",
                quantile(&mut counted.clone(), 0.5),
                quantile(&mut ratios, 0.5),
                quantile(&mut ratios, 0.0),
                quantile(&mut ratios, 1.0),
            );
        }
    });
}

/// A script that runs before a new page loads. It records when the page shows state LAST and when
/// the page paints that state, in milliseconds since navigation.
const MEASURE_DRAWN: &str = r#"
    window.drawn = new Promise((yes) => new MutationObserver(() => {
        const panel = document.querySelector('[data-source="live"]');
        if (panel?.dataset.index !== "LAST") return;
        const at = performance.now();
        requestAnimationFrame(() => setTimeout(() => yes([at, performance.now()])));
    }).observe(document, { subtree: true, childList: true, attributeFilter: ["data-index"] }));"#;

/// A script that moves the slider to each of the given states. For each state, it measures the time
/// until the page shows the state, and the time until the page paints it.
const SCRUB: &str = r#"
    const [positions, done] = arguments;
    const panel = document.querySelector('[data-source="live"]');
    const slider = panel.querySelector('[name=slider]');
    const frame = () => new Promise(requestAnimationFrame);
    (async () => {
        const times = [];
        for (const at of positions) {
            await frame();
            const shown = new Promise((yes) => {
                const observer = new MutationObserver(() => {
                    if (panel.dataset.index !== String(at)) return;
                    observer.disconnect();
                    yes();
                });
                observer.observe(panel, { attributeFilter: ["data-index"] });
            });
            const began = performance.now();
            slider.value = at;
            slider.dispatchEvent(new Event("input", { bubbles: true }));
            await shown;
            const set = performance.now() - began;
            await frame();
            await new Promise(setTimeout);
            times.push([set, performance.now() - began]);
        }
        done(times);
    })();"#;

#[test]
#[ignore = "measurement"]
fn a_history_of_a_million_states() {
    const STATES: usize = 1_000_000;
    print_load();
    with_page(&["harbour"], |browser, simulator| {
        let messages = search(simulator);
        browser.open("about:blank");
        let begun = Instant::now();
        stream(&simulator.serving.address, &messages, 1e9, |acknowledged| acknowledged == STATES);
        println!("{STATES} states in {:.1} s", begun.elapsed().as_secs_f64());
        let last = simulator.info().states - 1;

        let source = MEASURE_DRAWN.replace("LAST", &last.to_string());
        browser.devtools("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": source }));
        let (mut set, mut painted) = (Vec::new(), Vec::new());
        for _ in 0..11 {
            browser.open("about:blank");
            browser.open(&simulator.page);
            let drawn = "window.drawn.then(arguments[0])";
            let (at, frame): (f64, f64) = browser.run_async(drawn, &[]);
            set.push(at);
            painted.push(frame);
        }
        println!(
            "opening: newest state shown after {}; first {:.1}",
            summary(&mut set.clone()),
            set[0]
        );
        println!("opening: and painted after {}", summary(&mut painted));

        let mut rng = WyRand::new(7);
        let positions: Vec<usize> = (0..100).map(|_| rng.index(STATES)).collect();
        for round in 1..=2 {
            let times: Vec<(f64, f64)> = browser.run_async(SCRUB, &[json!(positions)]);
            let (mut shown, mut painted): (Vec<_>, Vec<_>) = times.into_iter().unzip();
            println!("scrubbing, round {round}: shown after {}", summary(&mut shown));
            println!("scrubbing, round {round}: painted after {}", summary(&mut painted));
        }
    });
}

#[test]
#[ignore = "measurement"]
fn an_exported_page_of_a_long_search() {
    const STATES: usize = 100_000;
    print_load();
    with_page(&["harbour", "--record", "kept"], |browser, simulator| {
        let messages = search(simulator);
        stream(&simulator.serving.address, &messages, 1e9, |acknowledged| acknowledged == STATES);
        let last = simulator.info().states - 1;
        simulator.send(b"reset");
        let recording = recorded(&simulator.home.path().join("kept"));
        let begun = Instant::now();
        let arguments = ["export", recording.to_str().unwrap(), "-o", "run.html"];
        assert_eq!(simulator.home.run(&arguments).code, Some(0));
        let file = simulator.home.path().join("run.html");
        let bytes = fs::metadata(&file).unwrap().len();
        println!("{last} states exported in {:.1} s, {bytes} bytes", begun.elapsed().as_secs_f64());
        for _ in 0..5 {
            browser.open("about:blank");
            let begun = Instant::now();
            browser.open(&format!("file://{}", file.display()));
            Panel { browser, source: "1" }.wait_for_state(last);
            println!("opened in {:.0} ms", begun.elapsed().as_secs_f64() * 1e3);
        }
    });
}
