//! Numbers by chance that are the same on every machine.

/// The generator of Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. Part of
/// the format of scenes: what a seed gives never changes.
///
/// ```
/// use taffeta::topology::random::SplitMix64;
///
/// // Stiffness that differs by up to a tenth from spring to spring, the same in every run.
/// let stiffness = |seed| {
///     let mut random = SplitMix64::new(seed);
///     [(); 4].map(|()| 50.0 * (0.9 + 0.2 * random.unit()))
/// };
/// assert_eq!(stiffness(1), stiffness(1));
/// assert_ne!(stiffness(1), stiffness(2));
/// assert!(stiffness(1).iter().all(|k| (45.0..55.0).contains(k)));
/// ```
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// Starts from a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// A number in [0, 1), from the upper 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The upper 32 bits.
    pub fn bits(&mut self) -> u32 {
        (self.next() >> 32) as u32
    }

    /// A number below `end`, as the upper half of a product of 128 bits.
    pub fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.next()) * end as u128) >> 64) as usize
    }

    /// Two of `nodes` nodes, the smaller first.
    pub fn pair(&mut self, nodes: usize) -> [u32; 2] {
        let [a, b] = [self.below(nodes), self.below(nodes)].map(|i| i as u32);
        [a.min(b), a.max(b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        let mut random = SplitMix64::new(1_234_567);
        assert_eq!(random.next(), 6_457_827_717_110_365_317);
        assert_eq!(random.next(), 3_203_168_211_198_807_973);
        assert_eq!(u64::from(SplitMix64::new(1_234_567).bits()), 6_457_827_717_110_365_317 >> 32);
    }
}
