//! Which program runs a session, and that it still does.
//!
//! A session is claimed by a numbered file that only one of several stations can create; the one with
//! the highest number counts. The program that created it writes it anew every few seconds, with
//! another count each time: that is its heartbeat. A claim whose count stands still belongs to a
//! program that crashed, and the next number may be taken. Clocks of two computers are never compared.

use super::{RecordError, list};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::files::{create_unsynced, named, write_unsynced};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Folder of the claims, with a folder for each session in it.
pub(super) const CLAIMS: &str = "log/claims";

/// Time between two heartbeats.
pub const PERIOD: Duration = Duration::from_secs(2);

/// How long a count must stand still until its program is taken for dead: two heartbeats and half a one,
/// for a slow network.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);

/// What the program that runs a session says about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Heartbeat {
    /// Name of the computer.
    pub station: String,
    /// What tells the computer, since it was last started, from all others; none where the system does
    /// not say.
    pub boot: Option<String>,
    /// Number of the process.
    pub process: u32,
    /// Version of the program.
    pub program_version: String,
    /// Who is asked.
    pub subject: ParticipantCode,
    /// The sitting, from 1.
    pub session: u32,
    /// The trial being asked, or asked last; 0 before the first.
    pub trial: u32,
    /// Trials of the session.
    pub of: u32,
    /// What the session is doing.
    pub state: State,
    /// Frames that were shown late or never, since the program opened the session.
    pub late_frames: u32,
    /// When the program opened the session, by its computer's clock (UTC, RFC 3339).
    pub began_at: String,
    /// When this was written, by the same clock.
    pub updated_at: String,
    /// How often this was written.
    pub count: u64,
}

/// What a session is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// A trial is being asked.
    Running,
    /// No trial is being asked: a break, a page of text, or a moment between two trials.
    Paused,
    /// The program has closed the session.
    Ended,
}

impl Heartbeat {
    /// The heartbeat of this process, which opens session number `session` of `subject`, with `of`
    /// trials, on the computer called `station`.
    pub(super) fn new(station: &str, subject: &ParticipantCode, session: u32, of: u32) -> Self {
        let now = format!("{:.3}", Timestamp::now());
        Self {
            station: station.into(),
            boot: boot(),
            process: std::process::id(),
            program_version: env!("CARGO_PKG_VERSION").into(),
            subject: subject.clone(),
            session,
            trial: 0,
            of,
            state: State::Paused,
            late_frames: 0,
            began_at: now.clone(),
            updated_at: now,
            count: 0,
        }
    }

    /// Whether it is from the computer called `station` as it runs now.
    pub(super) fn is_from_here(&self, station: &str) -> bool {
        self.station == station && self.boot.is_some() && self.boot == boot()
    }

    /// The bytes of its file.
    fn bytes(&self) -> io::Result<Vec<u8>> {
        Ok(serde_json::to_vec(self)?)
    }
}

fn boot() -> Option<String> {
    let id = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    Some(id.trim().into())
}

/// Name of this computer: that in the environment variable `SHUTTERLAB_STATION`, for laboratories whose
/// computers all have the same name, or what the system says.
pub fn station_name() -> String {
    let from_file = |path| std::fs::read_to_string(path).ok();
    std::env::var("SHUTTERLAB_STATION")
        .or_else(|_| std::env::var("COMPUTERNAME"))
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

/// `station` as part of the name of a file.
pub(super) fn in_file_name(station: &str) -> String {
    station
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' })
        .collect()
}

/// The claim that counts in `folder`, if there is one.
///
/// # Errors
/// It cannot be read.
pub(super) fn latest(folder: &Path) -> Result<Option<Look>, RecordError> {
    let Some(number) = last_number(folder)? else { return Ok(None) };
    let file = path(folder, number);
    let bytes = std::fs::read(&file).map_err(|e| named(&file, &e))?;
    let heartbeat = serde_json::from_slice(&bytes).ok();
    Ok(Some(Look { number, bytes, heartbeat }))
}

fn last_number(folder: &Path) -> Result<Option<u64>, RecordError> {
    let number = |file: PathBuf| file.file_stem()?.to_str()?.parse::<u64>().ok();
    Ok(list(folder, ".json")?.into_iter().filter_map(number).max())
}

fn path(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{number}.json"))
}

/// The claim that counts, as it was when it was looked at.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Look {
    number: u64,
    bytes: Vec<u8>,
    /// What it says; none if that cannot be read. Claims are not synced: a power cut can tear them.
    pub heartbeat: Option<Heartbeat>,
}

impl Look {
    /// Its heartbeat, unless that was the last one.
    pub fn unended(&self) -> Option<&Heartbeat> {
        self.heartbeat.as_ref().filter(|heartbeat| heartbeat.state != State::Ended)
    }

    /// Whether a program may run the session, so that only a second look can tell.
    pub fn is_open(&self) -> bool {
        self.heartbeat.is_none() || self.unended().is_some()
    }
}

/// A claim to a session. It beats until it is dropped.
#[derive(Debug)]
pub(super) struct Claim {
    folder: PathBuf,
    number: u64,
    heartbeat: Arc<Mutex<Heartbeat>>,
    /// Its end ends the thread.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Claim {
    /// Claims the session whose claims lie in `folder`. `lock` says that no other program of this
    /// computer runs it. Returns also the last heartbeat of a program that crashed, if it can be read.
    ///
    /// # Errors
    /// Another program runs it; a file cannot be read or written.
    pub fn take(
        folder: &Path,
        mine: Heartbeat,
        lock: bool,
    ) -> Result<(Self, Option<Heartbeat>), RecordError> {
        loop {
            let before = latest(folder)?;
            let last = before.as_ref().and_then(Look::unended);
            let is_dead = lock && last.is_some_and(|last| last.is_from_here(&mine.station));
            if !is_dead && before.as_ref().is_some_and(Look::is_open) {
                std::thread::sleep(PATIENCE);
                let now = latest(folder)?;
                if now != before {
                    let Some(other) = now.filter(Look::is_open) else { continue };
                    let [station, since] = other
                        .heartbeat
                        .map_or(["unknown".into(), "unknown".into()], |h| [h.station, h.began_at]);
                    let (file, subject) = (folder.into(), mine.subject);
                    return Err(RecordError::Locked { file, subject, station, since });
                }
            }
            let number = before.as_ref().map_or(1, |before| before.number + 1);
            // If another program was faster, its claim has that number and is found in the next round.
            if create_unsynced(&path(folder, number), &mine.bytes()?)? {
                return Ok((Self::beating(folder, number, mine), last.cloned()));
            }
        }
    }

    fn beating(folder: &Path, number: u64, mine: Heartbeat) -> Self {
        let heartbeat = Arc::new(Mutex::new(mine));
        let (stop, stopped) = channel();
        let (file, shared) = (path(folder, number), heartbeat.clone());
        let beat = move |end: bool| {
            let mut heartbeat = locked(&shared);
            heartbeat.count += 1;
            heartbeat.updated_at = format!("{:.3}", Timestamp::now());
            if end {
                heartbeat.state = State::Ended;
            }
            let bytes = heartbeat.bytes();
            drop(heartbeat);
            // A missed heartbeat is no reason to disturb a session: the next one may reach the disk.
            bytes.and_then(|bytes| write_unsynced(&file, &bytes)).ok();
        };
        let thread = std::thread::spawn(move || {
            while stopped.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                beat(false);
            }
            beat(true);
        });
        Self { folder: folder.into(), number, heartbeat, stop: Some(stop), thread: Some(thread) }
    }

    /// The folder of the session's claims.
    #[cfg(test)]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Changes what the next heartbeat says.
    pub fn tell(&self, change: impl FnOnce(&mut Heartbeat)) {
        change(&mut locked(&self.heartbeat));
    }

    /// Refuses to go on if another program has taken the session over, as it may when this one, or its
    /// computer, stood still.
    ///
    /// # Errors
    /// Another program has; the folder cannot be read.
    pub fn check(&self) -> Result<(), RecordError> {
        // Listed anew: a network share may remember for a while that a file was not there.
        match last_number(&self.folder)?.filter(|last| *last > self.number) {
            Some(last) => {
                let subject = locked(&self.heartbeat).subject.clone();
                Err(RecordError::TakenOver { file: path(&self.folder, last), subject })
            }
            None => Ok(()),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn locked(heartbeat: &Mutex<Heartbeat>) -> MutexGuard<'_, Heartbeat> {
    heartbeat.lock().unwrap_or_else(PoisonError::into_inner)
}
