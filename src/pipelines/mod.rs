//! One folder per rendering method: host code, shaders, the CPU twin and tests together.
//! Pipelines never import one another. Here is what they have in common: the device they run on, and how
//! frames and scenes come to it.

pub mod accumulation_buffer;
pub mod distribution_ray_tracing;
pub mod frame;
#[cfg(feature = "gpu")]
pub mod mesh_probe;
pub mod on_cpu;
#[cfg(feature = "gpu")]
pub mod on_gpu;
#[cfg(feature = "gpu")]
pub mod resources;
pub mod stochastic_rasterization;
#[cfg(test)]
mod tests;
#[cfg(feature = "gpu")]
pub mod triangles;
#[cfg(feature = "gpu")]
pub mod variant;
#[cfg(feature = "gpu")]
pub mod visibility;

/// WGSL twin of [`frame`].
pub const FRAME_WGSL: &str = include_str!("frame.wgsl");

use crate::film::Film;
#[cfg(feature = "gpu")]
use crate::gpu::device::Gpu;
use on_cpu::OnCpu;
#[cfg(feature = "gpu")]
use on_gpu::OnGpu;
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::{Method, View};
use shutterlab_stimuli::{Device, Stimulus};
use std::path::Path;

/// A rendering method on an open device.
pub trait Pipeline {
    /// Gathers the samples of frame number `frame` of `stimulus` as `view` sees it, and returns the
    /// film at each of the numbers of `samples`, which ascend.
    ///
    /// # Errors
    /// A file of the scene cannot be used, or the device fails or cannot hold the scene or the image.
    fn films(
        &mut self,
        stimulus: &Stimulus,
        view: &View,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Film>, RenderError>;
}

/// Which device to open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceChoice {
    /// A graphics adapter, be it in software; an error if there is none.
    Gpu,
    /// The processor, with the CPU twins.
    Cpu,
    /// A graphics adapter if there is one, else the processor.
    Auto,
}

/// An open device.
#[derive(Clone, Debug)]
pub enum OpenDevice {
    /// The processor.
    Cpu,
    /// A graphics adapter.
    #[cfg(feature = "gpu")]
    Gpu(std::rc::Rc<Gpu>),
}

impl OpenDevice {
    /// Opens the device chosen.
    ///
    /// # Errors
    /// A graphics adapter was asked for and there is none, or this build cannot use one.
    pub fn open(choice: DeviceChoice) -> Result<Self, RenderError> {
        match choice {
            DeviceChoice::Cpu => Ok(Self::Cpu),
            DeviceChoice::Gpu => Self::open_gpu(),
            DeviceChoice::Auto => Ok(Self::open_gpu().unwrap_or(Self::Cpu)),
        }
    }

    #[cfg(feature = "gpu")]
    fn open_gpu() -> Result<Self, RenderError> {
        Ok(Self::Gpu(std::rc::Rc::new(Gpu::open()?)))
    }

    #[cfg(not(feature = "gpu"))]
    fn open_gpu() -> Result<Self, RenderError> {
        Err("device: gpu: this build has no graphics (feature `gpu`); choose cpu".into())
    }

    /// Whether it is a graphics adapter that is made of the processor.
    pub fn is_software(&self) -> bool {
        match self {
            Self::Cpu => false,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.info.device_type == wgpu::DeviceType::Cpu,
        }
    }

    /// What it is, for manifests and reports.
    pub fn describe(&self) -> Device {
        match self {
            Self::Cpu => Device {
                kind: "cpu".into(),
                adapter: std::env::consts::ARCH.into(),
                driver: std::env::consts::OS.into(),
            },
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => {
                Device { kind: "gpu".into(), adapter: gpu.info.name.clone(), driver: gpu.driver() }
            }
        }
    }

    /// The pipeline of `method` on this device; files that stimuli need are taken from `assets`, the
    /// folder of the sequences.
    pub fn pipeline(&self, method: Method, assets: &Path) -> Box<dyn Pipeline> {
        match (method, self) {
            (Method::DistributionRayTracing, Self::Cpu) => {
                Box::new(OnCpu::new(distribution_ray_tracing::reference::films, assets))
            }
            (Method::AccumulationBuffer, Self::Cpu) => {
                Box::new(OnCpu::new(accumulation_buffer::reference::films, assets))
            }
            #[cfg(feature = "gpu")]
            (Method::AccumulationBuffer, Self::Gpu(gpu)) => {
                Box::new(OnGpu::<accumulation_buffer::render::Drawer>::new(gpu.clone(), assets))
            }
            (Method::StochasticRasterization, Self::Cpu) => {
                Box::new(OnCpu::new(stochastic_rasterization::reference::films, assets))
            }
            #[cfg(feature = "gpu")]
            (Method::StochasticRasterization, Self::Gpu(gpu)) => {
                type Rasterizer = stochastic_rasterization::compute::Rasterizer;
                Box::new(OnGpu::<Rasterizer>::new(gpu.clone(), assets))
            }
            #[cfg(feature = "gpu")]
            (Method::DistributionRayTracing, Self::Gpu(gpu)) => Box::new(OnGpu::<
                distribution_ray_tracing::compute::Tracer,
            >::new(
                gpu.clone(), assets
            )),
        }
    }
}
