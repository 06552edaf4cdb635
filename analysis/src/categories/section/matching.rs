//! Matching in words, tables and figures.

use super::method::{REFERENCES, TIMES_METHOD, observers_method};
use super::sentences::{SIMULATED, accuracy, agreement, d_prime, habits, known, reasons, times};
use super::tables::{
    accuracy_cells, accuracy_columns, column, comparisons_table, d_prime_cells, d_prime_columns,
    no_d_prime, times_table,
};
use crate::categories::Matching;
use crate::categories::discrimination::Strategy;
use crate::categories::matching::Pair;
use crate::report::labels::counted;
use crate::report::labels::letter;
use crate::report::plot::{Axis, Dot, dots, heat};
use crate::report::section::{Cell, Figure, Kind, Section, Table};

/// More pairs than these are left to the table.
const MOST_NAMED: usize = 12;

pub(super) fn section(matching: &Matching) -> Section {
    let mut references = REFERENCES.to_vec();
    references.push("Navarro, F. (2012). PhD thesis; part III, perception of motion blur.");
    references.sort_unstable();
    Section {
        heading: String::new(),
        sentences: sentences(matching),
        tables: vec![
            pairs(matching),
            confusion(matching),
            levels(matching),
            discrimination(matching),
            times_table(&matching.response_times),
            comparisons_table(&matching.comparisons),
            observers(matching),
        ],
        figures: figures(matching),
        method: vec![
            "In each trial one of two candidates matches the reference (Navarro 2012, §5.6), so guessing is \
             right in ½ of the trials. Two levels are told apart if the answers to their pair are better \
             than guessing by the exact binomial test, corrected by Holm (1979). Neighbouring levels are \
             merged where no pair among them is told apart. κ (Cohen 1960; standard error of Fleiss, Cohen \
             and Everitt 1969), χ² and information (Miller 1955) are of the side of the reference × the \
             side chosen: the table of levels cannot give them, because only two levels are offered."
                .into(),
            "Matching is the task ABX with the reference as X, and d′ follows from its models (Macmillan \
             and Creelman 2005, ch. 9; Kaplan, Macmillan and Creelman 1978). Levels change from trial to \
             trial, for which differencing is the model; independent observations assume a fixed pair. Over \
             all pairs side bias is taken out by hits and false alarms; for one pair d′ follows from the \
             share of right answers and assumes none. Shares of 0 and 1 are corrected (Hautus 1995). \
             Intervals are by likelihood over all pairs (Venzon and Moolgavkar 1988) and exact for one."
                .into(),
            observers_method(),
            TIMES_METHOD.into(),
            "Runs of the same side are tested by Wald and Wolfowitz (1940), exact.".into(),
        ],
        references,
    }
}

fn sentences(matching: &Matching) -> Vec<String> {
    let mut lines: Vec<String> = matching.simulated.then(|| SIMULATED.into()).into_iter().collect();
    lines.extend(accuracy(&matching.accuracy));
    lines.extend(told_apart(matching));
    lines.push(known("Merged levels", &matching.merged, |merged| {
        let groups = merged.groups.iter().map(|group| {
            let names: Vec<&str> = group.iter().map(|i| matching.levels[*i].as_str()).collect();
            format!("{{{}}}", names.join(", "))
        });
        let others = match &merged.others {
            Ok(others) => format!(
                "{:.1} % right in the other pairs, {} of {}; these were chosen after the answers were seen, \
                 so this is no estimate",
                others.percent, others.correct, others.trials
            ),
            Err(reason) => reason.clone(),
        };
        let groups = groups.collect::<Vec<_>>().join(" ");
        format!("{groups}; {} answers are about pairs within a group; {others}", merged.left_out)
    }));
    lines.extend(agreement("Side of the reference and side chosen", &matching.sides));
    lines.push(d_prime("All pairs taken for one, differencing", &matching.d_prime));
    lines.push(d_prime(
        "All pairs taken for one, independent observations",
        &matching.d_prime_independent,
    ));
    let missing = matching.pairs.iter().flat_map(|pair| {
        [&pair.d_prime, &pair.d_prime_independent].map(|d| match d {
            Ok(d) => d.estimate.se.as_ref().err().or(d.bootstrap_95.as_ref().err()).cloned(),
            Err(reason) => Some(reason.clone()),
        })
    });
    lines.extend(reasons("discrimination", missing.flatten()));
    lines.extend(times(&matching.response_times, &matching.comparisons));
    lines.extend(habits(matching.undecided, matching.too_fast, &matching.lapses));
    lines
}

/// The pairs that were and were not told apart.
fn told_apart(matching: &Matching) -> Vec<String> {
    let (apart, not): (Vec<&Pair>, Vec<&Pair>) =
        matching.pairs.iter().partition(|pair| pair.told_apart);
    let test = format!(
        "exact binomial tests against ½, upper tail, Holm's correction for {}, α = {}",
        counted(matching.pairs.len(), "pair"),
        matching.alpha
    );
    let mut lines = vec![format!(
        "Pairs told apart: {} of {} ({test}; intervals are of single pairs, at 95 %).",
        apart.len(),
        matching.pairs.len()
    )];
    if not.len() > MOST_NAMED {
        lines.push(format!(
            "Not told apart: {} pairs, named in the table of pairs. That does not show that they look the \
             same.",
            not.len()
        ));
    } else if !not.is_empty() {
        let each = not.iter().map(|pair| {
            let [low, high] = pair.accuracy.clopper_pearson_95;
            format!(
                "{} and {} ({:.0} % right of {}, {:.0} to {:.0} % possible)",
                pair.levels[0],
                pair.levels[1],
                pair.accuracy.percent,
                pair.accuracy.trials,
                100.0 * low,
                100.0 * high
            )
        });
        lines.push(format!(
            "Not told apart: {}. That does not show that they look the same: the exact 95 % intervals say \
             which accuracy remains possible.",
            each.collect::<Vec<_>>().join(", ")
        ));
    }
    lines
}

fn pairs(matching: &Matching) -> Table {
    let mut columns = vec![
        column("level", "level", Kind::Text, "The one level."),
        column("other", "other", Kind::Text, "The other."),
    ];
    columns.extend(accuracy_columns());
    columns.push(column("p_holm", "p (Holm)", Kind::P, "Corrected for the number of pairs."));
    columns.push(column("told_apart", "told apart", Kind::Flag, "Whether p_holm is at most α."));
    let rows = matching.pairs.iter().map(|pair| {
        let mut row: Vec<Cell> = pair.levels.iter().map(|level| level.as_str().into()).collect();
        row.extend(accuracy_cells(&pair.accuracy));
        row.extend([pair.p_holm.into(), pair.told_apart.into()]);
        row
    });
    Table {
        name: "pairs".into(),
        caption: format!(
            "Accuracy per pair of levels, whichever was the reference; α = {}.",
            matching.alpha
        ),
        columns,
        rows: rows.collect(),
    }
}

fn confusion(matching: &Matching) -> Table {
    let mut columns = vec![
        column("reference", "reference", Kind::Text, "Level of the reference."),
        column("foil", "other candidate", Kind::Text, "Level of the candidate that did not match."),
    ];
    columns.extend(accuracy_columns());
    columns.push(column("p_holm", "p (Holm)", Kind::P, "Corrected for the number of cells."));
    let rows = matching.cells.iter().map(|cell| {
        let mut row = vec![Cell::from(cell.reference.as_str()), cell.foil.as_str().into()];
        row.extend(accuracy_cells(&cell.accuracy));
        row.push(cell.p_holm.into());
        row
    });
    Table {
        name: "confusion".into(),
        caption:
            "Accuracy per reference and other candidate; the wrong answers chose the other one."
                .into(),
        columns,
        rows: rows.collect(),
    }
}

fn levels(matching: &Matching) -> Table {
    let roles = ["as_reference", "as_other", "when_chosen"];
    let titles = ["as reference", "as other candidate", "when chosen"];
    let mut columns = vec![
        column("level", "level", Kind::Text, "The level."),
        column(
            "groups",
            "groups",
            Kind::Text,
            "Letters of the groups of merged levels; levels that share one are not told apart.",
        ),
    ];
    for (role, title) in roles.iter().zip(titles) {
        columns.extend([
            column(&format!("{role}_trials"), title, Kind::Integer, "Answers in this role."),
            column(
                &format!("{role}_percent"),
                "% right",
                Kind::Number(1),
                "Right ones in percent.",
            ),
            column(
                &format!("{role}_low"),
                "95 %",
                Kind::Number(3),
                "Lower bound of Clopper and Pearson's exact 95 % interval.",
            ),
            column(&format!("{role}_high"), "to", Kind::Number(3), "Upper bound of it."),
        ]);
    }
    let rows = matching.per_level.iter().enumerate().map(|(place, level)| {
        let groups = matching.merged.as_ref().ok().map(|merged| {
            let of = merged.groups.iter().enumerate().filter(|(_, group)| group.contains(&place));
            of.map(|(group, _)| letter(group)).collect::<String>()
        });
        let mut row = vec![Cell::from(level.level.as_str()), groups.into()];
        for accuracy in [level.as_reference, level.as_foil, level.when_chosen] {
            row.extend([
                Cell::from(accuracy.map(|a| a.trials)),
                accuracy.map(|a| a.percent).into(),
                accuracy.map(|a| a.clopper_pearson_95[0]).into(),
                accuracy.map(|a| a.clopper_pearson_95[1]).into(),
            ]);
        }
        row
    });
    Table {
        name: "levels".into(),
        caption: "Accuracy per level: as the reference (recall), as the other candidate, and when it was \
                  chosen (precision); chance is 50 %."
            .into(),
        columns,
        rows: rows.collect(),
    }
}

fn discrimination(matching: &Matching) -> Table {
    let mut columns = vec![
        column("level", "level", Kind::Text, "The one level."),
        column("other", "other", Kind::Text, "The other."),
        column("correct", "right", Kind::Integer, "Right answers."),
        column("trials", "of", Kind::Integer, "Answers."),
    ];
    columns.extend(d_prime_columns());
    let rows = matching.pairs.iter().flat_map(|pair| {
        [
            (Strategy::Differencing, &pair.d_prime),
            (Strategy::IndependentObservations, &pair.d_prime_independent),
        ]
        .map(|(strategy, d)| {
            let mut row: Vec<Cell> =
                pair.levels.iter().map(|level| level.as_str().into()).collect();
            row.extend([pair.accuracy.correct.into(), pair.accuracy.trials.into()]);
            row.extend(match d {
                Err(_) => no_d_prime(strategy),
                Ok(d) => {
                    let e = &d.estimate;
                    let (interval, bootstrap) = (e.interval_95, &d.bootstrap_95);
                    d_prime_cells(strategy, e.d_prime, interval, &e.se, bootstrap, e.correction)
                }
            });
            row
        })
    });
    Table {
        name: "discrimination".into(),
        caption:
            "d′ per pair of levels, from the share of right answers as in ABX, without side bias."
                .into(),
        columns,
        rows: rows.collect(),
    }
}

fn observers(matching: &Matching) -> Table {
    let mut columns = vec![column("observer", "observer", Kind::Text, "The observer's code.")];
    columns.extend(accuracy_columns());
    columns.extend([
        column(
            "first_percent",
            "first chosen, %",
            Kind::Number(1),
            "How often the candidate shown first was chosen, in percent.",
        ),
        column("runs", "runs", Kind::Integer, "Runs of choosing the same side."),
        column("longest_run", "longest", Kind::Integer, "Answers in the longest of them."),
        column(
            "p_few_runs",
            "p (runs)",
            Kind::P,
            "Probability of no more runs if the answers came in any order, exact, lower tail, no \
             correction.",
        ),
    ]);
    let rows = matching.per_observer.iter().map(|observer| {
        let runs = observer.runs.as_ref().ok();
        let mut row = vec![Cell::from(observer.observer.as_str())];
        row.extend(accuracy_cells(&observer.accuracy));
        row.extend([
            observer.first_percent.into(),
            runs.map(|runs| runs.runs).into(),
            runs.map(|runs| runs.longest).into(),
            runs.map(|runs| runs.p_few).into(),
        ]);
        row
    });
    Table {
        name: "accuracy-by-observer".into(),
        caption: "Accuracy and habits of each observer. Without runs: all answers chose one side."
            .into(),
        columns,
        rows: rows.collect(),
    }
}

fn figures(matching: &Matching) -> Vec<Figure> {
    let cell = |i: usize, j: usize| {
        let of = |cell: &&crate::categories::matching::Cell| {
            cell.reference == matching.levels[i] && cell.foil == matching.levels[j]
        };
        let accuracy = matching.cells.iter().find(of)?.accuracy;
        Some((accuracy.share(), format!("{:.0}", accuracy.percent)))
    };
    let rows: Vec<Dot> = matching
        .pairs
        .iter()
        .map(|pair| Dot {
            label: format!("{} – {}", pair.levels[0], pair.levels[1]),
            value: Some(pair.accuracy.percent),
            interval: Some(pair.accuracy.clopper_pearson_95.map(|end| 100.0 * end)),
        })
        .collect();
    let axis = Axis { title: "right answers, %".into(), range: [0.0, 100.0], logarithmic: false };
    vec![
        Figure {
            name: "confusion".into(),
            caption: "Right answers in percent, by reference (row) and other candidate (column); white is \
                      chance, grey was not asked."
                .into(),
            svg: heat(
                "Right answers by reference and other candidate",
                &matching.levels,
                &matching.levels,
                cell,
            ),
        },
        Figure {
            name: "accuracy".into(),
            caption: "Right answers per pair of levels with exact 95 % intervals (Clopper and Pearson); the \
                      dotted line is chance."
                .into(),
            svg: dots("Right answers per pair of levels", &axis, &rows, &[50.0]),
        },
    ]
}
