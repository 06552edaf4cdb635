//! Psychometric functions fitted to other people's data, which are read from where they lie.

use crate::close;
use serde_json::Value;
use shutterlab_analysis::psychometric::fit::{Level, fit};
use shutterlab_analysis::psychometric::function::{Model, Shape};

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn fits_are_those_of_r() {
    let folder = std::env::var("SHUTTERLAB_GOLDEN").unwrap();
    let text = std::fs::read_to_string(format!("{folder}/psychometric_fits.json")).unwrap();
    let sets: serde_json::Map<String, Value> = serde_json::from_str(&text).unwrap();
    let mut largest = 0.0_f64;
    for (name, set) in &sets {
        let numbers = |key: &str| set[key].as_array().unwrap().clone();
        let levels: Vec<Level> = numbers("x")
            .iter()
            .zip(numbers("k").iter().zip(&numbers("n")))
            .map(|(level, (chosen, trials))| Level {
                level: level.as_f64().unwrap(),
                chosen: chosen.as_u64().unwrap(),
                trials: trials.as_u64().unwrap(),
            })
            .collect();
        let alternatives = set["m_alternatives"].as_u64().unwrap() as u32;
        for (key, shape) in [
            ("mafc_logit", Shape::Logistic),
            ("mafc_probit", Shape::Probit),
            ("yesno_logit", Shape::Logistic),
            ("yesno_probit", Shape::Probit),
            ("mafc_weibull_cloglog_logx", Shape::Weibull),
        ] {
            let model = match key.starts_with("mafc") {
                true => Model::forced_choice(shape, alternatives),
                false => Model::yes_no(shape),
            };
            let fit = fit(&levels, model).unwrap();
            let theirs = &set[key];
            let [intercept, slope] = [&fit.intercept, &fit.slope];
            for (ours, theirs) in [
                (intercept.estimate, &theirs["coef"][0]),
                (slope.estimate, &theirs["coef"][1]),
                (intercept.se.unwrap(), &theirs["se"][0]),
                (slope.se.unwrap(), &theirs["se"][1]),
                (fit.deviance, &theirs["deviance"]),
                (fit.log_likelihood, &theirs["logLik"]),
                (-intercept.estimate / slope.estimate, &theirs["threshold_x_at_eta0"]),
            ] {
                let theirs = theirs.as_f64().unwrap();
                largest = largest.max((ours / theirs - 1.0).abs());
                close(ours, theirs, 1e-5, &format!("{name} {key}"));
            }
        }
    }
    println!("psychometric_fits.json: largest relative difference {largest:e}");
}
