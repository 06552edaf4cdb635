//! Torn rows are cut off, damaged files are left alone, a full disk loses nothing.

use super::*;
use shutterlab_data_schema::protocol::{Eye, Task};
use shutterlab_data_schema::response::{Answer, Clock, Pacing, Resampling, Side, TrialKind};

pub(in crate::record) fn response(trial: u32) -> Response {
    Response {
        study: "demo".into(),
        subject: subject(),
        session: 1,
        station: "here".into(),
        block: 1,
        trial,
        repetition: 1,
        attempt: 1,
        kind: TrialKind::Real,
        observer: "participant".into(),
        task: Task::TwoAfc,
        question: "Which, \"left\" or\nright?".into(),
        reference: None,
        stimulus_a: "T3".into(),
        exemplar_a: 0,
        hash_a: "aa".into(),
        stimulus_b: "T4".into(),
        exemplar_b: 0,
        hash_b: "bb".into(),
        first: Side::B,
        answer: Answer::First,
        selected: Some("T4".into()),
        correct: None,
        response_time_s: 1.25,
        replays_reference: None,
        replays_a: 0,
        replays_b: 1,
        onset_reference_s: None,
        onset_a_s: 0.5,
        onset_b_s: 2.0,
        duration_reference_s: None,
        duration_a_s: 1.0,
        duration_b_s: 1.0,
        late_frames_reference: None,
        late_frames_a: 0,
        late_frames_b: 3,
        dropped_frames_reference: None,
        dropped_frames_a: 0,
        dropped_frames_b: 1,
        repeated_frames_reference: None,
        repeated_frames_a: 0,
        repeated_frames_b: 4,
        clock: Clock::Submission,
        pacing: Pacing::FixedRefresh,
        refresh_hz: Some(59.94),
        refreshes_per_frame: Some(2.0),
        display: "screen, 1280×800 px".into(),
        display_profile: "identity".into(),
        display_profile_sha256: None,
        display_faults: Some("no profile; \"quoted\"".into()),
        stereo_mode: "mono".into(),
        magnification: 1.0,
        resampling: Resampling::None,
        eye: Eye::Follow,
        pixels_per_degree: 17.8,
        viewed_pixels_per_degree: None,
        model: None,
        r: None,
        level_of_detail: None,
        speed_deg_per_s: 10.0,
        pilot: false,
        answered_at: "2026-11-22T06:00:00.000Z".into(),
        program_version: "0.1.0".into(),
    }
}

fn subject() -> ParticipantCode {
    "01".parse().unwrap()
}

fn found(path: &Path) -> Result<Found, RecordError> {
    read(path, "demo", &subject())
}

/// A file of three rows, and its bytes.
fn three_rows() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rows.csv");
    let mut rows = RowFile::open(&path, &Found::default()).unwrap();
    for trial in 1..=3 {
        rows.append(&response(trial)).unwrap();
    }
    let bytes = std::fs::read(&path).unwrap();
    (folder, path, bytes)
}

#[test]
fn rows_come_back_as_they_were_written() {
    let (_folder, path, _) = three_rows();
    let found = found(&path).unwrap();
    assert_eq!(found.rows, [response(1), response(2), response(3)]);
    assert!(found.torn.is_none());
}

/// A crash can end the file at any byte.
#[test]
fn a_file_cut_anywhere_keeps_its_whole_rows_and_goes_on() {
    let (_folder, path, bytes) = three_rows();
    for length in 0..bytes.len() {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let before = found(&path).unwrap();
        let kept = before.rows.len() as u32;
        if let Some(torn) = &before.torn {
            assert!(lossy(&bytes[..length]).ends_with(torn), "cut at {length}");
        }
        let mut rows = RowFile::open(&path, &before).unwrap();
        for trial in kept + 1..=3 {
            rows.append(&response(trial)).unwrap();
        }
        assert_eq!(std::fs::read(&path).unwrap(), bytes, "cut at {length}");
    }
}

#[test]
fn a_damaged_earlier_row_is_an_error_with_its_line_and_changes_nothing() {
    let (_folder, path, bytes) = three_rows();
    let text = String::from_utf8(bytes).unwrap();
    for (from, to) in [
        ("demo,01,1,here,1,2,", "demo,01,1,here,1,two,"),
        ("demo,01,1,here,1,2,", "\"demo,01,1,here,1,2,"),
        ("demo,01,1,here,1,2,", "\0\0\0\0,"),
    ] {
        let damaged = text.replace(from, to);
        std::fs::write(&path, &damaged).unwrap();
        let error = found(&path).unwrap_err().to_string();
        assert!(error.contains("rows.csv: line 4: "), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), damaged);
    }
}

#[test]
fn another_header_is_refused() {
    let (_folder, path, bytes) = three_rows();
    let text = String::from_utf8(bytes).unwrap().replace("study,subject", "subject,study");
    std::fs::write(&path, text).unwrap();
    let error = found(&path).unwrap_err().to_string();
    assert!(error.contains("line 1: header: subject,study,session"), "{error}");
}

/// A disk that takes `room` more bytes, then refuses; and perhaps refuses to cut, once.
struct FullDisk {
    bytes: Vec<u8>,
    room: usize,
    cut_fails: bool,
}

impl Storage for FullDisk {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let taken = bytes.len().min(self.room);
        self.bytes.extend(&bytes[..taken]);
        self.room -= taken;
        if taken < bytes.len() {
            return Err(io::Error::new(io::ErrorKind::StorageFull, "no space left on device"));
        }
        Ok(())
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        if std::mem::take(&mut self.cut_fails) {
            return Err(io::Error::other("input/output error"));
        }
        self.bytes.truncate(length as usize);
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_leaves_whole_rows_and_the_row_can_be_written_when_there_is_room() {
    for cut_fails in [false, true] {
        let disk = FullDisk { bytes: vec![], room: 500, cut_fails };
        let mut rows = RowFile::new(Path::new("rows.csv"), disk, 0);
        rows.append(&response(1)).unwrap();
        let whole = rows.storage.bytes.clone();
        let error = rows.append(&response(2)).unwrap_err().to_string();
        assert!(error.contains("rows.csv: no space left"), "{error}");
        rows.storage.room = 1000;
        rows.append(&response(2)).unwrap();
        assert!(rows.storage.bytes.starts_with(&whole));
        assert_eq!(rows.storage.bytes.len(), 2 * whole.len());
    }
}

#[test]
fn an_untimely_frame_that_shows_both_sides_counts_once() {
    let counts = Response {
        late_frames_a: 3,
        dropped_frames_a: 1,
        late_frames_b: 3,
        dropped_frames_b: 1,
        ..response(1)
    };
    let of = |task, late_frames_reference| {
        Response { task, late_frames_reference, ..counts.clone() }.untimely_frames()
    };
    assert_eq!(of(Task::TwoAfc, None), 8);
    assert_eq!(of(Task::Matching, Some(2)), 10);
    assert_eq!(of(Task::SameDifferent, None), 4);
}
