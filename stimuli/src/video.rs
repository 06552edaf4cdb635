//! A sequence as one lossless video: FFV1 in Matroska, by ffmpeg, where that is installed.

use crate::assets;
use crate::generate::lock;
use crate::manifest::Sequence;
use shutterlab_data_schema::files::sync_folder;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Name of the video in a sequence folder.
pub(crate) const FILE_NAME: &str = "sequence.mkv";

/// A video could not be made.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}", file.display())]
pub struct VideoError {
    file: PathBuf,
    what: String,
}

/// Whether ffmpeg can be run.
pub fn is_available() -> bool {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.arg("-version").stdout(Stdio::null()).stderr(Stdio::null());
    ffmpeg.status().is_ok_and(|status| status.success())
}

/// Writes the video of the finished sequence in `folder` into it, unless it is there, and its hash into
/// the manifest. Its frames are those of the sequence, bit for bit, in order.
///
/// # Errors
/// Another program is at work in the folder, a frame is damaged, or ffmpeg fails; its last line is told.
pub fn write(folder: &Path) -> Result<PathBuf, VideoError> {
    let file = folder.join(FILE_NAME);
    let fail = |what: &dyn ToString| VideoError { file: file.clone(), what: what.to_string() };
    let _lock = lock(folder).map_err(|e| fail(&e))?;
    let mut sequence = Sequence::open(folder).map_err(|e| fail(&e))?;
    let is_known = |hash| sequence.manifest.video_sha256 == Some(hash);
    if assets::sha256(&file).is_ok_and(is_known) {
        return Ok(file);
    }
    let part = folder.join(format!(".{FILE_NAME}.part"));
    encode(&sequence, &part).map_err(|what| {
        // There is none if ffmpeg did not begin.
        let _ = std::fs::remove_file(&part);
        fail(&what)
    })?;
    let mut finish = || -> io::Result<()> {
        sequence.manifest.video_sha256 = Some(assets::sha256(&part)?);
        File::open(&part)?.sync_all()?;
        std::fs::rename(&part, &file)?;
        sync_folder(folder)?;
        sequence.manifest.write(folder)
    };
    finish().map_err(|e| fail(&e))?;
    Ok(file)
}

/// Lets ffmpeg write the video to `file`.
fn encode(sequence: &Sequence, file: &Path) -> Result<(), String> {
    let [width, height] = sequence.manifest.stimulus.frame_size_px();
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    ffmpeg.args(["-s", &format!("{width}x{height}")]);
    ffmpeg.args(["-r", &sequence.manifest.stimulus.image.fps.to_string(), "-i", "-"]);
    ffmpeg.args(["-c:v", "ffv1", "-level", "3", "-pix_fmt", "bgr0", "-f", "matroska"]).arg(file);
    ffmpeg.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = ffmpeg.spawn().map_err(|e| format!("ffmpeg cannot be run: {e}"))?;
    let mut damaged = Ok(());
    if let Some(mut pipe) = child.stdin.take() {
        for frame in &sequence.manifest.frames {
            match sequence.read_frame(frame) {
                // When ffmpeg has stopped reading, its own message says why.
                Ok(image) if pipe.write_all(&image.bytes).is_err() => break,
                Ok(_) => {}
                Err(error) => {
                    damaged = Err(error.to_string());
                    break;
                }
            }
        }
    }
    let output = child.wait_with_output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("ffmpeg: {}", said.lines().last().unwrap_or("failed")));
    }
    damaged
}
