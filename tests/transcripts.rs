//! Compares mmsim with transcripts: recorded requests from the example clients and replies from the
//! reference server. The mmsim server must send the recorded replies, and the strategies must send
//! the recorded requests.

use std::ops::ControlFlow;
use std::path::Path;

use mmsim_client::{InMemory, search_run};
use mmsim_maze::Maze;
use mmsim_server::Simulation;
use mmsim_solvers::{BundledStrategy, Mouse};
use mmsim_tests::{Exchange, ask, classic_map, connect, json_lines, serve, shared, stop};

const MAZES: [&str; 2] = ["alljapan-045-2024-exp-fin", "apec2018"];

fn maze(shared: &Path, name: &str) -> Maze {
    mmsim_formats::read_maze(&shared.join("mazes/classic").join(name).with_extension("txt"))
        .unwrap()
}

fn transcript(shared: &Path, client: &str, maze: &str) -> Vec<Exchange> {
    json_lines(&shared.join("transcripts").join(format!("{client}.{maze}.jsonl")))
}

#[test]
fn the_server_replies_like_the_reference_server() {
    let Some(shared) = shared("") else { return };
    for name in MAZES {
        for client in ["flood-fill", "weight-increment", "left-wall", "tester"] {
            let server = serve(maze(&shared, name));
            let socket = connect(&server, zmq::REQ);
            let mut states = Vec::new();
            for (n, Exchange { req, rep }) in
                transcript(&shared, client, name).into_iter().enumerate()
            {
                assert_eq!(ask(&socket, &req), rep, "{client} on {name}, request {n}");
                if req[0] == b'S' {
                    states.push(req);
                }
            }
            let simulation = stop(server);
            assert!(simulation.history().iter().eq(states), "{client} on {name}");
        }
    }
}

#[test]
fn our_strategies_send_the_same_requests_as_the_example_clients() {
    let Some(shared) = shared("") else { return };
    for name in MAZES {
        // These strategies have an example client.
        for strategy in [
            BundledStrategy::FloodFill,
            BundledStrategy::WeightIncrement,
            BundledStrategy::LeftWall,
        ] {
            let expected = transcript(&shared, strategy.name(), name);
            let mut simulation = Simulation::new(name, maze(&shared, name));
            let mut requests = Vec::new();
            let mut transport = InMemory::new(|request, reply| {
                requests.push(request.to_vec());
                simulation.handle(request, reply);
            });
            let (map, start) = classic_map();
            let mut mouse = Mouse::new(strategy.strategy(), map, start);
            let run =
                search_run(&mut transport, &mut mouse, 1000, |_, _| ControlFlow::Continue(()))
                    .unwrap();
            assert_eq!(
                run.stats.goal_reached(),
                strategy != BundledStrategy::LeftWall,
                "{strategy} on {name}"
            );
            for (n, (request, expected)) in requests.iter().zip(&expected).enumerate() {
                assert_eq!(*request, expected.req, "{strategy} on {name}, request {n}");
            }
            assert_eq!(requests.len(), expected.len(), "{strategy} on {name}");
        }
    }
}
