//! The dynamics of a mouse.

use alloc::borrow::Cow;
use alloc::vec::Vec;
use core::f64::consts::{PI, SQRT_2};
use core::ops::RangeInclusive;

use libm::fmin;

use crate::arc;
use crate::line::Line;
use crate::turn::TurnKind;

/// The parameters of a mouse, in mm and s. [`Vehicle::new`] checks them.
#[derive(Clone, Debug, PartialEq)]
pub struct VehicleParameters {
    /// The name, for tables and messages.
    pub name: Cow<'static, str>,
    /// Half the distance between the centres of two neighbouring cells, in mm: 90 in classic mazes,
    /// 45 in half-size mazes.
    pub half_cell: f64,
    /// The limits along rows and columns.
    pub along: Line,
    /// The limits on diagonals, or `None` if the mouse does not drive diagonally.
    pub diagonal: Option<Line>,
    /// The turns that the mouse can do, each at most once.
    pub turns: Vec<(TurnKind, Arc)>,
    /// The distance in mm that the mouse stands behind the centre of the start cell.
    pub start_offset: f64,
    /// The distance in mm that the mouse may stop past the centre of a goal cell.
    pub stop_offset: f64,
}

/// The arc of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The length, in mm.
    pub length: f64,
    /// The greatest speed on the arc, in mm/s.
    pub speed: f64,
}

/// A mouse whose dynamics are known and possible.
///
/// ```
/// use mmsim_fastrun::{TurnKind, Vehicle};
/// let expert = Vehicle::expert();
/// assert_eq!(expert.parameters().along.top_speed, 2500.0);
/// assert_eq!(expert.speeds(TurnKind::L180), [1400.0, 1300.0, 1050.0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    parameters: VehicleParameters,
    arcs: [Option<FittedArc>; 9],
    /// The different greatest speeds of all turns, fastest first, in mm/s.
    speeds: Vec<f64>,
}

/// An arc and the straights that complete it to a turn on the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedArc {
    /// The arc.
    pub arc: Arc,
    /// The straight from the beginning of the turn to the arc, in mm.
    pub before: f64,
    /// The straight from the arc to the end of the turn, in mm.
    pub after: f64,
}

/// The reason why a vehicle is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VehicleError {
    /// A parameter is not within the limits of any micromouse.
    #[error("{what} of {found} {unit}: expected {} to {} {unit}{}", range.start(), range.end(), hint(*.found, range))]
    OutOfRange {
        /// The parameter.
        what: Cow<'static, str>,
        /// Its value.
        found: f64,
        /// Its unit.
        unit: &'static str,
        /// The accepted values.
        range: RangeInclusive<f64>,
    },
    /// An arc is too long for the straights that must complete it.
    #[error(
        "turn {kind} does not fit: its arc of {length} mm is {excess:.1} mm too long \
         (at most {} mm)", tenths_down(*.length - *.excess)
    )]
    TooLong {
        /// The turn.
        kind: TurnKind,
        /// The length of the arc, in mm.
        length: f64,
        /// The difference to the greatest length that fits, in mm.
        excess: f64,
    },
    /// The arc of the turn by 180° does not end at the centre of the neighbouring cell.
    #[error(
        "turn 180 does not fit: its arc of {length} mm ends {:.1} mm {} the centre of the \
         neighbouring cell (expected an arc of {expected:.2} mm)",
        libm::fabs(*.off), if *.off > 0.0 { "beyond" } else { "before" }
    )]
    WrongWidth {
        /// The length of the arc, in mm.
        length: f64,
        /// The only possible length, in mm.
        expected: f64,
        /// The distance between the end of the arc and the centre, in mm.
        off: f64,
    },
    /// A turn is faster than the straight that it joins.
    #[error("turn {kind} at {speed} mm/s is faster than the top speed of {top_speed} mm/s {place}")]
    FasterThanLine {
        /// The turn.
        kind: TurnKind,
        /// The speed of the turn, in mm/s.
        speed: f64,
        /// The top speed, in mm/s.
        top_speed: f64,
        /// Either `along` or `on diagonals`.
        place: &'static str,
    },
    /// A turn onto or off a diagonal, but no limits for diagonals.
    #[error("turn {kind} needs the limits of the mouse on diagonals, which are missing")]
    NoDiagonal {
        /// The turn.
        kind: TurnKind,
    },
    /// A turn is listed twice.
    #[error("turn {kind} is given twice")]
    Twice {
        /// The turn.
        kind: TurnKind,
    },
    /// The turn within a cell is missing, so not every cell can be reached.
    #[error("turn s90 is missing: without it, a mouse cannot reach every cell")]
    NoSmallTurn,
    /// The slowest turn is too fast to be reached from rest, or to stop after it.
    #[error(
        "a mouse cannot {} {speed} mm/s, the speed of its slowest turn, within {distance:.1} mm, \
         the distance {}",
        if *.stops { "stop from" } else { "reach" },
        if *.stops { "after the last turn" } else { "before the first turn" }
    )]
    TooWeak {
        /// The speed of the slowest turn, in mm/s.
        speed: f64,
        /// The distance, in mm.
        distance: f64,
        /// True if the mouse cannot stop, false if it cannot reach the speed.
        stops: bool,
    },
}

/// Suggests other units if the number fits in them.
fn hint(found: f64, range: &RangeInclusive<f64>) -> &'static str {
    if range.contains(&(found * 1000.0)) { " (all lengths are in mm; is it in m?)" } else { "" }
}

fn tenths_down(length: f64) -> f64 {
    libm::floor(length * 10.0) / 10.0
}

impl Vehicle {
    /// Checks the parameters of a mouse.
    ///
    /// # Errors
    /// Returns an error if a parameter is not plausible, if a turn does not fit on the lattice, or
    /// if the mouse cannot reach every cell that is connected to its start.
    pub fn new(parameters: VehicleParameters) -> Result<Self, VehicleError> {
        check_ranges(&parameters)?;
        let mut arcs = [None; 9];
        for &(kind, arc) in &parameters.turns {
            let place = &mut arcs[kind as usize];
            if place.is_some() {
                return Err(VehicleError::Twice { kind });
            }
            check_speed(&parameters, kind, arc)?;
            *place = Some(fit(kind, arc, parameters.half_cell)?);
        }
        let mut speeds: Vec<f64> = parameters.turns.iter().map(|(_, arc)| arc.speed).collect();
        speeds.sort_by(|a, b| b.total_cmp(a));
        speeds.dedup();
        let small = arcs[TurnKind::S90 as usize].ok_or(VehicleError::NoSmallTurn)?;
        let slowest = speeds.last().copied().unwrap_or(small.arc.speed);
        let along = &parameters.along;
        let first = parameters.start_offset + parameters.half_cell + small.before;
        let last = small.after + parameters.half_cell + parameters.stop_offset;
        for (distance, stops, time) in [
            (first, false, along.time(first, 0.0, slowest)),
            (last, true, along.time(last, slowest, 0.0)),
        ] {
            if time.is_none() {
                return Err(VehicleError::TooWeak { speed: slowest, distance, stops });
            }
        }
        Ok(Self { parameters, arcs, speeds })
    }

    /// Returns the parameters.
    pub const fn parameters(&self) -> &VehicleParameters {
        &self.parameters
    }

    /// Returns the name.
    pub fn name(&self) -> &str {
        &self.parameters.name
    }

    /// Returns half the distance between the centres of two neighbouring cells, in mm.
    pub const fn half_cell(&self) -> f64 {
        self.parameters.half_cell
    }

    /// Returns the arc of a turn, or `None` if the mouse cannot do the turn.
    pub const fn arc(&self, kind: TurnKind) -> Option<&FittedArc> {
        self.arcs[kind as usize].as_ref()
    }

    /// Returns the speeds in mm/s at which the mouse drives a turn: its greatest speed, and the
    /// greatest speeds of all slower turns, fastest first. The slice is empty if the mouse cannot
    /// do the turn.
    pub fn speeds(&self, kind: TurnKind) -> &[f64] {
        let Some(fitted) = self.arc(kind) else { return &[] };
        &self.speeds[self.speeds.partition_point(|&speed| speed > fitted.arc.speed)..]
    }

    /// Returns the limits along rows and columns, or on diagonals. A mouse that does not drive
    /// diagonally has no straights there, so the limits do not matter.
    pub fn line(&self, is_diagonal: bool) -> &Line {
        let Self { parameters: VehicleParameters { along, diagonal, .. }, .. } = self;
        if is_diagonal { diagonal.as_ref().unwrap_or(along) } else { along }
    }

    /// Returns the length in mm of a straight of `units` lattice steps.
    pub fn straight(&self, units: u8, is_diagonal: bool) -> f64 {
        let step = if is_diagonal { self.half_cell() * SQRT_2 } else { self.half_cell() };
        f64::from(units) * step
    }
}

fn check_ranges(parameters: &VehicleParameters) -> Result<(), VehicleError> {
    let check = |what: Cow<'static, str>, found, unit, range: RangeInclusive<f64>| {
        // NaN is in no range.
        if range.contains(&found) {
            Ok(())
        } else {
            Err(VehicleError::OutOfRange { what, found, unit, range })
        }
    };
    let VehicleParameters { half_cell, along, diagonal, turns, start_offset, stop_offset, .. } =
        parameters;
    check("half cell".into(), *half_cell, "mm", 5.0..=500.0)?;
    check("start offset".into(), *start_offset, "mm", 0.0..=*half_cell)?;
    check("stop offset".into(), *stop_offset, "mm", 0.0..=*half_cell)?;
    for (line, place) in [(Some(along), "along"), (diagonal.as_ref(), "on diagonals")] {
        let Some(line) = line else { continue };
        let name = |what: &str| Cow::Owned(alloc::format!("{what} {place}"));
        check(name("acceleration"), line.acceleration, "mm/s²", 100.0..=100_000.0)?;
        check(name("braking"), line.braking, "mm/s²", 100.0..=100_000.0)?;
        check(name("top speed"), line.top_speed, "mm/s", 50.0..=20_000.0)?;
        if line.jerk != f64::INFINITY {
            check(name("jerk"), line.jerk, "mm/s³", 1000.0..=1e9)?;
        }
    }
    for (kind, arc) in turns {
        let name = |what: &str| Cow::Owned(alloc::format!("{what} of turn {kind}"));
        check(name("length"), arc.length, "mm", 1.0..=10_000.0)?;
        check(name("speed"), arc.speed, "mm/s", 10.0..=20_000.0)?;
    }
    Ok(())
}

fn check_speed(
    parameters: &VehicleParameters,
    kind: TurnKind,
    arc: Arc,
) -> Result<(), VehicleError> {
    let uses_diagonal = kind.begins_diagonal() || kind.ends_diagonal();
    let uses_along = !kind.begins_diagonal() || !kind.ends_diagonal();
    if uses_diagonal && parameters.diagonal.is_none() {
        return Err(VehicleError::NoDiagonal { kind });
    }
    let lines = [
        (uses_along, Some(&parameters.along), "along"),
        (uses_diagonal, parameters.diagonal.as_ref(), "on diagonals"),
    ];
    for (is_used, line, place) in lines {
        if let Some(&Line { top_speed, .. }) =
            line.filter(|line| is_used && line.top_speed < arc.speed)
        {
            return Err(VehicleError::FasterThanLine { kind, speed: arc.speed, top_speed, place });
        }
    }
    Ok(())
}

/// Places an arc between the beginning and the end of its turn.
fn fit(kind: TurnKind, arc: Arc, half_cell: f64) -> Result<FittedArc, VehicleError> {
    if kind == TurnKind::L180 {
        let width = arc::displacement(PI, 1.0).1;
        let expected = 2.0 * half_cell / width;
        // The published lengths are rounded to 0.01 mm.
        if libm::fabs(arc.length - expected) > 0.01 {
            let off = arc.length * width - 2.0 * half_cell;
            return Err(VehicleError::WrongWidth { length: arc.length, expected, off });
        }
        let before = 8.0 / 15.0 * half_cell;
        return Ok(FittedArc { arc: Arc { length: expected, ..arc }, before, after: before });
    }
    let (to_corner, from_corner) = kind.geometry().corner;
    let tangent = arc::tangent(kind.angle());
    let room = |corner: f64| corner * half_cell - tangent * arc.length;
    let (before, after) = (room(to_corner), room(from_corner));
    let least = fmin(before, after);
    if least < 0.0 {
        let excess = -least / tangent;
        return Err(VehicleError::TooLong { kind, length: arc.length, excess });
    }
    Ok(FittedArc { arc, before, after })
}
