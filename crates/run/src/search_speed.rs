//! The speed of a mouse while it searches.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

/// The maximum time of a step or turn, in s.
const MAX_SECONDS: f64 = 3600.0;

/// The times that a mouse needs for a step and for a turn while it searches, in s.
/// The field names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SearchSpeed {
    /// The time for one cell.
    #[serde(rename = "cell_s")]
    step: f64,
    /// The time for a quarter turn.
    #[serde(rename = "turn_s")]
    turn: f64,
}

impl SearchSpeed {
    /// The default value as text: 0.6 m/s in a classic maze.
    pub const DEFAULT: &str = "0.3,0.2";

    /// Returns the time for a number of steps and quarter turns, in s.
    pub fn time(&self, steps: u32, turns: u32) -> f64 {
        f64::from(steps) * self.step + f64::from(turns) * self.turn
    }
}

impl FromStr for SearchSpeed {
    type Err = String;

    /// Parses the times for one cell and for a quarter turn, such as `0.3,0.2`.
    fn from_str(text: &str) -> Result<Self, String> {
        let time = |text: &str| {
            let seconds = text.trim().parse().ok();
            seconds.filter(|seconds| (0.0..=MAX_SECONDS).contains(seconds))
        };
        let times = text.split_once(',').and_then(|(step, turn)| Some((time(step)?, time(turn)?)));
        let (step, turn) = times.ok_or(
            "expected seconds per cell and seconds per quarter turn such as 0.3,0.2, \
             from 0 to 3600",
        )?;
        if step == 0.0 {
            return Err("the time per cell must be greater than 0".into());
        }
        Ok(Self { step, turn })
    }
}

impl fmt::Display for SearchSpeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s per cell and {} s per quarter turn", self.step, self.turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_a_step_and_a_turn_are_added() {
        let speed: SearchSpeed = "0.25, 0.5".parse().unwrap();
        assert!((speed.time(10, 3) - 4.0).abs() < 1e-12);
        assert_eq!(speed.to_string(), "0.25 s per cell and 0.5 s per quarter turn");
        assert!(SearchSpeed::DEFAULT.parse::<SearchSpeed>().is_ok());
        assert!("1,0".parse::<SearchSpeed>().is_ok());
        for wrong in ["", "0.3", "0.3 0.2", "-1,0.2", "0.3,-1", "nan,1", "inf,1", "1,3601"] {
            let error = wrong.parse::<SearchSpeed>().unwrap_err();
            assert!(error.starts_with("expected seconds per cell and "), "{wrong}: {error}");
        }
        for wrong in ["0,0", "0,0.2"] {
            let error = wrong.parse::<SearchSpeed>().unwrap_err();
            assert_eq!(error, "the time per cell must be greater than 0");
        }
    }
}
