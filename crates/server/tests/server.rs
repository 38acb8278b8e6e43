//! Serves a simulation to clients, and reads it from another thread.

use std::thread;

use mmsim_maze::Maze;
use mmsim_recording::{Block, LogLine};
use mmsim_server::{MonitorError, Server, Simulation, Status};
use mmsim_tests::{connect_to, within};

const STATE: &[u8] = b"S\x00\x00NC\x01\x00C\x0d\x00";

fn maze() -> Maze {
    "o---o---o\n| S   G |\no---o---o\n".parse().unwrap()
}

#[test]
fn only_loopback_addresses_are_loopback() {
    for host in ["127.0.0.1", "localhost", "*"] {
        let server = Server::bind(host, 0).unwrap();
        assert!(server.address().starts_with("tcp://"), "{}", server.address());
        assert_eq!(server.is_loopback(), host != "*");
    }
}

#[test]
fn idle_server_stops_and_stopping_it_again_does_nothing() {
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let (stop, late) = (server.stop_handle(), server.stop_handle());
    let running = thread::spawn(move || server.run(&mut Simulation::new("small", maze())));
    stop.stop();
    within("the server to stop", || running.join()).unwrap().unwrap();
    late.stop();
}

#[test]
fn monitor_sees_states_and_replaces_the_maze() {
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let monitor = server.monitor();
    assert_eq!(monitor.status(), Status { run: 0, states: 0 });
    let server = server.spawn(Simulation::new("small", maze()));
    let client = connect_to(server.address(), zmq::REQ);
    let ask = |request: &[u8]| mmsim_tests::ask(&client, request);
    let states = 2 * Block::STATES + 3;
    for _ in 0..states {
        assert_eq!(ask(STATE), b"ok");
    }
    assert_eq!(monitor.status(), Status { run: 1, states });
    let now = monitor.served().unwrap();
    assert_eq!((now.run, now.info.states, now.maze), (1, states, maze()));
    for index in 0..3 {
        let block = monitor.block(1, index).unwrap().unwrap().unpack().unwrap();
        assert_eq!(block.get(index * Block::STATES), Some(STATE));
        assert_eq!(block.len(), if index == 2 { 3 } else { Block::STATES });
    }
    assert!(monitor.block(1, 3).unwrap().is_none());
    assert!(monitor.times(1).unwrap().iter().is_sorted());
    assert_eq!(monitor.times(1).unwrap().len(), states);

    assert_eq!(monitor.log(1, states - 1, 10, |_| true), Ok(vec![]));
    for number in 0..3 {
        assert_eq!(ask(format!("AM\x07TheseusL\x01\0{number}").as_bytes()), b"ok");
        assert_eq!(ask(STATE), b"ok");
    }
    let line = |number: usize| LogLine { state: states + number, text: number.to_string() };
    let log = |last, filter: &str| monitor.log(1, last, 2, |text| text.contains(filter));
    assert_eq!(log(states + 2, ""), Ok(vec![line(1), line(2)]));
    assert_eq!(log(states + 1, ""), Ok(vec![line(0), line(1)]));
    assert_eq!(log(states + 2, "0"), Ok(vec![line(0)]));
    let now = monitor.served().unwrap();
    assert_eq!((now.mouse.as_deref(), now.strategy), (Some("Theseus"), None));

    assert_eq!(monitor.answer(None, STATE, 1), Ok((b"ok".to_vec(), true)));
    assert_eq!(monitor.answer(None, b"W\x00\x00E", 1), Ok((vec![1, 0, 1], true)));
    assert_eq!(monitor.status(), Status { run: 1, states: states + 4 });
    ask(b"reset");
    assert_eq!(monitor.log(1, 0, 1, |_| true), Err(MonitorError::RunEnded { run: 1 }));
    assert_eq!(monitor.block(1, 0).unwrap_err(), MonitorError::RunEnded { run: 1 });
    let other: Maze = "o---o\n|SG |\no---o\n".parse().unwrap();
    assert_eq!(monitor.serve("other", other), Ok(Status { run: 3, states: 0 }));
    assert!(ask(STATE).starts_with(b"error: expected a state of 8 bytes for a maze of 1x1 cells"));
    assert!(ask(b"info").starts_with(br#"{"maze":"other","width":1"#));
    within("the server to stop", || server.stop()).unwrap();
    assert_eq!(monitor.served().unwrap_err(), MonitorError::Ended);
}

#[test]
fn only_this_program_searches_a_reserved_maze() {
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let monitor = server.monitor();
    let server = server.spawn(Simulation::new("small", maze()));
    let client = connect_to(server.address(), zmq::REQ);
    let ask = |request: &[u8]| mmsim_tests::ask(&client, request);
    assert_eq!(ask(STATE), b"ok");
    monitor.reserve(true);
    for request in [b"reset", STATE, b"AM\x07Theseus"] {
        let error = "error: the simulator is running a mouse, and only the connection of \
                     this mouse may send reset, S and A (try again after its run)";
        assert_eq!(ask(request), error.as_bytes());
    }
    assert_eq!(ask(b"W\x00\x00E"), [1, 0, 1]);
    assert_eq!((ask(b"ping"), ask(b"info")[0]), (b"pong".to_vec(), b'{'));
    assert_eq!(monitor.answer(None, STATE, 1), Ok((b"ok".to_vec(), true)));
    assert_eq!(monitor.status(), Status { run: 1, states: 2 });
    monitor.reserve(false);
    assert_eq!(ask(b"reset"), b"ok");
    within("the server to stop", || server.stop()).unwrap();
}

#[test]
fn server_that_never_ran_answers_no_query() {
    let server = Server::bind("127.0.0.1", 0).unwrap();
    let monitor = server.monitor();
    drop(server);
    assert_eq!(monitor.served().unwrap_err(), MonitorError::Ended);
}
