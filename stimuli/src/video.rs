//! A sequence as one lossless video: FFV1 in Matroska, by ffmpeg, where that is installed.

use crate::manifest::Sequence;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Name of the video in a sequence folder.
const FILE_NAME: &str = "sequence.mkv";

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

/// Writes the video of `sequence` into its folder, unless it is there. Its frames are those of the
/// sequence, bit for bit, in order.
///
/// # Errors
/// A frame is damaged, or ffmpeg fails; its last line is told.
pub fn write(sequence: &Sequence) -> Result<PathBuf, VideoError> {
    let file = sequence.folder.join(FILE_NAME);
    let fail = |what: &dyn ToString| VideoError { file: file.clone(), what: what.to_string() };
    let part = sequence.folder.join(format!(".{FILE_NAME}.part"));
    let is_newer = |than: &str| {
        let modified = |path: PathBuf| path.metadata().and_then(|data| data.modified()).ok();
        modified(file.clone()) >= modified(sequence.folder.join(than))
    };
    if file.exists() && is_newer(crate::manifest::FILE_NAME) {
        return Ok(file);
    }
    let [width, height] = sequence.manifest.stimulus.frame_size_px();
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    ffmpeg.args(["-s", &format!("{width}x{height}")]);
    ffmpeg.args(["-r", &sequence.manifest.stimulus.image.fps.to_string(), "-i", "-"]);
    ffmpeg.args(["-c:v", "ffv1", "-level", "3", "-pix_fmt", "bgr0", "-f", "matroska"]).arg(&part);
    ffmpeg.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = ffmpeg.spawn().map_err(|e| fail(&format!("ffmpeg cannot be run: {e}")))?;
    if let Some(mut pipe) = child.stdin.take() {
        for frame in &sequence.manifest.frames {
            let image = sequence.read_frame(frame).map_err(|e| fail(&e))?;
            // When ffmpeg has stopped reading, its own message says why.
            if pipe.write_all(&image.bytes).is_err() {
                break;
            }
        }
    }
    let output = child.wait_with_output().map_err(|e| fail(&e))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(fail(&format!("ffmpeg: {}", said.lines().last().unwrap_or("failed"))));
    }
    std::fs::rename(&part, &file).map_err(|e| fail(&e))?;
    Ok(file)
}
