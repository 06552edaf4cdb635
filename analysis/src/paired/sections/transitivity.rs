//! The section on stochastic transitivity.

use super::not_known;
use crate::outcome::Outcome;
use crate::paired::transitivity::Transitivity;
use crate::report::section::{Cell, Column, Kind, Section, Table};

/// How many triples of stimuli violate stochastic transitivity.
pub fn transitivity(transitivity: &Outcome<Transitivity>) -> Section {
    let heading = "Stochastic transitivity";
    let found = match transitivity {
        Ok(found) => found,
        Err(reason) => return not_known(heading, reason),
    };
    let kinds = [("weak", found.weak), ("moderate", found.moderate), ("strong", found.strong)];
    let mut sentences = vec![format!(
        "violations among {} triples of stimuli: {}",
        found.triples,
        kinds
            .map(|(kind, v)| format!(
                "{kind} {} (largest deviation {:.3})",
                v.violations, v.max_deviation
            ))
            .join(", ")
    )];
    if found.untested_triples > 0 {
        sentences.push(format!(
            "{} more triples have a pair that was never judged",
            found.untested_triples
        ));
    }
    let rows = kinds.map(|(kind, violations)| {
        vec![
            Cell::from(kind),
            found.triples.into(),
            violations.violations.into(),
            violations.mean_deviation.into(),
            violations.max_deviation.into(),
        ]
    });
    let deviation = |name: &str, title: &str, which: &str| {
        let description = format!(
            "{which} of what the share of answers is short of in the violating triples, from 0 to 1."
        );
        Column::new(name, title, Kind::Number(3), &description)
    };
    let table = Table {
        name: "transitivity".into(),
        caption:
            "Triples of stimuli that violate weak, moderate and strong stochastic transitivity."
                .into(),
        columns: vec![
            Column::new("condition", "condition", Kind::Text, "Weak, moderate or strong."),
            Column::new(
                "triples",
                "triples",
                Kind::Integer,
                "Triples whose pairs were all judged.",
            ),
            Column::new("violations", "violations", Kind::Integer, "Triples that violate it."),
            deviation("mean_deviation", "mean deviation", "Mean"),
            deviation("max_deviation", "largest", "Largest"),
        ],
        rows: rows.to_vec(),
    };
    Section {
        heading: heading.into(),
        sentences,
        tables: vec![table],
        method: vec![
            "Where most answers prefer i to j and j to k, weak stochastic transitivity asks that most \
             prefer i to k; moderate and strong, that i is preferred to k at least as often as in the less \
             and the more certain of the two (Tversky 1969). A triple counts once. The counts describe the \
             data; sampling alone makes violations, most of all of the strong condition."
                .into(),
        ],
        references: vec![
            "Tversky, A. (1969). Intransitivity of preferences. Psychological Review 76, 31–48.",
        ],
        ..Section::default()
    }
}
