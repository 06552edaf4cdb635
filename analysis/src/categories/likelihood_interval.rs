//! The interval of d′ by its profile likelihood, which holds near d′ = 0 and for shares of 0 and 1, where
//! the delta method does not.

use super::discrimination::{Counts, MAX_D_PRIME, Model, Split};
use crate::maths::distributions::{Z_975, bisect};

/// The ends of the d′ that the answers do not contradict; none for an end beyond the range of d′. `inside`
/// is a d′ between them, such as the estimate.
///
/// # Formula
/// ```text
/// {d : 2 [max ℓ − max_c ℓ(d, c)] ≤ χ²_{1; 0.95}},  ℓ = Σ k ln p + (n − k) ln(1 − p)
/// ```
/// over hits and false alarms, where c is the criterion (Venzon and Moolgavkar 1988).
pub(super) fn likelihood_interval_95(
    model: Model,
    counts: &Counts,
    inside: f64,
) -> [Option<f64>; 2] {
    let least = model.min_d_prime();
    let Counts { hits, signals, false_alarms, noises } = *counts;
    // Where hits are fewer than false alarms, d′ = 0 fits best of all d′ ≥ 0.
    let best = match least == 0.0 && hits * noises < false_alarms * signals {
        true => profile(model, counts, 0.0),
        false => {
            let shares = [(hits, signals), (false_alarms, noises)];
            let splits = shares.map(|(yes, n)| [yes, n - yes].map(|k| k as f64 / n as f64));
            log_likelihood(counts, &splits)
        }
    };
    let contradicted = |d: f64| 2.0 * (best - profile(model, counts, d)) > Z_975 * Z_975;
    let lower = match contradicted(least) {
        true => Some(bisect(least, inside, |d| !contradicted(d))),
        false => (least == 0.0).then_some(0.0),
    };
    let upper = contradicted(MAX_D_PRIME).then(|| bisect(inside, MAX_D_PRIME, contradicted));
    [lower, upper]
}

/// The largest log-likelihood over all criteria, which has one peak, by golden-section search.
fn profile(model: Model, counts: &Counts, d: f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    const STEPS: usize = 45;
    let at = |criterion| log_likelihood(counts, &model.probabilities(d, criterion));
    let [mut low, mut high] = model.criteria();
    let mut inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let mut values = inner.map(at);
    for _ in 0..STEPS {
        if values[0] < values[1] {
            (low, inner[0], values[0]) = (inner[0], inner[1], values[1]);
            inner[1] = low + GOLDEN * (high - low);
            values[1] = at(inner[1]);
        } else {
            (high, inner[1], values[1]) = (inner[1], inner[0], values[0]);
            inner[0] = high - GOLDEN * (high - low);
            values[0] = at(inner[0]);
        }
    }
    values[0].max(values[1])
}

fn log_likelihood(counts: &Counts, [hit, false_alarm]: &[Split; 2]) -> f64 {
    let term =
        |k: u64, p: f64| if k == 0 { 0.0 } else { k as f64 * libm::log(p.max(f64::MIN_POSITIVE)) };
    let Counts { hits, signals, false_alarms, noises } = *counts;
    term(hits, hit[0])
        + term(signals - hits, hit[1])
        + term(false_alarms, false_alarm[0])
        + term(noises - false_alarms, false_alarm[1])
}
