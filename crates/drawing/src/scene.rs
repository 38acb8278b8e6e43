//! The contents of a picture.

use mmsim_maze::{Cell, CellSet, KnownMaze, Maze, MazeSize, Pose};

use crate::svg::{Svg, View};
use crate::theme::Theme;

/// The maximum number of cells drawn of a trail: the most recent ones.
pub const TRAIL_CELLS: usize = 500;

/// The contents of a picture: a maze or a client's map, plus mouse, numbers and trail. It borrows
/// mazes and trail; nothing is drawn until an output is requested.
///
/// In a scene of the true maze alone, a page shows all walls pale, because a client's map is added
/// later; a file shows them at full strength.
///
/// ```
/// use mmsim_drawing::{Layers, Scene, Theme};
/// use mmsim_maze::{Cell, Maze};
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let trail = [Cell::new(0, 0), Cell::new(1, 0)];
/// let scene = Scene::from_maze(&maze)
///     .with_trail(&trail)
///     .with_layers(Layers { heat: false, ..Layers::ALL })
///     .with_theme(Theme::Dark);
/// assert!(scene.page_svg().contains(r#"data-wall="0,0,N""#));
/// # Ok::<(), mmsim_maze::ParseMazeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    pub(crate) size: MazeSize,
    pub(crate) start: Cell,
    pub(crate) goals: &'a CellSet,
    pub(crate) truth: Option<&'a Maze>,
    pub(crate) map: Option<&'a KnownMaze>,
    pub(crate) mouse: Option<Pose>,
    /// One for each cell in the order of [`MazeSize::cells`], or empty.
    pub(crate) numbers: Vec<Option<u16>>,
    pub(crate) trail: &'a [Cell],
    pub(crate) layers: Layers,
    pub(crate) theme: Theme,
}

/// The layers of a scene that a file shows. A page contains all layers and hides them with classes
/// on the `<svg>`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layers {
    /// The numbers in the cells.
    pub numbers: bool,
    /// The weights as heat colours.
    pub heat: bool,
    /// The path of the mouse.
    pub trail: bool,
}

impl Layers {
    /// All layers.
    pub const ALL: Self = Self { numbers: true, heat: true, trail: true };
}

impl Default for Layers {
    /// Numbers and trail only.
    fn default() -> Self {
        Self { numbers: true, heat: false, trail: true }
    }
}

impl<'a> Scene<'a> {
    /// Creates a scene of the true maze, with no wall known to a client.
    pub fn from_maze(maze: &'a Maze) -> Self {
        let scene = Self::empty(maze.size(), maze.start().cell, maze.goals());
        Self { truth: Some(maze), ..scene }
    }

    /// Creates a scene of a client's map. Its walls count as real unless the
    /// [true maze](Self::with_truth) says otherwise.
    pub fn from_map(map: &'a KnownMaze) -> Self {
        let scene = Self::empty(map.size(), map.start().cell, map.goals());
        Self { map: Some(map), ..scene }
    }

    fn empty(size: MazeSize, start: Cell, goals: &'a CellSet) -> Self {
        Self {
            size,
            start,
            goals,
            truth: None,
            map: None,
            mouse: None,
            numbers: Vec::new(),
            trail: &[],
            layers: Layers::default(),
            theme: Theme::default(),
        }
    }

    /// Adds the true maze: walls unknown to the client are pale, and believed walls that do not exist
    /// are marked as mistaken. A maze of another size is ignored.
    pub fn with_truth(mut self, maze: Option<&'a Maze>) -> Self {
        self.truth = maze.filter(|maze| maze.size() == self.size);
        self
    }

    /// Adds the mouse. A mouse outside the maze is ignored.
    pub fn with_mouse(mut self, pose: Pose) -> Self {
        self.mouse = Some(pose).filter(|pose| self.size.contains(pose.cell));
        self
    }

    /// Adds the client's weight of each cell, as numbers and heat colours. If all weights are 0, none
    /// is shown.
    pub fn with_weights(mut self, weight: impl Fn(Cell) -> u8) -> Self {
        self.numbers = self.size.cells().map(|cell| Some(u16::from(weight(cell)))).collect();
        if self.numbers.iter().all(|&number| number == Some(0)) {
            self.numbers.clear();
        }
        self
    }

    /// Adds a number, such as a distance in steps, to each cell for which `number` returns one.
    pub fn with_numbers(mut self, number: impl Fn(Cell) -> Option<u16>) -> Self {
        self.numbers = self.size.cells().map(number).collect();
        self
    }

    /// Adds the path of the mouse, oldest cell first. The last [`TRAIL_CELLS`] cells are drawn.
    pub fn with_trail(mut self, cells: &'a [Cell]) -> Self {
        self.trail = &cells[cells.len().saturating_sub(TRAIL_CELLS)..];
        self
    }

    /// Sets the layers that a file shows.
    pub const fn with_layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self
    }

    /// Sets the theme of a file.
    pub const fn with_theme(mut self, theme: Theme) -> Self {
        self.theme = theme;
        self
    }

    /// Returns the drawing for a page that uses the [`stylesheet`](crate::stylesheet): all layers,
    /// without styles or a size. Each element that can change carries a class and its cell or wall, so
    /// a page can update it in place:
    ///
    ///
    /// ```text
    /// <svg class="maze" viewBox="…">              hide-numbers, hide-heat, hide-trail hide a layer
    ///   <rect class="floor"/>
    ///   <g class="cells"> <rect class="cell [start] [goal] [visited]" data-cell="x,y"/> …
    ///   <g class="heats"> <rect class="heat" data-cell="x,y" fill="#rrggbb or none"/> …
    ///   <g class="marks"> frames and badges of start and goals, which stay
    ///   <polyline class="trail"/>
    ///   <g class="numbers"> <path class="number" data-cell="x,y" d="digits or nothing"/> …
    ///   <g class="walls"> <path class="wall [true] [known or mistaken]" data-wall="x,y,NESW"/> …
    ///   <path class="posts"/>
    ///   <path class="mouse [absent]" transform="translate(x y) rotate(degrees)"/>
    /// </svg>
    /// ```
    ///
    /// Cells are ordered row by row from the south. Every place of a wall has an element: the north
    /// and the east side of each cell, then the south sides of the south row, then the west sides of
    /// the west column. The class `true` marks a wall of the true maze, `known` a wall that the client
    /// believes in, `mistaken` a believed wall that does not exist; an element with none of them is
    /// invisible.
    pub fn page_svg(&self) -> String {
        Svg::draw(self, View::Page)
    }

    /// Returns the drawing as a standalone SVG file: the page's drawing plus the style of its theme and
    /// a size in pixels, with the selected layers.
    pub fn svg(&self) -> String {
        Svg::draw(self, View::File)
    }
}
