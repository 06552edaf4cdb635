//! Scale values against R 4.2.2 (`glm`, `brglm` 0.7.2, `brglm2` 0.9; November 2026) on made-up counts, and
//! properties that hold for any counts.

use crate::close;
use rand::RngExt;
use shutterlab_analysis::maths::random::stream;
use shutterlab_analysis::scaling::bootstrap::bootstrap;
use shutterlab_analysis::scaling::comparisons::{Comparisons, Pair};
use shutterlab_analysis::scaling::differences::differences;
use shutterlab_analysis::scaling::fit::{Estimation, Scale, fit};
use shutterlab_analysis::scaling::goodness_of_fit::goodness_of_fit;
use shutterlab_analysis::scaling::intervals::profile_95;
use shutterlab_analysis::scaling::model::Model;
use shutterlab_analysis::scaling::section::section;
use shutterlab_analysis::scaling::simulated_fit::simulated_fit;
use shutterlab_analysis::scaling::study::{Scaling, of_observers, scaling};
use shutterlab_analysis::scaling::ties::davidson;
use shutterlab_analysis::{Outcome, input, report};

const MODELS: [Model; 2] = [Model::BradleyTerry, Model::ThurstoneV];
const ESTIMATIONS: [Estimation; 2] = [Estimation::MaximumLikelihood, Estimation::BiasReduced];

/// Rows chosen over columns, with unequal numbers of answers.
const MADE_UP: [[f64; 5]; 5] = [
    [0., 14., 17., 19., 20.],
    [7., 0., 12., 13., 16.],
    [4., 9., 0., 11., 15.],
    [2., 8., 10., 0., 12.],
    [1., 5., 6., 9., 0.],
];
/// The first item always wins.
const SEPARATED: [[f64; 4]; 4] =
    [[0., 10., 10., 10.], [0., 0., 8., 9.], [0., 2., 0., 6.], [0., 1., 4., 0.]];

fn names(t: usize) -> Vec<String> {
    (0..t).map(|i| format!("item{i}")).collect()
}

fn of<const T: usize>(wins: &[[f64; T]; T]) -> Comparisons {
    let rows: Vec<Vec<f64>> = wins.iter().map(|row| row.to_vec()).collect();
    Comparisons::of_matrix(&names(T), &rows).unwrap()
}

fn from_first(scale: &Scale, values: &[f64], errors: &[f64], what: &str) {
    for (k, (value, se)) in values.iter().zip(errors).enumerate() {
        let ours = scale.difference(k + 1, 0);
        close(ours.value, *value, 1e-8, &format!("{what}: value {k}"));
        close(ours.se, *se, 1e-8, &format!("{what}: standard error {k}"));
    }
}

#[test]
fn fits_are_those_of_r() {
    // glm(cbind(wins, losses) ~ X - 1), family binomial; brglm(…, pl = FALSE).
    let cases = [
        (
            Model::BradleyTerry,
            Estimation::MaximumLikelihood,
            [-1.09762258259090, -1.49018233492961, -1.79661847905610, -2.30969142761286],
            [0.338618199668541, 0.345450056884067, 0.353154613154632, 0.371589357695664],
        ),
        (
            Model::ThurstoneV,
            Estimation::MaximumLikelihood,
            [-0.659724433620809, -0.899621493052519, -1.091145083670549, -1.404526877809699],
            [0.195612455264191, 0.198239323462096, 0.201766940076035, 0.210463803407486],
        ),
        (
            Model::BradleyTerry,
            Estimation::BiasReduced,
            [-1.06943195118013, -1.45343864455400, -1.75322328159573, -2.25442369696945],
            [0.335513440995438, 0.342025428051673, 0.349475100085102, 0.367335515523215],
        ),
        (
            Model::ThurstoneV,
            Estimation::BiasReduced,
            [-0.645731247088873, -0.881342418286429, -1.069308393107995, -1.376677970023086],
            [0.194623032224490, 0.197128483160697, 0.200522915543304, 0.208917441649493],
        ),
    ];
    let made_up = of(&MADE_UP);
    for (model, estimation, values, errors) in cases {
        let scale = fit(&made_up, model, estimation).unwrap();
        from_first(&scale, &values, &errors, &format!("{model:?} {estimation:?}"));
    }
}

#[test]
fn goodness_of_fit_is_that_of_r() {
    let made_up = of(&MADE_UP);
    for (model, log_likelihood, deviance, pearson) in [
        (MODELS[0], -16.98622012257735, 2.52769239487804, 2.45587095117024),
        (MODELS[1], -16.78697264790399, 2.12919744553130, 2.09871610128583),
    ] {
        let scale = fit(&made_up, model, Estimation::MaximumLikelihood).unwrap();
        let goodness = goodness_of_fit(&made_up, &scale);
        close(goodness.log_likelihood, log_likelihood, 1e-10, "log-likelihood");
        close(goodness.deviance, deviance, 1e-9, "deviance");
        close(goodness.pearson, pearson, 1e-7, "Pearson");
        close(goodness.equal_worth.null_deviance, 60.16949646300289, 1e-10, "null deviance");
        assert_eq!((goodness.df, goodness.equal_worth.df), (6, 4));
    }
}

#[test]
fn profile_intervals_are_those_of_r() {
    // Roots of deviance − least deviance = qchisq(.95, 1) with the difference as an offset.
    let made_up = of(&MADE_UP);
    let scale = fit(&made_up, Model::BradleyTerry, Estimation::MaximumLikelihood).unwrap();
    for (contrast, expected) in [
        ([-1.0, 1.0, 0.0, 0.0, 0.0], [-1.792682703575328, -0.456261579951026]),
        ([-1.0, 0.0, 0.0, 0.0, 1.0], [-3.07647005241543, -1.61432131150232]),
    ] {
        let ours = profile_95(&made_up, &scale, &contrast).unwrap();
        close(ours[0], expected[0], 1e-9, "lower");
        close(ours[1], expected[1], 1e-9, "upper");
    }
}

#[test]
fn separated_data_have_the_bias_reduced_fit_of_r() {
    let separated = of(&SEPARATED);
    for model in MODELS {
        let refused = fit(&separated, model, Estimation::MaximumLikelihood).unwrap_err();
        assert!(refused.starts_with("item0 was never rejected"), "{refused}");
    }
    // brglm2: type = "AS_mean".
    let scale = fit(&separated, Model::BradleyTerry, Estimation::BiasReduced).unwrap();
    let values = [-3.32296147896795, -4.69858418322975, -5.14668646525306];
    from_first(&scale, &values, &[1.45025882561162, 1.51432854475653, 1.53236155329039], "logit");
    // brglm: family binomial("probit"), pl = FALSE.
    let scale = fit(&separated, Model::ThurstoneV, Estimation::BiasReduced).unwrap();
    let values = [-1.76655403663486, -2.58624055636304, -2.86617128442533];
    from_first(
        &scale,
        &values,
        &[0.636543124482016, 0.692032731843317, 0.705893033771525],
        "probit",
    );
}

#[test]
fn ties_with_a_threshold_are_those_of_r() {
    // psychotools 0.7-2: btmodel(…, undecided = TRUE); standard errors and deviance from glm, family
    // poisson, with a constant for each pair.
    let ties = [3., 1., 0., 2., 4., 3., 1., 2., 0., 5.];
    let untied = of(&MADE_UP);
    let pairs = untied.pairs().iter().zip(ties).map(|(pair, ties)| Pair { ties, ..*pair });
    let fitted = davidson(&Comparisons::of_pairs(&names(5), pairs.collect()).unwrap()).unwrap();
    let values = [-1.11868557916573, -1.50950840262709, -1.86576179445790, -2.35430425498268];
    let errors = [0.333642501563509, 0.345019331187778, 0.353596730196422, 0.370638096296497];
    from_first(&fitted.scale, &values, &errors, "Davidson");
    close(fitted.ln_nu.value, -1.44969681962089, 1e-8, "ln ν");
    close(fitted.ln_nu.se, 0.232693389970965, 1e-8, "standard error of ln ν");
    close(fitted.deviance, 14.5895198338699, 1e-8, "deviance");
    assert_eq!(fitted.df, 15);
}

fn fits(comparisons: &Comparisons) -> Vec<Scale> {
    let every = MODELS.iter().flat_map(|m| ESTIMATIONS.iter().map(move |e| (*m, *e)));
    every.map(|(model, estimation)| fit(comparisons, model, estimation).unwrap()).collect()
}

fn near(ours: f64, theirs: f64, what: &str) {
    assert!((ours - theirs).abs() < 1e-9, "{what}: {ours} is not {theirs}");
}

#[test]
fn relabelled_items_have_the_same_values() {
    let order = [3, 0, 4, 1, 2];
    let permuted = order.map(|i| order.map(|j| MADE_UP[i][j]));
    for (before, after) in fits(&of(&MADE_UP)).iter().zip(fits(&of(&permuted))) {
        for (k, i) in order.into_iter().enumerate() {
            near(after.values[k], before.values[i], "value");
            near(after.se[k], before.se[i], "standard error");
            for (l, j) in order.into_iter().enumerate() {
                let (after, before) = (after.difference(k, l), before.difference(i, j));
                near(after.value, before.value, "difference");
                near(after.se, before.se, "standard error of the difference");
            }
        }
    }
}

#[test]
fn exchanged_answers_negate_the_values() {
    let exchanged: [[f64; 5]; 5] = std::array::from_fn(|i| std::array::from_fn(|j| MADE_UP[j][i]));
    for (before, after) in fits(&of(&MADE_UP)).iter().zip(fits(&of(&exchanged))) {
        for i in 0..5 {
            near(after.values[i], -before.values[i], "value");
            near(after.se[i], before.se[i], "standard error");
        }
    }
}

#[test]
fn more_answers_shrink_standard_errors_by_their_root() {
    let more = MADE_UP.map(|row| row.map(|count| 9.0 * count));
    for model in MODELS {
        let [before, after] = [MADE_UP, more]
            .map(|wins| fit(&of(&wins), model, Estimation::MaximumLikelihood).unwrap());
        for i in 0..5 {
            near(after.values[i], before.values[i], "value");
            near(after.se[i], before.se[i] / 3.0, "standard error");
        }
    }
}

#[test]
fn exact_expected_counts_give_the_values_back() {
    // Unequal numbers of answers; the pairs without an answer leave a chain.
    let trials = [[0, 7, 0, 0, 31], [0, 0, 1, 12, 0], [0, 0, 0, 900, 0], [0; 5], [0; 5]];
    let truth = [0.4, -1.7, 2.1, 0.0, -0.8];
    for model in MODELS {
        let chance = |difference: f64| match model {
            Model::BradleyTerry => 1.0 / (1.0 + libm::exp(-difference)),
            Model::ThurstoneV => 0.5 * libm::erfc(-difference / std::f64::consts::SQRT_2),
        };
        let mut wins = [[0.0; 5]; 5];
        for i in 0..5 {
            for j in i + 1..5 {
                let chosen = chance(truth[i] - truth[j]);
                wins[i][j] = f64::from(trials[i][j]) * chosen;
                wins[j][i] = f64::from(trials[i][j]) * (1.0 - chosen);
            }
        }
        let comparisons = of(&wins);
        let scale = fit(&comparisons, model, Estimation::MaximumLikelihood).unwrap();
        (0..5).for_each(|i| near(scale.values[i], truth[i], "value"));
        let goodness = goodness_of_fit(&comparisons, &scale);
        near(goodness.deviance, 0.0, "deviance");
        near(goodness.pearson, 0.0, "Pearson");
        assert_eq!((goodness.df, goodness.p.is_some()), (1, true));
    }
}

/// Answers of `observers` who judge each pair once, by the Bradley–Terry model.
fn made_up_observers(values: &[f64], observers: u64, seed: u64) -> Vec<Comparisons> {
    let t = values.len();
    let of_one = |observer| {
        let mut random = stream(seed, observer);
        let mut wins = vec![vec![0.0; t]; t];
        for i in 0..t {
            for j in i + 1..t {
                let chosen = 1.0 / (1.0 + libm::exp(values[j] - values[i]));
                let [winner, loser] = if random.random_bool(chosen) { [i, j] } else { [j, i] };
                wins[winner][loser] = 1.0;
            }
        }
        Comparisons::of_matrix(&names(t), &wins).unwrap()
    };
    (0..observers).map(of_one).collect()
}

#[test]
fn the_bootstrap_does_not_depend_on_threads_or_order() {
    let observers = made_up_observers(&[0.9, 0.0, 0.3, -1.2], 9, 5);
    let draw =
        |observers: &[Comparisons]| bootstrap(observers, Model::BradleyTerry, 300, 11).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| draw(&observers))
    };
    assert_eq!(on(1), on(3));
    // The items in reverse order.
    let reversed: Vec<Comparisons> = observers
        .iter()
        .map(|observer| {
            let turn = |pair: &Pair| Pair {
                i: 3 - pair.j,
                j: 3 - pair.i,
                wins: [pair.wins[1], pair.wins[0]],
                ..*pair
            };
            let pairs = observer.pairs().iter().map(turn).collect();
            Comparisons::of_pairs(&names(4), pairs).unwrap()
        })
        .collect();
    for (before, after) in draw(&observers).values.iter().zip(draw(&reversed).values) {
        (0..4).for_each(|i| near(before[i], after[3 - i], "replicate"));
    }
    let others_first: Vec<Comparisons> = observers.iter().rev().cloned().collect();
    for (before, after) in draw(&observers).values.iter().zip(draw(&others_first).values) {
        (0..4).for_each(|i| near(before[i], after[i], "replicate"));
    }
}

#[test]
fn the_bootstrap_has_the_spread_of_independent_answers() {
    let observers = made_up_observers(&[1.0, 0.4, 0.0, -0.4, -1.0], 60, 2);
    let scale =
        fit(&Comparisons::pooled(&observers), Model::BradleyTerry, Estimation::MaximumLikelihood)
            .unwrap();
    let drawn = bootstrap(&observers, Model::BradleyTerry, 4000, 3).unwrap();
    assert_eq!((drawn.separated, drawn.unconnected), (0, 0));
    for i in 0..5 {
        let [low, high] = drawn.interval_95(|values| values[i]);
        assert!(low < scale.values[i] && scale.values[i] < high);
        let [wald_low, wald_high] = scale.centred(i).wald_95();
        let ratio = (high - low) / (wald_high - wald_low);
        assert!((0.7..1.4).contains(&ratio), "{ratio}");
    }
}

#[test]
fn separated_replicates_are_counted_and_fitted() {
    // One observer of twelve alone prefers the second item to the first.
    let mut observers = vec![of(&[[0., 1., 1.], [0., 0., 1.], [0., 0., 0.]]); 8];
    observers.extend(vec![of(&[[0., 1., 1.], [0., 0., 0.], [0., 1., 0.]]); 3]);
    observers.push(of(&[[0., 0., 1.], [1., 0., 1.], [0., 0., 0.]]));
    let drawn = bootstrap(&observers, Model::BradleyTerry, 2000, 1).unwrap();
    // Replicates without that one: (11/12)¹² = 35 %; without all three others: (9/12)¹² = 3 %.
    assert!((640..860).contains(&drawn.separated), "{}", drawn.separated);
    assert_eq!((drawn.unconnected, drawn.values.len()), (0, drawn.replicates));
    let [low, high] = drawn.interval_95(|values| values[0]);
    assert!(low.is_finite() && high.is_finite() && low < high);
    observers.pop();
    let refused = bootstrap(&observers, Model::BradleyTerry, 100, 1).unwrap_err();
    assert!(refused.contains("resampling makes no choice that nobody made"), "{refused}");
}

#[test]
fn differences_carry_holms_correction() {
    let scale = fit(&of(&MADE_UP), Model::BradleyTerry, Estimation::MaximumLikelihood).unwrap();
    let differences = differences(&scale);
    assert_eq!(differences.len(), 10);
    assert_eq!((differences[0].item.as_str(), differences[0].over.as_str()), ("item0", "item1"));
    // The smallest p of ten is multiplied by ten.
    let smallest = differences.iter().min_by(|a, b| a.p.value().total_cmp(&b.p.value())).unwrap();
    close(smallest.p_holm.value(), 10.0 * smallest.p.value(), 1e-12, "Holm");
    assert!(differences.iter().all(|d| d.estimate.value >= 0.0 && d.p_holm >= d.p));
}

#[test]
fn a_fit_is_tested_by_simulation_where_counts_are_small() {
    // A scale fits what follows it, and not a ring in which each item beats the next.
    let fits = Comparisons::pooled(&made_up_observers(&[1.0, 0.3, 0.0, -0.4, -1.0], 4, 3));
    let ring = of(&[[0., 5., 1.], [1., 0., 5.], [5., 1., 0.]]);
    for model in MODELS {
        let p = |comparisons| simulated_fit(comparisons, model, 499, 1).unwrap().p.value();
        assert!(p(&fits) > 0.05, "{}", p(&fits));
        assert!(p(&ring) < 0.05, "{}", p(&ring));
    }
    let two = of(&[[0., 5.], [1., 0.]]);
    assert!(simulated_fit(&two, MODELS[0], 9, 1).unwrap_err().contains("nothing is left"));
    let part = of(&[[0., 5.5, 1.], [1., 0., 5.], [5., 1., 0.]]);
    assert!(simulated_fit(&part, MODELS[0], 9, 1).unwrap_err().contains("parts of counts"));
}

/// All that is said of a study, in one text without numbers that are none.
fn said(scaling: &Outcome<Scaling>) -> String {
    let section = section(scaling);
    if let Ok(scaling) = scaling {
        let json = serde_json::to_string(scaling).unwrap();
        assert!(json.starts_with("{\"items\":["));
    }
    for table in &section.tables {
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{}", table.name);
    }
    let text = section.sentences.join("\n");
    let csv = ["scale", "scale-differences", "scale-fit"]
        .map(|name| report::csv(std::slice::from_ref(&section), name).unwrap_or_default());
    for text in csv.iter().chain([&text]) {
        let odd = ["NaN", "inf,", "inf\n", " inf"].iter().find(|odd| text.contains(**odd));
        assert_eq!(odd, None, "{text}");
    }
    text
}

#[test]
fn a_study_is_told_in_sentences_and_tables() {
    let observers = made_up_observers(&[1.0, 0.4, 0.0, -0.4, -1.0], 21, 4);
    let text = said(&of_observers(&observers, 1));
    for expected in [
        "Places of t = 5 items on one scale from 210 answers to 10 of 10 pairs by n = 21 observers.",
        "Bradley–Terry, goodness of fit: deviance = ",
        "df = 6, p = ",
        "Thurstone Case V, bootstrap: 10000 replicates of n = 21 observers, seed 1; in 0 of them",
        "Davidson's model of ties: none, there is no tie",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

#[test]
fn what_gives_no_scale_is_said_in_words() {
    let one = |wins: &[[f64; 3]; 3]| of_observers(&[of(wins)], 1);
    // One observer.
    let ring = said(&one(&[[0., 1., 0.], [0., 0., 1.], [1., 0., 0.]]));
    assert!(ring.contains("bootstrap intervals: none, at least 5 observers"), "{ring}");
    assert!(ring.contains("goodness of fit: no test, no pair was judged more than once"), "{ring}");
    // Nothing asked, and items without a common pair.
    let nothing = said(&one(&[[0.; 3]; 3]));
    assert_eq!(nothing, "No scale values: there is no answer to any pair.");
    let parts = said(&one(&[[0., 4., 0.], [2., 0., 0.], [0., 0., 0.]]));
    assert!(parts.contains("fall into 2 parts"), "{parts}");
    // An item never chosen; all answers alike; two items.
    let never = said(&one(&[[0., 4., 3.], [2., 0., 5.], [0., 0., 0.]]));
    assert!(never.contains("item2 was never chosen: in {item0, item1} > {item2}"), "{never}");
    assert!(never.contains("All values are bias-reduced"), "{never}");
    let alike = said(&one(&[[0., 4., 4.], [0., 0., 4.], [0., 0., 0.]]));
    assert!(alike.contains("item0 was never rejected, item2 was never chosen"), "{alike}");
    let two = of_observers(&[of(&[[0., 4.], [3., 0.]])], 1);
    assert!(said(&two).contains("nothing is left to test the fit with"));
    // Only ties.
    let tie = |i, j| Pair { i, j, wins: [0.0; 2], ties: 3.0 };
    let ties = Comparisons::of_pairs(&names(3), vec![tie(0, 1), tie(0, 2), tie(1, 2)]).unwrap();
    let ties = said(&of_observers(&[ties], 1));
    assert!(ties.contains("9 of 9 answers chose neither"), "{ties}");
    // Votes alone.
    let votes = shutterlab_data_schema::Votes::parse("item,votes\nA,3\nB,1\n", "v").unwrap();
    let votes = shutterlab_analysis::Preferences::from_votes(&votes, 4, "v").unwrap();
    assert!(said(&scaling(&votes, 1)).contains("votes alone do not tell"));
}

#[test]
fn a_matrix_has_a_scale_without_intervals_by_observer() {
    let matrix = input::matrix::parse(",A,B,C\nA,0,7,9\nB,3,0,6\nC,1,4,0\n", 10, "m").unwrap();
    let scaling = scaling(&matrix, 1);
    let text = said(&scaling);
    assert!(text.contains("none, a pooled matrix does not tell the answers of single"), "{text}");
    assert!(scaling.unwrap().bradley_terry.profile_95(0).is_some());
}

#[test]
fn far_apart_items_have_no_odd_numbers() {
    for exponent in [3, 6, 12, 100, 300] {
        let many = 10_f64.powi(exponent);
        let wins = [[0., many, many], [1., 0., many], [1., 1., 0.]];
        said(&of_observers(&[of(&wins)], 1));
        said(&of_observers(&[of(&[[0., many, many], [0., 0., many], [0., 0., 0.]])], 1));
    }
}
