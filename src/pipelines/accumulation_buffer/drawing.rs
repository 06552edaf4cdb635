//! Drawing which triangle is seen in each pixel, image by image into the layers of a texture.

use super::Image;
use super::render::BATCH;
use crate::gpu::buffers;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::shader;
use crate::mesh::bvh::Bvh;
use crate::mesh::upload::Geometry;
use crate::mesh::{BVH_WGSL, Mesh};
use crate::pipelines::on_gpu::Shown;
use crate::pipelines::resources::WorldBuffers;
use crate::raster::shapes::{object_to_image, shapes};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4, Vec4};
use shutterlab_stimuli::stimulus::View;
use std::borrow::Cow;
use std::collections::HashMap;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Nearer than this to the camera's plane nothing is drawn, in metres: as the CPU twin has it.
const NEAR: f32 = 1e-6;

const VISIBILITY: TextureFormat = TextureFormat::Rg32Uint;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// A [`Place`] begins at a multiple of this many bytes.
const ALIGNMENT: usize = 256;

/// The source of the shader that draws `drawn` meshes, some of which `move`.
pub fn wgsl(drawn: usize, moves: bool) -> String {
    let constants = format!("const DRAWN = {drawn}u;\nconst MESHES_MOVE = {moves};\n");
    constants + &shader::join(&[BVH_WGSL, include_str!("draw.wgsl")])
}

/// The compiled shaders, by the number of meshes and whether they move.
#[derive(Debug, Default)]
pub struct DrawingShaders {
    pipelines: HashMap<(usize, bool), wgpu::RenderPipeline>,
}

/// A frame whose images can be drawn.
pub struct Drawing<'a> {
    shown: &'a Shown<'a>,
    view: &'a View,
    /// Meshes that share a buffer, in the order of the objects.
    groups: Vec<Group>,
    places: wgpu::Buffer,
    layers: Vec<wgpu::TextureView>,
    depth: wgpu::TextureView,
    /// One more than the object and its face that is seen in each pixel, layer by layer of a batch.
    pub visibility: wgpu::TextureView,
}

/// Meshes that share a buffer.
struct Group {
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
    /// How many corners each has.
    corners: Vec<u32>,
}

/// An object at an instant, as `draw.wgsl` declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Place {
    to_clip: Mat4,
    object: u32,
    mesh: u32,
    time: f32,
    padding: u32,
}

impl<'a> Drawing<'a> {
    /// The frame as `view` sees it: spheres and planes with meshes of their own, meshes as they were uploaded.
    ///
    /// # Errors
    /// The adapter cannot bind the meshes.
    pub fn new(
        shown: &'a Shown<'a>,
        view: &'a View,
        shaders: &mut DrawingShaders,
    ) -> Result<Self, GpuError> {
        let Shown { gpu, frame, world, .. } = *shown;
        let size = (ALIGNMENT * frame.objects.len()) as u64 * u64::from(BATCH);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let places = buffers::empty(gpu, "places", usage, size)?;
        let [spheres, planes, _] = world.counts;
        let shapes = shapes(world, &frame.objects);
        let (own, meshes) = shapes.split_at(spheres + planes);
        let mut groups = vec![];
        if !own.is_empty() {
            let mut geometry = Geometry::default();
            // They are drawn, never searched.
            let push = |shape: &Cow<'_, Mesh>| {
                geometry.push(shape, &Bvh::default(), &vec![0; shape.triangles.len()])
            };
            let ranges: Vec<_> = own.iter().map(push).collect();
            let ranges = buffers::holding(gpu, "shape ranges", BufferUsages::UNIFORM, &ranges)?;
            let words = buffers::holding(gpu, "shapes", BufferUsages::STORAGE, &geometry.words)?;
            groups.push(shaders.group(gpu, own, false, [&places, &ranges, &words]));
        }
        if !meshes.is_empty() {
            let moves = meshes.iter().any(|mesh| mesh.end_positions.is_some());
            let WorldBuffers([_, ranges, words]) = shown.world_buffers;
            groups.push(shaders.group(gpu, meshes, moves, [&places, ranges, words]));
        }
        let texture = |format, layers, usage| {
            let (width, height) = (frame.params.width, frame.params.height);
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("visibility"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let visibility = texture(VISIBILITY, BATCH, TextureUsages::TEXTURE_BINDING);
        let layer = |base_array_layer| {
            visibility.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        Ok(Self {
            shown,
            view,
            groups,
            places,
            layers: (0..BATCH).map(layer).collect(),
            depth: texture(DEPTH, 1, TextureUsages::empty()).create_view(&Default::default()),
            visibility: visibility.create_view(&Default::default()),
        })
    }

    /// Draws each of `images` into a layer of its own.
    pub fn draw(&self, encoder: &mut wgpu::CommandEncoder, images: &[Image]) {
        let mut places = vec![];
        for (image, layer) in images.iter().zip(&self.layers) {
            let mut pass = self.pass(encoder, layer);
            let mut object = 0;
            for group in &self.groups {
                pass.set_pipeline(&group.pipeline);
                for (mesh, &corners) in (0..).zip(&group.corners) {
                    pass.set_bind_group(0, &group.bind_group, &[places.len() as u32]);
                    pass.draw(0..corners, 0..1);
                    places.extend(bytemuck::bytes_of(&self.place(object, mesh, image)));
                    places.resize(places.len().next_multiple_of(ALIGNMENT), 0);
                    object += 1;
                }
            }
        }
        self.shown.gpu.queue.write_buffer(&self.places, 0, &places);
    }

    fn pass<'p>(
        &self,
        encoder: &'p mut wgpu::CommandEncoder,
        layer: &wgpu::TextureView,
    ) -> wgpu::RenderPass<'p> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("draw"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: layer,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Where an object, which is a mesh of its group, is in an image.
    fn place(&self, object: u32, mesh: u32, image: &Image) -> Place {
        let of = &self.shown.frame.objects[object as usize];
        let pose = of.at(image.shutter);
        let width = self.shown.frame.params.width;
        let to_image = object_to_image(self.view, width, of, &pose, image.shutter);
        let to_clip = self.to_clip(&to_image, image.in_pixel);
        Place { to_clip, object, mesh, time: pose.time, padding: 0 }
    }

    /// From where `to_image` comes from to clip space, where the point `in_pixel` of a pixel is at its centre. Depth is
    /// reversed: 0 infinitely far away, so that single precision tells far things apart as well as near ones.
    fn to_clip(&self, to_image: &Affine3A, in_pixel: [f32; 2]) -> Mat4 {
        let params = &self.shown.frame.params;
        let [x, y] = [2.0 / params.width as f32, -2.0 / params.height as f32];
        let [right, down] = in_pixel.map(|at| 0.5 - at);
        Mat4::from_cols(
            Vec4::X * x,
            Vec4::Y * y,
            Vec4::new(right * x, down * y, 0.0, 1.0),
            Vec4::Z * NEAR,
        ) * Mat4::from(*to_image)
    }
}

impl DrawingShaders {
    /// The group of `meshes`, some of which move if `moves`, with their places, ranges and geometry.
    fn group(
        &mut self,
        gpu: &Gpu,
        meshes: &[Cow<'_, Mesh>],
        moves: bool,
        [places, ranges, geometry]: [&wgpu::Buffer; 3],
    ) -> Group {
        let compile = || pipeline(gpu, &wgsl(meshes.len(), moves));
        let pipeline = self.pipelines.entry((meshes.len(), moves)).or_insert_with(compile).clone();
        let place = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: places,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<Place>() as u64),
        });
        let resources = [place, ranges.as_entire_binding(), geometry.as_entire_binding()];
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("draw"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &(0..).zip(resources).map(entry).collect::<Vec<_>>(),
        });
        let corners = meshes.iter().map(|mesh| 3 * mesh.triangles.len() as u32).collect();
        Group { pipeline, bind_group, corners }
    }
}

/// The pipeline of a shader that draws.
fn pipeline(gpu: &Gpu, source: &str) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("draw"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let buffer = |binding, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    };
    let uniform = wgpu::BufferBindingType::Uniform;
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("draw"),
        entries: &[buffer(0, uniform, true), buffer(1, uniform, false), buffer(2, storage, false)],
    });
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("draw"),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("draw"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("see"),
            compilation_options: Default::default(),
            targets: &[Some(VISIBILITY.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
