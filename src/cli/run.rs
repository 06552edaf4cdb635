//! `shutterlab run`: a session, in a window or with a simulated observer.

use super::{UsageError, counted, say};
use anyhow::Context;
use shutterlab_analysis::replication::published;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_data_schema::{Cohort, ParticipantCode, Protocol, Votes};
use shutterlab_experiments::{
    CohortOutcome, CohortRequest, Outcome, SessionRequest, SimulatedObserver, protocols,
    run_cohort, run_simulated,
};
use std::path::{Path, PathBuf};

/// Run a session of an experiment. Each answer is saved when it is given; run the same again to go
/// on with an interrupted session.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A shipped protocol or a protocol file; without it, that of the study, or the one chosen in the
    /// window
    protocol: Option<String>,
    /// Folder of the rendered sequences
    #[arg(long, value_name = "DIR")]
    stimuli: PathBuf,
    /// Folder of the study; made if it is not there
    #[arg(long, value_name = "DIR")]
    study: PathBuf,
    /// The participant's code; the window asks for it if it is not given
    #[arg(long, value_name = "CODE")]
    participant: Option<ParticipantCode>,
    /// A simulated observer, who needs no window: simulated:guess, or simulated:NAME with the name
    /// of a published vote table (such as mono-shutter-sampling)
    #[arg(long, value_name = "simulated:NAME", value_parser = parse_observer)]
    observer: Option<SimulatedObserver>,
    /// A file of simulated observers, who all answer at once, into STUDY/simulated
    #[arg(long, value_name = "FILE", conflicts_with_all = ["participant", "observer", "display", "pilot"])]
    cohort: Option<PathBuf>,
    /// The profile of the display in front of the participant
    #[arg(long, value_name = "FILE")]
    display: Option<PathBuf>,
    /// A trial run: its answers are kept apart and never count
    #[arg(long)]
    pilot: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let requests: Vec<SessionRequest> = protocols_of(args)?
        .into_iter()
        .map(|protocol| SessionRequest {
            protocol,
            stimuli: args.stimuli.clone(),
            study: args.study.clone(),
            participant: args.participant.clone(),
            pilot: args.pilot,
        })
        .collect();
    if let [request] = requests.as_slice() {
        eprintln!("{}: {}", request.protocol.name, request.design()?);
    }
    if let Some(file) = &args.cohort {
        let [request] = requests.as_slice() else {
            return Err(UsageError::from("run: PROTOCOL: none given: a cohort needs one"));
        };
        return in_cohort(request, file);
    }
    let outcome = match (&args.observer, requests.as_slice()) {
        (Some(_), _) if args.participant.is_none() => {
            return Err(UsageError::from(
                "run: --participant: none given: a simulated observer needs a code",
            ));
        }
        (Some(observer), [request]) => run_simulated(request, observer)?,
        (Some(_), _) => {
            return Err(UsageError::from(
                "run: PROTOCOL: none given: a simulated observer needs one",
            ));
        }
        (None, requests) => in_window(requests, args.display.as_deref())?,
    };
    report(&outcome)
}

fn in_cohort(request: &SessionRequest, file: &Path) -> anyhow::Result<()> {
    let SessionRequest { protocol, stimuli, study, .. } = request.clone();
    let tables = file.parent().unwrap_or(Path::new("")).into();
    let cohort = Cohort::read(file)?;
    let CohortOutcome { study, sessions_now, sessions_before, answers_now } =
        run_cohort(&CohortRequest { protocol, stimuli, study, cohort, tables })?;
    let sessions = counted(sessions_now, "session");
    let answers = counted(answers_now, "answer");
    say(&format!("{sessions} now, {sessions_before} before; {answers}, in {}", study.display()))
}

/// The protocol that is given or that the study was begun with, or else all shipped ones.
fn protocols_of(args: &Args) -> anyhow::Result<Vec<Protocol>> {
    let Some(name) = &args.protocol else {
        let kind = match (args.pilot, args.observer.is_some() || args.cohort.is_some()) {
            (true, _) => StudyKind::Pilot,
            (false, true) => StudyKind::Simulated,
            (false, false) => StudyKind::Real,
        };
        let begun = kind.folder(&args.study).join("protocol.toml");
        return match begun.exists() {
            true => Ok(vec![Protocol::read(&begun)?]),
            false => Ok(protocols::shipped()?),
        };
    };
    let is_file = Path::new(name).exists();
    let protocol = protocols::load(name)
        .map_err(|error| if is_file { error.into() } else { UsageError::from(error) })?;
    Ok(vec![protocol])
}

#[cfg(feature = "window")]
fn in_window(requests: &[SessionRequest], display: Option<&Path>) -> anyhow::Result<Outcome> {
    use shutterlab_data_schema::DisplayProfile;
    let profile = display.map_or_else(|| Ok(DisplayProfile::identity()), DisplayProfile::read)?;
    Ok(shutterlab_experiments::window::run(requests, &profile)?)
}

#[cfg(not(feature = "window"))]
fn in_window(_: &[SessionRequest], _: Option<&Path>) -> anyhow::Result<Outcome> {
    anyhow::bail!(
        "run: this build has no window (feature `window`); it runs simulated observers only"
    )
}

fn report(outcome: &Outcome) -> anyhow::Result<()> {
    let Outcome { subject, data_file, answered_now, answered_before, trials, finished } = outcome;
    let state = match (finished, answered_now) {
        (true, 0) => "was already finished".to_string(),
        (true, _) => "finished".to_string(),
        (false, _) => format!(
            "stopped at {} of {trials} trials; run the same again to go on",
            answered_before + answered_now
        ),
    };
    let counts = format!("{answered_now} answers now, {answered_before} before");
    say(&format!("{subject}: {state}; {counts}, in {}", data_file.display()))
}

/// The simulated observer called `simulated:NAME`.
fn parse_observer(text: &str) -> Result<SimulatedObserver, String> {
    let names: Vec<&str> = published::tables().iter().map(|table| table.name).collect();
    let allowed =
        || format!("simulated:guess or simulated: with one of {} is needed", names.join(", "));
    match text.strip_prefix("simulated:") {
        Some("guess") => Ok(SimulatedObserver::guess()),
        Some(name) => {
            published_observer(name).map_err(|error| error.to_string())?.ok_or_else(allowed)
        }
        None => Err(allowed()),
    }
}

/// An observer whose preferences follow the published votes called `name`, if there are such.
pub(super) fn published_observer(name: &str) -> anyhow::Result<Option<SimulatedObserver>> {
    let Some(table) = published::find(name) else { return Ok(None) };
    let votes = Votes::parse(table.csv, name)?;
    let observers = u32::try_from(table.observers).context("observers of a published table")?;
    Ok(Some(SimulatedObserver::from_votes(name, &votes, observers)?))
}
