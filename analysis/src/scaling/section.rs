//! Scaling in a section of the report: a figure, the method and its sources beside sentences and tables.

use super::sentences::sentences;
use super::study::Scaling;
use super::tables::tables;
use crate::outcome::Outcome;
use crate::report::labels::labels;
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{Figure, Section};

const HEADING: &str = "Scale values";

/// The section on scale values; `scaling` says why there is none.
pub fn section(scaling: &Outcome<Scaling>) -> Section {
    match scaling {
        Ok(scaling) => Section {
            heading: HEADING.into(),
            sentences: sentences(scaling),
            tables: tables(scaling),
            figures: vec![figure(scaling)],
            method: method(scaling),
            references: references(scaling),
        },
        Err(reason) => Section {
            heading: HEADING.into(),
            sentences: vec![format!("No scale values: {reason}.")],
            ..Section::default()
        },
    }
}

fn figure(scaling: &Scaling) -> Figure {
    let thurstone = &scaling.thurstone;
    let unit = thurstone.scale.model.just_objectionable_difference();
    let labels = labels(&scaling.items);
    let bounds = |i: usize| {
        let wald = thurstone.scale.centred(i).wald_95();
        thurstone.bootstrap_95(i).or(thurstone.profile_95(i)).unwrap_or(wald).map(|b| b / unit)
    };
    let rows: Vec<Dot> = thurstone
        .scale
        .best_first()
        .into_iter()
        .map(|i| Dot {
            label: labels[i].clone(),
            value: Some(thurstone.scale.values[i] / unit),
            interval: Some(bounds(i)),
        })
        .collect();
    let axis = Axis::of(
        "just-objectionable differences from the mean",
        rows.iter().filter_map(|row| row.interval).flatten(),
    );
    let intervals = match (&thurstone.bootstrap, &thurstone.profile_95) {
        (Ok(_), _) => "by resampling observers",
        (_, Ok(_)) => "of the profile likelihood",
        _ => "by the standard error",
    };
    let label = "Scale values with 95 % intervals";
    Figure {
        name: "scale".into(),
        caption: format!(
            "Thurstone Case V scale values ({}) with 95 % intervals {intervals}. One \
             just-objectionable difference is a preference of 75 %.",
            thurstone.scale.estimation.name()
        ),
        svg: dots(label, &axis, &rows, &[0.0]),
    }
}

fn method(scaling: &Scaling) -> Vec<String> {
    let mut method = vec![
        "Scale values were estimated by maximum likelihood with Fisher scoring, once in the model of \
         Bradley and Terry (1952), in which the log odds of a choice are the difference of two values, \
         and once in Case V of Thurstone (1927), in which the difference is the normal quantile of its \
         chance. Values have mean zero; one just-objectionable difference (JOD) is the difference at \
         which 75 % prefer the better item (Perez-Ortiz and Mantiuk 2017). Finite values exist if and \
         only if no group of items won every comparison with the others (Ford 1957); otherwise, values \
         are those of Firth's (1993) bias-reduced estimating equations in the form of Kosmidis and \
         Firth (2009)."
            .into(),
        "Standard errors come from the expected information and take all answers as independent. Profile \
         intervals hold the values that a likelihood-ratio test at 0.05 does not reject (bias-reduced: \
         of the penalised likelihood, Heinze and Schemper 2002). Bootstrap intervals resample whole \
         observers and so allow for differences between people; every replicate is fitted by bias \
         reduction, which gives values for separated replicates too, and the quantiles are widened for \
         the number of observers (Hesterberg 2015). p-values of differences are corrected by Holm (1979). \
         χ² describes \
         deviances roughly where expected counts are small (Cochran 1954), and with many pairs of few \
         answers each the deviance exceeds its degrees of freedom by a few per cent even for a scale \
         that is true; Pearson's χ² does not, nor does the test by simulation from the fitted scale, a \
         parametric bootstrap (Efron and Tibshirani 1993, §16)."
            .into(),
    ];
    if scaling.davidson.is_ok() {
        method.push(
            "In the model of Davidson (1970), ties have a threshold ν of their own, and the log odds of \
             a win against a loss are the difference of two values."
                .into(),
        );
    }
    method
}

fn references(scaling: &Scaling) -> Vec<&'static str> {
    let mut references = vec![
        "Bradley, R. A. and Terry, M. E. (1952). Rank analysis of incomplete block designs: I. The method \
         of paired comparisons. Biometrika 39, 324–345.",
        "Cochran, W. G. (1954). Some methods for strengthening the common χ² tests. Biometrics 10, \
         417–451.",
        "Efron, B. and Tibshirani, R. J. (1993). An Introduction to the Bootstrap. Chapman and Hall, New \
         York.",
        "Firth, D. (1993). Bias reduction of maximum likelihood estimates. Biometrika 80, 27–38.",
        "Ford, L. R. (1957). Solution of a ranking problem from binary comparisons. The American \
         Mathematical Monthly 64 (8, part 2), 28–33.",
        "Heinze, G. and Schemper, M. (2002). A solution to the problem of separation in logistic \
         regression. Statistics in Medicine 21, 2409–2419.",
        "Hesterberg, T. C. (2015). What teachers should know about the bootstrap. The American \
         Statistician 69, 371–386.",
        "Holm, S. (1979). A simple sequentially rejective multiple test procedure. Scandinavian Journal \
         of Statistics 6, 65–70.",
        "Kosmidis, I. and Firth, D. (2009). Bias reduction in exponential family nonlinear models. \
         Biometrika 96, 793–804.",
        "Perez-Ortiz, M. and Mantiuk, R. K. (2017). A practical guide and software for analysing pairwise \
         comparison experiments. arXiv:1712.03686.",
        "Thurstone, L. L. (1927). A law of comparative judgment. Psychological Review 34, 273–286.",
    ];
    if scaling.davidson.is_ok() {
        references.insert(
            2,
            "Davidson, R. R. (1970). On extending the Bradley–Terry model to accommodate ties in paired \
             comparison experiments. Journal of the American Statistical Association 65, 317–328.",
        );
    }
    references
}
