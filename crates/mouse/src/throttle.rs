//! The gate that a mouse passes between two steps: its pace, pauses, single steps, time limit and
//! stop.

use std::time::{Duration, Instant};

/// The slowest pace, in steps per second.
const MIN_RATE: f64 = 0.01;

/// A step that is at most this late does not delay the following steps. Timers may be this late.
pub(crate) const MAX_DELAY: Duration = Duration::from_millis(10);

/// The maximum number of single steps that a mouse may be granted in advance.
pub(crate) const MAX_SINGLE_STEPS: u32 = 1000;

/// The pace of a mouse, stored as the time from one step to the next.
///
/// ```
/// use mmsim_mouse::Pace;
/// use std::time::Duration;
/// assert_eq!(Pace::from_interval(Duration::from_millis(50)).rate(), Some(20.0));
/// assert_eq!(Pace::from_rate(1280.0), Some(Pace::from_interval(Duration::from_nanos(781_250))));
/// assert_eq!(Pace::UNLIMITED.rate(), None);
/// assert_eq!(Pace::from_rate(0.0), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace(Duration);

impl Pace {
    /// No limit: a mouse never waits.
    pub const UNLIMITED: Self = Self(Duration::ZERO);

    /// Returns the pace with this time between two steps. Zero means no limit.
    pub const fn from_interval(interval: Duration) -> Self {
        Self(interval)
    }

    /// Returns the pace in steps per second, or `None` if the rate is below 0.01 or not a number.
    pub fn from_rate(rate: f64) -> Option<Self> {
        let interval = (rate >= MIN_RATE).then(|| Duration::try_from_secs_f64(rate.recip()))?;
        interval.ok().map(Self)
    }

    /// Returns the steps per second, or `None` if there is no limit.
    pub fn rate(self) -> Option<f64> {
        (!self.0.is_zero()).then(|| self.0.as_secs_f64().recip())
    }
}

/// A gate that a mouse passes between two steps. It has a pace, can be paused, lets a paused mouse take
/// single steps, and can be stopped. The mouse must also stop when it reaches its time limit, which does
/// not include pauses.
#[derive(Debug)]
pub(crate) struct Throttle {
    pub(crate) pace: Pace,
    /// True if the mouse must stop.
    pub(crate) is_stopped: bool,
    /// The start of the current pause.
    paused_at: Option<Instant>,
    /// The number of steps that a paused mouse may still take.
    single_steps: u32,
    /// The time at which the last step was due.
    last: Instant,
    time_limit: Option<Duration>,
    started: Instant,
    /// The total duration of the previous pauses.
    paused: Duration,
}

impl Throttle {
    /// Returns an open gate with this pace and no time limit.
    pub(crate) fn new(pace: Pace) -> Self {
        let now = Instant::now();
        Self {
            pace,
            is_stopped: false,
            paused_at: None,
            single_steps: 0,
            last: now,
            time_limit: None,
            started: now,
            paused: Duration::ZERO,
        }
    }

    /// Opens the gate for another run with this time limit. Keeps the pace.
    pub(crate) fn restart(&mut self, time_limit: Option<Duration>) {
        *self = Self { time_limit, ..Self::new(self.pace) };
    }

    /// Returns the time since the start, without pauses.
    fn elapsed(&self, now: Instant) -> Duration {
        let until = self.paused_at.unwrap_or(now);
        until.saturating_duration_since(self.started).saturating_sub(self.paused)
    }

    /// Returns the time that the mouse has left, or `None` if there is no limit.
    pub(crate) fn time_left(&self, now: Instant) -> Option<Duration> {
        self.time_limit.map(|limit| limit.saturating_sub(self.elapsed(now)))
    }

    /// Decides what the mouse does now.
    pub(crate) fn next(&mut self, now: Instant) -> Next {
        let Pace(interval) = self.pace;
        let time_left = self.time_left(now);
        if self.is_stopped || time_left.is_some_and(|left| left.is_zero()) {
            return Next::Stop;
        }
        if self.single_steps > 0 {
            self.single_steps -= 1;
            self.last = now;
            return Next::Step;
        }
        if self.paused_at.is_some() {
            return Next::Pause;
        }
        // A due time that is too late to represent never comes.
        let due = self.last.checked_add(interval);
        let left = due.map_or(interval, |due| due.saturating_duration_since(now));
        if left.is_zero() {
            // The next step is due one interval after this step was due, even if the timer was
            // late, so that the pace is exact. A slow mouse does not catch up.
            let max_delay = interval.max(MAX_DELAY);
            self.last = due.filter(|&due| now - due < max_delay).unwrap_or(now);
            return Next::Step;
        }
        Next::Wait(time_left.map_or(left, |time_left| time_left.min(left)))
    }

    pub(crate) const fn is_paused(&self) -> bool {
        self.paused_at.is_some()
    }

    /// Holds the mouse after its current step and this number of further steps.
    pub(crate) fn pause(&mut self, steps: u32) {
        self.paused_at.get_or_insert_with(Instant::now);
        self.single_steps = MAX_SINGLE_STEPS.min(self.single_steps.saturating_add(steps));
    }

    /// Ends a pause.
    pub(crate) fn resume(&mut self) {
        self.paused += self.paused_at.take().map_or(Duration::ZERO, |at| at.elapsed());
        self.single_steps = 0;
    }
}

/// What a mouse does at the gate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    Step,
    Stop,
    /// Wait until the state changes.
    Pause,
    /// Wait until the state changes, but at most for this time.
    Wait(Duration),
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOURLY: Pace = Pace(Duration::from_secs(3600));

    #[test]
    fn a_step_is_due_one_interval_after_the_previous_one() {
        let mut throttle = Throttle::new(HOURLY);
        let at = |minutes: u64| throttle.started + Duration::from_secs(60 * minutes);
        let [early, late, again, missed] = [at(20), at(70), at(80), at(500)];
        let wait = |minutes: u64| Next::Wait(Duration::from_secs(60 * minutes));
        assert_eq!(throttle.next(early), wait(40));
        assert_eq!((throttle.next(late), throttle.next(late)), (Next::Step, wait(50)));
        assert_eq!(throttle.next(again), wait(40));
        assert_eq!((throttle.next(missed), throttle.next(missed)), (Next::Step, wait(60)));
    }

    #[test]
    fn a_paused_mouse_takes_exactly_the_granted_steps() {
        let mut throttle = Throttle::new(Pace::UNLIMITED);
        let mut next = |act: fn(&mut Throttle)| {
            act(&mut throttle);
            throttle.next(Instant::now())
        };
        assert_eq!(next(|throttle| throttle.pause(0)), Next::Pause);
        assert_eq!(next(|throttle| throttle.pause(2)), Next::Step);
        assert_eq!([next(|_| ()), next(|_| ())], [Next::Step, Next::Pause]);
        assert_eq!(next(|throttle| throttle.pause(u32::MAX)), Next::Step);
        assert_eq!(throttle.single_steps, MAX_SINGLE_STEPS - 1);
        throttle.resume();
        assert!((0..10).all(|_| throttle.next(Instant::now()) == Next::Step));
        assert!(!throttle.is_paused() && throttle.single_steps == 0);
    }

    #[test]
    fn a_restart_opens_the_gate() {
        let mut throttle = Throttle::new(Pace::from_rate(1000.0).unwrap());
        throttle.pause(1);
        throttle.is_stopped = true;
        assert_eq!([(); 2].map(|()| throttle.next(Instant::now())), [Next::Stop; 2]);
        throttle.restart(None);
        assert!(!throttle.is_stopped && !throttle.is_paused());
        assert_eq!(throttle.pace.rate(), Some(1000.0));
    }

    #[test]
    fn pauses_do_not_count_towards_the_time_limit() {
        let hour = Duration::from_secs(3600);
        let mut throttle = Throttle::new(Pace::UNLIMITED);
        let started = throttle.started;
        let at = |hours| started + hours * hour;
        (throttle.paused_at, throttle.paused) = (Some(at(5)), 2 * hour);
        assert_eq!(throttle.elapsed(at(9)), 3 * hour);
        throttle.paused_at = None;
        assert_eq!(throttle.elapsed(at(9)), 7 * hour);
    }

    #[test]
    fn a_mouse_without_time_left_stops() {
        let limited = |pace, limit| {
            let mut throttle = Throttle::new(pace);
            throttle.restart(Some(limit));
            throttle
        };
        let minute = Duration::from_secs(60);
        let mut throttle = limited(HOURLY, minute);
        let started = throttle.started;
        assert_eq!(throttle.next(started), Next::Wait(minute), "the next step is due in an hour");
        assert_eq!(throttle.next(started + minute), Next::Stop);
        assert_eq!(throttle.time_left(started + minute), Some(Duration::ZERO));
        assert_eq!(limited(Pace::UNLIMITED, minute).next(Instant::now()), Next::Step);
    }

    #[test]
    fn rates_are_checked() {
        for rate in [0.0, -1.0, 0.001, f64::NAN] {
            assert_eq!(Pace::from_rate(rate), None, "{rate}");
        }
        for rate in [0.25, 5.0, 20.0, 1280.0] {
            assert_eq!(Pace::from_rate(rate).unwrap().rate(), Some(rate));
        }
        assert_eq!(Pace::from_rate(f64::INFINITY), Some(Pace::UNLIMITED));
    }
}
