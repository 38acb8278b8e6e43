//! The reply to `info`: a description of the maze.

use alloc::string::String;
use alloc::vec::Vec;

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose};

use crate::request::PROTOCOL_VERSION;

/// A description of the maze that a simulator serves, without its walls.
///
/// ```
/// let json = r#"{"maze":"small","width":2,"height":1,"start":[0,0],"heading":"N",
///                "goals":[[1,0]],"states":7,"protocol":1}"#;
/// let info: mmsim_protocol::Info = serde_json::from_str(json)?;
/// assert_eq!(info.goal_cells().len(), 1);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Info {
    /// The name of the maze.
    pub maze: String,
    /// The number of cells from west to east.
    pub width: u8,
    /// The number of cells from south to north.
    pub height: u8,
    /// The coordinates x and y of the start cell.
    pub start: [u8; 2],
    /// The letter of the start heading. Simulators always send `N`.
    pub heading: char,
    /// The coordinates x and y of each goal cell.
    pub goals: Vec<[u8; 2]>,
    /// The number of states in the history.
    pub states: usize,
    /// The version of the protocol.
    pub protocol: u32,
    /// The protocol extensions that the simulator supports, such as [`ANNOTATIONS`].
    #[serde(default)]
    pub extensions: Vec<String>,
}

/// The name of the extension for [`Annotations`](crate::Annotations).
pub const ANNOTATIONS: &str = "annotations";

impl Info {
    /// Creates the description of a maze.
    pub fn new(name: &str, size: MazeSize, start: Pose, goals: &CellSet, states: usize) -> Self {
        Self {
            maze: name.into(),
            width: size.width(),
            height: size.height(),
            start: [start.cell.x, start.cell.y],
            heading: start.heading.letter(),
            goals: goals.iter().map(|cell| [cell.x, cell.y]).collect(),
            states,
            protocol: PROTOCOL_VERSION,
            extensions: alloc::vec![ANNOTATIONS.into()],
        }
    }

    /// Returns the size of the maze, or `None` if the width or the height is invalid.
    pub fn size(&self) -> Option<MazeSize> {
        MazeSize::new(self.width.into(), self.height.into()).ok()
    }

    /// Returns true if the simulator accepts [`Annotations`](crate::Annotations).
    pub fn has_annotations(&self) -> bool {
        self.extensions.iter().any(|extension| extension == ANNOTATIONS)
    }

    /// Returns the start pose, or `None` if the heading is invalid.
    pub fn start_pose(&self) -> Option<Pose> {
        let heading = Heading::from_letter(self.heading)?;
        Some(Pose::new(Cell::new(self.start[0], self.start[1]), heading))
    }

    /// Returns the goal cells.
    pub fn goal_cells(&self) -> CellSet {
        self.goals.iter().map(|&[x, y]| Cell::new(x, y)).collect()
    }

    /// Returns the map of a mouse that has not sensed any walls yet, or `None` if the size of the
    /// maze is invalid.
    pub fn known_maze(&self) -> Option<KnownMaze> {
        let [x, y] = self.start;
        Some(KnownMaze::new(self.size()?, Cell::new(x, y), self.goal_cells()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn info_is_the_documented_json() {
        let size = MazeSize::CLASSIC;
        let start = Pose::new(Cell::new(0, 0), Heading::North);
        let info = Info::new("a \"maze\"", size, start, &size.central_cells(), 123);
        let json = serde_json::to_string(&info).unwrap();
        assert_eq!(
            json,
            r#"{"maze":"a \"maze\"","width":16,"height":16,"start":[0,0],"heading":"N","#
                .to_owned()
                + r#""goals":[[7,7],[8,7],[7,8],[8,8]],"states":123,"protocol":1,"#
                + r#""extensions":["annotations"]}"#
        );
        assert_eq!(serde_json::from_str::<Info>(&json).unwrap(), info);
        assert!(info.has_annotations());
        let older = json.replace(r#","extensions":["annotations"]"#, "");
        assert!(!serde_json::from_str::<Info>(&older).unwrap().has_annotations());
        assert_eq!(info.size(), Some(size));
        assert_eq!(info.start_pose(), Some(start));
        assert_eq!(info.goal_cells(), size.central_cells());
        assert_eq!(info.known_maze(), Some(KnownMaze::new(size, start.cell, size.central_cells())));
    }

    #[test]
    fn each_field_has_its_own_value() {
        let (size, cell) = (MazeSize::new(5, 3).unwrap(), Cell::new(4, 1));
        let start = Pose::new(cell, Heading::West);
        let goals = [Cell::new(3, 2)].into_iter().collect();
        let info = Info::new("wide", size, start, &goals, 7);
        assert_eq!((info.width, info.height, info.start, info.heading), (5, 3, [4, 1], 'W'));
        assert_eq!((&*info.goals, info.states, info.protocol), (&[[3, 2]][..], 7, 1));
        assert_eq!((info.size(), info.start_pose()), (Some(size), Some(start)));
        assert_eq!(info.goal_cells(), goals);
        assert_eq!(info.known_maze(), Some(KnownMaze::new(size, cell, goals)));
    }

    #[test]
    fn invalid_descriptions_have_no_size_or_start() {
        let size = MazeSize::CLASSIC;
        let start = Pose::new(Cell::new(0, 0), Heading::North);
        let info = Info::new("", size, start, &CellSet::EMPTY, 0);
        for (width, height) in [(0, 16), (16, 0), (33, 16), (16, 33)] {
            let invalid = Info { width, height, ..info.clone() };
            assert_eq!((invalid.size(), invalid.known_maze()), (None, None));
            assert_eq!(invalid.start_pose(), Some(start));
        }
        let invalid = Info { heading: 'n', ..info };
        assert_eq!((invalid.size(), invalid.start_pose()), (Some(size), None));
    }
}
