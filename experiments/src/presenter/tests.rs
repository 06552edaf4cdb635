//! Against displays with known refreshes: every frame on its refresh, every planted fault found, none
//! invented. What should be found is derived here from the times at which the display says it showed
//! something, refresh by refresh, and not by the code under test.

use super::*;
use crate::design::plan;
use crate::playback::FrameTime;
use crate::random::Stream;
use crate::record::{RecordError, ResponseWriter};
use crate::session::{Identity, Input};
use crate::stimuli_set::StimulusSet;
use crate::test_support::{rendered_as, small_protocol};
use jiff::Timestamp;
use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::response::{Answer, Response, Side, TrialKind};
use std::sync::Arc;

const FPS: f64 = 30.0;
const FRAMES: u32 = 24;

#[derive(Default)]
struct Kept(Vec<Response>);

impl ResponseWriter for Kept {
    fn begin(&mut self, _: u32) -> Result<u32, RecordError> {
        Ok(1)
    }
    fn write(&mut self, response: &Response) -> Result<(), RecordError> {
        self.0.push(response.clone());
        Ok(())
    }
    fn frame_times(&mut self, _: u32, _: u32, _: &[FrameTime]) {}

    fn set_aside(&mut self, _: u32, _: &str, _: Option<&Response>) -> Result<(), RecordError> {
        unreachable!("the protocol keeps late trials")
    }
}

fn protocol() -> Protocol {
    let mut protocol = small_protocol();
    protocol.practice.clear();
    protocol
}

fn set() -> Arc<StimulusSet> {
    let folder = rendered_as(|grid| grid.image.frames = FRAMES);
    Arc::new(StimulusSet::open(&protocol(), folder.path()).unwrap())
}

/// What was on the display and since when, as the display itself had it.
type Seen = Vec<(Screen, f64)>;

/// Answers one trial on `display` and says what was to be seen.
fn one_trial(set: &Arc<StimulusSet>, display: &mut SimulatedDisplay) -> (Response, Seen) {
    let (protocol, set) = (protocol(), set.clone());
    let identity = Identity {
        subject: "01".parse().unwrap(),
        session: 1,
        station: "here".into(),
        observer: "participant".into(),
        kind: TrialKind::Real,
        pilot: false,
        viewing: display.viewing(),
    };
    let plan = plan(&protocol, &set.pool(), 9, 1).unwrap();
    let mut session = Session::new(protocol, set, identity, plan, &[], &[]);
    let (mut kept, mut seen) = (Kept::default(), Seen::new());
    session.input(Input::Continue, display.now_s(), Timestamp::UNIX_EPOCH);
    session.begin(display.now_s(), &mut kept).unwrap();
    while kept.0.is_empty() {
        let screen = session.screen(display.now_s());
        let at_s = display.present(screen).unwrap().unwrap();
        session.shown(screen, at_s);
        seen.push((screen, at_s));
        if screen == Screen::Question {
            session.input(Input::Answer(Answer::First), display.now_s(), Timestamp::UNIX_EPOCH);
            session.save(&mut kept).unwrap();
        } else if let Some(next_s) = session.next_change_s() {
            display.wait_until(next_s);
        }
    }
    (kept.0.remove(0), seen)
}

/// Late, dropped and repeated frames of an interval, in steps of `step_s` of which each frame should
/// take `per_frame`: looked up step by step.
fn expected(seen: &Seen, interval: usize, step_s: f64, per_frame: f64) -> (u32, u32, u32) {
    let is_frame =
        |screen: &Screen| matches!(screen, Screen::Frame { interval: i, .. } if *i == interval);
    let start = seen.iter().position(|(screen, _)| is_frame(screen)).unwrap();
    let onset_s = seen[start].1;
    let on_display = |step: u64| {
        let moment_s = onset_s + (step as f64 + 0.5) * step_s;
        let (screen, _) = seen.iter().rfind(|(_, at_s)| *at_s <= moment_s).unwrap();
        match screen {
            Screen::Frame { interval: i, index } if *i == interval => Some(*index),
            _ => None,
        }
    };
    let due = |step: u64| ((step as f64 + 1e-6) / per_frame).floor() as u32;
    let first_due = |index: u32| (0..).find(|&step| due(step) >= index).unwrap();
    let mut counts = (0, 0, 0);
    for index in 0..FRAMES {
        let steps: Vec<u64> = (0..2000).filter(|&step| on_display(step) == Some(index)).collect();
        match (steps.first(), steps.last()) {
            (Some(&first), Some(&last)) => {
                counts.0 += u32::from(first > first_due(index));
                counts.2 += u32::from(last >= first_due(index + 1));
            }
            _ => counts.1 += 1,
        }
    }
    counts
}

/// Holds the row of a trial against what was to be seen.
fn check(response: &Response, seen: &Seen, step_s: f64, per_frame: f64, what: &str) -> u32 {
    let of_a = (response.late_frames_a, response.dropped_frames_a, response.repeated_frames_a);
    let of_b = (response.late_frames_b, response.dropped_frames_b, response.repeated_frames_b);
    let [first, second] = match response.first {
        Side::A => [of_a, of_b],
        Side::B => [of_b, of_a],
    };
    assert_eq!(first, expected(seen, 0, step_s, per_frame), "{what}, first");
    assert_eq!(second, expected(seen, 1, step_s, per_frame), "{what}, second");
    [first, second].into_iter().map(|(late, dropped, repeated)| late + dropped + repeated).sum()
}

#[test]
fn without_faults_every_frame_is_on_its_refresh() {
    let set = set();
    for (hz, per_frame) in [
        (60.0, 2.0),
        (59.94, 2.0),
        (120.0, 4.0),
        (119.88, 4.0),
        (144.0, 4.8),
        (75.0, 2.5),
        (30.0, 1.0),
    ] {
        let mut display = SimulatedDisplay::new(hz);
        let (response, seen) = one_trial(&set, &mut display);
        assert_eq!(check(&response, &seen, 1.0 / hz, per_frame, &format!("{hz} Hz")), 0);
        assert_eq!(
            response.refreshes_per_frame.map(|n| n.fract() == 0.0),
            Some(per_frame.fract() == 0.0)
        );
        // Each interval lasts as long as its refreshes.
        let lasts_s = (f64::from(FRAMES) * per_frame).ceil() / hz;
        for duration_s in [response.duration_a_s, response.duration_b_s] {
            assert!((duration_s - lasts_s).abs() < 1e-5, "{hz} Hz: {duration_s}");
        }
    }
    // However far the program is ahead of the display.
    for (hz, per_frame) in [(60.0, 2.0), (59.94, 2.0), (144.0, 4.8)] {
        for screens in 0..4 {
            let mut display = SimulatedDisplay::new(hz).with_queue(screens);
            let (response, _) = one_trial(&set, &mut display);
            let what = format!("{hz} Hz, queue of {screens}");
            assert_eq!(response.untimely_frames(), 0, "{what}");
            assert_eq!(response.repeated_frames_a + response.repeated_frames_b, 0, "{what}");
            let lasts_s = (f64::from(FRAMES) * per_frame).ceil() / hz;
            assert!((response.duration_b_s - lasts_s).abs() < 1e-5, "{what}");
        }
    }
    let mut display = SimulatedDisplay::variable(144.0);
    let (response, seen) = one_trial(&set, &mut display);
    assert_eq!(check(&response, &seen, 1.0 / (4.0 * FPS), 4.0, "variable"), 0);
    assert!((response.duration_a_s - f64::from(FRAMES) / FPS).abs() < 1e-5);
    assert_eq!((response.refresh_hz, response.refreshes_per_frame), (None, None));
}

#[test]
fn every_planted_hold_up_is_in_the_data_and_none_is_invented() {
    let (set, mut found) = (set(), 0);
    for trial in 0..200 {
        let mut stream = Stream::new(trial);
        let rates = [(60.0, 2.0), (59.94, 2.0), (120.0, 4.0), (144.0, 4.8), (0.0, 4.0)];
        let (hz, per_frame) = rates[stream.below(rates.len())];
        let variable = hz == 0.0;
        let mut display = match variable {
            true => SimulatedDisplay::variable(144.0),
            false => SimulatedDisplay::new(hz),
        };
        let step_s = if variable { 1.0 / (4.0 * FPS) } else { 1.0 / hz };
        for number in 0..1 + stream.below(4) {
            // Off the grid, so that no moment lies between two steps; at a variable rate so that what
            // is shown is there in the middle of a step, too, which is where this test looks.
            let off = if variable { 0.25 } else { 0.75 };
            let late_s = (stream.below(12) as f64 + off) * step_s;
            let at_s = if variable { 1.0 + 0.5 * number as f64 } else { 1.0 };
            display.hold_up(at_s + if variable { 0.1 } else { 2.0 } * stream.uniform(), late_s);
        }
        let (response, seen) = one_trial(&set, &mut display);
        found += check(&response, &seen, step_s, per_frame, &format!("trial {trial}, {hz} Hz"));
    }
    assert!(found > 200, "hardly any hold-up was planted: {found}");
}
