//! Checks which walls of a state count as known, and the distances that follow from them.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::thread;

use mmsim_client::{InMemory, search_run};
use mmsim_formats::Catalogue;
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, MazeSize, Pose, WallState, Walls};
use mmsim_protocol::{Annotation, Request, State, state_bytes};
use mmsim_recording::{Block, History};
use mmsim_server::{ReplyBuffer, Simulation};
use mmsim_solvers::{BundledStrategy, Mouse, PathBounds, steps_between};
use mmsim_tests::{Exchange, json_lines, shared};
use proptest::prelude::*;

/// Calls `check` with the index of each state and the walls that are known in this state. Without
/// `truth`, claims that are wrong count as known.
fn for_each_known_maze(
    simulation: &Simulation,
    truth: Option<&Maze>,
    mut check: impl FnMut(usize, KnownMaze),
) {
    let (history, maze) = (simulation.history(), simulation.maze());
    let unexplored = KnownMaze::unexplored(maze);
    for block in 0..history.len().div_ceil(Block::STATES) {
        let states = history.block(block).unwrap().unpack().unwrap();
        for index in (block * Block::STATES..).take(states.len()) {
            let state = State::decode(states.get(index).unwrap(), maze.size()).unwrap();
            let context = states.context(index).unwrap();
            check(index, context.known_maze(&state, &unexplored, truth));
        }
    }
}

/// Returns true if the bounds enclose the length of the shortest path. Without a path, there is no
/// upper bound.
fn encloses(bounds: PathBounds, shortest: Option<u16>) -> bool {
    let or_infinite = |steps: Option<u16>| steps.unwrap_or(u16::MAX);
    let shortest = or_infinite(shortest);
    or_infinite(bounds.optimistic) <= shortest && shortest <= or_infinite(bounds.pessimistic)
}

fn shortest(maze: &Maze) -> Option<u16> {
    steps_between(maze.walls(), maze.start().cell, maze.goals())
}

#[track_caller]
fn check_bounds(name: &str, simulation: &Simulation) {
    let shortest = shortest(simulation.maze());
    for_each_known_maze(simulation, None, |index, known| {
        let bounds = PathBounds::new(&known);
        assert!(encloses(bounds, shortest), "{name}, state {index}: {bounds:?}, not {shortest:?}");
    });
}

/// A simulation and the evidence that its client has for each wall.
struct Witness {
    simulation: Simulation,
    reply: ReplyBuffer,
    now: Evidence,
    /// The evidence before each state.
    states: Vec<Evidence>,
}

#[derive(Clone, Default)]
struct Evidence {
    /// The walls that the client has read, or `None` if it has not read any.
    read: Option<Walls>,
    declared: HashMap<(Cell, Heading), WallState>,
}

impl Witness {
    fn new(name: &str, maze: Maze) -> Self {
        let (now, states) = (Evidence::default(), Vec::new());
        let (simulation, reply) = (Simulation::new(name, maze), ReplyBuffer::new());
        Self { simulation, reply, now, states }
    }

    /// Sends a request that the simulation accepts.
    fn ask(&mut self, request: &[u8]) -> &[u8] {
        let size = self.simulation.maze().size();
        match Request::decode(request, size).unwrap() {
            Request::Reset => {
                self.now = Evidence::default();
                self.states.clear();
            }
            Request::Walls(Pose { cell, heading }) => {
                let read = self.now.read.get_or_insert_with(|| Walls::open(size));
                for heading in [heading.left(), heading, heading.right()] {
                    read.set(cell, heading, true);
                }
            }
            Request::State(_) => self.states.push(self.now.clone()),
            Request::Annotations(annotations) => {
                annotations.iter().for_each(|annotation| self.now.apply(annotation, size));
            }
            _ => {}
        }
        self.simulation.handle(request, &mut self.reply);
        assert!(!self.reply.starts_with(b"error"));
        &self.reply
    }

    /// Checks that exactly those walls are known that the client has read and claims, and that they
    /// are known to be what the client has claimed last. If the true maze is given, wrong claims
    /// must be unknown.
    #[track_caller]
    fn check(&self, name: &str) {
        self.check_with(name, None);
        self.check_with(name, Some(self.simulation.maze()));
    }

    #[track_caller]
    fn check_with(&self, name: &str, truth: Option<&Maze>) {
        let (maze, history) = (self.simulation.maze(), self.simulation.history());
        assert_eq!(history.len(), self.states.len());
        let sides = maze.size().cells().flat_map(|cell| Heading::ALL.map(|side| (cell, side)));
        let inner: Vec<_> =
            sides.filter(|&(cell, side)| maze.size().neighbour(cell, side).is_some()).collect();
        for_each_known_maze(&self.simulation, truth, |index, known| {
            let message = history.get(index).unwrap();
            let flags = State::decode(&message, maze.size()).unwrap();
            let flags = flags.map(maze.start().cell, *maze.goals());
            let Evidence { read, declared } = &self.states[index];
            for &(cell, side) in &inner {
                let claim = declared.get(&(cell, side)).copied();
                let claim = claim.unwrap_or_else(|| flags.wall(cell, side));
                let has_read = read.as_ref().is_none_or(|read| read.has(cell, side));
                let is_wrong = truth.is_some_and(|truth| {
                    let has_wall = truth.walls().has(cell, side);
                    claim == if has_wall { WallState::Absent } else { WallState::Present }
                });
                let is_known = has_read && !is_wrong;
                let expected = if is_known { claim } else { WallState::Unknown };
                assert_eq!(
                    known.wall(cell, side),
                    expected,
                    "{name}, state {index}: {cell} {side}"
                );
            }
        });
    }
}

impl Evidence {
    fn apply(&mut self, annotation: Annotation<'_>, size: MazeSize) {
        match annotation {
            Annotation::Wall { cell, heading, state } => {
                let neighbour = size.neighbour(cell, heading).map(|other| (other, heading.back()));
                for side in [Some((cell, heading)), neighbour].into_iter().flatten() {
                    self.declared.remove(&side);
                    self.declared.extend(state.map(|state| (side, state)));
                }
            }
            Annotation::ClearWalls => self.declared.clear(),
            _ => {}
        }
    }
}

#[test]
fn distances_of_the_transcripts_enclose_the_shortest_path() {
    let Some(shared) = shared("") else { return };
    for name in ["alljapan-045-2024-exp-fin", "apec2018"] {
        let path = shared.join("mazes/classic").join(name).with_extension("txt");
        for client in ["flood-fill", "weight-increment", "left-wall", "tester"] {
            let mut witness = Witness::new(name, mmsim_formats::read_maze(&path).unwrap());
            let path = shared.join("transcripts").join(format!("{client}.{name}.jsonl"));
            for exchange in json_lines::<Exchange>(&path) {
                witness.ask(&exchange.req);
            }
            assert!(witness.states.len() > 5, "{client} in {name}");
            let name = format!("{client} in {name}");
            witness.check(&name);
            check_bounds(&name, &witness.simulation);
        }
    }
}

/// A client that asks for walls before it reports them knows exactly the walls in its map.
#[test]
fn the_known_walls_of_bundled_strategies_are_the_walls_in_their_maps() {
    let folder = shared("mazes");
    let mazes = folder.map_or_else(Catalogue::bundled, |it| Catalogue::from_path(&it).unwrap());
    let check_every_second = |first| {
        let entries = mazes.entries().iter().skip(first).step_by(2);
        entries.fold((0, 0), |(states, updates), entry| {
            let more = check_known_walls(&entry.name(), &entry.maze().unwrap());
            (states + more.0, updates + more.1)
        })
    };
    let (even, odd) = thread::scope(|scope| {
        let even = scope.spawn(|| check_every_second(0));
        (check_every_second(1), even.join().unwrap())
    });
    let (states, updates) = (even.0 + odd.0, even.1 + odd.1);
    assert!(states > 10_000, "only {states} states were checked");
    // Only a mouse that reads the wall behind its start needs an update.
    println!("{states} states, {updates} updates");
    assert!(updates * 1000 <= states, "{updates} updates of {states} states");
}

/// Compares the known walls in each state of each bundled strategy with the walls in its map. Returns
/// the number of states, and of states that have an update.
fn check_known_walls(name: &str, maze: &Maze) -> (usize, usize) {
    let (mut states, mut updates) = (0, 0);
    let shortest = shortest(maze);
    for &strategy in BundledStrategy::ALL {
        let mut simulation = Simulation::new(name, maze.clone());
        let mut transport = InMemory::new(|request, reply| simulation.handle(request, reply));
        let mut mouse = Mouse::new(strategy.strategy(), KnownMaze::unexplored(maze), maze.start());
        let mut maps = Vec::new();
        // An unreachable goal is an error, but the states are checked.
        let _ = search_run(&mut transport, &mut mouse, MAX_STATES, |mouse, _| {
            maps.push(PathBounds::new(mouse.map()));
            ControlFlow::Continue(())
        });
        assert_eq!(simulation.history().len(), maps.len(), "{strategy} in {name}");
        for_each_known_maze(&simulation, None, |index, known| {
            let bounds = PathBounds::new(&known);
            assert_eq!(bounds, maps[index], "{strategy} in {name}, state {index}");
            assert!(encloses(bounds, shortest), "{strategy} in {name}, state {index}");
        });
        states += maps.len();
        updates += stored_updates(simulation.history());
    }
    (states, updates)
}

/// A search stops after this number of states.
const MAX_STATES: u32 = 2000;

/// Returns the number of states that have an update.
fn stored_updates(history: &History) -> usize {
    let blocks = (0..history.len().div_ceil(Block::STATES)).map(|index| {
        let states = history.block(index).unwrap().unpack().unwrap();
        let indexes = (index * Block::STATES..).take(states.len());
        indexes.filter(|&index| !states.update(index).unwrap().is_empty()).count()
    });
    blocks.sum()
}

/// The state of a mouse that takes walls around visited cells as absent if it has not read them.
fn hasty_state(pose: Pose, visited: &CellSet, read: &Walls, size: MazeSize) -> Vec<u8> {
    let mut state = vec![b'S', pose.cell.x, pose.cell.y, pose.heading.letter() as u8, b'C'];
    state.resize(5 + size.area(), 0);
    state.push(b'C');
    state.extend(size.cells().map(|cell| {
        let bits =
            [(Heading::East, 2), (Heading::South, 4), (Heading::West, 8), (Heading::North, 16)];
        let walls = bits.into_iter().filter(|&(heading, _)| read.has(cell, heading));
        u8::from(visited.contains(cell)) | walls.map(|(_, bit)| bit).sum::<u8>()
    }));
    state
}

/// Walks through the maze like a mouse that moves, reports its state, and only then asks for the
/// walls of its cell.
fn hasty_walk(maze: &Maze, steps: usize) -> Witness {
    let mut witness = Witness::new("hasty", maze.clone());
    let mut pose = maze.start();
    let (mut visited, mut read, mut visits) =
        (CellSet::EMPTY, Walls::open(maze.size()), [[0; 32]; 32]);
    for _ in 0..steps {
        visited.insert(pose.cell);
        visits[usize::from(pose.cell.y)][usize::from(pose.cell.x)] += 1;
        assert_eq!(witness.ask(&hasty_state(pose, &visited, &read, maze.size())), b"ok");
        for heading in Heading::ALL {
            let Pose { cell, .. } = pose;
            let reply = witness.ask(&[b'W', cell.x, cell.y, heading.letter() as u8]);
            read.set(cell, heading, reply[1] == 1);
        }
        let next = Heading::ALL.into_iter().filter(|&heading| !read.has(pose.cell, heading));
        let next =
            next.filter_map(|heading| Some(Pose::new(pose.cell.neighbour(heading)?, heading)));
        let Some(next) =
            next.min_by_key(|next| visits[usize::from(next.cell.y)][usize::from(next.cell.x)])
        else {
            break;
        };
        pose = next;
    }
    witness
}

#[test]
fn a_mouse_that_moves_before_it_asks_knows_only_what_it_has_read() {
    let mut wrong = 0;
    for entry in Catalogue::bundled().entries() {
        let (name, maze) = (entry.name(), entry.maze().unwrap());
        let witness = hasty_walk(&maze, 600);
        witness.check(&name);
        // All wrong claims are about walls that the mouse has not read.
        check_bounds(&name, &witness.simulation);
        let unexplored = KnownMaze::unexplored(&maze);
        for_each_known_maze(&witness.simulation, None, |index, known| {
            let state = witness.simulation.history().get(index).unwrap();
            let state = State::decode(&state, maze.size()).unwrap();
            assert!(known.visited().contains(state.pose().cell));
            let claimed = state.map(unexplored.start().cell, *unexplored.goals());
            wrong += usize::from(!encloses(PathBounds::new(&claimed), shortest(&maze)));
        });
    }
    assert!(wrong > 20, "the claims of the mouse were wrong in only {wrong} states");
}

/// A robot that has its walls from another source never asks for walls.
#[test]
fn the_walls_of_a_robot_that_never_asks_are_known() {
    let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse().unwrap();
    let mut simulation = Simulation::new("robot", maze.clone());
    let mut reply = ReplyBuffer::new();
    let state = |x| [b"S".as_slice(), &[x], b"\0EC\0\0\0C\x1d\x15\x17"].concat();
    for x in 0..3 {
        simulation.handle(&state(x), &mut reply);
        assert_eq!(reply, b"ok");
    }
    let proven = PathBounds { optimistic: Some(2), pessimistic: Some(2) };
    for_each_known_maze(&simulation, Some(&maze), |_, known| {
        assert_eq!(PathBounds::new(&known), proven);
    });
    assert_eq!(stored_updates(simulation.history()), 1);
    // After the first reading, only walls that have been read are known.
    simulation.handle(b"W\0\0N", &mut reply);
    simulation.handle(&state(0), &mut reply);
    for_each_known_maze(&simulation, Some(&maze), |index, known| {
        let unproven = PathBounds { optimistic: Some(2), pessimistic: None };
        assert_eq!(PathBounds::new(&known), if index < 3 { proven } else { unproven });
    });
}

/// A mouse can declare that it does not know a wall of a visited cell, and correct its flags.
#[test]
fn declared_walls_override_the_flags_of_a_state() {
    let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse().unwrap();
    let mut simulation = Simulation::new("declared", maze.clone());
    let mut reply = ReplyBuffer::new();
    let state = b"S\0\0NC\0\0\0C\x1d\x15\x17";
    let unproven = PathBounds { optimistic: Some(2), pessimistic: None };
    let proven = PathBounds { optimistic: Some(2), pessimistic: Some(2) };
    let mut expected = Vec::new();
    for (declaration, bounds) in [
        (&b"AD\0\0E0"[..], proven),
        (b"AD\0\0E?", unproven),
        (b"AD\0\0E-", proven),
        // The declaration is wrong.
        (b"AD\x01\0W1", unproven),
        (b"Ad", proven),
    ] {
        simulation.handle(declaration, &mut reply);
        assert_eq!(reply, b"ok");
        simulation.handle(state, &mut reply);
        assert_eq!(reply, b"ok");
        expected.push(bounds);
    }
    for_each_known_maze(&simulation, Some(&maze), |index, known| {
        assert_eq!(PathBounds::new(&known), expected[index], "state {index}");
    });
    let context = simulation.history().context(3).unwrap();
    let unexplored = KnownMaze::unexplored(&maze);
    let claimed = context.claimed_maze(&State::decode(state, maze.size()).unwrap(), &unexplored);
    assert_eq!(claimed.wall(Cell::new(0, 0), Heading::East), WallState::Present);
}

fn any_maze() -> impl Strategy<Value = Maze> {
    let walls = prop::collection::vec(any::<u32>(), 64);
    (1usize..=6, 1usize..=6, walls).prop_map(|(width, height, bits)| {
        let size = MazeSize::new(width, height).unwrap();
        let rows = |from: usize| std::array::from_fn(|y| bits[from + y] & bits[63 - from - y]);
        let walls = Walls::from_rows(size, rows(0), rows(31));
        Maze::new(walls, Cell::new(0, 0), size.central_cells()).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_states_readings_and_declarations_give_the_known_walls(
        maze in any_maze(),
        requests in prop::collection::vec(
            (
                (0u8..6, 0u8..6, 0usize..4),
                prop::option::of(prop::collection::vec(any::<u8>(), 72)),
                prop::option::of(prop::sample::select(b"01?-".to_vec())),
            ),
            1..40,
        ),
    ) {
        let size = maze.size();
        let mut witness = Witness::new("any", maze.clone());
        for ((x, y, heading), matrices, declaration) in requests {
            let pose = [x % size.width(), y % size.height(), b"NESW"[heading]];
            let request = match (matrices, declaration) {
                (None, None) => [b"W".as_slice(), &pose].concat(),
                (None, Some(state)) => [b"AD", &pose[..], &[state]].concat(),
                (Some(bytes), _) => {
                    let (weights, walls) = (&bytes[..size.area()], &bytes[36..36 + size.area()]);
                    [b"S", &pose[..], b"F", weights, b"C", walls].concat()
                }
            };
            witness.ask(&request);
            prop_assert!(request[0] != b'S' || request.len() == state_bytes(size));
        }
        witness.check("any maze");
    }
}
