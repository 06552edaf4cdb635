//! A plan for people.

use super::Plan;
use super::rating::TRUTHS;
use super::section_scores::{scale_section, score_section, simulated_section};
use super::share::ShareTest;
use crate::report::section::{Cell, Column, Kind, Section, Table};

/// The parts of `plan` that its task and design have.
pub fn sections(plan: &Plan) -> Vec<Section> {
    let assumptions = &plan.assumptions;
    let alpha = assumptions.alpha;
    let mut sections = Vec::new();
    let mut missing = Vec::new();
    let mut keep = |section: Result<Section, String>| match section {
        Ok(section) => sections.push(section),
        Err(reason) => missing.push(reason),
    };
    keep(
        plan.pair
            .as_ref()
            .map(|test| share_section("One pair", "pair", "", test, alpha))
            .map_err(|reason| format!("One pair: {reason}.")),
    );
    match &plan.levels {
        Ok(levels) => {
            for (comparisons, test) in levels {
                let names: Vec<String> = comparisons
                    .iter()
                    .map(|c| format!("{} {}–{}", c.axis, c.levels[0], c.levels[1]))
                    .collect();
                let name = format!("levels-{}", test.answers_per_observer);
                let about =
                    format!("Over the pairs that differ in nothing else: {}.", names.join(", "));
                keep(Ok(share_section("Two levels of an axis", &name, &about, test, alpha)));
            }
        }
        Err(reason) => keep(Err(format!("Two levels of an axis: {reason}."))),
    }
    keep(
        plan.accuracy
            .as_ref()
            .map(|test| {
                let about = "All answers that are right or wrong, against one half.";
                share_section("All answers", "accuracy", about, test, alpha)
            })
            .map_err(|reason| format!("Accuracy: {reason}.")),
    );
    keep(rating_section(plan).map_err(|reason| format!("Ratings: {reason}.")));
    let scores = plan.scores.as_ref().map(|rows| score_section(plan, rows));
    keep(scores.map_err(|reason| format!("Score differences: {reason}.")));
    let scale = plan.scale.as_ref().map(|rows| scale_section(plan, rows));
    keep(scale.map_err(|reason| format!("Scale: {reason}.")));
    let simulated = plan.simulated.as_ref().map(|simulated| simulated_section(plan, simulated));
    keep(simulated.map_err(|reason| format!("Simulated studies: {reason}.")));
    if !missing.is_empty() {
        let heading = "What does not apply".to_string();
        sections.push(Section { heading, sentences: missing, ..Section::default() });
    }
    sections
}

pub(super) fn observers() -> Column {
    Column::new("observers", "observers", Kind::Integer, "Number of observers")
}

pub(super) fn number(name: &str, title: &str, decimals: usize, description: &str) -> Column {
    Column::new(name, title, Kind::Number(decimals), description)
}

pub(super) fn whole(name: &str, title: &str, description: &str) -> Column {
    Column::new(name, title, Kind::Integer, description)
}

fn share_section(heading: &str, name: &str, about: &str, test: &ShareTest, alpha: f64) -> Section {
    let sided = match test.sides {
        super::power::Sides::One => "one-sided",
        super::power::Sides::Two => "two-sided",
    };
    let mut columns = vec![
        observers(),
        whole("answers", "answers", "Answers of all observers"),
        whole("critical", "critical", "The smallest count that is significant; missing if none is"),
        number(
            "size",
            "size",
            4,
            "Probability of significance if both answers are equally likely: exact",
        ),
    ];
    for share in &test.shares {
        let title = format!("power at {share}");
        let what = format!("Power at the true share {share}, answers independent: exact");
        columns.push(number(&format!("power_{}", 100.0 * share), &title, 3, &what));
    }
    for (name, title) in [("wilson_width", "Wilson width"), ("clopper_pearson_width", "C–P width")]
    {
        let what =
            "Expected width of the 95 % interval at a share of a half, in percentage points: exact";
        columns.push(number(name, title, 1, what));
    }
    let rows = test.rows.iter().map(|row| {
        let mut cells: Vec<Cell> =
            vec![row.observers.into(), row.trials.into(), row.critical.into(), row.size.into()];
        cells.extend(row.power.iter().map(|power| Cell::from(*power)));
        cells.extend([row.wilson_width, row.clopper_pearson_width].map(|w| Cell::from(100.0 * w)));
        cells
    });
    let exact = Table {
        name: format!("plan-{name}"),
        caption: format!(
            "Exact binomial test of a share against a half, {sided}, α = {alpha}, {} {} of each observer: exact, \
             all answers independent. Widths of 95 % intervals in percentage points, expected at 50 %.",
            test.answers_per_observer,
            if test.answers_per_observer == 1 { "answer" } else { "answers" },
        ),
        columns,
        rows: rows.collect(),
    };
    let mut tables = vec![exact];
    let mut sentences: Vec<String> =
        Some(about.to_string()).filter(|a| !a.is_empty()).into_iter().collect();
    match test.answers_per_observer {
        1 => {
            sentences.push("Each observer answers once, so people may differ as they like.".into())
        }
        _ if test.log_odds_sd > 0.0 => {
            let effects: Vec<String> = test
                .shares
                .iter()
                .zip(&test.correlations)
                .map(|(share, rho)| {
                    let effect = super::power::design_effect(test.answers_per_observer, *rho);
                    format!("{effect:.2} at {share}")
                })
                .collect();
            sentences.push(format!(
                "If people differ with an SD of {:.2} in log-odds, as much in all {} answers, the design effect \
                 is {}.",
                test.log_odds_sd,
                test.answers_per_observer,
                effects.join(", ")
            ));
            tables.push(clustered(name, test));
        }
        _ => {}
    }
    Section { heading: heading.into(), sentences, tables, ..Section::default() }
}

/// The table of a share when people differ.
fn clustered(name: &str, test: &ShareTest) -> Table {
    let size = "Approximate size of the test that takes all answers as independent";
    let mut columns = vec![observers(), number("size", "size of the plain test", 4, size)];
    for share in &test.shares {
        let what =
            format!("Approximate power at the true share {share} of a test that allows for that");
        let title = format!("power at {share}");
        columns.push(number(&format!("power_{}", 100.0 * share), &title, 3, &what));
    }
    let rows = test.rows.iter().map(|row| {
        let mut cells: Vec<Cell> = vec![row.observers.into(), row.size_if_people_differ.into()];
        cells.extend(row.power_if_people_differ.iter().map(|power| Cell::from(*power)));
        cells
    });
    Table {
        name: format!("plan-{name}-people-differ"),
        caption:
            "The same if people differ: size of the plain test, power of one that allows for it \
                  (approximation: as many independent answers as these are worth)."
                .into(),
        columns,
        rows: rows.collect(),
    }
}

fn rating_section(plan: &Plan) -> Result<Section, String> {
    let rows = plan.rating.as_ref().map_err(String::clone)?;
    let [high, higher] = TRUTHS;
    let clears = |truth: f64| {
        format!(
            "Probability that the lower end of Wilson's 95 % interval exceeds 0.8 at a true {truth}: exact"
        )
    };
    let width =
        "Expected width of the 95 % interval at a true rating of 0.8, in percentage points: exact";
    let table = Table {
        name: "plan-rating".into(),
        caption: "Rating of one pair, the share of answers \"the same\": probability that its interval clears \
                  0.8, exact; widths of 95 % intervals in percentage points, expected at 0.8."
            .into(),
        columns: vec![
            observers(),
            whole("answers", "answers", "Answers to the pair"),
            number("clears_90", &format!("clears 0.8 at {high}"), 3, &clears(high)),
            number("clears_95", &format!("clears 0.8 at {higher}"), 3, &clears(higher)),
            number("wilson_width", "Wilson width", 1, width),
            number("clopper_pearson_width", "C–P width", 1, width),
        ],
        rows: rows
            .iter()
            .map(|row| {
                let widths = [row.wilson_width, row.clopper_pearson_width].map(|w| 100.0 * w);
                let counts: [Cell; 2] = [row.observers.into(), row.trials.into()];
                counts.into_iter().chain(row.clears.into_iter().chain(widths).map(Cell::from)).collect()
            })
            .collect(),
    };
    Ok(Section { heading: "Rating of a pair".into(), tables: vec![table], ..Section::default() })
}
