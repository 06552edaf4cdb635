//! The manifest of a sequence folder, `sequence.json`: what was rendered, by what, and a hash of
//! every frame. A folder without one is no finished sequence.

use crate::frames::{EncodedImage, FrameError, hex};
use crate::stimulus::Stimulus;
use crate::{assets, video};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use shutterlab_data_schema::files::write_atomically;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the manifest inside a sequence folder.
pub const FILE_NAME: &str = "sequence.json";

/// What a sequence folder holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name of the grid that the stimulus is a cell of.
    pub grid: String,
    /// Everything that the pixels depend on.
    pub stimulus: Stimulus,
    /// The frames, in order.
    pub frames: Vec<Frame>,
    /// Hash over definition and pixels: see [`Manifest::hash`].
    pub sha256: String,
    /// Version of the program that rendered the frames.
    pub program_version: String,
    /// What rendered the frames.
    pub device: Device,
    /// Wall time spent on rendering the frames. With the video's hash, which depends on ffmpeg, the only
    /// entry that may differ between two runs.
    pub render_seconds: f64,
    /// SHA-256 of the video's file, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub video_sha256: Option<String>,
}

/// One frame of a sequence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// Its number: it shows the scene at `index / fps` seconds.
    pub index: u32,
    /// SHA-256 of its pixels' bytes (8-bit RGB, row by row from the top left).
    pub sha256: String,
    /// SHA-256 of the file of its linear image, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exr_sha256: Option<String>,
}

/// What rendered a sequence.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Device {
    /// `gpu` or `cpu`.
    pub kind: String,
    /// Name of the adapter or processor.
    pub adapter: String,
    /// The driver and its version; empty for the CPU.
    pub driver: String,
}

/// A finished sequence: a folder and its manifest.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// The folder.
    pub folder: PathBuf,
    /// What it holds.
    pub manifest: Manifest,
}

/// A sequence cannot be used. The message names the file.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError {
    /// A folder or file could not be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A frame could not be read.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The manifest is no manifest, or does not fit its frames.
    #[error("{}: {what}", file.display())]
    Invalid {
        /// The file.
        file: PathBuf,
        /// What is wrong and what was expected.
        what: String,
    },
}

impl Manifest {
    /// SHA-256 over the stimulus (as compact JSON), a newline, and the frames' hashes, each followed
    /// by a newline. Two sequences with the same hash show the same pixels for the same reason.
    pub fn hash(stimulus: &Stimulus, frames: &[Frame]) -> String {
        let mut hasher = Sha256::new();
        hasher.update(json(stimulus));
        for frame in frames {
            hasher.update(b"\n");
            hasher.update(frame.sha256.as_bytes());
        }
        hex(&hasher.finalize())
    }

    /// Writes the manifest into `folder`, which makes the sequence a finished one.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(io::Error::other)?;
        write_atomically(&folder.join(FILE_NAME), format!("{text}\n").as_bytes())
    }
}

impl Sequence {
    /// Opens the finished sequence in `folder`.
    ///
    /// # Errors
    /// There is no manifest, or it is truncated, damaged or does not agree with itself.
    pub fn open(folder: &Path) -> Result<Self, SequenceError> {
        let file = folder.join(FILE_NAME);
        let invalid = |what: String| SequenceError::Invalid { file: file.clone(), what };
        let text =
            std::fs::read_to_string(&file).map_err(|e| invalid(format!("cannot be read: {e}")))?;
        let manifest: Manifest = serde_json::from_str(&text)
            .map_err(|e| invalid(format!("not a whole manifest: {e}")))?;
        if manifest.schema != 1 {
            return Err(invalid(format!(
                "schema: {}: this version reads schema 1",
                manifest.schema
            )));
        }
        // Who wrote it may have been another program: what follows relies on its values.
        if let Err(error) = manifest.stimulus.check_resolved(&file.display().to_string()) {
            return Err(invalid(format!("stimulus: {error}")));
        }
        let expected = Manifest::hash(&manifest.stimulus, &manifest.frames);
        if manifest.sha256 != expected {
            return Err(invalid(format!(
                "sha256: {}: its definition and frames give {expected}",
                manifest.sha256
            )));
        }
        Ok(Self { folder: folder.into(), manifest })
    }

    /// The finished sequences in the folders directly below `folder`, in the order of their names.
    ///
    /// # Errors
    /// The folder cannot be read, or a manifest in it is damaged.
    pub fn open_all(folder: &Path) -> Result<Vec<Self>, SequenceError> {
        let mut folders = Vec::new();
        let unreadable = |e: io::Error| shutterlab_data_schema::files::named(folder, &e);
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if path.join(FILE_NAME).exists() {
                folders.push(path);
            }
        }
        folders.sort();
        folders.iter().map(|folder| Self::open(folder)).collect()
    }

    /// The file of frame number `index`.
    pub fn frame_path(&self, index: u32) -> PathBuf {
        frame_path(&self.folder, index)
    }

    /// Reads a frame and holds it against its size and hash in the manifest.
    ///
    /// # Errors
    /// The file is missing, truncated or damaged, or its pixels are not those of the manifest.
    pub fn read_frame(&self, frame: &Frame) -> Result<EncodedImage, SequenceError> {
        let file = self.frame_path(frame.index);
        let image = EncodedImage::read_png(&file)?;
        let [width, height] = self.manifest.stimulus.frame_size_px();
        if [image.width, image.height] != [width, height] {
            let what = format!(
                "{}×{} pixels: the manifest says {width}×{height}",
                image.width, image.height
            );
            return Err(SequenceError::Invalid { file, what });
        }
        let hash = image.sha256();
        if hash != frame.sha256 {
            let what = format!("its pixels hash to {hash}: the manifest says {}", frame.sha256);
            return Err(SequenceError::Invalid { file, what });
        }
        Ok(image)
    }

    /// What is wrong with the files beside the frames, linear images and the video, whose hashes the
    /// manifest tells.
    pub fn faults_beside(&self) -> Vec<SequenceError> {
        let Manifest { frames, video_sha256, .. } = &self.manifest;
        let linear = frames.iter().filter_map(|frame| {
            Some((exr_path(&self.folder, frame.index), frame.exr_sha256.as_ref()?))
        });
        let video = video_sha256.iter().map(|hash| (self.folder.join(video::FILE_NAME), hash));
        let fault = |(file, hash): (PathBuf, &String)| match assets::sha256(&file) {
            Ok(found) if found == *hash => None,
            Ok(found) => {
                let what = format!("its bytes hash to {found}: the manifest says {hash}");
                Some(SequenceError::Invalid { file, what })
            }
            Err(error) => Some(error.into()),
        };
        linear.chain(video).filter_map(fault).collect()
    }
}

/// The linear image of frame number `index` in a sequence folder.
pub(crate) fn exr_path(folder: &Path, index: u32) -> PathBuf {
    folder.join(format!("frame-{index:04}.exr"))
}

/// The file of frame number `index` in a sequence folder.
pub(crate) fn frame_path(folder: &Path, index: u32) -> PathBuf {
    folder.join(format!("frame-{index:04}.png"))
}

/// Compact JSON of a definition. Definitions hold only text, finite numbers and maps with text
/// keys, which always have a JSON form.
pub(crate) fn json<T: Serialize>(definition: &T) -> String {
    serde_json::to_string(definition)
        .unwrap_or_else(|error| unreachable!("a definition has a JSON form: {error}"))
}
