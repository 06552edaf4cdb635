//! What samples see, shaded on a graphics device once all of them are known to see it [BurnsHunt2013].

use super::on_gpu::Shown;
use super::resources::{FrameBuffers, OWN_BINDINGS};
use super::variant::Variant;
use crate::gpu::shader;
use std::collections::HashMap;
use wgpu::{BindingResource, TextureFormat, TextureUsages};

/// Samples of each pixel at most that are drawn, shaded and sent off together: enough that the rest costs little, few
/// enough that a slow adapter stays far from its driver's time-out.
pub const BATCH: u32 = 16;

/// Most bytes of what they see: of large images fewer are drawn together.
const MOST_BYTES: u64 = 1 << 27;

/// Two words.
pub const FORMAT: TextureFormat = TextureFormat::Rg32Uint;

/// One more than the object, and its face, that each sample of a batch sees of each pixel: a layer of a texture for each
/// sample.
#[derive(Debug)]
pub struct Visibility {
    /// All layers.
    pub view: wgpu::TextureView,
    /// How many there are.
    pub layers: u32,
    /// The texture.
    pub texture: wgpu::Texture,
}

impl Visibility {
    /// For what is `shown`, to be written to as `usage` says.
    pub fn new(shown: &Shown<'_>, usage: TextureUsages) -> Self {
        let (width, height) = (shown.frame.params.width, shown.frame.params.height);
        let bytes = u64::from(width) * u64::from(height) * 8;
        let layers = (MOST_BYTES / bytes).clamp(1, u64::from(BATCH)) as u32;
        let texture = shown.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("visibility"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: TextureUsages::TEXTURE_BINDING | usage,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { view, layers, texture }
    }
}

/// The shader for `variant` where `samples`, in WGSL, says which samples there are.
pub fn wgsl(variant: &Variant, samples: &str) -> String {
    variant.wgsl(&[include_str!("visibility.wgsl"), samples])
}

/// The compiled shaders of a method.
#[derive(Debug, Default)]
pub struct Shaders {
    pipelines: HashMap<Variant, wgpu::ComputePipeline>,
}

/// A shader with all that it reads.
#[derive(Debug)]
pub struct Shading {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
}

impl Shaders {
    /// Shading of the samples of `samples`, which reads `own` behind what all bind.
    pub fn shading<'a>(
        &mut self,
        shown: &Shown<'a>,
        buffers: &'a FrameBuffers,
        visibility: &'a Visibility,
        samples: &str,
        own: impl IntoIterator<Item = BindingResource<'a>>,
    ) -> Shading {
        let &Shown { gpu, frame, world, .. } = shown;
        let compile =
            |variant: &Variant| shader::compute_pipeline(gpu, wgsl(variant, samples), "shade");
        let variant = Variant::new(frame, world);
        let pipeline = self.pipelines.entry(variant).or_insert_with_key(compile).clone();
        // Nothing draws light from the environment.
        let of_frame = buffers.bindings(shown).take(OWN_BINDINGS as usize - 1);
        let own = [BindingResource::TextureView(&visibility.view)].into_iter().chain(own);
        let all = of_frame.chain((OWN_BINDINGS..).zip(own));
        let bind_group = shader::bind_group(gpu, &pipeline, all);
        Shading { pipeline, bind_group }
    }
}

impl Shading {
    /// Shades the samples that the frame's parameters name in so many tiles of 8 by 8 pixels to the right and down from the
    /// pixel that they name, and adds them to its film.
    pub fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, tiles: [u32; 2]) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(tiles[0], tiles[1], 1);
    }
}
