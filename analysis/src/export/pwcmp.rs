//! Export for pwcmp (Perez-Ortiz and Mantiuk 2017, "A practical guide and software for analysing
//! pairwise comparison experiments", arXiv:1712.03686): one table of choices, whose conditions are
//! compared within scenes.

use super::study::{Study, counts};
use crate::error::InputError;
use crate::input::pwcmp::COLUMNS;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;

/// The answers that count and choose, as `pwcmp.csv`.
pub(super) fn files(
    study: &Study,
    notes: &mut Vec<String>,
) -> Result<Vec<(String, Vec<u8>)>, InputError> {
    let refuse = |field: &str, value: String, allowed: &str| {
        Err(InputError::value("pwcmp", field, value, allowed))
    };
    let task = study.protocol.task;
    if task != Task::TwoAfc {
        let allowed = "answers of the task 2afc are needed, in which one of two stimuli is chosen";
        return refuse("task", format!("`{}`", task.name()), allowed);
    }
    let asked: Vec<&Response> = study.rows().filter(|row| counts(row)).collect();
    let left_out = study.rows().count() - asked.len();
    let unsure = asked.iter().filter(|row| row.selected.is_none()).count();
    if asked.len() == unsure {
        let value = format!("{left_out} that never count, {unsure} \"not sure\"");
        return refuse("answers", value, "at least one choice that counts is needed");
    }
    if left_out > 0 {
        notes.push(format!("Left out: {left_out} answers to practice, catch and pilot trials."));
    }
    if unsure > 0 {
        notes.push(format!("Left out: {unsure} answers \"not sure\", which choose neither."));
    }
    let scene = scene_places(&asked);
    let criterion = match study.kind.banner() {
        Some(banner) => format!("{banner}: {}", study.protocol.question),
        None => study.protocol.question.clone(),
    };
    let mut bytes = Vec::new();
    {
        let mut writer = csv::Writer::from_writer(&mut bytes);
        // Writing to memory cannot fail, and every row has seven cells.
        let _ = writer.write_record(COLUMNS);
        for row in asked.iter().filter(|row| row.selected.is_some()) {
            let (common, a) = split(&row.stimulus_a, &scene);
            let (_, b) = split(&row.stimulus_b, &scene);
            let a_selected = row.selected.as_ref() == Some(&row.stimulus_a);
            let _ = writer.write_record([
                row.subject.to_string().as_str(),
                row.session.to_string().as_str(),
                if common.is_empty() { &row.study } else { &common },
                &a,
                &b,
                if a_selected { "1" } else { "0" },
                &criterion,
            ]);
        }
        let _ = writer.flush();
    }
    Ok(vec![("pwcmp.csv".into(), bytes)])
}

/// The places in the ids whose levels are never compared with each other: together they are the
/// scene. None if the ids do not have equally many parts.
fn scene_places(rows: &[&Response]) -> Vec<usize> {
    let pairs: Vec<[Vec<&str>; 2]> = rows
        .iter()
        .map(|row| [&row.stimulus_a, &row.stimulus_b].map(|id| id.split('-').collect()))
        .collect();
    let width = pairs.first().map_or(0, |[a, _]| a.len());
    if pairs.iter().flatten().any(|parts| parts.len() != width) {
        return vec![];
    }
    (0..width).filter(|place| pairs.iter().all(|[a, b]| a[*place] == b[*place])).collect()
}

/// The scene and the condition of the stimulus `id`.
fn split(id: &str, scene: &[usize]) -> (String, String) {
    let (mut common, mut condition) = (vec![], vec![]);
    for (place, level) in id.split('-').enumerate() {
        if scene.contains(&place) { common.push(level) } else { condition.push(level) }
    }
    (common.join("-"), condition.join("-"))
}
