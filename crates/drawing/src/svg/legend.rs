//! The size and the contents of the legend of driven paths.
//!
//! ```text
//!   ── fastest       3.583 s                1.240 s     a row for each path, and the clock
//!   ── fewest cells  3.900 s
//!
//!   ▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉▉                     the scale of speeds, if there is one path
//!   0     0.5    1    1.5    2    2.5 m/s
//! ```
//!
//! The legend is below the maze. Its units are those of the maze at 16×16 cells, and it is scaled
//! with the longer side of the maze, so that texts have the same size in each picture.

use super::Svg;
use crate::scene::Scene;
use crate::scene::driven_path::{DrivenPath, seconds};
use crate::shapes::{Area, MARGIN, PITCH, around, units};
use crate::style::data_colours::speed_ramp;
use crate::svg::paths::{Style, area};
use crate::text::{ADVANCE, STROKE, decimals, line, pair};

/// The distance between two rows, in units of the legend.
pub(crate) const ROW: f64 = 11.0;

/// The distance from the maze to the middle of the first row, in units of the legend.
const TOP: f64 = 9.0;

/// The height of the scale of speeds with its ticks and numbers, in units of the legend.
const SCALE_HEIGHT: f64 = 23.0;

/// The distance between the sides of the picture and the legend, and between columns.
pub(crate) const GAP: f64 = 6.0;

/// The length of the sample of a line in front of a name.
pub(crate) const SAMPLE: f64 = 16.0;

/// The number of characters of a clock such as `12.345 s`.
const CLOCK_CHARS: usize = 8;

/// The places of the parts of a legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Legend {
    /// The size of a unit of the legend in units of the picture.
    pub(crate) factor: f64,
    /// The width in units of the legend.
    pub(crate) width: f64,
    /// The height in units of the legend.
    pub(crate) height: f64,
    /// The distance from the left side to the names.
    pub(crate) names: f64,
    /// The distance from the left side to the end of the times.
    pub(crate) times: f64,
    /// The distance from the top to the scale of speeds, if there is one.
    pub(crate) speeds: Option<f64>,
}

impl Legend {
    /// Returns the legend of a scene, or `None` if the scene has no paths.
    pub(crate) fn new(scene: &Scene<'_>) -> Option<Self> {
        let (width, height) = units(scene.size);
        let classic = 16 * PITCH + 2 * MARGIN;
        let factor = f64::from(width.max(height)) / f64::from(classic);
        let rows = u32::try_from(scene.paths.len()).ok().filter(|&rows| rows > 0)?;
        let longest = |texts: &mut dyn Iterator<Item = usize>| length(texts.max().unwrap_or(0));
        let name = longest(&mut scene.paths.iter().map(|path| path.name.chars().count()));
        let time = longest(&mut scene.paths.iter().map(|path| path.label().len()));
        let names = if rows > 1 { 2.0 * GAP + SAMPLE } else { GAP };
        let times = names + name + GAP + time;
        let least = times + 2.0 * GAP + length(CLOCK_CHARS) + GAP;
        let has_scale = matches!(scene.paths, [path] if path.is_coloured_by_speed());
        let speeds = has_scale.then_some(TOP + f64::from(rows) * ROW - 2.0);
        let height = TOP + f64::from(rows) * ROW - 2.0 + speeds.map_or(0.0, |_| SCALE_HEIGHT);
        let width = least.max(f64::from(width) / factor);
        Some(Self { factor, width, height, names, times, speeds })
    }

    /// Returns the middle of a row, in units of the legend.
    pub(crate) fn row(index: usize) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "few rows")]
        let index = index as f64;
        TOP + index * ROW
    }
}

impl Scene<'_> {
    /// Returns the width and the height of a picture of the scene in units, with the legend.
    pub(crate) fn extent(&self) -> (u32, u32) {
        let (width, height) = units(self.size);
        let Some(legend) = Legend::new(self) else { return (width, height) };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let whole = |length: f64| (length * legend.factor).ceil() as u32;
        (width.max(whole(legend.width)), height + whole(legend.height))
    }

    /// Returns the time in s after which all mice have arrived.
    pub fn duration(&self) -> f64 {
        self.paths.iter().map(DrivenPath::duration).fold(0.0, f64::max)
    }
}

impl Svg<'_> {
    /// Draws the legend below the maze.
    pub(super) fn legend(&mut self) {
        let (scene, Some(legend)) = (self.scene, Legend::new(self.scene)) else { return };
        let top = f64::from(units(scene.size).1 - MARGIN);
        let number = scene.theme.colours().number;
        self.put(format_args!(
            "<g class=\"legend\" transform=\"translate(-{MARGIN} {}) scale({:.4})\" stroke=\"{number}\" \
             stroke-width=\"{STROKE}\">\n",
            decimals(top),
            legend.factor
        ));
        let place = Place { legend, top };
        for (index, path) in scene.paths.iter().enumerate() {
            let y = Legend::row(index);
            let Style { colours, width } = self.style(index);
            if scene.paths.len() > 1 {
                let [x, length, width] = [GAP + width / 2.0, SAMPLE - width, width].map(decimals);
                let sample = format!(
                    "<path stroke=\"{}\" stroke-width=\"{width}\" d=\"M{x} {y}h{length}\"/>\n",
                    colours[0]
                );
                self.put_part(place.row(y), true, sample);
            }
            let time = path.label();
            self.text(&place, &path.name, legend.names, y);
            self.text(&place, &time, legend.times - length(time.len()), y);
        }
        if let Some(time) = scene.time {
            let clock = seconds(time);
            self.text(&place, &clock, legend.width - GAP - length(clock.len()), Legend::row(0));
        }
        if let (Some(top), [path]) = (legend.speeds, scene.paths) {
            self.speeds(&place, path, top);
        }
        self.put("</g>\n");
    }

    /// Draws the scale of speeds.
    fn speeds(&mut self, place: &Place, path: &DrivenPath, top: f64) {
        let colours = speed_ramp(self.scene.theme);
        let (unit, left) = ("m/s", GAP + 2.0);
        // Half of the last number and a space.
        let to_unit = 7.5 + 5.0;
        let width = place.legend.width - left - to_unit - length(unit.len()) - GAP;
        #[expect(clippy::cast_precision_loss, reason = "few colours")]
        let share = width / colours.len() as f64;
        let (mut x, right) = (left, decimals(left + width));
        for colour in colours {
            // Each colour continues below the next ones, so that there are no seams.
            let left = decimals(x);
            let bar = format!(
                "<path stroke=\"none\" style=\"fill:{colour}\" d=\"M{left} {top}H{right}v5H{left}z\"/>\n"
            );
            self.put_part(place.row(top), true, bar);
            x += share;
        }
        for (share, text) in path.scale().ticks() {
            let x = left + share * width;
            let tick = format!("<path d=\"M{} {}v1.5\"/>\n", decimals(x), top + 6.0);
            self.put_part(place.row(top + 6.0), true, tick);
            self.text(place, &text, x - length(text.len()) / 2.0, top + 13.5);
        }
        self.text(place, unit, left + width + to_unit, top + 13.5);
    }

    /// Writes a text that begins at (x, y), in units of the legend.
    fn text(&mut self, place: &Place, text: &str, x: f64, y: f64) {
        // A line of text is centred.
        let middle = x + length(text.chars().count()) / 2.0;
        let (at, line) = (pair(middle, y), line(text, 0.0));
        let element = format!("<path transform=\"translate({at})\" d=\"{line}\"/>\n");
        self.put_part(place.row(y), true, element);
    }
}

/// The place of the legend in the picture.
struct Place {
    legend: Legend,
    top: f64,
}

impl Place {
    /// Returns the area of a row, given its middle in units of the legend.
    fn row(&self, y: f64) -> Area {
        let Legend { factor, width, .. } = self.legend;
        let (north, south) = (self.top + factor * (y - 8.0), self.top + factor * (y + 8.0));
        around(area((0.0, north), 2.0), area((factor * width, south), 2.0))
    }
}

/// Returns the length of a line of this many characters, in units of the legend.
pub(crate) fn length(characters: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "short lines")]
    let characters = characters as f64;
    characters * ADVANCE
}

#[cfg(test)]
mod tests {
    use mmsim_maze::{Cell, CellSet, Maze, MazeSize, Walls};

    use super::*;
    use crate::scene::driven_path::path;

    fn maze(width: usize, height: usize) -> Maze {
        let walls = Walls::open(MazeSize::new(width, height).unwrap());
        Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap()
    }

    #[test]
    fn texts_have_the_same_size_in_each_picture() {
        let paths = [path("fastest")];
        for (width, height) in [(16, 16), (32, 32), (3, 2), (1, 14), (32, 1)] {
            let maze = maze(width, height);
            let scene = Scene::from_maze(&maze).with_paths(&paths);
            let (units, whole) = (units(maze.size()), scene.extent());
            let legend = Legend::new(&scene).unwrap();
            let longer = f64::from(units.0.max(units.1));
            assert!((legend.factor * 324.0 - longer).abs() < 1e-9);
            assert!(whole.0 >= units.0 && whole.1 > units.1, "{width} {height} {whole:?}");
            assert!(f64::from(whole.0) >= legend.width * legend.factor);
        }
        let (maze, two) = (maze(16, 16), [path("fastest"), path("fewest cells")]);
        let heights = [&[][..], &two[..1], &two]
            .map(|paths| Scene::from_maze(&maze).with_paths(paths).extent());
        assert_eq!(heights, [(324, 324), (324, 365), (324, 353)]);
    }

    #[test]
    fn the_slowest_mouse_defines_the_duration() {
        let maze = maze(3, 3);
        let point = crate::PathPoint { time: 2.5, x: 0.5, y: 0.5, heading: 0.0, speed: 0.0 };
        let paths = [path("a"), DrivenPath::new("b", vec![point])];
        let duration = Scene::from_maze(&maze).with_paths(&paths).duration();
        assert!((duration - 2.5).abs() < 1e-9);
    }
}
