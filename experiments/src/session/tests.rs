//! Sessions on a simulated display: order of events, ignored inputs, late frames, failing writers.

use super::*;
use crate::design::plan;
use crate::presenter::{Presenter, SimulatedDisplay, show};
use crate::test_support::{rendered, small_protocol};
use std::io;

/// Notes what it is asked to do; fails as often as told.
#[derive(Default)]
struct FakeWriter {
    events: Vec<String>,
    rows: Vec<Response>,
    failures: u32,
}

impl ResponseWriter for FakeWriter {
    fn begin(&mut self, trial: u32) -> Result<u32, RecordError> {
        self.events.push(format!("begin {trial}"));
        Ok(self.events.iter().filter(|e| **e == format!("begin {trial}")).count() as u32)
    }

    fn write(&mut self, response: &Response) -> Result<(), RecordError> {
        if self.failures > 0 {
            self.failures -= 1;
            return Err(io::Error::new(io::ErrorKind::StorageFull, "no space").into());
        }
        self.events.push(format!("write {}", response.trial));
        self.rows.push(response.clone());
        Ok(())
    }
}

struct Sitting {
    session: Session,
    display: SimulatedDisplay,
    writer: FakeWriter,
}

impl Sitting {
    /// Three stimuli: one trial of practice and three that count, a break after two of them.
    fn new(refresh_hz: f64) -> Self {
        let protocol = small_protocol();
        let set = Arc::new(StimulusSet::open(&protocol, rendered().path()).unwrap());
        let identity = Identity {
            subject: "01".parse().unwrap(),
            session: 1,
            station: "here".into(),
            observer: "participant".into(),
            kind: TrialKind::Real,
            display: "simulated".into(),
            clock: Clock::Simulated,
        };
        let plan = plan(&protocol.design, set.compared, &set.practice, 9);
        let session = Session::new(protocol, set, identity, plan, &[]);
        Self { session, display: SimulatedDisplay::new(refresh_hz), writer: FakeWriter::default() }
    }

    fn input(&mut self, input: Input) {
        self.session.input(input, self.display.now_s(), Timestamp::UNIX_EPOCH);
    }

    fn begin(&mut self) {
        self.session.begin(self.display.now_s(), &mut self.writer).unwrap();
    }

    /// Shows refresh after refresh until the screen is one that `stop` takes.
    fn until(&mut self, stop: impl Fn(Screen) -> bool) -> Screen {
        for _ in 0..10_000 {
            let screen = show(&mut self.session, &mut self.display).unwrap();
            if stop(screen) {
                return screen;
            }
        }
        panic!("never came");
    }

    /// From the instructions to the first question.
    fn first_question(&mut self) {
        self.input(Input::Continue);
        self.begin();
        self.until(|screen| screen == Screen::Question);
    }

    fn answer(&mut self, answer: Answer) {
        self.input(Input::Answer(answer));
        self.session.save(&mut self.writer).unwrap();
    }
}

#[test]
fn a_session_goes_from_instructions_to_end_and_writes_each_answer_before_the_next_trial() {
    let mut sitting = Sitting::new(60.0);
    let mut pages = vec![];
    loop {
        match show(&mut sitting.session, &mut sitting.display).unwrap() {
            Screen::Page(page) => {
                pages.push(page);
                sitting.input(Input::Continue);
            }
            Screen::Question => sitting.answer(Answer::First),
            Screen::Over => break,
            Screen::Grey | Screen::Frame { .. } => sitting.begin(),
        }
    }
    assert_eq!(pages, [Page::Instructions, Page::AfterPractice, Page::Pause, Page::End]);
    let expected: Vec<String> =
        (1..=4).flat_map(|n| [format!("begin {n}"), format!("write {n}")]).collect();
    assert_eq!(sitting.writer.events, expected);
    let rows = &sitting.writer.rows;
    assert_eq!((rows[0].kind, rows[1].kind), (TrialKind::Practice, TrialKind::Real));
    assert_eq!(rows[0].correct, Some(rows[0].selected == "M2-S2-T3-A5"));
    assert!(rows.iter().all(|row| row.late_frames_a + row.late_frames_b == 0), "{rows:?}");
    assert!(rows[1..].iter().all(|row| row.correct.is_none() && row.attempt == 1));
}

#[test]
fn times_are_those_of_the_display() {
    let mut sitting = Sitting::new(60.0);
    sitting.first_question();
    sitting.display.wait(1.0);
    sitting.answer(Answer::Second);
    let row = &sitting.writer.rows[0];
    let (first, second) = match row.first {
        Side::A => (row.onset_a_s, row.onset_b_s),
        Side::B => (row.onset_b_s, row.onset_a_s),
    };
    // Half a second of grey, three frames at 30 fps, half a second of grey.
    assert!((first - 0.5).abs() < 1e-6 && (second - 1.1).abs() < 1e-6, "{first} {second}");
    // The question is seen at one refresh, the answer comes 60 refreshes later.
    assert!((row.response_time_s - 61.0 / 60.0).abs() < 1e-6, "{}", row.response_time_s);
    assert_eq!(row.answered_at, "1970-01-01T00:00:00.000Z");
}

#[test]
fn inputs_before_both_sequences_were_seen_are_ignored() {
    let mut sitting = Sitting::new(60.0);
    sitting.input(Input::Answer(Answer::First));
    sitting.input(Input::Continue);
    sitting.begin();
    for interval in [Answer::First, Answer::Second] {
        sitting.until(|screen| screen == Screen::Frame { interval, index: 1 });
        sitting.input(Input::Answer(Answer::First));
        sitting.input(Input::Replay(Answer::First));
        sitting.input(Input::Continue);
        assert!(!sitting.session.has_answer());
        assert!(matches!(sitting.session.screen(sitting.display.now_s()), Screen::Frame { .. }));
    }
    sitting.until(|screen| screen == Screen::Question);
    sitting.answer(Answer::Second);
    let row = &sitting.writer.rows[0];
    assert_eq!((row.replays_a, row.replays_b, row.attempt), (0, 0, 1));
}

#[test]
fn replays_are_counted_and_an_answer_may_come_during_one() {
    let mut sitting = Sitting::new(60.0);
    sitting.first_question();
    for interval in [Answer::First, Answer::Second, Answer::Second] {
        sitting.input(Input::Replay(interval));
        sitting.until(|screen| screen == Screen::Frame { interval, index: 2 });
        sitting.until(|screen| screen == Screen::Question);
    }
    sitting.input(Input::Replay(Answer::First));
    sitting.until(|screen| matches!(screen, Screen::Frame { index: 1, .. }));
    sitting.answer(Answer::First);
    let row = &sitting.writer.rows[0];
    assert_eq!((row.replays_a, row.replays_b), (2, 2));
    assert_eq!((row.late_frames_a, row.late_frames_b), (0, 0));
}

#[test]
fn frames_held_up_or_skipped_are_counted_for_their_stimulus() {
    let mut sitting = Sitting::new(60.0);
    sitting.input(Input::Continue);
    sitting.begin();
    sitting.until(|screen| screen == Screen::Frame { interval: Answer::Second, index: 0 });
    // The display stands still for 75 ms: frame 1 is never shown, frame 2 comes late.
    sitting.display.wait(0.075);
    sitting.until(|screen| screen == Screen::Question);
    sitting.answer(Answer::First);
    let row = &sitting.writer.rows[0];
    let (first, second) = match row.first {
        Side::A => (row.late_frames_a, row.late_frames_b),
        Side::B => (row.late_frames_b, row.late_frames_a),
    };
    assert_eq!((first, second), (0, 2));
}

#[test]
fn an_interrupted_trial_is_begun_again() {
    let mut sitting = Sitting::new(60.0);
    sitting.input(Input::Continue);
    sitting.begin();
    sitting.until(|screen| matches!(screen, Screen::Frame { .. }));
    sitting.input(Input::Interrupt);
    assert_eq!(sitting.session.waiting().map(|t| t.number), Some(1));
    sitting.begin();
    sitting.until(|screen| screen == Screen::Question);
    sitting.input(Input::Interrupt);
    sitting.answer(Answer::First);
    assert_eq!((sitting.writer.rows[0].trial, sitting.writer.rows[0].attempt), (1, 2));
}

#[test]
fn an_answer_that_cannot_be_written_is_kept_and_the_trial_stays() {
    let mut sitting = Sitting::new(60.0);
    sitting.first_question();
    sitting.writer.failures = 2;
    sitting.input(Input::Answer(Answer::Second));
    for _ in 0..2 {
        let error = sitting.session.save(&mut sitting.writer).unwrap_err().to_string();
        assert!(error.contains("no space"), "{error}");
        assert!(sitting.session.has_answer());
        assert_eq!(sitting.session.trial().map(|t| t.number), Some(1));
        // Another key does not change the answer that was given.
        sitting.input(Input::Answer(Answer::First));
    }
    sitting.session.save(&mut sitting.writer).unwrap();
    assert_eq!(sitting.writer.rows[0].answer, Answer::Second);
    assert_eq!(sitting.session.trial().map(|t| t.number), Some(2));
}

#[test]
fn answered_trials_are_skipped() {
    let sitting = Sitting::new(60.0);
    let Session { protocol, set, identity, plan, .. } = sitting.session;
    let of = |answered: &[u32]| {
        Session::new(protocol.clone(), set.clone(), identity.clone(), plan.clone(), answered)
    };
    let session = of(&[1, 3]);
    assert_eq!(session.trial().map(|t| t.number), Some(2));
    assert_eq!(session.upcoming().map(|t| t.number), Some(4));
    assert_eq!(session.progress(), Some(Progress { practice: false, trial: 1, of: 3 }));
    assert_eq!(of(&[1, 2, 3, 4]).screen(0.0), Screen::Page(Page::End));
}
