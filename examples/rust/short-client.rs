//! A complete client with a custom strategy. The mouse goes to the least visited neighbour.
use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Pose};
use mmsim_protocol::{MAX_STATE_BYTES, MapState, Order, Reply, Request};
use mmsim_solvers::{Mouse, Move, SearchDriver, SearchError, Strategy, open_steps};

struct LeastVisited(std::collections::HashMap<Cell, u16>);

impl Strategy for LeastVisited {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        *self.0.entry(pose.cell).or_default() += 1;
        let least = open_steps(map, pose).min_by_key(|(_, cell)| self.0.get(cell));
        let (step, _) = least.ok_or(SearchError::BoxedIn { cell: pose.cell })?;
        Ok(if map.goals().contains(pose.cell) { Move::Stop } else { Move::Step(step) })
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let socket = zmq::Context::new().socket(zmq::REQ)?;
    socket.connect(&std::env::args().nth(1).unwrap_or("tcp://127.0.0.1:6574".into()))?;
    let ask = |request: &[u8]| socket.send(request, 0).and_then(|()| socket.recv_bytes(0));
    ask(b"reset")?;
    let (size, start) = (MazeSize::CLASSIC, Pose::new(Cell::new(0, 0), Heading::North));
    let map = KnownMaze::new(size, start.cell, size.central_cells());
    let mut mouse = Mouse::new(LeastVisited([].into()), map, start);
    let mut driver = SearchDriver::new(&mut mouse, 10_000);
    let mut buffer = [0; MAX_STATE_BYTES];
    while driver.advance(|pose| {
        let length = Request::Walls(pose).encode(&mut buffer).map_err(std::io::Error::other)?;
        match Reply::decode(&ask(&buffer[..length])?) {
            Ok(Reply::Walls(walls)) => Ok(walls),
            reply => Err(std::io::Error::other(format!("expected walls, found {reply:?}"))),
        }
    })? {
        let visits = |cell| driver.mouse().strategy().0.get(&cell).copied().unwrap_or(0);
        let state = MapState::new(driver.mouse().pose(), driver.mouse().map(), visits, Order::C);
        let length = state.encode(&mut buffer)?;
        ask(&buffer[..length])?;
    }
    driver.stats().steps_to_goal.map(|n| println!("{n} steps")).ok_or("goal not reached".into())
}
