//! A pseudorandom number generator that gives the same numbers on every machine.

/// `wyrand`, the pseudorandom number generator of Wang Yi's [wyhash](https://github.com/wangyi-fudan/wyhash),
/// version 4.2. Each number is the 128-bit product of a counter and its exclusive or with a constant,
/// folded to 64 bits.
///
/// The same seed gives the same numbers on every machine and in every version.
///
/// ```
/// use mmsim_maze::{Heading, WyRand};
/// let (mut rng, mut same) = (WyRand::new(7), WyRand::new(7));
/// assert_eq!(rng.next_u64(), same.next_u64());
/// let mut headings = Heading::ALL;
/// rng.shuffle(&mut headings);
/// assert!(headings.contains(&Heading::ALL[rng.index(4)]));
/// ```
// Not from a library, because a new version of it might give other numbers.
#[derive(Clone, Debug)]
pub struct WyRand {
    counter: u64,
}

impl WyRand {
    /// Creates a generator with this seed.
    pub const fn new(seed: u64) -> Self {
        Self { counter: seed }
    }

    /// Returns 64 random bits.
    // The product is folded to 64 bits on purpose.
    #[allow(clippy::cast_possible_truncation)]
    pub const fn next_u64(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(0x2d35_8dcc_aa6c_78a5);
        let product = self.counter as u128 * (self.counter ^ 0x8bb8_4b93_962e_acc9) as u128;
        product as u64 ^ (product >> 64) as u64
    }

    /// Returns 32 random bits.
    #[allow(clippy::cast_possible_truncation)]
    pub const fn next_u32(&mut self) -> u32 {
        self.next_u64() as u32
    }

    /// Returns true or false with equal probability.
    pub const fn flip(&mut self) -> bool {
        self.next_u64() % 2 == 0
    }

    /// Returns true with this probability, from 0 to 1.
    // 53 bits are as many as a number has without loss.
    #[allow(clippy::cast_precision_loss)]
    pub fn chance(&mut self, probability: f64) -> bool {
        ((self.next_u64() >> 11) as f64) < probability * (1_u64 << 53) as f64
    }

    /// Returns a random number below `count`, or 0 if `count` is 0. The numbers are equally likely
    /// up to a difference of `count` / 2³².
    // The upper half of the product is below the count.
    #[allow(clippy::cast_possible_truncation)]
    pub const fn below(&mut self, count: u32) -> u32 {
        ((self.next_u32() as u64 * count as u64) >> 32) as u32
    }

    /// Returns a random index below `count`, or 0 if `count` is 0. The indices are equally likely up
    /// to a difference of `count` / 2⁶⁴.
    #[allow(clippy::cast_possible_truncation)]
    pub const fn index(&mut self, count: usize) -> usize {
        ((self.next_u64() as u128 * count as u128) >> 64) as usize
    }

    /// Returns a random number from `first` to `last`, inclusive.
    ///
    /// # Panics
    /// May panic if `last` is less than `first`.
    pub const fn between(&mut self, [first, last]: [u32; 2]) -> u32 {
        first + self.below(last - first + 1)
    }

    /// Returns a random index with a probability proportional to its weight, or `None` if all
    /// weights are 0. The sum of the weights must be less than 2³².
    pub fn weighted<const N: usize>(&mut self, weights: [u32; N]) -> Option<usize> {
        let mut rest = self.below(weights.iter().sum());
        weights.into_iter().position(|weight| {
            let is_drawn = rest < weight;
            rest = rest.saturating_sub(weight);
            is_drawn
        })
    }

    /// Puts the items in random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for count in (2..=items.len()).rev() {
            items.swap(count - 1, self.index(count));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_wyrand() {
        let mut rng = WyRand::new(1_234_567);
        let numbers =
            [13_725_641_357_320_173_039, 13_099_500_103_347_697_343, 1_505_849_618_603_060_667];
        assert_eq!(numbers.map(|_| rng.next_u64()), numbers);
    }

    #[test]
    fn numbers_are_evenly_distributed() {
        let mut rng = WyRand::new(1);
        let mut counts = [0; 7];
        for _ in 0..7_000 {
            counts[rng.index(7)] += 1;
        }
        assert!(counts.iter().all(|count| (850..1_150).contains(count)), "{counts:?}");
        assert_eq!((rng.below(0), rng.below(1), rng.between([3, 3])), (0, 0, 3));
        let mut counts = [0; 3];
        for _ in 0..4_000 {
            counts[rng.weighted([1, 0, 3]).unwrap()] += 1;
        }
        assert!((850..1_150).contains(&counts[0]) && counts[1] == 0, "{counts:?}");
        assert_eq!(rng.weighted([0, 0]), None);
        let count = (0..2_000).filter(|_| rng.flip()).count();
        assert!((850..1_150).contains(&count), "{count}");
        let count = (0..4_000).filter(|_| rng.chance(0.25)).count();
        assert!((850..1_150).contains(&count), "{count}");
        assert!((0..100).all(|_| rng.chance(1.0) && !rng.chance(0.0)));
    }

    #[test]
    fn shuffling_keeps_all_items() {
        let mut items: [usize; 20] = core::array::from_fn(|index| index);
        WyRand::new(1).shuffle(&mut items);
        assert!(!items.is_sorted());
        items.sort_unstable();
        assert!(items.into_iter().eq(0..20));
    }
}
