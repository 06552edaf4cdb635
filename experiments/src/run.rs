//! Runs a session: finds the stimuli, opens the study, and drives the session to its end or as far as
//! it goes. The window does the same with people; here simulated observers sit in front of a
//! simulated display.

use crate::design::{DesignError, DesignReport, Trial, plan};
use crate::observer::{Judge, ObserverError, SimulatedObserver};
use crate::presenter::{Presenter, SimulatedDisplay, show};
use crate::random::session_seed;
use crate::record::heartbeat::station_name;
use crate::record::participants::{NewParticipant, PARTICIPANT};
use crate::record::study::Study;
use crate::record::{RecordError, Recorder, ResponseWriter, log};
use crate::session::{Identity, Input, Screen, Session, Viewing};
use crate::stimuli_set::{SetError, StimulusSet};
use indexmap::IndexMap;
use jiff::Timestamp;
use shutterlab_data_schema::participant::CodeError;
use shutterlab_data_schema::response::TrialKind;
use shutterlab_data_schema::study::StudyKind;
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

impl SessionRequest {
    /// The study in which `observer` answers: people, pilots and simulated observers have one each.
    ///
    /// # Errors
    /// As [`Study::open`].
    pub fn study(&self, observer: &str) -> Result<Study, RecordError> {
        let kind = match (self.pilot, observer) {
            (true, _) => StudyKind::Pilot,
            (false, PARTICIPANT) => StudyKind::Real,
            (false, _) => StudyKind::Simulated,
        };
        Study::open(&self.study, &self.protocol, kind)
    }

    /// What one session asks.
    ///
    /// # Errors
    /// The stimuli do not fit the protocol or do not make its design.
    pub fn design(&self) -> Result<DesignReport, RunError> {
        self.design_of(&StimulusSet::open(&self.protocol, &self.stimuli)?)
    }

    /// What one session asks about the stimuli of `set`.
    pub(crate) fn design_of(&self, set: &StimulusSet) -> Result<DesignReport, RunError> {
        let trials = plan(&self.protocol, &set.pool(), self.protocol.seed, 1)?;
        Ok(DesignReport::new(&self.protocol, &trials, set.sequence_s()))
    }
}

/// Who sits down.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The participant's code.
    pub subject: ParticipantCode,
    /// `participant`, or `simulated:NAME`.
    pub observer: String,
    /// The option chosen in each field of the protocol.
    pub fields: IndexMap<String, String>,
    /// When the consent was given.
    pub consented_at: Option<Timestamp>,
}

impl Entry {
    /// A person of whom only the code is known.
    pub fn person(subject: &ParticipantCode) -> Self {
        Self::observer(subject, PARTICIPANT)
    }

    /// `observer` under the code `subject`.
    pub fn observer(subject: &ParticipantCode, observer: &str) -> Self {
        let (subject, observer) = (subject.clone(), observer.into());
        Self { subject, observer, fields: IndexMap::new(), consented_at: None }
    }
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
    /// The stimuli do not make the design.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The study holds answers of another cohort.
    #[error("{}: {what}: changed since its sessions were run, which are not run again; choose another study folder", file.display())]
    OtherCohort {
        /// The cohort as it was.
        file: PathBuf,
        /// What differs.
        what: String,
    },
    /// Something cannot be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The simulated observer cannot judge the stimuli.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// An observer of a cohort would get a code that is none.
    #[error(transparent)]
    Code(#[from] CodeError),
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
    /// The display does not fit, and the protocol does not allow that.
    #[cfg(feature = "window")]
    #[error(
        "run: display: {0}: the protocol's [presentation] refuses that; mend the display, or let the protocol stamp it"
    )]
    Unfit(String),
    /// The window was closed before there was a participant.
    #[cfg(feature = "window")]
    #[error("run: the window was closed before a participant was entered; nothing was recorded")]
    Cancelled,
}

/// The sitting that a request is about: each participant has one.
pub(crate) const SESSION: u32 = 1;

/// Refreshes of the simulated display per second: the multiple of the frame rate that is nearest to this.
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
    pilot: bool,
    plan: Vec<Trial>,
    answered: Vec<u32>,
    set_aside: Vec<u32>,
}

impl Sitting {
    /// Opens the records of who sits down.
    pub(crate) fn open(
        request: &SessionRequest,
        set: Arc<StimulusSet>,
        entry: &Entry,
    ) -> Result<Self, RunError> {
        let Entry { subject, observer, fields, consented_at } = entry;
        let protocol = request.protocol.clone();
        let seed = session_seed("order", protocol.seed, subject, SESSION);
        let study = request.study(observer)?;
        let participant = study.enter(&NewParticipant {
            subject: subject.clone(),
            observer: observer.clone(),
            seed,
            fields: fields.clone(),
            consented_at: *consented_at,
        })?;
        study.keep_thumbnails(&set)?;
        let plan = plan(&protocol, &set.pool(), seed, participant.ordinal)?;
        let (recorder, rows) = study.session(subject, SESSION, plan.len() as u32)?;
        let set_aside = recorder.trials_set_aside().to_vec();
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
        let kind = match (observer.as_str(), request.pilot) {
            (PARTICIPANT, true) => TrialKind::Pilot,
            (PARTICIPANT, false) => TrialKind::Real,
            _ => TrialKind::Simulated,
        };
        let (subject, observer) = (subject.clone(), observer.clone());
        let pilot = request.pilot;
        Ok(Self {
            set,
            recorder,
            protocol,
            subject,
            observer,
            kind,
            pilot,
            plan,
            answered,
            set_aside,
        })
    }

    /// The session, seen as `viewing` says.
    pub(crate) fn session(&self, viewing: Viewing) -> Session {
        let identity = Identity {
            subject: self.subject.clone(),
            session: SESSION,
            station: station_name(),
            observer: self.observer.clone(),
            kind: self.kind,
            pilot: self.pilot,
            viewing,
        };
        let (protocol, set, plan) = (self.protocol.clone(), self.set.clone(), self.plan.clone());
        Session::new(protocol, set, identity, plan, &self.answered, &self.set_aside)
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
        let event = if outcome.finished { log::FINISHED } else { log::LEFT };
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
    let instructed = observer.instruct(&set, &request.protocol)?;
    let entry = Entry::observer(subject, &observer.name());
    let mut sitting = Sitting::open(request, set, &entry)?;
    if !sitting.is_finished() {
        let trials = sitting.outcome().trials;
        let judge = instructed.judge(request.protocol.seed, subject, SESSION, trials);
        let mut display = simulated_display(&sitting.set);
        let mut session = sitting.session(display.viewing());
        let utc = |_| Timestamp::now();
        drive(&mut session, &mut display, &judge, &mut sitting.recorder, utc)?;
    }
    Ok(sitting.close()?)
}

/// The display that simulated observers sit in front of.
pub(crate) fn simulated_display(set: &StimulusSet) -> SimulatedDisplay {
    let fps = set.stimulus(0).image.fps;
    SimulatedDisplay::new(fps * (SIMULATED_REFRESH_HZ / fps).round().max(1.0))
}

/// Lets `judge` go through the whole of `session`; `utc` tells the calendar time of a clock reading.
pub(crate) fn drive(
    session: &mut Session,
    display: &mut SimulatedDisplay,
    judge: &Judge,
    writer: &mut dyn ResponseWriter,
    utc: impl Fn(f64) -> Timestamp,
) -> Result<(), RecordError> {
    loop {
        let Ok(screen) = show(session, display);
        let now_s = display.now_s();
        match screen {
            Screen::Page(_) => session.input(Input::Continue, now_s, utc(now_s)),
            Screen::Question => {
                if let Some((answer, seconds)) = session.trial().map(|trial| judge.answer(trial)) {
                    // Whoever was too slow answers at once the next time: a session always ends.
                    display.wait(if session.times_set_aside() > 0 { 0.0 } else { seconds });
                    let now_s = display.now_s();
                    session.input(Input::Answer(answer), now_s, utc(now_s));
                    session.save(writer)?;
                }
            }
            Screen::Grey => {
                session.save(writer)?;
                session.begin(now_s, writer)?;
            }
            Screen::Fixation | Screen::Frame { .. } => {}
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
        (
            "reference",
            format!("{:?}", row.reference),
            format!(
                "{:?}",
                trial.reference.map(|side| set.stimulus(trial.stimulus(side)).id.clone())
            ),
        ),
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

#[cfg(test)]
mod tests;
