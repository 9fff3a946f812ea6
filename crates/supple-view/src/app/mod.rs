//! The program, whatever shows it: events go in, time goes on, pictures come out.

mod commands;
mod event;
mod frame;
mod pace;
mod pointer;

pub use event::{Button, Event};
pub use pace::Pace;

use crate::bake::{Loading, Request};
use crate::draw::{Camera, Drawn, Gpu, Posed, Renderer};
use crate::panel::{Command, Controls, Notice, Painter, Screen};
use crate::platform::Clock;
use crate::stage::Stage;
use crate::touch::{Balls, Grab, Probe};
use glam::DVec3;
use pointer::Pointer;
use std::path::PathBuf;
use supple::model::UpAxis;
use supple::wgpu;
use supple::world::Backend;
use supple::{Error, Result};
use supple_pictures::FONT_FILE;

/// How the program starts.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Whether the world is on the GPU that draws; else on the CPU.
    pub on_gpu: bool,
    /// Where bakes are kept; nowhere if none is given.
    pub cache: Option<PathBuf>,
    /// Where files are written.
    pub output: PathBuf,
    /// Whether characters are baked with fine handles, which wake where something touches.
    pub fine_handles: bool,
}

/// The program.
pub struct App {
    /// What is set.
    pub controls: Controls,
    /// How time goes.
    pub pace: Pace,
    /// From where it is looked.
    pub camera: Camera,
    options: Options,
    stage: Option<Box<Stage>>,
    loading: Option<Loading>,
    /// Who is shown, and who is on the way.
    request: Option<Request>,
    asked: Option<Request>,
    notice: Option<Notice>,
    renderer: Renderer,
    drawn: Option<Drawn>,
    /// Where the skin is on the device.
    posed: Option<Posed>,
    /// From end to end of the character, m.
    size: f64,
    /// Where the character's root was in the last frame.
    root: DVec3,
    pointer: Pointer,
    grab: Option<Grab>,
    /// How firmly bones are held: the power of ten of a factor.
    grip: f64,
    probe: Option<Probe>,
    balls: Balls,
    /// Those of the moment that is kept.
    kept: Balls,
    commands: Vec<Command>,
    screen: Screen,
    context: egui::Context,
    painter: Painter,
    input: Vec<egui::Event>,
    clock: Clock,
    /// What reading and drawing cost lately, ms.
    cost: [f64; 2],
}

impl App {
    /// Shows nobody yet; pictures are in `format`.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat, options: Options) -> Self {
        let renderer = Renderer::new(gpu, format);
        Self {
            controls: Controls::new(0.01),
            pace: Pace::default(),
            camera: Camera::around([DVec3::splat(-0.5), DVec3::splat(0.5)], UpAxis::Z),
            options,
            stage: None,
            loading: None,
            request: None,
            asked: None,
            notice: None,
            drawn: None,
            posed: None,
            size: 1.0,
            root: DVec3::ZERO,
            pointer: Pointer::default(),
            grab: None,
            grip: 0.0,
            probe: None,
            balls: Balls::default(),
            kept: Balls::default(),
            commands: Vec::new(),
            screen: Screen {
                size: [1, 1],
                scale: 1.0,
            },
            context: context(),
            painter: Painter::new(gpu, format),
            input: Vec::new(),
            clock: Clock::start(),
            cost: [0.0; 2],
            renderer,
        }
    }

    /// Begins to load; who is shown stays until that is done.
    pub fn open(&mut self, request: Request) {
        let backend = match self.options.on_gpu {
            true => Backend::Gpu {
                device: self.renderer.gpu().device.clone(),
                queue: self.renderer.gpu().queue.clone(),
            },
            false => Backend::Cpu,
        };
        self.asked = Some(request.clone());
        self.loading = Some(Loading::start(request, &self.options, backend));
        self.notice = None;
    }

    /// Whether somebody is on the way.
    pub fn is_loading(&self) -> bool {
        self.loading.is_some()
    }

    /// Who is shown.
    pub fn stage(&self) -> Option<&Stage> {
        self.stage.as_deref()
    }

    /// What was told last.
    pub fn notice(&self) -> Option<&Notice> {
        self.notice.as_ref()
    }

    /// Force with which the skin is held, N.
    pub fn pull(&self) -> f64 {
        match (&self.grab, &self.stage) {
            (Some(grab), Some(stage)) => grab.force(stage, self.controls.pull, self.size),
            _ => 0.0,
        }
    }

    /// What reading the skin and drawing cost the CPU lately, besides the steps, ms.
    pub fn frame_cost(&self) -> f64 {
        self.cost.iter().sum()
    }

    /// Lets `seconds` pass.
    pub async fn advance(&mut self, seconds: f64) {
        if let Some(done) = self.loading.as_mut().and_then(Loading::poll) {
            self.loading = None;
            match done {
                Ok(stage) => {
                    self.request = self.asked.take();
                    self.enter(stage);
                }
                Err(e) => self.tell_wrong(&e),
            }
        }
        for command in std::mem::take(&mut self.commands) {
            if let Err(e) = self.obey(command).await {
                self.tell_wrong(&e);
            }
        }
        self.lay_down();
        if let Err(e) = self.move_on(seconds).await {
            // It would fail again and again.
            self.pace.paused = true;
            self.tell_wrong(&e);
        }
    }

    /// Takes the steps of a frame.
    async fn move_on(&mut self, seconds: f64) -> Result<()> {
        let over = self.pointer.scene(self.scene_size()).is_some();
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        let controls = &self.controls;
        stage.set_time_step(controls.time_step);
        self.grip = match self.grab {
            Some(_) => controls.grip,
            // Who is let go comes back gently.
            None => (self.grip + LETTING_GO * seconds).min(0.0),
        };
        stage.grip = 10f64.powf(self.grip);
        stage.set_factors(controls.factors()?)?;
        stage.set_fine_handles(controls.fine_handles)?;
        let gravity = stage.character.scene.gravity();
        stage.world.set_gravity(controls.gravity * gravity);
        let steps = self.pace.steps(seconds, controls.time_step);
        for _ in 0..steps {
            match &self.grab {
                Some(grab) => grab.hold(stage, controls.pull, self.size)?,
                None => Grab::let_go(stage)?,
            }
            if let Some(probe) = &self.probe {
                probe.advance(stage, controls.time_step)?;
            }
            let rounds = stage.rounds;
            stage.step().await?;
            if stage.rounds != rounds {
                self.probe = None;
                self.balls.forget();
            }
        }
        let clock = Clock::start();
        if steps > 0 || stage.shown.map() != controls.map {
            stage.shown.set_map(controls.map);
            let touch = over || self.grab.is_some() || controls.handles;
            stage.read(touch).await?;
        }
        self.cost[0] = smoothed(self.cost[0], clock);
        let pull = match &self.grab {
            Some(grab) => grab.force(stage, controls.pull, self.size),
            None => 0.0,
        };
        if steps > 0 {
            stage.note(steps as f64 * controls.time_step, pull)?;
        }
        // The camera goes with who walks.
        let root = stage.world.instance(stage.me)?.frames()[0].position;
        let way = root - std::mem::replace(&mut self.root, root);
        let up = self.camera.up.direction();
        self.camera.target += way - way.dot(up) * up;
        Ok(())
    }

    /// Shows a new character in place of the old one.
    fn enter(&mut self, stage: Box<Stage>) {
        let map = self.controls.map;
        self.controls = Controls {
            tool: self.controls.tool,
            map,
            ..Controls::new(stage.time_step())
        };
        let [low, high] = stage.bounds();
        self.size = (high - low).length().max(1e-3);
        self.root = stage
            .world
            .instance(stage.me)
            .map_or(DVec3::ZERO, |c| c.frames()[0].position);
        self.drawn = Some(
            self.renderer
                .character(&stage.character.avatar, &stage.character.look),
        );
        self.posed = None;
        (self.grab, self.probe, self.balls) = (None, None, Balls::default());
        self.camera = Camera::around([low, high], stage.world.up());
        self.stage = Some(stage);
    }

    fn tell_wrong(&mut self, error: &Error) {
        self.notice = Some(Notice {
            text: error.to_string(),
            wrong: true,
        });
    }
}

/// How fast the hold on bones comes back, powers of ten a second.
const LETTING_GO: f64 = 4.0;

/// A mean over some twenty frames, ms.
fn smoothed(before: f64, clock: Clock) -> f64 {
    before + 0.05 * (1e3 * clock.seconds() - before)
}

/// The panel's context, with the font of the pictures.
fn context() -> egui::Context {
    let context = egui::Context::default();
    let mut fonts = egui::FontDefinitions::empty();
    let name = "DejaVu Sans".to_owned();
    let font = egui::FontData::from_static(FONT_FILE);
    fonts.font_data.insert(name.clone(), font.into());
    for family in [egui::FontFamily::Proportional, egui::FontFamily::Monospace] {
        fonts.families.insert(family, vec![name.clone()]);
    }
    context.set_fonts(fonts);
    context.set_theme(egui::Theme::Dark);
    context
}
