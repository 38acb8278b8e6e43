//! Curves that a mouse drives through a maze in time.

use mmsim_fastrun::{MotionState, Trajectory};

use crate::style::data_colours;

/// The number of points of a run for each cell, so that they are 2 mm apart in a classic maze.
const POINTS_PER_CELL: f64 = 90.0;

/// The greatest distance in cells between a curve and the line that is drawn for it: 0.2 mm in a
/// classic maze.
const TOLERANCE: f64 = 0.001;

/// The curve that a mouse drives, with a name for the legend.
///
/// ```
/// use mmsim_drawing::{DrivenPath, PathPoint, Scene};
/// use mmsim_maze::Maze;
///
/// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let point = |time, x, speed| PathPoint { time, x, y: 0.5, heading: 0.0, speed };
/// let points = vec![point(0.0, 0.5, 0.0), point(0.2, 1.0, 900.0), point(0.4, 1.5, 0.0)];
/// let paths = [DrivenPath::new("fastest", points)];
/// let scene = Scene::from_maze(&maze).with_paths(&paths);
/// assert!(scene.clone().at_time(0.3).svg().contains("rotate(90)"));
/// assert!(scene.png(440)?.starts_with(b"\x89PNG"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenPath {
    pub(crate) name: String,
    /// The text in the legend that replaces the time.
    label: Option<String>,
    pub(crate) points: Vec<PathPoint>,
    pub(crate) stretches: Vec<Stretch>,
}

/// The state of a mouse at one point of a [`DrivenPath`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// The time since the beginning, in s.
    pub time: f64,
    /// The distance to the east of the maze's south-west corner, in cells.
    pub x: f64,
    /// The distance to the north of the maze's south-west corner, in cells.
    pub y: f64,
    /// The heading in radians, counterclockwise from east. It must not jump by a revolution.
    pub heading: f64,
    /// The speed, in mm/s.
    pub speed: f64,
}

/// A part of a path with one colour, simplified to few points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stretch {
    /// The index of its colour in the [ramp](data_colours::speed_ramp) of speeds.
    pub(crate) level: usize,
    pub(crate) points: Vec<PathPoint>,
}

impl DrivenPath {
    /// The maximum number of characters of a name in a legend.
    pub const MAX_NAME_CHARS: usize = 32;

    /// Creates a path from points in the order of time. Neighbouring points should be a few
    /// millimetres apart; points that a line does not need are not drawn. Points with infinite
    /// numbers or NaN are ignored, and a longer name than
    /// [`MAX_NAME_CHARS`](Self::MAX_NAME_CHARS) is cut off.
    pub fn new(name: &str, mut points: Vec<PathPoint>) -> Self {
        points.retain(PathPoint::is_finite);
        let name = name.chars().take(Self::MAX_NAME_CHARS).collect();
        let stretches = stretches(&points, data_colours::SpeedScale::up_to(top_speed(&points)));
        Self { name, label: None, points, stretches }
    }

    /// Creates the path of a fast run.
    ///
    /// ```
    /// use mmsim_drawing::DrivenPath;
    /// use mmsim_fastrun::{FastRun, Vehicle};
    /// use mmsim_maze::Cell;
    ///
    /// let run = FastRun::parse(Cell::new(0, 0), "N 2 45inR@1400 2 45outL@1700 2")?;
    /// let trajectory = run.drive(&Vehicle::expert())?;
    /// let path = DrivenPath::from_trajectory("expert", &trajectory);
    /// assert!((path.duration() - trajectory.duration()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_trajectory(name: &str, trajectory: &Trajectory) -> Self {
        let pitch = 2.0 * trajectory.half_cell();
        let point = |MotionState { time, x, y, heading, speed, .. }: MotionState| PathPoint {
            time,
            x: x / pitch,
            y: y / pitch,
            heading,
            speed,
        };
        let states = trajectory.samples_along(pitch / POINTS_PER_CELL);
        Self::new(name, states.map(point).collect())
    }

    /// Creates a line of one colour from its corners: their distances to the east and to the north of
    /// the maze's south-west corner, in cells. The legend shows `label` instead of a time.
    ///
    /// ```
    /// use mmsim_drawing::{DrivenPath, Scene};
    /// use mmsim_maze::Maze;
    ///
    /// let maze: Maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
    /// let paths = [DrivenPath::line("race", "1 step", &[(0.5, 0.5), (1.5, 0.5)])];
    /// assert!(Scene::from_maze(&maze).with_paths(&paths).svg().contains("driven-paths"));
    /// # Ok::<(), mmsim_maze::ParseMazeError>(())
    /// ```
    pub fn line(name: &str, label: &str, corners: &[(f64, f64)]) -> Self {
        let point = |&(x, y): &(f64, f64)| PathPoint { time: 0.0, x, y, heading: 0.0, speed: 0.0 };
        let points: Vec<_> = corners.iter().map(point).filter(PathPoint::is_finite).collect();
        let path = Self::new(name, Vec::new());
        let stretches = vec![Stretch { level: 0, points: points.clone() }];
        let label = label.chars().take(Self::MAX_NAME_CHARS).collect();
        Self { label: Some(label), points, stretches, ..path }
    }

    /// Returns true if the colour shows the speed.
    pub(crate) const fn is_coloured_by_speed(&self) -> bool {
        self.label.is_none()
    }

    /// Returns the text in the legend: the label, or else the time.
    pub(crate) fn label(&self) -> String {
        self.label.clone().unwrap_or_else(|| seconds(self.duration()))
    }

    /// Returns the points that a line needs to stay near the curve: their distances to the east and to
    /// the north of the maze's south-west corner, in cells.
    pub fn outline(&self) -> Vec<(f64, f64)> {
        let mut kept: Vec<PathPoint> = self.points.first().copied().into_iter().collect();
        simplify(&self.points, &mut kept);
        kept.iter().map(|point| (point.x, point.y)).collect()
    }

    /// Returns the time at the last point, in s.
    pub fn duration(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.time)
    }

    /// Returns the scale of its speeds.
    pub(crate) fn scale(&self) -> data_colours::SpeedScale {
        data_colours::SpeedScale::up_to(top_speed(&self.points))
    }

    /// Returns the state at a time in s. Times outside of the path count as its beginning or end.
    pub(crate) fn at(&self, time: f64) -> Option<PathPoint> {
        let index = self.points.partition_point(|point| point.time <= time);
        let (Some(to), Some(from)) = (self.points.get(index), index.checked_sub(1)) else {
            return self.points.get(index.saturating_sub(1)).copied();
        };
        let from = self.points[from];
        let share = (time - from.time) / (to.time - from.time);
        let between = |from: f64, to: f64| from + share * (to - from);
        Some(PathPoint {
            time,
            x: between(from.x, to.x),
            y: between(from.y, to.y),
            heading: between(from.heading, to.heading),
            speed: between(from.speed, to.speed),
        })
    }
}

impl PathPoint {
    fn is_finite(&self) -> bool {
        let Self { time, x, y, heading, speed } = *self;
        [time, x, y, heading, speed].iter().all(|number| number.is_finite())
    }
}

fn top_speed(points: &[PathPoint]) -> f64 {
    points.iter().map(|point| point.speed).fold(0.0, f64::max)
}

/// Divides a path where its colour changes.
fn stretches(points: &[PathPoint], scale: data_colours::SpeedScale) -> Vec<Stretch> {
    let level = |pair: &[PathPoint]| scale.level(f64::midpoint(pair[0].speed, pair[1].speed));
    let mut stretches = Vec::new();
    let mut begin = 0;
    while begin + 1 < points.len() {
        let mut pairs = points[begin..].windows(2);
        let level_here = level(&points[begin..]);
        let length = pairs.position(|pair| level(pair) != level_here);
        let end = length.map_or(points.len() - 1, |length| begin + length);
        let mut kept = vec![points[begin]];
        simplify(&points[begin..=end], &mut kept);
        stretches.push(Stretch { level: level_here, points: kept });
        begin = end;
    }
    stretches
}

/// Adds the points after the first one that a line needs to stay near the curve (the algorithm by
/// Ramer, Douglas and Peucker).
fn simplify(curve: &[PathPoint], kept: &mut Vec<PathPoint>) {
    let [first, inner @ .., last] = curve else { return };
    let deviations = inner.iter().map(|point| deviation(point, first, last));
    let farthest = (1..).zip(deviations).max_by(|(_, one), (_, other)| one.total_cmp(other));
    match farthest.filter(|&(_, deviation)| deviation > TOLERANCE) {
        Some((index, _)) => {
            simplify(&curve[..=index], kept);
            simplify(&curve[index..], kept);
        }
        None => kept.push(*last),
    }
}

/// Returns the distance of a point from the line between two others, in cells.
fn deviation(point: &PathPoint, first: &PathPoint, last: &PathPoint) -> f64 {
    let (east, north) = (last.x - first.x, last.y - first.y);
    let (x, y) = (point.x - first.x, point.y - first.y);
    let square = east * east + north * north;
    let share = if square > 0.0 { ((x * east + y * north) / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - share * east).hypot(y - share * north)
}

/// Formats a time.
pub(crate) fn seconds(time: f64) -> String {
    format!("{time:.3} s")
}

#[cfg(test)]
pub(crate) use tests::path;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Returns a path that accelerates to the east for one cell, and turns left on a semicircle
    /// with the diameter of a cell.
    pub(crate) fn path(name: &str) -> DrivenPath {
        let straight = (0..100).map(|step| {
            let share = f64::from(step) / 100.0;
            let (time, x, speed) = (0.2 * share.sqrt(), 0.5 + share, 1800.0 * share.sqrt());
            PathPoint { time, x, y: 0.5, heading: 0.0, speed }
        });
        let arc = (0..=200).map(|step| {
            let heading = PI * f64::from(step) / 200.0;
            let (x, y) = (1.5 + 0.5 * heading.sin(), 1.0 - 0.5 * heading.cos());
            PathPoint { time: 0.2 + heading / 10.0, x, y, heading, speed: 1800.0 }
        });
        DrivenPath::new(name, straight.chain(arc).collect())
    }

    #[test]
    fn few_points_stay_near_the_curve() {
        let path = path("a");
        let drawn: Vec<_> = path.stretches.iter().flat_map(|part| &part.points).collect();
        assert!(drawn.len() < 80, "{}", drawn.len());
        let outline = path.outline();
        assert_eq!(outline[..2], [(0.5, 0.5), (1.5, 0.5)], "a straight is one line");
        assert!(outline.len() < 50, "{}", outline.len());
        for point in &path.points {
            let nearest = drawn.windows(2).map(|pair| deviation(point, pair[0], pair[1]));
            assert!(nearest.fold(f64::INFINITY, f64::min) <= TOLERANCE, "{point:?}");
        }
    }

    #[test]
    fn each_stretch_has_the_colour_of_its_speed() {
        let path = path("a");
        let (stretches, scale) = (&path.stretches, path.scale());
        for pair in stretches.windows(2) {
            assert_eq!(pair[0].points.last(), pair[1].points.first());
            assert_ne!(pair[0].level, pair[1].level);
        }
        let arc = stretches.last().unwrap();
        assert_eq!(arc.level, scale.level(1800.0));
        assert!(arc.points.len() > 10, "the arc is one stretch");
        for Stretch { level, points } in stretches {
            let inside = points.iter().filter(|point| scale.level(point.speed) == *level).count();
            assert!(inside + 2 >= points.len(), "{level}: {points:?}");
        }
    }

    #[test]
    fn the_place_at_a_time_is_on_the_curve() {
        let path = path("a");
        let at = |time| path.at(time).unwrap();
        assert_eq!((at(-1.0), at(9.0)), (path.points[0], *path.points.last().unwrap()));
        let quarter = at(0.2 + PI / 20.0);
        assert!((quarter.x - 2.0).abs() < 1e-4 && (quarter.y - 1.0).abs() < 1e-4, "{quarter:?}");
        assert!((quarter.heading - PI / 2.0).abs() < 1e-9);
        assert!((path.duration() - 0.2 - PI / 10.0).abs() < 1e-9);
    }

    #[test]
    fn short_paths_and_wrong_numbers_are_harmless() {
        let empty = DrivenPath::new("", Vec::new());
        assert_eq!((empty.at(1.0), empty.duration()), (None, 0.0));
        let point = PathPoint { time: 0.0, x: 0.5, y: 0.5, heading: 0.0, speed: 0.0 };
        let wrong = PathPoint { x: f64::NAN, ..point };
        let resting =
            DrivenPath::new("a very long name of a mouse and its route", vec![wrong, point]);
        assert_eq!((resting.at(1.0), resting.stretches.len()), (Some(point), 0));
        assert_eq!(resting.name, "a very long name of a mouse and ");
        let back = PathPoint { time: 2.0, ..point };
        let away = PathPoint { time: 1.0, x: 0.7, ..point };
        let there_and_back = DrivenPath::new("", vec![point, away, back]);
        assert_eq!(there_and_back.stretches[0].points.len(), 3);
    }
}
