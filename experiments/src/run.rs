//! Runs a session: finds the stimuli, opens the study, and drives the session to its end or as far as
//! it goes. The window does the same with people; here simulated observers sit in front of a
//! simulated display.

use crate::design::{Trial, plan};
use crate::observer::{Judge, ObserverError, SimulatedObserver};
use crate::presenter::{Presenter, SimulatedDisplay, show};
use crate::random::session_seed;
use crate::record::study::{PARTICIPANT, Study};
use crate::record::{RecordError, Recorder, ResponseWriter};
use crate::session::{Identity, Input, Screen, Session};
use crate::stimuli_set::{SetError, StimulusSet};
use jiff::Timestamp;
use shutterlab_data_schema::response::{Clock, TrialKind};
use shutterlab_data_schema::{ParticipantCode, Protocol, Response};
use std::path::PathBuf;
use std::sync::Arc;

/// What is to be run.
#[derive(Clone, Debug)]
pub struct SessionRequest {
    /// The experiment.
    pub protocol: Protocol,
    /// Folder of the sequences.
    pub stimuli: PathBuf,
    /// Folder of the study.
    pub study: PathBuf,
    /// Who answers; a window asks for the code if none is given.
    pub participant: Option<ParticipantCode>,
    /// Whether this is a trial run whose answers never count.
    pub pilot: bool,
}

/// How a session ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Who answered.
    pub subject: ParticipantCode,
    /// The file with the answers.
    pub data_file: PathBuf,
    /// Trials answered this time, practice included.
    pub answered_now: u32,
    /// Trials that had been answered before, practice included.
    pub answered_before: u32,
    /// Trials of the session, practice included.
    pub trials: u32,
    /// Whether all trials are answered. If not, running the same again goes on.
    pub finished: bool,
}

/// A session cannot be run, or cannot go on. Every answer given so far is saved.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The stimuli do not fit the protocol.
    #[error(transparent)]
    Stimuli(#[from] SetError),
    /// Something cannot be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The simulated observer cannot judge the stimuli.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A simulated observer has no code.
    #[error("run: --participant: none given: a simulated observer needs a code, for example S01")]
    NoCode,
    /// The session's earlier answers are not those of this design or these stimuli.
    #[error("{}: trial {trial}: {field}: {there}, now {now}: the session was begun with other stimuli; go on with those, or take another participant code", file.display())]
    OtherTrial {
        /// The data file.
        file: PathBuf,
        /// The trial.
        trial: u32,
        /// What differs.
        field: &'static str,
        /// Its value in the file.
        there: String,
        /// Its value now.
        now: String,
    },
    /// A trial is answered twice in the data file.
    #[error("{}: trial {trial}: is there twice: each trial is answered once; mend the file by hand, nothing was changed", file.display())]
    Twice {
        /// The data file.
        file: PathBuf,
        /// The trial.
        trial: u32,
    },
    /// The window or its device failed.
    #[cfg(feature = "window")]
    #[error(transparent)]
    Window(#[from] crate::window::shell::ShellError),
    /// The window was closed before there was a participant.
    #[cfg(feature = "window")]
    #[error(
        "run: the window was closed before a participant's code was given; nothing was recorded"
    )]
    Cancelled,
}

/// The sitting that a request is about: each participant has one.
const SESSION: u32 = 1;

/// Refreshes of the simulated display per second.
const SIMULATED_REFRESH_HZ: f64 = 60.0;

/// Everything a session needs but its display.
#[derive(Debug)]
pub(crate) struct Sitting {
    pub set: Arc<StimulusSet>,
    pub recorder: Recorder,
    protocol: Protocol,
    subject: ParticipantCode,
    observer: String,
    kind: TrialKind,
    plan: Vec<Trial>,
    answered: Vec<u32>,
}

impl Sitting {
    /// Opens the records of `subject`, who answers as `observer`.
    pub(crate) fn open(
        request: &SessionRequest,
        set: Arc<StimulusSet>,
        subject: &ParticipantCode,
        observer: &str,
    ) -> Result<Self, RunError> {
        let protocol = request.protocol.clone();
        let seed = session_seed("order", protocol.seed, subject, SESSION);
        let study = Study::open(&request.study, &protocol, request.pilot)?;
        study.enter(subject, observer, seed)?;
        study.keep_thumbnails(&set)?;
        let (recorder, rows) = study.session(subject, SESSION)?;
        let plan = plan(&protocol.design, set.compared, &set.practice, seed);
        let mut answered = Vec::new();
        for row in &rows {
            check_row(row, &plan, &set, &recorder, observer)?;
            if answered.contains(&row.trial) {
                return Err(RunError::Twice {
                    file: recorder.data_file().into(),
                    trial: row.trial,
                });
            }
            answered.push(row.trial);
        }
        let kind = match (observer, request.pilot) {
            (PARTICIPANT, true) => TrialKind::Pilot,
            (PARTICIPANT, false) => TrialKind::Real,
            _ => TrialKind::Simulated,
        };
        let (subject, observer) = (subject.clone(), observer.to_string());
        Ok(Self { set, recorder, protocol, subject, observer, kind, plan, answered })
    }

    /// The session, on a display called `display`.
    pub(crate) fn session(&self, display: String, clock: Clock) -> Session {
        let identity = Identity {
            subject: self.subject.clone(),
            session: SESSION,
            station: station(),
            observer: self.observer.clone(),
            kind: self.kind,
            display,
            clock,
        };
        let (protocol, set, plan) = (self.protocol.clone(), self.set.clone(), self.plan.clone());
        Session::new(protocol, set, identity, plan, &self.answered)
    }

    /// Whether nothing is left to ask.
    pub(crate) fn is_finished(&self) -> bool {
        self.outcome().finished
    }

    /// How far the session is.
    pub(crate) fn outcome(&self) -> Outcome {
        let (now, before) = (self.recorder.written(), self.answered.len() as u32);
        let trials = self.plan.len() as u32;
        Outcome {
            subject: self.subject.clone(),
            data_file: self.recorder.data_file().into(),
            answered_now: now,
            answered_before: before,
            trials,
            finished: now + before >= trials,
        }
    }

    /// Notes in the log that the session ends here.
    pub(crate) fn close(&mut self) -> Result<Outcome, RecordError> {
        let outcome = self.outcome();
        let event = if outcome.finished { "finished" } else { "left" };
        let answered = outcome.answered_before + outcome.answered_now;
        self.recorder.note(event, &format!("{answered} of {} answered", outcome.trials))?;
        Ok(outcome)
    }
}

/// Runs the session of a simulated observer, from where it is to its end. A session that is finished
/// is left as it is.
///
/// # Errors
/// See [`RunError`]. Answers given before the error are saved; running again goes on after them.
pub fn run_simulated(
    request: &SessionRequest,
    observer: &SimulatedObserver,
) -> Result<Outcome, RunError> {
    let subject = request.participant.as_ref().ok_or(RunError::NoCode)?;
    let set = Arc::new(StimulusSet::open(&request.protocol, &request.stimuli)?);
    set.verify()?;
    let judge = Judge::new(observer, &set, request.protocol.seed, subject, SESSION)?;
    let mut sitting = Sitting::open(request, set, subject, &observer.name())?;
    if !sitting.is_finished() {
        let mut display = SimulatedDisplay::new(SIMULATED_REFRESH_HZ);
        let mut session = sitting.session(display.name(), display.clock());
        drive(&mut session, &mut display, &judge, &mut sitting.recorder)?;
    }
    Ok(sitting.close()?)
}

/// Lets `judge` go through the whole of `session`.
fn drive(
    session: &mut Session,
    display: &mut SimulatedDisplay,
    judge: &Judge,
    writer: &mut dyn ResponseWriter,
) -> Result<(), RecordError> {
    loop {
        let Ok(screen) = show(session, display);
        let now_s = display.now_s();
        match screen {
            Screen::Page(_) => session.input(Input::Continue, now_s, Timestamp::now()),
            Screen::Question => {
                if let Some((answer, seconds)) = session.trial().map(|trial| judge.answer(trial)) {
                    display.wait(seconds);
                    session.input(Input::Answer(answer), display.now_s(), Timestamp::now());
                    session.save(writer)?;
                }
            }
            Screen::Grey => session.begin(now_s, writer)?,
            Screen::Frame { .. } => {}
            Screen::Over => return Ok(()),
        }
    }
}

/// Refuses a row that is not an answer to the trial of its number.
fn check_row(
    row: &Response,
    plan: &[Trial],
    set: &StimulusSet,
    recorder: &Recorder,
    observer: &str,
) -> Result<(), RunError> {
    let Some(trial) = plan.iter().find(|trial| trial.number == row.trial) else {
        return Err(RunError::OtherTrial {
            file: recorder.data_file().into(),
            trial: row.trial,
            field: "trial",
            there: row.trial.to_string(),
            now: format!("1 to {}", plan.len()),
        });
    };
    let (a, b) = (&set.sequences[trial.a].manifest, &set.sequences[trial.b].manifest);
    let fields = [
        ("session", row.session.to_string(), SESSION.to_string()),
        ("observer", row.observer.clone(), observer.to_string()),
        ("stimulus_a", row.stimulus_a.clone(), a.stimulus.id.clone()),
        ("stimulus_b", row.stimulus_b.clone(), b.stimulus.id.clone()),
        ("hash_a", row.hash_a.clone(), a.sha256.clone()),
        ("hash_b", row.hash_b.clone(), b.sha256.clone()),
        ("first", format!("{:?}", row.first), format!("{:?}", trial.first)),
    ];
    match fields.into_iter().find(|(_, there, now)| there != now) {
        None => Ok(()),
        Some((field, there, now)) => {
            let file = recorder.data_file().into();
            Err(RunError::OtherTrial { file, trial: row.trial, field, there, now })
        }
    }
}

/// Name of this computer, as far as it says.
fn station() -> String {
    let from_file = |path| std::fs::read_to_string(path).ok();
    std::env::var("COMPUTERNAME")
        .ok()
        .or_else(|| from_file("/proc/sys/kernel/hostname"))
        .or_else(|| from_file("/etc/hostname"))
        .or_else(|| {
            let output = std::process::Command::new("hostname").output().ok()?;
            String::from_utf8(output.stdout).ok()
        })
        .map(|name| name.trim().to_string())
        .filter(|name| !name.is_empty())
        .unwrap_or_else(|| "unknown".into())
}

#[cfg(test)]
mod tests;
