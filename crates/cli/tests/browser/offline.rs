//! The page while its simulator cannot be reached.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use fantoccini::key::Key;
use mmsim_solvers::BundledStrategy;
use mmsim_tests::TIMEOUT;
use serde_json::json;

use crate::browser::{Browser, wait_for, with_browser, with_page};
use crate::http;
use crate::page::{Page, Panel};
use crate::simulator::{Simulator, bundled, connect};
use crate::test_state::TestState;

/// The controls that need the simulator, those that need the run, and those that need neither.
const ONLINE: [&str; 6] = [
    "#mazes input",
    "#mazes li button",
    "#recordings [name=file]",
    "[name=strategy]",
    "[name=run]",
    "[data-export='picture.png']",
];
const RUN: [&str; 3] = ["[name=slider]", "[name=follow]", "[name=jump]"];
const OFFLINE: [&str; 4] = ["[name=numbers]", "[name=legend]", "[name=zoom-in]", ".map"];

/// A script that makes a page unable to keep runs.
const KEEP_NOTHING: &str = "
    const original = window.fetch;
    window.fetch = (url, ...rest) =>
        String(url).includes('/data.html') ? Promise.reject(new Error()) : original(url, ...rest);";

/// Tries to focus elements. Returns true for those that can receive the focus.
fn can_focus(browser: &Browser, selectors: &[&str]) -> Vec<bool> {
    let script = "return arguments[0].map((selector) => {
        const element = document.querySelector(selector);
        element?.focus();
        return element !== null && document.activeElement === element;
    })";
    browser.run(script, &[json!(selectors)])
}

/// Waits until the page says that its simulator has stopped, and asserts that the notice covers nothing.
fn wait_for_notice(browser: &Browser) {
    let script = "
        const notice = document.querySelector('#offline');
        if (!notice.checkVisibility()) return false;
        const { top, bottom } = notice.getBoundingClientRect();
        const header = document.querySelector('.bar').getBoundingClientRect();
        const layout = document.querySelector('.layout').getBoundingClientRect();
        return [header.bottom <= top, bottom <= layout.top, layout.bottom <= innerHeight];";
    let is_apart: [bool; 3] = browser.wait_until("the notice", script, &[]);
    assert_eq!(is_apart, [true; 3]);
}

#[test]
fn the_page_says_that_the_simulator_has_gone_and_recovers() {
    with_browser(|browser| {
        let source = json!({ "source": KEEP_NOTHING });
        browser.devtools("Page.addScriptToEvaluateOnNewDocument", &source);
        let mut simulator = Simulator::start(&["harbour"]);
        let page = simulator.page.clone();
        let port = page.rsplit(':').next().unwrap().to_string();
        browser.open(&page);
        let live = Panel::live(browser);
        live.wait_until_empty();
        let maze = bundled("01-harbour.txt");
        let states: Vec<_> = (0..2).map(|number| TestState::new(number, maze.size())).collect();
        for state in &states {
            simulator.send(&state.message('C', 'C'));
        }
        live.wait_for_state(1);
        simulator.disconnect();
        wait_for("the mazes", || (Page(browser).maze_names().len() > 3).then_some(()));
        let can_focus = |selectors: &[&str]| can_focus(browser, selectors);
        let is_said = || -> bool {
            browser.run("return document.querySelector('#offline').checkVisibility()", &[])
        };
        wait_for("the exports", || (can_focus(&ONLINE) == [true; 6]).then_some(()));
        assert_eq!((can_focus(&RUN), can_focus(&OFFLINE)), (vec![true; 3], vec![true; 4]));
        assert!(!is_said());

        simulator.serving.kill();
        wait_for_notice(browser);
        assert!(browser.text("#offline").contains("stopped"));
        assert_eq!((can_focus(&ONLINE), can_focus(&RUN)), (vec![false; 6], vec![false; 3]));
        assert_eq!(can_focus(&OFFLINE), [true; 4]);
        live.click("[name=heat]");
        live.click("[name=heat]");
        browser.press(['+', '0']);
        // The shortcuts of the timeline are disabled, too, and files cannot be dropped.
        let script = "
            document.activeElement.blur();
            const event = new DragEvent('dragover', { dataTransfer: new DataTransfer(), cancelable: true });
            document.body.dispatchEvent(event);
            return document.body.classList.contains('dropping')
                || !document.querySelector('.log').inert;";
        assert!(!browser.run::<bool>(script, &[]));
        browser.press(['/', 'g', ' ', char::from(Key::Left), char::from(Key::Home)]);
        assert_eq!(live.position(), "State 1 of 1");
        live.assert_shows(&maze, &states);
        assert!(
            !browser.run::<bool>("return document.querySelector('#error').checkVisibility()", &[])
        );

        // A simulator at the same address is another one, so the page loads again.
        let mut again = Simulator::start(&["meadow", "--viewer-port", &port]);
        assert_eq!(again.page, page);
        wait_for("the other maze", || {
            // One script, because the page may load again between two.
            let script = "const title = document.querySelector(arguments[0])?.textContent;
                return title === 'oblong-long-meadow'
                    && !document.querySelector('#offline').checkVisibility()";
            browser.run::<bool>(script, &[json!(live.part("h2"))]).then_some(())
        });
        again.send(&TestState::new(0, bundled("oblong-long-meadow.txt").size()).message('C', 'C'));
        live.wait_for_state(0);
        again.disconnect();
        wait_for("the controls", || (can_focus(&ONLINE) == [true; 6]).then_some(()));
        // The browser reports requests without a reply.
        let errors = browser.take_errors();
        assert!(errors.iter().all(|error| error.message.contains("net::ERR_")), "{errors:?}");
        browser.open("about:blank");
    });
}

/// A finished search is shown like before when its simulator has stopped.
#[test]
fn a_finished_search_outlives_its_simulator() {
    with_browser(|browser| {
        let mut simulator = Simulator::start(&["harbour"]);
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        live.wait_until_empty();
        let maze = bundled("01-harbour.txt");
        let states = simulator.search(&maze, BundledStrategy::ShortestPathSearch);
        let last = states.len() - 1;
        live.wait_for_state(last);
        live.wait_until_kept(states.len());
        let plot = live.attribute(".plot .optimistic", "d");
        simulator.serving.kill();
        wait_for_notice(browser);
        assert_eq!(can_focus(browser, &ONLINE), [false; 6]);
        assert_eq!(can_focus(browser, &RUN), [true; 3]);

        browser.run::<()>("document.activeElement.blur()", &[]);
        for at in [0, 1, last / 2, last] {
            live.slide_to(at);
            live.assert_shows(&maze, &states[..=at]);
        }
        assert_eq!(live.attribute(".plot .optimistic", "d"), plot);
        browser.press([char::from(Key::Home)]);
        live.wait_for_state(0);
        live.set_pace("no limit");
        browser.press([' ']);
        live.wait_for_state(last);
        browser.press("g12\u{e007}".chars());
        live.wait_for_state(12);
        browser.press(['f']);
        let duration = live.part("[data-route=fastest] .duration");
        assert_ne!(browser.wait_for_text(&duration, " s"), "none");
        let errors = browser.take_errors();
        assert!(errors.iter().all(|error| error.message.contains("net::ERR_")), "{errors:?}");
        browser.open("about:blank");
    });
}

/// A connection to a simulator that can be interrupted.
struct Line {
    address: String,
    is_cut: Arc<AtomicBool>,
    streams: Arc<Mutex<Vec<TcpStream>>>,
}

impl Line {
    fn to(simulator: &str) -> Self {
        let (listener, to) = (TcpListener::bind("127.0.0.1:0").unwrap(), simulator.to_string());
        let address = listener.local_addr().unwrap().to_string();
        let (is_cut, streams) = (Arc::default(), Arc::default());
        let line = Self { address, is_cut: Arc::clone(&is_cut), streams: Arc::clone(&streams) };
        thread::spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                if is_cut.load(Ordering::SeqCst) {
                    continue;
                }
                let Ok(far) = TcpStream::connect(&to) else { break };
                for [from, to] in [[&near, &far], [&far, &near]] {
                    let [mut from, mut to] = [from, to].map(|stream| stream.try_clone().unwrap());
                    thread::spawn(move || {
                        let _ = io::copy(&mut from, &mut to);
                        let _ = to.shutdown(Shutdown::Both);
                    });
                }
                streams.lock().unwrap().extend([near, far]);
            }
        });
        line
    }

    fn cut(&self) {
        self.is_cut.store(true, Ordering::SeqCst);
        for stream in self.streams.lock().unwrap().drain(..) {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }

    fn restore(&self) {
        self.is_cut.store(false, Ordering::SeqCst);
    }
}

/// The connection is lost but the simulator runs on.
#[test]
fn controls_work_again_after_a_lost_connection() {
    with_browser(|browser| {
        let simulator = Simulator::start(&["harbour"]);
        let line = Line::to(http::split_url(&simulator.page).0);
        let first = browser.window();
        let page = format!("http://{}/", line.address);
        let windows = [0; 3].map(|_| browser.open_window(&page));
        let wait_until_inert = |expected: bool| {
            for window in &windows {
                browser.switch_to(window);
                let is_inert = || browser.exists("#mazes[inert]") && browser.exists(".run[inert]");
                wait_for("the controls", || (is_inert() == expected).then_some(()));
            }
        };
        wait_until_inert(false);
        line.cut();
        wait_until_inert(true);
        line.restore();
        wait_until_inert(false);
        for window in &windows {
            browser.switch_to(window);
            assert_eq!(browser.text("#status"), "Connected");
            Panel::live(browser).wait_until_empty();
            let errors = browser.take_errors();
            assert!(errors.iter().all(|error| error.message.contains("net::ERR_")), "{errors:?}");
            browser.close_window();
        }
        browser.switch_to(&first);
    });
}

/// A browser opens only six connections to a server.
#[test]
fn seven_windows_of_one_browser_show_the_search() {
    with_browser(|browser| {
        let simulator = Simulator::start(&["harbour"]);
        let first = browser.window();
        let windows = [0; 7].map(|_| browser.open_window(&simulator.page));
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        for window in &windows {
            browser.switch_to(window);
            wait_for("the connection", || (browser.text("#status") == "Connected").then_some(()));
            Panel::live(browser).wait_for_state(states.len() - 1);
            let factor = "
                const done = arguments[0];
                import('/events.js').then((it) => done(it.drawFactor()));";
            wait_for("the other windows", || {
                (browser.run_async::<f64>(factor, &[]) >= 10.5).then_some(())
            });
        }
        for window in &windows {
            browser.switch_to(window);
            browser.close_window();
        }
        browser.switch_to(&first);
        assert!(browser.take_errors().is_empty());
    });
}

/// A search continues while another tab hides the page.
#[test]
fn a_hidden_page_requests_almost_nothing() {
    const COUNT: &str = "
        performance.setResourceTimingBufferSize(100_000);
        const requests = () => performance.getEntriesByType('resource');
        const charts = () => requests().filter(({ name }) => name.includes('/costs?')).length;";
    with_page(&["harbour"], |browser, simulator| {
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        Panel::live(browser).wait_for_state(states.len() - 1);
        let record = "
            window.counts = [];
            document.addEventListener('visibilitychange', () => counts.push(charts()));";
        browser.run::<()>(&[COUNT, record].concat(), &[]);
        let page = browser.window();
        let wait_for_updates = |count: u32| {
            wait_for("updates of the chart", || {
                let found = browser.run::<u32>(&[COUNT, "return charts();"].concat(), &[]);
                (found >= count).then_some(())
            });
        };
        let is_over = AtomicBool::new(false);
        thread::scope(|scope| {
            let (address, states, is_over) = (&simulator.serving.address, &states, &is_over);
            scope.spawn(move || {
                let (socket, begun) = (connect(address), Instant::now());
                let mut states = states.iter().cycle();
                while !is_over.load(Ordering::Relaxed) && begun.elapsed() < TIMEOUT {
                    socket.send(states.next().unwrap().message('C', 'C'), 0).unwrap();
                    assert_eq!(socket.recv_bytes(0).unwrap(), b"ok");
                }
            });
            wait_for_updates(3);
            browser.open_tab(&simulator.page);
            wait_for_updates(6);
            is_over.store(true, Ordering::Relaxed);
        });
        browser.leave();
        browser.close_window();
        browser.switch_to(&page);
        let counts = || browser.run::<Vec<u32>>("return window.counts;", &[]);
        let counts = wait_for("the page", || <[u32; 2]>::try_from(counts()).ok());
        assert!(counts[1] <= counts[0] + 5, "updates of the hidden chart: {counts:?}");
        Panel::live(browser).wait_for_state(simulator.info().states - 1);
    });
}

/// A page that the simulator refuses shows the reason, and connects when another page is closed.
#[test]
fn the_page_shows_why_the_simulator_refuses_it() {
    with_browser(|browser| {
        let simulator = Simulator::start(&["harbour"]);
        let (host, _) = http::split_url(&simulator.page);
        let port = host.rsplit(':').next().unwrap();
        let others: Vec<TcpStream> = (0..32)
            .map(|browser| {
                let mut stream = TcpStream::connect(host).unwrap();
                stream.set_read_timeout(Some(TIMEOUT)).unwrap();
                let cookie = format!("mmsim-{port}-browser={browser}");
                write!(stream, "GET /events HTTP/1.1\r\nhost: {host}\r\ncookie: {cookie}\r\n\r\n")
                    .unwrap();
                let mut status = [0; 12];
                stream.read_exact(&mut status).unwrap();
                assert_eq!(&status, b"HTTP/1.1 200");
                stream
            })
            .collect();
        browser.open(&simulator.page);
        wait_for("the reason", || {
            let text = browser.text("#offline");
            text.contains("32 browsers already show this page").then_some(())
        });
        drop(others);
        wait_for("the connection", || (browser.text("#status") == "Connected").then_some(()));
        let errors = browser.take_errors();
        assert!(errors.iter().all(|error| error.message.contains("503")), "{errors:?}");
        browser.leave();
    });
}
