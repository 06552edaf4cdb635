//! The pipeline on a graphics device: a few images are drawn into the layers of a texture, each pixel what is seen in it;
//! then all are shaded and added up at once.

use super::drawing::Drawing;
use super::{Image, images};
use crate::film::Film;
use crate::gpu::buffers;
use crate::gpu::device::GpuError;
use crate::pipelines::frame::FrameParams;
use crate::pipelines::on_gpu::{Method, Shown};
use crate::pipelines::resources::FrameBuffers;
use crate::pipelines::visibility::{BATCH, Shaders};
use bytemuck::Zeroable;
use shutterlab_stimuli::stimulus::View;
use wgpu::BufferUsages;

/// Which images there are, for [`wgsl`](crate::pipelines::visibility::wgsl).
pub fn samples_wgsl() -> String {
    format!("const BATCH = {BATCH}u;\n{}", include_str!("accumulate.wgsl"))
}

/// The compiled shaders.
#[derive(Debug, Default)]
pub struct Drawer {
    drawing: Option<wgpu::RenderPipeline>,
    shading: Shaders,
}

impl Method for Drawer {
    fn films(
        &mut self,
        shown: &Shown<'_>,
        view: &View,
        samples: &[u32],
    ) -> Result<Vec<Film>, GpuError> {
        let drawing = Drawing::new(shown, view, &mut self.drawing)?;
        // Each film has instants of its own.
        samples.iter().map(|&count| self.film(shown, &drawing, count)).collect()
    }
}

impl Drawer {
    /// The film of `count` images.
    fn film(
        &mut self,
        shown: &Shown<'_>,
        drawing: &Drawing<'_>,
        count: u32,
    ) -> Result<Film, GpuError> {
        let &Shown { gpu, frame, .. } = shown;
        let of_frame = FrameBuffers::new(gpu, frame)?;
        let of_images = [Image::zeroed(); BATCH as usize];
        let of_images = buffers::holding(gpu, "images", BufferUsages::UNIFORM, &of_images)?;
        let own = [of_images.as_entire_binding()];
        let visibility = &drawing.visibility;
        let shading = self.shading.shading(shown, &of_frame, visibility, &samples_wgsl(), own);
        for batch in images(&frame.params, count).chunks(visibility.layers as usize) {
            let [first, end] = drawing.region(batch);
            if first.cmpge(end).any() {
                continue;
            }
            let sample_count = batch.len() as u32;
            let params =
                FrameParams { sample_count, first_pixel: first.to_array(), ..frame.params };
            gpu.queue.write_buffer(&of_frame.params, 0, bytemuck::bytes_of(&params));
            gpu.queue.write_buffer(&of_images, 0, bytemuck::cast_slice(batch));
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            drawing.draw(&mut encoder, batch);
            shading.dispatch(&mut encoder, (end - first).to_array().map(|side| side.div_ceil(8)));
            gpu.queue.submit([encoder.finish()]);
        }
        let FrameParams { width, height, .. } = frame.params;
        Ok(Film { width, height, samples: count, sums: buffers::read(gpu, &of_frame.sums)? })
    }
}
