//! The report as one HTML page: styles and figures inside, no script, nothing from outside.

use super::labels::{common_levels, labels, letters};
use super::sentences::sentences;
use super::{ReportContext, figures};
use crate::analysis::{Analysis, Source};
use crate::data_quality::DataQuality;
use crate::preference::Proportion;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The report on `analysis`.
pub fn html(analysis: &Analysis, context: &ReportContext) -> String {
    let labels = labels(&analysis.items);
    let simulated = analysis.simulated == Some(true);
    let title = match simulated {
        true => format!("Simulated observers: {}", context.title),
        false => context.title.to_string(),
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                h1 { (title) }
                p.lead { "Paired comparison of " (analysis.items.len()) " stimuli by "
                    (analysis.observers) " observers" }
                @if simulated {
                    p.simulated { "The observers are simulated. This report checks the tool; it is no "
                        "finding about people." }
                }
                (question(analysis))
                (design(analysis))
                (data_quality(analysis))
                (results(analysis, context, &labels, simulated))
                (statistics(analysis))
                (pairs(analysis, &labels))
                (method())
                h2 { "Notes" }
                ul { @for note in &analysis.notes { li { (note) } } }
                h2 { "How this report was made" }
                dl {
                    dt { "Command" } dd { code { (context.command) } }
                    dt { "Version" } dd { (context.version) }
                }
            }
        }
    };
    page.into_string()
}

fn question(analysis: &Analysis) -> Markup {
    html! {
        h2 { "Question" }
        @match &analysis.data_quality {
            Some(data) => blockquote { (data.question) },
            None => p { (not_known(&analysis.data_quality_reason)) },
        }
    }
}

fn design(analysis: &Analysis) -> Markup {
    let common = common_levels(&analysis.items);
    html! {
        h2 { "Design" }
        dl {
            dt { "Task" } dd { "two-alternative forced choice, every pair of stimuli" }
            dt { "Stimuli" } dd { "t = " (analysis.items.len())
                @if !common.is_empty() { "; all have " (common) ", which the labels leave out" } }
            dt { "Observers" } dd { "n = " (analysis.observers)
                @if let Some(data) = &analysis.data_quality {
                    " complete sets of pairs from " (data.subjects) " subjects ("
                    (data.observers.join(", ")) ")" } }
            dt { "Trials" } dd { (analysis.trials) }
            dt { "Analysed from" } dd { (match analysis.source {
                Source::Responses => "the answers to single trials",
                Source::Matrix => "a preference matrix of all observers together",
                Source::Votes => "a table of votes",
            }) }
            @if let Some(data) = &analysis.data_quality {
                dt { "Study" } dd { (data.study) }
                dt { "Display" } dd { (data.displays.join("; ")) }
                dt { "Sessions run by" } dd { "version " (data.program_versions.join(", ")) }
            }
        }
    }
}

fn data_quality(analysis: &Analysis) -> Markup {
    html! {
        h2 { "Data quality" }
        @match &analysis.data_quality {
            Some(data) => (quality_list(data, analysis.trials)),
            None => p { (not_known(&analysis.data_quality_reason)) },
        }
    }
}

fn quality_list(data: &DataQuality, trials: u64) -> Markup {
    let of_trials = |count: u64| format!("{count} of {trials} trials");
    let first = &data.first_chosen;
    html! {
        dl {
            dt { "Left out" } dd {
                (data.excluded.practice) " practice trials, " (data.excluded.catch) " catch trials, " (data.excluded.pilot) " pilot trials, "
                (data.excluded.incomplete_sets) " trials of incomplete sets of pairs" }
            dt { "Late frames" } dd {
                (data.late_frames) ", in " (of_trials(data.trials_with_late_frames)) }
            dt { "Replays" } dd { (data.replays) ", in " (of_trials(data.trials_with_replays)) }
            dt { "Response time" } dd {
                "median " (seconds(data.response_time_s.median)) " s, quartiles "
                (seconds(data.response_time_s.first)) " s and "
                (seconds(data.response_time_s.third)) " s" }
            dt { "Side bias" } dd {
                "the sequence shown first was chosen in " (first.chosen) " of " (first.trials)
                " trials, " (percent(first)) " % (95 % interval " (interval(first.wilson_95))
                ", Wilson); exact binomial test against ½, two-sided, n = " (first.trials) ": "
                (first.p_binomial.equation()) }
        }
    }
}

fn results(
    analysis: &Analysis,
    context: &ReportContext,
    labels: &[String],
    simulated: bool,
) -> Markup {
    let mut number = 0;
    let mut caption = |text: &str| {
        number += 1;
        let prefix = if simulated { "Simulated observers. " } else { "" };
        html! { figcaption { b { "Figure " (number) ". " } (prefix) (symbols(text)) } }
    };
    html! {
        h2 { "Results" }
        @if analysis.items.iter().any(|item| context.thumbnails.contains_key(item)) {
            figure {
                div.stimuli {
                    @for ((item, label), votes) in analysis.items.iter().zip(labels).zip(&analysis.votes) {
                        div {
                            @if let Some(png) = context.thumbnails.get(item) {
                                img src=(format!("data:image/png;base64,{}", STANDARD.encode(png))) alt=(label);
                            }
                            span { (label) ": " (votes) " votes" }
                        }
                    }
                }
                (caption("The stimuli, from most to least chosen."))
            }
        }
        figure {
            (figures::votes(analysis, labels))
            (caption(match analysis.grouping {
                Some(_) => "Votes per stimulus. Brackets join the stimuli of one group: their votes \
                            differ by less than the critical difference R_c.",
                None => "Votes per stimulus.",
            }))
        }
        (preference_table(analysis, labels))
        @match &analysis.matrix {
            Some(matrix) => figure {
                (figures::matrix(matrix, labels))
                (caption("How often the stimulus of the row was chosen over that of the column. \
                          Blue: more often than not; orange: less often; white: as often."))
            },
            None => p { "Preference matrix " (not_known(&analysis.pairs_reason)) "." },
        }
        @match &analysis.consistency {
            Some(consistency) => figure {
                (figures::zeta(consistency))
                (caption("Coefficient of consistency ζ of each observer: 1 without circular triads, \
                          0 with as many as there can be."))
            },
            None => p { "Consistency of the observers " (not_known(&analysis.consistency_reason)) "." },
        }
    }
}

fn preference_table(analysis: &Analysis, labels: &[String]) -> Markup {
    html! {
        table {
            caption { "How often each stimulus was chosen. Intervals: 95 %, in percent. Tests against ½: \
                       χ² with df = 1, upper tail, no correction; exact binomial, two-sided." }
            thead { tr {
                th { "stimulus" } th { "votes" } th { "of" } th { "%" } th { "Wilson" }
                th { "Clopper–Pearson" } th { "χ²" } th { "p (χ²)" } th { "p (exact)" } th.word { "groups" }
            } }
            tbody {
                @for (label, preference) in labels.iter().zip(&analysis.preference) {
                    tr {
                        td { (label) }
                        (share_cells(&preference.proportion))
                        td.word { @if let Some(grouping) = &analysis.grouping {
                            (letters(&preference.item, &grouping.groups)) } }
                    }
                }
            }
        }
    }
}

fn statistics(analysis: &Analysis) -> Markup {
    html! {
        h2 { "Statistics" }
        dl {
            @for sentence in sentences(analysis) {
                dt { (sentence.name) }
                dd { @for result in &sentence.results { p { (symbols(result)) } } }
            }
        }
    }
}

fn pairs(analysis: &Analysis, labels: &[String]) -> Markup {
    let label = |item: &String| {
        let place = analysis.items.iter().position(|other| other == item);
        place.map_or_else(|| item.clone(), |place| labels[place].clone())
    };
    html! {
        h2 { "Preferences per pair" }
        @match &analysis.pairs {
            Some(pairs) => table {
                caption { "How often the first was chosen over the second. Intervals: 95 %, in percent. \
                           Tests against ½: χ² with df = 1, upper tail, no correction; exact binomial, \
                           two-sided. " (pairs.len()) " pairs, not corrected for their number." }
                thead { tr {
                    th { "pair" } th { "chosen" } th { "of" } th { "%" } th { "Wilson" }
                    th { "Clopper–Pearson" } th { "χ²" } th { "p (χ²)" } th { "p (exact)" }
                } }
                tbody {
                    @for pair in pairs {
                        tr {
                            td { (label(&pair.item)) " over " (label(&pair.over)) }
                            (share_cells(&pair.proportion))
                        }
                    }
                }
            },
            None => p { (not_known(&analysis.pairs_reason)) },
        }
    }
}

fn method() -> Markup {
    html! {
        h2 { "Method" }
        p { (symbols("A judge is one complete set of pairs. An observer who prefers X to Y, Y to Z and Z to X has \
             made a circular triad; their number d gives the coefficient of consistency ζ = 1 − d/d_max \
             (Kendall and Babington Smith 1940). It is tested against its exact distribution under random \
             choice for up to 10 stimuli, and by Kendall's χ² above. Agreement among the observers is the \
             coefficient u of the same authors, with its χ² test with and without continuity correction, \
             and its exact distribution under random choice by convolution over the pairs.")) }
        p { (symbols("Stimuli are grouped by the differences of their votes (David 1988; Starks and David 1961): the \
             critical difference R_c is the smallest whole number R with \
             P(W ≥ (2R − ½)/√(n t)) ≤ α, where W is the studentized range of t variables with infinite \
             degrees of freedom (Pearson and Hartley 1966), computed here by quadrature. A group is a \
             maximal run of the ordered stimuli whose votes differ by less than R_c; groups may overlap. \
             Navarro (2012) analysed motion-blurred stimuli in this way. Intervals of percentages are \
             those of Wilson (1927) and of Clopper and Pearson (1934).")) }
        ul.references {
            li { "Clopper, C. J. and Pearson, E. S. (1934). The use of confidence or fiducial limits \
                  illustrated in the case of the binomial. Biometrika 26, 404–413." }
            li { "David, H. A. (1988). The Method of Paired Comparisons, 2nd edition. Griffin, London." }
            li { "Kendall, M. G. and Babington Smith, B. (1940). On the method of paired comparisons. \
                  Biometrika 31, 324–345." }
            li { "Navarro, F. (2012). PhD thesis; part III, perception of motion blur." }
            li { "Pearson, E. S. and Hartley, H. O. (1966). Biometrika Tables for Statisticians, vol. 1, \
                  3rd edition. Cambridge University Press." }
            li { "Starks, T. H. and David, H. A. (1961). Significance tests for paired-comparison \
                  experiments. Biometrika 48, 95–108." }
            li { "Wilson, E. B. (1927). Probable inference, the law of succession, and statistical \
                  inference. Journal of the American Statistical Association 22, 209–212." }
        }
    }
}

/// Chosen, trials, percent, both intervals, χ² and both p.
fn share_cells(share: &Proportion) -> Markup {
    html! {
        td { (share.chosen) } td { (share.trials) } td { (percent(share)) }
        td { (interval(share.wilson_95)) } td { (interval(share.clopper_pearson_95)) }
        td { (format!("{:.2}", share.chi2)) } td { (share.p_chi2) } td { (share.p_binomial) }
    }
}

fn percent(share: &Proportion) -> String {
    format!("{:.1}", share.percent)
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("{:.1} to {:.1}", 100.0 * low, 100.0 * high)
}

fn seconds(seconds: f64) -> String {
    format!("{seconds:.2}")
}

/// `text` with the symbols R_c and d_max set with their subscripts.
fn symbols(text: &str) -> Markup {
    let set = |symbol: &str, base: &str, subscript: &str, text: &str| {
        text.replace(symbol, &format!("{base}<sub>{subscript}</sub>"))
    };
    // Escaped first; neither symbol holds a character that escaping changes.
    let escaped = html! { (text) }.into_string();
    PreEscaped(set("d_max", "d", "max", &set("R_c", "R", "c", &escaped)))
}

fn not_known(reason: &Option<String>) -> String {
    format!("not known: {}", reason.as_deref().unwrap_or("no reason given"))
}
