//! `shutterlab status`: who has done what, and how well the stations do.

use super::{counted, say};
use anyhow::bail;
use serde::Serialize;
use shutterlab_analysis::paired::circular_triads::{circular_triads, consistency};
use shutterlab_data_schema::Response;
use shutterlab_data_schema::protocol::Task;
use shutterlab_data_schema::response::TrialKind;
use shutterlab_data_schema::study::StudyKind;
use shutterlab_experiments::record::status::{Progress, SessionStatus, StudyStatus, status};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Show who has done what in a study: sessions, stations, and what went wrong.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the study
    study: PathBuf,
    /// Print the status as JSON
    #[arg(long)]
    json: bool,
}

/// A study, and its stations.
#[derive(Serialize)]
struct Section {
    #[serde(flatten)]
    study: StudyStatus,
    stations: Vec<Station>,
}

/// What was done at a station.
#[derive(Serialize)]
struct Station {
    station: String,
    sessions: u32,
    finished: u32,
    crashes: u32,
    answers: u32,
    late_frames: u32,
    catch_right: u32,
    catch_asked: u32,
    /// Mean coefficient of consistency of the finished 2AFC sessions; none if there is none.
    zeta: Option<f64>,
    /// Seconds since the last heartbeat of a session that runs here.
    heartbeat_age_s: Option<f64>,
}

pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let sections: Vec<Section> = StudyKind::ALL
        .into_iter()
        .filter_map(|kind| status(&args.study, kind, zeta))
        .map(|study| Section { stations: stations(&study.sessions), study })
        .collect();
    if sections.is_empty() {
        bail!("{}: not a study: it has no protocol.toml", args.study.display());
    }
    if args.json {
        return say(&serde_json::to_string_pretty(&sections)?);
    }
    let texts: Vec<String> = sections.iter().map(text).collect();
    say(&texts.join("\n"))
}

/// Kendall's ζ of one session: the mean over its complete sets of pairs, each pair judged once.
fn zeta(rows: &[Response]) -> Option<f64> {
    let counts = |row: &&Response| {
        row.task == Task::TwoAfc && !matches!(row.kind, TrialKind::Practice | TrialKind::Catch)
    };
    let mut sets: BTreeMap<u32, Vec<&Response>> = BTreeMap::new();
    for row in rows.iter().filter(counts) {
        sets.entry(row.repetition).or_default().push(row);
    }
    let zetas: Vec<f64> = sets.values().filter_map(|set| zeta_of_set(set)).collect();
    (!zetas.is_empty()).then(|| zetas.iter().sum::<f64>() / zetas.len() as f64)
}

fn zeta_of_set(set: &[&Response]) -> Option<f64> {
    let mut scores: BTreeMap<&str, u64> = BTreeMap::new();
    let mut pairs = BTreeSet::new();
    for row in set {
        let (a, b) = (row.stimulus_a.as_str(), row.stimulus_b.as_str());
        pairs.insert((a.min(b), a.max(b)));
        for stimulus in [a, b] {
            *scores.entry(stimulus).or_default() += u64::from(row.selected.as_deref()? == stimulus);
        }
    }
    let t = scores.len();
    let complete = t >= 3 && pairs.len() == set.len() && pairs.len() == t * (t - 1) / 2;
    let scores: Vec<u64> = scores.into_values().collect();
    complete.then(|| consistency(circular_triads(&scores), 1, t))
}

fn stations(sessions: &[SessionStatus]) -> Vec<Station> {
    let mut by_name: BTreeMap<String, Vec<&SessionStatus>> = BTreeMap::new();
    for session in sessions {
        let name = session.station.clone().unwrap_or_else(|| "unknown".into());
        by_name.entry(name).or_default().push(session);
    }
    let station = |(station, sessions): (String, Vec<&SessionStatus>)| {
        let sum = |of: &dyn Fn(&SessionStatus) -> u32| sessions.iter().map(|s| of(s)).sum();
        let zetas: Vec<f64> = sessions.iter().filter_map(|session| session.zeta).collect();
        Station {
            station,
            sessions: sessions.len() as u32,
            finished: sum(&|session| u32::from(session.state == Progress::Finished)),
            crashes: sum(&|session| session.crashes),
            answers: sum(&|session| session.answered),
            late_frames: sum(&|session| session.late_frames),
            catch_right: sum(&|session| session.catch_right),
            catch_asked: sum(&|session| session.catch_asked),
            zeta: (!zetas.is_empty()).then(|| zetas.iter().sum::<f64>() / zetas.len() as f64),
            heartbeat_age_s: sessions
                .iter()
                .filter_map(|session| session.heartbeat_age_s)
                .min_by(f64::total_cmp),
        }
    };
    by_name.into_iter().map(station).collect()
}

/// The section in words and tables.
fn text(Section { study, stations }: &Section) -> String {
    let banner = match study.kind {
        StudyKind::Real => "",
        StudyKind::Pilot => "PILOT, never a result: ",
        StudyKind::Simulated => "SIMULATED OBSERVERS, never a finding: ",
    };
    let title = study.title.as_deref().unwrap_or("protocol cannot be read");
    let mut text = format!(
        "{banner}{title}\n{}, {}\n",
        counted(study.participants.len(), "participant"),
        counted(study.sessions.len(), "session")
    );
    let share = |right: u32, of: u32| if of == 0 { "-".into() } else { format!("{right}/{of}") };
    let decimals = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.2}"));
    let mut rows = vec![
        ["participant", "session", "station", "state", "answers", "minutes", "late", "set aside"]
            .into_iter()
            .chain(["crashes", "catch", "zeta"])
            .map(String::from)
            .collect::<Vec<_>>(),
    ];
    rows.extend(study.sessions.iter().map(|s| {
        let answers = s.of.map_or(s.answered.to_string(), |of| format!("{} of {of}", s.answered));
        let state = match (s.state, &s.heartbeat) {
            (Progress::Running, Some(heartbeat)) => format!("running, trial {}", heartbeat.trial),
            (state, _) => format!("{state:?}").to_lowercase(),
        };
        vec![
            s.subject.to_string(),
            s.session.to_string(),
            s.station.clone().unwrap_or_else(|| "-".into()),
            state,
            answers,
            format!("{:.1}", s.minutes),
            s.late_frames.to_string(),
            s.set_aside.to_string(),
            s.crashes.to_string(),
            share(s.catch_right, s.catch_asked),
            decimals(s.zeta),
        ]
    }));
    text += &table(&rows);
    let mut rows = vec![
        ["station", "sessions", "finished", "crashes", "answers", "late", "catch", "zeta"]
            .into_iter()
            .chain(["heartbeat"])
            .map(String::from)
            .collect::<Vec<_>>(),
    ];
    rows.extend(stations.iter().map(|s| {
        let heartbeat = s.heartbeat_age_s.map_or("-".into(), |age| format!("{age:.0} s ago"));
        vec![
            s.station.clone(),
            s.sessions.to_string(),
            s.finished.to_string(),
            s.crashes.to_string(),
            s.answers.to_string(),
            s.late_frames.to_string(),
            share(s.catch_right, s.catch_asked),
            decimals(s.zeta),
            heartbeat,
        ]
    }));
    text += &format!("\n{}", table(&rows));
    if stations.iter().any(|station| station.heartbeat_age_s.is_some()) {
        text +=
            "(heartbeats are timed by the station's clock, which may differ from the one here)\n";
    }
    for gone in &study.withdrawn {
        let state = match gone.completed_at {
            Some(_) => "",
            None => "; interrupted: withdraw again to complete it",
        };
        let answers = counted(gone.rows as usize, "answer");
        text += &format!("{} withdrawn {}, {answers}{state}\n", gone.subject, gone.withdrawn_at);
    }
    for fault in &study.faults {
        text += &format!("cannot be read: {fault}\n");
    }
    text
}

/// `rows` in columns as wide as they need to be.
fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: Vec<usize> = (0..columns).filter_map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:width$}"));
        format!("{}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    rows.iter().map(line).collect()
}
