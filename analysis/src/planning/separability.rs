//! Which differences between stimuli the groups by score differences find: exactly for two stimuli that
//! differ in a set otherwise alike.

use crate::maths::binomial::{lower_tail, upper_tail};
use crate::maths::distributions::bisect;

/// Probability that the scores of two stimuli differ by `r_c` or more, when one is preferred to the other
/// with log-odds `theta` and the other `t` − 2 stimuli stand halfway between them; `judges` complete
/// sets of pairs.
///
/// # Formula
/// ```text
/// aᵢ − aⱼ = 2X − m + Y − m(t − 2),  X ~ Binomial(m, P(θ)),  Y ~ Binomial(2m(t − 2), P(θ/2))
/// P(θ) = 1/(1 + exp(−θ))
/// ```
/// X are the judges who choose i over j, Y the choices of i over a third plus those of a third over j:
/// exact for independent answers.
pub fn separation(judges: u64, t: usize, r_c: u64, theta: f64) -> f64 {
    let chance = |theta: f64| 1.0 / (1.0 + libm::exp(-theta));
    let others = judges * (t as u64).saturating_sub(2);
    let (direct, indirect) = (chance(theta), chance(0.5 * theta));
    let [m, rest, r] = [judges as i64, others as i64, r_c as i64];
    (0..=m)
        .map(|x| {
            let weight =
                upper_tail(x as u64, judges, direct) - upper_tail(x as u64 + 1, judges, direct);
            let reached = r + rest + m - 2 * x;
            let fallen = rest - r + m - 2 * x;
            let above = upper_tail(reached.max(0) as u64, 2 * others, indirect);
            let below =
                if fallen < 0 { 0.0 } else { lower_tail(fallen as u64, 2 * others, indirect) };
            weight * (above + below)
        })
        .sum()
}

/// The smallest preference between two stimuli that is found with probability `power`, see
/// [`separation`]; none if no preference is.
pub fn smallest_preference(judges: u64, t: usize, r_c: u64, power: f64) -> Option<f64> {
    const CERTAIN: f64 = 20.0;
    if separation(judges, t, r_c, CERTAIN) < power {
        return None;
    }
    let theta = bisect(0.0, CERTAIN, |theta| separation(judges, t, r_c, theta) >= power);
    Some(1.0 / (1.0 + libm::exp(-theta)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paired::score_groups::critical_difference;

    #[test]
    fn one_judge_of_three_stimuli_is_counted_by_hand() {
        // aᵢ − aⱼ = 2 needs i over j, i over k and k over j: (½)³; and so does −2.
        assert!((separation(1, 3, 2, 0.0) - 0.25).abs() < 1e-15);
        // With P(θ) = 0.8, P(θ/2) = 2/3: 0.8·(2/3)² + 0.2·(1/3)².
        let by_hand = 0.8 * 4.0 / 9.0 + 0.2 / 9.0;
        assert!((separation(1, 3, 2, libm::log(4.0)) - by_hand).abs() < 1e-12);
    }

    #[test]
    fn two_stimuli_are_a_sign_test() {
        // |2X − 8| ≥ 8 of 8 judges: all agree.
        assert!((separation(8, 2, 8, 0.0) - 2.0 / 256.0).abs() < 1e-15);
    }

    #[test]
    fn more_judges_find_smaller_preferences() {
        let found = [10, 20, 40].map(|judges| {
            let r_c = critical_difference(judges, 9, 0.01);
            let preference = smallest_preference(judges, 9, r_c, 0.8).unwrap();
            let theta = libm::log(preference / (1.0 - preference));
            assert!((separation(judges, 9, r_c, theta) - 0.8).abs() < 1e-9);
            preference
        });
        assert!(found[0] > found[1] && found[1] > found[2], "{found:?}");
        assert_eq!(smallest_preference(1, 3, 3, 0.8), None);
    }
}
