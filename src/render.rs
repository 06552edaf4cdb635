//! Method → pipeline: the renderer that the stimulus generator asks for frames.

use crate::pipelines::{DeviceChoice, OpenDevice, Pipeline};
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::Method;
use shutterlab_stimuli::{Device, LinearImage, Render, Stimulus};
use std::path::{Path, PathBuf};

/// A renderer on an open device.
pub struct Renderer {
    device: OpenDevice,
    /// The folder of the sequences, where the files that stimuli need are kept.
    assets: PathBuf,
    /// The pipeline used last: compiled once, kept while the method stays the same.
    pipeline: Option<(Method, Box<dyn Pipeline>)>,
}

impl Renderer {
    /// Opens the device chosen; files that stimuli need are taken from `assets`, the folder of the
    /// sequences.
    ///
    /// # Errors
    /// As [`OpenDevice::open`].
    pub fn open(choice: DeviceChoice, assets: &Path) -> Result<Self, RenderError> {
        Ok(Self { device: OpenDevice::open(choice)?, assets: assets.into(), pipeline: None })
    }
}

impl Render for Renderer {
    fn device(&self) -> Device {
        self.device.describe()
    }

    fn render(
        &mut self,
        stimulus: &Stimulus,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Vec<LinearImage>>, RenderError> {
        let (method, mut pipeline) = match self.pipeline.take() {
            Some(kept) if kept.0 == stimulus.method => kept,
            _ => (stimulus.method, self.device.pipeline(stimulus.method, &self.assets)),
        };
        let mut images = vec![vec![]; samples.len()];
        for view in stimulus.views(frame) {
            let films = pipeline.films(stimulus, &view, frame, samples)?;
            images.iter_mut().zip(films).for_each(|(views, film)| views.push(film.image()));
        }
        self.pipeline = Some((method, pipeline));
        Ok(images)
    }
}
