//! The heart of a paired comparison in words, tables and figures: votes and groups, pairs, consistency
//! and agreement.

use super::agreement::Agreement;
use super::analysis::{NOT_ASKED, PairedComparison, Source};
use super::consistency::Consistency;
use super::sections::{corrected_cells, corrected_columns};
use super::{figures, sections};
use crate::maths::proportion::Proportion;
use crate::outcome::Outcome;
use crate::report::labels::{common_levels, labels, letters};
use crate::report::section::{
    Cell, Column, Figure, Kind, Section, Table, share_cells, share_columns,
};
use crate::report::{Document, quality};
use crate::scaling;

const SHARES: &str = "Intervals: 95 %, from 0 to 1. Tests against ½: χ² with df = 1, upper tail, no \
                      correction; exact binomial, two-sided.";

/// Votes with groups, pairs, consistency and agreement.
fn heart(analysis: &PairedComparison) -> Vec<Section> {
    let nt = format!("n = {}, t = {}", analysis.observers, analysis.items.len());
    let labels = labels(&analysis.items);
    vec![
        votes(analysis, &nt, &labels),
        pairs(analysis, &labels),
        consistency(&analysis.consistency, &nt),
        agreement(&analysis.agreement, &nt),
    ]
}

fn votes(analysis: &PairedComparison, nt: &str, labels: &[String]) -> Section {
    let groups = match &analysis.grouping {
        Ok(grouping) => format!(
            "R_c = {} votes at α = {} ({nt}; W = {:.4}, studentized range with infinite degrees of \
             freedom, continuity correction ½): {} group{}",
            grouping.r_c,
            grouping.alpha,
            grouping.w,
            grouping.groups.len(),
            if grouping.groups.len() == 1 { "" } else { "s" },
        ),
        Err(reason) => format!("Score differences not known: {reason}"),
    };
    let most = analysis.observers * (analysis.items.len() as u64 - 1);
    let too_few = analysis.grouping.as_ref().is_ok_and(|grouping| grouping.r_c > most).then(|| {
        format!(
            "No two stimuli can be told apart by their votes: with {nt} they differ by {most} at most, \
             less than R_c."
        )
    });
    let equality = match &analysis.score_equality {
        Ok(test) => format!(
            "Equality of the scores: D = {:.3}, df = {}, {} ({nt}; {} tail, χ² approximation, no \
             correction)",
            test.d,
            test.df,
            test.p.equation(),
            test.tail
        ),
        Err(reason) => format!("Equality of the scores not known: {reason}"),
    };
    let mut columns = vec![
        Column::new("item", "stimulus", Kind::Text, "Id of the stimulus."),
        Column::new(
            "groups",
            "groups",
            Kind::Text,
            "Letters of the groups whose votes differ by less than R_c; stimuli that share one are \
             not told apart.",
        ),
    ];
    columns.extend(share_columns());
    columns.extend(corrected_columns());
    let rows = analysis.preference.iter().map(|preference| {
        let groups = analysis.grouping.as_ref();
        let groups = groups.map_or(Cell::Missing, |g| letters(&preference.item, &g.groups).into());
        let mut row = vec![Cell::from(preference.item.as_str()), groups];
        row.extend(share_cells(&preference.proportion));
        row.extend(corrected_cells(&preference.corrected));
        row
    });
    let table = Table {
        name: "stimuli".into(),
        caption: format!(
            "How often each stimulus was chosen. {SHARES} Corrected for {} stimuli.",
            analysis.preference.len()
        ),
        columns,
        rows: rows.collect(),
    };
    let caption = match analysis.grouping {
        Ok(_) => {
            "Votes per stimulus. Brackets join the stimuli of one group: their votes differ by less \
             than the critical difference R_c."
        }
        Err(_) => "Votes per stimulus.",
    };
    Section {
        heading: "Votes and groups".into(),
        sentences: [Some(groups), too_few, Some(equality)].into_iter().flatten().collect(),
        tables: vec![table],
        figures: vec![Figure {
            name: "votes".into(),
            caption: caption.into(),
            svg: figures::votes(analysis, labels),
        }],
        method: vec![
            "Stimuli are grouped by the differences of their votes (David 1988; Starks and David \
             1961): the critical difference R_c is the smallest whole number R with \
             P(W ≥ (2R − ½)/√(n t)) ≤ α, where W is the studentized range of t variables with \
             infinite degrees of freedom (Pearson and Hartley 1966), computed here by quadrature. A \
             group is a maximal run of the ordered stimuli whose votes differ by less than R_c; \
             groups may overlap. The level holds if every answer is independent; where observers have \
             tastes of their own, more than a share α of studies without a common preference shows \
             groups, and the tests with observers as clusters decide. Navarro (2012) analysed motion-blurred stimuli in this way. \
             Intervals of percentages are those of Wilson (1927) and of Clopper and Pearson (1934). \
             p-values of a table are given as they are and corrected for their number by Holm (1979) \
             and by Benjamini and Hochberg (1995)."
                .into(),
        ],
        references: vec![
            sections::BENJAMINI_HOCHBERG,
            "Clopper, C. J. and Pearson, E. S. (1934). The use of confidence or fiducial limits \
             illustrated in the case of the binomial. Biometrika 26, 404–413.",
            "David, H. A. (1988). The Method of Paired Comparisons, 2nd edition. Griffin, London.",
            sections::HOLM,
            "Navarro, F. (2012). PhD thesis; part III, perception of motion blur.",
            "Pearson, E. S. and Hartley, H. O. (1966). Biometrika Tables for Statisticians, vol. 1, \
             3rd edition. Cambridge University Press.",
            "Starks, T. H. and David, H. A. (1961). Significance tests for paired-comparison \
             experiments. Biometrika 48, 95–108.",
            "Wilson, E. B. (1927). Probable inference, the law of succession, and statistical \
             inference. Journal of the American Statistical Association 22, 209–212.",
        ],
    }
}

fn pairs(analysis: &PairedComparison, labels: &[String]) -> Section {
    let heading = "Preferences per pair".into();
    let (Ok(pairs), Ok(matrix)) = (&analysis.pairs, &analysis.matrix) else {
        let reason = analysis.pairs.as_ref().err().map_or("", String::as_str);
        let sentences = vec![format!("Preferences per pair not known: {reason}")];
        return Section { heading, sentences, ..Section::default() };
    };
    let mut columns = vec![
        Column::new(
            "item",
            "stimulus",
            Kind::Text,
            "Id of the stimulus with more votes over all pairs.",
        ),
        Column::new("over", "over", Kind::Text, "Id of the other."),
    ];
    columns.extend(share_columns());
    columns.extend(corrected_columns());
    let rows = pairs.iter().map(|pair| {
        let mut row = vec![Cell::from(pair.item.as_str()), pair.over.as_str().into()];
        row.extend(share_cells(&pair.proportion));
        row.extend(corrected_cells(&pair.corrected));
        row
    });
    let per_pair = Table {
        name: "pairs".into(),
        caption: format!(
            "How often the first was chosen over the second. {SHARES} Corrected for {} pairs.",
            pairs.len()
        ),
        columns,
        rows: rows.collect(),
    };
    let mut columns = vec![Column::new(
        "chosen over",
        "chosen over",
        Kind::Text,
        "Id of the stimulus that was chosen.",
    )];
    columns.extend(analysis.items.iter().zip(labels).map(|(item, label)| {
        let description = format!("How often it was chosen over {item}.");
        Column::new(item, label, Kind::Integer, &description)
    }));
    let rows = analysis.items.iter().zip(matrix).map(|(item, counts)| {
        let mut row = vec![Cell::from(item.as_str())];
        row.extend(counts.iter().map(|count| Cell::from(*count)));
        row
    });
    let matrix_table = Table {
        name: "matrix".into(),
        caption: "How often the stimulus of the row was chosen over that of the column.".into(),
        columns,
        rows: rows.collect(),
    };
    Section {
        heading,
        tables: vec![per_pair, matrix_table],
        figures: vec![Figure {
            name: "matrix".into(),
            caption: "How often the stimulus of the row was chosen over that of the column. Blue: \
                      more often than not; orange: less often; white: as often."
                .into(),
            svg: figures::matrix(matrix, labels),
        }],
        ..Section::default()
    }
}

fn consistency(consistency: &Outcome<Consistency>, nt: &str) -> Section {
    let heading = "Consistency".into();
    let consistency = match consistency {
        Ok(consistency) => consistency,
        Err(reason) => {
            let sentences = vec![format!("Consistency of the observers not known: {reason}")];
            return Section { heading, sentences, ..Section::default() };
        }
    };
    let rows = consistency.per_observer.iter().map(|observer| {
        vec![
            Cell::from(observer.subject.as_str()),
            u64::from(observer.session).into(),
            u64::from(observer.repetition).into(),
            observer.circular_triads.into(),
            observer.zeta.into(),
            observer.test.p.into(),
            observer.test.exact.into(),
            observer.test.chi2.into(),
            observer.test.df.into(),
            observer.test.p_chi2.into(),
        ]
    });
    let table = Table {
        name: "observers".into(),
        caption: format!("Circular triads and ζ of each observer; p: {}.", consistency.tail),
        columns: vec![
            Column::new("subject", "subject", Kind::Text, "The participant's code."),
            Column::new("session", "session", Kind::Integer, "The participant's sitting, from 1."),
            Column::new(
                "repetition",
                "repetition",
                Kind::Integer,
                "Which of the sitting's sets of pairs, from 1.",
            ),
            Column::new(
                "circular_triads",
                "circular triads",
                Kind::Integer,
                "Number d of circular triads.",
            ),
            Column::new("zeta", "ζ", Kind::Number(4), "Kendall's coefficient of consistency."),
            Column::new("p", "p", Kind::P, "Probability of so few circular triads by chance."),
            Column::new("exact", "exact", Kind::Flag, "Whether p is exact; else it is p_chi2."),
            Column::new(
                "chi2",
                "χ²",
                Kind::Number(2),
                "χ² of the circular triads with continuity correction −½; large for few of them.",
            ),
            Column::new("df", "df", Kind::Number(2), "Degrees of freedom of χ²; not whole."),
            Column::new("p_chi2", "p of χ²", Kind::P, "Upper tail of χ², approximate."),
        ],
        rows: rows.collect(),
    };
    Section {
        heading,
        sentences: consistency_sentences(consistency, nt),
        tables: vec![table],
        figures: vec![Figure {
            name: "consistency".into(),
            caption: "Coefficient of consistency ζ of each observer: 1 without circular triads, 0 \
                      with as many as there can be."
                .into(),
            svg: figures::zeta(consistency),
        }],
        method: vec![
            "A judge is one complete set of pairs. An observer who prefers X to Y, Y to Z and Z to X \
             has made a circular triad; their number d gives the coefficient of consistency \
             ζ = 1 − d/d_max (Kendall and Babington Smith 1940). It is tested against its exact \
             distribution under random choice for up to 10 stimuli, and by Kendall's χ² from 5 on."
                .into(),
        ],
        references: vec![KENDALL],
    }
}

const KENDALL: &str = "Kendall, M. G. and Babington Smith, B. (1940). On the method of paired \
                       comparisons. Biometrika 31, 324–345.";

fn consistency_sentences(consistency: &Consistency, nt: &str) -> Vec<String> {
    let test = &consistency.test;
    let mut lines = vec![format!(
        "ζ = {:.4} pooled over all observers ({:.4} as the mean of theirs): {} circular triads of \
         at most {} ({nt})",
        consistency.zeta,
        consistency.zeta_mean,
        consistency.circular_triads,
        consistency.max_circular_triads,
    )];
    if test.exact {
        lines.push(format!("{} ({nt}; {}, exact)", test.p.equation(), consistency.tail));
    }
    match (test.chi2, test.df, test.p_chi2) {
        (Some(chi2), Some(df), Some(p)) => lines.push(format!(
            "χ² = {chi2:.3}, df = {df:.3}, {} ({nt}; upper tail, χ² approximation, continuity \
             correction −½)",
            p.equation()
        )),
        _ => lines.extend(consistency.chi2_reason.clone()),
    }
    lines.push(match &consistency.per_observer_not_testable {
        Some(reason) => format!("observer by observer {reason}"),
        None => {
            let observers = &consistency.per_observer;
            let p = |p: f64| observers.iter().filter(|o| o.test.p.value() <= p).count();
            format!(
                "observer by observer ({}; {}, {}): {} of {} have p ≤ 0.05, {} have p ≤ 0.01",
                nt.replace(&format!("n = {}", observers.len()), "n = 1"),
                consistency.tail,
                match test.exact {
                    true => "exact",
                    false => "χ² approximation with continuity correction −½",
                },
                p(0.05),
                observers.len(),
                p(0.01),
            )
        }
    });
    lines
}

fn agreement(agreement: &Outcome<Agreement>, nt: &str) -> Section {
    let sentences = match agreement {
        Ok(agreement) => agreement_sentences(agreement, nt),
        Err(reason) => vec![format!("Agreement of the observers not known: {reason}")],
    };
    Section {
        heading: "Agreement".into(),
        sentences,
        method: vec![
            "Agreement among the observers is the coefficient u of Kendall and Babington Smith \
             (1940), with its χ² test with and without continuity correction, and its exact \
             distribution under random choice by convolution over the pairs."
                .into(),
        ],
        references: vec![KENDALL],
        ..Section::default()
    }
}

fn agreement_sentences(agreement: &Agreement, nt: &str) -> Vec<String> {
    let not_known = |reason: &Option<String>| {
        format!("not known: {}", reason.as_deref().unwrap_or("no reason given"))
    };
    let mut lines =
        vec![format!("u = {:.4} (from {:.4} to 1; {nt})", agreement.u, agreement.u_min)];
    match (agreement.chi2, agreement.df, agreement.p) {
        (Some(chi2), Some(df), Some(p)) => lines.push(format!(
            "χ² = {chi2:.3}, df = {df:.3}, {} ({nt}; upper tail, χ² approximation, no correction)",
            p.equation()
        )),
        _ => lines.push(not_known(&agreement.chi2_reason)),
    }
    if let (Some(chi2), Some(df), Some(p)) =
        (agreement.chi2_corrected, agreement.df, agreement.p_corrected)
    {
        lines.push(format!(
            "χ² = {chi2:.3}, df = {df:.3}, {} ({nt}; upper tail, χ² approximation, continuity \
             correction: 1 subtracted from Σ)",
            p.equation()
        ));
    }
    lines.push(match agreement.p_exact {
        Some(p) => format!("Σ = {}, {} ({nt}; upper tail, exact)", agreement.sigma, p.equation()),
        None => not_known(&agreement.p_exact_reason),
    });
    lines
}

/// The ranking for the terminal: votes, percentages and groups.
fn ranking(analysis: &PairedComparison) -> String {
    let labels = labels(&analysis.items);
    let width = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0).max(8);
    let mut lines =
        vec![format!("rank  {:width$}  votes  percent  95 % interval   groups", "stimulus")];
    for (rank, preference) in analysis.preference.iter().enumerate() {
        let place = analysis.items.iter().position(|item| *item == preference.item);
        let label = place.map_or("", |place| labels[place].as_str());
        let groups = analysis.grouping.as_ref();
        let groups = groups.map_or("–".into(), |g| letters(&preference.item, &g.groups));
        let Proportion { chosen, percent, wilson_95, .. } = preference.proportion;
        let [low, high] = wilson_95.map(|bound| 100.0 * bound);
        lines.push(format!(
            "{:>4}  {label:width$}  {chosen:>5}  {percent:>7.1}  {low:>5.1} to {high:>5.1}  {groups}",
            rank + 1
        ));
    }
    lines.push("\nStimuli that share a letter are one group. Intervals are Wilson's.".into());
    lines.join("\n")
}

impl PairedComparison {
    /// The analysis for people.
    pub fn document(&self) -> Document {
        let labels = labels(&self.items);
        let common = common_levels(&self.items);
        let all = if common.is_empty() { common } else { format!(", all {common}") };
        let t = self.items.len();
        let mut design = vec![
            ("Task".into(), "two-alternative forced choice between pairs of stimuli".into()),
            ("Stimuli".into(), format!("t = {t}{all}")),
            ("Observers".into(), format!("n = {}", self.observers)),
            ("Trials".into(), self.trials.to_string()),
            (
                "Analysed from".into(),
                match self.source {
                    Source::Responses => "the answers to single trials",
                    Source::Matrix => "a preference matrix of all observers together",
                    Source::Votes => "a table of votes",
                }
                .into(),
            ),
        ];
        design.extend(self.data_quality.iter().flat_map(Document::design_of));
        let stimuli = self.items.iter().zip(&labels).zip(&self.votes);
        let mut all_sections = vec![quality::section(&self.data_quality)];
        all_sections.extend(heart(self));
        if self.level_check != Err(NOT_ASKED.into()) {
            all_sections.push(sections::level_check(&self.level_check));
        }
        all_sections.extend([
            sections::concordance(&self.friedman),
            sections::transitivity(&self.transitivity),
            scaling::section::section(&self.scaling),
            sections::levels(&self.levels),
            sections::clustered(&self.clustered_items, &self.clustered_levels),
            sections::equivalence(&self.equivalence),
            sections::order_effects(&self.order_effects),
            sections::observer_groups(&self.observer_groups),
        ]);
        Document {
            lead: format!(
                "Paired comparison of t = {t} stimuli{all} by n = {} observer{}: {} trials",
                self.observers,
                if self.observers == 1 { "" } else { "s" },
                self.trials
            ),
            simulated: self.simulated == Ok(true),
            questions: match &self.data_quality {
                Ok(data) => Ok(data.questions.clone()),
                Err(reason) => Err(reason.clone()),
            },
            design,
            stimuli: stimuli
                .map(|((id, label), votes)| (id.clone(), format!("{label}: {votes} votes")))
                .collect(),
            summary: ranking(self),
            sections: all_sections,
            notes: self.notes.clone(),
        }
    }
}
