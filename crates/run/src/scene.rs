//! The maze and the pose of the mouse as messages for the 3D view of Foxglove and Lichtblick.
//!
//! Lengths are in cells. The centre of cell (x, y) is at the position (x, y, 0), so north is the
//! direction of increasing y.

use std::f64::consts::FRAC_1_SQRT_2;

use mmsim_maze::{Cell, Heading, Maze, Pose, Walls};
use serde::Serialize;
use serde_json::{Value, json};

/// The names of the message types, which viewers recognize, and their JSON schemas. The schemas
/// contain only the properties that mmsim writes.
pub(crate) const POSE_SCHEMA: [&str; 2] =
    ["foxglove.PoseInFrame", include_str!("../schemas/pose_in_frame.json")];
pub(crate) const SCENE_SCHEMA: [&str; 2] =
    ["foxglove.SceneUpdate", include_str!("../schemas/scene_update.json")];

/// The coordinate frame of all positions.
const FRAME: &str = "maze";

/// The number of nanoseconds in a second.
const NANOSECONDS: u64 = 1_000_000_000;

/// The number of a line primitive that consists of separate lines, each with two points.
const LINE_LIST: u8 = 2;

/// The thickness of a wall in cells.
const WALL_THICKNESS: f64 = 0.08;

/// The message for the pose of the mouse. The field names are JSON keys.
#[derive(Serialize)]
pub(crate) struct PoseMessage {
    timestamp: Timestamp,
    frame_id: &'static str,
    pose: PoseInFrame,
}

#[derive(Serialize)]
struct Timestamp {
    sec: u64,
    nsec: u64,
}

#[derive(Serialize)]
struct PoseInFrame {
    position: Position,
    orientation: Quaternion,
}

#[derive(Serialize)]
struct Position {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Serialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl PoseMessage {
    /// Creates the message about a mouse with this pose at `time`, in nanoseconds since 1970 (UTC).
    pub(crate) fn new(Pose { cell, heading }: Pose, time: u64) -> Self {
        // An arrow points to the east, and is rotated counterclockwise.
        let (z, w) = match heading {
            Heading::East => (0., 1.),
            Heading::North => (FRAC_1_SQRT_2, FRAC_1_SQRT_2),
            Heading::West => (1., 0.),
            Heading::South => (-FRAC_1_SQRT_2, FRAC_1_SQRT_2),
        };
        let pose = PoseInFrame {
            position: Position { x: cell.x.into(), y: cell.y.into(), z: 0. },
            orientation: Quaternion { x: 0., y: 0., z, w },
        };
        Self { timestamp: Timestamp::new(time), frame_id: FRAME, pose }
    }
}

impl Timestamp {
    const fn new(time: u64) -> Self {
        Self { sec: time / NANOSECONDS, nsec: time % NANOSECONDS }
    }
}

/// Returns the message that draws the walls and the goal cells of a maze.
pub(crate) fn maze_message(maze: &Maze, time: u64) -> Value {
    let walls: Vec<Value> =
        wall_lines(maze.walls()).into_iter().flatten().map(|[x, y]| point(x, y)).collect();
    let goals: Vec<Value> = maze.goals().iter().map(goal_cube).collect();
    let identity =
        json!({"position": point(0., 0.), "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}});
    json!({
        "deletions": [],
        "entities": [{
            "timestamp": Timestamp::new(time),
            "frame_id": FRAME,
            "id": "maze",
            "lifetime": {"sec": 0, "nsec": 0},
            "frame_locked": false,
            "metadata": [],
            "arrows": [],
            "cubes": goals,
            "spheres": [],
            "cylinders": [],
            "lines": [{
                "type": LINE_LIST,
                "pose": identity,
                "thickness": WALL_THICKNESS,
                "scale_invariant": false,
                "points": walls,
                "color": {"r": 0.8, "g": 0.1, "b": 0.1, "a": 1},
                "colors": [],
                "indices": [],
            }],
            "triangles": [],
            "texts": [],
            "models": [],
        }],
    })
}

/// Returns a thin plate that covers a goal cell.
fn goal_cube(cell: Cell) -> Value {
    json!({
        "pose": {
            "position": {"x": cell.x, "y": cell.y, "z": -0.05},
            "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
        },
        "size": {"x": 1, "y": 1, "z": 0.01},
        "color": {"r": 0.2, "g": 0.7, "b": 0.3, "a": 0.5},
    })
}

/// Returns the two ends of each wall. Walls in a row are one line.
fn wall_lines(walls: &Walls) -> Vec<[[f64; 2]; 2]> {
    let (width, height) = (walls.size().width(), walls.size().height());
    let row = |y| walls.row_runs(y).map(move |run| [[run.start, y], [run.end, y]]);
    let column = |x| walls.column_runs(x).map(move |run| [[x, run.start], [x, run.end]]);
    let lines = (0..=height).flat_map(row).chain((0..=width).flat_map(column));
    // Post (x, y) is the south-west corner of cell (x, y).
    let corner = |post: u8| f64::from(post) - 0.5;
    lines.map(|ends| ends.map(|post| post.map(corner))).collect()
}

fn point(x: f64, y: f64) -> Value {
    json!({"x": x, "y": y, "z": 0})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_in_a_row_are_one_line() {
        let maze: Maze =
            "o---o---o---o\n|     G |   |\no---o   o   o\n| S         |\no---o---o---o\n"
                .parse()
                .unwrap();
        let expected = [
            [[-0.5, -0.5], [2.5, -0.5]],
            [[-0.5, 0.5], [0.5, 0.5]],
            [[-0.5, 1.5], [2.5, 1.5]],
            [[-0.5, -0.5], [-0.5, 1.5]],
            [[1.5, 0.5], [1.5, 1.5]],
            [[2.5, -0.5], [2.5, 1.5]],
        ];
        assert_eq!(wall_lines(maze.walls()), expected);
    }
}
