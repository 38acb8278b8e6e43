//! What holds for all mazes and all commands: the mouse goes by the rules of mms, told case by case.

use mmsim_maze::{Cell, Heading, MazeSize, Walls};
use mmsim_mms::{Command, GridPoint, Mouse};
use proptest::prelude::*;

/// East and north of each eighth of a turn, clockwise from north.
const STEPS: [(i32, i32); 8] =
    [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// Whether half a step is blocked, by where the mouse stands and where it looks.
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
        (false, false) => unreachable!("a mouse on a post"),
    }
}

/// How far the way is clear, in half steps, at most so far.
fn clear(walls: &Walls, mut at: (i32, i32), eighths: usize, most: u64) -> u64 {
    for gone in 0..most {
        if is_blocked(walls, at, eighths) {
            return gone;
        }
        at = (at.0 + STEPS[eighths].0, at.1 + STEPS[eighths].1);
    }
    most
}

fn mazes() -> impl Strategy<Value = Walls> {
    let rows = || prop::array::uniform32(any::<u32>());
    // Half of the walls, a quarter or an eighth, since a mouse that cannot move shows nothing.
    (1usize..=6, 1usize..=6, rows(), rows(), rows(), rows(), any::<bool>()).prop_map(
        |(width, height, north, east, fewer, less, is_open)| {
            let size = MazeSize::new(width, height).unwrap();
            let some = |rows: [u32; 32]| {
                let mut index = 0;
                rows.map(|row| {
                    index += 1;
                    row & fewer[index - 1] & if is_open { less[index - 1] } else { u32::MAX }
                })
            };
            Walls::from_rows(size, some(north), some(east))
        },
    )
}

fn lines() -> impl Strategy<Value = Vec<(String, u64)>> {
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

proptest! {
    #[test]
    fn the_mouse_goes_by_the_rules(walls in mazes(), lines in lines()) {
        let size = walls.size();
        let mut mouse = Mouse::new(size, Cell::new(0, 0), size.central_cells());
        let (mut at, mut eighths, mut half_steps) = ((1, 1), 0, 0);
        for (name, number) in lines {
            let turns = name.starts_with("turn");
            let line = if turns { name.clone() } else { format!("{name} {number}") };
            let command = Command::parse(line.as_bytes(), size).unwrap();
            let Ok(reply) = mouse.obey(command, &mut walls.clone());
            let side = ["Front", "FrontRight", "Right", "BackRight", "Back", "BackLeft", "Left", "FrontLeft"]
                .iter()
                .position(|side| name.strip_prefix("wall") == Some(side));
            let expected = if let Some(side) = side {
                (clear(&walls, at, (eighths + side) % 8, number) < number).to_string()
            } else if turns {
                let by = match &name[4..] { "Right" => 2, "Right45" => 1, "Left" => 6, _ => 7 };
                eighths = (eighths + by) % 8;
                "ack".into()
            } else {
                let most = if name == "moveForward" { 2 * number } else { number };
                let gone = clear(&walls, at, eighths, most);
                half_steps += gone;
                let gone_far = i32::try_from(gone).unwrap();
                at = (at.0 + STEPS[eighths].0 * gone_far, at.1 + STEPS[eighths].1 * gone_far);
                if gone == most { "ack".into() } else { "crash".into() }
            };
            prop_assert_eq!(reply.map(|reply| reply.to_string()), Some(expected), "{}", line);
            let point = GridPoint { x: u8::try_from(at.0).unwrap(), y: u8::try_from(at.1).unwrap() };
            prop_assert_eq!(mouse.point(), point, "{}", line);
            prop_assert!(size.contains(mouse.pose().cell));
        }
        #[expect(clippy::cast_precision_loss, reason = "no mouse of these goes that far")]
        let distance = half_steps as f64 / 2.;
        prop_assert!((mouse.scores().total().distance() - distance).abs() < 1e-9);
        // What it believes is true: it has marked nothing.
        for cell in size.cells() {
            for heading in Heading::ALL {
                match mouse.map().wall(cell, heading) {
                    mmsim_maze::WallState::Present => prop_assert!(walls.has(cell, heading)),
                    mmsim_maze::WallState::Absent => prop_assert!(!walls.has(cell, heading)),
                    mmsim_maze::WallState::Unknown => {}
                }
            }
        }
    }
}
