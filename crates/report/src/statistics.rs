//! The values of one measure, and their statistics.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF as _, Normal, StudentsT};
use statrs::statistics::Statistics as _;

/// The values of one measure: a row for each candidate, with a value for each maze in which the
/// candidate has one.
///
/// ```
/// use mmsim_report::Values;
/// let values = Values::new(2, 3, |candidate, maze| {
///     (candidate == 0 || maze != 1).then_some(10.0 * candidate as f64 + maze as f64)
/// });
/// assert_eq!(values.row(1), [Some(10.0), None, Some(12.0)]);
/// assert_eq!(values.common_mazes(), [0, 2]);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values(Vec<Vec<Option<f64>>>);

/// The largest absolute value. Sums and squares of such values are always finite.
const MAX: f64 = 1e15;

impl Values {
    /// Collects the values that `value` returns for the index of a candidate and the index of a
    /// maze. A number that is not finite, or whose absolute value exceeds 10¹⁵, counts as no value.
    pub fn new(
        candidates: usize,
        mazes: usize,
        mut value: impl FnMut(usize, usize) -> Option<f64>,
    ) -> Self {
        let mut value = |candidate, maze| value(candidate, maze).filter(|value| value.abs() <= MAX);
        let row = |candidate| (0..mazes).map(|maze| value(candidate, maze)).collect();
        Self((0..candidates).map(row).collect())
    }

    /// Returns the values of a candidate, one for each maze, or an empty slice if there is no
    /// candidate with this index.
    pub fn row(&self, candidate: usize) -> &[Option<f64>] {
        self.0.get(candidate).map_or(&[], Vec::as_slice)
    }

    /// Returns the values of all candidates.
    pub fn rows(&self) -> &[Vec<Option<f64>>] {
        &self.0
    }

    /// Returns the indices of the mazes in which every candidate has a value. Candidates with values in
    /// fewer than half as many mazes as another one are ignored: otherwise, one candidate that fails in
    /// most mazes would leave few mazes to compare the others in.
    pub fn common_mazes(&self) -> Vec<usize> {
        let rows = || self.0.iter().filter(|row| self.is_compared(row));
        let mazes = rows().next().map_or(0, Vec::len);
        (0..mazes).filter(|&maze| rows().all(|row| row[maze].is_some())).collect()
    }

    /// Returns true unless a row has no values, or values in fewer than half as many mazes as another.
    fn is_compared(&self, row: &[Option<f64>]) -> bool {
        let count = |row: &[Option<f64>]| row.iter().flatten().count();
        let most = self.0.iter().map(|row| count(row)).max().unwrap_or(0);
        has_values(row) && 2 * count(row) >= most
    }

    /// Returns the index of the first candidate that has any value. The other candidates are
    /// compared with this candidate.
    pub fn reference(&self) -> Option<usize> {
        self.0.iter().position(|row| has_values(row))
    }

    /// Returns the indices of the mazes in which both candidates have a value, and the value of
    /// `candidate` minus the value of `reference` in each of these mazes.
    ///
    /// ```
    /// use mmsim_report::Values;
    /// let values = Values::new(2, 2, |candidate, maze| Some((3 * candidate + maze) as f64));
    /// assert_eq!(values.differences(1, 0), [(0, 3.0), (1, 3.0)]);
    /// ```
    pub fn differences(&self, candidate: usize, reference: usize) -> Vec<(usize, f64)> {
        let pairs = self.row(candidate).iter().zip(self.row(reference)).enumerate();
        pairs.filter_map(|(maze, (value, other))| Some((maze, (*value)? - (*other)?))).collect()
    }

    /// Returns the statistics of each candidate.
    ///
    /// ```
    /// use mmsim_report::Values;
    /// let rows = [[Some(4.0), Some(8.0), None], [Some(7.0), Some(9.0), Some(5.0)]];
    /// let values = Values::new(2, 3, |candidate, maze| rows[candidate][maze]);
    /// let statistics = values.statistics();
    /// assert_eq!((statistics[1].mazes, statistics[1].common_mazes), (3, 2));
    /// assert_eq!(statistics[1].distribution.as_ref().unwrap().mean, 8.0);
    /// assert_eq!(statistics[1].difference.as_ref().unwrap().worse, 2);
    /// ```
    pub fn statistics(&self) -> Vec<Statistics> {
        let (common, reference) = (self.common_mazes(), self.reference());
        let statistics = |(candidate, row): (usize, &Vec<Option<f64>>)| {
            let is_compared = self.is_compared(row);
            let numbers = common.iter().filter(|_| is_compared).filter_map(|&maze| row[maze]);
            let reference = reference.filter(|&reference| reference != candidate);
            let difference = reference.and_then(|reference| {
                let differences = self.differences(candidate, reference).into_iter();
                Difference::new(&differences.map(|(_, difference)| difference).collect::<Vec<_>>())
            });
            Statistics {
                mazes: row.iter().flatten().count(),
                common_mazes: common.len(),
                is_compared,
                distribution: Distribution::new(numbers.collect()),
                difference,
            }
        };
        self.rows().iter().enumerate().map(statistics).collect()
    }
}

/// The statistics of one candidate. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// The number of mazes in which the candidate has a value.
    #[serde(rename = "maze_count")]
    pub mazes: usize,
    /// The number of mazes in which all compared candidates have a value (see
    /// [`Values::common_mazes`]).
    #[serde(rename = "common_maze_count")]
    pub common_mazes: usize,
    /// True unless the candidate has values in so few mazes that it is ignored there.
    #[serde(skip)]
    pub is_compared: bool,
    /// The distribution of the candidate's values in the common mazes, or `None` if there are no
    /// common mazes or if the candidate has too few values.
    pub distribution: Option<Distribution>,
    /// The difference to the [reference](Values::reference), or `None` for the reference itself
    /// and for a candidate without a maze in which both have a value.
    pub difference: Option<Difference>,
}

/// The distribution of at least one number. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Distribution {
    /// The arithmetic mean.
    pub mean: f64,
    /// The median.
    pub median: f64,
    /// The first quartile: a quarter of the numbers are smaller. Quartiles are interpolated
    /// linearly between the two nearest numbers (type 7 of Hyndman and Fan, the default of R,
    /// `NumPy` and spreadsheets).
    pub lower_quartile: f64,
    /// The third quartile: a quarter of the numbers are larger.
    pub upper_quartile: f64,
    /// The sample standard deviation (with *n* − 1 as the divisor), or `None` for a single number.
    pub standard_deviation: Option<f64>,
    /// The smallest number.
    pub minimum: f64,
    /// The largest number.
    pub maximum: f64,
}

/// The paired difference of a candidate to the reference, over the mazes in which both have a
/// value. In each maze, the difference is the value of the candidate minus the value of the
/// reference. The field names are JSON keys.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The number of mazes in which both have a value.
    #[serde(rename = "maze_count")]
    pub mazes: usize,
    /// The mean difference. It is negative if the candidate needs less than the reference.
    pub mean: f64,
    /// The 95 % confidence interval of the mean difference (Student's *t*-distribution), or `None`
    /// for a single maze.
    pub confidence_interval: Option<Interval>,
    /// The number of mazes in which the candidate's value is lower than that of the reference.
    pub better: usize,
    /// The number of mazes in which both values are exactly equal.
    pub equal: usize,
    /// The number of mazes in which the candidate's value is higher.
    pub worse: usize,
}

/// An interval. The field names are JSON keys.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The lower end.
    pub lower: f64,
    /// The upper end.
    pub upper: f64,
}

impl Interval {
    /// Returns true if the number is in the interval or at one of its ends.
    ///
    /// ```
    /// use mmsim_report::Interval;
    /// assert!(Interval { lower: -1.0, upper: 0.0 }.contains(0.0));
    /// ```
    pub fn contains(self, number: f64) -> bool {
        self.lower <= number && number <= self.upper
    }
}

impl Distribution {
    /// Returns the distribution of finite numbers, or `None` if there are no numbers.
    ///
    /// ```
    /// use mmsim_report::Distribution;
    /// let distribution = Distribution::new(vec![4.0, 1.0, 3.0, 2.0]).unwrap();
    /// assert_eq!(distribution.lower_quartile, 1.75);
    /// ```
    pub fn new(mut numbers: Vec<f64>) -> Option<Self> {
        numbers.sort_by(f64::total_cmp);
        let (&minimum, &maximum) = (numbers.first()?, numbers.last()?);
        Some(Self {
            mean: mean(&numbers),
            median: quantile(&numbers, 0.5),
            lower_quartile: quantile(&numbers, 0.25),
            upper_quartile: quantile(&numbers, 0.75),
            standard_deviation: standard_deviation(&numbers),
            minimum,
            maximum,
        })
    }
}

impl Difference {
    fn new(differences: &[f64]) -> Option<Self> {
        let count = |is: fn(&f64) -> bool| differences.iter().filter(|number| is(number)).count();
        (!differences.is_empty()).then(|| Self {
            mazes: differences.len(),
            mean: mean(differences),
            confidence_interval: confidence_interval(differences),
            better: count(|&difference| difference < 0.0),
            equal: count(|&difference| difference == 0.0),
            worse: count(|&difference| difference > 0.0),
        })
    }
}

fn has_values(row: &[Option<f64>]) -> bool {
    row.iter().any(Option::is_some)
}

#[expect(clippy::cast_precision_loss, reason = "a number of mazes")]
fn count(numbers: &[f64]) -> f64 {
    numbers.len() as f64
}

/// Returns the arithmetic mean. The sum of integers is exact, unlike the running mean of a library,
/// so means of integers have no rounding errors such as `4.999999`.
fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / count(numbers)
}

/// Returns the sample standard deviation, or `None` for fewer than two numbers.
fn standard_deviation(numbers: &[f64]) -> Option<f64> {
    (numbers.len() > 1).then(|| numbers.std_dev())
}

/// Returns the number below which this share of the sorted numbers lies.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let position = (count(sorted) - 1.0) * share;
    let (below, above) = (sorted[position.floor() as usize], sorted[position.ceil() as usize]);
    below + (above - below) * position.fract()
}

/// Returns the 95 % confidence interval of the mean, or `None` for fewer than two numbers.
fn confidence_interval(numbers: &[f64]) -> Option<Interval> {
    let deviation = standard_deviation(numbers)?;
    let half = student_quantile(count(numbers) - 1.0)? * deviation / count(numbers).sqrt();
    let mean = mean(numbers);
    Some(Interval { lower: mean - half, upper: mean + half })
}

/// Returns the 97.5 % quantile of Student's *t*-distribution, or `None` for less than one degree of
/// freedom.
fn student_quantile(freedom: f64) -> Option<f64> {
    // With more degrees of freedom, the library loses digits, and the quantile differs from that of
    // the normal distribution by less than 0.005 %.
    if freedom > 30_000.0 {
        return Some(Normal::standard().inverse_cdf(0.975));
    }
    Some(StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn values(rows: &[Vec<Option<f64>>]) -> Values {
        Values::new(rows.len(), rows[0].len(), |candidate, maze| rows[candidate][maze])
    }

    fn assert_close(actual: f64, expected: f64) {
        assert!((actual - expected).abs() < 5e-4, "{actual} is not {expected}");
    }

    /// The table is worked out by hand:
    ///
    /// ```text
    /// maze         1    2    3    4    5    6
    /// a           10   20   30   40   50   60
    /// b           12   20   27    -   58   70    common mazes: 1, 2, 3, 5
    /// c            8   25   33   41   50    -
    /// b - a       +2    0   -3        +8  +10    sum 17, squared deviations 119.2 from the mean 3.4
    /// c - a       -2   +5   +3   +1    0         sum 7, squared deviations 29.2 from the mean 1.4
    /// ```
    #[test]
    fn statistics_equal_those_worked_out_by_hand() {
        let some =
            |row: [i32; 6]| row.map(|value| (value > 0).then_some(f64::from(value))).to_vec();
        let statistics = values(&[
            some([10, 20, 30, 40, 50, 60]),
            some([12, 20, 27, 0, 58, 70]),
            some([8, 25, 33, 41, 50, 0]),
        ])
        .statistics();
        assert_eq!(statistics.iter().map(|one| one.mazes).collect::<Vec<_>>(), [6, 5, 5]);
        assert!(statistics.iter().all(|one| one.common_mazes == 4));

        // a: 10, 20, 30, 50; deviations from 27.5 squared: 306.25 + 56.25 + 6.25 + 506.25 = 875.
        let a = statistics[0].distribution.as_ref().unwrap();
        assert_eq!((a.mean, a.median, a.minimum, a.maximum), (27.5, 25.0, 10.0, 50.0));
        assert_eq!((a.lower_quartile, a.upper_quartile), (17.5, 35.0));
        assert_close(a.standard_deviation.unwrap(), 17.0783); // √(875 / 3)

        // b: 12, 20, 27, 58; deviations from 29.25 squared: 297.5625 + 85.5625 + 5.0625 + 826.5625.
        let b = statistics[1].distribution.as_ref().unwrap();
        assert_eq!(
            (b.mean, b.median, b.lower_quartile, b.upper_quartile),
            (29.25, 23.5, 18.0, 34.75)
        );
        assert_close(b.standard_deviation.unwrap(), 20.1225); // √(1214.75 / 3)

        assert_eq!(statistics[0].difference, None);
        let b = statistics[1].difference.as_ref().unwrap();
        assert_eq!((b.mazes, b.better, b.equal, b.worse), (5, 1, 1, 3));
        assert_close(b.mean, 3.4);
        // t = 2.776 for 4 degrees of freedom; 2.776 · √(119.2 / 4 / 5) = 6.7780.
        let interval = b.confidence_interval.unwrap();
        assert_close(interval.lower, -3.3781);
        assert_close(interval.upper, 10.1781);
        let c = statistics[2].difference.as_ref().unwrap();
        assert_eq!((c.mazes, c.better, c.equal, c.worse), (5, 1, 1, 3));
        // 2.776 · √(29.2 / 4 / 5) = 3.3548.
        assert_close(c.mean, 1.4);
        assert_close(c.confidence_interval.unwrap().lower, -1.9548);
    }

    #[test]
    fn confidence_intervals_use_students_t() {
        // The numbers 0, 0, …, 1, 1 with n − 1 degrees of freedom and the quantile t from a table.
        for (numbers, t) in [(2, 12.706), (4, 3.182), (12, 2.201), (32, 2.040), (122, 1.980)] {
            let halves: Vec<f64> = (0..numbers).map(|n| f64::from(u8::from(n % 2 == 0))).collect();
            let Interval { lower, upper } = confidence_interval(&halves).unwrap();
            let half = t * standard_deviation(&halves).unwrap() / f64::from(numbers).sqrt();
            assert_close(upper - 0.5, half);
            assert_close(0.5 - lower, half);
        }
        assert_eq!(confidence_interval(&[1.0]), None);
        assert_eq!(confidence_interval(&[2.0; 3]), Some(Interval { lower: 2.0, upper: 2.0 }));
    }

    /// The formulas for one and two degrees of freedom, and values from tables.
    #[test]
    fn quantiles_equal_those_of_tables() {
        for (freedom, t) in [
            (1.0, (0.475 * std::f64::consts::PI).tan()),
            (2.0, 0.95 * (2.0_f64 / (1.0 - 0.95 * 0.95)).sqrt()),
            (5.0, 2.570_582),
            (10.0, 2.228_139),
            (30.0, 2.042_272),
            (100.0, 1.983_972),
            (1e3, 1.962_339),
            (1e4, 1.960_201),
            (1e5, 1.959_988),
            (1e6, 1.959_966),
            (1e9, 1.959_964),
        ] {
            let found = student_quantile(freedom).unwrap();
            assert!((found / t - 1.0).abs() < 5e-5, "{freedom}: {found} is not {t}");
        }
        assert_eq!(student_quantile(0.0), None);
    }

    #[test]
    fn a_single_maze_has_no_spread() {
        let statistics = values(&[vec![Some(3.0)], vec![Some(5.0)], vec![None]]).statistics();
        let distribution = statistics[1].distribution.as_ref().unwrap();
        assert_eq!((distribution.median, distribution.standard_deviation), (5.0, None));
        let difference = statistics[1].difference.as_ref().unwrap();
        assert_eq!((difference.mean, difference.confidence_interval), (2.0, None));
        assert_eq!((&statistics[2].distribution, &statistics[2].difference), (&None, &None));
    }

    #[test]
    fn candidates_without_a_common_maze_have_no_distribution() {
        let statistics = values(&[vec![Some(1.0), None], vec![None, Some(2.0)]]).statistics();
        for one in &statistics {
            assert_eq!((one.mazes, one.common_mazes), (1, 0));
            assert_eq!((&one.distribution, &one.difference), (&None, &None));
        }
    }

    /// Returns rows of values, all equally long.
    fn rows() -> impl Strategy<Value = Vec<Vec<Option<f64>>>> {
        (1usize..5, 1usize..12).prop_flat_map(|(candidates, mazes)| {
            let value = prop::option::weighted(0.8, (0..400).prop_map(f64::from));
            prop::collection::vec(prop::collection::vec(value, mazes), candidates)
        })
    }

    fn is_close(one: Option<f64>, other: Option<f64>) -> bool {
        match (one, other) {
            (Some(one), Some(other)) => (one - other).abs() < 1e-6,
            (one, other) => one.is_none() && other.is_none(),
        }
    }

    proptest! {
        #[test]
        fn permuting_the_candidates_permutes_the_rows(
            (rows, order) in rows().prop_flat_map(|rows| {
                let order = Just((1..rows.len()).collect::<Vec<_>>()).prop_shuffle();
                (Just(rows), order)
            }),
        ) {
            // The first candidate stays first, because the others are compared with it.
            let mut rows = rows;
            rows[0][0] = Some(1.0);
            let order: Vec<usize> = std::iter::once(0).chain(order).collect();
            let permuted: Vec<_> = order.iter().map(|&index| rows[index].clone()).collect();
            let (before, after) = (values(&rows).statistics(), values(&permuted).statistics());
            let expected: Vec<_> = order.iter().map(|&index| before[index].clone()).collect();
            prop_assert_eq!(after, expected);
        }

        #[test]
        fn a_candidate_differs_from_itself_by_nothing(row in rows().prop_map(|mut rows| rows.remove(0))) {
            let statistics = values(&[row.clone(), row.clone()]).statistics();
            prop_assert_eq!(&statistics[0].distribution, &statistics[1].distribution);
            let count = row.iter().flatten().count();
            let expected = (count > 0).then_some(Difference {
                mazes: count,
                mean: 0.0,
                confidence_interval: (count > 1).then_some(Interval { lower: 0.0, upper: 0.0 }),
                better: 0,
                equal: count,
                worse: 0,
            });
            prop_assert_eq!(&statistics[1].difference, &expected);
        }

        #[test]
        fn adding_a_constant_shifts_the_values_but_not_the_differences(
            rows in rows(),
            shift in (0..1000).prop_map(f64::from),
        ) {
            let shifted: Vec<Vec<_>> = (rows.iter())
                .map(|row| row.iter().map(|value| value.map(|value| value + shift)).collect())
                .collect();
            let (before, after) = (values(&rows).statistics(), values(&shifted).statistics());
            for (before, after) in before.iter().zip(&after) {
                prop_assert_eq!((before.mazes, before.common_mazes), (after.mazes, after.common_mazes));
                prop_assert_eq!(&before.difference, &after.difference);
                let numbers = |one: &Statistics, shift: f64| {
                    one.distribution.as_ref().map(|one| {
                        let Distribution { mean, median, lower_quartile, upper_quartile, .. } = *one;
                        let moved = [mean, median, lower_quartile, upper_quartile, one.minimum, one.maximum]
                            .map(|number| Some(number - shift));
                        [&moved[..], &[one.standard_deviation]].concat()
                    })
                };
                let (before, after) = (numbers(before, 0.0), numbers(after, shift));
                prop_assert_eq!(before.is_some(), after.is_some());
                for (before, after) in before.into_iter().flatten().zip(after.into_iter().flatten()) {
                    prop_assert!(is_close(before, after), "{:?} is not {:?}", after, before);
                }
            }
        }

        #[test]
        fn quartiles_divide_the_numbers(numbers in prop::collection::vec(-50.0..50.0, 1..40)) {
            let Distribution { mean, median, lower_quartile, upper_quartile, minimum, maximum, .. } =
                Distribution::new(numbers.clone()).unwrap();
            prop_assert!([minimum, lower_quartile, median, upper_quartile, maximum].is_sorted());
            prop_assert!(minimum <= mean + 1e-9 && mean <= maximum + 1e-9);
            for (quartile, quarters) in [(lower_quartile, 1), (median, 2), (upper_quartile, 3)] {
                let below = numbers.iter().filter(|&&number| number < quartile).count();
                let above = numbers.iter().filter(|&&number| number > quartile).count();
                let steps = numbers.len() - 1;
                prop_assert!(below <= (quarters * steps).div_ceil(4));
                prop_assert!(above <= ((4 - quarters) * steps).div_ceil(4));
            }
        }
    }

    #[test]
    fn unusable_numbers_count_as_no_value() {
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e15, -1e15, 0.0];
        let values = Values::new(1, numbers.len(), |_, maze| Some(numbers[maze]));
        assert_eq!(values.row(0), [None, None, None, None, Some(-1e15), Some(0.0)]);
        assert!(values.row(1).is_empty());
    }

    #[test]
    fn a_candidate_with_few_values_has_only_differences() {
        // The first candidate has a value in 2 of 5 mazes, the third one in 3.
        let rows = [[1, 2, 0, 0, 0], [3, 3, 3, 3, 3], [4, 0, 4, 4, 0]];
        let values = Values::new(3, 5, |candidate, maze| {
            Some(f64::from(rows[candidate][maze])).filter(|&value| value > 0.0)
        });
        assert_eq!(values.common_mazes(), [0, 2, 3]);
        let statistics = values.statistics();
        assert!(statistics[0].distribution.is_none() && statistics[2].distribution.is_some());
        let compared: Vec<_> = statistics.iter().map(|one| one.is_compared).collect();
        assert_eq!(compared, [false, true, true]);
        assert_eq!(
            statistics[1].difference.as_ref().map(|one| (one.mazes, one.mean)),
            Some((2, 1.5))
        );
    }

    #[test]
    fn a_candidate_without_values_does_not_limit_the_common_mazes() {
        let rows = [vec![None; 3], vec![Some(1.0), None, Some(2.0)], vec![Some(3.0); 3]];
        let values = Values::new(3, 3, |candidate, maze| rows[candidate][maze]);
        assert_eq!(values.common_mazes(), [0, 2]);
        assert_eq!(values.reference(), Some(1));
        assert_eq!(values.differences(2, 1), [(0, 2.0), (2, 1.0)]);
        assert!(values.differences(0, 1).is_empty());
        let none = Values::new(2, 3, |_, _| None);
        assert_eq!((none.common_mazes(), none.reference()), (vec![], None));
        assert!(Values::default().common_mazes().is_empty());
    }
}
