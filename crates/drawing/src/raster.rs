//! Rasterization.

pub(crate) mod animation;
pub(crate) mod canvas;
pub(crate) mod palette;

use mmsim_maze::MazeSize;
use resvg::tiny_skia::{Pixmap, PremultipliedColorU8, Transform};
use resvg::usvg::{Options, Tree};

use crate::scene::Scene;
use crate::style::colour::Rgb;
use crate::svg::{Svg, View};

/// The minimum and maximum width of a picture, in pixels.
pub const WIDTH_PX: std::ops::RangeInclusive<u32> = 16..=4096;

/// The maximum height of a picture, in pixels.
pub const MAX_HEIGHT_PX: u32 = 4096;

/// The error returned if a picture or animation cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The picture would be too small or too large.
    #[error(
        "cannot draw a picture of {width}x{height} pixels: the width must be {} to {} and the height at most {MAX_HEIGHT_PX}",
        WIDTH_PX.start(), WIDTH_PX.end()
    )]
    Size {
        /// The requested width in pixels.
        width: u32,
        /// The height in pixels that results from the requested width.
        height: u64,
    },
    /// Drawing or encoding failed. No scene is known to cause this error.
    #[error("cannot draw the picture: {0}")]
    Drawing(String),
    /// The animation has no frame.
    #[error("cannot write an animation without frames")]
    NoFrame,
    /// The maze in a new frame differs in size from the one in the first frame.
    #[error("cannot add a frame of {found} cells to an animation of {expected} cells")]
    OtherFrame {
        /// The size of the maze in the first frame.
        expected: MazeSize,
        /// The size of the maze in the new frame.
        found: MazeSize,
    },
    /// The legend of a new frame differs in size from the one in the first frame.
    #[error("cannot add a frame with another legend to an animation")]
    OtherLegend,
}

impl Scene<'_> {
    /// Draws the scene as a PNG of this width in pixels. The height follows from the size of the
    /// maze; see [`width_within`](Self::width_within).
    ///
    /// # Errors
    /// Returns an error if the width is outside 16 to 4096 pixels or the height exceeds 4096
    /// pixels.
    ///
    /// ```
    /// use mmsim_drawing::Scene;
    /// let maze: mmsim_maze::Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
    /// let png = Scene::from_maze(&maze).png(440)?;
    /// assert!(png.starts_with(b"\x89PNG"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn png(&self, width_px: u32) -> Result<Vec<u8>, PictureError> {
        self.pixmap(width_px)?.encode_png().map_err(failed)
    }

    /// Returns the largest picture width at which both the width and the height are at most
    /// `side_px` pixels. The result is never less than the minimum picture width.
    ///
    /// ```
    /// use mmsim_drawing::Scene;
    /// let maze: mmsim_maze::Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
    /// assert_eq!(Scene::from_maze(&maze).width_within(640), 640, "it is 44 by 24 units large");
    /// # Ok::<(), mmsim_maze::ParseMazeError>(())
    /// ```
    pub fn width_within(&self, side_px: u32) -> u32 {
        let (width, height) = self.extent();
        let side_px = side_px.min(MAX_HEIGHT_PX);
        let width = if width < height { side_px * width / height } else { side_px };
        width.clamp(*WIDTH_PX.start(), *WIDTH_PX.end())
    }

    /// Draws the scene as opaque pixels.
    pub(crate) fn pixmap(&self, width_px: u32) -> Result<Pixmap, PictureError> {
        let pixmap = self.blank(width_px)?;
        paint(&Svg::draw(self, View::Pixels { width_px }), pixmap)
    }

    /// Creates an empty picture of this width in pixels.
    pub(crate) fn blank(&self, width_px: u32) -> Result<Pixmap, PictureError> {
        let (width, height) = (width_px, height_px(self.extent(), width_px));
        let size_error = PictureError::Size { width, height };
        let height = u32::try_from(height).ok().filter(|&height| height <= MAX_HEIGHT_PX);
        let Some(height) = height.filter(|_| WIDTH_PX.contains(&width)) else {
            return Err(size_error);
        };
        Pixmap::new(width, height).ok_or(size_error)
    }
}

/// Returns the colour of a pixel, which must be opaque.
pub(crate) fn rgb(pixel: PremultipliedColorU8) -> Rgb {
    Rgb(pixel.red(), pixel.green(), pixel.blue())
}

/// Draws an SVG, scaled to the size of the picture.
pub(crate) fn paint(drawing: &str, mut pixmap: Pixmap) -> Result<Pixmap, PictureError> {
    let tree = Tree::from_str(drawing, &Options::default()).map_err(failed)?;
    #[expect(clippy::cast_precision_loss, reason = "at most 4096")]
    let scale = Transform::from_scale(
        pixmap.width() as f32 / tree.size().width(),
        pixmap.height() as f32 / tree.size().height(),
    );
    resvg::render(&tree, scale, &mut pixmap.as_mut());
    Ok(pixmap)
}

pub(crate) fn failed(error: impl std::fmt::Display) -> PictureError {
    PictureError::Drawing(error.to_string())
}

/// Returns the height in pixels of a picture of this width and this extent in units.
fn height_px((width, height): (u32, u32), width_px: u32) -> u64 {
    let (width, height) = (u64::from(width), u64::from(height));
    ((u64::from(width_px) * height + width / 2) / width).max(1)
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, Colour, Heading, KnownMaze, Maze, Pose, WallState, Walls};

    use super::*;
    use crate::scene::Layers;
    use crate::shapes::{AGES, centre, units};
    use crate::style::colour::Theme;
    use crate::style::colour::contrast;
    use crate::style::data_colours::{cell_colour, heat_ramp};

    fn maze() -> Maze {
        "o---o---o\n|     G |\no   o---o\n| S     |\no---o---o\n".parse().unwrap()
    }

    /// Draws the scene with 3 pixels per unit and returns the colour at a point given in units.
    fn at(scene: &Scene<'_>, x: u32, y: u32) -> Rgb {
        let pixmap = scene.pixmap(3 * units(scene.size).0).unwrap();
        let (x, y) = (3 * (x + 2) + 1, 3 * (y + 2) + 1);
        rgb(pixmap.pixel(x, y).unwrap())
    }

    #[test]
    fn a_png_has_the_requested_size() {
        let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let png = Scene::from_maze(&maze).png(440).unwrap();
        let pixmap = Pixmap::decode_png(&png).unwrap();
        assert_eq!((pixmap.width(), pixmap.height()), (440, 240));
        assert!(pixmap.pixels().iter().all(|pixel| pixel.alpha() == 255), "opaque");
    }

    #[test]
    fn pixels_have_the_colours_of_the_theme() {
        let maze = maze();
        let mut map = KnownMaze::unexplored(&maze);
        map.visit(Cell::new(0, 1));
        map.set_wall(Cell::new(0, 1), Heading::East, WallState::Present);
        for theme in [Theme::Light, Theme::Dark] {
            let colours = theme.colours();
            let scene = Scene::from_map(&map).with_truth(Some(&maze)).with_theme(theme);
            assert_eq!(at(&scene, 30, 39), colours.wall, "{theme:?}: an outer wall");
            assert_eq!(at(&scene, 20, 3), colours.mistaken, "{theme:?}");
            assert_eq!(at(&scene, 30, 30), colours.floor, "{theme:?}");
            assert_eq!(at(&scene, 10, 10), colours.visited, "{theme:?}");
            assert_eq!(at(&scene, 10, 30), colours.start.floor, "{theme:?}");
            assert_eq!(at(&scene, 30, 10), colours.goal.floor, "{theme:?}");
            assert!(at(&scene, 30, 20) != colours.wall, "{theme:?}: unknown to the mouse");
            assert_eq!(at(&Scene::from_maze(&maze).with_theme(theme), 30, 20), colours.wall);
            let heat = scene.with_weights(|cell| cell.x + cell.y).with_layers(Layers {
                numbers: false,
                trail: false,
                ..Layers::ALL
            });
            assert_eq!(at(&heat, 15, 30), heat_ramp(theme)[0]);
            assert_eq!(at(&heat, 35, 10), heat_ramp(theme)[63]);
        }
    }

    /// Returns the maximum contrast and the sum of the contrasts of the pixels between the middle of a
    /// cell and the middle of its eastern neighbour.
    fn across(scene: &Scene<'_>, pixmap: &Pixmap, cell: Cell) -> (f64, f64) {
        let pixel = |units| (units + 2) * pixmap.width() / crate::shapes::units(scene.size).0;
        let east = Cell::new(cell.x + 1, cell.y);
        let [(west, y), (east, _)] = [cell, east].map(|cell| centre(scene.size, cell));
        let pixels = (pixel(west)..=pixel(east)).map(|x| rgb(pixmap.pixel(x, pixel(y)).unwrap()));
        let pixels: Vec<Rgb> = pixels.collect();
        let contrasts = pixels.iter().map(|&pixel| contrast(pixel, pixels[0]));
        let ink = contrasts.clone().map(|contrast| contrast - 1.0).sum();
        (contrasts.fold(1.0, f64::max), ink)
    }

    #[test]
    fn unknown_walls_are_visible_but_thin() {
        let largest = MazeSize::new(32, 32).unwrap();
        let gif_px = 480;
        for (size, width_px) in [(MazeSize::CLASSIC, 640), (largest, 640), (largest, gif_px)] {
            let cells = |from: u8| (from..from + 8).step_by(2).map(|x| Cell::new(x, 3));
            let mut walls = Walls::open(size);
            cells(0).chain(cells(8)).for_each(|cell| walls.set(cell, Heading::East, true));
            let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
            let mut map = KnownMaze::unexplored(&maze);
            cells(8).for_each(|cell| map.set_wall(cell, Heading::East, WallState::Present));
            for is_visited in [false, true] {
                if is_visited {
                    (0..16).for_each(|x| map.visit(Cell::new(x, 3)));
                }
                for theme in [Theme::Light, Theme::Dark] {
                    let scene = Scene::from_map(&map).with_truth(Some(&maze)).with_theme(theme);
                    let pixmap = scene.pixmap(width_px).unwrap();
                    for (unknown, known) in cells(0).zip(cells(8)) {
                        let [(unknown, thin), (known, thick)] =
                            [unknown, known].map(|cell| across(&scene, &pixmap, cell));
                        assert!(unknown >= 3.0 && known > 1.5 * unknown, "{unknown} {known}");
                        assert!(thick > 2.0 * thin, "{theme:?} {width_px} {thin} {thick}");
                    }
                }
            }
        }
    }

    #[test]
    fn walls_are_on_floor_in_a_heat_map() {
        let maze = maze();
        let map = KnownMaze::unexplored(&maze);
        for theme in [Theme::Light, Theme::Dark] {
            let layers = Layers { numbers: false, ..Layers::ALL };
            let scene = Scene::from_map(&map).with_truth(Some(&maze)).with_theme(theme);
            let scene = scene.with_weights(|cell| 9 + cell.x).with_layers(layers);
            // The wall between the south-eastern cell and the goal.
            assert_ne!(at(&scene, 30, 20), theme.colours().floor, "{theme:?}");
            assert_eq!(at(&scene, 30, 21), theme.colours().floor, "{theme:?}");
            assert_eq!(at(&scene, 30, 23), heat_ramp(theme)[63], "{theme:?}");
        }
    }

    #[test]
    fn the_trail_is_faint_behind_numbers() {
        let maze = maze();
        let trail = [(0, 0, Heading::North), (0, 1, Heading::East)]
            .map(|(x, y, heading)| Pose::new(Cell::new(x, y), heading));
        for theme in [Theme::Light, Theme::Dark] {
            let scene = Scene::from_maze(&maze).with_trail(&trail).with_theme(theme);
            let newest = theme.colours().trail(AGES - 1);
            let at = |numbers, x, y| {
                let layers = Layers { numbers, ..Layers::ALL };
                at(&scene.clone().with_layers(layers), x, y)
            };
            assert_eq!([at(true, 9, 18), at(false, 9, 18)], [newest; 2], "between two cells");
            assert_eq!(at(false, 9, 13), newest, "without numbers");
            let behind = contrast(at(true, 9, 13), theme.colours().floor);
            assert!(1.0 < behind && behind < 1.6, "{theme:?} {behind}");
        }
    }

    #[test]
    fn layers_can_be_hidden() {
        let maze = maze();
        let trail = [Pose::new(Cell::new(0, 0), Heading::North)];
        let scene = Scene::from_maze(&maze).with_weights(|_| 1).with_trail(&trail);
        let scene = scene.with_texts(|cell| if cell.x == 0 { "a" } else { "" });
        let scene = scene.with_colours(|cell| Some(Colour::Green).filter(|_| cell.y == 0));
        let all = Layers::ALL;
        let pixels = |layers| scene.clone().with_layers(layers).pixmap(220).unwrap();
        assert!(pixels(all) != pixels(Layers { numbers: false, ..all }));
        assert!(pixels(all) != pixels(Layers { heat: false, ..all }));
        assert!(pixels(all) != pixels(Layers { trail: false, ..all }));
        assert!(pixels(all) != pixels(Layers { texts: false, ..all }));
        assert!(pixels(all) != pixels(Layers { colours: false, ..all }));
    }

    #[test]
    fn the_svg_file_renders_like_the_png() {
        let maze = maze();
        let map = KnownMaze::unexplored(&maze);
        let trail = [Pose::new(Cell::new(0, 0), Heading::North)];
        let few = Layers { numbers: false, heat: false, trail: false, ..Layers::ALL };
        for layers in [Layers::ALL, few] {
            let scene = Scene::from_map(&map).with_truth(Some(&maze)).with_layers(layers);
            let scene = scene.with_weights(|cell| cell.x).with_trail(&trail);
            let file = paint(&scene.svg(), scene.blank(220).unwrap()).unwrap();
            assert!(file == scene.pixmap(220).unwrap(), "{layers:?}");
        }
    }

    #[test]
    fn texts_are_legible_on_every_colour() {
        let maze = maze();
        let cell = Cell::new(0, 1);
        for theme in [Theme::Light, Theme::Dark] {
            for colour in Colour::ALL {
                let scene = Scene::from_maze(&maze)
                    .with_colours(|at| (at == cell).then_some(colour))
                    .with_texts(|at| if at == cell { "l" } else { "" })
                    .with_theme(theme);
                let beside = at(&scene, 14, 10);
                assert_eq!(beside, cell_colour(colour), "{theme:?} {colour:?}");
                // The pixels across the stem of the letter, with 3 pixels per unit.
                let pixmap = scene.pixmap(3 * units(scene.size).0).unwrap();
                let stem = (30..42).map(|x| rgb(pixmap.pixel(x, 36).unwrap()));
                let contrast = stem.map(|pixel| contrast(pixel, beside)).fold(1.0, f64::max);
                assert!(contrast >= 4.5, "{theme:?} {colour:?}: {contrast}");
                // The floor between the colour and the walls.
                assert_eq!(at(&scene, 10, 1), theme.colours().floor);
            }
        }
    }

    #[test]
    fn sizes_are_bounded() {
        let tall = Maze::new(
            Walls::open(MazeSize::new(1, 32).unwrap()),
            Cell::new(0, 0),
            [Cell::new(0, 31)].into_iter().collect(),
        );
        let tall = tall.unwrap();
        let scene = Scene::from_maze(&tall);
        assert_eq!(
            scene.png(640).unwrap_err().to_string(),
            "cannot draw a picture of 640x17173 pixels: the width must be 16 to 4096 and the height at most 4096"
        );
        assert_eq!(scene.png(15).unwrap_err(), PictureError::Size { width: 15, height: 403 });
        assert!(scene.png(u32::MAX).is_err());
        assert_eq!(scene.width_within(640), 23);
        assert_eq!(scene.width_within(u32::MAX), 152, "the maximum height");
        assert!(scene.png(scene.width_within(u32::MAX)).is_ok());
    }
}
