//! How much of the differences between scores goes with one factor of the stimuli.

use crate::maths::distributions::chi_square_tail;
use crate::maths::p_value::PValue;

/// The part of the statistic D of equal scores that goes with the levels of one factor.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorEffect {
    /// Votes of each level together.
    pub levels: Vec<(String, u64)>,
    /// Its part of D.
    pub chi2: f64,
    /// Levels less one.
    pub df: u64,
    /// Upper tail of χ², approximate.
    pub p: PValue,
}

/// The effect of the factor that gives each of t `items` the level `level_of(item)`.
///
/// # Formula
/// ```text
/// χ² = 4/(m t) · Σ over levels of (A − k·ā)²/k,  df = levels − 1
/// ```
/// where A is the sum of the votes of the k items of a level, ā the mean vote of an item and m the number
/// of judges. Were every answer a fair coin, the scores would have the covariance (m t/4)·(I − J/t), so
/// each orthogonal contrast of D = 4 Σ (a − ā)²/(m t) would be a χ² of its own (David 1988, §3.2).
pub fn factor_effect<'a>(
    items: &'a [String],
    votes: &[u64],
    judges: u64,
    level_of: impl Fn(&'a str) -> &'a str,
) -> FactorEffect {
    let (t, m) = (items.len() as f64, judges as f64);
    let mean = 0.5 * m * (t - 1.0);
    let mut levels: Vec<(String, u64, u64)> = Vec::new();
    for (item, votes) in items.iter().zip(votes) {
        let level = level_of(item);
        match levels.iter_mut().find(|(name, ..)| name == level) {
            Some((_, sum, count)) => (*sum, *count) = (*sum + votes, *count + 1),
            None => levels.push((level.into(), *votes, 1)),
        }
    }
    let part = |(_, sum, count): &(String, u64, u64)| {
        let (sum, count) = (*sum as f64, *count as f64);
        (sum - count * mean) * (sum - count * mean) / count
    };
    let chi2 = 4.0 / (m * t) * levels.iter().map(part).sum::<f64>();
    let df = levels.len() as u64 - 1;
    let p = PValue::new(chi_square_tail(chi2, df as f64));
    levels.sort();
    FactorEffect { levels: levels.into_iter().map(|(l, sum, _)| (l, sum)).collect(), chi2, df, p }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paired::score_equality::score_equality;

    #[test]
    fn the_parts_of_a_full_design_add_up_to_d() {
        let items: Vec<String> = ["A1T1", "A1T2", "A2T1", "A2T2"].map(String::from).into();
        let votes = [17, 5, 12, 14];
        let a = factor_effect(&items, &votes, 8, |item| &item[..2]);
        let t = factor_effect(&items, &votes, 8, |item| &item[2..]);
        // The interaction has the levels "same" and "other".
        let both = factor_effect(&items, &votes, 8, |item| {
            if ["A1T1", "A2T2"].contains(&item) { "same" } else { "other" }
        });
        let d = score_equality(&votes, 8);
        assert!((a.chi2 + t.chi2 + both.chi2 - d.d).abs() < 1e-12);
        assert_eq!(a.df + t.df + both.df, d.df);
        assert_eq!(a.levels, [("A1".to_string(), 22), ("A2".to_string(), 26)]);
    }

    #[test]
    fn every_item_a_level_of_its_own_is_the_overall_test() {
        let items: Vec<String> = ["a", "b", "c"].map(String::from).into();
        let all = factor_effect(&items, &[9, 5, 1], 5, |item| item);
        let d = score_equality(&[9, 5, 1], 5);
        assert!((all.chi2 - d.d).abs() < 1e-12 && all.p == d.p);
    }
}
