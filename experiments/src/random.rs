//! Reproducible chance: the same seed gives the same numbers in every version and on every machine.
//!
//! Numbers come from SplitMix64 (Steele, Lea and Flood 2014), which is a bijective mix of a counter:
//! number n of a stream is `mix(seed + (n + 1) · 0x9E3779B97F4A7C15)`. It is written out here, in ten
//! lines, because a library's generator may change its stream from one version to the next.

use sha2::{Digest, Sha256};
use shutterlab_data_schema::ParticipantCode;

/// A seed for one purpose in one session: the first 53 bits of the SHA-256 of
/// `shutterlab/PURPOSE/SEED/SUBJECT/SESSION`. 53 bits, because it is written into a CSV and every
/// program reads integers of that size exactly.
pub fn session_seed(
    purpose: &str,
    protocol_seed: u64,
    subject: &ParticipantCode,
    session: u32,
) -> u64 {
    let text = format!("shutterlab/{purpose}/{protocol_seed}/{subject}/{session}");
    let hash = Sha256::digest(text.as_bytes());
    hash.iter().take(8).fold(0, |seed, &byte| seed << 8 | u64::from(byte)) >> 11
}

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Stream {
    state: u64,
}

impl Stream {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The stream that belongs to number `key` under `seed`, whatever was drawn for other keys.
    pub fn keyed(seed: u64, key: u64) -> Self {
        Self { state: mix(seed ^ mix(key)) }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mix(self.state)
    }

    /// Uniform in [0, 1), in steps of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform among 0..`end`. `end` is at least 1; its bias is below `end`/2⁶⁴.
    pub fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.bits()) * end as u128) >> 64) as usize
    }

    /// Standard normal, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Puts `items` into random order (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published first numbers of SplitMix64 for the seed 1234567.
    #[test]
    fn the_stream_is_splitmix64() {
        let mut stream = Stream::new(1_234_567);
        for expected in [6_457_827_717_110_365_317, 3_203_168_211_198_807_973] {
            assert_eq!(stream.bits(), expected);
        }
    }

    #[test]
    fn seeds_differ_between_subjects_sessions_and_purposes_and_never_change() {
        let code = |text: &str| text.parse::<ParticipantCode>().unwrap();
        let seed = session_seed("order", 1, &code("01"), 1);
        // Pinned: studies that are under way depend on it.
        assert_eq!(seed, 8_116_432_031_464_217);
        for other in [
            session_seed("order", 2, &code("01"), 1),
            session_seed("order", 1, &code("02"), 1),
            session_seed("order", 1, &code("01"), 2),
            session_seed("answers", 1, &code("01"), 1),
        ] {
            assert_ne!(seed, other);
            assert!(other < 1 << 53);
        }
    }

    #[test]
    fn normal_numbers_have_mean_0_and_variance_1() {
        let mut stream = Stream::new(7);
        let numbers: Vec<f64> = (0..100_000).map(|_| stream.normal()).collect();
        let mean = numbers.iter().sum::<f64>() / 1e5;
        let variance = numbers.iter().map(|x| x * x).sum::<f64>() / 1e5;
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    }
}
