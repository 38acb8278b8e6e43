//! What is to be seen.

use mmsim_maze::{Cell, CellSet, KnownMaze, Maze, MazeSize, Pose};

use crate::Theme;
use crate::svg::{Svg, View};

/// How many cells of a trail are drawn at most: those that were entered last.
pub const TRAIL_CELLS: usize = 500;

/// What is to be seen: a maze or what a client believes of one, and what goes with it. It borrows
/// the mazes and the trail; building one draws nothing.
///
/// A scene of the truth alone shows all walls as pale on a page, where a client's belief is added
/// later, and strong in a file.
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
    /// For each cell in the order of [`MazeSize::cells`], or empty.
    pub(crate) numbers: Vec<Option<u16>>,
    pub(crate) trail: &'a [Cell],
    pub(crate) layers: Layers,
    pub(crate) theme: Theme,
}

/// Which layers of a scene a file shows. On a page they are all there, and classes of the `<svg>`
/// hide them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layers {
    /// The numbers themselves.
    pub numbers: bool,
    /// The numbers as colours.
    pub heat: bool,
    /// Where the mouse has been.
    pub trail: bool,
}

impl Layers {
    /// All there is.
    pub const ALL: Self = Self { numbers: true, heat: true, trail: true };
}

impl Default for Layers {
    /// Numbers and trail.
    fn default() -> Self {
        Self { numbers: true, heat: false, trail: true }
    }
}

impl<'a> Scene<'a> {
    /// The true maze, of which nobody knows anything.
    pub fn from_maze(maze: &'a Maze) -> Self {
        let scene = Self::empty(maze.size(), maze.start().cell, maze.goals());
        Self { truth: Some(maze), ..scene }
    }

    /// What a client believes. Its walls count as there unless the [truth](Self::with_truth) says
    /// otherwise.
    pub fn from_map(map: &'a KnownMaze) -> Self {
        let scene = Self::empty(map.size(), map.start(), map.goals());
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

    /// Adds the true maze, where it is known: its walls are there, pale where nobody knows of them,
    /// and shows which believed walls are mistaken. A maze of another size is left out.
    pub fn with_truth(mut self, maze: Option<&'a Maze>) -> Self {
        self.truth = maze.filter(|maze| maze.size() == self.size);
        self
    }

    /// Adds the mouse. One outside of the maze is left out.
    pub fn with_mouse(mut self, pose: Pose) -> Self {
        self.mouse = Some(pose).filter(|pose| self.size.contains(pose.cell));
        self
    }

    /// Adds a client's weight for each cell. If all of them are 0, the client has none to show, and
    /// there is neither a number nor a colour; else each cell has both.
    pub fn with_weights(mut self, weight: impl Fn(Cell) -> u8) -> Self {
        self.numbers = self.size.cells().map(|cell| Some(u16::from(weight(cell)))).collect();
        if self.numbers.iter().all(|&number| number == Some(0)) {
            self.numbers.clear();
        }
        self
    }

    /// Adds a number, such as a distance in steps, in each cell for which there is one.
    pub fn with_numbers(mut self, number: impl Fn(Cell) -> Option<u16>) -> Self {
        self.numbers = self.size.cells().map(number).collect();
        self
    }

    /// Adds the cells that the mouse went through, oldest first. The last [`TRAIL_CELLS`] are drawn.
    pub fn with_trail(mut self, cells: &'a [Cell]) -> Self {
        self.trail = &cells[cells.len().saturating_sub(TRAIL_CELLS)..];
        self
    }

    /// Which layers a file shows.
    pub const fn with_layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self
    }

    /// In which colours a file is drawn.
    pub const fn with_theme(mut self, theme: Theme) -> Self {
        self.theme = theme;
        self
    }

    /// The drawing for a page that has the [`stylesheet`](crate::stylesheet): no style and no size
    /// of its own, all layers. Everything that can change is there with a class and the cell or the
    /// wall it stands for, so that a page can change it in place:
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
    /// Cells come row by row from the south. Every place where a wall can be has its element: the
    /// north and the east side of each cell, then the south sides of the south row, then the west
    /// sides of the west column. `true` is a wall of the true maze, `known` one that the client
    /// believes in, `mistaken` one that it believes in and that is not there; without any of these
    /// there is nothing to see.
    pub fn page_svg(&self) -> String {
        Svg::of(self, View::Page)
    }

    /// The drawing as a file that stands for itself: as on a page, with the style of its theme and
    /// a size in pixels, its layers shown or hidden.
    pub fn svg(&self) -> String {
        Svg::of(self, View::File)
    }
}
