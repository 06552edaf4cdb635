//! The re-fit of the law of the level of detail in words, tables and figures.

use super::joint_law::{JointLaw, JointParameter, ModelUnderLaw};
use super::law::{PUBLISHED_R, Refit};
use super::law_tables::{figure, joint_tables, models, parameters, residuals, units};
use super::level_of_detail::Rule;
use super::reciprocal::{Parameter, ReciprocalFit};
use super::section::{interval, known, left_out, who};
use crate::outcome::Outcome;
use crate::report::labels::significant;
use crate::report::section::Section;
use crate::report::section::ZHANG;
use shutterlab_data_schema::fitted::LevelOfDetailLaw;

/// With a share of "same" that is off by more, a model is named.
const UNLIKE: f64 = 0.1;

const PUBLISHED: LevelOfDetailLaw = LevelOfDetailLaw::PUBLISHED;

/// The section on a re-fit.
pub fn section(refit: &Refit) -> Section {
    let mut tables: Vec<_> =
        refit.joint.iter().flat_map(|joint| joint_tables(refit, joint)).collect();
    tables.push(parameters(refit));
    let mut figures = Vec::new();
    if let Ok(fit) = &refit.fit {
        tables.push(residuals(refit, fit));
        figures.push(figure(refit, fit));
    }
    tables.extend(refit.over_models.as_ref().ok().map(models));
    Section {
        heading: "The law of the level of detail".into(),
        sentences: sentences(refit),
        tables,
        figures,
        method: method(refit),
        references: vec![
            "Bates, D. M. & Watts, D. G. (1988). Nonlinear Regression Analysis and Its \
             Applications. Wiley.",
            "Davidian, M. & Giltinan, D. M. (1995). Nonlinear Models for Repeated Measurement \
             Data. Chapman & Hall.",
            "Efron, B. & Tibshirani, R. J. (1993). An Introduction to the Bootstrap. Chapman & Hall.",
            "Hesterberg, T. C. (2015). What teachers should know about the bootstrap. The American \
             Statistician 69, 371–386.",
            "Moré, J. J. (1978). The Levenberg–Marquardt algorithm: implementation and theory. \
             In: Numerical Analysis, Lecture Notes in Mathematics 630. Springer.",
            ZHANG,
        ],
    }
}

/// How the laws were found.
fn method(refit: &Refit) -> Vec<String> {
    let from_all_answers = refit.joint.iter().map(|_| {
        "The law from all answers at once is that of the largest likelihood with P(same) = λ/2 + \
         (1 − λ) L(c + s·(ln ρ + ln(σ₁v + σ₂))), L the logistic function, lapses λ of 0 to 6 %, and \
         c such that 80 % say \"same\" where ρ is that of the law. Standard errors are those of the \
         jackknife over observers, of ln σ₁ and ln σ₂; intervals are Student's (Efron and \
         Tibshirani 1993, chapter 11)."
            .into()
    });
    let others = [
        "The law ρ = 1/(σ₁v + σ₂) of Zhang et al. (2014, Eq. 8) gives the highest spatial \
             frequency ρ to keep at the screen velocity v. It was fitted by least squares with \
             the method of Levenberg and Marquardt (Moré 1978). Standard errors and Student's t \
             intervals are those of the linearised model; profile intervals hold the σ whose \
             least sum of squares is within the F limit (Bates and Watts 1988). Both take the \
             frequencies as equally and independently scattered at all speeds."
            .into(),
        match refit.drawn {
            "residuals" => "Bootstrap intervals come from residuals, each divided by √(1 − \
                                leverage), drawn with replacement and studentised (Efron and \
                                Tibshirani 1993)."
                .into(),
            drawn => format!(
                "Bootstrap intervals come from {}: their coarsest levels are found and the \
                     law is fitted again. They take the scatter of the ratings as it is, which \
                     falls with the frequency; where there is no law from all answers they are the \
                     ones to quote. Percentiles are expanded for few observers (Hesterberg 2015).",
                if drawn == "observers" {
                    "resampled observers"
                } else {
                    "answers to each image drawn anew"
                }
            ),
        },
        "A level of detail is a share of faces; its spatial frequency is the reciprocal of \
             the mean perimeter of the model's projected triangles. Between two levels of known \
             frequency it is interpolated on logarithmic scales."
            .into(),
        "The mean law over models is a global two-stage estimate (Davidian and Giltinan \
             1995, §5.3): each model's own law, weighted by its own uncertainty and the \
             covariance between models, which is estimated by restricted maximum likelihood."
            .into(),
    ];
    from_all_answers.chain(others).collect()
}

fn sentences(refit: &Refit) -> Vec<String> {
    let setting = &refit.setting;
    let [velocity, frequency] = units(refit);
    let mut lines: Vec<String> = who(setting.simulated).into_iter().collect();
    lines.extend(left_out(setting.unnamed));
    lines.push(format!("Speeds v are in {velocity}, spatial frequencies ρ in {frequency}."));
    lines.extend((setting.rule == Some(Rule::Smoothed)).then(|| from_all_answers(&refit.joint)));
    lines.extend(refit.joint.as_ref().ok().and_then(unlike_the_law));
    match setting.rule {
        Some(Rule::Smoothed) => lines.push(
            "The points are the levels of detail at which a function through the ratings is 0.8."
                .into(),
        ),
        Some(Rule::Point) => lines.push(
            "The points are the coarsest levels tested whose rating is 0.8 or more (the rule of \
             Zhang et al. 2014). It names levels tested only, so the frequencies are too high \
             and the σ too low by up to the step between two levels."
                .into(),
        ),
        None => {}
    }
    match &refit.fit {
        Err(reason) => lines.push(format!("No law through points follows: {reason}.")),
        Ok(fit) => {
            lines.push(parameter("σ₁", refit, 0, fit));
            lines.push(parameter("σ₂", refit, 1, fit));
            if setting.rule.is_some() && refit.joint.is_err() && refit.bootstrap.is_ok() {
                lines.push(
                    "Quote the bootstrap intervals: points from ratings scatter less where the \
                     frequency is low, and share their observers, which the t and profile \
                     intervals leave out of account."
                        .into(),
                );
            }
            lines.push(quality(fit, frequency));
        }
    }
    lines.push(match (setting.r, refit.r_less_published) {
        (Some(r), Some(difference)) => format!(
            "The rated models were simplified with r = {r}; Zhang et al. (2014) take \
             {PUBLISHED_R}, the difference is {difference}."
        ),
        _ => format!(
            "With which r the models were simplified is not known; Zhang et al. (2014) take \
             {PUBLISHED_R}."
        ),
    });
    lines.push(format!(
        "The published law is ρ = 1/({}·v + {}), v in {}, ρ in {}. In these units it does not \
         give the face counts of its own Table 1, nor does it in degrees of visual angle; a fit \
         of one's own replaces it.",
        PUBLISHED.sigma_1.value,
        PUBLISHED.sigma_2.value,
        PUBLISHED.velocity_unit.symbol(),
        PUBLISHED.frequency_unit.symbol()
    ));
    lines.push(over_models(refit));
    if !refit.left_out.is_empty() {
        lines.push(format!("{} models and speeds give no point.", refit.left_out.len()));
        lines.extend(refit.left_out.iter().cloned());
    }
    lines
}

/// The law from all answers at once.
fn from_all_answers(found: &Outcome<JointLaw>) -> String {
    let found = match found {
        Err(reason) => return format!("No law from all answers at once: {reason}."),
        Ok(found) => found,
    };
    let [one, two] = found.sigma.map(|JointParameter { estimate, se, interval_95 }| {
        let [estimate, se] = [estimate, se].map(significant);
        format!("{estimate} (SE {se}, 95 % interval {})", interval(interval_95))
    });
    format!(
        "From all answers at once ({} to {} images): σ₁ = {one}, σ₂ = {two}; the log-odds of \"same\" grow by {} \
         with the logarithm of ρ. These are the values to quote, for these \
         models: they need no points.",
        found.answers,
        found.images,
        significant(found.slope)
    )
}

/// The models for which the law of all does not hold.
fn unlike_the_law(joint: &JointLaw) -> Option<String> {
    let off = |of: &&ModelUnderLaw| (of.same - of.expected).abs() > UNLIKE;
    let percent = |share: f64| (100.0 * share).round();
    let said: Vec<String> = joint
        .models
        .iter()
        .filter(off)
        .map(|of| {
            format!("{} ({} %, by the law {} %)", of.model, percent(of.same), percent(of.expected))
        })
        .collect();
    (!said.is_empty()).then(|| {
        format!(
            "One law does not hold for all models: the share of \"same\" is another with {}. Look at the law of \
             each, below, and at whether such models belong together.",
            said.join(", ")
        )
    })
}

fn parameter(name: &str, refit: &Refit, i: usize, fit: &ReciprocalFit) -> String {
    let Parameter { estimate, se, wald_95, profile_95 } = [&fit.sigma_1, &fit.sigma_2][i];
    let published = [PUBLISHED.sigma_1.value, PUBLISHED.sigma_2.value][i];
    let less = [&refit.sigma_1_less_published, &refit.sigma_2_less_published][i];
    let beside = format!(
        "published {published}, difference {}",
        known(less, |difference| significant(*difference))
    );
    let estimate = significant(*estimate);
    let (Some(se), Some(wald), Some(profile)) = (se, wald_95, profile_95) else {
        let reason = fit.reason.unwrap_or_default();
        return format!(
            "{name} = {estimate}, no standard error and no interval: {reason}; {beside}."
        );
    };
    let open = |bound: &Option<f64>| bound.map_or("open".into(), significant);
    let [low, high] = profile.each_ref().map(open);
    let drawn = match refit.drawn {
        "residuals" => "residuals, studentised",
        "observers" => "by observer",
        _ => "answers to each image",
    };
    let bootstrap = known(&refit.bootstrap, |bootstrap| {
        format!(
            "{} ({} resamples, {} without a law)",
            interval(bootstrap[i].interval_95),
            bootstrap[i].replicates,
            bootstrap[i].failed
        )
    });
    format!(
        "{name} = {estimate} (SE {}; 95 % intervals: t({}) {}, profile [{low}, {high}], \
         bootstrap {drawn} {bootstrap}); {beside}.",
        significant(*se),
        fit.df,
        interval(*wald)
    )
}

fn quality(fit: &ReciprocalFit, unit: &str) -> String {
    if fit.residual_se.is_none() {
        return format!(
            "n = {} points, df = {}: how well the law fits does not follow.",
            fit.points.len(),
            fit.df
        );
    }
    let number = |value: Option<f64>| value.map_or("not known".into(), significant);
    format!(
        "n = {} points, df = {}, residual standard error {} {unit}, R² = {}, AIC = {}.",
        fit.points.len(),
        fit.df,
        number(fit.residual_se),
        number(fit.r_squared),
        number(fit.aic)
    )
}

fn over_models(refit: &Refit) -> String {
    match &refit.over_models {
        Err(reason) => format!("No mean law over models: {reason}."),
        Ok(found) => {
            let mean = |mean: &super::over_models::Mean| {
                format!(
                    "{} (SE {}, t({}) 95 % interval {}, standard deviation between models {})",
                    significant(mean.estimate),
                    significant(mean.se),
                    found.models.len() - 1,
                    interval(mean.interval_95),
                    significant(mean.sd_between)
                )
            };
            let left_out = match found.left_out.len() {
                0 => String::new(),
                n => format!(
                    " {n} models have no law of their own with σ₁ and σ₂ above 0 and are left out: {}.",
                    found.left_out.join(", ")
                ),
            };
            format!(
                "Mean law over {} models: σ₁ = {}, σ₂ = {}.{left_out}",
                found.models.len(),
                mean(&found.sigma_1),
                mean(&found.sigma_2)
            )
        }
    }
}
