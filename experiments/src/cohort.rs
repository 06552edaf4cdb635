//! Runs a cohort: every simulated observer of a file goes through a session, on all cores.
//!
//! Each goes through the same state machine as a person, in front of a simulated display. All that is
//! written follows from the protocol, the cohort and the stimuli, whatever the number of threads: the
//! answers of a session are dated from 1970-01-01, by the simulated clock.

use crate::design::{Pool, plan};
use crate::observer::{Instructed, SimulatedObserver};
use crate::random::{Stream, session_seed};
use crate::record::RecordError;
use crate::record::cohort::Cohort as Records;
use crate::record::participants::NewParticipant;
use crate::record::study::Study;
use crate::run::{RunError, SESSION, drive, simulated_display};
use crate::session::{Identity, Session};
use crate::stimuli_set::StimulusSet;
use indexmap::IndexMap;
use jiff::{SignedDuration, Timestamp};
use rayon::prelude::*;
use shutterlab_data_schema::cohort::Observers;
use shutterlab_data_schema::definition;
use shutterlab_data_schema::files::write_atomically;
use shutterlab_data_schema::response::TrialKind;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_data_schema::{Cohort, Participant, Protocol};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

/// A cohort to be run.
#[derive(Clone, Debug)]
pub struct CohortRequest {
    /// The experiment.
    pub protocol: Protocol,
    /// Folder of the sequences.
    pub stimuli: PathBuf,
    /// Folder of the study; the answers go into its folder `simulated`.
    pub study: PathBuf,
    /// The cohort.
    pub cohort: Cohort,
    /// The folder from which the cohort names files.
    pub tables: PathBuf,
}

/// What came of a cohort.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CohortOutcome {
    /// The study of simulated answers.
    pub study: PathBuf,
    /// Sessions that were run now.
    pub sessions_now: usize,
    /// Sessions that were there before.
    pub sessions_before: usize,
    /// Answers given now, practice included.
    pub answers_now: usize,
}

/// Runs the sessions of a cohort that are not there yet. Killed, it leaves whole sessions only, and goes
/// on with the others when it is run again.
///
/// # Errors
/// See [`RunError`].
pub fn run_cohort(request: &CohortRequest) -> Result<CohortOutcome, RunError> {
    let CohortRequest { protocol, cohort, .. } = request;
    let set = Arc::new(StimulusSet::open(protocol, &request.stimuli)?);
    set.verify()?;
    let mut sorts = Vec::new();
    let mut newcomers = Vec::new();
    for sort in &cohort.observers {
        let observer = SimulatedObserver::from_cohort(sort, &request.tables)?;
        let instructed = Arc::new(observer.instruct(&set, protocol)?);
        for code in sort.codes() {
            let subject = code.parse()?;
            let seed = session_seed("order", protocol.seed, &subject, SESSION);
            let (observer, fields) = (observer.name(), IndexMap::new());
            newcomers.push(NewParticipant { subject, observer, seed, fields, consented_at: None });
            sorts.push(Arc::clone(&instructed));
        }
    }
    let study = Study::open(&request.study, protocol, StudyKind::Simulated)?;
    keep(cohort, &study)?;
    study.keep_thumbnails(&set)?;
    let records = study.cohort(&newcomers)?;
    let room = Room {
        protocol,
        pool: set.pool(),
        set,
        station: study.station(),
        // Answers to two protocols have nothing in common, nor have those of two cohorts.
        seed: Stream::keyed(cohort.seed, protocol.seed).bits(),
        records: &records,
    };
    let sessions = records.participants().par_iter().zip(&sorts);
    let answers: Vec<Option<usize>> = sessions
        .map(|(participant, sort)| room.run(participant, sort))
        .collect::<Result<_, _>>()?;
    records.finish()?;
    let sessions_now = answers.iter().flatten().count();
    Ok(CohortOutcome {
        study: study.folder().into(),
        sessions_now,
        sessions_before: answers.len() - sessions_now,
        answers_now: answers.iter().flatten().sum(),
    })
}

/// Keeps the cohort beside its answers. Sessions that are there already are not run again, so the sorts they
/// belong to must be what they were; there may be more of a sort, and other sorts.
fn keep(cohort: &Cohort, study: &Study) -> Result<(), RunError> {
    let file = study.folder().join("cohort.toml");
    if file.exists() {
        let there: Cohort = definition::read(&file).map_err(RecordError::from)?;
        let changed = cohort.observers.iter().find(|sort| {
            let earlier = there.observers.iter().find(|earlier| earlier.name == sort.name);
            earlier.is_some_and(|earlier| {
                Observers { count: earlier.count, ..(*sort).clone() } != *earlier
            })
        });
        let what = match changed {
            Some(sort) => format!("observers {}", sort.name),
            None if there.seed != cohort.seed => "seed".into(),
            None => String::new(),
        };
        if !what.is_empty() {
            return Err(RunError::OtherCohort { file, what });
        }
    }
    let text = toml::to_string(cohort).map_err(io::Error::other).map_err(RecordError::from)?;
    Ok(write_atomically(&file, text.as_bytes()).map_err(RecordError::from)?)
}

/// What the sessions of a cohort have in common.
struct Room<'a> {
    protocol: &'a Protocol,
    pool: Pool,
    set: Arc<StimulusSet>,
    station: &'a str,
    /// Seed of all answers.
    seed: u64,
    records: &'a Records<'a>,
}

impl Room<'_> {
    /// Runs a session, unless it is there already; how many trials it has.
    fn run(&self, participant: &Participant, sort: &Instructed) -> Result<Option<usize>, RunError> {
        let Participant { subject, observer, seed, ordinal, .. } = participant;
        let Some(mut writer) = self.records.writer(subject, SESSION) else { return Ok(None) };
        let plan = plan(self.protocol, &self.pool, *seed, *ordinal)?;
        let trials = plan.len();
        let judge = sort.judge(self.seed, subject, SESSION, trials as u32);
        let mut display = simulated_display(&self.set);
        let identity = Identity {
            subject: subject.clone(),
            session: SESSION,
            station: self.station.into(),
            observer: observer.clone(),
            kind: TrialKind::Simulated,
            pilot: false,
            viewing: display.viewing(),
        };
        let (protocol, set) = (self.protocol.clone(), Arc::clone(&self.set));
        let mut session = Session::new(protocol, set, identity, plan, &[], &[]);
        drive(&mut session, &mut display, &judge, &mut writer, simulated_date)?;
        writer.finish()?;
        Ok(Some(trials))
    }
}

/// The date of a reading of the simulated clock.
fn simulated_date(now_s: f64) -> Timestamp {
    let since = SignedDuration::from_micros((now_s * 1e6).round() as i64);
    Timestamp::UNIX_EPOCH.checked_add(since).unwrap_or(Timestamp::MAX)
}

#[cfg(test)]
mod tests;
