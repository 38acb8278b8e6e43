//! The values of one measure.

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

    /// Returns the indices of the mazes in which every candidate has a value. Candidates without
    /// any value are ignored: otherwise, one candidate that fails in every maze would leave no maze
    /// to compare the others in.
    pub fn common_mazes(&self) -> Vec<usize> {
        let rows = || self.0.iter().filter(|row| has_values(row));
        let mazes = rows().next().map_or(0, Vec::len);
        (0..mazes).filter(|&maze| rows().all(|row| row[maze].is_some())).collect()
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
}

fn has_values(row: &[Option<f64>]) -> bool {
    row.iter().any(Option::is_some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_numbers_count_as_no_value() {
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e15, -1e15, 0.0];
        let values = Values::new(1, numbers.len(), |_, maze| Some(numbers[maze]));
        assert_eq!(values.row(0), [None, None, None, None, Some(-1e15), Some(0.0)]);
        assert!(values.row(1).is_empty());
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
