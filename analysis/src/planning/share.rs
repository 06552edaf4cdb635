//! Shares: the power of their test and the width of their interval, against the number of observers.

use super::power::{Sides, critical_count, design_effect, intraclass_correlation, power};
use super::precision::expected_widths;
use crate::maths::distributions::{bisect, normal_tail};
use serde::Serialize;

/// The exact binomial test of a share against a half, and its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShareTest {
    /// Answers of each observer to the question.
    pub answers_per_observer: u64,
    /// Which departures from a half the test looks for.
    pub sides: Sides,
    /// The true shares at which power is told.
    pub shares: Vec<f64>,
    /// Standard deviation between observers of the log-odds of the answers.
    pub log_odds_sd: f64,
    /// Correlation of two answers of one observer at each share.
    pub correlations: Vec<f64>,
    /// One row per number of observers.
    pub rows: Vec<ShareRow>,
}

/// A test and an interval of a share with so many observers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShareRow {
    /// Number of observers.
    pub observers: u64,
    /// Answers of all of them.
    pub trials: u64,
    /// The smallest count that is significant; none if not even all are.
    pub critical: Option<u64>,
    /// Exact probability of a significant count when both answers are equally likely.
    pub size: f64,
    /// Exact power at each share, all answers independent.
    pub power: Vec<f64>,
    /// Approximate power at each share when observers differ and the test allows for that: exact power of as
    /// many independent answers as those are worth.
    pub power_if_people_differ: Vec<f64>,
    /// Approximate size of the test, with all answers taken as independent, when observers differ and prefer
    /// neither on the whole.
    pub size_if_people_differ: f64,
    /// Expected width of Wilson's 95 % interval at a share of a half, where it is widest.
    pub wilson_width: f64,
    /// The same of Clopper and Pearson's.
    pub clopper_pearson_width: f64,
}

impl ShareTest {
    /// The test at `alpha`, where each observer gives so many `answers` and people's log-odds have the
    /// standard deviation `log_odds_sd`.
    pub fn new(
        observers: &[u64],
        answers: u64,
        alpha: f64,
        shares: &[f64],
        sides: Sides,
        log_odds_sd: f64,
    ) -> Self {
        let correlation = |share: f64| match log_odds_sd > 0.0 {
            true => intraclass_correlation(share, log_odds_sd),
            false => 0.0,
        };
        let correlations: Vec<f64> = shares.iter().map(|share| correlation(*share)).collect();
        let inflation = design_effect(answers, correlation(0.5));
        let row = |&observers: &u64| {
            let trials = observers * answers;
            let critical = critical_count(trials, alpha, sides);
            let at = |share: f64| power(critical, trials, share, sides);
            let robust = |(share, correlation): (&f64, &f64)| {
                let worth = (trials as f64 / design_effect(answers, *correlation)) as u64;
                power(critical_count(worth, alpha, sides), worth, *share, sides)
            };
            let size = at(0.5);
            let [wilson_width, clopper_pearson_width] = expected_widths(trials, 0.5);
            ShareRow {
                observers,
                trials,
                critical,
                size,
                power: shares.iter().map(|share| at(*share)).collect(),
                power_if_people_differ: shares.iter().zip(&correlations).map(robust).collect(),
                size_if_people_differ: inflated(size, inflation, sides),
                wilson_width,
                clopper_pearson_width,
            }
        };
        let rows = observers.iter().map(row).collect();
        let (answers_per_observer, shares) = (answers, shares.to_vec());
        Self { answers_per_observer, sides, shares, log_odds_sd, correlations, rows }
    }
}

/// The size of a test whose statistic has the variance `inflation` instead of 1, by the normal approximation.
fn inflated(size: f64, inflation: f64, sides: Sides) -> f64 {
    if size <= 0.0 || inflation <= 1.0 {
        return size;
    }
    let both = if sides == Sides::Two { 2.0 } else { 1.0 };
    let z = bisect(0.0, 40.0, |z| both * normal_tail(z) <= size);
    both * normal_tail(z / libm::sqrt(inflation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_answer_each_is_independent_whoever_gives_it() {
        let test = ShareTest::new(&[10, 24], 1, 0.05, &[0.7], Sides::Two, 2.0);
        for row in &test.rows {
            assert_eq!(row.power, row.power_if_people_differ);
            assert_eq!(row.size, row.size_if_people_differ);
        }
    }

    #[test]
    fn several_answers_of_people_who_differ_are_worth_less() {
        let test = ShareTest::new(&[24], 8, 0.01, &[0.6, 0.7], Sides::Two, 0.7);
        let row = &test.rows[0];
        assert_eq!(row.trials, 192);
        assert!(row.power_if_people_differ.iter().zip(&row.power).all(|(less, more)| less < more));
        assert!(row.size <= 0.01 && row.size_if_people_differ > 0.01, "{row:?}");
        assert!(row.wilson_width < row.clopper_pearson_width);
        // Alike people: nothing is lost.
        let alike = ShareTest::new(&[24], 8, 0.01, &[0.6, 0.7], Sides::Two, 0.0);
        assert_eq!(alike.rows[0].power, alike.rows[0].power_if_people_differ);
    }
}
