//! A window with a device in it: event loop, surface, egui on top of whatever is drawn below it.
//!
//! Knows nothing of experiments. An [`App`] is asked to redraw, draws through [`Shell::draw`], and
//! says when it wants to be asked again. The surface's format stores code values unchanged (no sRGB
//! conversion), so an 8-bit value that a shader writes is the value that goes to the screen.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{ElementState, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, OwnedDisplayHandle};
use winit::keyboard::Key;
use winit::window::{Fullscreen, Window, WindowId};

/// What a window shows and does.
pub trait App {
    /// Why it cannot go on.
    type Error: From<ShellError>;

    /// The window is there. Called once, before anything else.
    ///
    /// # Errors
    /// The window is closed and [`run`] returns the error.
    fn start(&mut self, shell: &mut Shell) -> Result<(), Self::Error>;

    /// A key was pressed (not repeated). Returns whether that was all: if not, egui gets the key too.
    fn key(&mut self, key: &Key) -> bool;

    /// Draws, and says when to draw again; events lead to another call in any case.
    ///
    /// # Errors
    /// The window is closed and [`run`] returns the error.
    fn redraw(&mut self, shell: &mut Shell) -> Result<Next, Self::Error>;
}

/// What comes after a redraw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Redraw when something happens.
    OnEvent,
    /// Redraw at this moment, or when something happens before.
    At(Instant),
    /// Close the window.
    Exit,
}

/// There is no window, or it cannot be drawn in.
#[derive(Debug, thiserror::Error)]
pub enum ShellError {
    /// No display to open a window on.
    #[error(
        "window: no display could be opened ({0}); run from a desktop session, or use a simulated observer, which needs no window"
    )]
    NoDisplay(String),
    /// No graphics device.
    #[error("window: no graphics adapter can draw in it ({0}); install a Vulkan or OpenGL driver")]
    NoAdapter(String),
    /// The surface has no format that keeps 8-bit code values.
    #[error(
        "window: the adapter {adapter} offers {formats}: Bgra8Unorm or Rgba8Unorm is needed to show stimuli unchanged"
    )]
    NoFormat {
        /// The adapter.
        adapter: String,
        /// The formats there are.
        formats: String,
    },
    /// The surface failed.
    #[error("window: drawing failed: {0}")]
    Surface(String),
}

/// An open window, its device, and egui.
pub struct Shell {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    egui: egui_winit::State,
    egui_renderer: egui_wgpu::Renderer,
    egui_repaint_at: Option<Instant>,
    /// What the device first complained of, if it did.
    failure: Arc<Mutex<Option<String>>>,
}

/// Opens a window called `title` that fills the screen, and runs `app` in it until it is closed.
/// Must be called from the main thread, once per process.
///
/// # Errors
/// There is no display or no device, or the app failed.
pub fn run<A: App>(title: &str, app: &mut A) -> Result<(), A::Error> {
    let no_display =
        |error: winit::error::EventLoopError| ShellError::NoDisplay(cause(&error.to_string()));
    let event_loop = EventLoop::new().map_err(no_display)?;
    let display = event_loop.owned_display_handle();
    let mut handler =
        Handler { title, app, display, shell: None, next: Next::OnEvent, failure: None };
    event_loop.run_app(&mut handler).map_err(no_display)?;
    handler.failure.map_or(Ok(()), Err)
}

impl Shell {
    /// The graphics device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The device's queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Format of what is drawn on.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// Width and height of the window's inside, in physical pixels.
    pub fn size_px(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// The egui context, for its style.
    pub fn egui(&self) -> &egui::Context {
        self.egui.egui_ctx()
    }

    /// The monitor's name, its physical pixels, and how many of them make a logical one.
    pub fn display(&self) -> String {
        let scale = self.window.scale_factor();
        let [width, height] = self.size_px();
        match self.window.current_monitor() {
            Some(monitor) => {
                let (name, size) = (monitor.name().unwrap_or("unnamed".into()), monitor.size());
                let (w, h) = (size.width, size.height);
                format!("{name}, {w}x{h} px, window {width}x{height} px, scale {scale}")
            }
            None => format!("unknown, window {width}x{height} px, scale {scale}"),
        }
    }

    /// Clears the window with `background`, lets `paint` draw, lays `ui` over it, and presents.
    /// Returns the time of submission, or none if the window cannot be seen just now.
    ///
    /// # Errors
    /// The surface failed for good.
    pub fn draw(
        &mut self,
        background: wgpu::Color,
        paint: impl FnOnce(&mut wgpu::RenderPass<'static>),
        ui: impl FnMut(&mut egui::Ui),
    ) -> Result<Option<Instant>, ShellError> {
        let input = self.egui.take_egui_input(&self.window);
        let mut output = self.egui.egui_ctx().run_ui(input, ui);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let delay = output.viewport_output.values().map(|viewport| viewport.repaint_delay).min();
        self.egui_repaint_at = delay
            .filter(|delay| *delay < Duration::from_secs(3600))
            .map(|delay| Instant::now() + delay);
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in &deltas {
                self.egui_renderer.update_texture(&self.device, &self.queue, id, delta);
            }
        }
        let freed: Vec<egui::TextureId> = output.textures_delta.free.drain().collect();
        let triangles = self.egui.egui_ctx().tessellate(output.shapes, output.pixels_per_point);
        let submitted = self.submit(background, paint, &triangles, output.pixels_per_point);
        for id in &freed {
            self.egui_renderer.free_texture(id);
        }
        match self.failure.lock().ok().and_then(|failure| failure.clone()) {
            Some(failure) => Err(ShellError::Surface(failure)),
            None => submitted,
        }
    }

    fn submit(
        &mut self,
        background: wgpu::Color,
        paint: impl FnOnce(&mut wgpu::RenderPass<'static>),
        triangles: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<Option<Instant>, ShellError> {
        let Some(texture) = self.acquire()? else { return Ok(None) };
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let screen =
            egui_wgpu::ScreenDescriptor { size_in_pixels: self.size_px(), pixels_per_point };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut commands = self.egui_renderer.update_buffers(
            &self.device,
            &self.queue,
            &mut encoder,
            triangles,
            &screen,
        );
        let attachment = wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(background),
                store: wgpu::StoreOp::Store,
            },
        };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("window"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        let mut pass = pass.forget_lifetime();
        paint(&mut pass);
        let [width, height] = self.size_px();
        pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        self.egui_renderer.render(&mut pass, triangles, &screen);
        drop(pass);
        commands.push(encoder.finish());
        self.queue.submit(commands);
        self.window.pre_present_notify();
        self.queue.present(texture);
        Ok(Some(Instant::now()))
    }

    fn acquire(&mut self) -> Result<Option<wgpu::SurfaceTexture>, ShellError> {
        use wgpu::CurrentSurfaceTexture as Current;
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => Ok(Some(texture)),
            Current::Timeout | Current::Occluded => Ok(None),
            Current::Outdated | Current::Lost => {
                self.surface.configure(&self.device, &self.config);
                Ok(None)
            }
            Current::Validation => Err(ShellError::Surface("the surface was refused".into())),
        }
    }

    fn open(
        event_loop: &ActiveEventLoop,
        display: OwnedDisplayHandle,
        title: &str,
    ) -> Result<Self, ShellError> {
        let attributes = Window::default_attributes()
            .with_title(title)
            .with_inner_size(LogicalSize::new(1200, 760))
            .with_fullscreen(Some(Fullscreen::Borderless(None)));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| ShellError::NoDisplay(cause(&error.to_string())))?;
        let window = Arc::new(window);
        // OpenGL only where there is nothing better.
        let (surface, adapter) = adapter(&window, &display, wgpu::Backends::PRIMARY)
            .or_else(|_| adapter(&window, &display, wgpu::Backends::SECONDARY))?;
        let descriptor = wgpu::DeviceDescriptor {
            required_limits: wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits()),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| ShellError::NoAdapter(one_line(&error.to_string())))?;
        // Without this a complaint of the device would end the program in a panic.
        let failure = Arc::new(Mutex::new(None));
        let noted = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut failure) = noted.lock() {
                failure.get_or_insert_with(|| one_line(&error.to_string()));
            }
        }));

        let config = configuration(&surface, &adapter, &window)?;
        surface.configure(&device, &config);
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        let egui_renderer = egui_wgpu::Renderer::new(&device, config.format, options);
        let context = egui::Context::default();
        context.options_mut(|options| options.zoom_with_keyboard = false);
        let id = egui::ViewportId::ROOT;
        let scale = window.scale_factor() as f32;
        let side = device.limits().max_texture_dimension_2d as usize;
        let egui = egui_winit::State::new(context, id, &window, Some(scale), None, Some(side));
        let egui_repaint_at = None;
        Ok(Self {
            window,
            surface,
            config,
            device,
            queue,
            egui,
            egui_renderer,
            egui_repaint_at,
            failure,
        })
    }

    fn resize(&mut self, width: u32, height: u32) {
        // A minimised window has no pixels, and a surface needs at least one.
        if width > 0 && height > 0 {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&self.device, &self.config);
        }
    }
}

fn adapter(
    window: &Arc<Window>,
    display: &OwnedDisplayHandle,
    backends: wgpu::Backends,
) -> Result<(wgpu::Surface<'static>, wgpu::Adapter), ShellError> {
    let no_adapter = |error: String| ShellError::NoAdapter(one_line(&error));
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_with_display_handle(Box::new(display.clone()))
    });
    let surface =
        instance.create_surface(window.clone()).map_err(|error| no_adapter(error.to_string()))?;
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
        compatible_surface: Some(&surface),
        ..Default::default()
    }))
    .map_err(|error| no_adapter(error.to_string()))?;
    Ok((surface, adapter))
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

struct Handler<'a, A: App> {
    title: &'a str,
    app: &'a mut A,
    display: OwnedDisplayHandle,
    shell: Option<Shell>,
    next: Next,
    failure: Option<A::Error>,
}

impl<A: App> Handler<'_, A> {
    fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        let Some(shell) = &mut self.shell else { return };
        match self.app.redraw(shell) {
            Ok(Next::Exit) => event_loop.exit(),
            Ok(next) => self.next = next,
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: A::Error) {
        self.failure.get_or_insert(error);
        event_loop.exit();
    }
}

impl<A: App> ApplicationHandler for Handler<'_, A> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shell.is_some() {
            return;
        }
        let opened = Shell::open(event_loop, self.display.clone(), self.title);
        let started = opened.map_err(A::Error::from).and_then(|mut shell| {
            self.app.start(&mut shell)?;
            shell.window.request_redraw();
            Ok(shell)
        });
        match started {
            Ok(shell) => self.shell = Some(shell),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(shell)) = (cause, &self.shell) {
            shell.window.request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shell) = &mut self.shell else { return };
        match &event {
            WindowEvent::RedrawRequested => return self.redraw(event_loop),
            WindowEvent::CloseRequested => return event_loop.exit(),
            WindowEvent::Resized(size) => shell.resize(size.width, size.height),
            WindowEvent::KeyboardInput { event: key, is_synthetic: false, .. }
                if key.state == ElementState::Pressed
                    && !key.repeat
                    && self.app.key(&key.logical_key) =>
            {
                return shell.window.request_redraw();
            }
            _ => {}
        }
        if shell.egui.on_window_event(&shell.window, &event).repaint {
            shell.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let egui = self.shell.as_ref().and_then(|shell| shell.egui_repaint_at);
        let app = match self.next {
            Next::At(moment) => Some(moment),
            Next::OnEvent | Next::Exit => None,
        };
        let next = app.into_iter().chain(egui).min();
        event_loop.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

/// What winit says without the place in its source where it says so.
fn cause(text: &str) -> String {
    one_line(text.rsplit(": ").next().unwrap_or(text).trim_end_matches('.'))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
