//! Drawing which triangle is seen in each pixel, image by image into the layers of a texture.

use super::Image;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::{buffers, shader};
use crate::mesh::BVH_WGSL;
use crate::pipelines::on_gpu::Shown;
use crate::pipelines::triangles::Triangles;
use crate::pipelines::visibility::{self, Visibility};
use crate::raster::shapes::{corners, object_to_image};
use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4, UVec2, Vec2, Vec3, Vec4};
use shutterlab_stimuli::stimulus::View;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Nearer than this to the camera's plane nothing is drawn, in metres: as the CPU twin has it.
const NEAR: f32 = 1e-6;

const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// A [`Place`] begins at a multiple of this many bytes.
const ALIGNMENT: usize = 256;

/// The source of the shader.
pub fn wgsl() -> String {
    shader::join(&["const MESHES_MOVE = true;", BVH_WGSL, include_str!("draw.wgsl")])
}

/// A frame whose images can be drawn.
pub struct Drawing<'a> {
    shown: &'a Shown<'a>,
    view: &'a View,
    triangles: Triangles<'a>,
    /// The corners of the box around each object.
    boxes: Vec<[Vec3; 8]>,
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
    places: wgpu::Buffer,
    layers: Vec<wgpu::TextureView>,
    depth: wgpu::TextureView,
    /// What is seen, in each image of a batch.
    pub visibility: Visibility,
}

/// An object at an instant, as `draw.wgsl` declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Place {
    /// From the object's own space to clip space.
    pub to_clip: Mat4,
    /// The object.
    pub object: u32,
    /// See [`MeshRange`](crate::mesh::upload::MeshRange).
    pub faces: u32,
    /// The same.
    pub vertices: u32,
    /// The same.
    pub end_vertices: u32,
    /// Between its two poses.
    pub time: f32,
    /// Fills up to a multiple of 16 bytes.
    pub padding: [u32; 3],
}

impl<'a> Drawing<'a> {
    /// The frame as `view` sees it.
    ///
    /// # Errors
    /// The adapter cannot bind all triangles together.
    pub fn new(
        shown: &'a Shown<'a>,
        view: &'a View,
        pipeline: &mut Option<wgpu::RenderPipeline>,
    ) -> Result<Self, GpuError> {
        let Shown { gpu, frame, .. } = *shown;
        let triangles = Triangles::new(shown)?;
        let visibility = Visibility::new(shown, TextureUsages::RENDER_ATTACHMENT);
        let size = (ALIGNMENT * frame.objects.len()) as u64 * u64::from(visibility.layers);
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let places = buffers::empty(gpu, "places", usage, size)?;
        let place = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &places,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<Place>() as u64),
        });
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let resources = (0..).zip([place, triangles.geometry.as_entire_binding()]);
        let pipeline = pipeline.get_or_insert_with(|| drawing_pipeline(gpu)).clone();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("draw"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &resources.map(entry).collect::<Vec<_>>(),
        });
        let layer = |base_array_layer| {
            visibility.texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let depth = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: wgpu::Extent3d { depth_or_array_layers: 1, ..visibility.texture.size() },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Ok(Self {
            shown,
            view,
            boxes: triangles.shapes.iter().map(|shape| corners(shape)).collect(),
            triangles,
            pipeline,
            bind_group,
            places,
            layers: (0..visibility.layers).map(layer).collect(),
            depth: depth.create_view(&Default::default()),
            visibility,
        })
    }

    /// The pixels from a first to a last, of which it has none, in which one of `images` may show something else than a
    /// black environment.
    pub fn region(&self, images: &[Image]) -> [UVec2; 2] {
        let size = Vec2::new(self.width() as f32, self.shown.frame.params.height as f32);
        let all = [UVec2::ZERO, size.as_uvec2()];
        if !self.shown.environment.is_black {
            return all;
        }
        let [mut min, mut max] = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        for image in images {
            for (object, corners) in self.shown.frame.objects.iter().zip(&self.boxes) {
                let pose = object.at(image.shutter);
                let to_image =
                    object_to_image(self.view, self.width(), object, &pose, image.shutter);
                let to_image = image.shift(&self.shown.frame.params) * to_image;
                let corners = corners.map(|corner| to_image.transform_point3(corner));
                if corners.iter().all(|at| at.z < NEAR) {
                    continue;
                }
                if corners.iter().any(|at| at.z < 1e-3) {
                    return all;
                }
                for at in corners {
                    min = min.min(at.truncate() / at.z);
                    max = max.max(at.truncate() / at.z);
                }
            }
        }
        // A pixel more for where in it the image is seen, and one for rounding.
        let within = |place: Vec2| (place + 0.5 * size).clamp(Vec2::ZERO, size).as_uvec2();
        [within(min - 2.0), within(max + 3.0)]
    }

    /// Draws each of `images` into a layer of its own.
    pub fn draw(&self, encoder: &mut wgpu::CommandEncoder, images: &[Image]) {
        let mut places = vec![];
        for (image, layer) in images.iter().zip(&self.layers) {
            let mut pass = self.pass(encoder, layer);
            pass.set_pipeline(&self.pipeline);
            for (object, shape) in self.triangles.shapes.iter().enumerate() {
                pass.set_bind_group(0, &self.bind_group, &[places.len() as u32]);
                pass.draw(0..3 * shape.triangles.len() as u32, 0..1);
                places.extend(bytemuck::bytes_of(&self.place(object, image)));
                places.resize(places.len().next_multiple_of(ALIGNMENT), 0);
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

    /// Where an object is in an image.
    fn place(&self, object: usize, image: &Image) -> Place {
        let of = &self.shown.frame.objects[object];
        let pose = of.at(image.shutter);
        let to_image = object_to_image(self.view, self.width(), of, &pose, image.shutter);
        let range = &self.triangles.ranges[object];
        Place {
            to_clip: self.to_clip(&(image.shift(&self.shown.frame.params) * to_image)),
            object: object as u32,
            faces: range.faces,
            vertices: range.vertices,
            end_vertices: range.end_vertices,
            time: pose.time,
            padding: [0; 3],
        }
    }

    fn width(&self) -> u32 {
        self.shown.frame.params.width
    }

    /// From where `to_image` comes from to clip space. Depth is reversed: 0 infinitely far away, so that single precision
    /// tells far things apart as well as near ones.
    fn to_clip(&self, to_image: &Affine3A) -> Mat4 {
        let params = &self.shown.frame.params;
        let [x, y] = [2.0 / params.width as f32, -2.0 / params.height as f32];
        Mat4::from_cols(Vec4::X * x, Vec4::Y * y, Vec4::W, Vec4::Z * NEAR) * Mat4::from(*to_image)
    }
}

fn drawing_pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("draw"),
        source: wgpu::ShaderSource::Wgsl(wgsl().into()),
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
        entries: &[buffer(0, uniform, true), buffer(1, storage, false)],
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
            targets: &[Some(visibility::FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
