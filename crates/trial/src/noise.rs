//! Sensors that err.

use fastrand::Rng;

/// Sensors that err: each reading is, with some probability, wrong by one cell.
///
/// It errs as often to more as to less; a reading of 0 errs to 1, since none is negative. The same
/// seed gives the same errors.
///
/// ```
/// use mmsim_trial::Noise;
/// assert_eq!(Noise::none().blur([0, 3, 7]), [0, 3, 7]);
/// let [left, front, _] = Noise::new(1., 7).blur([0, 3, 7]);
/// assert_eq!((left, front.abs_diff(3)), (1, 1));
/// ```
#[derive(Clone, Debug)]
pub struct Noise {
    probability: f64,
    random: Rng,
}

impl Noise {
    /// Sensors that never err.
    pub fn none() -> Self {
        Self::new(0., 0)
    }

    /// Sensors each of whose readings is wrong with this probability, 0 to 1.
    pub fn new(probability: f64, seed: u64) -> Self {
        Self { probability, random: Rng::with_seed(seed) }
    }

    /// The readings as the sensors tell them.
    pub fn blur(&mut self, readings: [u8; 3]) -> [u8; 3] {
        readings.map(|cells| {
            if self.random.f64() >= self.probability {
                cells
            } else if cells == 0 || self.random.bool() {
                cells.saturating_add(1)
            } else {
                cells - 1
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_err_as_often_as_they_shall_by_one_cell() {
        let mut noise = Noise::new(0.25, 3);
        let mut wrong = 0;
        for _ in 0..10_000 {
            for (told, true_cells) in noise.blur([0, 5, 30]).into_iter().zip([0, 5, 30]) {
                assert!(told.abs_diff(true_cells) <= 1);
                wrong += u32::from(told != true_cells);
            }
        }
        assert!((7_000..8_000).contains(&wrong), "{wrong} of 30,000");
    }
}
