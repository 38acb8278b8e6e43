//! A mouse's belief at one moment: its pose and two matrices with one byte per cell.

use mmsim_maze::{Cell, CellSet, Heading, KnownMaze, MazeSize, Pose, WallState};

use crate::error::RequestError;
use crate::layout::{self, BufferTooSmall, front_of, state_bytes};
use crate::matrix::{CellWalls, Matrix, Order};
use crate::message::{StateMessage, heading_byte};

/// A mouse's belief at one moment of its search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State<'a> {
    pose: Pose,
    weights: Matrix<'a>,
    walls: Matrix<'a>,
}

impl<'a> State<'a> {
    /// Creates a state. Returns `None` if the sizes of the matrices differ or the mouse is outside
    /// the maze.
    pub fn new(pose: Pose, weights: Matrix<'a>, walls: Matrix<'a>) -> Option<Self> {
        let fits = weights.size == walls.size && weights.size.contains(pose.cell);
        fits.then_some(Self { pose, weights, walls })
    }

    /// Returns the size of the maze.
    pub const fn size(&self) -> MazeSize {
        self.weights.size
    }

    /// Returns the pose of the mouse.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Returns the weights, one number for each cell. The client chooses the meaning of the
    /// weights, such as distances in steps or visit counts. The weight 255 means 255 or more.
    pub const fn weights(&self) -> Matrix<'a> {
        self.weights
    }

    /// Returns the flags of each cell as bytes. See [`cell_walls`](Self::cell_walls).
    pub const fn walls(&self) -> Matrix<'a> {
        self.walls
    }

    /// Returns the flags of one cell, or `None` if the cell is outside the maze.
    pub fn cell_walls(&self, cell: Cell) -> Option<CellWalls> {
        self.walls.at(cell).map(CellWalls)
    }

    /// Returns true if the flags of either adjacent cell report the wall on this side of a cell.
    pub fn has_wall(&self, cell: Cell, heading: Heading) -> bool {
        let is_reported = |cell, side| self.cell_walls(cell).is_some_and(|walls| walls.wall(side));
        let neighbour = cell.neighbour(heading);
        is_reported(cell, heading)
            || neighbour.is_some_and(|neighbour| is_reported(neighbour, heading.back()))
    }

    /// Returns the client's map of the maze.
    ///
    /// A wall is present if the flags of either adjacent cell report it. A wall that no
    /// flag reports is absent if either adjacent cell has been visited, and unknown otherwise.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, CellSet, Heading, MazeSize, State, WallState};
    /// let size = MazeSize::new(3, 1)?;
    /// let message = b"S\x00\x00NC\x02\x01\x00C\x1d\x00\x00";
    /// let state = State::decode(message, size)?;
    /// let map = state.map(Cell::new(0, 0), CellSet::EMPTY);
    /// assert_eq!(map.wall(Cell::new(0, 0), Heading::East), WallState::Absent);
    /// assert_eq!(map.wall(Cell::new(1, 0), Heading::East), WallState::Unknown);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map(&self, start: Cell, goals: CellSet) -> KnownMaze {
        let size = self.size();
        let mut map = KnownMaze::new(size, start, goals);
        for cell in size.cells() {
            let here = self.cell_walls(cell).unwrap_or_default();
            if here.visited() {
                map.visit(cell);
            }
            for heading in [Heading::North, Heading::East] {
                let Some(neighbour) = size.neighbour(cell, heading) else { continue };
                let there = self.cell_walls(neighbour).unwrap_or_default();
                map.set_wall(cell, heading, between(here, there, heading));
            }
        }
        map
    }

    /// Decodes a state message (`S`) for a maze of this size.
    ///
    /// # Errors
    /// Returns an error if the bytes are not a valid state of a maze of this size.
    pub fn decode(message: &'a [u8], size: MazeSize) -> Result<Self, RequestError> {
        let message = StateMessage::new(message, size)?;
        let (pose, weights, walls) = (message.pose()?, message.weights()?, message.walls()?);
        Ok(Self { pose, weights, walls })
    }

    /// Writes the state to the start of `buffer` and returns the number of bytes written.
    ///
    /// # Errors
    /// Returns an error if the buffer is shorter than the state.
    pub fn encode(&self, buffer: &mut [u8]) -> Result<usize, BufferTooSmall> {
        let size = self.weights.size;
        let message = front_of(buffer, state_bytes(size))?;
        put_head(message, self.pose, size, [self.weights.order, self.walls.order]);
        message[layout::weights(size.area())].copy_from_slice(self.weights.bytes);
        message[layout::walls(size.area())].copy_from_slice(self.walls.bytes);
        Ok(message.len())
    }
}

/// Returns the state of the wall on the `heading` side of `here`. The cell `there` is on the other
/// side of the wall.
const fn between(here: CellWalls, there: CellWalls, heading: Heading) -> WallState {
    if here.wall(heading) || there.wall(heading.back()) {
        WallState::Present
    } else if here.visited() || there.visited() {
        WallState::Absent
    } else {
        WallState::Unknown
    }
}

/// A state that is encoded directly from a mouse's map. A function provides the weight of each
/// cell. Both matrices use the same cell order.
///
/// ```
/// use mmsim_protocol::{Cell, Heading, KnownMaze, MapState, MazeSize, Order, Pose, State};
/// let (size, start) = (MazeSize::CLASSIC, Pose::new(Cell::new(0, 0), Heading::North));
/// let map = KnownMaze::new(size, start.cell, size.central_cells());
/// let mut buffer = [0; 518];
/// MapState::new(start, &map, |cell| 100 * u16::from(cell.x), Order::F).encode(&mut buffer)?;
/// let state = State::decode(&buffer, size)?;
/// assert_eq!(state.weights().at(Cell::new(2, 9)), Some(200));
/// assert_eq!(state.weights().at(Cell::new(3, 9)), Some(255));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct MapState<'m, W> {
    pose: Pose,
    map: &'m KnownMaze,
    weight: W,
    order: Order,
}

impl<'m, W: Fn(Cell) -> u16> MapState<'m, W> {
    /// Creates the state of a mouse with this pose and map. A weight above 255 is sent as 255.
    pub const fn new(pose: Pose, map: &'m KnownMaze, weight: W, order: Order) -> Self {
        Self { pose, map, weight, order }
    }

    /// Writes the state to the start of `buffer` and returns the number of bytes written.
    ///
    /// # Errors
    /// Returns an error if the buffer is shorter than the state.
    pub fn encode(&self, buffer: &mut [u8]) -> Result<usize, BufferTooSmall> {
        let Self { pose, map, weight, order } = self;
        let size = map.size();
        let message = front_of(buffer, state_bytes(size))?;
        put_head(message, *pose, size, [*order; 2]);
        let (head, walls) = message.split_at_mut(layout::walls(size.area()).start);
        let weights = &mut head[layout::weights(size.area())];
        // Faster than a `for` loop, because `cells` is a nested iterator.
        size.cells().for_each(|cell| {
            if let Some(index) = order.index(cell, size) {
                weights[index] = u8::try_from(weight(cell)).unwrap_or(u8::MAX);
                walls[index] = CellWalls::known(map, cell).0;
            }
        });
        Ok(state_bytes(size))
    }
}

/// Writes all fields except the two matrices.
fn put_head(message: &mut [u8], pose: Pose, size: MazeSize, [weights, walls]: [Order; 2]) {
    message[layout::LETTER] = b'S';
    message[layout::X] = pose.cell.x;
    message[layout::Y] = pose.cell.y;
    message[layout::HEADING] = heading_byte(pose.heading);
    message[layout::WEIGHTS_ORDER] = weights as u8;
    message[layout::walls_order(size.area())] = walls as u8;
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use mmsim_maze::WallsAround;

    use super::*;
    use crate::layout::MAX_STATE_BYTES;
    use crate::request::Request;

    /// A state in a 2x1 maze: the mouse at (1, 0) faces east, and the weights are 7 and 9.
    const SMALL: [u8; 10] = *b"S\x01\x00EC\x07\x09F\x0d\x1f";

    fn small() -> MazeSize {
        MazeSize::new(2, 1).unwrap()
    }

    #[test]
    fn a_state_is_decoded_and_encoded() {
        let Ok(Request::State(state)) = Request::decode(&SMALL, small()) else { panic!() };
        let pose = Pose::new(Cell::new(1, 0), Heading::East);
        let weights = Matrix::new(Order::C, small(), &[7, 9]).unwrap();
        let walls = Matrix::new(Order::F, small(), &[0x0d, 0x1f]).unwrap();
        assert_eq!(Some(state), State::new(pose, weights, walls));
        assert_eq!((state.size(), state.pose()), (small(), pose));
        assert_eq!((state.weights(), state.walls()), (weights, walls));
        assert_eq!(state.cell_walls(Cell::new(1, 0)), Some(CellWalls(0x1f)));
        assert_eq!(state.cell_walls(Cell::new(2, 0)), None);
        let walls = state.cell_walls(Cell::new(0, 0)).unwrap();
        assert!(walls.visited() && walls.wall(Heading::South) && walls.wall(Heading::West));
        assert!(!walls.wall(Heading::North) && !walls.wall(Heading::East));
        let mut buffer = [0xa5; 12];
        assert_eq!(Request::State(state).encode(&mut buffer), Ok(10));
        assert_eq!(buffer[..10], SMALL);
        assert_eq!(buffer[10..], [0xa5; 2]);
        let too_small = BufferTooSmall { expected: 10, found: 9 };
        assert_eq!(state.encode(&mut buffer[..9]), Err(too_small));
    }

    #[test]
    fn malformed_states_are_errors() {
        let error = |index: usize, byte| {
            let mut message = SMALL;
            message[index] = byte;
            Request::decode(&message, small()).unwrap_err().to_string()
        };
        insta::assert_snapshot!(error(1, 2), @"expected a cell in a maze of 2x1 cells, found (2, 0)");
        insta::assert_snapshot!(error(3, b'X'), @r#"expected N, E, S or W as the heading, found "X""#);
        insta::assert_snapshot!(error(4, b'c'), @r#"expected C or F as the order of the weights, found "c""#);
        insta::assert_snapshot!(error(7, b'Z'), @r#"expected C or F as the order of the walls, found "Z""#);
        let classic = [b'S'; 518];
        let error = Request::decode(&classic, MazeSize::HALF_SIZE).unwrap_err();
        insta::assert_snapshot!(error, @"expected a state of 2054 bytes for a maze of 32x32 cells, found 518 bytes");
        for length in (1..700).filter(|&length| length != 518) {
            let message = [b'S'; 700];
            let error = Request::decode(&message[..length], MazeSize::CLASSIC).unwrap_err();
            let found = RequestError::StateLength { size: MazeSize::CLASSIC, found: length };
            assert_eq!(error, found);
        }
    }

    #[test]
    fn a_map_is_encoded() {
        let pose = Pose::new(Cell::new(0, 0), Heading::East);
        let mut map = KnownMaze::new(small(), pose.cell, small().central_cells());
        map.observe(pose, WallsAround { left: true, front: false, right: true }).unwrap();
        let mut buffer = [0xa5; MAX_STATE_BYTES];
        let weight = |cell: Cell| 254 + 2 * u16::from(cell.x);
        let length = MapState::new(pose, &map, weight, Order::F).encode(&mut buffer).unwrap();
        assert_eq!(&buffer[..length], b"S\x00\x00EF\xfe\xffF\x1d\x16");
        assert!(buffer[length..].iter().all(|&byte| byte == 0xa5));
        let too_small = BufferTooSmall { expected: 10, found: 9 };
        let result = MapState::new(pose, &map, weight, Order::F).encode(&mut buffer[..9]);
        assert_eq!(result, Err(too_small));
    }

    #[test]
    fn the_parts_of_a_state_must_match() {
        let matrix = |size: MazeSize, bytes| Matrix::new(Order::C, size, bytes).unwrap();
        let (wide, high) =
            (matrix(small(), &[1, 2]), matrix(MazeSize::new(1, 2).unwrap(), &[1, 2]));
        let pose = |x| Pose::new(Cell::new(x, 0), Heading::North);
        assert!(State::new(pose(1), wide, wide).is_some());
        assert!(State::new(pose(1), wide, high).is_none());
        assert!(State::new(pose(2), wide, wide).is_none());
    }

    #[test]
    fn a_report_of_either_cell_decides_about_a_wall() {
        use WallState::{Absent, Present, Unknown};
        let (nothing, visited) = (CellWalls(0), CellWalls(1));
        let (west, east) = (CellWalls(8), CellWalls(2));
        for (here, there, expected) in [
            (nothing, nothing, Unknown),
            (visited, nothing, Absent),
            (nothing, visited, Absent),
            (east, nothing, Present),
            (nothing, west, Present),
            (east, visited, Present),
            (visited, west, Present),
            (west, nothing, Unknown),
            (nothing, east, Unknown),
        ] {
            let cells = [b'S', 0, 0, b'N', b'C', 0, 0, b'C', here.0, there.0];
            let size = MazeSize::new(2, 1).unwrap();
            let map = State::decode(&cells, size).unwrap().map(Cell::new(0, 0), CellSet::EMPTY);
            assert_eq!(map.wall(Cell::new(0, 0), Heading::East), expected, "{here:?}, {there:?}");
            let is_visited = [here, there].map(|flags| flags == visited);
            let cells = [0, 1].map(|x| Cell::new(x, 0));
            assert_eq!(cells.map(|cell| map.visited().contains(cell)), is_visited);
        }
        let (south, north) = (CellWalls(4), CellWalls(16));
        for (here, there, expected) in
            [(north, nothing, Present), (nothing, south, Present), (south, north, Unknown)]
        {
            let cells = [b'S', 0, 0, b'N', b'C', 0, 0, b'C', here.0, there.0];
            let size = MazeSize::new(1, 2).unwrap();
            let map = State::decode(&cells, size).unwrap().map(Cell::new(0, 0), CellSet::EMPTY);
            assert_eq!(map.wall(Cell::new(0, 0), Heading::North), expected, "{here:?}, {there:?}");
        }
    }

    fn any_order() -> impl Strategy<Value = Order> {
        prop_oneof![Just(Order::C), Just(Order::F)]
    }

    proptest! {
        #[test]
        fn a_state_survives_a_round_trip(
            (width, height) in (1usize..=32, 1usize..=32),
            (x, y, heading) in (any::<u8>(), any::<u8>(), 0usize..4),
            orders in (any_order(), any_order()),
            bytes in prop::collection::vec(any::<u8>(), 2 * MazeSize::MAX_AREA),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let cell = Cell::new(x % size.width(), y % size.height());
            let (weights, walls) = bytes[..2 * size.area()].split_at(size.area());
            let pose = Pose::new(cell, Heading::ALL[heading]);
            let weights_matrix = Matrix::new(orders.0, size, weights).unwrap();
            let walls_matrix = Matrix::new(orders.1, size, walls).unwrap();
            let state = State::new(pose, weights_matrix, walls_matrix).unwrap();
            let mut buffer = [0xa5; MAX_STATE_BYTES];
            let length = Request::State(state).encode(&mut buffer).unwrap();
            prop_assert_eq!(length, state_bytes(size));
            prop_assert_eq!(Request::decode(&buffer[..length], size), Ok(Request::State(state)));
            for cell in size.cells() {
                let f = usize::from(cell.x) * height + usize::from(cell.y);
                let index = if orders.0 == Order::C { size.index(cell).unwrap() } else { f };
                prop_assert_eq!(state.weights.at(cell), Some(weights[index]));
            }
        }

        /// In this test, the mouse knows all four walls of each visited cell, because a state
        /// cannot represent an unknown wall of a visited cell.
        #[test]
        fn a_map_survives_a_round_trip(
            (width, height) in (1usize..=32, 1usize..=32),
            readings in prop::collection::vec((any::<u8>(), any::<u8>(), any::<[bool; 4]>()), 0..60),
            order in any_order(),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let (start, goals) = (Pose::new(Cell::new(0, 0), Heading::North), size.central_cells());
            let mut map = KnownMaze::new(size, start.cell, goals);
            for (x, y, walls) in readings {
                let cell = Cell::new(x % size.width(), y % size.height());
                for (heading, wall) in Heading::ALL.into_iter().zip(walls) {
                    if map.wall(cell, heading) == WallState::Unknown {
                        let wall = if wall { WallState::Present } else { WallState::Absent };
                        map.set_wall(cell, heading, wall);
                    }
                }
                map.visit(cell);
            }
            let mut buffer = [0; MAX_STATE_BYTES];
            let length = MapState::new(start, &map, |_| 0, order).encode(&mut buffer).unwrap();
            let state = State::decode(&buffer[..length], size).unwrap();
            prop_assert_eq!(state.map(start.cell, goals), map);
        }
    }
}
