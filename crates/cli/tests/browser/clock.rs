//! The time of a page.

use serde_json::json;

use crate::browser::Browser;

/// A script that makes the pauses of a page ten times as short. Longer timeouts stay as they are, because
/// the simulator knows nothing of the page's time.
pub(crate) const SHORT_PAUSES: &str = "
    const start = setTimeout;
    window.setTimeout = (run, pause = 0, ...rest) => start(run, pause > 5000 ? pause : pause / 10, ...rest);";

/// The clock of an animation, which a test has stopped.
pub(crate) struct Clock<'a>(&'a Browser);

impl<'a> Clock<'a> {
    pub(crate) fn stop(browser: &'a Browser) -> Self {
        let script = "
            window.clock = { now: performance.now(), frames: [], start: requestAnimationFrame };
            performance.now = () => window.clock.now;
            window.requestAnimationFrame = (frame) => window.clock.frames.push(frame);";
        browser.run::<()>(script, &[]);
        Self(browser)
    }

    /// Advances the clock by a time in ms, and draws a frame.
    pub(crate) fn advance(&self, ms: u32) {
        let script = "
            window.clock.now += arguments[0];
            for (const frame of window.clock.frames.splice(0)) frame(window.clock.now);";
        self.0.run::<()>(script, &[json!(ms)]);
    }

    pub(crate) fn restart(self) {
        let script = "
            window.requestAnimationFrame = window.clock.start;
            delete performance.now;
            for (const frame of window.clock.frames.splice(0)) requestAnimationFrame(frame);";
        self.0.run::<()>(script, &[]);
    }
}
