//! The drawing of driven paths, their mice and their legend.

use super::Svg;
use crate::scene::driven_path::{DrivenPath, PathPoint, Stretch};
use crate::shapes::{Area, MOUSE, PITCH, around};
use crate::style::colour::Rgb;
use crate::style::data_colours::{faint, path_colours, speed_ramp};
use crate::text::{decimals, pair};

/// The width of a single path, in units.
const WIDTH: f64 = 3.0;

/// The width of the first of several paths, which is on top, in units. Paths are the wider the deeper
/// they are, so that all of them are visible where they coincide.
const LEAST_WIDTH: f64 = 1.8;

/// The size of a mouse. The mouse of a search almost fills a cell; on a curve, a mouse has about
/// the size of real ones.
const MOUSE_SCALE: f64 = 0.62;

/// How a path is drawn.
pub(super) struct Style {
    /// The colours of speeds, or a single colour.
    pub(super) colours: Vec<Rgb>,
    pub(super) width: f64,
}

impl Svg<'_> {
    /// Draws the paths. The part that a mouse has not driven yet is faint.
    pub(super) fn driven_paths(&mut self) {
        let (scene, floor) = (self.scene, self.scene.theme.colours().floor);
        if scene.paths.is_empty() {
            return;
        }
        self.put("<g class=\"driven-paths\">\n");
        for is_faint in [true, false] {
            if is_faint && scene.time.is_none() {
                continue;
            }
            for (index, path) in scene.paths.iter().enumerate().rev() {
                let mut style = self.style(index);
                for colour in style.colours.iter_mut().filter(|_| is_faint) {
                    *colour = faint(*colour, floor);
                }
                let until = scene.time.filter(|_| !is_faint).unwrap_or(f64::INFINITY);
                self.put(format_args!("<g stroke-width=\"{}\">\n", decimals(style.width)));
                for stretch in &path.stretches {
                    self.stretch(path, stretch, until, &style);
                }
                if !is_faint {
                    self.ends(path, &style);
                }
                self.put("</g>\n");
            }
        }
        self.put("</g>\n");
    }

    pub(super) fn style(&self, index: usize) -> Style {
        let (theme, count) = (self.scene.theme, self.scene.paths.len());
        if matches!(self.scene.paths, [path] if path.is_coloured_by_speed()) {
            return Style { colours: speed_ramp(theme), width: WIDTH };
        }
        #[expect(clippy::cast_precision_loss, reason = "few paths")]
        let (depth, all) = (index as f64, (count - 1) as f64);
        let step = f64::min(1.9, 5.0 / f64::max(all, 1.0));
        Style { colours: vec![path_colours(theme)[index]], width: LEAST_WIDTH + step * depth }
    }

    /// Draws a part of a path, up to a time in s.
    fn stretch(&mut self, path: &DrivenPath, stretch: &Stretch, until: f64, style: &Style) {
        let Style { colours, width } = style;
        let driven = stretch.points.iter().take_while(|point| point.time <= until).copied();
        let mut points: Vec<PathPoint> = driven.collect();
        if points.is_empty() {
            return;
        }
        if points.len() < stretch.points.len() {
            points.extend(path.at(until));
        }
        let points: Vec<_> = points.iter().map(|point| self.place(point)).collect();
        let line: Vec<_> = points.iter().map(|&(x, y)| pair(x, y)).collect();
        let line = line.join("L");
        let areas = points.iter().map(|&place| area(place, width / 2.0));
        let Some(area) = areas.reduce(around) else { return };
        let colour = colours[stretch.level.min(colours.len() - 1)];
        let element = format_args!("<path stroke=\"{colour}\" d=\"M{line}\"/>\n");
        self.put_part(area, true, element);
    }

    /// Draws a disc at the end of a path, and a ring at the beginning of a single path.
    fn ends(&mut self, path: &DrivenPath, Style { colours, width }: &Style) {
        let (Some(first), Some(last)) = (path.points.first(), path.points.last()) else { return };
        let (colour, ring, disc) = (colours[0], width / 2.0 + 1.8, width / 2.0 + 1.2);
        let mut marks = vec![(last, disc, format!("fill=\"{colour}\""))];
        if colours.len() > 1 {
            let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.3\"");
            marks.push((first, ring, style));
        }
        for (point, radius, style) in marks {
            let (x, y) = self.place(point);
            let area = area((x, y), radius + 1.0);
            let [x, y, radius] = [x, y, radius].map(decimals);
            let element = format_args!("<circle {style} cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>\n");
            self.put_part(area, true, element);
        }
    }

    /// Draws the mice on their paths, the first one on top.
    pub(super) fn mice_on_paths(&mut self) {
        let Some(time) = self.scene.time else { return };
        let count = self.scene.paths.len();
        for (index, path) in self.scene.paths.iter().enumerate().rev() {
            let Some(point) = path.at(time) else { continue };
            let (x, y) = self.place(&point);
            let fill = match count {
                1 => String::new(),
                _ => format!(" style=\"fill:{}\"", self.style(index).colours[0]),
            };
            let (place, turn) = (pair(x, y), decimals(90.0 - point.heading.to_degrees()));
            let element = format_args!(
                "<path class=\"mouse\"{fill} transform=\"translate({place}) rotate({turn}) \
                 scale({MOUSE_SCALE})\" d=\"{MOUSE}\"/>\n"
            );
            self.put_part(area((x, y), 11.0 * MOUSE_SCALE), true, element);
        }
    }

    /// Returns the position of a point in the drawing, in units.
    fn place(&self, point: &PathPoint) -> (f64, f64) {
        let (pitch, height) = (f64::from(PITCH), f64::from(self.scene.size.height()));
        (point.x * pitch, (height - point.y) * pitch)
    }
}

/// Returns the area around a point.
pub(super) fn area((x, y): (f64, f64), reach: f64) -> Area {
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers, saturated")]
    let [west, north, east, south] = [
        (x - reach).floor() as i32,
        (y - reach).floor() as i32,
        (x + reach).ceil() as i32,
        (y + reach).ceil() as i32,
    ];
    [west, north, east, south]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use mmsim_maze::{Cell, CellSet, Maze, MazeSize, Walls};
    use resvg::usvg::{Options, Tree};

    use super::*;
    use crate::scene::Scene;
    use crate::scene::driven_path::path;
    use crate::shapes::units;
    use crate::style::colour::Theme;
    use crate::svg::tests::maze;

    /// Returns the lines of a drawing between two texts.
    fn between<'a>(svg: &'a str, from: &str, to: &str) -> Vec<&'a str> {
        let inside = svg.split_once(from).unwrap().1.split_once(to).unwrap().0;
        inside.lines().collect()
    }

    #[test]
    fn a_single_path_is_coloured_by_speed() {
        let (maze, paths) = (maze(), [path("fastest")]);
        let scene = Scene::from_maze(&maze).with_paths(&paths);
        let svg = scene.svg();
        let lines = between(&svg, "<g class=\"driven-paths\">", "<g class=\"walls\">");
        let colours: Vec<_> = speed_ramp(Theme::Light).iter().map(ToString::to_string).collect();
        let levels: Vec<_> = lines
            .iter()
            .filter_map(|line| line.strip_prefix("<path stroke=\"")?.split_once('"'))
            .map(|(colour, _)| colours.iter().position(|other| other == colour).unwrap())
            .collect();
        assert!(levels.is_sorted() && levels.len() > 8, "{levels:?}");
        let place = format!(" d=\"M{} {}", 20.0 * 0.5, 20.0 * 1.5);
        assert!(lines[2].contains(&place), "it begins in the start cell: {}", lines[2]);
        assert_eq!(svg.matches("<circle").count(), 2);
        let legend = between(&svg, "<g class=\"legend\"", "</g>");
        let bars = legend.iter().filter(|line| line.contains("fill:#")).count();
        assert_eq!(bars, colours.len());
        assert!(!svg.contains("scale(0.62)"), "no mouse");
        assert_eq!(scene.page_svg(), Scene::from_maze(&maze).page_svg());
    }

    #[test]
    fn a_mouse_is_where_it_is_at_a_time() {
        let (maze, paths) = (maze(), [path("fastest")]);
        let scene = Scene::from_maze(&maze).with_paths(&paths).at_time(0.2 + PI / 20.0);
        let svg = scene.svg();
        // After a quarter of a revolution, one cell to the east and half a cell to the north of
        // the beginning of the arc.
        assert!(svg.contains("translate(40 20) rotate(0) scale(0.62)"), "{svg}");
        let lines = between(&svg, "<g class=\"driven-paths\">", "<g class=\"walls\">");
        let (faint, driven) =
            lines.split_at(lines.iter().position(|line| line.contains("</g>")).unwrap());
        let ends = |lines: &[&str]| {
            let last = lines.iter().rfind(|line| line.starts_with("<path")).unwrap();
            last.rsplit_once('L').unwrap().1.trim_end_matches("\"/>").to_string()
        };
        assert_eq!((ends(faint), ends(driven)), ("30 10".into(), "40 20".into()));
    }

    #[test]
    fn several_paths_have_distinct_colours_and_widths() {
        let maze = maze();
        let paths: Vec<_> = (0..9).map(|number| path(&number.to_string())).collect();
        for (count, shown) in [(2, 2), (3, 3), (6, 6), (9, 6)] {
            let svg = Scene::from_maze(&maze).with_paths(&paths[..count]).at_time(0.1).svg();
            for colour in &path_colours(Theme::Light)[..shown] {
                let mouse = format!("style=\"fill:{colour}\" transform");
                assert_eq!(svg.matches(&mouse).count(), 1, "{count}");
            }
            assert_eq!(svg.matches("scale(0.62)").count(), shown);
            let widths: Vec<f64> =
                between(&svg, "<g class=\"driven-paths\">", "<g class=\"walls\">")
                    .iter()
                    .filter_map(|line| line.strip_prefix("<g stroke-width=\"")?.strip_suffix("\">"))
                    .map(|width| width.parse().unwrap())
                    .collect();
            assert_eq!(widths.len(), 2 * shown, "faint and strong");
            assert!(widths[..shown].windows(2).all(|pair| pair[0] > pair[1] + 0.9), "{widths:?}");
            let place = |colour: &Rgb| svg.find(&format!("style=\"fill:{colour}\" transform"));
            let places: Vec<_> = path_colours(Theme::Light)[..shown].iter().map(place).collect();
            assert!(places.is_sorted_by(|one, other| one > other), "the first mouse is on top");
        }
    }

    #[test]
    fn the_drawing_of_a_race_is_stable() {
        let (maze, paths) = (maze(), [path("fastest"), path("fewest-cells")]);
        let svg = Scene::from_maze(&maze).with_paths(&paths).at_time(0.25).svg();
        let lines = between(&svg, "<g class=\"driven-paths\">", "<g class=\"walls\">");
        let ends = between(&svg, "<g class=\"numbers\">", "</svg>");
        insta::assert_snapshot!("race", [&lines[..], &ends].concat().join("\n"));
    }

    #[test]
    fn everything_in_a_legend_is_visible() {
        let names = ["fastest", "a long name of a mouse, cut off."];
        let paths: Vec<_> = names.iter().map(|name| path(name)).collect();
        for (width, height) in [(1, 1), (2, 2), (16, 16), (32, 5), (1, 32)] {
            let walls = Walls::open(MazeSize::new(width, height).unwrap());
            let maze = Maze::new(walls, Cell::new(0, 0), CellSet::EMPTY).unwrap();
            for paths in [&paths[1..], &paths] {
                let scene = Scene::from_maze(&maze).with_paths(paths).at_time(0.3);
                let svg = scene.svg();
                let head = svg.split_once("<style>").unwrap().0;
                let start = svg.find("<g class=\"legend\"").unwrap();
                let style = ".maze path{fill:none}";
                let legend = format!("{head}<style>{style}</style>{}", &svg[start..]);
                let tree = Tree::from_str(&legend, &Options::default()).unwrap();
                let area = tree.root().abs_stroke_bounding_box();
                let size = tree.size();
                assert!(area.left() > 0.0 && area.right() < size.width(), "{width} {area:?}");
                assert!(area.bottom() < size.height(), "{width} {height} {area:?} {size:?}");
                // The picture has 2 pixels per unit.
                let maze_height = 2.0 * f64::from(units(maze.size()).1);
                assert!(f64::from(area.top()) > maze_height, "{width} {height} {area:?}");
            }
        }
    }
}
