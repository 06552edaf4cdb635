//! Study folders: one protocol, no mixing, one process per session.

use super::*;
use crate::test_support::{protocol, rendered, small_protocol};
use shutterlab_data_schema::study::data_files;

fn code(text: &str) -> ParticipantCode {
    text.parse().unwrap()
}

#[test]
fn a_study_is_begun_once_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let study = Study::open(folder.path(), &protocol(), false).unwrap();
        study.enter(&code("01"), PARTICIPANT, 5).unwrap();
        let (recorder, rows) = study.session(&code("01"), 1).unwrap();
        assert!(rows.is_empty());
        assert_eq!(data_files(folder.path()).unwrap(), [recorder.data_file()]);
    }
    let copy = Protocol::read(&folder.path().join("protocol.toml")).unwrap();
    assert_eq!(copy, protocol());
    let participants = std::fs::read_to_string(folder.path().join("participants.csv")).unwrap();
    assert_eq!(participants.lines().count(), 2);
    let log = folder.path().join("log/study-demo_subject-01_session-1_task-2afc.log");
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains("\tbegan\t") && log.contains("\tresumed\t"), "{log}");
    assert!(folder.path().join("datapackage.json").exists());
}

#[test]
fn another_protocol_is_refused_by_the_first_differing_key() {
    let folder = tempfile::tempdir().unwrap();
    Study::open(folder.path(), &protocol(), false).unwrap();
    let mut other = protocol();
    other.design.gap_s = 0.75;
    other.seed = 3;
    let error = Study::open(folder.path(), &other, false).unwrap_err().to_string();
    assert!(error.contains("protocol.toml: seed: 20121, now 3: "), "{error}");
    let error = Study::open(folder.path(), &small_protocol(), false).unwrap_err().to_string();
    assert!(error.contains("stimuli.samples: [\"A3\",\"A4\",\"A5\"], now [\"A3\"]"), "{error}");
}

#[test]
fn a_pilot_is_a_study_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::open(folder.path(), &protocol(), true).unwrap();
    let (recorder, _) = study.session(&code("01"), 1).unwrap();
    assert!(recorder.data_file().starts_with(folder.path().join("pilot/data")));
    assert!(!folder.path().join("data").exists());
}

#[test]
fn people_and_simulated_observers_never_share_a_study() {
    for (first, second, holds) in [
        (PARTICIPANT, "simulated:guess", "people"),
        ("simulated:guess", PARTICIPANT, "simulated observers (simulated:guess)"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let study = Study::open(folder.path(), &protocol(), false).unwrap();
        study.enter(&code("01"), first, 5).unwrap();
        let error = study.enter(&code("02"), second, 6).unwrap_err().to_string();
        assert!(error.contains(&format!("the study holds answers of {holds}")), "{error}");
    }
}

#[test]
fn a_code_stays_with_its_observer() {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::open(folder.path(), &protocol(), false).unwrap();
    study.enter(&code("01"), "simulated:guess", 5).unwrap();
    let error = study.enter(&code("01"), "simulated:thesis", 5).unwrap_err().to_string();
    assert!(error.contains("observer: simulated:guess, now simulated:thesis"), "{error}");
    study.enter(&code("02"), "simulated:thesis", 6).unwrap();
}

#[test]
fn a_session_that_is_running_is_locked() {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::open(folder.path(), &protocol(), false).unwrap();
    let running = study.session(&code("01"), 1).unwrap();
    let error = study.session(&code("01"), 1).unwrap_err().to_string();
    assert!(error.contains("subject 01 is being asked by another running session"), "{error}");
    study.session(&code("02"), 1).unwrap();
    drop(running);
    study.session(&code("01"), 1).unwrap();
}

#[test]
fn a_torn_row_is_moved_to_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let study = Study::open(folder.path(), &protocol(), false).unwrap();
    let path = study.session(&code("01"), 1).unwrap().0.data_file().to_path_buf();
    let header = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{header}demo,01,1,he")).unwrap();
    let (_recorder, rows) = study.session(&code("01"), 1).unwrap();
    assert!(rows.is_empty());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), header);
    let log = folder.path().join("log/study-demo_subject-01_session-1_task-2afc.log");
    assert!(std::fs::read_to_string(log).unwrap().contains("\ttorn-row\tdemo,01,1,he\n"));
}

#[test]
fn a_study_under_a_regular_file_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plain");
    std::fs::write(&file, "").unwrap();
    let error = Study::open(&file.join("study"), &protocol(), false).unwrap_err().to_string();
    assert!(error.contains("plain/study/data"), "{error}");
}

#[test]
fn thumbnails_show_the_middle_frame() {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let set = StimulusSet::open(&protocol(), stimuli.path()).unwrap();
    Study::open(folder.path(), &protocol(), false).unwrap().keep_thumbnails(&set).unwrap();
    let thumbnail = folder.path().join("thumbnails/M2-S2-T4-A4.png");
    let original = stimuli.path().join("M2-S2-T4-A4/frame-0001.png");
    use shutterlab_stimuli::frames::EncodedImage;
    assert_eq!(
        EncodedImage::read_png(&thumbnail).unwrap(),
        EncodedImage::read_png(&original).unwrap()
    );
}
