//! A window of winit's that shows the program.

use crate::app::{App, Button, Event, Options};
use crate::bake::Request;
use crate::draw::Gpu;
use crate::panel::Screen;
use crate::platform::{Clock, rest};
use std::sync::Arc;
use supple::wgpu;
use supple::{Error, Result};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

/// Opens a window that shows `request`, and returns when it is closed.
///
/// # Errors
/// No display, no adapter.
pub fn open_window(options: Options, request: Request) -> Result<()> {
    let refused = |e: winit::error::EventLoopError| {
        let cure =
            "a window needs X11 or Wayland; set DISPLAY or WAYLAND_DISPLAY, or use `supple play`";
        Error::invalid("window", format!("{e}: {cure}"))
    };
    let mut host = Host {
        options,
        request: Some(request),
        shown: None,
        failed: None,
    };
    (EventLoop::new().map_err(refused)?.run_app(&mut host)).map_err(refused)?;
    host.failed.map_or(Ok(()), Err)
}

struct Host {
    options: Options,
    request: Option<Request>,
    shown: Option<Shown>,
    failed: Option<Error>,
}

/// What there is once the window is open.
struct Shown {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    app: App,
    clock: Clock,
}

impl Shown {
    fn new(event_loop: &ActiveEventLoop, options: Options) -> Result<Self> {
        let refused = |e: &dyn std::fmt::Display| Error::invalid("window", e.to_string());
        let attributes = Window::default_attributes()
            .with_title("supple")
            .with_inner_size(LogicalSize::new(1180, 760));
        let window = event_loop
            .create_window(attributes)
            .map_err(|e| refused(&e))?;
        let window = Arc::new(window);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance
            .create_surface(window.clone())
            .map_err(|e| refused(&e))?;
        let gpu = pollster::block_on(Gpu::open(&instance, Some(&surface)))?;
        let size = window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let config = surface.get_default_config(&gpu.adapter, width, height);
        let mut config = config.ok_or_else(|| refused(&"the adapter cannot draw on it"))?;
        // Else colours come out dark.
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let srgb = formats.iter().copied().find(wgpu::TextureFormat::is_srgb);
        config.format = srgb.unwrap_or(config.format);
        surface.configure(&gpu.device, &config);
        Ok(Self {
            app: App::new(&gpu, config.format, options),
            clock: Clock::start(),
            window,
            surface,
            config,
            gpu,
        })
    }

    /// Lets the time since the last frame pass, and draws.
    fn draw(&mut self) {
        let seconds = std::mem::replace(&mut self.clock, Clock::start()).seconds();
        pollster::block_on(self.app.advance(seconds.min(0.1)));
        use wgpu::CurrentSurfaceTexture as Current;
        let frame = match self.surface.get_current_texture() {
            Current::Success(frame) | Current::Suboptimal(frame) => frame,
            Current::Outdated | Current::Lost => {
                self.surface.configure(&self.gpu.device, &self.config);
                return;
            }
            _ => {
                // Hidden: nobody waits for the picture.
                rest();
                return;
            }
        };
        let screen = Screen {
            size: [self.config.width, self.config.height],
            scale: self.window.scale_factor() as f32,
        };
        self.app
            .draw(&frame.texture.create_view(&Default::default()), screen);
        self.gpu.queue.present(frame);
    }

    fn handle(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::Resized(size) if size.width > 0 && size.height > 0 => {
                (self.config.width, self.config.height) = (size.width, size.height);
                self.surface.configure(&self.gpu.device, &self.config);
            }
            WindowEvent::RedrawRequested => {
                self.draw();
                self.window.request_redraw();
            }
            other => told(other).iter().for_each(|event| self.app.handle(event)),
        }
    }
}

/// A window's event as the program has it.
fn told(event: &WindowEvent) -> Vec<Event> {
    match event {
        WindowEvent::CursorMoved { position, .. } => vec![Event::Moved([position.x, position.y])],
        WindowEvent::CursorLeft { .. } => vec![Event::Left],
        WindowEvent::MouseInput { state, button, .. } => {
            let button = match button {
                MouseButton::Left => Button::Primary,
                MouseButton::Right => Button::Secondary,
                MouseButton::Middle => Button::Middle,
                _ => return Vec::new(),
            };
            vec![Event::Button(button, *state == ElementState::Pressed)]
        }
        WindowEvent::MouseWheel { delta, .. } => vec![Event::Wheel(match delta {
            MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / 40.0,
        })],
        WindowEvent::KeyboardInput { event, .. } => {
            let pressed = event.state == ElementState::Pressed;
            let key = match &event.logical_key {
                Key::Named(NamedKey::Space) => Some(egui::Key::Space),
                Key::Named(NamedKey::Backspace) => Some(egui::Key::Backspace),
                Key::Named(NamedKey::Delete) => Some(egui::Key::Delete),
                Key::Named(NamedKey::Enter) => Some(egui::Key::Enter),
                Key::Named(NamedKey::Tab) => Some(egui::Key::Tab),
                Key::Named(NamedKey::ArrowLeft) => Some(egui::Key::ArrowLeft),
                Key::Named(NamedKey::ArrowRight) => Some(egui::Key::ArrowRight),
                Key::Character(text) => egui::Key::from_name(&text.to_uppercase()),
                _ => None,
            };
            let text = event.text.as_ref().filter(|_| pressed);
            let text = text.filter(|t| !t.chars().any(char::is_control));
            let text = text.map(|t| Event::Text(t.to_string()));
            // A key that is held down toggles nothing.
            let edits = matches!(&event.logical_key, Key::Named(name) if *name != NamedKey::Space);
            key.filter(|_| !event.repeat || edits)
                .map(|key| Event::Key(key, pressed))
                .into_iter()
                .chain(text)
                .collect()
        }
        WindowEvent::DroppedFile(path) => vec![Event::Dropped(path.clone())],
        _ => Vec::new(),
    }
}

impl ApplicationHandler for Host {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        match Shown::new(event_loop, self.options.clone()) {
            Ok(mut shown) => {
                if let Some(request) = self.request.take() {
                    shown.app.open(request);
                }
                self.shown = Some(shown);
            }
            Err(error) => {
                self.failed = Some(error);
                event_loop.exit();
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let escape = matches!(&event, WindowEvent::KeyboardInput { event, .. }
            if event.logical_key == Key::Named(NamedKey::Escape));
        if escape || event == WindowEvent::CloseRequested {
            event_loop.exit();
        } else if let Some(shown) = &mut self.shown {
            shown.handle(&event);
        }
    }
}
