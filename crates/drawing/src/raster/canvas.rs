//! A raster picture that is updated tile by tile.

use std::collections::HashSet;

use mmsim_maze::MazeSize;
use resvg::tiny_skia::Pixmap;

use crate::raster::{PictureError, paint};
use crate::scene::Scene;
use crate::shapes::{Area, MARGIN, PITCH};
use crate::svg::{Part, Svg, View};

/// The minimum scale at which single tiles are redrawn, in pixels per unit. Below this scale, the
/// whole picture is redrawn, because the trail is thinner than a pixel, and each pixel under the
/// trail may depend on the whole trail.
const THIN: f64 = 0.5;

/// A picture that redraws only the tiles in which something changed. The result is the same as if
/// the whole scene were redrawn.
pub(crate) struct Canvas {
    size: MazeSize,
    extent: (u32, u32),
    drawing: String,
    parts: Vec<Part>,
    pixmap: Pixmap,
}

impl Canvas {
    /// Draws the scene.
    pub(crate) fn new(scene: &Scene<'_>, width_px: u32) -> Result<Self, PictureError> {
        let (drawing, parts) = Svg::with_parts(scene, View::Pixels { width_px });
        let pixmap = paint(&drawing, scene.blank(width_px)?)?;
        Ok(Self { size: scene.size, extent: scene.extent(), drawing, parts, pixmap })
    }

    /// Returns the pixels.
    pub(crate) const fn pixmap(&self) -> &Pixmap {
        &self.pixmap
    }

    /// Updates the picture to show this scene.
    ///
    /// # Errors
    /// Returns an error if the size of the maze or of the legend has changed.
    pub(crate) fn show(&mut self, scene: &Scene<'_>) -> Result<(), PictureError> {
        let width_px = self.pixmap.width();
        if scene.size != self.size {
            return Err(PictureError::OtherFrame { expected: self.size, found: scene.size });
        }
        if scene.extent() != self.extent {
            return Err(PictureError::OtherLegend);
        }
        let (drawing, parts) = Svg::with_parts(scene, View::Pixels { width_px });
        let tiles = Tiles::new(self.extent, &self.pixmap);
        let has_thin_lines = tiles.scale.iter().any(|&scale| scale < THIN);
        let is_alike = head(&drawing, &parts) == head(&self.drawing, &self.parts);
        let stale = if is_alike && !has_thin_lines {
            let changed = changes((&self.drawing, &self.parts), (&drawing, &parts));
            tiles.touched(changed)
        } else {
            vec![true; tiles.columns * tiles.rows]
        };
        let is_wanted = |part: &&Part| tiles.indices(part.area).any(|tile| stale[tile]);
        let fresh = paint(&only(&drawing, &parts, is_wanted), scene.blank(width_px)?)?;
        for tile in (0..stale.len()).filter(|&tile| stale[tile]) {
            tiles.copy(tile, &fresh, &mut self.pixmap);
        }
        (self.drawing, self.parts) = (drawing, parts);
        Ok(())
    }
}

/// Returns the beginning of a drawing, up to its first [`Part`]. The beginning contains the styles
/// and the names of the hidden layers.
fn head<'a>(drawing: &'a str, parts: &[Part]) -> &'a str {
    &drawing[..parts.first().map_or(drawing.len(), |part| part.text.start)]
}

/// Returns the areas of all parts that occur in only one of the drawings `old` and `new`.
fn changes(old: (&str, &[Part]), new: (&str, &[Part])) -> Vec<Area> {
    let (old, new) = (keys(old), keys(new));
    old.symmetric_difference(&new).map(|(_, area)| *area).collect()
}

fn keys<'a>((drawing, parts): (&'a str, &[Part])) -> HashSet<(&'a str, Area)> {
    parts.iter().map(|part| (&drawing[part.text.clone()], part.area)).collect()
}

/// Returns the drawing without the parts for which `is_wanted` returns false.
fn only(drawing: &str, parts: &[Part], is_wanted: impl Fn(&&Part) -> bool) -> String {
    let mut text = String::with_capacity(drawing.len());
    let mut done = 0;
    for part in parts.iter().filter(|part| !is_wanted(part)) {
        text.push_str(&drawing[done..part.text.start]);
        done = part.text.end;
    }
    text + &drawing[done..]
}

/// A grid of cell-sized tiles that covers a picture. The grid begins at the north-west corner of
/// the picture, so the margin shifts the tiles relative to the cells.
struct Tiles {
    columns: usize,
    rows: usize,
    /// The scale in pixels per unit, horizontally and vertically.
    scale: [f64; 2],
}

impl Tiles {
    fn new((width, height): (u32, u32), pixmap: &Pixmap) -> Self {
        Self {
            columns: width.div_ceil(PITCH) as usize,
            rows: height.div_ceil(PITCH) as usize,
            scale: [
                f64::from(pixmap.width()) / f64::from(width),
                f64::from(pixmap.height()) / f64::from(height),
            ],
        }
    }

    /// Returns a flag for each tile: true if at least one of these areas touches the tile.
    fn touched(&self, areas: Vec<Area>) -> Vec<bool> {
        let mut touched = vec![false; self.columns * self.rows];
        for tile in areas.into_iter().flat_map(|area| self.indices(area)) {
            touched[tile] = true;
        }
        touched
    }

    /// Returns the indices of the tiles that may contain pixels of an element in this area.
    fn indices(&self, [west, north, east, south]: Area) -> impl Iterator<Item = usize> + '_ {
        let span = |from: i32, to: i32, scale: f64, count: usize| {
            // Two extra pixels: one for anti-aliased edges, and one for tiles that begin within a
            // pixel.
            let tile = |units: f64| (units + f64::from(MARGIN)) / f64::from(PITCH);
            let first = tile(f64::from(from) - 2.0 / scale).floor().max(0.0);
            let end = tile(f64::from(to) + 2.0 / scale).ceil().max(0.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            (first as usize..(end as usize).min(count))
        };
        let columns = span(west, east, self.scale[0], self.columns);
        let rows = span(north, south, self.scale[1], self.rows);
        rows.flat_map(move |row| columns.clone().map(move |column| row * self.columns + column))
    }

    /// Copies the pixels of a tile, including those on its edges.
    fn copy(&self, tile: usize, from: &Pixmap, to: &mut Pixmap) {
        let span = |index: usize, scale: f64, end: u32| {
            #[expect(clippy::cast_precision_loss, reason = "at most 33")]
            let edge = |index: usize| index as f64 * f64::from(PITCH) * scale;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            let (first, last) = (edge(index).floor() as usize, edge(index + 1).ceil() as usize);
            first..last.min(end as usize)
        };
        let columns = span(tile % self.columns, self.scale[0], from.width());
        for row in span(tile / self.columns, self.scale[1], from.height()) {
            let begin = row * from.width() as usize;
            let row = begin + columns.start..begin + columns.end;
            to.pixels_mut()[row.clone()].copy_from_slice(&from.pixels()[row]);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use mmsim_maze::{Cell, CellSet, Colour, Heading, KnownMaze, Maze, Pose, WallState, Walls};
    use proptest::prelude::*;

    use super::*;
    use crate::scene::Layers;
    use crate::style::colour::Theme;

    /// A random change to the scene between two canvas updates.
    #[derive(Clone, Debug)]
    struct Change {
        walls: Vec<(u8, u8, bool)>,
        weights: Vec<(usize, u8)>,
        notes: Vec<(u8, u8, String, Option<Colour>)>,
        mouse: (u8, u8),
        layers: u8,
    }

    fn change() -> impl Strategy<Value = Change> {
        let walls = prop::collection::vec(any::<(u8, u8, bool)>(), 0..3);
        let weights = prop::collection::vec((0usize..64, 1u8..200), 0..3);
        let colour = prop::option::of(prop::sample::select(vec![
            Colour::Black,
            Colour::White,
            Colour::DarkRed,
        ]));
        let special = prop::sample::select(vec!['&', '<', '"', '\u{fffe}', '\u{ffff}']);
        let text = prop::collection::vec(prop_oneof![any::<char>(), special], 0..=10)
            .prop_map(String::from_iter);
        let notes = prop::collection::vec((any::<u8>(), any::<u8>(), text, colour), 0..3);
        (walls, weights, notes, any::<(u8, u8)>(), 0u8..12).prop_map(
            |(walls, weights, notes, mouse, layers)| Change {
                walls,
                weights,
                notes,
                mouse,
                layers,
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        /// Compares the canvas with a naive implementation that redraws the whole scene.
        #[test]
        fn partial_updates_match_a_full_redraw(
            (width, height) in (1usize..=8, 1usize..=8),
            width_px in 16u32..400,
            changes in prop::collection::vec(change(), 1..6),
        ) {
            let size = MazeSize::new(width, height).unwrap();
            let maze = Maze::new(Walls::open(size), Cell::new(0, 0), CellSet::EMPTY).unwrap();
            let mut map = KnownMaze::unexplored(&maze);
            let (mut texts, mut colours) = (HashMap::new(), HashMap::new());
            let (mut weights, mut trail) = ([9; 64], Vec::new());
            prop_assume!(Scene::from_map(&map).blank(width_px).is_ok());
            let mut canvas = Canvas::new(&Scene::from_map(&map), width_px).unwrap();
            for Change { walls, weights: heavier, notes, mouse: (x, y), layers } in changes {
                for (x, y, text, colour) in notes {
                    let cell = Cell::new(x % size.width(), y % size.height());
                    texts.insert(cell, text);
                    colours.insert(cell, colour);
                }
                for (x, y, is_north) in walls {
                    let heading = if is_north { Heading::North } else { Heading::East };
                    let cell = Cell::new(x % size.width(), y % size.height());
                    map.set_wall(cell, heading, WallState::Present);
                    map.visit(cell);
                }
                for (cell, weight) in heavier {
                    weights[cell] = weight;
                }
                let heading = Heading::ALL[usize::from(x ^ y) % 4];
                let mouse = Pose::new(Cell::new(x % size.width(), y % size.height()), heading);
                trail.push(mouse);
                let scene = Scene::from_map(&map)
                    .with_truth(Some(&maze))
                    .with_mouse(mouse)
                    .with_weights(|cell| weights[usize::from(cell.y) * 8 + usize::from(cell.x)])
                    .with_texts(|cell| texts.get(&cell).map_or("", String::as_str))
                    .with_colours(|cell| colours.get(&cell).copied().flatten())
                    .with_trail(&trail)
                    .with_theme(if layers == 0 { Theme::Dark } else { Theme::Light })
                    .with_layers(Layers { heat: layers == 1, ..Layers::ALL });
                canvas.show(&scene).unwrap();
                prop_assert!(canvas.pixmap().data() == scene.pixmap(width_px).unwrap().data());
            }
        }
    }
}
