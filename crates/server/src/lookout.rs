//! Looking for the next request for a moment before going to sleep.
//!
//! To be woken costs more than to answer: a mouse that waits for its reply sends the next request
//! some 20 µs later, and a server that still looks then is twice as fast. It gives its processor to
//! whoever wants it between two looks. Where all processors have work to do, that can take
//! milliseconds while sleepers are preferred. So it keeps account of what looking gains and what it
//! costs: beside a browser that draws now and then it goes on, beside others who always have work it
//! looks ever less often.

use std::io;
use std::thread;
use std::time::{Duration, Instant};

/// How long it looks after something has come.
const LOOK: Duration = Duration::from_micros(50);

/// Others who keep the processor for so long have work of their own.
const CROWDED: Duration = Duration::from_micros(200);

/// What is gained where something is found: that much longer it takes to be woken.
const GAIN: Duration = Duration::from_micros(20);

/// What may be lost in a crowd, of what was gained before.
const MOST_GAINED: Duration = Duration::from_millis(80);

/// For so many sleeps there is no look at first once more was lost than gained, and at most.
const SLEEPS: u32 = 64;
const MOST_SLEEPS: u32 = 1 << 16;

/// Once so much was gained since, it is forgotten.
const FORGIVEN: Duration = Duration::from_millis(20);

/// Decides whether to look before the next sleep.
#[derive(Debug)]
pub(crate) struct Lookout {
    /// Whether something came the last time, so that more may come at any moment.
    expects: bool,
    /// Sleeps to go without a look.
    sleeps: u32,
    /// How many there will be the next time that it was not worth it.
    next_sleeps: u32,
    /// What looking has gained since then, less what it has cost.
    gained: Duration,
}

impl Lookout {
    pub(crate) const fn new() -> Self {
        Self { expects: false, sleeps: 0, next_sleeps: SLEEPS, gained: Duration::ZERO }
    }

    /// Looks for up to `most`, if it is likely to find something. Gives whether `look` has.
    pub(crate) fn look(
        &mut self,
        most: Duration,
        mut look: impl FnMut() -> io::Result<bool>,
    ) -> io::Result<bool> {
        if !self.begins() {
            return Ok(false);
        }
        let mut now = Instant::now();
        let end = now + most.min(LOOK);
        while now < end {
            if look()? {
                self.finds();
                return Ok(true);
            }
            thread::yield_now();
            let before = std::mem::replace(&mut now, Instant::now());
            if now - before >= CROWDED {
                self.loses(now - before);
            }
        }
        Ok(false)
    }

    /// Tells whether anything has come in the end, found or slept for.
    pub(crate) const fn has_come(&mut self, something: bool) {
        self.expects = something;
    }

    const fn begins(&mut self) -> bool {
        let looks = self.expects && self.sleeps == 0;
        self.sleeps = self.sleeps.saturating_sub(1);
        looks
    }

    fn finds(&mut self) {
        self.gained = (self.gained + GAIN).min(MOST_GAINED);
        if self.gained >= FORGIVEN {
            self.next_sleeps = SLEEPS;
        }
    }

    fn loses(&mut self, time: Duration) {
        if let Some(rest) = self.gained.checked_sub(time) {
            self.gained = rest;
        } else {
            self.gained = Duration::ZERO;
            self.sleeps = self.next_sleeps;
            self.next_sleeps = (4 * self.next_sleeps).min(MOST_SLEEPS);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(9);

    #[test]
    fn it_looks_only_after_something_has_come() {
        let mut lookout = Lookout::new();
        assert!(!lookout.look(LONG, || panic!("nothing has come")).unwrap());
        lookout.has_come(true);
        let mut looks = 0;
        let found = lookout.look(LONG, || {
            looks += 1;
            Ok(looks == 3)
        });
        // On a machine that stops for a while there may be fewer.
        assert_eq!(found.unwrap(), looks == 3);
        lookout.has_come(false);
        assert!(!lookout.look(LONG, || panic!("nothing has come")).unwrap());
    }

    #[test]
    fn it_does_not_look_for_ever_nor_past_an_error() {
        let mut lookout = Lookout::new();
        lookout.has_come(true);
        assert!(!lookout.look(LONG, || Ok(false)).unwrap());
        let mut lookout = Lookout::new();
        lookout.has_come(true);
        assert!(!lookout.look(Duration::ZERO, || panic!("no time")).unwrap());
        assert!(lookout.look(LONG, || Err(io::ErrorKind::Other.into())).is_err());
    }

    #[test]
    fn in_a_crowd_it_looks_ever_less_often_until_that_gains_again() {
        let mut lookout = Lookout::new();
        lookout.has_come(true);
        let sleeps = |lookout: &mut Lookout| {
            lookout.loses(CROWDED);
            std::iter::repeat_with(|| lookout.begins()).take_while(|looks| !looks).count()
        };
        assert_eq!(
            [0; 7].map(|_| sleeps(&mut lookout)),
            [64, 256, 1024, 4096, 16384, 65536, 65536]
        );
        while lookout.gained < FORGIVEN {
            lookout.finds();
        }
        // What was gained is lost first.
        lookout.loses(FORGIVEN);
        assert!(lookout.begins());
        assert_eq!(sleeps(&mut lookout), 64);
    }

    #[test]
    fn it_does_not_gain_for_ever() {
        let mut lookout = Lookout::new();
        lookout.has_come(true);
        for _ in 0..1_000_000 {
            lookout.finds();
        }
        lookout.loses(MOST_GAINED);
        assert!(lookout.begins());
        lookout.loses(CROWDED);
        assert!(!lookout.begins());
    }
}
