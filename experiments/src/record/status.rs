//! Who has done what in a study, for whoever looks after it: read from the files, without changing any.

use super::heartbeat::{self, Heartbeat, Look, PATIENCE, latest};
use super::log::{CRASHED, FINISHED, Story};
use super::study::SessionFiles;
use super::withdraw::{self, Withdrawal};
use super::{RecordError, participants, rows};
use jiff::Timestamp;
use serde::Serialize;
use shutterlab_data_schema::definition;
use shutterlab_data_schema::response::TrialKind;
use shutterlab_data_schema::study::{StudyKind, data_files};
use shutterlab_data_schema::{Participant, ParticipantCode, Protocol, Response};
use std::path::Path;

/// How far a study is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyStatus {
    /// Whose answers it holds.
    pub kind: StudyKind,
    /// Title of the protocol; none if the protocol cannot be read.
    pub title: Option<String>,
    /// Participants, in the order in which they were entered.
    pub participants: Vec<Participant>,
    /// Sessions, in the order of their files.
    pub sessions: Vec<SessionStatus>,
    /// Participants who were withdrawn.
    pub withdrawn: Vec<Withdrawal>,
    /// What could not be read, and why.
    pub faults: Vec<String>,
}

/// How far a session is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionStatus {
    /// Who answers.
    pub subject: ParticipantCode,
    /// The sitting, from 1.
    pub session: u32,
    /// Where the last answer was given, or the session is open; none if neither is known.
    pub station: Option<String>,
    /// What it is doing.
    pub state: Progress,
    /// Trials answered, practice included.
    pub answered: u32,
    /// Trials of the session; none if no heartbeat says so.
    pub of: Option<u32>,
    /// Minutes from the first answer to the last, breaks included.
    pub minutes: f64,
    /// Frames shown late or never in the answered trials.
    pub late_frames: u32,
    /// Catch trials that were answered rightly, and all that were answered.
    pub catch_right: u32,
    /// Catch trials answered.
    pub catch_asked: u32,
    /// Trials that were set aside, to be asked again.
    pub set_aside: u32,
    /// How often the program that ran it was killed or crashed.
    pub crashes: u32,
    /// Coefficient of consistency; none if it is not known.
    pub zeta: Option<f64>,
    /// The last heartbeat of the program that runs it; none if none runs it.
    pub heartbeat: Option<Heartbeat>,
    /// Seconds since then, by this computer's clock, which may differ from that of the station.
    pub heartbeat_age_s: Option<f64>,
}

/// What a session is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Progress {
    /// A program runs it.
    Running,
    /// It came to its end.
    Finished,
    /// It was left before its end and can be continued.
    Left,
    /// The program that ran it was killed, or failed; the session can be continued.
    Crashed,
}

/// A session whose files were read once, and the look at its claims.
struct Seen {
    files: SessionFiles,
    status: SessionStatus,
    story: Story,
    look: Option<Look>,
}

/// Looks at the study of the kind `kind` in `folder`; none if there is none. `zeta` judges the rows of
/// finished sessions.
///
/// Whether a session of another station still runs is told by looking twice, some seconds apart.
pub fn status(
    folder: &Path,
    kind: StudyKind,
    zeta: impl Fn(&[Response]) -> Option<f64>,
) -> Option<StudyStatus> {
    let folder = kind.folder(folder);
    let mut faults = vec![];
    let mut kept = |fault: &dyn std::fmt::Display| faults.push(fault.to_string());
    let file = folder.join("protocol.toml");
    if !file.exists() {
        return None;
    }
    let protocol = definition::read::<Protocol>(&file).map_err(|e| kept(&e)).ok();
    let records = participants::files(&folder).map_err(|e| kept(&e)).unwrap_or_default();
    let mut participants = vec![];
    for file in records {
        match participants::read(&file) {
            Ok(record) => participants.push(record.participant),
            Err(error) => kept(&error),
        }
    }
    participants.sort_by_key(|participant| participant.ordinal);
    let withdrawn = withdraw::traces(&folder).map_err(|e| kept(&e)).unwrap_or_default();

    let station = heartbeat::station_name();
    let mut seen = vec![];
    for file in data_files(&folder).map_err(|e| kept(&e)).unwrap_or_default() {
        match look_at(&folder, &file, &zeta) {
            Ok(session) => seen.push(session),
            Err(error) => kept(&error),
        }
    }
    let is_from_here =
        |look: &Look| look.heartbeat.as_ref().is_some_and(|last| last.is_from_here(&station));
    let needs_a_second_look = |look: &Look| look.is_open() && !is_from_here(look);
    if seen.iter().filter_map(|session| session.look.as_ref()).any(needs_a_second_look) {
        std::thread::sleep(PATIENCE);
    }
    let mut sessions = vec![];
    for Seen { files, mut status, story, look } in seen {
        let is_unended = look.as_ref().and_then(Look::unended).is_some();
        let running = match look {
            Some(look) if is_from_here(&look) => Some(look).filter(|_| files.runs_here(&station)),
            Some(look) if look.is_open() => match latest(&files.claims) {
                Ok(now) => now.filter(|now| now.is_open() && *now != look),
                Err(error) => {
                    kept(&error);
                    None
                }
            },
            _ => None,
        };
        status.state = match (&running, story.last_event()) {
            (Some(_), _) => Progress::Running,
            (None, Some(FINISHED)) => Progress::Finished,
            (None, Some(CRASHED)) => Progress::Crashed,
            (None, _) if story.is_open() || is_unended => {
                // The journal will say so when the session goes on.
                status.crashes += 1;
                Progress::Crashed
            }
            (None, _) => Progress::Left,
        };
        status.heartbeat = running.and_then(|look| look.heartbeat);
        status.heartbeat_age_s = status.heartbeat.as_ref().and_then(age_s);
        sessions.push(status);
    }
    let title = protocol.map(|protocol| protocol.title);
    Some(StudyStatus { kind, title, participants, sessions, withdrawn, faults })
}

/// Reads the files of the session whose answers are in `file`.
fn look_at(
    folder: &Path,
    file: &Path,
    zeta: &impl Fn(&[Response]) -> Option<f64>,
) -> Result<Seen, RecordError> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let part = |keyword: &str| {
        name.split('_').find_map(|part| part.strip_prefix(keyword)?.strip_prefix('-'))
    };
    let subject = part("subject").and_then(|text| text.parse::<ParticipantCode>().ok());
    let session = part("session").and_then(|text| text.parse::<u32>().ok());
    let (Some(study), Some(subject), Some(session)) = (part("study"), subject, session) else {
        return Err(super::damaged(
            file,
            "the name of a file of answers says study, subject and session",
        ));
    };
    let files = SessionFiles::new(folder, &name);
    let rows = rows::read(file, study, &subject)?.rows;
    let story = Story::read(&files.journal)?;
    let look = latest(&files.claims)?;
    let catch = |row: &&Response| row.kind == TrialKind::Catch;
    let right = |row: &&Response| row.correct == Some(true);
    let claim = look.as_ref().and_then(|look| look.heartbeat.as_ref());
    let is_finished = story.last_event() == Some(FINISHED);
    let status = SessionStatus {
        subject,
        session,
        station: claim.map(|c| &c.station).or(rows.last().map(|row| &row.station)).cloned(),
        state: Progress::Left,
        answered: rows.len() as u32,
        of: claim.map(|c| c.of).filter(|of| *of > 0),
        minutes: minutes(&rows),
        late_frames: rows.iter().fold(0, |sum, row| sum.saturating_add(row.untimely_frames())),
        catch_right: rows.iter().filter(catch).filter(right).count() as u32,
        catch_asked: rows.iter().filter(catch).count() as u32,
        set_aside: story.set_aside.len() as u32,
        crashes: story.crashes,
        zeta: if is_finished { zeta(&rows) } else { None },
        heartbeat: None,
        heartbeat_age_s: None,
    };
    Ok(Seen { files, status, story, look })
}

/// From the first answer to the last.
fn minutes(rows: &[Response]) -> f64 {
    let at = |row: Option<&Response>| row?.answered_at.parse::<Timestamp>().ok();
    match (at(rows.first()), at(rows.last())) {
        (Some(first), Some(last)) => last.duration_since(first).as_secs_f64() / 60.0,
        _ => 0.0,
    }
}

fn age_s(heartbeat: &Heartbeat) -> Option<f64> {
    let then: Timestamp = heartbeat.updated_at.parse().ok()?;
    Some(Timestamp::now().duration_since(then).as_secs_f64())
}
