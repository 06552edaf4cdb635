//! Makes sequence folders from stimuli: frame by frame, so that an interrupted run goes on where it
//! stopped and what is finished is never rendered again. Stimuli that differ in nothing but the number
//! of samples are made together: one pass over the samples of a frame yields it at every level.

use crate::assets;
use crate::frames::{EncodedImage, LinearImage, hex};
use crate::manifest::{
    self, Device, Frame, Manifest, Sequence, SequenceError, exr_path, frame_path, json,
};
use crate::stereo::beside;
use crate::stimulus::Stimulus;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A renderer, as the generator sees it.
pub trait Render {
    /// What renders `stimulus`, for the manifest.
    fn device(&self, stimulus: &Stimulus) -> Device;

    /// Renders frame number `frame` of `stimulus`: for each number in `samples`, which ascend, the
    /// images of its [`Stimulus::views`] made of that many samples of the stimulus's own. The same
    /// arguments give the same images, whatever was rendered before and whatever else is in `samples`.
    ///
    /// # Errors
    /// The device fails, or cannot render this stimulus.
    fn render(
        &mut self,
        stimulus: &Stimulus,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Vec<LinearImage>>, RenderError>;
}

/// Why a renderer failed.
pub type RenderError = Box<dyn std::error::Error + Send + Sync>;

/// A sequence could not be made. Frames already written stay for the next run.
#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    /// A file or folder cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A sequence that is already there is damaged.
    #[error("{0}; remove its folder to render it again")]
    Damaged(#[from] SequenceError),
    /// A sequence that is already there is another one.
    #[error("{}: holds another sequence ({what}); choose another folder, or remove this one to render it again", folder.display())]
    Occupied {
        /// The sequence folder.
        folder: PathBuf,
        /// The first field in which it differs, with both values.
        what: String,
    },
    /// The range of frames does not fit the sequence.
    #[error("render: --frames: {}..{}: a range of at least one frame within 0..{frames} of {stimulus} is needed", range.start, range.end)]
    Frames {
        /// The range asked for.
        range: Range<u32>,
        /// Id of the stimulus.
        stimulus: String,
        /// The number of its frames.
        frames: u32,
    },
    /// The renderer failed.
    #[error("{stimulus}: frame {frame}: {source}")]
    Render {
        /// Id of the stimulus.
        stimulus: String,
        /// Number of the frame.
        frame: u32,
        /// What the renderer said.
        source: RenderError,
    },
    /// Another process is making the same sequence.
    #[error("{}: another running program is making this sequence; wait for it, or choose another folder", folder.display())]
    Busy {
        /// The sequence folder.
        folder: PathBuf,
    },
    /// The run was asked to stop.
    #[error("stopped; run the same command again to go on")]
    Stopped,
}

/// What happens while sequences are made.
pub trait Progress {
    /// One more frame of `stimulus` is there; `rendered` says whether this run rendered it.
    fn frame(&mut self, stimulus: &Stimulus, rendered: bool);
    /// The sequence is finished; `rendered` is the number of its frames that this run rendered.
    fn sequence(&mut self, sequence: &Sequence, rendered: usize);
    /// Asked before each frame: whether to stop.
    fn stop(&self) -> bool;
}

/// Who made the frames of a folder that is not yet finished: frames of two devices or two versions
/// never mix in one sequence.
#[derive(Debug, Serialize, Deserialize)]
struct Origin {
    definition: String,
    program_version: String,
    device: Device,
    /// Time spent on the frames so far.
    render_seconds: f64,
}

impl Origin {
    fn is_of(&self, other: &Self) -> bool {
        (&self.definition, &self.program_version, &self.device)
            == (&other.definition, &other.program_version, &other.device)
    }
}

/// File that tells the origin of the frames in a folder that is not yet finished.
pub const ORIGIN_FILE: &str = "unfinished.json";

/// What to make.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Name of the grid.
    pub grid: &'a str,
    /// Its stimuli that are wanted.
    pub stimuli: &'a [Stimulus],
    /// Which of their frames; all, if none are named.
    pub frames: Option<&'a Range<u32>>,
    /// Whether the linear images are wanted too, as OpenEXR.
    pub exr: bool,
    /// The folder for the sequence folders.
    pub out: &'a Path,
}

/// Renders what is requested, each stimulus into its own folder.
///
/// A sequence whose manifest already lists all the frames is skipped; frames that an earlier run
/// left, by the same program on the same device, are kept.
///
/// # Errors
/// See [`GenerateError`]. Whatever was written before the error stays and is whole.
pub fn generate(
    request: &Request<'_>,
    renderer: &mut dyn Render,
    progress: &mut dyn Progress,
) -> Result<(), GenerateError> {
    let &Request { stimuli, out, .. } = request;
    request.check()?;
    // What cannot be written is better said before hours of rendering than after.
    for stimulus in stimuli {
        same_stimulus(&out.join(stimulus.folder_name()), stimulus)?;
    }
    for pass in passes(stimuli) {
        make_sequences(request, &pass, renderer, progress)?;
    }
    Ok(())
}

impl Request<'_> {
    /// Refuses frames that a stimulus does not have.
    ///
    /// # Errors
    /// [`GenerateError::Frames`].
    pub fn check(&self) -> Result<(), GenerateError> {
        for stimulus in self.stimuli {
            let (range, frames) = (self.range(stimulus), stimulus.image.frames);
            if range.is_empty() || range.end > frames {
                let stimulus = stimulus.id.clone();
                return Err(GenerateError::Frames { range, stimulus, frames });
            }
        }
        Ok(())
    }

    /// The frames of `stimulus` that are wanted.
    fn range(&self, stimulus: &Stimulus) -> Range<u32> {
        self.frames.cloned().unwrap_or(0..stimulus.image.frames)
    }

    /// Whether frame number `index` lacks its linear image in `folder`.
    fn lacks_exr(&self, folder: &Path, index: u32) -> bool {
        self.exr && !exr_path(folder, index).exists()
    }

    /// Bytes that the frames may take that are not there yet: seven tenths of their pixels', which is
    /// what the noisiest frames take as PNG, and the linear pixels as they are.
    pub fn bytes_needed(&self) -> u64 {
        let of_stimulus = |stimulus: &Stimulus| {
            let folder = self.out.join(stimulus.folder_name());
            let count = |lacks: &dyn Fn(u32) -> bool| {
                self.range(stimulus).filter(|&index| lacks(index)).count() as u64
            };
            let pixels = |[width, height]: [u32; 2]| 3 * u64::from(width) * u64::from(height);
            let views = [stimulus.image.width_px, stimulus.image.height_px];
            count(&|index| !frame_path(&folder, index).exists())
                * (pixels(stimulus.frame_size_px()) * 7 / 10)
                + count(&|index| self.lacks_exr(&folder, index))
                    * (4 * pixels(views) * stimulus.views(0).len() as u64)
        };
        self.stimuli.iter().map(of_stimulus).sum()
    }
}

/// The stimuli in groups that one pass over the samples yields together, in their order; within a
/// group the number of samples ascends.
pub fn passes(stimuli: &[Stimulus]) -> Vec<Vec<&Stimulus>> {
    let mut passes: IndexMap<_, Vec<&Stimulus>> = IndexMap::new();
    for stimulus in stimuli {
        let Stimulus { levels, noise_stream, exemplar, .. } = stimulus;
        let others: Vec<_> = levels.iter().filter(|(axis, _)| *axis != "samples").collect();
        passes.entry((others, noise_stream, exemplar)).or_default().push(stimulus);
    }
    let sorted = |mut pass: Vec<_>| {
        pass.sort_by_key(|stimulus: &&Stimulus| stimulus.samples);
        pass
    };
    passes.into_values().map(sorted).collect()
}

/// A sequence that is being made.
struct Unfinished<'a> {
    stimulus: &'a Stimulus,
    folder: PathBuf,
    origin: Origin,
    frames: Vec<Frame>,
    /// The manifest that is there already, of fewer frames.
    before: Option<Manifest>,
    /// How many of the frames this run rendered.
    rendered: usize,
    /// Keeps other processes away.
    _lock: std::fs::File,
}

fn make_sequences(
    request: &Request<'_>,
    pass: &[&Stimulus],
    renderer: &mut dyn Render,
    progress: &mut dyn Progress,
) -> Result<(), GenerateError> {
    let mut unfinished = Vec::new();
    for stimulus in pass {
        unfinished.extend(Unfinished::open(request, stimulus, renderer, progress)?);
    }
    for index in request.range(pass[0]) {
        let mut missing = Vec::new();
        for sequence in &mut unfinished {
            if !sequence.keep(request, index, progress) {
                missing.push(sequence);
            }
        }
        if missing.is_empty() {
            continue;
        }
        if progress.stop() {
            return Err(GenerateError::Stopped);
        }
        let samples: Vec<u32> = missing.iter().map(|sequence| sequence.stimulus.samples).collect();
        let begun = Instant::now();
        let last = missing[missing.len() - 1].stimulus;
        let images = renderer.render(last, index, &samples).map_err(|source| {
            GenerateError::Render { stimulus: last.id.clone(), frame: index, source }
        })?;
        // Each sequence bears the time of the samples that it adds.
        let seconds_per_sample = begun.elapsed().as_secs_f64() / f64::from(last.samples);
        let mut fewer = 0;
        for (sequence, views) in missing.into_iter().zip(images) {
            let added = sequence.stimulus.samples - fewer;
            fewer = sequence.stimulus.samples;
            sequence.add(request, index, &views, seconds_per_sample * f64::from(added))?;
            progress.frame(sequence.stimulus, true);
        }
    }
    unfinished.into_iter().try_for_each(|sequence| sequence.finish(request.grid, progress))
}

impl<'a> Unfinished<'a> {
    /// Takes the folder of `stimulus`, unless all that is wanted is finished there.
    fn open(
        request: &Request<'_>,
        stimulus: &'a Stimulus,
        renderer: &dyn Render,
        progress: &mut dyn Progress,
    ) -> Result<Option<Self>, GenerateError> {
        let folder = request.out.join(stimulus.folder_name());
        create_folder(&folder)?;
        let lock = lock(&folder)?;
        let finished = finished_sequence(&folder, stimulus)?;
        if let Some(sequence) = &finished
            && request.range(stimulus).all(|index| {
                sequence.manifest.frames.iter().any(|f| f.index == index)
                    && !request.lacks_exr(&folder, index)
            })
        {
            request.range(stimulus).for_each(|_| progress.frame(stimulus, false));
            // Left by a run that was killed after its last step but one.
            let _ = std::fs::remove_file(folder.join(ORIGIN_FILE));
            progress.sequence(sequence, 0);
            return Ok(None);
        }
        let mut origin = Origin {
            definition: json(stimulus),
            program_version: env!("CARGO_PKG_VERSION").into(),
            device: renderer.device(stimulus),
            render_seconds: finished.as_ref().map_or(0.0, |s| s.manifest.render_seconds),
        };
        claim(&folder, finished.as_ref(), &mut origin)?;
        let before = finished.map(|sequence| sequence.manifest);
        let frames = before.as_ref().map_or(vec![], |manifest| manifest.frames.clone());
        Ok(Some(Self { stimulus, folder, origin, frames, before, rendered: 0, _lock: lock }))
    }

    /// Whether frame number `index` is there already, finished or left by an interrupted run.
    fn keep(&mut self, request: &Request<'_>, index: u32, progress: &mut dyn Progress) -> bool {
        if request.lacks_exr(&self.folder, index) {
            return false;
        }
        // What the manifest lists has been held against it when the sequence was opened.
        if !self.frames.iter().any(|frame| frame.index == index) {
            let Ok(image) = EncodedImage::read_png(&frame_path(&self.folder, index)) else {
                return false;
            };
            if [image.width, image.height] != self.stimulus.frame_size_px() {
                return false;
            }
            let exr_sha256 = assets::sha256(&exr_path(&self.folder, index)).ok();
            self.frames.push(Frame { index, sha256: image.sha256(), exr_sha256 });
        }
        progress.frame(self.stimulus, false);
        true
    }

    /// Writes frame number `index`.
    fn add(
        &mut self,
        request: &Request<'_>,
        index: u32,
        views: &[LinearImage],
        seconds: f64,
    ) -> Result<(), GenerateError> {
        let mut exr_sha256 = None;
        if request.exr {
            let linear = views[1..].iter().fold(views[0].clone(), |all, view| beside(&all, view));
            let bytes = linear.to_exr()?;
            write_atomically(&exr_path(&self.folder, index), &bytes)?;
            exr_sha256 = Some(hex(&Sha256::digest(bytes)));
        }
        let image = self.stimulus.encode(views);
        write_atomically(&frame_path(&self.folder, index), &image.to_png()?)?;
        self.origin.render_seconds += seconds;
        write_atomically(&self.folder.join(ORIGIN_FILE), json(&self.origin).as_bytes())?;
        // A frame may be there already and lack its linear image alone.
        self.frames.retain(|frame| frame.index != index);
        self.frames.push(Frame { index, sha256: image.sha256(), exr_sha256 });
        self.rendered += 1;
        Ok(())
    }

    /// Writes the manifest.
    fn finish(mut self, grid: &str, progress: &mut dyn Progress) -> Result<(), GenerateError> {
        self.frames.sort_by_key(|frame| frame.index);
        let sha256 = Manifest::hash(self.stimulus, &self.frames);
        // A video of other frames is not this sequence's.
        let of_these_frames = self.before.filter(|before| before.sha256 == sha256);
        let manifest = Manifest {
            schema: 1,
            grid: grid.into(),
            sha256,
            stimulus: self.stimulus.clone(),
            frames: self.frames,
            program_version: self.origin.program_version,
            device: self.origin.device,
            render_seconds: self.origin.render_seconds,
            video_sha256: of_these_frames.and_then(|before| before.video_sha256),
        };
        manifest.write(&self.folder)?;
        let origin_file = self.folder.join(ORIGIN_FILE);
        std::fs::remove_file(&origin_file).map_err(|e| named(&origin_file, &e))?;
        progress.sequence(&Sequence { folder: self.folder, manifest }, self.rendered);
        Ok(())
    }
}

/// The finished sequence in `folder`, if there is one; it must be of this very stimulus.
fn same_stimulus(folder: &Path, stimulus: &Stimulus) -> Result<Option<Sequence>, GenerateError> {
    if !folder.join(manifest::FILE_NAME).exists() {
        return Ok(None);
    }
    let sequence = Sequence::open(folder)?;
    if sequence.manifest.stimulus != *stimulus {
        let what = first_difference(&sequence.manifest.stimulus, stimulus);
        return Err(GenerateError::Occupied { folder: folder.into(), what });
    }
    Ok(Some(sequence))
}

/// As [`same_stimulus`], and its frames must be those of its manifest.
fn finished_sequence(
    folder: &Path,
    stimulus: &Stimulus,
) -> Result<Option<Sequence>, GenerateError> {
    let finished = same_stimulus(folder, stimulus)?;
    if let Some(sequence) = &finished {
        for frame in &sequence.manifest.frames {
            sequence.read_frame(frame)?;
        }
    }
    Ok(finished)
}

/// Makes `folder` one whose frames all come from `origin`: removes frames that an interrupted run
/// left for another definition, version or device, and refuses to mix with a finished sequence.
fn claim(
    folder: &Path,
    finished: Option<&Sequence>,
    origin: &mut Origin,
) -> Result<(), GenerateError> {
    if let Some(Sequence { manifest, .. }) = finished
        && (&manifest.program_version, &manifest.device)
            != (&origin.program_version, &origin.device)
    {
        let what = format!(
            "frames of version {} on {}, now it is {} on {}",
            manifest.program_version,
            manifest.device.adapter,
            origin.program_version,
            origin.device.adapter
        );
        return Err(GenerateError::Occupied { folder: folder.into(), what });
    }
    let file = folder.join(ORIGIN_FILE);
    let left: Option<Origin> =
        std::fs::read(&file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if let Some(left) = left.filter(|left| left.is_of(origin)) {
        origin.render_seconds = left.render_seconds;
    } else if finished.is_none() {
        for entry in std::fs::read_dir(folder).map_err(|e| named(folder, &e))? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.starts_with("frame-") {
                std::fs::remove_file(&path).map_err(|e| named(&path, &e))?;
            }
        }
    }
    write_atomically(&file, json(&*origin).as_bytes())?;
    Ok(())
}

/// Keeps other processes away from `folder` for as long as the file returned is open.
pub(crate) fn lock(folder: &Path) -> Result<std::fs::File, GenerateError> {
    let path = folder.join(".lock");
    let file = std::fs::File::create(&path).map_err(|e| named(&path, &e))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(std::fs::TryLockError::WouldBlock) => {
            Err(GenerateError::Busy { folder: folder.into() })
        }
        Err(std::fs::TryLockError::Error(error)) => Err(named(&path, &error).into()),
    }
}

/// The first field in which two stimuli differ, with both values.
fn first_difference(there: &Stimulus, now: &Stimulus) -> String {
    let fields = |stimulus: &Stimulus| serde_json::to_value(stimulus).unwrap_or_default();
    let (there, now) = (fields(there), fields(now));
    let keys = there.as_object().into_iter().flat_map(|map| map.keys());
    keys.filter(|key| there[*key] != now[*key])
        .map(|key| format!("{key}: {}, now {}", there[key], now[key]))
        .next()
        .unwrap_or_default()
}

#[cfg(test)]
mod tests;
