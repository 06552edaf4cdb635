//! Psychometric functions fitted to made-up answers: R 4.2.2, psyphy 0.2-3 (`mafc.logit`, `mafc.probit`,
//! `mafc.cloglog` on ln level) and `glm` (yes or no), November 2026.

use crate::close;
use shutterlab_analysis::psychometric::fit::{Level, PsychometricFit, fit};
use shutterlab_analysis::psychometric::function::{Model, Rate, Shape};
use shutterlab_analysis::psychometric::threshold::threshold;

const LEVELS: [f64; 8] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0];
const CHOSEN_1: [u64; 8] = [12, 18, 13, 19, 20, 19, 20, 20];
const CHOSEN_2: [u64; 8] = [17, 25, 25, 25, 26, 34, 39, 40];

/// What the other program gives: intercept, slope, their standard errors, deviance, log-likelihood, and
/// where η is 0 on the axis.
struct Case {
    chosen: [u64; 8],
    trials: u64,
    /// Alternatives of a forced choice; none for yes or no.
    alternatives: Option<u32>,
    shape: Shape,
    values: [f64; 7],
}

const CASES: [Case; 10] = [
    Case {
        chosen: CHOSEN_1,
        trials: 20,
        alternatives: Some(2),
        shape: Shape::Logistic,
        values: [
            -1.21410095490142,
            1.1848181076072,
            0.752646360739693,
            0.408303005299991,
            10.820890732052,
            -12.0213017603882,
            1.02471505719418,
        ],
    },
    Case {
        chosen: CHOSEN_1,
        trials: 20,
        alternatives: Some(2),
        shape: Shape::Probit,
        values: [
            -0.616644219042516,
            0.628947913368631,
            0.427513320157102,
            0.209173788339324,
            11.2020692778083,
            -12.2118910332663,
            0.980437657770075,
        ],
    },
    Case {
        chosen: CHOSEN_1,
        trials: 20,
        alternatives: None,
        shape: Shape::Logistic,
        values: [
            0.111679182588368,
            0.983372193048746,
            0.474123921544413,
            0.306268416611119,
            10.5844081844733,
            -11.9030604865988,
            -0.11356756208667,
        ],
    },
    Case {
        chosen: CHOSEN_1,
        trials: 20,
        alternatives: None,
        shape: Shape::Probit,
        values: [
            0.179984815096476,
            0.493356990693997,
            0.268921864265741,
            0.152206927254537,
            10.8037137470561,
            -12.0127132678902,
            -0.364816590200321,
        ],
    },
    Case {
        chosen: CHOSEN_1,
        trials: 20,
        alternatives: Some(2),
        shape: Shape::Weibull,
        values: [
            -0.343266396851803,
            1.10420414388771,
            0.313168348043856,
            0.319867239607102,
            10.5565147071094,
            -11.8891137479169,
            0.310872222996033,
        ],
    },
    Case {
        chosen: CHOSEN_2,
        trials: 40,
        alternatives: Some(2),
        shape: Shape::Logistic,
        values: [
            -3.47019307306446,
            1.05692534052644,
            0.895423482628033,
            0.239947253765878,
            4.46593272440571,
            -15.1979051231739,
            3.28329063558645,
        ],
    },
    Case {
        chosen: CHOSEN_2,
        trials: 40,
        alternatives: Some(2),
        shape: Shape::Probit,
        values: [
            -1.95244455996503,
            0.596379980529391,
            0.46258498115333,
            0.120587274144551,
            4.19227047451837,
            -15.0610739982302,
            3.27382645915091,
        ],
    },
    Case {
        chosen: CHOSEN_2,
        trials: 40,
        alternatives: None,
        shape: Shape::Logistic,
        values: [
            -0.47916159756969,
            0.563514011612267,
            0.228643533813811,
            0.092099637206978,
            7.35799129057432,
            -16.6439344062582,
            0.850309997081994,
        ],
    },
    Case {
        chosen: CHOSEN_2,
        trials: 40,
        alternatives: None,
        shape: Shape::Probit,
        values: [
            -0.272401772956914,
            0.329529624206951,
            0.136675893872606,
            0.049993325547611,
            5.93078810311109,
            -15.9303328125266,
            0.826638192582773,
        ],
    },
    Case {
        chosen: CHOSEN_2,
        trials: 40,
        alternatives: Some(2),
        shape: Shape::Weibull,
        values: [
            -2.99812842362418,
            2.26279275545642,
            0.723504877581129,
            0.476961914570555,
            4.74489160850417,
            -15.3373845652231,
            1.32496819092009,
        ],
    },
];

fn levels(chosen: &[u64], trials: u64) -> Vec<Level> {
    let rows = LEVELS.into_iter().zip(chosen);
    rows.map(|(level, chosen)| Level { level, chosen: *chosen, trials }).collect()
}

fn model(case: &Case) -> Model {
    match case.alternatives {
        Some(alternatives) => Model::forced_choice(case.shape, alternatives),
        None => Model::yes_no(case.shape),
    }
}

/// What [`Case`] has, as found.
fn found(fit: &PsychometricFit) -> [f64; 7] {
    let [intercept, slope] = [&fit.intercept, &fit.slope];
    let zero = -intercept.estimate / slope.estimate;
    [
        intercept.estimate,
        slope.estimate,
        intercept.se.unwrap(),
        slope.se.unwrap(),
        fit.deviance,
        fit.log_likelihood,
        zero,
    ]
}

#[test]
fn fits_are_those_of_r() {
    for case in &CASES {
        let fit = fit(&levels(&case.chosen, case.trials), model(case)).unwrap();
        for (ours, theirs) in found(&fit).into_iter().zip(case.values) {
            close(ours, theirs, 1e-5, &format!("{:?} {:?}", case.shape, case.alternatives));
        }
        assert_eq!(fit.df, 6);
        // The level at η = 0 is the threshold at the chance there.
        let (zero, axis) = (case.values[6], case.shape == Shape::Weibull);
        let level = if axis { zero.exp() } else { zero };
        close(threshold(&fit, fit.chance(level)).unwrap().level, level, 1e-5, "threshold");
    }
}

/// Deviances of R's `glm` with the threshold given (an offset), solved by `uniroot` for the bounds.
#[test]
fn profile_intervals_are_those_of_r() {
    for (shape, alternatives, chance, theirs) in [
        (Shape::Logistic, None, 0.5, [0.8503099970820, 0.0866718219494, 1.3660486248956]),
        (Shape::Logistic, Some(2), 0.75, [3.28329066271, 2.67633525706, 3.93589459171]),
        (Shape::Weibull, Some(2), 0.75, [3.19950006310, 2.52447726815, 3.92489258421]),
    ] {
        let model = alternatives
            .map_or(Model::yes_no(shape), |alternatives| Model::forced_choice(shape, alternatives));
        let fit = fit(&levels(&CHOSEN_2, 40), model).unwrap();
        let found = threshold(&fit, chance).unwrap();
        let [low, high] = found.profile_95.map(Option::unwrap);
        for (ours, theirs) in [found.level, low, high].into_iter().zip(theirs) {
            close(ours, theirs, 1e-5, &format!("{shape:?} {alternatives:?}"));
        }
    }
}

/// The likelihood maximised by R's `optim` over a lapse rate as well.
#[test]
fn a_fitted_lapse_rate_is_that_of_r() {
    let rows = [(1.0, 1), (2.0, 8), (3.0, 30), (4.0, 38), (6.0, 38)];
    let levels = rows.map(|(level, chosen)| Level { level, chosen, trials: 40 });
    let model = Model { lapse: Rate::Fitted([0.0, 0.1]), ..Model::yes_no(Shape::Logistic) };
    let fit = fit(&levels, model).unwrap();
    let [intercept, slope, lapse] = [&fit.intercept, &fit.slope, &fit.lapse_rate];
    for (found, estimate, se) in [
        (intercept, -6.4579004406681, 1.1354278513115),
        (slope, 2.585720131006, 0.4704705828538),
        (lapse, 0.0424009635664, 0.0267095170488),
    ] {
        close(found.estimate, estimate, 1e-5, "estimate");
        close(found.se.unwrap(), se, 1e-5, "standard error");
    }
    close(fit.log_likelihood, -7.45573616002, 1e-9, "log-likelihood");
}

/// The order of the levels, and levels without trials, change nothing.
#[test]
fn the_order_of_the_levels_changes_nothing() {
    let case = &CASES[5];
    let forwards = levels(&case.chosen, case.trials);
    let mut backwards: Vec<Level> = forwards.iter().rev().copied().collect();
    backwards.push(Level { level: 7.0, chosen: 0, trials: 0 });
    let [ours, theirs] =
        [forwards, backwards].map(|levels| found(&fit(&levels, model(case)).unwrap()));
    for (ours, theirs) in ours.into_iter().zip(theirs) {
        close(ours, theirs, 1e-9, "order");
    }
}
