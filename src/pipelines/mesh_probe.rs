//! Rays against one mesh on a graphics device, nothing else: what the twins of the hierarchy's search are
//! compared with, and timed.

use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::shader;
use crate::mesh::bvh::Bvh;
use crate::mesh::ray::{Hit, Ray};
use crate::mesh::upload::{Geometry, NONE};
use crate::mesh::{BVH_WGSL, Mesh};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::BufferUsages;

/// The shader for a mesh that moves or rests, and for the nearest hit or any.
pub fn wgsl(moves: bool, any: bool) -> String {
    let constants = format!("const MESHES_MOVE = {moves};\nconst FIND_ANY = {any};\n");
    shader::join(&[&constants, BVH_WGSL, include_str!("mesh_probe.wgsl")])
}

/// Invocations of a workgroup, and the most workgroups in a row.
const WORKGROUP: u32 = 64;
const ROW: u32 = 1 << 15;

/// A [`Ray`] as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeRay {
    origin: Vec3,
    time: f32,
    direction: Vec3,
    first: f32,
    last: f32,
    padding: [u32; 3],
}

/// A [`Hit`] as the shader writes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ProbeHit {
    barycentrics: [f32; 3],
    distance: f32,
    face: u32,
    padding: [u32; 3],
}

/// A mesh and rays on a device.
#[derive(Debug)]
pub struct MeshProbe {
    buffers: [wgpu::Buffer; 4],
    /// The nearest hit, and any.
    pipelines: [wgpu::ComputePipeline; 2],
    rays: u32,
}

impl MeshProbe {
    /// Uploads `mesh`, its hierarchy and `rays`.
    ///
    /// # Errors
    /// They are larger than the adapter can bind.
    pub fn new(gpu: &Gpu, mesh: &Mesh, bvh: &Bvh, rays: &[Ray]) -> Result<Self, GpuError> {
        let mut geometry = Geometry::default();
        let range = geometry.push(mesh, bvh, &vec![0; mesh.triangles.len()]);
        let moves = mesh.end_positions.is_some();
        let probe_rays: Vec<ProbeRay> = rays
            .iter()
            .map(|&Ray { origin, direction, time, between: [first, last] }| ProbeRay {
                origin,
                time,
                direction,
                first,
                last,
                padding: [0; 3],
            })
            .collect();
        let hits_size = (rays.len() * size_of::<ProbeHit>()) as u64;
        let result = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Ok(Self {
            buffers: [
                buffers::holding(gpu, "mesh", BufferUsages::UNIFORM, &[range])?,
                buffers::holding(gpu, "geometry", BufferUsages::STORAGE, &geometry.words)?,
                buffers::holding(gpu, "rays", BufferUsages::STORAGE, &probe_rays)?,
                buffers::empty(gpu, "hits", result, hits_size)?,
            ],
            pipelines: [false, true]
                .map(|any| shader::compute_pipeline(gpu, wgsl(moves, any), "probe")),
            rays: rays.len() as u32,
        })
    }

    /// What each ray meets first.
    ///
    /// # Errors
    /// The device fails.
    pub fn nearest(&self, gpu: &Gpu) -> Result<Vec<Option<Hit>>, GpuError> {
        let hits = self.search(gpu, 0)?;
        let hit = |&ProbeHit { barycentrics, distance, face, .. }: &ProbeHit| Hit {
            triangle: face,
            distance,
            barycentrics,
        };
        Ok(hits.iter().map(|found| (found.face != NONE).then(|| hit(found))).collect())
    }

    /// Whether each ray meets anything.
    ///
    /// # Errors
    /// The device fails.
    pub fn any(&self, gpu: &Gpu) -> Result<Vec<bool>, GpuError> {
        Ok(self.search(gpu, 1)?.iter().map(|hit| hit.face != NONE).collect())
    }

    fn search(&self, gpu: &Gpu, kind: usize) -> Result<Vec<ProbeHit>, GpuError> {
        let pipeline = &self.pipelines[kind];
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(&self.buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("probe"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            let groups = self.rays.div_ceil(WORKGROUP);
            pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
        }
        gpu.queue.submit([encoder.finish()]);
        buffers::read(gpu, &self.buffers[3])
    }
}

#[cfg(test)]
mod tests;
