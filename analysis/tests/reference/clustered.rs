//! The clustered preference model: simulated answers (R 4.2.2, November 2026: `glm`, clubSandwich 0.5
//! `vcovCR` type CR3 times (G − 1)/G, `brglm`), and false positives over simulated studies.

use crate::close;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use shutterlab_analysis::input::preferences::Choice;
use shutterlab_analysis::maths::distributions::clopper_pearson_95;
use shutterlab_analysis::maths::logistic::Method;
use shutterlab_analysis::maths::random::stream;
use shutterlab_analysis::paired::clustered::{ClusteredPreference, by_item, by_level};
use shutterlab_data_schema::response::Side;

const ITEMS: [&str; 4] = ["T3-A4", "T3-A5", "T4-A4", "T4-A5"];
/// Each observer's answers to the pairs (0,1), (0,2), (0,3), (1,2), (1,3), (2,3); `?` is "not sure".
const ANSWERS: [&str; 7] = ["BAAABB", "AAAAAA", "?AAAAA", "AAAAAA", "BAAAAB", "AAABAA", "AAAABA"];

fn items() -> Vec<String> {
    ITEMS.map(String::from).to_vec()
}

fn choices(answers: &[&str]) -> Vec<Choice> {
    let mut choices = Vec::new();
    for (observer, answers) in answers.iter().enumerate() {
        let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b)));
        for ((a, b), answer) in pairs.zip(answers.chars()) {
            let chosen = match answer {
                'A' => Some(Side::A),
                'B' => Some(Side::B),
                _ => None,
            };
            choices.push(Choice { observer, a, b, chosen, first: Some(Side::A) });
        }
    }
    choices
}

/// Expects (item, over, estimate, naive SE, clustered SE, p) of each contrast.
fn expect(found: &ClusteredPreference, expected: &[(&str, &str, f64, f64, f64, f64)]) {
    assert_eq!(found.contrasts.len(), expected.len());
    for (contrast, (item, over, estimate, naive, se, p)) in found.contrasts.iter().zip(expected) {
        let what = format!("{item} over {over}");
        assert_eq!((contrast.item.as_str(), contrast.over.as_str()), (*item, *over));
        // R's standard errors rest on the weights before its last step.
        close(contrast.estimate, *estimate, 1e-8, &what);
        close(contrast.se_naive, *naive, 1e-7, &what);
        let clustered = contrast.clustered.as_ref().unwrap();
        close(clustered.se, *se, 1e-7, &what);
        close(clustered.p.value(), *p, 1e-7, &what);
        close(clustered.design_effect.unwrap(), (se / naive) * (se / naive), 1e-7, &what);
    }
}

#[test]
fn contrasts_of_stimuli_are_those_of_r() {
    let found = by_item(&items(), &choices(&ANSWERS)).unwrap();
    assert_eq!((found.observers, found.trials, found.not_sure), (7, 42, 1));
    assert_eq!(found.method, Method::MaximumLikelihood);
    expect(
        &found,
        &[
            (
                "T3-A4",
                "T3-A5",
                1.1344462973615,
                0.74086194577085,
                0.73930277718657,
                0.17580996601583,
            ),
            (
                "T3-A4",
                "T4-A4",
                2.6165200484919,
                0.85939486356695,
                0.39392153951866,
                0.00056210914972194,
            ),
            (
                "T3-A4",
                "T4-A5",
                3.0384530404029,
                0.89991264083359,
                1.0252194524465,
                0.025161681406417,
            ),
            (
                "T3-A5",
                "T4-A4",
                1.4820737511303,
                0.71337329901555,
                0.73830051095429,
                0.091481872919696,
            ),
            (
                "T3-A5",
                "T4-A5",
                1.9040067430414,
                0.75827993753749,
                0.79328034967357,
                0.053282621485104,
            ),
            (
                "T4-A4",
                "T4-A5",
                0.42193299191103,
                0.6583271902528,
                0.80425538627226,
                0.61865344397808,
            ),
        ],
    );
    let overall = found.tests[0].test.as_ref().unwrap();
    assert_eq!((overall.df, overall.df_error), (3, 4));
    close(overall.f, 11.5194223793014, 1e-8, "F");
    close(overall.p.value(), 0.0194664472026578, 1e-8, "p");
}

#[test]
fn contrasts_of_levels_are_those_of_r() {
    let found = by_level(&items(), &choices(&ANSWERS)).unwrap();
    expect(
        &found,
        &[
            (
                "T3",
                "T4",
                2.230367947275202,
                0.634473067900067,
                0.576441382318085,
                0.00827353134235019,
            ),
            (
                "A4",
                "A5",
                0.757260238647663,
                0.487188193175153,
                0.695242401884425,
                0.317866114960986,
            ),
        ],
    );
    assert_eq!(found.tests.len(), 2);
    assert_eq!(found.tests[0].of, "T3/T4");
}

#[test]
fn a_stimulus_never_chosen_is_said_and_has_firths_coefficient() {
    let mut separated = choices(&ANSWERS);
    separated.iter_mut().filter(|c| c.b == 3).for_each(|c| c.chosen = Some(Side::A));
    let found = by_item(&items(), &separated).unwrap();
    assert_eq!(found.method, Method::Firth);
    let expected = [
        ("T3-A4", "T3-A5", 0.69422592517605, 0.72993745925199),
        ("T3-A4", "T4-A4", 2.5428289583506, 0.97197576442),
        ("T3-A4", "T4-A5", 5.3732720169451, 1.6830747796921),
        ("T3-A5", "T4-A4", 1.8486030331746, 0.89400220831937),
        ("T3-A5", "T4-A5", 4.679046091769, 1.6373771491726),
        ("T4-A4", "T4-A5", 2.8304430585945, 1.4783425447262),
    ];
    for (contrast, (item, over, estimate, se)) in found.contrasts.iter().zip(expected) {
        assert_eq!((contrast.item.as_str(), contrast.over.as_str()), (item, over));
        close(contrast.estimate, estimate, 1e-8, item);
        close(contrast.se_naive, se, 1e-8, item);
        assert!(contrast.clustered.as_ref().unwrap().se >= contrast.se_naive * (1.0 - 1e-12));
    }
    assert!(found.tests[0].test.is_err());
}

#[test]
fn relabelling_and_swapping_sides_change_nothing_but_labels() {
    let straight = by_item(&items(), &choices(&ANSWERS)).unwrap();
    let order = [2, 0, 3, 1];
    let mut turned = choices(&ANSWERS);
    for choice in &mut turned {
        choice.observer = 10 + 3 * (6 - choice.observer);
        // Stimulus i moves to place order[i]; its sides are swapped.
        (choice.a, choice.b) = (order[choice.b], order[choice.a]);
        (choice.chosen, choice.first) =
            (choice.chosen.map(Side::other), choice.first.map(Side::other));
    }
    let mut moved = items();
    order.iter().enumerate().for_each(|(i, place)| moved[*place] = ITEMS[i].into());
    let turned = by_item(&moved, &turned).unwrap();
    for (turned, straight) in turned.contrasts.iter().zip(&straight.contrasts) {
        assert_eq!((&turned.item, &turned.over), (&straight.item, &straight.over));
        close(turned.estimate, straight.estimate, 1e-9, &turned.item);
        let se = |contrast: &shutterlab_analysis::paired::clustered::Contrast| {
            contrast.clustered.as_ref().unwrap().se
        };
        close(se(turned), se(straight), 1e-9, &turned.item);
    }
}

#[test]
fn what_does_not_follow_is_said() {
    let all = items();
    let one = by_item(&all, &choices(&ANSWERS[..1])).unwrap_err();
    assert!(one.starts_with("a model with observers as clusters needs at least 2"), "{one}");
    assert!(by_item(&all, &[]).is_err());
    let apart: Vec<Choice> =
        choices(&ANSWERS).into_iter().filter(|c| (c.a, c.b) == (0, 1) || c.a == 2).collect();
    let error = by_item(&all, &apart).unwrap_err();
    assert!(error.starts_with("the pairs that were compared do not"), "{error}");
    // Everyone goes round in a circle: finite coefficients, and nobody differs.
    let alike = by_item(&all, &choices(&["AABAAA"; 5])).unwrap();
    assert_eq!(alike.method, Method::MaximumLikelihood);
    assert!(alike.contrasts.iter().all(|c| c.clustered.is_err()));
    assert!(alike.tests[0].test.is_err() && alike.design_effect.is_err());
    // Everyone agrees on an order.
    let ordered = by_item(&all, &choices(&["AAAAAA"; 5])).unwrap();
    assert_eq!(ordered.method, Method::Firth);
    assert!(ordered.contrasts.iter().all(|c| c.estimate.is_finite()));
    let json = serde_json::to_string(&(alike, ordered)).unwrap();
    assert!(!json.contains("NaN") && !json.contains("inf"), "{json}");
}

/// How many of `studies` without any difference on the whole in which the contrast of two stimuli, and the
/// overall test, have p ≤ 0.05, and how many have these tests; observers' own preferences have standard deviation `spread`.
fn false_positives(studies: u64, observers: usize, t: usize, spread: f64) -> [(u64, u64); 2] {
    let items: Vec<String> = (0..t).map(|i| format!("S{i}")).collect();
    let mut counts = [(0, 0); 2];
    for study in 0..studies {
        let mut random = stream(20_121, study);
        let mut choices = Vec::new();
        for observer in 0..observers {
            let own: Vec<f64> = (0..t)
                .map(|_| {
                    let standard: f64 = StandardNormal.sample(&mut random);
                    spread * standard
                })
                .collect();
            for a in 0..t {
                for b in a + 1..t {
                    let p = 1.0 / (1.0 + (own[b] - own[a]).exp());
                    let chosen = if random.random::<f64>() < p { Side::A } else { Side::B };
                    choices.push(Choice {
                        observer,
                        a,
                        b,
                        chosen: Some(chosen),
                        first: Some(Side::A),
                    });
                }
            }
        }
        let found = by_item(&items, &choices).unwrap();
        let named = ["S0", "S1"];
        let contrast = found
            .contrasts
            .iter()
            .find(|c| named.contains(&c.item.as_str()) && named.contains(&c.over.as_str()));
        let contrast = contrast.and_then(|c| Some(c.clustered.as_ref().ok()?.p.value()));
        for (count, p) in counts
            .iter_mut()
            .zip([contrast, found.tests[0].test.as_ref().ok().map(|test| test.p.value())])
        {
            if let Some(p) = p {
                count.0 += u64::from(p <= 0.05);
                count.1 += 1;
            }
        }
    }
    counts
}

#[test]
fn false_positives_keep_the_level() {
    for (observers, t, spread) in [(10, 4, 1.0), (21, 5, 1.0)] {
        for (rejected, of) in false_positives(400, observers, t, spread) {
            assert!(of > 390 && clopper_pearson_95(rejected, of)[0] <= 0.05, "{rejected} of {of}");
        }
    }
}
