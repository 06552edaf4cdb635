//! Scale values of other people's data, as R 4.2.2 (`glm`, `BradleyTerry2`, `eba`) computes them.

use crate::close;
use serde_json::Value;
use shutterlab_analysis::scaling::comparisons::Comparisons;
use shutterlab_analysis::scaling::fit::{Estimation, Scale, fit};
use shutterlab_analysis::scaling::goodness_of_fit::goodness_of_fit;
use shutterlab_analysis::scaling::model::Model;
use std::path::Path;

const NEEDED: &str = "SHUTTERLAB_GOLDEN names the folder of reference values";

fn read(file: &str) -> Value {
    let folder = std::env::var("SHUTTERLAB_GOLDEN").expect(NEEDED);
    let text = std::fs::read_to_string(Path::new(&folder).join(file)).expect(NEEDED);
    serde_json::from_str(&text).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn comparisons(table: &Value) -> Comparisons {
    let labels = table["labels"].as_array().unwrap();
    let items: Vec<String> = labels.iter().map(|label| label.as_str().unwrap().into()).collect();
    let wins: Vec<Vec<f64>> = table["wins"].as_array().unwrap().iter().map(numbers).collect();
    Comparisons::of_matrix(&items, &wins).unwrap()
}

fn close_all(ours: impl Iterator<Item = f64>, theirs: &Value, what: &str) {
    let theirs = numbers(theirs);
    for (k, (ours, theirs)) in ours.zip(&theirs).enumerate() {
        close(ours, *theirs, 1e-6, &format!("{what} {k}"));
    }
}

fn close_from_first(scale: &Scale, values: &Value, errors: &Value, what: &str) {
    let from_first = |i| scale.difference(i, 0);
    let t = scale.values.len();
    close_all((0..t).map(|i| from_first(i).value), values, &format!("{what}: value"));
    close_all((0..t).map(|i| from_first(i).se), errors, &format!("{what}: standard error"));
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn fits_are_those_of_r() {
    for (name, case) in read("bradley_terry_fits.json").as_object().unwrap() {
        if name == "separated_firth" {
            continue;
        }
        let comparisons = comparisons(&case["mat"]);
        let scale = fit(&comparisons, Model::BradleyTerry, Estimation::MaximumLikelihood).unwrap();
        close_from_first(&scale, &case["logit_ref_first"], &case["se_ref_first"], name);
        let centred = |i| scale.centred(i);
        let t = scale.values.len();
        close_all((0..t).map(|i| centred(i).value), &case["logit_centered"], name);
        close_all((0..t).map(|i| centred(i).se), &case["se_centered"], name);
        close_all(scale.worths().into_iter(), &case["worth_sum1"], name);
        let goodness = goodness_of_fit(&comparisons, &scale);
        let p = goodness.p.map_or(f64::NAN, |p| p.value());
        for (ours, theirs) in [
            (goodness.log_likelihood, "logLik_binom"),
            (goodness.deviance, "deviance"),
            (goodness.pearson, "pearson_X2"),
            (goodness.df as f64, "df_resid"),
            (goodness.equal_worth.null_deviance, "null_deviance_equal_ability"),
        ] {
            close(ours, case[theirs].as_f64().unwrap(), 1e-6, &format!("{name}: {theirs}"));
        }
        close(p, case["p_gof"].as_f64().unwrap(), 1e-6, &format!("{name}: p"));
        let scale = fit(&comparisons, Model::ThurstoneV, Estimation::MaximumLikelihood).unwrap();
        let (values, errors) = (&case["thurstoneV_probit_ref_first"], &case["thurstoneV_se"]);
        close_from_first(&scale, values, errors, name);
        let deviance = goodness_of_fit(&comparisons, &scale).deviance;
        close(deviance, case["thurstoneV_deviance"].as_f64().unwrap(), 1e-6, name);
    }
}

#[test]
#[ignore = "needs the reference values of other people's data: SHUTTERLAB_GOLDEN=FOLDER"]
fn unequal_counts_are_those_of_r() {
    for (name, case) in read("incomplete_video_tmo_bt.json")["scenes"].as_object().unwrap() {
        let comparisons = comparisons(case);
        let [bradley_terry, thurstone] = [Model::BradleyTerry, Model::ThurstoneV]
            .map(|model| fit(&comparisons, model, Estimation::MaximumLikelihood).unwrap());
        close_from_first(&bradley_terry, &case["bt_logit_ref_first"], &case["bt_se"], name);
        let (values, errors) = (&case["thurstone_probit_ref_first"], &case["thurstone_se"]);
        close_from_first(&thurstone, values, errors, name);
        let unit = Model::ThurstoneV.just_objectionable_difference();
        let jods = (0..thurstone.values.len()).map(|i| thurstone.difference(i, 0).value / unit);
        close_all(jods, &case["JOD_thurstone"], name);
        let goodness = goodness_of_fit(&comparisons, &bradley_terry);
        close(goodness.deviance, case["deviance"].as_f64().unwrap(), 1e-6, name);
    }
}
