//! The straights and turns of a fast run in time, and the state of the mouse on them.

use alloc::vec::Vec;

use libm::{cos, fabs, sin, sqrt};

use crate::arc;
use crate::straight::Piece;
use crate::turn::{Side, TurnKind};

/// A straight or the arc of a turn. A straight contains the straight parts of the turns before and
/// after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The straight or turn.
    pub shape: Shape,
    /// The state of the mouse at the beginning.
    pub entry: MotionState,
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

/// The pose and motion of a mouse at one moment of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionState {
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

impl Segment {
    /// Returns the greatest speed, in mm/s.
    pub fn top_speed(&self) -> f64 {
        let ends = self.pieces.iter().map(|piece| piece.at(piece.duration).1);
        ends.fold(self.entry.speed, libm::fmax)
    }

    /// Returns the state of the mouse at the end.
    pub fn exit(&self) -> MotionState {
        MotionState {
            speed: self.exit_speed,
            acceleration: 0.0,
            angular_velocity: 0.0,
            ..self.at(self.duration)
        }
    }

    /// Returns the state of the mouse at a time in s since the beginning of the segment.
    pub fn at(&self, time: f64) -> MotionState {
        match self.shape {
            Shape::Straight(_) => self.on_straight(time),
            Shape::Turn(kind, side) => self.on_arc(kind, side, time),
        }
    }

    fn on_straight(&self, time: f64) -> MotionState {
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
        MotionState {
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

    fn on_arc(&self, kind: TurnKind, side: Side, time: f64) -> MotionState {
        let distance = time * self.entry.speed;
        let q = distance / self.length;
        let angle = match side {
            Side::Left => kind.angle(),
            Side::Right => -kind.angle(),
        };
        let (forward, aside) = arc::displacement(angle, q);
        let (forward, aside) = (forward * self.length, aside * self.length);
        let (sin, cos) = (sin(self.entry.heading), cos(self.entry.heading));
        MotionState {
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
    pub(crate) fn time_of(&self, distance: f64) -> f64 {
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
