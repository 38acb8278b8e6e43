//! Pictures of mazes and of the maps that mice build, as SVG (for web pages, files and thumbnails),
//! PNG and animated GIF.
//!
//! ```text
//!   -2,-2 ┌───────────────► x     a cell is 20 units wide, and north is on top: cell (x, y) begins
//!         │ o────o────o           at 20·x, 20·(height − 1 − y). Walls are 2 units wide, centred on
//!         │ │    │    │           the lines between cells. Around the maze is a margin of 2 units.
//!         │ o────o────o
//!       y ▼                       For a 16×16 maze the viewBox is `-2 -2 324 324`.
//! ```
//!
//! A [`Scene`] describes a picture: a maze or a client's map, and optionally the mouse, numbers in
//! the cells, the trail, and curves that mice drive. Every scene is first drawn as SVG. PNG files and the frames of an
//! [`Animation`] are rasterized from that SVG, so all formats look alike.
//!
//! [`thumbnail`] and [`two_paths`] draw small pictures of a maze.
//!
//! The elements of an SVG have classes (see [`Scene::page_svg`]). In a page, the [`stylesheet`]
//! sets the colours of the classes. An SVG file contains its own styles. Numbers and
//! texts are drawn as strokes ([`digits`]), so no font is needed.
//!
//! ```
//! use mmsim_drawing::{Scene, Theme};
//! use mmsim_maze::{KnownMaze, Maze};
//!
//! let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
//! let map = KnownMaze::unexplored(&maze);
//! let scene = Scene::from_map(&map)
//!     .with_truth(Some(&maze))
//!     .with_mouse(maze.start())
//!     .with_weights(|cell| 1 - cell.x)
//!     .with_theme(Theme::Dark);
//! assert!(scene.svg().starts_with("<svg "));
//! # Ok::<(), mmsim_maze::ParseMazeError>(())
//! ```
//!
//! The crate performs no I/O and depends on neither the protocol nor the file formats.
//!
//! ```text
//! raster/    pixels: PNG, canvas, palette and animated GIF, drawn from the SVG
//! svg/       the SVG of a scene, and its legend
//! scene/     what a picture contains
//! style/     themes, colours and the stylesheet
//! page       tables for scripts of a page that draw the same
//! thumbnail  small pictures, without styles
//! shapes     the positions of cells, and the shapes of marks, mice and trails
//! text       numbers and texts as lines
//! ```
#![forbid(unsafe_code)]

mod page;
mod raster;
mod scene;
mod shapes;
mod style;
mod svg;
mod text;
mod thumbnail;

pub use page::page_json;
pub use raster::animation::{Animation, FRAME_MS, MAX_FRAMES, frame_indices, frame_times};
pub use raster::{MAX_HEIGHT_PX, PictureError, WIDTH_PX};
pub use scene::driven_path::{DrivenPath, PathPoint};
pub use scene::{Layers, Scene};
pub use style::colour::Theme;
pub use style::data_colours::MAX_PATHS;
pub use style::stylesheet;
pub use text::{digits, weight};
pub use thumbnail::{PATH_COLOURS, thumbnail, two_paths};

/// Runs the code in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
