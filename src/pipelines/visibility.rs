//! What samples see, shaded on a graphics device once all of them are known to see it [BurnsHunt2013].

use super::on_gpu::Shown;
use super::resources::FrameBuffers;
use super::variant::Variant;
use crate::gpu::shader;
use std::collections::HashMap;
use wgpu::BindingResource;

/// The number of the first binding of a method's own.
pub const OWN_BINDINGS: u32 = 11;

/// The shader for `variant` where `samples`, in WGSL, says which samples there are and what each sees.
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
    groups: [u32; 2],
}

impl Shaders {
    /// Shading of the samples of `samples`, which reads `own` from [`OWN_BINDINGS`] on.
    pub fn shading<'a>(
        &mut self,
        shown: &Shown<'a>,
        buffers: &'a FrameBuffers,
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
        let all = of_frame.chain((OWN_BINDINGS..).zip(own));
        let bind_group = shader::bind_group(gpu, &pipeline, all);
        let groups = [frame.params.width, frame.params.height].map(|side| side.div_ceil(8));
        Shading { pipeline, bind_group, groups }
    }
}

impl Shading {
    /// Shades the samples that the frame's parameters name and adds them to its film.
    pub fn dispatch(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(self.groups[0], self.groups[1], 1);
    }
}
