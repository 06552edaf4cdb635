//! Ratings: made-up answers of a study, and tests against 0.8: R 4.2.2 `binom.test` and, for Wilson's interval, `prop.test(correct = FALSE)`,
//! November 2026.

use crate::close;
use shutterlab_analysis::ratings::analysis::analyze;
use shutterlab_analysis::ratings::answers::{RatingTrial, Ratings};
use shutterlab_analysis::ratings::rating::ratings;
use shutterlab_analysis::ratings::section::section;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::fitted::VelocityUnit;
use shutterlab_data_schema::response::Answer;

/// Same, of so many; Clopper and Pearson's interval, Wilson's, and the exact tests against 0.8, upper and
/// lower tail.
#[expect(clippy::type_complexity, reason = "a table of numbers")]
const CASES: [(usize, usize, [f64; 2], [f64; 2], f64, f64); 6] = [
    (
        14,
        20,
        [0.457210817723711, 0.881068409594272],
        [0.481027181646477, 0.854522755132396],
        0.9133074864326,
        0.195792214540451,
    ),
    (20, 20, [0.831566529016915, 1.0], [0.838874841947181, 1.0], 0.0115292150460685, 1.0),
    (
        6,
        21,
        [0.112809403921941, 0.521751118247114],
        [0.138138629521221, 0.499563807160856],
        0.999999952901949,
        5.13222262128639e-07,
    ),
    (
        13,
        18,
        [0.465198034416944, 0.903050787474441],
        [0.491273434397025, 0.87500246620446],
        0.867083665757176,
        0.283646184271381,
    ),
    (
        104,
        210,
        [0.425724039891736, 0.564888467599968],
        [0.428311604646329, 0.562335672027569],
        1.0,
        8.00037961408288e-23,
    ),
    (63, 63, [0.943127647667984, 1.0], [0.942528800411148, 1.0], 7.84637716923339e-07, 1.0),
];

#[test]
fn ratings_are_tested_as_in_r() {
    for (same, trials, exact, wilson, above, below) in CASES {
        let trial = |observer: usize| RatingTrial {
            observer,
            model: "made-up".into(),
            r: 4.0,
            level_of_detail: 0.1,
            speed: 10.0,
            same: Some(observer < same),
        };
        let trials: Vec<RatingTrial> = (0..trials).map(trial).collect();
        let answers = Ratings::from_trials(&trials, VelocityUnit::PixelsPerShutter).unwrap();
        let found = ratings(&answers)[0].share.clone().unwrap();
        for bound in 0..2 {
            close(found.clopper_pearson_95[bound], exact[bound], 1e-10, "Clopper and Pearson");
            close(found.wilson_95[bound], wilson[bound], 1e-10, "Wilson");
        }
        close(found.p_above.value(), above, 1e-10, "upper tail");
        close(found.p_below.value(), below, 1e-10, "lower tail");
        assert_eq!(found.reaches, 10 * same >= 8 * trials.len());
        assert_eq!(found.clopper_pearson_clears, exact[0] > 0.8);
        assert_eq!(found.wilson_clears, wilson[0] > 0.8);
    }
}

/// A study's rows become ratings where they say of which model they are; the original beside itself, and
/// rows without a model, are none.
#[test]
fn ratings_are_read_from_responses() {
    let text = include_str!("../../../data-schema/examples/valid/responses-same-different.csv");
    let rows: Vec<Response> =
        csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<_, _>>().unwrap();
    let none = Ratings::from_responses(&rows.iter().collect::<Vec<_>>()).unwrap_err();
    assert!(none.contains("the columns model, r and level_of_detail are empty"), "{none}");
    let of = |answer: Answer, model: Option<&str>| Response {
        answer,
        model: model.map(str::to_string),
        r: Some(4.0),
        level_of_detail: Some(0.1),
        ..rows[3].clone()
    };
    let identical =
        Response { stimulus_b: rows[3].stimulus_a.clone(), ..of(Answer::Same, Some("bunny")) };
    let answers = [
        of(Answer::Same, Some("bunny")),
        of(Answer::Different, Some("bunny")),
        of(Answer::NotSure, Some("bunny")),
        of(Answer::Same, None),
        identical,
    ];
    let ratings = Ratings::from_responses(&answers.iter().collect::<Vec<_>>()).unwrap();
    let counts = ratings.counts();
    assert_eq!(
        (counts.len(), counts[0].same, counts[0].different, counts[0].not_sure),
        (1, 1, 1, 1)
    );
    assert_eq!(ratings.unnamed, 1);
    let said = section(&analyze(&ratings, 99, 1)).sentences.join(" ");
    assert!(said.contains("1 answers have no model, r or level_of_detail"), "{said}");
    assert_eq!(ratings.images()[0].speed, rows[3].speed_deg_per_s);
    assert_eq!(
        (ratings.observers(), ratings.simulated, ratings.repeated()),
        (Some(1), Some(true), true)
    );
}
