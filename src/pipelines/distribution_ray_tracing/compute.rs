//! The pipeline on a graphics device: one invocation per pixel, a few samples per dispatch.

use crate::film::Film;
use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::shader;
use crate::mesh::BVH_WGSL;
use crate::pipelines::frame::{Frame, FrameParams, Kept};
use crate::pipelines::resources::{EnvironmentBuffers, WorldBuffers};
use crate::pipelines::variant::Variant;
use crate::pipelines::{FRAME_WGSL, Pipeline};
use crate::sampling::{RANDOM_WGSL, SAMPLER_WGSL, WARP_WGSL};
use crate::scene::world::World;
use crate::scene::{
    CAMERA_WGSL, ENVIRONMENT_WGSL, LIGHT_WGSL, OBJECT_WGSL, PICTURE_WGSL, SHUTTER_WGSL, WORLD_WGSL,
};
use crate::shading::{BSDF_WGSL, DIRECT_WGSL, MATERIAL_WGSL, SURFACE_WGSL};
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::View;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use wgpu::BufferUsages;

/// The parts of the shader that follow the constants of a [`Variant`].
pub const PARTS: [&str; 17] = [
    RANDOM_WGSL,
    SAMPLER_WGSL,
    WARP_WGSL,
    BVH_WGSL,
    ENVIRONMENT_WGSL,
    SHUTTER_WGSL,
    CAMERA_WGSL,
    LIGHT_WGSL,
    PICTURE_WGSL,
    OBJECT_WGSL,
    WORLD_WGSL,
    MATERIAL_WGSL,
    BSDF_WGSL,
    SURFACE_WGSL,
    DIRECT_WGSL,
    FRAME_WGSL,
    include_str!("trace.wgsl"),
];

/// Width and height of a workgroup.
const WORKGROUP: u32 = 8;

/// Paths per dispatch: enough that starting one costs little, few enough that a slow adapter stays
/// far from its driver's time-out of about two seconds. With meshes an eighth of it.
const PATHS_PER_DISPATCH: u32 = 1 << 24;

/// Samples per dispatch at most.
const SAMPLES_PER_DISPATCH: u32 = 64;

/// The pipeline with what it keeps between frames.
#[derive(Debug)]
pub struct OnGpu {
    gpu: Rc<Gpu>,
    assets: PathBuf,
    tracer: Tracer,
    kept: Kept<EnvironmentBuffers, (World, WorldBuffers)>,
}

impl OnGpu {
    /// The pipeline on `gpu` with the files in `assets`.
    pub fn new(gpu: Rc<Gpu>, assets: &Path) -> Self {
        Self { tracer: Tracer::default(), gpu, assets: assets.into(), kept: Kept::default() }
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
        let gpu = &self.gpu;
        let (environment, (world, buffers)) = self.kept.of::<RenderError>(
            stimulus,
            &self.assets,
            |environment| Ok(EnvironmentBuffers::new(gpu, &environment)?),
            |world| {
                let buffers = WorldBuffers::new(gpu, &world)?;
                Ok((world, buffers))
            },
        )?;
        let frame = Frame::new(stimulus, world, view, frame);
        Ok(self.tracer.trace(gpu, &frame, world, buffers, environment, samples)?)
    }
}

/// The compiled pipelines. None is compiled before it is needed.
#[derive(Debug, Default)]
pub struct Tracer {
    pipelines: HashMap<Variant, wgpu::ComputePipeline>,
}

impl Tracer {
    /// Draws the samples of every pixel from `frame.params.first_sample` on, and returns the film at each
    /// of the numbers of `samples`, which ascend.
    ///
    /// # Errors
    /// The image is larger than the adapter can bind, or the device fails.
    pub fn trace(
        &mut self,
        gpu: &Gpu,
        frame: &Frame,
        world: &World,
        WorldBuffers(of_world): &WorldBuffers,
        EnvironmentBuffers(of_environment): &EnvironmentBuffers,
        samples: &[u32],
    ) -> Result<Vec<Film>, GpuError> {
        let pipeline =
            self.pipelines.entry(Variant::new(frame, world)).or_insert_with_key(|variant| {
                shader::compute_pipeline(gpu, variant.wgsl(&PARTS), "trace")
            });
        let FrameParams { width, height, first_sample, .. } = frame.params;
        let size = u64::from(width) * u64::from(height) * size_of::<glam::Vec4>() as u64;
        let sums =
            buffers::empty(gpu, "film", BufferUsages::STORAGE | BufferUsages::COPY_SRC, size)?;
        let params = buffers::holding(gpu, "frame", BufferUsages::UNIFORM, &[frame.params])?;
        let objects = buffers::holding(gpu, "objects", BufferUsages::UNIFORM, &frame.objects)?;
        let materials =
            buffers::holding(gpu, "materials", BufferUsages::UNIFORM, &frame.materials)?;
        let bsdfs = buffers::holding(gpu, "bsdfs", BufferUsages::UNIFORM, &frame.bsdfs)?;
        let of_frame = [&params, &objects, &materials, &bsdfs];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(of_frame.into_iter().chain(of_world).chain(of_environment).chain([&sums]))
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
        let paths =
            if world.meshes.is_empty() { PATHS_PER_DISPATCH } else { PATHS_PER_DISPATCH / 8 };
        let most = (paths / (width * height)).clamp(1, SAMPLES_PER_DISPATCH);
        let mut drawn = 0;
        let mut films = Vec::new();
        for &count in samples {
            while drawn < count {
                let sample_count = most.min(count - drawn);
                let first_sample = first_sample + drawn;
                let part = FrameParams { first_sample, sample_count, ..frame.params };
                gpu.queue.write_buffer(&params, 0, bytemuck::bytes_of(&part));
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                {
                    let mut pass = encoder.begin_compute_pass(&Default::default());
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, &bind_group, &[]);
                    let groups = [width, height].map(|side| side.div_ceil(WORKGROUP));
                    pass.dispatch_workgroups(groups[0], groups[1], 1);
                }
                gpu.queue.submit([encoder.finish()]);
                drawn += sample_count;
            }
            let sums = buffers::read(gpu, &sums)?;
            films.push(Film { width, height, samples: count, sums });
        }
        Ok(films)
    }
}
