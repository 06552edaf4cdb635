//! How sequences come to be, with a renderer that only paints.

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
    fn device(&self, _: &Stimulus) -> Device {
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
        Ok(samples.iter().map(|&n| vec![image(n); stimulus.views(0).len()]).collect())
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
    let same_device = verify(&sequence, 0, &mut painter("one")).unwrap_err();
    assert!(matches!(same_device[..], [VerifyError::OtherBytes { .. }]), "{same_device:?}");
    let error = verify(&sequence, 0, &mut painter("two")).unwrap_err()[0].to_string();
    assert!(error.contains("frame-0000.png: rendered anew it is another image"), "{error}");

    // All that is wrong is told; the frame rendered anew is one of those that are left.
    std::fs::copy(sequence.frame_path(1), sequence.frame_path(0)).unwrap();
    std::fs::remove_file(sequence.frame_path(2)).unwrap();
    let faults = verify(&sequence, 1, &mut painter("one")).unwrap_err();
    let faults: Vec<String> = faults.iter().map(VerifyError::to_string).collect();
    let expected =
        ["frame-0000.png: its pixels", "frame-0002.png: cannot", "frame-0003.png: rendered"];
    assert_eq!(faults.len(), expected.len(), "{faults:?}");
    assert!(faults.iter().zip(expected).all(|(fault, e)| fault.contains(e)), "{faults:?}");
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
    assert_eq!(before[0].manifest.sha256, after[0].manifest.sha256);
    let image = exr::prelude::read_first_rgba_layer_from_file(
        exr_path(&after[0].folder, 3),
        |size, _| vec![[0.0_f32; 3]; size.width() * size.height()],
        |pixels, place, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[place.y() * 40 + place.x()] = [r, g, b];
        },
    );
    assert_eq!(image.unwrap().layer_data.channel_data.pixels[41], [0.125, 0.25, 0.0]);

    assert!(after[0].faults_beside().is_empty());
    std::fs::remove_file(exr_path(&after[0].folder, 2)).unwrap();
    std::fs::write(exr_path(&after[0].folder, 3), "").unwrap();
    let faults: Vec<String> = after[0].faults_beside().iter().map(|f| f.to_string()).collect();
    assert!(
        faults.len() == 2
            && faults[0].contains("frame-0002.exr: ")
            && faults[1].contains("frame-0003.exr: its bytes hash to e3b0c442"),
        "{faults:?}"
    );
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
