//! Sends malformed requests over a real socket. Each malformed request must get one error and
//! change nothing. The next valid request must succeed, both from the same client and from another
//! client.

use mmsim_maze::{Maze, MazeSize, Walls};
use mmsim_protocol::Cell;
use mmsim_server::LIMITS;
use mmsim_tests::{TIMEOUT_MS, ask, connect, good_state, malformed_requests, serve, stop};

fn open_maze(cells: usize) -> Maze {
    let size = MazeSize::new(cells, cells).unwrap();
    Maze::new(Walls::open(size), Cell::new(0, 0), size.central_cells()).unwrap()
}

/// Checks that valid requests still succeed on both sockets and that the history is unchanged.
fn check_unaffected(same: &zmq::Socket, other: &zmq::Socket, after: &str) {
    for socket in [same, other] {
        assert_eq!(ask(socket, b"ping"), b"pong", "after {after}");
        assert_eq!(ask(socket, b"W\0\0N"), [1, 0, 0], "after {after}");
        let info = String::from_utf8(ask(socket, b"info")).unwrap();
        assert!(info.contains(r#""states":1,"#), "after {after}: {info}");
    }
}

fn check_error(reply: &[u8], request: &str) {
    let reply = String::from_utf8(reply.to_vec()).unwrap();
    let is_error = reply.starts_with("error: expected ") && reply.contains(", found ");
    assert!(is_error && !reply.contains('\n'), "{request}: {reply}");
}

#[test]
fn each_malformed_request_gets_one_error_and_changes_nothing() {
    let server = serve(open_maze(16));
    let (client, other) = (connect(&server, zmq::REQ), connect(&server, zmq::REQ));
    assert_eq!(ask(&client, &good_state()), b"ok");
    for request in malformed_requests() {
        let name = format!("{:?}", request.escape_ascii().to_string());
        check_error(&ask(&client, &request), &name);
        check_unaffected(&client, &other, &name);
    }
    // The annotations of malformed requests do not belong to the next state.
    assert_eq!(ask(&client, &good_state()), b"ok");
    let simulation = stop(server);
    let history = simulation.history();
    assert_eq!((history.get(0), history.get(1)), (Some(good_state()), Some(good_state())));
    assert_eq!(history.len(), 2);
    assert!(history.newest_context().notes().is_empty());
    assert_eq!(history.log(1, usize::MAX, |_| true), []);
}

#[test]
fn a_request_of_several_frames_gets_one_error() {
    let server = serve(open_maze(16));
    let (client, other) = (connect(&server, zmq::REQ), connect(&server, zmq::REQ));
    assert_eq!(ask(&client, &good_state()), b"ok");
    let requests: [&[&[u8]]; 7] = [
        &[b"ping", b"x"],
        &[b"foo", b"ping"],
        &[b"", b"ping"],
        &[b"ping", b""],
        &[b"ping", b"ping"],
        &[b"W\0\0N", b"S\0\0N"],
        &[b"W\0\0", b"N"],
    ];
    for frames in requests {
        client.send_multipart(frames, 0).unwrap();
        let reply = client.recv_multipart(0).unwrap();
        assert_eq!(reply.len(), 1, "{frames:?}");
        check_error(&reply[0], &format!("{frames:?}"));
        check_unaffected(&client, &other, &format!("{frames:?}"));
    }
    let many = vec![&b"ping"[..]; 1000];
    client.send_multipart(many, 0).unwrap();
    check_error(&client.recv_bytes(0).unwrap(), "1000 frames");
    check_unaffected(&client, &other, "1000 frames");
    stop(server);
}

#[test]
fn a_request_over_the_limit_gets_one_error() {
    let server = serve(open_maze(16));
    let (large, other) = (connect(&server, zmq::REQ), connect(&server, zmq::REQ));
    assert_eq!(ask(&other, &good_state()), b"ok");
    for length in [LIMITS.max_request_bytes + 1, 1 << 20] {
        check_error(&ask(&large, &vec![b'x'; length]), "a long request");
        check_unaffected(&large, &other, "a long request");
        large.send_multipart([&b"ping"[..], &vec![b'x'; length], b"ping"], 0).unwrap();
        check_error(&large.recv_bytes(0).unwrap(), "a long frame");
        check_unaffected(&large, &other, "a long frame");
    }
    stop(server);
}

#[test]
fn a_dealer_that_omits_the_empty_frame_gets_no_reply() {
    let server = serve(open_maze(16));
    let (dealer, other) = (connect(&server, zmq::DEALER), connect(&server, zmq::REQ));
    assert_eq!(ask(&other, &good_state()), b"ok");
    dealer.set_rcvtimeo(300).unwrap();
    for request in [&b"ping"[..], b"reset"] {
        dealer.send(request, 0).unwrap();
        dealer.send_multipart([request, request], 0).unwrap();
    }
    assert_eq!(dealer.recv_bytes(0), Err(zmq::Error::EAGAIN));
    check_unaffected(&other, &connect(&server, zmq::REQ), "a dealer");
    dealer.set_rcvtimeo(TIMEOUT_MS).unwrap();
    dealer.send_multipart([&b""[..], b"ping"], 0).unwrap();
    assert_eq!(dealer.recv_multipart(0).unwrap(), [b"".to_vec(), b"pong".to_vec()]);
    stop(server);
}

#[test]
fn bounds_depend_on_the_maze_size() {
    for side in [21, 32] {
        let server = serve(open_maze(side.into()));
        let client = connect(&server, zmq::REQ);
        let last = side - 1;
        assert_eq!(ask(&client, &[b'W', last, last, b'N']), [0, 1, 1]);
        for (x, y) in [(side, last), (last, side), (255, 255)] {
            check_error(&ask(&client, &[b'W', x, y, b'N']), "a cell outside the maze");
        }
        let reply = ask(&client, &good_state());
        check_error(&reply, "a classic state");
        let reply = String::from_utf8(reply).unwrap();
        let length = 6 + 2 * usize::from(side) * usize::from(side);
        assert!(reply.contains(&length.to_string()) && reply.contains("518"), "{reply}");
        assert!(stop(server).history().is_empty());
    }
}
