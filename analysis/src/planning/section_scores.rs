//! Scores, scale and simulated studies of a plan, for people.

use super::section::{number, observers, whole};
use super::simulation::{Estimate, Found};
use super::{Plan, ScaleRow, ScoreRow, Simulated};
use crate::report::section::{Cell, Section, Table};

pub(super) fn score_section(plan: &Plan, rows: &[ScoreRow]) -> Section {
    let effect = plan.assumptions.effect;
    let table = Table {
        name: "plan-scores".into(),
        caption: format!(
            "Groups by score differences at α = {}, t = {}: exact for two stimuli, one preferred to the other, \
             in a set otherwise halfway between them, all answers independent; simulated where people differ \
             (SD of each ln π).",
            plan.assumptions.alpha,
            plan.design.stimuli.len()
        ),
        columns: vec![
            observers(),
            whole("sets", "sets", "Complete sets of pairs: n of the test"),
            whole("r_c", "R_c", "Critical score difference"),
            whole(
                "largest",
                "largest difference",
                "The largest score difference that there can be",
            ),
            number("share", "R_c of it, %", 1, "R_c in percent of the largest difference"),
            number(
                "smallest_preference",
                "smallest preference at power 0.8",
                3,
                "The smallest preference that R_c separates with probability 0.8: exact; missing if none is",
            ),
            number(
                "power",
                &format!("power at {effect}"),
                3,
                "Probability that R_c separates the assumed effect: exact",
            ),
            number(
                "power_people_differ",
                &format!("power at {effect}, SD {}", plan.assumptions.spread),
                3,
                "The same if people differ so much in the log-worth of each stimulus: simulated",
            ),
        ],
        rows: rows
            .iter()
            .enumerate()
            .map(|(place, row)| {
                let simulated = plan.simulated.as_ref().ok();
                let differ = simulated.and_then(|simulated| simulated.effect_differ.get(place));
                vec![
                    row.observers.into(),
                    row.sets.into(),
                    row.r_c.into(),
                    row.largest.into(),
                    (100.0 * row.share).into(),
                    row.smallest_preference.into(),
                    row.power.into(),
                    differ.map(|found| found.ends.value).into(),
                ]
            })
            .collect(),
    };
    Section {
        heading: "Score differences (R_c)".into(),
        tables: vec![table],
        method: vec![
            "R_c is the critical difference of David (1988) from the studentized range.".into(),
        ],
        references: vec![
            "David, H. A. (1988). The Method of Paired Comparisons, 2nd edition. Griffin, London.",
        ],
        ..Section::default()
    }
}

pub(super) fn scale_section(plan: &Plan, rows: &[ScaleRow]) -> Section {
    let effect = plan.assumptions.effect;
    let range = |name: &str, title: &str, what: &str| {
        let of = |end: &str| {
            let what = format!("{end} standard error of a difference of two log-worths, {what}");
            number(
                &format!("{name}_{}", end.to_lowercase()),
                &format!("{title}, {}", end.to_lowercase()),
                3,
                &what,
            )
        };
        [of("Least"), of("Largest")]
    };
    let mut columns = vec![observers()];
    columns.extend(range("se_equal", "SE, equal", "if all are equal: Fisher information"));
    columns.extend(range("se_assumed", "SE, assumed", "at the assumed worths: Fisher information"));
    columns.extend([
        number(
            "preference_95",
            "±95 % of an even preference, points",
            1,
            "Half the 95 % interval of the preference between the least precise two of equal stimuli, in percentage points",
        ),
        number(
            "smallest_preference",
            "smallest preference at power 0.8",
            3,
            "The smallest preference that is found with probability 0.8 among all differences: normal approximation, Tukey",
        ),
        number("power", &format!("power at {effect}"), 3, "Power of that test at the assumed effect: approximate"),
    ]);
    let table = Table {
        name: "plan-scale".into(),
        caption: format!(
            "Bradley–Terry scale: standard errors of differences of ln π from the Fisher information; least and \
             largest over all pairs of stimuli. Tests of all differences at once at α = {}: normal \
             approximation, Tukey's correction, for the least precise two.",
            plan.assumptions.alpha
        ),
        columns,
        rows: rows
            .iter()
            .map(|row| {
                let numbers = row.se_equal.into_iter().chain(row.se_assumed).chain([
                    100.0 * row.preference_95,
                    row.smallest_preference,
                    row.power,
                ]);
                std::iter::once(row.observers.into()).chain(numbers.map(Cell::from)).collect()
            })
            .collect(),
    };
    Section {
        heading: "Scale".into(),
        sentences: vec![worths_sentence(plan)],
        tables: vec![table],
        method: vec!["The information is that of the model of Bradley and Terry (1952).".into()],
        references: vec![
            "Bradley, R. A. and Terry, M. E. (1952). Rank analysis of incomplete block designs. Biometrika 39, \
             324–345.",
        ],
        ..Section::default()
    }
}

/// The assumed worths in words.
fn worths_sentence(plan: &Plan) -> String {
    let assumptions = &plan.assumptions;
    let worths = assumptions.log_worths(&plan.design);
    let [low, high] =
        worths.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], w| [l.min(*w), h.max(*w)]);
    let ends = 100.0 / (1.0 + libm::exp(low - high));
    match (&assumptions.worths, plan.design.complete()) {
        (Some(_), _) => {
            format!(
                "Worths as given; the best is preferred to the worst in {ends:.1} % of the answers."
            )
        }
        (None, Ok(_)) => format!(
            "Assumed worths: each stimulus is preferred to the next in {:.0} % of the answers, {} before {}; \
             the first to the last in {ends:.1} %.",
            100.0 * assumptions.step,
            plan.design.name(0),
            plan.design.name(1)
        ),
        (None, Err(_)) => format!(
            "Assumed worths: each level is preferred to the next of its axis in {:.0} % of the answers, the \
             best stimulus to the worst in {ends:.1} %.",
            100.0 * assumptions.step
        ),
    }
}

pub(super) fn simulated_section(plan: &Plan, simulated: &Simulated) -> Section {
    let assumptions = &plan.assumptions;
    let spread = assumptions.spread;
    let all =
        [&simulated.alike, &simulated.differ, &simulated.equal_alike, &simulated.equal_differ];
    let largest_error = all
        .iter()
        .flat_map(|found| found.iter())
        .flat_map(|found| [found.any, found.neighbours, found.ends, found.all])
        .map(|estimate| estimate.monte_carlo_error)
        .fold(0.0, f64::max);
    let mut tables = vec![
        found_table("plan-groups", "all observers alike", &simulated.alike),
        false_table("plan-false", &simulated.equal_alike, &simulated.equal_differ, spread),
    ];
    if spread > 0.0 {
        let who = format!("observers who differ, SD {spread} of each ln π");
        tables.insert(1, found_table("plan-groups-people-differ", &who, &simulated.differ));
    }
    Section {
        heading: "Simulated studies".into(),
        sentences: vec![
            worths_sentence(plan),
            format!(
                "{} simulated studies, seed {}; the Monte Carlo error of a probability is at most {largest_error:.3}.",
                assumptions.studies, assumptions.seed
            ),
        ],
        tables,
        ..Section::default()
    }
}

fn value(estimate: &Result<Estimate, String>) -> Cell {
    estimate.as_ref().map_or(Cell::Missing, |estimate| estimate.value.into())
}

fn found_table(name: &str, who: &str, found: &[Found]) -> Table {
    Table {
        name: name.into(),
        caption: format!("With the assumed worths, {who}: simulated."),
        columns: vec![
            observers(),
            number("groups", "groups", 2, "Mean number of groups"),
            number(
                "neighbours",
                "neighbours told apart",
                3,
                "Share of neighbours in worth that R_c tells apart",
            ),
            number("all", "all neighbours", 3, "Probability that all neighbours are told apart"),
            number(
                "ends",
                "best and worst",
                3,
                "Probability that the best and the worst are told apart",
            ),
            number("zeta", "power of ζ", 3, "Power of the pooled test of circular triads"),
            number("u", "power of u", 3, "Power of the exact test of agreement"),
        ],
        rows: found
            .iter()
            .map(|row| {
                let numbers =
                    [row.groups, row.neighbours, row.all, row.ends].map(|e| e.value.into());
                let tests = [value(&row.zeta), value(&row.u)];
                std::iter::once(row.observers.into()).chain(numbers).chain(tests).collect()
            })
            .collect(),
    }
}

fn false_table(name: &str, alike: &[Found], differ: &[Found], spread: f64) -> Table {
    let mut columns = vec![observers()];
    for (key, who) in [("alike", "alike".to_string()), ("differ", format!("SD {spread}"))] {
        for (test, title) in [("r_c", "R_c"), ("zeta", "ζ"), ("u", "u")] {
            let what = format!(
                "How often {title} is significant although no stimulus is better, people {who}"
            );
            columns.push(number(&format!("{test}_{key}"), &format!("{title}, {who}"), 4, &what));
        }
    }
    Table {
        name: name.into(),
        caption: "With equal worths, how often each test finds something: its size if people are alike. If they \
                  differ, ζ finds that each has preferences, u that they share none, and R_c finds differences \
                  that are only theirs. Simulated."
            .into(),
        columns,
        rows: alike
            .iter()
            .zip(differ)
            .map(|(alike, differ)| {
                let of = |found: &Found| [found.any.value.into(), value(&found.zeta), value(&found.u)];
                std::iter::once(alike.observers.into()).chain(of(alike)).chain(of(differ)).collect()
            })
            .collect(),
    }
}
