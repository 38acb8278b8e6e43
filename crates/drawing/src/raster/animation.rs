//! Animated GIFs.

use std::borrow::Cow;

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use resvg::tiny_skia::Pixmap;

use crate::raster::canvas::Canvas;
use crate::raster::palette::Palette;
use crate::raster::{PictureError, failed, rgb};
use crate::scene::Scene;

/// The minimum display time of the last frame, in milliseconds.
const LAST_MS: u32 = 2500;

/// The maximum number of frames in the animation of a search or of fast runs. The limit keeps the file
/// small.
pub const MAX_FRAMES: usize = 400;

/// The display time of each frame in the animation of a search, in milliseconds.
pub const FRAME_MS: u32 = 60;

/// A builder for an animated GIF that repeats forever and shows its last frame for at least 2.5
/// seconds.
///
/// All frames share one palette, chosen for the theme and the layers of the first frame. To keep
/// the file small, each frame stores only the rectangle that changed.
///
/// ```
/// use mmsim_drawing::{Animation, Scene};
/// use mmsim_maze::{Cell, Heading, KnownMaze, Maze, Pose};
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let map = KnownMaze::unexplored(&maze);
/// let mut animation = Animation::new(220);
/// for x in 0..2 {
///     let pose = Pose::new(Cell::new(x, 0), Heading::East);
///     animation.push(&Scene::from_map(&map).with_truth(Some(&maze)).with_mouse(pose), 200)?;
/// }
/// assert!(animation.finish()?.starts_with(b"GIF89a"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Animation {
    width_px: u32,
    begun: Option<Begun>,
}

/// The state of an animation after its first frame has been added.
struct Begun {
    palette: Palette,
    encoder: Encoder<Vec<u8>>,
    canvas: Canvas,
    /// The newest frame and its display time in milliseconds. The frame is not yet written, because
    /// its display time depends on whether another frame follows.
    last: Option<(Frame<'static>, u32)>,
}

impl std::fmt::Debug for Animation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Animation").field("width_px", &self.width_px).finish_non_exhaustive()
    }
}

impl Animation {
    /// Creates an animation that is `width_px` pixels wide. The height follows from the maze size.
    pub const fn new(width_px: u32) -> Self {
        Self { width_px, begun: None }
    }

    /// Adds a frame that is shown for `delay_ms` milliseconds. The display time is rounded up to a
    /// hundredth of a second, the time unit of GIF, and is at least 20 ms, the minimum that
    /// browsers support.
    ///
    /// # Errors
    /// Returns an error if the width is out of range (see [`Scene::png`]) or if the maze
    /// differs in size from the one in the first frame, or if the legend does.
    pub fn push(&mut self, scene: &Scene<'_>, delay_ms: u32) -> Result<(), PictureError> {
        let Some(begun) = &mut self.begun else {
            self.begun = Some(Begun::new(scene, self.width_px, delay_ms)?);
            return Ok(());
        };
        let shown = begun.canvas.pixmap().clone();
        begun.canvas.show(scene)?;
        let frame = begun.change(&shown);
        begun.write_last(0)?;
        begun.last = Some((frame, delay_ms));
        Ok(())
    }

    /// Returns the GIF file.
    ///
    /// # Errors
    /// Returns an error if the animation has no frame.
    pub fn finish(self) -> Result<Vec<u8>, PictureError> {
        let mut begun = self.begun.ok_or(PictureError::NoFrame)?;
        begun.write_last(LAST_MS)?;
        begun.encoder.into_inner().map_err(failed)
    }
}

impl Begun {
    fn new(scene: &Scene<'_>, width_px: u32, delay_ms: u32) -> Result<Self, PictureError> {
        let canvas = Canvas::new(scene, width_px)?;
        let mut palette = Palette::like(scene, width_px)?;
        let pixmap = canvas.pixmap();
        let (width, height) = (px(pixmap.width() as usize), px(pixmap.height() as usize));
        let mut encoder =
            Encoder::new(Vec::new(), width, height, &palette.bytes()).map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        let pixels = pixmap.pixels().iter().map(|&pixel| palette.index(rgb(pixel))).collect();
        let frame = frame((0, 0), (width, height), pixels);
        Ok(Self { palette, encoder, canvas, last: Some((frame, delay_ms)) })
    }

    /// Returns a frame that turns the picture `shown` into the picture on the canvas.
    fn change(&mut self, shown: &Pixmap) -> Frame<'static> {
        let (old, new) = (shown.pixels(), self.canvas.pixmap().pixels());
        let width = shown.width() as usize;
        let rows = || old.chunks(width).zip(new.chunks(width));
        let is_other = |(old, new): (&[_], &[_])| old != new;
        let (Some(top), Some(bottom)) = (rows().position(is_other), rows().rposition(is_other))
        else {
            return frame((0, 0), (1, 1), vec![Palette::UNCHANGED]);
        };
        let columns = || rows().map(|(old, new)| old.iter().zip(new).map(|(old, new)| old != new));
        let left = columns().filter_map(|mut row| row.position(|is| is)).min().unwrap_or(0);
        let right = columns().filter_map(|mut row| row.rposition(|is| is)).max().unwrap_or(left);
        let pixels = (top..=bottom)
            .flat_map(|y| y * width + left..=y * width + right)
            .map(|pixel| {
                let is_same = new[pixel] == old[pixel];
                if is_same { Palette::UNCHANGED } else { self.palette.index(rgb(new[pixel])) }
            })
            .collect();
        frame((px(left), px(top)), (px(right - left + 1), px(bottom - top + 1)), pixels)
    }

    fn write_last(&mut self, least_ms: u32) -> Result<(), PictureError> {
        let Some((mut frame, delay_ms)) = self.last.take() else { return Ok(()) };
        frame.delay = u16::try_from(delay_ms.max(least_ms).div_ceil(10)).unwrap_or(u16::MAX).max(2);
        self.encoder.write_frame(&frame).map_err(failed)
    }
}

fn frame((left, top): (u16, u16), (width, height): (u16, u16), pixels: Vec<u8>) -> Frame<'static> {
    Frame {
        left,
        top,
        width,
        height,
        dispose: DisposalMethod::Keep,
        transparent: Some(Palette::UNCHANGED),
        buffer: Cow::Owned(pixels),
        ..Frame::default()
    }
}

fn px(pixels: usize) -> u16 {
    u16::try_from(pixels).unwrap_or(u16::MAX)
}

/// Returns the times in s of the frames of an animation in real time, and the display time of each
/// frame in milliseconds: 40 ms, or more if the animation would have more than [`MAX_FRAMES`]
/// frames. The last time is the duration.
///
/// ```
/// use mmsim_drawing::frame_times;
/// let (times, frame_ms) = frame_times(0.1);
/// assert_eq!((times.collect::<Vec<_>>(), frame_ms), (vec![0.0, 0.04, 0.08, 0.1], 40));
/// let (times, frame_ms) = frame_times(60.0);
/// assert_eq!((times.count(), frame_ms), (376, 160));
/// ```
pub fn frame_times(duration: f64) -> (impl Iterator<Item = f64>, u32) {
    let duration = duration.clamp(0.0, 3600.0);
    let frames = (1_u32..).map(|hundredths| 10 * hundredths).skip(3);
    let count = |frame_ms: u32| duration * 1000.0 / f64::from(frame_ms);
    #[expect(clippy::cast_precision_loss, reason = "small")]
    let frame_ms = frames.take(1000).find(|&frame_ms| count(frame_ms) < (MAX_FRAMES - 1) as f64);
    let frame_ms = frame_ms.unwrap_or(10_000);
    let times = (0_u32..).map(move |frame| f64::from(frame * frame_ms) / 1000.0);
    // Rounding must not repeat the last frame.
    (times.take_while(move |&time| time < duration - 1e-6).chain([duration]), frame_ms)
}

/// Returns the indices of the states to show in an animation of a search with `states` states: at
/// most `max_frames` evenly spaced states, including the last one and, if `max_frames` is at least
/// 2, the first one.
///
/// ```
/// use mmsim_drawing::frame_indices;
/// assert_eq!(frame_indices(3, 400).collect::<Vec<_>>(), [0, 1, 2]);
/// assert_eq!(frame_indices(1001, 5).collect::<Vec<_>>(), [0, 250, 500, 750, 1000]);
/// assert_eq!(frame_indices(1001, 1).collect::<Vec<_>>(), [1000]);
/// ```
pub fn frame_indices(states: usize, max_frames: usize) -> impl ExactSizeIterator<Item = usize> {
    let frames = states.min(max_frames);
    (0..frames).map(move |frame| {
        // Counted from the end, so that a single frame shows the last state.
        let back = frames - 1 - frame;
        states - 1 - back * (states - 1) / (frames - 1).max(1)
    })
}

#[cfg(test)]
mod tests {
    use gif::{ColorOutput, DecodeOptions};
    use mmsim_maze::{Cell, Heading, KnownMaze, Maze, Pose, Step};

    use super::*;
    use crate::scene::Layers;
    use crate::style::colour::Theme;

    /// Decodes a GIF. Returns the final picture, and each frame's display time in hundredths of a
    /// second.
    fn played(gif: &[u8]) -> (Pixmap, Vec<u16>) {
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::RGBA);
        let mut decoder = options.read_info(gif).unwrap();
        assert_eq!(decoder.repeat(), Repeat::Infinite);
        let (width, height) = (decoder.width(), decoder.height());
        let mut pixmap = Pixmap::new(width.into(), height.into()).unwrap();
        let mut delays = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            delays.push(frame.delay);
            for (index, colour) in frame.buffer.chunks(4).enumerate() {
                let (x, y) = (index % usize::from(frame.width), index / usize::from(frame.width));
                let (x, y) = (x + usize::from(frame.left), y + usize::from(frame.top));
                let at = 4 * (y * usize::from(width) + x);
                if colour[3] != 0 {
                    pixmap.data_mut()[at..at + 4].copy_from_slice(colour);
                }
            }
        }
        (pixmap, delays)
    }

    fn maze() -> Maze {
        "\
o---o---o---o
|       | G |
o   o---o   o
| S         |
o---o---o---o
"
        .parse()
        .unwrap()
    }

    #[test]
    fn the_last_frame_is_the_last_scene() {
        let maze = maze();
        for (theme, heat) in [(Theme::Light, false), (Theme::Dark, true)] {
            let mut map = KnownMaze::unexplored(&maze);
            let mut pose = Pose::new(Cell::new(0, 0), Heading::North);
            let mut trail = Vec::new();
            let mut animation = Animation::new(384);
            let mut last = None;
            for step in [Step::Right, Step::Front, Step::Left, Step::Back, Step::Right] {
                map.observe(pose, maze.walls().around(pose)).unwrap();
                let left = pose.cell;
                pose = pose.after(step).unwrap();
                trail.push(Pose::new(left, pose.heading));
                let scene = Scene::from_map(&map)
                    .with_truth(Some(&maze))
                    .with_mouse(pose)
                    .with_weights(|cell| 40 * cell.x + cell.y + step as u8)
                    .with_trail(&trail)
                    .with_theme(theme)
                    .with_layers(Layers { heat, ..Layers::ALL });
                animation.push(&scene, 45).unwrap();
                last = Some(scene.pixmap(384).unwrap());
            }
            let (shown, delays) = played(&animation.finish().unwrap());
            assert_eq!(delays, [5, 5, 5, 5, 250]);
            let last = last.unwrap();
            let differences = shown.data().iter().zip(last.data()).map(|(a, b)| a.abs_diff(*b));
            assert!(differences.clone().max().unwrap() <= 40, "a blend that the palette lacks");
            let total: u64 = differences.map(u64::from).sum();
            assert!(total < last.data().len() as u64 / 4, "{total} of {}", last.data().len());
        }
    }

    #[test]
    fn an_unchanged_scene_still_adds_a_frame() {
        let maze = maze();
        let mut animation = Animation::new(100);
        for _ in 0..3 {
            animation.push(&Scene::from_maze(&maze), 0).unwrap();
        }
        assert_eq!(played(&animation.finish().unwrap()).1, [2, 2, 250]);
    }

    #[test]
    fn an_animation_needs_a_frame_and_one_size() {
        let other: Maze = "o---o---o\n| S   G |\no---o---o\n".parse().unwrap();
        let maze = maze();
        let mut animation = Animation::new(100);
        animation.push(&Scene::from_maze(&maze), 100).unwrap();
        let error = animation.push(&Scene::from_maze(&other), 100).unwrap_err().to_string();
        assert_eq!(error, "cannot add a frame of 2x1 cells to an animation of 3x2 cells");
        assert_eq!(Animation::new(100).finish().unwrap_err(), PictureError::NoFrame);
        assert!(Animation::new(8).push(&Scene::from_maze(&maze), 100).is_err());
    }

    #[test]
    fn a_race_ends_like_a_picture_of_its_end() {
        use crate::scene::driven_path::path;
        let maze = maze();
        for (theme, names) in [(Theme::Light, &["a"][..]), (Theme::Dark, &["a", "b", "c"])] {
            let paths: Vec<_> = names.iter().map(|name| path(name)).collect();
            let scene = Scene::from_maze(&maze).with_paths(&paths).with_theme(theme);
            let (times, frame_ms) = frame_times(scene.duration());
            let mut animation = Animation::new(400);
            for time in times {
                animation.push(&scene.clone().at_time(time), frame_ms).unwrap();
            }
            let error = animation.push(&Scene::from_maze(&maze), frame_ms).unwrap_err();
            assert_eq!(error, PictureError::OtherLegend);
            let (shown, delays) = played(&animation.finish().unwrap());
            assert_eq!(delays.len(), 14, "0.514 s");
            let last = scene.clone().at_time(scene.duration()).pixmap(400).unwrap();
            let differences = shown.data().iter().zip(last.data()).map(|(a, b)| a.abs_diff(*b));
            assert!(differences.max().unwrap() <= 40, "{theme:?}: a blend that the palette lacks");
        }
    }

    #[test]
    fn frames_are_in_real_time_and_not_too_many() {
        for duration in [0.0, 0.04, 3.583, 15.96, 16.0, 75.0, 1e9] {
            let (times, frame_ms) = frame_times(duration);
            let times: Vec<f64> = times.collect();
            assert!(times.len() <= MAX_FRAMES && frame_ms >= 40, "{duration}: {}", times.len());
            assert_eq!(times.last().copied(), Some(duration.min(3600.0)));
            for pair in times.windows(2) {
                let difference = (pair[1] - pair[0]) * 1000.0;
                assert!(difference > 0.0 && difference < f64::from(frame_ms) + 1e-6);
            }
        }
    }

    #[test]
    fn frames_are_evenly_spaced_and_end_with_the_last_state() {
        for states in 0..50 {
            for most in 1..20 {
                let indices: Vec<usize> = frame_indices(states, most).collect();
                assert_eq!(indices.len(), states.min(most));
                assert_eq!(indices.last().copied(), states.checked_sub(1));
                assert!(most == 1 || states == 0 || indices[0] == 0);
                let gaps: Vec<usize> = indices.windows(2).map(|pair| pair[1] - pair[0]).collect();
                let (least, most) = (gaps.iter().min(), gaps.iter().max());
                assert!(most.zip(least).is_none_or(|(most, least)| most - least <= 1), "{gaps:?}");
            }
        }
    }
}
