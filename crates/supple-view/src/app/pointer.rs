//! What mouse and keys do: in the scene they turn, grab, press and throw; in the panel they are the panel's.

use super::event::points;
use super::{App, Button, Event};
use crate::bake::{Request, is_motion};
use crate::draw::Ray;
use crate::panel::Command;
use crate::stage::ValueMap;
use crate::touch::{Grab, Hit, Probe, Tool, pick};
use std::path::Path;

/// What the mouse is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Drag {
    #[default]
    None,
    Turn,
    Shift,
}

/// Where the cursor is, and what it drags.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pointer {
    at: Option<[f64; 2]>,
    drag: Drag,
}

impl Pointer {
    /// Where it is in a scene of these pixels, from −1 at the left and below to 1; none beside it.
    pub fn scene(&self, [width, height]: [u32; 2]) -> Option<[f64; 2]> {
        let [x, y] = self.at?;
        let at = [
            2.0 * x / f64::from(width) - 1.0,
            1.0 - 2.0 * y / f64::from(height),
        ];
        at.iter().all(|a| a.abs() <= 1.0).then_some(at)
    }
}

impl App {
    /// Something happens.
    pub fn handle(&mut self, event: &Event) {
        let scale = self.screen.scale;
        let cursor = points(self.pointer.at.unwrap_or([-1.0; 2]), scale);
        self.input.extend(event.for_panel(cursor, scale));
        match event {
            Event::Moved(place) => self.moved(*place),
            Event::Left => self.pointer.at = None,
            Event::Button(button, pressed) => self.button(*button, *pressed),
            Event::Wheel(notches) => self.wheel(*notches),
            Event::Key(key, true) if !self.context.wants_keyboard_input() => self.key(*key),
            Event::Key(..) | Event::Text(_) => {}
            Event::Dropped(path) => self.drop(path),
        }
    }

    /// A motion is for who is shown, anything else is shown.
    fn drop(&mut self, path: &Path) {
        let file = Request::File(path.into());
        let request = match &self.request {
            Some(who) if is_motion(path) => who.clone().with_motion(path.into()),
            _ => file,
        };
        self.open(request);
    }

    /// Width of the scene by its height.
    pub(super) fn aspect(&self) -> f64 {
        let [width, height] = self.scene_size();
        f64::from(width) / f64::from(height)
    }

    /// The ray under the cursor, where it is over the scene.
    fn ray(&self) -> Option<Ray> {
        let at = self.pointer.scene(self.scene_size())?;
        Some(self.camera.ray(at, self.aspect()))
    }

    /// What of the character is under the cursor.
    fn hit(&self) -> Option<(Ray, Hit)> {
        let (ray, stage) = (self.ray()?, self.stage.as_ref()?);
        let triangles = &stage.character.avatar.triangles;
        Some((ray, pick(&ray, &stage.shown.positions, triangles)?))
    }

    fn moved(&mut self, place: [f64; 2]) {
        let before = self.pointer.at.replace(place).unwrap_or(place);
        let height = f64::from(self.scene_size()[1]);
        let by = [0, 1].map(|k| (place[k] - before[k]) / height);
        match self.pointer.drag {
            Drag::None => {}
            Drag::Turn => self.camera.turn(by.map(|b| 4.0 * b)),
            Drag::Shift => self.camera.shift(by),
        }
        if let (Some(ray), Some(grab)) = (self.ray(), &mut self.grab) {
            grab.follow(&ray, &self.camera);
        }
        if self.controls.tool != Tool::Hand && self.pointer.drag == Drag::None {
            self.hover();
        }
    }

    /// Has the thing on the cursor over the skin.
    fn hover(&mut self) {
        let Some(ray) = self.ray() else { return };
        let hit = self.hit().map(|(_, hit)| hit);
        let Some(stage) = &mut self.stage else { return };
        match (&mut self.probe, hit) {
            (Some(probe), hit) => probe.follow(&ray, hit.as_ref()),
            (None, Some(hit)) => {
                let (tool, width) = (self.controls.tool, self.controls.width * self.size);
                match Probe::new(stage, tool, &ray, &hit, width) {
                    Ok(probe) => self.probe = probe,
                    Err(e) => self.tell_wrong(&e),
                }
            }
            (None, None) => {}
        }
    }

    fn button(&mut self, button: Button, pressed: bool) {
        if !pressed {
            self.pointer.drag = Drag::None;
            if button == Button::Primary {
                self.grab = None;
            }
            return;
        }
        if self.ray().is_none() {
            return;
        }
        self.pointer.drag = match button {
            Button::Middle => Drag::Shift,
            Button::Secondary => Drag::Turn,
            Button::Primary => {
                let hit = self.hit().filter(|_| self.controls.tool == Tool::Hand);
                match (hit, &self.stage) {
                    (Some((_, hit)), Some(stage)) => {
                        self.grab = Some(Grab::new(&hit, &self.camera, stage, self.size));
                        Drag::None
                    }
                    _ => Drag::Turn,
                }
            }
        };
    }

    fn wheel(&mut self, notches: f64) {
        if self.ray().is_none() {
            return;
        }
        let over = self.hit().is_some();
        if let Some(probe) = (self.probe.as_mut()).filter(|p| over || p.pressed > 0.0) {
            probe.press(notches);
            self.hover();
        } else if let Some(grab) = &mut self.grab {
            grab.push(0.02 * self.size * notches);
            if let (Some(ray), Some(grab)) = (self.ray(), &mut self.grab) {
                grab.follow(&ray, &self.camera);
            }
        } else {
            self.camera.come_near(notches);
        }
    }

    fn key(&mut self, key: egui::Key) {
        use egui::Key;
        let tool = |k: usize| Tool::ALL.get(k).copied().unwrap_or_default();
        match key {
            Key::Space => self.pace.paused = !self.pace.paused,
            Key::Period => self.pace.step_once(),
            Key::S => self.pace.toggle_slow(),
            Key::R => self.ask(Command::Reset),
            Key::F => self.ask(Command::Fit),
            Key::B => self.ask(Command::Throw),
            Key::K => self.ask(Command::Keep),
            Key::L => self.ask(Command::Restore),
            Key::H => self.controls.handles = !self.controls.handles,
            Key::M => {
                let all = ValueMap::ALL;
                let now = all.iter().position(|m| *m == self.controls.map);
                self.controls.map = all[now.map_or(0, |k| (k + 1) % all.len())];
            }
            Key::Num1 => self.take(tool(0)),
            Key::Num2 => self.take(tool(1)),
            Key::Num3 => self.take(tool(2)),
            Key::Num4 => self.take(tool(3)),
            _ => {}
        }
    }

    /// Takes another thing in hand.
    fn take(&mut self, tool: Tool) {
        self.controls.tool = tool;
    }

    /// Lays down what is no longer in hand.
    pub(super) fn lay_down(&mut self) {
        let (tool, width) = (self.controls.tool, self.controls.width * self.size);
        let same = match &self.probe {
            Some(probe) => probe.is(tool, width),
            None => tool == Tool::Hand,
        };
        if same {
            return;
        }
        if let (Some(probe), Some(stage)) = (self.probe.take(), &mut self.stage)
            && let Err(e) = probe.remove(stage)
        {
            self.tell_wrong(&e);
        }
        if tool != Tool::Hand {
            self.grab = None;
            self.hover();
        }
    }
}
