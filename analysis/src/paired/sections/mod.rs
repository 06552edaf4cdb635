//! What the comparisons of levels, orders and groups, transitivity, equivalence and the clustered model
//! have to say, as sections of a report.

mod clustered;
mod concordance;
mod equivalence;
mod level_check;
mod levels;
mod observer_groups;
mod order_effects;
mod transitivity;

pub use clustered::clustered;
pub use concordance::concordance;
pub use equivalence::equivalence;
pub use level_check::level_check;
pub use levels::levels;
pub use observer_groups::observer_groups;
pub use order_effects::order_effects;
pub use transitivity::transitivity;

use crate::maths::corrections::Corrected;
use crate::maths::proportion::Proportion;
use crate::report::section::{Cell, Column, Kind, Section};

pub(super) const BENJAMINI_HOCHBERG: &str = "Benjamini, Y. and Hochberg, Y. (1995). Controlling the false discovery \
                                  rate: a practical and powerful approach to multiple testing. Journal of \
                                  the Royal Statistical Society B 57, 289–300.";
const FISHER: &str = "Fisher, R. A. (1935). The Design of Experiments. Oliver and Boyd, Edinburgh.";
pub(super) const HOLM: &str = "Holm, S. (1979). A simple sequentially rejective multiple test procedure. \
                    Scandinavian Journal of Statistics 6, 65–70.";

/// The columns that [`corrected_cells`] fills.
pub(super) fn corrected_columns() -> [Column; 2] {
    [
        Column::new("p_holm", "p (Holm)", Kind::P, "p_binomial corrected by Holm (1979)."),
        Column::new(
            "p_benjamini_hochberg",
            "p (BH)",
            Kind::P,
            "p_binomial corrected by Benjamini and Hochberg (1995).",
        ),
    ]
}

pub(super) fn corrected_cells(corrected: &Corrected) -> [Cell; 2] {
    [corrected.p_holm.into(), corrected.p_benjamini_hochberg.into()]
}

/// A section that only says why there is nothing.
fn not_known(heading: &str, reason: &str) -> Section {
    Section {
        heading: heading.into(),
        sentences: vec![format!("{heading} not known: {reason}")],
        ..Section::default()
    }
}

/// `15 of 20 (75.0 %, 95 % interval 53.1 to 88.8 %)`.
fn share(share: &Proportion) -> String {
    let [low, high] = share.wilson_95.map(|bound| 100.0 * bound);
    format!(
        "{} of {} ({:.1} %, 95 % interval {low:.1} to {high:.1} %)",
        share.chosen, share.trials, share.percent
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::preferences::{Choice, Observer, WinMatrix};
    use crate::paired::clustered::{by_item, by_level};
    use crate::paired::equivalence::equivalence_within_groups;
    use crate::paired::friedman::friedman;
    use crate::paired::level_check::level_check as check;
    use crate::paired::levels::levels as of_levels;
    use crate::paired::observer_groups::observer_groups as of_groups;
    use crate::paired::order_effects::order_effects as of_order;
    use crate::paired::transitivity::transitivity as of_triples;
    use shutterlab_data_schema::response::Side;
    use std::collections::BTreeMap;

    /// `observers` who answer by `answer(observer, a, b)` to each pair of a grid of four stimuli.
    fn all_of(
        observers: usize,
        answer: impl Fn(usize, usize, usize) -> Option<Side>,
    ) -> Vec<Section> {
        let items = ["T3-A4", "T3-A5", "T4-A4", "T4-A5"].map(String::from);
        let people: Vec<Observer> = (0..observers)
            .map(|place| Observer {
                code: format!("P{place}"),
                traits: BTreeMap::from([("half".into(), (place % 2).to_string())]),
            })
            .collect();
        let mut wins = WinMatrix::new(4);
        let mut scores = vec![vec![0; 4]; observers];
        let mut choices = Vec::new();
        for (observer, scores) in scores.iter_mut().enumerate() {
            for (a, b) in wins.pairs() {
                let chosen = answer(observer, a, b);
                let first = if (observer + a + b) % 2 == 0 { Side::A } else { Side::B };
                choices.push(Choice { observer, a, b, chosen, first: Some(first) });
                if let Some(chosen) = chosen {
                    let (winner, loser) = if chosen == Side::A { (a, b) } else { (b, a) };
                    wins.add(winner, loser, 1);
                    scores[winner] += 1;
                }
            }
        }
        let groups = [items.to_vec()];
        vec![
            levels(&of_levels(&items, &wins)),
            order_effects(&of_order(&items, &people, &choices)),
            observer_groups(&Ok(of_groups(&items, &people, &choices))),
            concordance(&friedman(&scores)),
            transitivity(&of_triples(&wins)),
            equivalence(&equivalence_within_groups(&items, &wins, &groups, 0.1, 0.05)),
            clustered(&by_item(&items, &choices), &by_level(&items, &choices)),
            level_check(&check(observers as u64, 4, 0.05, 0.0, 50, 1)),
        ]
    }

    /// Every p stands beside its n (or trials) and the name of its test, and every row fits its header.
    fn check_form(sections: &[Section]) {
        for section in sections {
            assert!(!section.sentences.is_empty(), "{}", section.heading);
            let text = format!("{section:?}");
            assert!(!text.contains("NaN") && !text.contains("inf,"), "{text}");
            for sentence in section.sentences.iter().filter(|s| s.contains("p = ")) {
                assert!(
                    ["exact", "approximat", "permut", "Holm", "best"]
                        .iter()
                        .any(|how| sentence.contains(how)),
                    "{sentence}"
                );
            }
            for table in &section.tables {
                assert!(
                    table.rows.iter().all(|row| row.len() == table.columns.len()),
                    "{}",
                    table.name
                );
            }
        }
    }

    #[test]
    fn ordinary_answers_have_every_section() {
        let found = all_of(9, |observer, a, b| {
            let noisy = (observer * 5 + a * 3 + b * 7) % 4 == 0;
            Some(if noisy { Side::B } else { Side::A })
        });
        check_form(&found);
        assert!(found.iter().all(|section| !section.sentences[0].contains("not known")));
    }

    #[test]
    fn awkward_answers_have_words() {
        let alike = |_, _, _| Some(Side::A);
        let nothing = |_, _, _| None;
        let circle = |_, a, b| Some(if (a, b) == (0, 3) { Side::B } else { Side::A });
        for (observers, sections) in [
            (1, all_of(1, alike)),
            (2, all_of(2, alike)),
            (6, all_of(6, alike)),
            (6, all_of(6, nothing)),
            (6, all_of(6, circle)),
            (0, all_of(0, alike)),
        ] {
            check_form(&sections);
            assert_eq!(sections.len(), 8, "{observers}");
        }
    }
}
