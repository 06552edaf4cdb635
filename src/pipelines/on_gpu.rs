//! A method on a graphics device as a pipeline: what all have in common is where scenes come from.

use super::Pipeline;
use super::frame::{Frame, Kept};
use super::resources::{EnvironmentBuffers, WorldBuffers};
use crate::film::Film;
use crate::gpu::device::{Gpu, GpuError};
use crate::scene::world::World;
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::View;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A frame and what it shows, on a device.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The frame.
    pub frame: &'a Frame,
    /// The world.
    pub world: &'a World,
    /// The world on the device.
    pub world_buffers: &'a WorldBuffers,
    /// The environment on the device.
    pub environment: &'a EnvironmentBuffers,
}

/// A method with the shaders that it keeps. None is compiled before it is needed.
pub trait Method: Default {
    /// The films of a frame as `view` sees it, at each of the numbers of `samples`, which ascend.
    ///
    /// # Errors
    /// The device fails, or cannot hold the image.
    fn films(
        &mut self,
        shown: &Shown<'_>,
        view: &View,
        samples: &[u32],
    ) -> Result<Vec<Film>, GpuError>;
}

/// A pipeline on a graphics device.
#[derive(Debug)]
pub struct OnGpu<M> {
    gpu: Rc<Gpu>,
    assets: PathBuf,
    method: M,
    kept: Kept<EnvironmentBuffers, (World, WorldBuffers)>,
}

impl<M: Method> OnGpu<M> {
    /// The pipeline on `gpu` with the files in `assets`.
    pub fn new(gpu: Rc<Gpu>, assets: &Path) -> Self {
        Self { gpu, assets: assets.into(), method: M::default(), kept: Kept::default() }
    }
}

impl<M: Method> Pipeline for OnGpu<M> {
    fn films(
        &mut self,
        stimulus: &Stimulus,
        view: &View,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Film>, RenderError> {
        let gpu = &*self.gpu;
        let (environment, (world, world_buffers)) = self.kept.of::<RenderError>(
            stimulus,
            &self.assets,
            |environment| Ok(EnvironmentBuffers::new(gpu, &environment)?),
            |world| {
                let buffers = WorldBuffers::new(gpu, &world)?;
                Ok((world, buffers))
            },
        )?;
        let frame = &Frame::new(stimulus, world, view, frame);
        let shown = Shown { gpu, frame, world, world_buffers, environment };
        Ok(self.method.films(&shown, view, samples)?)
    }
}
