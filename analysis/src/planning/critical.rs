//! From which ζ and u on a study of so many judges is significant.

use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use crate::paired::agreement::{law_of_sum, one_pair};
use crate::paired::circular_triads::{Alternative, TriadsByChance, max_circular_triads};

/// P(D ≤ `d`) by chance, where `d` are the circular triads of all `judges` together: exact up to ten stimuli,
/// by χ² with continuity correction above.
pub(crate) fn p_of_triads(chance: &TriadsByChance, d: u64, judges: u64) -> Option<PValue> {
    // Only the sum counts.
    let triads: Vec<u64> = (0..judges).map(|judge| if judge == 0 { d } else { 0 }).collect();
    let test = chance.test(&triads, Alternative::Less);
    test.p_exact.or(test.chi_square_corrected.map(|chi_square| chi_square.p))
}

/// The largest number of circular triads of `judges` judges of `t` ≥ 3 stimuli together that is significantly
/// small at `alpha`: exact up to ten stimuli, by χ² above. None if not even 0 is.
pub fn circular_triads(chance: &TriadsByChance, judges: u64, t: usize, alpha: f64) -> Option<u64> {
    let significant = |d| p_of_triads(chance, d, judges).is_some_and(|p| p.value() <= alpha);
    if !significant(0) {
        return None;
    }
    let (mut low, mut high) = (0, judges * max_circular_triads(t) + 1);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if significant(middle) { low = middle } else { high = middle }
    }
    Some(low)
}

/// More multiplications than this are not made for one number of judges.
const MAX_WORK: u64 = 1_500_000_000;

/// The smallest excess of Σ over its least that is significant at `alpha`, exact, for `judges` judges of so
/// many `pairs`. None if not even unanimity is.
///
/// # Errors
/// Says how large the work would be when it is too large.
pub fn agreement_excess(judges: u64, pairs: usize, alpha: f64) -> Outcome<Option<u64>> {
    // Each pair convolves its judges/2 + 1 gains with the sums so far, which end at judges²/4 per pair.
    let pairs_squared = (pairs as u64).saturating_mul(pairs as u64);
    let work = pairs_squared.saturating_mul(judges.saturating_pow(3) / 16 + 1);
    if work > MAX_WORK {
        return Err(format!(
            "the exact test would take {work} steps, at most {MAX_WORK} are taken"
        ));
    }
    let (law, _) = law_of_sum(&vec![one_pair(judges); pairs], u64::MAX);
    let mut tail = 0.0;
    let mut critical = None;
    for (excess, p) in law.iter().enumerate().rev() {
        tail += p;
        if tail > alpha {
            break;
        }
        critical = Some(excess as u64);
    }
    Ok(critical)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paired::agreement::exact_tail;

    #[test]
    fn one_less_triad_is_significant_and_one_more_is_not() {
        for (judges, t) in [(1, 7), (5, 5), (20, 5), (10, 9), (6, 12)] {
            let chance = TriadsByChance::new(t);
            let d = circular_triads(&chance, judges, t, 0.01).unwrap();
            assert!(p_of_triads(&chance, d, judges).unwrap().value() <= 0.01, "{judges}, {t}");
            assert!(p_of_triads(&chance, d + 1, judges).unwrap().value() > 0.01, "{judges}, {t}");
        }
        // Kendall: one observer of five stimuli cannot be shown to be consistent.
        assert_eq!(circular_triads(&TriadsByChance::new(5), 1, 5, 0.05), None);
    }

    #[test]
    fn the_critical_agreement_is_that_of_the_exact_test() {
        for (judges, pairs) in [(3, 10), (10, 10), (21, 36)] {
            let excess = agreement_excess(judges, pairs, 0.01).unwrap().unwrap();
            let p = |excess| exact_tail(&vec![judges; pairs], excess).unwrap().value();
            assert!(p(excess) <= 0.01 && p(excess - 1) > 0.01, "{judges}, {pairs}");
        }
        assert_eq!(agreement_excess(2, 3, 0.01), Ok(None));
        assert!(agreement_excess(60, 25_200, 0.01).unwrap_err().contains("steps"));
    }
}
