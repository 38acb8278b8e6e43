//! A fast run in time: pose, speed and acceleration of the mouse at every moment.

use alloc::vec::Vec;

use libm::{cos, fabs, sin, sqrt};
use mmsim_maze::{Cell, CellSet};

use crate::arc;
use crate::lattice::Point;
use crate::line::{Line, Piece};
use crate::run::{FastRun, Turn};
use crate::turn::{Side, TurnKind};
use crate::vehicle::Vehicle;

/// A [`FastRun`] driven by a [`Vehicle`]: its segments, and the state of the mouse at any time.
///
/// ```
/// use mmsim_fastrun::{FastRun, Vehicle};
/// use mmsim_maze::Cell;
/// let run = FastRun::parse(Cell::new(0, 0), "N 28").unwrap();
/// let trajectory = run.drive(&Vehicle::expert())?;
/// assert!((trajectory.duration() - 1.1911).abs() < 1e-4);
/// assert_eq!(trajectory.at(0.5).speed, 2500.0);
/// # Ok::<(), mmsim_fastrun::DriveError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    segments: Vec<Segment>,
    half_cell: f64,
    end: Moment,
}

/// A straight or the arc of a turn. A straight contains the straight parts of the turns before and
/// after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The straight or turn.
    pub shape: Shape,
    /// The state of the mouse at the beginning.
    pub entry: Moment,
    /// The duration, in s.
    pub duration: f64,
    /// The length, in mm.
    pub length: f64,
    /// The speed at the end, in mm/s.
    pub exit_speed: f64,
    /// The parts of a straight with constant jerk, in order. Empty for turns.
    pub pieces: Vec<Piece>,
}

/// The shape of a [`Segment`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight of this many lattice steps, plus the straight parts of the turns.
    Straight(u8),
    /// The arc of a turn.
    Turn(TurnKind, Side),
}

/// The state of a mouse at one moment of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The time since the beginning of the run, in s.
    pub time: f64,
    /// The distance since the beginning of the run, in mm.
    pub distance: f64,
    /// The distance to the east of the maze's south-west corner, in mm.
    pub x: f64,
    /// The distance to the north of the maze's south-west corner, in mm.
    pub y: f64,
    /// The heading in radians, counterclockwise from east. It is continuous over the whole run, so
    /// it can leave the range of one revolution.
    pub heading: f64,
    /// The speed, in mm/s.
    pub speed: f64,
    /// The acceleration in the direction of travel, in mm/s².
    pub acceleration: f64,
    /// The angular velocity in rad/s, positive to the left.
    pub angular_velocity: f64,
}

/// The reason why a vehicle cannot drive a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DriveError {
    /// The vehicle cannot do a turn, or not so fast.
    #[error("{vehicle} cannot drive turn {} ({kind}) at {speed} mm/s", index + 1)]
    Turn {
        /// The name of the vehicle.
        vehicle: alloc::string::String,
        /// The index of the turn.
        index: usize,
        /// The turn.
        kind: TurnKind,
        /// The speed, in mm/s.
        speed: f64,
    },
    /// A straight is too short for the change of speed.
    #[error(
        "{vehicle} cannot change its speed from {from} to {to} mm/s within the {distance:.1} mm \
         before turn {}", index + 1
    )]
    Straight {
        /// The name of the vehicle.
        vehicle: alloc::string::String,
        /// The index of the turn after the straight.
        index: usize,
        /// The length of the straight, in mm.
        distance: f64,
        /// The speed before the straight, in mm/s.
        from: f64,
        /// The speed after the straight, in mm/s.
        to: f64,
    },
}

/// The straight after a turn or from the start: what the calculation of its time needs.
struct Leg {
    after: f64,
    speed: f64,
}

impl FastRun {
    /// Returns the time in s that the vehicle needs for the run.
    ///
    /// # Errors
    /// Returns an error if the vehicle cannot drive the run.
    pub fn time(&self, vehicle: &Vehicle) -> Result<f64, DriveError> {
        let mut total = 0.0;
        self.for_each_leg(vehicle, |_, line, distance, from, to, turn| {
            let time = line.time(distance, from, to)?;
            let arc = turn.and_then(|turn| vehicle.arc(turn.kind));
            total += time + arc.map_or(0.0, |fitted| fitted.arc.length / to);
            Some(())
        })?;
        Ok(total)
    }

    /// Returns the run in time, as driven by the vehicle.
    ///
    /// # Errors
    /// Returns an error if the vehicle cannot drive the run.
    pub fn drive(&self, vehicle: &Vehicle) -> Result<Trajectory, DriveError> {
        let half_cell = vehicle.half_cell();
        let (start, heading) = (Point::centre(self.start()), self.direction().angle());
        let offset = if self.is_empty() { 0.0 } else { vehicle.parameters().start_offset };
        let mut end = Moment {
            time: 0.0,
            distance: 0.0,
            x: f64::from(start.i) * half_cell - offset * cos(heading),
            y: f64::from(start.j) * half_cell - offset * sin(heading),
            heading,
            speed: 0.0,
            acceleration: 0.0,
            angular_velocity: 0.0,
        };
        let mut segments = Vec::with_capacity(2 * self.turns().len() + 1);
        self.for_each_leg(vehicle, |straight, line, length, from, to, turn| {
            let pieces: Vec<_> = line.pieces(length, from, to)?.collect();
            let duration = pieces.iter().map(|piece| piece.duration).sum();
            let shape = Shape::Straight(straight);
            segments.push(Segment { shape, entry: end, duration, length, exit_speed: to, pieces });
            let turn = turn.and_then(|turn| Some((turn, vehicle.arc(turn.kind)?.arc.length)));
            if let Some((turn, length)) = turn {
                let (shape, entry) =
                    (Shape::Turn(turn.kind, turn.side), segments[segments.len() - 1].exit());
                let (duration, pieces) = (length / to, Vec::new());
                segments.push(Segment { shape, entry, duration, length, exit_speed: to, pieces });
            }
            end = segments[segments.len() - 1].exit();
            Some(())
        })?;
        Ok(Trajectory { segments, half_cell, end })
    }

    /// Calls `visit` for each straight, with its number of lattice steps, its limits, its distance
    /// in mm, the speeds at its ends and the turn after it. `visit` returns `None` if the straight
    /// is too short.
    fn for_each_leg(
        &self,
        vehicle: &Vehicle,
        mut visit: impl FnMut(u8, &Line, f64, f64, f64, Option<&Turn>) -> Option<()>,
    ) -> Result<(), DriveError> {
        if self.is_empty() {
            return Ok(());
        }
        let parameters = vehicle.parameters();
        let mut leg = Leg { after: parameters.start_offset, speed: 0.0 };
        let mut is_diagonal = false;
        let mut straight = |index, steps, is_diagonal, leg: &Leg, before, speed, turn| {
            let distance = leg.after + vehicle.straight(steps, is_diagonal) + before;
            let line = vehicle.line(is_diagonal);
            visit(steps, line, distance, leg.speed, speed, turn).ok_or_else(|| {
                let vehicle = vehicle.name().into();
                DriveError::Straight { vehicle, index, distance, from: leg.speed, to: speed }
            })
        };
        for (index, turn) in self.turns().iter().enumerate() {
            let &Turn { straight: steps, kind, speed, .. } = turn;
            let fitted =
                vehicle.arc(kind).filter(|fitted| speed > 0.0 && speed <= fitted.arc.speed);
            let fitted = fitted.ok_or_else(|| {
                let vehicle = vehicle.name().into();
                DriveError::Turn { vehicle, index, kind, speed }
            })?;
            straight(index, steps, is_diagonal, &leg, fitted.before, speed, Some(turn))?;
            leg = Leg { after: fitted.after, speed };
            is_diagonal = kind.ends_diagonal();
        }
        let index = self.turns().len();
        straight(index, self.last(), is_diagonal, &leg, parameters.stop_offset, 0.0, None)
    }
}

impl Trajectory {
    /// Returns the segments: straight, turn, straight, turn, …, straight.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns the duration in s, from rest to rest.
    pub const fn duration(&self) -> f64 {
        self.end.time
    }

    /// Returns the length, in mm.
    pub const fn length(&self) -> f64 {
        self.end.distance
    }

    /// Returns the greatest speed, in mm/s.
    pub fn top_speed(&self) -> f64 {
        self.segments.iter().map(Segment::top_speed).fold(0.0, libm::fmax)
    }

    /// Returns half the distance between the centres of two neighbouring cells, in mm. It converts
    /// the coordinates of a [`Moment`] to cells.
    pub const fn half_cell(&self) -> f64 {
        self.half_cell
    }

    /// Returns the state of the mouse at a time in s. Times outside of the run count as its
    /// beginning or end.
    pub fn at(&self, time: f64) -> Moment {
        let index = self.segments.partition_point(|segment| segment.entry.time <= time);
        match self.segments.get(index.saturating_sub(1)) {
            Some(segment) if time < self.end.time => segment.at(time - segment.entry.time),
            _ => self.end,
        }
    }

    /// Returns the state of the mouse after a distance in mm. Distances outside of the run count
    /// as its beginning or end.
    pub fn at_distance(&self, distance: f64) -> Moment {
        let before = |segment: &Segment| segment.entry.distance <= distance;
        let index = self.segments.partition_point(before);
        match self.segments.get(index.saturating_sub(1)) {
            Some(segment) if distance < self.end.distance => {
                segment.at(segment.time_of(distance - segment.entry.distance))
            }
            _ => self.end,
        }
    }

    /// Returns states of the mouse at regular times, `interval` s apart, and the last one.
    ///
    /// # Panics
    /// Panics if the interval is not positive.
    pub fn samples(&self, interval: f64) -> impl Iterator<Item = Moment> {
        assert!(interval > 0.0, "expected a positive interval, found {interval}");
        let times = (0_u32..).map(move |index| f64::from(index) * interval);
        let regular = times.take_while(|&time| time < self.duration()).map(|time| self.at(time));
        regular.chain([self.end])
    }

    /// Returns the time in s from leaving the start cell to entering a goal cell, as contests
    /// measure it. The point of the mouse that is driven along the path opens and closes the gates.
    pub fn gate_to_gate(&self, goals: &CellSet) -> f64 {
        let cell = |moment: &Moment| self.cell(moment);
        let Some(start) = self.segments.first().map(|segment| cell(&segment.entry)) else {
            return 0.0;
        };
        let is_goal = |moment: &Moment| cell(moment).is_some_and(|cell| goals.contains(cell));
        let leaves = self.first(|moment| cell(moment) != start);
        let enters = self.first(is_goal);
        if enters > leaves { enters - leaves } else { 0.0 }
    }

    /// Returns the first time in s at which `is_past` holds, to 0.1 µs. Looks at one moment per mm.
    fn first(&self, is_past: impl Fn(&Moment) -> bool) -> f64 {
        let mut low = 0.0;
        let millimetres = (0_u32..).map(f64::from).take_while(|&mm| mm < self.length());
        for moment in millimetres.map(|mm| self.at_distance(mm)).chain([self.end]) {
            if !is_past(&moment) {
                low = moment.time;
                continue;
            }
            let mut high = moment.time;
            while high - low > 1e-7 {
                let middle = f64::midpoint(low, high);
                *(if is_past(&self.at(middle)) { &mut high } else { &mut low }) = middle;
            }
            return high;
        }
        self.duration()
    }

    /// Returns the cell in which the mouse is, or `None` to the west or south of the maze.
    pub fn cell(&self, moment: &Moment) -> Option<Cell> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let column = |position: f64| {
            let column = libm::floor(position / (2.0 * self.half_cell));
            (0.0..256.0).contains(&column).then_some(column as u8)
        };
        Some(Cell::new(column(moment.x)?, column(moment.y)?))
    }
}

impl Segment {
    /// Returns the greatest speed, in mm/s.
    pub fn top_speed(&self) -> f64 {
        let ends = self.pieces.iter().map(|piece| piece.at(piece.duration).1);
        ends.fold(self.entry.speed, libm::fmax)
    }

    /// Returns the state of the mouse at the end.
    pub fn exit(&self) -> Moment {
        Moment {
            speed: self.exit_speed,
            acceleration: 0.0,
            angular_velocity: 0.0,
            ..self.at(self.duration)
        }
    }

    /// Returns the state of the mouse at a time in s since the beginning of the segment.
    pub fn at(&self, time: f64) -> Moment {
        match self.shape {
            Shape::Straight(_) => self.on_straight(time),
            Shape::Turn(kind, side) => self.on_arc(kind, side, time),
        }
    }

    fn on_straight(&self, time: f64) -> Moment {
        let (mut distance, mut rest) = (0.0, time);
        let (mut speed, mut acceleration) = (self.entry.speed, 0.0);
        for piece in &self.pieces {
            let within = libm::fmin(rest, piece.duration);
            let (covered, now, change) = piece.at(within);
            (distance, speed, acceleration) = (distance + covered, now, change);
            rest -= within;
            if rest <= 0.0 {
                break;
            }
        }
        let (x, y, heading) = (self.entry.x, self.entry.y, self.entry.heading);
        Moment {
            time: self.entry.time + time,
            distance: self.entry.distance + distance,
            x: x + distance * cos(heading),
            y: y + distance * sin(heading),
            heading,
            speed,
            acceleration,
            angular_velocity: 0.0,
        }
    }

    fn on_arc(&self, kind: TurnKind, side: Side, time: f64) -> Moment {
        let distance = time * self.entry.speed;
        let q = distance / self.length;
        let angle = match side {
            Side::Left => kind.angle(),
            Side::Right => -kind.angle(),
        };
        let (forward, aside) = arc::displacement(angle, q);
        let (forward, aside) = (forward * self.length, aside * self.length);
        let (sin, cos) = (sin(self.entry.heading), cos(self.entry.heading));
        Moment {
            time: self.entry.time + time,
            distance: self.entry.distance + distance,
            x: self.entry.x + forward * cos - aside * sin,
            y: self.entry.y + forward * sin + aside * cos,
            heading: self.entry.heading + arc::heading(angle, q),
            speed: self.entry.speed,
            acceleration: 0.0,
            angular_velocity: self.entry.speed * arc::curvature(angle, self.length, q),
        }
    }

    /// Returns the time in s since the beginning of the segment at which the mouse has covered
    /// `distance` mm of it.
    fn time_of(&self, distance: f64) -> f64 {
        if let Shape::Turn(..) = self.shape {
            return distance / self.entry.speed;
        }
        let (mut time, mut rest) = (0.0, distance);
        for piece in &self.pieces {
            let length = piece.at(piece.duration).0;
            if rest < length {
                return time + time_within(piece, rest);
            }
            (time, rest) = (time + piece.duration, rest - length);
        }
        time
    }
}

/// Returns the time in s at which a mouse has covered `distance` mm of a piece.
fn time_within(piece: &Piece, distance: f64) -> f64 {
    if fabs(piece.jerk) > 0.0 {
        let (mut low, mut high) = (0.0, piece.duration);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            *(if piece.at(middle).0 < distance { &mut low } else { &mut high }) = middle;
        }
        return high;
    }
    let Piece { speed, acceleration, .. } = *piece;
    let root = sqrt(libm::fmax(speed * speed + 2.0 * acceleration * distance, 0.0));
    if speed + root > 0.0 { 2.0 * distance / (speed + root) } else { 0.0 }
}
