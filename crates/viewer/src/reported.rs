//! The map that a client reports.

use mmsim_maze::{Heading, KnownMaze, WallState};
use mmsim_protocol::State;
use mmsim_recording::Context;

/// Returns the map that a client reports with a state. A client that marks a cell as visited before
/// it reads the walls does not report that they are absent, unless it declares so.
pub fn reported_maze(context: &Context, state: &State<'_>, unexplored: &KnownMaze) -> KnownMaze {
    let mut map = context.claimed_maze(state, unexplored);
    let Some(read) = context.walls_read() else { return map };
    for cell in map.size().cells() {
        for heading in [Heading::North, Heading::East] {
            let is_reported =
                read.has(cell, heading) || context.notes().declared_wall(cell, heading).is_some();
            if map.wall(cell, heading) == WallState::Absent && !is_reported {
                map.set_wall(cell, heading, WallState::Unknown);
            }
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, MazeSize};
    use mmsim_protocol::{Annotations, state_bytes};
    use mmsim_recording::{Block, History, Readings, Update, UpdateTracker};

    use super::*;

    #[test]
    fn absent_walls_are_read_or_declared() {
        let size = MazeSize::new(3, 1).unwrap();
        let unexplored = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
        // The cells (0, 0) and (2, 0) are visited and have no walls.
        let mut message = b"S\0\0NC\0\0\0C\x01\0\x01".to_vec();
        message.resize(state_bytes(size), 0);
        let east = |readings, annotations: &[u8]| {
            let mut tracker = UpdateTracker::default();
            if !annotations.is_empty() {
                tracker.annotate(Annotations::decode(annotations, size).unwrap()).unwrap();
            }
            let mut history = History::new(size);
            let update = Update { readings, ..tracker.update() };
            history.push_with_update(update, &message).unwrap();
            let states = history.block(0).and_then(Block::unpack).unwrap();
            let state = State::decode(states.get(0).unwrap(), size).unwrap();
            let map = reported_maze(&states.context(0).unwrap(), &state, &unexplored);
            [0, 1].map(|x| map.wall(Cell::new(x, 0), Heading::East))
        };
        let [absent, unknown] = [WallState::Absent, WallState::Unknown];
        assert_eq!(east(Readings::AtPose, b""), [absent, unknown], "the walls around the mouse");
        assert_eq!(east(Readings::Poses(&[]), b""), [unknown; 2]);
        assert_eq!(east(Readings::Untracked, b""), [absent; 2]);
        assert_eq!(east(Readings::Poses(&[]), b"AD\x01\x00E0"), [unknown, absent]);
    }
}
