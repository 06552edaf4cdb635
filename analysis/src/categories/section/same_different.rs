//! Same/different in words, tables and figures.

use super::method::{REFERENCES, TIMES_METHOD, observers_method};
use super::sentences::{SIMULATED, accuracy, agreement, d_prime, habits, reasons, times};
use super::tables::{
    column, comparisons_table, d_prime_cells, d_prime_columns, no_d_prime, times_table,
};
use crate::categories::SameDifferent;
use crate::categories::discrimination::Strategy;
use crate::categories::same_different::Candidate;
use crate::report::labels::counted;
use crate::report::plot::{Axis, Dot, dots};
use crate::report::section::{Cell, Figure, Kind, Section, Table, ZHANG};

pub(super) fn section(study: &SameDifferent) -> Section {
    let mut references = REFERENCES.to_vec();
    references.extend([
        "Fisher, R. A. (1935). The logic of inductive inference. Journal of the Royal Statistical Society \
         98, 39–82.",
        ZHANG,
    ]);
    // Runs of answers are looked at in matching only.
    references.retain(|reference| !reference.starts_with("Wald"));
    references.sort_unstable();
    Section {
        heading: String::new(),
        sentences: sentences(study),
        tables: vec![
            confusion(study),
            discrimination(study),
            times_table(&study.response_times),
            comparisons_table(&study.comparisons),
        ],
        figures: vec![figure(study)],
        method: vec![
            "\"Different\" is a hit where the two stimuli differ and a false alarm where they are identical; \
             the false alarms of a candidate are those of its own ground truth. A candidate is told from \
             its ground truth if it is called different more often, by Fisher's (1935) exact test, corrected \
             by Holm (1979). The task is that of Zhang et al. (2014, Appendix A), whose ratings count \
             \"the same\" alone and cannot tell seeing a difference from always saying so. κ is Cohen's \
             (1960; standard error of Fleiss, Cohen and Everitt 1969), information that of Miller (1955)."
                .into(),
            "d′ follows from the two models of same/different (Macmillan and Creelman 2005, ch. 9; Kaplan, \
             Macmillan and Creelman 1978). Candidates change from trial to trial, for which differencing is \
             the model; independent observations assume one fixed pair, of which all four orders are shown. \
             Shares of 0 and 1 are corrected in the estimates (Hautus 1995), not in the intervals, which are \
             by likelihood (Venzon and Moolgavkar 1988)."
                .into(),
            observers_method(),
            TIMES_METHOD.into(),
        ],
        references,
    }
}

fn sentences(study: &SameDifferent) -> Vec<String> {
    let mut lines: Vec<String> = study.simulated.then(|| SIMULATED.into()).into_iter().collect();
    lines.extend(accuracy(&study.accuracy));
    if let Ok(answers) = &study.answers {
        let different = answers.counts[1].iter().sum::<u64>() as f64;
        lines.push(format!(
            "Chance is that of a coin: whoever always says \"different\" is right in {:.1} %.",
            100.0 * different / answers.accuracy.trials as f64
        ));
    }
    lines.extend(told_apart(study));
    lines.extend(agreement("Stimuli (identical or different) and answers", &study.answers));
    lines.push(d_prime("All candidates taken for one, differencing", &study.d_prime));
    lines.push(d_prime(
        "All candidates taken for one, independent observations",
        &study.d_prime_independent,
    ));
    let missing = study.candidates.iter().flat_map(|candidate| {
        both(candidate).map(|(_, d)| match d {
            Ok(d) => d.estimate.se.as_ref().err().or(d.bootstrap_95.as_ref().err()).cloned(),
            Err(reason) => Some(reason.clone()),
        })
    });
    lines.extend(reasons("discrimination", missing.flatten()));
    lines.extend(times(&study.response_times, &study.comparisons));
    lines.extend(habits(study.undecided, study.too_fast, &study.lapses));
    lines
}

type Estimate = crate::outcome::Outcome<
    crate::categories::resampled::Resampled<crate::categories::discrimination::DPrime>,
>;

fn both(candidate: &Candidate) -> [(Strategy, &Estimate); 2] {
    [
        (Strategy::Differencing, &candidate.d_prime),
        (Strategy::IndependentObservations, &candidate.d_prime_independent),
    ]
}

fn told_apart(study: &SameDifferent) -> Vec<String> {
    let tested = study.candidates.iter().filter(|candidate| candidate.told_apart.is_some()).count();
    let apart = study.candidates.iter().filter(|candidate| candidate.told_apart == Some(true));
    let mut lines = vec![format!(
        "Candidates told from their ground truth: {} of {tested} (Fisher's exact test of \"different\" \
         against the false alarms, upper tail, Holm's correction for {}, α = {}).",
        apart.count(),
        counted(tested, "candidate"),
        study.alpha
    )];
    let not: Vec<String> = study
        .candidates
        .iter()
        .filter(|candidate| candidate.told_apart == Some(false))
        .map(|candidate| {
            let counts = &candidate.counts;
            format!(
                "{} from {} (\"different\" {} of {}, false alarms {} of {})",
                candidate.candidate,
                candidate.reference,
                counts.hits,
                counts.signals,
                counts.false_alarms,
                counts.noises
            )
        })
        .collect();
    if !not.is_empty() {
        lines.push(format!(
            "Not told apart: {}. That does not show that they look the same: the interval of d′ says which \
             difference remains possible.",
            not.join(", ")
        ));
    }
    let untested = study.candidates.iter().filter_map(|candidate| {
        let reason = candidate.p.as_ref().err()?;
        Some(format!("{} from {}: {reason}", candidate.candidate, candidate.reference))
    });
    lines.extend(reasons("confusion", untested));
    lines
}

fn confusion(study: &SameDifferent) -> Table {
    let rows = study.candidates.iter().map(|candidate| {
        let share = &candidate.called_different;
        vec![
            candidate.candidate.as_str().into(),
            candidate.reference.as_str().into(),
            share.chosen.into(),
            share.trials.into(),
            share.percent.into(),
            share.wilson_95[0].into(),
            share.wilson_95[1].into(),
            share.clopper_pearson_95[0].into(),
            share.clopper_pearson_95[1].into(),
            candidate.counts.false_alarms.into(),
            candidate.counts.noises.into(),
            candidate.p.as_ref().ok().copied().into(),
            candidate.p_holm.into(),
            candidate.told_apart.into(),
        ]
    });
    Table {
        name: "confusion".into(),
        caption: format!(
            "How often each candidate was called different from its ground truth, and the ground truth from \
             itself; α = {}.",
            study.alpha
        ),
        columns: vec![
            column("candidate", "candidate", Kind::Text, "Level of the candidate."),
            column("reference", "ground truth", Kind::Text, "Level of the ground truth."),
            column("hits", "different", Kind::Integer, "Answers \"different\" to the two."),
            column("signals", "of", Kind::Integer, "Answers to the two."),
            column("percent", "%", Kind::Number(1), "Answers \"different\" in percent."),
            column(
                "wilson_95_low",
                "Wilson",
                Kind::Number(3),
                "Lower bound of Wilson's 95 % interval.",
            ),
            column("wilson_95_high", "to", Kind::Number(3), "Upper bound of it."),
            column(
                "clopper_pearson_95_low",
                "Clopper–Pearson",
                Kind::Number(3),
                "Lower bound of Clopper and Pearson's exact 95 % interval.",
            ),
            column("clopper_pearson_95_high", "to", Kind::Number(3), "Upper bound of it."),
            column(
                "false_alarms",
                "false alarms",
                Kind::Integer,
                "Answers \"different\" to the ground truth beside itself.",
            ),
            column("noises", "of", Kind::Integer, "Answers to the ground truth beside itself."),
            column("p", "p (exact)", Kind::P, "Fisher's exact test of the two shares, upper tail."),
            column("p_holm", "p (Holm)", Kind::P, "Corrected for the candidates that were tested."),
            column("told_apart", "told apart", Kind::Flag, "Whether p_holm is at most α."),
        ],
        rows: rows.collect(),
    }
}

fn discrimination(study: &SameDifferent) -> Table {
    let mut columns = vec![
        column("candidate", "candidate", Kind::Text, "Level of the candidate."),
        column("reference", "ground truth", Kind::Text, "Level of the ground truth."),
    ];
    columns.extend(d_prime_columns());
    columns.extend([
        column(
            "criterion",
            "criterion",
            Kind::Number(2),
            "By differencing k, the difference, in the unit of d′, from which on two stimuli are called \
             different; else c = −½(z(H) + z(F)), negative for more \"different\".",
        ),
        column(
            "ln_beta",
            "ln β",
            Kind::Number(2),
            "Logarithm of the ratio of likelihoods at the criterion.",
        ),
    ]);
    let rows = study.candidates.iter().flat_map(|candidate| {
        both(candidate).map(|(strategy, d)| {
            let mut row =
                vec![Cell::from(candidate.candidate.as_str()), candidate.reference.as_str().into()];
            match d {
                Err(_) => {
                    row.extend(no_d_prime(strategy));
                    row.extend([Cell::Missing, Cell::Missing]);
                }
                Ok(d) => {
                    let e = &d.estimate;
                    let (interval, bootstrap) = (e.interval_95, &d.bootstrap_95);
                    let cells = d_prime_cells(
                        strategy,
                        e.d_prime,
                        interval,
                        &e.se,
                        bootstrap,
                        e.correction,
                    );
                    row.extend(cells);
                    row.extend([e.criterion.into(), e.ln_beta.into()]);
                }
            }
            row
        })
    });
    Table {
        name: "discrimination".into(),
        caption: "d′ and criterion of each candidate and its ground truth.".into(),
        columns,
        rows: rows.collect(),
    }
}

fn figure(study: &SameDifferent) -> Figure {
    let rows: Vec<Dot> = study
        .candidates
        .iter()
        .map(|candidate| Dot {
            label: format!("{} – {}", candidate.candidate, candidate.reference),
            value: Some(candidate.called_different.percent),
            interval: Some(candidate.called_different.clopper_pearson_95.map(|end| 100.0 * end)),
        })
        .collect();
    let false_alarms =
        study.d_prime.as_ref().ok().map(|d| {
            100.0 * d.estimate.counts.false_alarms as f64 / d.estimate.counts.noises as f64
        });
    let axis =
        Axis { title: "called different, %".into(), range: [0.0, 100.0], logarithmic: false };
    let rules: Vec<f64> = false_alarms.into_iter().collect();
    Figure {
        name: "called-different".into(),
        caption: "How often each candidate was called different from its ground truth, with exact 95 % \
                  intervals (Clopper and Pearson); the dotted line, if there is one, is the share of false \
                  alarms over all identical pairs."
            .into(),
        svg: dots("How often candidates were called different", &axis, &rows, &rules),
    }
}
