//! The colour palette of an animation.

use std::collections::{BTreeMap, HashMap};

use mmsim_maze::{Cell, Colour, Heading, KnownMaze, Maze, MazeSize, Pose, WallState, Walls};

use resvg::tiny_skia::Pixmap;

use crate::raster::{PictureError, rgb};
use crate::scene::Scene;
use crate::shapes::units;
use crate::style::colour::Rgb;
use crate::style::data_colours::{cell_colour, faint, heat_ramp, path_colours, speed_ramp};

/// The maximum number of colours in a GIF palette, not counting the index for unchanged pixels.
const MAX_COLOURS: usize = 255;

/// The number of colours that a palette reproduces exactly. These are the colours of the theme, the
/// colours that mice give to cells, and the colours that cover the largest areas. The rest of the
/// palette approximates all other colours.
const EXACT: usize = 160;

/// A set of colours with a cached lookup of the nearest colour.
#[derive(Debug)]
pub(crate) struct Palette {
    colours: Vec<Rgb>,
    nearest: HashMap<Rgb, u8>,
}

impl Palette {
    /// The index that marks unchanged pixels.
    #[expect(clippy::cast_possible_truncation, reason = "255")]
    pub(crate) const UNCHANGED: u8 = MAX_COLOURS as u8;

    /// Builds a palette for an animation of this width in pixels. All scenes of the animation must
    /// have the same theme and layers as `scene`. The colours come from a sample scene with
    /// everything that a scene can contain, so the palette suits all frames of the animation.
    pub(crate) fn like(scene: &Scene<'_>, width_px: u32) -> Result<Self, PictureError> {
        if !scene.paths.is_empty() {
            return Self::for_paths(scene, width_px);
        }
        let size = MazeSize::CLASSIC;
        // Draw the sample at the scale of the scene, but limit its size.
        let side_px = (width_px * units(size).0 / units(scene.size).0).clamp(64, 768);
        let sheet = Sheet::new(size);
        let samples = [Heading::North, Heading::East]
            .map(|heading| sheet.scene(scene, heading).pixmap(side_px));
        let theme = scene.theme;
        let mut chosen = theme.colours().areas();
        chosen.extend(Colour::ALL.map(cell_colour));
        if scene.layers.heat {
            chosen.extend(heat_ramp(theme));
        }
        Self::new(chosen, samples)
    }

    /// Builds a palette for an animation of mice on paths. Its frames differ only in the places of
    /// the mice and in the parts of the paths that are faint.
    fn for_paths(scene: &Scene<'_>, width_px: u32) -> Result<Self, PictureError> {
        let samples =
            [0.0, scene.duration()].map(|time| scene.clone().at_time(time).pixmap(width_px));
        let theme = scene.theme;
        let mut chosen = theme.colours().areas();
        let paths = path_colours(theme).into_iter().take(scene.paths.len());
        let strong = if scene.paths.len() == 1 { speed_ramp(theme) } else { paths.collect() };
        chosen.extend(strong.iter().map(|&colour| faint(colour, theme.colours().floor)));
        chosen.extend(strong);
        Self::new(chosen, samples)
    }

    /// Builds a palette with all `chosen` colours and the colours of pictures.
    fn new(
        chosen: Vec<Rgb>,
        pictures: [Result<Pixmap, PictureError>; 2],
    ) -> Result<Self, PictureError> {
        let mut areas = BTreeMap::new();
        for picture in pictures {
            for &pixel in picture?.pixels() {
                *areas.entry(rgb(pixel)).or_insert(0_u32) += 1;
            }
        }
        Ok(Self { colours: choose(chosen, areas.into_iter().collect()), nearest: HashMap::new() })
    }

    /// Returns the colours as bytes, padded to 256 colours of three bytes each.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let colours = self.colours.iter().flat_map(|colour| [colour.0, colour.1, colour.2]);
        colours.chain(std::iter::repeat(0)).take(3 * (MAX_COLOURS + 1)).collect()
    }

    /// Returns the index of the palette colour that is nearest to `colour`.
    pub(crate) fn index(&mut self, colour: Rgb) -> u8 {
        let colours = &self.colours;
        *self.nearest.entry(colour).or_insert_with(|| {
            let nearest = (0..).zip(colours).min_by_key(|(_, other)| distance(colour, **other));
            nearest.map_or(0, |(index, _)| index)
        })
    }
}

/// Returns the weighted squared distance between two colours.
fn distance(one: Rgb, other: Rgb) -> u32 {
    let square = |one: u8, other: u8| u32::from(one.abs_diff(other)).pow(2);
    // Green contributes most to perceived lightness, blue least.
    2 * square(one.0, other.0) + 4 * square(one.1, other.1) + square(one.2, other.2)
}

/// Adds the colours of the largest areas to `chosen`. Then repeatedly adds the colour whose
/// distance to the nearest chosen colour is largest. Flat areas therefore keep their exact colours,
/// while the blended colours at their edges are approximated.
fn choose(mut chosen: Vec<Rgb>, mut areas: Vec<(Rgb, u32)>) -> Vec<Rgb> {
    areas.retain(|(colour, _)| !chosen.contains(colour));
    areas.sort_by_key(|&(_, area)| std::cmp::Reverse(area));
    let exact = EXACT - chosen.len();
    chosen.extend(areas.iter().take(exact).map(|&(colour, _)| colour));
    let far = |colour: Rgb| chosen.iter().map(|&other| distance(colour, other)).min().unwrap_or(0);
    let mut rest: Vec<(Rgb, u32)> =
        areas.iter().skip(exact).map(|&(colour, _)| (colour, far(colour))).collect();
    while chosen.len() < MAX_COLOURS {
        let Some(&(next, 1..)) = rest.iter().max_by_key(|(_, far)| far) else { break };
        chosen.push(next);
        for (colour, far) in &mut rest {
            *far = (*far).min(distance(*colour, next));
        }
    }
    chosen
}

/// The maze, the map and the trail of a sample scene. Together, they contain all kinds of walls and
/// cells.
struct Sheet {
    maze: Maze,
    map: KnownMaze,
    trail: Vec<Pose>,
}

impl Sheet {
    fn new(size: MazeSize) -> Self {
        let start = Cell::new(0, 0);
        let mut walls = Walls::open(size);
        let mut map = KnownMaze::new(size, start, size.central_cells());
        for cell in size.cells() {
            if (cell.x / 4 + cell.y / 4) % 2 == 0 {
                map.visit(cell);
            }
            for (heading, kind) in
                [(Heading::North, cell.x + 2 * cell.y), (Heading::East, 2 * cell.x + cell.y)]
            {
                walls.set(cell, heading, kind % 5 < 2);
                if kind % 5 == 1 || kind % 10 == 2 {
                    map.set_wall(cell, heading, WallState::Present);
                }
            }
        }
        let maze = Maze::new(walls, start, size.central_cells());
        // The mouse drives to the east in even rows and back to the west in odd ones.
        let (width, last) = (size.width(), size.width() - 1);
        let row = |y| (0..width).map(move |x| Cell::new(if y % 2 == 0 { x } else { last - x }, y));
        let cells: Vec<Cell> = (0..size.height()).flat_map(row).collect();
        let passage = |pair: &[Cell]| {
            let is_next = |heading: &Heading| pair[0].neighbour(*heading) == Some(pair[1]);
            Heading::ALL.into_iter().find(is_next).map(|heading| Pose::new(pair[0], heading))
        };
        let trail = cells.windows(2).filter_map(passage).collect();
        #[expect(clippy::unwrap_used, reason = "the start and the goals lie inside the maze")]
        Self { maze: maze.unwrap(), map, trail }
    }

    /// Returns the sample scene with the theme and the layers of `like`.
    fn scene(&self, like: &Scene<'_>, heading: Heading) -> Scene<'_> {
        let scene = Scene::from_map(&self.map)
            .with_truth(Some(&self.maze))
            .with_mouse(Pose::new(Cell::new(2, 1), heading))
            .with_numbers(|cell| Some(u16::from(cell.x) * 16 + u16::from(cell.y) * 7 % 16))
            .with_trail(&self.trail)
            .with_layers(like.layers)
            .with_theme(like.theme);
        // Each colour is in one cell with a text.
        let colour = |Cell { x, y }: Cell| {
            let width = self.maze.size().width();
            let diagonal = usize::from((x + width - y % width) % width);
            Colour::ALL.get(usize::from(y) + usize::from(width) * diagonal).copied()
        };
        let text = |cell| if colour(cell).is_some() { "80" } else { "" };
        scene.with_texts(text).with_colours(colour)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Layers;
    use crate::style::colour::Theme;

    #[test]
    fn the_nearest_colour_is_found() {
        let mut palette = Palette {
            colours: vec![Rgb(0, 0, 0), Rgb(255, 255, 255), Rgb(200, 0, 0)],
            nearest: HashMap::new(),
        };
        let indices = [Rgb(10, 0, 9), Rgb(200, 210, 220), Rgb(180, 20, 0), Rgb(10, 0, 9)];
        assert_eq!(indices.map(|colour| palette.index(colour)), [0, 1, 2, 0]);
    }

    #[test]
    fn large_areas_are_exact_and_outliers_are_covered() {
        let grey = |level: u8, area| (Rgb(level, level, level), area);
        let mut areas: Vec<_> = (0..=200).map(|level| grey(level, 10)).collect();
        areas.push((Rgb(0, 0, 255), 1));
        areas.push(grey(255, 1000));
        let chosen = choose(Vec::new(), areas);
        assert_eq!(chosen[0], Rgb(255, 255, 255));
        assert_eq!(chosen.len(), 203, "there is room for all");
        let many = (0..=255).flat_map(|red| [(Rgb(red, 0, 0), 1), (Rgb(red, 0, 255), 1)]);
        let chosen = choose(Vec::new(), many.collect());
        assert_eq!(chosen.len(), MAX_COLOURS);
        for blue in [0, 255] {
            for red in 0..=255 {
                let error = chosen.iter().map(|&other| distance(Rgb(red, 0, blue), other)).min();
                assert!(error <= Some(2 * 4 * 4), "{red} {error:?}");
            }
        }
    }

    #[test]
    fn the_palette_contains_all_cell_colours() {
        let sheet = Sheet::new(MazeSize::CLASSIC);
        for theme in [Theme::Light, Theme::Dark] {
            let scene = Scene::from_maze(&sheet.maze).with_theme(theme).with_layers(Layers::ALL);
            let mut palette = Palette::like(&scene, 648).unwrap();
            let notes = Colour::ALL.map(cell_colour);
            for colour in heat_ramp(theme).into_iter().chain(theme.colours().areas()).chain(notes) {
                let index = usize::from(palette.index(colour));
                assert_eq!(palette.colours[index], colour, "{theme:?}");
            }
        }
    }
}
