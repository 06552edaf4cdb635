//! The rows of one session's answers: a CSV that only ever grows by whole rows.
//!
//! A row is appended in one write, then synced: a crash can lose only the row being written, and a
//! row that is only half there is found when the file is next opened, moved to the log and cut off.
//! Anything else that does not fit (another header, a damaged earlier row) is an error with its line,
//! and the file is left as it is.

use super::RecordError;
use csv::ReaderBuilder;
use shutterlab_data_schema::ParticipantCode;
use shutterlab_data_schema::files::{named, sync_folder};
use shutterlab_data_schema::response::Response;
use shutterlab_data_schema::study::responses_schema;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// What rows are written to: a file, or a test's stand-in for a failing one.
pub trait Storage {
    /// Writes `bytes` at the end, in one go.
    ///
    /// # Errors
    /// Some or all of the bytes were not written.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Cuts off everything after the first `length` bytes.
    ///
    /// # Errors
    /// Nothing was cut off.
    fn cut(&mut self, length: u64) -> io::Result<()>;

    /// Waits until everything written is where a power cut cannot reach it.
    ///
    /// # Errors
    /// The system cannot say so.
    fn sync(&mut self) -> io::Result<()>;
}

impl Storage for File {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.seek(SeekFrom::End(0))?;
        self.write_all(bytes)?;
        self.flush()
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_data()
    }
}

/// Appends rows to a session's data file.
#[derive(Debug)]
pub struct RowFile<S> {
    path: PathBuf,
    storage: S,
    /// Length of the whole rows, which a failed write must not change.
    length: u64,
    /// Part of a row that could not be written may lie behind them.
    dirty: bool,
}

/// What a data file held when it was opened.
#[derive(Debug, Default)]
pub struct Found {
    /// Its whole rows.
    pub rows: Vec<Response>,
    /// A last row that was only half there. It is cut off when it has been noted elsewhere.
    pub torn: Option<String>,
    /// Length of the header and the whole rows, in bytes.
    length: u64,
}

/// Reads the data file of `subject` in the study `study`; a missing file holds nothing.
///
/// # Errors
/// The file cannot be read; its header is another one; a row other than the last is damaged.
pub fn read(path: &Path, study: &str, subject: &ParticipantCode) -> Result<Found, RecordError> {
    let bytes = match std::fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Found::default()),
        other => other.map_err(|e| named(path, &e))?,
    };
    let damaged = |line: u64, what: String| RecordError::Damaged { file: path.into(), line, what };
    let header = header();
    if !bytes.contains(&b'\n') && header.starts_with(&bytes) {
        let torn = (!bytes.is_empty()).then(|| lossy(&bytes));
        return Ok(Found { torn, ..Found::default() });
    }
    if !bytes.starts_with(header) {
        let line = lossy(bytes.split(|&b| b == b'\n').next().unwrap_or_default());
        let what = format!("header: {line:.200}: {} is needed", lossy(header).trim_end());
        return Err(damaged(1, what));
    }

    let mut found = Found { length: header.len() as u64, ..Found::default() };
    let mut reader = ReaderBuilder::new().flexible(true).from_reader(bytes.as_slice());
    let names = reader.byte_headers().map_err(io::Error::other)?.clone();
    let mut record = csv::ByteRecord::new();
    while reader.read_byte_record(&mut record).map_err(io::Error::other)? {
        let line = record.position().map_or(0, csv::Position::line);
        let end = reader.position().byte();
        let parsed = record.deserialize::<Response>(Some(&names));
        // Too few fields may be a torn row; too many are two rows run together.
        if record.len() > names.len() {
            let what = format!("{} fields: {} are needed", record.len(), names.len());
            return Err(damaged(line, what));
        }
        let tail = &bytes[found.length as usize..];
        let is_last = end as usize >= bytes.len();
        match parsed {
            Ok(row) if !is_last || bytes.ends_with(b"\n") => {
                found.rows.push(row);
                found.length = end;
            }
            // A torn row is the beginning of one row. If another row begins inside it, it is damage.
            Ok(_) | Err(_) if is_last && !holds_a_row_start(tail, study, subject) => {
                found.torn = Some(lossy(tail));
            }
            Ok(_) => return Err(damaged(line, "the file's end is damaged".into())),
            Err(error) => {
                return Err(damaged(line, format!("not a whole row of answers: {error}")));
            }
        }
    }
    Ok(found)
}

impl RowFile<File> {
    /// Opens the file at `path`, which [`read`] found to hold `found`; cuts off a torn row and writes
    /// the header if there is none.
    ///
    /// # Errors
    /// The file cannot be opened or written.
    pub fn open(path: &Path, found: &Found) -> io::Result<Self> {
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path);
        let mut rows = Self::new(path, file.map_err(|e| named(path, &e))?, found.length);
        if found.torn.is_some() {
            rows.storage.cut(found.length).map_err(|e| named(path, &e))?;
        }
        if found.length == 0 {
            rows.append_bytes(header())?;
            sync_folder(path.parent().unwrap_or(Path::new("."))).map_err(|e| named(path, &e))?;
        }
        Ok(rows)
    }
}

impl<S: Storage> RowFile<S> {
    /// Rows that go to `storage`, which holds `length` bytes of header and whole rows.
    pub fn new(path: &Path, storage: S, length: u64) -> Self {
        Self { path: path.into(), storage, length, dirty: false }
    }

    /// Where the rows go.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends `response` and waits until it is safe.
    ///
    /// # Errors
    /// The row is not there: it can be tried again.
    pub fn append(&mut self, response: &Response) -> io::Result<()> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(vec![]);
        writer.serialize(response)?;
        let row = writer.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
        self.append_bytes(&row)
    }

    fn append_bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        let attempt = self
            .remove_half_row()
            .and_then(|()| self.storage.append(bytes))
            .and_then(|()| self.storage.sync());
        match attempt {
            Ok(()) => {
                self.length += bytes.len() as u64;
                Ok(())
            }
            Err(error) => {
                // If even the cut fails, the next attempt begins with it, and so does the next
                // opening of the file: no row ever follows half a row.
                self.dirty = true;
                self.remove_half_row().ok();
                Err(named(&self.path, &error))
            }
        }
    }

    fn remove_half_row(&mut self) -> io::Result<()> {
        if self.dirty {
            self.storage.cut(self.length)?;
            self.dirty = false;
        }
        Ok(())
    }
}

/// The header line of a file of answers.
pub(super) fn header() -> &'static [u8] {
    static HEADER: LazyLock<String> = LazyLock::new(|| {
        let schema = responses_schema();
        let fields = schema["fields"].as_array().into_iter().flatten();
        let names: Vec<&str> = fields.filter_map(|field| field["name"].as_str()).collect();
        format!("{}\n", names.join(","))
    });
    HEADER.as_bytes()
}

fn holds_a_row_start(tail: &[u8], study: &str, subject: &ParticipantCode) -> bool {
    let start = format!("\n{study},{subject},");
    tail.windows(start.len()).any(|window| window == start.as_bytes())
}

fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[cfg(test)]
pub(super) mod tests;
