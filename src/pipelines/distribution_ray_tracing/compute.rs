//! The pipeline on a graphics device: one invocation per pixel, a few samples per dispatch.

use super::{Frame, FrameParams, Kept};
use crate::film::Film;
use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::shader;
use crate::mesh::BVH_WGSL;
use crate::mesh::upload::{Geometry, MeshRange};
use crate::pipelines::Pipeline;
use crate::sampling::{RANDOM_WGSL, SAMPLER_WGSL, WARP_WGSL};
use crate::scene::environment::Environment;
use crate::scene::object::Object;
use crate::scene::world::{SceneMesh, World};
use crate::scene::{
    CAMERA_WGSL, ENVIRONMENT_WGSL, LIGHT_WGSL, OBJECT_WGSL, PICTURE_WGSL, SHUTTER_WGSL, WORLD_WGSL,
};
use crate::shading::bsdf::Bsdf;
use crate::shading::{BSDF_WGSL, MATERIAL_WGSL, SURFACE_WGSL};
use bytemuck::{Pod, Zeroable};
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::generate::RenderError;
use shutterlab_stimuli::stimulus::View;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use wgpu::BufferUsages;

/// The parts of the shader that follow the constants of a [`Variant`].
const PARTS: [&str; 15] = [
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
    include_str!("trace.wgsl"),
];

/// With more objects the code for each is not worth a copy.
const MAX_UNROLLED: usize = 4;

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

/// What is constant in a shader: numbers of things that loops over them are unrolled by, and what frames
/// never do, because branches that are never taken cost time on SIMD.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// See [`FrameParams::sampler`].
    pub sampler: u32,
    /// See [`FrameParams::shutter_kind`].
    pub shutter_kind: u32,
    /// Spheres, planes and meshes.
    pub counts: [usize; 3],
    /// The kind of each object's material.
    pub kinds: Vec<u32>,
    /// Lights without extent.
    pub lights: usize,
    /// Whether any plane moves at all.
    pub planes_move: bool,
    /// Whether any plane turns.
    pub planes_turn: bool,
    /// Whether any plane does not lie level, with its sides along x and z.
    pub planes_tilt: bool,
    /// Whether the camera moves.
    pub camera_moves: bool,
    /// Whether any surface is not Lambertian.
    pub coats: bool,
    /// Whether any mesh has a second pose.
    pub meshes_move: bool,
}

impl Variant {
    /// The variant for `frame` in `world`.
    pub fn new(frame: &Frame, world: &World) -> Self {
        let planes = &frame.objects[world.counts[0]..][..world.counts[1]];
        Self {
            sampler: frame.params.sampler,
            shutter_kind: frame.params.shutter_kind,
            counts: world.counts,
            kinds: frame.materials.iter().map(|material| material.kind).collect(),
            lights: world.lights.len(),
            planes_move: planes.iter().any(Object::moves),
            planes_tilt: planes.iter().any(Object::is_turned),
            planes_turn: planes.iter().any(|plane| plane.turns_per_m != 0.0),
            camera_moves: frame.params.camera.moves != 0,
            coats: frame.bsdfs.iter().any(|bsdf| *bsdf != Bsdf::new(None)),
            meshes_move: world.meshes.iter().any(|of| of.mesh.end_positions.is_some()),
        }
    }

    /// The shader.
    pub fn wgsl(&self) -> String {
        let [spheres, planes, meshes] = self.counts;
        let numbers = [
            ("SAMPLER", self.sampler as usize),
            ("SHUTTER_KIND", self.shutter_kind as usize),
            ("SPHERES", spheres),
            ("PLANES", planes),
            ("MESHES", meshes),
            ("OBJECTS", self.kinds.len()),
            ("LIGHTS", self.lights),
        ];
        let truths = [
            ("PLANES_MOVE", self.planes_move),
            ("PLANES_TURN", self.planes_turn),
            ("PLANES_TILT", self.planes_tilt),
            ("CAMERA_MOVES", self.camera_moves),
            ("COATS", self.coats),
            ("MESHES_MOVE", self.meshes_move),
            ("MAY_END", self.coats || meshes > 0),
            ("MANY_OBJECTS", self.kinds.len() > MAX_UNROLLED),
        ];
        let kinds: Vec<String> = self.kinds.iter().map(|kind| format!("{kind}u")).collect();
        let constants = numbers
            .map(|(name, value)| format!("const {name} = {value}u;\n"))
            .into_iter()
            .chain(truths.map(|(name, value)| format!("const {name} = {value};\n")))
            .chain([format!("const KINDS = array<u32, OBJECTS>({});\n", kinds.join(", "))]);
        let most = if self.kinds.len() > MAX_UNROLLED { 0 } else { MAX_UNROLLED };
        constants.collect::<String>() + &shader::unroll(&shader::join(&PARTS), &numbers, most)
    }
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

/// A world on the device.
#[derive(Debug)]
pub struct WorldBuffers([wgpu::Buffer; 3]);

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
        let pipeline = self
            .pipelines
            .entry(Variant::new(frame, world))
            .or_insert_with_key(|variant| shader::compute_pipeline(gpu, variant.wgsl(), "trace"));
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
