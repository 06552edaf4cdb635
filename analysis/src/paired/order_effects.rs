//! Order effects: is what is shown first chosen more (or less) often?

use crate::input::preferences::{Choice, Observer};
use crate::maths::corrections::{holm, holm_of_known};
use crate::maths::fisher_exact::fisher_exact;
use crate::maths::p_value::PValue;
use crate::maths::proportion::Proportion;
use crate::outcome::{Outcome, serialize_outcomes};
use serde::Serialize;
use shutterlab_data_schema::response::Side;
use std::collections::BTreeMap;

/// How the order of two stimuli bears on the choice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderEffects {
    /// How often the one shown first was chosen, over the answers that chose in `pairs`.
    pub first_chosen: Proportion,
    /// Answers that chose neither ("not sure"), left out.
    pub not_sure: u64,
    /// Each pair that was shown in both orders.
    pub pairs: Vec<PairOrder>,
    /// Pairs that were shown in one order only, in which order and preference cannot be told apart.
    pub pairs_in_one_order: u64,
    /// Answers that chose in those pairs, left out.
    pub answers_in_one_order: u64,
    /// Each observer who chose in `pairs`, over the answers in them.
    pub observers: Vec<ObserverOrder>,
}

/// The choices in one pair by order.
#[derive(Clone, Debug, PartialEq)]
pub struct PairOrder {
    /// The stimulus that comes first in the list of stimuli.
    pub item: String,
    /// The other.
    pub other: String,
    /// How often `item` was chosen where it was shown first, and out of how many.
    pub chosen_when_first: [u64; 2],
    /// How often `item` was chosen where it was shown second, and out of how many.
    pub chosen_when_second: [u64; 2],
    /// Fisher's exact test of order and choice, two-sided.
    pub p: Outcome<PValue>,
    /// `p` corrected for the number of pairs that were tested by Holm (1979).
    pub p_holm: Option<PValue>,
}

serialize_outcomes!(PairOrder, [item, other, chosen_when_first, chosen_when_second, p_holm], [p]);

/// How often one observer chose what was shown first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObserverOrder {
    /// The observer's code.
    pub observer: String,
    /// How often the first was chosen.
    #[serde(flatten)]
    pub proportion: Proportion,
    /// Exact p corrected for the number of observers by Holm (1979).
    pub p_holm: PValue,
}

/// Order effects in `choices` of `observers` among `items`.
///
/// If a fair coin decides which stimulus comes first in each trial and the order does not matter, the
/// first one is chosen with probability ½ whatever the preferences, trial by trial independently, even
/// for one observer. So the exact binomial test needs no model of the observers. Pairs that were shown in
/// one order only count nowhere: in them no coin was seen to decide.
///
/// # Errors
/// In words: nothing was chosen, or the order was not varied within any pair.
pub fn order_effects(
    items: &[String],
    observers: &[Observer],
    choices: &[Choice],
) -> Outcome<OrderEffects> {
    // Observer, pair, and whether the first was chosen.
    let mut answers: Vec<(usize, (usize, usize), bool)> = Vec::new();
    // Per pair: [chosen, trials] of the stimulus listed first, where it was shown first and second.
    let mut by_pair: BTreeMap<(usize, usize), [[u64; 2]; 2]> = BTreeMap::new();
    let mut not_sure = 0;
    if !choices.is_empty() && choices.iter().all(|choice| choice.first.is_none()) {
        return Err("the answers do not tell which stimulus was shown first".into());
    }
    for choice in choices {
        let Some(first) = choice.first else { continue };
        let Some(chosen) = choice.chosen else {
            not_sure += 1;
            continue;
        };
        let listed_first = if choice.a < choice.b { Side::A } else { Side::B };
        let pair = (choice.a.min(choice.b), choice.a.max(choice.b));
        answers.push((choice.observer, pair, chosen == first));
        let order = usize::from(first != listed_first);
        let [listed_first_chosen, trials] = &mut by_pair.entry(pair).or_default()[order];
        *listed_first_chosen += u64::from(chosen == listed_first);
        *trials += 1;
    }
    if answers.is_empty() {
        return Err("no answer chose a stimulus".into());
    }
    let (varied, fixed): (BTreeMap<_, _>, BTreeMap<_, _>) =
        by_pair.into_iter().partition(|(_, [first, second])| first[1] > 0 && second[1] > 0);
    if varied.is_empty() {
        return Err(
            "the order was not varied within any pair, so what is first and what is preferred \
                    cannot be told apart"
                .into(),
        );
    }
    let mut by_observer: BTreeMap<usize, [u64; 2]> = BTreeMap::new();
    for (observer, _, first_chosen) in answers.iter().filter(|of| varied.contains_key(&of.1)) {
        let [chosen, trials] = by_observer.entry(*observer).or_default();
        *chosen += u64::from(*first_chosen);
        *trials += 1;
    }
    let rest = |[chosen, trials]: [u64; 2]| [chosen, trials - chosen];
    let p: Vec<Outcome<f64>> = varied
        .values()
        .map(|[first, second]| fisher_exact(&[rest(*first), rest(*second)]))
        .collect();
    let p_holm = holm_of_known(&p);
    let pairs = varied.iter().zip(p.into_iter().zip(p_holm));
    let pairs = pairs.map(|((pair, [first, second]), (p, p_holm))| PairOrder {
        item: items[pair.0].clone(),
        other: items[pair.1].clone(),
        chosen_when_first: *first,
        chosen_when_second: *second,
        p: p.map(PValue::new),
        p_holm,
    });
    let shares: Vec<(usize, Proportion)> = by_observer
        .iter()
        .map(|(observer, [chosen, trials])| (*observer, Proportion::new(*chosen, *trials)))
        .collect();
    let p: Vec<f64> = shares.iter().map(|(_, share)| share.p_binomial.value()).collect();
    let sum = |column: usize| by_observer.values().map(|counts| counts[column]).sum();
    Ok(OrderEffects {
        first_chosen: Proportion::new(sum(0), sum(1)),
        not_sure,
        pairs: pairs.collect(),
        pairs_in_one_order: fixed.len() as u64,
        answers_in_one_order: fixed.values().flatten().map(|[_, trials]| trials).sum(),
        observers: shares
            .into_iter()
            .zip(holm(&p))
            .map(|((observer, proportion), p_holm)| ObserverOrder {
                observer: observers[observer].code.clone(),
                proportion,
                p_holm: PValue::new(p_holm),
            })
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observers(n: usize) -> Vec<Observer> {
        (0..n).map(|i| Observer { code: format!("P{i}"), traits: BTreeMap::new() }).collect()
    }

    fn items() -> [String; 2] {
        ["A", "B"].map(String::from)
    }

    fn choice(observer: usize, chosen: Option<Side>, first: Side) -> Choice {
        Choice { observer, a: 0, b: 1, chosen, first: Some(first) }
    }

    /// A is chosen 9 of 10 times where it is first and 3 of 10 times where it is second.
    fn study() -> Vec<Choice> {
        let mut choices = Vec::new();
        for (first, wins) in [(Side::A, 9), (Side::B, 3)] {
            for trial in 0..10 {
                let chosen = if trial < wins { Side::A } else { Side::B };
                choices.push(choice(trial % 2, Some(chosen), first));
            }
        }
        choices.push(choice(0, None, Side::A));
        choices
    }

    #[test]
    fn shares_and_tests_are_those_of_r() {
        let found = order_effects(&items(), &observers(2), &study()).unwrap();
        assert_eq!((found.first_chosen.chosen, found.first_chosen.trials), (16, 20));
        // R 4.2.2: binom.test(16, 20); fisher.test(matrix(c(9, 3, 1, 7), 2)).
        assert!((found.first_chosen.p_binomial.value() - 0.0118179321289062).abs() < 1e-12);
        assert_eq!(found.pairs[0].chosen_when_first, [9, 10]);
        assert_eq!(found.pairs[0].chosen_when_second, [3, 10]);
        assert!((found.pairs[0].p.as_ref().unwrap().value() - 0.0197666110978805).abs() < 1e-12);
        assert_eq!((found.not_sure, found.observers.len()), (1, 2));
    }

    #[test]
    fn swapping_sides_or_items_changes_labels_alone() {
        let straight = order_effects(&items(), &observers(2), &study()).unwrap();

        let mut swapped = study();
        for choice in &mut swapped {
            (choice.a, choice.b) = (choice.b, choice.a);
            (choice.chosen, choice.first) =
                (choice.chosen.map(Side::other), choice.first.map(Side::other));
        }
        assert_eq!(order_effects(&items(), &observers(2), &swapped).unwrap(), straight);
        let mut renumbered = study();
        for choice in &mut renumbered {
            (choice.a, choice.b) = (1, 0);
        }
        let found = order_effects(&items(), &observers(2), &renumbered).unwrap();
        assert_eq!(found.first_chosen, straight.first_chosen);
        let p = |order: &OrderEffects| order.pairs[0].p.as_ref().unwrap().value();
        assert!((p(&found) - p(&straight)).abs() < 1e-13);
    }

    #[test]
    fn pairs_in_one_order_count_nowhere() {
        let items = ["A", "B", "C"].map(String::from);
        let straight = order_effects(&items, &observers(3), &study()).unwrap();
        // A is preferred to C, and always first.
        let mut more = study();
        more.extend(
            [0, 1, 2].map(|observer| Choice { b: 2, ..choice(observer, Some(Side::A), Side::A) }),
        );
        let found = order_effects(&items, &observers(3), &more).unwrap();
        assert_eq!((found.pairs_in_one_order, found.answers_in_one_order), (1, 3));
        assert_eq!(found.first_chosen, straight.first_chosen);
        assert_eq!(found.observers, straight.observers);
    }

    #[test]
    fn an_order_that_was_not_varied_is_said() {
        let fixed: Vec<Choice> = (0..6).map(|_| choice(0, Some(Side::A), Side::A)).collect();
        let error = order_effects(&items(), &observers(1), &fixed).unwrap_err();
        assert!(error.starts_with("the order was not varied"), "{error}");
        assert_eq!(order_effects(&items(), &[], &[]), Err("no answer chose a stimulus".into()));
    }
}
