//! What a mouse is told.

use std::fmt;

/// The reply to a command, which [`Display`](fmt::Display) writes as mms does, without the end of the
/// line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reply {
    /// It was done.
    Ack,
    /// There was a wall in the way, or nowhere to go.
    Crash,
    /// Whether it is so.
    Truth(bool),
    /// A number of things.
    Whole(u64),
    /// A number that need not be whole.
    Decimal(Decimal),
    /// There is no such number yet: -1.
    Absent,
}

impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ack => f.write_str("ack"),
            Self::Crash => f.write_str("crash"),
            Self::Truth(truth) => write!(f, "{truth}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Decimal(number) => write!(f, "{number}"),
            Self::Absent => f.write_str("-1"),
        }
    }
}

/// A number with six significant digits, as `%g` of C and Qt write it.
///
/// ```
/// use mmsim_mms::Decimal;
/// let texts = [20., 3.5, 0.1 + 0.2, 1234567., 0.000_012_5].map(|number| Decimal(number).to_string());
/// assert_eq!(texts, ["20", "3.5", "0.3", "1.23457e+06", "1.25e-05"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimal(pub f64);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const DIGITS: i32 = 6;
        let rounded = format!("{:.5e}", self.0);
        let Some((mantissa, exponent)) = rounded.split_once('e') else {
            // Not a number, or infinite.
            return f.write_str(&rounded);
        };
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let without_zeros = |text: &str| {
            let is_whole = !text.contains('.');
            let end =
                if is_whole { text } else { text.trim_end_matches('0').trim_end_matches('.') };
            end.to_string()
        };
        if (-4..DIGITS).contains(&exponent) {
            let decimals = usize::try_from(DIGITS - 1 - exponent).unwrap_or(0);
            f.write_str(&without_zeros(&format!("{:.decimals$}", self.0)))
        } else {
            write!(f, "{}e{exponent:+03}", without_zeros(mantissa))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replies_are_their_words() {
        let replies = [
            Reply::Ack,
            Reply::Crash,
            Reply::Truth(true),
            Reply::Truth(false),
            Reply::Whole(16),
            Reply::Decimal(Decimal(2000.)),
            Reply::Absent,
        ];
        let words = ["ack", "crash", "true", "false", "16", "2000", "-1"];
        assert_eq!(replies.map(|reply| reply.to_string()), words);
    }

    #[test]
    fn decimals_have_six_digits() {
        for (number, text) in [
            (0., "0"),
            (0.5, "0.5"),
            (123.456_789, "123.457"),
            (999_999.4, "999999"),
            (999_999.6, "1e+06"),
            (100_000., "100000"),
            (1e100, "1e+100"),
            (0.000_1, "0.0001"),
            (-2.25, "-2.25"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Decimal(number).to_string(), text);
        }
    }
}
