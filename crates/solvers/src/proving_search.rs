//! The proving search, which explores until the best run is proven.

use mmsim_maze::{Cell, CellSet, KnownMaze, MazeSize, Pose, Step, Unknown, Walls};

use crate::flood::{Distances, FloodMemory, UNREACHABLE, only, steps_between_in};
use crate::strategy::{Move, Phase, SearchError, Strategy, step_to_least};

/// A strategy that goes to the goal, explores until the best run is proven, returns to the start,
/// and runs to the goal. The [`Objective`] defines which run is best.
///
/// If the goal is unreachable, the mouse returns to the start before the strategy returns an error.
#[derive(Clone, Debug)]
pub(crate) struct ProvingSearch<O> {
    pub(crate) objective: O,
    stage: ProofStage,
    plan: DownhillPlan,
    /// The cells in which the strategy has made a decision. A second visit to a cell reveals no new
    /// walls.
    visited: CellSet,
    /// The current target of the exploration.
    target: Option<Cell>,
    /// The south-western and north-eastern corners of the bounding box of the goal cells, or `None`
    /// before the first decision.
    goal_corners: Option<[Cell; 2]>,
}

/// What one proving search does differently from another: it selects the cells to explore, and it
/// plans the fast run.
pub(crate) trait Objective {
    /// True if [`next_target`](Self::next_target) overwrites the distances of the plan.
    const OVERWRITES_DISTANCES: bool = false;

    /// Returns true if the walls around `cell`, which the mouse has just read, may change the
    /// target.
    fn may_change_target(&self, cell: Cell) -> bool;

    /// Selects the cell that a mouse in `cell` explores next. Returns `None` if the best run is
    /// proven.
    fn next_target(&mut self, map: &KnownMaze, cell: Cell, plan: &mut DownhillPlan)
    -> Option<Cell>;

    /// Returns a number for each neighbour of `cell`, in the order of
    /// [`Heading::ALL`](mmsim_maze::Heading::ALL). Among equally near neighbours, the mouse prefers
    /// the one with the smallest number.
    fn preferences(&self, map: &KnownMaze, cell: Cell) -> [u8; 4];

    /// Plans the fast run, which begins at the start.
    fn plan_fast_run(&mut self, map: &KnownMaze, plan: &mut DownhillPlan);

    /// Forgets what was concluded from walls that have turned out to be wrong.
    fn reconsider(&mut self) {}

    /// Returns the next move of the fast run, or `None` if the mouse is boxed in.
    fn fast_move(&mut self, map: &KnownMaze, pose: Pose, plan: &DownhillPlan) -> Option<Move>;
}

/// A plan to take the steps that lead nearer to a target.
#[derive(Clone, Debug)]
pub(crate) struct DownhillPlan {
    pub(crate) distances: Distances,
    /// Memory for floods and for the selection of a target on small cores.
    pub(crate) memory: FloodMemory,
}

/// A part of a proving search.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ProofStage {
    ToGoal,
    Explore,
    Return,
    /// The mouse returns to the start because the goal is unreachable.
    GiveUp,
    FastRun,
}

impl<O: Objective> ProvingSearch<O> {
    pub(crate) const fn new(objective: O) -> Self {
        let distances = Distances::unreachable(MazeSize::CLASSIC);
        Self {
            objective,
            stage: ProofStage::ToGoal,
            plan: DownhillPlan { distances, memory: FloodMemory::NEW },
            visited: CellSet::EMPTY,
            target: None,
            goal_corners: None,
        }
    }

    /// Plans the next steps. If the current stage is complete, begins the next one.
    fn plan(&mut self, map: &KnownMaze, cell: Cell) {
        let open = map.walls(Unknown::Open);
        if self.stage == ProofStage::ToGoal {
            if !self.plan.distances.is_downhill_open(open, cell) {
                self.plan.flood(open, map.goals());
            }
            if map.goals().contains(cell) {
                self.stage = ProofStage::Explore;
            } else if self.plan.distances.at(cell).is_none() {
                self.stage = ProofStage::GiveUp;
            }
        }
        if self.stage == ProofStage::Explore {
            self.plan_exploration(map, cell);
        }
        if matches!(self.stage, ProofStage::Return | ProofStage::GiveUp) {
            self.plan.return_to_start(map, cell);
        }
        if self.stage == ProofStage::Return && cell == map.start().cell {
            self.stage = ProofStage::FastRun;
            self.objective.plan_fast_run(map, &mut self.plan);
        }
    }

    fn plan_exploration(&mut self, map: &KnownMaze, cell: Cell) {
        let open = map.walls(Unknown::Open);
        let is_valid = self.target.is_some() && self.plan.distances.is_downhill_open(open, cell);
        if is_valid && !self.objective.may_change_target(cell) {
            return;
        }
        let before = self.target;
        self.target = self.objective.next_target(map, cell, &mut self.plan);
        let is_same = is_valid && before == self.target && !O::OVERWRITES_DISTANCES;
        match self.target {
            Some(target) if !is_same => self.plan.flood_from(open, target),
            Some(_) => {}
            None => self.stage = ProofStage::Return,
        }
    }
}

impl DownhillPlan {
    pub(crate) fn flood(&mut self, walls: &Walls, targets: &CellSet) {
        self.distances.reflood_in(Some(&mut self.memory.sides), walls, targets);
    }

    // Not inlined, like `return_to_start`, so that the set occupies the stack only during this call.
    #[inline(never)]
    pub(crate) fn flood_from(&mut self, walls: &Walls, cell: Cell) {
        self.flood(walls, &only(cell));
    }

    /// Plans the shortest known path to the start, or a shorter path through unknown walls.
    #[inline(never)]
    fn return_to_start(&mut self, map: &KnownMaze, cell: Cell) {
        let (open, closed) = (map.walls(Unknown::Open), map.walls(Unknown::Closed));
        let start = only(map.start().cell);
        let optimistic = steps_between_in(Some(&mut self.memory), open, cell, &start);
        self.flood(closed, &start);
        if optimistic.unwrap_or(UNREACHABLE) < self.distances.raw(cell) {
            self.flood(open, &start);
        }
    }

    /// Returns the step to the neighbour that is nearest to the target. Among equally near
    /// neighbours, prefers the one with the smallest of `preferences`.
    // Not inlined, because it has two callers and small cores have little flash.
    #[inline(never)]
    pub(crate) fn step(&self, map: &KnownMaze, pose: Pose, preferences: [u8; 4]) -> Option<Step> {
        let mut numbers = self.distances.raw_around(pose.cell).map(u32::from);
        for (number, preference) in numbers.iter_mut().zip(preferences) {
            *number = *number << 8 | u32::from(preference);
        }
        let (step, number) = step_to_least(map, pose, numbers)?;
        (number >> 8 < UNREACHABLE.into()).then_some(step)
    }
}

impl<O: Objective> Strategy for ProvingSearch<O> {
    fn next_move(&mut self, map: &KnownMaze, pose: Pose) -> Result<Move, SearchError> {
        let cell = pose.cell;
        let is_new = self.visited.insert(cell) || cell == map.start().cell;
        if is_new && self.stage != ProofStage::FastRun {
            self.plan(map, cell);
        }
        let preferences = match self.stage {
            ProofStage::FastRun => {
                let next = self.objective.fast_move(map, pose, &self.plan);
                return next.ok_or(SearchError::BoxedIn { cell });
            }
            ProofStage::GiveUp if map.start().cell == cell => {
                return Err(SearchError::GoalUnreachable { cell });
            }
            ProofStage::ToGoal => {
                let corners = *self.goal_corners.get_or_insert_with(|| corners(map.goals()));
                crow_flies_around(cell, corners)
            }
            _ => self.objective.preferences(map, cell),
        };
        let step = self.plan.step(map, pose, preferences);
        step.map(Move::Step).ok_or(SearchError::BoxedIn { cell })
    }

    fn reconsider(&mut self) {
        self.objective.reconsider();
        self.visited = CellSet::EMPTY;
        self.target = None;
        self.plan.distances = Distances::unreachable(MazeSize::CLASSIC);
        self.stage = match self.stage {
            ProofStage::ToGoal | ProofStage::GiveUp => ProofStage::ToGoal,
            ProofStage::Explore | ProofStage::Return | ProofStage::FastRun => ProofStage::Explore,
        };
    }

    fn weight(&self, cell: Cell) -> Option<u16> {
        self.plan.distances.at(cell)
    }

    fn phase(&self) -> Phase {
        match self.stage {
            ProofStage::ToGoal | ProofStage::Explore => Phase::SearchRun,
            ProofStage::Return | ProofStage::GiveUp => Phase::ReturnRun,
            ProofStage::FastRun => Phase::FastRun,
        }
    }
}

/// Returns the south-western and north-eastern corners of the bounding box of `cells`.
fn corners(cells: &CellSet) -> [Cell; 2] {
    let mut cells = cells.iter();
    let first = cells.next().unwrap_or(Cell::new(0, 0));
    cells.fold([first; 2], |[south_west, north_east], Cell { x, y }| {
        [
            Cell::new(south_west.x.min(x), south_west.y.min(y)),
            Cell::new(north_east.x.max(x), north_east.y.max(y)),
        ]
    })
}

/// Returns the distances of a cell's neighbours from a bounding box, in the order of
/// [`Heading::ALL`](mmsim_maze::Heading::ALL). The distance is the difference in columns or in
/// rows, whichever is larger. Walls are ignored.
fn crow_flies_around(cell: Cell, [south_west, north_east]: [Cell; 2]) -> [u8; 4] {
    let off = |from: u8, at: u8, to: u8| from.saturating_sub(at).max(at.saturating_sub(to));
    let columns = |x| off(south_west.x, x, north_east.x);
    let rows = |y| off(south_west.y, y, north_east.y);
    let Cell { x, y } = cell;
    [
        columns(x).max(rows(y.saturating_add(1))),
        columns(x.saturating_add(1)).max(rows(y)),
        columns(x).max(rows(y.saturating_sub(1))),
        columns(x.saturating_sub(1)).max(rows(y)),
    ]
}
