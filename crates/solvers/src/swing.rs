//! The swing strategy, which visits the centre and the corners, returns, and runs to the goal.

use mmsim_maze::{Cell, KnownMaze, MazeSize, Pose, Step, Unknown, Walls};

use crate::a_star::ShortestPath;
use crate::flood::{Distances, only};
use crate::key_point_route::{KeyPointRoute, centre};
use crate::strategy::{Move, Phase, SearchError, Strategy, step_to_least};

/// A strategy that visits the key points of a [`KeyPointRoute`] and then runs from the start to the
/// goal on the shortest known path. The strategy finds an optimistic shortest path to each key
/// point with A*, and plans again whenever the mouse sees a new wall.
///
/// The weight of a cell is its distance in steps to the next key point of the route or, on the fast
/// run, to the goal. The strategy always reaches the goal, or reports that it is unreachable.
#[derive(Clone, Debug)]
pub struct Swing {
    /// The route, or `None` before the first decision.
    route: Option<KeyPointRoute>,
    /// The path to the next key point, and the number of steps that the mouse has taken along it.
    plan: Option<(ShortestPath, usize)>,
    /// The walls that were known when the path was planned.
    walls: Walls,
    distances: Distances,
    phase: Phase,
}

impl Swing {
    /// Creates the strategy in its initial state.
    pub const fn new() -> Self {
        Self {
            route: None,
            plan: None,
            walls: Walls::open(MazeSize::CLASSIC),
            distances: Distances::unreachable(MazeSize::CLASSIC),
            phase: Phase::SearchRun,
        }
    }

    /// Plans the path to the next key point. If no key point is left, the fast run begins.
    fn plan(&mut self, map: &KnownMaze, cell: Cell) -> Result<(), SearchError> {
        let walls = map.walls(Unknown::Open);
        centre(map.goals(), walls, cell).ok_or(SearchError::GoalUnreachable { cell })?;
        let target = self.route.as_mut().and_then(|route| route.target(walls, cell));
        self.plan = target.and_then(|target| Some((ShortestPath::find(walls, cell, target)?, 0)));
        self.walls = walls.clone();
        let is_returning = self.route.as_ref().is_some_and(KeyPointRoute::is_returning);
        self.phase = match target {
            None => Phase::FastRun,
            Some(_) if is_returning => Phase::ReturnRun,
            Some(_) => Phase::SearchRun,
        };
        self.distances = match target {
            Some(target) => Distances::flood(walls, &only(target)),
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

    fn reconsider(&mut self) {
        self.plan = None;
        if self.phase == Phase::FastRun {
            self.route = self.route.take().map(KeyPointRoute::back);
            self.phase = Phase::ReturnRun;
        }
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        self.distances.at(cell)
    }

    fn phase(&self) -> Phase {
        self.phase
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{Outcome, search};

    #[test]
    fn visits_the_key_points_and_runs_to_the_goal() {
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
    fn reports_an_unreachable_goal() {
        let maze = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o\n";
        let Outcome { result, .. } = search(Swing::new(), maze, 100);
        assert!(matches!(result, Err(SearchError::GoalUnreachable { .. })), "{result:?}");
    }

    #[test]
    fn stops_if_the_start_is_a_goal() {
        for maze in ["o---o\n|SG |\no---o\n", "o---o---o\n| G |SG |\no---o---o\n"] {
            assert_eq!(search(Swing::new(), maze, 100).result, Ok(Move::Stop));
        }
    }
}
