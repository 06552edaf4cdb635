//! The pipeline on a graphics device: one invocation per pixel, a few samples per dispatch.

use crate::film::Film;
use crate::gpu::buffers;
use crate::gpu::device::GpuError;
use crate::gpu::shader;
use crate::pipelines::frame::FrameParams;
use crate::pipelines::on_gpu::{Method, Shown};
use crate::pipelines::resources::FrameBuffers;
use crate::pipelines::variant::Variant;
use shutterlab_stimuli::stimulus::View;
use std::collections::HashMap;

/// What the shader has of its own.
pub const TRACE_WGSL: &str = include_str!("trace.wgsl");

/// Width and height of a workgroup.
const WORKGROUP: u32 = 8;

/// Paths per dispatch: enough that starting one costs little, few enough that a slow adapter stays
/// far from its driver's time-out of about two seconds. With meshes an eighth of it.
const PATHS_PER_DISPATCH: u32 = 1 << 24;

/// Samples per dispatch at most.
const SAMPLES_PER_DISPATCH: u32 = 64;

/// The compiled shaders.
#[derive(Debug, Default)]
pub struct Tracer {
    pipelines: HashMap<Variant, wgpu::ComputePipeline>,
}

impl Method for Tracer {
    /// The view is in the frame's camera.
    fn films(
        &mut self,
        shown: &Shown<'_>,
        _: &View,
        samples: &[u32],
    ) -> Result<Vec<Film>, GpuError> {
        self.trace(shown, samples)
    }
}

impl Tracer {
    /// Draws the samples of every pixel from `frame.params.first_sample` on, and returns the film at each
    /// of the numbers of `samples`, which ascend.
    ///
    /// # Errors
    /// The image is larger than the adapter can bind, or the device fails.
    pub fn trace(&mut self, shown: &Shown<'_>, samples: &[u32]) -> Result<Vec<Film>, GpuError> {
        let &Shown { gpu, frame, world, .. } = shown;
        let pipeline =
            self.pipelines.entry(Variant::new(frame, world)).or_insert_with_key(|variant| {
                shader::compute_pipeline(gpu, variant.wgsl(&[TRACE_WGSL]), "trace")
            });
        let FrameParams { width, height, first_sample, .. } = frame.params;
        let buffers = FrameBuffers::new(gpu, frame)?;
        let bind_group = shader::bind_group(gpu, pipeline, buffers.bindings(shown));
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
                gpu.queue.write_buffer(&buffers.params, 0, bytemuck::bytes_of(&part));
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
            let sums = buffers::read(gpu, &buffers.sums)?;
            films.push(Film { width, height, samples: count, sums });
        }
        Ok(films)
    }
}
