//! One participant's sitting as a state machine: no files, no window, no sleeping.
//!
//! ```text
//! Instructions → practice trials → AfterPractice → trials, a Pause between blocks → End → over
//!
//! a trial:  Blank ──begin()──► Lead (grey) → first sequence → Gap (grey) → second sequence
//!             ▲                                                               │
//!             │ Interrupt                                                     ▼
//!             └──(from any state before the question)        Question ⇄ replay of either
//!                                                                             │ Answer
//!           next trial ◄──save() succeeds── Answered ◄────────────────────────┘
//! ```
//!
//! Whoever drives it asks for the [`Screen`] to show at a clock reading, reports when it was shown,
//! passes on the participant's inputs, prepares a trial's sequences before [`Session::begin`], and
//! lets [`Session::save`] write each answer. A session whose answer cannot be written stays where it
//! is, answer in hand, and can be asked to save again. Inputs that mean nothing at the moment (an
//! answer before both sequences were seen whole) are ignored.

use crate::design::Trial;
use crate::playback::Playback;
use crate::record::{RecordError, ResponseWriter};
use crate::stimuli_set::StimulusSet;
use jiff::Timestamp;
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::protocol::{Protocol, Text};
use shutterlab_data_schema::response::{Answer, Clock, Response, Side, TrialKind};
use std::sync::Arc;

/// What is to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Screen {
    /// A page of text, left by [`Input::Continue`].
    Page(Page),
    /// Neutral grey.
    Grey,
    /// A frame of one of the trial's two sequences.
    Frame {
        /// The sequence: the one that this answer would choose.
        interval: Answer,
        /// Number of the frame.
        index: u32,
    },
    /// The question, with the choice of answering or seeing a sequence again.
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
    /// Asks to see the sequence again that this answer would choose.
    Replay(Answer),
    /// Gives up the trial that is being shown; it will be shown again from its beginning, as another
    /// attempt. Without effect once the question is asked.
    Interrupt,
}

/// What every response of a session has in common.
#[derive(Clone, Debug)]
pub struct Identity {
    /// Who answers.
    pub subject: ParticipantCode,
    /// The sitting, from 1.
    pub session: u32,
    /// Name of the computer.
    pub station: String,
    /// `participant`, or `simulated:NAME`.
    pub observer: String,
    /// Kind of the trials that are not practice.
    pub kind: TrialKind,
    /// The display: its name, physical pixels and scale factor.
    pub display: String,
    /// What the times are read from.
    pub clock: Clock,
}

/// How far a session is, for the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Whether this is about practice trials.
    pub practice: bool,
    /// Place of the present or coming trial among those of its sort, from 1.
    pub trial: u32,
    /// How many of its sort there are.
    pub of: u32,
}

/// A session under way.
#[derive(Debug)]
pub struct Session {
    protocol: Protocol,
    set: Arc<StimulusSet>,
    identity: Identity,
    plan: Vec<Trial>,
    position: usize,
    answered: Vec<bool>,
    state: State,
    seen: Seen,
}

#[derive(Debug)]
enum State {
    Page(Page),
    Blank,
    Lead { until_s: f64 },
    First(Playback),
    Gap { until_s: f64 },
    Second(Playback),
    Question,
    Replay(Answer, Playback),
    Answered(Box<Response>),
    Over,
}

/// What has been shown of the present trial.
#[derive(Debug, Default)]
struct Seen {
    attempt: u32,
    first: Showings,
    second: Showings,
    second_ended_s: f64,
}

/// The showings of one sequence within a trial.
#[derive(Debug, Default)]
struct Showings {
    onset_s: f64,
    replays: u32,
    late: u32,
}

impl Session {
    /// The session that asks the trials of `plan`, except those whose number is in `answered`.
    pub fn new(
        protocol: Protocol,
        set: Arc<StimulusSet>,
        identity: Identity,
        plan: Vec<Trial>,
        answered: &[u32],
    ) -> Self {
        let answered: Vec<bool> = plan.iter().map(|t| answered.contains(&t.number)).collect();
        let position = answered.iter().position(|done| !done).unwrap_or(plan.len());
        // Who goes on after the practice has read the instructions, which speak of practice to come.
        let first_page = match plan.get(position) {
            None => Page::End,
            Some(trial) if !trial.is_practice() && answered.contains(&true) => Page::Pause,
            Some(_) => Page::Instructions,
        };
        let state = State::Page(first_page);
        let seen = Seen::default();
        Self { protocol, set, identity, plan, position, answered, state, seen }
    }

    /// What is to be seen at `now_s`.
    pub fn screen(&mut self, now_s: f64) -> Screen {
        loop {
            let next = match &self.state {
                State::Page(page) => return Screen::Page(*page),
                State::Blank | State::Answered(_) => return Screen::Grey,
                State::Lead { until_s } if now_s >= *until_s => {
                    State::First(self.playback(Answer::First))
                }
                State::Gap { until_s } if now_s >= *until_s => {
                    State::Second(self.playback(Answer::Second))
                }
                State::Lead { .. } | State::Gap { .. } => return Screen::Grey,
                State::First(playback) => match playback.due(now_s) {
                    Some(index) => return Screen::Frame { interval: Answer::First, index },
                    None => {
                        self.seen.first.late += playback.late_at_end();
                        self.seen.first.onset_s = playback.onset_s().unwrap_or(now_s);
                        let ended_s = playback.end_s().unwrap_or(now_s);
                        State::Gap { until_s: ended_s + self.protocol.design.gap_s }
                    }
                },
                State::Second(playback) => match playback.due(now_s) {
                    Some(index) => return Screen::Frame { interval: Answer::Second, index },
                    None => {
                        self.seen.second.late += playback.late_at_end();
                        self.seen.second.onset_s = playback.onset_s().unwrap_or(now_s);
                        self.seen.second_ended_s = playback.end_s().unwrap_or(now_s);
                        State::Question
                    }
                },
                State::Replay(interval, playback) => match playback.due(now_s) {
                    Some(index) => return Screen::Frame { interval: *interval, index },
                    None => {
                        let (interval, late) = (*interval, playback.late_at_end());
                        self.seen.of(interval).late += late;
                        State::Question
                    }
                },
                State::Question => return Screen::Question,
                State::Over => return Screen::Over,
            };
            self.state = next;
        }
    }

    /// Takes down that `screen` was shown at `at_s`.
    pub fn shown(&mut self, screen: Screen, at_s: f64) {
        if let Screen::Frame { index, .. } = screen
            && let State::First(playback) | State::Second(playback) | State::Replay(_, playback) =
                &mut self.state
        {
            playback.shown(index, at_s);
        }
    }

    /// When the screen will change by itself, if it will.
    pub fn next_change_s(&self) -> Option<f64> {
        match &self.state {
            State::Lead { until_s } | State::Gap { until_s } => Some(*until_s),
            State::First(playback) | State::Second(playback) | State::Replay(_, playback) => {
                Some(playback.next_change_s().unwrap_or(0.0))
            }
            _ => None,
        }
    }

    /// Takes an input given at `now_s`, which is `utc` by the calendar.
    pub fn input(&mut self, input: Input, now_s: f64, utc: Timestamp) {
        // Let whatever ended before the input end first.
        self.screen(now_s);
        match (input, &self.state) {
            (Input::Continue, State::Page(Page::End)) => self.state = State::Over,
            (Input::Continue, State::Page(_)) => self.state = State::Blank,
            (Input::Answer(answer), State::Question | State::Replay(..)) => {
                self.leave_replay();
                self.state = State::Answered(Box::new(self.response(answer, now_s, utc)));
            }
            (Input::Replay(interval), State::Question | State::Replay(..)) => {
                self.leave_replay();
                self.seen.of(interval).replays += 1;
                self.state = State::Replay(interval, self.playback(interval));
            }
            (
                Input::Interrupt,
                State::Lead { .. } | State::First(_) | State::Gap { .. } | State::Second(_),
            ) => self.state = State::Blank,
            // The rest of a replay is not missed but given up: its frames are not late.
            (Input::Interrupt, State::Replay(..)) => self.state = State::Question,
            _ => {}
        }
    }

    /// The trial that waits to be prepared and begun, if one does.
    pub fn waiting(&self) -> Option<&Trial> {
        matches!(self.state, State::Blank).then(|| &self.plan[self.position])
    }

    /// Begins the trial that waits, at `now_s`: the gap's length of grey, then the first sequence.
    ///
    /// # Errors
    /// `writer` could not note it; the trial still waits.
    pub fn begin(
        &mut self,
        now_s: f64,
        writer: &mut dyn ResponseWriter,
    ) -> Result<(), RecordError> {
        if let Some(trial) = self.waiting() {
            let attempt = writer.begin(trial.number)?;
            self.seen = Seen { attempt, ..Seen::default() };
            self.state = State::Lead { until_s: now_s + self.protocol.design.gap_s };
        }
        Ok(())
    }

    /// Whether an answer waits to be written.
    pub fn has_answer(&self) -> bool {
        matches!(self.state, State::Answered(_))
    }

    /// Lets `writer` write the answer that was given, if there is one, and only then goes on.
    ///
    /// # Errors
    /// The answer could not be written. It is kept: save again.
    pub fn save(&mut self, writer: &mut dyn ResponseWriter) -> Result<(), RecordError> {
        if let State::Answered(response) = &self.state {
            writer.write(response)?;
            self.advance();
        }
        Ok(())
    }

    /// The trial being asked or to be asked next; none after the last.
    pub fn trial(&self) -> Option<&Trial> {
        self.plan.get(self.position)
    }

    /// The trial to be asked after the present one.
    pub fn upcoming(&self) -> Option<&Trial> {
        self.next_position().map(|position| &self.plan[position])
    }

    /// How far the session is; none after the last trial.
    pub fn progress(&self) -> Option<Progress> {
        let practice = self.trial()?.is_practice();
        let of_its_sort =
            |trials: &[Trial]| trials.iter().filter(|t| t.is_practice() == practice).count() as u32;
        let trial = of_its_sort(&self.plan[..=self.position]);
        Some(Progress { practice, trial, of: of_its_sort(&self.plan) })
    }

    /// The text of `page`.
    pub fn text(&self, page: Page) -> &str {
        let Text { instructions, after_practice, pause, end } = &self.protocol.text;
        match page {
            Page::Instructions => instructions,
            Page::AfterPractice => after_practice,
            Page::Pause => pause,
            Page::End => end,
        }
    }

    /// The question.
    pub fn question(&self) -> &str {
        &self.protocol.question
    }

    fn next_position(&self) -> Option<usize> {
        let later = self.position + 1;
        self.answered.iter().skip(later).position(|done| !done).map(|offset| later + offset)
    }

    fn advance(&mut self) {
        let (practised, block) =
            (self.plan[self.position].is_practice(), self.plan[self.position].block);
        self.answered[self.position] = true;
        let Some(next) = self.next_position() else {
            self.position = self.plan.len();
            self.state = State::Page(Page::End);
            return;
        };
        self.position = next;
        let trial = &self.plan[next];
        self.state = if practised && !trial.is_practice() {
            State::Page(Page::AfterPractice)
        } else if trial.block != block {
            State::Page(Page::Pause)
        } else {
            State::Blank
        };
    }

    /// Ends a replay early: frames whose time had not come are not late.
    fn leave_replay(&mut self) {
        if let State::Replay(interval, playback) = &self.state {
            let (interval, late) = (*interval, playback.late());
            self.seen.of(interval).late += late;
        }
    }

    fn playback(&self, interval: Answer) -> Playback {
        let trial = &self.plan[self.position];
        let image = &self.set.stimulus(trial.stimulus(trial.side(interval))).image;
        Playback::new(image.fps, image.frames)
    }

    fn response(&self, answer: Answer, now_s: f64, utc: Timestamp) -> Response {
        let trial = &self.plan[self.position];
        let (a, b) = (&self.set.sequences[trial.a].manifest, &self.set.sequences[trial.b].manifest);
        let selected = trial.side(answer);
        let (shown_a, shown_b) = match trial.first {
            Side::A => (&self.seen.first, &self.seen.second),
            Side::B => (&self.seen.second, &self.seen.first),
        };
        Response {
            study: self.protocol.name.clone(),
            subject: self.identity.subject.clone(),
            session: self.identity.session,
            station: self.identity.station.clone(),
            block: trial.block,
            trial: trial.number,
            repetition: trial.repetition,
            attempt: self.seen.attempt,
            kind: if trial.is_practice() { TrialKind::Practice } else { self.identity.kind },
            observer: self.identity.observer.clone(),
            task: self.protocol.task,
            question: self.protocol.question.clone(),
            reference: None,
            stimulus_a: a.stimulus.id.clone(),
            exemplar_a: a.stimulus.exemplar,
            hash_a: a.sha256.clone(),
            stimulus_b: b.stimulus.id.clone(),
            exemplar_b: b.stimulus.exemplar,
            hash_b: b.sha256.clone(),
            first: trial.first,
            answer,
            selected: self.set.stimulus(trial.stimulus(selected)).id.clone(),
            correct: trial.better.map(|better| better == selected),
            response_time_s: microseconds(now_s - self.seen.second_ended_s),
            replays_a: shown_a.replays,
            replays_b: shown_b.replays,
            onset_a_s: microseconds(shown_a.onset_s),
            onset_b_s: microseconds(shown_b.onset_s),
            late_frames_a: shown_a.late,
            late_frames_b: shown_b.late,
            clock: self.identity.clock,
            display: self.identity.display.clone(),
            pixels_per_degree: a.stimulus.pixels_per_degree,
            answered_at: format!("{utc:.3}"),
            program_version: env!("CARGO_PKG_VERSION").into(),
        }
    }
}

impl Seen {
    fn of(&mut self, interval: Answer) -> &mut Showings {
        match interval {
            Answer::First => &mut self.first,
            Answer::Second => &mut self.second,
        }
    }
}

/// `seconds` without the digits that no clock has.
fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests;
