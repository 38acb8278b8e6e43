//! A pseudorandom number generator that gives the same numbers on every machine.

/// `SplitMix64`, the pseudorandom number generator of Steele, Lea and Flood ("Fast splittable
/// pseudorandom number generators", OOPSLA 2014), which mixes the bits of a counter. The algorithm
/// is implemented here because a new version of another crate could give different numbers for the
/// same seed.
#[derive(Clone, Debug)]
pub(crate) struct SplitMix64 {
    counter: u64,
}

impl SplitMix64 {
    pub(crate) const fn new(seed: u64) -> Self {
        Self { counter: seed }
    }

    fn next(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.counter ^ self.counter >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// Returns a random number below `count`, or 0 if `count` is 0.
    // Multiplying 32 random bits by the count is uniform enough for the small counts used here, and
    // the upper half of the product is below the count.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        (((self.next() >> 32) * u64::from(count)) >> 32) as u32
    }

    /// Returns a random number from `first` to `last`, inclusive.
    pub(crate) fn between(&mut self, [first, last]: [u32; 2]) -> u32 {
        first + self.below(last - first + 1)
    }

    /// Returns a random index below `count`. `count` must be less than 2³².
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn index(&mut self, count: usize) -> usize {
        self.below(count as u32) as usize
    }

    /// Returns a random index with a probability proportional to its weight, or `None` if all
    /// weights are 0.
    pub(crate) fn weighted<const N: usize>(&mut self, weights: [u32; N]) -> Option<usize> {
        let mut rest = self.below(weights.iter().sum());
        weights.into_iter().position(|weight| {
            let is_drawn = rest < weight;
            rest = rest.saturating_sub(weight);
            is_drawn
        })
    }

    /// Returns the items in random order.
    pub(crate) fn shuffled<T>(&mut self, items: impl IntoIterator<Item = T>) -> Vec<T> {
        let mut items: Vec<T> = items.into_iter().collect();
        for count in (2..=items.len()).rev() {
            items.swap(count - 1, self.index(count));
        }
        items
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_splitmix64() {
        let mut rng = SplitMix64::new(1_234_567);
        let numbers =
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(numbers.map(|_| rng.next()), numbers);
    }

    #[test]
    fn numbers_are_evenly_distributed() {
        let mut rng = SplitMix64::new(1);
        let mut counts = [0; 7];
        for _ in 0..7_000 {
            counts[rng.below(7) as usize] += 1;
        }
        assert!(counts.iter().all(|count| (850..1_150).contains(count)), "{counts:?}");
        assert_eq!((rng.below(0), rng.below(1), rng.between([3, 3])), (0, 0, 3));
        let mut counts = [0; 3];
        for _ in 0..4_000 {
            counts[rng.weighted([1, 0, 3]).unwrap()] += 1;
        }
        assert!((850..1_150).contains(&counts[0]) && counts[1] == 0, "{counts:?}");
        assert_eq!(rng.weighted([0, 0]), None);
    }

    #[test]
    fn shuffling_keeps_all_items() {
        let mut shuffled = SplitMix64::new(1).shuffled(0..20);
        assert!(!shuffled.is_sorted());
        shuffled.sort_unstable();
        assert!(shuffled.into_iter().eq(0..20));
    }
}
