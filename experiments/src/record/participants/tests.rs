//! Participants entered from many stations at once; codes, fields and consent.

use super::super::study::Study;
use super::*;
use crate::test_support::protocol;
use shutterlab_data_schema::protocol::ParticipantField;
use shutterlab_data_schema::study::StudyKind;
use std::collections::BTreeSet;

/// A participant to be entered as `subject`, who answers as `observer`.
pub(in crate::record) fn new_participant(subject: &str, observer: &str) -> NewParticipant {
    NewParticipant {
        subject: subject.parse().unwrap(),
        observer: observer.into(),
        seed: 5,
        fields: IndexMap::new(),
        consented_at: None,
    }
}

fn open(folder: &Path) -> Study {
    Study::open(folder, &protocol(), StudyKind::Real).unwrap()
}

fn rows(folder: &Path) -> Vec<csv::StringRecord> {
    let reader = csv::Reader::from_path(folder.join("participants.csv"));
    reader.unwrap().records().map(|row| row.unwrap()).collect()
}

#[test]
fn many_at_once_all_get_in_and_each_gets_a_number_of_its_own() {
    const STATIONS: usize = 8;
    const EACH: usize = 12;
    let folder = tempfile::tempdir().unwrap();
    let enter = |station: usize| {
        let study = open(folder.path()).at_station(&format!("station{station}"));
        (0..EACH)
            .map(|n| {
                let new = new_participant(&format!("P{station}x{n}"), PARTICIPANT);
                study.enter(&new).unwrap().ordinal
            })
            .collect::<Vec<u32>>()
    };
    let given: BTreeSet<u32> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..STATIONS).map(|n| scope.spawn(move || enter(n))).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    let all = (STATIONS * EACH) as u32;
    assert!(given.into_iter().eq(1..=all));
    let rows = rows(folder.path());
    assert!(rows.iter().map(|row| row[3].parse::<u32>().unwrap()).eq(1..=all));
}

#[test]
fn one_code_entered_at_once_is_one_participant() {
    for _ in 0..20 {
        let folder = tempfile::tempdir().unwrap();
        let enter = || open(folder.path()).enter(&new_participant("P1", PARTICIPANT)).unwrap();
        let entered: Vec<Participant> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(enter)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(entered.iter().all(|participant| *participant == entered[0]), "{entered:?}");
        assert_eq!(rows(folder.path()).len(), 1);
        let next = open(folder.path()).enter(&new_participant("P2", PARTICIPANT)).unwrap();
        assert_eq!((entered[0].ordinal, next.ordinal), (1, 2));
    }
}

#[test]
fn who_comes_again_is_the_same_and_keeps_the_number() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    assert_eq!(study.find(&"01".parse().unwrap()).unwrap(), None);
    let first = study.enter(&new_participant("01", PARTICIPANT)).unwrap();
    study.enter(&new_participant("02", PARTICIPANT)).unwrap();
    assert_eq!(study.enter(&new_participant("01", PARTICIPANT)).unwrap(), first);
    assert_eq!(study.find(&"01".parse().unwrap()).unwrap(), Some(first));
}

/// A program killed between giving a number and writing the record leaves no gap.
#[test]
fn a_number_given_to_nobody_yet_is_given_to_its_code() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    std::fs::write(folder.path().join(ORDINALS).join("1"), "p1").unwrap();
    assert_eq!(study.enter(&new_participant("P2", PARTICIPANT)).unwrap().ordinal, 2);
    assert_eq!(study.enter(&new_participant("P1", PARTICIPANT)).unwrap().ordinal, 1);
}

#[test]
fn a_code_stays_with_its_observer() {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::open(folder.path(), &protocol(), StudyKind::Simulated).unwrap();
    study.enter(&new_participant("P1", "simulated:guess")).unwrap();
    let refused = |new: &NewParticipant| study.enter(new).unwrap_err().to_string();
    let error = refused(&new_participant("P1", "simulated:thesis"));
    assert!(error.contains("observer: simulated:guess, now simulated:thesis"), "{error}");
    let error = refused(&new_participant("p1", "simulated:guess"));
    assert!(error.contains("subject p1: code: P1, now p1: "), "{error}");
    let error = refused(&NewParticipant { seed: 6, ..new_participant("P1", "simulated:guess") });
    assert!(error.contains("seed: 5, now 6"), "{error}");
    study.enter(&new_participant("P2", "simulated:thesis")).unwrap();
}

#[test]
fn a_damaged_record_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    study.enter(&new_participant("P1", PARTICIPANT)).unwrap();
    std::fs::write(path(folder.path(), &"P1".parse().unwrap()), "{").unwrap();
    let error = study.enter(&new_participant("P1", PARTICIPANT)).unwrap_err().to_string();
    assert!(error.contains("log/participants/p1.json: line 1: "), "{error}");
}

#[test]
fn the_protocols_own_fields_are_columns_and_the_consent_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut protocol = protocol();
    protocol.text.consent = Some("I agree.".into());
    protocol.participant = vec![ParticipantField {
        key: "sight".into(),
        label: "Do you wear glasses?".into(),
        options: vec!["glasses".into(), "lenses, \"soft\"".into(), "neither".into()],
    }];
    let study = Study::open(folder.path(), &protocol, StudyKind::Real).unwrap();
    let with = |value: &str, key: &str| NewParticipant {
        fields: IndexMap::from([(key.to_string(), value.to_string())]),
        consented_at: Some("2026-11-22T06:00:00Z".parse().unwrap()),
        ..new_participant("P1", PARTICIPANT)
    };
    for (value, key) in [("monocle", "sight"), ("glasses", "name")] {
        let error = study.enter(&with(value, key)).unwrap_err().to_string();
        assert!(error.contains(&format!("subject P1: {key}: {value:?}: allowed")), "{error}");
    }
    study.enter(&with("lenses, \"soft\"", "sight")).unwrap();
    study.enter(&new_participant("P2", PARTICIPANT)).unwrap();
    let text = std::fs::read_to_string(folder.path().join("participants.csv")).unwrap();
    assert!(text.starts_with(
        "subject,observer,seed,ordinal,first_session,consented_at,sight\nP1,participant,5,1,"
    ));
    let rows = rows(folder.path());
    assert_eq!((&rows[0][5], &rows[0][6]), ("2026-11-22T06:00:00.000Z", "lenses, \"soft\""));
    assert_eq!((&rows[1][5], &rows[1][6]), ("", ""));
    // `printf 'I agree.' | sha256sum`
    let sha256 = "826ff0dab649a97ffdd7779a332accafb35cc161012253a19383db19289d6e02";
    let record = read(&path(folder.path(), &"P1".parse().unwrap())).unwrap();
    assert_eq!(record.consent_sha256.as_deref(), Some(sha256));
}
