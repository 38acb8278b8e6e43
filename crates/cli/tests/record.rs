//! Recording and replaying searches without losing acknowledged states.

mod harness;

use std::hash::{BuildHasher, RandomState};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;
use std::{fs, thread};

use harness::noise::state;
use harness::{Home, check_mouse_message, mouse_messages, recorded, recordings};
#[cfg(unix)]
use harness::{Serving, limited};
use mmsim_recording::{Integrity, Recording};
use mmsim_tests::{ask, connect_to, wait_for};
use serde_json::json;

const MAZE: &str = "hedgerow";

/// Receives a reply. Returns `None` if there is no reply and the server has been killed.
fn receive(socket: &zmq::Socket, killed: &AtomicBool) -> Option<Vec<Vec<u8>>> {
    socket.set_rcvtimeo(20).unwrap();
    wait_for("a reply, or the server to be killed", || {
        // The flag is read first, so that a reply from before the kill still counts.
        let over = killed.load(Ordering::Relaxed);
        match socket.recv_multipart(0) {
            Ok(reply) => Some(Some(reply)),
            Err(zmq::Error::EAGAIN) => over.then_some(None),
            Err(error) => panic!("{error}"),
        }
    })
}

/// Sends states one by one with occasional resets, and counts the acknowledged states.
fn send_one_by_one(address: &str, acknowledged: &AtomicU64, killed: &AtomicBool) {
    let socket = connect_to(address, zmq::REQ);
    for number in 0.. {
        for request in [(number % 300 == 299).then(|| b"reset".to_vec()), Some(state(number))] {
            let Some(request) = request else { continue };
            socket.send(request, 0).unwrap();
            let Some(reply) = receive(&socket, killed) else { return };
            assert_eq!(reply, [b"ok"]);
        }
        acknowledged.store(number + 1, Ordering::Relaxed);
    }
}

/// Sends states without waiting for replies, and counts the acknowledged states.
fn send_in_advance(address: &str, acknowledged: &AtomicU64, killed: &AtomicBool) {
    let socket = connect_to(address, zmq::DEALER);
    let (mut sent, mut answered) = (0, 0);
    loop {
        while sent < answered + AHEAD && !killed.load(Ordering::Relaxed) {
            socket.send_multipart([b"".to_vec(), state(sent)], 0).unwrap();
            sent += 1;
        }
        let Some(reply) = receive(&socket, killed) else { return };
        assert_eq!(reply, [&b""[..], b"ok"]);
        answered += 1;
        acknowledged.store(answered, Ordering::Relaxed);
    }
}

/// The maximum number of unacknowledged states.
const AHEAD: u64 = 100;

/// A guard that sets a flag on drop, even during a panic.
struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Kills the server at fifty different times while it receives states at full speed.
#[test]
fn no_acknowledged_state_is_lost_when_the_server_is_killed() {
    let (mut lost, mut total) = (0, 0);
    for round in 0..50_u64 {
        let home = Home::new();
        let mut server = home.serve(&["--port", "0", MAZE, "--record", "recordings"]);
        let address = server.address.clone();
        let (one_by_one, killed) = (round % 2 == 0, AtomicBool::new(false));
        let acknowledged = AtomicU64::new(0);
        thread::scope(|scope| {
            scope.spawn(|| {
                if one_by_one {
                    send_one_by_one(&address, &acknowledged, &killed);
                } else {
                    send_in_advance(&address, &acknowledged, &killed);
                }
            });
            let killed = SetOnDrop(&killed);
            // Some servers are killed during startup, most of them while recording.
            if round % 5 != 0 {
                let is_acknowledged = || acknowledged.load(Ordering::Relaxed) > 0;
                wait_for("the first acknowledged state", || is_acknowledged().then_some(()));
            }
            thread::sleep(Duration::from_micros(RandomState::new().hash_one(round) % 70_000));
            server.kill();
            drop(killed);
        });
        server.wait();
        let recorded: Vec<Vec<u8>> = recordings(&home.path().join("recordings"))
            .iter()
            .flat_map(|(_, recording)| recording.history().iter().collect::<Vec<_>>())
            .collect();
        for (number, recorded) in (0..).zip(&recorded) {
            assert!(*recorded == state(number), "round {round}: state {number} is another one");
        }
        let (recorded, acknowledged) = (recorded.len() as u64, acknowledged.into_inner());
        lost += acknowledged.saturating_sub(recorded);
        // The last states may be recorded but not acknowledged.
        let ahead = if one_by_one { 1 } else { AHEAD };
        assert!(recorded <= acknowledged + ahead, "round {round}: {recorded} of {acknowledged}");
        total += acknowledged;
    }
    println!("{lost} of {total} acknowledged states lost in 50 kills");
    assert_eq!(lost, 0, "of {total}");
    assert!(total >= 40, "at least one in each round that waits for it");
}

#[test]
#[cfg_attr(not(unix), allow(unused_mut))]
fn each_search_is_a_recording_that_can_be_replayed() {
    let home = Home::new();
    let mut server = home.serve(&["-p", "0", MAZE, "--record", "recordings"]);
    let own = home.path().join("own.mcap");
    let solve = |strategy, more: &[&str]| {
        let arguments = [&["solve", strategy, "--connect", &server.address], more].concat();
        assert_eq!(home.run(&arguments).code, Some(0));
    };
    solve("flood-fill", &["--record", "own.mcap"]);
    solve("weight-increment", &[]);
    solve("left-wall", &["--goal", "server", "--record", "asking.mcap"]);
    #[cfg(unix)]
    {
        server.signal("INT");
        assert_eq!(server.wait().0.code(), Some(0));
    }
    let recordings = recordings(&home.path().join("recordings"));
    let [(first, flood_fill), (second, weight_increment), _] = &recordings[..] else { panic!() };
    assert_eq!(*flood_fill.integrity(), Integrity::Closed);
    assert_eq!(flood_fill.maze().unwrap().to_string(), mmsim_mazes::HEDGEROW);
    assert_eq!((flood_fill.info().states, weight_increment.info().states), (192, 446));
    #[cfg(unix)]
    assert_eq!(*weight_increment.integrity(), Integrity::Closed);

    let bytes = fs::metadata(&own).unwrap().len();
    assert!(bytes <= 192 * 100, "packed: {bytes} bytes");
    let client = Recording::open(&own).unwrap();
    assert!(client.history().iter().eq(flood_fill.history().iter()));
    assert_eq!((client.maze(), client.integrity()), (None, &Integrity::Closed));

    // Only the client with `--goal server` has learnt that the simulator accepts annotations.
    let asking = Recording::open(&home.path().join("asking.mcap")).unwrap();
    assert_eq!([&client, &asking].map(|it| it.info().has_annotations()), [false, true]);

    let replay = |path: &Path, more: &[&str]| {
        home.run(&[&["replay", path.to_str().unwrap()], more].concat())
    };
    let shown = replay(first, &[]);
    assert_eq!(shown.code, Some(0));
    assert!(shown.stdout.contains(": 05-hedgerow, 16x16, goal 59 steps away\n192 states in "));
    assert!(shown.stdout.contains("state 191 after "), "{}", shown.stdout);
    assert!(shown.stdout.contains("(8, 7) heading north, 126 cells visited\n"), "{}", shown.stdout);
    let shown = replay(first, &["--at", "4"]).stdout;
    let (_, state) = shown.split_once("state 4 after ").unwrap();
    let (_, state) = state.split_once(" ms: ").unwrap();
    let (pose, rest) = state.split_once('\n').unwrap();
    let (phases, rest) = rest.split_once('\n').unwrap();
    let (goal, rest) = rest.split_once('\n').unwrap();
    let (bounds, map) = rest.split_once('\n').unwrap();
    assert_eq!(goal, "goal not reached");
    assert!(bounds.starts_with("shortest path: at least "), "{bounds}");
    assert!(phases.starts_with("search run  4 steps  0 turns  "), "{phases}");
    insta::assert_snapshot!("replayed-state", format!("{pose}\n{map}"));

    let json = replay(first, &["--json"]).json();
    assert_eq!((&json["states"], &json["integrity"]), (&192.into(), &"closed".into()));
    assert_eq!(json["poses"].as_array().unwrap().len(), 192);
    assert_eq!(json["state"]["index"], 191);
    assert_eq!(json["state"]["wrong_walls"], 0);
    let json = replay(second, &["--json", "--at", "0"]).json();
    assert_eq!((&json["poses"], &json["state"]["cell"]), (&().into(), &[0, 0].into()));
    assert_eq!(json["state"]["walls"][0][0].as_u64().unwrap() & 1, 1, "visited");
    let json = replay(&own, &["--json"]).json();
    assert_eq!((&json["drawing"], &json["state"]["wrong_walls"]), (&().into(), &().into()));

    let ended = replay(first, &["--at", "192"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.ends_with("no state 192 (--at takes 0 to 191)\n"));
    let ended =
        home.run(&["solve", "flood-fill", "--record", "own.mcap", "--connect", "127.0.0.1:1"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.starts_with("mmsim: cannot record in own.mcap: "), "{ended:?}");
}

/// A mouse often logs its result after its last state.
#[test]
fn acknowledged_annotations_after_the_last_state_survive_a_kill() {
    let home = Home::new();
    let mut server = home.serve(&["--port", "0", MAZE, "--record", "recordings"]);
    let client = connect_to(&server.address, zmq::REQ);
    for number in 0..10 {
        assert_eq!(ask(&client, &state(number)), b"ok");
    }
    assert_eq!(ask(&client, b"AL\x06\0RESULTT\x01\0\x03endC\x01\0g"), b"ok");
    server.kill();
    server.wait();
    let [(killed, _)] = &recordings(&home.path().join("recordings"))[..] else { panic!() };
    let packed = home.path().join("packed.mcap");
    let packed = packed.to_str().unwrap();
    let exported = home.run(&["export", killed.to_str().unwrap(), "-o", packed]);
    assert_eq!(exported.code, Some(0), "{exported:?}");
    for file in [killed.to_str().unwrap(), packed] {
        let replay = |more: &[&str]| home.run(&[&["replay", file, "--json"], more].concat()).json();
        let json = replay(&[]);
        assert_eq!(json["log"], json!([{"state": 10, "text": "RESULT"}]));
        assert_eq!(json["state"]["texts"], json!([{"cell": [1, 0], "text": "end"}]));
        assert_eq!(json["state"]["colours"], json!([{"cell": [1, 0], "colour": "g"}]));
        let earlier = replay(&["--at", "8"]);
        assert_eq!((&earlier["log"], &earlier["state"]["texts"]), (&json!(null), &json!([])));
    }
}

/// The JSON channel contains the figures of `mmsim replay`.
#[test]
fn other_tools_read_the_figures_of_the_mouse() {
    let home = Home::new();
    let server = home.serve(&["-p", "0", MAZE]);
    let solve = |strategy, more: &[&str]| {
        let arguments = [&["solve", strategy, "--connect", &server.address], more].concat();
        assert_eq!(home.run(&arguments).code, Some(0));
    };
    solve("swing", &["--record", "swing.mcap"]);
    let path = home.path().join("swing.mcap");
    let messages = mouse_messages(&path);
    assert_eq!(messages.len(), Recording::open(&path).unwrap().history().len());
    for (index, message) in messages.iter().enumerate().step_by(23) {
        let at = index.to_string();
        let report = home.run(&["replay", "swing.mcap", "--json", "--at", &at]).json();
        let total = &report["state"]["phases"]["total"];
        assert_eq!((&message["steps"], &message["turns"]), (&total["steps"], &total["turns"]));
        check_mouse_message(message, &report["state"]);
    }
    solve("flood-fill", &["--record", "states.mcap", "--states-only"]);
    let path = home.path().join("states.mcap");
    assert!(mouse_messages(&path).is_empty());
    let bytes = fs::metadata(&path).unwrap().len();
    assert!(bytes <= 192 * 40, "packed: {bytes} bytes");
    let refused = home.run(&["solve", "flood-fill", "--states-only"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
}

/// The recording of a killed server contains only states until it is exported.
#[test]
fn exporting_adds_the_figures_of_the_mouse() {
    let home = Home::new();
    let mut server = home.serve(&["-p", "0", MAZE, "--record", "r"]);
    assert_eq!(home.run(&["solve", "flood-fill", "--connect", &server.address]).code, Some(0));
    server.kill();
    server.wait();
    let (path, killed) = recordings(&home.path().join("r")).swap_remove(0);
    assert!(matches!(killed.integrity(), Integrity::Truncated { .. }));
    assert!(mouse_messages(&path).is_empty());
    let export = |more: &[&str]| {
        let file = path.to_str().unwrap();
        let ended = home.run(&[&["export", file, "-o", "packed.mcap"], more].concat());
        assert_eq!((ended.code, &ended.stdout[..], &ended.stderr[..]), (Some(0), "", ""));
        let path = home.path().join("packed.mcap");
        (mouse_messages(&path), Recording::open(&path).unwrap())
    };
    for (more, count) in [(&[][..], 192), (&["--states-only"], 0)] {
        let (messages, packed) = export(more);
        assert_eq!((messages.len(), packed.integrity()), (count, &Integrity::Closed));
        assert_eq!((packed.info(), packed.maze()), (killed.info(), killed.maze()));
        assert!(packed.history().iter().eq(killed.history().iter()));
        assert!(packed.times().iter().eq(killed.times().iter()));
        assert_eq!(packed.history().newest_context(), killed.history().newest_context());
    }
}

/// A mouse that marks a cell as visited before it reads the walls neither knows these walls nor
/// reports them incorrectly.
#[test]
fn walls_that_the_mouse_has_not_read_are_unknown() {
    let home = Home::new();
    home.write(
        "maze.txt",
        "o---o---o---o\n| S |       |\no   o   o   o\n|         G |\no---o---o---o\n",
    );
    let server = home.serve(&["maze.txt", "-p", "0", "--record", "r"]);
    let socket = connect_to(&server.address, zmq::REQ);
    let state =
        |x: u8, y: u8, walls: [u8; 6]| [b"S", &[x, y][..], b"EC\0\0\0\0\0\0C", &walls].concat();
    for (reading, state) in [
        (b"W\0\x01S", state(0, 1, [0, 0, 0, 1 | 2 | 8 | 16, 0, 0])),
        // The mouse moves through (0, 0) and (1, 0) before it asks.
        (b"W\x01\0E", state(1, 0, [1, 1, 0, 1 | 2 | 8 | 16, 0, 0])),
        (b"W\0\0E", state(0, 0, [1, 1 | 4, 0, 1 | 2 | 8 | 16, 0, 0])),
    ] {
        assert_eq!(ask(&socket, &state), b"ok");
        assert_eq!(ask(&socket, reading).len(), 3);
    }
    assert_eq!(ask(&socket, &state(0, 0, [1 | 4 | 8, 1 | 4, 0, 1 | 2 | 8 | 16, 0, 0])), b"ok");
    let recording = recorded(&home.path().join("r"));
    let at = |at: &str| {
        let report =
            home.run(&["replay", recording.to_str().unwrap(), "--json", "--at", at]).json();
        let state = &report["state"];
        let keys = ["optimistic_distance", "pessimistic_distance", "proven", "wrong_walls"];
        serde_json::Value::from_iter(keys.map(|key| state[key].clone()))
    };
    assert_eq!(at("0"), json!([3, null, false, 0]));
    assert_eq!(at("1"), json!([3, null, false, 0]));
    assert_eq!(at("3"), json!([3, 3, true, 0]));
}

#[test]
fn truncated_recordings_show_their_intact_states() {
    let home = Home::new();
    let server = home.serve(&["-p", "0", MAZE, "--record", "r"]);
    home.run(&["solve", "flood-fill", "--connect", &server.address]);
    let (path, _) = recordings(&home.path().join("r")).swap_remove(0);
    let mut bytes = fs::read(path).unwrap();
    bytes.truncate(bytes.len() - 1000);
    let whole = home.write("cut.mcap", &bytes);
    let shown = home.run(&["replay", whole.to_str().unwrap()]);
    assert_eq!(shown.code, Some(0), "{shown:?}");
    let expected = format!(" of {} bytes are intact", bytes.len());
    assert!(shown.stdout.contains(&expected), "{shown:?}");
    assert!(shown.stdout.contains("\n190 states in "), "{shown:?}");
    bytes[50_000..60_000].fill(0xa5);
    home.write("damaged.mcap", &bytes);
    let shown = home.run(&["replay", "damaged.mcap"]);
    assert_eq!(shown.code, Some(1), "{shown:?}");
    assert!(shown.stdout.contains(", damaged after byte "), "{shown:?}");
    assert!(shown.stderr.contains("damaged.mcap: damaged after byte "), "{shown:?}");
    for (name, content, found) in [
        ("empty.mcap", &b""[..], "found the end of the file at byte 0"),
        ("head.mcap", &bytes[..40], "found the end of the file at byte 40"),
        ("text.mcap", b"o---o---o", "found other data at byte 0"),
    ] {
        home.write(name, content);
        let ended = home.run(&["replay", name]);
        assert_eq!(ended.code, Some(1));
        assert!(ended.stderr.contains(found), "{ended:?}");
    }
    assert_eq!(home.run(&["replay", "no-such.mcap"]).code, Some(1));
}

#[test]
fn a_full_history_refuses_states_and_a_reset_makes_room() {
    let home = Home::new();
    let server = home.serve(&["-p", "0", MAZE, "--history-limit", "1", "--record", "r"]);
    let socket = connect_to(&server.address, zmq::REQ);
    let states = (0..10_000).take_while(|&number| ask(&socket, &state(number)) == b"ok").count();
    assert!((1900..2100).contains(&states), "{states} states of noise in a mebibyte");
    let reply = String::from_utf8(ask(&socket, &state(0))).unwrap();
    assert!(reply.starts_with("error: cannot store another state: history limit of "), "{reply}");
    assert!(reply.ends_with(&format!(
        "1 MiB reached after {states} states (reset, or raise --history-limit)"
    )));
    assert_eq!(ask(&socket, b"ping"), b"pong");
    assert_eq!(recordings(&home.path().join("r"))[0].1.info().states, states);
    assert_eq!(ask(&socket, b"reset"), b"ok");
    assert_eq!(ask(&socket, &state(0)), b"ok");
}

#[test]
fn a_full_recording_refuses_states_and_a_reset_starts_a_new_one() {
    let home = Home::new();
    let options = ["-p", "0", MAZE, "--record", "r", "--record-limit", "100kB"];
    let server = home.serve(&options);
    let socket = connect_to(&server.address, zmq::REQ);
    let states = (0..1000).take_while(|&number| ask(&socket, &state(number)) == b"ok").count();
    assert!((150..200).contains(&states), "{states} states");
    let reply = String::from_utf8(ask(&socket, &state(0))).unwrap();
    let reason = format!(
        ".mcap: limit of 97.7 KiB reached after {states} states (reset starts a new recording; \
         --record-limit changes the limit)"
    );
    assert!(reply.starts_with("error: cannot record in r") && reply.ends_with(&reason), "{reply}");
    assert_eq!(ask(&socket, b"reset"), b"ok");
    assert_eq!(ask(&socket, &state(0)), b"ok");
    drop(server);
    let recordings = recordings(&home.path().join("r"));
    assert_eq!(recordings.len(), 2);
    assert_eq!(recordings[0].1.info().states, states);
    assert_eq!(*recordings[0].1.integrity(), Integrity::Closed);
}

#[test]
fn a_full_recording_of_a_client_is_closed() {
    let home = Home::new();
    let server = home.serve(&["-p", "0", MAZE]);
    let solve = ["solve", "flood-fill", "--connect", &server.address, "--record", "a.mcap"];
    let ended = home.run(&[&solve[..], &["--record-limit", "20kB"]].concat());
    assert_eq!(ended.code, Some(1), "{ended:?}");
    let reason = "incomplete recording: cannot record in a.mcap: limit of 19.5 KiB reached after ";
    assert!(ended.stderr.contains(reason), "{ended:?}");
    let recording = Recording::open(&home.path().join("a.mcap")).unwrap();
    assert_eq!(*recording.integrity(), Integrity::Closed);
    assert!((10..40).contains(&recording.history().len()));
    for refused in [&["--record-limit", "0", "--record", "b.mcap"][..], &["--record-limit", "1MB"]]
    {
        assert_eq!(home.run(&[&solve[..4], refused].concat()).code, Some(2));
    }
}

/// Windows does not move a folder that contains an open file.
#[cfg(unix)]
#[test]
fn a_lost_folder_refuses_states_until_reset() {
    let home = Home::new();
    let server = home.serve(&["-p", "0", MAZE, "--record", "r"]);
    let socket = connect_to(&server.address, zmq::REQ);
    assert_eq!(ask(&socket, &state(0)), b"ok");
    fs::rename(home.path().join("r"), home.path().join("moved")).unwrap();
    for _ in 0..3 {
        let reply = String::from_utf8(ask(&socket, &state(1))).unwrap();
        assert!(reply.starts_with("error: cannot record in r"), "{reply}");
        assert!(
            reply.ends_with(": the file was removed or replaced (reset starts a new recording)"),
            "{reply}"
        );
        assert_eq!(ask(&socket, b"W\0\0N").len(), 3);
    }
    assert!(ask(&socket, b"info").starts_with(b"{"));
    assert_eq!(ask(&socket, b"reset"), b"ok");
    assert_eq!(ask(&socket, &state(2)), b"ok");
    for (folder, number) in [("moved", 0), ("r", 2)] {
        let (_, recording) = recordings(&home.path().join(folder)).swap_remove(0);
        assert!(recording.history().iter().eq([state(number)]), "{folder}");
        assert!(
            matches!(*recording.integrity(), Integrity::Truncated { intact, length } if intact == length)
        );
    }
}

/// After another program has changed the recording, the server refuses all states until a reset.
#[cfg(unix)]
#[test]
fn a_recording_changed_by_another_program_refuses_states_until_reset() {
    let home = Home::new();
    let server = home.serve(&["-p", "0", MAZE, "--record", "r"]);
    let socket = connect_to(&server.address, zmq::REQ);
    let lengths: [fn(u64) -> u64; 3] = [|_| 0, |length| length / 2, |length| length + 7];
    for (round, length) in lengths.into_iter().enumerate() {
        for number in 0..20 {
            assert_eq!(ask(&socket, &state(number)), b"ok");
        }
        let file = recorded(&home.path().join("r"));
        let changed = fs::File::options().write(true).open(&file).unwrap();
        changed.set_len(length(changed.metadata().unwrap().len())).unwrap();
        let bytes = fs::read(&file).unwrap();
        for _ in 0..3 {
            let reply = String::from_utf8(ask(&socket, &state(20))).unwrap();
            assert!(reply.starts_with("error: cannot record in r/"), "round {round}: {reply}");
            assert!(reply.contains(": another program changed the file: expected "), "{reply}");
            assert!(reply.ends_with(" (reset starts a new recording)"), "{reply}");
            assert!(ask(&socket, b"info").windows(11).any(|bytes| bytes == b"\"states\":20"));
        }
        assert_eq!(ask(&socket, b"reset"), b"ok");
        assert!(fs::read(&file).unwrap() == bytes, "the file is unchanged");
    }
    assert_eq!(ask(&socket, &state(7)), b"ok");
    let (_, recording) = recordings(&home.path().join("r")).pop().unwrap();
    assert!(recording.history().iter().eq([state(7)]));
}

/// A limit on the file size simulates a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_refuses_states_and_keeps_written_states() {
    // The limits are in blocks of 512 bytes. After the last state, one limit leaves enough space
    // for the summary, and the other limit does not.
    for limit in [64, 55] {
        fill_disk(limit);
    }
}

#[cfg(unix)]
fn fill_disk(limit: usize) {
    let home = Home::new();
    let mmsim = home.server(&["-p", "0", MAZE, "--record", "r"]);
    let server = Serving::start(limited(&mmsim, &format!("-f {limit}")), "tcp://");
    let socket = connect_to(&server.address, zmq::REQ);
    let states = (0..10_000).take_while(|&number| ask(&socket, &state(number)) == b"ok").count();
    assert!((limit / 2..2 * limit).contains(&states), "{states} states in {limit} blocks");
    for _ in 0..3 {
        let reply = String::from_utf8(ask(&socket, &state(9))).unwrap();
        assert!(reply.starts_with("error: cannot record in r"), "{reply}");
        assert_eq!(ask(&socket, b"ping"), b"pong");
    }
    let whole = |index: usize| {
        let (_, recording) = recordings(&home.path().join("r")).swap_remove(index);
        assert!(recording.history().iter().eq((0..states as u64).map(state)), "file {index}");
        // The file is closed after compression, for which there may be enough space.
        assert!(!matches!(*recording.integrity(), Integrity::Damaged { .. }));
    };
    whole(0);
    assert_eq!(ask(&socket, b"reset"), b"ok");
    for number in 0..states as u64 {
        assert_eq!(ask(&socket, &state(number)), b"ok", "another file has its own room");
    }
    whole(0);
    whole(1);
}
