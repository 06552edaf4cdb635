//! Exports of made-up studies: nothing is lost or mixed, and what cannot be exported is refused.

use crate::made_up::{STIMULI, csv_text, study};
use shutterlab_analysis::export::{Format, Study, export};
use shutterlab_analysis::input::pwcmp;
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::{Answer, TrialKind};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tempfile::TempDir;

const FORMATS: [Format; 4] = [Format::Csv, Format::Bids, Format::PsychDs, Format::Pwcmp];

const PROTOCOL: &str = r#"
schema = 1
name = "madeUp"
title = "A made-up study"
task = "2afc"
question = "Which of the two sequences has the higher quality?"
seed = 1
[stimuli]
samples = ["A3", "A4", "A5"]
shutter = ["T3", "T4", "T5"]
[design]
pairs = "all"
repetitions = 1
[timeline]
fixation_s = 0.5
gap_s = 0.5
eye = "follow"
replays = true
[text]
instructions = "Look."
after_practice = "Now it counts."
pause = "Rest."
end = "Thank you."
[[participant]]
key = "sight"
label = "Do you wear glasses?"
options = ["glasses, \"thick\"", "none"]
"#;

/// A study folder with `rows`, one file per subject and session, and all their subjects.
fn folder(rows: &[Response]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    std::fs::write(folder.path().join("protocol.toml"), PROTOCOL).unwrap();
    let mut sessions: BTreeMap<(String, u32), Vec<Response>> = BTreeMap::new();
    for row in rows {
        let key = (row.subject.to_string(), row.session);
        sessions.entry(key).or_default().push(row.clone());
    }
    let mut participants =
        "subject,observer,seed,ordinal,first_session,consented_at,sight\n".to_string();
    let mut seen = BTreeSet::new();
    for (place, ((subject, session), rows)) in sessions.iter().enumerate() {
        let name = format!("study-madeUp_subject-{subject}_session-{session}_task-2afc_data.csv");
        std::fs::write(folder.path().join("data").join(name), csv_text(rows)).unwrap();
        if seen.insert(subject) {
            let sight = if place == 0 { "\"glasses, \"\"thick\"\"\"" } else { "" };
            let observer = &rows[0].observer;
            participants += &format!(
                "{subject},{observer},18446744073709551615,{},2026-11-22T08:59:00Z,,{sight}\n",
                place + 1
            );
        }
    }
    std::fs::write(folder.path().join("participants.csv"), participants).unwrap();
    folder
}

fn read(rows: &[Response]) -> Study {
    Study::read(folder(rows).path(), BTreeMap::new()).unwrap()
}

fn refusal(folder: &Path) -> String {
    let error = Study::read(folder, BTreeMap::new()).unwrap_err().to_string();
    error.replace(&folder.display().to_string(), "STUDY")
}

/// Three people, the second in two sessions.
fn rows() -> Vec<Response> {
    let mut rows = study(4, &STIMULI, TrialKind::Real);
    for row in rows.iter_mut().filter(|row| row.subject.to_string() == "P03") {
        (row.subject, row.session) = ("P02".parse().unwrap(), 2);
    }
    rows
}

fn simulated() -> Vec<Response> {
    let mut rows = study(2, &STIMULI, TrialKind::Simulated);
    rows.iter_mut().for_each(|row| row.observer = "simulated:made-up".into());
    rows
}

/// The files of an export, by path in it.
fn files(study: &Study, format: Format) -> BTreeMap<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    export(study, format).unwrap().write(&out).unwrap();
    let (mut files, mut folders) = (BTreeMap::new(), vec![out.clone()]);
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(&out).unwrap().display().to_string();
                files.insert(name.replace('\\', "/"), std::fs::read_to_string(&path).unwrap());
            }
        }
    }
    files
}

/// The rows of a table, by column.
fn table(text: &str, delimiter: u8) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .quoting(delimiter == b',')
        .from_reader(text.as_bytes());
    reader.deserialize().map(Result::unwrap).collect()
}

/// All rows of the tables whose names end in `ending`.
fn tables(files: &BTreeMap<String, String>, ending: &str) -> Vec<BTreeMap<String, String>> {
    let delimiter = if ending.ends_with("tsv") { b'\t' } else { b',' };
    let texts = files.iter().filter(|(name, _)| name.ends_with(ending)).map(|(_, text)| text);
    texts.flat_map(|text| table(text, delimiter)).collect()
}

/// Every answer is there, with every value as the session wrote it.
#[test]
fn no_answer_and_no_value_is_lost() {
    let rows = rows();
    let study = read(&rows);
    let mut expected = table(&csv_text(&rows), b',');
    let sort = |rows: &mut Vec<BTreeMap<String, String>>| {
        rows.sort_by_key(|row| ["subject", "session", "trial"].map(|name| row[name].clone()));
    };
    sort(&mut expected);
    for (format, ending) in
        [(Format::Csv, "responses.csv"), (Format::PsychDs, "_data.csv"), (Format::Bids, "_beh.tsv")]
    {
        let mut found = tables(&files(&study, format), ending);
        for row in &mut found {
            if format == Format::Bids {
                let time = row.remove("response_time").unwrap();
                row.insert("response_time_s".into(), time);
                row.values_mut().filter(|value| *value == "n/a").for_each(String::clear);
            }
            let counts = row.remove("counts").unwrap_or((row["kind"] == "real").to_string());
            assert_eq!(counts, (row["kind"] == "real").to_string());
            assert_eq!(row.remove("study_kind").unwrap_or("real".into()), "real");
        }
        sort(&mut found);
        assert_eq!(found.len(), 4 * 38);
        assert!(found == expected, "{format:?}");
    }
}

/// The codebook has every column of every table, and no other.
#[test]
fn the_codebook_is_that_of_the_tables() {
    let files = files(&read(&rows()), Format::Csv);
    let codebook = table(&files["codebook.csv"], b',');
    for name in ["responses.csv", "participants.csv", "stimuli.csv"] {
        let header = files[name].lines().next().unwrap();
        let about = codebook.iter().filter(|row| row["file"] == name);
        let variables: Vec<&str> = about.clone().map(|row| row["variable"].as_str()).collect();
        assert_eq!(variables.join(","), header);
        for row in about {
            assert!(!row["description"].is_empty() && !row["type"].is_empty(), "{row:?}");
            let (levels, labels) = (row["levels"].lines().count(), row["labels"].lines().count());
            assert_eq!(levels, labels, "{row:?}");
        }
    }
    let about = |file: &str, name: &str| {
        codebook.iter().find(|row| row["file"] == file && row["variable"] == name).unwrap()
    };
    assert_eq!(about("responses.csv", "response_time_s")["unit"], "s");
    assert_eq!(about("responses.csv", "speed_deg_per_s")["unit"], "deg/s");
    assert_eq!(about("participants.csv", "sight")["levels"], "glasses, \"thick\"\nnone");
    assert!(about("responses.csv", "kind")["levels"].starts_with("real\npilot\npractice\n"));
}

/// The protocol says which axis the levels are of, as far as it names them.
#[test]
fn stimuli_are_taken_apart_into_their_levels() {
    let stimuli = table(&files(&read(&rows()), Format::Csv)["stimuli.csv"], b',');
    assert_eq!(stimuli.len(), 9);
    for row in stimuli {
        let [shutter, samples] = [&row["shutter"], &row["samples"]];
        assert_eq!(row["stimulus"], format!("M2-S2-{shutter}-{samples}"));
        assert_eq!((row["axis_1"].as_str(), row["axis_2"].as_str()), ("M2", "S2"));
    }
    let uneven = study(1, &["plain", "M1-T1", "M1-T2"], TrialKind::Real);
    let stimuli = &files(&read(&uneven), Format::Csv)["stimuli.csv"];
    assert!(stimuli.starts_with("study_kind,stimulus\nreal,M1-T1\n"), "{stimuli}");
}

#[test]
fn simulated_and_pilot_answers_are_marked_in_every_file() {
    let pilot = study(2, &STIMULI, TrialKind::Pilot);
    let pilot: Vec<Response> =
        pilot.into_iter().map(|row| Response { pilot: true, ..row }).collect();
    for (rows, formats, word) in
        [(simulated(), &FORMATS[..], "simulated"), (pilot, &FORMATS[..3], "pilot")]
    {
        let study = read(&rows);
        for format in formats {
            for (name, text) in files(&study, *format) {
                // The protocol was the same whoever answered, and so are the columns of its participants.
                let exempt = name == "materials/protocol.toml"
                    || (word == "pilot"
                        && *format == Format::PsychDs
                        && name == "participants.csv");
                let marked = |line: &str| line.to_lowercase().contains(word);
                let every_row = !name.ends_with("sv") || text.lines().skip(1).all(marked);
                let inside = marked(&text) && (every_row || name == "codebook.csv");
                assert!(exempt || marked(&name) || inside, "{format:?}: {name}");
            }
        }
        let counted = tables(&files(&study, Format::Csv), "responses.csv");
        let counted = counted.iter().filter(|row| row["counts"] == "true").count();
        assert_eq!(counted, if word == "simulated" { 2 * 36 } else { 0 });
    }
}

/// What is exported for pwcmp is read again: the same choices, without those that choose nothing.
#[test]
fn choices_for_pwcmp_come_back() {
    let mut rows = simulated();
    for row in rows.iter_mut().filter(|row| row.trial == 7) {
        (row.answer, row.selected) = (Answer::NotSure, None);
    }
    let study = read(&rows);
    let export = export(&study, Format::Pwcmp).unwrap();
    let notes = export.notes.join(" ");
    assert!(notes.contains("4 answers to practice") && notes.contains("2 answers \"not sure\""));
    let text = &files(&study, Format::Pwcmp)["pwcmp.csv"];
    assert!(pwcmp::is_pwcmp(text));
    let scenes = pwcmp::parse(text, "pwcmp.csv").unwrap();
    assert_eq!(scenes.len(), 1);
    // All stimuli have the same material and speed.
    assert!(scenes[0].name == "M2-S2" && scenes[0].simulated);
    let chosen: Vec<(String, String, bool)> = scenes[0]
        .choices
        .iter()
        .map(|choice| {
            let id = |condition: &str| format!("M2-S2-{condition}");
            (id(&choice.a), id(&choice.b), choice.a_selected)
        })
        .collect();
    let expected: Vec<(String, String, bool)> = rows
        .iter()
        .filter(|row| row.kind == TrialKind::Simulated && row.selected.is_some())
        .map(|row| {
            let a_selected = row.selected.as_ref() == Some(&row.stimulus_a);
            (row.stimulus_a.clone(), row.stimulus_b.clone(), a_selected)
        })
        .collect();
    assert_eq!(chosen, expected);
    assert_eq!(chosen.len(), 2 * 35);
}

#[test]
fn pwcmp_takes_choices_between_two_only() {
    let mut unsure = rows();
    unsure.iter_mut().for_each(|row| (row.answer, row.selected) = (Answer::NotSure, None));
    let error = export(&read(&unsure), Format::Pwcmp).unwrap_err().to_string();
    assert_eq!(
        error,
        "pwcmp: answers: 8 that never count, 144 \"not sure\": at least one choice that counts is needed"
    );
    let mut rows = rows();
    rows.iter_mut().for_each(|row| row.task = Task::Matching);
    let folder = folder(&rows);
    let matching = PROTOCOL.replace("\"2afc\"", "\"matching\"");
    std::fs::write(folder.path().join("protocol.toml"), matching).unwrap();
    let study = Study::read(folder.path(), BTreeMap::new()).unwrap();
    let error = export(&study, Format::Pwcmp).unwrap_err().to_string();
    assert!(error.starts_with("pwcmp: task: `matching`: answers of the task 2afc"), "{error}");
    assert!(FORMATS[..3].iter().all(|format| export(&study, *format).is_ok()));
}

#[test]
fn damaged_and_mixed_studies_are_refused_by_name() {
    let change = |change: &dyn Fn(&mut Vec<Response>)| {
        let mut rows = rows();
        change(&mut rows);
        refusal(folder(&rows).path())
    };
    let first = "STUDY/data/study-madeUp_subject-P01_session-1_task-2afc_data.csv";
    let twice = change(&|rows| {
        let row = rows[3].clone();
        rows.push(row);
    });
    assert_eq!(
        twice,
        format!("{first}: line 40: trial: subject P01, session 1, trial 4: answered twice")
    );
    let other = change(&|rows| rows[2].study = "other".into());
    assert_eq!(other, format!("{first}: line 4: study: `other`: the study's protocol is `madeUp`"));
    let pilot = change(&|rows| rows[2].pilot = true);
    assert!(pilot.starts_with("STUDY: pilot: 1 of 152 answers"), "{pilot}");
    let mixed = change(&|rows| rows[2].observer = "simulated:x".into());
    assert!(mixed.starts_with("STUDY: observer: 1 of 152 answers are simulated"), "{mixed}");
    assert_eq!(
        change(&|rows| rows.clear()),
        "STUDY: data: no answers: at least one answer is needed"
    );

    let unknown = folder(&rows());
    let participants = unknown.path().join("participants.csv");
    let text = std::fs::read_to_string(&participants).unwrap();
    std::fs::write(&participants, text.replace("\nP01,", "\nP09,")).unwrap();
    assert_eq!(
        refusal(unknown.path()),
        format!("{first}: line 2: subject: `P01`: participants.csv has nobody of this code")
    );
    std::fs::write(&participants, text.replace(",sight", ",sights")).unwrap();
    assert!(refusal(unknown.path()).starts_with("STUDY/participants.csv: line 1: header: "));

    let taken = folder(&rows());
    let protocol = PROTOCOL.replace("\"sight\"", "\"participant_id\"");
    std::fs::write(taken.path().join("protocol.toml"), protocol).unwrap();
    let error = refusal(taken.path());
    assert!(error.starts_with("STUDY/protocol.toml: participant.key: participant_id: "), "{error}");

    let copied = folder(&rows());
    let data = copied.path().join("data");
    let name = "study-madeUp_subject-P04_session-1_task-2afc_data.csv";
    std::fs::copy(data.join(name), data.join(name.replace("session-1", "session-2"))).unwrap();
    assert!(refusal(copied.path()).ends_with(&format!("{name} has its answers already")));
}

/// Somebody who has not answered yet is told of, and is no folder of BIDS.
#[test]
fn participants_without_answers_are_told_of() {
    let mut rows = rows();
    let folder = folder(&rows);
    rows.retain(|row| row.subject.to_string() != "P04");
    let name = "data/study-madeUp_subject-P04_session-1_task-2afc_data.csv";
    let header = csv_text(&rows).lines().next().unwrap().to_string() + "\n";
    std::fs::write(folder.path().join(name), header).unwrap();
    let study = Study::read(folder.path(), BTreeMap::new()).unwrap();
    let notes = export(&study, Format::Bids).unwrap().notes.join(" ");
    assert!(notes.contains("has no answers: study-madeUp_subject-P04"), "{notes}");
    assert!(notes.contains("Entered, but without answers: P04."), "{notes}");
    let bids = files(&study, Format::Bids);
    assert!(!bids["participants.tsv"].contains("P04"));
    assert!(bids.contains_key("sub-P02/ses-2/beh/sub-P02_ses-2_task-2afc_beh.tsv"));
    assert!(files(&study, Format::Csv)["participants.csv"].contains("P04"));
}

#[test]
fn an_export_replaces_itself_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/out");
    let all = read(&rows());
    export(&all, Format::Bids).unwrap().write(&out).unwrap();
    let withdrawn: Vec<Response> =
        rows().into_iter().filter(|row| row.subject.to_string() != "P04").collect();
    let rest = export(&read(&withdrawn), Format::Bids).unwrap();
    assert!(out.join("sub-P04").exists());
    rest.write(&out).unwrap();
    assert!(!out.join("sub-P04").exists() && out.join("sub-P01").exists());
    assert_eq!(std::fs::read_dir(folder.path().join("a")).unwrap().count(), 1);

    let refusal = |export: &shutterlab_analysis::export::Export| {
        let error = export.write(&out).unwrap_err().to_string();
        error.replace(&out.display().to_string(), "OUT")
    };
    let not_mine =
        "OUT: not empty, and no earlier export of this study in this format; choose another folder";
    assert_eq!(refusal(&export(&all, Format::PsychDs).unwrap()), not_mine);
    assert_eq!(refusal(&export(&read(&simulated()), Format::Bids).unwrap()), not_mine);
    std::fs::write(out.join("mine.txt"), "mine").unwrap();
    assert_eq!(refusal(&rest), "OUT: mine.txt: not of the export; choose another folder");
    assert_eq!(std::fs::read_to_string(out.join("mine.txt")).unwrap(), "mine");
}

/// BIDS quotes nothing: what would break a row is a space.
#[test]
fn no_text_breaks_a_row_of_bids() {
    let mut rows = rows();
    rows.iter_mut().for_each(|row| row.question = "Which\tis\r\nbetter, \"A\"?".into());
    let found = tables(&files(&read(&rows), Format::Bids), "_beh.tsv");
    assert_eq!(found.len(), rows.len());
    assert!(found.iter().all(|row| row["question"] == "Which is  better, \"A\"?"));
}
