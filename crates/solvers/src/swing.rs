//! Swing: over centre and corners, back to the start, and then fast to the goal.

use mmsim_maze::{Cell, KnownMaze, MazeSize, Pose, Step, Unknown, Walls};

use crate::a_star::ShortestPath;
use crate::flood::Distances;
use crate::key_point_route::{KeyPointRoute, centre};
use crate::strategy::{Move, Phase, SearchError, Strategy, step_to_least};

/// Swing: explores on a [`KeyPointRoute`] from key point to key point, each time by the shortest way with
/// unknown walls taken as open, planned anew with A* whenever a wall shows up; then it runs from
/// the start to the goal by the shortest way that it knows.
///
/// Its weights are distances to the current key point over what is known, in steps, and on the fast
/// run those to the goal. It reaches the goal wherever there is a way, and says so where there is
/// none.
#[derive(Clone, Debug)]
pub struct Swing {
    /// From the first decision on.
    route: Option<KeyPointRoute>,
    /// The way to the key point and how many steps of it are done.
    plan: Option<(ShortestPath, usize)>,
    /// The walls for which it was planned.
    walls: Walls,
    distances: Distances,
    phase: Phase,
}

impl Swing {
    /// A search that has not begun yet.
    pub const fn new() -> Self {
        Self {
            route: None,
            plan: None,
            walls: Walls::open(MazeSize::CLASSIC),
            distances: Distances::unreachable(MazeSize::CLASSIC),
            phase: Phase::SearchRun,
        }
    }

    /// Plans the way to the next key point; without one the fast run begins.
    fn plan(&mut self, map: &KnownMaze, cell: Cell) -> Result<(), SearchError> {
        let walls = map.walls(Unknown::Open);
        centre(map.goals(), walls, cell).ok_or(SearchError::GoalUnreachable { cell })?;
        let target = self.route.as_mut().and_then(|route| route.target(walls, cell));
        self.plan = target.and_then(|target| Some((ShortestPath::find(walls, cell, target)?, 0)));
        self.walls = walls.clone();
        self.phase = match &self.route {
            Some(route) if target.is_some() && !route.is_returning() => Phase::SearchRun,
            Some(_) if target.is_some() => Phase::ReturnRun,
            _ => Phase::FastRun,
        };
        self.distances = match target {
            Some(target) => Distances::flood(walls, &[target].into_iter().collect()),
            None => Distances::flood(map.walls(Unknown::Closed), map.goals()),
        };
        Ok(())
    }
}

impl Default for Swing {
    fn default() -> Self {
        Self::new()
    }
}

impl Strategy for Swing {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        let Pose { cell, heading } = pose;
        let route = || KeyPointRoute::there_and_back(map.size(), map.start().cell, *map.goals());
        self.route.get_or_insert_with(route).pass(cell);
        let is_done = |(path, done): &(ShortestPath, usize)| *done >= path.length().into();
        let is_stale = self.walls != *map.walls(Unknown::Open);
        if self.phase != Phase::FastRun && (is_stale || self.plan.as_ref().is_none_or(is_done)) {
            self.plan(map, cell)?;
        }
        let next = self.plan.as_mut().and_then(|(path, done)| {
            *done += 1;
            path.headings().nth(*done - 1)
        });
        let step = match next {
            Some(next) => Step::ALL.into_iter().find(|&step| heading.turned(step) == next),
            None if map.goals().contains(cell) => return Ok(Move::Stop),
            None => {
                let steps = self.distances.raw_around(cell).map(u32::from);
                step_to_least(map, pose, steps).map(|(step, _)| step)
            }
        };
        step.map(Move::Step).ok_or(SearchError::BoxedIn { cell })
    }

    fn weight(&self, cell: Cell) -> u16 {
        self.distances.raw(cell)
    }

    fn phase(&self) -> Phase {
        self.phase
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Outcome, search};

    #[test]
    fn it_swings_over_the_maze_and_runs_fast() {
        let maze = "\
o---o---o---o
|           |
o   o---o   o
|   | G     |
o   o---o   o
| S |       |
o---o---o---o
";
        let outcome = search(Swing::new(), maze, 100);
        assert_eq!((outcome.result, outcome.steps), (Ok(Move::Stop), 22));
        insta::assert_snapshot!(outcome.drawing, @"
        o---o---o---o
        | 4   3   2 |
        o   o---o   o
        | 5 | <   1 |
        o   o---o   o
        | 6 | 3   2 |
        o---o---o---o
        ");
    }

    #[test]
    fn a_goal_without_a_way_is_reported() {
        let maze = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";
        let Outcome { result, .. } = search(Swing::new(), maze, 100);
        assert!(matches!(result, Err(SearchError::GoalUnreachable { .. })), "{result:?}");
    }

    #[test]
    fn a_start_in_the_goal_is_no_trap() {
        for maze in ["o---o\n|SG |\no---o\n", "o---o---o\n| G |SG |\no---o---o\n"] {
            assert_eq!(search(Swing::new(), maze, 100).result, Ok(Move::Stop));
        }
    }
}
