//! The section on the model with observers as clusters.

use super::HOLM;
use crate::maths::logistic::Method;
use crate::outcome::Outcome;
use crate::paired::clustered::{ClusteredPreference, Contrast};
use crate::report::labels::counted;
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{Cell, Column, Figure, Kind, Section, Table};

/// More contrasts than this make no readable figure.
const MOST_DRAWN: usize = 45;

/// Preferences with observers as clusters: between stimuli, and between levels of each axis.
pub fn clustered(
    items: &Outcome<ClusteredPreference>,
    levels: &Outcome<ClusteredPreference>,
) -> Section {
    let heading = "Preferences with observers as clusters";
    let both = [("stimuli", items), ("levels", levels)];
    let mut section = Section { heading: heading.into(), ..Section::default() };
    for (what, model) in both {
        match model {
            Ok(model) => {
                section.sentences.extend(sentences(what, model));
                section.tables.push(table(what, model));
                section.figures.extend(figure(what, model));
            }
            Err(reason) => {
                section.sentences.push(format!("{heading}: {what} not known, {reason}"));
            }
        }
    }
    if section.tables.is_empty() {
        return section;
    }
    section.method = vec![
        "A logistic model of the preferences (Bradley and Terry 1952), logit P(a over b) = βₐ − β_b, and the \
         same with a sum over the axes for the levels. Its coefficients are of all observers together; \
         \"not sure\" counts as half a choice of each. Observers differ, so standard errors come from \
         leaving out one observer at a time (the linearised jackknife, CR3: Bell and McCaffrey 2002), \
         with Student's t on one degree of freedom less than observers, and all coefficients together are \
         tested by Hotelling's (1931) F. The design effect is the variance with clusters over the variance \
         without: above 1, the pooled tests are too sure of themselves. Where maximum likelihood has no \
         finite coefficients (separated data) they are those of Firth's (1993) penalised likelihood, with \
         the larger of the two standard errors."
            .into(),
    ];
    section.references = vec![
        "Bell, R. M. and McCaffrey, D. F. (2002). Bias reduction in standard errors for linear regression \
         with multi-stage samples. Survey Methodology 28, 169–181.",
        "Bradley, R. A. and Terry, M. E. (1952). Rank analysis of incomplete block designs. I. The method \
         of paired comparisons. Biometrika 39, 324–345.",
        "Firth, D. (1993). Bias reduction of maximum likelihood estimates. Biometrika 80, 27–38.",
        HOLM,
        "Hotelling, H. (1931). The generalization of Student's ratio. Annals of Mathematical Statistics 2, \
         360–378.",
    ];
    section
}

fn sentences(what: &str, model: &ClusteredPreference) -> Vec<String> {
    let n = format!("n = {} observers, {} answers", model.observers, model.trials);
    let mut sentences: Vec<String> = model
        .tests
        .iter()
        .map(|test| match &test.test {
            Ok(f) => format!(
                "{}: F({}, {}) = {:.3}, {} ({n}; upper tail, approximate, observers as clusters)",
                test.of,
                f.df,
                f.df_error,
                f.f,
                f.p.equation()
            ),
            Err(reason) => format!("{}: no test of all together, {reason}", test.of),
        })
        .collect();
    let contrasts: Vec<_> = model.contrasts.iter().flat_map(|c| &c.clustered).collect();
    if !contrasts.is_empty() {
        sentences.push(format!(
            "{what}: {} of {} have p ≤ 0.05 ({n}; two-sided, Student's t with df = {}, corrected by Holm)",
            contrasts.iter().filter(|contrast| contrast.p_holm.value() <= 0.05).count(),
            counted(contrasts.len(), "contrast"),
            model.observers - 1
        ));
    }
    sentences.push(match &model.design_effect {
        Ok(effect) => format!("{what}: mean design effect {effect:.2}"),
        Err(reason) => format!("{what}: design effect not known, {reason}"),
    });
    if model.method == Method::Firth {
        sentences.push(format!(
            "{what}: some were always or never chosen over the others (separated data), so maximum \
             likelihood has no finite coefficients; these are Firth's (1993)"
        ));
    }
    if let Some(reason) = model.contrasts.iter().find_map(|c| c.clustered.as_ref().err()) {
        let alike = model.contrasts.len() - contrasts.len();
        sentences.push(format!("{what}: {} without a test, {reason}", counted(alike, "contrast")));
    }
    if model.not_sure > 0 {
        sentences.push(format!("{} answers \"not sure\" count half for each", model.not_sure));
    }
    sentences
}

fn table(what: &str, model: &ClusteredPreference) -> Table {
    let number = |name: &str, title: &str, description: &str| {
        Column::new(name, title, Kind::Number(3), description)
    };
    Table {
        name: format!("clustered-{what}"),
        caption: format!(
            "Differences in logits between {what}, with observers as clusters. Intervals: 95 %. {} tests.",
            model.contrasts.len()
        ),
        columns: vec![
            Column::new("item", "preferred", Kind::Text, "What is preferred."),
            Column::new("over", "over", Kind::Text, "The other."),
            number("estimate", "logits", "Difference in logits: ln of the odds that it is chosen."),
            number(
                "se_naive",
                "SE, independent",
                "Standard error if all answers were independent.",
            ),
            number("se", "SE, clustered", "Standard error with observers as clusters."),
            number("t", "t", "The estimate in clustered standard errors."),
            Column::new("df", "df", Kind::Integer, "Degrees of freedom of t."),
            Column::new("p", "p", Kind::P, "Two-sided p of t, approximate."),
            Column::new("p_holm", "p (Holm)", Kind::P, "p corrected by Holm (1979)."),
            number("interval_low", "interval", "Lower bound of the 95 % interval of the estimate."),
            number("interval_high", "to", "Upper bound of the 95 % interval of the estimate."),
            number(
                "design_effect",
                "design effect",
                "Variance with clusters over variance without.",
            ),
        ],
        rows: model.contrasts.iter().map(row).collect(),
    }
}

fn row(contrast: &Contrast) -> Vec<Cell> {
    let mut row = vec![
        Cell::from(contrast.item.as_str()),
        contrast.over.as_str().into(),
        contrast.estimate.into(),
        contrast.se_naive.into(),
    ];
    match &contrast.clustered {
        Ok(clustered) => row.extend([
            clustered.se.into(),
            clustered.t.into(),
            clustered.df.into(),
            clustered.p.into(),
            clustered.p_holm.into(),
            clustered.interval_95[0].into(),
            clustered.interval_95[1].into(),
            clustered.design_effect.into(),
        ]),
        Err(_) => row.resize(12, Cell::Missing),
    }
    row
}

fn figure(what: &str, model: &ClusteredPreference) -> Option<Figure> {
    if model.contrasts.len() > MOST_DRAWN {
        return None;
    }
    let rows: Vec<Dot> = model
        .contrasts
        .iter()
        .map(|contrast| Dot {
            label: format!("{} over {}", contrast.item, contrast.over),
            value: Some(contrast.estimate),
            interval: contrast.clustered.as_ref().ok().map(|clustered| clustered.interval_95),
        })
        .collect();
    let ends = rows.iter().flat_map(|dot| dot.interval.into_iter().flatten().chain(dot.value));
    let axis = Axis::of("difference in logits", ends.chain([0.0]));
    Some(Figure {
        name: format!("clustered-{what}"),
        caption: format!(
            "Differences between {what} in logits, with 95 % intervals that allow for observers who \
             differ. The line is at no difference."
        ),
        svg: dots("Preferences with observers as clusters", &axis, &rows, &[0.0]),
    })
}
