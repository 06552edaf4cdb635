//! Finding an adapter and opening a device on it, without a window.

use std::sync::{Arc, Mutex};

/// An open device and its queue.
#[derive(Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it runs on.
    pub info: wgpu::AdapterInfo,
    failure: Arc<Mutex<Option<String>>>,
}

/// No device could be opened, or it failed.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter at all, not even one in software.
    #[error(
        "device: gpu: no graphics adapter found ({0}); install a driver (in software: mesa-vulkan-drivers) or choose cpu"
    )]
    NoAdapter(wgpu::RequestAdapterError),
    /// The adapter cannot give what every pipeline needs.
    #[error("device: gpu: {adapter}: {source}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What it refused.
        source: wgpu::RequestDeviceError,
    },
    /// The device was lost, ran out of memory or refused a command.
    #[error("device: gpu: {0}")]
    Failed(String),
}

impl Gpu {
    /// Opens the fastest adapter there is; one in software is as good as any.
    ///
    /// # Errors
    /// There is no adapter, or it cannot be opened.
    pub fn open() -> Result<Self, GpuError> {
        let adapter = request_adapter(wgpu::Backends::PRIMARY)
            .or_else(|_| request_adapter(wgpu::Backends::SECONDARY))
            .map_err(GpuError::NoAdapter)?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("shutterlab"),
            // Light maps of 16 million texels and images of 8 million pixels fit where they fit at all.
            required_limits: wgpu::Limits {
                max_storage_buffer_binding_size: adapter.limits().max_storage_buffer_binding_size,
                max_buffer_size: adapter.limits().max_buffer_size,
                max_texture_dimension_2d: adapter.limits().max_texture_dimension_2d,
                ..wgpu::Limits::downlevel_defaults()
            },
            ..Default::default()
        }))
        .map_err(|source| GpuError::NoDevice { adapter: info.name.clone(), source })?;
        let failure = Arc::new(Mutex::new(None));
        let note = {
            let failure = Arc::clone(&failure);
            move |message: String| {
                if let Ok(mut failure) = failure.lock() {
                    failure.get_or_insert(message);
                }
            }
        };
        let note_error = note.clone();
        device
            .on_uncaptured_error(Arc::new(move |error: wgpu::Error| note_error(error.to_string())));
        device.set_device_lost_callback(move |reason, message| {
            // Dropping the device ends it too; that is no failure.
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(format!("lost: {message}"));
            }
        });
        Ok(Self { device, queue, info, failure })
    }

    /// What has gone wrong since the device was opened, if anything has. Commands after a failure do
    /// nothing, so results are trusted only where this is `Ok`.
    ///
    /// # Errors
    /// The first failure.
    pub fn check(&self) -> Result<(), GpuError> {
        let failure = self.failure.lock().ok().and_then(|failure| failure.clone());
        failure.map_or(Ok(()), |message| Err(GpuError::Failed(message)))
    }

    /// Name and version of the driver.
    pub fn driver(&self) -> String {
        format!("{:?} {} {}", self.info.backend, self.info.driver, self.info.driver_info)
            .trim()
            .to_string()
    }
}

/// Looking for OpenGL makes some systems complain on stderr, so it is not looked for where Vulkan,
/// Metal or Direct3D 12 will do.
fn request_adapter(backends: wgpu::Backends) -> Result<wgpu::Adapter, wgpu::RequestAdapterError> {
    let descriptor = wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    };
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..Default::default()
    };
    pollster::block_on(wgpu::Instance::new(descriptor).request_adapter(&options))
}
