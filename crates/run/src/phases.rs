//! What a mouse did up to a state: its phases, their steps and turns, and whether it has reached the
//! goal.

use mmsim_maze::{Cell, Pose};

use crate::movement::{MovementRules, Transition};

/// The phases of the states from the first state of a run to another state.
///
/// - A mouse has *reached the goal* when its search run ends in a goal cell. It must have begun in the
///   start cell and have moved there: after a jump, a goal does not count.
/// - The *search run* leads from the first state to the first goal cell. It continues if the mouse
///   is put back at the start before it has reached a goal cell.
/// - A *return run* leads from the goal to the start cell, whether or not the mouse still explores.
/// - A *fast run* leads from the start cell to the goal. Its time begins with the last state before
///   the mouse leaves the start cell, and earlier turns in this cell count as its turns. It ends
///   early if the mouse is put back at the start.
///
/// Only the latest return run, the latest fast run and the best complete fast run are kept;
/// [`total`](Self::total) counts all runs. See [`Transition`] for what counts as a movement.
///
/// ```
/// use mmsim_maze::{Cell, Heading, Maze, Pose};
/// use mmsim_run::{MovementRules, Phases};
/// let maze: Maze = "o---o---o---o\n| S       G |\no---o---o---o\n".parse()?;
/// let (rules, mut phases) = (MovementRules::from_maze(&maze), Phases::default());
/// for (x, heading) in [(0, Heading::North), (1, Heading::East), (2, Heading::East)] {
///     phases.add(&rules, Pose::new(Cell::new(x, 0), heading), false);
/// }
/// assert_eq!((phases.total.steps, phases.total.turns), (2, 1));
/// assert!(phases.is_goal_reached());
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Phases {
    /// The number of states.
    pub states: u32,
    /// The newest valid pose.
    pub pose: Option<Pose>,
    /// The phase in which the mouse is.
    pub phase: RunPhase,
    /// The transition to the newest state, or `None` in the first state.
    pub transition: Option<Transition>,
    /// The steps and turns until the mouse has reached the goal, or `None` if it has not.
    pub goal: Option<MotionCount>,
    /// The cells before and after the first change of the pose that no movement explains. A mouse
    /// that begins outside the start cell has jumped there.
    pub first_jump: Option<[Cell; 2]>,
    /// The search run.
    pub search_run: RunFigures,
    /// The latest return run.
    pub return_run: RunFigures,
    /// The latest fast run, which may be incomplete.
    pub fast_run: RunFigures,
    /// The complete fast run with the fewest steps or, among several, the fewest turns. Runs after a jump
    /// do not count.
    pub best_run: Option<RunFigures>,
    /// The number of fast runs that have begun.
    pub fast_runs: u32,
    /// The number of times that the mouse was put back at the start.
    pub restarts: u32,
    /// The number of jumps to other cells.
    pub jumps: u32,
    /// All steps and turns.
    pub total: MotionCount,
    /// The number of quarter turns in the start cell since the last return run.
    pub(crate) turns_at_start: u32,
}

/// The phase in which a mouse is.
// Recordings contain the numbers of these variants, so their order must not change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RunPhase {
    /// The mouse has not reached the goal yet.
    #[default]
    Search,
    /// The mouse has reached the goal and not moved since.
    AtGoal,
    /// The mouse returns to the start.
    Return,
    /// The mouse is in the start cell, ready for a fast run.
    AtStart,
    /// The mouse is on a fast run.
    Fast,
}

impl RunPhase {
    /// Returns the phase as a value in JSON.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Search => "search_run",
            Self::AtGoal => "at_goal",
            Self::Return => "return_run",
            Self::AtStart => "at_start",
            Self::Fast => "fast_run",
        }
    }

    /// Returns the name of the phase.
    pub fn name(self) -> String {
        self.key().replace('_', " ")
    }
}

/// The figures of a search run, a return run or a fast run. States are numbered from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RunFigures {
    /// The state in which the run began.
    pub first: u32,
    /// The state after the last movement.
    pub last: u32,
    /// The number of steps, in cells.
    pub steps: u32,
    /// The number of quarter turns.
    pub turns: u32,
}

/// A number of steps and turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionCount {
    /// The number of steps, in cells.
    pub steps: u64,
    /// The number of quarter turns. A U-turn counts as two.
    pub turns: u64,
}

/// How far a mouse has come: the number of its current leg, and the steps since the leg began.
///
/// Legs are the runs of a search in order: leg 0 is the search run, leg 2k is the k-th fast run, and
/// leg 2k + 1 is the return run that follows leg 2k. A mouse that waits in the goal or in the start
/// cell is at the end of a leg. A leg has no steps if the mouse is put back at the start instead of
/// returning. From state to state, the progress never decreases.
///
/// ```
/// use mmsim_run::{LegProgress, Phases};
/// assert_eq!(Phases::default().leg(), LegProgress { leg: 0, steps: 0 });
/// assert!(LegProgress { leg: 1, steps: 3 } < LegProgress { leg: 2, steps: 0 });
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct LegProgress {
    /// The number of the leg.
    pub leg: u32,
    /// The number of steps since the leg began, in cells.
    pub steps: u32,
}

impl RunFigures {
    const fn beginning(first: u32, turns: u32) -> Self {
        Self { first, last: first, steps: 0, turns }
    }

    /// Returns true if the run has neither steps nor turns.
    pub const fn is_empty(&self) -> bool {
        self.steps == 0 && self.turns == 0
    }

    fn add(&mut self, state: u32, steps: u8, turns: u8) {
        if steps > 0 || turns > 0 {
            self.last = state;
        }
        self.steps = self.steps.saturating_add(steps.into());
        self.turns = self.turns.saturating_add(turns.into());
    }
}

impl Phases {
    /// Adds the next state. If the client says that the mouse was put back at the start before it,
    /// `is_restart` is true.
    pub fn add(&mut self, rules: &MovementRules, pose: Pose, is_restart: bool) {
        let state = self.states;
        self.states = state.saturating_add(1);
        if let Some(before) = self.pose.replace(pose) {
            let transition =
                if is_restart { rules.restart(pose) } else { rules.transition(before, pose) };
            self.transition = Some(transition);
            self.apply(state, transition);
            if transition == Transition::Jump {
                self.first_jump.get_or_insert([before.cell, pose.cell]);
            }
        } else if pose.cell != rules.start().cell {
            self.first_jump = Some([rules.start().cell, pose.cell]);
        }
        self.arrive(rules, pose);
    }

    /// Counts a state whose pose is invalid. The mouse counts as unmoved.
    pub const fn skip(&mut self) {
        self.states = self.states.saturating_add(1);
        self.transition = None;
    }

    /// Returns true if the mouse has reached the goal.
    pub const fn is_goal_reached(&self) -> bool {
        self.goal.is_some()
    }

    /// Describes the first jump, or returns `None` if the mouse has not jumped.
    pub fn jump_error(&self) -> Option<String> {
        let [from, to] = self.first_jump?;
        Some(format!("jumped from {from} to {to}, which no movement can reach"))
    }

    /// Returns the current leg and the steps since it began.
    pub fn leg(&self) -> LegProgress {
        let outward = 2 * u64::from(self.fast_runs);
        let returned = self.return_run;
        // Before the return run of this leg, `return_run` is an earlier one.
        let is_current = !returned.is_empty() && returned.first >= self.fast_run.first;
        let (leg, run) = match self.phase {
            RunPhase::Search => (outward, self.search_run),
            RunPhase::AtGoal if self.fast_runs == 0 => (outward, self.search_run),
            RunPhase::AtGoal | RunPhase::Fast => (outward, self.fast_run),
            RunPhase::Return => (outward + 1, returned),
            RunPhase::AtStart if is_current => (outward + 1, returned),
            RunPhase::AtStart => (outward + 1, RunFigures::default()),
        };
        LegProgress { leg: u32::try_from(leg).unwrap_or(u32::MAX), steps: run.steps }
    }

    fn apply(&mut self, state: u32, transition: Transition) {
        match transition {
            Transition::Move { steps, turns } => {
                self.total.steps += u64::from(steps);
                self.total.turns += u64::from(turns);
                self.begin_run(state, steps, turns);
                match self.phase {
                    RunPhase::Search => self.search_run.add(state, steps, turns),
                    RunPhase::Return => self.return_run.add(state, steps, turns),
                    RunPhase::Fast => self.fast_run.add(state, steps, turns),
                    RunPhase::AtStart => {
                        self.turns_at_start = self.turns_at_start.saturating_add(turns.into());
                    }
                    RunPhase::AtGoal => {}
                }
            }
            Transition::Restart => {
                self.restarts = self.restarts.saturating_add(1);
                if self.phase != RunPhase::Search {
                    self.phase = RunPhase::AtStart;
                }
            }
            Transition::Jump => self.jumps = self.jumps.saturating_add(1),
        }
    }

    /// Begins a return run or a fast run if the mouse leaves the goal or the start.
    fn begin_run(&mut self, state: u32, steps: u8, turns: u8) {
        let before = state.saturating_sub(1);
        match self.phase {
            RunPhase::AtGoal if steps > 0 || turns > 0 => {
                self.return_run = RunFigures::beginning(before, 0);
                self.phase = RunPhase::Return;
            }
            RunPhase::AtStart if steps > 0 => {
                let turns = std::mem::take(&mut self.turns_at_start);
                self.fast_run = RunFigures::beginning(before, turns);
                self.fast_runs = self.fast_runs.saturating_add(1);
                self.phase = RunPhase::Fast;
            }
            _ => {}
        }
    }

    /// Ends a run if the mouse has reached the goal or the start.
    fn arrive(&mut self, rules: &MovementRules, pose: Pose) {
        let is_goal = rules.goals().contains(pose.cell);
        match self.phase {
            RunPhase::Search if is_goal => {
                self.phase = RunPhase::AtGoal;
                self.goal = self.first_jump.is_none().then_some(self.total);
            }
            RunPhase::Fast if is_goal => {
                self.phase = RunPhase::AtGoal;
                if self.first_jump.is_none() {
                    let runs = [self.best_run, Some(self.fast_run)].into_iter().flatten();
                    self.best_run = runs.min_by_key(|run| (run.steps, run.turns));
                }
            }
            RunPhase::Return if pose.cell == rules.start().cell => self.phase = RunPhase::AtStart,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::Heading::{East, North, West};
    use mmsim_maze::{Cell, Heading, Maze};
    use proptest::prelude::*;

    use super::*;

    fn phases(rules: &MovementRules, poses: &[Pose]) -> Phases {
        let mut phases = Phases::default();
        for &pose in poses {
            phases.add(rules, pose, false);
        }
        phases
    }

    /// A corridor of five cells from west to east, with the start in the west and the goal in the
    /// east.
    fn corridor() -> MovementRules {
        let maze: Maze = "o---o---o---o---o---o\n| S               G |\no---o---o---o---o---o\n"
            .parse()
            .unwrap();
        MovementRules::from_maze(&maze)
    }

    fn poses(list: &[(u8, Heading)]) -> Vec<Pose> {
        list.iter().map(|&(x, heading)| Pose::new(Cell::new(x, 0), heading)).collect()
    }

    fn run(first: u32, last: u32, steps: u32, turns: u32) -> RunFigures {
        RunFigures { first, last, steps, turns }
    }

    #[test]
    fn a_search_has_a_search_run_a_return_run_and_a_fast_run() {
        let states = poses(&[
            (0, North),
            (0, North),
            (1, East),
            (4, East),
            (4, West),
            (1, West),
            (0, West),
            (0, North),
            (2, East),
            (4, East),
        ]);
        let up_to = |count| phases(&corridor(), &states[..count]);
        assert_eq!((up_to(1).states, up_to(1).total), (1, MotionCount::default()));
        assert_eq!(up_to(3).search_run, run(0, 2, 1, 1));
        let at_goal = up_to(4);
        assert_eq!((at_goal.phase, at_goal.search_run), (RunPhase::AtGoal, run(0, 3, 4, 1)));
        assert_eq!(up_to(6).return_run, run(3, 5, 3, 2));
        // The turn in the start cell belongs to the fast run, which starts when the mouse leaves
        // the cell.
        let at_start = up_to(8);
        assert_eq!((at_start.phase, at_start.return_run), (RunPhase::AtStart, run(3, 6, 4, 2)));
        assert_eq!((at_start.fast_run, at_start.fast_runs), (RunFigures::default(), 0));
        assert_eq!(up_to(9).fast_run, run(7, 8, 2, 2));
        let end = up_to(10);
        assert_eq!((end.fast_run, end.fast_runs), (run(7, 9, 4, 2), 1));
        assert_eq!(end.best_run, Some(end.fast_run));
        assert_eq!((end.search_run, end.return_run), (at_goal.search_run, at_start.return_run));
        assert_eq!(end.total, MotionCount { steps: 12, turns: 5 });
        assert_eq!((end.restarts, end.jumps), (0, 0));
    }

    #[test]
    fn a_restart_counts_no_steps() {
        let mut states = poses(&[(0, North), (2, East), (0, North), (3, East), (4, East)]);
        let searched = phases(&corridor(), &states);
        assert_eq!((searched.restarts, searched.phase), (1, RunPhase::AtGoal));
        assert_eq!(searched.search_run, run(0, 4, 6, 2));
        states.extend(poses(&[(3, West), (0, West)]));
        // A fast run that ends in a crash, a fast run to the goal, and one with more turns.
        states.extend(poses(&[(2, East), (0, North), (4, East)]));
        states.extend(poses(&[(0, North), (2, East), (2, North), (2, East), (4, East)]));
        let end = phases(&corridor(), &states);
        assert_eq!((end.restarts, end.fast_runs), (3, 3));
        assert_eq!((end.search_run, end.return_run), (searched.search_run, run(4, 6, 4, 2)));
        assert_eq!((end.fast_run, end.best_run), (run(10, 14, 4, 3), Some(run(8, 9, 4, 1))));
        assert_eq!(end.total, MotionCount { steps: 6 + 4 + 2 + 4 + 4, turns: 2 + 2 + 2 + 1 + 3 });
        // A mouse that appears in another cell.
        states.extend(poses(&[(4, North), (1, North)]));
        let jumped = phases(&corridor(), &states);
        assert_eq!((jumped.jumps, jumped.total.steps), (1, end.total.steps));
    }

    /// Computes the phases from the list of all transitions.
    fn twin(rules: &MovementRules, poses: &[Pose]) -> Phases {
        let transitions: Vec<_> = (1..poses.len())
            .map(|state| rules.transition(poses[state - 1], poses[state]))
            .collect();
        let count = |is: fn(&Transition) -> bool| {
            u32::try_from(transitions.iter().filter(|one| is(one)).count()).unwrap()
        };
        let at = |state: usize| transitions[state - 1];
        let motion = |state: usize| match at(state) {
            Transition::Move { steps, turns } => (u32::from(steps), u32::from(turns)),
            Transition::Restart | Transition::Jump => (0, 0),
        };
        let figures = |first: usize, end: usize| {
            let states: Vec<_> = (first + 1..=end).filter(|&it| motion(it) != (0, 0)).collect();
            let sum = |part: fn((u32, u32)) -> u32| states.iter().map(|&it| part(motion(it))).sum();
            let last = states.last().copied().unwrap_or(first);
            let [first, last] = [first, last].map(|state| u32::try_from(state).unwrap());
            run(first, last, sum(|it| it.0), sum(|it| it.1))
        };
        let is_goal = |&state: &usize| rules.goals().contains(poses[state].cell);
        let is_restart = |state: &usize| at(*state) == Transition::Restart;
        let all = 0..poses.len();
        let newest = poses.len() - 1;
        let jump = all.clone().skip(1).find(|&state| at(state) == Transition::Jump);
        let first_goal = all.clone().find(is_goal);
        let counted = first_goal.filter(|&goal| jump.is_none_or(|jump| jump > goal)).map(|goal| {
            let sum = figures(0, goal);
            MotionCount { steps: sum.steps.into(), turns: sum.turns.into() }
        });
        let mut result = Phases {
            states: u32::try_from(poses.len()).unwrap(),
            pose: poses.last().copied(),
            goal: counted,
            first_jump: jump.map(|state| [poses[state - 1].cell, poses[state].cell]),
            restarts: count(|it| *it == Transition::Restart),
            jumps: count(|it| *it == Transition::Jump),
            transition: transitions.last().copied(),
            ..Phases::default()
        };
        let sum = figures(0, newest);
        result.total = MotionCount { steps: sum.steps.into(), turns: sum.turns.into() };
        let mut goal = all.clone().find(is_goal);
        result.search_run = figures(0, goal.unwrap_or(newest));
        while let Some(reached) = goal.take() {
            result.phase = RunPhase::AtGoal;
            let moves = (reached + 1..=newest).find(|&state| motion(state) != (0, 0));
            let returned = moves.and_then(|moves| {
                (moves..=newest).find(|&state| poses[state].cell == rules.start().cell)
            });
            let lifted = (reached + 1..=newest).find(is_restart);
            let is_lifted =
                lifted.is_some() && returned.is_none_or(|state| lifted < Some(state + 1));
            let start = if is_lifted { lifted } else { returned };
            if let Some(moves) = moves.filter(|&moves| start.is_none_or(|start| moves <= start)) {
                result.phase = RunPhase::Return;
                result.return_run = figures(moves - 1, start.unwrap_or(newest));
            }
            let Some(mut start) = start else { break };
            loop {
                result.phase = RunPhase::AtStart;
                let leaves = (start + 1..=newest).find(|&state| motion(state).0 > 0);
                let Some(leaves) = leaves else {
                    result.turns_at_start = figures(start, newest).turns;
                    break;
                };
                result.phase = RunPhase::Fast;
                result.fast_runs += 1;
                let end = (leaves..=newest).find(|state| is_goal(state) || is_restart(state));
                result.fast_run = figures(leaves - 1, end.unwrap_or(newest));
                result.fast_run.turns += figures(start, leaves - 1).turns;
                match end {
                    Some(end) if is_restart(&end) => start = end,
                    Some(end) => {
                        let has_jumped = jump.is_some_and(|jump| jump <= end);
                        let new = Some(result.fast_run).filter(|_| !has_jumped);
                        let runs = [result.best_run, new].into_iter().flatten();
                        result.best_run = runs.min_by_key(|run| (run.steps, run.turns));
                        goal = Some(end);
                        break;
                    }
                    None => break,
                }
            }
        }
        result
    }

    proptest! {
        #[test]
        fn phases_equal_those_found_in_the_list_of_all_transitions(
            (width, height) in (1usize..=4, 1usize..=3),
            (start, goal) in (any::<(u8, u8)>(), any::<(u8, u8)>()),
            moves in prop::collection::vec((0u8..16, 0u8..4), 1..120),
        ) {
            let size = mmsim_maze::MazeSize::new(width, height).unwrap();
            let cell = |(x, y): (u8, u8)| Cell::new(x % size.width(), y % size.height());
            let walls = mmsim_maze::Walls::open(size);
            let goals = [cell(goal)].into_iter().collect();
            let Ok(maze) = Maze::new(walls, cell(start), goals) else { return Ok(()) };
            let (rules, mut pose) = (MovementRules::from_maze(&maze), maze.start());
            let mut poses = vec![pose];
            for (kind, heading) in moves {
                let heading = Heading::ALL[usize::from(heading)];
                pose = match kind {
                    0 => maze.start(),
                    1 => Pose::new(cell((kind * 3 + heading as u8, heading as u8)), heading),
                    2..5 => Pose::new(pose.cell, heading),
                    _ => {
                        let next = size.neighbour(pose.cell, heading).unwrap_or(pose.cell);
                        Pose::new(next, heading)
                    }
                };
                poses.push(pose);
            }
            for count in 1..=poses.len() {
                prop_assert_eq!(phases(&rules, &poses[..count]), twin(&rules, &poses[..count]));
            }
        }
    }

    /// Returns the progress in each state of a mouse in a corridor of five cells, with the start in
    /// cell 0 and the goal in cell 4. The mouse is put back at the start if it moves from another cell
    /// to cell 0 with the heading north.
    fn progress(states: &[(u8, Heading)]) -> Vec<(u32, u32)> {
        let maze: Maze = "o---o---o---o---o---o\n| S               G |\no---o---o---o---o---o\n"
            .parse()
            .unwrap();
        let (rules, mut phases) = (MovementRules::from_maze(&maze), Phases::default());
        let add = |&(x, heading): &(u8, Heading)| {
            phases.add(&rules, Pose::new(Cell::new(x, 0), heading), false);
            let LegProgress { leg, steps } = phases.leg();
            (leg, steps)
        };
        states.iter().map(add).collect()
    }

    #[test]
    fn legs_are_the_runs_in_order() {
        let states = [
            (0, North),
            (3, East),
            (4, East),
            // A return run and the first fast run.
            (4, West),
            (1, West),
            (0, West),
            (0, East),
            (2, East),
            (4, East),
            // The mouse is put back instead of returning. The second fast run ends early.
            (0, North),
            (2, East),
            (0, North),
            // The third fast run.
            (1, East),
            (4, East),
            (4, West),
            (3, West),
        ];
        let expected = [
            (0, 0),
            (0, 3),
            (0, 4),
            (1, 0),
            (1, 3),
            (1, 4),
            (1, 4),
            (2, 2),
            (2, 4),
            (3, 0),
            (4, 2),
            (5, 0),
            (6, 1),
            (6, 4),
            (7, 0),
            (7, 1),
        ];
        assert_eq!(progress(&states), expected);
    }

    proptest! {
        #[test]
        fn progress_never_decreases(
            states in prop::collection::vec((0u8..5, 0usize..4), 1..200),
        ) {
            let heading = |index: usize| Heading::ALL[index];
            let states: Vec<_> = states.into_iter().map(|(x, at)| (x, heading(at))).collect();
            let progress = progress(&states);
            prop_assert!(progress.is_sorted(), "{:?}", progress);
        }
    }
}
