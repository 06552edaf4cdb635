//! One participant's sitting as a state machine: no files, no window, no sleeping.
//!
//! ```text
//! Instructions → practice trials → AfterPractice → trials, a Pause between blocks → End → over
//!
//! a trial:  Blank ──begin()──► grey → fixation mark → interval → grey → interval → …
//!             ▲                                                                 │
//!             │ Interrupt                                                       ▼
//!             └──(from any state before the answer)           Question ⇄ replay of an interval
//!                                                                │ Answer    │ time is up
//!           next trial ◄──save() succeeds── Answered ◄───────────┴───────────┘
//! ```
//!
//! Whoever drives it asks for the [`Screen`] to show at a clock reading, reports when it was shown,
//! passes on the participant's inputs, prepares a trial's sequences before [`Session::begin`], and
//! lets [`Session::save`] write each answer. A session whose answer cannot be written stays where it
//! is, answer in hand, and can be asked to save again. Inputs that mean nothing at the moment (an
//! answer before everything was seen whole) are ignored.
//!
//! A trial whose time to answer is up, or whose frames were late where the protocol does not accept
//! that, is *set aside*: noted in the log and asked again at the end, of the practice or of all.

mod progress;
mod response;

pub use progress::Progress;
pub use response::{Identity, Viewing};

use crate::design::{Part, Trial};
use crate::playback::{Cadence, Faults, FrameTime, Playback};
use crate::record::{RecordError, ResponseWriter};
use crate::stimuli_set::StimulusSet;
use jiff::Timestamp;
use progress::Pace;
use shutterlab_data_schema::protocol::{LateFrames, Protocol, Task};
use shutterlab_data_schema::response::{Answer, Response};
use std::collections::VecDeque;
use std::sync::Arc;

/// What is to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Screen {
    /// A page of text, left by [`Input::Continue`].
    Page(Page),
    /// Neutral grey.
    Grey,
    /// The fixation mark on neutral grey.
    Fixation,
    /// A frame of what one of the trial's intervals shows.
    Frame {
        /// Number of the interval, from 0.
        interval: usize,
        /// Number of the frame.
        index: u32,
    },
    /// The question, with the choice of answering or seeing an interval again.
    Question,
    /// Nothing more: the session is over.
    Over,
}

/// A page of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// Before anything else.
    Instructions,
    /// Between practice and the trials that count.
    AfterPractice,
    /// A break.
    Pause,
    /// The time to answer was up.
    TooSlow,
    /// After the last trial.
    End,
}

/// What a participant can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Leaves a page.
    Continue,
    /// Answers the question.
    Answer(Answer),
    /// Asks to see an interval again.
    Replay(usize),
    /// Gives up the trial that is being shown; it will be shown again from its beginning, as another
    /// attempt. Without effect once the question is asked, unless its time is limited.
    Interrupt,
}

/// A trial is set aside for late frames so often at most; then its answer is kept and marked. On a
/// display that is always late a session would never end.
const MOST_LATE: u32 = 2;

/// A session under way.
#[derive(Debug)]
pub struct Session {
    protocol: Protocol,
    set: Arc<StimulusSet>,
    identity: Identity,
    plan: Vec<Trial>,
    /// Places in the plan of the trials to be asked, the present one first.
    queue: VecDeque<usize>,
    /// How often each trial of the plan was set aside, and how often for late frames.
    set_aside: Vec<u32>,
    late: Vec<u32>,
    block: u32,
    state: State,
    seen: Seen,
    pace: Pace,
}

#[derive(Debug)]
enum State {
    Page(Page),
    Blank,
    /// Grey until the fixation mark, or, after the first, until interval number `next`.
    Grey {
        until_s: f64,
        next: usize,
    },
    Fixation {
        until_s: f64,
    },
    Interval(usize, Playback),
    /// Since when the question can be answered.
    Question {
        since_s: f64,
    },
    Replay(usize, Playback, f64),
    Answered(Box<Response>),
    /// No answer came in time.
    Missed,
    Over,
}

/// What has been shown of the present trial.
#[derive(Debug, Default)]
struct Seen {
    attempt: u32,
    begun_s: f64,
    showings: Vec<Showings>,
    ended_s: f64,
    times: Vec<FrameTime>,
    /// The showing that has just ended, until it is known when something else was seen.
    leaving: Option<(usize, Playback, bool)>,
}

/// The showings of one interval within a trial.
#[derive(Clone, Copy, Debug, Default)]
struct Showings {
    onset_s: f64,
    duration_s: f64,
    replays: u32,
    faults: Faults,
}

impl Session {
    /// The session that asks the trials of `plan`, except those whose number is in `answered`; those
    /// in `set_aside` last, in that order.
    pub fn new(
        protocol: Protocol,
        set: Arc<StimulusSet>,
        identity: Identity,
        plan: Vec<Trial>,
        answered: &[u32],
        set_aside: &[u32],
    ) -> Self {
        let open = |trial: &&Trial| !answered.contains(&trial.number);
        let first_page = match plan.iter().find(open) {
            None => Page::End,
            Some(trial) if trial.part == Part::Practice || answered.is_empty() => {
                Page::Instructions
            }
            // Who goes on after the practice has read the instructions, which speak of practice to come.
            Some(_) if plan.iter().any(|t| t.part != Part::Practice && !open(&t)) => Page::Pause,
            Some(_) => Page::AfterPractice,
        };
        let mut session = Self {
            queue: (0..plan.len()).filter(|&place| open(&&plan[place])).collect(),
            set_aside: vec![0; plan.len()],
            late: vec![0; plan.len()],
            block: 0,
            state: State::Page(first_page),
            seen: Seen::default(),
            pace: Pace::default(),
            protocol,
            set,
            identity,
            plan,
        };
        for number in set_aside {
            if let Some(at) = session.queue.iter().position(|&p| session.plan[p].number == *number)
                && let Some(place) = session.queue.remove(at)
            {
                session.put_back(place);
            }
        }
        session.block = session.trial().map_or(0, |trial| trial.block);
        session
    }

    /// What is to be seen at `now_s`.
    pub fn screen(&mut self, now_s: f64) -> Screen {
        // What is shown now is seen at the nearest refresh.
        let seen_s = now_s + 0.5 * self.cadence().period_s();
        loop {
            let next = match &self.state {
                State::Page(page) => return Screen::Page(*page),
                State::Blank | State::Answered(_) | State::Missed => return Screen::Grey,
                State::Grey { until_s, .. } if seen_s < *until_s => return Screen::Grey,
                State::Grey { until_s, next: 0 } if self.protocol.timeline.fixation_s > 0.0 => {
                    State::Fixation { until_s: until_s + self.protocol.timeline.fixation_s }
                }
                State::Grey { next, .. } => State::Interval(*next, self.playback()),
                State::Fixation { until_s } if seen_s < *until_s => return Screen::Fixation,
                State::Fixation { .. } => State::Interval(0, self.playback()),
                State::Interval(interval, playback) => match playback.due(now_s) {
                    Some(index) => return Screen::Frame { interval: *interval, index },
                    None => {
                        let (interval, playback) = (*interval, playback.clone());
                        self.after_interval(interval, playback, now_s)
                    }
                },
                State::Replay(interval, playback, since_s) => match playback.due(now_s) {
                    Some(index) => return Screen::Frame { interval: *interval, index },
                    None => {
                        let since_s = *since_s;
                        self.seen.leaving = Some((*interval, playback.clone(), false));
                        State::Question { since_s }
                    }
                },
                State::Question { since_s } => match self.protocol.timeline.response_window_s {
                    Some(window_s) if now_s >= since_s + window_s => State::Missed,
                    _ => return Screen::Question,
                },
                State::Over => return Screen::Over,
            };
            self.state = next;
        }
    }

    /// Takes down that `screen` was shown at `at_s`.
    pub fn shown(&mut self, screen: Screen, at_s: f64) {
        self.leave_showing(at_s);
        if let Screen::Frame { index, .. } = screen
            && let State::Interval(_, playback) | State::Replay(_, playback, _) = &mut self.state
        {
            playback.shown(index, at_s);
        }
    }

    /// Whether something is shown whose time is fixed: grey, fixation mark or a sequence.
    pub fn is_playing(&self) -> bool {
        matches!(
            self.state,
            State::Grey { .. } | State::Fixation { .. } | State::Interval(..) | State::Replay(..)
        )
    }

    /// When the screen will change by itself, if it will.
    pub fn next_change_s(&self) -> Option<f64> {
        match &self.state {
            State::Grey { until_s, .. } | State::Fixation { until_s } => Some(*until_s),
            State::Interval(_, playback) | State::Replay(_, playback, _) => {
                Some(playback.next_change_s().unwrap_or(0.0))
            }
            State::Question { since_s } => {
                self.protocol.timeline.response_window_s.map(|window_s| since_s + window_s)
            }
            _ => None,
        }
    }

    /// Takes an input given at `now_s`, which is `utc` by the calendar.
    pub fn input(&mut self, input: Input, now_s: f64, utc: Timestamp) {
        // Let whatever ended before the input end first.
        self.screen(now_s);
        let asking = matches!(self.state, State::Question { .. } | State::Replay(..));
        match input {
            Input::Continue => match self.state {
                State::Page(Page::End) => self.state = State::Over,
                State::Page(Page::TooSlow) => self.advance(),
                State::Page(_) => self.state = State::Blank,
                _ => {}
            },
            Input::Answer(answer) if asking && self.answers().contains(&answer) => {
                self.leave_replay(now_s);
                if let Some(response) = self.response(answer, now_s, utc) {
                    self.state = State::Answered(Box::new(response));
                }
            }
            Input::Replay(interval)
                if asking
                    && self.protocol.timeline.replays
                    && interval < self.seen.showings.len() =>
            {
                let since_s = self.leave_replay(now_s);
                self.seen.showings[interval].replays += 1;
                self.state = State::Replay(interval, self.playback(), since_s);
            }
            Input::Interrupt => self.interrupt(now_s),
            _ => {}
        }
    }

    /// The answers that the task allows, in the order in which they are offered.
    pub fn answers(&self) -> Vec<Answer> {
        let mut answers = match self.protocol.task {
            Task::TwoAfc | Task::Matching => vec![Answer::First, Answer::Second],
            Task::SameDifferent => vec![Answer::Same, Answer::Different],
        };
        answers.extend(self.protocol.not_sure.as_ref().map(|_| Answer::NotSure));
        answers
    }

    /// The trial that waits to be prepared and begun, if one does.
    pub fn waiting(&self) -> Option<&Trial> {
        matches!(self.state, State::Blank).then(|| self.trial()).flatten()
    }

    /// Begins the trial that waits, at `now_s`.
    ///
    /// # Errors
    /// `writer` could not note it; the trial still waits.
    pub fn begin(
        &mut self,
        now_s: f64,
        writer: &mut dyn ResponseWriter,
    ) -> Result<(), RecordError> {
        if let Some(trial) = self.waiting() {
            let intervals = trial.intervals(self.protocol.task).len();
            let attempt = writer.begin(trial.number)?;
            let showings = vec![Showings::default(); intervals];
            self.seen = Seen { attempt, begun_s: now_s, showings, ..Seen::default() };
            self.state = State::Grey { until_s: now_s + self.protocol.timeline.gap_s, next: 0 };
        }
        Ok(())
    }

    /// Whether an answer, or that there was none, waits to be written.
    pub fn has_answer(&self) -> bool {
        matches!(self.state, State::Answered(_) | State::Missed)
    }

    /// Lets `writer` write the answer that was given, if there is one, and only then goes on.
    ///
    /// # Errors
    /// The answer could not be written. It is kept: save again.
    pub fn save(&mut self, writer: &mut dyn ResponseWriter) -> Result<(), RecordError> {
        match &self.state {
            State::Answered(response) if self.must_repeat() => {
                writer.set_aside(response.trial, "late frames", Some(response))?;
                writer.frame_times(response.trial, response.attempt, &self.seen.times);
                if let Some(&place) = self.queue.front() {
                    self.late[place] += 1;
                }
                self.postpone();
                self.advance();
            }
            State::Answered(response) => {
                writer.write(response)?;
                writer.frame_times(response.trial, response.attempt, &self.seen.times);
                self.pace.take(response.response_time_s, self.seen.ended_s - self.seen.begun_s);
                self.queue.pop_front();
                self.advance();
            }
            State::Missed => {
                if let Some(trial) = self.trial() {
                    writer.set_aside(trial.number, "no answer in time", None)?;
                    writer.frame_times(trial.number, self.seen.attempt, &self.seen.times);
                }
                self.postpone();
                self.state = State::Page(Page::TooSlow);
            }
            _ => {}
        }
        Ok(())
    }

    /// The trial being asked or to be asked next; none after the last.
    pub fn trial(&self) -> Option<&Trial> {
        self.queue.front().map(|&place| &self.plan[place])
    }

    /// How often the present trial was set aside.
    pub fn times_set_aside(&self) -> u32 {
        self.queue.front().map_or(0, |&place| self.set_aside[place])
    }

    /// The trial to be asked after the present one.
    pub fn upcoming(&self) -> Option<&Trial> {
        self.queue.get(1).map(|&place| &self.plan[place])
    }

    /// The experiment.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    fn after_interval(&mut self, interval: usize, playback: Playback, now_s: f64) -> State {
        let ended_s = playback.end_s().unwrap_or(now_s);
        self.seen.showings[interval].onset_s = playback.onset_s().unwrap_or(now_s);
        // Until something else is seen, the last frame has its time and no more.
        self.seen.showings[interval].duration_s = ended_s - self.seen.showings[interval].onset_s;
        self.seen.leaving = Some((interval, playback, true));
        if interval + 1 < self.seen.showings.len() {
            State::Grey { until_s: ended_s + self.protocol.timeline.gap_s, next: interval + 1 }
        } else {
            self.seen.ended_s = ended_s;
            State::Question { since_s: ended_s }
        }
    }

    /// Something else than the showing that ended is seen at `at_s`.
    fn leave_showing(&mut self, at_s: f64) {
        if let Some((interval, playback, is_first)) = self.seen.leaving.take()
            && let Some(showings) = self.seen.showings.get_mut(interval)
        {
            let replay = if is_first { 0 } else { showings.replays };
            self.seen.times.extend(playback.times(interval, replay));
            if is_first {
                showings.duration_s = at_s - showings.onset_s;
            }
            showings.faults += playback.faults_until(at_s);
        }
    }

    /// Ends a replay early: frames whose time had not come are neither late nor dropped. Returns since
    /// when the question has been there.
    fn leave_replay(&mut self, now_s: f64) -> f64 {
        self.leave_showing(now_s);
        match &self.state {
            State::Replay(interval, playback, since_s) => {
                let showings = &mut self.seen.showings[*interval];
                self.seen.times.extend(playback.times(*interval, showings.replays));
                showings.faults += playback.faults();
                *since_s
            }
            State::Question { since_s } => *since_s,
            _ => now_s,
        }
    }

    fn interrupt(&mut self, now_s: f64) {
        let timed = self.protocol.timeline.response_window_s.is_some();
        self.state = match self.state {
            State::Grey { .. } | State::Fixation { .. } | State::Interval(..) => State::Blank,
            State::Question { .. } | State::Replay(..) if timed => State::Blank,
            // The rest of a replay is not missed but given up.
            State::Replay(..) => State::Question { since_s: self.leave_replay(now_s) },
            _ => return,
        };
    }

    fn must_repeat(&self) -> bool {
        let Some(&place) = self.queue.front() else { return false };
        self.protocol.presentation.late_frames == LateFrames::Repeat
            && self.late[place] < MOST_LATE
            && self.seen.showings.iter().any(|showings| showings.faults.any())
    }

    /// Puts the present trial to the end.
    fn postpone(&mut self) {
        if let Some(place) = self.queue.pop_front() {
            self.put_back(place);
        }
    }

    /// Puts a trial to the end of its sort: of the practice, or of all.
    fn put_back(&mut self, place: usize) {
        self.set_aside[place] += 1;
        let practice = |place: usize| self.plan[place].part == Part::Practice;
        let at = match practice(place) {
            true => self.queue.iter().take_while(|&&other| practice(other)).count(),
            false => self.queue.len(),
        };
        self.queue.insert(at, place);
    }

    fn advance(&mut self) {
        let practised = self.block == 0;
        let Some(trial) = self.trial() else {
            self.state = State::Page(Page::End);
            return;
        };
        let (block, is_practice) = (trial.block, trial.part == Part::Practice);
        self.state = if practised && !is_practice {
            State::Page(Page::AfterPractice)
        } else if block > self.block {
            State::Page(Page::Pause)
        } else {
            State::Blank
        };
        // Trials that were set aside belong to blocks that are over.
        self.block = self.block.max(block);
    }

    fn playback(&self) -> Playback {
        let frames = match self.protocol.timeline.still {
            Some(_) => 1,
            None => self.set.stimulus(0).image.frames,
        };
        Playback::new(self.cadence(), frames)
    }

    /// How frames fall on refreshes.
    fn cadence(&self) -> Cadence {
        self.identity.viewing.cadence(self.set.fps_shown(&self.protocol))
    }
}

#[cfg(test)]
mod tests;
