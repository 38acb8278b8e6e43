//! Belief: how likely each wall stands, and where the robot may be, when sensors err.

use mmsim_maze::{Cell, Heading, KnownMaze, MazeSize, Pose, WallState};

use crate::{Action, Survey};

const SIDE: usize = MazeSize::MAX_SIDE as usize;

/// What a robot believes whose sensors err: for each wall how likely the way is open, and a few
/// accounts of where it is, since a wall that it did not expect cuts its move short without a
/// word.
///
/// A reading counts open cells up to the next wall. Each number of cells that may be true has a
/// chance by what is believed of the walls on the way, and one by how the sensors err; each wall is
/// believed anew by Bayes' rule. With sensors that never err all chances are 0 and 1, and this is
/// a [`Survey`].
#[derive(Clone, Debug)]
pub(super) struct Belief {
    accounts: Vec<Account>,
    noise: f64,
}

/// One account of what has happened.
#[derive(Clone, Debug)]
pub(super) struct Account {
    /// What is believed of walls, rounded to known and unknown, and where the robot stands.
    pub(super) survey: Survey,
    /// Whether a step of the first run ended in the goal.
    pub(super) been_in_goal: bool,
    /// Whether this is the second run.
    pub(super) races: bool,
    /// Whether a step of the second run ended in the goal: then this account is mistaken, or over.
    has_arrived: bool,
    /// How likely the way is open: `[y][x]`, to the north and to the east.
    open: Box<[[[f32; 2]; SIDE]; SIDE]>,
    chance: f64,
}

/// A way is known to be open, or closed, where it is that likely.
const SURE: f32 = 0.9;
/// Nothing is so sure that sensors that err could not teach the contrary.
const MAX_CONFIDENCE: f32 = 0.999;
/// Where not all walls are known, a reading is not less likely than this: long corridors are more
/// frequent than walls that know nothing of each other would have them.
const LEAST_NEW: f64 = 0.05;
/// How many accounts are kept.
const ACCOUNTS: usize = 8;
/// Accounts less likely than this, beside the likeliest, are dropped.
const LEAST_CHANCE: f64 = 1e-6;

impl Belief {
    pub(super) fn new(before: KnownMaze, noise: f64) -> Self {
        let account = Account {
            survey: Survey::new(before),
            been_in_goal: false,
            races: false,
            has_arrived: false,
            open: Box::new([[[0.5; 2]; SIDE]; SIDE]),
            chance: 1.,
        };
        Self { accounts: vec![account], noise }
    }

    /// The likeliest account.
    pub(super) fn likeliest(&self) -> &Account {
        &self.accounts[0]
    }

    /// Weighs the accounts by what the sensors tell, and learns from it in each.
    pub(super) fn observe(&mut self, sensors: [u8; 3]) {
        let chance = |account: &Account| {
            let told = account.told(account.survey.pose(), sensors, self.noise);
            // A race that has ended does not go on.
            if account.has_arrived { 0. } else { account.chance * told }
        };
        let chances: Vec<f64> = self.accounts.iter().map(chance).collect();
        if chances.iter().sum::<f64>() > 0. {
            for (account, chance) in self.accounts.iter_mut().zip(chances) {
                account.chance = chance;
            }
        } else {
            self.accounts = self.accounts[0].anywhere(sensors, self.noise);
        }
        self.accounts.sort_by(|a, b| b.chance.total_cmp(&a.chance));
        self.accounts.truncate(ACCOUNTS);
        let most = self.accounts[0].chance;
        self.accounts.retain(|account| account.chance >= most * LEAST_CHANCE);
        for account in &mut self.accounts {
            account.chance /= most;
            account.observe(sensors, self.noise);
        }
    }

    /// Does what the robot does in each account, which splits where a wall may be in the way.
    pub(super) fn go(&mut self, action: Action) {
        let errs = self.noise > 0.;
        self.accounts =
            self.accounts.iter().flat_map(|account| account.after(action, errs)).collect();
        self.accounts.sort_by(|a, b| b.chance.total_cmp(&a.chance));
    }
}

impl Account {
    /// What it knows if all walls that may have been misread are taken as unknown.
    pub(super) fn doubting(&self) -> KnownMaze {
        let mut map = self.survey.map().clone();
        for cell in map.size().cells() {
            for heading in [Heading::North, Heading::East] {
                let may_be_open = self.open(cell, heading) > 2. * (1. - MAX_CONFIDENCE);
                if may_be_open && map.wall(cell, heading) == WallState::Present {
                    map.set_wall(cell, heading, WallState::Unknown);
                }
            }
        }
        map
    }

    /// How likely the way is open.
    fn open(&self, cell: Cell, heading: Heading) -> f32 {
        self.place(cell, heading).map_or(0., |(x, y, side)| self.open[y][x][side])
    }

    fn believe(&mut self, cell: Cell, heading: Heading, open: f32, noise: f64) {
        if let Some((x, y, side)) = self.place(cell, heading) {
            let most = if noise > 0. { MAX_CONFIDENCE } else { 1. };
            let open = open.clamp(1. - most, most);
            self.open[y][x][side] = open;
            let wall = if open >= SURE {
                WallState::Absent
            } else if open <= 1. - SURE {
                WallState::Present
            } else {
                WallState::Unknown
            };
            self.survey.believe(cell, heading, wall);
        }
    }

    fn place(&self, cell: Cell, heading: Heading) -> Option<(usize, usize, usize)> {
        let next = self.survey.map().size().neighbour(cell, heading)?;
        let (of, side) = match heading {
            Heading::North => (cell, 0),
            Heading::East => (cell, 1),
            Heading::South => (next, 0),
            Heading::West => (next, 1),
        };
        Some((of.x.into(), of.y.into(), side))
    }

    /// How likely the sensors tell this in a pose.
    fn told(&self, pose: Pose, sensors: [u8; 3], noise: f64) -> f64 {
        let told = |(heading, told): (Heading, u8)| {
            let chance = self.chances(pose.cell, heading, told, noise).sum::<f64>();
            let mut way = self.way(pose.cell, heading).take(usize::from(told) + 1);
            let is_new = way.any(|here| (1. - SURE..SURE).contains(&self.open(here, heading)));
            if is_new { chance.max(LEAST_NEW) } else { chance }
        };
        around(pose).into_iter().zip(sensors).map(told).product()
    }

    /// For each number of open cells that there may be from here to the next wall, the chance that
    /// it is so and told as it was.
    fn chances(
        &self,
        cell: Cell,
        heading: Heading,
        told: u8,
        noise: f64,
    ) -> impl Iterator<Item = f64> + '_ {
        let mut reached = 1.;
        (0..).zip(self.way(cell, heading)).map(move |(cells, here)| {
            let open = f64::from(self.open(here, heading));
            let chance = reached * (1. - open) * told_as(told, cells, noise);
            reached *= open;
            chance
        })
    }

    /// The cells from here to the edge of the maze.
    fn way(&self, cell: Cell, heading: Heading) -> impl Iterator<Item = Cell> + use<> {
        let size = self.survey.map().size();
        std::iter::successors(Some(cell), move |&cell| size.neighbour(cell, heading))
    }

    /// Learns from what the sensors tell.
    fn observe(&mut self, sensors: [u8; 3], noise: f64) {
        let pose = self.survey.pose();
        self.survey.visit();
        for (heading, told) in around(pose).into_iter().zip(sensors) {
            let chances: Vec<f64> = self.chances(pose.cell, heading, told, noise).collect();
            let all: f64 = chances.iter().sum();
            if all <= 0. {
                continue;
            }
            for (index, here) in self.way(pose.cell, heading).enumerate() {
                let nearer: f64 = chances[..index].iter().sum();
                let further: f64 = chances[index + 1..].iter().sum();
                let open = (nearer * f64::from(self.open(here, heading)) + further) / all;
                // Chances need not be more exact than that.
                #[allow(clippy::cast_possible_truncation)]
                self.believe(here, heading, open as f32, noise);
            }
        }
    }

    /// Accounts of a robot that is lost: what it knows of the maze, and where that fits best what
    /// its sensors tell.
    fn anywhere(&self, sensors: [u8; 3], noise: f64) -> Vec<Self> {
        let poses =
            self.survey.map().size().cells().flat_map(|cell| {
                Heading::ALL.into_iter().map(move |heading| Pose::new(cell, heading))
            });
        let mut chances: Vec<(f64, Pose)> =
            poses.map(|pose| (self.told(pose, sensors, noise), pose)).collect();
        chances.sort_by(|a, b| b.0.total_cmp(&a.0));
        chances.truncate(ACCOUNTS);
        let at = |(chance, pose): (f64, Pose)| {
            let mut account = Self { chance, has_arrived: false, ..self.clone() };
            account.survey.stand(pose);
            account
        };
        let mut accounts: Vec<Self> = chances.into_iter().map(at).collect();
        accounts[0].chance = accounts[0].chance.max(f64::MIN_POSITIVE);
        accounts
    }

    /// What may have become of it after this action.
    fn after(&self, action: Action, errs: bool) -> Vec<Self> {
        let mut accounts = match action {
            Action::Move { rotation, cells } => {
                self.after_move(rotation.turn(self.survey.pose().heading), cells)
            }
            Action::Reset => {
                let mut granted = Self { races: true, ..self.clone() };
                granted.survey.go(action);
                let mut refused = Self { been_in_goal: false, races: false, ..self.clone() };
                // It may have been mistaken about the goal.
                let mistaken = if self.been_in_goal { &mut refused } else { &mut granted };
                mistaken.chance *= 0.01;
                match (errs, self.been_in_goal) {
                    (true, _) => vec![granted, refused],
                    (false, true) => vec![granted],
                    (false, false) => vec![refused],
                }
            }
            Action::GiveUp => vec![self.clone()],
        };
        for account in &mut accounts {
            let is_in_goal = account.survey.is_in_goal();
            account.been_in_goal |= is_in_goal;
            account.has_arrived = is_in_goal && self.races;
        }
        accounts
    }

    fn after_move(&self, nose: Heading, cells: i8) -> Vec<Self> {
        let towards = if cells < 0 { nose.back() } else { nose };
        let mut here = self.clone();
        here.survey.stand(Pose::new(self.survey.pose().cell, nose));
        let mut accounts = Vec::new();
        for _ in 0..cells.unsigned_abs() {
            let cell = here.survey.pose().cell;
            let open = here.open(cell, towards);
            if open < 1. {
                let mut cut = here.clone();
                cut.chance *= f64::from(1. - open);
                cut.believe(cell, towards, 0., 1.);
                accounts.push(cut);
            }
            let Some(next) = cell.neighbour(towards).filter(|_| open > 0.) else { return accounts };
            here.chance *= f64::from(open);
            here.believe(cell, towards, 1., if open < 1. { 1. } else { 0. });
            here.survey.stand(Pose::new(next, nose));
        }
        accounts.push(here);
        accounts
    }
}

/// Where the sensors look.
const fn around(Pose { heading, .. }: Pose) -> [Heading; 3] {
    [heading.left(), heading, heading.right()]
}

/// How likely sensors tell this many cells where so many are open.
fn told_as(told: u8, cells: u8, noise: f64) -> f64 {
    match (told.abs_diff(cells), cells) {
        (0, _) => 1. - noise,
        (1, 0) => noise,
        (1, _) => noise / 2.,
        _ => 0.,
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::CellSet;

    use super::*;

    fn belief(noise: f64) -> Belief {
        Belief::new(KnownMaze::new(MazeSize::CLASSIC, Cell::new(0, 0), CellSet::EMPTY), noise)
    }

    fn wall(belief: &Belief, y: u8) -> WallState {
        belief.likeliest().survey.map().wall(Cell::new(0, y), Heading::North)
    }

    #[test]
    fn sensors_that_never_err_are_believed_at_once() {
        let mut belief = belief(0.);
        belief.observe([0, 2, 0]);
        let mut survey = Survey::new(belief.likeliest().survey.map().clone());
        survey.observe([0, 2, 0]);
        assert_eq!(belief.likeliest().survey, survey);
        belief.go(Action::from_numbers(0, 2));
        assert_eq!(belief.accounts.len(), 1);
        assert_eq!(belief.likeliest().survey.pose().cell, Cell::new(0, 2));
    }

    #[test]
    fn sensors_that_err_are_believed_in_the_long_run() {
        let mut belief = belief(0.3);
        belief.observe([0, 3, 0]);
        assert_eq!(wall(&belief, 2), WallState::Unknown, "once is not enough");
        assert_eq!(wall(&belief, 0), WallState::Absent, "it errs by one cell only");
        for told in [2, 2, 2, 3, 2, 2] {
            belief.observe([0, told, 0]);
        }
        assert_eq!(wall(&belief, 1), WallState::Absent);
        assert_eq!(wall(&belief, 2), WallState::Present);
    }

    #[test]
    fn a_wall_that_was_not_expected_is_learnt_from() {
        let mut belief = belief(0.1);
        belief.observe([0, 1, 5]);
        belief.go(Action::from_numbers(0, 1));
        let cell = |belief: &Belief| belief.likeliest().survey.pose().cell;
        let mut elsewhere = belief.clone();
        elsewhere.observe([0, 0, 1]);
        assert_eq!(cell(&elsewhere), Cell::new(0, 1), "to the right it looks different there");
        // What it sees is what it saw before it moved, but for a wall ahead: it ran into that.
        for _ in 0..3 {
            belief.observe([0, 0, 5]);
        }
        assert_eq!(cell(&belief), Cell::new(0, 0));
        assert_eq!(wall(&belief, 0), WallState::Present);
        assert_eq!(wall(&elsewhere, 0), WallState::Absent);
    }

    #[test]
    fn a_reset_before_the_goal_is_refused() {
        for noise in [0., 0.1] {
            let mut belief = belief(noise);
            for _ in 0..3 {
                belief.observe([0, 5, 0]);
            }
            belief.go(Action::from_numbers(0, 2));
            belief.observe([0, 3, 1]);
            belief.go(Action::Reset);
            belief.observe([0, 3, 1]);
            let account = belief.likeliest();
            assert_eq!(account.survey.pose().cell, Cell::new(0, 2));
            assert!(!account.races);
        }
    }
}
