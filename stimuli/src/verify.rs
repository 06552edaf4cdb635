//! Whether a sequence is what its manifest says: its files' hashes, and one frame rendered anew.

use crate::assets::{self, Asset, Kind};
use crate::frames::EncodedImage;
use crate::generate::{Render, RenderError};
use crate::manifest::{Frame, Sequence, SequenceError};
use std::path::Path;

/// How a frame that was rendered anew compares with the one in its folder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Agreement {
    /// The same bytes.
    SameBytes,
    /// Another version, adapter or driver rendered it, and it is the same image: at most 0.1 % of the
    /// pixels differ by more than one code value, and the relative RMSE is at most 10⁻³.
    SameImage {
        /// Part of the pixels in which a channel differs by more than one code value.
        differing: f64,
        /// Root of the relative mean squared error in linear light.
        relative_rmse: f64,
    },
}

/// A sequence is not what its manifest says.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// A file is missing, damaged, or not the one of the manifest.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The frame could not be rendered anew.
    #[error("{file}: cannot be rendered anew: {source}")]
    Render {
        /// The frame's file.
        file: String,
        /// What the renderer said.
        source: RenderError,
    },
    /// The frame was rendered by what renders now, and is not the same bytes.
    #[error(
        "{file}: rendered anew by the same version, adapter and driver it is not the same bytes"
    )]
    OtherBytes {
        /// The frame's file.
        file: String,
    },
    /// The frame is another image.
    #[error("{file}: rendered anew it is another image: {:.3} % of the pixels differ by more than 1/255 (0.1 % is allowed), relative RMSE {relative_rmse:.1e} (1.0e-3 is allowed)", 100.0 * differing)]
    OtherImage {
        /// The frame's file.
        file: String,
        /// See [`Agreement::SameImage`].
        differing: f64,
        /// See [`Agreement::SameImage`].
        relative_rmse: f64,
    },
}

/// Holds every file of `sequence` against its hash, and renders anew the frame at place `place` (modulo
/// their number) among those that hold theirs.
///
/// # Errors
/// All that is wrong; see [`VerifyError`].
pub fn verify(
    sequence: &Sequence,
    place: usize,
    renderer: &mut dyn Render,
) -> Result<(u32, Agreement), Vec<VerifyError>> {
    let (mut sound, mut faults) = (vec![], vec![]);
    for frame in &sequence.manifest.frames {
        match sequence.read_frame(frame) {
            Ok(_) => sound.push(frame),
            Err(fault) => faults.push(fault.into()),
        }
    }
    faults.extend(sequence.faults_beside().into_iter().map(VerifyError::from));
    faults.extend(asset_faults(sequence).into_iter().map(VerifyError::from));
    if sequence.manifest.frames.is_empty() {
        let file = sequence.folder.join(crate::manifest::FILE_NAME);
        let what = "frames: none: one is needed".into();
        faults.push(SequenceError::Invalid { file, what }.into());
    }
    if sound.is_empty() {
        return Err(faults);
    }
    let frame = sound[place % sound.len()];
    match render_anew(sequence, frame, renderer) {
        Ok(agreement) if faults.is_empty() => return Ok((frame.index, agreement)),
        Ok(_) => {}
        Err(fault) => faults.push(fault),
    }
    Err(faults)
}

/// The files that the sequence was made with, where they are not what its manifest says.
fn asset_faults(sequence: &Sequence) -> Vec<SequenceError> {
    // The folder `.` has one above it, too.
    let folder = std::path::absolute(&sequence.folder).unwrap_or(sequence.folder.clone());
    let out = folder.parent().unwrap_or(Path::new(""));
    let fault = |(name, sha256, kind): (&str, &str, Kind)| {
        let file = assets::path(out, Path::new(name), sha256);
        match Asset::open(&file, kind) {
            Ok(found) if found.sha256 == sha256 => None,
            Ok(found) => {
                let what = format!("it hashes to {}: the manifest says {sha256}", found.sha256);
                Some(SequenceError::Invalid { file, what })
            }
            Err(error) => Some(error.into()),
        }
    };
    sequence.manifest.stimulus.files().into_iter().filter_map(fault).collect()
}

fn render_anew(
    sequence: &Sequence,
    frame: &Frame,
    renderer: &mut dyn Render,
) -> Result<Agreement, VerifyError> {
    let there = sequence.read_frame(frame)?;
    let manifest = &sequence.manifest;
    let file = sequence.frame_path(frame.index).display().to_string();
    let stimulus = &manifest.stimulus;
    let views = match renderer.render(stimulus, frame.index, &[stimulus.samples]) {
        Ok(mut images) => images.remove(0),
        Err(source) => return Err(VerifyError::Render { file, source }),
    };
    let anew = stimulus.encode(&views);
    if anew == there {
        return Ok(Agreement::SameBytes);
    }
    let by_the_same = manifest.program_version == env!("CARGO_PKG_VERSION")
        && manifest.device == renderer.device(stimulus);
    if by_the_same {
        return Err(VerifyError::OtherBytes { file });
    }
    let (differing, relative_rmse) =
        compare(&anew, &there, |code| stimulus.image.transfer.decode(f32::from(code) / 255.0));
    if differing > 1e-3 || relative_rmse > 1e-3 {
        return Err(VerifyError::OtherImage { file, differing, relative_rmse });
    }
    Ok(Agreement::SameImage { differing, relative_rmse })
}

/// The part of the pixels in which a channel differs by more than one code value, and the relative RMSE
/// of what the codes stand for, with ε 1 % of the mean.
fn compare(a: &EncodedImage, b: &EncodedImage, light: impl Fn(u8) -> f32) -> (f64, f64) {
    let pixels = a.bytes.chunks(3).zip(b.bytes.chunks(3));
    let differs = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
    let differing =
        pixels.filter(|&pair| differs(pair)).count() as f64 * 3.0 / a.bytes.len() as f64;
    let table: Vec<f64> = (0..=255).map(|code| f64::from(light(code))).collect();
    let count = a.bytes.len() as f64;
    let mean = b.bytes.iter().map(|&code| table[usize::from(code)]).sum::<f64>() / count;
    let error = |(&a, &b): (&u8, &u8)| {
        let (x, y) = (table[usize::from(a)], table[usize::from(b)]);
        (x - y).powi(2) / (y * y + (0.01 * mean).powi(2)).max(1e-12)
    };
    let squares: f64 = a.bytes.iter().zip(&b.bytes).map(error).sum();
    (differing, (squares / count).sqrt())
}
