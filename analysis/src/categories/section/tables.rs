//! Columns, cells and tables that matching and same/different have in common.

use crate::categories::accuracy::Accuracy;
use crate::categories::discrimination::Strategy;
use crate::categories::response_times::{Comparison, Condition};
use crate::outcome::Outcome;
use crate::report::section::{Cell, Column, Kind, Table};

pub(super) fn column(name: &str, title: &str, kind: Kind, description: &str) -> Column {
    Column::new(name, title, kind, description)
}

/// The columns that [`accuracy_cells`] fills.
pub(super) fn accuracy_columns() -> Vec<Column> {
    vec![
        column("correct", "right", Kind::Integer, "Right answers."),
        column("trials", "of", Kind::Integer, "Answers."),
        column("percent", "%", Kind::Number(1), "Right answers in percent."),
        column("chance", "chance", Kind::Number(2), "Share that guessing gets right, 0 to 1."),
        column(
            "wilson_95_low",
            "Wilson",
            Kind::Number(3),
            "Lower bound of Wilson's 95 % interval.",
        ),
        column("wilson_95_high", "to", Kind::Number(3), "Upper bound of Wilson's 95 % interval."),
        column(
            "clopper_pearson_95_low",
            "Clopper–Pearson",
            Kind::Number(3),
            "Lower bound of Clopper and Pearson's exact 95 % interval.",
        ),
        column(
            "clopper_pearson_95_high",
            "to",
            Kind::Number(3),
            "Upper bound of Clopper and Pearson's exact 95 % interval.",
        ),
        column("p", "p (exact)", Kind::P, "Exact binomial test against chance, upper tail."),
    ]
}

/// Accuracy as cells.
pub(super) fn accuracy_cells(accuracy: &Accuracy) -> Vec<Cell> {
    vec![
        accuracy.correct.into(),
        accuracy.trials.into(),
        accuracy.percent.into(),
        accuracy.chance.into(),
        accuracy.wilson_95[0].into(),
        accuracy.wilson_95[1].into(),
        accuracy.clopper_pearson_95[0].into(),
        accuracy.clopper_pearson_95[1].into(),
        accuracy.p_above_chance.into(),
    ]
}

/// The columns that [`d_prime_cells`] fills.
pub(super) fn d_prime_columns() -> Vec<Column> {
    vec![
        column(
            "strategy",
            "sensations compared by",
            Kind::Text,
            "How sensations are taken to be compared: differencing or independent observations.",
        ),
        column(
            "d_prime",
            "d′",
            Kind::Number(2),
            "Sensitivity, in standard deviations of a sensation.",
        ),
        column("se", "SE", Kind::Number(2), "Standard error of d′ by the delta method."),
        column("low_95", "95 %", Kind::Number(2), "Lower end of the 95 % interval of d′."),
        column("high_95", "to", Kind::Number(2), "Upper end; empty if the answers set none."),
        column(
            "bootstrap_low_95",
            "by observer",
            Kind::Number(2),
            "Lower end of the 95 % bootstrap interval of d′ by observer.",
        ),
        column("bootstrap_high_95", "to", Kind::Number(2), "Upper end of it."),
        column("correction", "correction", Kind::Text, "How shares of 0 and 1 were corrected."),
    ]
}

/// d′, its interval, standard error, bootstrap interval and correction as cells.
pub(super) fn d_prime_cells(
    strategy: Strategy,
    d_prime: f64,
    interval: [Option<f64>; 2],
    se: &Outcome<f64>,
    bootstrap: &Outcome<[f64; 2]>,
    correction: Option<&str>,
) -> Vec<Cell> {
    let end = |end: usize| bootstrap.as_ref().ok().map(|interval| interval[end]).into();
    vec![
        strategy.name().into(),
        d_prime.into(),
        se.as_ref().ok().copied().into(),
        interval[0].into(),
        interval[1].into(),
        end(0),
        end(1),
        correction.into(),
    ]
}

/// The cells of a row without d′.
pub(super) fn no_d_prime(strategy: Strategy) -> Vec<Cell> {
    let mut cells = vec![Cell::Missing; d_prime_columns().len()];
    cells[0] = strategy.name().into();
    cells
}

pub(super) fn times_table(conditions: &[Condition]) -> Table {
    let seconds = |name: &str, title: &str, description: &str| {
        column(name, title, Kind::Number(2), description)
    };
    let rows = conditions.iter().map(|condition| {
        let name = Cell::from(condition.condition.as_str());
        let Ok(times) = &condition.times else {
            return [vec![name], vec![Cell::Missing; 10]].concat();
        };
        let interval = times.median_interval.as_ref().ok();
        vec![
            name,
            times.answers.into(),
            times.before_end.into(),
            times.quartiles.first.into(),
            times.quartiles.median.into(),
            times.quartiles.third.into(),
            interval.map(|interval| interval.low).into(),
            interval.map(|interval| interval.high).into(),
            interval.map(|interval| interval.coverage).into(),
            times.geometric_mean.as_ref().ok().copied().into(),
            times.outliers.into(),
        ]
    });
    Table {
        name: "response-times".into(),
        caption: "Response times in seconds, from the end of what was shown last to the answer. Conditions \
                  without answers are empty; a median's interval needs 6 answers."
            .into(),
        columns: vec![
            column("condition", "condition", Kind::Text, "What the answers have in common."),
            column("answers", "n", Kind::Integer, "Answers."),
            column(
                "before_end",
                "before the end",
                Kind::Integer,
                "Answers given before the end of what was shown last; their times are negative.",
            ),
            seconds("first_quartile_s", "¼", "First quartile in seconds."),
            seconds("median_s", "median", "Median in seconds."),
            seconds("third_quartile_s", "¾", "Third quartile in seconds."),
            seconds("median_low_s", "interval", "Lower end of the median's interval in seconds."),
            seconds("median_high_s", "to", "Upper end of the median's interval in seconds."),
            column(
                "coverage",
                "level",
                Kind::Number(3),
                "Exact level of confidence of that interval, at least 0.95.",
            ),
            seconds(
                "geometric_mean_s",
                "geometric mean",
                "Geometric mean in seconds, of the answers given after the end.",
            ),
            column(
                "outliers",
                "outliers",
                Kind::Integer,
                "Answers more than 3 interquartile ranges outside the quartiles; left in.",
            ),
        ],
        rows: rows.collect(),
    }
}

pub(super) fn comparisons_table(comparisons: &[Comparison]) -> Table {
    let rows = comparisons.iter().map(|comparison| {
        let [before, after] = &comparison.conditions;
        let test = comparison.test.as_ref().ok();
        vec![
            before.as_str().into(),
            after.as_str().into(),
            comparison.observers.into(),
            comparison.median_difference_s.into(),
            test.map(|test| test.w).into(),
            test.map(|test| test.p).into(),
            comparison.p_holm.into(),
        ]
    });
    Table {
        name: "response-time-comparisons".into(),
        caption:
            "Response times compared within observers, by each observer's medians: Wilcoxon's \
                  signed-rank test, two-sided, exact."
                .into(),
        columns: vec![
            column("condition", "condition", Kind::Text, "The one."),
            column("other", "other", Kind::Text, "The other."),
            column("observers", "observers", Kind::Integer, "Observers with answers in both."),
            column(
                "median_difference_s",
                "other less one, s",
                Kind::Number(2),
                "Median over the observers of the difference of their medians, in seconds.",
            ),
            column("w", "W", Kind::Number(1), "Sum of the ranks of positive differences."),
            column("p", "p", Kind::P, "Two-sided, exact."),
            column(
                "p_holm",
                "p (Holm)",
                Kind::P,
                "Corrected for the comparisons that were tested.",
            ),
        ],
        rows: rows.collect(),
    }
}
