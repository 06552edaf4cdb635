//! Compute shaders, put together from an explicit list of WGSL parts.

use super::device::Gpu;

/// The WGSL module made of `parts`, in their order.
pub fn join(parts: &[&str]) -> String {
    parts.join("\n")
}

/// The compute pipeline of the entry point `entry` of the module made of `parts`, with values for the
/// module's `override` constants.
pub fn compute_pipeline(
    gpu: &Gpu,
    parts: &[&str],
    entry: &str,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(join(parts).into()),
    });
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: None,
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}
