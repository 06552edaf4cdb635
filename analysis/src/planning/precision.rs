//! How precise a share or a scale value will be.

use crate::maths::binomial::upper_tail;
use crate::maths::distributions::{clopper_pearson_95, wilson_95};
use crate::outcome::Outcome;
use nalgebra::DMatrix;

/// Expected width of a 95 % interval of a share when each of `trials` has the chance `share`: exact.
///
/// # Formula
/// ```text
/// Σₖ P(X = k)·(upperₖ − lowerₖ), X ~ Binomial(n, p)
/// ```
/// Counts that together have less than 10⁻¹² are left out.
pub fn expected_width(trials: u64, share: f64, interval: impl Fn(u64, u64) -> [f64; 2]) -> f64 {
    let mut width = 0.0;
    let mut above = 1.0;
    for count in 0..=trials {
        let from_next = upper_tail(count + 1, trials, share);
        let chance = above - from_next;
        if chance > 1e-12 / (trials as f64 + 1.0) {
            let [low, high] = interval(count, trials);
            width += chance * (high - low);
        }
        above = from_next;
    }
    width
}

/// Expected widths by Wilson and by Clopper and Pearson.
pub fn expected_widths(trials: u64, share: f64) -> [f64; 2] {
    [expected_width(trials, share, wilson_95), expected_width(trials, share, clopper_pearson_95)]
}

/// Variances of the differences of Bradley–Terry log-worths, of one observer: divided by the number of
/// observers they are those of a study.
///
/// # Formula
/// ```text
/// I = Σ over pairs of times·p(1 − p)·(eᵢ − eⱼ)(eᵢ − eⱼ)ᵀ,  p = 1/(1 + exp(uⱼ − uᵢ))
/// var(ûᵢ − ûⱼ) = (eᵢ − eⱼ)ᵀ I⁺ (eᵢ − eⱼ)
/// ```
/// The Fisher information of the model (Bradley 1976) at the log-worths u; I⁺ by adding a constant to every
/// entry of I, which differences do not see. With all t(t−1)/2 pairs and equal worths it is 8/t.
///
/// # Errors
/// Says what cannot be told: the pairs leave stimuli unconnected.
pub fn difference_variances(
    worths: &[f64],
    pairs: &[(usize, usize, u64)],
) -> Outcome<DMatrix<f64>> {
    let t = worths.len();
    let mut information = DMatrix::from_element(t, t, 1.0);
    for &(i, j, times) in pairs {
        let p = 1.0 / (1.0 + libm::exp(worths[j] - worths[i]));
        let weight = times as f64 * p * (1.0 - p);
        information[(i, i)] += weight;
        information[(j, j)] += weight;
        information[(i, j)] -= weight;
        information[(j, i)] -= weight;
    }
    let inverse = information.cholesky().map(|cholesky| cholesky.inverse());
    // Without a connection the matrix is singular, or so nearly that rounding hides it.
    let inverse = inverse.filter(|inverse| inverse.iter().all(|x| x.is_finite() && x.abs() < 1e8));
    let inverse = inverse
        .ok_or("the pairs, with the assumed worths, do not connect all stimuli into one scale")?;
    Ok(DMatrix::from_fn(t, t, |i, j| {
        inverse[(i, i)] + inverse[(j, j)] - inverse[(i, j)] - inverse[(j, i)]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pairs_of_equal_stimuli_have_the_closed_form() {
        for t in [2_usize, 5, 9] {
            let pairs: Vec<(usize, usize, u64)> =
                (0..t).flat_map(|i| (i + 1..t).map(move |j| (i, j, 2))).collect();
            let variances = difference_variances(&vec![0.3; t], &pairs).unwrap();
            assert!((variances[(0, 1)] - 8.0 / (2.0 * t as f64)).abs() < 1e-12, "{t}");
            assert_eq!(variances[(0, 0)], 0.0);
        }
    }

    #[test]
    fn one_pair_has_the_variance_of_its_log_odds() {
        let variances = difference_variances(&[1.0, 0.0], &[(0, 1, 4)]).unwrap();
        let p = 1.0 / (1.0 + libm::exp(-1.0));
        assert!((variances[(0, 1)] - 1.0 / (4.0 * p * (1.0 - p))).abs() < 1e-12);
    }

    #[test]
    fn unconnected_stimuli_have_no_scale() {
        assert!(difference_variances(&[0.0; 4], &[(0, 1, 1), (2, 3, 1)]).is_err());
        assert!(difference_variances(&[90.0, 0.0], &[(0, 1, 1)]).is_err());
        assert!(difference_variances(&[0.0; 3], &[(0, 1, 1), (1, 2, 1)]).is_ok());
    }

    #[test]
    fn a_certain_share_has_the_width_of_its_one_count() {
        let [low, high] = wilson_95(20, 20);
        assert!((expected_width(20, 1.0, wilson_95) - (high - low)).abs() < 1e-15);
        // One trial: either count has the same width.
        let [low, high] = clopper_pearson_95(1, 1);
        assert!((expected_width(1, 0.3, clopper_pearson_95) - (high - low)).abs() < 1e-12);
    }
}
