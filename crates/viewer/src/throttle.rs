//! The gate that a mouse passes between two steps: its pace, pauses, single steps, time limit and
//! stop.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The slowest pace, in steps per second.
const MIN_RATE: f64 = 0.01;

/// The maximum number of single steps that a mouse may be granted in advance.
pub(crate) const MAX_SINGLE_STEPS: u32 = 1000;

/// The pace of a mouse, stored as the time from one step to the next.
///
/// ```
/// use mmsim_viewer::Pace;
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

/// A gate that a mouse passes between two steps. Other threads change the pace, pause the mouse, let
/// it take single steps, or stop it. Each change takes effect at once. The mouse must also stop when
/// it reaches its time limit, which does not include pauses.
#[derive(Debug)]
pub struct Throttle {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Clone, Debug)]
struct State {
    pace: Pace,
    is_stopped: bool,
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
    /// The number of restarts so far.
    run: u64,
}

impl State {
    fn new(pace: Pace, time_limit: Option<Duration>) -> Self {
        let now = Instant::now();
        Self {
            pace,
            is_stopped: false,
            paused_at: None,
            single_steps: 0,
            last: now,
            time_limit,
            started: now,
            paused: Duration::ZERO,
            run: 0,
        }
    }

    /// Returns the time since the start, without pauses.
    fn elapsed(&self, now: Instant) -> Duration {
        let until = self.paused_at.unwrap_or(now);
        until.saturating_duration_since(self.started).saturating_sub(self.paused)
    }

    fn time_left(&self, now: Instant) -> Option<Duration> {
        self.time_limit.map(|limit| limit.saturating_sub(self.elapsed(now)))
    }

    /// Decides what the mouse does now.
    fn next(&mut self, now: Instant) -> Next {
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
            // The next step is due one interval after this step was due, even if this thread woke
            // late, so that the pace is exact. A slow mouse does not catch up.
            self.last = due.filter(|&due| now - due < interval).unwrap_or(now);
            return Next::Step;
        }
        Next::Wait(time_left.map_or(left, |time_left| time_left.min(left)))
    }
}

/// What a mouse does at the gate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    Step,
    Stop,
    /// Wait until the state changes.
    Pause,
    /// Wait until the state changes, but at most for this time.
    Wait(Duration),
}

impl Throttle {
    /// Returns an open gate with this pace and no time limit.
    pub fn new(pace: Pace) -> Self {
        Self { state: Mutex::new(State::new(pace, None)), changed: Condvar::new() }
    }

    /// Blocks until the next step is allowed. Returns true if the mouse must stop instead, or if
    /// another run has begun.
    pub fn wait(&self) -> bool {
        let mut state = self.lock();
        let run = state.run;
        loop {
            if state.run != run {
                return true;
            }
            state = match state.next(Instant::now()) {
                Next::Stop => return true,
                Next::Step => return false,
                Next::Pause => self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
                Next::Wait(timeout) => {
                    let waited = self.changed.wait_timeout(state, timeout);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
            }
        }
    }

    /// Returns the time that the mouse has left, or `None` if there is no limit.
    pub fn time_left(&self) -> Option<Duration> {
        self.lock().time_left(Instant::now())
    }

    /// Returns the pace.
    pub fn pace(&self) -> Pace {
        self.lock().pace
    }

    /// Changes the pace. The new pace also applies to a step that the mouse is waiting for.
    pub fn set_pace(&self, pace: Pace) {
        self.change(|state| state.pace = pace);
    }

    /// Returns true if the mouse is paused.
    pub fn is_paused(&self) -> bool {
        self.lock().paused_at.is_some()
    }

    /// Holds the mouse after its current step.
    pub fn pause(&self) {
        self.change(|state| {
            state.paused_at.get_or_insert_with(Instant::now);
        });
    }

    /// Ends a pause.
    pub fn resume(&self) {
        self.change(|state| {
            state.paused += state.paused_at.take().map_or(Duration::ZERO, |at| at.elapsed());
            state.single_steps = 0;
        });
    }

    /// Lets the mouse take one step, then holds it.
    pub fn step(&self) {
        self.change(|state| {
            state.paused_at.get_or_insert_with(Instant::now);
            state.single_steps = MAX_SINGLE_STEPS.min(state.single_steps + 1);
        });
    }

    /// Stops the mouse: from now on, [`wait`](Self::wait) returns true at once.
    pub fn stop(&self) {
        self.change(|state| state.is_stopped = true);
    }

    /// Opens the gate for another run with this time limit. Keeps the pace.
    pub fn restart(&self, time_limit: Option<Duration>) {
        self.change(|state| {
            *state = State { run: state.run + 1, ..State::new(state.pace, time_limit) }
        });
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::mpsc::{self, Receiver};
    use std::thread;

    use super::*;
    use crate::wait::{TIMEOUT, wait_for};

    const HOURLY: Pace = Pace(Duration::from_secs(3600));

    /// Starts a mouse that reports each step. The channel closes when the mouse stops.
    fn mouse(throttle: &Arc<Throttle>) -> Receiver<()> {
        let (throttle, (send, steps)) = (Arc::clone(throttle), mpsc::sync_channel(0));
        thread::spawn(move || while !throttle.wait() && send.send(()).is_ok() {});
        steps
    }

    impl Throttle {
        pub(crate) fn single_steps(&self) -> u32 {
            self.lock().single_steps
        }

        /// Decides what a mouse would do now, without changing the state.
        fn next(&self) -> Next {
            self.lock().clone().next(Instant::now())
        }
    }

    fn step(steps: &Receiver<()>) {
        steps.recv_timeout(TIMEOUT).expect("a step");
    }

    #[test]
    fn another_run_ends_the_wait_of_a_mouse() {
        let throttle = Arc::new(Throttle::new(HOURLY));
        let steps = mouse(&throttle);
        wait_for("the end of the mouse", || {
            throttle.restart(None);
            matches!(steps.try_recv(), Err(mpsc::TryRecvError::Disconnected)).then_some(())
        });
        assert!(matches!(throttle.next(), Next::Wait(_)));
    }

    #[test]
    fn changes_take_effect_while_the_mouse_waits() {
        let throttle = Arc::new(Throttle::new(HOURLY));
        assert!(matches!(throttle.next(), Next::Wait(_)), "the first step is due in an hour");
        let steps = mouse(&throttle);
        throttle.set_pace(Pace::UNLIMITED);
        (0..100).for_each(|_| step(&steps));
        throttle.set_pace(HOURLY);
        throttle.stop();
        wait_for("the mouse to stop", || {
            matches!(steps.try_recv(), Err(mpsc::TryRecvError::Disconnected)).then_some(())
        });
    }

    #[test]
    fn a_paused_mouse_takes_exactly_the_granted_steps() {
        let throttle = Arc::new(Throttle::new(Pace::UNLIMITED));
        throttle.pause();
        for _ in 0..3 {
            throttle.step();
        }
        for _ in 0..3 {
            assert!(!throttle.wait());
        }
        assert!(throttle.is_paused());
        assert_eq!((throttle.next(), throttle.single_steps()), (Next::Pause, 0));
        let steps = mouse(&throttle);
        throttle.step();
        step(&steps);
        assert_eq!((throttle.next(), throttle.single_steps()), (Next::Pause, 0));
        throttle.resume();
        (0..10).for_each(|_| step(&steps));
        assert!(!throttle.is_paused());
        throttle.stop();
    }

    #[test]
    fn a_restart_opens_the_gate() {
        let throttle = Throttle::new(Pace::from_rate(1000.0).unwrap());
        throttle.step();
        throttle.stop();
        assert!(throttle.wait() && throttle.wait());
        throttle.restart(None);
        assert!((0..5).all(|_| !throttle.wait()), "neither stopped nor paused");
        assert_eq!(throttle.pace().rate(), Some(1000.0));
    }

    #[test]
    fn pauses_do_not_count_towards_the_time_limit() {
        let hour = Duration::from_secs(3600);
        let mut state = State::new(Pace::UNLIMITED, None);
        let started = state.started;
        let at = |hours| started + hours * hour;
        (state.paused_at, state.paused) = (Some(at(5)), 2 * hour);
        assert_eq!(state.elapsed(at(9)), 3 * hour);
        state.paused_at = None;
        assert_eq!(state.elapsed(at(9)), 7 * hour);
    }

    #[test]
    fn a_mouse_without_time_left_stops() {
        let limited = |pace, limit| {
            let throttle = Throttle::new(pace);
            throttle.restart(Some(limit));
            throttle
        };
        let throttle = limited(Pace::UNLIMITED, Duration::ZERO);
        assert!(throttle.wait() && throttle.time_left() == Some(Duration::ZERO));
        // The time limit also ends a wait for the next step, which is due in an hour.
        assert!(limited(HOURLY, Duration::from_millis(1)).wait());
        let throttle = limited(Pace::UNLIMITED, Duration::from_secs(3600));
        assert!(!throttle.wait() && throttle.time_left() > Some(Duration::ZERO));
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
