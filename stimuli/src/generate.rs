//! Makes sequence folders from stimuli: frame by frame, so that an interrupted run goes on where it
//! stopped and what is finished is never rendered again.

use crate::frames::{EncodedImage, LinearImage};
use crate::manifest::{self, Device, Frame, Manifest, Sequence, SequenceError, frame_path, json};
use crate::stimulus::Stimulus;
use serde::{Deserialize, Serialize};
use shutterlab_data_schema::files::{create_folder, named, write_atomically};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A renderer, as the generator sees it.
pub trait Render {
    /// What renders, for the manifest.
    fn device(&self) -> Device;

    /// Renders frame number `frame` of `stimulus`. The same arguments give the same image, whatever
    /// was rendered before.
    ///
    /// # Errors
    /// The device fails, or cannot render this stimulus.
    fn render(&mut self, stimulus: &Stimulus, frame: u32) -> Result<LinearImage, RenderError>;
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
const ORIGIN_FILE: &str = "unfinished.json";

/// Renders frames `frames` (all, if none are named) of every stimulus into `out/<id>/`.
///
/// A sequence whose manifest already lists all the frames is skipped; frames that an earlier run
/// left, by the same program on the same device, are kept.
///
/// # Errors
/// See [`GenerateError`]. Whatever was written before the error stays and is whole.
pub fn generate(
    grid: &str,
    stimuli: &[Stimulus],
    frames: Option<Range<u32>>,
    out: &Path,
    renderer: &mut dyn Render,
    progress: &mut dyn Progress,
) -> Result<(), GenerateError> {
    for stimulus in stimuli {
        let length = stimulus.image.frames;
        let range = frames.clone().unwrap_or(0..length);
        if range.is_empty() || range.end > length {
            return Err(GenerateError::Frames {
                range,
                stimulus: stimulus.id.clone(),
                frames: length,
            });
        }
    }
    // What cannot be written is better said before hours of rendering than after.
    for stimulus in stimuli {
        same_stimulus(&out.join(&stimulus.id), stimulus)?;
    }
    for stimulus in stimuli {
        let range = frames.clone().unwrap_or(0..stimulus.image.frames);
        let folder = out.join(&stimulus.id);
        create_folder(&folder)?;
        make_sequence(grid, stimulus, range, &folder, renderer, progress)?;
    }
    Ok(())
}

fn make_sequence(
    grid: &str,
    stimulus: &Stimulus,
    range: Range<u32>,
    folder: &Path,
    renderer: &mut dyn Render,
    progress: &mut dyn Progress,
) -> Result<(), GenerateError> {
    let _lock = lock(folder)?;
    let finished = finished_sequence(folder, stimulus)?;
    if let Some(sequence) = &finished
        && range.clone().all(|index| sequence.manifest.frames.iter().any(|f| f.index == index))
    {
        range.for_each(|_| progress.frame(stimulus, false));
        progress.sequence(sequence, 0);
        return Ok(());
    }

    let mut origin = Origin {
        definition: json(stimulus),
        program_version: env!("CARGO_PKG_VERSION").into(),
        device: renderer.device(),
        render_seconds: finished.as_ref().map_or(0.0, |s| s.manifest.render_seconds),
    };
    claim(folder, finished.as_ref(), &mut origin)?;
    let mut rendered = 0;
    let mut frames = finished.map_or(vec![], |sequence| sequence.manifest.frames);
    for index in range {
        if progress.stop() {
            return Err(GenerateError::Stopped);
        }
        // What the manifest lists has been held against it when the sequence was opened.
        if frames.iter().any(|frame| frame.index == index) {
            progress.frame(stimulus, false);
            continue;
        }
        let file = frame_path(folder, index);
        let kept = EncodedImage::read_png(&file).ok();
        let is_new = kept.is_none();
        let image = match kept {
            Some(image) => image,
            None => {
                let begun = Instant::now();
                let image = render_frame(stimulus, index, &file, renderer)?;
                origin.render_seconds += begun.elapsed().as_secs_f64();
                write_atomically(&folder.join(ORIGIN_FILE), json(&origin).as_bytes())?;
                image
            }
        };
        rendered += usize::from(is_new);
        frames.push(Frame { index, sha256: image.sha256() });
        progress.frame(stimulus, is_new);
    }
    frames.sort_by_key(|frame| frame.index);
    let manifest = Manifest {
        schema: 1,
        grid: grid.into(),
        sha256: Manifest::hash(stimulus, &frames),
        stimulus: stimulus.clone(),
        frames,
        program_version: origin.program_version,
        device: origin.device,
        render_seconds: origin.render_seconds,
    };
    manifest.write(folder)?;
    let origin_file = folder.join(ORIGIN_FILE);
    std::fs::remove_file(&origin_file).map_err(|e| named(&origin_file, &e))?;
    progress.sequence(&Sequence { folder: folder.into(), manifest }, rendered);
    Ok(())
}

fn render_frame(
    stimulus: &Stimulus,
    index: u32,
    file: &Path,
    renderer: &mut dyn Render,
) -> Result<EncodedImage, GenerateError> {
    let linear = renderer.render(stimulus, index).map_err(|source| GenerateError::Render {
        stimulus: stimulus.id.clone(),
        frame: index,
        source,
    })?;
    let image = linear.encode(stimulus.image.exposure_stops, stimulus.image.transfer);
    write_atomically(file, &image.to_png()?)?;
    Ok(image)
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
            if name.starts_with("frame-") && name.ends_with(".png") {
                std::fs::remove_file(&path).map_err(|e| named(&path, &e))?;
            }
        }
    }
    write_atomically(&file, json(&*origin).as_bytes())?;
    Ok(())
}

/// Keeps other processes away from `folder` for as long as the file returned is open.
fn lock(folder: &Path) -> Result<std::fs::File, GenerateError> {
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
mod tests {
    use super::*;
    use crate::{Grid, Selection};
    use std::cell::Cell;

    /// A renderer that paints frame numbers, and fails at a chosen frame.
    struct Painter {
        adapter: &'static str,
        fail_at: Option<u32>,
        rendered: u32,
    }

    impl Render for Painter {
        fn device(&self) -> Device {
            Device { kind: "cpu".into(), adapter: self.adapter.into(), driver: String::new() }
        }

        fn render(&mut self, stimulus: &Stimulus, frame: u32) -> Result<LinearImage, RenderError> {
            if self.fail_at == Some(frame) {
                return Err("the device is gone".into());
            }
            self.rendered += 1;
            let (width, height) = (stimulus.image.width_px, stimulus.image.height_px);
            let grey = frame as f32 / stimulus.image.frames as f32;
            Ok(LinearImage { width, height, pixels: vec![[grey; 3]; (width * height) as usize] })
        }
    }

    fn painter(adapter: &'static str) -> Painter {
        Painter { adapter, fail_at: None, rendered: 0 }
    }

    #[derive(Default)]
    struct Quiet {
        stop_after: Option<u32>,
        frames: Cell<u32>,
    }

    impl Progress for Quiet {
        fn frame(&mut self, _: &Stimulus, _: bool) {
            self.frames.set(self.frames.get() + 1);
        }
        fn sequence(&mut self, _: &Sequence, _: usize) {}
        fn stop(&self) -> bool {
            self.stop_after.is_some_and(|after| self.frames.get() >= after)
        }
    }

    fn one_stimulus() -> Vec<Stimulus> {
        let mut grid = Grid::load("demo").unwrap();
        (grid.image.width_px, grid.image.height_px) = (4, 3);
        let selection = Selection::parse(&["shutter=T3,samples=A3"], &grid).unwrap();
        grid.stimuli(&selection).unwrap()
    }

    fn make(out: &Path, painter: &mut Painter, progress: &mut Quiet) -> Result<(), GenerateError> {
        generate("demo", &one_stimulus(), None, out, painter, progress)
    }

    #[test]
    fn a_stopped_run_goes_on_with_the_next_frame() {
        let out = tempfile::tempdir().unwrap();
        let mut first = painter("one");
        let stopped =
            make(out.path(), &mut first, &mut Quiet { stop_after: Some(5), ..Quiet::default() });
        assert!(matches!(stopped, Err(GenerateError::Stopped)));
        assert!(!out.path().join("M2-S2-T3-A3").join(manifest::FILE_NAME).exists());
        let mut second = painter("one");
        make(out.path(), &mut second, &mut Quiet::default()).unwrap();
        assert_eq!((first.rendered, second.rendered), (5, 19));
        let mut third = painter("one");
        make(out.path(), &mut third, &mut Quiet::default()).unwrap();
        assert_eq!(third.rendered, 0);
    }

    #[test]
    fn a_failing_renderer_is_named_and_nothing_is_finished() {
        let out = tempfile::tempdir().unwrap();
        let error = make(
            out.path(),
            &mut Painter { fail_at: Some(3), ..painter("one") },
            &mut Quiet::default(),
        );
        assert_eq!(error.unwrap_err().to_string(), "M2-S2-T3-A3: frame 3: the device is gone");
        assert!(Sequence::open_all(out.path()).unwrap().is_empty());
    }

    /// Frames that another device left are rendered again, not mixed in.
    #[test]
    fn frames_of_two_devices_never_mix() {
        let out = tempfile::tempdir().unwrap();
        let stop = || Quiet { stop_after: Some(5), ..Quiet::default() };
        assert!(make(out.path(), &mut painter("one"), &mut stop()).is_err());
        let mut other = painter("two");
        make(out.path(), &mut other, &mut Quiet::default()).unwrap();
        assert_eq!(other.rendered, 24);
    }

    #[test]
    fn a_changed_pixel_is_noticed() {
        let out = tempfile::tempdir().unwrap();
        make(out.path(), &mut painter("one"), &mut Quiet::default()).unwrap();
        let sequence = Sequence::open_all(out.path()).unwrap().remove(0);
        let frames = sequence.manifest.frames.clone();
        assert!(frames.iter().all(|frame| sequence.read_frame(frame).is_ok()));
        std::fs::copy(sequence.frame_path(1), sequence.frame_path(2)).unwrap();
        let error = sequence.read_frame(&frames[2]).unwrap_err().to_string();
        assert!(error.contains("frame-0002.png: its pixels hash to"), "{error}");
    }
}
