//! Buffers: making them and reading them back.

use super::device::{Gpu, GpuError};
use bytemuck::Pod;
use wgpu::BufferUsages;

/// A buffer for `usage` that holds `items` and can be written to again.
///
/// # Errors
/// The device cannot bind that many bytes.
pub fn holding<T: Pod>(
    gpu: &Gpu,
    label: &str,
    usage: BufferUsages,
    items: &[T],
) -> Result<wgpu::Buffer, GpuError> {
    let bytes: &[u8] = bytemuck::cast_slice(items);
    let buffer = empty(gpu, label, usage | BufferUsages::COPY_DST, bytes.len() as u64)?;
    gpu.queue.write_buffer(&buffer, 0, bytes);
    Ok(buffer)
}

/// A zeroed buffer of `size` bytes.
///
/// # Errors
/// The device cannot bind that many bytes.
pub fn empty(
    gpu: &Gpu,
    label: &str,
    usage: BufferUsages,
    size: u64,
) -> Result<wgpu::Buffer, GpuError> {
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    if size > limit {
        let message = format!("{label}: {size} bytes: this adapter binds at most {limit}");
        return Err(GpuError::Failed(message));
    }
    let descriptor =
        wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
    Ok(gpu.device.create_buffer(&descriptor))
}

/// Waits for all work and returns what `source` holds.
///
/// # Errors
/// The device failed at this or at an earlier command.
pub fn read<T: Pod>(gpu: &Gpu, source: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
    let failed = |error: &dyn std::fmt::Display| GpuError::Failed(error.to_string());
    let staging =
        empty(gpu, "readback", BufferUsages::MAP_READ | BufferUsages::COPY_DST, source.size())?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &staging, 0, source.size());
    gpu.queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    staging.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone only if waiting failed, which is reported there.
        let _ = sender.send(result);
    });
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(&e))?;
    receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
    gpu.check()?;
    let bytes = staging.get_mapped_range(..).map_err(|e| failed(&e))?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}
