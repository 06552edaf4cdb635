//! What the unit tests share: tiny sequences made by a fake renderer, a protocol over them, and a
//! response.

use shutterlab_data_schema::Protocol;
use shutterlab_data_schema::protocol::ObviousPair;
use shutterlab_stimuli::generate::{Progress, RenderError, Request, generate};
use shutterlab_stimuli::{Device, Grid, LinearImage, Render, Selection, Sequence, Stimulus};
use std::ops::Range;
use tempfile::TempDir;

struct FakeRenderer;

impl Render for FakeRenderer {
    fn device(&self, _: &Stimulus) -> Device {
        Device { kind: "cpu".into(), adapter: "fake".into(), driver: String::new() }
    }

    fn render(
        &mut self,
        stimulus: &Stimulus,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Vec<LinearImage>>, RenderError> {
        let (width, height) = (stimulus.image.width_px, stimulus.image.height_px);
        let image = |samples: u32| {
            let light = samples as f32 / 1024.0 + stimulus.shutter_open_fraction as f32 / 4.0;
            let pixels = vec![[light, light, frame as f32 / 8.0]; (width * height) as usize];
            LinearImage { width, height, pixels }
        };
        Ok(samples.iter().map(|&samples| vec![image(samples)]).collect())
    }
}

struct Silent;

impl Progress for Silent {
    fn frame(&mut self, _: &Stimulus, _: bool) {}
    fn sequence(&mut self, _: &Sequence, _: usize) {}
    fn stop(&self) -> bool {
        false
    }
}

/// The nine stimuli of the grid `demo`, 8×6 pixels and 3 frames at 30 fps.
pub fn rendered() -> TempDir {
    rendered_with(None)
}

/// As [`rendered`], with only some of the frames.
pub fn rendered_with(frames: Option<Range<u32>>) -> TempDir {
    render(frames, |_| {})
}

/// As [`rendered`], of a grid that was changed.
pub fn rendered_as(change: impl FnOnce(&mut Grid)) -> TempDir {
    render(None, change)
}

fn render(frames: Option<Range<u32>>, change: impl FnOnce(&mut Grid)) -> TempDir {
    let mut grid = Grid::load("demo").unwrap();
    (grid.image.width_px, grid.image.height_px, grid.image.frames) = (8, 6, 3);
    change(&mut grid);
    let stimuli = grid.stimuli(&Selection::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let request = Request {
        grid: "demo",
        stimuli: &stimuli,
        frames: frames.as_ref(),
        exr: false,
        out: folder.path(),
    };
    generate(&request, &mut FakeRenderer, &mut Silent).unwrap();
    folder
}

/// The protocol `demo`, with one practice pair and no fixation mark.
pub fn protocol() -> Protocol {
    let mut protocol = crate::protocols::load("demo").unwrap();
    protocol.timeline.fixation_s = 0.0;
    protocol.practice =
        vec![ObviousPair { better: "M2-S2-T3-A5".into(), worse: "M2-S2-T5-A3".into() }];
    protocol
}

/// The protocol with three stimuli, so three trials after one of practice, and a break after two.
pub fn small_protocol() -> Protocol {
    let mut protocol = protocol();
    protocol.stimuli["samples"] = vec!["A3".into()];
    protocol.design.trials_between_breaks = Some(2);
    protocol
}
