//! Makes sequence folders from stimuli: frame by frame, so that an interrupted run goes on where it
//! stopped and what is finished is never rendered again. Stimuli that differ in nothing but the number
//! of samples are made together: one pass over the samples of a frame yields it at every level.

use crate::frames::{EncodedImage, LinearImage};
use crate::manifest::{self, Device, Frame, Manifest, Sequence, SequenceError, frame_path, json};
use crate::stereo::beside;
use crate::stimulus::Stimulus;
use indexmap::IndexMap;
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
const ORIGIN_FILE: &str = "unfinished.json";

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
    for stimulus in stimuli {
        let (range, length) = (request.range(stimulus), stimulus.image.frames);
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
        same_stimulus(&out.join(stimulus.folder_name()), stimulus)?;
    }
    for pass in passes(stimuli) {
        make_sequences(request, &pass, renderer, progress)?;
    }
    Ok(())
}

impl Request<'_> {
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
                    * (4 * pixels(views) * stimulus.views().len() as u64)
        };
        self.stimuli.iter().map(of_stimulus).sum()
    }
}

/// The linear image of frame number `index` in a sequence folder.
fn exr_path(folder: &Path, index: u32) -> PathBuf {
    folder.join(format!("frame-{index:04}.exr"))
}

/// The stimuli in groups that one pass over the samples yields together, in their order; within a
/// group the number of samples ascends.
pub fn passes(stimuli: &[Stimulus]) -> Vec<Vec<&Stimulus>> {
    let mut passes: IndexMap<_, Vec<&Stimulus>> = IndexMap::new();
    for stimulus in stimuli {
        passes.entry((&stimulus.noise_stream, stimulus.exemplar)).or_default().push(stimulus);
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
            progress.sequence(sequence, 0);
            return Ok(None);
        }
        let mut origin = Origin {
            definition: json(stimulus),
            program_version: env!("CARGO_PKG_VERSION").into(),
            device: renderer.device(),
            render_seconds: finished.as_ref().map_or(0.0, |s| s.manifest.render_seconds),
        };
        claim(&folder, finished.as_ref(), &mut origin)?;
        let frames = finished.map_or(vec![], |sequence| sequence.manifest.frames);
        Ok(Some(Self { stimulus, folder, origin, frames, rendered: 0, _lock: lock }))
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
            self.frames.push(Frame { index, sha256: image.sha256() });
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
        if request.exr {
            let linear = views[1..].iter().fold(views[0].clone(), |all, view| beside(&all, view));
            write_atomically(&exr_path(&self.folder, index), &linear.to_exr()?)?;
        }
        let image = self.stimulus.encode(views);
        write_atomically(&frame_path(&self.folder, index), &image.to_png()?)?;
        self.origin.render_seconds += seconds;
        write_atomically(&self.folder.join(ORIGIN_FILE), json(&self.origin).as_bytes())?;
        // A frame may be there already and lack its linear image alone.
        self.frames.retain(|frame| frame.index != index);
        self.frames.push(Frame { index, sha256: image.sha256() });
        self.rendered += 1;
        Ok(())
    }

    /// Writes the manifest.
    fn finish(mut self, grid: &str, progress: &mut dyn Progress) -> Result<(), GenerateError> {
        self.frames.sort_by_key(|frame| frame.index);
        let manifest = Manifest {
            schema: 1,
            grid: grid.into(),
            sha256: Manifest::hash(self.stimulus, &self.frames),
            stimulus: self.stimulus.clone(),
            frames: self.frames,
            program_version: self.origin.program_version,
            device: self.origin.device,
            render_seconds: self.origin.render_seconds,
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

    /// A renderer that paints frame numbers, and fails at a chosen frame. The one called `two` has a
    /// corner one code value off.
    struct Painter {
        adapter: &'static str,
        fail_at: Option<u32>,
        rendered: u32,
    }

    impl Render for Painter {
        fn device(&self) -> Device {
            Device { kind: "cpu".into(), adapter: self.adapter.into(), driver: String::new() }
        }

        fn render(
            &mut self,
            stimulus: &Stimulus,
            frame: u32,
            samples: &[u32],
        ) -> Result<Vec<Vec<LinearImage>>, RenderError> {
            if self.fail_at == Some(frame) {
                return Err("the device is gone".into());
            }
            self.rendered += 1;
            let (width, height) = (stimulus.image.width_px, stimulus.image.height_px);
            let image = |samples: u32| {
                let red = frame as f32 / stimulus.image.frames as f32;
                let pixel = [red, samples as f32 / 1024.0, 0.0];
                let mut pixels = vec![pixel; (width * height) as usize];
                pixels[0][1] += if self.adapter == "two" { 0.009 } else { 0.0 };
                LinearImage { width, height, pixels }
            };
            Ok(samples.iter().map(|&n| vec![image(n); stimulus.views().len()]).collect())
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
        (grid.image.width_px, grid.image.height_px) = (40, 30);
        let selection = Selection::parse(&["shutter=T3,samples=A3"], &grid).unwrap();
        grid.stimuli(&selection).unwrap()
    }

    fn make(out: &Path, painter: &mut Painter, progress: &mut Quiet) -> Result<(), GenerateError> {
        let stimuli = one_stimulus();
        let request = Request { grid: "demo", stimuli: &stimuli, frames: None, exr: false, out };
        generate(&request, painter, progress)
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

    /// The levels of `samples` come from one pass per frame, and what a level lacks after an
    /// interruption is all that is rendered of it; exemplars and independent levels have passes of
    /// their own.
    #[test]
    fn levels_of_samples_share_their_passes() {
        let mut grid = Grid::load("demo").unwrap();
        (grid.image.width_px, grid.image.height_px, grid.exemplars) = (4, 3, 2);
        let selection = Selection::parse(&["shutter=T3"], &grid).unwrap();
        let stimuli = grid.stimuli(&selection).unwrap();
        let ids = |pass: &Vec<&Stimulus>| {
            pass.iter().map(|stimulus| stimulus.folder_name()).collect::<Vec<_>>().join(" ")
        };
        let nested: Vec<String> = passes(&stimuli).iter().map(ids).collect();
        assert_eq!(
            nested,
            ["M2-S2-T3-A3 M2-S2-T3-A4 M2-S2-T3-A5", "M2-S2-T3-A3-E1 M2-S2-T3-A4-E1 M2-S2-T3-A5-E1"]
        );
        let out = tempfile::tempdir().unwrap();
        let make = |painter: &mut Painter| {
            let (stimuli, out) = (stimuli.as_slice(), out.path());
            let request = Request { grid: "demo", stimuli, frames: None, exr: false, out };
            generate(&request, painter, &mut Quiet::default()).unwrap();
            painter.rendered
        };
        assert_eq!(make(&mut painter("one")), 48);
        let image = |folder: &str| {
            EncodedImage::read_png(&out.path().join(folder).join("frame-0003.png")).unwrap()
        };
        assert_ne!(image("M2-S2-T3-A3"), image("M2-S2-T3-A4"));
        std::fs::remove_dir_all(out.path().join("M2-S2-T3-A4")).unwrap();
        assert_eq!(make(&mut painter("one")), 24);
        assert_eq!(Sequence::open_all(out.path()).unwrap().len(), 6);

        grid.sampling = crate::grid::Sampling::Independent;
        assert_eq!(passes(&grid.stimuli(&selection).unwrap()).len(), 6);
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

    /// The same renderer must give the same bytes, another nearly the same image.
    #[test]
    fn a_frame_rendered_anew_tells_a_false_manifest() {
        use crate::verify::{Agreement, VerifyError, verify};
        let out = tempfile::tempdir().unwrap();
        make(out.path(), &mut painter("one"), &mut Quiet::default()).unwrap();
        let mut sequence = Sequence::open_all(out.path()).unwrap().remove(0);
        let found = verify(&sequence, 29, &mut painter("one")).unwrap();
        assert_eq!(found, (5, Agreement::SameBytes));
        let other_device = verify(&sequence, 0, &mut painter("two")).unwrap();
        assert!(matches!(other_device, (0, Agreement::SameImage { .. })), "{other_device:?}");
        // A manifest that fits its pixels and itself, and claims other samples than were drawn.
        sequence.manifest.stimulus.samples = 512;
        let same_device = verify(&sequence, 0, &mut painter("one"));
        assert!(matches!(same_device, Err(VerifyError::OtherBytes { .. })));
        let error = verify(&sequence, 0, &mut painter("two")).unwrap_err().to_string();
        assert!(error.contains("frame-0000.png: rendered anew it is another image"), "{error}");
    }

    /// Linear images can be asked for when the frames are there already, which stay as they are.
    #[test]
    fn linear_images_hold_what_was_rendered() {
        let out = tempfile::tempdir().unwrap();
        make(out.path(), &mut painter("one"), &mut Quiet::default()).unwrap();
        let before = Sequence::open_all(out.path()).unwrap();
        let (stimuli, frames) = (one_stimulus(), 2..4);
        let (stimuli, out) = (stimuli.as_slice(), out.path());
        let request = Request { grid: "demo", stimuli, frames: Some(&frames), exr: true, out };
        assert_eq!(request.bytes_needed(), 2 * 4 * 3 * 40 * 30);
        let mut painter = painter("one");
        generate(&request, &mut painter, &mut Quiet::default()).unwrap();
        assert_eq!((painter.rendered, request.bytes_needed()), (2, 0));
        let after = Sequence::open_all(out).unwrap();
        assert_eq!(before[0].manifest.frames, after[0].manifest.frames);
        let image = exr::prelude::read_first_rgba_layer_from_file(
            exr_path(&after[0].folder, 3),
            |size, _| vec![[0.0_f32; 3]; size.width() * size.height()],
            |pixels, place, (r, g, b, _): (f32, f32, f32, f32)| {
                pixels[place.y() * 40 + place.x()] = [r, g, b];
            },
        );
        assert_eq!(image.unwrap().layer_data.channel_data.pixels[41], [0.125, 0.25, 0.0]);
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
