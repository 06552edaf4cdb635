//! Withdrawn whole, or so that running it again completes it.

use super::super::participants::PARTICIPANT;
use super::*;
use crate::record::ResponseWriter;
use crate::record::participants::tests::new_participant;
use crate::record::rows::tests::response;
use crate::test_support::protocol;
use shutterlab_data_schema::study::StudyKind;

fn code(text: &str) -> ParticipantCode {
    text.parse().unwrap()
}

/// A study with two participants of three answers each.
fn study(folder: &Path) -> Study {
    let study = Study::open(folder, &protocol(), StudyKind::Real).unwrap();
    for subject in ["P1", "P10"] {
        study.enter(&new_participant(subject, PARTICIPANT)).unwrap();
        let (mut recorder, _) = study.session(&code(subject), 1, 3).unwrap();
        for trial in 1..=3 {
            recorder.begin(trial).unwrap();
            let response = response(trial);
            recorder
                .write(&shutterlab_data_schema::Response { subject: code(subject), ..response })
                .unwrap();
        }
    }
    study
}

/// Names of all files but the traces.
fn names(folder: &Path) -> BTreeSet<String> {
    let (mut names, mut folders) = (BTreeSet::new(), vec![folder.to_path_buf()]);
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                names.insert(path.strip_prefix(folder).unwrap().display().to_string());
            }
        }
    }
    names
}

fn assert_withdrawn(folder: &Path, trace: &Withdrawal) {
    assert_eq!((trace.rows, trace.files), (3, 3));
    let left: Vec<String> = names(folder)
        .into_iter()
        .filter(|name| name.to_lowercase().contains("p1") && !name.to_lowercase().contains("p10"))
        .collect();
    assert_eq!(left, ["log/withdrawn/p1.json"]);
    for file in ["participants.csv", "datapackage.json"] {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        assert!(!text.contains("P1,") && !text.contains("P1_") && text.contains("P10"), "{text}");
    }
    let table = std::fs::read_to_string(folder.join("log/withdrawn.csv")).unwrap();
    assert_eq!(table.lines().count(), 2);
    assert!(table.starts_with("subject,withdrawn_at,rows,files,completed_at\nP1,"), "{table}");
}

#[test]
fn a_withdrawn_participant_is_gone_and_the_code_is_not_used_again() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path());
    let trace = study.withdraw(&code("P1")).unwrap();
    assert_withdrawn(folder.path(), &trace);
    for error in [
        study.enter(&new_participant("P1", PARTICIPANT)).unwrap_err(),
        study.enter(&new_participant("p1", PARTICIPANT)).unwrap_err(),
        study.session(&code("P1"), 1, 3).unwrap_err(),
        study.withdraw(&code("P1")).unwrap_err(),
    ] {
        assert!(matches!(error, RecordError::Withdrawn { .. }), "{error}");
    }
    // The number of the row of a Latin square is not given again either.
    assert_eq!(study.enter(&new_participant("P2", PARTICIPANT)).unwrap().ordinal, 3);
    let error = study.withdraw(&code("P3")).unwrap_err().to_string();
    assert!(error.contains("subject P3: no participant of this study"), "{error}");
}

#[test]
fn a_withdrawal_that_fails_anywhere_is_completed_by_the_next() {
    for step in 0.. {
        let folder = tempfile::tempdir().unwrap();
        let study = study(folder.path());
        let mut steps = 0;
        let failed = study.withdraw_with(&code("P1"), &mut |path| {
            steps += 1;
            if steps > step { Err(io::Error::other("killed")) } else { remove(path) }
        });
        if failed.is_ok() {
            // Answers, journal, frame times, claims and record.
            assert_eq!(step, 5);
            return;
        }
        let error = study.enter(&new_participant("P1", PARTICIPANT)).unwrap_err();
        assert!(matches!(error, RecordError::Withdrawn { .. }), "{error}");
        let trace = study.withdraw(&code("P1")).unwrap();
        assert_withdrawn(folder.path(), &trace);
    }
}

#[test]
fn who_is_being_asked_is_not_withdrawn() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path());
    let (running, _) = study.session(&code("P1"), 1, 3).unwrap();
    let before = names(folder.path());
    let error = study.withdraw(&code("P1")).unwrap_err();
    assert!(matches!(error, RecordError::Locked { .. }), "{error}");
    assert_eq!(names(folder.path()), before);
    drop(running);
    study.withdraw(&code("P1")).unwrap();
}
