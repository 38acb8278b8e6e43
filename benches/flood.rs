//! Compares mmsim's flood with other implementations, both on randomly chosen mazes and on a single
//! maze. Further benchmarks measure how long it takes to update the distances during a search and
//! to compute the distance from the start to the goal.

use std::collections::VecDeque;
use std::hint::black_box;

use criterion::Criterion;
use mmsim_benches::{Nibbles, Row, classic_mazes, compare, large_mazes, sensor_poses};
use mmsim_maze::{Cell, CellSet, KnownMaze, Maze, MazeSize, Unknown, Walls};
use mmsim_solvers::{Distances, Downhill, FloodFill, Instructions, steps_between};
use pathfinding::prelude::bfs;
use petgraph::graph::{NodeIndex, UnGraph};
use petgraph::visit::{Bfs, Walker};

/// Floods a maze with a textbook breadth-first search.
fn textbook(walls: &Walls, targets: &CellSet) -> Vec<u16> {
    let mut distances = vec![FAR; SIDE * SIDE];
    let mut queue = VecDeque::new();
    for cell in targets {
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

fn index(cell: Cell) -> usize {
    usize::from(cell.y) * SIDE + usize::from(cell.x)
}

/// A maze as a `petgraph` graph, with an extra node that is connected to all goal cells.
struct Graph {
    graph: UnGraph<(), ()>,
    goal: NodeIndex,
}

impl Graph {
    fn new(maze: &Maze) -> Self {
        let mut graph = UnGraph::default();
        let nodes: Vec<_> = (0..SIDE * SIDE).map(|_| graph.add_node(())).collect();
        let goal = graph.add_node(());
        for wall in maze.size().inner_walls() {
            if !maze.walls().has(wall.cell, wall.heading) {
                let next = wall.cell.neighbour(wall.heading).unwrap();
                graph.add_edge(nodes[index(wall.cell)], nodes[index(next)], ());
            }
        }
        for cell in maze.goals() {
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
        // Subtract the step from the extra node to the goal cells.
        distances
            .iter()
            .map(|&steps| if steps == FAR { FAR } else { steps.saturating_sub(1) })
            .collect()
    }
}

/// A maze in the representations that the compared implementations use. Converting the maze is not
/// part of the measured time.
struct Prepared {
    maze: Maze,
    nibbles: Nibbles,
    graph: Graph,
}

impl Prepared {
    fn all(mazes: Vec<Maze>) -> Vec<Self> {
        let prepared = |maze| Self { nibbles: Nibbles::new(&maze), graph: Graph::new(&maze), maze };
        mazes.into_iter().map(prepared).collect()
    }

    /// Returns the number of steps from the start to the goal according to the `pathfinding` crate.
    fn steps_by_pathfinding(&self) -> Option<usize> {
        let Self { maze, .. } = self;
        let neighbours = |&cell: &Cell| maze.walls().open_neighbours(cell);
        let path = bfs(&maze.start().cell, neighbours, |&cell| maze.goals().contains(cell))?;
        Some(path.len() - 1)
    }

    /// Asserts that all flood implementations give the same distances.
    fn check(&self) {
        let Self { maze, nibbles, graph } = self;
        let (walls, goals) = (maze.walls(), maze.goals());
        let (ours, graph) = (Distances::flood(walls, goals), graph.flood());
        let queue: Vec<u16> = if maze.size() == MazeSize::CLASSIC {
            let widened = |&steps: &u8| if steps == u8::MAX { FAR } else { steps.into() };
            nibbles.flood::<256, u8>().iter().map(widened).collect()
        } else {
            nibbles.flood::<1024, u16>().into()
        };
        let textbook = textbook(walls, goals);
        for &instructions in Instructions::ALL {
            let flooded = Distances::flood_with(instructions, walls, goals);
            assert_eq!(flooded, ours, "{instructions:?}");
        }
        let sum: u32 = textbook.iter().filter(|&&steps| steps != FAR).copied().map(u32::from).sum();
        assert_eq!([sum_of_rows(&ours), sum_of_cells(&ours, maze.size())], [sum; 2]);
        let downhill = Downhill::flood(walls, goals);
        for cell in maze.size().cells() {
            let steps = Some(textbook[index(cell)]).filter(|&steps| steps != FAR);
            assert_eq!(ours.at(cell), steps);
            assert_eq!(queue[maze.size().index(cell).unwrap()], steps.unwrap_or(FAR));
            assert_eq!(graph[index(cell)], steps.unwrap_or(FAR));
            assert_eq!(
                downhill.headings(cell).next().is_some(),
                steps.is_some_and(|steps| steps > 0)
            );
        }
        let start = maze.start().cell;
        assert_eq!(self.steps_by_pathfinding(), ours.at(start).map(usize::from));
        assert_eq!(steps_between(walls, start, goals), ours.at(start));
    }
}

/// Returns a benchmark row for each available instruction set, fastest first.
fn ours() -> impl Iterator<Item = Row<'static, Prepared>> {
    let available =
        Instructions::ALL.iter().rev().filter(|instructions| instructions.is_available());
    available.map(|&instructions| {
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
        Row::new("array queue", |Prepared { maze, nibbles, .. }| {
            if maze.size().area() == 256 {
                black_box(&nibbles.flood::<256, u8>());
            } else {
                black_box(&nibbles.flood::<1024, u16>());
            }
        }),
        Row::new("petgraph", |Prepared { graph, .. }| {
            black_box(graph.flood());
        }),
        Row::new("pathfinding bfs, start to goal", |prepared: &Prepared| {
            black_box(prepared.steps_by_pathfinding());
        }),
    ]
}

/// Reads all distances with [`Distances::rows`] and returns their sum.
fn sum_of_rows(distances: &Distances) -> u32 {
    let mut sum = 0;
    for row in distances.rows() {
        for steps in row {
            sum += u32::from(steps.unwrap_or(0));
        }
    }
    sum
}

/// Reads all distances with [`Distances::at`] and returns their sum.
fn sum_of_cells(distances: &Distances, size: MazeSize) -> u32 {
    let mut sum = 0;
    for y in 0..size.height() {
        for x in 0..size.width() {
            sum += u32::from(distances.at(Cell::new(x, y)).unwrap_or(0));
        }
    }
    sum
}

/// Returns a benchmark row for a flood alone and three rows for a flood followed by reading all
/// distances.
fn floods_and_reads() -> [Row<'static, Prepared>; 4] {
    let flood = |maze: &Maze| Distances::flood(maze.walls(), maze.goals());
    [
        Row::new("mmsim, flood only", move |Prepared { maze, .. }: &Prepared| {
            black_box(&flood(maze));
        }),
        Row::new("mmsim, flood and rows", move |Prepared { maze, .. }| {
            black_box(sum_of_rows(&flood(maze)));
        }),
        Row::new("mmsim, flood and at", move |Prepared { maze, .. }| {
            black_box(sum_of_cells(&flood(maze), maze.size()));
        }),
        Row::new("array queue and sum", |Prepared { nibbles, .. }| {
            let distances = nibbles.flood::<256, u8>();
            black_box(distances.iter().copied().map(u32::from).sum::<u32>());
        }),
    ]
}

/// A recorded search: the maze and the poses in which the mouse read the walls.
struct Trace {
    maze: Maze,
    poses: Vec<mmsim_maze::Pose>,
}

impl Trace {
    fn new(maze: &Maze) -> Self {
        Self { maze: maze.clone(), poses: sensor_poses(maze, FloodFill::new()) }
    }

    /// Replays the search and returns the final distances. Calls `update` after each wall reading
    /// to update the distances.
    fn replay(&self, mut update: impl FnMut(&mut Distances, &KnownMaze, Cell)) -> Distances {
        let (maze, mut map) = (&self.maze, KnownMaze::unexplored(&self.maze));
        let mut distances = Distances::flood(map.walls(Unknown::Open), maze.goals());
        for &pose in &self.poses {
            map.observe(pose, maze.walls().around(pose)).unwrap();
            update(&mut distances, &map, pose.cell);
        }
        assert_eq!(map.visited().len() > 1, self.poses.len() > 1);
        distances
    }
}

fn flood_again(distances: &mut Distances, map: &KnownMaze, _: Cell) {
    *distances = Distances::flood(map.walls(Unknown::Open), map.goals());
}

fn update(distances: &mut Distances, map: &KnownMaze, cell: Cell) {
    distances.update(map.walls(Unknown::Open), map.goals(), cell);
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let classic = Prepared::all(classic_mazes());
    let large = Prepared::all(large_mazes());
    for prepared in classic.iter().chain(&large) {
        prepared.check();
    }
    let traces: Vec<_> = classic.iter().map(|prepared| Trace::new(&prepared.maze)).collect();
    for trace in &traces {
        assert_eq!(trace.replay(update), trace.replay(flood_again));
    }
    let events = traces.iter().map(|trace| trace.poses.len()).sum::<usize>() / traces.len();

    let all = || ours().chain(peers()).collect::<Vec<_>>();
    compare(&mut criterion, "flood/mixed", &classic, &all());
    compare(&mut criterion, "flood/hot", &classic[..1], &all());
    compare(&mut criterion, "flood/32x32", &large, &all());
    compare(&mut criterion, "flood-and-read/mixed", &classic, &floods_and_reads());
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
            black_box(&trace.replay(flood_again));
        }),
        Row::new("neither", |trace: &Trace| {
            black_box(&trace.replay(|_, _, _| {}));
        }),
    ];
    compare(&mut criterion, &format!("wall-updates/{events} per trace"), &traces, &rows);
    criterion.final_summary();
}
