//! Confusion matrices (R 4.2.2, November 2026) and d′ (R 4.2.2, psyphy 0.2-3, November 2026, whose
//! root-finding stops within about 1e-4).

use crate::close;
use shutterlab_analysis::categories::confusion::confusion;
use shutterlab_analysis::categories::discrimination::{Counts, Model, Strategy};
use shutterlab_analysis::categories::forced_choice::ForcedChoice;
use shutterlab_analysis::categories::kappa::{Weights, kappa};

/// What R says about a confusion matrix: accuracy, its exact interval, κ, its SE, χ², df, p, V, recall,
/// precision, bits.
struct Case {
    counts: Vec<Vec<u64>>,
    accuracy: f64,
    interval: [f64; 2],
    kappa: [f64; 2],
    chi2: f64,
    df: u64,
    p: f64,
    cramers_v: f64,
    recall: Vec<f64>,
    precision: Vec<f64>,
    bits: f64,
}

fn textbook_2x2() -> Case {
    Case {
        counts: vec![vec![20, 5], vec![10, 15]],
        accuracy: 0.7,
        interval: [0.553917674338822, 0.821382154335853],
        kappa: [0.4, 0.1269960629311],
        chi2: 8.33333333333333,
        df: 1,
        p: 0.00389241712277863,
        cramers_v: 0.408248290463863,
        recall: vec![0.8, 0.6],
        precision: vec![0.666666666666667, 0.75],
        bits: 0.124511249783653,
    }
}

fn matching_5x5() -> Case {
    Case {
        counts: vec![
            vec![20, 6, 3, 1, 0],
            vec![5, 18, 5, 2, 0],
            vec![2, 6, 15, 5, 2],
            vec![1, 2, 6, 16, 5],
            vec![0, 1, 2, 7, 20],
        ],
        accuracy: 0.593333333333333,
        interval: [0.51019256374035, 0.672711686222737],
        kappa: [0.491666666666667, 0.0502101617155947],
        chi2: 169.245799003864,
        df: 16,
        p: 1.19051213832359e-27,
        cramers_v: 0.531108587459388,
        recall: vec![0.666666666666667, 0.6, 0.5, 0.533333333333333, 0.666666666666667],
        precision: vec![
            0.714285714285714,
            0.545454545454545,
            0.483870967741935,
            0.516129032258065,
            0.740740740740741,
        ],
        bits: 0.730596855314275,
    }
}

#[test]
fn confusion_matrices_are_those_of_r() {
    for case in [textbook_2x2(), matching_5x5()] {
        let found = confusion(&case.counts).unwrap();
        close(found.accuracy.share(), case.accuracy, 1e-10, "accuracy");
        for side in [0, 1] {
            close(found.accuracy.clopper_pearson_95[side], case.interval[side], 1e-10, "interval");
        }
        let kappa = found.kappa.unwrap();
        close(kappa.kappa, case.kappa[0], 1e-10, "κ");
        close(kappa.se, case.kappa[1], 1e-10, "SE of κ");
        let association = found.association.unwrap();
        close(association.chi2, case.chi2, 1e-10, "χ²");
        assert_eq!(association.df, case.df);
        close(association.p.value(), case.p, 1e-10, "p");
        close(association.cramers_v, case.cramers_v, 1e-10, "V");
        for (found, recall) in found.recall.iter().zip(&case.recall) {
            close(found.unwrap().share(), *recall, 1e-10, "recall");
        }
        for (found, precision) in found.precision.iter().zip(&case.precision) {
            close(found.unwrap(), *precision, 1e-10, "precision");
        }
        close(found.mutual_information_bits, case.bits, 1e-10, "bits");
    }
}

/// (share right, m, d′)
const ALTERNATIVES: [(f64, u32, f64); 24] = [
    (0.5001, 2, 0.000354485976682484),
    (0.5001, 3, 0.556851829230921),
    (0.5001, 4, 0.837087069106791),
    (0.5001, 8, 1.34213303650478),
    (0.6, 2, 0.358264162574853),
    (0.6, 3, 0.885149083161445),
    (0.6, 4, 1.15323039978121),
    (0.6, 8, 1.64070269286947),
    (0.7, 2, 0.741632405712305),
    (0.7, 3, 1.23795451220812),
    (0.7, 4, 1.49323151005522),
    (0.7, 8, 1.96207581557645),
    (0.8, 2, 1.19020648805231),
    (0.8, 3, 1.65241427018581),
    (0.8, 4, 1.89314303479436),
    (0.8, 8, 2.34032043777934),
    (0.9, 2, 1.81237421414998),
    (0.9, 3, 2.23020024189002),
    (0.9, 4, 2.45156984709818),
    (0.9, 8, 2.86913945452952),
    (0.99, 2, 3.28995478056639),
    (0.99, 3, 3.61726765921749),
    (0.99, 4, 3.79695592046355),
    (0.99, 8, 4.14748336737888),
];
/// (hits, false alarms, d′ by differencing, d′ by independent observations)
type Rates = (f64, f64, f64, f64);
const ABX: [Rates; 4] = [
    (0.6, 0.4, 1.11521917874936, 1.00194876386397),
    (0.7, 0.3, 1.7153018060875, 1.5286941224899),
    (0.8, 0.2, 2.35486030593842, 2.07257976257047),
    (0.9, 0.1, 3.26310796179488, 2.8072890545045),
];
const SAME_DIFFERENT: [Rates; 4] = [
    (0.6, 0.3, 1.78474036647821, 1.51122561425025),
    (0.8, 0.2, 3.00095879405731, 2.42456985877262),
    (0.9, 0.4, 2.99011697129346, 2.28353177481491),
    (0.7, 0.5, 1.54179096438832, 1.20990337164868),
];

/// Answers whose shares are these.
fn counts(hits: f64, false_alarms: f64) -> Counts {
    let of = |share: f64| (1000.0 * share).round() as u64;
    Counts { hits: of(hits), signals: 1000, false_alarms: of(false_alarms), noises: 1000 }
}

#[test]
fn sensitivities_are_those_of_psyphy() {
    let near = |found: f64, expected: f64, what: &str| {
        assert!((found - expected).abs() < 1e-4, "{what}: {found} is not {expected}");
    };
    for (share, m, d_prime) in ALTERNATIVES {
        let correct = (10_000.0 * share).round() as u64;
        let found = ForcedChoice::Alternatives(m).d_prime(correct, 10_000).unwrap();
        near(found.d_prime, d_prime, &format!("{share} of {m}"));
    }
    for (hits, false_alarms, differencing, independent) in ABX {
        for (strategy, expected) in [
            (Strategy::Differencing, differencing),
            (Strategy::IndependentObservations, independent),
        ] {
            let found = Model::Abx(strategy).d_prime(counts(hits, false_alarms)).unwrap();
            near(found.d_prime, expected, &format!("ABX {strategy:?} {hits} {false_alarms}"));
        }
    }
    for (hits, false_alarms, differencing, independent) in SAME_DIFFERENT {
        for (strategy, expected) in [
            (Strategy::Differencing, differencing),
            (Strategy::IndependentObservations, independent),
        ] {
            let found = Model::SameDifferent(strategy).d_prime(counts(hits, false_alarms)).unwrap();
            near(found.d_prime, expected, &format!("same {strategy:?} {hits} {false_alarms}"));
        }
    }
}

#[test]
fn weighted_kappa_is_that_of_statsmodels() {
    // Python 3.11, statsmodels 0.15.0, November 2026: cohens_kappa(table, wt).
    let expected = [
        (Weights::Linear, 0.6621621621621623, 0.04073092694735739),
        (Weights::Quadratic, 0.7876712328767124, 0.036915486844902264),
    ];
    for (weights, value, se) in expected {
        let found = kappa(&matching_5x5().counts, weights).unwrap();
        close(found.kappa, value, 1e-10, "κ");
        close(found.se, se, 1e-10, "SE of κ");
    }
}

#[test]
fn yes_no_is_a_probit_regression() {
    // R 4.2.2, November 2026: glm(cbind(c(42, 15), c(18, 45)) ~ c(1, 0), binomial(probit)) and confint of
    // MASS 7.3-58, whose profile is interpolated.
    let counts = Counts { hits: 42, signals: 60, false_alarms: 15, noises: 60 };
    let found = Model::YesNo.d_prime(counts).unwrap();
    close(found.d_prime, 1.198890262904122, 1e-10, "d′");
    close(found.se.unwrap(), 0.244740735011278, 1e-7, "SE");
    close(found.interval_95[0].unwrap(), 0.724476606918812, 1e-4, "lower");
    close(found.interval_95[1].unwrap(), 1.684520285150662, 1e-4, "upper");
}
