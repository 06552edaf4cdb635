//! A method's CPU twin as a pipeline: what all have in common is where scenes come from.

use super::Pipeline;
use super::frame::{Frame, Kept};
use crate::film::Film;
use crate::scene::environment::Environment;
use crate::scene::world::World;
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::View;
use std::path::{Path, PathBuf};

/// The films of a frame as a view sees it, at each of the numbers of samples, which ascend.
type Films = fn(&Frame, &World, &Environment, &View, &[u32]) -> Vec<Film>;

/// A pipeline on the processor.
#[derive(Debug)]
pub struct OnCpu {
    films: Films,
    assets: PathBuf,
    kept: Kept<Environment, World>,
}

impl OnCpu {
    /// The pipeline that renders by `films`, with the files in `assets`.
    pub fn new(films: Films, assets: &Path) -> Self {
        Self { films, assets: assets.into(), kept: Kept::default() }
    }
}

impl Pipeline for OnCpu {
    fn films(
        &mut self,
        stimulus: &Stimulus,
        view: &View,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Film>, RenderError> {
        let (environment, world) = self.kept.of::<RenderError>(stimulus, &self.assets, Ok, Ok)?;
        let frame = Frame::new(stimulus, world, view, frame);
        Ok((self.films)(&frame, world, environment, view, samples))
    }
}
