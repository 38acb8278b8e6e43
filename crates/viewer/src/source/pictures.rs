//! Pictures of mazes and states, for the page and for download.

use axum::body::Body;
use axum::extract::Query;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use mmsim_drawing::{
    Animation, FRAME_MS, Layers, MAX_FRAMES, PictureError, Scene, Theme, frame_indices,
};
use mmsim_run::{planned_path, shortest_path};
use serde::Deserialize;

use crate::http::jobs::{ApiError, ApiResult, CancelToken};
use crate::http::requested_run::RequestedRun;
use crate::source::{DecodedState, StateSource};

/// The length of the longer side of a PNG, in pixels.
const PNG_SIDE_PX: u32 = 1280;

/// The length of the longer side of a GIF, in pixels.
const GIF_SIDE_PX: u32 = 480;

/// The options of a downloaded picture.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default)]
pub(crate) struct PictureOptions {
    numbers: bool,
    heat: bool,
    trail: bool,
    texts: bool,
    colours: bool,
    /// True to draw the shortest path of the true maze.
    shortest: bool,
    /// True to draw the path that the mouse plans to take.
    plan: bool,
    #[serde(with = "ThemeName")]
    theme: Theme,
}

#[derive(Deserialize)]
#[serde(remote = "Theme", rename_all = "lowercase")]
enum ThemeName {
    Light,
    Dark,
}

impl Default for PictureOptions {
    fn default() -> Self {
        let Layers { numbers, heat, trail, texts, colours } = Layers::default();
        let theme = Theme::default();
        Self { numbers, heat, trail, texts, colours, shortest: false, plan: false, theme }
    }
}

impl PictureOptions {
    fn apply(self, scene: Scene<'_>) -> Scene<'_> {
        let Self { numbers, heat, trail, texts, colours, theme, .. } = self;
        scene.with_layers(Layers { numbers, heat, trail, texts, colours }).with_theme(theme)
    }
}

/// Draws the initial SVG of a run, which the page updates for each state.
pub(crate) fn page_svg(source: &StateSource, run: u32) -> ApiResult<String> {
    let description = source.describe(run)?;
    let scene = match &description.truth {
        Some(maze) => Scene::from_maze(maze),
        None => Scene::from_map(&description.unexplored),
    };
    Ok(scene.page_svg())
}

/// Draws a scene as a PNG.
pub(crate) fn png(scene: &Scene<'_>) -> ApiResult<Vec<u8>> {
    scene.png(scene.width_within(PNG_SIDE_PX)).map_err(ApiError::internal)
}

/// Draws a run as an animated GIF.
pub(crate) fn gif(
    source: &StateSource,
    run: u32,
    options: PictureOptions,
    cancel: &CancelToken,
) -> ApiResult<Vec<u8>> {
    let states = source.states(run)?;
    if states == 0 {
        return Err(ApiError::conflict("cannot animate the run: it has no states yet"));
    }
    let mut animation: Option<Animation> = None;
    for index in frame_indices(states, MAX_FRAMES) {
        cancel.check()?;
        draw_state(source, run, index, options, cancel, |scene| {
            let width = scene.width_within(GIF_SIDE_PX);
            animation.get_or_insert_with(|| Animation::new(width)).push(&scene, FRAME_MS)
        })?
        .map_err(ApiError::internal)?;
    }
    animation.map_or(Err(PictureError::NoFrame), Animation::finish).map_err(ApiError::internal)
}

/// Calls `draw` with the scene of a state. If the run has no states yet, the scene shows the
/// unexplored maze.
pub(crate) fn draw_state<T>(
    source: &StateSource,
    run: u32,
    index: usize,
    options: PictureOptions,
    cancel: &CancelToken,
    draw: impl FnOnce(Scene<'_>) -> T,
) -> ApiResult<T> {
    let description = source.describe(run)?;
    let shortest = |is_trial| {
        let truth = description.truth.as_ref().filter(|_| options.shortest);
        truth.map_or_else(Vec::new, |maze| shortest_path(maze, is_trial))
    };
    if source.states(run)? == 0 {
        let scene = Scene::from_map(&description.unexplored)
            .with_truth(description.truth.as_ref())
            .with_shortest_path(shortest(false));
        return Ok(draw(options.apply(scene)));
    }
    let states = source.block(run, index)?;
    let trailing = source.trailing(run, index)?;
    let DecodedState { state, map, context, is_trial, .. } =
        description.decode(&states, index, &trailing)?;
    let (notes, (_, trail)) = (context.notes(), source.run_to(run, index, cancel)?);
    let passages = trail.passages();
    let plan = || planned_path(&map, state.pose(), |cell| state.weights().at(cell));
    let scene = Scene::from_map(&map)
        .with_truth(description.truth.as_ref())
        .with_mouse(state.pose())
        .with_weights(|cell| state.weights().at(cell).unwrap_or(0))
        .with_texts(|cell| notes.text(cell))
        .with_colours(|cell| notes.colour(cell))
        .with_trail(&passages)
        .with_shortest_path(shortest(is_trial))
        .with_planned_path(options.plan.then(plan).unwrap_or_default());
    Ok(draw(options.apply(scene)))
}

#[derive(Deserialize)]
pub(crate) struct PictureQuery {
    /// The index of the state.
    #[serde(default)]
    at: usize,
}

/// Responds with the picture of a state, as a file that `draw` creates.
pub(crate) async fn picture<T: Into<Body> + 'static>(
    RequestedRun { state, source, run }: RequestedRun,
    Query(PictureQuery { at }): Query<PictureQuery>,
    Query(options): Query<PictureOptions>,
    (extension, media_type): (&'static str, &'static str),
    draw: fn(&Scene<'_>) -> ApiResult<T>,
) -> ApiResult<Response> {
    let draw = move |cancel: &CancelToken| {
        let picture = draw_state(&source, run, at, options, cancel, |scene| draw(&scene))??;
        download(&source, run, extension, media_type, picture)
    };
    state.pictures.run(draw).await
}

/// Returns a response that browsers save as a file.
pub(crate) fn download(
    source: &StateSource,
    run: u32,
    extension: &str,
    media_type: &'static str,
    content: impl Into<Body>,
) -> ApiResult<Response> {
    let title = source.describe(run)?.title.clone();
    let stem = title.strip_suffix(".mcap").unwrap_or(&title);
    let sanitize = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = stem.chars().map(sanitize).take(100).collect();
    let disposition = format!("attachment; filename=\"{name}.{extension}\"");
    let headers = [(header::CONTENT_TYPE, media_type), (header::CONTENT_DISPOSITION, &disposition)];
    Ok((headers, content.into()).into_response())
}
