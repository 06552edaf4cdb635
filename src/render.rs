//! Method → pipeline: the renderer that the stimulus generator asks for frames.

use crate::pipelines::{DeviceChoice, OpenDevice, Pipeline};
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::Method;
use shutterlab_stimuli::{Device, LinearImage, Render, Stimulus};
use std::path::{Path, PathBuf};

/// A renderer on an open device.
pub struct Renderer {
    device: OpenDevice,
    /// What renders meshes: the processor, where an adapter in software was not asked for by name. Its own
    /// code searches them two to four times as fast as the adapter's does.
    for_meshes: OpenDevice,
    /// The folder of the sequences, where the files that stimuli need are kept.
    assets: PathBuf,
    /// The pipeline used last.
    kept: Option<Kept>,
}

/// A pipeline, compiled once and kept while it suits the stimuli.
struct Kept {
    method: Method,
    is_for_meshes: bool,
    pipeline: Box<dyn Pipeline>,
}

impl Renderer {
    /// Opens the device chosen; files that stimuli need are taken from `assets`, the folder of the
    /// sequences.
    ///
    /// # Errors
    /// As [`OpenDevice::open`].
    pub fn open(choice: DeviceChoice, assets: &Path) -> Result<Self, RenderError> {
        let device = OpenDevice::open(choice)?;
        let for_meshes = match choice {
            DeviceChoice::Auto if device.is_software() => OpenDevice::Cpu,
            _ => device.clone(),
        };
        Ok(Self { device, for_meshes, assets: assets.into(), kept: None })
    }

    fn device_of(&self, stimulus: &Stimulus) -> &OpenDevice {
        if stimulus.scene.has_mesh() { &self.for_meshes } else { &self.device }
    }
}

impl Render for Renderer {
    fn device(&self, stimulus: &Stimulus) -> Device {
        self.device_of(stimulus).describe()
    }

    fn render(
        &mut self,
        stimulus: &Stimulus,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Vec<LinearImage>>, RenderError> {
        let (method, is_for_meshes) = (stimulus.method, stimulus.scene.has_mesh());
        let suits = |kept: &Kept| kept.method == method && kept.is_for_meshes == is_for_meshes;
        let kept = self.kept.take().filter(suits);
        let kept = kept.unwrap_or_else(|| Kept {
            method,
            is_for_meshes,
            pipeline: self.device_of(stimulus).pipeline(method, &self.assets),
        });
        let Kept { pipeline, .. } = self.kept.insert(kept);
        let mut images = vec![vec![]; samples.len()];
        for view in stimulus.views(frame) {
            let films = pipeline.films(stimulus, &view, frame, samples)?;
            images.iter_mut().zip(films).for_each(|(views, film)| views.push(film.image()));
        }
        Ok(images)
    }
}
