//! What a rounded number in print implies, and what vote totals allow.
//!
//! A count in percent, a ζ and a u are each made of one whole number. Where a printed value is that of no
//! whole number, something else was computed than is said; where it is that of one, the number can be
//! recovered and tested.

use crate::paired::circular_triads::{consistency, max_circular_triads};

/// Whether `value` rounds to `printed`, which has so many decimals. A half may have gone either way.
pub fn rounds_to(value: f64, printed: f64, decimals: usize) -> bool {
    (value - printed).abs() <= 0.500_000_1 * libm::pow(10.0, -(decimals as f64))
}

/// The counts out of `trials` whose share in percent rounds to `printed`.
pub fn counts(printed: f64, decimals: usize, trials: u64) -> Vec<u64> {
    let percent = |count: &u64| 100.0 * *count as f64 / trials as f64;
    (0..=trials).filter(|count| rounds_to(percent(count), printed, decimals)).collect()
}

/// The numbers of circular triads of `judges` judges together whose ζ rounds to `printed`.
pub fn circular_triads(printed: f64, decimals: usize, judges: u64, t: usize) -> Vec<u64> {
    (0..=judges * max_circular_triads(t))
        .filter(|d| rounds_to(consistency(*d, judges, t), printed, decimals))
        .collect()
}

/// The Σ of `judges` judges of `t` stimuli whose u rounds to `printed`.
///
/// With an odd number of judges a pair adds an even number to the least Σ, so only every second Σ is
/// possible.
pub fn sigmas(printed: f64, decimals: usize, judges: u64, t: usize) -> Vec<u64> {
    let all = (t * (t - 1) / 2) as u64 * choose_2(judges);
    (least_sigma(judges, t)..=all)
        .step_by(if judges % 2 == 1 { 2 } else { 1 })
        .filter(|sigma| rounds_to(2.0 * *sigma as f64 / all as f64 - 1.0, printed, decimals))
        .collect()
}

/// The least Σ of `judges` judges of `t` stimuli: each pair is split as evenly as they can.
pub fn least_sigma(judges: u64, t: usize) -> u64 {
    let half = judges / 2;
    (t * (t - 1) / 2) as u64 * (choose_2(half) + choose_2(judges - half))
}

/// A bound from below on the ζ of `judges` judges whose scores together are `votes`.
///
/// # Formula
/// ```text
/// Σ dₖ = m·C(t,3) − Σᵢ Σₖ C(sᵢₖ, 2),  Σₖ sᵢₖ = aᵢ
/// ```
/// C(s, 2) is convex, so the inner sum is least, and the number of triads largest, when the judges divide
/// the votes aᵢ as evenly as whole numbers allow.
pub fn least_zeta(votes: &[u64], judges: u64) -> f64 {
    let t = votes.len() as u64;
    let transitive: u64 = votes
        .iter()
        .map(|a| {
            let (each, more) = (a / judges, a % judges);
            more * choose_2(each + 1) + (judges - more) * choose_2(each)
        })
        .sum();
    let most = (judges * (t * (t - 1) * (t - 2) / 6)).saturating_sub(transitive);
    consistency(most, judges, votes.len()).max(0.0)
}

/// A bound from below on the u of `judges` judges whose scores together are `votes`.
///
/// # Formula
/// ```text
/// Σ = C(t,2)·m(m − 2)/4 + Σ_{i<j} (xᵢⱼ − m/2)² ≥ C(t,2)·m(m − 2)/4 + Σᵢ (aᵢ − ā)²/t
/// ```
/// The squares are least, among real xᵢⱼ with these votes, at xᵢⱼ = m/2 + (aᵢ − aⱼ)/t.
pub fn least_u(votes: &[u64], judges: u64) -> f64 {
    let (t, m) = (votes.len() as f64, judges as f64);
    let pairs = 0.5 * t * (t - 1.0);
    let mean = 0.5 * m * (t - 1.0);
    let squares: f64 = votes.iter().map(|a| (*a as f64 - mean) * (*a as f64 - mean)).sum();
    let least = 0.25 * pairs * m * (m - 2.0) + squares / t;
    4.0 * least / (m * (m - 1.0) * pairs) - 1.0
}

fn choose_2(n: u64) -> u64 {
    n * n.saturating_sub(1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentage_gives_back_its_counts() {
        assert_eq!(counts(86.25, 2, 160), [138]);
        assert_eq!(counts(67.0, 0, 168), [112, 113]);
        assert!(counts(67.0, 0, 4).is_empty());
    }

    #[test]
    fn a_printed_zeta_or_u_of_no_whole_number_is_found_out() {
        // One judge of three stimuli has ζ = 0 or 1; two judges of one pair have u = −1 or 1.
        assert_eq!(circular_triads(1.0, 4, 1, 3), [0]);
        assert!(circular_triads(0.5, 4, 1, 3).is_empty());
        assert_eq!((sigmas(1.0, 2, 2, 2), sigmas(-1.0, 2, 2, 2)), (vec![1], vec![0]));
        assert!(sigmas(0.5, 2, 2, 2).is_empty());
        // Three judges of one pair: Σ = 1 or 3, never 2.
        assert_eq!((sigmas(-0.3333, 4, 3, 2), sigmas(1.0, 4, 3, 2)), (vec![1], vec![3]));
    }

    #[test]
    fn the_bounds_hold_and_are_met() {
        // Three judges with one ranking each way of three stimuli: equal scores, each judge consistent.
        assert_eq!(least_zeta(&[3, 3, 3], 3), 0.0);
        // All agree: only one matrix has these votes.
        assert_eq!(least_zeta(&[8, 4, 0], 4), 1.0);
        assert!((least_u(&[4, 0], 4) - 1.0).abs() < 1e-15);
        // An even split is possible with equal votes and an even number of judges.
        assert!((least_u(&[12, 12, 12], 12) + 1.0 / 11.0).abs() < 1e-15);
    }
}
