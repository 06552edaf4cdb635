//! `shutterlab run`: a session, in a window or with a simulated observer.

use super::{UsageError, say};
use anyhow::Context;
use shutterlab_analysis::published;
use shutterlab_data_schema::{ParticipantCode, Votes};
use shutterlab_experiments::{
    Outcome, SessionRequest, SimulatedObserver, protocols, run_simulated,
};
use std::path::{Path, PathBuf};

/// Run a session of an experiment. Each answer is saved when it is given; run the same again to go
/// on with an interrupted session.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A shipped protocol (demo) or a protocol file
    protocol: String,
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
    /// A trial run: its answers are kept apart and never count
    #[arg(long)]
    pilot: bool,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let is_file = Path::new(&args.protocol).exists();
    let protocol = protocols::load(&args.protocol)
        .map_err(|error| if is_file { error.into() } else { UsageError::from(error) })?;
    let request = SessionRequest {
        protocol,
        stimuli: args.stimuli.clone(),
        study: args.study.clone(),
        participant: args.participant.clone(),
        pilot: args.pilot,
    };
    let outcome = match &args.observer {
        Some(_) if args.participant.is_none() => {
            return Err(UsageError::from(
                "run: --participant: none given: a simulated observer needs a code",
            ));
        }
        Some(observer) => run_simulated(&request, observer)?,
        None => in_window(&request)?,
    };
    report(&outcome)
}

#[cfg(feature = "window")]
fn in_window(request: &SessionRequest) -> anyhow::Result<Outcome> {
    Ok(shutterlab_experiments::window::run(request)?)
}

#[cfg(not(feature = "window"))]
fn in_window(_: &SessionRequest) -> anyhow::Result<Outcome> {
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
