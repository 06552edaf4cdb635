//! Study folders: one protocol, no mixing, one program per session.

use super::super::heartbeat::State;
use super::super::{RecordError, ResponseWriter, list};
use super::*;
use crate::record::participants::tests::new_participant;
use crate::record::rows::tests::response;
use crate::record::status::{Progress, status};
use crate::test_support::{protocol, rendered, small_protocol};
use shutterlab_data_schema::study::data_files;

fn code(text: &str) -> ParticipantCode {
    text.parse().unwrap()
}

fn open(folder: &Path) -> Study {
    Study::open(folder, &protocol(), StudyKind::Real).unwrap()
}

#[test]
fn a_study_is_begun_once_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let study = open(folder.path());
        study.enter(&new_participant("01", PARTICIPANT)).unwrap();
        let (mut recorder, rows) = study.session(&code("01"), 1, 38).unwrap();
        assert!(rows.is_empty());
        assert_eq!(data_files(folder.path()).unwrap(), [recorder.data_file()]);
        recorder.note(log::LEFT, "0 of 38 answered").unwrap();
    }
    let copy = Protocol::read(&folder.path().join("protocol.toml")).unwrap();
    assert_eq!(copy, protocol());
    let participants = std::fs::read_to_string(folder.path().join("participants.csv")).unwrap();
    assert_eq!(participants.lines().count(), 2);
    let log = folder.path().join("log/study-demo_subject-01_session-1_task-2afc.log");
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains("\tbegan\t") && log.contains("\tresumed\t"), "{log}");
    assert!(!log.contains("\tcrashed\t"), "{log}");
    assert!(folder.path().join("datapackage.json").exists());
}

#[test]
fn another_protocol_is_refused_by_the_first_differing_key() {
    let folder = tempfile::tempdir().unwrap();
    open(folder.path());
    let again = |protocol: &Protocol| {
        Study::open(folder.path(), protocol, StudyKind::Real).unwrap_err().to_string()
    };
    let mut other = protocol();
    other.timeline.gap_s = 0.75;
    other.seed = 3;
    let error = again(&other);
    assert!(error.contains("protocol.toml: seed: 20121, now 3: "), "{error}");
    let error = again(&small_protocol());
    assert!(error.contains("stimuli.samples: [\"A3\",\"A4\",\"A5\"], now [\"A3\"]"), "{error}");
}

/// Of stations with different protocols that begin one study at once, the protocol of one is kept, and
/// whoever has another one is refused.
#[test]
fn a_study_begun_at_once_has_one_protocol() {
    let folder = tempfile::tempdir().unwrap();
    let begin = |seed: u64| {
        let mut protocol = protocol();
        protocol.seed = seed;
        Study::open(folder.path(), &protocol, StudyKind::Real).map(|_| seed)
    };
    let begun: Vec<u64> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|n| scope.spawn(move || begin(n % 4))).collect();
        threads.into_iter().filter_map(|thread| thread.join().unwrap().ok()).collect()
    });
    let kept = Protocol::read(&folder.path().join("protocol.toml")).unwrap().seed;
    assert_eq!(begun, [kept; 2]);
}

#[test]
fn pilot_and_simulated_answers_lie_in_studies_of_their_own_that_say_so() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, name, observer, banner) in [
        (StudyKind::Pilot, "pilot", PARTICIPANT, "PILOT"),
        (StudyKind::Simulated, "simulated", "simulated:guess", "SIMULATED"),
    ] {
        let study = Study::open(folder.path(), &protocol(), kind).unwrap();
        study.enter(&new_participant("01", observer)).unwrap();
        let (recorder, _) = study.session(&code("01"), 1, 38).unwrap();
        assert!(recorder.data_file().starts_with(folder.path().join(name).join("data")));
        for file in ["README.md", "datapackage.json", "dataset_description.json"] {
            let path = folder.path().join(name).join(file);
            assert!(std::fs::read_to_string(path).unwrap().contains(banner), "{file}");
        }
    }
    assert!(!folder.path().join("data").exists());
}

#[test]
fn people_and_simulated_observers_never_share_a_study() {
    for (kind, observer) in
        [(StudyKind::Real, "simulated:guess"), (StudyKind::Simulated, PARTICIPANT)]
    {
        let folder = tempfile::tempdir().unwrap();
        let study = Study::open(folder.path(), &protocol(), kind).unwrap();
        let error = study.enter(&new_participant("01", observer)).unwrap_err();
        assert!(matches!(error, RecordError::Mixed { .. }), "{error}");
    }
    for (first, second, holds) in [
        (PARTICIPANT, "simulated:guess", "people"),
        ("simulated:guess", PARTICIPANT, "simulated observers (simulated:guess)"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let pilot = Study::open(folder.path(), &protocol(), StudyKind::Pilot).unwrap();
        pilot.enter(&new_participant("01", first)).unwrap();
        let error = pilot.enter(&new_participant("02", second)).unwrap_err().to_string();
        assert!(error.contains(&format!("the study holds answers of {holds}")), "{error}");
    }
}

/// As a program that was killed leaves it: nothing is said any more, and no lock is held.
fn kill(recorder: Recorder) {
    let claims = recorder.claim.folder().to_path_buf();
    drop(recorder);
    let mut last = heartbeat::latest(&claims).unwrap().unwrap().heartbeat.unwrap();
    last.state = State::Running;
    std::fs::write(last_of(&claims), serde_json::to_vec(&last).unwrap()).unwrap();
}

/// The file of the claim that counts.
fn last_of(claims: &Path) -> PathBuf {
    list(claims, ".json").unwrap().pop().unwrap()
}

#[test]
fn a_session_that_is_running_is_locked_and_a_killed_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path()).at_station("alpha");
    let (running, _) = study.session(&code("01"), 1, 38).unwrap();
    let error = study.session(&code("01"), 1, 38).unwrap_err().to_string();
    let expected = "subject 01 is being asked by another running session, at station alpha since ";
    assert!(error.contains(expected), "{error}");
    study.session(&code("02"), 1, 38).unwrap();
    let journal = running.journal().to_path_buf();
    kill(running);
    study.session(&code("01"), 1, 38).unwrap();
    let story = Story::read(&journal).unwrap();
    assert_eq!(story.crashes, 1);
}

#[test]
fn status_counts_a_crash_where_a_session_crashed_and_none_where_one_runs() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    let told = || {
        let status = status(folder.path(), StudyKind::Real, |_| None).unwrap();
        assert_eq!(status.faults, Vec::<String>::new());
        (status.sessions[0].state, status.sessions[0].crashes)
    };
    let (running, _) = study.session(&code("01"), 1, 38).unwrap();
    assert_eq!(told(), (Progress::Running, 0));
    kill(running);
    assert_eq!(told(), (Progress::Crashed, 1));
    let (mut again, _) = study.session(&code("01"), 1, 38).unwrap();
    assert_eq!(told(), (Progress::Running, 1));
    again.note(log::LEFT, "0 of 38 answered").unwrap();
    drop(again);
    assert_eq!(told(), (Progress::Left, 1));
}

/// Two stations: no lock of one is seen by the other.
#[test]
fn another_station_is_refused_while_the_heart_beats_and_takes_over_when_it_stands_still() {
    let folder = tempfile::tempdir().unwrap();
    let alpha = open(folder.path()).at_station("alpha");
    let beta = open(folder.path()).at_station("beta");
    let (mut running, _) = alpha.session(&code("01"), 1, 38).unwrap();
    running.begin(3).unwrap();
    let error = beta.session(&code("01"), 1, 38).unwrap_err();
    assert!(matches!(&error, RecordError::Locked { station, .. } if station == "alpha"), "{error}");
    let journal = running.journal().to_path_buf();
    running.claim.tell(|heartbeat| heartbeat.trial = 3);
    kill(running);
    let (mut second, _) = beta.session(&code("01"), 1, 38).unwrap();
    let text = std::fs::read_to_string(&journal).unwrap();
    assert!(text.contains("\tcrashed\talpha, process "), "{text}");
    assert!(text.contains(", trial 3 of 38, last heard "), "{text}");
    // The fourth trial begins, and the first one counts on.
    assert_eq!((second.begin(3).unwrap(), second.begin(4).unwrap()), (2, 1));
}

/// A page may follow every answer, and the next trial only when it was read.
#[test]
fn a_session_runs_from_a_trials_beginning_to_its_answer() {
    let folder = tempfile::tempdir().unwrap();
    let (mut recorder, _) = open(folder.path()).session(&code("01"), 1, 38).unwrap();
    let told = |recorder: &Recorder| {
        let mut told = (State::Ended, 0, 0);
        recorder.claim.tell(|h| told = (h.state, h.trial, h.late_frames));
        told
    };
    assert_eq!(told(&recorder), (State::Paused, 0, 0));
    recorder.begin(1).unwrap();
    assert_eq!(told(&recorder), (State::Running, 1, 0));
    recorder.write(&response(1)).unwrap();
    assert_eq!(told(&recorder), (State::Paused, 1, response(1).untimely_frames()));
    recorder.begin(2).unwrap();
    assert_eq!(told(&recorder).0, State::Running);
    recorder.set_aside(2, "no answer in time", None).unwrap();
    assert_eq!(told(&recorder).0, State::Paused);
}

/// Claims are not synced: after a power cut there may be nothing in one, or half of it.
#[test]
fn a_claim_that_a_power_cut_has_torn_locks_nobody_out() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    for (subject, kept) in [("01", 0), ("02", 40)] {
        let (mut recorder, _) = study.session(&code(subject), 1, 38).unwrap();
        recorder.begin(1).unwrap();
        let journal = recorder.journal().to_path_buf();
        let claims = recorder.claim.folder().to_path_buf();
        let before = std::fs::read(&journal).unwrap();
        kill(recorder);
        std::fs::write(&journal, before).unwrap();
        let claim = std::fs::read(last_of(&claims)).unwrap();
        std::fs::write(last_of(&claims), &claim[..kept]).unwrap();
    }
    let seen = status(folder.path(), StudyKind::Real, |_| None).unwrap();
    let states: Vec<_> = seen.sessions.iter().map(|s| (s.state, s.crashes)).collect();
    assert_eq!((states, seen.faults), (vec![(Progress::Crashed, 1); 2], vec![]));
    for subject in ["01", "02"] {
        let (mut recorder, _) = study.session(&code(subject), 1, 38).unwrap();
        assert_eq!(recorder.begin(1).unwrap(), 2);
        assert_eq!(Story::read(recorder.journal()).unwrap().crashes, 1);
    }
}

#[test]
fn a_session_that_is_left_while_another_station_waits_has_not_crashed() {
    let folder = tempfile::tempdir().unwrap();
    let (alpha, beta) =
        (open(folder.path()).at_station("alpha"), open(folder.path()).at_station("beta"));
    let (mut running, _) = alpha.session(&code("01"), 1, 38).unwrap();
    let next = std::thread::scope(|scope| {
        let next = scope.spawn(|| beta.session(&code("01"), 1, 38).unwrap().0);
        // Beta has found the claim open by now, and waits for another heartbeat.
        std::thread::sleep(heartbeat::PATIENCE / 5);
        running.note(log::LEFT, "0 of 38 answered").unwrap();
        drop(running);
        next.join().unwrap()
    });
    assert_eq!(Story::read(next.journal()).unwrap().crashes, 0);
    assert!(last_of(next.claim.folder()).ends_with("2.json"));
}

/// A computer that was asleep wakes up after another one has taken the session over.
#[test]
fn a_program_that_was_taken_over_writes_nothing_more() {
    let folder = tempfile::tempdir().unwrap();
    let alpha = open(folder.path()).at_station("alpha");
    let (mut asleep, _) = alpha.session(&code("01"), 1, 38).unwrap();
    asleep.begin(1).unwrap();
    // It may have gone on from station to station meanwhile.
    std::fs::copy(asleep.claim.folder().join("1.json"), asleep.claim.folder().join("3.json"))
        .unwrap();
    let before = std::fs::read(asleep.journal()).unwrap();
    let error = asleep.begin(2).unwrap_err();
    assert!(matches!(error, RecordError::TakenOver { .. }), "{error}");
    assert_eq!(std::fs::read(asleep.journal()).unwrap(), before);
}

#[test]
fn trials_set_aside_are_known_when_the_session_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    let (mut recorder, _) = study.session(&code("01"), 1, 38).unwrap();
    recorder.set_aside(5, "late frames", None).unwrap();
    recorder.set_aside(2, "no answer in time", None).unwrap();
    assert_eq!(recorder.trials_set_aside(), [5, 2]);
    drop(recorder);
    let (recorder, _) = study.session(&code("01"), 1, 38).unwrap();
    assert_eq!(recorder.trials_set_aside(), [5, 2]);
}

#[test]
fn a_torn_row_is_moved_to_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let study = open(folder.path());
    let path = study.session(&code("01"), 1, 38).unwrap().0.data_file().to_path_buf();
    let header = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{header}demo,01,1,he")).unwrap();
    let (_recorder, rows) = study.session(&code("01"), 1, 38).unwrap();
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
    let error = Study::open(&file.join("study"), &protocol(), StudyKind::Real).unwrap_err();
    assert!(error.to_string().contains("plain/study/data"), "{error}");
}

#[test]
fn thumbnails_show_the_middle_frame() {
    let (stimuli, folder) = (rendered(), tempfile::tempdir().unwrap());
    let set = StimulusSet::open(&protocol(), stimuli.path()).unwrap();
    open(folder.path()).keep_thumbnails(&set).unwrap();
    let thumbnail = folder.path().join("thumbnails/M2-S2-T4-A4.png");
    let original = stimuli.path().join("M2-S2-T4-A4/frame-0001.png");
    use shutterlab_stimuli::frames::EncodedImage;
    assert_eq!(
        EncodedImage::read_png(&thumbnail).unwrap(),
        EncodedImage::read_png(&original).unwrap()
    );
}
