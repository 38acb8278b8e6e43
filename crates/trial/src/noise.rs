//! Noisy sensors.

use mmsim_maze::WyRand;

/// Sensor noise that makes each reading wrong by one cell with a given probability.
///
/// A wrong reading is equally likely to be too high or too low. If the true value is 0, a wrong
/// reading is always 1. The same seed gives the same errors.
///
/// ```
/// use mmsim_trial::SensorNoise;
/// assert_eq!(SensorNoise::none().apply([0, 3, 7]), [0, 3, 7]);
/// let [left, front, _] = SensorNoise::new(1., 7).apply([0, 3, 7]);
/// assert_eq!((left, front.abs_diff(3)), (1, 1));
/// ```
#[derive(Clone, Debug)]
pub struct SensorNoise {
    probability: f64,
    rng: WyRand,
}

impl SensorNoise {
    /// Creates noise-free sensors.
    pub fn none() -> Self {
        Self::new(0., 0)
    }

    /// Creates sensors whose readings are wrong with the given probability, from 0 to 1.
    pub fn new(probability: f64, seed: u64) -> Self {
        Self { probability, rng: WyRand::new(seed) }
    }

    /// Adds random errors to the readings.
    pub fn apply(&mut self, readings: [u8; 3]) -> [u8; 3] {
        readings.map(|cells| {
            if !self.rng.chance(self.probability) {
                cells
            } else if cells == 0 || self.rng.flip() {
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
    fn errors_have_the_given_rate_and_are_one_cell() {
        let mut noise = SensorNoise::new(0.25, 3);
        let mut wrong = 0;
        for _ in 0..10_000 {
            for (reading, cells) in noise.apply([0, 5, 30]).into_iter().zip([0, 5, 30]) {
                assert!(reading.abs_diff(cells) <= 1);
                wrong += u32::from(reading != cells);
            }
        }
        assert!((7_000..8_000).contains(&wrong), "{wrong} of 30,000");
    }
}
