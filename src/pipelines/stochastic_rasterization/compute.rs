//! The pipeline on a graphics device: triangles are put into tiles, then a workgroup for each tile finds what the samples
//! of its pixels see, a few samples of each pixel at a time; then these are shaded.

use super::bins::Bins;
use super::{TILE, moving_wgsl};
use crate::film::Film;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::{buffers, shader};
use crate::pipelines::frame::FrameParams;
use crate::pipelines::on_gpu::{Method, Shown};
use crate::pipelines::resources::{FrameBuffers, OWN_BINDINGS};
use crate::pipelines::triangles::Triangles;
use crate::pipelines::variant::Variant;
use crate::pipelines::visibility::{BATCH, Shaders, Visibility};
use shutterlab_stimuli::stimulus::View;
use std::collections::HashMap;
use wgpu::{BindingResource, TextureUsages};

/// So many rounds of its loops a shader makes on Mesa's adapter in software, which then leaves them without a word
/// (2¹⁶ less some for what else there is).
const ROUNDS: u32 = 60_000;

/// Samples of a pixel in a slice of time.
const SLICE: u32 = 4;

/// Which samples there are, for [`wgsl`](crate::pipelines::visibility::wgsl).
pub const SAMPLES_WGSL: &str = include_str!("samples.wgsl");

/// The source of the shader that finds what samples see.
pub fn wgsl(variant: &Variant) -> String {
    let constants = format!("const BATCH = {BATCH}u;\nconst SLICE = {SLICE}u;\n");
    variant.wgsl(&[&constants, &moving_wgsl(), include_str!("rasterize.wgsl")])
}

/// The compiled shaders.
#[derive(Debug)]
pub struct Rasterizer {
    most_entries: u64,
    binning: Option<wgpu::ComputePipeline>,
    rasterizing: HashMap<Variant, wgpu::ComputePipeline>,
    shading: Shaders,
}

impl Rasterizer {
    /// With so many entries of triangles in tiles at most at a time, if the adapter can bind them; what is more is drawn in
    /// bands.
    pub fn new(most_entries: u64) -> Self {
        let (binning, rasterizing, shading) = Default::default();
        Self { most_entries, binning, rasterizing, shading }
    }
}

impl Default for Rasterizer {
    fn default() -> Self {
        Self::new(1 << 24)
    }
}

impl Method for Rasterizer {
    fn films(
        &mut self,
        shown: &Shown<'_>,
        view: &View,
        samples: &[u32],
    ) -> Result<Vec<Film>, GpuError> {
        let &Shown { gpu, frame, world, .. } = shown;
        let triangles = Triangles::new(shown)?;
        let bins = Bins::new(shown, view, &triangles, self.most_entries, &mut self.binning)?;
        let of_frame = FrameBuffers::new(gpu, frame)?;
        let visibility = Visibility::new(shown, TextureUsages::STORAGE_BINDING);
        let shading = self.shading.shading(shown, &of_frame, &visibility, SAMPLES_WGSL, []);
        let compile = |variant: &Variant| shader::compute_pipeline(gpu, wgsl(variant), "rasterize");
        let variant = Variant::new(frame, world);
        let pipeline = &*self.rasterizing.entry(variant).or_insert_with_key(compile);
        let own = [&bins.band, &bins.segments, &bins.places, &bins.entries];
        let own = own.map(wgpu::Buffer::as_entire_binding);
        let own = own.into_iter().chain([BindingResource::TextureView(&visibility.view)]);
        let buffers =
            [(0, of_frame.params.as_entire_binding()), (7, triangles.geometry.as_entire_binding())];
        let all = buffers.into_iter().chain((OWN_BINDINGS..).zip(own));
        let bind_group = shader::bind_group(gpu, pipeline, all);

        let FrameParams { width, height, .. } = frame.params;
        let first_row = bins.bands.first().map_or(0, |band| band.start);
        let end_row = bins.bands.last().map_or(0, |band| band.end);
        let columns = bins.columns.len() as u32;
        let first_pixel = [bins.columns.start, first_row].map(|tile| tile * TILE);
        let most = visibility.layers.min(samples_at_once(gpu, bins.most_in_tile())?);
        let mut is_filled = false;
        let mut drawn = 0;
        let mut films = vec![];
        for &count in samples {
            while drawn < count {
                let sample_count = most.min(count - drawn);
                let part =
                    FrameParams { first_sample: drawn, sample_count, first_pixel, ..frame.params };
                gpu.queue.write_buffer(&of_frame.params, 0, bytemuck::bytes_of(&part));
                for band in &bins.bands {
                    let mut encoder = gpu.device.create_command_encoder(&Default::default());
                    // What is all there stays.
                    if !is_filled || bins.bands.len() > 1 {
                        bins.fill(&mut encoder, band);
                        is_filled = true;
                    }
                    let mut pass = encoder.begin_compute_pass(&Default::default());
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, &bind_group, &[]);
                    pass.dispatch_workgroups(columns, band.len() as u32, 1);
                    drop(pass);
                    if band.end == end_row {
                        shading.dispatch(&mut encoder, [columns, end_row - first_row]);
                    }
                    gpu.queue.submit([encoder.finish()]);
                }
                drawn += sample_count;
            }
            let sums = buffers::read(gpu, &of_frame.sums)?;
            films.push(Film { width, height, samples: count, sums });
        }
        Ok(films)
    }
}

/// How many samples of each pixel can be drawn at once where a tile has so many entries: each slice goes through all of
/// them.
///
/// # Errors
/// An adapter in software does not get through a single slice.
fn samples_at_once(gpu: &Gpu, entries: u32) -> Result<u32, GpuError> {
    if gpu.info.device_type != wgpu::DeviceType::Cpu {
        return Ok(u32::MAX);
    }
    match ROUNDS / entries.max(1) {
        0 => Err(GpuError::Failed(format!(
            "stochastic-rasterization: {entries} triangles in a tile: an adapter in software goes through {ROUNDS} at most; \
             choose cpu"
        ))),
        slices => Ok(slices.saturating_mul(SLICE)),
    }
}
