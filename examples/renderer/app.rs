//! The window, and what the mouse does in it.

use super::{Camera, Renderer, Upload};
use crate::{Anything, Arguments, Character, Host, Stage};
use std::sync::Arc;
use std::time::Instant;
use supple::wgpu;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

/// Opens a window, and returns when it is closed.
pub fn open_window(arguments: Arguments, character: Character) -> Anything<()> {
    let mut app = App {
        arguments,
        character,
        shown: None,
        failed: None,
    };
    EventLoop::new()?.run_app(&mut app)?;
    app.failed.map_or(Ok(()), Err)
}

struct App {
    arguments: Arguments,
    character: Character,
    shown: Option<Shown>,
    failed: Option<Box<dyn std::error::Error>>,
}

/// What there is once a window is open.
struct Shown {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    host: Host,
    stage: Stage,
    renderer: Renderer,
    upload: Upload,
    camera: Camera,
    drawn: Instant,
    /// Where the mouse is, and whether it drags.
    mouse: Option<[f64; 2]>,
    drags: bool,
}

impl Shown {
    fn new(
        event_loop: &ActiveEventLoop,
        arguments: &Arguments,
        character: &Character,
    ) -> Anything<Self> {
        let attributes = Window::default_attributes().with_title("supple");
        let window = Arc::new(event_loop.create_window(attributes)?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window.clone())?;
        let host = pollster::block_on(Host::open(&instance, Some(&surface)))?;
        let size = window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let mut config = (surface.get_default_config(&host.adapter, width, height))
            .ok_or("the adapter cannot draw on the window")?;
        // Else colours come out dark.
        let formats = surface.get_capabilities(&host.adapter).formats;
        let srgb = formats.iter().copied().find(wgpu::TextureFormat::is_srgb);
        config.format = srgb.unwrap_or(config.format);
        surface.configure(&host.device, &config);
        let mut stage = Stage::new(character, host.backend(arguments))?;
        Ok(Self {
            renderer: host.renderer(config.format, arguments, character),
            upload: Upload::new(&host.device, character.avatar.skin.len()),
            camera: stage.camera()?,
            drawn: Instant::now(),
            mouse: None,
            drags: false,
            window,
            surface,
            config,
            host,
            stage,
        })
    }

    /// Steps by the time since the last picture, and draws.
    fn draw(&mut self) -> Anything<()> {
        let time = self.drawn.elapsed().as_secs_f64().clamp(1e-3, 0.1);
        self.drawn = Instant::now();
        self.stage.step(time)?;
        self.camera.target = self.stage.target()?;
        use wgpu::CurrentSurfaceTexture as Current;
        let frame = match self.surface.get_current_texture() {
            Current::Success(frame) | Current::Suboptimal(frame) => frame,
            Current::Outdated | Current::Lost => {
                self.surface.configure(&self.host.device, &self.config);
                return Ok(());
            }
            _ => return Ok(()),
        };
        let Stage { world, me, .. } = &mut self.stage;
        let posed = self.upload.posed(&self.host.queue, world, *me)?;
        let target = frame.texture.create_view(&Default::default());
        let size = [self.config.width, self.config.height];
        self.renderer.draw(&posed, &self.camera, &target, size);
        self.host.queue.present(frame);
        Ok(())
    }

    fn handle(&mut self, event: WindowEvent) -> Anything<()> {
        match event {
            WindowEvent::Resized(size) if size.width > 0 && size.height > 0 => {
                (self.config.width, self.config.height) = (size.width, size.height);
                self.surface.configure(&self.host.device, &self.config);
            }
            WindowEvent::MouseInput {
                state,
                button: MouseButton::Left,
                ..
            } => self.drags = state == ElementState::Pressed,
            WindowEvent::CursorMoved { position, .. } => {
                let now = [position.x, position.y];
                let before = self.mouse.replace(now).unwrap_or(now);
                if self.drags {
                    let by = [0, 1].map(|k| 0.01 * (now[k] - before[k]) as f32);
                    self.camera.turn(by);
                }
            }
            WindowEvent::MouseWheel { delta, .. } => self.camera.come_near(match delta {
                MouseScrollDelta::LineDelta(_, lines) => lines,
                MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
            }),
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed
                    && event.logical_key == Key::Character("m".into()) =>
            {
                self.renderer.shows_motion ^= true;
            }
            WindowEvent::RedrawRequested => {
                self.draw()?;
                self.window.request_redraw();
            }
            _ => {}
        }
        Ok(())
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.shown.is_none() {
            match Shown::new(event_loop, &self.arguments, &self.character) {
                Ok(shown) => self.shown = Some(shown),
                Err(error) => self.fail(event_loop, error),
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let is_escape = matches!(&event, WindowEvent::KeyboardInput { event, .. }
            if event.logical_key == Key::Named(NamedKey::Escape));
        if is_escape || event == WindowEvent::CloseRequested {
            event_loop.exit();
        } else if let Some(Err(error)) = self.shown.as_mut().map(|shown| shown.handle(event)) {
            self.fail(event_loop, error);
        }
    }
}

impl App {
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Box<dyn std::error::Error>) {
        self.failed = Some(error);
        event_loop.exit();
    }
}
