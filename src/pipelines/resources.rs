//! Scenes on a graphics device, as the shaders of all pipelines read them.

use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::mesh::upload::{Geometry, MeshRange};
use crate::scene::environment::Environment;
use crate::scene::world::{SceneMesh, World};
use bytemuck::{Pod, Zeroable};
use std::borrow::Cow;
use wgpu::BufferUsages;

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
pub struct EnvironmentBuffers(pub [wgpu::Buffer; 3]);

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

/// A world on the device.
#[derive(Debug)]
pub struct WorldBuffers(pub [wgpu::Buffer; 3]);

impl WorldBuffers {
    /// Uploads `world`.
    ///
    /// # Errors
    /// Its meshes or pictures are larger than the adapter can bind.
    pub fn new(gpu: &Gpu, world: &World) -> Result<Self, GpuError> {
        let mut geometry = Geometry::default();
        // The least of adapters bind four storage buffers, so pictures and meshes share one.
        let texels = world.pictures.texels.chunks(4);
        let words = texels.map(|four| std::array::from_fn(|k| four.get(k).copied().unwrap_or(0)));
        geometry.append(&words.collect::<Vec<_>>());
        let range = |of: &SceneMesh| {
            let mut range = geometry.push(&of.mesh, &of.bvh, &of.face_materials);
            if !of.materials.is_empty() {
                range.materials = geometry.append(bytemuck::cast_slice(&of.materials));
            }
            range
        };
        let ranges: Vec<MeshRange> = world.meshes.iter().map(range).collect();
        Ok(Self([
            buffers::holding(gpu, "lights", BufferUsages::UNIFORM, &or_one(&world.lights))?,
            buffers::holding(gpu, "meshes", BufferUsages::UNIFORM, &or_one(&ranges))?,
            buffers::holding(gpu, "geometry", BufferUsages::STORAGE, &or_one(&geometry.words))?,
        ]))
    }
}

/// `items`, or one that nothing reads: a binding needs something.
fn or_one<T: Pod>(items: &[T]) -> Cow<'_, [T]> {
    if items.is_empty() { vec![T::zeroed()].into() } else { items.into() }
}
