//! A frame: the scene, and the panel at its right.

use super::{App, smoothed};
use crate::draw::{Posed, Sight, Solid};
use crate::panel::{self, Facts, Screen};
use crate::platform::Clock;
use supple::collider::Shape;
use supple::wgpu;
use supple_files::from_srgb;
use supple_scene::COLLIDER_COLOUR;

impl App {
    /// Draws a frame: the scene, and the panel at its right.
    pub fn draw(&mut self, target: &wgpu::TextureView, screen: Screen) {
        self.screen = screen;
        let clock = Clock::start();
        let output = self.lay_out();
        let primitives = self
            .context
            .tessellate(output.shapes, output.pixels_per_point);
        let gpu = self.renderer.gpu().clone();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let solids = self.solids();
        self.bring_skin();
        let sight = Sight {
            camera: &self.camera,
            solids: &solids,
            extent: self.size,
            own_colour: 0.0,
        };
        let sizes = [self.scene_size(), screen.size];
        let character = self.drawn.as_mut().zip(self.posed.as_ref());
        self.renderer
            .draw(&mut encoder, character, &sight, target, sizes);
        let changed = &output.textures_delta;
        (self.painter).paint(&mut encoder, target, screen, &primitives, changed);
        gpu.queue.submit([encoder.finish()]);
        self.cost[1] = smoothed(self.cost[1], clock);
    }

    /// Lays out the panel.
    fn lay_out(&mut self) -> egui::FullOutput {
        let screen = self.screen;
        let size = screen.size.map(|n| n as f32 / screen.scale);
        let mut input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size.into())),
            time: Some(self.clock.seconds()),
            events: std::mem::take(&mut self.input),
            ..Default::default()
        };
        let viewport = input.viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(screen.scale);
        let facts = Facts {
            stage: self.stage.as_deref(),
            loading: self.loading.as_ref(),
            notice: self.notice.as_ref(),
            frame: self.frame_cost(),
            label: self.pull_label(),
            pull: self.pull(),
        };
        let (controls, pace) = (&mut self.controls, &mut self.pace);
        let mut asked = Vec::new();
        let output = self.context.run(input, |context| {
            asked = panel::show(context, controls, pace, &facts);
        });
        self.commands.extend(asked);
        output
    }

    /// Brings skin and colours onto the device.
    fn bring_skin(&mut self) {
        let (Some(stage), Some(drawn)) = (&self.stage, &mut self.drawn) else {
            return;
        };
        let gpu = self.renderer.gpu();
        let shown = &stage.shown;
        let there = stage.world.skin_buffer(stage.me).ok().flatten();
        self.posed = Some(match there {
            Some(skin) => Posed {
                buffer: skin.buffer.clone(),
                range: skin.range,
                origin: skin.origin,
            },
            None => (drawn.skin).upload(gpu, &shown.positions, &shown.normals, self.root),
        });
        if shown.coloured {
            drawn.skin.show(gpu, &shown.colours);
        }
    }

    /// What stands beside the character.
    fn solids(&mut self) -> Vec<Solid> {
        let mut solids = Vec::new();
        let Some(stage) = &mut self.stage else {
            return solids;
        };
        for key in stage.colliders.clone() {
            let Ok(collider) = stage.world.collider_mut(key) else {
                continue;
            };
            let ground = collider.shape == Shape::HalfSpace;
            let colour = if ground {
                [0.42; 3]
            } else {
                from_srgb(COLLIDER_COLOUR)
            };
            if ground || self.controls.colliders {
                solids.push(Solid::of_shape(&collider.shape, collider.frame, colour));
            }
        }
        for (key, body) in stage.bodies.iter().zip(&stage.character.scene.bodies) {
            if let Ok(frame) = stage.world.body_frame(*key) {
                solids.push(Solid::of_shape(&body.shape, frame, BODY));
            }
        }
        self.balls.solids(stage, &mut solids);
        if let Some(probe) = &self.probe {
            probe.solids(stage, &mut solids);
        }
        if let Some(grab) = &self.grab {
            grab.solids(stage, self.size, &mut solids);
        }
        if self.controls.handles {
            let at = |v: &u32| stage.shown.positions[*v as usize];
            let dots = stage.character.handles.iter().map(at);
            solids.extend(dots.map(|at| Solid::dot(at, 0.004 * self.size, HANDLE)));
        }
        solids
    }

    /// The pixels left of the panel.
    pub(super) fn scene_size(&self) -> [u32; 2] {
        let [width, height] = self.screen.size;
        let panel = (panel::WIDTH * self.screen.scale) as u32;
        [width.saturating_sub(panel).max(1), height.max(1)]
    }

    /// The force's label, and where it stands in the scene, points.
    fn pull_label(&self) -> Option<(egui::Pos2, String)> {
        let (grab, stage) = (self.grab.as_ref()?, self.stage.as_ref()?);
        let place = grab.label_place(stage, self.size);
        let [x, y] = self.camera.project(place, self.aspect())?;
        let size = self.scene_size().map(|n| n as f32 / self.screen.scale);
        let at = egui::Pos2::new(
            0.5 * size[0] * (1.0 + x as f32),
            0.5 * size[1] * (1.0 - y as f32),
        );
        Some((at, format!("{:.2} N", self.pull())))
    }
}

/// Linear red, green, blue.
const BODY: [f32; 3] = [0.75, 0.3, 0.03];
const HANDLE: [f32; 3] = [0.05, 0.6, 0.25];
