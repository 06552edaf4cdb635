//! Scenes and frames on a graphics device, as the shaders of all pipelines read them.

use super::frame::Frame;
use super::on_gpu::Shown;
use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::mesh::upload::{Geometry, MeshRange};
use crate::scene::environment::Environment;
use crate::scene::world::{SceneMesh, World};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use std::borrow::Cow;
use wgpu::{BindingResource, BufferUsages};

/// The number of the first binding of a shader's own, behind those of [`FrameBuffers::bindings`].
pub const OWN_BINDINGS: u32 = 11;

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

/// An environment on the device.
#[derive(Debug)]
pub struct EnvironmentBuffers {
    /// Whether it is black: nothing has to be drawn where nothing else is seen.
    pub is_black: bool,
    /// Its parameters and its two tables.
    buffers: [wgpu::Buffer; 3],
}

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
        let buffers = [
            buffers::holding(gpu, "environment", BufferUsages::UNIFORM, &[params])?,
            buffers::holding(gpu, "environment texels", BufferUsages::STORAGE, texels)?,
            buffers::holding(gpu, "environment parts", BufferUsages::STORAGE, parts)?,
        ];
        Ok(Self { is_black: environment.uniform() == Some(Vec3::ZERO), buffers })
    }
}

/// A world on the device.
#[derive(Debug)]
pub struct WorldBuffers {
    /// Where in `geometry` the parts of each mesh begin.
    pub ranges: Vec<MeshRange>,
    /// Pictures, then meshes.
    pub geometry: wgpu::Buffer,
    lights: wgpu::Buffer,
    meshes: wgpu::Buffer,
}

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
        let uniform = BufferUsages::UNIFORM;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Ok(Self {
            geometry: buffers::holding(gpu, "geometry", storage, &or_one(&geometry.words))?,
            lights: buffers::holding(gpu, "lights", uniform, &or_one(&world.lights))?,
            meshes: buffers::holding(gpu, "meshes", uniform, &or_one(&ranges))?,
            ranges,
        })
    }
}

/// A frame on the device.
#[derive(Debug)]
pub struct FrameBuffers {
    /// Its [`FrameParams`](super::frame::FrameParams), the samples to draw among them.
    pub params: wgpu::Buffer,
    /// Its film: of each pixel the sums that [`Film`](crate::film::Film) has.
    pub sums: wgpu::Buffer,
    objects: wgpu::Buffer,
    materials: wgpu::Buffer,
    bsdfs: wgpu::Buffer,
}

impl FrameBuffers {
    /// Uploads `frame`, of which no sample has been drawn.
    ///
    /// # Errors
    /// The image is larger than the adapter can bind.
    pub fn new(gpu: &Gpu, frame: &Frame) -> Result<Self, GpuError> {
        let uniform = BufferUsages::UNIFORM;
        let size = u64::from(frame.params.width)
            * u64::from(frame.params.height)
            * size_of::<Vec4>() as u64;
        Ok(Self {
            params: buffers::holding(gpu, "frame", uniform, &[frame.params])?,
            sums: buffers::empty(
                gpu,
                "film",
                BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                size,
            )?,
            objects: buffers::holding(gpu, "objects", uniform, &frame.objects)?,
            materials: buffers::holding(gpu, "materials", uniform, &frame.materials)?,
            bsdfs: buffers::holding(gpu, "bsdfs", uniform, &frame.bsdfs)?,
        })
    }

    /// What shaders of the frame bind first, as `frame.wgsl` has it; then the parts of the environment, which only those
    /// do that draw light from it.
    ///
    /// Mesa 22.3's software adapter notes the uniforms that branches depend on, those of the n-th buffer at 32n words into
    /// a list of 128: the fourth buffer's are taken for something else, and the eighth's lie beyond its memory. So the
    /// fourth is one that no branch depends on, and so must be any from the eighth on.
    pub fn bindings<'a>(
        &'a self,
        shown: &Shown<'a>,
    ) -> impl Iterator<Item = (u32, BindingResource<'a>)> {
        let WorldBuffers { lights, meshes, geometry, .. } = shown.world_buffers;
        let [environment, texels, parts] = &shown.environment.buffers;
        let Self { params, sums, objects, materials, bsdfs } = self;
        let uniforms = [params, objects, materials, environment, bsdfs, lights, meshes];
        let buffers = uniforms.into_iter().chain([geometry, texels, sums, parts]);
        (0..).zip(buffers.map(wgpu::Buffer::as_entire_binding))
    }
}

/// `items`, or one that nothing reads: a binding needs something.
fn or_one<T: Pod>(items: &[T]) -> Cow<'_, [T]> {
    if items.is_empty() { vec![T::zeroed()].into() } else { items.into() }
}
