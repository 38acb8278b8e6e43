//! The search of one mouse as a reinforcement-learning environment.

use std::sync::Arc;

use mmsim_generator::{Style, generate};
use mmsim_maze::{Cell, Heading, KnownMaze, Maze, MazeSize, Pose, Sides, Unknown, WyRand};
use mmsim_solvers::PathBounds;

/// The flag of a visited cell, as in a state.
const VISITED: u8 = 1;

/// The mazes that episodes are drawn from.
#[derive(Clone)]
pub(crate) enum MazePool {
    /// Each episode takes a random maze of this list, which is not empty.
    Listed(Arc<[Maze]>),
    /// Each episode generates a new maze.
    Generated(MazeSize, Style),
}

impl MazePool {
    fn draw(&self, rng: &mut WyRand) -> Maze {
        match self {
            Self::Listed(mazes) => mazes[rng.index(mazes.len())].clone(),
            Self::Generated(size, style) => generate(*size, rng.next_u64(), *style),
        }
    }
}

/// When an episode ends.
#[derive(Clone, Copy)]
pub(crate) struct EpisodeRules {
    /// True if an episode ends when the shortest path is proven, false if it ends at the goal.
    pub(crate) until_proven: bool,
    /// The number of actions after which an episode is truncated.
    pub(crate) max_steps: u32,
}

/// The result of one action.
#[derive(Clone, Copy, Default)]
pub(crate) struct Outcome {
    pub(crate) reward: f64,
    pub(crate) is_terminated: bool,
    pub(crate) is_truncated: bool,
}

/// One episode after another, each in a maze of the pool.
pub(crate) struct SearchEnv {
    rng: WyRand,
    maze: Maze,
    known: KnownMaze,
    pose: Pose,
    /// The number of actions in this episode, including those against a wall.
    steps: u32,
    is_goal_reached: bool,
    is_proven: bool,
    /// The flags of each cell as in a state, in the order of [`cell_index`]: [`VISITED`], and the
    /// sides that are known to have a wall.
    walls: Vec<u8>,
    /// The sides of each cell that are known to be open, with the same flags.
    openings: Vec<u8>,
    /// 1 for each goal cell, else 0.
    goals: Vec<u8>,
}

impl SearchEnv {
    /// Begins the first episode.
    pub(crate) fn new(pool: &MazePool, seed: u64) -> Self {
        let mut rng = WyRand::new(seed);
        let maze = pool.draw(&mut rng);
        let mut env = Self {
            rng,
            known: KnownMaze::unexplored(&maze),
            pose: maze.start(),
            maze,
            steps: 0,
            is_goal_reached: false,
            is_proven: false,
            walls: Vec::new(),
            openings: Vec::new(),
            goals: Vec::new(),
        };
        env.begin();
        env
    }

    /// Begins a new episode, in the next maze of the random sequence.
    pub(crate) fn reset(&mut self, pool: &MazePool) {
        self.maze = pool.draw(&mut self.rng);
        self.begin();
    }

    fn begin(&mut self) {
        self.known = KnownMaze::unexplored(&self.maze);
        self.pose = self.maze.start();
        (self.steps, self.is_proven) = (0, false);
        let size = self.maze.size();
        for flags in [&mut self.walls, &mut self.openings, &mut self.goals] {
            flags.clear();
            flags.resize(size.area(), 0);
        }
        for cell in size.cells() {
            self.update(cell);
            self.goals[cell_index(size, cell)] = self.maze.goals().contains(cell).into();
        }
        // Like the bundled strategies, the mouse also sees the wall behind it at the start.
        let behind = Pose::new(self.pose.cell, self.pose.heading.back());
        self.observe(behind);
        self.observe(self.pose);
        self.is_goal_reached = self.maze.goals().contains(self.pose.cell);
    }

    /// Turns by `quarters` to the right and takes a step, unless there is a wall.
    pub(crate) fn act(&mut self, quarters: u8, rules: EpisodeRules) -> Outcome {
        let heading = Heading::ALL[usize::from((self.pose.heading as u8 + quarters) % 4)];
        self.steps += 1;
        self.pose.heading = heading;
        let mut reward = -1.;
        let next = self.maze.size().neighbour(self.pose.cell, heading);
        if let Some(cell) = next.filter(|_| !self.maze.walls().has(self.pose.cell, heading)) {
            self.pose.cell = cell;
            let is_new = self.observe(self.pose);
            let bonus = self.bonus();
            if !self.is_goal_reached && self.maze.goals().contains(cell) {
                self.is_goal_reached = true;
                reward += bonus;
                self.is_proven = rules.until_proven && PathBounds::new(&self.known).is_proven();
            } else if is_new && self.is_goal_reached && rules.until_proven {
                self.is_proven = PathBounds::new(&self.known).is_proven();
            }
            if self.is_proven {
                reward += bonus;
            }
        }
        let is_terminated = if rules.until_proven { self.is_proven } else { self.is_goal_reached };
        let is_truncated = !is_terminated && self.steps >= rules.max_steps;
        Outcome { reward, is_terminated, is_truncated }
    }

    /// Returns the reward for reaching the goal, and that for a proof: the number of cells.
    fn bonus(&self) -> f64 {
        f64::from(u16::try_from(self.maze.size().area()).unwrap_or(u16::MAX))
    }

    /// Reads the walls around the mouse. Returns true if the mouse was never in this cell before.
    fn observe(&mut self, pose: Pose) -> bool {
        let is_new = !self.known.visited().contains(pose.cell);
        // The walls of a maze never contradict each other.
        let _ = self.known.observe(pose, self.maze.walls().around(pose));
        let size = self.maze.size();
        self.update(pose.cell);
        for heading in Heading::ALL {
            if let Some(cell) = size.neighbour(pose.cell, heading) {
                self.update(cell);
            }
        }
        is_new
    }

    fn update(&mut self, cell: Cell) {
        let present = self.known.walls(Unknown::Open).sides(cell);
        let possible = self.known.walls(Unknown::Closed).sides(cell);
        let index = cell_index(self.maze.size(), cell);
        let visited = if self.known.visited().contains(cell) { VISITED } else { 0 };
        self.walls[index] = visited | flags(present);
        self.openings[index] = flags(Sides::from_bits(!possible.bits()));
    }

    pub(crate) const fn maze(&self) -> &Maze {
        &self.maze
    }

    pub(crate) const fn known(&self) -> &KnownMaze {
        &self.known
    }

    pub(crate) const fn is_goal_reached(&self) -> bool {
        self.is_goal_reached
    }

    pub(crate) fn walls(&self) -> &[u8] {
        &self.walls
    }

    pub(crate) fn openings(&self) -> &[u8] {
        &self.openings
    }

    pub(crate) fn goals(&self) -> &[u8] {
        &self.goals
    }

    /// Returns x, y and the heading (0 to 3 from north clockwise).
    pub(crate) fn pose(&self) -> [i64; 3] {
        [self.pose.cell.x.into(), self.pose.cell.y.into(), self.pose.heading as i64]
    }

    /// Returns, for each action, 1 if there is no wall in that direction, else 0.
    pub(crate) fn action_mask(&self) -> [i8; 4] {
        let Pose { cell, heading } = self.pose;
        let walls = self.maze.walls();
        [heading, heading.right(), heading.back(), heading.left()]
            .map(|heading| i8::from(!walls.has(cell, heading)))
    }
}

/// Returns the index of a cell in an array of the shape (width, height).
fn cell_index(size: MazeSize, cell: Cell) -> usize {
    usize::from(cell.x) * usize::from(size.height()) + usize::from(cell.y)
}

/// Returns the flags of sides: 2 for east, 4 for south, 8 for west, 16 for north.
const fn flags(sides: Sides) -> u8 {
    sides.bits() & 0b1110 | (sides.bits() & 1) << 4
}
