//! The pipeline on a graphics device: one invocation per pixel, a few samples per dispatch.

use super::{FrameParams, kept};
use crate::film::Film;
use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::shader;
use crate::pipelines::Pipeline;
use crate::sampling::{RANDOM_WGSL, SAMPLER_WGSL, WARP_WGSL};
use crate::scene::environment::Environment;
use crate::scene::{ENVIRONMENT_WGSL, MOTION_WGSL, SHUTTER_WGSL};
use crate::shading::MATERIAL_WGSL;
use bytemuck::{Pod, Zeroable};
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::View;
use shutterlab_stimuli::{Stimulus, scene};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use wgpu::BufferUsages;

/// The parts of the shader.
pub const WGSL: &[&str] = &[
    RANDOM_WGSL,
    SAMPLER_WGSL,
    WARP_WGSL,
    ENVIRONMENT_WGSL,
    MOTION_WGSL,
    SHUTTER_WGSL,
    MATERIAL_WGSL,
    include_str!("trace.wgsl"),
];

/// Width and height of a workgroup.
const WORKGROUP: u32 = 8;

/// Paths per dispatch: enough that starting one costs little, few enough that a slow adapter stays
/// far from its driver's time-out of about two seconds.
const PATHS_PER_DISPATCH: u32 = 1 << 24;

/// Samples per dispatch at most.
const SAMPLES_PER_DISPATCH: u32 = 64;

/// The pipeline with what it keeps between frames.
#[derive(Debug)]
pub struct OnGpu {
    gpu: Rc<Gpu>,
    assets: PathBuf,
    tracer: Tracer,
    environment: Option<(scene::Environment, EnvironmentBuffers)>,
}

impl OnGpu {
    /// The pipeline on `gpu` with the files in `assets`.
    pub fn new(gpu: Rc<Gpu>, assets: &Path) -> Self {
        Self { tracer: Tracer::default(), gpu, assets: assets.into(), environment: None }
    }
}

impl Pipeline for OnGpu {
    fn films(
        &mut self,
        stimulus: &Stimulus,
        view: &View,
        frame: u32,
        samples: &[u32],
    ) -> Result<Vec<Film>, RenderError> {
        let description = &stimulus.scene.environment;
        let buffers = kept(&mut self.environment, description, || {
            let environment = Environment::load(description, &self.assets)?;
            Ok::<_, RenderError>(EnvironmentBuffers::new(&self.gpu, &environment)?)
        })?;
        let frame = FrameParams::new(stimulus, view, frame);
        Ok(self.tracer.trace(&self.gpu, &frame, buffers, samples)?)
    }
}

/// The compiled pipelines: one for each kind of material, sampler and shutter, because branches that a
/// frame never takes cost time on SIMD. None is compiled before it is needed.
#[derive(Debug, Default)]
pub struct Tracer {
    pipelines: HashMap<[u32; 3], wgpu::ComputePipeline>,
}

/// What `environment.wgsl` reads its tables with.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct EnvironmentParams {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// See [`Environment::exponent_base`].
    pub exponent_base: u32,
    /// There are 2 to the power of this many parts.
    pub part_bits: u32,
    /// See [`Environment::inverse_flux`].
    pub inverse_flux: f32,
    /// See [`Environment::part_scale`].
    pub part_scale: f32,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 2],
}

/// An environment on the device: its parameters and its two tables.
#[derive(Debug)]
pub struct EnvironmentBuffers([wgpu::Buffer; 3]);

impl EnvironmentBuffers {
    /// Uploads `environment`.
    ///
    /// # Errors
    /// The map is larger than the adapter can bind.
    pub fn new(gpu: &Gpu, environment: &Environment) -> Result<Self, GpuError> {
        let params = EnvironmentParams {
            width: environment.width,
            height: environment.height,
            exponent_base: environment.exponent_base,
            part_bits: environment.parts.len().ilog2(),
            inverse_flux: environment.inverse_flux,
            part_scale: environment.part_scale,
            padding: [0; 2],
        };
        let Environment { texels, parts, .. } = environment;
        Ok(Self([
            buffers::holding(gpu, "environment", BufferUsages::UNIFORM, &[params])?,
            buffers::holding(gpu, "environment texels", BufferUsages::STORAGE, texels)?,
            buffers::holding(gpu, "environment parts", BufferUsages::STORAGE, parts)?,
        ]))
    }
}

impl Tracer {
    /// Draws the samples of every pixel from `frame.first_sample` on, and returns the film at each of
    /// the numbers of `samples`, which ascend.
    ///
    /// # Errors
    /// The image is larger than the adapter can bind, or the device fails.
    pub fn trace(
        &mut self,
        gpu: &Gpu,
        frame: &FrameParams,
        EnvironmentBuffers(environment): &EnvironmentBuffers,
        samples: &[u32],
    ) -> Result<Vec<Film>, GpuError> {
        let kinds = [frame.material.kind, frame.sampler, frame.shutter_kind];
        let pipeline = self.pipelines.entry(kinds).or_insert_with(|| {
            let names = ["MATERIAL_KIND", "SAMPLER", "SHUTTER_KIND"];
            let constants: Vec<_> = names.into_iter().zip(kinds.map(f64::from)).collect();
            shader::compute_pipeline(gpu, WGSL, "trace", &constants)
        });
        let size =
            u64::from(frame.width) * u64::from(frame.height) * size_of::<glam::Vec4>() as u64;
        let sums =
            buffers::empty(gpu, "film", BufferUsages::STORAGE | BufferUsages::COPY_SRC, size)?;
        let params = buffers::holding(gpu, "frame", BufferUsages::UNIFORM, &[*frame])?;
        let [environment, texels, parts] = environment;
        let bound = [&params, environment, texels, parts, &sums];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(bound)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("trace"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let most =
            (PATHS_PER_DISPATCH / (frame.width * frame.height)).clamp(1, SAMPLES_PER_DISPATCH);
        let mut drawn = 0;
        let mut films = Vec::new();
        for &count in samples {
            while drawn < count {
                let sample_count = most.min(count - drawn);
                let first_sample = frame.first_sample + drawn;
                let part = FrameParams { first_sample, sample_count, ..*frame };
                gpu.queue.write_buffer(&params, 0, bytemuck::bytes_of(&part));
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                {
                    let mut pass = encoder.begin_compute_pass(&Default::default());
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, &bind_group, &[]);
                    let groups = [frame.width, frame.height].map(|side| side.div_ceil(WORKGROUP));
                    pass.dispatch_workgroups(groups[0], groups[1], 1);
                }
                gpu.queue.submit([encoder.finish()]);
                drawn += sample_count;
            }
            let sums = buffers::read(gpu, &sums)?;
            films.push(Film { width: frame.width, height: frame.height, samples: count, sums });
        }
        Ok(films)
    }
}
