//! Method → pipeline: the renderer that the stimulus generator asks for frames.

use crate::pipelines::{DeviceChoice, OpenDevice, Pipeline};
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::Method;
use shutterlab_stimuli::{Device, LinearImage, Render, Stimulus};

/// A renderer on an open device.
pub struct Renderer {
    device: OpenDevice,
    /// The pipeline used last: compiled once, kept while the method stays the same.
    pipeline: Option<(Method, Box<dyn Pipeline>)>,
}

impl Renderer {
    /// Opens the device chosen.
    ///
    /// # Errors
    /// As [`OpenDevice::open`].
    pub fn open(choice: DeviceChoice) -> Result<Self, RenderError> {
        Ok(Self { device: OpenDevice::open(choice)?, pipeline: None })
    }
}

impl Render for Renderer {
    fn device(&self) -> Device {
        self.device.describe()
    }

    fn render(&mut self, stimulus: &Stimulus, frame: u32) -> Result<LinearImage, RenderError> {
        let (method, mut pipeline) = match self.pipeline.take() {
            Some(kept) if kept.0 == stimulus.method => kept,
            _ => (stimulus.method, self.device.pipeline(stimulus.method)),
        };
        let film = pipeline.film(stimulus, frame)?;
        self.pipeline = Some((method, pipeline));
        Ok(film.image())
    }
}
