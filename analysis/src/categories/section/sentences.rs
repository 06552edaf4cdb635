//! Sentences that matching and same/different have in common.

use crate::categories::confusion::Confusion;
use crate::categories::discrimination::{DPrime, Model, Strategy};
use crate::categories::observers::Observers;
use crate::categories::quality::{FASTEST_S, Lapses};
use crate::categories::resampled::Resampled;
use crate::categories::response_times::{Comparison, Condition};
use crate::outcome::Outcome;
use crate::report::labels::counted;

pub(super) const SIMULATED: &str =
    "The observers were simulated: this is a check of the tool, never a finding.";

/// What `words` say of a result, or why there is none.
pub(super) fn known<T>(
    what: &str,
    result: &Outcome<T>,
    words: impl FnOnce(&T) -> String,
) -> String {
    match result {
        Ok(result) => format!("{what}: {}.", words(result)),
        Err(reason) => format!("{what}: not known, {reason}."),
    }
}

/// A share's interval in percent.
pub(super) fn percents([low, high]: [f64; 2]) -> String {
    format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high)
}

/// An interval whose ends may be open.
pub(super) fn ends(interval: [Option<f64>; 2]) -> String {
    match interval {
        [Some(low), Some(high)] => format!("{low:.2} to {high:.2}"),
        [Some(low), None] => format!("from {low:.2}, without an upper end"),
        [None, Some(high)] => format!("up to {high:.2}, without a lower end"),
        [None, None] => "of any value".into(),
    }
}

/// Accuracy over all observers.
pub(super) fn accuracy(accuracy: &Observers) -> Vec<String> {
    let pooled = &accuracy.pooled;
    let people = counted(accuracy.observers as usize, "observer");
    let n = format!("n = {} answers by {people}", pooled.trials);
    let test = match (pooled.p_above_chance, pooled.p_above_chance_reason) {
        (Some(p), _) => format!("upper tail, no correction, {n}: {}", p.equation()),
        (None, reason) => format!("none, {}; {n}", reason.unwrap_or_default()),
    };
    let mut lines = vec![
        format!(
            "Accuracy: {:.2} %, {} of {} answers (95 % interval {}, Clopper and Pearson; {}, Wilson); \
             exact binomial test against chance, {:.0} %, {test}. These take all answers for independent.",
            pooled.percent,
            pooled.correct,
            pooled.trials,
            percents(pooled.clopper_pearson_95),
            percents(pooled.wilson_95),
            100.0 * pooled.chance,
        ),
        known("Accuracy, cluster-robust 95 % interval by observer", &accuracy.robust_95, |x| {
            percents(*x)
        }),
        known("Accuracy, bootstrap 95 % interval by observer", &accuracy.bootstrap_95, |x| {
            percents(*x)
        }),
    ];
    lines.push(known("Differences between observers", &accuracy.heterogeneity, |test| {
        let effect = accuracy.design_effect.as_ref().ok();
        let effect = effect.map_or(String::new(), |x| format!("; design effect {x:.2}"));
        format!(
            "χ² = {:.2}, df = {}, {} ({n}; upper tail, χ² approximation), {} ({} permutations){effect}",
            test.chi2,
            test.df,
            test.p.equation(),
            test.p_permutation.equation(),
            test.deals
        )
    }));
    lines
}

/// A table of two kinds of trials × two answers.
pub(super) fn agreement(what: &str, table: &Outcome<Confusion>) -> Vec<String> {
    let table = match table {
        Ok(table) => table,
        Err(reason) => return vec![format!("{what}: not known, {reason}.")],
    };
    let n = table.accuracy.trials;
    let information = format!(
        "information {:.3} bits ({:.3} less the excess by chance)",
        table.mutual_information_bits, table.mutual_information_corrected_bits
    );
    vec![
        known(&format!("{what}, κ"), &table.kappa, |kappa| {
            let interval = match &kappa.interval_95 {
                Ok([low, high]) => format!("95 % interval {low:.3} to {high:.3}"),
                Err(reason) => format!("95 % interval not known, {reason}"),
            };
            format!("{:.3} (SE {:.3}, {interval}, n = {n}); {information}", kappa.kappa, kappa.se)
        }),
        known(&format!("{what}, independence"), &table.association, |test| {
            let few = match test.cells_below_5 {
                0 => String::new(),
                cells => format!("; poor, {cells} cells are expected to hold less than 5"),
            };
            format!(
                "χ² = {:.2}, df = {}, {} (n = {n}; upper tail, χ² approximation, no correction{few}); \
                 Cramér's V = {:.3}",
                test.chi2,
                test.df,
                test.p.equation(),
                test.cramers_v
            )
        }),
    ]
}

/// d′ over all trials.
pub(super) fn d_prime(what: &str, result: &Outcome<Resampled<DPrime>>) -> String {
    known(what, result, |resampled| {
        let DPrime { model, counts, .. } = &resampled.estimate;
        let d = &resampled.estimate;
        let se = d.se.as_ref().map_or_else(Clone::clone, |se| format!("SE {se:.2}"));
        let bootstrap = match &resampled.bootstrap_95 {
            Ok([low, high]) => format!("{low:.2} to {high:.2} by bootstrap over observers"),
            Err(reason) => format!("none by bootstrap, {reason}"),
        };
        let criterion = match model {
            Model::SameDifferent(Strategy::Differencing) => "criterion k",
            _ => "criterion c",
        };
        let correction = d.correction.map_or(String::new(), |how| format!("; {how}"));
        format!(
            "d′ = {:.2} ({se}; 95 % interval {} by likelihood, {bootstrap}); {criterion} = {:.2}, ln β = \
             {:.2}; hits {} of {}, false alarms {} of {}{correction}",
            d.d_prime,
            ends(d.interval_95),
            d.criterion,
            d.ln_beta,
            counts.hits,
            counts.signals,
            counts.false_alarms,
            counts.noises,
        )
    })
}

/// How observers answered, apart from what.
pub(super) fn habits(undecided: u64, too_fast: u64, lapses: &Outcome<Lapses>) -> Vec<String> {
    let fast = format!(
        "Answers within {FASTEST_S} s of the beginning of what was shown last: {too_fast}; they are counted \
         and left in."
    );
    let undecided = format!("Answers \"not sure\": {undecided}; they count nowhere else.");
    let lapses = known("Lapse rate from catch trials", lapses, |lapses| {
        format!(
            "{:.1} % (95 % interval {}, Clopper and Pearson; {} wrong of {}, of which guessers get half \
             right)",
            100.0 * lapses.rate,
            percents(lapses.interval_95),
            lapses.wrong,
            lapses.trials
        )
    });
    vec![undecided, fast, lapses]
}

/// Response times in words: all answers, and what differs.
pub(super) fn times(conditions: &[Condition], comparisons: &[Comparison]) -> Vec<String> {
    let mut lines: Vec<String> = conditions
        .first()
        .map(|all| {
            known("Response time, all answers", &all.times, |times| {
                let interval = match &times.median_interval {
                    Ok(i) => format!(
                        "{:.2} to {:.2} s at {:.1} %, order statistics",
                        i.low,
                        i.high,
                        100.0 * i.coverage
                    ),
                    Err(reason) => format!("interval not known, {reason}"),
                };
                format!(
                    "median {:.2} s ({interval}; n = {}); {} before the end of what was shown last; {} \
                     outliers, left in",
                    times.quartiles.median, times.answers, times.before_end, times.outliers
                )
            })
        })
        .into_iter()
        .collect();
    if let Some(first) = comparisons.first() {
        let [before, after] = &first.conditions;
        lines.push(known(&format!("Response time, {after} less {before}"), &first.test, |test| {
            format!(
                "{:+.2} s in the median observer; Wilcoxon's signed-rank test of the observers' medians, \
                 W = {}, {} observers ({} without a difference), two-sided, exact: {}, {} by Holm's \
                 correction for {}",
                first.median_difference_s.unwrap_or(0.0),
                test.w,
                test.pairs + test.zeros,
                test.zeros,
                test.p.equation(),
                first.p_holm.map_or(String::new(), |p| p.equation()),
                counted(
                    comparisons.iter().filter(|comparison| comparison.test.is_ok()).count(),
                    "comparison"
                ),
            )
        }));
    }
    lines
}

/// The reasons that `outcomes` of a table give, each once.
pub(super) fn reasons(table: &str, reasons: impl IntoIterator<Item = String>) -> Option<String> {
    let mut reasons: Vec<String> = reasons.into_iter().collect();
    reasons.sort();
    reasons.dedup();
    (!reasons.is_empty())
        .then(|| format!("Missing in the table of {table}: {}.", reasons.join("; ")))
}
