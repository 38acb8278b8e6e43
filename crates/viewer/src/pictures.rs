//! Pictures of mazes and moments: those of the page, and those to keep.

use mmsim_drawing::{
    Animation, FRAME_MS, Layers, MAX_FRAMES, PictureError, Scene, Theme, frame_indices,
};
use mmsim_maze::Cell;
use serde::Deserialize;

use crate::api_error::ApiError;
use crate::source::Source;
use crate::state_view;
use crate::work::CancelToken;

/// The longer side of a PNG and of a GIF, in pixels.
const PNG_SIDE_PX: u32 = 1280;
const GIF_SIDE_PX: u32 = 480;

/// How a picture to keep shall look.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default)]
pub(crate) struct Look {
    numbers: bool,
    heat: bool,
    trail: bool,
    theme: LightOrDark,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum LightOrDark {
    #[default]
    Light,
    Dark,
}

impl Default for Look {
    fn default() -> Self {
        let Layers { numbers, heat, trail } = Layers::default();
        Self { numbers, heat, trail, theme: LightOrDark::default() }
    }
}

impl Look {
    fn of(self, scene: Scene<'_>) -> Scene<'_> {
        let Self { numbers, heat, trail, theme } = self;
        scene.with_layers(Layers { numbers, heat, trail }).with_theme(match theme {
            LightOrDark::Light => Theme::Light,
            LightOrDark::Dark => Theme::Dark,
        })
    }
}

/// The maze before the first state, on which the page draws.
pub(crate) fn before(source: &Source, run: u32) -> Result<String, ApiError> {
    let described = source.describe(run)?;
    let scene = match &described.truth {
        Some(maze) => Scene::from_maze(maze),
        None => Scene::from_map(&described.unknown),
    };
    Ok(scene.page_svg())
}

/// The picture of a state as PNG.
pub(crate) fn png(
    source: &Source,
    run: u32,
    index: usize,
    look: Look,
) -> Result<Vec<u8>, ApiError> {
    at(source, run, index, look, |scene| scene.png(scene.width_within(PNG_SIDE_PX)))?
        .map_err(ApiError::failed)
}

/// A run as an animated GIF.
pub(crate) fn gif(
    source: &Source,
    run: u32,
    look: Look,
    wanted: &CancelToken,
) -> Result<Vec<u8>, ApiError> {
    let states = source.states(run)?;
    if states == 0 {
        return Err(ApiError::conflict("expected a search, found no state yet"));
    }
    let mut animation = None;
    for index in frame_indices(states, MAX_FRAMES) {
        wanted.check()?;
        at(source, run, index, look, |scene| {
            let width = scene.width_within(GIF_SIDE_PX);
            animation.get_or_insert_with(|| Animation::new(width)).push(&scene, FRAME_MS)
        })?
        .map_err(ApiError::failed)?;
    }
    animation.map_or(Err(PictureError::NoFrame), Animation::finish).map_err(ApiError::failed)
}

/// Shows a state of a run to `draw`, or the maze if there is no state yet.
pub(crate) fn at<T>(
    source: &Source,
    run: u32,
    at: usize,
    look: Look,
    draw: impl FnOnce(Scene<'_>) -> T,
) -> Result<T, ApiError> {
    let described = source.describe(run)?;
    if source.states(run)? == 0 {
        let scene = Scene::from_map(&described.unknown).with_truth(described.truth.as_ref());
        return Ok(draw(look.of(scene)));
    }
    let states = source.around(run, at)?;
    let message = states.get(at).ok_or_else(|| ApiError::failed("expected a state"))?;
    let (state, map) = described.read(message)?;
    let trail: Vec<Cell> =
        state_view::cells(source, run, at)?.into_iter().map(|[x, y]| Cell::new(x, y)).collect();
    let scene = Scene::from_map(&map)
        .with_truth(described.truth.as_ref())
        .with_mouse(state.pose())
        .with_weights(|cell| state.weights().at(cell).unwrap_or(0))
        .with_trail(&trail);
    Ok(draw(look.of(scene)))
}
