//! Cohorts: whole sessions only, the same participants when run again.

use super::*;
use crate::record::participants::tests::new_participant;
use crate::record::rows::tests::response;
use crate::test_support::protocol;
use shutterlab_data_schema::study::data_files;

fn observers(count: u32) -> Vec<NewParticipant> {
    (1..=count).map(|n| new_participant(&format!("S{n}"), "simulated:guess")).collect()
}

fn answer(writer: &mut SessionWriter, subject: &ParticipantCode) {
    for trial in 1..=3 {
        assert_eq!(writer.begin(trial).unwrap(), 1);
        writer.write(&Response { subject: subject.clone(), ..response(trial) }).unwrap();
    }
}

#[test]
fn a_cohort_run_again_writes_what_is_missing_and_leaves_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::open(folder.path(), &protocol(), StudyKind::Simulated).unwrap();
    let simulated = StudyKind::Simulated.folder(folder.path());
    {
        // Killed in the third session.
        let cohort = study.cohort(&observers(5)).unwrap();
        for (index, participant) in cohort.participants().iter().enumerate().take(3) {
            let mut writer = cohort.writer(&participant.subject, 1).unwrap();
            answer(&mut writer, &participant.subject);
            if index < 2 {
                writer.finish().unwrap();
            }
        }
    }
    let files = data_files(&simulated).unwrap();
    assert_eq!(files.len(), 2);
    let before: Vec<Vec<u8>> = files.iter().map(|file| std::fs::read(file).unwrap()).collect();

    let cohort = study.cohort(&observers(6)).unwrap();
    assert!(cohort.participants().iter().map(|p| p.ordinal).eq(1..=6));
    let mut written = 0;
    for participant in cohort.participants() {
        if let Some(mut writer) = cohort.writer(&participant.subject, 1) {
            answer(&mut writer, &participant.subject);
            writer.finish().unwrap();
            written += 1;
        }
    }
    cohort.finish().unwrap();
    assert_eq!(written, 4);
    for (file, bytes) in files.iter().zip(before) {
        assert_eq!(std::fs::read(file).unwrap(), bytes);
    }
    let participants = std::fs::read_to_string(simulated.join("participants.csv")).unwrap();
    assert_eq!(participants.lines().count(), 7);
    // Its sessions are like any other: finished, and opened again if somebody asks.
    let (_, rows) = study.session(&"S3".parse().unwrap(), 1, 3).unwrap();
    assert_eq!(rows.len(), 3);
}

#[test]
fn a_cohort_is_never_real() {
    let folder = tempfile::tempdir().unwrap();
    for kind in [StudyKind::Real, StudyKind::Pilot] {
        let study = Study::open(folder.path(), &protocol(), kind).unwrap();
        let error = study.cohort(&observers(1)).unwrap_err();
        assert!(matches!(error, RecordError::Mixed { .. }), "{error}");
    }
}
