//! Property tests that use random mazes to compare the mouse with an independent model of the mms
//! rules.

use mmsim_maze::{Cell, Heading, MazeSize, Point, WallState, Walls};
use mmsim_mms::{Command, GeneralFormat, ScoreRules, SimulatedMouse, Stat};
use proptest::prelude::*;

/// The east and north components of half a step in each direction, clockwise from north.
const STEPS: [(i32, i32); 8] =
    [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// Returns true if a wall or post blocks a half step from this position in this direction.
fn is_blocked(walls: &Walls, (x, y): (i32, i32), eighths: usize) -> bool {
    let (east, north) = STEPS[eighths];
    let has_wall = |x: i32, y: i32, heading| {
        let (Ok(x), Ok(y)) = (u8::try_from(x), u8::try_from(y)) else { return true };
        walls.has(Cell::new(x, y), heading)
    };
    let is_diagonal = east != 0 && north != 0;
    match (x % 2 == 1, y % 2 == 1) {
        (true, true) if is_diagonal => true,
        (true, true) => has_wall(x / 2, y / 2, Heading::ALL[eighths / 2]),
        (false, true) if east == 0 => true,
        (true, false) if north == 0 => true,
        (false, true) | (true, false) if !is_diagonal => false,
        (false, true) => {
            let side = if north > 0 { Heading::North } else { Heading::South };
            has_wall(if east > 0 { x / 2 } else { x / 2 - 1 }, y / 2, side)
        }
        (true, false) => {
            let side = if east > 0 { Heading::East } else { Heading::West };
            has_wall(x / 2, if north > 0 { y / 2 } else { y / 2 - 1 }, side)
        }
        (false, false) => unreachable!("the mouse is on a post"),
    }
}

/// Returns the number of half steps that the mouse can move ahead, at most `limit`.
fn free_half_steps(walls: &Walls, mut at: (i32, i32), eighths: usize, limit: u64) -> u64 {
    for half_steps in 0..limit {
        if is_blocked(walls, at, eighths) {
            return half_steps;
        }
        at = (at.0 + STEPS[eighths].0, at.1 + STEPS[eighths].1);
    }
    limit
}

fn mazes() -> impl Strategy<Value = Walls> {
    let rows = || prop::array::uniform32(any::<u32>());
    // Use a quarter or an eighth of the walls. With more walls, the mouse could hardly move.
    (1usize..=6, 1usize..=6, rows(), rows(), rows(), rows(), any::<bool>()).prop_map(
        |(width, height, north, east, mask, sparse_mask, is_sparse)| {
            let size = MazeSize::new(width, height).unwrap();
            let thin_out = |rows: [u32; 32]| {
                std::array::from_fn(|row| {
                    let sparse_mask = if is_sparse { sparse_mask[row] } else { u32::MAX };
                    rows[row] & mask[row] & sparse_mask
                })
            };
            Walls::from_rows(size, thin_out(north), thin_out(east))
        },
    )
}

fn commands() -> impl Strategy<Value = Vec<(String, u64)>> {
    const NAMES: [&str; 15] = [
        "wallFront",
        "wallFrontRight",
        "wallRight",
        "wallBackRight",
        "wallBack",
        "wallBackLeft",
        "wallLeft",
        "wallFrontLeft",
        "moveForward",
        "moveForwardHalf",
        "turnRight",
        "turnLeft",
        "turnRight45",
        "turnLeft45",
        "moveForwardHalf",
    ];
    let line = (prop::sample::select(&NAMES[..]), prop_oneof![1u64..5, Just(1 << 40)]);
    prop::collection::vec(line.prop_map(|(name, number)| (name.to_string(), number)), 0..80)
}

/// The statistics of mms 1.2, counted in the way mms counts them: with single precision, on each
/// command, and read back from their texts.
#[derive(Default)]
struct NaiveStats {
    /// The distance, the effective distance and the turns.
    total: [f32; 3],
    current: [f32; 3],
    best: Option<[f32; 3]>,
    has_started: bool,
    penalty: f32,
}

impl NaiveStats {
    fn move_forward(&mut self, half_steps: u64, is_at_start: bool) {
        if is_at_start {
            self.current = [0., self.penalty, 0.];
            self.total[1] += self.penalty;
            self.penalty = 0.;
            self.has_started = true;
        }
        #[expect(clippy::cast_precision_loss, reason = "as in mms")]
        let distance = half_steps as f32;
        let effective = if distance > 2. { distance / 2. + 1. } else { distance };
        self.add([distance, effective, 0.]);
    }

    fn add(&mut self, more: [f32; 3]) {
        for (index, more) in more.into_iter().enumerate() {
            self.total[index] += more;
            if self.has_started {
                self.current[index] += more;
            }
        }
    }

    /// Called after each movement and each turn.
    fn arrive(&mut self, is_at_goal: bool, is_at_start: bool) {
        if is_at_goal {
            let cost = |stats: [f32; 3]| stats[1] + stats[2];
            if self.best.is_none_or(|best| cost(self.current) < cost(best)) {
                self.best = Some(self.current);
            }
        }
        if is_at_goal || is_at_start {
            self.has_started = false;
        }
    }

    fn reset(&mut self) {
        self.penalty = 15.;
        self.has_started = false;
    }

    /// Returns the replies to `getStat` in the order of [`Stat::ALL`].
    fn replies(&self) -> [String; 10] {
        let text = |number: f32| GeneralFormat(number.into()).to_string();
        let integer = |number: f32| text(number).parse().unwrap_or(-1).to_string();
        let best = |index: usize, format: &dyn Fn(f32) -> String| {
            self.best.map_or("-1".into(), |best| format(best[index]))
        };
        #[expect(clippy::cast_possible_truncation, reason = "as in mms")]
        let score = self.best.map_or(2000., |best| {
            (f64::from(best[1] + best[2]) + 0.1 * f64::from(self.total[1] + self.total[2])) as f32
        });
        [
            integer(self.total[0]),
            integer(self.total[2]),
            best(0, &integer),
            best(2, &integer),
            integer(self.current[0]),
            integer(self.current[2]),
            text(self.total[1]),
            best(1, &text),
            text(self.current[1]),
            text(score),
        ]
    }
}

/// Commands that move the mouse, with small and with large distances. mms reads a larger number
/// than 2,147,483,647 as 0.
fn movements() -> impl Strategy<Value = Vec<(&'static str, u64)>> {
    const NAMES: [&str; 9] = [
        "moveForward",
        "moveForward",
        "moveForwardHalf",
        "turnRight",
        "turnLeft",
        "turnRight45",
        "turnLeft45",
        "turnRight",
        "ackReset",
    ];
    let numbers = prop_oneof![9 => 0u64..5, 2 => 5u64..200, 1 => Just(300_000)];
    prop::collection::vec((prop::sample::select(&NAMES[..]), numbers), 0..80)
}

proptest! {
    #[test]
    fn statistics_equal_those_of_mms(walls in mazes(), commands in movements()) {
        let size = walls.size();
        let mut mouse = SimulatedMouse::new(size, Cell::new(0, 0), size.central_cells());
        let (mut at, mut eighths, mut naive) = ((1, 1), 0, NaiveStats::default());
        let cell = |(x, y): (i32, i32)| (x / 2, y / 2);
        let goals: Vec<_> = size.central_cells().iter().map(|cell| (cell.x.into(), cell.y.into())).collect();
        for (name, number) in commands {
            let line = if name.starts_with("move") { format!("{name} {number}") } else { name.into() };
            let command = Command::parse(line.as_bytes(), size).unwrap();
            let Ok(_) = mouse.execute(command, &mut walls.clone());
            if name == "ackReset" {
                (at, eighths) = ((1, 1), 0);
                naive.reset();
            } else if let Some(turn) = name.strip_prefix("turn") {
                let turn = match turn { "Right" => 2, "Right45" => 1, "Left" => 6, _ => 7 };
                eighths = (eighths + turn) % 8;
                naive.add([0., 0., 1.]);
                naive.arrive(goals.contains(&cell(at)), cell(at) == (0, 0));
            } else {
                let requested = if name == "moveForward" { 2 * number } else { number };
                let moved = free_half_steps(&walls, at, eighths, requested);
                if moved > 0 {
                    naive.move_forward(requested, cell(at) == (0, 0));
                    let steps = i32::try_from(moved).unwrap();
                    at = (at.0 + STEPS[eighths].0 * steps, at.1 + STEPS[eighths].1 * steps);
                    naive.arrive(goals.contains(&cell(at)), cell(at) == (0, 0));
                }
            }
            let replies = Stat::ALL.map(|stat| mouse.scores().stat(stat).to_string());
            prop_assert_eq!(replies, naive.replies(), "{}", line);
        }
    }

    #[test]
    fn the_mouse_follows_the_rules(walls in mazes(), commands in commands()) {
        let size = walls.size();
        let mut mouse = SimulatedMouse::new(size, Cell::new(0, 0), size.central_cells());
        let (mut at, mut eighths, mut half_steps) = ((1, 1), 0, 0);
        for (name, number) in commands {
            let is_turn = name.starts_with("turn");
            let line = if is_turn { name.clone() } else { format!("{name} {number}") };
            let command = Command::parse(line.as_bytes(), size).unwrap();
            let Ok(response) = mouse.execute(command, &mut walls.clone());
            let side = ["Front", "FrontRight", "Right", "BackRight", "Back", "BackLeft", "Left", "FrontLeft"]
                .iter()
                .position(|side| name.strip_prefix("wall") == Some(side));
            let expected = if let Some(side) = side {
                (free_half_steps(&walls, at, (eighths + side) % 8, number) < number).to_string()
            } else if is_turn {
                let turn = match &name[4..] { "Right" => 2, "Right45" => 1, "Left" => 6, _ => 7 };
                eighths = (eighths + turn) % 8;
                "ack".into()
            } else {
                let requested = if name == "moveForward" { 2 * number } else { number };
                let moved = free_half_steps(&walls, at, eighths, requested);
                half_steps += moved;
                let steps = i32::try_from(moved).unwrap();
                at = (at.0 + STEPS[eighths].0 * steps, at.1 + STEPS[eighths].1 * steps);
                if moved == requested { "ack".into() } else { "crash".into() }
            };
            prop_assert_eq!(response.map(|response| response.to_string()), Some(expected), "{}", line);
            let point = Point { i: u8::try_from(at.0).unwrap(), j: u8::try_from(at.1).unwrap() };
            prop_assert_eq!(mouse.point(), point, "{}", line);
            prop_assert!(size.contains(mouse.pose().cell));
        }
        #[expect(clippy::cast_precision_loss, reason = "the distances are small")]
        let distance = half_steps as f64 / 2.;
        prop_assert!((mouse.scores_by(ScoreRules::Cells).total().distance() - distance).abs() < 1e-9);
        // The mouse has marked no walls, so its map is correct.
        for cell in size.cells() {
            for heading in Heading::ALL {
                match mouse.map().wall(cell, heading) {
                    WallState::Present => prop_assert!(walls.has(cell, heading)),
                    WallState::Absent => prop_assert!(!walls.has(cell, heading)),
                    WallState::Unknown => {}
                }
            }
        }
    }
}
