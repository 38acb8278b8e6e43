//! Numbers without a pattern, the same on every machine.

/// `SplitMix64`, by Steele, Lea and Flood ("Fast splittable pseudorandom number generators", OOPSLA
/// 2014): a counter whose bits are mixed. A seed promises a maze for ever, so this is ours and
/// never changes.
#[derive(Clone, Debug)]
pub(crate) struct Random {
    counter: u64,
}

impl Random {
    pub(crate) const fn new(seed: u64) -> Self {
        Self { counter: seed }
    }

    fn next(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.counter ^ self.counter >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// A number below `count`, or 0 if that is 0.
    // Half of the bits times the count: as even as the small counts here need it. What is left of
    // the product lies below the count.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn below(&mut self, count: u32) -> u32 {
        (((self.next() >> 32) * u64::from(count)) >> 32) as u32
    }

    /// A number from the first to the last of these.
    pub(crate) fn between(&mut self, [first, last]: [u32; 2]) -> u32 {
        first + self.below(last - first + 1)
    }

    /// The index of one of `count` things, fewer than 2³².
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn index(&mut self, count: usize) -> usize {
        self.below(count as u32) as usize
    }

    /// The index of one of these, each as likely as its weight says, `None` without any weight.
    pub(crate) fn weighted<const N: usize>(&mut self, weights: [u32; N]) -> Option<usize> {
        let mut rest = self.below(weights.iter().sum());
        weights.into_iter().position(|weight| {
            let is_drawn = rest < weight;
            rest = rest.saturating_sub(weight);
            is_drawn
        })
    }

    /// These in another order.
    pub(crate) fn shuffled<T>(&mut self, all: impl IntoIterator<Item = T>) -> Vec<T> {
        let mut all: Vec<T> = all.into_iter().collect();
        for count in (2..=all.len()).rev() {
            all.swap(count - 1, self.index(count));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_splitmix64() {
        let mut random = Random::new(1_234_567);
        let numbers =
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(numbers.map(|_| random.next()), numbers);
    }

    #[test]
    fn all_that_may_come_does_about_equally_often() {
        let mut random = Random::new(1);
        let mut counts = [0; 7];
        for _ in 0..7_000 {
            counts[random.below(7) as usize] += 1;
        }
        assert!(counts.iter().all(|count| (850..1_150).contains(count)), "{counts:?}");
        assert_eq!((random.below(0), random.below(1), random.between([3, 3])), (0, 0, 3));
        let mut counts = [0; 3];
        for _ in 0..4_000 {
            counts[random.weighted([1, 0, 3]).unwrap()] += 1;
        }
        assert!((850..1_150).contains(&counts[0]) && counts[1] == 0, "{counts:?}");
        assert_eq!(random.weighted([0, 0]), None);
    }

    #[test]
    fn shuffled_things_are_the_same_in_another_order() {
        let mut shuffled = Random::new(1).shuffled(0..20);
        assert!(!shuffled.is_sorted());
        shuffled.sort_unstable();
        assert!(shuffled.into_iter().eq(0..20));
    }
}
