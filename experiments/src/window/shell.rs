//! A window, or two, with a device: event loop, surfaces, egui on top of whatever is drawn below it.
//!
//! Knows nothing of experiments. An [`App`] is asked to redraw, draws through [`Shell::draw`], and
//! says when it wants to be asked again. The surface's format stores code values unchanged (no sRGB
//! conversion), so an 8-bit value that a shader writes is the value that goes to the screen. Everything
//! is drawn in physical pixels, whatever the system's scale factor.

mod pane;

use crate::display::Codes;
use crate::display::check::Facts;
use pane::{Pane, adapter, open_window, surface_of};
use shutterlab_data_schema::DisplayProfile;
use shutterlab_data_schema::display::{StereoMode, StereoOutput};
use shutterlab_stimuli::frames::Transfer;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, OwnedDisplayHandle};
use winit::keyboard::Key;
use winit::monitor::MonitorHandle;
use winit::window::WindowId;

/// What a window shows and does.
pub trait App {
    /// Why it cannot go on.
    type Error: From<ShellError>;

    /// The window is there. Called once, before anything else.
    ///
    /// # Errors
    /// The window is closed and [`run`] returns the error.
    fn start(&mut self, shell: &mut Shell) -> Result<(), Self::Error>;

    /// A key was pressed (not repeated) and came in `at` this moment, whatever is being waited for.
    /// Returns whether that was all: if not, egui gets the key too.
    fn key(&mut self, key: &Key, at: Instant) -> bool;

    /// Draws, and says when to draw again.
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
    /// Redraw at this moment and not before, whatever happens.
    Only(Instant),
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
    /// No monitor has the name that the display profile gives.
    #[error("window: output: {output}: the monitors are {there}")]
    NoOutput {
        /// The name.
        output: String,
        /// The names there are.
        there: String,
    },
    /// The surface failed.
    #[error("window: drawing failed: {0}")]
    Surface(String),
}

/// How long before a moment the loop stops to sleep and watches the clock: longer than systems are
/// late to wake it.
const WATCHFUL: Duration = Duration::from_micros(1500);

/// By so much the guess of how long handing over takes is mended each time.
const HANDOVER_STEP: Duration = Duration::from_micros(50);

/// Logical pixels that pages of text need from top to bottom. In a lower window letters become smaller
/// than the system's scale factor asks for, down to the smallest size.
const PAGE_POINTS: f64 = 720.0;
const SMALLEST: f64 = 0.75;

/// An open window or two, their device, and egui.
pub struct Shell {
    /// The window; after it the right eye's, if it has one of its own.
    panes: Vec<Pane>,
    adapter: wgpu::AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    egui: egui_winit::State,
    egui_renderer: egui_wgpu::Renderer,
    egui_repaint_at: Option<Instant>,
    /// The neutral grey, as the display makes it.
    background: wgpu::Color,
    /// How long handing over what is drawn takes as often as not.
    handover: Duration,
    /// What the device first complained of, if it did.
    failure: Arc<Mutex<Option<String>>>,
}

/// Opens a window called `title` where `profile` says, and runs `app` in it until it is closed. Must be
/// called from the main thread, once per process.
///
/// # Errors
/// There is no display, not that monitor or no device, or the app failed.
pub fn run<A: App>(title: &str, profile: &DisplayProfile, app: &mut A) -> Result<(), A::Error> {
    let no_display =
        |error: winit::error::EventLoopError| ShellError::NoDisplay(cause(&error.to_string()));
    let event_loop = EventLoop::new().map_err(no_display)?;
    let display = event_loop.owned_display_handle();
    let mut handler =
        Handler { title, profile, app, display, shell: None, next: Next::OnEvent, failure: None };
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
        self.panes[0].config.format
    }

    /// Width and height of the window's inside, in physical pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.panes[0].size_px()
    }

    /// The egui context, for its style.
    pub fn egui(&self) -> &egui::Context {
        self.egui.egui_ctx()
    }

    /// Physical pixels per logical one.
    pub fn scale_factor(&self) -> f64 {
        self.panes[0].window.scale_factor()
    }

    /// What the system says about window, monitor and adapter.
    pub fn facts(&self) -> Facts {
        let monitor = self.panes[0].window.current_monitor();
        let millihertz = monitor.as_ref().and_then(MonitorHandle::refresh_rate_millihertz);
        Facts {
            monitor: monitor.as_ref().and_then(MonitorHandle::name),
            monitor_px: monitor.as_ref().map(|m| [m.size().width, m.size().height]),
            system_hz: millihertz.map(|hz| f64::from(hz) / 1000.0),
            window_px: self.size_px(),
            scale_factor: self.scale_factor(),
            adapter: self.adapter.name.clone(),
            software: self.adapter.device_type == wgpu::DeviceType::Cpu,
        }
    }

    /// The monitor's name, its physical pixels, and how many of them make a logical one.
    pub fn display(&self) -> String {
        let Facts { monitor, monitor_px, window_px: [width, height], scale_factor, .. } =
            self.facts();
        match monitor_px {
            Some([w, h]) => {
                let name = monitor.unwrap_or("unnamed".into());
                format!("{name}, {w}x{h} px, window {width}x{height} px, scale {scale_factor}")
            }
            None => format!("unknown, window {width}x{height} px, scale {scale_factor}"),
        }
    }

    /// Clears the window with `background`, lets `paint` draw, lays `ui` over it, and presents. If there
    /// are two windows, `paint` is called for each: it is given the number, 0 or 1, and the physical
    /// width and height; `ui` is laid over the second if that is as large as the first.
    /// Returns the time of submission, or none if a window cannot be seen just now.
    ///
    /// # Errors
    /// The surface failed for good.
    pub fn draw(
        &mut self,
        paint: impl FnMut(&mut wgpu::RenderPass<'static>, usize, [u32; 2]),
        ui: impl FnMut(&mut egui::Ui),
    ) -> Result<Option<Instant>, ShellError> {
        self.draw_for(None, paint, ui)
    }

    /// As [`Shell::draw`], but if there is a `moment`, drawing is done before, and handing over ends
    /// then, as well as can be foreseen.
    ///
    /// # Errors
    /// As [`Shell::draw`].
    pub fn draw_for(
        &mut self,
        moment: Option<Instant>,
        paint: impl FnMut(&mut wgpu::RenderPass<'static>, usize, [u32; 2]),
        ui: impl FnMut(&mut egui::Ui),
    ) -> Result<Option<Instant>, ShellError> {
        let points = f64::from(self.size_px()[1]) / self.scale_factor();
        let zoom = (points / PAGE_POINTS).clamp(SMALLEST, 1.0);
        self.egui.egui_ctx().set_zoom_factor(zoom as f32);
        let input = self.egui.take_egui_input(&self.panes[0].window);
        let mut output = self.egui.egui_ctx().run_ui(input, ui);
        self.egui.handle_platform_output(&self.panes[0].window, output.platform_output);
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
        let submitted = self.submit(moment, paint, &triangles, output.pixels_per_point);
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
        moment: Option<Instant>,
        mut paint: impl FnMut(&mut wgpu::RenderPass<'static>, usize, [u32; 2]),
        triangles: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> Result<Option<Instant>, ShellError> {
        let mut textures = Vec::new();
        for pane in &self.panes {
            let Some(texture) = pane.acquire(&self.device)? else { return Ok(None) };
            textures.push(texture);
        }
        let size_in_pixels = self.size_px();
        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels, pixels_per_point };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut commands = self.egui_renderer.update_buffers(
            &self.device,
            &self.queue,
            &mut encoder,
            triangles,
            &screen,
        );
        for (number, (pane, texture)) in self.panes.iter().zip(&textures).enumerate() {
            let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let attachment = wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(self.background),
                    store: wgpu::StoreOp::Store,
                },
            };
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(attachment)],
                ..Default::default()
            });
            let mut pass = pass.forget_lifetime();
            let [width, height] = pane.size_px();
            paint(&mut pass, number, [width, height]);
            if [width, height] == size_in_pixels {
                pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
                self.egui_renderer.render(&mut pass, triangles, &screen);
            }
        }
        commands.push(encoder.finish());
        let submission_index = Some(self.queue.submit(commands));
        if let Some(moment) = moment {
            // Drawing must be over when the moment comes; if it fails, the device has said why.
            self.device.poll(wgpu::PollType::Wait { submission_index, timeout: None }).ok();
            wait_until(moment.checked_sub(self.handover).unwrap_or(moment));
        }
        let begun = Instant::now();
        for (pane, texture) in self.panes.iter().zip(textures) {
            pane.window.pre_present_notify();
            self.queue.present(texture);
        }
        let submitted = Instant::now();
        if moment.is_some() {
            self.handover = match submitted - begun > self.handover {
                true => self.handover + HANDOVER_STEP,
                false => self.handover.saturating_sub(HANDOVER_STEP),
            };
        }
        Ok(Some(submitted))
    }

    fn open(
        event_loop: &ActiveEventLoop,
        display: &OwnedDisplayHandle,
        title: &str,
        profile: &DisplayProfile,
    ) -> Result<Self, ShellError> {
        let StereoOutput { mode, second_output } = &profile.stereo;
        let has_second = *mode == StereoMode::TwoWindows;
        // Two windows on one monitor stand side by side.
        let shift = match (profile.window, second_output) {
            (Some(size), None) if has_second => size.width_px as i32 / 2,
            _ => 0,
        };
        let window = open_window(event_loop, title, profile, profile.output.as_deref(), -shift)?;
        // OpenGL only where there is nothing better.
        let (instance, surface, adapter) = adapter(&window, display, wgpu::Backends::PRIMARY)
            .or_else(|_| adapter(&window, display, wgpu::Backends::SECONDARY))?;
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

        let mut panes = vec![Pane::new(window, surface, &adapter, &device)?];
        if has_second {
            let title = format!("{title} – right eye");
            let output = second_output.as_deref().or(profile.output.as_deref());
            let window = open_window(event_loop, &title, profile, output, shift)?;
            let surface = surface_of(&instance, &window)?;
            panes.push(Pane::new(window, surface, &adapter, &device)?);
        }
        let window = &panes[0].window;
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        let egui_renderer = egui_wgpu::Renderer::new(&device, panes[0].config.format, options);
        let context = egui::Context::default();
        context.options_mut(|options| options.zoom_with_keyboard = false);
        let id = egui::ViewportId::ROOT;
        let scale = window.scale_factor() as f32;
        let side = device.limits().max_texture_dimension_2d as usize;
        let egui = egui_winit::State::new(context, id, window, Some(scale), None, Some(side));
        Ok(Self {
            panes,
            adapter: adapter.get_info(),
            device,
            queue,
            egui,
            egui_renderer,
            egui_repaint_at: None,
            background: grey(profile),
            handover: Duration::ZERO,
            failure,
        })
    }

    fn resize(&mut self, id: WindowId, width: u32, height: u32) {
        let Some(pane) = self.panes.iter_mut().find(|pane| pane.window.id() == id) else { return };
        // A minimised window has no pixels, and a surface needs at least one.
        if width > 0 && height > 0 {
            (pane.config.width, pane.config.height) = (width, height);
            pane.surface.configure(&self.device, &pane.config);
        }
    }
}

struct Handler<'a, A: App> {
    title: &'a str,
    profile: &'a DisplayProfile,
    app: &'a mut A,
    display: OwnedDisplayHandle,
    shell: Option<Shell>,
    next: Next,
    failure: Option<A::Error>,
}

impl<A: App> Handler<'_, A> {
    fn redraw(&mut self, event_loop: &ActiveEventLoop) {
        let Some(shell) = &mut self.shell else { return };
        shell.egui_repaint_at = None;
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

    /// When to redraw if nothing happens.
    fn due(&self) -> Option<Instant> {
        let egui = self.shell.as_ref().and_then(|shell| shell.egui_repaint_at);
        match self.next {
            Next::At(moment) => Some(egui.map_or(moment, |egui| egui.min(moment))),
            Next::Only(moment) => Some(moment),
            Next::OnEvent => egui,
            Next::Exit => None,
        }
    }
}

impl<A: App> ApplicationHandler for Handler<'_, A> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shell.is_some() {
            return;
        }
        let opened = Shell::open(event_loop, &self.display, self.title, self.profile);
        let started = opened.map_err(A::Error::from).and_then(|mut shell| {
            self.app.start(&mut shell)?;
            shell.panes[0].window.request_redraw();
            Ok(shell)
        });
        match started {
            Ok(shell) => self.shell = Some(shell),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        let at = Instant::now();
        let Some(shell) = &mut self.shell else { return };
        let waits = matches!(self.next, Next::Only(moment) if at < moment);
        let redraw = match &event {
            WindowEvent::RedrawRequested if waits => return,
            WindowEvent::RedrawRequested => return self.redraw(event_loop),
            WindowEvent::CloseRequested => {
                // Keys that came before count.
                self.redraw(event_loop);
                return event_loop.exit();
            }
            WindowEvent::KeyboardInput { event: key, is_synthetic: false, .. }
                if key.state == ElementState::Pressed
                    && !key.repeat
                    && self.app.key(&key.logical_key, at) =>
            {
                true
            }
            event => {
                if let WindowEvent::Resized(size) = event {
                    shell.resize(id, size.width, size.height);
                }
                let window = shell.panes.iter().find(|pane| pane.window.id() == id);
                window.is_some_and(|pane| shell.egui.on_window_event(&pane.window, event).repaint)
            }
        };
        if redraw && !waits {
            shell.panes[0].window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.due().is_some_and(|due| due <= Instant::now()) {
            self.redraw(event_loop);
        }
        event_loop.set_control_flow(match self.due() {
            None => ControlFlow::Wait,
            Some(due) => match due.checked_sub(WATCHFUL) {
                Some(early) if early > Instant::now() => ControlFlow::WaitUntil(early),
                _ => ControlFlow::Poll,
            },
        });
    }
}

/// Code value of the neutral grey between and around the stimuli: the middle of the scale, for red, green
/// and blue. In sRGB that is 22 % of white's luminance, near the mean of the scenes.
pub const GREY: u8 = 128;

/// The neutral grey as the display of `profile` is to be given it: with what a stimulus of that code value
/// looks like.
fn grey(profile: &DisplayProfile) -> wgpu::Color {
    let codes = Codes::new(Transfer::Srgb, profile);
    let code = f64::from(codes.sent[usize::from(GREY)]) / 255.0;
    wgpu::Color { r: code, g: code, b: code, a: 1.0 }
}

/// Sleeps as long as that is safe, then watches the clock.
fn wait_until(moment: Instant) {
    let left = moment.saturating_duration_since(Instant::now());
    std::thread::sleep(left.saturating_sub(WATCHFUL));
    while Instant::now() < moment {
        std::hint::spin_loop();
    }
}

/// What winit says without the place in its source where it says so.
fn cause(text: &str) -> String {
    one_line(text.rsplit(": ").next().unwrap_or(text).trim_end_matches('.'))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
