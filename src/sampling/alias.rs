//! The alias method (Walker 1977; construction after Vose 1991): draws an index with given
//! probabilities from one random word and one look-up.
//!
//! A table has 2^b slots (b ≥ 1). Each is one word: the upper 32 − b bits are the probability that
//! the slot stands for its own index, as a fraction, and the lower b bits are the index it stands
//! for otherwise. Of the random word, the upper b bits choose the slot and the rest choose between
//! its two indices, so tables are small and slots draw with a precision of 2^(b−32).

/// Bits of the slot number of a table over `weights` weights.
pub fn slot_bits(weights: usize) -> u32 {
    weights.next_power_of_two().trailing_zeros().max(1)
}

/// Appends to `slots` the table that draws index i with probability `weights[i]` / Σ weights. The
/// weights are finite and not negative; if none is positive, all are taken as equal.
pub fn push_table(slots: &mut Vec<u32>, weights: &[f64]) {
    let bits = slot_bits(weights.len());
    let count = 1_usize << bits;
    let total: f64 = weights.iter().sum();
    let share = |weight: f64| if total > 0.0 { weight / total } else { 1.0 / weights.len() as f64 };
    let mut scaled: Vec<f64> = weights.iter().map(|&weight| share(weight) * count as f64).collect();
    scaled.resize(count, 0.0);
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..count).partition(|&i| scaled[i] < 1.0);
    let first = slots.len();
    slots.extend((0..count).map(|index| pack(1.0, index, bits)));
    while let (Some(poor), Some(&rich)) = (small.pop(), large.last()) {
        slots[first + poor] = pack(scaled[poor], rich, bits);
        scaled[rich] -= 1.0 - scaled[poor];
        if scaled[rich] < 1.0 {
            large.pop();
            small.push(rich);
        }
    }
}

fn pack(own: f64, other: usize, bits: u32) -> u32 {
    let top = (1_u64 << (32 - bits)) - 1;
    let own = ((own * (top + 1) as f64).round() as u64).min(top) as u32;
    own << bits | other as u32
}

/// The index that `word` draws from the table of 2^`bits` slots that begins at `first`.
pub fn draw(slots: &[u32], first: u32, bits: u32, word: u32) -> u32 {
    let slot = word >> (32 - bits);
    let entry = slots[(first + slot) as usize];
    // Both sides hold the fraction in their upper bits, so they compare as they are.
    if word << bits < entry >> bits << bits { slot } else { entry & ((1 << bits) - 1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The probability that a table gives to each index, added up slot by slot, is its weight.
    #[test]
    fn a_table_holds_its_weights() {
        let cases: [Vec<f64>; 4] = [
            vec![1.0],
            vec![0.0, 3.0, 1.0],
            (0..1000).map(|i| f64::from(i * i % 97)).collect(),
            vec![0.0; 8],
        ];
        for weights in cases {
            let bits = slot_bits(weights.len());
            let mut slots = vec![];
            push_table(&mut slots, &weights);
            let mut mass = vec![0.0; slots.len()];
            let steps = (1_u64 << (32 - bits)) as f64;
            for (slot, entry) in slots.iter().enumerate() {
                let own = f64::from(entry >> bits) / steps;
                mass[slot] += own;
                mass[(entry & ((1 << bits) - 1)) as usize] += 1.0 - own;
            }
            let total: f64 = weights.iter().sum();
            for (index, mass) in mass.iter().enumerate() {
                let weight = weights.get(index).copied().unwrap_or(0.0);
                let expected =
                    if total > 0.0 { weight / total } else { 1.0 / weights.len() as f64 };
                let found = mass / slots.len() as f64;
                assert!((found - expected).abs() < 2.0 / steps, "{index}: {found} {expected}");
            }
        }
    }

    /// The draw follows the slots: over all words of a coarse comb, each index comes as often as its
    /// weight says.
    #[test]
    fn draws_follow_the_weights() {
        let weights = [1.0, 0.0, 5.0, 2.0];
        let mut slots = vec![7, 7, 7];
        push_table(&mut slots, &weights);
        let mut counts = [0_u32; 4];
        for step in 0..1_u32 << 16 {
            counts[draw(&slots, 3, 2, step << 16 | 0x8000) as usize] += 1;
        }
        assert_eq!(counts, [8192, 0, 40960, 16384]);
    }
}
