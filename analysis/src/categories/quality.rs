//! What answers look like apart from what they say: side bias, lapses, repeated answers, haste.

use crate::maths::distributions::clopper_pearson_95;
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use serde::Serialize;
use statrs::function::factorial::ln_binomial;

/// No answer to a stimulus comes sooner after its beginning, in seconds (Luce 1986).
pub const FASTEST_S: f64 = 0.2;

/// How often an observer did not attend, from trials with an answer that anybody would give.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lapses {
    /// Trials with an obvious answer.
    pub trials: u64,
    /// Wrong answers to them.
    pub wrong: u64,
    /// Estimated share of trials in which the observer did not attend and guessed, from 0 to 1.
    pub rate: f64,
    /// Its exact 95 % interval.
    pub interval_95: [f64; 2],
}

/// The lapse rate from obvious trials, each `right` or not, of which guessing gets the share `chance`
/// right.
///
/// # Formula
/// ```text
/// λ = min(1, (wrong/trials)/(1 − c)), at the ends of Clopper and Pearson's interval, too
/// ```
///
/// # Errors
/// In words: there are no such trials, or `chance` is no share below 1.
pub fn lapses(right: &[bool], chance: f64) -> Outcome<Lapses> {
    if right.is_empty() {
        return Err("there are no catch trials".into());
    }
    if !(0.0..1.0).contains(&chance) {
        return Err(format!("chance {chance}: a share from 0 to below 1 is needed"));
    }
    let trials = right.len() as u64;
    let wrong = right.iter().filter(|right| !**right).count() as u64;
    let rate = |share: f64| (share / (1.0 - chance)).min(1.0);
    Ok(Lapses {
        trials,
        wrong,
        rate: rate(wrong as f64 / trials as f64),
        interval_95: clopper_pearson_95(wrong, trials).map(rate),
    })
}

/// Runs of the same answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Runs {
    /// Answers.
    pub answers: u64,
    /// Runs: stretches of one answer.
    pub runs: u64,
    /// Answers in the longest run.
    pub longest: u64,
    /// P(no more runs) if the answers came in any order (Wald and Wolfowitz 1940): exact, lower tail,
    /// so small when answers are repeated.
    pub p_few: PValue,
}

/// The runs of the same answer in a sequence of two kinds of answers, in the order of the trials.
///
/// # Formula
/// ```text
/// P(R = 2k) = 2 C(a−1, k−1) C(b−1, k−1)/C(n, a)
/// P(R = 2k+1) = [C(a−1, k) C(b−1, k−1) + C(a−1, k−1) C(b−1, k)]/C(n, a)
/// ```
/// for a answers of one kind and b of the other, n = a + b.
///
/// # Errors
/// In words: no answers, or all alike.
pub fn runs(answers: &[bool]) -> Outcome<Runs> {
    let a = answers.iter().filter(|answer| **answer).count() as u64;
    let b = answers.len() as u64 - a;
    if a == 0 || b == 0 {
        return Err(match answers.len() {
            0 => "there are no answers".into(),
            n => format!("all {n} answers are alike"),
        });
    }
    let lengths: Vec<usize> = answers.chunk_by(|x, y| x == y).map(<[bool]>::len).collect();
    let ways = |k: u64, l: u64| {
        libm::exp(ln_binomial(a - 1, k) + ln_binomial(b - 1, l) - ln_binomial(a + b, a))
    };
    let probability = |runs: u64| {
        let k = runs / 2;
        match runs % 2 {
            0 => 2.0 * ways(k - 1, k - 1),
            _ => ways(k, k - 1) + ways(k - 1, k),
        }
    };
    Ok(Runs {
        answers: a + b,
        runs: lengths.len() as u64,
        longest: lengths.iter().copied().max().unwrap_or(0) as u64,
        p_few: PValue::new((2..=lengths.len() as u64).map(probability).sum::<f64>().min(1.0)),
    })
}

/// How many answers came sooner than [`FASTEST_S`] after the beginning of what was shown last, of which
/// `since_onset_s` are the times.
pub fn too_fast(since_onset_s: &[f64]) -> u64 {
    since_onset_s.iter().filter(|time| **time < FASTEST_S).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lapses_are_twice_the_errors_of_guessers() {
        let of = |wrong: usize| lapses(&[vec![false; wrong], vec![true; 10 - wrong]].concat(), 0.5);
        let found = of(2).unwrap();
        assert_eq!(found.rate, 0.4);
        assert_eq!(found.interval_95[0], 2.0 * clopper_pearson_95(2, 10)[0]);
        assert_eq!(of(9).unwrap().rate, 1.0);
        assert!(lapses(&[], 0.5).unwrap_err().contains("no catch trials"));
        assert!(lapses(&[true], 1.0).is_err());
    }

    #[test]
    fn runs_are_counted_over_all_orders() {
        let orders = |bits: u32| (0..9).map(|i| bits >> i & 1 == 1).collect::<Vec<bool>>();
        let of_four: Vec<Vec<bool>> =
            (0..512).filter(|bits: &u32| bits.count_ones() == 4).map(orders).collect();
        let count = |answers: &[bool]| answers.chunk_by(|x, y| x == y).count() as u64;
        for answers in &of_four {
            let found = runs(answers).unwrap();
            let few = of_four.iter().filter(|other| count(other) <= found.runs).count();
            let share = few as f64 / of_four.len() as f64;
            assert!((found.p_few.value() - share).abs() < 1e-12, "{} runs", found.runs);
        }
        assert_eq!(runs(&[true, true, false, true, true, true]).unwrap().longest, 3);
        assert!(runs(&[true; 4]).unwrap_err().contains("all 4 answers are alike"));
        assert!(runs(&[]).is_err());
    }

    #[test]
    fn haste_is_measured_from_the_beginning() {
        assert_eq!(too_fast(&[0.1, 0.2, 4.0, -1.0]), 2);
    }
}
