//! Chance that can be repeated: one stream of random numbers per replicate.

use rand::SeedableRng;
use rand_pcg::Pcg64;

/// The stream of random numbers of replicate `index` of what `seed` stands for. Replicates can be
/// computed in any order and on any number of threads.
pub fn stream(seed: u64, index: u64) -> Pcg64 {
    // An odd multiple spreads neighbouring replicates over all seeds.
    Pcg64::seed_from_u64(seed.wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}
