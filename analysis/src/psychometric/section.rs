//! A psychometric function in words, tables and a figure.

use super::analysis::PsychometricAnalysis;
use super::fit::{Coefficient, PsychometricFit};
use super::function::{Rate, Shape};
use crate::maths::distributions::wilson_95;
use crate::ratings::section::WHO_IS_UNKNOWN;
use crate::report::labels::significant;
use crate::report::plot::{Axis, Plot, Series, Style};
use crate::report::section::{Cell, Column, Figure, Kind, Section, Table};

/// The section on a psychometric function.
pub fn section(analysis: &PsychometricAnalysis) -> Section {
    Section {
        heading: "Psychometric function".into(),
        sentences: sentences(analysis),
        tables: vec![coefficients(&analysis.fit), levels(&analysis.fit)],
        figures: vec![figure(analysis)],
        method: vec![
            "The function ψ = γ + (1 − γ − λ)·F with guess rate γ and lapse rate λ was fitted by \
             binomial maximum likelihood with Fisher scoring (Wichmann and Hill 2001). Standard \
             errors come from the expected information. The threshold has intervals by the delta \
             method, by the profile likelihood and by the bootstrap, of whole observers where \
             they are told apart (expanded percentiles, Hesterberg 2015) and of answers drawn \
             from the fitted function otherwise. The deviance is compared with that of answers \
             drawn from the function."
                .into(),
        ],
        references: vec![
            "Hesterberg, T. C. (2015). What teachers should know about the bootstrap. The American \
             Statistician 69, 371–386.",
            "Wichmann, F. A. & Hill, N. J. (2001). The psychometric function: I. Fitting, \
             sampling, and goodness of fit. II. Bootstrap-based confidence intervals and \
             sampling. Perception & Psychophysics 63, 1293–1329.",
        ],
    }
}

fn form(shape: Shape) -> &'static str {
    match shape {
        Shape::Logistic => "logistic function of the level",
        Shape::Probit => "probit function of the level",
        Shape::Weibull => "Weibull function of the level",
    }
}

fn named(fit: &PsychometricFit) -> [(&'static str, &Coefficient); 4] {
    [
        ("intercept", &fit.intercept),
        ("slope", &fit.slope),
        ("guess rate γ", &fit.guess_rate),
        ("lapse rate λ", &fit.lapse_rate),
    ]
}

fn sentences(analysis: &PsychometricAnalysis) -> Vec<String> {
    let fit = &analysis.fit;
    let trials: u64 = fit.levels.iter().map(|level| level.answers.trials).sum();
    let mut lines = vec![
        WHO_IS_UNKNOWN.into(),
        format!(
            "A {} fitted to {trials} trials at {} levels{}: {}.",
            form(fit.model.shape),
            fit.levels.len(),
            analysis.observers.map_or(String::new(), |n| format!(" by {n} observers")),
            named(fit)
                .map(|(name, coefficient)| match (coefficient.se, coefficient.se_reason) {
                    (Some(se), _) => format!(
                        "{name} {} (SE {})",
                        significant(coefficient.estimate),
                        significant(se)
                    ),
                    (None, reason) => format!(
                        "{name} {} ({})",
                        significant(coefficient.estimate),
                        reason.unwrap_or_default()
                    ),
                })
                .join(", ")
        ),
    ];
    let interval = |[low, high]: [f64; 2]| format!("[{}, {}]", significant(low), significant(high));
    lines.push(match &analysis.threshold {
        Err(reason) => format!("No threshold: {reason}."),
        Ok(found) => {
            let open = |bound: Option<f64>| bound.map_or("open".into(), significant);
            let [low, high] = found.profile_95.map(open);
            let drawn = if analysis.observers.is_some() { "by observer" } else { "parametric" };
            let bootstrap = match &analysis.bootstrap {
                Ok(drawn) => format!(
                    "{} ({} resamples, {} without a threshold)",
                    interval(drawn.interval_95),
                    drawn.replicates,
                    drawn.failed
                ),
                Err(reason) => format!("not known ({reason})"),
            };
            let reason =
                found.profile_95_reason.map_or(String::new(), |reason| format!(" Open: {reason}."));
            let outside = found.outside.map_or(String::new(), |outside| {
                format!(" It lies {outside}: the function is extrapolated.")
            });
            format!(
                "Threshold: ψ is {} at the level {} (SE {}, delta method; 95 % intervals: delta \
                 {}, profile [{low}, {high}], bootstrap {drawn} {bootstrap}).{outside}{reason}",
                found.chance,
                significant(found.level),
                significant(found.se),
                interval(found.delta_95)
            )
        }
    });
    lines.push(match &analysis.goodness_of_fit {
        Err(reason) => format!("No test of the fit: {reason}."),
        Ok(tests) => format!(
            "Deviance = {:.3}, df = {}: {} (upper tail, χ² approximation), {} (upper tail, Monte \
             Carlo with {} sets of answers, {} of them without a fit).",
            tests.deviance,
            tests.df,
            tests.p.equation(),
            tests.p_monte_carlo.equation(),
            tests.replicates,
            tests.failed
        ),
    });
    if analysis.observers.is_none() {
        lines.push(
            "Standard errors, intervals and tests take all answers as independent; answers of \
             several observers are not, and need the column `observer`."
                .into(),
        );
    }
    lines
}

fn coefficients(fit: &PsychometricFit) -> Table {
    let column = |name: &str, kind, description: &str| Column::new(name, name, kind, description);
    let axis = if fit.model.shape == Shape::Weibull { "ln level" } else { "level" };
    let slope = format!("F(intercept + slope·{axis}), or a rate.");
    let rows = named(fit).map(|(name, coefficient)| {
        let note = coefficient.se_reason.map_or(Cell::Missing, Cell::from);
        vec![name.into(), coefficient.estimate.into(), coefficient.se.into(), note]
    });
    Table {
        name: "psychometric-fit".into(),
        caption: format!("The parameters of the {}.", form(fit.model.shape)),
        columns: vec![
            column("parameter", Kind::Text, &slope),
            column("estimate", Kind::Number(4), "Maximum-likelihood estimate, or the value given."),
            column("se", Kind::Number(4), "Standard error by the expected information."),
            column("note", Kind::Text, "Why there is no standard error."),
        ],
        rows: rows.to_vec(),
    }
}

fn levels(fit: &PsychometricFit) -> Table {
    let column = |name: &str, kind, description: &str| Column::new(name, name, kind, description);
    let rows = fit.levels.iter().map(|level| {
        let [low, high] = wilson_95(level.answers.chosen, level.answers.trials);
        let numbers = [level.share, low, high, level.fitted, level.deviance_residual];
        let mut row: Vec<Cell> = vec![
            level.answers.level.into(),
            level.answers.chosen.into(),
            level.answers.trials.into(),
        ];
        row.extend(numbers.map(Cell::from));
        row
    });
    Table {
        name: "psychometric-levels".into(),
        caption: "The answers at each level and what the function says of them.".into(),
        columns: vec![
            column("level", Kind::Number(4), "The level."),
            column("chosen", Kind::Integer, "How often the answer was given."),
            column("trials", Kind::Integer, "In how many trials."),
            column("share", Kind::Number(3), "chosen/trials."),
            column(
                "wilson_95_low",
                Kind::Number(3),
                "Lower bound of Wilson's 95 % interval of the share.",
            ),
            column(
                "wilson_95_high",
                Kind::Number(3),
                "Upper bound of Wilson's 95 % interval of the share.",
            ),
            column("fitted", Kind::Number(3), "Chance of the answer by the function."),
            column(
                "deviance_residual",
                Kind::Number(2),
                "Signed root of what the level adds to the deviance.",
            ),
        ],
        rows: rows.collect(),
    }
}

fn figure(analysis: &PsychometricAnalysis) -> Figure {
    let fit = &analysis.fit;
    let levels = || fit.levels.iter().map(|level| level.answers.level);
    let [low, high] =
        [levels().fold(f64::INFINITY, f64::min), levels().fold(f64::NEG_INFINITY, f64::max)];
    let curve = (0..=100).map(|k| {
        let level = low + (high - low) * f64::from(k) / 100.0;
        [level, fit.chance(level)]
    });
    let shares = Series {
        name: "answers".into(),
        style: Style::Points,
        points: fit.levels.iter().map(|level| [level.answers.level, level.share]).collect(),
        intervals: fit
            .levels
            .iter()
            .map(|l| wilson_95(l.answers.chosen, l.answers.trials))
            .collect(),
    };
    let line = Series {
        name: "function".into(),
        style: Style::Line,
        points: curve.collect(),
        intervals: vec![],
    };
    let mut rules = Vec::new();
    if let Ok(found) = &analysis.threshold {
        rules.push((found.chance, format!("at {}", significant(found.level))));
    }
    if let Rate::Fixed(guess) = fit.model.guess
        && guess > 0.0
    {
        rules.push((guess, "guessing".into()));
    }
    Figure {
        name: "psychometric".into(),
        caption: "Shares of the answer with Wilson's 95 % intervals, and the fitted function."
            .into(),
        svg: Plot {
            label: "Psychometric function".into(),
            x: Axis::of("level", [low, high]),
            y: Axis::of("share", [0.0, 1.0]),
            series: vec![shares, line],
            rules,
        }
        .svg(),
    }
}
