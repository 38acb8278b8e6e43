//! What a mouse believes at one moment: its pose and two matrices, a byte a cell.

use crate::request::{decode_pose, heading_byte};
use crate::{
    BufferTooSmall, Cell, Heading, KnownMaze, MazeSize, Pose, RequestError, Unknown, front_of,
};

/// Where everything stands in a state of A cells: `S` x y heading order weights order walls.
pub(crate) mod field {
    use core::ops::Range;

    pub(crate) const LETTER: usize = 0;
    pub(crate) const X: usize = 1;
    pub(crate) const Y: usize = 2;
    pub(crate) const HEADING: usize = 3;
    pub(crate) const WEIGHTS_ORDER: usize = 4;
    pub(crate) const WEIGHTS: usize = 5;

    pub(crate) const fn weights(area: usize) -> Range<usize> {
        WEIGHTS..WEIGHTS + area
    }

    pub(crate) const fn walls_order(area: usize) -> usize {
        weights(area).end
    }

    pub(crate) const fn walls(area: usize) -> Range<usize> {
        let start = walls_order(area) + 1;
        start..start + area
    }
}

/// Length of the longest state, that of a 32×32 maze, in bytes.
pub const MAX_STATE_BYTES: usize = state_bytes(MazeSize::HALF_SIZE);

/// Length of a state of a maze of this size in bytes: 518 for 16×16.
pub const fn state_bytes(size: MazeSize) -> usize {
    field::walls(size.area()).end
}

/// What a mouse believes at one moment of its search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State<'a> {
    pose: Pose,
    weights: Matrix<'a>,
    walls: Matrix<'a>,
}

/// A byte for each cell of a maze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Matrix<'a> {
    order: Order,
    size: MazeSize,
    bytes: &'a [u8],
}

/// In which order the cells of a matrix follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// Row by row from the south, x fastest: cell (x, y) stands at y × width + x.
    C,
    /// Column by column from the west, y fastest: cell (x, y) stands at x × height + y.
    F,
}

impl Order {
    /// Where the byte of `cell` stands in a matrix of a maze of this size, `None` outside.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, MazeSize, Order};
    /// let size = MazeSize::new(5, 3)?;
    /// assert_eq!(Order::C.index(Cell::new(2, 1), size), Some(7));
    /// assert_eq!(Order::F.index(Cell::new(2, 1), size), Some(7));
    /// assert_eq!(Order::C.index(Cell::new(4, 0), size), Some(4));
    /// assert_eq!(Order::F.index(Cell::new(4, 0), size), Some(12));
    /// # Ok::<(), mmsim_maze::SizeError>(())
    /// ```
    pub const fn index(self, cell: Cell, size: MazeSize) -> Option<usize> {
        let (x, y) = (cell.x as usize, cell.y as usize);
        match self {
            _ if !size.contains(cell) => None,
            Self::C => Some(y * size.width() as usize + x),
            Self::F => Some(x * size.height() as usize + y),
        }
    }

    const fn byte(self) -> u8 {
        match self {
            Self::C => b'C',
            Self::F => b'F',
        }
    }

    fn decode(byte: u8, matrix: &'static str) -> Result<Self, RequestError> {
        match byte {
            b'C' => Ok(Self::C),
            b'F' => Ok(Self::F),
            found => Err(RequestError::Order { matrix, found }),
        }
    }
}

impl<'a> Matrix<'a> {
    /// A matrix of these bytes; `None` unless there is one for each cell.
    pub fn new(order: Order, size: MazeSize, bytes: &'a [u8]) -> Option<Self> {
        (bytes.len() == size.area()).then_some(Self { order, size, bytes })
    }

    /// In which order the bytes follow one another.
    pub const fn order(&self) -> Order {
        self.order
    }

    /// Its bytes, in its order.
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The byte of `cell`, `None` outside of the maze.
    pub fn at(&self, cell: Cell) -> Option<u8> {
        self.bytes.get(self.order.index(cell, self.size)?).copied()
    }
}

/// What a client says of one cell in the second matrix of a state: visited or not, and on which
/// sides it believes in a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct CellWalls(pub u8);

impl CellWalls {
    const VISITED: u8 = 1;

    /// What a mouse with this map says of `cell`. Unknown walls are not told apart from absent
    /// ones.
    ///
    /// ```
    /// use mmsim_protocol::{Cell, CellWalls, Heading, KnownMaze, MazeSize};
    /// let size = MazeSize::CLASSIC;
    /// let map = KnownMaze::new(size, Cell::new(0, 0), size.central_cells());
    /// let corner = CellWalls::known(&map, Cell::new(0, 0));
    /// assert!(corner.wall(Heading::South) && corner.wall(Heading::West) && !corner.visited());
    /// assert_eq!(corner.0, 4 | 8);
    /// ```
    pub fn known(map: &KnownMaze, cell: Cell) -> Self {
        let visited = if map.visited().contains(cell) { Self::VISITED } else { 0 };
        let certain = map.walls(Unknown::Open);
        let present = |&heading: &Heading| certain.has(cell, heading);
        let walls = Heading::ALL.into_iter().filter(present).map(Self::flag);
        Self(walls.fold(visited, |byte, flag| byte | flag))
    }

    /// Whether the mouse has been in the cell.
    pub const fn visited(self) -> bool {
        self.0 & Self::VISITED != 0
    }

    /// Whether the mouse believes in a wall on this side of the cell.
    pub const fn wall(self, heading: Heading) -> bool {
        self.0 & Self::flag(heading) != 0
    }

    const fn flag(heading: Heading) -> u8 {
        match heading {
            Heading::East => 2,
            Heading::South => 4,
            Heading::West => 8,
            Heading::North => 16,
        }
    }
}

impl<'a> State<'a> {
    /// A state of these parts; `None` unless both matrices are of one size and the mouse stands
    /// inside.
    pub fn new(pose: Pose, weights: Matrix<'a>, walls: Matrix<'a>) -> Option<Self> {
        let fits = weights.size == walls.size && weights.size.contains(pose.cell);
        fits.then_some(Self { pose, weights, walls })
    }

    /// How many cells the maze has each way.
    pub const fn size(&self) -> MazeSize {
        self.weights.size
    }

    /// Where the mouse stands.
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// A number a cell, with whatever meaning the client gives it: a distance in steps, a count of
    /// visits. 255 also stands for anything greater.
    pub const fn weights(&self) -> Matrix<'a> {
        self.weights
    }

    /// A set of flags a cell, as bytes. See [`cell_walls`](Self::cell_walls).
    pub const fn walls(&self) -> Matrix<'a> {
        self.walls
    }

    /// What the client says of one cell, `None` outside of the maze.
    pub fn cell_walls(&self, cell: Cell) -> Option<CellWalls> {
        self.walls.at(cell).map(CellWalls)
    }

    /// The state of a message that begins with `S`.
    pub(crate) fn decode(message: &'a [u8], size: MazeSize) -> Result<Self, RequestError> {
        let area = size.area();
        if message.len() != state_bytes(size) {
            return Err(RequestError::StateLength { size, found: message.len() });
        }
        let matrix =
            |order, bytes, name| Ok(Matrix { order: Order::decode(order, name)?, size, bytes });
        Ok(Self {
            pose: decode_pose(message[field::X], message[field::Y], message[field::HEADING], size)?,
            weights: matrix(
                message[field::WEIGHTS_ORDER],
                &message[field::weights(area)],
                "weights",
            )?,
            walls: matrix(
                message[field::walls_order(area)],
                &message[field::walls(area)],
                "walls",
            )?,
        })
    }

    pub(crate) fn encode(&self, buffer: &mut [u8]) -> Result<usize, BufferTooSmall> {
        let size = self.weights.size;
        let message = front_of(buffer, state_bytes(size))?;
        put_head(message, self.pose, size, [self.weights.order, self.walls.order]);
        message[field::weights(size.area())].copy_from_slice(self.weights.bytes);
        message[field::walls(size.area())].copy_from_slice(self.walls.bytes);
        Ok(message.len())
    }
}

/// Writes the state of a mouse in `pose` that knows `map` to the front of `buffer`, both matrices
/// in the same order, and gives its length in bytes. A weight over 255 is sent as 255.
///
/// # Errors
/// The buffer is shorter than [`state_bytes`].
///
/// ```
/// use mmsim_protocol::{Cell, Heading, KnownMaze, MazeSize, Order, Pose, Request, encode_state};
/// let (size, start) = (MazeSize::CLASSIC, Pose::new(Cell::new(0, 0), Heading::North));
/// let map = KnownMaze::new(size, start.cell, size.central_cells());
/// let mut buffer = [0; 518];
/// encode_state(&mut buffer, start, &map, |cell| 100 * u16::from(cell.x), Order::F)?;
/// let Ok(Request::State(state)) = Request::decode(&buffer, size) else { panic!() };
/// assert_eq!(state.weights().at(Cell::new(2, 9)), Some(200));
/// assert_eq!(state.weights().at(Cell::new(3, 9)), Some(255));
/// # Ok::<(), mmsim_protocol::BufferTooSmall>(())
/// ```
pub fn encode_state(
    buffer: &mut [u8],
    pose: Pose,
    map: &KnownMaze,
    weight: impl Fn(Cell) -> u16,
    order: Order,
) -> Result<usize, BufferTooSmall> {
    let size = map.size();
    let message = front_of(buffer, state_bytes(size))?;
    put_head(message, pose, size, [order; 2]);
    for cell in size.cells() {
        if let Some(index) = order.index(cell, size) {
            let weight = u8::try_from(weight(cell)).unwrap_or(u8::MAX);
            message[field::weights(size.area()).start + index] = weight;
            message[field::walls(size.area()).start + index] = CellWalls::known(map, cell).0;
        }
    }
    Ok(message.len())
}

/// Writes everything but the matrices' bytes. The message is as long as a state of this size.
fn put_head(message: &mut [u8], pose: Pose, size: MazeSize, [weights, walls]: [Order; 2]) {
    message[field::LETTER] = b'S';
    message[field::X] = pose.cell.x;
    message[field::Y] = pose.cell.y;
    message[field::HEADING] = heading_byte(pose.heading);
    message[field::WEIGHTS_ORDER] = weights.byte();
    message[field::walls_order(size.area())] = walls.byte();
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Request, WallsAround};

    /// A state of a maze 2 cells wide and 1 high: at (1, 0) heading east, weights 7 and 9, walls.
    const SMALL: [u8; 10] = *b"S\x01\x00EC\x07\x09F\x0d\x1f";

    fn small() -> MazeSize {
        MazeSize::new(2, 1).unwrap()
    }

    #[test]
    fn a_state_is_its_bytes() {
        let Ok(Request::State(state)) = Request::decode(&SMALL, small()) else { panic!() };
        assert_eq!(state.pose, Pose::new(Cell::new(1, 0), Heading::East));
        assert_eq!((state.weights.order(), state.walls.order()), (Order::C, Order::F));
        assert_eq!(state.weights.at(Cell::new(1, 0)), Some(9));
        assert_eq!(state.weights.at(Cell::new(0, 1)), None);
        let walls = state.cell_walls(Cell::new(0, 0)).unwrap();
        assert!(walls.visited() && walls.wall(Heading::South) && walls.wall(Heading::West));
        assert!(!walls.wall(Heading::North) && !walls.wall(Heading::East));
        let mut buffer = [0xa5; 12];
        assert_eq!(Request::State(state).encode(&mut buffer), Ok(10));
        assert_eq!(buffer[..10], SMALL);
        assert_eq!(buffer[10..], [0xa5; 2]);
    }

    #[test]
    fn malformed_states_say_what_is_wrong() {
        let error = |index: usize, byte| {
            let mut message = SMALL;
            message[index] = byte;
            Request::decode(&message, small()).unwrap_err().to_string()
        };
        insta::assert_snapshot!(error(1, 2), @"expected a cell in a maze of 2x1 cells, found (2, 0)");
        insta::assert_snapshot!(error(3, b'X'), @r#"expected N, E, S or W as heading, found "X""#);
        insta::assert_snapshot!(error(4, b'c'), @r#"expected C or F as order of the weights, found "c""#);
        insta::assert_snapshot!(error(7, b'Z'), @r#"expected C or F as order of the walls, found "Z""#);
        let classic = [b'S'; 518];
        let error = Request::decode(&classic, MazeSize::HALF_SIZE).unwrap_err();
        insta::assert_snapshot!(error, @"expected S of 2054 bytes for a maze of 32x32 cells, found 518 bytes");
        for length in (1..700).filter(|&length| length != 518) {
            let message = [b'S'; 700];
            let error = Request::decode(&message[..length], MazeSize::CLASSIC).unwrap_err();
            let found = RequestError::StateLength { size: MazeSize::CLASSIC, found: length };
            assert_eq!(error, found);
        }
    }

    #[test]
    fn a_map_is_sent_as_the_mouse_knows_it() {
        let pose = Pose::new(Cell::new(0, 0), Heading::East);
        let mut map = KnownMaze::new(small(), pose.cell, small().central_cells());
        map.observe(pose, WallsAround { left: true, front: false, right: true }).unwrap();
        let mut buffer = [0xa5; MAX_STATE_BYTES];
        let weight = |cell: Cell| 254 + 2 * u16::from(cell.x);
        let length = encode_state(&mut buffer, pose, &map, weight, Order::F).unwrap();
        assert_eq!(&buffer[..length], b"S\x00\x00EF\xfe\xffF\x1d\x16");
        assert!(buffer[length..].iter().all(|&byte| byte == 0xa5));
        let too_small = BufferTooSmall { expected: 10, found: 9 };
        let result = encode_state(&mut buffer[..9], pose, &map, weight, Order::F);
        assert_eq!(result, Err(too_small));
    }

    #[test]
    fn a_matrix_has_a_byte_for_each_cell() {
        assert!(Matrix::new(Order::C, small(), &[1, 2]).is_some());
        assert!(Matrix::new(Order::C, small(), &[1, 2, 3]).is_none());
    }

    #[test]
    fn the_parts_of_a_state_fit_together() {
        let matrix = |size: MazeSize, bytes| Matrix::new(Order::C, size, bytes).unwrap();
        let (wide, high) =
            (matrix(small(), &[1, 2]), matrix(MazeSize::new(1, 2).unwrap(), &[1, 2]));
        let pose = |x| Pose::new(Cell::new(x, 0), Heading::North);
        assert!(State::new(pose(1), wide, wide).is_some());
        assert!(State::new(pose(1), wide, high).is_none());
        assert!(State::new(pose(2), wide, wide).is_none());
    }

    fn any_order() -> impl Strategy<Value = Order> {
        prop_oneof![Just(Order::C), Just(Order::F)]
    }

    proptest! {
        #[test]
        fn a_state_survives(
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
                let c = usize::from(cell.y) * width + usize::from(cell.x);
                let f = usize::from(cell.x) * height + usize::from(cell.y);
                let index = if orders.0 == Order::C { c } else { f };
                prop_assert_eq!(state.weights.at(cell), Some(weights[index]));
            }
        }
    }
}
