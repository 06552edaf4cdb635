//! The section on order effects.

use super::{FISHER, HOLM, not_known, share};
use crate::outcome::Outcome;
use crate::paired::order_effects::OrderEffects;
use crate::report::labels::counted;
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{
    Cell, Column, Figure, Kind, Section, Table, share_cells, share_columns,
};

/// Whether what is shown first is chosen more or less often.
pub fn order_effects(effects: &Outcome<OrderEffects>) -> Section {
    let heading = "Order effects";
    let effects = match effects {
        Ok(effects) => effects,
        Err(reason) => return not_known(heading, reason),
    };
    let first = &effects.first_chosen;
    let tested = effects.pairs.iter().filter_map(|pair| pair.p_holm);
    let mut sentences = vec![
        format!(
            "the one shown first was chosen in {}, {} (n = {} trials by {}, in pairs shown in both orders; \
             two-sided, exact binomial, no correction); this assumes that chance decided the order within \
             each pair",
            share(first),
            first.p_binomial.equation(),
            first.trials,
            counted(effects.observers.len(), "observer")
        ),
        format!(
            "order and choice in each pair (Fisher's exact test, two-sided, corrected by Holm): {} of {} \
             have corrected p ≤ 0.05",
            tested.clone().filter(|p| p.value() <= 0.05).count(),
            counted(tested.count(), "pair")
        ),
        format!(
            "observer by observer (exact binomial, two-sided, corrected by Holm): {} of {} have corrected \
             p ≤ 0.05",
            effects.observers.iter().filter(|observer| observer.p_holm.value() <= 0.05).count(),
            effects.observers.len()
        ),
    ];
    sentences.extend(effects.pairs.iter().filter_map(|pair| {
        let reason = pair.p.as_ref().err()?;
        Some(format!("{} and {}: not tested, {reason}", pair.item, pair.other))
    }));
    if effects.not_sure > 0 {
        sentences.push(format!("{} chose neither and are left out", effects.not_sure));
    }
    if effects.pairs_in_one_order > 0 {
        sentences.push(format!(
            "{} shown in one order only, in which order and preference cannot be told apart; {} left out",
            match effects.pairs_in_one_order {
                1 => "1 pair was".to_string(),
                pairs => format!("{pairs} pairs were"),
            },
            match effects.answers_in_one_order {
                1 => "1 answer is".to_string(),
                answers => format!("{answers} answers are"),
            }
        ));
    }
    Section {
        heading: heading.into(),
        sentences,
        tables: vec![pairs(effects), observers(effects)],
        figures: vec![Figure {
            name: "order".into(),
            caption: "How often each observer chose the stimulus shown first, with Wilson's 95 % intervals. \
                      The line is at ½."
                .into(),
            svg: figure(effects),
        }],
        method: vec![
            "If chance decides which stimulus of a pair comes first and the order does not matter, the \
             first one is chosen in half of the trials, whatever the preferences and independently from \
             trial to trial; so the exact binomial test holds for all observers together. Pairs shown in one order only are \
             left out, since in them the first may be chosen because it is preferred. In each pair \
             that was shown in both orders, order and choice are tested by Fisher's (1935) exact test. \
             Tables are corrected by Holm (1979)."
                .into(),
        ],
        references: vec![FISHER, HOLM],
    }
}

fn pairs(effects: &OrderEffects) -> Table {
    let rows = effects.pairs.iter().map(|pair| {
        let ([first, of_first], [second, of_second]) =
            (pair.chosen_when_first, pair.chosen_when_second);
        vec![
            Cell::from(pair.item.as_str()),
            pair.other.as_str().into(),
            first.into(),
            of_first.into(),
            second.into(),
            of_second.into(),
            pair.p.as_ref().ok().copied().into(),
            pair.p_holm.into(),
        ]
    });
    let number = |name: &str, title: &str, description: &str| {
        Column::new(name, title, Kind::Integer, description)
    };
    Table {
        name: "order-pairs".into(),
        caption: format!(
            "Choices by order in each pair shown in both orders; tests corrected for {} pairs.",
            effects.pairs.iter().filter(|pair| pair.p.is_ok()).count()
        ),
        columns: vec![
            Column::new("item", "stimulus", Kind::Text, "Id of the stimulus."),
            Column::new("other", "other", Kind::Text, "Id of the other."),
            number(
                "chosen_when_first",
                "chosen as first",
                "Choices of item where it was shown first.",
            ),
            number("trials_when_first", "of", "Trials in which it was shown first."),
            number("chosen_when_second", "as second", "Choices of item where it was shown second."),
            number("trials_when_second", "of", "Trials in which it was shown second."),
            Column::new("p", "p", Kind::P, "Fisher's exact test, two-sided."),
            Column::new("p_holm", "p (Holm)", Kind::P, "p corrected by Holm (1979)."),
        ],
        rows: rows.collect(),
    }
}

fn observers(effects: &OrderEffects) -> Table {
    let mut columns = vec![Column::new("observer", "observer", Kind::Text, "The observer's code.")];
    columns.extend(share_columns());
    columns.push(Column::new(
        "p_holm",
        "p (Holm)",
        Kind::P,
        "p_binomial corrected by Holm (1979).",
    ));
    let rows = effects.observers.iter().map(|observer| {
        let mut row = vec![Cell::from(observer.observer.as_str())];
        row.extend(share_cells(&observer.proportion));
        row.push(observer.p_holm.into());
        row
    });
    Table {
        name: "order-observers".into(),
        caption: format!(
            "How often each observer chose what was shown first. Intervals: 95 %. Tests against ½, \
             corrected for {} observers.",
            effects.observers.len()
        ),
        columns,
        rows: rows.collect(),
    }
}

fn figure(effects: &OrderEffects) -> String {
    let axis = Axis { title: "share of the first".into(), range: [0.0, 1.0], logarithmic: false };
    let rows: Vec<Dot> = effects
        .observers
        .iter()
        .map(|observer| Dot {
            label: observer.observer.clone(),
            value: Some(observer.proportion.percent / 100.0),
            interval: Some(observer.proportion.wilson_95),
        })
        .collect();
    dots("First choices per observer", &axis, &rows, &[0.5])
}
