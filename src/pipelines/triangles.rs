//! The triangles of all objects of a frame on a graphics device, as [`shapes`] has them.

use super::on_gpu::Shown;
use crate::gpu::buffers;
use crate::gpu::device::GpuError;
use crate::mesh::Mesh;
use crate::mesh::bvh::Bvh;
use crate::mesh::upload::{Geometry, MeshRange};
use crate::raster::shapes::shapes;
use std::borrow::Cow;
use wgpu::BufferUsages;

/// The objects as triangles.
#[derive(Debug)]
pub struct Triangles<'a> {
    /// One per object.
    pub shapes: Vec<Cow<'a, Mesh>>,
    /// Where each of them begins in `geometry`.
    pub ranges: Vec<MeshRange>,
    /// All vertices and faces.
    pub geometry: wgpu::Buffer,
}

impl<'a> Triangles<'a> {
    /// The triangles of what is `shown`: meshes as they were uploaded, behind them spheres and planes with meshes of their
    /// own.
    ///
    /// # Errors
    /// The adapter cannot bind all of them together.
    pub fn new(shown: &Shown<'a>) -> Result<Self, GpuError> {
        let Shown { gpu, frame, world, world_buffers, .. } = *shown;
        let shapes = shapes(world, &frame.objects);
        let [.., meshes] = world.counts;
        let own = &shapes[..shapes.len() - meshes];
        if own.is_empty() {
            let geometry = world_buffers.geometry.clone();
            return Ok(Self { shapes, ranges: world_buffers.ranges.clone(), geometry });
        }
        let uploaded = world_buffers.geometry.size();
        // Where what is pushed begins.
        let mut geometry = Geometry { begin: (uploaded / 16) as u32, words: vec![] };
        // They are drawn, never searched.
        let push = |shape: &Cow<'_, Mesh>| {
            geometry.push(shape, &Bvh::default(), &vec![0; shape.triangles.len()])
        };
        let mut ranges: Vec<_> = own.iter().map(push).collect();
        ranges.extend(&world_buffers.ranges);
        let words: &[u8] = bytemuck::cast_slice(&geometry.words);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let all = buffers::empty(gpu, "triangles", usage, uploaded + words.len() as u64)?;
        gpu.queue.write_buffer(&all, uploaded, words);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&world_buffers.geometry, 0, &all, 0, uploaded);
        gpu.queue.submit([encoder.finish()]);
        Ok(Self { shapes, ranges, geometry: all })
    }
}
