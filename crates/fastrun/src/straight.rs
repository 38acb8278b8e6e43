//! Straights: the speed of a mouse over time.

use libm::{fmax, fmin, sqrt};

/// The limits of a mouse on a straight, in mm and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightLimits {
    /// The greatest acceleration, in mm/s².
    pub acceleration: f64,
    /// The greatest deceleration, in mm/s² (a positive number).
    pub braking: f64,
    /// The greatest speed, in mm/s.
    pub top_speed: f64,
    /// The greatest change of the acceleration, in mm/s³. Infinite by default: the acceleration
    /// changes at once.
    pub jerk: f64,
}

/// A part of a straight with constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The duration, in s.
    pub duration: f64,
    /// The speed at the beginning, in mm/s.
    pub speed: f64,
    /// The acceleration at the beginning, in mm/s².
    pub acceleration: f64,
    /// The change of the acceleration, in mm/s³.
    pub jerk: f64,
}

/// The squares of speeds may differ by this much, in mm²/s².
const TOLERANCE: f64 = 1e-9;

impl StraightLimits {
    /// Returns the least time in s in which a mouse covers `distance` mm, from the speed `from` to
    /// the speed `to` (mm/s). Returns `None` if the distance is too short for the change of speed,
    /// or if one of the speeds is above the top speed.
    ///
    /// Without a limit on the jerk, the mouse accelerates to a peak speed (at most the top speed),
    /// keeps it, and brakes. With a limit on the jerk, the acceleration rises and falls linearly,
    /// and is zero at both ends.
    ///
    /// ```
    /// use mmsim_fastrun::StraightLimits;
    /// let limits =
    ///     StraightLimits { acceleration: 17000.0, braking: 17000.0, top_speed: 2500.0, jerk: f64::INFINITY };
    /// let time = limits.time(2610.0, 0.0, 0.0).unwrap();
    /// assert!((time - 1.1911).abs() < 1e-4);
    /// assert_eq!(limits.time(10.0, 0.0, 2500.0), None);
    /// ```
    pub fn time(&self, distance: f64, from: f64, to: f64) -> Option<f64> {
        let drive = self.drive(distance, from, to)?;
        Some(drive.up.duration() + drive.cruise + drive.down.duration())
    }

    /// Returns the parts of the fastest drive over `distance` mm. The sum of their durations is
    /// [`time`](Self::time).
    pub fn pieces(
        &self,
        distance: f64,
        from: f64,
        to: f64,
    ) -> Option<impl Iterator<Item = Piece> + use<>> {
        let Drive { up, down, peak, cruise } = self.drive(distance, from, to)?;
        let rest = Piece { duration: cruise, speed: peak, acceleration: 0.0, jerk: 0.0 };
        let pieces = up.pieces(from, 1.0).into_iter().chain([rest]).chain(down.pieces(peak, -1.0));
        Some(pieces.filter(|piece| piece.duration > 0.0))
    }

    fn drive(&self, distance: f64, from: f64, to: f64) -> Option<Drive> {
        let peak = self.peak(distance, from, to)?;
        if distance <= 0.0 {
            return Some(Drive { up: Ramp::NONE, down: Ramp::NONE, peak, cruise: 0.0 });
        }
        let [up, down] = self.ramps(from, to, peak);
        let rest = distance - up.distance(from, peak) - down.distance(peak, to);
        Some(Drive { up, down, peak, cruise: fmax(rest, 0.0) / peak })
    }

    /// Returns the greatest speed of the drive, or `None` if the distance is too short.
    fn peak(&self, distance: f64, from: f64, to: f64) -> Option<f64> {
        let Self { acceleration: a, braking: b, top_speed, jerk } = *self;
        if fmax(from, to) > top_speed {
            return None;
        }
        if jerk == f64::INFINITY {
            if to * to > from * from + 2.0 * a * distance + TOLERANCE
                || from * from > to * to + 2.0 * b * distance + TOLERANCE
            {
                return None;
            }
            let square = (2.0 * a * b * distance + b * from * from + a * to * to) / (a + b);
            return Some(fmin(sqrt(square), top_speed));
        }
        let needed = |peak| {
            let [up, down] = self.ramps(from, to, peak);
            up.distance(from, peak) + down.distance(peak, to)
        };
        let (mut low, mut high) = (fmax(from, to), top_speed);
        if needed(low) > distance + TOLERANCE {
            return None;
        }
        if needed(high) <= distance {
            return Some(high);
        }
        // The distance grows with the peak speed. The bisection ends when no number is left
        // between the bounds.
        loop {
            let middle = low + (high - low) / 2.0;
            if middle <= low || middle >= high {
                return Some(low);
            }
            *(if needed(middle) <= distance { &mut low } else { &mut high }) = middle;
        }
    }

    /// Returns the changes of speed up to the peak and down from it.
    fn ramps(&self, from: f64, to: f64, peak: f64) -> [Ramp; 2] {
        let (up, down) = (fmax(peak - from, 0.0), fmax(peak - to, 0.0));
        [Ramp::new(up, self.acceleration, self.jerk), Ramp::new(down, self.braking, self.jerk)]
    }
}

/// The fastest drive over a straight: up to a peak speed, on at this speed, and down from it.
struct Drive {
    up: Ramp,
    down: Ramp,
    peak: f64,
    /// The duration at the peak speed, in s.
    cruise: f64,
}

/// A change of speed. The acceleration rises linearly, stays, and falls as it rose.
struct Ramp {
    acceleration: f64,
    /// The time in which the acceleration rises, in s.
    rise: f64,
    /// The time at the greatest acceleration, in s.
    hold: f64,
}

impl Ramp {
    const NONE: Self = Self { acceleration: 0.0, rise: 0.0, hold: 0.0 };

    fn new(difference: f64, limit: f64, jerk: f64) -> Self {
        let rise = limit / jerk;
        if difference >= limit * rise {
            Self { acceleration: limit, rise, hold: difference / limit - rise }
        } else {
            let rise = sqrt(difference / jerk);
            Self { acceleration: jerk * rise, rise, hold: 0.0 }
        }
    }

    fn duration(&self) -> f64 {
        2.0 * self.rise + self.hold
    }

    /// Returns the distance in mm. The change is symmetric, so the mean speed is that of its ends.
    fn distance(&self, from: f64, to: f64) -> f64 {
        f64::midpoint(from, to) * self.duration()
    }

    /// Returns the parts of the change, which begins at `speed`. The sign is 1 to speed up and -1
    /// to slow down.
    fn pieces(&self, speed: f64, sign: f64) -> [Piece; 3] {
        let acceleration = sign * self.acceleration;
        let jerk = if self.rise > 0.0 { acceleration / self.rise } else { 0.0 };
        let after_rise = speed + acceleration * self.rise / 2.0;
        let after_hold = after_rise + acceleration * self.hold;
        let (rise, hold) = (self.rise, self.hold);
        [
            Piece { duration: rise, speed, acceleration: 0.0, jerk },
            Piece { duration: hold, speed: after_rise, acceleration, jerk: 0.0 },
            Piece { duration: rise, speed: after_hold, acceleration, jerk: -jerk },
        ]
    }
}

impl Piece {
    /// Returns the distance in mm, the speed in mm/s and the acceleration in mm/s² at `time` s
    /// after the beginning of the piece.
    pub fn at(&self, time: f64) -> (f64, f64, f64) {
        let Self { speed, acceleration, jerk, .. } = *self;
        let distance = time * (speed + time * (acceleration / 2.0 + time * jerk / 6.0));
        let now = speed + time * (acceleration + time * jerk / 2.0);
        (distance, now, acceleration + time * jerk)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn limits(acceleration: f64, braking: f64, jerk: f64) -> StraightLimits {
        StraightLimits { acceleration, braking, top_speed: 2500.0, jerk }
    }

    /// Adds up many short stretches at the greatest speed that is possible there, both from the
    /// beginning and towards the end.
    fn by_small_steps(limits: &StraightLimits, distance: f64, from: f64, to: f64) -> f64 {
        let steps = 200_000;
        let width = distance / f64::from(steps);
        let speed = |place: f64| {
            let up = from * from + 2.0 * limits.acceleration * place;
            let down = to * to + 2.0 * limits.braking * (distance - place);
            up.min(down).sqrt().min(limits.top_speed)
        };
        (0..steps).map(|step| width / speed((f64::from(step) + 0.5) * width)).sum()
    }

    #[test]
    fn the_time_equals_that_of_many_small_steps() {
        for (distance, from, to) in
            [(2610.0, 0.0, 0.0), (300.0, 500.0, 1400.0), (90.0, 1000.0, 900.0), (900.0, 600.0, 0.0)]
        {
            let limits = limits(17000.0, 9000.0, f64::INFINITY);
            let (time, sum) = (
                limits.time(distance, from, to).unwrap(),
                by_small_steps(&limits, distance, from, to),
            );
            assert!((time - sum).abs() < 1e-3 * sum, "{distance} {from} {to}: {time} {sum}");
        }
    }

    #[test]
    fn a_straight_without_length_takes_no_time() {
        for jerk in [f64::INFINITY, 1e6] {
            let limits = limits(10_000.0, 8000.0, jerk);
            assert_eq!(limits.time(0.0, 700.0, 700.0), Some(0.0));
            assert_eq!(limits.time(0.0, 700.0, 701.0), None);
            assert_eq!(limits.pieces(0.0, 700.0, 700.0).unwrap().count(), 0);
        }
    }

    #[test]
    fn no_speed_is_above_the_top_speed() {
        for jerk in [f64::INFINITY, 1e6] {
            let limits = limits(10_000.0, 8000.0, jerk);
            assert!(limits.time(3000.0, 2500.0, 2500.0).is_some());
            assert_eq!(limits.time(3000.0, 2501.0, 0.0), None);
            assert_eq!(limits.time(3000.0, 0.0, 2501.0), None);
        }
    }

    proptest! {
        #[test]
        fn pieces_join_and_cover_the_distance(
            (distance, from, to) in (0.0..3000.0, 0.0..2500.0, 0.0..2500.0),
            (acceleration, braking) in (500.0..30_000.0, 500.0..30_000.0),
            jerk in prop_oneof![Just(f64::INFINITY), 1e4..1e7],
        ) {
            let limits = limits(acceleration, braking, jerk);
            let Some(time) = limits.time(distance, from, to) else {
                prop_assert!(limits.pieces(distance, from, to).is_none());
                // The change of speed alone needs this distance.
                let limit = if to > from { acceleration } else { braking };
                let difference = (to - from).abs();
                let duration = if difference * jerk > limit * limit {
                    difference / limit + limit / jerk
                } else {
                    2.0 * (difference / jerk).sqrt()
                };
                prop_assert!(distance < f64::midpoint(from, to) * duration);
                return Ok(());
            };
            let (mut covered, mut speed, mut duration) = (0.0, from, 0.0);
            for piece in limits.pieces(distance, from, to).unwrap() {
                prop_assert!((piece.speed - speed).abs() < 1e-6);
                let (length, end, last) = piece.at(piece.duration);
                prop_assert!(piece.acceleration.abs().max(last.abs()) < acceleration.max(braking) + 1e-6);
                prop_assert!(end < 2500.0 + 1e-6);
                (covered, speed, duration) = (covered + length, end, duration + piece.duration);
            }
            prop_assert!((duration - time).abs() < 1e-9);
            prop_assert!(distance == 0.0 || (covered - distance).abs() < 1e-5, "{covered} {distance}");
            prop_assert!(distance == 0.0 || (speed - to).abs() < 1e-5);
        }

        #[test]
        fn better_limits_and_slower_ends_are_never_slower(
            (distance, from, to) in (1.0..3000.0, 1.0..2500.0, 1.0..2500.0),
            jerk in prop_oneof![Just(f64::INFINITY), 1e4..1e7],
            factor in 1.0..2.0,
        ) {
            let limits = limits(10_000.0, 8000.0, jerk);
            let Some(time) = limits.time(distance, from, to) else { return Ok(()) };
            let better = [
                StraightLimits { acceleration: factor * limits.acceleration, ..limits },
                StraightLimits { braking: factor * limits.braking, ..limits },
                StraightLimits { top_speed: factor * limits.top_speed, ..limits },
                StraightLimits { jerk: factor * limits.jerk, ..limits },
            ];
            for better in better {
                prop_assert!(better.time(distance, from, to).unwrap() <= time + 1e-9);
            }
            let unlimited = StraightLimits { jerk: f64::INFINITY, ..limits };
            prop_assert!(unlimited.time(distance, from, to).unwrap() <= time + 1e-9);
            prop_assert!(limits.time(factor * distance, from, to).unwrap() >= time - 1e-9);
        }
    }
}
