//! Sessions on a simulated display: order of events, ignored inputs, late frames, failing writers.

use super::*;
use crate::design::plan;
use crate::presenter::{Presenter, SimulatedDisplay, show};
use crate::random::Stream;
use crate::test_support::{rendered, small_protocol};
use shutterlab_data_schema::protocol::{Pairs, Still};
use shutterlab_data_schema::response::{Side, TrialKind};
use std::io;

/// Notes what it is asked to do; fails as often as told.
#[derive(Default)]
struct FakeWriter {
    events: Vec<String>,
    rows: Vec<Response>,
    set_aside: Vec<u32>,
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

    fn frame_times(&mut self, _: u32, _: u32, _: &[FrameTime]) {}

    fn set_aside(
        &mut self,
        trial: u32,
        why: &str,
        _: Option<&Response>,
    ) -> Result<(), RecordError> {
        self.events.push(format!("aside {trial} {why}"));
        self.set_aside.push(trial);
        Ok(())
    }
}

struct Sitting {
    session: Session,
    display: SimulatedDisplay,
    writer: FakeWriter,
}

/// Who answers on a display of `refresh_hz`.
fn identity(refresh_hz: f64) -> Identity {
    Identity {
        subject: "01".parse().unwrap(),
        session: 1,
        station: "here".into(),
        observer: "participant".into(),
        kind: TrialKind::Real,
        pilot: false,
        viewing: SimulatedDisplay::new(refresh_hz).viewing(),
    }
}

impl Sitting {
    /// Three stimuli: one trial of practice and three that count, a break after two of them.
    fn new(refresh_hz: f64) -> Self {
        Self::of(small_protocol(), refresh_hz)
    }

    fn of(protocol: Protocol, refresh_hz: f64) -> Self {
        let set = Arc::new(StimulusSet::open(&protocol, rendered().path()).unwrap());
        let plan = plan(&protocol, &set.pool(), 9, 1).unwrap();
        let session = Session::new(protocol, set, identity(refresh_hz), plan, &[], &[]);
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
            _ => sitting.begin(),
        }
    }
    assert_eq!(pages, [Page::Instructions, Page::AfterPractice, Page::Pause, Page::End]);
    let expected: Vec<String> =
        (1..=4).flat_map(|n| [format!("begin {n}"), format!("write {n}")]).collect();
    assert_eq!(sitting.writer.events, expected);
    let rows = &sitting.writer.rows;
    assert_eq!((rows[0].kind, rows[1].kind), (TrialKind::Practice, TrialKind::Real));
    assert_eq!(rows[0].correct, Some(rows[0].selected.as_deref() == Some("M2-S2-T3-A5")));
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
    assert_eq!(row.answered_at, "1970-01-01T00:00:00.000000Z");
}

#[test]
fn inputs_before_both_sequences_were_seen_are_ignored() {
    let mut sitting = Sitting::new(60.0);
    sitting.input(Input::Answer(Answer::First));
    sitting.input(Input::Continue);
    sitting.begin();
    for interval in [0, 1] {
        sitting.until(|screen| screen == Screen::Frame { interval, index: 1 });
        sitting.input(Input::Answer(Answer::First));
        sitting.input(Input::Replay(0));
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
    for interval in [0, 1, 1] {
        sitting.input(Input::Replay(interval));
        sitting.until(|screen| screen == Screen::Frame { interval, index: 2 });
        sitting.until(|screen| screen == Screen::Question);
    }
    sitting.input(Input::Replay(0));
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
    sitting.until(|screen| screen == Screen::Frame { interval: 1, index: 0 });
    // The display stands still for four refreshes: frame 0 stays, frame 1 is never shown, frame 2
    // comes one refresh late.
    sitting.display.wait(4.0 / 60.0);
    sitting.until(|screen| screen == Screen::Question);
    sitting.answer(Answer::First);
    let row = &sitting.writer.rows[0];
    let of_a = [row.late_frames_a, row.dropped_frames_a, row.repeated_frames_a];
    let of_b = [row.late_frames_b, row.dropped_frames_b, row.repeated_frames_b];
    let (first, second) = if row.first == Side::A { (of_a, of_b) } else { (of_b, of_a) };
    assert_eq!((first, second), ([0, 0, 0], [1, 1, 1]));
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
        Session::new(protocol.clone(), set.clone(), identity.clone(), plan.clone(), answered, &[])
    };
    let session = of(&[1, 3]);
    assert_eq!(session.trial().map(|t| t.number), Some(2));
    assert_eq!(session.upcoming().map(|t| t.number), Some(4));
    let progress = session.progress().unwrap();
    assert_eq!((progress.practice, progress.trial, progress.of), (false, 2, 3));
    assert_eq!(of(&[1, 2, 3, 4]).screen(0.0), Screen::Page(Page::End));
}

/// A protocol of one of the tasks, with rules by chance.
fn any_protocol(stream: &mut Stream) -> Protocol {
    let mut protocol = small_protocol();
    protocol.task = [Task::TwoAfc, Task::Matching, Task::SameDifferent][stream.below(3)];
    if protocol.task == Task::SameDifferent {
        protocol.design.pairs = Pairs::GroundTruth;
        protocol.design.ground_truth = [("shutter".to_string(), "T3".to_string())].into();
        protocol.design.identical_pairs = 1;
    }
    protocol.catch = protocol.practice.clone();
    protocol.not_sure = (stream.below(2) == 0).then(|| "I cannot tell".into());
    protocol.timeline.fixation_s = [0.0, 0.1][stream.below(2)];
    protocol.timeline.response_window_s = [None, Some(0.5)][stream.below(2)];
    protocol.timeline.replays = stream.below(3) > 0;
    protocol.timeline.still = (stream.below(3) == 0).then_some(Still { frame: 1, seconds: 0.2 });
    protocol.presentation.late_frames = [LateFrames::Keep, LateFrames::Repeat][stream.below(2)];
    protocol
}

fn any_input(stream: &mut Stream) -> Input {
    match stream.below(9) {
        0 | 1 => Input::Continue,
        2 => Input::Answer(Answer::First),
        3 => Input::Answer(Answer::Same),
        4 => Input::Answer(Answer::Different),
        5 => Input::Answer(Answer::NotSure),
        6 | 7 => Input::Replay(stream.below(4)),
        _ => Input::Interrupt,
    }
}

/// Answers, replays, pages, Escape, held-up displays, failing disks, crashes and clocks that jump, in
/// any order: each trial is answered exactly once, and nothing that was written is lost.
#[test]
fn any_sequence_of_events_answers_each_trial_exactly_once() {
    let folder = rendered();
    let (mut crashes, mut set_aside) = (0, 0);
    for seed in 0..1500 {
        let mut stream = Stream::new(seed);
        let protocol = any_protocol(&mut stream);
        let set = Arc::new(StimulusSet::open(&protocol, folder.path()).unwrap());
        let plan = plan(&protocol, &set.pool(), seed, 1).unwrap();
        let mut writer = FakeWriter::default();
        let mut display = SimulatedDisplay::new(60.0);
        let open = |writer: &FakeWriter| {
            let identity = identity(60.0);
            let answered: Vec<u32> = writer.rows.iter().map(|row| row.trial).collect();
            let (protocol, set) = (protocol.clone(), set.clone());
            Session::new(protocol, set, identity, plan.clone(), &answered, &writer.set_aside)
        };
        let mut session = open(&writer);
        let mut events = 300;
        loop {
            // After so many events, everything goes as it should.
            let calm = events == 0;
            events -= u32::from(!calm);
            let mut now_s = display.now_s();
            match if calm { 99 } else { stream.below(40) } {
                0 => {
                    // Nothing is left but what was written.
                    session = open(&writer);
                    crashes += 1;
                }
                1 => writer.failures = stream.below(3) as u32,
                2 => display.wait(0.3 * stream.uniform()),
                3 => now_s += 20.0 * (stream.uniform() - 0.5),
                4..10 => session.input(any_input(&mut stream), now_s, Timestamp::UNIX_EPOCH),
                _ => {}
            }
            let screen = session.screen(now_s);
            if let Some(at_s) = display.present(screen).unwrap() {
                session.shown(screen, at_s);
            }
            if session.save(&mut writer).is_ok() && !session.has_answer() {
                session.begin(now_s, &mut writer).unwrap();
            }
            if calm {
                writer.failures = 0;
                match screen {
                    Screen::Page(_) => session.input(Input::Continue, now_s, Timestamp::UNIX_EPOCH),
                    Screen::Question => {
                        let answer = session.answers()[0];
                        session.input(
                            Input::Answer(answer),
                            display.now_s(),
                            Timestamp::UNIX_EPOCH,
                        );
                    }
                    Screen::Over => break,
                    _ => {}
                }
            }
        }
        set_aside += writer.set_aside.len();
        let mut answered: Vec<u32> = writer.rows.iter().map(|row| row.trial).collect();
        // In the order of the plan, but for what was set aside.
        let straight: Vec<u32> =
            answered.iter().copied().filter(|n| !writer.set_aside.contains(n)).collect();
        assert!(straight.is_sorted(), "seed {seed}: {straight:?}");
        answered.sort_unstable();
        let all: Vec<u32> = plan.iter().map(|trial| trial.number).collect();
        assert_eq!(answered, all, "seed {seed}");
        for row in &writer.rows {
            let begun = format!("begin {}", row.trial);
            let times = writer.events.iter().filter(|event| **event == begun).count();
            assert_eq!(row.attempt as usize, times, "seed {seed}, trial {}", row.trial);
            assert!(row.onset_a_s.is_finite() && row.response_time_s.is_finite());
        }
    }
    assert!(crashes > 1000 && set_aside > 100, "{crashes} crashes, {set_aside} set aside");
}

#[test]
fn a_trial_with_late_frames_comes_again_at_the_end_if_the_protocol_says_so() {
    let mut protocol = small_protocol();
    protocol.presentation.late_frames = LateFrames::Repeat;
    let mut sitting = Sitting::of(protocol, 60.0);
    let mut order = vec![];
    loop {
        match show(&mut sitting.session, &mut sitting.display).unwrap() {
            Screen::Page(_) => sitting.input(Input::Continue),
            // The second trial is always late.
            Screen::Frame { index: 1, .. }
                if sitting.session.trial().is_some_and(|trial| trial.number == 2) =>
            {
                sitting.display.wait(0.1);
            }
            Screen::Question => {
                order.extend(sitting.session.trial().map(|trial| trial.number));
                sitting.answer(Answer::First);
            }
            Screen::Over => break,
            _ => sitting.begin(),
        }
    }
    // Twice it is asked again, then its answer is kept and says so.
    assert_eq!(order, [1, 2, 3, 4, 2, 2]);
    let rows: Vec<(u32, u32)> = sitting.writer.rows.iter().map(|r| (r.trial, r.attempt)).collect();
    assert_eq!(rows, [(1, 1), (3, 1), (4, 1), (2, 3)]);
    assert!(sitting.writer.rows[3].untimely_frames() > 0);
    assert_eq!(sitting.writer.set_aside, [2, 2]);
}

#[test]
fn a_question_whose_time_is_up_comes_again_at_the_end() {
    let mut protocol = small_protocol();
    protocol.timeline.response_window_s = Some(1.0);
    let mut sitting = Sitting::of(protocol, 60.0);
    sitting.first_question();
    sitting.answer(Answer::First);
    sitting.until(|screen| screen == Screen::Page(Page::AfterPractice));
    sitting.input(Input::Continue);
    sitting.begin();
    sitting.until(|screen| screen == Screen::Question);
    sitting.until(|screen| screen == Screen::Grey);
    sitting.input(Input::Answer(Answer::First));
    sitting.session.save(&mut sitting.writer).unwrap();
    assert_eq!(sitting.session.screen(sitting.display.now_s()), Screen::Page(Page::TooSlow));
    let left: Vec<u32> =
        sitting.session.queue.iter().map(|&p| sitting.session.plan[p].number).collect();
    assert_eq!(left, [3, 4, 2]);
    assert_eq!(sitting.writer.rows.len(), 1);
}

#[test]
fn a_matching_trial_shows_the_reference_then_both_candidates() {
    let mut protocol = small_protocol();
    protocol.task = Task::Matching;
    let mut sitting = Sitting::of(protocol, 60.0);
    sitting.first_question();
    sitting.input(Input::Replay(0));
    sitting.until(|screen| screen == Screen::Frame { interval: 0, index: 2 });
    sitting.until(|screen| screen == Screen::Question);
    let right = sitting.session.trial().and_then(|trial| trial.right).unwrap();
    sitting.answer(right);
    let row = &sitting.writer.rows[0];
    assert_eq!((row.correct, &row.selected), (Some(true), &row.reference));
    assert_eq!((row.replays_reference, row.replays_a, row.replays_b), (Some(1), 0, 0));
    // Half a second of grey, 0.1 s of reference, grey, the left one, grey, the right one.
    let (left, other) = match row.first {
        Side::A => (row.onset_a_s, row.onset_b_s),
        Side::B => (row.onset_b_s, row.onset_a_s),
    };
    let onsets = [row.onset_reference_s.unwrap(), left, other];
    for (onset, expected) in onsets.into_iter().zip([0.5, 1.1, 1.7]) {
        assert!((onset - expected).abs() < 1e-6, "{onsets:?}");
    }
    assert!((row.duration_a_s - 0.1).abs() < 1e-6);
}

#[test]
fn same_and_different_are_asked_about_both_at_once() {
    let mut protocol = small_protocol();
    protocol.task = Task::SameDifferent;
    protocol.design.pairs = Pairs::GroundTruth;
    protocol.design.ground_truth = [("shutter".to_string(), "T3".to_string())].into();
    protocol.timeline.still = Some(Still { frame: 2, seconds: 0.25 });
    let mut sitting = Sitting::of(protocol, 60.0);
    assert_eq!(sitting.session.answers(), [Answer::Same, Answer::Different]);
    sitting.first_question();
    sitting.input(Input::Answer(Answer::First));
    assert!(!sitting.session.has_answer());
    sitting.answer(Answer::Different);
    let row = &sitting.writer.rows[0];
    assert_eq!((row.correct, &row.selected), (Some(true), &None));
    assert_eq!(row.reference.as_deref(), Some("M2-S2-T3-A5"));
    assert_eq!((row.onset_a_s, row.duration_a_s), (row.onset_b_s, row.duration_b_s));
    assert!((row.duration_a_s - 0.25).abs() < 1e-6);
}
