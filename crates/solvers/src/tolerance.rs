//! The accepted difference between the best known run and the fastest run.

use core::fmt;
use core::str::FromStr;

/// The share of the fastest run's time by which the best known run may be slower, from 0 to 1.
///
/// ```
/// use mmsim_solvers::Tolerance;
/// let tolerance: Tolerance = "3%".parse()?;
/// assert_eq!(tolerance, "0.03".parse()?);
/// assert_eq!((tolerance.ratio(), tolerance.to_string()), (0.03, "3%".into()));
/// # Ok::<(), mmsim_solvers::InvalidTolerance>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Tolerance(f64);

/// The error for a tolerance that is not a number from 0 to 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a tolerance from 0 to 100%, such as 3% or 0.03, found {found:?}")]
#[non_exhaustive]
pub struct InvalidTolerance {
    /// The invalid tolerance.
    pub found: String,
}

impl Tolerance {
    /// The tolerance that accepts only the fastest run.
    pub const ZERO: Self = Self(0.0);

    /// Creates a tolerance from a number from 0 to 1.
    ///
    /// # Errors
    /// Returns an error if the number is less than 0, greater than 1 or not a number.
    pub fn new(ratio: f64) -> Result<Self, InvalidTolerance> {
        let is_valid = (0.0..=1.0).contains(&ratio);
        // Minus zero would be displayed with its sign.
        let valid = is_valid.then_some(Self(ratio.abs()));
        valid.ok_or_else(|| InvalidTolerance { found: ratio.to_string() })
    }

    /// Returns the tolerance as a number from 0 to 1.
    pub const fn ratio(self) -> f64 {
        self.0
    }
}

impl FromStr for Tolerance {
    type Err = InvalidTolerance;

    fn from_str(text: &str) -> Result<Self, InvalidTolerance> {
        let ratio = match text.strip_suffix('%') {
            Some(percent) => percent.trim_end().parse().map(|percent: f64| percent / 100.0),
            None => text.parse(),
        };
        let tolerance = ratio.ok().and_then(|ratio| Self::new(ratio).ok());
        tolerance.ok_or_else(|| InvalidTolerance { found: text.into() })
    }
}

/// Writes the tolerance in percent, such as `3%`.
impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Rounded, because 0.07 times 100 is a little more than 7.
        write!(f, "{}%", (self.0 * 1e10).round() / 1e8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_percentages_or_ratios() {
        for (text, ratio, shown) in [
            ("0", 0.0, "0%"),
            ("-0", 0.0, "0%"),
            ("7%", 0.07, "7%"),
            ("0.5 %", 0.005, "0.5%"),
            ("0.07", 0.07, "7%"),
            ("1", 1.0, "100%"),
            ("100%", 1.0, "100%"),
        ] {
            let tolerance: Tolerance = text.parse().unwrap();
            assert!((tolerance.ratio() - ratio).abs() < 1e-12, "{text}");
            assert_eq!(tolerance.to_string(), shown);
        }
    }

    #[test]
    fn other_tolerances_are_errors() {
        for text in ["", "%", "3", "-1%", "101%", "NaN", "inf%", "3%%", "three"] {
            let error = text.parse::<Tolerance>().unwrap_err();
            assert_eq!(error, InvalidTolerance { found: text.into() });
        }
        for ratio in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            assert!(Tolerance::new(ratio).is_err(), "{ratio}");
        }
        let error = "3".parse::<Tolerance>().unwrap_err();
        insta::assert_snapshot!(error, @r#"expected a tolerance from 0 to 100%, such as 3% or 0.03, found "3""#);
    }
}
