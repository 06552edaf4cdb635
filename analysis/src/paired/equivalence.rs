//! Equivalence: may two stimuli be called interchangeable? "Not different" is not "equal".

use crate::input::preferences::WinMatrix;
use crate::maths::binomial::{lower_tail, upper_tail};
use crate::maths::corrections::holm;
use crate::maths::distributions::clopper_pearson;
use crate::maths::p_value::PValue;
use crate::outcome::Outcome;
use serde::Serialize;

/// Two stimuli count as interchangeable if either is chosen in 40 to 60 % of the trials.
pub const DEFAULT_MARGIN: f64 = 0.10;

/// Tests whether a preference is as good as ½.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Equivalence {
    /// How often one was chosen.
    pub chosen: u64,
    /// Out of how many trials.
    pub trials: u64,
    /// The share is shown to be within ½ ± this.
    pub margin: f64,
    /// The larger p of the two one-sided exact binomial tests.
    pub p: PValue,
    /// Level of significance α.
    pub alpha: f64,
    /// Level of the interval: 1 − 2α.
    pub level: f64,
    /// Clopper and Pearson's exact interval of the share at `level`: within ½ ± `margin` just where `p`
    /// does not exceed α.
    pub interval: [f64; 2],
    /// The smallest margin within which these answers would show equivalence at α.
    pub smallest_margin: f64,
    /// The smallest `p` that so many trials could give, with as even a split as can be.
    pub smallest_p: PValue,
}

/// Tests `chosen` of `trials` > 0 against shares outside ½ ± `margin`, with the interval that belongs to
/// the level of significance `alpha` (Schuirmann 1987, with exact binomial tests).
///
/// # Formula
/// ```text
/// p = max{ P(X ≥ k | n, ½ − margin), P(X ≤ k | n, ½ + margin) }
/// ```
///
/// # Errors
/// In words: there are no trials, or the margin is not between 0 and ½.
pub fn equivalence(chosen: u64, trials: u64, margin: f64, alpha: f64) -> Outcome<Equivalence> {
    if trials == 0 {
        return Err("there are no answers".into());
    }
    if !(margin > 0.0 && margin < 0.5) {
        return Err(format!("the margin is {margin}, and between 0 and 0.5 is needed"));
    }
    if !(alpha > 0.0 && alpha < 0.5) {
        return Err(format!("α is {alpha}, and between 0 and 0.5 is needed"));
    }
    let p = |k: u64| {
        PValue::new(upper_tail(k, trials, 0.5 - margin).max(lower_tail(k, trials, 0.5 + margin)))
    };
    let level = 1.0 - 2.0 * alpha;
    let interval = clopper_pearson(chosen, trials, level);
    Ok(Equivalence {
        chosen,
        trials,
        margin,
        p: p(chosen),
        alpha,
        level,
        interval,
        smallest_margin: (0.5 - interval[0]).max(interval[1] - 0.5),
        smallest_p: p(trials / 2),
    })
}

/// The test of one pair among others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairEquivalence {
    /// The stimulus that comes first among the items.
    pub item: String,
    /// The other.
    pub other: String,
    /// The test of the share of `item`.
    #[serde(flatten)]
    pub test: Equivalence,
    /// `p` corrected for the number of pairs by Holm (1979).
    pub p_holm: PValue,
    /// Whether `p_holm` does not exceed α: shown to be equivalent within the margin.
    pub equivalent: bool,
}

/// Tests every pair of `items` that are together in one of `groups` (the pairs that a text might call
/// interchangeable).
///
/// # Errors
/// In words: as [`equivalence`], or no pair is in one group and was judged.
pub fn equivalence_within_groups(
    items: &[String],
    wins: &WinMatrix,
    groups: &[Vec<String>],
    margin: f64,
    alpha: f64,
) -> Outcome<Vec<PairEquivalence>> {
    let together = |i: usize, j: usize| {
        groups.iter().any(|group| group.contains(&items[i]) && group.contains(&items[j]))
    };
    let pairs: Vec<(usize, usize)> =
        wins.pairs().filter(|(i, j)| together(*i, *j) && wins.trials(*i, *j) > 0).collect();
    if pairs.is_empty() {
        return Err("no two stimuli are in one group and were compared".into());
    }
    let tests: Vec<Equivalence> = pairs
        .iter()
        .map(|(i, j)| equivalence(wins.get(*i, *j), wins.trials(*i, *j), margin, alpha))
        .collect::<Outcome<_>>()?;
    let p: Vec<f64> = tests.iter().map(|test| test.p.value()).collect();
    let pairs = pairs.into_iter().zip(tests.into_iter().zip(holm(&p)));
    Ok(pairs
        .map(|((i, j), (test, p_holm))| PairEquivalence {
            item: items[i].clone(),
            other: items[j].clone(),
            test,
            p_holm: PValue::new(p_holm),
            equivalent: p_holm <= alpha,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_tests_are_those_of_r() {
        // R 4.2.2: max(binom.test(k, n, .4, "greater")$p.value, binom.test(k, n, .6, "less")$p.value).
        for (k, n, p) in [
            (10, 21, 0.308558187885275),
            (100, 200, 0.00263540335619095),
            (110, 200, 0.0857236761151918),
        ] {
            let found = equivalence(k, n, 0.1, 0.05).unwrap();
            assert!((found.p.value() / p - 1.0).abs() < 1e-10, "{k} of {n}: {:?}", found.p);
        }
    }

    #[test]
    fn the_interval_lies_within_the_margin_just_where_the_tests_reject() {
        for n in [20_u64, 150, 400] {
            for k in n * 2 / 5..=n * 3 / 5 {
                for (margin, alpha) in [(0.1, 0.05), (0.08, 0.01)] {
                    let found = equivalence(k, n, margin, alpha).unwrap();
                    let [low, high] = found.interval;
                    let within = low >= 0.5 - margin && high <= 0.5 + margin;
                    assert_eq!(found.p.value() <= alpha, within, "{k} of {n}");
                    assert_eq!(found.smallest_margin <= margin, within, "{k} of {n}");
                    assert!(found.smallest_p <= found.p);
                    let mirrored = equivalence(n - k, n, margin, alpha).unwrap();
                    assert!((mirrored.p.value() - found.p.value()).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn pairs_of_a_group_are_tested_and_corrected_together() {
        let items = ["A", "B", "C"].map(String::from);
        let mut wins = WinMatrix::new(3);
        for (i, j, won) in [(0, 1, 150), (0, 2, 290), (1, 2, 160)] {
            wins.add(i, j, won);
            wins.add(j, i, 300 - won);
        }
        let groups = [vec!["A".to_string(), "B".into()], vec!["B".into(), "C".into()]];
        let found = equivalence_within_groups(&items, &wins, &groups, 0.1, 0.05).unwrap();
        let pairs: Vec<_> = found.iter().map(|p| (p.item.as_str(), p.other.as_str())).collect();
        assert_eq!(pairs, [("A", "B"), ("B", "C")]);
        assert!(found[0].equivalent && found[0].p_holm >= found[0].test.p);
        let alone = [vec!["A".to_string()]];
        let error = equivalence_within_groups(&items, &wins, &alone, 0.1, 0.05).unwrap_err();
        assert!(error.starts_with("no two stimuli"), "{error}");
    }

    #[test]
    fn margins_and_levels_that_make_no_sense_are_refused_in_words() {
        for (trials, margin, alpha) in
            [(0, 0.1, 0.05), (9, 0.0, 0.05), (9, 0.5, 0.05), (9, 0.1, 0.5)]
        {
            assert!(equivalence(0, trials, margin, alpha).is_err());
        }
    }
}
