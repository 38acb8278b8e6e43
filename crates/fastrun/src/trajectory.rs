//! A fast run in time: pose, speed and acceleration of the mouse at every moment.

use alloc::format;
use alloc::vec::Vec;

use libm::{cos, fabs, sin};
use mmsim_maze::{Cell, CellSet, Point};

use crate::run::{FastRun, Turn};
use crate::segment::{MotionState, Segment, Shape};
use crate::straight::StraightLimits;
use crate::turn::TurnKind;
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
/// # Ok::<(), mmsim_fastrun::TrajectoryError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    segments: Vec<Segment>,
    half_cell: f64,
    /// The centre of the start cell, in mm.
    start: (f64, f64),
    end: MotionState,
}

/// The reason why a vehicle cannot drive a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryError {
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
         before {}", turn.map_or("the end".into(), |index| format!("turn {}", index + 1))
    )]
    Straight {
        /// The name of the vehicle.
        vehicle: alloc::string::String,
        /// The index of the turn after the straight, or `None` for the last straight.
        turn: Option<usize>,
        /// The length of the straight, in mm.
        distance: f64,
        /// The speed before the straight, in mm/s.
        from: f64,
        /// The speed after the straight, in mm/s.
        to: f64,
    },
}

impl FastRun {
    /// Returns the time in s that the vehicle needs for the run.
    ///
    /// # Errors
    /// Returns an error if the vehicle cannot drive the run.
    pub fn time(&self, vehicle: &Vehicle) -> Result<f64, TrajectoryError> {
        let mut total = 0.0;
        self.for_each_leg(vehicle, |_, limits, distance, from, to, turn| {
            let time = limits.time(distance, from, to)?;
            let arc = turn.and_then(|turn| vehicle.arc(turn.kind));
            total += time + arc.map_or(0.0, |fitted| fitted.arc.length / to);
            Some(())
        })?;
        Ok(total)
    }

    /// Returns the same straights and turns with the speeds at which the vehicle needs the least time.
    ///
    /// ```
    /// use mmsim_fastrun::{FastRun, Vehicle};
    /// use mmsim_maze::Cell;
    /// let run = FastRun::parse(Cell::new(0, 0), "N 2 45inR 2 45outL 0").unwrap();
    /// let run = run.with_fastest_speeds(&Vehicle::expert())?;
    /// assert_eq!(run.to_string(), "N 2 45inR@1400 2 45outL@1300 0");
    /// # Ok::<(), mmsim_fastrun::TrajectoryError>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the vehicle cannot drive the run at any speeds.
    pub fn with_fastest_speeds(&self, vehicle: &Vehicle) -> Result<Self, TrajectoryError> {
        let parameters = vehicle.parameters();
        let (mut entry, mut is_diagonal) = (parameters.start_offset, false);
        let mut exits = alloc::vec![Exit { speed: 0.0, time: 0.0, before: 0 }];
        // The exits before each turn.
        let mut earlier = Vec::with_capacity(self.turns().len());
        let too_short = |exits: &[Exit], turn, distance, to| {
            let (vehicle, from) = (vehicle.name().into(), exits.last().map_or(0.0, |it| it.speed));
            TrajectoryError::Straight { vehicle, turn, distance, from, to }
        };
        for (index, &Turn { straight, kind, speed, .. }) in self.turns().iter().enumerate() {
            let fitted = vehicle.arc(kind).ok_or_else(|| {
                let vehicle = vehicle.name().into();
                TrajectoryError::Turn { vehicle, index, kind, speed }
            })?;
            let distance = entry + vehicle.straight(straight, is_diagonal) + fitted.before;
            let (limits, speeds) = (vehicle.limits(is_diagonal), vehicle.speeds(kind));
            let reach = |&speed: &f64| {
                let straight = Exit::after_straight(&exits, limits, distance, speed)?;
                Some(Exit { time: straight.time + fitted.arc.length / speed, ..straight })
            };
            let next: Vec<Exit> = speeds.iter().filter_map(reach).collect();
            if next.is_empty() {
                let slowest = speeds.last().copied().unwrap_or_default();
                return Err(too_short(&exits, Some(index), distance, slowest));
            }
            earlier.push(core::mem::replace(&mut exits, next));
            (entry, is_diagonal) = (fitted.after, kind.ends_diagonal());
        }
        let distance = entry + vehicle.straight(self.last(), is_diagonal) + parameters.stop_offset;
        let end = Exit::after_straight(&exits, vehicle.limits(is_diagonal), distance, 0.0)
            .ok_or_else(|| too_short(&exits, None, distance, 0.0))?;
        let (mut turns, mut index) = (self.turns().to_vec(), end.before);
        for (turn, before) in turns.iter_mut().zip(earlier).rev() {
            if let Some(exit) = exits.get(index) {
                (turn.speed, index) = (exit.speed, exit.before);
            }
            exits = before;
        }
        Ok(Self::new(self.start(), self.direction(), turns, self.last()))
    }

    /// Returns the run in time, as driven by the vehicle.
    ///
    /// # Errors
    /// Returns an error if the vehicle cannot drive the run.
    pub fn drive(&self, vehicle: &Vehicle) -> Result<Trajectory, TrajectoryError> {
        let half_cell = vehicle.half_cell();
        let (centre, heading) = (Point::centre(self.start()), self.direction().angle());
        let start = (f64::from(centre.i) * half_cell, f64::from(centre.j) * half_cell);
        let offset = if self.is_empty() { 0.0 } else { vehicle.parameters().start_offset };
        let mut end = MotionState {
            x: start.0 - offset * cos(heading),
            y: start.1 - offset * sin(heading),
            heading,
            ..MotionState::default()
        };
        let mut segments = Vec::with_capacity(2 * self.turns().len() + 1);
        self.for_each_leg(vehicle, |straight, limits, length, from, to, turn| {
            let pieces: Vec<_> = limits.pieces(length, from, to)?.collect();
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
        Ok(Trajectory { segments, half_cell, start, end })
    }

    /// Calls `visit` for each straight, with its number of lattice steps, its limits, its distance
    /// in mm, the speeds at its ends and the turn after it. `visit` returns `None` if the straight
    /// is too short.
    fn for_each_leg(
        &self,
        vehicle: &Vehicle,
        mut visit: impl FnMut(u8, &StraightLimits, f64, f64, f64, Option<&Turn>) -> Option<()>,
    ) -> Result<(), TrajectoryError> {
        if self.is_empty() {
            return Ok(());
        }
        let parameters = vehicle.parameters();
        // The straight part before the first lattice step, and the speed there.
        let mut entry = (parameters.start_offset, 0.0);
        let mut is_diagonal = false;
        let mut straight =
            |index: Option<usize>, steps, is_diagonal, (after, from), before, to, turn| {
                let distance = after + vehicle.straight(steps, is_diagonal) + before;
                let limits = vehicle.limits(is_diagonal);
                visit(steps, limits, distance, from, to, turn).ok_or_else(|| {
                    let vehicle = vehicle.name().into();
                    TrajectoryError::Straight { vehicle, turn: index, distance, from, to }
                })
            };
        for (index, turn) in self.turns().iter().enumerate() {
            let &Turn { straight: steps, kind, speed, .. } = turn;
            let fitted =
                vehicle.arc(kind).filter(|fitted| speed > 0.0 && speed <= fitted.arc.speed);
            let fitted = fitted.ok_or_else(|| {
                let vehicle = vehicle.name().into();
                TrajectoryError::Turn { vehicle, index, kind, speed }
            })?;
            straight(Some(index), steps, is_diagonal, entry, fitted.before, speed, Some(turn))?;
            entry = (fitted.after, speed);
            is_diagonal = kind.ends_diagonal();
        }
        straight(None, self.last(), is_diagonal, entry, parameters.stop_offset, 0.0, None)
    }
}

/// The least time in which a mouse can end a turn at a speed.
#[derive(Clone, Copy)]
struct Exit {
    speed: f64,
    time: f64,
    /// The index of the exit of the turn before.
    before: usize,
}

impl Exit {
    /// Returns the fastest end of a straight at a speed, or `None` if the straight is too short.
    fn after_straight(
        exits: &[Self],
        limits: &StraightLimits,
        distance: f64,
        speed: f64,
    ) -> Option<Self> {
        let ends = exits.iter().enumerate().filter_map(|(before, exit)| {
            let time = exit.time + limits.time(distance, exit.speed, speed)?;
            Some(Self { speed, time, before })
        });
        ends.min_by(|a, b| a.time.total_cmp(&b.time))
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
    /// the coordinates of a [`MotionState`] to cells.
    pub const fn half_cell(&self) -> f64 {
        self.half_cell
    }

    /// Returns the state of the mouse at a time in s. Times outside of the run count as its
    /// beginning or end.
    pub fn at(&self, time: f64) -> MotionState {
        let index = self.segments.partition_point(|segment| segment.entry.time <= time);
        match self.segments.get(index.saturating_sub(1)) {
            Some(segment) if time < self.end.time => segment.at(time - segment.entry.time),
            _ => self.end,
        }
    }

    /// Returns the state of the mouse after a distance in mm. Distances outside of the run count
    /// as its beginning or end.
    pub fn at_distance(&self, distance: f64) -> MotionState {
        let before = |segment: &Segment| segment.entry.distance <= distance;
        let index = self.segments.partition_point(before);
        match self.segments.get(index.saturating_sub(1)) {
            Some(segment) if distance < self.end.distance => {
                segment.at(segment.time_of(distance - segment.entry.distance))
            }
            _ => self.end,
        }
    }

    /// Returns states of the mouse at regular distances, `spacing` mm apart, and the last one.
    ///
    /// # Panics
    /// Panics if the spacing is not positive.
    pub fn samples_along(&self, spacing: f64) -> impl Iterator<Item = MotionState> {
        assert!(spacing > 0.0, "expected a positive spacing, found {spacing} mm");
        (0_u32..)
            .map(move |index| f64::from(index) * spacing)
            .take_while(|&distance| distance < self.end.distance)
            .map(|distance| self.at_distance(distance))
            .chain([self.end])
    }

    /// Returns states of the mouse at regular times, `interval` s apart, and the last one.
    ///
    /// # Panics
    /// Panics if the interval is not positive.
    pub fn samples(&self, interval: f64) -> impl Iterator<Item = MotionState> {
        assert!(interval > 0.0, "expected a positive interval, found {interval}");
        let times = (0_u32..).map(move |index| f64::from(index) * interval);
        let regular = times.take_while(|&time| time < self.duration()).map(|time| self.at(time));
        regular.chain([self.end])
    }

    /// Returns the time in s from leaving the start cell to entering a goal cell, as contests
    /// measure it. The point of the mouse that is driven along the path opens and closes the gates.
    pub fn gate_to_gate(&self, goals: &CellSet) -> f64 {
        let is_goal =
            |state: &MotionState| self.cell(state).is_some_and(|cell| goals.contains(cell));
        // The run begins on the edge of the cell if the start offset is half a cell.
        let half = self.half_cell + 1e-6;
        let leaves = self.first(|state| {
            fabs(state.x - self.start.0) > half || fabs(state.y - self.start.1) > half
        });
        let enters = self.first(is_goal);
        if enters > leaves { enters - leaves } else { 0.0 }
    }

    /// Returns the first time in s at which `is_past` holds, to 0.1 µs. Looks at one moment per mm.
    fn first(&self, is_past: impl Fn(&MotionState) -> bool) -> f64 {
        let mut low = 0.0;
        for state in self.samples_along(1.0) {
            if !is_past(&state) {
                low = state.time;
                continue;
            }
            let mut high = state.time;
            while high - low > 1e-7 {
                let middle = f64::midpoint(low, high);
                *(if is_past(&self.at(middle)) { &mut high } else { &mut low }) = middle;
            }
            return high;
        }
        self.duration()
    }

    /// Returns the cell in which the mouse is, or `None` to the west or south of the maze.
    pub fn cell(&self, state: &MotionState) -> Option<Cell> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let column = |position: f64| {
            let column = libm::floor(position / (2.0 * self.half_cell));
            (0.0..256.0).contains(&column).then_some(column as u8)
        };
        Some(Cell::new(column(state.x)?, column(state.y)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::VehicleParameters;

    /// A mouse with other limits than `expert`.
    fn vehicle(change: impl FnOnce(&mut VehicleParameters)) -> Vehicle {
        let mut parameters = Vehicle::expert().parameters().clone();
        change(&mut parameters);
        Vehicle::new(parameters).unwrap()
    }

    #[test]
    fn the_clock_starts_at_the_edge_of_the_start_cell_in_each_direction() {
        for offset in [0.0, 45.0, 90.0] {
            let vehicle = vehicle(|parameters| parameters.start_offset = offset);
            let goals = [(5, 9), (9, 5), (5, 1), (1, 5)];
            for (direction, (x, y)) in ["N", "E", "S", "W"].into_iter().zip(goals) {
                let run = FastRun::parse(Cell::new(5, 5), &format!("{direction} 8")).unwrap();
                let trajectory = run.drive(&vehicle).unwrap();
                let time_at = |distance| trajectory.at_distance(offset + distance).time;
                let expected = time_at(7.0 * 90.0) - time_at(90.0);
                let time = trajectory.gate_to_gate(&[Cell::new(x, y)].into_iter().collect());
                assert!((time - expected).abs() < 1e-6, "{offset} {direction}: {time} {expected}");
            }
        }
    }

    #[test]
    fn errors_say_where_a_run_is_impossible() {
        let error = |run, vehicle: &Vehicle| {
            let run = FastRun::parse(Cell::new(0, 0), run).unwrap();
            assert_eq!(run.drive(vehicle).unwrap_err(), run.time(vehicle).unwrap_err());
            run.time(vehicle).unwrap_err().to_string()
        };
        let expert = Vehicle::expert();
        insta::assert_snapshot!(error("N 2 l90R@1900 2", &expert), @"expert cannot drive turn 1 (l90) at 1900 mm/s");
        let weak = vehicle(|parameters| parameters.along.braking = 6000.0);
        insta::assert_snapshot!(error("N 9 l90R@1400 0 s90L@600 2", &weak), @"expert cannot change its speed from 1400 to 600 mm/s within the 38.2 mm before turn 2");
        insta::assert_snapshot!(error("N 9 l90R@1400 0", &weak), @"expert cannot change its speed from 1400 to 0 mm/s within the 63.4 mm before the end");
    }
}
