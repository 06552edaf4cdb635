//! Outside validators on what a study writes.

use crate::support::{answers_of, guess, read_table, skip, succeed, tree};
use serde_json::Value;
use shutterlab_data_schema::protocol::ParticipantField;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_experiments::protocols;
use shutterlab_experiments::record::participants::{NewParticipant, PARTICIPANT};
use shutterlab_experiments::record::study::Study;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A study with the answers of two simulated observers, in the folder `study/simulated`.
fn two_sessions() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for code in ["S01", "S02"] {
        succeed(folder.path(), &guess("study", code));
    }
    folder
}

/// The validator of data packages, if it is there.
pub fn frictionless() -> Option<OsString> {
    program("SHUTTERLAB_FRICTIONLESS", "frictionless", "SHUTTERLAB_REQUIRE_VALIDATORS")
}

/// The program that the environment names as `variable`, else `name`, if it runs. It must if `required` is
/// set.
pub fn program(variable: &str, name: &str, required: &str) -> Option<OsString> {
    let program = std::env::var_os(variable).unwrap_or(name.into());
    let version = Command::new(&program).arg("--version").output();
    if version.as_ref().is_ok_and(|output| output.status.success()) {
        return Some(program);
    }
    skip(required, &format!("{} does not run: {version:?}", program.display()));
    None
}

/// What the validator says about the data package in `folder`, which has `tables` tables: its kinds of
/// error; none if it is valid.
pub fn errors(program: &OsString, folder: &Path, tables: usize) -> BTreeSet<String> {
    let output = Command::new(program)
        .current_dir(folder)
        .args(["validate", "--json", "datapackage.json"])
        .output()
        .unwrap();
    let report: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    assert_eq!(report["tasks"].as_array().unwrap().len(), tables, "{report:#}");
    let lists = std::iter::once(&report).chain(report["tasks"].as_array().unwrap());
    let errors: BTreeSet<String> = lists
        .flat_map(|part| part["errors"].as_array().unwrap())
        .map(|error| error["type"].as_str().unwrap().to_string())
        .collect();
    assert_eq!(report["valid"], errors.is_empty(), "{report:#}");
    assert_eq!(output.status.success(), errors.is_empty(), "{report:#}");
    errors
}

#[test]
fn a_study_is_a_valid_data_package_and_a_damaged_one_is_not() {
    let Some(program) = frictionless() else { return };
    let folder = two_sessions();
    let study = folder.path().join("study/simulated");
    assert_eq!(errors(&program, &study, 3), BTreeSet::new());

    let file = answers_of(&study, "S02");
    let text = std::fs::read_to_string(&file).unwrap();
    let last = text.lines().last().unwrap();
    let doubled = format!("{text}{last}\n");
    for (damaged, kind) in [
        (text.replacen(",simulated,simulated:", ",imagined,simulated:", 1), "constraint-error"),
        (text.replacen("demo,S02,1,", "demo,S02,one,", 1), "type-error"),
        (doubled, "primary-key"),
    ] {
        assert_ne!(damaged, text);
        std::fs::write(&file, damaged).unwrap();
        assert_eq!(errors(&program, &study, 3), BTreeSet::from([kind.to_string()]));
    }
}

/// The protocol's own questions about the participant are columns with their options.
#[test]
fn the_participants_own_columns_are_valid_and_another_option_is_not() {
    let Some(program) = frictionless() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut protocol = protocols::load("demo").unwrap();
    protocol.text.consent = Some("I agree.".into());
    protocol.participant = vec![ParticipantField {
        key: "sight".into(),
        label: "Do you wear glasses?".into(),
        options: vec!["glasses, \"thick\"".into(), "none".into()],
    }];
    let study = Study::open(folder.path(), &protocol, StudyKind::Real).unwrap();
    for (code, fields) in [("P1", vec![("sight", "glasses, \"thick\"")]), ("P2", vec![])] {
        let entered = study.enter(&NewParticipant {
            subject: code.parse().unwrap(),
            observer: PARTICIPANT.into(),
            seed: 5,
            fields: fields.into_iter().map(|(key, value)| (key.into(), value.into())).collect(),
            consented_at: Some("2026-11-22T06:00:00.5Z".parse().unwrap()),
        });
        study.session(&entered.unwrap().subject, 1, 38).unwrap();
    }
    assert_eq!(errors(&program, folder.path(), 3), BTreeSet::new());
    let table = folder.path().join("participants.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    std::fs::write(&table, text.replace(",\"glasses, \"\"thick\"\"\"", ",monocle")).unwrap();
    assert_eq!(errors(&program, folder.path(), 3), BTreeSet::from(["constraint-error".into()]));
}

/// What Psych-DS asks of a dataset: its description with all required keys, data files named by
/// keywords and values, every column declared.
#[test]
fn a_study_is_named_and_described_as_psych_ds_asks() {
    let folder = two_sessions();
    let study = folder.path().join("study/simulated");
    let text = std::fs::read_to_string(study.join("dataset_description.json")).unwrap();
    let description: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(description["@context"], "https://schema.org/");
    assert_eq!(description["@type"], "Dataset");
    for key in ["name", "description"] {
        assert!(!description[key].as_str().unwrap().is_empty(), "{key}");
    }
    let declared: BTreeSet<&str> = description["variableMeasured"]
        .as_array()
        .unwrap()
        .iter()
        .map(|variable| variable.as_str().unwrap())
        .collect();

    let mut data_files = 0;
    for name in tree(&study).into_keys().filter(|name| name.starts_with("data")) {
        let file_name = name.file_name().unwrap().to_str().unwrap();
        assert!(is_psych_ds_name(file_name), "{file_name}");
        let rows = read_table(&study.join(&name));
        let columns: BTreeSet<&str> = rows[0].keys().map(String::as_str).collect();
        assert_eq!(columns, declared, "{file_name}");
        data_files += 1;
    }
    assert_eq!(data_files, 2);
}

/// `keyword-value`, once or more, joined by `_`, then `_data.csv`: keywords are lower-case letters,
/// values letters and digits, no keyword comes twice.
pub fn is_psych_ds_name(name: &str) -> bool {
    let Some(parts) = name.strip_suffix("_data.csv") else { return false };
    let mut keywords = BTreeSet::new();
    parts.split('_').all(|part| {
        part.split_once('-').is_some_and(|(keyword, value)| {
            let is_keyword = !keyword.is_empty() && keyword.bytes().all(|b| b.is_ascii_lowercase());
            let is_value = !value.is_empty() && value.bytes().all(|b| b.is_ascii_alphanumeric());
            is_keyword && is_value && keywords.insert(keyword.to_string())
        })
    })
}

#[test]
fn names_that_psych_ds_does_not_allow_are_told_apart() {
    assert!(is_psych_ds_name("study-demo_subject-01_data.csv"));
    for bad in ["data.csv", "subject-01.csv", "subject-0_1_data.csv", "Subject-1_data.csv"] {
        assert!(!is_psych_ds_name(bad), "{bad}");
    }
    assert!(!is_psych_ds_name("subject-1_subject-2_data.csv"));
}
