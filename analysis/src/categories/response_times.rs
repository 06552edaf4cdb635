//! Response times: medians with intervals that need no form of the distribution, and comparisons between
//! conditions within observers.

use crate::input::data_quality::Quartiles;
use crate::maths::corrections::holm;
use crate::maths::distributions::fair_binomial;
use crate::maths::p_value::PValue;
use crate::maths::signed_rank::{SignedRank, signed_rank};
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;

/// An answer's observer (place among the observers) and response time in seconds.
pub type Timed = (usize, f64);

/// Response times of one condition, in seconds from the end of the last film to the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSummary {
    /// Answers.
    pub answers: u64,
    /// Those given before the end of the film, whose times are negative.
    pub before_end: u64,
    /// Quartiles, with the median.
    pub quartiles: Quartiles,
    /// Answers beyond Tukey's outer fences, 3 interquartile ranges below the first or above the third
    /// quartile. They are counted, and left in.
    pub outliers: u64,
    /// Interval of the median.
    pub median_interval: Outcome<MedianInterval>,
    /// Geometric mean of the times of answers given after the end of the film.
    pub geometric_mean: Outcome<f64>,
}

serialize_outcomes!(
    TimeSummary,
    [answers, before_end, quartiles, outliers],
    [median_interval, geometric_mean]
);

/// An interval between two order statistics that holds the median of any distribution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MedianInterval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Its exact level of confidence, at least 0.95.
    pub coverage: f64,
}

/// The response times `seconds` of one condition.
///
/// # Formula
/// ```text
/// [x₍j₎, x₍n−j+1₎] for the largest j with P(B ≤ j − 1) ≤ 0.025, B ~ Binomial(n, ½)
/// ```
/// (Conover 1999, §3.2).
///
/// # Errors
/// In words: there are no times, or one is no finite number.
pub fn summarize(seconds: &[f64]) -> Outcome<TimeSummary> {
    if seconds.is_empty() {
        return Err("there are no answers".into());
    }
    if seconds.iter().any(|time| !time.is_finite()) {
        return Err("a response time is no finite number".into());
    }
    // Sorted, so that no sum depends on the order of the answers.
    let mut seconds = seconds.to_vec();
    seconds.sort_by(f64::total_cmp);
    let quartiles = Quartiles::of(seconds.iter().copied());
    let reach = 3.0 * (quartiles.third - quartiles.first);
    let fences = quartiles.first - reach..=quartiles.third + reach;
    let positive: Vec<f64> = seconds.iter().copied().filter(|time| *time > 0.0).collect();
    let mean_log =
        positive.iter().map(|time| libm::log(*time)).sum::<f64>() / positive.len() as f64;
    Ok(TimeSummary {
        answers: seconds.len() as u64,
        before_end: seconds.iter().filter(|time| **time < 0.0).count() as u64,
        quartiles,
        outliers: seconds.iter().filter(|time| !fences.contains(time)).count() as u64,
        median_interval: median_interval(&seconds),
        geometric_mean: match positive.is_empty() {
            true => Err("no answer was given after the end of the film".into()),
            false => Ok(libm::exp(mean_log)),
        },
    })
}

fn median_interval(sorted: &[f64]) -> Outcome<MedianInterval> {
    let n = sorted.len() as u64;
    let (mut below, mut j) = (0.0, 0);
    loop {
        let next = below + fair_binomial(n, j as u64);
        if next > 0.025 {
            break;
        }
        (below, j) = (next, j + 1);
    }
    if j == 0 {
        return Err(format!(
            "a 95 % interval of the median needs at least 6 answers, here are {n}"
        ));
    }
    let (low, high) = (sorted[j - 1], sorted[sorted.len() - j]);
    Ok(MedianInterval { low, high, coverage: 1.0 - 2.0 * below })
}

/// Response times of a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// What the answers have in common.
    pub condition: String,
    /// Their times.
    pub times: Outcome<TimeSummary>,
}

serialize_outcomes!(Condition, [condition], [times]);

/// Summarizes conditions, each a name and its answers.
pub fn conditions(conditions: &[(String, Vec<Timed>)]) -> Vec<Condition> {
    let summary = |answers: &[Timed]| {
        summarize(&answers.iter().map(|(_, seconds)| *seconds).collect::<Vec<_>>())
    };
    conditions
        .iter()
        .map(|(name, answers)| Condition { condition: name.clone(), times: summary(answers) })
        .collect()
}

/// Two conditions compared within observers: by the medians of each observer's times.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared.
    pub conditions: [String; 2],
    /// Observers with answers in both.
    pub observers: u64,
    /// Median over the observers of the second's median less the first's, in seconds; none without
    /// observers.
    pub median_difference_s: Option<f64>,
    /// Its p by Holm's correction for the comparisons of the table that could be tested.
    pub p_holm: Option<PValue>,
    /// Wilcoxon's signed-rank test of the differences.
    pub test: Outcome<SignedRank>,
}

serialize_outcomes!(Comparison, [conditions, observers, median_difference_s, p_holm], [test]);

/// Compares pairs of conditions, each a name and its answers.
pub fn compare(pairs: &[[(String, Vec<Timed>); 2]]) -> Vec<Comparison> {
    let mut comparisons: Vec<Comparison> = pairs
        .iter()
        .map(|[(first, before), (second, after)]| {
            let differences: Vec<f64> = medians(before)
                .into_iter()
                .filter_map(|(observer, median)| {
                    let other = medians(after).into_iter().find(|(other, _)| *other == observer)?;
                    Some(other.1 - median)
                })
                .collect();
            Comparison {
                conditions: [first.clone(), second.clone()],
                observers: differences.len() as u64,
                median_difference_s: (!differences.is_empty())
                    .then(|| Quartiles::of(differences.iter().copied()).median),
                p_holm: None,
                test: match differences.len() {
                    0 => Err("no observer has answers in both conditions".into()),
                    1 => Err("one observer alone can show no difference".into()),
                    _ => signed_rank(&differences),
                },
            }
        })
        .collect();
    let tested = comparisons.iter().filter_map(|c| c.test.as_ref().ok());
    let corrected = holm(&tested.map(|test| test.p.value()).collect::<Vec<_>>());
    let places = comparisons.iter_mut().filter(|comparison| comparison.test.is_ok());
    for (comparison, p) in places.zip(corrected) {
        comparison.p_holm = Some(PValue::new(p));
    }
    comparisons
}

/// Each observer's median.
fn medians(answers: &[Timed]) -> Vec<Timed> {
    let mut sorted = answers.to_vec();
    sorted.sort_by_key(|(observer, _)| *observer);
    let of_one = |answers: &[Timed]| {
        (answers[0].0, Quartiles::of(answers.iter().map(|(_, time)| *time)).median)
    };
    sorted.chunk_by(|a, b| a.0 == b.0).map(of_one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_have_intervals_of_order_statistics() {
        // R 4.2.2: qbinom(.025, 10, .5) is 2: the 2nd and the 9th of 10, at 1 − 2 pbinom(1, 10, .5).
        let times: Vec<f64> = (1..=10).map(f64::from).collect();
        let interval = summarize(&times).unwrap().median_interval.unwrap();
        assert_eq!((interval.low, interval.high), (2.0, 9.0));
        assert!((interval.coverage - 0.978515625).abs() < 1e-12);
        assert!(
            summarize(&times[..5]).unwrap().median_interval.unwrap_err().contains("at least 6")
        );
    }

    #[test]
    fn answers_before_the_end_are_counted_and_kept_out_of_logarithms() {
        let summary = summarize(&[-0.5, 1.0, 4.0, 2.0, 0.0]).unwrap();
        assert_eq!((summary.before_end, summary.quartiles.median), (1, 1.0));
        assert!((summary.geometric_mean.unwrap() - 2.0).abs() < 1e-12);
        let early = summarize(&[-1.0, -2.0]).unwrap();
        assert!(early.geometric_mean.unwrap_err().contains("after the end"));
        assert!(summarize(&[]).is_err() && summarize(&[f64::NAN]).is_err());
    }

    #[test]
    fn outliers_are_beyond_the_outer_fences() {
        let mut times: Vec<f64> = (0..20).map(|i| 1.0 + 0.1 * f64::from(i)).collect();
        assert_eq!(summarize(&times).unwrap().outliers, 0);
        times.push(60.0);
        assert_eq!(summarize(&times).unwrap().outliers, 1);
    }

    #[test]
    fn comparisons_are_within_observers() {
        let slow: Vec<Timed> = (0..8).flat_map(|i| [(i, i as f64), (i, i as f64 + 2.0)]).collect();
        let slower: Vec<Timed> = slow.iter().map(|(i, t)| (*i, t + 0.5 + *i as f64)).collect();
        let of = |name: &str, times: &[Timed]| (name.to_string(), times.to_vec());
        let found = compare(&[
            [of("a", &slow), of("b", &slower)],
            [of("a", &slow), of("c", &[])],
            [of("a", &slow[..2]), of("b", &slower)],
        ]);
        assert_eq!((found[0].observers, found[0].median_difference_s), (8, Some(4.0)));
        // All 8 differences are positive: 2 · 2⁻⁸, the only test of the table.
        assert!((found[0].p_holm.unwrap().value() - 0.0078125).abs() < 1e-12);
        assert!(found[1].test.as_ref().unwrap_err().contains("no observer"));
        assert!(found[2].test.as_ref().unwrap_err().contains("one observer"));
    }
}
