//! Whole sessions of simulated observers: resumed ones give the same rows as undisturbed ones.

use super::*;
use crate::playback::FrameTime;
use crate::test_support::{protocol, rendered};
use shutterlab_data_schema::response::Clock;
use shutterlab_data_schema::study::data_files;
use std::io;
use std::path::Path;

fn request(stimuli: &Path, study: &Path, code: &str) -> SessionRequest {
    SessionRequest {
        protocol: protocol(),
        stimuli: stimuli.into(),
        study: study.into(),
        participant: Some(code.parse().unwrap()),
        pilot: false,
    }
}

fn rows(file: &Path) -> Vec<Response> {
    csv::Reader::from_path(file).unwrap().deserialize().map(|row| row.unwrap()).collect()
}

/// The rows without what differs from one run to the next: calendar time, and places in the
/// session's own time, which begins anew when a session is resumed.
fn timeless(file: &Path) -> Vec<Response> {
    let mut rows = rows(file);
    for row in &mut rows {
        row.answered_at.clear();
        (row.onset_a_s, row.onset_b_s, row.response_time_s) = (0.0, 0.0, 0.0);
    }
    rows
}

/// Writes until it has written `left` answers, then dies.
struct DyingWriter<'a> {
    recorder: &'a mut Recorder,
    left: u32,
}

impl ResponseWriter for DyingWriter<'_> {
    fn begin(&mut self, trial: u32) -> Result<u32, RecordError> {
        self.recorder.begin(trial)
    }

    fn write(&mut self, response: &Response) -> Result<(), RecordError> {
        if self.left == 0 {
            return Err(io::Error::other("killed").into());
        }
        self.left -= 1;
        self.recorder.write(response)
    }

    fn frame_times(&mut self, _: u32, _: u32, _: &[FrameTime]) {}

    fn set_aside(
        &mut self,
        trial: u32,
        why: &str,
        response: Option<&Response>,
    ) -> Result<(), RecordError> {
        self.recorder.set_aside(trial, why, response)
    }
}

/// Runs the session of `request` until it dies after `answers` of them.
fn run_until(request: &SessionRequest, answers: u32) {
    let subject = request.participant.clone().unwrap();
    let set = Arc::new(StimulusSet::open(&request.protocol, &request.stimuli).unwrap());
    let guess = SimulatedObserver::guess();
    let instructed = guess.instruct(&set, &request.protocol).unwrap();
    let entry = Entry::observer(&subject, &guess.name());
    let mut sitting = Sitting::open(request, set, &entry).unwrap();
    let mut display = simulated_display(&sitting.set);
    let mut session = sitting.session(display.viewing());
    let mut writer = DyingWriter { recorder: &mut sitting.recorder, left: answers };
    let judge = instructed.judge(request.protocol.seed, &subject, SESSION, 37);
    drive(&mut session, &mut display, &judge, &mut writer, |_| Timestamp::now()).unwrap_err();
}

#[test]
fn a_whole_session_answers_every_pair_once() {
    let (stimuli, study) = (rendered(), tempfile::tempdir().unwrap());
    let request = request(stimuli.path(), study.path(), "S01");
    let outcome = run_simulated(&request, &SimulatedObserver::guess()).unwrap();
    assert_eq!((outcome.answered_now, outcome.answered_before, outcome.finished), (37, 0, true));
    let rows = rows(&outcome.data_file);
    assert_eq!(rows.iter().map(|row| row.trial).collect::<Vec<_>>(), (1..=37).collect::<Vec<_>>());
    assert_eq!((rows[0].kind, rows[0].block), (TrialKind::Practice, 0));
    assert!(rows[1..].iter().all(|r| r.kind == TrialKind::Simulated));
    assert!(rows.iter().all(|row| {
        row.observer == "simulated:guess"
            && row.clock == Clock::Simulated
            && row.late_frames_a + row.late_frames_b == 0
            && row.attempt == 1
    }));
    assert_eq!(data_files(&study.path().join("simulated")).unwrap(), [outcome.data_file]);
}

#[test]
fn a_resumed_session_gives_the_rows_of_an_undisturbed_one() {
    let stimuli = rendered();
    let (whole, broken) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let guess = SimulatedObserver::guess();
    let expected = run_simulated(&request(stimuli.path(), whole.path(), "S01"), &guess).unwrap();

    let request = request(stimuli.path(), broken.path(), "S01");
    run_until(&request, 5);
    run_until(&request, 0);
    let outcome = run_simulated(&request, &guess).unwrap();
    assert_eq!((outcome.answered_now, outcome.answered_before, outcome.finished), (32, 5, true));

    let mut rows = timeless(&outcome.data_file);
    // The sixth trial was begun three times; everything else is the same.
    assert_eq!(rows[5].attempt, 3);
    rows[5].attempt = 1;
    assert_eq!(rows, timeless(&expected.data_file));
}

#[test]
fn a_finished_session_is_left_as_it_is() {
    let (stimuli, study) = (rendered(), tempfile::tempdir().unwrap());
    let request = request(stimuli.path(), study.path(), "S01");
    let first = run_simulated(&request, &SimulatedObserver::guess()).unwrap();
    let before = std::fs::read(&first.data_file).unwrap();
    let again = run_simulated(&request, &SimulatedObserver::guess()).unwrap();
    assert_eq!((again.answered_now, again.answered_before, again.finished), (0, 37, true));
    assert_eq!(std::fs::read(&first.data_file).unwrap(), before);
}

#[test]
fn observers_differ_in_order_and_answers() {
    let (stimuli, study) = (rendered(), tempfile::tempdir().unwrap());
    let run = |code| {
        let request = request(stimuli.path(), study.path(), code);
        timeless(&run_simulated(&request, &SimulatedObserver::guess()).unwrap().data_file)
    };
    let pairs = |rows: &[Response]| -> Vec<(String, String)> {
        rows.iter().map(|row| (row.stimulus_a.clone(), row.stimulus_b.clone())).collect()
    };
    assert_ne!(pairs(&run("S01")), pairs(&run("S02")));
}

#[test]
fn a_session_does_not_go_on_with_other_stimuli() {
    let (stimuli, study) = (rendered(), tempfile::tempdir().unwrap());
    let request = request(stimuli.path(), study.path(), "S01");
    run_until(&request, 5);
    let file = data_files(&study.path().join("simulated")).unwrap().remove(0);
    let text = std::fs::read_to_string(&file).unwrap();
    let hash = rows(&file)[2].hash_a.clone();
    std::fs::write(&file, text.replace(&hash, "0000")).unwrap();
    let error = run_simulated(&request, &SimulatedObserver::guess()).unwrap_err().to_string();
    assert!(error.contains("hash_") && error.contains("0000, now"), "{error}");
}

#[test]
fn a_simulated_observer_needs_a_code() {
    let (stimuli, study) = (rendered(), tempfile::tempdir().unwrap());
    let mut request = request(stimuli.path(), study.path(), "S01");
    request.participant = None;
    let error = run_simulated(&request, &SimulatedObserver::guess()).unwrap_err();
    assert!(matches!(error, RunError::NoCode));
}
