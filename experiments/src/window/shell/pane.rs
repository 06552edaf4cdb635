//! One window and what is drawn on: where it opens, which adapter can draw in it, and in which format.

use super::{ShellError, cause, one_line};
use shutterlab_data_schema::DisplayProfile;
use std::sync::Arc;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event_loop::{ActiveEventLoop, OwnedDisplayHandle};
use winit::monitor::MonitorHandle;
use winit::window::{Fullscreen, Window};

/// A window and what is drawn on.
pub(super) struct Pane {
    pub window: Arc<Window>,
    pub surface: wgpu::Surface<'static>,
    pub config: wgpu::SurfaceConfiguration,
}

impl Pane {
    pub(super) fn new(
        window: Arc<Window>,
        surface: wgpu::Surface<'static>,
        adapter: &wgpu::Adapter,
        device: &wgpu::Device,
    ) -> Result<Self, ShellError> {
        let config = configuration(&surface, adapter, &window)?;
        surface.configure(device, &config);
        Ok(Self { window, surface, config })
    }

    pub(super) fn size_px(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    pub(super) fn acquire(
        &self,
        device: &wgpu::Device,
    ) -> Result<Option<wgpu::SurfaceTexture>, ShellError> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => Ok(Some(texture)),
            Current::Timeout | Current::Occluded => Ok(None),
            Current::Outdated | Current::Lost => {
                self.surface.configure(device, &self.config);
                Ok(None)
            }
            Current::Validation => Err(ShellError::Surface("the surface was refused".into())),
        }
    }
}

/// Opens a window that fills the monitor called `output`, or the one that the system chooses; or one of
/// the size that `profile` asks for, `shift_px` to the right of its middle.
pub(super) fn open_window(
    event_loop: &ActiveEventLoop,
    title: &str,
    profile: &DisplayProfile,
    output: Option<&str>,
    shift_px: i32,
) -> Result<Arc<Window>, ShellError> {
    let there: Vec<MonitorHandle> = event_loop.available_monitors().collect();
    let named = |monitor: &MonitorHandle| monitor.name().unwrap_or("unnamed".into());
    let monitor = match output {
        None => event_loop.primary_monitor().or_else(|| there.first().cloned()),
        Some(output) => {
            let found = there.iter().find(|monitor| named(monitor) == output).cloned();
            Some(found.ok_or_else(|| ShellError::NoOutput {
                output: output.into(),
                there: there.iter().map(named).collect::<Vec<_>>().join(", "),
            })?)
        }
    };
    let mut attributes = Window::default_attributes().with_title(title);
    // Where nobody manages windows they are as large and where it is said here, full screen or not.
    let (corner, whole) = match &monitor {
        Some(monitor) => (monitor.position(), monitor.size()),
        None => (PhysicalPosition::new(0, 0), PhysicalSize::new(1280, 720)),
    };
    let size =
        profile.window.map_or(whole, |size| PhysicalSize::new(size.width_px, size.height_px));
    let middle = |whole: u32, part: u32| (i64::from(whole) - i64::from(part)).div_euclid(2) as i32;
    attributes = attributes.with_inner_size(size).with_position(PhysicalPosition::new(
        corner.x + middle(whole.width, size.width) + shift_px,
        corner.y + middle(whole.height, size.height),
    ));
    if profile.window.is_none() {
        // Without the name the window stays on the monitor that the system opens it on.
        attributes = attributes.with_fullscreen(Some(Fullscreen::Borderless(output.and(monitor))));
    }
    event_loop
        .create_window(attributes)
        .map(Arc::new)
        .map_err(|error| ShellError::NoDisplay(cause(&error.to_string())))
}

pub(super) fn surface_of(
    instance: &wgpu::Instance,
    window: &Arc<Window>,
) -> Result<wgpu::Surface<'static>, ShellError> {
    instance
        .create_surface(window.clone())
        .map_err(|error| ShellError::NoAdapter(one_line(&error.to_string())))
}

pub(super) fn adapter(
    window: &Arc<Window>,
    display: &OwnedDisplayHandle,
    backends: wgpu::Backends,
) -> Result<(wgpu::Instance, wgpu::Surface<'static>, wgpu::Adapter), ShellError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_with_display_handle(Box::new(display.clone()))
    });
    let surface = surface_of(&instance, window)?;
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
        compatible_surface: Some(&surface),
        ..Default::default()
    }))
    .map_err(|error| ShellError::NoAdapter(one_line(&error.to_string())))?;
    Ok((instance, surface, adapter))
}

fn configuration(
    surface: &wgpu::Surface<'_>,
    adapter: &wgpu::Adapter,
    window: &Window,
) -> Result<wgpu::SurfaceConfiguration, ShellError> {
    let formats = surface.get_capabilities(adapter).formats;
    let unchanged = [wgpu::TextureFormat::Bgra8Unorm, wgpu::TextureFormat::Rgba8Unorm];
    let format = unchanged.into_iter().find(|format| formats.contains(format));
    let size = window.inner_size();
    let config = surface.get_default_config(adapter, size.width.max(1), size.height.max(1));
    match (format, config) {
        (Some(format), Some(config)) => Ok(wgpu::SurfaceConfiguration {
            format,
            present_mode: wgpu::PresentMode::Fifo,
            desired_maximum_frame_latency: 1,
            ..config
        }),
        _ => {
            let formats: Vec<String> = formats.iter().map(|f| format!("{f:?}")).collect();
            let adapter = adapter.get_info().name;
            Err(ShellError::NoFormat { adapter, formats: formats.join(", ") })
        }
    }
}
