//! Floods: the distance of every cell to the goal, of mazes in mixed order and of one again and
//! again, beside what others flood with; what an update costs while a mouse explores; and how far it
//! is from the start.

use std::collections::VecDeque;
use std::hint::black_box;

use criterion::Criterion;
use mmsim_benches::{Row, classic_mazes, compare, large_mazes, walls_seen};
use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, Maze, Unknown, Walls};
use mmsim_solvers::{Distances, Downhill, FloodFill, Instructions, steps_between};
use pathfinding::prelude::bfs;
use petgraph::graph::{NodeIndex, UnGraph};
use petgraph::visit::{Bfs, Walker};

/// The flood as a textbook has it: a growing queue, and a distance for each cell.
fn textbook(walls: &Walls, targets: &CellSet) -> Vec<u16> {
    let mut distances = vec![FAR; SIDE * SIDE];
    let mut queue = VecDeque::new();
    for cell in targets.iter() {
        distances[index(cell)] = 0;
        queue.push_back(cell);
    }
    while let Some(cell) = queue.pop_front() {
        for neighbour in walls.open_neighbours(cell) {
            if distances[index(neighbour)] == FAR {
                distances[index(neighbour)] = distances[index(cell)] + 1;
                queue.push_back(neighbour);
            }
        }
    }
    distances
}

const SIDE: usize = 32;
const FAR: u16 = u16::MAX;

/// A maze as firmware likes it: a byte a cell with a bit for each open side.
struct Nibbles {
    /// Bit i is open towards the i-th heading: row by row, 32 cells to a row.
    open: [u8; SIDE * SIDE],
    goals: Vec<u16>,
}

impl Nibbles {
    fn of(maze: &Maze) -> Self {
        let mut open = [0; SIDE * SIDE];
        for cell in maze.size().cells() {
            for (bit, heading) in Heading::ALL.into_iter().enumerate() {
                open[index(cell)] |= u8::from(!maze.walls().has(cell, heading)) << bit;
            }
        }
        let goals = maze.goals().iter().map(|cell| u16::try_from(index(cell)).unwrap()).collect();
        Self { open, goals }
    }

    /// A good queue: a fixed array, no bounds to check, a distance that is written once.
    fn flood(&self) -> [u16; SIDE * SIDE] {
        let mut distances = [FAR; SIDE * SIDE];
        let mut queue = [0_u16; SIDE * SIDE];
        let (mut done, mut reached) = (0, 0);
        for &goal in &self.goals {
            distances[usize::from(goal)] = 0;
            queue[reached] = goal;
            reached += 1;
        }
        while done < reached {
            let cell = usize::from(queue[done]);
            done += 1;
            let next = distances[cell] + 1;
            for (bit, step) in [SIDE, 1, SIDE.wrapping_neg(), usize::MAX].into_iter().enumerate() {
                if self.open[cell] >> bit & 1 == 1 {
                    let neighbour = cell.wrapping_add(step) % (SIDE * SIDE);
                    if distances[neighbour] == FAR {
                        distances[neighbour] = next;
                        queue[reached] = u16::try_from(neighbour).unwrap_or(0);
                        reached += 1;
                    }
                }
            }
        }
        distances
    }
}

fn index(cell: Cell) -> usize {
    usize::from(cell.y) * SIDE + usize::from(cell.x)
}

/// A maze as a graph of `petgraph`, with one node more that is next to all goal cells.
struct Graph {
    graph: UnGraph<(), ()>,
    goal: NodeIndex,
}

impl Graph {
    fn of(maze: &Maze) -> Self {
        let mut graph = UnGraph::default();
        let nodes: Vec<_> = (0..SIDE * SIDE).map(|_| graph.add_node(())).collect();
        let goal = graph.add_node(());
        for cell in maze.size().cells() {
            for heading in [Heading::North, Heading::East] {
                if !maze.walls().has(cell, heading) {
                    let next = cell.neighbour(heading).unwrap();
                    graph.add_edge(nodes[index(cell)], nodes[index(next)], ());
                }
            }
        }
        for cell in maze.goals().iter() {
            graph.add_edge(goal, nodes[index(cell)], ());
        }
        Self { graph, goal }
    }

    fn flood(&self) -> Vec<u16> {
        let mut distances = vec![FAR; SIDE * SIDE + 1];
        distances[self.goal.index()] = 0;
        for node in Bfs::new(&self.graph, self.goal).iter(&self.graph) {
            let next = distances[node.index()] + 1;
            for neighbour in self.graph.neighbors(node) {
                let distance = &mut distances[neighbour.index()];
                *distance = next.min(*distance);
            }
        }
        // A step to the goal cells was one too many.
        distances
            .iter()
            .map(|&steps| if steps == FAR { FAR } else { steps.saturating_sub(1) })
            .collect()
    }
}

/// A maze in all the forms it is flooded in. None is made while the clock runs.
struct Prepared {
    maze: Maze,
    nibbles: Box<Nibbles>,
    graph: Graph,
}

impl Prepared {
    fn all(mazes: Vec<Maze>) -> Vec<Self> {
        let prepared = |maze| Self { nibbles: Nibbles::of(&maze).into(), graph: Graph::of(&maze), maze };
        mazes.into_iter().map(prepared).collect()
    }

    /// The steps from the start to the goal, by a crate whose search goes from one cell to others.
    fn by_pathfinding(&self) -> Option<usize> {
        let Self { maze, .. } = self;
        let neighbours = |&cell: &Cell| maze.walls().open_neighbours(cell);
        let way = bfs(&maze.start().cell, neighbours, |&cell| maze.goals().contains(cell))?;
        Some(way.len() - 1)
    }

    /// Asserts that all floods agree.
    fn check(&self) {
        let Self { maze, nibbles, graph } = self;
        let (walls, goals) = (maze.walls(), maze.goals());
        let (ours, queue, graph) = (Distances::flood(walls, goals), nibbles.flood(), graph.flood());
        let textbook = textbook(walls, goals);
        for instructions in Instructions::ALL {
            let flooded = Distances::flood_with(instructions, walls, goals);
            assert_eq!(flooded, ours, "{instructions:?}");
        }
        let downhill = Downhill::flood(walls, goals);
        for cell in maze.size().cells() {
            let steps = Some(textbook[index(cell)]).filter(|&steps| steps != FAR);
            assert_eq!(ours.at(cell), steps);
            assert_eq!(queue[index(cell)], steps.unwrap_or(FAR));
            assert_eq!(graph[index(cell)], steps.unwrap_or(FAR));
            assert_eq!(
                downhill.headings(cell).next().is_some(),
                steps.is_some_and(|steps| steps > 0)
            );
        }
        let start = maze.start().cell;
        assert_eq!(self.by_pathfinding(), ours.at(start).map(usize::from));
        assert_eq!(steps_between(walls, start, goals), ours.at(start));
    }
}

/// Our floods, with each kind of instructions that this processor has, the best first.
fn ours() -> impl Iterator<Item = Row<'static, Prepared>> {
    let there = Instructions::ALL.into_iter().rev().filter(|instructions| instructions.are_there());
    there.map(|instructions| {
        Row::new(&format!("mmsim, {}", instructions.name()), move |Prepared { maze, .. }| {
            black_box(&Distances::flood_with(instructions, maze.walls(), maze.goals()));
        })
    })
}

fn peers() -> [Row<'static, Prepared>; 4] {
    [
        Row::new("textbook queue", |Prepared { maze, .. }| {
            black_box(textbook(maze.walls(), maze.goals()));
        }),
        Row::new("good queue", |Prepared { nibbles, .. }| {
            black_box(&nibbles.flood());
        }),
        Row::new("petgraph", |Prepared { graph, .. }| {
            black_box(graph.flood());
        }),
        Row::new("pathfinding bfs, start to goal", |prepared: &Prepared| {
            black_box(prepared.by_pathfinding());
        }),
    ]
}

/// What a mouse has seen at each state of a search, in the order in which it saw it.
struct Trace {
    maze: Maze,
    seen: Vec<mmsim_maze::Pose>,
}

impl Trace {
    fn of(maze: &Maze) -> Self {
        Self { maze: maze.clone(), seen: walls_seen(maze, FloodFill::new()) }
    }

    /// Goes through it; `keep` is to bring distances up to date each time.
    fn replay(&self, mut keep: impl FnMut(&mut Distances, &KnownMaze, Cell)) -> Distances {
        let (maze, mut map) = (&self.maze, KnownMaze::before(&self.maze));
        let mut distances = Distances::flood(map.walls(Unknown::Open), maze.goals());
        for &pose in &self.seen {
            map.note(pose, maze.walls().around(pose)).unwrap();
            keep(&mut distances, &map, pose.cell);
        }
        assert_eq!(map.visited().len() > 1, self.seen.len() > 1);
        distances
    }
}

fn anew(distances: &mut Distances, map: &KnownMaze, _: Cell) {
    *distances = Distances::flood(map.walls(Unknown::Open), map.goals());
}

fn update(distances: &mut Distances, map: &KnownMaze, seen: Cell) {
    distances.update(map.walls(Unknown::Open), map.goals(), seen);
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let classic = Prepared::all(classic_mazes());
    let large = Prepared::all(large_mazes());
    for prepared in classic.iter().chain(&large) {
        prepared.check();
    }
    let traces: Vec<_> = classic.iter().map(|prepared| Trace::of(&prepared.maze)).collect();
    for trace in &traces {
        assert_eq!(trace.replay(update), trace.replay(anew));
    }
    let events = traces.iter().map(|trace| trace.seen.len()).sum::<usize>() / traces.len();

    let all = || ours().chain(peers()).collect::<Vec<_>>();
    compare(&mut criterion, "flood/mixed", &classic, &all());
    compare(&mut criterion, "flood/hot", &classic[..1], &all());
    compare(&mut criterion, "flood/32x32", &large, &all());
    let start_goal = [
        Row::new("mmsim, steps between", |Prepared { maze, .. }: &Prepared| {
            black_box(steps_between(maze.walls(), maze.start().cell, maze.goals()));
        }),
        Row::new("mmsim, downhill", |Prepared { maze, .. }| {
            black_box(&Downhill::flood(maze.walls(), maze.goals()));
        }),
    ];
    let [.., pathfinding] = peers();
    compare(
        &mut criterion,
        "start-goal/mixed",
        &classic,
        &start_goal.into_iter().chain([pathfinding]).collect::<Vec<_>>(),
    );
    let rows = [
        Row::new("update", |trace: &Trace| {
            black_box(&trace.replay(update));
        }),
        Row::new("flood", |trace: &Trace| {
            black_box(&trace.replay(anew));
        }),
        Row::new("neither", |trace: &Trace| {
            black_box(&trace.replay(|_, _, _| {}));
        }),
    ];
    compare(&mut criterion, &format!("wall-updates/{events} a trace"), &traces, &rows);
    criterion.final_summary();
}
