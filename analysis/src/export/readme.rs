//! The README of an export: what it holds, whose answers, and what is known about the people.

use super::Format;
use super::study::{Study, counts};
use std::collections::BTreeMap;

/// The line that tells an export of this study in this format from everything else.
pub(super) fn mark(study: &Study, format: Format) -> String {
    let (name, kind) = (&study.protocol.name, study.kind.name());
    format!("Export of the study {name} ({kind} answers) as {} by Shutterlab", format.name())
}

/// How many answers of which kind there are.
pub(super) fn summary(study: &Study) -> String {
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    for row in study.rows() {
        *kinds.entry(format!("{:?}", row.kind).to_lowercase()).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    let sessions = study.sessions.len();
    format!(
        "{sessions} session{} with {} answers ({}), of which {} count",
        if sessions == 1 { "" } else { "s" },
        study.rows().count(),
        kinds.join(", "),
        study.rows().filter(|row| counts(row)).count(),
    )
}

pub(super) fn text(study: &Study, format: Format, notes: &[String]) -> String {
    let notes: String = notes.iter().map(|note| format!("{note}\n")).collect();
    let people = study.participants.fields();
    let people = people.iter().map(|field| format!("- `{}`: {}\n", field.name, field.description));
    format!(
        "# {title}\n\n{mark} {version}.\n\n\
         Question: {question} (task {task}).\n{summary}.\n{notes}\n\
         ## Files\n\n{files}\n\
         ## Answers\n\n{rows}\n\
         ## People\n\n\
         Participants are codes of letters and digits; the study holds neither names nor addresses. What is \
         kept of each:\n\n{people}",
        title = study.title(),
        mark = mark(study, format),
        version = env!("CARGO_PKG_VERSION"),
        question = study.protocol.question,
        task = study.protocol.task.name(),
        summary = summary(study),
        files = files(format),
        rows = rows(format),
        people = people.collect::<String>(),
    )
}

/// What lies where.
fn files(format: Format) -> &'static str {
    match format {
        Format::Csv => {
            "\
- `responses.csv`: one row per answer, of all sessions.
- `participants.csv`: one row per participant.
- `stimuli.csv`: one row per stimulus, its id taken apart into the levels of the axes.
- `codebook.csv`: every column of these: type, unit, levels and what they mean.
- `datapackage.json`: the same as a Frictionless data package.
- `load.R`, `load.py`: load the tables into R (`source(\"load.R\")`) and pandas (`from load import responses`) \
with types, levels, labels and units.
"
        }
        Format::Bids => {
            "\
- `sub-CODE/ses-N/beh/…_beh.tsv`: one row per answer of a session.
- `task-…_beh.json`: the columns of these, their units and levels, and the instructions.
- `participants.tsv`, `participants.json`: one row per participant, and its columns.
- `dataset_description.json`: please add Authors and License before you publish.
"
        }
        Format::PsychDs => {
            "\
- `data/`: one file per session, one row per answer.
- `dataset_description.json`: every column of these, with units and levels, in the words of schema.org.
- `participants.csv`: one row per participant.
- `datapackage.json`, `responses.schema.json`: the same as a Frictionless data package.
- `materials/`: the protocol that was run, and an image of each stimulus.
"
        }
        Format::Pwcmp => {
            "\
- `pwcmp.csv`: one row per choice, for pwcmp (Perez-Ortiz and Mantiuk 2017, arXiv:1712.03686): `observer` and \
`session_id`; `scene`, the levels in which the stimuli of no pair differ; `condition_A` and `condition_B`, \
their other levels; `is_A_selected`, 1 or 0; `criterion`, the question.
"
        }
    }
}

/// Which answers there are.
fn rows(format: Format) -> &'static str {
    match format {
        Format::Pwcmp => {
            "Only choices that count are here. Answers to practice, catch and pilot trials and answers \"not \
             sure\" are left out, as the format has no place for them.\n"
        }
        Format::Csv | Format::Bids => {
            "Every answer is here. The column `kind` says what it is; where `counts` is `false` it is one to a \
             practice, catch or pilot trial and never a result. `study_kind`, in every table, says whose \
             answers the study holds: those of simulated observers are a check of the tool, never a finding. \
             An empty cell (in BIDS `n/a`) is a missing value.\n"
        }
        Format::PsychDs => {
            "Every answer is here. The column `kind` says what it is: `practice`, `catch` and `pilot` are never \
             a result, and `simulated` is a check of the tool, never a finding. An empty cell is a missing \
             value.\n"
        }
    }
}
