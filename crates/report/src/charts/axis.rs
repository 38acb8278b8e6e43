//! Axes with round ticks.

/// The scale of an axis. It begins and ends with a tick.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// The distance between two ticks, a power of ten times 1, 2 or 5.
    step: f64,
    /// The first and the last tick, in steps.
    first: f64,
    last: f64,
    /// The coordinates of the first and the last tick.
    from: f64,
    to: f64,
}

impl Axis {
    /// Creates the shortest axis with about `ticks` round ticks that contains all numbers.
    /// Coordinates run from `from` (the first tick) to `to` (the last tick).
    pub(crate) fn new(
        numbers: impl IntoIterator<Item = f64>,
        ticks: f64,
        (from, to): (f64, f64),
    ) -> Self {
        let range = numbers.into_iter().map(|number| (number, number));
        let range = range.reduce(|(low, high), (number, _)| (low.min(number), high.max(number)));
        let (mut low, mut high) = range.unwrap_or((0.0, 1.0));
        // Show 0 if it is not far away.
        if low > 0.0 && low < 0.4 * high {
            low = 0.0;
        } else if high < 0.0 && high > 0.4 * low {
            high = 0.0;
        }
        // Numbers that are almost equal would need ticks with too many digits.
        let least = (low.abs().max(high.abs()) * 1e-6).max(1e-6);
        if high - low < least {
            let margin = if high == 0.0 { 1.0 } else { high.abs() / 10.0 };
            (low, high) = (low - margin, high + margin);
        }
        let rough = (high - low) / ticks;
        let power = 10_f64.powf(rough.log10().floor());
        let factors = [1.0, 2.0, 5.0].into_iter();
        let step = factors.map(|factor| factor * power).find(|&step| step >= rough);
        let step = step.unwrap_or(10.0 * power);
        Self { step, first: (low / step).floor(), last: (high / step).ceil(), from, to }
    }

    /// Returns the coordinate of a number.
    pub(crate) fn at(&self, number: f64) -> f64 {
        let share = (number / self.step - self.first) / (self.last - self.first);
        self.from + share * (self.to - self.from)
    }

    /// Returns the coordinate and the label of each tick.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let ticks = std::iter::successors(Some(self.first), |tick| Some(tick + 1.0));
        let ticks = ticks.take_while(|&tick| tick <= self.last).map(|tick| tick * self.step);
        ticks.map(|tick| (self.at(tick), self.label(tick))).collect()
    }

    /// Formats a tick with as many decimals as its step has. Large numbers have an exponent.
    fn label(&self, tick: f64) -> String {
        let largest = self.first.abs().max(self.last.abs()) * self.step;
        if largest >= 1e6 && tick != 0.0 {
            return format!("{tick:e}").replace('-', "−");
        }
        let decimals = (0..9).find(|&decimals| {
            let scaled = self.step * 10_f64.powi(decimals);
            (scaled - scaled.round()).abs() < 1e-6
        });
        let decimals = usize::try_from(decimals.unwrap_or(9)).unwrap_or_default();
        let text = format!("{:.decimals$}", tick.abs());
        if tick < 0.0 { format!("−{text}") } else { text }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn labels(numbers: &[f64]) -> String {
        let axis = Axis::new(numbers.iter().copied(), 5.0, (0.0, 100.0));
        axis.ticks().into_iter().map(|(_, label)| label).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn ticks_are_round() {
        for (numbers, expected) in [
            (&[31.0, 212.0][..], "0 50 100 150 200 250"),
            (&[212.0, 231.0], "210 215 220 225 230 235"),
            (&[0.12, 0.31], "0.0 0.1 0.2 0.3 0.4"),
            (&[0.31, 0.33], "0.310 0.315 0.320 0.325 0.330"),
            (&[-17.0, 3.0], "−20 −15 −10 −5 0 5"),
            (&[-50.0, -20.0], "−50 −40 −30 −20"),
            (&[7.0], "6.0 6.5 7.0 7.5 8.0"),
            (&[0.0], "−1.0 −0.5 0.0 0.5 1.0"),
            (&[], "0.0 0.2 0.4 0.6 0.8 1.0"),
            (&[1.5e6, 7.5e6], "0 2e6 4e6 6e6 8e6"),
        ] {
            assert_eq!(labels(numbers), expected, "{numbers:?}");
        }
    }

    proptest! {
        #[test]
        fn an_axis_contains_all_numbers(
            numbers in prop::collection::vec((-1e3..1e3, 0..12), 1..20),
            ticks in 3.0..8.0,
        ) {
            let numbers: Vec<f64> =
                numbers.into_iter().map(|(number, power)| number * 10_f64.powi(power)).collect();
            let axis = Axis::new(numbers.iter().copied(), ticks, (10.0, 110.0));
            for number in numbers {
                let at = axis.at(number);
                prop_assert!((9.999..=110.001).contains(&at), "{number} at {at} of {axis:?}");
            }
            let ticks = axis.ticks();
            prop_assert!((2..=11).contains(&ticks.len()), "{ticks:?}");
            prop_assert!((ticks[0].0 - 10.0).abs() < 1e-6);
            prop_assert!((ticks[ticks.len() - 1].0 - 110.0).abs() < 1e-6);
        }
    }
}
