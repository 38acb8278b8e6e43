//! The dynamics of a mouse.

use alloc::borrow::Cow;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::f64::consts::{PI, SQRT_2};
use core::ops::RangeInclusive;

use libm::fmin;

use crate::arc;
use crate::straight::StraightLimits;
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
    pub along: StraightLimits,
    /// The limits on diagonals, or `None` if the mouse does not drive diagonally.
    pub diagonal: Option<StraightLimits>,
    /// The turns that the mouse can do, each at most once.
    pub turns: Vec<(TurnKind, Arc)>,
    /// The distance in mm that the mouse stands behind the centre of the start cell.
    pub start_offset: f64,
    /// The distance in mm that the mouse may stop past the centre of a goal cell.
    pub stop_offset: f64,
    /// The speed in mm/s at which the mouse drives through cells while it searches or returns.
    pub search_speed: f64,
    /// The time in s that a quarter turn takes while the mouse searches or returns.
    pub search_turn_time: f64,
}

/// The arc of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The length, in mm.
    pub length: f64,
    /// The greatest speed on the arc, in mm/s.
    pub speed: f64,
}

impl Arc {
    /// Returns the greatest centripetal acceleration on the arc at its speed, in mm/s²:
    /// v²·1.5·θ/L, in the middle of the arc.
    ///
    /// ```
    /// use mmsim_fastrun::{Arc, TurnKind};
    /// let arc = Arc { length: 195.0, speed: 909.0 };
    /// let acceleration = arc.centripetal_acceleration(TurnKind::L90);
    /// assert!((acceleration - 9984.0).abs() < 1.0);
    /// assert!((arc.speed_at(TurnKind::L90, acceleration) - 909.0).abs() < 1e-9);
    /// ```
    pub fn centripetal_acceleration(&self, kind: TurnKind) -> f64 {
        self.speed * self.speed * arc::greatest_curvature(kind.angle(), self.length)
    }

    /// Returns the speed in mm/s at which the arc needs a centripetal acceleration in mm/s².
    pub fn speed_at(&self, kind: TurnKind, centripetal_acceleration: f64) -> f64 {
        let curvature = arc::greatest_curvature(kind.angle(), self.length);
        libm::sqrt(centripetal_acceleration / curvature)
    }
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
    #[error(
        "{key}: expected {} to {} {unit}, found {} {unit}{}",
        range.start(), range.end(), number(*.found), hint(*.found, unit, range)
    )]
    OutOfRange {
        /// The parameter, such as `along.top_speed` or `turns.l90.length`.
        key: Cow<'static, str>,
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
    FasterThanTopSpeed {
        /// The turn.
        kind: TurnKind,
        /// The speed of the turn, in mm/s.
        speed: f64,
        /// The top speed, in mm/s.
        top_speed: f64,
        /// Either `along rows and columns` or `on diagonals`.
        place: &'static str,
    },
    /// A turn onto or off a diagonal, but no limits for diagonals.
    #[error(
        "turn {kind} needs the limits of the mouse on diagonals \
         (set diagonal.acceleration and diagonal.top_speed)"
    )]
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
        "a mouse cannot {} {speed} mm/s, the speed of its slowest turn {kind}, within \
         {distance:.1} mm, the distance {}",
        if *.stops { "stop from" } else { "reach" },
        if *.stops { "after the last turn" } else { "before the first turn" }
    )]
    TooWeak {
        /// The slowest turn.
        kind: TurnKind,
        /// The speed of the slowest turn, in mm/s.
        speed: f64,
        /// The distance, in mm.
        distance: f64,
        /// True if the mouse cannot stop, false if it cannot reach the speed.
        stops: bool,
    },
}

impl VehicleError {
    /// Returns the parameter at fault, such as `along.top_speed` or `turns.l90.length`.
    ///
    /// ```
    /// use mmsim_fastrun::{Vehicle, VehicleError};
    /// assert_eq!(VehicleError::NoSmallTurn.key(), "turns");
    /// let mut parameters = Vehicle::expert().parameters().clone();
    /// parameters.half_cell = 45.0;
    /// assert_eq!(Vehicle::new(parameters).unwrap_err().key(), "turns.s90.length");
    /// ```
    pub fn key(&self) -> Cow<'static, str> {
        match self {
            Self::OutOfRange { key, .. } => key.clone(),
            Self::TooLong { kind, .. } => format!("turns.{kind}.length").into(),
            Self::WrongWidth { .. } => "turns.180.length".into(),
            Self::FasterThanTopSpeed { kind, .. } => format!("turns.{kind}.speed").into(),
            Self::NoDiagonal { kind } | Self::Twice { kind } => format!("turns.{kind}").into(),
            Self::NoSmallTurn => "turns".into(),
            Self::TooWeak { stops: true, .. } => "along.braking".into(),
            Self::TooWeak { stops: false, .. } => "along.acceleration".into(),
        }
    }

    /// Returns the second value of the conflict, if there is one.
    #[cfg(feature = "std")]
    pub(crate) fn other_key(&self) -> Option<Cow<'static, str>> {
        match self {
            Self::FasterThanTopSpeed { place, .. } if *place == ON_DIAGONALS => {
                Some("diagonal.top_speed".into())
            }
            Self::FasterThanTopSpeed { .. } => Some("along.top_speed".into()),
            Self::TooWeak { kind, .. } => Some(format!("turns.{kind}.speed").into()),
            _ => None,
        }
    }
}

const ON_DIAGONALS: &str = "on diagonals";

/// Suggests millimetres for a number that seems to be in metres.
fn hint(found: f64, unit: &str, range: &RangeInclusive<f64>) -> String {
    // The number has so few digits that the product is not exact.
    let millimetres = libm::round(found * 1e9) / 1e6;
    let seconds = found / 1e3;
    match unit.strip_prefix('m') {
        Some(metres) if range.contains(&millimetres) => {
            format!(" (if it is in {metres}, write {millimetres})")
        }
        None if unit == "s" && range.contains(&seconds) => {
            format!(" (if it is in ms, write {seconds})")
        }
        _ => String::new(),
    }
}

/// Writes a number, with an exponent if it has many digits.
fn number(number: f64) -> String {
    if libm::fabs(number) < 1e9 { format!("{number}") } else { format!("{number:e}") }
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
    pub fn new(mut parameters: VehicleParameters) -> Result<Self, VehicleError> {
        check_ranges(&parameters)?;
        let mut arcs = [None; 9];
        for &(kind, arc) in &parameters.turns {
            let place = &mut arcs[kind as usize];
            if place.is_some() {
                return Err(VehicleError::Twice { kind });
            }
            check_speed(&parameters, kind, arc.speed)?;
            *place = Some(fit(kind, arc, parameters.half_cell)?);
        }
        let mut speeds: Vec<f64> = parameters.turns.iter().map(|(_, arc)| arc.speed).collect();
        speeds.sort_by(|a, b| b.total_cmp(a));
        speeds.dedup();
        let small = arcs[TurnKind::S90 as usize].ok_or(VehicleError::NoSmallTurn)?;
        let by_speed = |a: &&(TurnKind, Arc), b: &&(TurnKind, Arc)| a.1.speed.total_cmp(&b.1.speed);
        let slowest = parameters.turns.iter().min_by(by_speed);
        let (kind, Arc { speed, .. }) = slowest.copied().unwrap_or((TurnKind::S90, small.arc));
        let along = &parameters.along;
        let first = parameters.start_offset + parameters.half_cell + small.before;
        let last = small.after + parameters.half_cell + parameters.stop_offset;
        for (distance, stops, time) in [
            (first, false, along.time(first, 0.0, speed)),
            (last, true, along.time(last, speed, 0.0)),
        ] {
            if time.is_none() {
                return Err(VehicleError::TooWeak { kind, speed, distance, stops });
            }
        }
        for (kind, arc) in &mut parameters.turns {
            // The exact length of the turn by 180° replaces a rounded one.
            *arc = arcs[*kind as usize].map_or(*arc, |fitted| fitted.arc);
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

    /// Returns the time in s of a search with a number of steps, each to the neighbouring cell, and of
    /// quarter turns.
    ///
    /// ```
    /// use mmsim_fastrun::Vehicle;
    /// // 10 cells of 180 mm at 600 mm/s, and 5 turns of 0.2 s.
    /// assert!((Vehicle::expert().search_time(10, 5) - 4.0).abs() < 1e-12);
    /// // 10 cells of 90 mm at 300 mm/s, and 5 turns of 0.25 s.
    /// assert!((Vehicle::kerise().search_time(10, 5) - 4.25).abs() < 1e-12);
    /// ```
    pub fn search_time(&self, steps: u32, turns: u32) -> f64 {
        let VehicleParameters { half_cell, search_speed, search_turn_time, .. } = self.parameters;
        f64::from(steps) * (2.0 * half_cell / search_speed) + f64::from(turns) * search_turn_time
    }

    /// Returns the arc of a turn, or `None` if the mouse cannot do the turn.
    pub const fn arc(&self, kind: TurnKind) -> Option<&FittedArc> {
        self.arcs[kind as usize].as_ref()
    }

    /// Returns the greatest centripetal acceleration in a turn at its greatest speed, in mm/s², or
    /// `None` if the mouse cannot do the turn.
    ///
    /// ```
    /// use mmsim_fastrun::{STANDARD_GRAVITY, TurnKind, Vehicle};
    /// let acceleration = Vehicle::expert().centripetal_acceleration(TurnKind::L90).unwrap();
    /// assert!((acceleration / STANDARD_GRAVITY - 2.3).abs() < 0.01);
    /// ```
    pub fn centripetal_acceleration(&self, kind: TurnKind) -> Option<f64> {
        self.arc(kind).map(|fitted| fitted.arc.centripetal_acceleration(kind))
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
    pub fn limits(&self, is_diagonal: bool) -> &StraightLimits {
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
    let check = |key: Cow<'static, str>, found, unit, range: RangeInclusive<f64>| {
        // NaN is in no range.
        if range.contains(&found) {
            Ok(())
        } else {
            Err(VehicleError::OutOfRange { key, found, unit, range })
        }
    };
    let VehicleParameters {
        half_cell,
        along,
        diagonal,
        turns,
        start_offset,
        stop_offset,
        search_speed,
        search_turn_time,
        ..
    } = parameters;
    check("half_cell".into(), *half_cell, "mm", 5.0..=500.0)?;
    check("start_offset".into(), *start_offset, "mm", 0.0..=*half_cell)?;
    check("stop_offset".into(), *stop_offset, "mm", 0.0..=*half_cell)?;
    check("search_speed".into(), *search_speed, "mm/s", 10.0..=20_000.0)?;
    check("search_turn_time".into(), *search_turn_time, "s", 0.0..=10.0)?;
    for (limits, place) in [(Some(along), "along"), (diagonal.as_ref(), "diagonal")] {
        let Some(limits) = limits else { continue };
        let key = |field: &str| Cow::Owned(format!("{place}.{field}"));
        check(key("acceleration"), limits.acceleration, "mm/s²", 100.0..=100_000.0)?;
        check(key("braking"), limits.braking, "mm/s²", 100.0..=100_000.0)?;
        check(key("top_speed"), limits.top_speed, "mm/s", 50.0..=20_000.0)?;
        if limits.jerk != f64::INFINITY {
            check(key("jerk"), limits.jerk, "mm/s³", 1000.0..=1e9)?;
        }
    }
    for (kind, arc) in turns {
        let key = |field: &str| Cow::Owned(format!("turns.{kind}.{field}"));
        check(key("length"), arc.length, "mm", 1.0..=10_000.0)?;
        check(key("speed"), arc.speed, "mm/s", 10.0..=20_000.0)?;
    }
    Ok(())
}

fn check_speed(
    parameters: &VehicleParameters,
    kind: TurnKind,
    speed: f64,
) -> Result<(), VehicleError> {
    let uses_diagonal = kind.begins_diagonal() || kind.ends_diagonal();
    let uses_along = !kind.begins_diagonal() || !kind.ends_diagonal();
    if uses_diagonal && parameters.diagonal.is_none() {
        return Err(VehicleError::NoDiagonal { kind });
    }
    let limits = [
        (uses_along, Some(&parameters.along), "along rows and columns"),
        (uses_diagonal, parameters.diagonal.as_ref(), ON_DIAGONALS),
    ];
    for (is_used, limits, place) in limits {
        if let Some(&StraightLimits { top_speed, .. }) =
            limits.filter(|limits| is_used && limits.top_speed < speed)
        {
            return Err(VehicleError::FasterThanTopSpeed { kind, speed, top_speed, place });
        }
    }
    Ok(())
}

/// Returns the length in mm of the arc that leads to the centre of the neighbouring cell.
pub(crate) fn length_of_180(half_cell: f64) -> f64 {
    2.0 * half_cell / arc::displacement(PI, 1.0).1
}

/// Places an arc between the beginning and the end of its turn.
fn fit(kind: TurnKind, arc: Arc, half_cell: f64) -> Result<FittedArc, VehicleError> {
    if kind == TurnKind::L180 {
        let (width, expected) = (arc::displacement(PI, 1.0).1, length_of_180(half_cell));
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
