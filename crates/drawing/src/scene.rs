//! Scenes: descriptions of pictures.

pub(crate) mod driven_path;

use std::collections::HashMap;

use mmsim_maze::{Cell, CellSet, Colour, KnownMaze, Maze, MazeSize, Pose};

use crate::scene::driven_path::DrivenPath;
use crate::style::colour::{Rgb, Theme};
use crate::style::data_colours::{MAX_PATHS, cell_colour};
use crate::text::Label;

/// The contents of a picture: a maze or a client's map, plus the mouse, numbers and the trail. A
/// scene borrows the maze, the map and the trail. Nothing is drawn until an output is requested.
///
/// If a scene has no client's map, all walls are drawn thick in a file, but thin in a page,
/// because the page adds a map later.
///
/// ```
/// use mmsim_drawing::{Layers, Scene, Theme};
/// use mmsim_maze::{Cell, Heading, Maze, Pose};
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let trail = [Pose::new(maze.start().cell, Heading::East)];
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
    /// The label of each cell, in the order of [`MazeSize::cells`], or an empty list if the scene
    /// has no labels.
    labels: Vec<Option<Label>>,
    /// The text of each cell that has one, which replaces the label.
    texts: HashMap<Cell, String>,
    /// The colour of each cell that has one.
    colours: HashMap<Cell, Colour>,
    /// The passages of the trail, oldest first.
    pub(crate) trail: &'a [Pose],
    pub(crate) shortest_path: Vec<Cell>,
    pub(crate) planned_path: Vec<Cell>,
    pub(crate) paths: &'a [DrivenPath],
    /// The time in s at which mice are drawn on the paths.
    pub(crate) time: Option<f64>,
    pub(crate) layers: Layers,
    pub(crate) theme: Theme,
}

/// The layers of a scene that are visible in a file. A page contains numbers, heat colours and the
/// trail in any case, and hides them with classes on the `<svg>` element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layers {
    /// The numbers in the cells.
    pub numbers: bool,
    /// The weights as heat colours.
    pub heat: bool,
    /// The path of the mouse.
    pub trail: bool,
    /// The texts in the cells.
    pub texts: bool,
    /// The colours of the cells.
    pub colours: bool,
}

impl Layers {
    /// All layers.
    pub const ALL: Self =
        Self { numbers: true, heat: true, trail: true, texts: true, colours: true };
}

impl Default for Layers {
    /// Selects all layers except the heat colours.
    fn default() -> Self {
        Self { heat: false, ..Self::ALL }
    }
}

impl<'a> Scene<'a> {
    /// Creates a scene that shows the true maze, without a client's map.
    pub fn from_maze(maze: &'a Maze) -> Self {
        let scene = Self::empty(maze.size(), maze.start().cell, maze.goals());
        Self { truth: Some(maze), ..scene }
    }

    /// Creates a scene that shows a client's map. Without a [true maze](Self::with_truth), all
    /// walls on the map are assumed to exist.
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
            labels: Vec::new(),
            texts: HashMap::new(),
            colours: HashMap::new(),
            trail: &[],
            shortest_path: Vec::new(),
            planned_path: Vec::new(),
            paths: &[],
            time: None,
            layers: Layers::default(),
            theme: Theme::default(),
        }
    }

    /// Adds the true maze. Walls unknown to the client are drawn thin, and walls that differ on the
    /// client's map are highlighted. A maze of a different size is ignored.
    pub fn with_truth(mut self, maze: Option<&'a Maze>) -> Self {
        self.truth = maze.filter(|maze| maze.size() == self.size);
        self
    }

    /// Adds the mouse. A mouse outside the maze is ignored.
    pub fn with_mouse(mut self, pose: Pose) -> Self {
        self.mouse = Some(pose).filter(|pose| self.size.contains(pose.cell));
        self
    }

    /// Adds the weight that the client assigned to each cell, shown as a number and as a heat
    /// colour. If all weights are 0, no weights are shown. The largest weight, 255, means that there
    /// is no path: it is shown as ∞ and has no heat colour.
    pub fn with_weights(mut self, weight: impl Fn(Cell) -> u8) -> Self {
        let weights: Vec<u8> = self.size.cells().map(weight).collect();
        let is_blank = weights.iter().all(|&weight| weight == 0);
        let weights = if is_blank { Vec::new() } else { weights };
        self.labels = weights.into_iter().map(|weight| Some(Label::from_weight(weight))).collect();
        self
    }

    /// Adds a number, such as a distance in steps, to each cell for which `number` returns a value.
    pub fn with_numbers(mut self, number: impl Fn(Cell) -> Option<u16>) -> Self {
        self.labels = self.size.cells().map(|cell| number(cell).map(Label::Number)).collect();
        self
    }

    /// Adds a text of up to 10 characters to each cell for which `text` returns a non-empty string.
    /// The text replaces the number of the cell. If any cell has a text, the number 0 is not shown
    /// in other cells, because a mouse for the simulator mms has no weights except its texts. A text
    /// of more than 5 characters is split into two lines, as in mms.
    pub fn with_texts<'b>(mut self, text: impl Fn(Cell) -> &'b str) -> Self {
        let texts = self.size.cells().map(|cell| (cell, text(cell)));
        let texts = texts.filter(|(_, text)| !text.is_empty());
        self.texts = texts.map(|(cell, text)| (cell, text.into())).collect();
        self
    }

    /// Colours each cell for which `colour` returns a colour.
    pub fn with_colours(mut self, colour: impl Fn(Cell) -> Option<Colour>) -> Self {
        self.colours = self.size.cells().filter_map(|cell| Some((cell, colour(cell)?))).collect();
        self
    }

    /// Adds the path of the mouse, which fades from its newest to its oldest part. A passage is the cell
    /// that the mouse left, and the direction of the step; the oldest passage comes first. Passages
    /// outside the maze are ignored.
    pub fn with_trail(mut self, passages: &'a [Pose]) -> Self {
        self.trail = passages;
        self
    }

    /// Adds the shortest path as a line through the centres of cells. An empty list adds nothing, and
    /// cells outside the maze are ignored.
    pub fn with_shortest_path(mut self, cells: Vec<Cell>) -> Self {
        self.shortest_path = cells;
        self
    }

    /// Adds the path that the mouse plans to take, as a dashed line through the centres of cells. An
    /// empty list adds nothing, and cells outside the maze are ignored.
    pub fn with_planned_path(mut self, cells: Vec<Cell>) -> Self {
        self.planned_path = cells;
        self
    }

    /// Adds curves that mice drive, with a legend below the maze. A single path is coloured by the
    /// speed, and has a scale; several paths have distinct colours, and the first one is on top. Paths
    /// after the first [`MAX_PATHS`] are ignored. A page contains no curves.
    pub fn with_paths(mut self, paths: &'a [DrivenPath]) -> Self {
        self.paths = &paths[..paths.len().min(MAX_PATHS)];
        self
    }

    /// Draws a mouse on each path where it is at a time in s, and the time as a clock. The part of
    /// the path that the mouse has not driven yet is faint.
    pub fn at_time(mut self, time: f64) -> Self {
        self.time = Some(time).filter(|_| !self.paths.is_empty());
        self
    }

    /// Sets the layers that are visible in a file.
    pub const fn with_layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self
    }

    /// Sets the theme of a file. In a page, the theme affects only the heat colours, because the
    /// [`stylesheet`](crate::stylesheet) sets all other colours.
    pub const fn with_theme(mut self, theme: Theme) -> Self {
        self.theme = theme;
        self
    }

    /// Returns the colour of a cell.
    pub(crate) fn colour(&self, cell: Cell) -> Option<Rgb> {
        self.colours.get(&cell).filter(|_| self.layers.colours).copied().map(cell_colour)
    }

    /// Returns the text of a cell.
    pub(crate) fn text(&self, cell: Cell) -> Option<&str> {
        self.texts.get(&cell).filter(|_| self.layers.texts).map(String::as_str)
    }

    /// Returns true if a cell has a text.
    pub(crate) fn has_texts(&self) -> bool {
        self.layers.texts && !self.texts.is_empty()
    }

    /// Returns the labels that are shown, in the order of [`MazeSize::cells`]. A cell with a text
    /// keeps its label, on which its heat colour depends.
    pub(crate) fn labels(&self) -> impl Iterator<Item = (Cell, Option<&Label>)> {
        let labels = self.labels.iter().map(Option::as_ref).chain(std::iter::repeat(None));
        self.size.cells().zip(labels).map(|(cell, label)| {
            let is_blank = |label: &&Label| {
                **label == Label::Number(0) && self.has_texts() && self.text(cell).is_none()
            };
            (cell, label.filter(|label| !is_blank(label)))
        })
    }
}
