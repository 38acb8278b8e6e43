//! The paths on the map: the shortest path of the true maze, and the path that a mouse plans to take.

use mmsim_maze::{Cell, KnownMaze, Maze, Pose, Unknown, Walls};
use mmsim_solvers::Distances;
use mmsim_trial::RaceSteps;

/// Returns the cells of a shortest path from the start to the goal or, in a two-run trial, the cells
/// in which the steps of a fastest race end. The path is empty if the goal is unreachable or if the
/// start is in the goal.
pub fn shortest_path(maze: &Maze, is_trial: bool) -> Vec<Cell> {
    if is_trial {
        return RaceSteps::flood(maze.walls(), maze.goals()).path(maze.walls(), maze.start());
    }
    let distances = Distances::flood(maze.walls(), maze.goals());
    descend(maze.walls(), maze.start(), |cell| distances.at(cell))
}

/// Returns the cells along which the weights lead: always to the neighbour with the lowest weight
/// among those with a lower weight and without a known wall in between. The path is empty if there is
/// no such neighbour.
pub fn planned_path(map: &KnownMaze, pose: Pose, weight: impl Fn(Cell) -> Option<u8>) -> Vec<Cell> {
    descend(map.walls(Unknown::Open), pose, |cell| weight(cell).map(u16::from))
}

/// Goes to the neighbour with the lowest number as long as it is lower than the number of the cell.
/// Prefers the heading of the last step.
fn descend(walls: &Walls, from: Pose, number: impl Fn(Cell) -> Option<u16>) -> Vec<Cell> {
    let next = |&Pose { cell, heading }: &Pose| {
        let headings = [heading, heading.left(), heading.right(), heading.back()];
        let open = headings.into_iter().filter(|&heading| !walls.has(cell, heading));
        let neighbours =
            open.filter_map(|heading| Some(Pose::new(cell.neighbour(heading)?, heading)));
        let lower = neighbours.filter_map(|pose| Some((number(pose.cell)?, pose)));
        let here = number(cell)?;
        let lower = lower.filter(|&(number, _)| number < here);
        lower.min_by_key(|&(number, _)| number).map(|(_, pose)| pose)
    };
    let path: Vec<Cell> = std::iter::successors(Some(from), next).map(|pose| pose.cell).collect();
    if path.len() > 1 { path } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Heading, WallState};
    use mmsim_solvers::MazeFacts;
    use mmsim_trial::race_optimum;

    use super::*;

    const MAZE: &str = "\
o---o---o---o---o
|             G |
o   o---o---o   o
|   |           |
o   o   o---o---o
|   |           |
o   o   o---o   o
| S |       |   |
o---o---o---o---o
";

    #[test]
    fn the_shortest_path_is_as_long_as_the_shortest_distance() {
        let maze: Maze = MAZE.parse().unwrap();
        let path = shortest_path(&maze, false);
        assert_eq!(path.len(), 7);
        assert_eq!(Some(path.len() - 1), MazeFacts::new(&maze).shortest_path.map(usize::from));
        let expected = [(0, 0), (0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (3, 3)];
        assert_eq!(path, expected.map(|(x, y)| Cell::new(x, y)));
        let race = shortest_path(&maze, true);
        assert_eq!(race, [(0, 0), (0, 3), (3, 3)].map(|(x, y)| Cell::new(x, y)));
        let optimum = race_optimum(maze.walls(), maze.start().cell, maze.goals());
        assert_eq!(optimum.map(usize::from), Some(race.len() - 1));
    }

    #[test]
    fn an_unreachable_goal_has_no_path() {
        let closed: Maze = "o---o---o\n| S | G |\no---o---o\n".parse().unwrap();
        let at_goal: Maze = "o---o---o\n|SG     |\no---o---o\n".parse().unwrap();
        for maze in [closed, at_goal] {
            assert_eq!((shortest_path(&maze, false), shortest_path(&maze, true)), (vec![], vec![]));
        }
    }

    #[test]
    fn the_planned_path_follows_the_weights_around_known_walls() {
        let maze: Maze = MAZE.parse().unwrap();
        let mut map = KnownMaze::unexplored(&maze);
        let plan = |map: &KnownMaze, pose, weight: &dyn Fn(Cell) -> u16| {
            planned_path(map, pose, |cell| u8::try_from(weight(cell)).ok())
        };
        let to_goal = |cell: Cell| u16::from(3 - cell.x + 3 - cell.y);
        let start = maze.start();
        let cells = |list: &[(u8, u8)]| -> Vec<Cell> {
            list.iter().map(|&(x, y)| Cell::new(x, y)).collect()
        };
        // Straight ahead, since all neighbours are equally good.
        let expected = cells(&[(0, 0), (0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (3, 3)]);
        assert_eq!(plan(&map, start, &to_goal), expected);
        map.set_wall(start.cell, Heading::North, WallState::Present);
        let expected = cells(&[(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (3, 3)]);
        assert_eq!(plan(&map, start, &to_goal), expected);
        // A dead end of the weights, no lower weight, and the goal.
        let dead_end = |cell: Cell| if cell == Cell::new(1, 0) { 0 } else { 7 };
        assert_eq!(plan(&map, start, &dead_end), cells(&[(0, 0), (1, 0)]));
        assert_eq!(plan(&map, start, &|_| 0), []);
        assert_eq!(plan(&map, Pose::new(Cell::new(3, 3), Heading::East), &to_goal), []);
    }
}
