//! Data quality in words: what was left out, how the frames came, how people answered.

use super::labels::counted;
use super::section::Section;
use crate::input::data_quality::{Catch, DataQuality};
use crate::outcome::Outcome;

/// The section on data quality; `data` says why there is none.
pub fn section(data: &Outcome<DataQuality>) -> Section {
    Section {
        heading: "Data quality".into(),
        sentences: match data {
            Ok(data) => sentences(data),
            Err(reason) => vec![format!("Not known: {reason}")],
        },
        ..Section::default()
    }
}

fn sentences(data: &DataQuality) -> Vec<String> {
    let left_out = &data.excluded;
    let of_trials = |count: u64| format!("{count} of {}", counted(data.trials as usize, "trial"));
    let seconds = &data.response_time_s;
    let mut lines = vec![
        format!(
            "Left out: {}, {}, {} and {} of incomplete sets of pairs.",
            counted(left_out.practice as usize, "practice trial"),
            counted(left_out.catch as usize, "catch trial"),
            counted(left_out.pilot as usize, "pilot trial"),
            counted(left_out.incomplete_sets as usize, "trial"),
        ),
        format!(
            "Frames shown late or never: {}, in {}.",
            data.late_frames,
            of_trials(data.trials_with_late_frames)
        ),
        match data.display_faults.is_empty() {
            true => "Displays: no check found a fault.".into(),
            false => {
                let faults = data.display_faults.iter();
                let faults =
                    faults.map(|(fault, trials)| format!("{fault} ({})", of_trials(*trials)));
                format!("Displays: {}.", faults.collect::<Vec<_>>().join("; "))
            }
        },
        format!("Replays: {}, in {}.", data.replays, of_trials(data.trials_with_replays)),
        format!(
            "Response time: median {:.2} s, quartiles {:.2} s and {:.2} s; {} came before the last \
             interval had been shown once.",
            seconds.median,
            seconds.first,
            seconds.third,
            counted(data.early_answers as usize, "answer"),
        ),
    ];
    if let Some(first) = &data.first_chosen {
        let [low, high] = first.wilson_95.map(|bound| 100.0 * bound);
        lines.push(format!(
            "Side bias: the first or left one was chosen in {} of {}, {:.1} % (95 % interval {low:.1} \
             to {high:.1}, Wilson); exact binomial test against ½, two-sided, n = {}: {}.",
            first.chosen,
            counted(first.trials as usize, "trial"),
            first.percent,
            first.trials,
            first.p_binomial.equation()
        ));
    }
    lines.push(match &data.catch {
        Some(catch) => lapses(catch),
        None => "Lapses: not known, no catch trials were asked.".into(),
    });
    lines
}

fn lapses(catch: &Catch) -> String {
    let right = &catch.right;
    let [low, high] = right.clopper_pearson_95.map(|bound| 100.0 * bound);
    let who: Vec<String> = catch
        .lapses
        .iter()
        .map(|(who, right, trials)| format!("{who} {} of {trials}", trials - right))
        .collect();
    let who = if who.is_empty() { String::new() } else { format!("; wrong: {}", who.join(", ")) };
    format!(
        "Lapses: {} of {} answered rightly, {:.1} % (95 % interval {low:.1} to {high:.1}, Clopper and \
         Pearson){who}.",
        right.chosen,
        counted(right.trials as usize, "catch trial"),
        right.percent,
    )
}
