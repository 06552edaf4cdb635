//! The pipeline on a graphics device: one invocation per pixel, a few samples per dispatch.

use super::FrameParams;
use crate::film::Film;
use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::shader;
use crate::pipelines::Pipeline;
use crate::sampling::{RANDOM_WGSL, WARP_WGSL};
use crate::scene::environment::Environment;
use crate::scene::{ENVIRONMENT_WGSL, MOTION_WGSL};
use crate::shading::MATERIAL_WGSL;
use crate::shading::material::MATERIAL_KINDS;
use bytemuck::{Pod, Zeroable};
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::{Stimulus, scene};
use std::rc::Rc;
use wgpu::BufferUsages;

/// The parts of the shader.
pub const WGSL: &[&str] = &[
    RANDOM_WGSL,
    WARP_WGSL,
    ENVIRONMENT_WGSL,
    MOTION_WGSL,
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
    tracer: Tracer,
    environment: Option<(scene::Environment, EnvironmentBuffers)>,
}

impl OnGpu {
    /// The pipeline on `gpu`.
    pub fn new(gpu: Rc<Gpu>) -> Self {
        Self { tracer: Tracer::default(), gpu, environment: None }
    }
}

impl Pipeline for OnGpu {
    fn film(&mut self, stimulus: &Stimulus, frame: u32) -> Result<Film, RenderError> {
        let description = &stimulus.scene.environment;
        let kept = match self.environment.take() {
            Some(kept) if kept.0 == *description => kept,
            _ => {
                let buffers = EnvironmentBuffers::new(&self.gpu, &Environment::new(description))?;
                (description.clone(), buffers)
            }
        };
        let (_, buffers) = self.environment.insert(kept);
        Ok(self.tracer.trace(&self.gpu, &FrameParams::new(stimulus, frame), buffers)?)
    }
}

/// The compiled pipelines: one for each kind of material, because branches that a frame never takes
/// cost time on SIMD. None is compiled before it is needed.
#[derive(Debug, Default)]
pub struct Tracer {
    pipelines: [Option<wgpu::ComputePipeline>; MATERIAL_KINDS],
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
    /// Draws samples `first_sample..first_sample + sample_count` of every pixel.
    ///
    /// # Errors
    /// The image is larger than the adapter can bind, or the device fails.
    pub fn trace(
        &mut self,
        gpu: &Gpu,
        frame: &FrameParams,
        EnvironmentBuffers(environment): &EnvironmentBuffers,
    ) -> Result<Film, GpuError> {
        let kind = frame.material.kind;
        let pipeline = self.pipelines[kind as usize].get_or_insert_with(|| {
            shader::compute_pipeline(gpu, WGSL, "trace", &[("MATERIAL_KIND", f64::from(kind))])
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
        let end = frame.first_sample + frame.sample_count;
        let step =
            (PATHS_PER_DISPATCH / (frame.width * frame.height)).clamp(1, SAMPLES_PER_DISPATCH);
        for first_sample in (frame.first_sample..end).step_by(step as usize) {
            let sample_count = step.min(end - first_sample);
            let part = FrameParams { first_sample, sample_count, ..*frame };
            gpu.queue.write_buffer(&params, 0, bytemuck::bytes_of(&part));
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &bind_group, &[]);
                pass.dispatch_workgroups(
                    frame.width.div_ceil(WORKGROUP),
                    frame.height.div_ceil(WORKGROUP),
                    1,
                );
            }
            gpu.queue.submit([encoder.finish()]);
        }
        let sums = buffers::read(gpu, &sums)?;
        Ok(Film { width: frame.width, height: frame.height, samples: frame.sample_count, sums })
    }
}
